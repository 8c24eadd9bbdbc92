//! The realization error against ε (paper, Figures 1, 2 and 9).

use std::ops::RangeInclusive;

use leafwise_core::diagnostics::RealizationInstrument;
use leafwise_core::{PartParameters, Registry};
use leafwise_report::{Panel, PanelAxis, PanelSeries, Stroke};

use super::error::ReproduceError;
use super::figure::{Finding, Reproduced};
use super::order::{ErrorCurve, finding, geometric};
use super::paper::PaperFigure;
use crate::verify::Problem;

/// The truncated realization of a library system at a point.
#[derive(Clone, Debug)]
pub struct RealizationPoint {
    /// The library's system.
    pub system: &'static str,
    /// n.
    pub order: i64,
    /// x.
    pub x: Vec<f64>,
    /// p.
    pub p: Vec<f64>,
}

/// Roundings that end up in one component of the error: its two brackets are sums of products of
/// derivatives, each a few hundred operations deep at n = 10.
const OPERATIONS: f64 = 1e3;

impl RealizationPoint {
    /// On so(3)*, at the paper's point (2, 3, 3, 1, 2, 3).
    pub fn on_so3(order: i64) -> Self {
        Self {
            system: "rigid-body",
            order,
            x: vec![2.0, 3.0, 3.0],
            p: vec![1.0, 2.0, 3.0],
        }
    }

    /// On the magnetic bracket.
    pub fn on_magnetic(order: i64) -> Self {
        Self {
            system: "magnetic",
            order,
            x: vec![2.0, 3.0, 3.0, 1.0, 2.0, 3.0],
            p: vec![1.0, 2.0, 3.0, 2.0, 3.0, 3.0],
        }
    }

    /// (Σ_{i<j} (ε Π_ij(α̂) − {α̂_i, α̂_j}_ω)²)^{1/2} at every ε, as far as the chart reaches.
    ///
    /// # Errors
    /// When the system or the realization cannot be built.
    pub fn errors(
        &self,
        registry: &Registry,
        epsilons: &[f64],
    ) -> Result<ErrorCurve, ReproduceError> {
        let system = Problem::of_library(self.system)?.system;
        let part = registry
            .realization("karasev-truncated")?
            .build(&system, &PartParameters::new().with("order", self.order))?;
        let mut instrument =
            RealizationInstrument::new(&system, &part, &system.parameter_values())?;
        let mut curve = ErrorCurve {
            points: Vec::with_capacity(epsilons.len()),
            round_off: 0.0,
        };
        for &epsilon in epsilons {
            // Beyond the chart there is no error to measure.
            if let Ok(error) = instrument.measure(epsilon, &self.x, &self.p) {
                let round_off = error.scale * OPERATIONS * f64::EPSILON / 2.0;
                curve.round_off = curve.round_off.max(round_off);
                curve.points.push((epsilon, error.source));
            }
        }
        Ok(curve)
    }
}

/// Setting of a figure of this kind: point, ranges of ε, window of the fit and expected slope.
struct View {
    point: RealizationPoint,
    /// The ends of the linear pictures.
    ranges: Vec<f64>,
    /// The window of the fit.
    fit: RangeInclusive<f64>,
    /// The order by which the next term is smaller.
    gap: f64,
    /// Slope that theory predicts.
    slope: f64,
    /// A unit of the printed slope's last digit.
    digit: f64,
}

const POINTS: u32 = 160;

fn view(paper: &PaperFigure) -> View {
    let so3 = |order: i64, ranges: [f64; 2], largest: f64, digit: f64| View {
        point: RealizationPoint::on_so3(order),
        ranges: ranges.to_vec(),
        fit: largest / 16.0..=largest,
        gap: 2.0,
        slope: order as f64 + 2.0,
        digit,
    };
    match paper.number {
        1 => so3(10, [1.6, 0.8], 0.6, 0.01),
        2 => so3(4, [1.6, 0.2], 0.4, 0.1),
        _ => View {
            point: RealizationPoint::on_magnetic(2),
            ranges: Vec::new(),
            fit: 1e-3..=0.1,
            gap: 1.0,
            slope: 3.0,
            digit: 1.0,
        },
    }
}

/// Measures Figure 1, 2 or 9.
pub(super) fn reproduce(
    paper: &'static PaperFigure,
    registry: &Registry,
) -> Result<Reproduced, ReproduceError> {
    let view = view(paper);
    let n = view.point.order;
    let mut panels = Vec::new();
    for &end in &view.ranges {
        let epsilons: Vec<f64> = (1..=POINTS)
            .map(|k| end * f64::from(k) / f64::from(POINTS))
            .collect();
        let curve = view.point.errors(registry, &epsilons)?;
        panels.push(linear(n, end, curve));
    }
    let octaves = libm::ceil(libm::log2(view.fit.end() / view.fit.start())) as u32;
    let fine = geometric(*view.fit.end(), octaves, 12);
    let curve = view.point.errors(registry, &fine)?;
    let fitted = curve.order(paper.number, view.gap)?;
    panels.push(logarithmic(n, &curve, view.slope));
    let mut findings = vec![finding(
        &paper.claims[0],
        fitted,
        view.slope,
        view.digit / 2.0,
        explanation(&view),
    )];
    if let Some(claim) = paper.claims.get(1) {
        let at = |epsilon: f64| -> Result<f64, ReproduceError> {
            let curve = view.point.errors(registry, &[epsilon])?;
            Ok(curve.points.first().map_or(f64::NAN, |point| point.1))
        };
        let (small, large) = (at(0.6)?, at(0.8)?);
        findings.push(Finding {
            claim,
            measured: format!("{small:.1e} at epsilon = 0.6, {large:.1e} at 0.8"),
            value: Some(small),
            tolerance: None,
            explanation: "The chart of the exact realization ends at epsilon = 2 pi/|p| = 1.679, \
                          where its series diverges; the truncated one grows towards it."
                .to_owned(),
            agrees: Some(small < 1e-3),
            holds: small < large,
        });
    }
    Ok(Reproduced {
        paper,
        panels,
        findings,
        scene: None,
    })
}

fn explanation(view: &View) -> String {
    let n = view.point.order;
    match view.point.system {
        "rigid-body" => format!(
            "The slope is n + 2 = {}, one more than the paper's bound n + 1, which holds all the \
             same. On a linear tensor alpha is the series of the Bernoulli numbers B_k, and \
             B_{} = 0, so that the first term left out has order epsilon^{}. Derivatives here are \
             exact. Numerical ones have an error floor that flattens a fit at small epsilon, which \
             can explain a printed slope below {}.",
            n + 2,
            n + 1,
            n + 2,
            n + 2
        ),
        _ => "The slope is n + 1 = 3. From n = 3 on the truncated series of this bracket is \
              exact: there is no error left to fit."
            .to_owned(),
    }
}

fn linear(n: i64, end: f64, curve: ErrorCurve) -> Panel {
    Panel {
        title: format!("Realization error up to epsilon = {end}"),
        caption: format!("The realization error of order n = {n} on linear axes."),
        x: PanelAxis::linear("epsilon"),
        y: PanelAxis::linear("error"),
        series: vec![PanelSeries {
            name: format!("n = {n}"),
            points: curve.points,
            stroke: Stroke::Line,
        }],
    }
}

fn logarithmic(n: i64, curve: &ErrorCurve, slope: f64) -> Panel {
    Panel {
        title: "The same on logarithmic axes".to_owned(),
        caption: format!(
            "Dashed: slope {slope}. Errors below {:.0e} are round-off of the brackets.",
            curve.round_off
        ),
        x: PanelAxis::logarithmic("epsilon"),
        y: PanelAxis::logarithmic("error"),
        series: vec![
            PanelSeries {
                name: format!("n = {n}"),
                points: curve.points.clone(),
                stroke: Stroke::Points,
            },
            curve.guide(slope),
        ],
    }
}
