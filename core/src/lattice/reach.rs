//! How far the templates of a lattice look, as their indices are written.

use leafwise_expression::syntax::{Formula, Offsets, SyntaxError, VariablePattern, joined};

/// How far the templates of a lattice look, read off the indices that they are written with.
///
/// On a short lattice `x[i+6]` may be `x[i-3]`, or beyond an open end. A trial tells how far a formula looks only
/// where the lattice is long enough. But how long that is, the trial itself would have to tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TemplateReach {
    /// The largest distance between two sites that an entry of the bracket names, those of its pair among them.
    pub bracket: usize,
    /// The same of a term of H.
    pub hamiltonian: usize,
    /// The same of a term of a Casimir.
    pub casimirs: usize,
    /// How far forces look from the coordinate that feels them.
    pub forces: usize,
    /// How far the index of such a template is from the nearest site that it names: of `sum(i, x[i+2]*x[i+3])`
    /// two sites.
    pub beside: usize,
    /// How far the terms at a site look from it: of the energy, of Casimirs and of what else is observed.
    pub terms: usize,
}

impl TemplateReach {
    /// How many sites the tensor and dH together look to either side, at least 1.
    pub fn each(&self) -> usize {
        self.bracket.saturating_add(self.hamiltonian).max(1)
    }

    /// Number of sites that code looks to either side which goes through tensor and dH `times` times. It is at least
    /// what a check of Casimirs looks. On an open lattice it includes how far templates stand beside the sites that
    /// they name.
    pub fn of_times(&self, times: usize, is_open: bool) -> usize {
        let of_casimirs = self.casimirs.saturating_add(self.bracket).saturating_sub(1);
        let beside = if is_open { self.beside } else { 0 };
        let each = self.each().saturating_mul(times).max(self.forces);
        each.max(of_casimirs).saturating_add(beside)
    }

    /// With an entry of the bracket.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_from`] and [`VariablePattern::offsets`].
    pub fn with_entry(
        mut self,
        pair: [&VariablePattern; 2],
        entry: &Formula,
    ) -> Result<Self, SyntaxError> {
        let index = pair.iter().find_map(|pattern| pattern.index_name());
        let own = entry.offsets_from(index.unwrap_or_default())?;
        let named = [pair[0].offsets()?, pair[1].offsets()?, own];
        let all = named
            .into_iter()
            .flatten()
            .reduce(|all, own| joined(&all, &own));
        self.bracket = self.bracket.max(self.apart(all));
        Ok(self)
    }

    /// With H.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_of_sums`].
    pub fn with_hamiltonian(self, formula: &Formula) -> Result<Self, SyntaxError> {
        let mut with = self.with_observable(formula)?;
        with.hamiltonian = with.hamiltonian.max(with.apart(formula.offsets_of_sums()?));
        Ok(with)
    }

    /// With a Casimir.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_of_sums`].
    pub fn with_casimir(self, formula: &Formula) -> Result<Self, SyntaxError> {
        let mut with = self.with_observable(formula)?;
        with.casimirs = with.casimirs.max(with.apart(formula.offsets_of_sums()?));
        Ok(with)
    }

    /// With a channel of noise: a sum over sites, or a template of its own index; its increment stands at the index.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_of_sums`] and [`Formula::offsets_from`].
    pub fn with_channel(mut self, formula: &Formula) -> Result<Self, SyntaxError> {
        let templates = match formula.free_index() {
            Some(index) => formula.offsets_from(index)?.into_iter().collect(),
            None => formula.offsets_of_sums()?,
        };
        let templates = templates.iter().map(|own| joined(own, &(0..=0)));
        let templates: Vec<Offsets> = templates.collect();
        for offsets in &templates {
            let farthest = offsets
                .start()
                .unsigned_abs()
                .max(offsets.end().unsigned_abs());
            self.terms = self.terms.max(sites(farthest));
        }
        self.hamiltonian = self.hamiltonian.max(self.apart(templates));
        Ok(self)
    }

    /// With a component of a one-form, or an entry of a metric, at a coordinate.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_from`] and [`VariablePattern::offsets`].
    pub fn with_force(
        mut self,
        coordinate: &VariablePattern,
        formula: &Formula,
    ) -> Result<Self, SyntaxError> {
        let index = coordinate.index_name().unwrap_or_default();
        let named = [coordinate.offsets()?, formula.offsets_from(index)?];
        let all = named.into_iter().flatten();
        let all = all.reduce(|all, own| joined(&all, &own));
        self.forces = self.forces.max(self.apart(all));
        Ok(self)
    }

    /// With a function that is evaluated alone.
    ///
    /// # Errors
    /// Those of [`Formula::offsets_of_sums`].
    pub fn with_observable(mut self, formula: &Formula) -> Result<Self, SyntaxError> {
        for offsets in formula.offsets_of_sums()? {
            let farthest = offsets
                .start()
                .unsigned_abs()
                .max(offsets.end().unsigned_abs());
            self.terms = self.terms.max(sites(farthest));
        }
        Ok(self)
    }

    /// How far from each other the sites of a template are at most; takes in how far its index stands beside them.
    fn apart(&mut self, templates: impl IntoIterator<Item = Offsets>) -> usize {
        let mut apart = 0;
        for offsets in templates {
            let (least, greatest) = (*offsets.start(), *offsets.end());
            apart = apart.max(sites(least.abs_diff(greatest)));
            let beside = match (least > 0, greatest < 0) {
                (true, _) => least.unsigned_abs(),
                (_, true) => greatest.unsigned_abs(),
                _ => 0,
            };
            self.beside = self.beside.max(sites(beside));
        }
        apart
    }
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
            bracket: 9,
            hamiltonian: 1,
            casimirs: 0,
            forces: 0,
            beside: 30,
            terms: 40,
        };
        assert_eq!(reach, Ok(expected));
        for text in [
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
