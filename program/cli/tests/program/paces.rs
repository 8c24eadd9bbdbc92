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
