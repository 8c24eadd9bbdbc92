//! `leafwise explain`: what the guide says of a word.

use leafwise::scene::document::nearest;

use super::describe::system_text;
use crate::arguments::ExplainArguments;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::guide::{PAGES, title};
use crate::synonyms::explained;
use crate::table::words;

/// Prints the parts of the guide that explain a word, or the names of its pages; returns the exit code.
///
/// # Errors
/// [`Failure::Usage`] where the guide has no such word.
pub fn execute(arguments: &ExplainArguments, console: &mut Console<'_>) -> Result<u8, Failure> {
    if arguments.words.is_empty() {
        let pages = PAGES.iter();
        let rows: Vec<Vec<String>> = pages
            .map(|(name, text)| vec![format!("  {name}"), title(text).to_owned()])
            .collect();
        console.result("Pages of the guide, for `leafwise explain PAGE`; warnings, keys and headings have words of their own:");
        for line in words(&rows) {
            console.result(&line);
        }
        return Ok(exit::DONE);
    }
    let word = arguments.words.join(" ");
    let found = explained(&word);
    let id = word.to_lowercase().replace([' ', '_'], "-");
    let system = leafwise::systems::find(&id);
    if found.is_empty() && system.is_none() {
        let names = PAGES.map(|(name, _)| name);
        let help = match nearest(&word, names) {
            Some(name) => format!("did you mean `{name}`?"),
            None => "`leafwise explain` lists the pages; a warning's word and a key of a scene are explained too".to_owned(),
        };
        return Err(Failure::usage(format!("the guide has no `{word}`"), help));
    }
    for (at, part) in found.iter().enumerate() {
        if at > 0 {
            console.result("");
        }
        if found.len() > 1 || !part.text.starts_with("# ") {
            console.result(&format!(
                "({} · leafwise explain {})",
                title_of(part.page),
                part.page
            ));
        }
        console.result(part.text.trim_end());
    }
    if let Some(system) = system {
        if !found.is_empty() {
            console.result("");
        }
        console.result(&format!("(leafwise describe {id})"));
        let text = system_text(system);
        let (lines, _) = text.map_err(|error| Failure::usage(error.to_string(), "report this"))?;
        lines.iter().for_each(|line| console.result(line));
    }
    Ok(exit::DONE)
}

fn title_of(page: &str) -> &'static str {
    let page = PAGES.iter().find(|(name, _)| *name == page);
    page.map_or("", |(_, text)| title(text))
}
