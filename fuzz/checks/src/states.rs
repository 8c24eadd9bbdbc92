//! Files of initial states, arbitrary and mutated: members with these states, or an error with a place.

use std::fs;

use leafwise::core::Registry;
use leafwise::run::ensemble::compose_ensemble;
use leafwise::scene::SceneDocument;

use crate::Reached;
use crate::source::Source;

const SCENE: &str = "[system]\nvariables = [\"x\", \"y\"]\nbracket = { \"x,y\" = \"1\" }\n\
    hamiltonian = \"x^2/2 + y^2/2\"\n[method]\nstepper = \"rk4\"\ntime-step = 0.1\n[run]\ninitial = [1, 2]\n\
    steps = 1\n[ensemble]\ninitial = { file = \"states\" }\n";

/// Longer tables only take longer.
const LONGEST: usize = 4096;

/// One file.
///
/// # Errors
/// Members that are not those of the file, or a refusal without a message, with the file.
pub fn check(bytes: &[u8]) -> Result<Reached, String> {
    let mut source = Source::new(bytes);
    let (content, rows) = match source.below(4) {
        0 => (source.rest().to_vec(), None),
        1 => table(&mut source),
        _ => {
            let (mut content, rows) = table(&mut source);
            for _ in 0..1 + source.below(3) {
                crate::resumed::mutate(&mut source, &mut content);
            }
            let is_same = table(&mut Source::new(bytes.get(1..).unwrap_or_default())).0 == content;
            (content, rows.filter(|_| is_same))
        }
    };
    let content = &content[..content.len().min(LONGEST)];
    read(content, rows.as_deref())
        .map_err(|what| format!("{what}\n{}", String::from_utf8_lossy(content)))
}

/// A table as CSV with or without headings, or as JSON; and its numbers.
fn table(source: &mut Source<'_>) -> (Vec<u8>, Option<Vec<f64>>) {
    let count = 1 + source.below(5);
    let rows: Vec<[f64; 2]> = (0..count)
        .map(|_| [source.decimal(-9.0, 9.0), source.decimal(-9.0, 9.0)])
        .collect();
    let mark = source.pick(&[",", ";", "\t", " "]);
    let mut text = String::new();
    match source.below(3) {
        0 => text = format!("{rows:?}"),
        headings => {
            if headings == 1 {
                text = format!("x{mark}y\n");
            }
            for [x, y] in &rows {
                text.push_str(&format!("{x:?}{mark}{y:?}\n"));
            }
        }
    }
    (text.into_bytes(), Some(rows.concat()))
}

fn read(content: &[u8], rows: Option<&[f64]>) -> Result<Reached, String> {
    let io = |error: std::io::Error| error.to_string();
    let folder = tempfile::tempdir().map_err(io)?;
    fs::write(folder.path().join("states"), content).map_err(io)?;
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("scene.toml", SCENE, &registry)
        .map_err(|errors| errors.to_string())?;
    match (compose_ensemble(&document, &registry, folder.path()), rows) {
        (Ok(ensemble), Some(rows)) => {
            let members = ensemble.population.members() as usize;
            match members * 2 == rows.len() {
                true => Ok(Reached::Comparison),
                false => Err(format!("{members} members of {} numbers", rows.len())),
            }
        }
        (Err(refusal), Some(_)) => Err(format!("a table is refused: {refusal}")),
        (Ok(_), None) => Ok(Reached::Comparison),
        (Err(refusal), None) if refusal.message.is_empty() => Err("no message".to_owned()),
        (Err(_), None) => Ok(Reached::Comparison),
    }
}
