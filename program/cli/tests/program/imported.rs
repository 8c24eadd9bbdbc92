//! Equilibria of tokamaks: `leafwise import`.

use std::fs;

use crate::support::Place;

/// The g-file of the scenes.
fn solovev() -> String {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/tokamak/solovev.geqdsk"
    );
    fs::read_to_string(file).expect("the g-file of the scenes")
}

/// An import runs, one ion and many, and keeps the toroidal momentum to round-off.
#[test]
fn an_equilibrium_becomes_a_scene_that_runs() {
    let here = Place::new();
    here.write("shot.geqdsk", &solovev());
    let said = here.leafwise(&["import", "shot.geqdsk", "--members", "6", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    let axis = &json["safety_factors"][0];
    let q = axis["q"].as_f64().expect("a number");
    assert!((q - 1.2).abs() < 1e-6 && axis["s"] == 0.0, "{json}");
    assert_eq!(json["scene"], "shot/scene.toml");
    assert!(said.err.contains("leafwise ensemble shot/scene.toml"));

    let said = here.leafwise(&["run", "shot/scene.toml", "--out", "ion", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let samples = here.read("ion/samples.csv");
    let mut lines = samples.lines();
    let headings: Vec<&str> = lines.next().expect("headings").split(',').collect();
    let column = headings.iter().position(|name| *name == "momentum");
    let column = column.expect("the momentum");
    let momenta = lines.map(|line| line.split(',').nth(column).expect("a column"));
    let momenta: Vec<f64> = momenta
        .map(|text| text.parse().expect("a number"))
        .collect();
    let drift = momenta.iter().map(|p| (p / momenta[0] - 1.0).abs());
    // Two thousand steps, each of a few roundings.
    assert!(drift.fold(0.0, f64::max) < 1e-12);

    let said = here.leafwise(&["ensemble", "shot/scene.toml", "--set", "run.steps=50"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let said = here.leafwise(&["import", "shot.geqdsk"]);
    assert_eq!(said.code, Some(2));
    said.says(&["exists and is left as it is", "--out DIRECTORY"]);
    // A table of the user's stays too, and nothing is written beside it.
    fs::create_dir(here.path("mine")).expect("a folder");
    here.write("mine/psi.csv", "mine");
    let said = here.leafwise(&["import", "shot.geqdsk", "--out", "mine"]);
    assert_eq!(said.code, Some(2));
    assert_eq!(here.read("mine/psi.csv"), "mine");
    assert!(!here.path("mine/scene.toml").exists());
}

#[test]
fn files_that_are_none_are_refused_where_they_are_wrong() {
    let here = Place::new();
    let text = solovev();
    let cut: String = text.chars().take(9000).collect();
    let word = text.replacen(" 4.177856445E-01", " ***************", 1);
    let small = text.replacen(" 7.500000000E-01", " 9.500000000E-01", 1);
    for (text, message) in [
        ("a scene, not an equilibrium", "two whole numbers"),
        (&cut, "the file ends in the flux psi(R, Z)"),
        (&word, "line 3: `***************` is not a number"),
        (&small, "no extremum within three cells"),
    ] {
        here.write("shot.geqdsk", text);
        let said = here.leafwise(&["import", "shot.geqdsk"]);
        assert_eq!(said.code, Some(2), "{}", said.err);
        said.says(&[message, "shot.geqdsk"]);
    }
    here.write("shot.geqdsk", &text);
    for (options, message) in [
        (["--energy", "1e7"], "not relativistic"),
        (["--pitch", "-2"], "from -1 to 1"),
        (["--species", "muon"], "there are proton, deuteron"),
        (["--surface", "1"], "between the axis, 0, and the edge, 1"),
    ] {
        let said = here.leafwise(&["import", "shot.geqdsk", options[0], options[1]]);
        assert_eq!(said.code, Some(2), "{}", said.err);
        said.says(&[message]);
        assert!(!here.path("shot").exists(), "nothing is written");
    }
}

/// A stellarator as JSON: |B| = 2 − 0.3 √s cos θ + 0.2 s cos(2θ − 5ζ) on nine surfaces.
fn stellarator() -> serde_json::Value {
    let angle = |part: usize, of: usize| 2.0 * std::f64::consts::PI * part as f64 / of as f64;
    let s: Vec<f64> = (0..9).map(|k| f64::from(k) / 8.0).collect();
    let strength: Vec<Vec<Vec<f64>>> = (s.iter())
        .map(|s| {
            let row = |j: usize| {
                let at = |l: usize| {
                    let helical = libm::cos(2.0 * angle(j, 8) - angle(l, 6));
                    2.0 - 0.3 * libm::sqrt(*s) * libm::cos(angle(j, 8)) + 0.2 * s * helical
                };
                (0..6).map(at).collect()
            };
            (0..8).map(row).collect()
        })
        .collect();
    let iota: Vec<f64> = s.iter().map(|s| 0.6 + 0.2 * s).collect();
    serde_json::json!({
        "periods": 5, "psi": 0.4, "s": s, "iota": iota, "G": vec![3.2; 9], "B": strength
    })
}

/// A field in Boozer coordinates runs, one ion and many.
#[test]
fn a_field_in_boozer_coordinates_becomes_a_scene_that_runs() {
    let here = Place::new();
    here.write("field.json", &stellarator().to_string());
    let options = ["--nodes", "17", "--members", "3", "--json"];
    let said = here.leafwise(&[&["import", "field.json"], &options[..]].concat());
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    assert_eq!(json["nodes"], serde_json::json!([9, 8, 6]));
    assert_eq!(json["scene"], "field/scene.toml");
    assert!((json["field_on_axis"].as_f64().expect("a number") - 2.0).abs() < 1e-12);
    let said = here.leafwise(&["run", "field/scene.toml", "--set", "run.steps=20", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let moved = said.json()["drift"]["energy"].as_f64().expect("a number");
    let energy = said.json()["invariants"]["energy"]["initial"]
        .as_f64()
        .expect("a number");
    assert!(moved < 1e-6 * energy, "{moved} of {energy}");
    let said = here.leafwise(&["ensemble", "field/scene.toml", "--set", "run.steps=5"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
}

#[test]
fn fields_that_are_none_are_refused_with_what_is_wrong() {
    let here = Place::new();
    let with = |key: &str, value: serde_json::Value| {
        let mut field = stellarator();
        field[key] = value;
        field.to_string()
    };
    for (text, message) in [
        ("{}".to_owned(), "`B` is missing"),
        ("[1, 2]".to_owned(), "two whole numbers"),
        (
            with("currents", 1.into()),
            "`currents` is not part of a field",
        ),
        (
            with("periods", 5.5.into()),
            "`periods` is 5.5, and must be a whole number",
        ),
        (
            with("periods", (-5).into()),
            "`periods` is -5, and must be a whole number",
        ),
        (
            with("periods", u32::MAX.into()),
            "`periods` is 4294967295: a torus has 1 to 1000 field periods",
        ),
        (
            with("periods", "five".into()),
            "`periods` is the text \"five\", and must be a number",
        ),
        (
            with("psi", serde_json::Value::Null),
            "`psi` is null, and must be a number",
        ),
        (with("psi", 1e-300.into()), "`psi` is 1e-300 Wb/rad"),
        (
            with("G", serde_json::json!([3.2, null])),
            "`G[1]` is null, and must be a number",
        ),
        (
            with("s", 0.5.into()),
            "`s` is 0.5, and must be a list of numbers",
        ),
        (
            stellarator()
                .to_string()
                .replace("\"psi\":0.4", "\"psi\":NaN"),
            "JSON has no NaN",
        ),
        (
            stellarator()
                .to_string()
                .replace("\"psi\":0.4", "\"psi\":1e999"),
            "no JSON: number out of range",
        ),
        (
            with("B", serde_json::json!([[[1.0, 2.0], [1.0, "x"]]])),
            "`B[0][1][1]` is the text \"x\", and must be a number",
        ),
        (
            with("B", 1.into()),
            "`B` is 1, and must be lists of numbers",
        ),
        (with("B", "B.npy".into()), "B.npy"),
        (
            with("iota", vec![0.5; 8].into()),
            "`iota` has 8 numbers where `s` has 9 surfaces",
        ),
        (with("psi", 0.into()), "the toroidal flux at the edge"),
        (
            with("B", serde_json::json!([[[1.0], [1.0, 2.0]]])),
            "rows of different lengths",
        ),
    ] {
        here.write("field.json", &text);
        let said = here.leafwise(&["import", "field.json"]);
        assert_eq!(said.code, Some(2), "{}", said.err);
        said.says(&[message, "field.json"]);
        assert!(!here.path("field/scene.toml").exists());
    }
}

/// Whole numbers in any spelling are taken; what is left out, and where a table leaves the numbers, is told on both outputs.
#[test]
fn what_an_import_leaves_out_or_guesses_is_told() {
    let here = Place::new();
    let mut field = stellarator();
    field["periods"] = 5.0.into();
    for surface in field["B"].as_array_mut().expect("surfaces") {
        let rows = surface.as_array_mut().expect("rows");
        rows.push(rows[0].clone());
    }
    // A transform that rises within the last surfaces.
    let steep: Vec<f64> = (0..9)
        .map(|k| libm::exp(6.0 * (f64::from(k) / 8.0 - 1.0)))
        .collect();
    field["iota"] = steep.into();
    here.write("field.json", &field.to_string());
    let said = here.leafwise(&["import", "field.json", "--nodes", "17", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let told = [
        "the last node of theta is the end of a turn and repeats the first one: it is left out",
        "the table of iota has",
        "beyond the last surface, s = 1",
    ];
    said.says(&told);
    let json = said.json();
    assert_eq!(json["nodes"], serde_json::json!([9, 8, 6]));
    assert_eq!(json["warnings"].as_array().map(Vec::len), Some(2), "{json}");
}

/// ψ with noise of a hundredth of its range warns, with a number; that of the scenes does not.
#[test]
fn a_noisy_flux_is_told() {
    let here = Place::new();
    let text = solovev();
    here.write("shot.geqdsk", &text);
    let said = here.leafwise(&["import", "shot.geqdsk", "--json"]);
    assert_eq!(said.json()["warnings"], serde_json::json!([]));
    assert!(
        said.json()["roughness"]
            .as_f64()
            .is_some_and(|part| part < 1e-6)
    );
    // Every third number of ψ, away from the lines about the axis, a hundredth of its range larger.
    let (first, last) = (5 + 4 * 7, 5 + 4 * 7 + 33 * 33 / 5);
    let moved = |at: usize, line: &str| {
        let is_far = (first + 10..first + 70).contains(&at) || (last - 70..last - 10).contains(&at);
        if !is_far || !at.is_multiple_of(3) {
            return line.to_owned();
        }
        let (head, tail) = line.split_at(16);
        let number: f64 = head.trim().parse().expect("a number");
        format!("{:>16}{tail}", format!("{:.9E}", number + 4e-3))
    };
    let noisy: Vec<String> = (text.lines().enumerate())
        .map(|(at, line)| moved(at, line))
        .collect();
    here.write("noisy.geqdsk", &noisy.join("\n"));
    let said = here.leafwise(&["import", "noisy.geqdsk"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["psi of the file is noisy, or its grid coarse"]);
}
