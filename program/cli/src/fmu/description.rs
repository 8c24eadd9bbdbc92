//! `modelDescription.xml`: names, values and numbers of a unit's variables.

use std::fmt::Write as _;

use super::{IDENTIFIER, Role, Variable};

/// The description of a unit by its name, its token, the time of a step and that of the run, and its variables.
pub fn description(
    (name, token): (&str, &str),
    (step, stop): (f64, f64),
    variables: &[Variable],
) -> String {
    let mut text = String::new();
    let mut line = |content: &str| {
        let _ = writeln!(text, "{content}");
    };
    line("<?xml version=\"1.0\" encoding=\"UTF-8\"?>");
    line(&format!(
        "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{}\" instantiationToken=\"{token}\" generationTool=\"Leafwise {}\">",
        escaped(name),
        env!("CARGO_PKG_VERSION")
    ));
    line(&format!(
        "  <CoSimulation modelIdentifier=\"{IDENTIFIER}\" canHandleVariableCommunicationStepSize=\"true\" fixedInternalStepSize=\"{step:?}\"/>"
    ));
    line(
        "  <LogCategories>\n    <Category name=\"logStatusError\" description=\"Why a call did nothing\"/>\n  </LogCategories>",
    );
    line(&format!(
        "  <DefaultExperiment startTime=\"0\" stopTime=\"{stop:?}\" stepSize=\"{step:?}\"/>"
    ));
    line("  <ModelVariables>");
    for (number, variable) in variables.iter().enumerate() {
        let kind = match variable.role {
            Role::Time => "causality=\"independent\" variability=\"continuous\"",
            Role::Parameter(_) => "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"",
            Role::Coordinate(_) => {
                "causality=\"output\" variability=\"continuous\" initial=\"exact\""
            }
            Role::Invariant(_) => {
                "causality=\"output\" variability=\"continuous\" initial=\"calculated\""
            }
        };
        let start = variable.start;
        let start = start.map_or_else(String::new, |start| format!(" start=\"{start:?}\""));
        let name = escaped(&variable.name);
        line(&format!(
            "    <Float64 name=\"{name}\" valueReference=\"{number}\" {kind}{start}/>"
        ));
    }
    line("  </ModelVariables>\n  <ModelStructure>");
    let numbered = || variables.iter().enumerate();
    for (number, variable) in numbered() {
        if matches!(variable.role, Role::Coordinate(_) | Role::Invariant(_)) {
            line(&format!("    <Output valueReference=\"{number}\"/>"));
        }
    }
    for (number, variable) in numbered() {
        if matches!(variable.role, Role::Invariant(_)) {
            line(&format!(
                "    <InitialUnknown valueReference=\"{number}\"/>"
            ));
        }
    }
    line("  </ModelStructure>\n</fmiModelDescription>");
    text
}

/// A text within an attribute.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            _ => out.push(letter),
        }
    }
    out
}
