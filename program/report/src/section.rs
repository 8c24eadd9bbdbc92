//! A section: a dot for each crossing.

use super::axis::{Axis, Frame};
use super::canvas::{Canvas, Ink, SERIES};
use super::data::SectionPoints;
use super::error::ReportError;
use super::figure::Figure;
use super::stroke::draw_dots;

/// How many colours there are for members.
const COLOURS: u64 = SERIES.len() as u64;

/// The states on a section in the plane of two columns.
pub(super) fn section_figure(section: &SectionPoints) -> Result<Figure, ReportError> {
    let (width, height) = (480.0, 480.0);
    let is_finite = |(point, _): &(&[f64; 2], Ink)| point.iter().all(|value| value.is_finite());
    let inks = section
        .members
        .iter()
        .map(|member| SERIES[(member % COLOURS) as usize]);
    let inks = inks.chain(std::iter::repeat(SERIES[0]));
    let points: Vec<_> = section.points.iter().zip(inks).filter(is_finite).collect();
    let x = Axis::linear(points.iter().map(|(point, _)| point[0]), 0.06);
    let y = Axis::linear(points.iter().map(|(point, _)| point[1]), 0.06);
    let frame = Frame::new(width, height, x, y);
    let mut canvas = Canvas::new(width, height);
    let [across, up] = &section.names;
    frame.draw(&mut canvas, across, up);
    let dots: Vec<_> = points
        .iter()
        .map(|(point, _)| frame.point(point[0], point[1]))
        .collect();
    let is_of_many = !section.members.is_empty();
    draw_dots(&mut canvas, &dots, |index| points[index].1, is_of_many);
    let mut notes = Vec::new();
    if points.len() < section.points.len() {
        notes.push(format!(
            "Not finite and not drawn: {} of {} crossings.",
            section.points.len() - points.len(),
            section.points.len()
        ));
    }
    Ok(Figure {
        title: format!("Section {} in ({across}, {up})", section.title),
        svg: canvas.finish("The states on the section")?,
        legend: Vec::new(),
        caption: format!(
            "A dot for each crossing, each located between two steps by the method itself.{}",
            match is_of_many {
                true => " Members have colours in turn.",
                false => "",
            }
        ),
        colors: Vec::new(),
        notes,
    })
}
