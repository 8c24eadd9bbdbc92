//! Pictures as PDF, with text in fonts that every reader has.

use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str};
use plotters::style::{RGBAColor, ShapeStyle};

use super::canvas::{Anchor, Canvas, Piece, SCALE};
use super::error::ReportError;
use super::letters::{LATIN, SMALL, SYMBOL, glyph};

/// Points of PDF, 1/72 inch, in a drawing unit: a logical pixel is 1/96 inch.
const POINT: f32 = 0.75 / SCALE as f32;

/// The part of the circle's radius at which its four cubic pieces have their handles.
const HANDLE: f32 = 0.552_284_8;

impl Canvas {
    /// The picture as a PDF file of one page.
    ///
    /// # Errors
    /// [`ReportError::Letter`] for text with a letter that the fonts do not have.
    pub fn finish_pdf(self, description: &str) -> Result<Vec<u8>, ReportError> {
        let [catalog, tree, page, content, latin, symbol, about] =
            [1, 2, 3, 4, 5, 6, 7].map(Ref::new);
        let size = [self.width, self.height].map(|length| length as f32 * 0.75);
        let mut drawn = Content::new();
        drawn.set_line_cap(LineCapStyle::RoundCap);
        drawn.set_line_join(LineJoinStyle::RoundJoin);
        let place = |(x, y): (i32, i32)| (x as f32 * POINT, size[1] - y as f32 * POINT);
        for piece in &self.pieces {
            draw(&mut drawn, piece, &place)?;
        }
        let mut pdf = Pdf::new();
        pdf.catalog(catalog).pages(tree);
        pdf.pages(tree).kids([page]).count(1);
        let mut sheet = pdf.page(page);
        sheet.media_box(Rect::new(0.0, 0.0, size[0], size[1]));
        sheet.parent(tree).contents(content);
        sheet
            .resources()
            .fonts()
            .pair(LATIN, latin)
            .pair(SYMBOL, symbol);
        sheet.finish();
        let mut font = pdf.type1_font(latin);
        font.base_font(Name(b"Helvetica"));
        font.encoding_predefined(Name(b"WinAnsiEncoding"));
        font.finish();
        pdf.type1_font(symbol).base_font(Name(b"Symbol"));
        pdf.stream(content, &drawn.finish());
        pdf.document_info(about)
            .title(pdf_writer::TextStr(description));
        Ok(pdf.finish())
    }
}

fn draw(
    drawn: &mut Content,
    piece: &Piece,
    place: &impl Fn((i32, i32)) -> (f32, f32),
) -> Result<(), ReportError> {
    match piece {
        Piece::Area { points, style } => {
            fill(drawn, style.color);
            line(drawn, points, place);
            drawn.close_path().fill_nonzero();
        }
        Piece::Path { points, style } => {
            stroke(drawn, style);
            line(drawn, points, place);
            drawn.stroke();
        }
        Piece::Rectangle {
            corners: [from, to],
            style,
        } => {
            fill(drawn, style.color);
            let ((left, top), (right, bottom)) = (place(*from), place(*to));
            drawn
                .rect(left, bottom, right - left, top - bottom)
                .fill_nonzero();
        }
        Piece::Circle {
            center,
            radius,
            style,
        } => {
            if style.filled {
                fill(drawn, style.color);
                circle(drawn, place(*center), *radius as f32 * POINT);
                drawn.fill_nonzero();
            } else {
                stroke(drawn, style);
                circle(drawn, place(*center), *radius as f32 * POINT);
                drawn.stroke();
            }
        }
        Piece::Label {
            text,
            at,
            ink,
            size,
            anchor,
        } => {
            let glyphs = text.chars().map(|letter| {
                glyph(letter).ok_or_else(|| ReportError::Letter {
                    text: text.clone(),
                    letter,
                })
            });
            let glyphs = glyphs.collect::<Result<Vec<_>, _>>()?;
            let size = *size as f32 * 0.75;
            let width: f32 = glyphs.iter().map(|glyph| glyph.width * size).sum();
            let before = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5,
                Anchor::End => 1.0,
            };
            let (x, y) = place(*at);
            let [r, g, b] = [ink.0, ink.1, ink.2].map(|part| f32::from(part) / 255.0);
            drawn.set_fill_rgb(r, g, b);
            drawn.begin_text();
            // The middle of its capitals stands at the point.
            drawn.next_line(x - before * width, y - 0.35 * size);
            for glyph in glyphs {
                let own = if glyph.shift.is_some() {
                    SMALL * size
                } else {
                    size
                };
                drawn.set_font(glyph.font, own);
                drawn.set_rise(glyph.shift.unwrap_or(0.0) * size);
                drawn.show(Str(&[glyph.code]));
            }
            drawn.end_text();
        }
    }
    Ok(())
}

fn fill(drawn: &mut Content, color: RGBAColor) {
    let [r, g, b] = [color.0, color.1, color.2].map(|part| f32::from(part) / 255.0);
    drawn.set_fill_rgb(r, g, b);
}

fn stroke(drawn: &mut Content, style: &ShapeStyle) {
    let color = style.color;
    let [r, g, b] = [color.0, color.1, color.2].map(|part| f32::from(part) / 255.0);
    drawn.set_stroke_rgb(r, g, b);
    drawn.set_line_width(style.stroke_width as f32 * POINT);
}

fn line(drawn: &mut Content, points: &[(i32, i32)], place: &impl Fn((i32, i32)) -> (f32, f32)) {
    for (at, point) in points.iter().enumerate() {
        let (x, y) = place(*point);
        match at {
            0 => drawn.move_to(x, y),
            _ => drawn.line_to(x, y),
        };
    }
}

fn circle(drawn: &mut Content, (x, y): (f32, f32), radius: f32) {
    let handle = HANDLE * radius;
    drawn.move_to(x + radius, y);
    for (from, to) in [
        ((1.0, 0.0), (0.0, 1.0)),
        ((0.0, 1.0), (-1.0, 0.0)),
        ((-1.0, 0.0), (0.0, -1.0)),
        ((0.0, -1.0), (1.0, 0.0)),
    ] {
        let ((a, b), (c, d)): ((f32, f32), (f32, f32)) = (from, to);
        drawn.cubic_to(
            x + radius * a + handle * c,
            y + radius * b + handle * d,
            x + radius * c + handle * a,
            y + radius * d + handle * b,
            x + radius * c,
            y + radius * d,
        );
    }
    drawn.close_path();
}
