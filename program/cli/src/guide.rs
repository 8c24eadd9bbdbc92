//! The pages of the guide inside the program: by name, and by what they explain.

use leafwise::scene::SceneDiagnostic;

macro_rules! pages {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../../docs/guide/", $name, ".md")))),*]
    };
}

/// Names and texts of the pages, in the order of the guide's contents.
pub const PAGES: [(&str, &str); 39] = pages![
    "start",
    "from-scipy",
    "from-julia",
    "from-rebound",
    "from-boris",
    "from-rust",
    "from-c",
    "define-a-system",
    "textbook",
    "formulas",
    "products",
    "tensors-by-forms",
    "lattices",
    "tables",
    "equilibria",
    "find",
    "time",
    "forces",
    "contact",
    "noise",
    "choose",
    "choose-a-method",
    "other-tools",
    "read-the-report",
    "events",
    "ensembles",
    "sweeps",
    "clusters",
    "shadow",
    "indicators",
    "orbits",
    "gradients",
    "learn",
    "tabulate",
    "own-parts",
    "fmi",
    "theory",
    "commands",
    "keys",
];

/// The title of a page: its first heading.
pub fn title(text: &str) -> &str {
    let mut lines = text.lines();
    lines
        .find_map(|line| line.strip_prefix("# "))
        .unwrap_or_default()
}

/// Parts of the guide that explain a word.
pub struct Explained {
    /// The page's name.
    pub page: &'static str,
    /// Text of the part, as Markdown.
    pub text: String,
}

/// Parts of all pages with a name, rows of tables before sections.
pub fn named(name: &str) -> impl Iterator<Item = Explained> {
    let (rows, sections): (Vec<_>, Vec<_>) = PAGES
        .into_iter()
        .flat_map(|(page, _)| part(page, name))
        .partition(|part| !part.text.starts_with('#'));
    rows.into_iter().chain(sections)
}

/// Parts of a page with a name, in any letters and without accents: rows of tables that begin with it, and sections whose
/// headings have it.
pub fn part(page: &str, name: &str) -> Vec<Explained> {
    let name = folded(name);
    let Some((page, text)) = PAGES.into_iter().find(|(known, _)| *known == page) else {
        return Vec::new();
    };
    let row = Some(rows(text, &name)).filter(|found| !found.is_empty());
    let has_name = |section: &&str| {
        let heading = folded(section.lines().next().unwrap_or_default());
        heading.starts_with('#') && has_words(&heading, &name)
    };
    let sections = sections(text).into_iter().filter(has_name).map(readable);
    let texts = row.into_iter().chain(sections);
    texts.map(|text| Explained { page, text }).collect()
}

/// Whether a heading has words one after the other, the last in the singular or the plural.
fn has_words(heading: &str, words: &str) -> bool {
    let spaced = |text: &str| {
        let letters = text.chars();
        let plain = |letter: char| {
            if letter.is_alphanumeric() {
                letter
            } else {
                ' '
            }
        };
        let text: String = letters.map(plain).collect();
        format!(
            " {} ",
            text.split_whitespace().collect::<Vec<_>>().join(" ")
        )
    };
    let (heading, words) = (spaced(heading), spaced(words));
    heading.contains(&words) || heading.contains(&format!("{}s ", words.trim_end()))
}

/// A word in small letters without the accents of Latin ones.
pub(crate) fn folded(word: &str) -> String {
    let letters = word.chars().flat_map(char::to_lowercase);
    let plain = |letter| match letter {
        'à' | 'á' | 'â' | 'ä' | 'å' => 'a',
        'ç' => 'c',
        'è' | 'é' | 'ê' | 'ë' => 'e',
        'ì' | 'í' | 'î' | 'ï' => 'i',
        'ñ' => 'n',
        'ò' | 'ó' | 'ô' | 'ö' | 'ø' => 'o',
        'ù' | 'ú' | 'û' | 'ü' => 'u',
        other => other,
    };
    letters.map(plain).collect()
}

/// Rows of tables whose first cell has the word between accents, each with the table's heading as `heading: cell`.
fn rows(text: &str, word: &str) -> String {
    let (mut found, mut heads) = (Vec::new(), Vec::new());
    let mut before = "";
    for line in text.lines() {
        if line.starts_with("|---") || line.starts_with("| ---") {
            heads = cells(before);
        }
        let row = cells(line);
        let is_meant = row.first().is_some_and(|first| {
            let names = first.split('`').skip(1).step_by(2);
            names.map(folded).any(|name| name == word)
        });
        if is_meant {
            let rest = row.iter().zip(&heads).filter(|(cell, _)| !cell.is_empty());
            let lines = rest.map(|(cell, head)| match head.is_empty() {
                true => plain(cell),
                false => format!("{}: {}", plain(head), plain(cell)),
            });
            found.push(lines.collect::<Vec<_>>().join("\n"));
        }
        before = line;
    }
    found.join("\n\n")
}

/// The cells of a table's row; none where the line is no row.
fn cells(line: &str) -> Vec<String> {
    let Some(inside) = line
        .strip_prefix('|')
        .and_then(|line| line.trim_end().strip_suffix('|'))
    else {
        return Vec::new();
    };
    let inside = inside.replace("\\|", "\u{0}");
    let cells = inside.split('|');
    cells
        .map(|cell| cell.trim().replace('\u{0}', "|"))
        .collect()
}

/// The parts of a page from one heading to the next.
fn sections(text: &str) -> Vec<&str> {
    let (mut starts, mut at, mut is_code) = (vec![0], 0, false);
    for line in text.split_inclusive('\n') {
        is_code ^= line.trim_start().starts_with("```");
        if !is_code && line.starts_with('#') && at > 0 {
            starts.push(at);
        }
        at += line.len();
    }
    starts.push(text.len());
    starts
        .windows(2)
        .map(|ends| &text[ends[0]..ends[1]])
        .collect()
}

/// A part of a page without pictures and the addresses of links.
pub(crate) fn readable(text: &str) -> String {
    let mut is_code = false;
    let lines = text.lines().filter(|line| !line.starts_with("<img"));
    let lines = lines.map(|line| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        if is_code || is_fence {
            line.to_owned()
        } else {
            plain(line)
        }
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A line without the addresses of its links.
fn plain(line: &str) -> String {
    let (mut made, mut rest) = (String::new(), line);
    while let Some(middle) = rest.find("](") {
        let (head, tail) = rest.split_at(middle);
        let Some(end) = tail.find(')') else { break };
        let Some(open) = opening(head) else { break };
        made.push_str(&head[..open]);
        made.push_str(&head[open + 1..]);
        rest = &tail[end + 1..];
    }
    (made + rest)
        .replace("\\[", "[")
        .replace("\\]", "]")
        .replace("\\_", "_")
        .replace("\\*", "*")
}

/// The place of the bracket that a link's text begins with; the text may have brackets in pairs.
fn opening(head: &str) -> Option<usize> {
    let mut depth = 0;
    head.rmatch_indices(['[', ']']).find_map(|(at, bracket)| {
        match bracket {
            "]" => depth += 1,
            _ if depth == 0 => return Some(at),
            _ => depth -= 1,
        }
        None
    })
}

/// The page about the key of a scene where a problem stands.
pub fn page_of(problem: &SceneDiagnostic) -> &'static str {
    let start = problem.span.start.min(problem.source_text.len());
    let before = problem.source_text.get(..start).unwrap_or_default();
    let line = before.rfind('\n').map_or(0, |end| end + 1);
    let is_of_header = problem.source_text.get(line..).is_some_and(|text| {
        let line = text.lines().next().unwrap_or_default().trim();
        line.starts_with('[') && line.ends_with(']') && !line.contains([',', '='])
    });
    // The name of a table itself.
    if is_of_header {
        return "keys";
    }
    // Rows of a list begin with a bracket too.
    let is_header = |line: &&str| {
        let line = line.trim();
        line.starts_with('[') && line.ends_with(']') && !line.contains(',')
    };
    let header = before.lines().rfind(is_header);
    let table = header.unwrap_or_default().trim().trim_matches(['[', ']']);
    let key = keys_before(&problem.source_text, start).unwrap_or_default();
    let path = match problem.source_name.as_str() {
        "--set" => problem
            .source_text
            .split('=')
            .next()
            .unwrap_or_default()
            .to_owned(),
        _ if table.is_empty() => key,
        _ => format!("{table}.{key}"),
    };
    let mut words = path.split('.').map(str::trim);
    match (
        words.next().unwrap_or_default(),
        words.next().unwrap_or_default(),
    ) {
        ("system", "hamiltonian" | "define" | "casimirs") => "formulas",
        ("system", "families" | "boundary") => "lattices",
        ("system", "tables") => "tables",
        ("system", "equations") => "find",
        ("system", "forces" | "damping" | "torque" | "friction") => "forces",
        ("system", "noise") => "noise",
        ("system", _) => "define-a-system",
        ("method", "pace") => "time",
        ("method", _) => "choose",
        ("run", "stop" | "section") => "events",
        ("ensemble", _) => "ensembles",
        ("sweep", _) => "sweeps",
        ("plugins", _) => "own-parts",
        _ => "keys",
    }
}

/// The key whose value holds a place: of the last line before it that begins one.
fn keys_before(text: &str, start: usize) -> Option<String> {
    let end = text
        .get(start..)?
        .find('\n')
        .map_or(text.len(), |at| start + at);
    let line = text.get(..end)?.lines().rfind(|line| {
        let first = line.chars().next();
        first.is_some_and(|c| c.is_alphabetic() || c == '"') && line.contains('=')
    })?;
    Some(line.split('=').next()?.trim().trim_matches('"').to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pages of the folder that are none of the program's: contents, pictures of scenes, further theory.
    const OTHERS: [&str; 3] = ["README", "gallery", "more-theory"];

    #[test]
    fn every_page_of_the_guide_is_there() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/guide");
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .expect("the guide")
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter_map(|name| name.strip_suffix(".md").map(str::to_owned))
            .filter(|name| !OTHERS.contains(&name.as_str()))
            .collect();
        let mut known = PAGES.map(|(name, _)| name.to_owned()).to_vec();
        names.sort();
        known.sort();
        assert_eq!(names, known);
    }

    #[test]
    fn links_and_cells_are_read_as_text() {
        assert_eq!(
            plain("see [the guide](a/b.md#c) and [x]"),
            "see the guide and [x]"
        );
        assert_eq!(
            plain("[`torque = [\"0\", \"0\"]`](forces.md) and [`[ensemble]`](e.md), [x]"),
            "`torque = [\"0\", \"0\"]` and `[ensemble]`, [x]"
        );
        assert_eq!(cells("| a | `b \\| c` |"), ["a", "`b | c`"]);
    }
}
