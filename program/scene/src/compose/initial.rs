//! The initial state, and the parameters of sites behind it.

use leafwise_expression::syntax::{AXES, At, Formula, Scope, VariablePattern};

use super::Refusal;
use super::definitions::scope;
use super::geometry::geometry;
use super::names::{parse, refusal, sites_of};
use crate::document::{FieldSpec, InitialSpec, Located, Place, SceneDocument};
use crate::npy::read_npy;
use crate::table::read_column;

/// The initial state of the scene: one number for each coordinate, then the parameters of sites.
pub(super) fn initial_state(document: &SceneDocument) -> Result<Vec<f64>, Refusal> {
    let system = &document.system;
    let lattice = geometry(document);
    let parameters = system.parameters.iter();
    let mut state = State {
        document,
        scope: scope(document, &lattice, None)?,
        parameters: parameters.map(|(_, value)| value.value.value).collect(),
        values: vec![0.0; system.dimension()],
        is_given: vec![false; system.dimension()],
    };
    state.assign_all(&system.sites)?;
    match &document.run.initial.value {
        InitialSpec::Vector(numbers) => {
            let dimension = system.coordinates();
            if numbers.len() != dimension {
                return Err(Box::new(document.diagnostic(
                    &document.run.initial.place(),
                    format!(
                        "initial has {} entries, and the state has {dimension} coordinates",
                        numbers.len()
                    ),
                    format!("expected {dimension} numbers"),
                    None,
                )));
            }
            for (at, number) in numbers.iter().enumerate() {
                state.values[at] = number.value.value;
                state.is_given[at] = true;
            }
        }
        InitialSpec::Fields(fields) => {
            state.check_moving(fields)?;
            state.assign_all(fields)?;
        }
    }
    state.finish()
}

struct State<'a> {
    document: &'a SceneDocument,
    scope: Scope,
    parameters: Vec<f64>,
    values: Vec<f64>,
    is_given: Vec<bool>,
}

impl State<'_> {
    /// Parameters of sites have their values in `[system]`.
    fn check_moving(&self, fields: &[(Located<String>, FieldSpec)]) -> Result<(), Refusal> {
        for (key, _) in fields {
            let pattern = VariablePattern::parse_one(&key.value)
                .map_err(|error| refusal(self.document, key, &error))?;
            if self.document.system.is_at_rest(pattern.name()) {
                return Err(Box::new(self.document.diagnostic(
                    &key.place(),
                    format!("`{}` is a parameter of every site", pattern.name()),
                    "no coordinate",
                    Some("its values stand in [system] parameters".to_owned()),
                )));
            }
        }
        Ok(())
    }

    /// The more indices a key has, the sooner: a row overrides the field and a single site both, whatever their order.
    fn assign_all(&mut self, fields: &[(Located<String>, FieldSpec)]) -> Result<(), Refusal> {
        for indices in (0..=AXES).rev() {
            for (key, field) in fields {
                let pattern = VariablePattern::parse_one(&key.value)
                    .map_err(|error| refusal(self.document, key, &error))?;
                let names = pattern.index_names();
                if names.iter().filter(|name| !name.is_empty()).count() == indices {
                    match field {
                        FieldSpec::Formula(formula) => {
                            let parsed = parse(self.document, formula)?;
                            self.assign(key, &pattern, formula, &parsed)?;
                        }
                        FieldSpec::Numbers(numbers, place) => {
                            let numbers: Vec<f64> = numbers.iter().map(|n| n.value.value).collect();
                            self.assign_numbers(key, &pattern, &numbers, place)?;
                        }
                        FieldSpec::Rows(_, place) => return Err(self.rows(key, place)),
                        FieldSpec::File { file, column } => {
                            let numbers = self.read(file, column.as_ref())?;
                            self.assign_numbers(key, &pattern, &numbers, &file.place())?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn read(
        &self,
        file: &Located<String>,
        column: Option<&Located<String>>,
    ) -> Result<Vec<f64>, Refusal> {
        let path = self.document.directory().join(&file.value);
        let name = column.map(|column| column.value.as_str());
        let end = path.extension();
        let is_npy = end.is_some_and(|end| end.eq_ignore_ascii_case("npy"));
        let numbers = match is_npy && column.is_none() {
            true => read_npy(&path).map(|array| array.numbers),
            false => read_column(&path, name),
        };
        numbers.map_err(|reason| {
            let help = "a number for each site, each in a row of its own: CSV, with the columns' names in the first \
                        line or without, or a JSON list; or an array of NumPy's (.npy), the last axis fastest";
            let document = self.document;
            Box::new(document.diagnostic(&file.place(), reason, "this file", Some(help.to_owned())))
        })
    }

    /// Rows of numbers are those of every two sites of a chain.
    fn rows(&self, key: &Located<String>, place: &Place) -> Refusal {
        let message = format!(
            "`{}` has one number for each site, and these are rows of numbers",
            key.value
        );
        let help = "one list of numbers, the last axis fastest; numbers for every two sites of a chain are parameters \"J[i,j]\"";
        let document = self.document;
        Box::new(document.diagnostic(place, message, "rows", Some(help.to_owned())))
    }

    /// The number of sites of the family that a key names.
    fn length(&self, pattern: &VariablePattern) -> usize {
        let mut families = self.document.system.families.iter();
        let family = families.find(|(name, _)| name.value == pattern.name());
        family.map_or(1, |(_, length)| length.value)
    }

    /// The sites that a key stands for, of those that its family has.
    fn sites(
        &self,
        key: &Located<String>,
        pattern: &VariablePattern,
        names: &[&str],
    ) -> Result<Vec<usize>, Refusal> {
        let length = self.length(pattern);
        let sites = sites_of(self.document, &self.scope, key, names)?.into_iter();
        Ok(sites.filter(|site| *site < length).collect())
    }

    /// A number for each site.
    fn assign_numbers(
        &mut self,
        key: &Located<String>,
        pattern: &VariablePattern,
        numbers: &[f64],
        place: &Place,
    ) -> Result<(), Refusal> {
        let refuse = |place: &Place, message: String, help: String| {
            Err(Box::new(self.document.diagnostic(
                place,
                message,
                "here",
                Some(help),
            )))
        };
        let names = pattern.index_names();
        if names.is_empty() {
            return refuse(
                &key.place(),
                format!("`{}` is one site, and these are numbers of many", key.value),
                format!("write \"{}[i]\" for all sites", pattern.name()),
            );
        }
        let sites = self.sites(key, pattern, &names)?;
        let (length, found) = (sites.len(), numbers.len());
        if found != length {
            return refuse(
                place,
                format!(
                    "{found} numbers, and `{}` has {length} sites",
                    pattern.name()
                ),
                "one number for each site".to_owned(),
            );
        }
        if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
            return refuse(
                place,
                format!("the number of site {at} is {:?}", numbers[at]),
                "a finite number for each site".to_owned(),
            );
        }
        for (i, value) in sites.into_iter().zip(numbers) {
            let at = pattern
                .resolve(&self.scope, Some((&names, i)))
                .map_err(|error| refusal(self.document, key, &error))?;
            if let Some(at) = at {
                self.values[at] = *value;
                self.is_given[at] = true;
            }
        }
        Ok(())
    }

    fn assign(
        &mut self,
        key: &Located<String>,
        pattern: &VariablePattern,
        formula: &Located<String>,
        parsed: &Formula,
    ) -> Result<(), Refusal> {
        let names = pattern.index_names();
        let sites = match names.is_empty() {
            false => self.sites(key, pattern, &names)?,
            true => vec![0],
        };
        for i in sites {
            let index = (!names.is_empty()).then_some((&names[..], i));
            let at = pattern
                .resolve(&self.scope, index)
                .map_err(|error| refusal(self.document, key, &error))?;
            let Some(at) = at else { continue };
            let value = parsed
                .value(&self.scope, &self.parameters, index)
                .map_err(|error| refusal(self.document, formula, &error))?;
            if !value.is_finite() {
                return Err(self.not_finite(formula, at, index, value));
            }
            self.values[at] = value;
            self.is_given[at] = true;
        }
        Ok(())
    }

    fn not_finite(
        &self,
        formula: &Located<String>,
        at: usize,
        index: Option<At<'_>>,
        value: f64,
    ) -> Refusal {
        let name = self.name(at);
        let written = if value.is_nan() {
            "not a number"
        } else {
            "infinite"
        };
        let site = index.map_or_else(String::new, |site| {
            format!(" at {}", self.scope.named_site(site))
        });
        Box::new(
            self.document.diagnostic(
                &self
                    .document
                    .place_in_formula(formula, 0..formula.value.len()),
                match at < self.document.system.coordinates() {
                    true => format!("the initial value of {name} is {written}"),
                    false => format!("the value of {name} is {written}"),
                },
                format!("outside the formula's domain{site}"),
                Some("a logarithm or root of a negative number, or a division by zero".to_owned()),
            ),
        )
    }

    fn name(&self, at: usize) -> String {
        let system = &self.document.system;
        if let Some(name) = system.variables.get(at) {
            return name.value.clone();
        }
        let (lattice, member) = (geometry(self.document), at - system.variables.len());
        match member < lattice.dimension() {
            true => lattice.name(member),
            false => format!("coordinate {at}"),
        }
    }

    fn finish(self) -> Result<Vec<f64>, Refusal> {
        let Some(at) = self.is_given.iter().position(|given| !given) else {
            return Ok(self.values);
        };
        let system = &self.document.system;
        let name = self.name(at);
        let family = name.split('[').next().unwrap_or_default();
        let mut sites = system.sites.iter();
        let key = sites.find(|(key, _)| key.value.split('[').next() == Some(family));
        let (what, place) = match key {
            Some((key, _)) if at >= system.coordinates() => ("parameters", key.place()),
            _ => ("initial", self.document.run.initial.place()),
        };
        let help = match what {
            "parameters" => format!("give every site one, as in \"{family}[i]\" = \"1 + i/N\""),
            _ => "give every variable and family, as in \"x[i]\" = \"1 + i/N\"".to_owned(),
        };
        Err(Box::new(self.document.diagnostic(
            &place,
            format!("{what} gives no value for {name}"),
            "incomplete",
            Some(help),
        )))
    }
}
