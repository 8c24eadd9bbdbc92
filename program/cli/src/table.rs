//! Aligned columns.

/// Rows as lines: the first column flush left, the others flush right, two spaces between.
pub fn numbers(rows: &[Vec<String>]) -> Vec<String> {
    aligned(rows, |column| column > 0)
}

/// Rows as lines, every column flush left.
pub fn words(rows: &[Vec<String>]) -> Vec<String> {
    aligned(rows, |_| false)
}

/// Rows as lines: columns before `left` flush left, the others flush right.
pub fn aligned_after(rows: &[Vec<String>], left: usize) -> Vec<String> {
    aligned(rows, |column| column >= left)
}

fn aligned(rows: &[Vec<String>], is_right: impl Fn(usize) -> bool) -> Vec<String> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns)
        .map(|at| {
            rows.iter()
                .filter_map(|row| row.get(at))
                .map(|c| c.chars().count())
                .max()
        })
        .map(Option::unwrap_or_default)
        .collect();
    rows.iter()
        .map(|row| {
            let cells: Vec<String> = row
                .iter()
                .enumerate()
                .map(|(at, cell)| {
                    let gap = " ".repeat(widths[at] - cell.chars().count());
                    if is_right(at) {
                        format!("{gap}{cell}")
                    } else {
                        format!("{cell}{gap}")
                    }
                })
                .collect();
            cells.join("  ").trim_end().to_owned()
        })
        .collect()
}

/// Digits in groups of three: 12 345 678.
pub fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut grouped = String::with_capacity(digits.len() * 4 / 3);
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            grouped.push(' ');
        }
        grouped.push(digit);
    }
    grouped
}

/// A number with up to ten digits.
pub fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-4..1e9).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// A duration for reading: 0.42 ms, 3.1 s, 2 min 05 s.
pub fn duration(seconds: f64) -> String {
    if seconds < 1e-3 {
        format!("{:.0} µs", seconds * 1e6)
    } else if seconds < 1.0 {
        format!("{:.1} ms", seconds * 1e3)
    } else if seconds < 60.0 {
        format!("{seconds:.2} s")
    } else {
        format!(
            "{} min {:02} s",
            (seconds / 60.0) as u64,
            (seconds % 60.0) as u64
        )
    }
}

/// The width of running text, its label apart.
const WIDTH: usize = 88;

/// Texts beside their labels, in lines that a terminal holds.
pub fn labelled(texts: &[(&str, &str)]) -> Vec<String> {
    let longest = texts.iter().map(|(label, _)| label.chars().count()).max();
    let column = longest.unwrap_or(0) + 2;
    let mut lines = Vec::new();
    for (label, text) in texts {
        for (at, line) in wrapped(text, WIDTH).into_iter().enumerate() {
            let label = if at == 0 { label } else { "" };
            lines.push(format!("{label:column$}{line}"));
        }
    }
    lines
}

/// Words in lines of at most `width` characters.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last_mut().expect("a line was put there");
        let length = last.chars().count() + 1 + word.chars().count();
        if last.is_empty() {
            last.push_str(word);
        } else if length <= width {
            last.push(' ');
            last.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_text_is_broken_between_words() {
        assert_eq!(wrapped("one two three", 7), ["one two", "three"]);
        assert_eq!(wrapped("unbreakable", 3), ["unbreakable"]);
        let lines = labelled(&[("a", "text"), ("label", "more")]);
        assert_eq!(lines, ["a      text", "label  more"]);
    }

    #[test]
    fn columns_line_up() {
        let rows = [
            vec!["energy".to_owned(), "1".to_owned()],
            vec!["é".to_owned(), "22".to_owned()],
        ];
        assert_eq!(numbers(&rows), ["energy   1", "é       22"]);
        assert_eq!(words(&rows), ["energy  1", "é       22"]);
    }

    #[test]
    fn long_numbers_are_grouped() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(1234), "1 234");
        assert_eq!(grouped(123_456_789), "123 456 789");
        assert_eq!(duration(0.0000124), "12 µs");
        assert_eq!(duration(125.4), "2 min 05 s");
    }
}
