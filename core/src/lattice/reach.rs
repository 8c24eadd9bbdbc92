//! How far the templates of a lattice look, as their indices are written.

use leafwise_expression::syntax::{AXES, Formula, Offsets, SyntaxError, VariablePattern};

use super::geometry::PerAxis;

/// How far the templates of a lattice look, read off the indices that they are written with.
///
/// On a short lattice `x[i+6]` may be `x[i-3]`, or beyond an open end. A trial tells how far a formula looks only
/// where the lattice is long enough. But how long that is, the trial itself would have to tell. Each number is one an
/// axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TemplateReach {
    /// The largest distance between two sites that an entry of the bracket names, those of its pair among them.
    pub bracket: PerAxis<usize>,
    /// The same of a term of H.
    pub hamiltonian: PerAxis<usize>,
    /// The same of a term of a Casimir.
    pub casimirs: PerAxis<usize>,
    /// How far forces look from the coordinate that feels them.
    pub forces: PerAxis<usize>,
    /// How far the index of such a template is from the nearest site that it names: of `sum(i, x[i+2]*x[i+3])`
    /// two sites.
    pub beside: PerAxis<usize>,
    /// How far the terms at a site look from it: of the energy, of Casimirs and of what else is observed.
    pub terms: PerAxis<usize>,
}

impl TemplateReach {
    /// How many sites the tensor and dH together look to either side, at least 1.
    pub fn each(&self) -> PerAxis<usize> {
        sums(self.bracket, self.hamiltonian).map(|each| each.max(1))
    }

    /// Whether bracket, H and forces are sums and templates of single sites, each of coordinates at its index.
    pub fn has_sites_apart(&self) -> bool {
        let looks = [self.bracket, self.hamiltonian, self.forces, self.beside];
        looks == [[0; AXES]; 4]
    }

    /// Number of sites that code looks to either side which goes through tensor and dH `times` times. It is at least
    /// what a check of Casimirs looks. Along an axis with ends it includes how far templates stand beside the sites that
    /// they name.
    pub fn of_times(&self, times: usize, has_ends: PerAxis<bool>) -> PerAxis<usize> {
        let (each, of_casimirs) = (self.each(), sums(self.casimirs, self.bracket));
        std::array::from_fn(|axis| {
            let beside = if has_ends[axis] { self.beside[axis] } else { 0 };
            let each = each[axis].saturating_mul(times).max(self.forces[axis]);
            let of_casimirs = of_casimirs[axis].saturating_sub(1);
            each.max(of_casimirs).saturating_add(beside)
        })
    }

    /// With an entry of the bracket.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_from`] and [`VariablePattern::offsets_from`].
    pub fn with_entry(
        mut self,
        pair: [&VariablePattern; 2],
        entry: &Formula,
    ) -> Result<Self, SyntaxError> {
        let names = pair.map(VariablePattern::index_names);
        let names = names.into_iter().find(|names| !names.is_empty());
        let names = names.unwrap_or_default();
        let [a, b] = pair.map(|pattern| pattern.offsets_from(&names));
        let named = [a?, b?, entry.offsets_from(&names)?];
        let all = named.into_iter().flatten();
        let all = all.reduce(|all, own| all.joined(&own));
        self.bracket = largest(self.bracket, self.apart(all));
        Ok(self)
    }

    /// With H.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_of_sums`].
    pub fn with_hamiltonian(self, formula: &Formula) -> Result<Self, SyntaxError> {
        let mut with = self.with_observable(formula)?;
        with.hamiltonian = largest(with.hamiltonian, with.apart(formula.offsets_of_sums()?));
        Ok(with)
    }

    /// With a Casimir.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_of_sums`].
    pub fn with_casimir(self, formula: &Formula) -> Result<Self, SyntaxError> {
        let mut with = self.with_observable(formula)?;
        with.casimirs = largest(with.casimirs, with.apart(formula.offsets_of_sums()?));
        Ok(with)
    }

    /// With a channel of noise: a sum over sites, or a template of its own index; its increment stands at the index.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_of_sums`] and [`Formula::offsets_from`].
    pub fn with_channel(mut self, formula: &Formula) -> Result<Self, SyntaxError> {
        let names = formula.free_indices();
        let templates = match names.is_empty() {
            false => formula.offsets_from(&names)?.into_iter().collect(),
            true => formula.offsets_of_sums()?,
        };
        let templates = templates.iter().map(|own| own.joined(&Offsets::here()));
        let templates: Vec<Offsets> = templates.collect();
        for offsets in &templates {
            self.terms = largest(self.terms, farthest(offsets));
        }
        self.hamiltonian = largest(self.hamiltonian, self.apart(templates));
        Ok(self)
    }

    /// With a component of a one-form, or an entry of a metric, at a coordinate.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_from`] and [`VariablePattern::offsets_from`].
    pub fn with_force(
        mut self,
        coordinate: &VariablePattern,
        formula: &Formula,
    ) -> Result<Self, SyntaxError> {
        let names = coordinate.index_names();
        let named = [
            coordinate.offsets_from(&names)?,
            formula.offsets_from(&names)?,
        ];
        let all = named.into_iter().flatten();
        let all = all.reduce(|all, own| all.joined(&own));
        self.forces = largest(self.forces, self.apart(all));
        Ok(self)
    }

    /// With a function that is evaluated alone.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_of_sums`].
    pub fn with_observable(mut self, formula: &Formula) -> Result<Self, SyntaxError> {
        for offsets in formula.offsets_of_sums()? {
            self.terms = largest(self.terms, farthest(&offsets));
        }
        Ok(self)
    }

    /// How far from each other the sites of a template are at most; takes in how far its indices stand beside them.
    fn apart(&mut self, templates: impl IntoIterator<Item = Offsets>) -> PerAxis<usize> {
        let mut apart = [0; AXES];
        for offsets in templates {
            for (axis, range) in offsets.axes().iter().enumerate() {
                let (least, greatest) = (*range.start(), *range.end());
                apart[axis] = apart[axis].max(sites(least.abs_diff(greatest)));
                let beside = match (least > 0, greatest < 0) {
                    (true, _) => least.unsigned_abs(),
                    (_, true) => greatest.unsigned_abs(),
                    _ => 0,
                };
                self.beside[axis] = self.beside[axis].max(sites(beside));
            }
        }
        apart
    }
}

/// How far the farthest site is that a template names.
fn farthest(offsets: &Offsets) -> PerAxis<usize> {
    std::array::from_fn(|axis| {
        let range = &offsets.axes()[axis];
        sites(range.start().unsigned_abs().max(range.end().unsigned_abs()))
    })
}

/// The larger number along each axis.
fn largest(a: PerAxis<usize>, b: PerAxis<usize>) -> PerAxis<usize> {
    std::array::from_fn(|axis| a[axis].max(b[axis]))
}

/// The sum along each axis.
fn sums(a: PerAxis<usize>, b: PerAxis<usize>) -> PerAxis<usize> {
    std::array::from_fn(|axis| a[axis].saturating_add(b[axis]))
}

/// A distance; saturated it is longer than every lattice.
fn sites(distance: u64) -> usize {
    usize::try_from(distance).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::{Formula, TemplateReach, VariablePattern};

    #[test]
    fn offsets_are_read_as_they_are_written() {
        let formula = |text| Formula::parse(text).expect("a formula");
        let pair = |text| VariablePattern::parse_pair(text).expect("a pair");
        let (a, b) = pair("x[i-2],x[i+5]");
        let reach = TemplateReach::default()
            .with_entry([&a, &b], &formula("x[i+1]*x[i-4]"))
            .and_then(|reach| {
                reach.with_hamiltonian(&formula("sum(i, x[i+30]*x[i+31]) + sum(i, x[i]^2)"))
            })
            .and_then(|reach| reach.with_observable(&formula("sum(k, x[k]*x[k-40])/2")));
        let expected = TemplateReach {
            bracket: [9, 0, 0],
            hamiltonian: [1, 0, 0],
            casimirs: [0; 3],
            forces: [0; 3],
            beside: [30, 0, 0],
            terms: [40, 0, 0],
        };
        assert_eq!(reach, Ok(expected));
        let plane = formula("sum(i, j, x[i,j]*x[i+1,j] + x[i,j]*x[i,j-2]) + sum(j, i, x[i+1,j+4])");
        let reach = TemplateReach::default().with_hamiltonian(&plane);
        let reach = reach.expect("sums over sites");
        assert_eq!((reach.hamiltonian, reach.beside), ([1, 2, 0], [1, 4, 0]));
        for text in [
            "sum(i, j, x[i,j]*x[j,i])",
            "sum(i, j, x[i]*y[j])",
            "sum(i<j, x[i]*x[j])",
            "sum(i, x[i])^2",
            "sum(i, x[i]*x[0])",
            "sum(i, x[i]*sum(j, 1))",
            "x[3]^2",
        ] {
            let refused = TemplateReach::default().with_hamiltonian(&formula(text));
            assert!(refused.is_err(), "{text}");
        }
        let (a, b) = pair("x[0],x[1]");
        let fixed = TemplateReach::default().with_entry([&a, &b], &formula("1"));
        assert!(fixed.is_err());
    }
}
