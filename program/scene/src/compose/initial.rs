//! The initial state, and the parameters of sites behind it.

use leafwise_core::NumberArray;
use leafwise_expression::syntax::{AXES, At, Formula, Scope, VariablePattern};

use super::Refusal;
use super::definitions::scope;
use super::geometry::geometry;
use super::keys::variable;
use super::names::{parse, refusal, sites_of};
use crate::document::{FieldSpec, InitialSpec, Located, Place, SceneDocument};
use crate::npy::read_npy;
use crate::table::read_numbers;

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
        given_by: vec![0; system.dimension()],
    };
    for family in parameters_of_sites(document)? {
        state.assign_all(&family)?;
    }
    state.assign_spec(&document.run.initial)?;
    state.finish()
}

/// The key of values that are given beside a state's own.
const BESIDE: u32 = u32::MAX;

/// A state of the scene's coordinates written as its initial state is; those that it does not name have the values of `others`.
///
/// # Errors
/// A name that is no coordinate, and a formula without a value, underlined in the scene.
pub fn state_beside(
    document: &SceneDocument,
    spec: &Located<InitialSpec>,
    others: &[f64],
) -> Result<Vec<f64>, Refusal> {
    let (lattice, dimension) = (geometry(document), document.system.dimension());
    let parameters = document.system.parameters.iter();
    let mut state = State {
        document,
        scope: scope(document, &lattice, None)?,
        parameters: parameters.map(|(_, value)| value.value.value).collect(),
        values: vec![0.0; dimension],
        given_by: vec![0; dimension],
    };
    for family in parameters_of_sites(document)? {
        state.assign_all(&family)?;
    }
    state.values[..others.len()].copy_from_slice(others);
    state.given_by[..others.len()].fill(BESIDE);
    state.assign_spec(spec)?;
    state.values.truncate(others.len());
    Ok(state.values)
}

/// Values that a key gives: that of one site, or of many.
type Field = (Located<String>, FieldSpec);

/// The parameters of sites, family by family: those that formulas of others name come before them.
fn parameters_of_sites(document: &SceneDocument) -> Result<Vec<Vec<&Field>>, Refusal> {
    let mut families: Vec<SiteFamily<'_>> = Vec::new();
    for field in &document.system.sites {
        let (key, given) = field;
        let pattern = variable(document, key)?;
        let mut names = Vec::new();
        if let FieldSpec::Formula(formula) = given {
            let parsed = parse(document, formula)?;
            names.extend(parsed.references().into_iter().map(str::to_owned));
        }
        match families.iter_mut().find(|own| own.name == pattern.name()) {
            Some(own) => {
                own.fields.push(field);
                own.names.extend(names);
            }
            None => families.push(SiteFamily {
                name: pattern.name().to_owned(),
                fields: vec![field],
                names,
            }),
        }
    }
    let mut ordered = Vec::with_capacity(families.len());
    while !families.is_empty() {
        let is_free =
            |own: &SiteFamily<'_>| !families.iter().any(|other| own.names.contains(&other.name));
        match families.iter().position(is_free) {
            Some(at) => ordered.push(families.remove(at).fields),
            None => return Err(circle(document, &families)),
        }
    }
    Ok(ordered)
}

/// Parameters of a family of sites, and the names in their formulas.
struct SiteFamily<'a> {
    name: String,
    fields: Vec<&'a Field>,
    names: Vec<String>,
}

/// Of families each of which waits for another one, those that wait for themselves.
fn circle(document: &SceneDocument, families: &[SiteFamily<'_>]) -> Refusal {
    let mut way = vec![0];
    loop {
        let last = &families[way[way.len() - 1]];
        let next = families
            .iter()
            .position(|own| last.names.contains(&own.name));
        let next = next.unwrap_or_default();
        if let Some(begin) = way.iter().position(|own| *own == next) {
            way.drain(..begin);
            break;
        }
        way.push(next);
    }
    let first = &families[way[0]];
    let names: Vec<String> = way
        .iter()
        .map(|at| format!("`{}`", families[*at].name))
        .collect();
    let message = match names.as_slice() {
        [only] => format!("values of {only} are defined by values of {only}"),
        several => format!(
            "the values of {} are each defined by the next",
            several.join(", ")
        ),
    };
    let is_it = |(_, given): &&&Field| match given {
        FieldSpec::Formula(formula) => parse(document, formula).is_ok_and(|parsed| {
            let names = parsed.references();
            way.iter()
                .any(|at| names.contains(families[*at].name.as_str()))
        }),
        _ => false,
    };
    let key = first
        .fields
        .iter()
        .find(is_it)
        .map_or(&first.fields[0].0, |(key, _)| key);
    Box::new(document.diagnostic(
        &key.place(),
        message,
        "a circular definition",
        Some("write one of them by numbers, indices and other parameters".to_owned()),
    ))
}

/// A coordinate that another key had given another value: its number, that key, and both values.
type Twice = (usize, u32, [f64; 2]);

/// A key of initial values, with its number among them.
struct GivenKey<'a> {
    key: &'a Located<String>,
    pattern: &'a VariablePattern,
    number: u32,
}

struct State<'a> {
    document: &'a SceneDocument,
    scope: Scope,
    parameters: Vec<f64>,
    values: Vec<f64>,
    /// The key that gave each its value, counted from 1; 0 where none has.
    given_by: Vec<u32>,
}

impl State<'_> {
    fn assign_spec(&mut self, spec: &Located<InitialSpec>) -> Result<(), Refusal> {
        match &spec.value {
            InitialSpec::Vector(numbers) => {
                let dimension = self.document.system.coordinates();
                if numbers.len() != dimension {
                    return Err(Box::new(self.document.diagnostic(
                        &spec.place(),
                        format!(
                            "initial has {} entries, and the state has {dimension} coordinates",
                            numbers.len()
                        ),
                        format!("expected {dimension} numbers"),
                        None,
                    )));
                }
                for (at, number) in numbers.iter().enumerate() {
                    self.values[at] = number.value.value;
                    self.given_by[at] = 1;
                }
                Ok(())
            }
            InitialSpec::Fields(fields) => {
                self.check_moving(fields)?;
                self.assign_all(&fields.iter().collect::<Vec<_>>())
            }
        }
    }

    /// Parameters of sites have their values in `[system]`.
    fn check_moving(&self, fields: &[(Located<String>, FieldSpec)]) -> Result<(), Refusal> {
        for (key, _) in fields {
            let pattern = variable(self.document, key)?;
            if self.document.system.is_at_rest(pattern.name()) {
                return Err(Box::new(self.document.diagnostic(
                    &key.place(),
                    format!("`{}` is a parameter of every site", pattern.name()),
                    "no coordinate",
                    Some("its values belong in [system] parameters".to_owned()),
                )));
            }
        }
        Ok(())
    }

    /// The more indices a key has, the sooner: a row overrides the field and a single site both, whatever their order. Keys with
    /// as many indices give no site two values.
    fn assign_all(&mut self, fields: &[&Field]) -> Result<(), Refusal> {
        let mut keys = Vec::with_capacity(fields.len());
        for ((key, field), number) in fields.iter().zip(1..) {
            let pattern = variable(self.document, key)?;
            let names = pattern.index_names();
            let indices = names.iter().filter(|name| !name.is_empty()).count();
            keys.push((indices, number, key, pattern, field));
        }
        keys.sort_by_key(|(indices, ..)| std::cmp::Reverse(*indices));
        let mut first = (AXES + 1, 1);
        for (place, (indices, number, key, pattern, field)) in keys.iter().enumerate() {
            if *indices < first.0 {
                first = (*indices, place);
            }
            let own = GivenKey {
                key,
                pattern,
                number: *number,
            };
            let given = match field {
                FieldSpec::Formula(formula) => {
                    let parsed = parse(self.document, formula)?;
                    self.assign(&own, formula, &parsed)?
                }
                FieldSpec::Numbers(numbers, place) => {
                    let array = NumberArray {
                        shape: vec![numbers.len()],
                        numbers: numbers.iter().map(|n| n.value.value).collect(),
                    };
                    self.assign_numbers(&own, &array, place)?
                }
                FieldSpec::Rows(array, place) => self.assign_numbers(&own, array, place)?,
                FieldSpec::File { file, column } => {
                    let array = self.read(file, column.as_ref())?;
                    self.assign_numbers(&own, &array, &file.place())?
                }
            };
            let alike = &keys[first.1..place];
            for (at, before, value) in given {
                let other = alike.iter().find(|(_, number, ..)| *number == before);
                if let Some((_, _, other, ..)) = other {
                    return Err(self.given_twice(at, [other, key], value));
                }
            }
        }
        Ok(())
    }

    /// Two keys alike that give one site different values.
    fn given_twice(
        &self,
        at: usize,
        [one, other]: [&Located<String>; 2],
        [before, after]: [f64; 2],
    ) -> Refusal {
        let (one, written) = (&one.value, &other.value);
        Box::new(self.document.diagnostic(
            &other.place(),
            format!(
                "\"{one}\" and \"{written}\" give {} two values, {before:?} and {after:?}",
                self.name(at)
            ),
            "given twice",
            Some(format!(
                "index names are arbitrary, and neither key has priority: keep one, write both as one formula, or give \
                 single sites or rows their own values, as in \"{}\"",
                match one.split_once('[') {
                    Some((family, indices)) if indices.contains(',') => format!("{family}[0,j]"),
                    Some((family, _)) => format!("{family}[0]"),
                    None => one.clone(),
                }
            )),
        ))
    }

    /// Takes in the value of a coordinate. Where another key has given it another one: the coordinate, that key and both values.
    fn set(&mut self, at: usize, value: f64, number: u32) -> Option<Twice> {
        let before = std::mem::replace(&mut self.given_by[at], number);
        let other = std::mem::replace(&mut self.values[at], value);
        let is_other = before != 0 && before != number && other != value;
        is_other.then_some((at, before, [other, value]))
    }

    fn read(
        &self,
        file: &Located<String>,
        column: Option<&Located<String>>,
    ) -> Result<NumberArray, Refusal> {
        let path = self.document.directory().join(&file.value);
        let name = column.map(|column| column.value.as_str());
        let end = path.extension();
        let is_npy = end.is_some_and(|end| end.eq_ignore_ascii_case("npy"));
        let numbers = match is_npy && column.is_none() {
            true => read_npy(&path),
            false => read_numbers(&path, name),
        };
        numbers.map_err(|reason| {
            let help = "a number for each site: CSV or a JSON list, each in a row of its own or those of the last axis in a row, or an \
                        array of NumPy's (.npy), of the lattice's shape or the last axis fastest";
            let document = self.document;
            Box::new(document.diagnostic(&file.place(), reason, "this file", Some(help.to_owned())))
        })
    }

    /// How many sites there are along each axis of which a key names the index.
    fn shape(&self, names: &[&str], sites: usize) -> Vec<usize> {
        let axes = &self.document.system.axes;
        match axes.len() > 1 && axes.len() == names.len() {
            true => {
                let named = names.iter().zip(axes).filter(|(name, _)| !name.is_empty());
                named.map(|(_, length)| *length).collect()
            }
            false => vec![sites],
        }
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

    /// A number for each site: an array of the lattice's shape, with the last axis in rows, or in one list.
    fn assign_numbers(
        &mut self,
        own: &GivenKey<'_>,
        NumberArray { shape, numbers }: &NumberArray,
        place: &Place,
    ) -> Result<Vec<Twice>, Refusal> {
        let (key, pattern) = (own.key, own.pattern);
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
        let expected = self.shape(&names, length);
        let last = expected.last().copied().unwrap_or(1);
        let is_grid = expected.len() > 2 && matches!(shape[..], [_, columns] if columns == last);
        if shape.len() > 1 && *shape != expected && !is_grid {
            return refuse(
                place,
                format!(
                    "the numbers have the shape {shape:?}, and the sites of `{}` have the shape {expected:?}",
                    key.value
                ),
                "an array of that shape, or one list with the last axis fastest; numbers for every two sites of a chain are \
                 parameters \"J[i,j]\""
                    .to_owned(),
            );
        }
        if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
            return refuse(
                place,
                format!("the number of site {at} is {:?}", numbers[at]),
                "a finite number for each site".to_owned(),
            );
        }
        let mut twice = Vec::new();
        for (i, value) in sites.into_iter().zip(numbers) {
            let at = pattern
                .resolve(&self.scope, Some((&names, i)))
                .map_err(|error| refusal(self.document, key, &error))?;
            if let Some(at) = at {
                twice.extend(self.set(at, *value, own.number));
            }
        }
        Ok(twice)
    }

    fn assign(
        &mut self,
        own: &GivenKey<'_>,
        formula: &Located<String>,
        parsed: &Formula,
    ) -> Result<Vec<Twice>, Refusal> {
        let (key, pattern) = (own.key, own.pattern);
        let mut twice = Vec::new();
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
            // Parameters of sites stand behind the coordinates.
            let coordinates = self.document.system.coordinates();
            let known = |at: usize| {
                let is_known = at >= coordinates && self.given_by[at] != 0;
                is_known.then(|| self.values[at])
            };
            let value = parsed
                .value_with_sites(&self.scope, (&self.parameters, &known), index)
                .map_err(|error| refusal(self.document, formula, &error))?;
            if !value.is_finite() {
                return Err(self.not_finite(formula, at, index, value));
            }
            twice.extend(self.set(at, value, own.number));
        }
        Ok(twice)
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
        let Some(at) = self.given_by.iter().position(|key| *key == 0) else {
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
