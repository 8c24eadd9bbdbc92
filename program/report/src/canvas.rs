//! Drawing in logical pixels on the SVG back end.
//!
//! The back end takes whole pixels, so a canvas draws four times enlarged and the page scales
//! the picture down. Colours are fixed words of the palette below: the style sheet's dark mode
//! recolours them by attribute selectors.

use plotters::prelude::{DrawingBackend, IntoFont, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor, ShapeStyle, TextStyle};

use super::error::ReportError;
use super::html::escaped;
use super::letters::width_of;

/// The size of labels.
const LETTERS: f64 = 12.5;

/// The letters of a browser's font over those of Helvetica, at most.
pub(super) const WIDER: f64 = 1.16;

/// How many SVG units make a logical pixel.
pub(super) const SCALE: f64 = 4.0;

/// The back end writes font sizes divided by this.
const FONT_FACTOR: f64 = 1.24;

/// A colour the style sheet knows.
pub(super) type Ink = RGBColor;

/// Labels.
pub(super) const TEXT: Ink = RGBColor(0x3B, 0x47, 0x54);
/// Frames, boxes and reference lines.
pub(super) const AXIS: Ink = RGBColor(0x9A, 0xA5, 0xB1);
/// Grid lines and everything behind the data.
pub(super) const GRID: Ink = RGBColor(0xE4, 0xE8, 0xED);
/// The surface of a leaf.
pub(super) const LEAF: Ink = RGBColor(0xC9, 0xD3, 0xDF);
/// The inside of a leaf's outline.
pub(super) const SURFACE: Ink = RGBColor(0xF2, 0xF5, 0xF9);
/// The page, to set markers off from lines.
pub(super) const PAPER: Ink = RGBColor(0xFE, 0xFE, 0xFE);
/// Pale blue of curves and areas that lie behind the first series or around it.
pub(super) const FAINT: Ink = RGBColor(0xA9, 0xC6, 0xE0);
/// Values that are not finite.
pub(super) const ALARM: Ink = RGBColor(0xC6, 0x28, 0x28);
/// Series, told apart by colour-blind readers too; they repeat after the last.
pub(super) const SERIES: [Ink; 6] = [
    RGBColor(0x1F, 0x6F, 0xB2),
    RGBColor(0xC8, 0x50, 0x1E),
    RGBColor(0x1D, 0x8A, 0x5F),
    RGBColor(0x8E, 0x4B, 0xA8),
    RGBColor(0xA8, 0x7A, 0x0A),
    RGBColor(0xB2, 0x3A, 0x6B),
];

/// Where a label stands relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    /// To the right of the point.
    Start,
    /// Centered on the point.
    Middle,
    /// To the left of the point.
    End,
}

/// A picture under construction.
pub(super) struct Canvas {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) pieces: Vec<Piece>,
}

/// A part of a picture, in drawing units.
pub(super) enum Piece {
    Area {
        points: Vec<(i32, i32)>,
        style: ShapeStyle,
    },
    Path {
        points: Vec<(i32, i32)>,
        style: ShapeStyle,
    },
    Rectangle {
        corners: [(i32, i32); 2],
        style: ShapeStyle,
    },
    Circle {
        center: (i32, i32),
        radius: u32,
        style: ShapeStyle,
    },
    Label {
        text: String,
        at: (i32, i32),
        ink: Ink,
        size: f64,
        anchor: Anchor,
    },
}

fn unit(value: f64) -> i32 {
    (value * SCALE).round().clamp(-1e6, 1e6) as i32
}

fn style(ink: Ink, width: f64, filled: bool) -> ShapeStyle {
    let stroke_width = (width * SCALE).round().max(1.0) as u32;
    ShapeStyle {
        color: ink.to_rgba(),
        filled,
        stroke_width,
    }
}

/// Samples that lie further apart on a line of their own are drawn one by one, in logical pixels.
const SPARSE: f64 = 16.0;

impl Canvas {
    /// An empty picture of the given logical size.
    pub fn new(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            pieces: Vec::new(),
        }
    }

    /// A polyline; points must be finite.
    pub fn path(&mut self, points: &[(f64, f64)], ink: Ink, width: f64) {
        let mut units: Vec<_> = points.iter().map(|&(x, y)| (unit(x), unit(y))).collect();
        units.dedup();
        if units.len() > 1 {
            self.pieces.push(Piece::Path {
                points: units,
                style: style(ink, width, false),
            });
        } else if let Some(&center) = units.first() {
            let radius = (width * SCALE * 0.7).round() as u32;
            self.pieces.push(Piece::Circle {
                center,
                radius,
                style: style(ink, 1.0, true),
            });
        }
    }

    /// Whether so many samples over a width are drawn one by one.
    pub fn are_sparse(&self, samples: usize, over: f64) -> bool {
        samples as f64 <= over / SPARSE
    }

    /// A polyline through samples over a width; few of them are dots, with a faint line that leads from one to the next: nothing is
    /// known between them.
    pub fn samples(&mut self, points: &[(f64, f64)], over: f64, ink: Ink, width: f64) {
        if !self.are_sparse(points.len(), over) {
            return self.path(points, ink, width);
        }
        self.path(points, FAINT, 1.0);
        for point in points {
            self.disc(*point, 1.6 * width, ink);
        }
    }

    /// A dashed straight line.
    pub fn dashes(&mut self, from: (f64, f64), to: (f64, f64), ink: Ink, width: f64) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = libm::hypot(dx, dy);
        let count = (length / 8.0).ceil().max(1.0);
        for dash in 0..count as usize {
            let begin = dash as f64 / count;
            let end = begin + 0.5 / count;
            let at = |s: f64| (from.0 + s * dx, from.1 + s * dy);
            self.path(&[at(begin), at(end)], ink, width);
        }
    }

    /// A filled polygon.
    pub fn area(&mut self, points: &[(f64, f64)], ink: Ink) {
        let points = points.iter().map(|&(x, y)| (unit(x), unit(y))).collect();
        self.pieces.push(Piece::Area {
            points,
            style: style(ink, 1.0, true),
        });
    }

    /// A filled rectangle.
    pub fn cell(&mut self, from: (f64, f64), to: (f64, f64), ink: Ink) {
        let corners = [(unit(from.0), unit(from.1)), (unit(to.0), unit(to.1))];
        self.pieces.push(Piece::Rectangle {
            corners,
            style: style(ink, 1.0, true),
        });
    }

    /// A disc.
    pub fn disc(&mut self, center: (f64, f64), radius: f64, ink: Ink) {
        self.pieces.push(Piece::Circle {
            center: (unit(center.0), unit(center.1)),
            radius: (radius * SCALE).round() as u32,
            style: style(ink, 1.0, true),
        });
    }

    /// A circle.
    pub fn ring(&mut self, center: (f64, f64), radius: f64, ink: Ink, width: f64) {
        self.disc(center, radius, PAPER);
        self.pieces.push(Piece::Circle {
            center: (unit(center.0), unit(center.1)),
            radius: (radius * SCALE).round() as u32,
            style: style(ink, width, false),
        });
    }

    /// A line of text, centered vertically on the point.
    pub fn label(&mut self, text: &str, at: (f64, f64), anchor: Anchor) {
        self.label_in(text, at, anchor, TEXT, LETTERS);
    }

    /// A line of text that is moved along where it would leave the picture.
    pub fn label_within(&mut self, text: &str, (x, y): (f64, f64), anchor: Anchor) {
        let width = WIDER * width_of(text, LETTERS);
        let before = match anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => width / 2.0,
            Anchor::End => width,
        };
        let x = x.min(self.width - (width - before)).max(before);
        self.label(text, (x, y), anchor);
    }

    /// A line of text of a given colour and size.
    pub fn label_in(&mut self, text: &str, at: (f64, f64), anchor: Anchor, ink: Ink, size: f64) {
        if text.is_empty() {
            return;
        }
        let at = (unit(at.0), unit(at.1));
        self.pieces.push(Piece::Label {
            text: text.to_owned(),
            at,
            ink,
            size,
            anchor,
        });
    }

    /// The picture as a file of its own, in logical pixels; the scale stays in the view box.
    pub fn finish_alone(self, description: &str) -> Result<String, ReportError> {
        let (width, height) = (self.width, self.height);
        let scaled = format!("width=\"{}\" height=\"{}\"", unit(width), unit(height));
        let size = format!("width=\"{width}\" height=\"{height}\"");
        Ok(self.finish(description)?.replacen(&scaled, &size, 1))
    }

    /// The picture as an `<svg>` element that is never shown larger than it was drawn, in the middle of its card.
    pub fn finish_in_own_size(self, description: &str) -> Result<String, ReportError> {
        let own = format!("<svg style=\"--own: {:.0}px\" ", self.width.ceil());
        Ok(self.finish(description)?.replacen("<svg ", &own, 1))
    }

    /// The picture as an `<svg>` element with a description for readers who cannot see it.
    pub fn finish(self, description: &str) -> Result<String, ReportError> {
        let mut svg = String::new();
        let size = (
            unit(self.width).unsigned_abs(),
            unit(self.height).unsigned_abs(),
        );
        let failed = |message: String| ReportError::Drawing {
            figure: description.to_owned(),
            message,
        };
        let mut backend = SVGBackend::with_string(&mut svg, size);
        for piece in &self.pieces {
            draw(&mut backend, piece).map_err(failed)?;
        }
        backend
            .present()
            .map_err(|error| failed(error.to_string()))?;
        drop(backend);
        let label = escaped(description);
        Ok(svg.replacen(
            "<svg ",
            &format!("<svg role=\"img\" aria-label=\"{label}\" "),
            1,
        ))
    }
}

fn draw(backend: &mut SVGBackend<'_>, piece: &Piece) -> Result<(), String> {
    let drawn = match piece {
        Piece::Area { points, style } => backend.fill_polygon(points.iter().copied(), style),
        Piece::Path { points, style } => backend.draw_path(points.iter().copied(), style),
        Piece::Rectangle {
            corners: [from, to],
            style,
        } => backend.draw_rect(*from, *to, style, true),
        Piece::Circle {
            center,
            radius,
            style,
        } => backend.draw_circle(*center, *radius, style, style.filled),
        Piece::Label {
            text,
            at,
            ink,
            size,
            anchor,
        } => {
            let horizontal = match anchor {
                Anchor::Start => HPos::Left,
                Anchor::Middle => HPos::Center,
                Anchor::End => HPos::Right,
            };
            let font = ("sans-serif", size * SCALE * FONT_FACTOR).into_font();
            let style = TextStyle::from(font)
                .color(ink)
                .pos(Pos::new(horizontal, VPos::Center));
            backend.draw_text(text, &style, *at)
        }
    };
    drawn.map_err(|error| error.to_string())
}
