//! A picture with what stands around it.

use super::html::escape;

/// A picture, its legend, caption and notes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Figure {
    /// The heading.
    pub title: String,
    /// The `<svg>` element.
    pub svg: String,
    /// Series names, in the order of the series colours; empty when one series needs no name.
    pub legend: Vec<String>,
    /// What is shown and how to read it.
    pub caption: String,
    /// What the picture could not show: values moved or left out.
    pub notes: Vec<String>,
}

impl Figure {
    /// The figure as HTML.
    pub fn html(&self) -> String {
        let mut html = format!("<figure>\n<h3>{}</h3>\n", escape(&self.title));
        if !self.legend.is_empty() {
            html.push_str("<ul class=\"legend\">");
            for (index, name) in self.legend.iter().enumerate() {
                let color = index % super::canvas::SERIES.len();
                html.push_str(&format!("<li class=\"s{color}\">{}</li>", escape(name)));
            }
            html.push_str("</ul>\n");
        }
        html.push_str(&self.svg);
        html.push_str(&format!("<figcaption>{}", escape(&self.caption)));
        for note in &self.notes {
            html.push_str(&format!(" <span class=\"note\">{}</span>", escape(note)));
        }
        html.push_str("</figcaption>\n</figure>\n");
        html
    }
}
