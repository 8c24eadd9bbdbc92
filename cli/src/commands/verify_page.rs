//! The survey as a page.

use std::fmt::Write as _;

use leafwise::verify::Survey;

use super::verify::{HEADINGS, cells};

const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1c2530;--paper:#f5f7f9;--card:#fff;--line:#dde4ea;--bad:#b3261e}\
@media(prefers-color-scheme:dark){:root{--ink:#e6ebf0;--paper:#12171c;--card:#1a2128;\
--line:#2c3640;--bad:#ff8a80}}\
body{font:14px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);margin:2rem}\
table{border-collapse:collapse;background:var(--card);margin-bottom:2rem}\
th,td{border:1px solid var(--line);padding:.35rem .7rem;text-align:left;white-space:nowrap}\
tr.fails td{color:var(--bad);font-weight:600}";

/// One self-contained page: a table for each problem, then what does not fit.
pub(super) fn page(survey: &Survey) -> String {
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">\
         <title>leafwise verify</title><style>{STYLE}</style></head><body>\
         <h1>What every part does, against what it declares</h1>"
    );
    let mut problem = None;
    for row in &survey.rows {
        if problem != Some(&row.problem) {
            if problem.is_some() {
                page.push_str("</table>");
            }
            problem = Some(&row.problem);
            let headings: String = HEADINGS
                .iter()
                .map(|h| format!("<th>{}</th>", escaped(h)))
                .collect();
            // Writing to a String cannot fail.
            let _ = write!(
                page,
                "<h2>{}</h2><table><tr>{headings}</tr>",
                escaped(&row.problem)
            );
        }
        let class = if row.is_met() { "" } else { " class=\"fails\"" };
        let cells: String = cells(row)
            .iter()
            .map(|cell| format!("<td>{}</td>", escaped(cell)))
            .collect();
        let _ = write!(page, "<tr{class}>{cells}</tr>");
    }
    if problem.is_some() {
        page.push_str("</table>");
    }
    if !survey.refused.is_empty() {
        page.push_str("<h2>Combinations that do not fit</h2><ul>");
        for (name, reason) in &survey.refused {
            let _ = write!(
                page,
                "<li><b>{}</b>: {}</li>",
                escaped(name),
                escaped(reason)
            );
        }
        page.push_str("</ul>");
    }
    page.push_str("</body></html>");
    page
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
