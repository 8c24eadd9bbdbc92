//! Observables that a run records: the energy, Casimirs, or any formula of the state.

use std::sync::Arc;

use leafwise_core::PoissonSystem;
use leafwise_core::lattice::LatticeGeometry;
use leafwise_core::pairs::{BodyFunction, BodyShape};
use leafwise_core::shadow::MakeShadowEnergy;
use leafwise_expression::Expression;
use leafwise_expression::syntax::Scope;
use leafwise_walk::Indicator;

use super::Refusal;
use super::geometry::geometry;
use super::names::{function, parse_text, refusal};
use super::own_columns::{INDICATORS, SHADOW_ENERGY};
use super::site_functions::SiteFunction;
use super::spin_temperature::{SPIN_TEMPERATURE, is_spin_temperature};
use super::time::TIME;
use crate::document::{Located, ObservableSpec, SceneDocument, nearest};

/// One recorded quantity.
#[derive(Clone, Debug)]
pub enum Observable {
    /// An invariant by its place: 0 is the energy, k the k-th Casimir.
    Invariant {
        /// Its name.
        name: String,
        /// Its place.
        index: usize,
    },
    /// A formula of the state, named by its text.
    Formula {
        /// The text.
        name: String,
        /// The function.
        formula: RecordedFormula,
    },
    /// A coordinate of a long lattice by its place.
    Coordinate {
        /// Its name.
        name: String,
        /// Its place.
        index: usize,
    },
    /// An indicator of chaos by its place among those of the run.
    Indicator {
        /// Its name.
        name: String,
        /// Its place.
        index: usize,
    },
}

/// A recorded function of the state.
#[derive(Clone, Debug)]
pub enum RecordedFormula {
    /// A formula of the coordinates.
    Written(Expression),
    /// A function of sums over sites and pairs, evaluated in a loop.
    Sums(BodyShape, Box<BodyFunction>),
    /// A shadow energy as numbers.
    Shadow(ShadowNumbers),
    /// A function of sums over sites, which a long lattice evaluates by itself.
    OfSites,
    /// The temperature of all spins.
    SpinTemperature,
}

/// H̃ as numbers, of the step t.
#[derive(Clone)]
pub struct ShadowNumbers {
    pub(super) make: Arc<MakeShadowEnergy>,
    pub(super) t: f64,
}

impl std::fmt::Debug for ShadowNumbers {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut text = f.debug_struct("ShadowNumbers");
        text.field("t", &self.t).finish_non_exhaustive()
    }
}

impl Observable {
    /// The heading of its column.
    pub fn name(&self) -> &str {
        match self {
            Self::Invariant { name, .. }
            | Self::Formula { name, .. }
            | Self::Coordinate { name, .. }
            | Self::Indicator { name, .. } => name,
        }
    }
}

/// The observables the scene asks for; with the lattice at its true length and its names in `lattice` where `scope` is that
/// of a shorter one.
pub(super) fn observables(
    document: &SceneDocument,
    scope: &Scope,
    lattice: Option<(&LatticeGeometry, &Scope)>,
) -> Result<Vec<Observable>, Refusal> {
    observables_in(document, lattice, |formula, known| {
        let mut names = scope;
        if let Some((geometry, whole)) = lattice
            && let Ok(function) = SiteFunction::of(document, formula)
        {
            // Where a single site is named, the short lattice may have none.
            names = whole;
            match &function {
                SiteFunction::Sum(_) => names = scope,
                SiteFunction::OfSums(_, sums) if !sums.is_empty() => {
                    function.outside(document, (formula, whole), geometry.dimension())?;
                    return Ok(RecordedFormula::OfSites);
                }
                _ => {}
            }
        }
        expression(document, names, formula, known).map(RecordedFormula::Written)
    })
}

/// The same with formulas as `read` makes them, of the text and of the names of invariants.
pub(super) fn observables_in(
    document: &SceneDocument,
    lattice: Option<(&LatticeGeometry, &Scope)>,
    read: impl Fn(&Located<String>, &[&str]) -> Result<RecordedFormula, Refusal>,
) -> Result<Vec<Observable>, Refusal> {
    let mut known = vec!["energy"];
    known.extend(
        document
            .system
            .casimirs
            .iter()
            .map(|(name, _)| name.value.as_str()),
    );
    known.extend(document.system.constraints.iter().map(|c| c.value.as_str()));
    // Whether the scene has a name for a text of its own.
    let is_declared = |formula: &Located<String>, known: &[&str]| {
        known.contains(&formula.value.as_str()) || read(formula, known).is_ok()
    };
    let mut chosen: Vec<Observable> = Vec::new();
    for asked in &document.run.record.observables {
        let heading = asked.heading();
        if chosen.iter().any(|observable| observable.name() == heading) {
            let place = asked.name.as_ref().unwrap_or(&asked.formula).place();
            return Err(Box::new(document.diagnostic(
                &place,
                format!("`{heading}` is recorded twice"),
                "again",
                Some("remove one of them, or give it another name".to_owned()),
            )));
        }
        check_heading(document, asked)?;
        let formula = &asked.formula;
        let name = heading.to_owned();
        if shadow_order(&formula.value).is_some() {
            // H, until there is a map with a shadow.
            chosen.push(Observable::Invariant { name, index: 0 });
            continue;
        }
        if is_spin_temperature(&formula.value) {
            let formula = RecordedFormula::SpinTemperature;
            chosen.push(Observable::Formula { name, formula });
            continue;
        }
        if asks_for_indicator(&formula.value) && !is_declared(formula, &known) {
            if indicator(&formula.value).is_none() {
                return Err(no_indicator(document, formula));
            }
            let earlier = chosen
                .iter()
                .filter(|o| matches!(o, Observable::Indicator { .. }));
            let index = earlier.count();
            chosen.push(Observable::Indicator { name, index });
            continue;
        }
        let coordinate = lattice.and_then(|(lattice, _)| coordinate(lattice, &formula.value));
        chosen.push(match known.iter().position(|name| *name == formula.value) {
            Some(index) => Observable::Invariant { name, index },
            None => match coordinate {
                Some(index) => Observable::Coordinate { name, index },
                None => Observable::Formula {
                    name,
                    formula: read(formula, &known)?,
                },
            },
        });
    }
    Ok(chosen)
}

/// Refuses a column by the name of something else that a run records: it would be taken for that.
///
/// # Errors
/// The name, underlined in the scene.
fn check_heading(document: &SceneDocument, asked: &ObservableSpec) -> Result<(), Refusal> {
    let Some(given) = &asked.name else {
        return Ok(());
    };
    let (name, text) = (given.value.trim(), asked.formula.value.trim());
    let system = &document.system;
    let mut casimirs = system.casimirs.iter();
    let casimir = casimirs.find(|(own, _)| own.value == name);
    let mut constraints = system.constraints.iter();
    let is_variable = || system.variables.iter().any(|own| own.value == name);
    // What it is, and the formula that may stand for it.
    let (what, own) = if name == "energy" {
        ("the Hamiltonian's value", Some(&system.hamiltonian.value))
    } else if let Some((_, formula)) = casimir {
        ("a Casimir", Some(&formula.value))
    } else if constraints.any(|own| own.value == name) {
        ("a constraint", None)
    } else if name == TIME {
        ("the time, the first column of every table", None)
    } else if is_variable() || coordinate(&geometry(document), name).is_some() {
        ("a coordinate", None)
    } else if asks_for_indicator(name) && !asks_for_indicator(text) {
        ("an indicator of chaos", None)
    } else if shadow_order(name).is_some() && shadow_order(text).is_none() {
        ("the energy of the map's shadow", None)
    } else if is_spin_temperature(name) {
        ("the temperature of spins", None)
    } else {
        return Ok(());
    };
    if text == name || own.is_some_and(|own| own.trim() == text) {
        return Ok(());
    }
    Err(Box::new(document.diagnostic(
        &given.place(),
        format!("an observable cannot be called `{name}` here: that is {what}, and `{text}` is another function"),
        "taken",
        Some(format!("give it another name, as {{ my_{} = \"…\" }}", plain(name))),
    )))
}

/// A name without the signs that formulas have.
fn plain(name: &str) -> String {
    let is_sign = |c: char| !(c.is_alphanumeric() || c == '_');
    let parts = name.split(is_sign).filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join("_")
}

/// Refuses the temperature of spins where a system has none, or no formulas of them.
///
/// # Errors
/// The name, underlined in the scene.
pub(super) fn check_spins(
    document: &SceneDocument,
    system: &PoissonSystem,
    observables: &[Observable],
) -> Result<(), Refusal> {
    let recorded = document.run.record.observables.iter().zip(observables);
    let is_one = |observable: &Observable| {
        let Observable::Formula { formula, .. } = observable else {
            return false;
        };
        matches!(formula, RecordedFormula::SpinTemperature)
    };
    let Some((asked, _)) = recorded.into_iter().find(|(_, own)| is_one(own)) else {
        return Ok(());
    };
    let (why, help) = match system.expressions() {
        None => (
            "is formed of the derivatives of H at each spin, which loops over pairs and systems of numbers do not offer",
            "record sums of your own, or shorten the lattice for a stepper that writes it out",
        ),
        Some(formulas) if formulas.spins().is_empty() => (
            "is that of coordinates with the brackets of so(3), and this system has none",
            "declare spins: families = { s = { components = [\"x\", \"y\", \"z\"], length = 100 } } with bracket = { \
             lie-algebra = \"so3\" }",
        ),
        Some(_) => return Ok(()),
    };
    Err(Box::new(document.diagnostic(
        &document.place_in_formula(&asked.formula, 0..asked.formula.value.len()),
        format!("`{SPIN_TEMPERATURE}` {why}"),
        "here",
        Some(help.to_owned()),
    )))
}

/// The coordinate that a text such as `q[500]` or `q[Sun]` names.
pub(super) fn coordinate(lattice: &LatticeGeometry, text: &str) -> Option<usize> {
    let (family, rest) = text.trim().split_once('[')?;
    let sites = rest.strip_suffix(']')?.split(',');
    let names = &lattice.site_names;
    let number = |site: &str| names.position(site).or_else(|| site.parse().ok());
    let sites: Vec<usize> = sites
        .map(|site| number(site.trim()))
        .collect::<Option<_>>()?;
    let at = lattice
        .families
        .iter()
        .position(|(name, _)| name == family.trim())?;
    let (length, axes) = (lattice.families[at].1, &lattice.axes);
    let site = match (&sites[..], axes.len()) {
        ([site], 1) => *site,
        (sites, count) if sites.len() == count => {
            let pairs = sites.iter().zip(axes);
            pairs
                .clone()
                .all(|(site, axis)| *site < axis.length)
                .then_some(())?;
            pairs.fold(0, |all, (site, axis)| all * axis.length + site)
        }
        _ => return None,
    };
    (site < length).then(|| lattice.offsets()[at] + site)
}

/// The order that a shadow energy is asked for; `None` where the text is no shadow energy.
pub(super) fn shadow_order(text: &str) -> Option<Option<usize>> {
    let rest = text.trim().strip_prefix(SHADOW_ENERGY)?;
    if rest.is_empty() {
        return Some(None);
    }
    let order = rest.trim_start().strip_prefix("of order")?;
    order.trim().parse().ok().map(Some)
}

/// The indicator that a text names.
pub(super) fn indicator(text: &str) -> Option<Indicator> {
    let text = text.trim();
    match text {
        "megno" => Some(Indicator::Megno),
        "sali" => Some(Indicator::Sali),
        "lyapunov" => Some(Indicator::Lyapunov(1)),
        _ => {
            let number = text.strip_prefix("lyapunov ")?.trim_start();
            let number: usize = number.parse().ok()?;
            (number > 0).then_some(Indicator::Lyapunov(number))
        }
    }
}

/// Whether a text is that of an indicator, with or without something behind it, rightly or not.
pub(super) fn asks_for_indicator(text: &str) -> bool {
    let text = text.trim();
    let (name, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let rest = rest.trim_start();
    let behind = rest.strip_prefix(['+', '-']).unwrap_or(rest);
    let is_word = |c: char| c.is_alphanumeric() || c == '.';
    INDICATORS.contains(&name) && (rest.is_empty() || behind.starts_with(is_word))
}

/// The refusal of a text that asks for no indicator there is.
fn no_indicator(document: &SceneDocument, asked: &Located<String>) -> Refusal {
    Box::new(document.diagnostic(
        &document.place_in_formula(asked, 0..asked.value.len()),
        format!("`{}` is not an indicator of chaos", asked.value),
        "here",
        Some(
            "write `megno`, `sali`, `lyapunov`, or `lyapunov 2`, `lyapunov 3`, … for the second, third, … largest exponent"
                .to_owned(),
        ),
    ))
}

/// A formula of the state by its text.
///
/// # Errors
/// A text that is neither one of the known names nor a formula.
pub(super) fn expression(
    document: &SceneDocument,
    scope: &Scope,
    asked: &Located<String>,
    known: &[&str],
) -> Result<Expression, Refusal> {
    let resolved =
        parse_text(document, &asked.value).and_then(|parsed| parsed.resolve(scope, None).map(drop));
    if let Err(error) = resolved {
        let begins_like_one = asked.value.starts_with(char::is_alphabetic);
        let is_name = |c: char| c.is_alphabetic() || c.is_ascii_digit() || "_-'".contains(c);
        let is_name = begins_like_one && asked.value.chars().all(is_name);
        let is_constant = ["π", "e"].contains(&asked.value.as_str());
        if !is_name || is_constant || asked.value == TIME {
            return Err(refusal(document, asked, &error));
        }
        let names = known.iter().copied();
        let names = names
            .chain([SHADOW_ENERGY, SPIN_TEMPERATURE])
            .chain(INDICATORS);
        let mut families = document.system.families.iter();
        let is_family = families.any(|(family, _)| family.value == asked.value);
        let help = match nearest(&asked.value, names) {
            _ if is_family => format!(
                "`{0}` has many members: states = [\"{0}\"] records all, and a sum over them is one number",
                asked.value
            ),
            Some(name) => format!("did you mean `{name}`?"),
            None => format!(
                "record {}, {SHADOW_ENERGY}, {SPIN_TEMPERATURE}, {}, or a formula of the variables",
                known.join(", "),
                INDICATORS.join(", ")
            ),
        };
        return Err(Box::new(document.diagnostic(
            &document.place_in_formula(asked, 0..asked.value.len()),
            format!("unknown observable `{}`", asked.value),
            "neither an invariant nor a formula of the variables",
            Some(help),
        )));
    }
    function(document, scope, asked)
}

#[cfg(test)]
mod tests {
    use leafwise_walk::Indicator;

    use super::{asks_for_indicator, indicator, shadow_order};

    #[test]
    fn an_order_may_stand_behind_the_name() {
        assert_eq!(shadow_order("shadow-energy"), Some(None));
        assert_eq!(shadow_order(" shadow-energy of order 8 "), Some(Some(8)));
        assert_eq!(shadow_order("shadow-energy of order two"), None);
        assert_eq!(shadow_order("energy"), None);
    }

    #[test]
    fn a_number_may_stand_behind_the_exponent() {
        assert_eq!(indicator("lyapunov"), Some(Indicator::Lyapunov(1)));
        assert_eq!(indicator(" lyapunov  4"), Some(Indicator::Lyapunov(4)));
        for none in ["lyapunov 0", "lyapunov4", "lyapunov -1", "Megno", "energy"] {
            assert_eq!(indicator(none), None, "{none}");
        }
        for wrong in [
            "lyapunov 0",
            "lyapunov 1.5",
            "lyapunov -1",
            "sali 2",
            "megno two",
        ] {
            assert!(asks_for_indicator(wrong), "{wrong}");
        }
        for formula in ["lyapunov - 1", "sali + q", "lyapunov4", "energy", "2*megno"] {
            assert!(!asks_for_indicator(formula), "{formula}");
        }
    }
}
