//! Slips of the pen in a scene's text, from which it is no TOML.

use std::ops::Range;

use toml::de::DeTable;

/// Help where a text is no TOML, by the line where it breaks; `None` where the line tells nothing.
pub(super) fn slip(text: &str, span: &Range<usize>) -> Option<String> {
    let at = span.start.min(text.len());
    let before = text.get(..at)?;
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    let line = text.get(start..)?.lines().next()?;
    let bare = outside_quotes(line);
    let (key, value) = match line.split_once('=') {
        Some((key, value)) => (key.trim(), value.trim()),
        None => ("", ""),
    };
    if bare.contains(CURLY) {
        let straight = line.replace(CURLY, "\"");
        return Some(format!("quotes are straight: {}", straight.trim()));
    }
    if bare.contains("//") {
        let (rest, comment) = line.rsplit_once("//")?;
        let (rest, comment) = (rest.trim(), comment.trim());
        return Some(format!("a comment begins with #: {rest} # {comment}"));
    }
    if bare.trim_end().ends_with(';') {
        let (rest, _) = line.rsplit_once(';')?;
        return Some(format!("a line ends without `;`: {}", rest.trim()));
    }
    if let Some((whole, part)) = value.split_once(',')
        && [whole, part].iter().all(|own| is_digits(own))
    {
        return Some(format!(
            "decimals stand behind a point: {key} = {whole}.{part}"
        ));
    }
    // A formula without quotes: the value begins with a letter, or goes on behind a number.
    let is_bare = !value.is_empty()
        && !value.contains(['"', '\'', '{', '[', '#', '='])
        && value.contains(|c: char| c.is_alphabetic() || "+-*/^(".contains(c))
        && DeTable::parse(&format!("value = {value}")).is_err();
    let told = || format!("words and formulas stand in quotes: {key} = \"{value}\"");
    (is_bare && !key.is_empty()).then(told)
}

/// Quotes of print.
const CURLY: [char; 7] = ['“', '”', '„', '‘', '’', '«', '»'];

/// The text of a line without what stands in quotes, and without a comment.
fn outside_quotes(line: &str) -> String {
    let mut open = None;
    let mut outside = String::new();
    for letter in line.chars() {
        match (open, letter) {
            (None, '#') => break,
            (None, '"' | '\'') => open = Some(letter),
            (None, letter) => outside.push(letter),
            (Some(quote), letter) if quote == letter => open = None,
            (Some(_), _) => {}
        }
    }
    outside
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::slip;

    fn told(line: &str, broken: &str) -> Option<String> {
        let text = format!("[run]\nsteps = 1\n{line}\n[method]\n");
        let at = text.find(broken).expect("a place");
        slip(&text, &(at..at + broken.len()))
    }

    /// Behind the colon stands the line as it should be, which is TOML.
    #[test]
    fn what_is_told_is_toml() {
        for (line, broken, expected) in [
            ("H = “p^2/2”", "“p", "H = \"p^2/2\""),
            ("steps = 10 // ten", "10 //", "steps = 10 # ten"),
            ("steps = 10;", "10;", "steps = 10"),
            ("time-step = 0,1", ",1", "time-step = 0.1"),
            ("file = \"a//b\" // here", "//", "file = \"a//b\" # here"),
            ("H = p^2/2 - cos(q)", "p^2", "H = \"p^2/2 - cos(q)\""),
            (
                "stepper = splitting",
                "splitting",
                "stepper = \"splitting\"",
            ),
        ] {
            let told = told(line, broken).expect(line);
            let (_, mended) = told.split_once(": ").expect("a colon");
            assert_eq!(mended, expected);
            assert!(toml::de::DeTable::parse(mended).is_ok(), "{mended}");
        }
    }

    #[test]
    fn where_the_line_tells_nothing_nothing_is_told() {
        for (line, broken) in [
            ("file = \"a//b\" x", "x"),
            ("file = 'a//b;' x", "x"),
            ("title = \"don’t; stop\" x", "x"),
            ("x = = 1 # “so” // said;", "= 1"),
            ("epsilon = = 0.1", "= 0.1"),
            ("x = [1, 2", "2"),
            ("", "[method]"),
            ("Iα = 2e3", "Iα"),
        ] {
            assert_eq!(told(line, broken), None, "{line}");
        }
    }
}
