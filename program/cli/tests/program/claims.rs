//! `reproduce` and `stress`: what they print, write and refuse.

use crate::support::Place;

#[test]
fn a_figure_of_the_paper_is_written_with_its_numbers() {
    let here = Place::new();
    let said = here.leafwise(&["reproduce", "9", "so3-realization-4", "--out", "figures"]);
    assert_eq!(said.code, Some(0), "{}{}", said.out, said.err);
    for piece in [
        "Figure 9, section 5.3",
        "Figure 2, section 5.1",
        "approximately 4.9",
        "differs",
        "agrees",
    ] {
        assert!(said.out.contains(piece), "{piece}: {}", said.out);
    }
    let object: serde_json::Value =
        serde_json::from_str(&here.read("figures/reproduce.json")).expect("an object");
    assert_eq!(object["outcome"], "met");
    let measured = &object["figures"][1]["findings"][0]["measured"];
    let slope = measured["value"].as_f64().expect("a number");
    assert!((slope - 6.0).abs() < 0.1, "{slope}");
    let csv = here.read("figures/figure-9-1.csv");
    assert!(csv.starts_with("series,epsilon,error\n"), "{csv}");
    assert!(here.read("figures/figure-9-1.svg").contains("<svg"));
    let page = here.read("figures/reproduce.html");
    assert!(page.contains("n + 2 = 6") && page.ends_with("</html>\n"));
}

#[test]
fn a_figure_the_paper_does_not_have_is_refused() {
    let here = Place::new();
    let said = here.leafwise(&["reproduce", "10", "--json"]);
    assert_eq!(said.code, Some(2));
    said.says(&["no figure `10`", "1 to 9", "magnetic-realization"]);
    assert_eq!(said.json()["outcome"], "refused");
    for name in ["0", "", "rigid", "9.5", "nan"] {
        let said = here.leafwise(&["reproduce", "9", name]);
        assert_eq!((said.code, said.out.as_str()), (Some(2), ""), "{name}");
        said.says(&[&format!("no figure `{name}`")]);
    }
    // Nothing is measured for a directory that cannot be made.
    here.write("figures", "a file");
    let said = here.leafwise(&["reproduce", "9", "--out", "figures"]);
    assert_eq!((said.code, said.out.as_str()), (Some(1), ""));
    said.says(&["cannot write figures"]);
    assert_eq!(here.read("figures"), "a file");
}

#[test]
fn a_figure_that_is_named_twice_is_measured_once() {
    let here = Place::new();
    let names = ["reproduce", "9", "magnetic-realization", "9", "--json"];
    let said = here.leafwise(&names);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert_eq!(said.json()["figures"].as_array().map(Vec::len), Some(1));
}

#[test]
fn a_family_of_extremes_is_run_row_by_row() {
    let here = Place::new();
    let said = here.leafwise(&["stress", "trivial", "dimensions/two"]);
    assert_eq!(said.code, Some(0), "{}", said.out);
    for piece in [
        "ok    trivial/zero-tensor",
        "dimensions/two",
        "expected",
        "measured",
        "3 cases met",
    ] {
        assert!(said.out.contains(piece), "{piece}: {}", said.out);
    }
    let object = here.leafwise(&["stress", "trivial", "--json"]).json();
    assert_eq!(object["outcome"], "met");
    assert_eq!(object["cases"].as_array().map(Vec::len), Some(2));
}

#[test]
fn extremes_are_listed_and_unknown_ones_refused() {
    let here = Place::new();
    let said = here.leafwise(&["stress", "--list"]);
    assert_eq!(said.code, Some(0));
    assert!(said.out.contains("scene-fields/keys"), "{}", said.out);
    for name in ["nothing", "", "trivial/", "trivial/nothing", "nan"] {
        // Before any case is run.
        let said = here.leafwise(&["stress", "trivial", name]);
        assert_eq!((said.code, said.out.as_str()), (Some(2), ""), "{name}");
        said.says(&[&format!("no case is called `{name}`"), "scene-fields"]);
    }
    let listed = here
        .leafwise(&["stress", "trivial", "--list", "--json"])
        .json();
    assert_eq!(listed["cases"].as_array().map(Vec::len), Some(2));
}

#[test]
fn figures_are_listed_and_have_a_number_and_a_name() {
    let here = Place::new();
    let said = here.leafwise(&["reproduce", "--list", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert_eq!(said.json()["figures"].as_array().map(Vec::len), Some(9));
    for name in ["1", "figure-1", "so3-realization-10"] {
        let said = here.leafwise(&["reproduce", name, "--list"]);
        assert!(
            said.out.starts_with("1  so3-realization-10"),
            "{}",
            said.out
        );
    }
}
