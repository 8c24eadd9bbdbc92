//! Ensembles and comparisons of paced scenes, at one time.

use crate::support::Place;
use crate::time::PACED;

/// Problem D5 of Enright and Pryce, with their end.
#[test]
fn methods_are_compared_at_one_time_whatever_their_steps_are() {
    let scene = PACED
        .replace("[0.5, 0, 0, 1.7]", "[0.1, 0, 0, 4.358898943540674]")
        .replace("until   = 6", "until   = 20");
    let here = Place::with(&scene);
    let only = "auto+hamilton-jacobi:4,rk4";
    for at_end in [&[][..], &["--at-end"]] {
        let asked = [
            &[
                "compare",
                "scene.toml",
                "--steps",
                "800,1600",
                "--only",
                only,
                "--json",
            ],
            at_end,
        ]
        .concat();
        let told = here.leafwise(&asked).json();
        assert_eq!(told["time"], 20.0);
        let end = [
            -1.295266250987574,
            0.4003938963793321,
            -0.6775390924707566,
            -0.1270838154278686,
        ];
        for (at, expected) in end.into_iter().enumerate() {
            let found = told["reference"]["state"][at].as_f64().expect("a number");
            assert!((found - expected).abs() < 1e-12, "{at}: {found}");
        }
        let points = told["points"].as_array().expect("points");
        assert_eq!(points.len(), 4, "{points:?}");
        // Both methods are of order 4 in τ, and so at equal times.
        for pair in points.chunks(2) {
            let [coarse, fine] = [0, 1].map(|at| pair[at]["error"].as_f64().expect("an error"));
            let order = libm::log2(coarse / fine);
            assert!((order - 4.0).abs() < 0.3, "{order}: {pair:?}");
        }
    }
    let tuned = [
        "tune",
        "scene.toml",
        "--error",
        "1e-6",
        "--only",
        "auto+hamilton-jacobi:4",
        "--write",
    ];
    let said = here.leafwise(&tuned);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(said.out.contains("until       = 20"), "{}", said.out);
    let written = here.read("scene.toml");
    assert!(
        written.contains("until   = 20") && written.contains("pace "),
        "{written}"
    );
    assert!(!written.contains("steps"), "{written}");
    let told = here.leafwise(&["run", "scene.toml", "--json"]).json();
    assert_eq!(
        (&told["outcome"], &told["time"]),
        (&"done".into(), &20.0.into())
    );
}

#[test]
fn an_ensemble_with_a_pace_is_told_times() {
    let scene = format!(
        "{PACED}[ensemble]\nmembers = 3\ninitial = {{ ball = 0.01 }}\nrecord = {{ interval = 2 }}\n"
    );
    let here = Place::with(&scene);
    let told = here
        .leafwise(&["ensemble", "scene.toml", "--out", "run", "--json"])
        .json();
    assert_eq!(told["time"], 6.0);
    assert!(told.get("steps").is_none(), "{told}");
    let times: Vec<f64> = told["statistics"]
        .as_array()
        .expect("statistics")
        .iter()
        .filter_map(|at| at["time"].as_f64())
        .collect();
    assert_eq!(times, [0.0, 2.0, 4.0, 6.0]);
    assert!(
        here.read("run/report.html")
            .contains("its own, at the pace (q1^2 + q2^2)^0.75")
    );
    for (from, to, pieces) in [
        (
            "interval = 2",
            "every = 2",
            ["`every` has no meaning", "write an `interval` or `times`"],
        ),
        (
            "until   = 6\n",
            "steps = 6\n",
            ["come to different times", "write `until`"],
        ),
    ] {
        let here = Place::with(&scene.replacen(from, to, 1));
        let said = here.leafwise(&["ensemble", "scene.toml"]);
        assert_eq!(said.code, Some(3), "{}", said.err);
        said.says(&["scene.toml:5:13"]);
        said.says(&pieces);
    }
    // A member that would begin where the pace has no value fails alone.
    let here = Place::with(&scene.replace("(q1^2 + q2^2)^0.75", "sqrt(q1 - 0.4999)"));
    let told = here
        .leafwise(&["ensemble", "scene.toml", "--out", "run", "--json"])
        .json();
    let message = told["failures"][0]["message"].as_str().expect("a failure");
    assert!(message.contains("and must be positive"), "{message}");
}

/// Last state and drift of every member are those of its own run; one that cannot begin is told with its own initial state.
#[test]
fn a_paced_member_is_its_run_to_the_bit_and_one_without_a_beginning_keeps_its_state() {
    let here = Place::with(&format!(
        "{PACED}[ensemble]\ninitial = {{ file = \"states.csv\" }}\nfinal-states = \"csv\"\nrecord = {{ interval = 2 }}\n"
    ));
    here.write(
        "states.csv",
        "0.5,0,0,1.7\n0.45,0.1,0,1.8\n0,0,1,0\n0.55,-0.05,0.1,1.6\n",
    );
    here.leafwise(&["ensemble", "scene.toml", "--out", "all", "--quiet"]);
    let table = here.read("all/final_states.csv");
    let mut rows = table.lines();
    let headings: Vec<&str> = rows.next().expect("headings").split(',').collect();
    let place = |name: &str| {
        let found = headings.iter().position(|heading| *heading == name);
        found.unwrap_or_else(|| panic!("no {name} in {headings:?}"))
    };
    let rows: Vec<Vec<&str>> = rows.map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len(), 4);
    for row in &rows {
        let member = row[0];
        if member == "2" {
            assert_eq!(row[1], "failed");
            for names in [
                ["q1", "q2", "p1", "p2"],
                ["q1_initial", "q2_initial", "p1_initial", "p2_initial"],
            ] {
                assert_eq!(
                    names.map(|name| row[place(name)]),
                    ["0.0", "0.0", "1.0", "0.0"]
                );
            }
            continue;
        }
        let asked = [
            "ensemble",
            "scene.toml",
            "--member",
            member,
            "--out",
            member,
            "--json",
        ];
        let told = here.leafwise(&asked).json();
        let drift = told["drift"]["energy"].as_f64().expect("a drift");
        assert_eq!(
            row[place("energy_drift")],
            format!("{drift:?}"),
            "member {member}"
        );
        for (at, name) in ["q1", "q2", "p1", "p2"].into_iter().enumerate() {
            let last = told["final_state"][at].as_f64().expect("a number");
            assert_eq!(
                row[place(name)],
                format!("{last:?}"),
                "member {member}: {name}"
            );
        }
    }
    assert!(
        here.read("all/failures.csv")
            .lines()
            .nth(1)
            .is_some_and(|row| row.ends_with("0.0,0.0,1.0,0.0"))
    );
}
