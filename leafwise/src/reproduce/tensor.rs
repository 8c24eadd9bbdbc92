//! The tensor conservation error against ε over a fixed bisection (paper, Figures 5 and 8).

use leafwise_core::Registry;
use leafwise_core::diagnostics::TensorDefect;
use leafwise_scene::report::{Panel, PanelAxis, PanelSeries, Stroke};

use super::error::ReproduceError;
use super::figure::Reproduced;
use super::order::{ErrorCurve, finding, geometric};
use super::paper::PaperFigure;
use super::scene::{FigureScene, composed};

/// h: with Hamilton–Jacobi to order 2 the bisection is graph(h dH), whatever ε is.
const H: f64 = 2.0;

/// Roundings of DΦ Π DΦᵀ, whose factors come out of a linear solve.
const OPERATIONS: f64 = 100.0;

/// Measures Figure 5 or 8.
pub(super) fn reproduce(
    paper: &'static PaperFigure,
    registry: &Registry,
) -> Result<Reproduced, ReproduceError> {
    // Where errors are asymptotic: the exponents of the Lotka–Volterra realization are ten times
    // as large as the angles of the rigid body's.
    let (system, n, largest, theory) = match paper.number {
        5 => ("rigid-body", 6, 0.1, 9.0),
        _ => ("lotka-volterra", 8, 0.02, 9.0),
    };
    let scene = FigureScene {
        system,
        order: n,
        epsilon: largest,
        h: H,
        steps: 1,
    };
    let fit = geometric(largest, 4, 12);
    let curve = errors(&scene, registry, &fit)?;
    let fitted = curve.order(paper.number, 1.0)?;
    let wide: Vec<f64> = (1..=100)
        .map(|k| 2.0 * largest * f64::from(k) / 100.0)
        .collect();
    let wide = errors(&scene, registry, &wide)?;
    let explanation = match paper.number {
        5 => {
            "The slope is n + 3 = 9, the bound of Theorem 1 being n + 1 = 7. The first term left \
             out of alpha has order n + 2 and is even in p, so that alpha and beta err alike, and \
             what remains in alpha after beta^-1 has one order more."
        }
        _ => {
            "Theorem 1 gives n + 1 = 9, and no Bernoulli number helps here: the tensor is \
             quadratic. A fit that reaches out of the asymptotic regime gives slightly more."
        }
    };
    let finding = finding(
        &paper.claims[0],
        fitted,
        theory,
        0.5,
        explanation.to_owned(),
    );
    let name = format!("n = {n}");
    Ok(Reproduced {
        paper,
        panels: vec![
            Panel {
                title: "Tensor conservation error".to_owned(),
                caption: "One step over the bisection graph(2 dH), on linear axes.".to_owned(),
                x: PanelAxis::linear("epsilon"),
                y: PanelAxis::linear("error"),
                series: vec![PanelSeries {
                    name: name.clone(),
                    points: wide.points,
                    stroke: Stroke::Line,
                }],
            },
            Panel {
                title: "The same on logarithmic axes".to_owned(),
                caption: format!(
                    "Dashed: slope {theory}. Errors below {:.0e} are round-off.",
                    curve.round_off
                ),
                x: PanelAxis::logarithmic("epsilon"),
                y: PanelAxis::logarithmic("error"),
                series: vec![
                    PanelSeries {
                        name,
                        points: curve.points.clone(),
                        stroke: Stroke::Points,
                    },
                    curve.guide(theory),
                ],
            },
        ],
        findings: vec![finding],
        scene: None,
    })
}

/// |DΦ Π DΦᵀ − Π∘Φ| of one step at every ε; steps that fail are left out.
pub(super) fn errors(
    scene: &FigureScene,
    registry: &Registry,
    epsilons: &[f64],
) -> Result<ErrorCurve, ReproduceError> {
    let run = composed(&scene.text(), registry)?;
    let values = run.system.parameter_values();
    let mut curve = ErrorCurve {
        points: Vec::with_capacity(epsilons.len()),
        round_off: 0.0,
    };
    for &epsilon in epsilons {
        let mut instrument =
            TensorDefect::new(&run.system, run.method.map(), &values, epsilon, scene.h)?;
        if let Ok(defect) = instrument.measure(&run.plan.initial) {
            let stretch = defect.tangent.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
            let size = defect.scale * stretch * stretch;
            curve.round_off = curve.round_off.max(OPERATIONS * size * f64::EPSILON / 2.0);
            curve.points.push((epsilon, defect.norm));
        }
    }
    Ok(curve)
}
