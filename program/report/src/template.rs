//! Pages from templates: `templates/*.html` say what stands where, and every value is escaped.

use minijinja::syntax::SyntaxConfig;
use minijinja::value::{Serde, Value};
use minijinja::{
    AutoEscape, Environment, Error, Output, State, UndefinedBehavior, escape_formatter,
};
use serde::Serialize;

use super::canvas::SERIES;
use super::error::ReportError;
use super::html::escaped;
use super::number::number;

macro_rules! templates {
    ($($name:literal),*) => {
        [$(($name, include_str!(concat!("../templates/", $name)))),*]
    };
}

const TEMPLATES: [(&str, &str); 11] = templates![
    "page.html",
    "style.css",
    "parts.html",
    "run.html",
    "explore.js",
    "ensemble.html",
    "comparison.html",
    "reproduction.html",
    "survey.html",
    "sweep.html",
    "errors.svg"
];

/// A template filled with values; what it names must be there.
///
/// # Errors
/// [`ReportError::Page`] where a template is none, or names what there is not.
pub(super) fn render(name: &'static str, values: &impl Serialize) -> Result<String, ReportError> {
    fill(name, Value::from(Serde(values))).map_err(|error| ReportError::Page {
        page: name,
        message: format!("{error:#}"),
    })
}

fn write_value(out: &mut Output, state: &mut State, value: &Value) -> Result<(), Error> {
    match value.as_str() {
        Some(text) if !value.is_safe() => Ok(out.write_str(&escaped(text))?),
        _ => escape_formatter(out, state, value),
    }
}

fn fill(name: &str, values: Value) -> Result<String, Error> {
    let mut pages = Environment::new();
    pages.set_auto_escape_callback(|_| AutoEscape::Html);
    pages.set_formatter(write_value);
    pages.set_undefined_behavior(UndefinedBehavior::Strict);
    let mut syntax = SyntaxConfig::builder();
    syntax.trim_blocks(true).lstrip_blocks(true);
    pages.set_syntax(syntax.keep_trailing_newline(true).build()?);
    pages.add_global("colors", SERIES.len());
    pages.add_filter("number", number);
    pages.add_filter("exact", |value: f64| format!("{value:?}"));
    for (name, source) in TEMPLATES {
        pages.add_template(name, source)?;
    }
    pages.get_template(name)?.render(values)
}
