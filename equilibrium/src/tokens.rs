//! Numbers as Fortran writes them, with no space between some.

use crate::error::EquilibriumError;

/// The numbers of a text, one after another.
pub(crate) struct Tokens<'a> {
    words: Vec<(usize, &'a str)>,
    next: usize,
}

impl<'a> Tokens<'a> {
    /// The words of a text from one line on. A sign that follows no letter of an exponent begins a word, since five numbers of
    /// sixteen places stand in a line without spaces. An exponent of three digits is written without its letter: `1.5-103`.
    pub fn of(text: &'a str, first_line: usize) -> Self {
        let mut words = Vec::new();
        for (at, line) in text.lines().enumerate().skip(first_line) {
            for word in line.split([' ', '\t', ',', '\r']) {
                let mut start = 0;
                let mut before = 'e';
                for (place, letter) in word.char_indices() {
                    let is_sign = matches!(letter, '+' | '-');
                    let is_exponent = begins_exponent(&word[start..place], &word[place..]);
                    if is_sign && !matches!(before, 'e' | 'E' | 'd' | 'D') && !is_exponent {
                        words.push((at + 1, &word[start..place]));
                        start = place;
                    }
                    before = letter;
                }
                words.push((at + 1, &word[start..]));
            }
        }
        words.retain(|(_, word)| !word.is_empty());
        Self { words, next: 0 }
    }

    /// The next `count` numbers.
    ///
    /// # Errors
    /// A word that is no finite number, and an early end.
    pub fn numbers(
        &mut self,
        name: &'static str,
        count: usize,
    ) -> Result<Vec<f64>, EquilibriumError> {
        let rest = &self.words[self.next..];
        if rest.len() < count {
            return Err(EquilibriumError::Short {
                name,
                found: rest.len(),
                needed: count,
            });
        }
        self.next += count;
        let number = |(line, word): &(usize, &str)| {
            let mut written = word.replace(['d', 'D'], "e");
            let sign = written.rfind(['+', '-']).filter(|place| *place > 0);
            if let Some(place) =
                sign.filter(|place| begins_exponent(&written[..*place], &written[*place..]))
            {
                written.insert(place, 'e');
            }
            let value = written
                .parse::<f64>()
                .ok()
                .filter(|value| value.is_finite());
            value.ok_or_else(|| EquilibriumError::Number {
                name,
                line: *line,
                word: (*word).to_owned(),
            })
        };
        rest[..count].iter().map(number).collect()
    }

    /// Whether no word is left.
    pub fn is_at_end(&self) -> bool {
        self.next == self.words.len()
    }
}

/// Whether a sign and three digits behind a number with a point are its exponent, as Fortran writes those below −99 and above 99.
fn begins_exponent(before: &str, from: &str) -> bool {
    let Some(rest) = from.strip_prefix(['+', '-']) else {
        return false;
    };
    let digits = rest.find(|letter: char| !letter.is_ascii_digit());
    let ends = digits.unwrap_or(rest.len()) == 3 && !rest[3..].starts_with('.');
    ends && before.contains('.') && !before.contains(['e', 'E', 'd', 'D'])
}
