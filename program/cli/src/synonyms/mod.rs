//! Everyday words, and where the guide explains what is meant.

mod words;

use crate::guide::{Explained, PAGES, folded, named, part, readable};
use words::{SMALL, SYNONYMS};

/// The parts of the guide that explain what an everyday word stands for.
fn synonyms(word: &str) -> Vec<Explained> {
    let meant = SYNONYMS.iter().filter(|own| own.words.contains(&word));
    meant.flat_map(|own| part(own.page, own.at)).collect()
}

/// Parts of the pages that explain a word.
///
/// 1. The page of that name, alone.
/// 2. Parts of which it is an everyday word.
/// 3. Rows of tables that begin with the word, and sections whose headings have it.
/// 4. For a question of several words without these, the same of its longest parts that are known.
pub fn explained(word: &str) -> Vec<Explained> {
    let word = folded(word.trim());
    let whole = of_word(&word);
    let parts: Vec<&str> = word
        .split(|c: char| !(c.is_alphanumeric() || "-_.".contains(c)))
        .collect();
    let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    if !whole.is_empty() || parts.len() < 2 {
        return whole;
    }
    (1..parts.len())
        .rev()
        .map(|length| {
            let mut found = Vec::new();
            for words in parts.windows(length) {
                if words.iter().any(|word| !SMALL.contains(word)) {
                    add(&mut found, of_word(&words.join(" ")));
                }
            }
            found
        })
        .find(|found| !found.is_empty())
        .unwrap_or_default()
}

/// Adds parts that are not there yet.
fn add(found: &mut Vec<Explained>, parts: impl IntoIterator<Item = Explained>) {
    for part in parts {
        if found.iter().all(|known| known.text != part.text) {
            found.push(part);
        }
    }
}

/// Parts that explain a word or a phrase as it stands, in the singular or the plural, with or without hyphens.
fn of_word(word: &str) -> Vec<Explained> {
    let word = word.to_owned();
    if let Some((page, text)) = PAGES.into_iter().find(|(name, _)| *name == word) {
        return vec![Explained {
            page,
            text: readable(text),
        }];
    }
    let mut found: Vec<Explained> = Vec::new();
    for form in forms(&word) {
        add(&mut found, synonyms(&form));
    }
    add(&mut found, named(&word));
    for form in forms(&word) {
        if found.is_empty() {
            add(&mut found, named(&form));
        }
    }
    found
}

/// A word, with spaces and with hyphens, and each in the singular; `time step` and `time-step` of `timestep`.
fn forms(word: &str) -> Vec<String> {
    let mut forms = vec![word.to_owned(), word.replace(['-', '_'], " ")];
    forms.push(forms[1].replace(' ', "-"));
    if let Some(rest) = word.strip_prefix("time")
        && rest.starts_with("step")
    {
        forms.push(format!("time-{rest}"));
    }
    for at in 0..forms.len() {
        forms.extend(forms[at].strip_suffix('s').map(str::to_owned));
    }
    forms
}

#[cfg(test)]
mod tests {
    use super::{SYNONYMS, explained};
    use crate::guide::{PAGES, part};

    /// Each leads to a part that contains the answer, and is found by each of its words.
    #[test]
    fn everyday_words_lead_to_their_answers() {
        for own in &SYNONYMS {
            let parts = part(own.page, own.at);
            let text: String = parts.iter().map(|part| part.text.as_str()).collect();
            assert!(text.contains(own.says), "{}: {}: {text}", own.page, own.at);
            for word in own.words {
                let found = explained(word);
                let is_led = found
                    .iter()
                    .any(|found| parts.iter().any(|part| part.text == found.text));
                assert!(is_led, "{word}");
            }
        }
    }

    #[test]
    fn the_words_of_newcomers_are_known() {
        for word in [
            "sign",
            "units",
            "friction",
            "drag",
            "fit",
            "restart",
            "checkpoint",
            "exit codes",
            "negative",
            "backward",
            "adaptive",
            "n-body",
            "gravity",
            "planets",
            "species",
            "poincare",
            "Poincaré",
            "POINCARE",
            "numpy",
            "field",
            "vary",
            "accuracy",
            "tolerance",
            "energy drift",
            "resume",
            "Exit Code",
            "step-size control",
            "dense output",
            "failed steps",
            "collision",
            "temperature",
            "threads",
            "time-dependent",
            "quaternion",
            "timestep",
            "time-steps",
            "seeds",
            "pendulum",
            "magnet",
            "degrees",
            "save",
            "memory",
            "speed",
            "cite",
            "initial values",
            "continue a run",
            "how do I add friction?",
            "exit code 6",
            "use from C",
            "sweep two parameters",
            "stop at an event",
            "units of time-step",
        ] {
            assert!(!explained(word).is_empty(), "{word}");
        }
    }

    #[test]
    fn every_kind_of_advice_is_explained() {
        let page = PAGES.iter().find(|(name, _)| *name == "read-the-report");
        let (_, text) = page.expect("a page");
        let kinds = text.lines().filter_map(|line| {
            let kind = line.strip_prefix("| `")?.split('`').next()?;
            line.matches('|').nth(3).map(|_| kind)
        });
        let mut count = 0;
        for kind in kinds {
            let found = explained(kind);
            assert!(found.iter().any(|part| part.text.contains(kind)), "{kind}");
            count += 1;
        }
        assert!(count > 20, "{count} rows");
    }

    #[test]
    fn words_lead_to_pages_rows_and_sections() {
        assert_eq!(explained("formulas").len(), 1);
        let row = explained("backward-time");
        assert!(
            row[0].text.contains("the other `convention`"),
            "{}",
            row[0].text
        );
        let sections = explained("torque");
        for page in ["forces", "keys"] {
            assert!(sections.iter().any(|part| part.page == page), "{page}");
        }
        for unknown in ["xyzzy", "xyzzy plugh", "how is the xyzzy"] {
            assert!(explained(unknown).is_empty(), "{unknown}");
        }
    }
}
