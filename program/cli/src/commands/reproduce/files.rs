//! Figures as files: a picture and its numbers for each panel, a page, an object.

use std::path::Path;

use leafwise::report::{Panel, Stroke};
use leafwise::reproduce::{Reproduced, reproduction_page};
use leafwise::run::csv::Table;

use super::json;
use crate::failure::Failure;
use crate::files;

/// The page.
pub(super) const PAGE: &str = "reproduce.html";
const OBJECT: &str = "reproduce.json";

/// Writes everything into a directory, which is there.
pub(super) fn write(
    directory: &Path,
    figures: &[Reproduced],
    command: &str,
    seconds: f64,
) -> Result<(), Failure> {
    let put = |name: &str, text: &str| files::write(&directory.join(name), text);
    for figure in figures {
        for (at, panel) in figure.panels.iter().enumerate() {
            let name = format!("figure-{}-{}", figure.paper.number, at + 1);
            put(&format!("{name}.svg"), &panel.svg()?)?;
            put(&format!("{name}.csv"), numbers(panel).as_str())?;
        }
    }
    put(PAGE, &reproduction_page(figures, command)?)?;
    files::write_json(
        &directory.join(OBJECT),
        &json::FiguresJson::of(figures, seconds),
    )
}

/// A panel's points, one a line.
fn numbers(panel: &Panel) -> Table {
    let mut table = Table::new(["series", &panel.x.title, &panel.y.title]);
    for series in panel.series.iter().filter(|s| s.stroke != Stroke::Guide) {
        for (x, y) in &series.points {
            table.text(&series.name).number(*x).number(*y).end_row();
        }
    }
    table
}
