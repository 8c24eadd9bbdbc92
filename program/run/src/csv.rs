//! Comma-separated values (RFC 4180): every table that the program writes goes through here.
//!
//! Why not the crate `csv`: it quotes by one style for a whole file, and has no rule for cells that
//! begin like a formula.

use std::fmt::Write as _;

/// A table as text, written cell after cell and row after row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    text: String,
    /// Whether the row that is being written has a cell.
    is_begun: bool,
}

impl Table {
    /// A table that begins with these headings.
    pub fn new(headings: impl IntoIterator<Item = impl AsRef<str>>) -> Self {
        let mut table = Self::default();
        for heading in headings {
            table.text(heading.as_ref());
        }
        table.end_row();
        table
    }

    /// A cell of text: in quotes where it holds a comma, a quote or a line break, and where it begins
    /// like a formula of a spreadsheet. A number is never in quotes.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.begin_cell();
        let is_number = text.parse::<f64>().is_ok();
        let is_like_a_formula = text.starts_with(['=', '+', '-', '@']) && !is_number;
        if text.contains([',', '"', '\n', '\r']) || is_like_a_formula {
            self.text.push('"');
            self.text.push_str(&text.replace('"', "\"\""));
            self.text.push('"');
        } else {
            self.text.push_str(text);
        }
        self
    }

    /// A cell with a double: the shortest decimals that read back as the same one, `NaN`, `inf` or `-inf`.
    pub fn number(&mut self, value: f64) -> &mut Self {
        self.begin_cell();
        let size = value.abs();
        // Elsewhere the crate writes the same digits in another way than Rust does, as 0.00002 and 1e+16.
        if (1e-4..1e16).contains(&size) || size < 1e-5 {
            self.text.push_str(zmij::Buffer::new().format_finite(value));
        } else {
            // Writing to a string cannot fail.
            let _ = write!(self.text, "{value:?}");
        }
        self
    }

    /// A cell with a double; an empty one where there is none.
    pub fn optional(&mut self, value: Option<f64>) -> &mut Self {
        match value {
            Some(value) => self.number(value),
            None => self.text(""),
        }
    }

    /// A cell for each of these doubles.
    pub fn numbers(&mut self, values: impl IntoIterator<Item = f64>) -> &mut Self {
        for value in values {
            self.number(value);
        }
        self
    }

    /// A cell with a whole number.
    pub fn whole(&mut self, value: u64) -> &mut Self {
        self.begin_cell();
        let _ = write!(self.text, "{value}");
        self
    }

    /// Ends the row.
    pub fn end_row(&mut self) {
        self.text.push('\n');
        self.is_begun = false;
    }

    /// Forgets every row, and keeps the memory.
    pub fn clear(&mut self) {
        self.text.clear();
        self.is_begun = false;
    }

    /// The rows so far.
    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// The bytes of all rows.
    pub fn into_bytes(self) -> Vec<u8> {
        self.text.into_bytes()
    }

    fn begin_cell(&mut self) {
        if self.is_begun {
            self.text.push(',');
        }
        self.is_begun = true;
    }
}

/// The numbers of a row that holds nothing else; NaN where a cell is none.
pub(crate) fn numbers(row: &str) -> impl Iterator<Item = f64> {
    row.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN))
}

/// Cells of each row of a table, as [`Table`] writes it. Empty lines are left out.
///
/// # Errors
/// A quote that is not closed, and the line in which it stands.
pub fn rows(text: &str) -> Result<Vec<Vec<String>>, String> {
    let (mut rows, mut row, mut cell) = (Vec::new(), Vec::new(), String::new());
    // The line in which an open quote stands.
    let (mut line, mut quoted) = (1, None);
    let mut all = text.chars().peekable();
    while let Some(c) = all.next() {
        line += usize::from(c == '\n');
        match (c, quoted) {
            ('"', Some(_)) if all.peek() == Some(&'"') => {
                all.next();
                cell.push('"');
            }
            ('"', Some(_)) => quoted = None,
            (c, Some(_)) => cell.push(c),
            ('"', None) if cell.is_empty() => quoted = Some(line),
            (',', None) => row.push(std::mem::take(&mut cell)),
            ('\r', None) if all.peek() == Some(&'\n') => {}
            ('\n', None) => {
                row.push(std::mem::take(&mut cell));
                rows.push(std::mem::take(&mut row));
            }
            (c, None) => cell.push(c),
        }
    }
    if let Some(line) = quoted {
        return Err(format!("the quote in line {line} is not closed"));
    }
    if !(cell.is_empty() && row.is_empty()) {
        row.push(cell);
        rows.push(row);
    }
    rows.retain(|row: &Vec<String>| row.len() > 1 || !row[0].is_empty());
    Ok(rows)
}

/// The headings of a table, each of them once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Headings(Vec<String>);

impl Headings {
    /// One more column. Where its name is taken, what it is stands behind it: `q (Casimir)`.
    pub fn push(&mut self, name: &str, kind: &str) {
        let mut heading = name.to_owned();
        let mut again = 1_u32;
        while self.0.contains(&heading) {
            heading = match again {
                1 => format!("{name} ({kind})"),
                again => format!("{name} ({kind} {again})"),
            };
            again += 1;
        }
        self.0.push(heading);
    }

    /// Several of a kind.
    pub fn extend(&mut self, names: impl IntoIterator<Item = impl AsRef<str>>, kind: &str) {
        for name in names {
            self.push(name.as_ref(), kind);
        }
    }

    /// One after the other.
    pub fn into_names(self) -> Vec<String> {
        self.0
    }

    /// The table that begins with them.
    pub fn table(&self) -> Table {
        Table::new(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_reads_back_and_is_no_formula() {
        for (text, cell) in [
            ("energy", "energy"),
            ("x[3]^2 + 1", "x[3]^2 + 1"),
            ("max(a, b)", "\"max(a, b)\""),
            ("q^2\n+ p^2", "\"q^2\n+ p^2\""),
            ("a\rb", "\"a\rb\""),
            ("say \"h\"", "\"say \"\"h\"\"\""),
            ("=HYPERLINK(1)", "\"=HYPERLINK(1)\""),
            ("-q", "\"-q\""),
            ("-1.0", "-1.0"),
            ("-1e-300", "-1e-300"),
            ("+0.5", "+0.5"),
            ("-inf", "-inf"),
            ("-1.0 + q", "\"-1.0 + q\""),
        ] {
            assert_eq!(Table::default().text(text).as_str(), cell);
        }
    }

    #[test]
    fn cells_read_back() {
        let mut table = Table::new(["a, b", "say \"x\"", ""]);
        table.text("1\n2").text("").number(0.5).end_row();
        let back = rows(table.as_str()).expect("rows");
        assert_eq!(
            back,
            [vec!["a, b", "say \"x\"", ""], vec!["1\n2", "", "0.5"]]
        );
        assert_eq!(
            rows("a\r\n\r\n1"),
            Ok(vec![vec!["a".to_owned()], vec!["1".to_owned()]])
        );
        assert!(rows("a\n\"b").expect_err("open").contains("line 2"));
    }

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        let values = [0.1, -0.0, 5e-324, f64::MAX, 1e16, f64::INFINITY, -7.0];
        let mut table = Table::default();
        table.numbers(values).end_row();
        let row = "0.1,-0.0,5e-324,1.7976931348623157e308,1e16,inf,-7.0\n";
        assert_eq!(table.as_str(), row);
        assert!(numbers(row.trim_end()).eq(values));
        assert!(numbers("NaN,word").all(f64::is_nan));
    }

    /// The text is the shortest that reads back, at every size: Rust's own, but for the last digit where two are equally near.
    #[test]
    fn numbers_are_written_as_rust_writes_them() {
        let mut others = 0;
        let edges = [
            1e-5,
            1e-4,
            1e15,
            1e16,
            5e-324,
            f64::MIN_POSITIVE,
            f64::MAX,
            0.0,
        ];
        let near = edges.iter().flat_map(|x| [x.next_down(), *x, x.next_up()]);
        let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
        let drawn = (0..200_000).map(|k: i32| {
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            let part = bits as f64 / u64::MAX as f64 - 0.5;
            match k % 2 {
                0 => f64::from_bits(bits),
                _ => libm::ldexp(part, k % 120 - 60),
            }
        });
        let mut table = Table::default();
        for value in near.chain(drawn) {
            table.clear();
            table.number(value);
            let (own, rusts) = (table.as_str(), format!("{value:?}"));
            if own != rusts {
                others += 1;
                assert_eq!(own.len(), rusts.len(), "{own} {rusts}");
                let read: f64 = own.parse().expect("a number");
                assert_eq!(read.to_bits(), value.to_bits(), "{own} {rusts}");
            }
        }
        assert!(others < 1000, "ties are rare: {others}");
    }

    #[test]
    fn rows_have_a_cell_for_each_heading_and_empty_ones_count() {
        let mut table = Table::new(["method", "steps", "error"]);
        table.text("rk4").whole(10).optional(None).end_row();
        table.text("").whole(0).optional(Some(0.5)).end_row();
        assert_eq!(table.as_str(), "method,steps,error\nrk4,10,\n,0,0.5\n");
        table.clear();
        assert_eq!(table.as_str(), "");
    }

    #[test]
    fn a_heading_that_is_taken_says_what_it_is() {
        let mut headings = Headings::default();
        headings.push("t", "time");
        headings.extend(["q", "t", "p (Casimir)"], "variable");
        headings.extend(["q", "p", "q"], "Casimir");
        let line = "t,q,t (variable),p (Casimir),q (Casimir),p,q (Casimir 2)\n";
        assert_eq!(headings.table().as_str(), line);
    }
}
