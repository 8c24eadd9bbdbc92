//! Which variables a part of a formula depends on, where they are few.

/// At most so many are told; what depends on more counts as depending on all.
const MOST_TOLD: usize = 16;

/// The variables that something depends on, in rising order; `None` for more than sixteen.
///
/// Most parts of a formula in thousands of variables depend on a few: their derivatives by all the
/// others are 0 without a look inside.
#[derive(Clone, Debug)]
pub(crate) struct Reach(Option<Vec<u32>>);

impl Reach {
    /// No variable.
    pub fn nothing() -> Self {
        Self(Some(Vec::new()))
    }

    /// One variable.
    pub fn variable(index: u32) -> Self {
        Self(Some(vec![index]))
    }

    /// Whatever one of the parts depends on.
    pub fn union<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut all = Vec::new();
        for part in parts {
            let Some(variables) = &part.0 else {
                return Self(None);
            };
            all.extend_from_slice(variables);
            if all.len() > MOST_TOLD {
                all.sort_unstable();
                all.dedup();
            }
            if all.len() > MOST_TOLD {
                return Self(None);
            }
        }
        all.sort_unstable();
        all.dedup();
        Self(Some(all))
    }

    /// Whether a derivative by the variable may be other than 0.
    pub fn may_contain(&self, variable: u32) -> bool {
        self.0
            .as_ref()
            .is_none_or(|variables| variables.binary_search(&variable).is_ok())
    }
}

#[cfg(test)]
mod tests {
    use super::Reach;

    #[test]
    fn a_union_tells_sixteen_variables_and_no_more() {
        let variables = |range: std::ops::Range<u32>| -> Vec<Reach> {
            range.map(|index| Reach::variable(index / 2)).collect()
        };
        let few = Reach::union(&variables(0..32));
        assert!(few.may_contain(15) && !few.may_contain(16));
        let many = Reach::union(&variables(0..34));
        assert!(many.may_contain(1000));
        assert!(!Reach::nothing().may_contain(0));
    }
}
