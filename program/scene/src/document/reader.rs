//! Typed access to a parsed TOML table; every failure is recorded with its place.

use std::num::IntErrorKind;
use std::ops::Range;

use leafwise_expression::syntax::{Formula, Scope, SyntaxErrorKind};
use toml::de::{DeTable, DeValue};

use super::error::{ConstantNames, SceneProblem, SceneProblemCause};
use super::located::{Located, Number, Place, Source};
use super::shape::{Key, choices, has, names};
use super::slips::slip;
use super::suggest::nearest;

/// The problems found so far.
#[derive(Debug, Default)]
pub(super) struct Problems(pub Vec<SceneProblem>);

impl Problems {
    /// Records a problem.
    pub fn push(&mut self, cause: SceneProblemCause, place: Place) {
        self.0.push(SceneProblem { cause, place });
    }

    /// Records that an entry does not stand beside `first`.
    pub fn conflict(&mut self, first: &str, second: &Item<'_>, advice: String) {
        self.push(
            SceneProblemCause::Conflict {
                first: first.to_owned(),
                second: second.key.value.clone(),
                advice,
            },
            second.key.place(),
        );
    }

    /// Whether an entry was found that does not stand beside another.
    pub fn has_conflict(&self) -> bool {
        let mut causes = self.0.iter().map(|problem| &problem.cause);
        causes.any(|cause| matches!(cause, SceneProblemCause::Conflict { .. }))
    }

    /// Records that a text is no TOML.
    pub fn syntax(
        &mut self,
        message: &str,
        span: Option<Range<usize>>,
        (text, source): (&str, Source),
    ) {
        let message = message.to_owned();
        let span = span.unwrap_or(0..0);
        let slip = slip(text, &span);
        self.push(
            SceneProblemCause::Syntax { message, slip },
            Place { source, span },
        );
    }
}

/// A table with its entries in the order of the text.
#[derive(Clone, Debug)]
pub(super) struct Table<'a> {
    /// Name of the table in messages, such as `[method]`.
    pub title: String,
    /// Its header, or the whole inline table.
    pub place: Place,
    /// The entries.
    pub items: Vec<Item<'a>>,
}

/// A key with its value.
#[derive(Clone, Debug)]
pub(super) struct Item<'a> {
    /// The key.
    pub key: Located<String>,
    /// Name of the value in messages: its key, with an index inside a list.
    pub title: String,
    value: &'a DeValue<'a>,
    place: Place,
    text: &'a str,
}

impl<'a> Table<'a> {
    /// The entries of `table`, a piece of `text`.
    pub fn new(title: &str, table: &'a DeTable<'a>, place: Place, text: &'a str) -> Self {
        let mut items: Vec<_> = table
            .iter()
            .map(|(key, value)| Item {
                key: Located {
                    value: key.get_ref().to_string(),
                    span: key.span(),
                    source: place.source.clone(),
                },
                title: key.get_ref().to_string(),
                value: value.get_ref(),
                place: Place {
                    source: place.source.clone(),
                    span: value.span(),
                },
                text,
            })
            .collect();
        items.sort_by_key(|item| item.key.span.start);
        Self {
            title: title.to_owned(),
            place,
            items,
        }
    }

    /// The entry with this key.
    pub fn get(&self, key: &str) -> Option<&Item<'a>> {
        self.items.iter().find(|item| item.key.value == key)
    }

    /// The entry with this key, which must be there.
    pub fn require(&self, key: &str, example: &str, problems: &mut Problems) -> Option<&Item<'a>> {
        let item = self.get(key);
        if item.is_none() {
            problems.push(
                SceneProblemCause::MissingKey {
                    table: self.title.clone(),
                    key: key.to_owned(),
                    example: example.to_owned(),
                },
                self.place.clone(),
            );
        }
        item
    }

    /// Records every key that is not among `valid`, and every one that does not stand beside another.
    pub fn only(&self, valid: &[Key], problems: &mut Problems) {
        for item in &self.items {
            if !has(valid, &item.key.value) {
                problems.push(
                    SceneProblemCause::UnknownKey {
                        key: item.key.value.clone(),
                        table: self.title.clone(),
                        nearest: nearest(&item.key.value, names(valid)),
                        valid: names(valid).map(str::to_owned).collect(),
                    },
                    item.key.place(),
                );
            }
        }
        let declared = valid.iter().filter(|key| self.get(key.name).is_some());
        for (first, (second, advice)) in
            declared.flat_map(|key| key.conflicts().map(|conflict| (key.name, conflict)))
        {
            if let Some(item) = self.get(second) {
                problems.conflict(first, item, advice.to_owned());
            }
        }
        if let [first, second, ..] = self.chosen(valid).as_slice() {
            let choices: Vec<_> = choices(valid).collect();
            let advice = format!("keep one of {}", choices.join(", "));
            problems.conflict(&first.key.value, second, advice);
        }
    }

    /// The one entry of those of which a scene gives one alone; `None` where there are more, which [`only`](Self::only)
    /// records.
    pub fn choice(&self, valid: &[Key]) -> Option<&Item<'a>> {
        match self.chosen(valid).as_slice() {
            [one] => Some(one),
            _ => None,
        }
    }

    /// Whether there is any entry of those of which a scene gives one alone.
    pub fn has_choice(&self, valid: &[Key]) -> bool {
        !self.chosen(valid).is_empty()
    }

    fn chosen(&self, valid: &[Key]) -> Vec<&Item<'a>> {
        let is_choice = |item: &&Item<'a>| choices(valid).any(|name| name == item.key.value);
        self.items.iter().filter(is_choice).collect()
    }
}

impl<'a> Item<'a> {
    /// Where the value stands.
    pub fn place(&self) -> Place {
        self.place.clone()
    }

    /// Whether the value is a string.
    pub fn is_string(&self) -> bool {
        self.value.is_str()
    }

    /// Whether the value is a list.
    pub fn is_list(&self) -> bool {
        self.value.is_array()
    }

    /// Whether the value is a list of which the first entry is a list.
    pub fn has_lists(&self) -> bool {
        let entries = self.value.as_array();
        let first = entries.and_then(|entries| entries.first());
        first.is_some_and(|first| first.get_ref().is_array())
    }

    /// Whether the value is a list that begins with a text.
    pub fn has_texts(&self) -> bool {
        let entries = self.value.as_array();
        let first = entries.and_then(|entries| entries.first());
        first.is_some_and(|first| first.get_ref().is_str())
    }

    /// Whether the value is a table.
    pub fn is_table(&self) -> bool {
        self.value.is_table()
    }

    /// Whether the value is a table with an entry of this name.
    pub fn has_key(&self, name: &str) -> bool {
        let table = self.value.as_table();
        table.is_some_and(|table| table.keys().any(|key| key.get_ref() == name))
    }

    /// Whether the value is a number.
    pub fn is_number(&self) -> bool {
        matches!(self.value, DeValue::Integer(_) | DeValue::Float(_))
    }

    /// Whether the value is this string.
    pub fn is_word(&self, word: &str) -> bool {
        self.value.as_str() == Some(word)
    }

    /// The value if it is a truth value.
    pub fn flag(&self) -> Option<bool> {
        self.value.as_bool()
    }

    /// Records that the value is not `expected`.
    pub fn wrong_type(&self, expected: &str, problems: &mut Problems) {
        let found = match self.value {
            DeValue::String(text) => format!("the string \"{text}\""),
            DeValue::Integer(_) | DeValue::Float(_) | DeValue::Boolean(_) => self.written().into(),
            DeValue::Datetime(_) => "a date".to_owned(),
            DeValue::Array(_) => "a list".to_owned(),
            DeValue::Table(_) => "a table".to_owned(),
        };
        problems.push(
            SceneProblemCause::WrongType {
                key: self.title.clone(),
                expected: expected.to_owned(),
                found,
            },
            self.place(),
        );
    }

    /// A string.
    pub fn string(&self, problems: &mut Problems) -> Option<Located<String>> {
        match self.value {
            DeValue::String(text) => Some(Located::new(text.to_string(), self.place())),
            _ => {
                self.wrong_type("a string", problems);
                None
            }
        }
    }

    /// A formula: a string, or a finite number standing for itself.
    pub fn formula(&self, problems: &mut Problems) -> Option<Located<String>> {
        match self.value {
            DeValue::String(text) => Some(Located::new(text.to_string(), self.place())),
            DeValue::Integer(_) | DeValue::Float(_) => self
                .number(problems)
                .map(|number| number.map(|number| number.literal)),
            _ => {
                self.wrong_type("a formula in quotes", problems);
                None
            }
        }
    }

    /// Meaning of the value, one of a few words; spaces inside the word do not matter.
    pub fn word<T: Copy>(
        &self,
        kind: &'static str,
        words: &[(&'static str, T)],
        problems: &mut Problems,
    ) -> Option<T> {
        let written = self.string(problems)?;
        let squeezed: String = written.value.split_whitespace().collect();
        let known = words.iter().find(|(word, _)| *word == squeezed);
        if known.is_none() {
            let valid = words.iter().map(|(word, _)| *word);
            let cause = SceneProblemCause::unknown(kind, &written.value, valid);
            problems.push(cause, written.place());
        }
        known.map(|(_, meaning)| *meaning)
    }

    /// A finite number.
    pub fn number(&self, problems: &mut Problems) -> Option<Located<Number>> {
        let literal = match self.value {
            DeValue::Float(float) => float.as_str().replace('_', ""),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().replace('_', ""),
            DeValue::Integer(integer) => {
                match u128::from_str_radix(&integer.as_str().replace('_', ""), integer.radix()) {
                    Ok(value) => value.to_string(),
                    Err(_) => self.written().to_owned(),
                }
            }
            _ => {
                self.wrong_type("a number", problems);
                return None;
            }
        };
        match literal.parse::<f64>() {
            Ok(value) if value.is_finite() => {
                Some(Located::new(Number { literal, value }, self.place()))
            }
            _ => {
                problems.push(
                    SceneProblemCause::NotFinite {
                        key: self.title.clone(),
                        literal: self.written().to_owned(),
                    },
                    self.place(),
                );
                None
            }
        }
    }

    /// A finite number, or a formula of numbers alone: `"3/4"`, `"sqrt(3)/2"`.
    pub fn constant(&self, problems: &mut Problems) -> Option<Located<Number>> {
        let DeValue::String(text) = self.value else {
            return self.number(problems);
        };
        let formula = Formula::parse(text);
        let resolved = formula.and_then(|formula| formula.resolve(&Scope::new(), None));
        let value = match resolved {
            Ok(expression) => expression.map_or(f64::NAN, |of| of.evaluate(&[], &[])),
            Err(error) => {
                let cause = SceneProblemCause::NoConstant {
                    key: self.title.clone(),
                    text: text.to_string(),
                    reason: match &error.kind {
                        SyntaxErrorKind::LengthUnknown { name } => {
                            format!("`{name}` is not known to parameters")
                        }
                        kind => kind.to_string(),
                    },
                    names: ConstantNames::None,
                    is_of_state: false,
                };
                problems.push(cause, self.place());
                return None;
            }
        };
        if !value.is_finite() {
            problems.push(
                SceneProblemCause::NotFinite {
                    key: self.title.clone(),
                    literal: self.written().to_owned(),
                },
                self.place(),
            );
            return None;
        }
        let literal = format!("{value:?}");
        Some(Located::new(Number { literal, value }, self.place()))
    }

    /// Whether it is a formula that names something.
    pub fn names_others(&self) -> bool {
        let DeValue::String(text) = self.value else {
            return false;
        };
        Formula::parse(text).is_ok_and(|formula| !formula.references().is_empty())
    }

    /// A whole number of at least `minimum`.
    pub fn whole(&self, minimum: u64, problems: &mut Problems) -> Option<Located<u64>> {
        self.whole_in(minimum, u64::MAX, problems)
    }

    /// A whole number from `minimum` to `maximum`.
    pub fn whole_in(
        &self,
        minimum: u64,
        maximum: u64,
        problems: &mut Problems,
    ) -> Option<Located<u64>> {
        let parsed = match self.value {
            DeValue::Integer(integer) => {
                let digits = integer.as_str().replace('_', "");
                u64::from_str_radix(digits.trim_start_matches('+'), integer.radix())
            }
            // 1e3 and 1000.0 are whole numbers: each below 2^53 is a double.
            DeValue::Float(float) => {
                let value: Option<f64> = float.as_str().replace('_', "").parse().ok();
                let whole = value.filter(|value| libm::trunc(*value) == *value);
                match whole.filter(|value| value.abs() < 9_007_199_254_740_992.0) {
                    Some(value) => format!("{value:.0}").parse::<u64>(),
                    None => {
                        self.wrong_type("a whole number", problems);
                        return None;
                    }
                }
            }
            _ => {
                self.wrong_type("a whole number", problems);
                return None;
            }
        };
        match parsed {
            Ok(value) if (minimum..=maximum).contains(&value) => {
                Some(Located::new(value, self.place()))
            }
            outcome => {
                let is_too_large = match outcome {
                    Ok(value) => value > maximum,
                    Err(error) => *error.kind() == IntErrorKind::PosOverflow,
                };
                let allowed = if is_too_large {
                    format!("a whole number of at most {maximum}")
                } else {
                    format!("a whole number of at least {minimum}")
                };
                problems.push(
                    SceneProblemCause::OutOfRange {
                        key: self.title.clone(),
                        value: self.written().to_owned(),
                        allowed,
                    },
                    self.place(),
                );
                None
            }
        }
    }

    /// The entries of a list.
    pub fn list(&self, expected: &str, problems: &mut Problems) -> Option<Vec<Item<'a>>> {
        let Some(array) = self.value.as_array() else {
            self.wrong_type(expected, problems);
            return None;
        };
        let source = &self.place.source;
        let entries = array.iter().enumerate().map(|(index, value)| Item {
            key: self.key.clone(),
            title: format!("{}[{index}]", self.title),
            value: value.get_ref(),
            place: Place {
                source: source.clone(),
                span: value.span(),
            },
            text: self.text,
        });
        Some(entries.collect())
    }

    /// A list whose entries `read` understands.
    pub fn list_of<T>(
        &self,
        expected: &str,
        problems: &mut Problems,
        mut read: impl FnMut(&Item<'a>, &mut Problems) -> Option<T>,
    ) -> Option<Vec<T>> {
        let entries = self.list(expected, problems)?;
        let values: Vec<_> = entries.iter().map(|entry| read(entry, problems)).collect();
        values.into_iter().collect()
    }

    /// A square matrix of numbers, by its rows.
    pub fn square_matrix(&self, problems: &mut Problems) -> Option<Vec<Vec<Located<Number>>>> {
        let rows = self.list("a list of rows of numbers", problems)?;
        let count = rows.len();
        let mut matrix = Vec::with_capacity(count);
        let mut is_square = true;
        for row in &rows {
            let Some(numbers) = row.list_of("a row of numbers", problems, Item::number) else {
                is_square = false;
                continue;
            };
            if numbers.len() != count {
                is_square = false;
                problems.push(
                    SceneProblemCause::Shape {
                        what: row.title.clone(),
                        found: format!("{} entries", numbers.len()),
                        expected: format!("{count}, as many as there are rows"),
                    },
                    row.place(),
                );
            }
            matrix.push(numbers);
        }
        is_square.then_some(matrix)
    }

    /// A table; `title` is what messages call it.
    pub fn table(&self, title: &str, expected: &str, problems: &mut Problems) -> Option<Table<'a>> {
        match self.value {
            DeValue::Table(table) => {
                let whole = self.place();
                let is_inline = self.text[whole.span.clone()].starts_with('{');
                let place = if is_inline { whole } else { self.key.place() };
                Some(Table::new(title, table, place, self.text))
            }
            _ => {
                self.wrong_type(expected, problems);
                None
            }
        }
    }

    /// A table whose values `read` understands, in the order of the text.
    pub fn pairs<T>(
        &self,
        expected: &str,
        problems: &mut Problems,
        mut read: impl FnMut(&Item<'a>, &mut Problems) -> Option<T>,
    ) -> Option<Vec<(Located<String>, T)>> {
        let table = self.table(&self.title, expected, problems)?;
        let values: Vec<_> = table
            .items
            .iter()
            .map(|item| read(item, problems).map(|value| (item.key.clone(), value)))
            .collect();
        values.into_iter().collect()
    }

    /// The value as it is written.
    pub fn written(&self) -> &'a str {
        &self.text[self.place.span.clone()]
    }
}

/// The place of a text's end, where an absent table would stand.
pub(super) fn end_of(text: &str) -> Place {
    let end = text.trim_end().len();
    Place {
        source: Source::Scene,
        span: end..end,
    }
}
