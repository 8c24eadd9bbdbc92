//! Scene texts, arbitrary and mutated: parsing and composing never panic, and every error has a place.

use leafwise::core::Registry;
use leafwise::scene::{SceneDiagnostic, SceneDocument, compose};

use crate::Reached;
use crate::scene::RandomScene;
use crate::source::Source;

/// Longer texts only take longer.
const LONGEST: usize = 4096;

/// Pieces of scenes, put in place of others.
const PIECES: [&str; 24] = [
    "\n[system]\n",
    "\n[method]\n",
    "\n[run]\n",
    "\n[ensemble]\n",
    "families = { x = 5 }\n",
    "\"x[i],x[i+1]\" = \"x[i]*x[i+1]\"",
    "boundary = \"periodic\"\n",
    "sum(i, ",
    "x[i]",
    "nan",
    "1e400",
    "-0",
    "''",
    "\"\"\"",
    "{",
    "]",
    "^(1/0)",
    "99999999999999999999",
    "\u{feff}",
    "π²",
    "\r\n",
    "library = \"rigid-body\"\n",
    "parameters = { a = 1 }\n",
    "plugins = []\n",
];

/// A text of any bytes, or a random scene with pieces cut, put in and moved.
///
/// # Errors
/// An error without a place, with the text.
pub fn check(bytes: &[u8]) -> Result<Reached, String> {
    let mut source = Source::new(bytes);
    let text = match source.chance(40) {
        true => String::from_utf8_lossy(source.rest()).into_owned(),
        false => mutated(&mut source),
    };
    let cut = text
        .char_indices()
        .map(|(at, _)| at)
        .find(|at| *at > LONGEST);
    let text = &text[..cut.unwrap_or(text.len())];
    read(text).map_err(|what| format!("{what}\n{text}"))
}

fn mutated(source: &mut Source<'_>) -> String {
    let mut text: Vec<char> = RandomScene::drawn(source).text.chars().collect();
    for _ in 0..source.below(6) {
        let at = source.below(text.len().max(1));
        let end = (at + source.below(12)).min(text.len());
        match source.below(4) {
            0 => drop(text.drain(at..end)),
            1 => {
                let piece = source.pick(&PIECES).chars();
                drop(text.splice(at..end, piece));
            }
            2 => {
                let copy: Vec<char> = text[at..end].to_vec();
                let to = source.below(text.len());
                drop(text.splice(to..to, copy));
            }
            _ => text.insert(at, char::from(source.byte())),
        }
    }
    text.into_iter().collect()
}

fn read(text: &str) -> Result<Reached, String> {
    let has_place = |diagnostic: &SceneDiagnostic| -> Result<(), String> {
        let (line, _) = diagnostic.line_column();
        let source = &diagnostic.source_text;
        let is_in_text = source.get(diagnostic.span.clone()).is_some();
        let said = !diagnostic.message.is_empty() && !diagnostic.render(false).is_empty();
        if is_in_text && said && line <= source.matches('\n').count() + 1 {
            return Ok(());
        }
        Err(format!("an error without a place: {diagnostic:?}"))
    };
    let registry = Registry::with_builtin();
    match SceneDocument::parse("scene.toml", text, &registry) {
        Err(errors) => errors.diagnostics().iter().try_for_each(has_place)?,
        Ok(document) => {
            if document.system.dimension() > crate::LARGEST {
                return Ok(Reached::Refusal);
            }
            if let Err(refusal) = compose(&document, &registry) {
                has_place(&refusal)?;
            }
        }
    }
    Ok(Reached::Comparison)
}
