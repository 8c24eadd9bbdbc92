//! The page of a survey: errors and a table for each problem, then what does not fit.

use serde::Serialize;

use super::error::ReportError;
use super::figure::Figure;
use super::template::render;

/// Contents of a survey's page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurveyData {
    /// The heading.
    pub title: String,
    /// The program and its version.
    pub version: String,
    /// The tables' headings.
    pub headings: Vec<String>,
    /// The problems.
    pub problems: Vec<SurveyedProblem>,
    /// Parts that do not fit, problem by problem.
    pub refused: Vec<RefusedParts>,
}

/// A problem with all maps that were measured on it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurveyedProblem {
    /// Its name.
    pub name: String,
    /// Global errors, a line a map.
    #[serde(skip)]
    pub lines: Vec<ErrorLine>,
    /// The table, a row a map.
    pub rows: Vec<SurveyedMap>,
}

/// Global errors of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorLine {
    /// The map.
    pub map: String,
    /// Its declared order, which gives the colour.
    pub order: usize,
    /// (t, error); errors that are not finite are left out.
    pub points: Vec<(f64, f64)>,
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurveyedMap {
    /// A cell for each heading.
    pub cells: Vec<String>,
    /// Whether it is what it declares to be.
    pub is_met: bool,
}

/// Parts that do not fit a problem, with the causes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RefusedParts {
    /// The problem.
    pub name: String,
    /// Who does not fit, and why.
    pub causes: Vec<(String, String)>,
}

/// A survey as one HTML page: no scripts, nothing fetched, light and dark.
///
/// # Errors
/// None on a survey; [`ReportError::Page`] where the template does not fit these types.
pub fn render_survey(data: &SurveyData) -> Result<String, ReportError> {
    let drawn = data.problems.iter().map(|problem| errors(&problem.lines));
    let figures: Result<Vec<Option<Figure>>, ReportError> = drawn.collect();
    let page = Page {
        data,
        figures: figures?,
    };
    render("survey.html", &page)
}

/// Values for the template `survey.html`.
#[derive(Serialize)]
struct Page<'a> {
    data: &'a SurveyData,
    /// For each problem its errors, where something was measured.
    figures: Vec<Option<Figure>>,
}

/// The picture's size in logical pixels, and the edges of its frame.
const SIZE: (u32, u32) = (720, 390);
const EDGES: Edges = Edges {
    left: 56.0,
    top: 16.0,
    right: 700.0,
    bottom: 344.0,
};

/// Errors below this are round-off.
const SMALLEST: f64 = 1e-16;

/// Declared orders with a colour of their own; what declares another has that of the next lower.
const ORDERS: [usize; 5] = [2, 4, 6, 8, 10];

/// Lines are coloured by the declared order, so that lines of one colour run parallel; `None` where
/// nothing was measured.
fn errors(lines: &[ErrorLine]) -> Result<Option<Figure>, ReportError> {
    let logarithms: Vec<Vec<(f64, f64)>> = lines.iter().map(logarithms).collect();
    let Some(frame) = Frame::around(logarithms.iter().flatten()) else {
        return Ok(None);
    };
    let drawn = lines.iter().zip(&logarithms);
    let picture = Picture {
        size: SIZE,
        frame: EDGES,
        errors: frame.decades(),
        steps: frame.octaves(),
        lines: drawn
            .map(|(line, points)| Polyline {
                map: &line.map,
                color: color(line.order),
                points: frame.points(points),
            })
            .collect(),
    };
    Ok(Some(Figure {
        title: "Global errors".to_owned(),
        svg: render("errors.svg", &picture)?,
        legend: ORDERS.map(|order| format!("order {order}")).to_vec(),
        caption:
            "Error after twenty of the problem's steps, relative to the state, against the step; \
                  by declared order. Under the pointer a line names its map."
                .to_owned(),
        colors: Vec::new(),
        notes: Vec::new(),
    }))
}

/// (log₁₀ t, log₁₀ error).
fn logarithms(line: &ErrorLine) -> Vec<(f64, f64)> {
    let finite = line.points.iter().filter(|(_, error)| error.is_finite());
    let logarithm = |(t, error): &(f64, f64)| (libm::log10(*t), libm::log10(error.max(SMALLEST)));
    finite.map(logarithm).collect()
}

/// The class of the style sheet, as the legend counts them.
fn color(order: usize) -> String {
    let known = ORDERS.iter().rposition(|known| *known <= order);
    known.map_or_else(|| "plain".to_owned(), |at| format!("s{at}"))
}

/// Values for the template `errors.svg`.
#[derive(Serialize)]
struct Picture<'a> {
    size: (u32, u32),
    frame: Edges,
    errors: Vec<Tick>,
    steps: Vec<Tick>,
    lines: Vec<Polyline<'a>>,
}

/// Where a frame ends.
#[derive(Clone, Copy, Serialize)]
struct Edges {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

/// A line, as the template draws it.
#[derive(Serialize)]
struct Polyline<'a> {
    map: &'a str,
    color: String,
    points: String,
}

/// A grid line and its label.
#[derive(Serialize)]
struct Tick {
    at: String,
    label: String,
}

/// The ranges of log₁₀ t and log₁₀ error.
struct Frame {
    x: [f64; 2],
    y: [f64; 2],
}

impl Frame {
    fn around<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> Option<Self> {
        let floor = libm::log10(SMALLEST);
        let mut frame = Self {
            x: [f64::INFINITY, f64::NEG_INFINITY],
            y: [floor, floor],
        };
        for (x, y) in points {
            frame.x = [frame.x[0].min(*x), frame.x[1].max(*x)];
            frame.y[1] = frame.y[1].max(libm::ceil(*y));
        }
        (frame.x[0] < frame.x[1] && frame.y[0] < frame.y[1]).then_some(frame)
    }

    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let fraction = |value: f64, [low, high]: [f64; 2]| (value - low) / (high - low);
        (
            EDGES.left + fraction(x, self.x) * (EDGES.right - EDGES.left),
            EDGES.bottom - fraction(y, self.y) * (EDGES.bottom - EDGES.top),
        )
    }

    /// Points as SVG lists them.
    fn points(&self, points: &[(f64, f64)]) -> String {
        let places = points.iter().map(|point| self.place(*point));
        let texts: Vec<String> = places.map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        texts.join(" ")
    }

    /// Every other decade of errors.
    fn decades(&self) -> Vec<Tick> {
        let exponents = (self.y[0] as i32..=self.y[1] as i32).step_by(2);
        exponents
            .map(|exponent| Tick {
                at: format!("{:.1}", self.place((self.x[0], f64::from(exponent))).1),
                label: format!("1e{exponent}"),
            })
            .collect()
    }

    /// Steps that are powers of two.
    fn octaves(&self) -> Vec<Tick> {
        let octave = libm::log10(2.0);
        let (first, last) = (self.x[0] / octave, self.x[1] / octave);
        let exponents = libm::ceil(first) as i32..=libm::floor(last) as i32;
        exponents
            .map(|exponent| Tick {
                at: format!(
                    "{:.1}",
                    self.place((f64::from(exponent) * octave, self.y[0])).0
                ),
                label: libm::exp2(f64::from(exponent)).to_string(),
            })
            .collect()
    }
}
