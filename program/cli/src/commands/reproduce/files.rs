//! Figures as files: a picture and its numbers for each panel, a page, an object.

use std::fmt::Write as _;
use std::path::Path;

use leafwise::report::{Panel, Stroke};
use leafwise::reproduce::{Reproduced, reproduction_page};

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
            put(&format!("{name}.csv"), &numbers(panel))?;
        }
    }
    put(PAGE, &reproduction_page(figures, command)?)?;
    put(OBJECT, &format!("{:#}\n", json::object(figures, seconds)))
}

/// A panel's points, one a line.
fn numbers(panel: &Panel) -> String {
    let mut text = format!(
        "series,{},{}\n",
        quoted(&panel.x.title),
        quoted(&panel.y.title)
    );
    for series in panel.series.iter().filter(|s| s.stroke != Stroke::Guide) {
        let name = quoted(&series.name);
        for (x, y) in &series.points {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{name},{x:?},{y:?}");
        }
    }
    text
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}
