//! Figures as one object.

use leafwise::report::{Panel, PanelSeries, Stroke};
use leafwise::reproduce::{Finding, PaperFigure, Reproduced};
use leafwise::scene::json::{Double, points};
use serde::Serialize;

/// The object of `reproduce --json`.
#[derive(Serialize)]
pub(super) struct FiguresJson<'a> {
    outcome: &'static str,
    seconds: Double,
    figures: Vec<Figure<'a>>,
}

/// A figure: what was found, and its curves.
#[derive(Serialize)]
struct Figure<'a> {
    #[serde(flatten)]
    paper: &'static PaperFigure,
    findings: Vec<Statement<'a>>,
    panels: Vec<Curves<'a>>,
    scene: Option<&'a str>,
}

/// A statement of the paper and what was measured of it.
#[derive(Serialize)]
struct Statement<'a> {
    quantity: &'static str,
    printed: Printed,
    measured: Measured<'a>,
    theory: &'a str,
    agrees: Option<bool>,
    holds: bool,
}

/// Value that the paper prints: its text, and its number where it has one.
#[derive(Serialize)]
struct Printed {
    text: &'static str,
    value: Option<f64>,
}

/// Value that was measured: its text, then its number and tolerance where it has them.
#[derive(Serialize)]
struct Measured<'a> {
    text: &'a str,
    value: Option<Double>,
    tolerance: Option<Double>,
}

/// The curves of a panel, guides apart.
#[derive(Serialize)]
struct Curves<'a> {
    title: &'a str,
    x: &'a str,
    y: &'a str,
    series: Vec<Series<'a>>,
}

/// A curve.
#[derive(Serialize)]
struct Series<'a> {
    name: &'a str,
    #[serde(serialize_with = "points")]
    points: &'a [(f64, f64)],
}

impl<'a> FiguresJson<'a> {
    pub(super) fn of(figures: &'a [Reproduced], seconds: f64) -> Self {
        let holds = figures.iter().all(Reproduced::holds);
        Self {
            outcome: if holds { "met" } else { "not met" },
            seconds: Double(seconds),
            figures: figures.iter().map(Figure::from).collect(),
        }
    }
}

impl<'a> From<&'a Reproduced> for Figure<'a> {
    fn from(figure: &'a Reproduced) -> Self {
        Self {
            paper: figure.paper,
            findings: figure.findings.iter().map(Statement::from).collect(),
            panels: figure.panels.iter().map(Curves::from).collect(),
            scene: figure.scene.as_deref(),
        }
    }
}

impl<'a> From<&'a Finding> for Statement<'a> {
    fn from(finding: &'a Finding) -> Self {
        Self {
            quantity: finding.claim.quantity,
            printed: Printed {
                text: finding.claim.printed,
                value: finding.claim.value,
            },
            measured: Measured {
                text: &finding.measured,
                value: finding.value.map(Double),
                tolerance: finding.tolerance.map(Double),
            },
            theory: &finding.explanation,
            agrees: finding.agrees,
            holds: finding.holds,
        }
    }
}

impl<'a> From<&'a Panel> for Curves<'a> {
    fn from(panel: &'a Panel) -> Self {
        let series = |series: &'a PanelSeries| Series {
            name: &series.name,
            points: &series.points,
        };
        let measured = panel.series.iter().filter(|s| s.stroke != Stroke::Guide);
        Self {
            title: &panel.title,
            x: &panel.x.title,
            y: &panel.y.title,
            series: measured.map(series).collect(),
        }
    }
}
