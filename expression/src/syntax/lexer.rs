//! From text to tokens.

use super::error::{SyntaxError, SyntaxErrorKind};
use super::tree::Span;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Symbol {
    Plus,
    Minus,
    Times,
    Divide,
    Power,
    Open,
    Close,
    OpenBracket,
    CloseBracket,
    Comma,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TokenKind {
    Number,
    Name,
    Symbol(Symbol),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Token {
    pub(super) kind: TokenKind,
    pub(super) span: Span,
}

/// The greatest number of tokens of a formula: what is made of as many takes less than a gigabyte.
pub(super) const TOKEN_LIMIT: usize = 1 << 21;

/// The tokens of `text`, in order.
pub(super) fn tokens(text: &str) -> Result<Vec<Token>, SyntaxError> {
    let mut tokens = Vec::new();
    let mut position = 0;
    while let Some(character) = text[position..].chars().next() {
        let start = position;
        let rest = &text[start..];
        if character.is_whitespace() {
            position += character.len_utf8();
            continue;
        }
        let kind = if let Some(length) = number_length(rest) {
            position += length;
            TokenKind::Number
        } else if begins_name(character) {
            position += name_length(rest);
            TokenKind::Name
        } else if let Some((symbol, length)) = symbol(rest, character) {
            position += length;
            TokenKind::Symbol(symbol)
        } else {
            let span = Span {
                start,
                end: start + character.len_utf8(),
            };
            let kind = SyntaxErrorKind::UnexpectedCharacter { character };
            let is_in_choice = text[..start].contains("if(");
            let plain = plain(character).or((character == '=' && is_in_choice).then_some("=="));
            let suggestion = magnitude(rest).or(plain.map(str::to_owned));
            return Err(SyntaxError::new(span, kind).suggesting(suggestion));
        };
        if tokens.len() == TOKEN_LIMIT {
            let span = Span {
                start,
                end: position,
            };
            let limit = TOKEN_LIMIT;
            return Err(SyntaxError::new(span, SyntaxErrorKind::TooLong { limit }));
        }
        tokens.push(Token {
            kind,
            span: Span {
                start,
                end: position,
            },
        });
    }
    Ok(tokens)
}

/// Whether `text` is one name: letters, digits and underscores, beginning with no digit; or a name and that of a component with
/// a point between, `s.x`.
pub(super) fn is_name(text: &str) -> bool {
    text.starts_with(begins_name) && name_length(text) == text.len()
}

/// The length of the name at the beginning of `text`.
fn name_length(text: &str) -> usize {
    let word = |text: &str| text.find(|c| !continues_name(c)).unwrap_or(text.len());
    let length = word(text);
    match text[length..].strip_prefix('.') {
        Some(component) if component.starts_with(begins_name) => length + 1 + word(component),
        _ => length,
    }
}

fn begins_name(character: char) -> bool {
    character == '_' || character.is_alphabetic() && continues_name(character)
}

/// Superscripts count as digits in Unicode, but `x²` means a power.
fn continues_name(character: char) -> bool {
    let superscript = matches!(character, '²' | '³' | '¹' | '⁰'..='ⁿ');
    (character == '_' || character.is_alphanumeric()) && !superscript
}

/// The symbol at the beginning of `text`, whose first character is given, and its length in bytes.
fn symbol(text: &str, character: char) -> Option<(Symbol, usize)> {
    let doubled = match text.get(..2) {
        Some("**") => Some(Symbol::Power),
        Some("<=") => Some(Symbol::LessOrEqual),
        Some(">=") => Some(Symbol::GreaterOrEqual),
        Some("==") => Some(Symbol::Equal),
        Some("!=") => Some(Symbol::NotEqual),
        _ => None,
    };
    if let Some(doubled) = doubled {
        return Some((doubled, 2));
    }
    let single = match character {
        '+' => Symbol::Plus,
        '-' => Symbol::Minus,
        '*' => Symbol::Times,
        '/' => Symbol::Divide,
        '^' => Symbol::Power,
        '(' => Symbol::Open,
        ')' => Symbol::Close,
        '[' => Symbol::OpenBracket,
        ']' => Symbol::CloseBracket,
        ',' => Symbol::Comma,
        '<' => Symbol::Less,
        '>' => Symbol::Greater,
        _ => return None,
    };
    Some((single, 1))
}

/// A magnitude between bars, `|q - 1|`, as it is written here.
fn magnitude(text: &str) -> Option<String> {
    let (inner, _) = text.strip_prefix('|')?.split_once('|')?;
    (!inner.trim().is_empty()).then(|| format!("abs({})", inner.trim()))
}

/// The spelling of a typographic character in formulas.
fn plain(character: char) -> Option<&'static str> {
    Some(match character {
        '−' | '–' | '—' => "-",
        '×' | '·' | '⋅' | '∙' => "*",
        '÷' | '∕' => "/",
        '²' => "^2",
        '³' => "^3",
        '{' => "(",
        '}' => ")",
        ';' => ",",
        '≤' => "<=",
        '≥' => ">=",
        '≠' => "!=",
        '&' => "and",
        '|' => "or",
        '!' => "not",
        _ => return None,
    })
}

/// The length of the decimal at the beginning of `text`. An `e` belongs to it only when an
/// exponent follows.
fn number_length(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let digits_from = |from: usize| {
        bytes[from..]
            .iter()
            .take_while(|byte| byte.is_ascii_digit())
            .count()
    };
    let whole = digits_from(0);
    let mut end = whole;
    if bytes.get(whole) == Some(&b'.') {
        let fraction = digits_from(whole + 1);
        if whole == 0 && fraction == 0 {
            return None;
        }
        end = whole + 1 + fraction;
    } else if whole == 0 {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let signed = matches!(bytes.get(end + 1), Some(b'+' | b'-'));
        let exponent = end + 1 + usize::from(signed);
        let digits = if exponent < bytes.len() {
            digits_from(exponent)
        } else {
            0
        };
        if digits > 0 {
            end = exponent + digits;
        }
    }
    Some(end)
}
