//! A motion that has no finite value where a run begins, and the parameter to blame.

use leafwise_core::Evaluator;
use leafwise_scene::compose::{ComposedRun, LatticeStepping, Stepping};
use leafwise_scene::document::{FieldSpec, Located, Place, SceneDocument};

/// The most parameters of value 0 that are tried with another one.
const MOST_ZEROS: usize = 64;

/// A motion without a finite value at the initial state.
pub(super) struct UndefinedMotion {
    /// Its coordinate and value; of a long lattice neither.
    pub message: String,
    /// The parameter, of all sites or of one, that is 0 and with another value would leave the motion finite.
    pub zero: Option<String>,
}

/// ẋ at any values of the parameters and in any state; `None` where it cannot be evaluated.
type Field<'a> = dyn Fn(&[f64], &[f64]) -> Option<Vec<f64>> + 'a;

/// The motion where it has no finite value at the initial state; of a long lattice at a state of the short one that stands for it.
pub(super) fn undefined_motion(composed: &ComposedRun) -> Option<UndefinedMotion> {
    let system = &composed.system;
    let near = match composed.method.lattice() {
        Some(_) => &composed.near,
        None => &composed.plan.initial,
    };
    let map = system.field_values().ok()?;
    let field = |parameters: &[f64], state: &[f64]| {
        let mut field = vec![0.0_f64; state.len()];
        let mut evaluator = map.evaluator(parameters, 1.0, 1.0);
        evaluator.values(state, &mut field).ok().map(|()| field)
    };
    let parameters = system.parameter_values();
    let found = field(&parameters, near)?;
    let at = found.iter().position(|v| !v.is_finite());
    // One after the other with another value.
    let cures = |values: &[f64], with: &dyn Fn(&[f64]) -> Option<Vec<f64>>| {
        let zeros = (0..values.len()).filter(|k| values[*k] == 0.0);
        zeros.take(MOST_ZEROS).find(|k| {
            let mut values = values.to_vec();
            values[*k] = 1.0;
            with(&values).is_some_and(|field| at.is_some_and(|at| field[at].is_finite()))
        })
    };
    let number = cures(&parameters, &|parameters| field(parameters, near));
    let number = number.map(|k| system.parameters()[k].name.clone());
    let message = "the motion has no finite value at the initial state";
    if let Stepping::Lattice(lattice) = &composed.method {
        let zero = number.or_else(|| zero_site(composed, lattice, &field));
        return (at.is_some() || zero.is_some()).then(|| UndefinedMotion {
            message: message.to_owned(),
            zero,
        });
    }
    let at = at?;
    // Parameters of sites stand behind the coordinates.
    let (moving, resting) = near.split_at(composed.plan.layout.own().end);
    let of_site = || {
        let with = |resting: &[f64]| field(&parameters, &[moving, resting].concat());
        let name = system
            .variables()
            .get(moving.len() + cures(resting, &with)?);
        name.cloned()
    };
    Some(UndefinedMotion {
        message: format!("{message}: d{}/dt is {}", system.variables()[at], found[at]),
        zero: number.or_else(of_site),
    })
}

/// The first parameter of a long lattice's site that is 0, where the motion has no finite value with that at all sites and has one
/// with another.
fn zero_site(
    composed: &ComposedRun,
    lattice: &LatticeStepping,
    field: &Field<'_>,
) -> Option<String> {
    let (whole, written) = (&lattice.geometry, &lattice.written);
    let parameters = composed.system.parameter_values();
    let is_finite = |family: usize, value: f64| {
        let mut state = composed.near.clone();
        let offset = written.offsets()[family];
        state[offset..offset + written.families[family].1].fill(value);
        let field = field(&parameters, &state);
        field.is_some_and(|field| field.iter().all(|v| v.is_finite()))
    };
    let own = composed.plan.layout.own().end;
    let families = whole.offsets().into_iter().zip(&whole.families).enumerate();
    let resting = families.filter(|(_, (offset, _))| *offset >= own);
    let mut zeros = resting.filter_map(|(family, (offset, (_, sites)))| {
        let values = composed.plan.initial.get(offset..offset + sites)?;
        let site = values.iter().position(|value| *value == 0.0)?;
        (!is_finite(family, 0.0) && is_finite(family, 1.0)).then(|| whole.name(offset + site))
    });
    zeros.next()
}

/// Where a scene gives a parameter, as `g` or `gamma[3]`, its value.
pub(super) fn place_of(document: &SceneDocument, name: &str) -> Place {
    let system = &document.system;
    let Some((family, site)) = name.split_once('[') else {
        let mut numbers = system.parameters.iter();
        let number = numbers.find(|(own, _)| own.value == name);
        return number.map_or_else(|| document.run.initial.place(), |(_, value)| value.place());
    };
    let keys = || {
        system
            .sites
            .iter()
            .filter(|(key, _)| key.value.starts_with(family))
    };
    let compact = |text: &str| text.replace(' ', "");
    let of_site = keys().find(|(key, _)| compact(&key.value) == name);
    let of_all = keys().find(|(key, _)| {
        let rest = key.value[family.len()..].trim_start();
        let index = rest.strip_prefix('[');
        index.is_some_and(|index| index.trim_start().starts_with(char::is_alphabetic))
    });
    match of_site.or(of_all) {
        None => document.run.initial.place(),
        Some((_, FieldSpec::Numbers(numbers, whole))) => {
            let site = site.trim_end_matches(']').parse().ok();
            let number = site.and_then(|site: usize| numbers.get(site));
            number.map_or_else(|| whole.clone(), Located::place)
        }
        Some((_, FieldSpec::Formula(formula))) => formula.place(),
        Some((key, FieldSpec::Rows(..) | FieldSpec::File { .. })) => key.place(),
    }
}
