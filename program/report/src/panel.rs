//! Curves in one frame, on linear or logarithmic axes.

use super::axis::{Axis, Frame};
use super::canvas::{AXIS, Canvas, PAPER, SERIES};
use super::error::ReportError;
use super::figure::Figure;

/// An axis of a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelAxis {
    /// Quantity that the axis shows, as the axis's label.
    pub title: String,
    /// Whether equal ratios have equal distances; values that are not positive are then left out.
    pub is_logarithmic: bool,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Points joined by a line.
    Line,
    /// Discs.
    Points,
    /// A thin dashed line between its first and last point, to compare with. Guides stand after
    /// the other series; the caption tells what they are.
    Guide,
}

/// A curve.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelSeries {
    /// Its name, for the legend.
    pub name: String,
    /// Its points; those that are not finite are left out and counted.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub stroke: Stroke,
}

/// A picture of curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// The heading.
    pub title: String,
    /// Caption: the quantities shown and how to read the picture.
    pub caption: String,
    /// The horizontal axis.
    pub x: PanelAxis,
    /// The vertical axis.
    pub y: PanelAxis,
    /// The curves.
    pub series: Vec<PanelSeries>,
}

/// The picture's size in logical pixels.
const SIZE: (f64, f64) = (480.0, 300.0);

impl PanelAxis {
    /// Equal differences, equal distances.
    pub fn linear(title: &str) -> Self {
        Self {
            title: title.to_owned(),
            is_logarithmic: false,
        }
    }

    /// Equal ratios, equal distances.
    pub fn logarithmic(title: &str) -> Self {
        Self {
            title: title.to_owned(),
            is_logarithmic: true,
        }
    }

    fn shows(&self, value: f64) -> bool {
        value.is_finite() && (!self.is_logarithmic || value > 0.0)
    }

    fn over(&self, values: impl Iterator<Item = f64>, padding: f64) -> Axis {
        if self.is_logarithmic {
            Axis::logarithmic(values)
        } else {
            Axis::linear(values, padding)
        }
    }
}

impl Panel {
    /// The picture as an SVG file of its own, on white.
    ///
    /// # Errors
    /// [`ReportError`] if the drawing library refuses it.
    pub fn svg(&self) -> Result<String, ReportError> {
        self.draw(true)
    }

    fn draw(&self, has_ground: bool) -> Result<String, ReportError> {
        let (width, height) = SIZE;
        let shown = |point: &(f64, f64)| self.x.shows(point.0) && self.y.shows(point.1);
        let all = || self.series.iter().flat_map(|series| &series.points);
        let x = self.x.over(all().filter(|p| shown(p)).map(|p| p.0), 0.0);
        let y = self.y.over(all().filter(|p| shown(p)).map(|p| p.1), 0.06);
        let frame = Frame::new(width, height, x, y);
        let mut canvas = Canvas::new(width, height);
        if has_ground {
            canvas.cell((0.0, 0.0), SIZE, PAPER);
        }
        frame.draw(&mut canvas, &self.x.title, &self.y.title);
        for (at, series) in self.series.iter().enumerate() {
            let ink = SERIES[at % SERIES.len()];
            let points: Vec<(f64, f64)> = series
                .points
                .iter()
                .filter(|point| shown(point))
                .map(|&(x, y)| frame.point(x, y))
                .collect();
            match (series.stroke, points.first(), points.last()) {
                (Stroke::Line, ..) => canvas.path(&points, ink, 1.6),
                (Stroke::Guide, Some(&first), Some(&last)) => {
                    canvas.dashes(first, last, AXIS, 1.2);
                }
                (Stroke::Points, ..) => points.iter().for_each(|&at| canvas.disc(at, 2.6, ink)),
                (Stroke::Guide, ..) => {}
            }
        }
        if has_ground {
            canvas.finish_alone(&self.title)
        } else {
            canvas.finish(&self.title)
        }
    }

    /// Values that are not finite, and how many.
    fn left_out(&self) -> Option<String> {
        let all = self.series.iter().flat_map(|series| &series.points);
        let count = all.filter(|(_, y)| !y.is_finite()).count();
        match count {
            0 => None,
            1 => Some("One value is not finite and is not drawn.".to_owned()),
            _ => Some(format!("{count} values are not finite and are not drawn.")),
        }
    }
}

/// Draws a panel with its heading, legend and caption.
pub(super) fn panel_figure(panel: &Panel) -> Result<Figure, ReportError> {
    let curves = panel.series.iter().filter(|s| s.stroke != Stroke::Guide);
    let names: Vec<String> = curves.map(|series| series.name.clone()).collect();
    let legend = if names.len() > 1 { names } else { Vec::new() };
    Ok(Figure {
        title: panel.title.clone(),
        svg: panel.draw(false)?,
        legend,
        caption: panel.caption.clone(),
        colors: Vec::new(),
        notes: panel.left_out().into_iter().collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(points: Vec<(f64, f64)>) -> Panel {
        Panel {
            title: "error".to_owned(),
            caption: String::new(),
            x: PanelAxis::logarithmic("epsilon"),
            y: PanelAxis::logarithmic("error"),
            series: vec![PanelSeries {
                name: "n = 4".to_owned(),
                points,
                stroke: Stroke::Line,
            }],
        }
    }

    #[test]
    fn what_has_no_place_on_the_axes_is_left_out_and_counted() {
        let panel = panel(vec![(0.1, 1e-3), (0.0, 1.0), (0.2, f64::NAN), (0.4, 0.1)]);
        let svg = panel.svg().expect("a picture");
        assert!(svg.contains("polyline") && !svg.contains("NaN"), "{svg}");
        // A file of its own has the size of a picture, not that of its drawing units.
        let size = format!("width=\"{}\" height=\"{}\"", SIZE.0, SIZE.1);
        assert!(svg.contains(&size), "{svg}");
        let figure = panel_figure(&panel).expect("a picture");
        assert_eq!(figure.notes, ["One value is not finite and is not drawn."]);
        assert!(figure.legend.is_empty());
    }

    #[test]
    fn an_empty_panel_is_a_frame() {
        assert!(panel(Vec::new()).svg().expect("a frame").contains("error"));
    }
}
