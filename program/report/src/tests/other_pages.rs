//! Pages of ensembles, comparisons, reproductions and surveys.

use super::assert_well_formed;
use crate::*;

const HOSTILE: &str = "<b>\"x\" & 'y'</b>";

fn hostile(texts: usize) -> Vec<(String, String)> {
    vec![(HOSTILE.to_owned(), HOSTILE.to_owned()); texts]
}

/// Every other page, with and without what a page may lack, each text hostile.
fn other_pages() -> Vec<String> {
    let text = || HOSTILE.to_owned();
    let band = Band {
        name: text(),
        times: vec![0.0, 1.0],
        means: vec![0.5, 0.25],
        confidences: vec![0.01, 0.02],
        deviations: vec![0.1, 0.2],
        ranges: vec![(0.0, 1.0); 2],
        quantiles: vec![vec![0.5]; 2],
    };
    let ensemble = EnsembleData {
        title: text(),
        scene_text: text(),
        advice: hostile(1),
        facts: hostile(2),
        parts: vec![0.25],
        ranks: Some(text()),
        bands: vec![band.clone(), Band::new("never"), band],
        drifts: vec![InvariantSeries {
            name: text(),
            reference: 1.0,
            times: vec![1.0, 2.0],
            deviations: vec![1e-3, 2e-3],
        }],
        drift_every: 2,
        failures: hostile(1),
        ..EnsembleData::default()
    };
    let comparison = ComparisonData {
        title: text(),
        scene_name: text(),
        scene_text: text(),
        version: text(),
        command: text(),
        facts: hostile(1),
        families: vec![text(), text()],
        curves: vec![
            Curve {
                name: text(),
                family: 1,
                number: Some(1),
            },
            Curve {
                name: text(),
                family: 0,
                number: None,
            },
        ],
        plots: vec![
            Plot {
                title: text(),
                caption: text(),
                cost: text(),
                error: text(),
                points: vec![Vec::new(), Vec::new()],
                floor: None,
                is_wide: true,
            };
            2
        ],
        headings: vec![text(), text()],
        numbers_from: 1,
        rows: vec![vec![text(), text()]],
        reading: text(),
        failures: hostile(1),
    };
    let compared = Compared {
        quantity: text(),
        printed: text(),
        measured: text(),
        verdict: text(),
        is_good: false,
        explanation: text(),
    };
    let panel = Panel {
        title: text(),
        caption: text(),
        x: PanelAxis::linear("x"),
        y: PanelAxis::linear("y"),
        series: Vec::new(),
    };
    let reproduction = ReproductionData {
        title: text(),
        source: text(),
        version: text(),
        command: text(),
        introduction: vec![text()],
        figures: vec![ReproducedFigure {
            label: text(),
            title: text(),
            setting: text(),
            panels: vec![panel.clone(), panel.clone(), panel],
            comparisons: vec![compared],
            scene: Some(text()),
        }],
    };
    let line = |order: usize| ErrorLine {
        map: text(),
        order,
        points: vec![(0.1, 1e-9), (0.2, 1e-7), (0.4, f64::NAN), (0.8, 0.0)],
    };
    let row = SurveyedMap {
        cells: vec![text(); 2],
        is_met: false,
    };
    let problem = |lines: Vec<ErrorLine>| SurveyedProblem {
        name: text(),
        lines,
        rows: vec![row.clone()],
    };
    let survey = SurveyData {
        title: text(),
        version: text(),
        headings: vec![text(); 2],
        problems: vec![
            problem(vec![line(0), line(5), line(20)]),
            problem(Vec::new()),
        ],
        refused: vec![RefusedParts {
            name: text(),
            causes: hostile(2),
        }],
    };
    vec![
        render_ensemble(&ensemble).expect("an ensemble"),
        render_ensemble(&EnsembleData::default()).expect("an empty ensemble"),
        render_comparison(&comparison).expect("a comparison"),
        render_reproduction(&reproduction).expect("a reproduction"),
        render_survey(&survey).expect("a survey"),
    ]
}

#[test]
fn every_page_is_well_formed_and_escapes_every_text() {
    for html in other_pages() {
        assert_well_formed(&html);
        assert!(!html.contains(HOSTILE), "{html}");
        assert!(html.starts_with("<!DOCTYPE html>") && html.ends_with("</html>\n"));
    }
}

#[test]
fn a_survey_draws_a_line_a_map_in_the_colour_of_its_order() {
    let html = other_pages().pop().expect("the survey");
    for class in ["plain", "s1", "s4"] {
        // Three errors are finite; the smallest is drawn at round-off, the frame's lower edge.
        let line = format!("344.0\" class=\"{class}\"");
        assert!(html.contains(&line), "{html}");
    }
    assert_eq!(html.matches("<polyline").count(), 3);
    assert_eq!(html.matches("<svg").count(), 1);
    assert_eq!(html.matches("class=\"fails\"").count(), 2);
}
