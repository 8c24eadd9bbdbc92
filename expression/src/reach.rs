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

    /// How many of so many variables it may be that are depended on.
    pub fn count(&self, variables: usize) -> usize {
        self.0.as_ref().map_or(variables, Vec::len)
    }

    /// Whether a derivative by the variable may be other than 0.
    pub fn may_contain(&self, variable: u32) -> bool {
        self.0
            .as_ref()
            .is_none_or(|variables| variables.binary_search(&variable).is_ok())
    }
}

/// Which terms of a sum depend on which variables.
#[derive(Clone, Debug)]
pub(crate) struct SumReach {
    /// A variable and a term that depends on it, in rising order.
    told: Vec<(u32, u32)>,
    /// The terms that count as depending on all variables.
    others: Vec<u32>,
}

impl SumReach {
    /// Of terms that depend on these variables each.
    pub fn new<'a>(terms: impl IntoIterator<Item = &'a Reach>) -> Self {
        let (mut told, mut others) = (Vec::new(), Vec::new());
        for (at, reach) in (0..).zip(terms) {
            match &reach.0 {
                Some(variables) => told.extend(variables.iter().map(|variable| (*variable, at))),
                None => others.push(at),
            }
        }
        told.sort_unstable();
        Self { told, others }
    }

    /// The terms whose derivative by the variable may be other than 0, in rising order.
    pub fn terms_of(&self, variable: u32) -> Vec<usize> {
        let first = self.told.partition_point(|(told, _)| *told < variable);
        let told = self.told[first..].iter();
        let told = told.take_while(|(told, _)| *told == variable);
        let mut terms: Vec<usize> = told
            .map(|(_, term)| term)
            .chain(&self.others)
            .map(|term| *term as usize)
            .collect();
        terms.sort_unstable();
        terms
    }
}

#[cfg(test)]
mod tests {
    use super::{Reach, SumReach};

    #[test]
    fn a_sum_tells_the_terms_of_each_variable() {
        let all = Reach::union(&(0..17).map(Reach::variable).collect::<Vec<_>>());
        let both = Reach::union(&[Reach::variable(3), Reach::variable(5)]);
        let terms = [Reach::variable(5), all, both, Reach::nothing()];
        let sum = SumReach::new(&terms);
        for variable in 0..20 {
            let expected = (0..terms.len()).filter(|at| terms[*at].may_contain(variable));
            assert_eq!(sum.terms_of(variable), expected.collect::<Vec<_>>());
        }
    }

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
