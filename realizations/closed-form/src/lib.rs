//! Realizations that a scene writes as formulas.
//!
//! In a cotangent chart about σ(x) = (x, 0) a realization is a map α_ε(x, p) with α_ε(x, 0) = x. Where (x, p) ↦ (x, −p)
//! is the inverse, β_ε(x, p) = α_ε(x, −p). A scene gives the components of α, and those of β where it is another map.
//! Its words on their accuracy are a claim, which `leafwise verify` measures.

use std::sync::Arc;

use leafwise_core::formulas::{FormulaRealization, FormulaText, RealizationFormulas, scope};
use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{Accuracy, BuildError, ClosedRealization, PoissonSystem, RealizationData};
use leafwise_expression::Expression;

static INFO: PartInfo = PartInfo {
    name: "closed-form",
    summary: "a realization that the scene writes: alpha(x, p) by formulas in a cotangent chart",
    declares: "what the scene claims: exact, or an order; self-adjoint where beta is alpha at -p",
    domain: "systems of single variables, where the formulas have values and `domain` is below 1",
    literature: "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic Realizations, sections 2 and 3.2",
    parameters: &[
        ParameterInfo {
            name: ALPHA,
            summary: "a formula for each variable, of the variables x, y, ..., their momenta p_x, p_y, ..., epsilon and \
                      the system's parameters: [\"x + epsilon*p_y/2\", \"y - epsilon*p_x/2\"]",
            default: ParameterDefault::Formulas(&[]),
        },
        ParameterInfo {
            name: BETA,
            summary: "the same for beta; the default is alpha at -p",
            default: ParameterDefault::Formulas(&[]),
        },
        ParameterInfo {
            name: DOMAIN,
            summary: "a formula that is below 1 inside the chart, as \"epsilon*sqrt(p_x^2 + p_y^2)/pi\"; the default is everywhere",
            default: ParameterDefault::Formulas(&[]),
        },
        ParameterInfo {
            name: ORDER,
            summary: "the order n that is claimed, alpha + O(eps^(n+1)); 0 claims that it is exact",
            default: ParameterDefault::Integer(0),
        },
    ],
    is_written: true,
    ..PartInfo::of(PartKind::Realization)
};

const ALPHA: &str = "alpha";
const BETA: &str = "beta";
const DOMAIN: &str = "domain";
const ORDER: &str = "order";

/// Orders beyond this one are claims that no measurement in doubles tells apart.
const LARGEST_ORDER: i64 = 20;

/// The realization of the formulas that are given.
fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    system.formulas(INFO.name)?;
    let d = system.dimension();
    let momenta = system.variables().iter().map(|name| format!("p_{name}"));
    let further: Vec<String> = momenta.chain(["epsilon".to_owned()]).collect();
    let scope = scope(INFO.name, system, &further)?;
    let read = |parameter, count| -> Result<Option<Vec<Expression>>, BuildError> {
        let text = parameters.setting(&INFO, parameter)?.to_string();
        let text = FormulaText {
            part: INFO.name,
            parameter,
            text: &text,
        };
        match text.is_empty() {
            true => Ok(None),
            false => text.parse_all(&scope, count).map(Some),
        }
    };
    let alpha = read(ALPHA, d)?.ok_or_else(|| BuildError::NotMade {
        part: INFO.name,
        reason: format!("it needs `{ALPHA}`, a formula for each of the system's {d} variables"),
    })?;
    let formulas = RealizationFormulas {
        alpha,
        beta: read(BETA, d)?,
        domain: read(DOMAIN, 1)?.and_then(|domain| domain.into_iter().next()),
    };
    let values = system.parameter_values();
    let form = FormulaRealization::new(formulas, accuracy(parameters)?, false, &values);
    if let Some(off) = form.off_section(near(system), &values) {
        let (parameter, name) = match off.is_target {
            false => (ALPHA, &system.variables()[off.position]),
            true => (BETA, &system.variables()[off.position]),
        };
        return Err(BuildError::Formula {
            part: INFO.name,
            parameter: parameter.to_owned(),
            position: off.position,
            span: None,
            problem: format!(
                "{parameter}(x, 0) must be x, and where {name} = {:.6} and p = 0 this is {:.6}",
                off.expected, off.value
            ),
        });
    }
    Ok(Arc::new(ClosedRealization::new(INFO.name, form)?))
}

/// Accuracy that the scene claims: exact, or an order in ε.
fn accuracy(parameters: &PartParameters) -> Result<Accuracy, BuildError> {
    match parameters.get(&INFO, ORDER)? {
        0 => Ok(Accuracy::Exact),
        order @ 1..=LARGEST_ORDER => Ok(Accuracy::Order(order.unsigned_abs() as usize)),
        order => Err(BuildError::Parameter {
            part: INFO.name,
            parameter: ORDER.to_owned(),
            value: order.to_string(),
            expected: format!("1 to {LARGEST_ORDER}, or 0 for an exact realization"),
        }),
    }
}

/// The state that the system was composed at, where it has one.
fn near(system: &PoissonSystem) -> &[f64] {
    system.expressions().map_or(&[], |formulas| formulas.near())
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
