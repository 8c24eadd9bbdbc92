//! The survey as a page.

use std::fmt::Write as _;

use leafwise::verify::{Row, Survey};

use super::figure::{ORDERS, figure};
use super::html::escaped;
use super::row::{HEADINGS, cells};

const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1c2530;--paper:#f5f7f9;--card:#fff;--line:#dde4ea;--bad:#b3261e}\
@media(prefers-color-scheme:dark){:root{--ink:#e6ebf0;--paper:#12171c;--card:#1a2128;\
--line:#2c3640;--bad:#ff8a80}}\
body{font:14px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);margin:2rem}\
table{border-collapse:collapse;background:var(--card);margin-bottom:2rem}\
th,td{border:1px solid var(--line);padding:.35rem .7rem;text-align:left;white-space:nowrap}\
tr.fails td{color:var(--bad);font-weight:600}\
figure{margin:0 0 1rem}svg{background:var(--card);max-width:100%;height:auto}\
svg text{font-size:12px;fill:var(--ink)}svg .grid{stroke:var(--line)}\
polyline:hover{stroke-width:3;stroke-opacity:1}figcaption i{font-style:normal;margin-right:.8rem}";

/// One self-contained page: errors and a table for each problem, then what does not fit.
pub(super) fn page(survey: &Survey) -> String {
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">\
         <title>leafwise verify</title><style>{STYLE}</style></head><body>\
         <h1>What every part does, against what it declares</h1>"
    );
    let problems = survey.rows.chunk_by(|a, b| a.problem == b.problem);
    for rows in problems {
        let rows: Vec<&Row> = rows.iter().collect();
        problem(&mut page, &rows);
    }
    let refusals = survey.refusals();
    for of_problem in refusals.chunk_by(|a, b| a.problem == b.problem) {
        // Writing to a String cannot fail.
        let _ = write!(
            page,
            "<h2>What does not fit {}</h2><ul>",
            escaped(of_problem[0].problem)
        );
        for refusal in of_problem {
            let _ = write!(
                page,
                "<li><b>{}</b>: {}</li>",
                escaped(&refusal.who.join(", ")),
                escaped(refusal.cause)
            );
        }
        page.push_str("</ul>");
    }
    page.push_str("</body></html>");
    page
}

fn problem(page: &mut String, rows: &[&Row]) {
    let name = rows.first().map_or("", |row| row.problem.as_str());
    let _ = write!(page, "<h2>{}</h2>", escaped(name));
    if let Some(svg) = figure(rows) {
        let legend: String = ORDERS
            .iter()
            .skip(1)
            .map(|(order, color)| format!("<i style=\"color:{color}\">order {order}</i>"))
            .collect();
        let _ = write!(
            page,
            "<figure>{svg}<figcaption>Error after twenty of the problem's steps, relative to the \
             state, against the step; by declared order: {legend}</figcaption></figure>"
        );
    }
    let headings = HEADINGS.map(|heading| format!("<th>{}</th>", escaped(heading)));
    let _ = write!(page, "<table><tr>{}</tr>", headings.concat());
    for row in rows {
        let class = if row.is_met() { "" } else { " class=\"fails\"" };
        let cells: String = cells(row)
            .iter()
            .map(|cell| format!("<td>{}</td>", escaped(cell)))
            .collect();
        let _ = write!(page, "<tr{class}>{cells}</tr>");
    }
    page.push_str("</table>");
}
