//! Ensembles from the command line.

#[cfg(target_os = "linux")]
use crate::support::refusing_threads;
use crate::support::{BODY, Place};

const ENSEMBLE: &str = "[ensemble]\nmembers = 30\ninitial = { ball = 0.1 }\n\
    record = { every = 20, quantiles = [0.5] }\nfinal-states = \"csv\"\n";

fn with(ensemble: &str) -> Place {
    Place::with(&format!("{BODY}{ensemble}"))
}

#[test]
fn an_ensemble_prints_its_object_and_tables() {
    let here = with(ENSEMBLE);
    let said = here.leafwise(&["ensemble", "scene.toml", "--json", "--threads", "2"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    assert_eq!(json["outcome"], "done");
    assert_eq!((&json["members"], &json["failed"]), (&30.into(), &0.into()));
    let times: Vec<_> = json["statistics"]
        .as_array()
        .expect("a list")
        .iter()
        .collect();
    assert_eq!(times.len(), 3);
    assert_eq!(times[2]["time"], 4.0);
    let energy = &times[2]["energy"];
    assert!(
        energy["variance"].as_f64().is_some_and(|v| v > 0.0),
        "{energy}"
    );
    assert_eq!(energy["rank_error"], 0.0);
    assert_eq!(json["run_directory"], "runs/scene-ensemble");
    said.says(&[
        "30 members to t = 4",
        "at the end",
        "50%",
        "drift",
        "members a second",
    ]);
    for file in [
        "scene.toml",
        "manifest.json",
        "statistics.csv",
        "windows.csv",
        "report.html",
    ] {
        assert!(
            here.path("runs/scene-ensemble").join(file).exists(),
            "{file}"
        );
    }
    let again = here.leafwise(&["ensemble", "scene.toml", "--json"]);
    assert_eq!(again.code, Some(0), "{}", again.err);
    again.says(&["was already complete", "at the end", "50%"]);
    assert_eq!(again.json(), json);
    let other = here.leafwise(&["run", "scene.toml", "--out", "runs/scene-ensemble"]);
    assert_eq!(other.code, Some(2));
    other.says(&["runs/scene-ensemble holds an ensemble"]);
}

#[test]
fn a_member_runs_alone_as_an_ordinary_run() {
    let here = with(ENSEMBLE);
    let said = here.leafwise(&["ensemble", "scene.toml", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let said = here.leafwise(&["ensemble", "scene.toml", "--member", "17", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    assert_eq!(json["run_directory"], "runs/scene-member-17");
    let state: Vec<String> = json["final_state"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|x| format!("{:?}", x.as_f64().expect("a number")))
        .collect();
    let states = here.read("runs/scene-ensemble/final_states.csv");
    let row = states.lines().nth(18).expect("a row");
    assert!(
        row.starts_with(&format!("17,done,{},", state.join(","))),
        "{row}"
    );
    // The scene it leaves behind is a scene of its own.
    let text = here.read("runs/scene-member-17/scene.toml");
    assert!(!text.contains("[ensemble]"), "{text}");
    let absent = here.leafwise(&["ensemble", "scene.toml", "--member", "30"]);
    assert_eq!(absent.code, Some(2));
    absent.says(&["there is no member 30: they are 0 to 29"]);
}

/// All members step by one method: what it chose at the scene's own parameters, the pieces of a splitting
/// and multiples of Casimirs, a member alone keeps.
#[test]
fn a_member_alone_has_the_ensembles_method_whatever_its_parameters() {
    let scene = |method: &str| {
        let (before, rest) = BODY.split_once("[method]").expect("a method");
        let (_, after) = rest.split_once("[run]").expect("a run");
        format!(
            "{before}[method]\n{method}\ntime-step = 0.1\n[run]{after}[ensemble]\n\
             parameters = {{ I2 = {{ range = [0.5, 1.5, 5] }}, I3 = {{ uniform = [0.6, 2] }} }}\n\
             final-states = \"csv\"\n"
        )
    };
    for method in [
        "stepper = \"splitting\"",
        "stepper = \"splitting\"\ncomposition = \"suzuki-4\"",
        "realization = \"lie-poisson\"\n\
         dynamics = { name = \"hamilton-jacobi\", order = 4, hamiltonian = \"energy-casimir\" }",
    ] {
        let here = Place::with(&scene(method));
        let said = here.leafwise(&["ensemble", "scene.toml", "--quiet"]);
        assert_eq!(said.code, Some(0), "{method}: {}", said.err);
        let states = here.read("runs/scene-ensemble/final_states.csv");
        for member in 0..5 {
            let number = member.to_string();
            let said = here.leafwise(&["ensemble", "scene.toml", "--member", &number, "--json"]);
            assert_eq!(said.code, Some(0), "{method}: {}", said.err);
            let json = said.json();
            let state: Vec<String> = json["final_state"]
                .as_array()
                .expect("a list")
                .iter()
                .map(|x| format!("{:?}", x.as_f64().expect("a number")))
                .collect();
            let row = states.lines().nth(member + 1).expect("a row");
            // Behind the number and the outcome stand the parameters that differ.
            let cells: Vec<&str> = row.split(',').collect();
            assert_eq!(cells[..2], [number.as_str(), "done"], "{row}");
            assert_eq!(cells[4..7], state[..], "{method}, member {number}: {row}");
            // The scene that it leaves behind is that of the same motion.
            let file = format!("runs/scene-member-{number}/scene.toml");
            let again =
                here.leafwise(&["run", &file, "--out", &format!("again{number}"), "--json"]);
            assert_eq!(again.json()["final_state"], json["final_state"], "{method}");
        }
    }
}

#[test]
fn what_is_wrong_with_the_table_is_underlined() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["ensemble", "scene.toml"]);
    assert_eq!(said.code, Some(3));
    said.says(&["the scene has no [ensemble] table", "for example"]);
    let here = with("[ensemble]\nmembers = 30\ninitial = { bal = 0.1 }\n");
    let said = here.leafwise(&["ensemble", "scene.toml"]);
    assert_eq!(said.code, Some(3));
    said.says(&[
        "unknown key `bal` in initial",
        "did you mean `ball`?",
        "initial = { bal = 0.1 }",
    ]);
}

#[test]
fn a_table_of_states_is_read_by_name_and_refused_with_the_row_or_column_that_is_wrong() {
    let here = with("[ensemble]\ninitial = { file = \"states.csv\" }\n");
    let run = |table: &str| {
        here.write("states.csv", table);
        here.leafwise(&["ensemble", "scene.toml", "--json", "--force", "--quiet"])
    };
    for (table, piece) in [
        ("", "it has no row"),
        ("x1,x2,x3\n", "it has no row"),
        ("x1,x2,x3\n1,2,3\n1,2\n", "row 2 has 2 numbers"),
        ("x1,x2,x3\n1,2,3\n1,nan,3\n", "row 2 holds NaN"),
        ("x1,x2,x3\n1,2,inf\n", "row 1 holds inf"),
        ("x1,x2,x3\n1,2,1e999\n", "row 1 holds inf"),
        ("x1,x2,x3\n1,2,a\n", "line 2 is not a row of numbers"),
        ("x1,x2,x3\n1,,2,3\n", "line 2 has an empty cell in column 2"),
        (
            "x1,x2,x3\n,4,5\n6,7,8\n",
            "line 2 has an empty cell in column 1",
        ),
        (
            "x1,x2,x4\n1,2,3\n",
            "column `x4` is neither one of the coordinates x1, x2, x3",
        ),
        ("x1,x2\n1,2\n", "no column `x3`"),
        ("x1,x2,x2\n1,2,3\n", "two columns `x2`"),
        ("x1,x2,x3,I4\n1,2,3,0.7\n", "column `I4` is neither"),
    ] {
        let said = run(table);
        assert_eq!(said.code, Some(3), "{table}: {}", said.err);
        said.says(&["states.csv", piece]);
    }
    std::fs::remove_file(here.path("states.csv")).expect("a file");
    let said = here.leafwise(&["ensemble", "scene.toml"]);
    assert_eq!(said.code, Some(3));
    said.says(&["cannot read states.csv"]);
    // The order of the columns is the file's.
    let of_order = |table: &str| {
        let said = run(table);
        assert_eq!(said.code, Some(0), "{}", said.err);
        said.json()["statistics"].clone()
    };
    assert_eq!(of_order("x3,x1,x2\n3,1,2\n"), of_order("x1,x2,x3\n1,2,3\n"));
    assert_ne!(of_order("x3,x1,x2\n3,1,2\n"), of_order("3,1,2\n"));
}

/// The method of an ensemble is judged at its members' states.
#[test]
fn an_ensemble_is_warned_as_a_run_is() {
    let here = with(ENSEMBLE);
    let warned = |method: &[&str], out: &str| {
        let command = ["ensemble", "scene.toml", "--json", "--out", out];
        let said = here.leafwise(&[&command[..], method].concat());
        assert_eq!(said.code, Some(0), "{}", said.err);
        let kinds = said.json()["warnings"].as_array().expect("a list").clone();
        let kinds: Vec<String> = kinds
            .iter()
            .filter_map(|one| Some(one["kind"].as_str()?.to_owned()))
            .collect();
        assert_eq!(
            said.err.matches("warning").count(),
            kinds.len(),
            "{}",
            said.err
        );
        kinds
    };
    let long = [
        "--set",
        "method.realization.order=14",
        "--set",
        "method.time-step=0.01",
    ];
    assert_eq!(warned(&long, "long"), ["truncation-order"]);
    let good = ["--set", "method.realization=auto"];
    assert_eq!(warned(&good, "good"), Vec::<String>::new());
    // At the members' states, which are not the scene's: there the chart is nearly used up.
    here.write(
        "scene.toml",
        &format!("{BODY}[ensemble]\ninitial = {{ file = \"states.csv\" }}\n").replace(
            "{ name = \"karasev-truncated\", order = 4 }",
            "\"so3-exponential\"",
        ),
    );
    // A spin about the axis of the largest inertia, I3 = 1.25: it turns by 0.83 of 2π a step.
    here.write("states.csv", "0,0,5\n");
    let step = ["--set", "method.time-step=1.3"];
    let kinds = warned(&step, "large");
    assert!(kinds.contains(&"chart".to_owned()), "{kinds:?}");
}

#[test]
fn members_that_are_not_there_are_refused() {
    let here = with(ENSEMBLE);
    let refused = |arguments: &[&str], code: i32, piece: &str| {
        let said = here.leafwise(&[&["ensemble", "scene.toml"][..], arguments].concat());
        assert_eq!(said.code, Some(code), "{arguments:?}: {}", said.err);
        said.says(&[piece]);
    };
    refused(
        &["--member", "30"],
        2,
        "there is no member 30: they are 0 to 29",
    );
    for member in ["-1", "1.5", "nan", "99999999999999999999"] {
        refused(&["--member", member], 2, "--member");
    }
    for count in ["0", "-3", "1.5", "nan", "1e30"] {
        refused(
            &["--set", &format!("ensemble.members={count}")],
            3,
            "must be a whole number",
        );
    }
    refused(&["--threads", "0"], 2, "--threads");
    refused(&["--lanes", "0"], 2, "--lanes");
    assert!(here.is_untouched());
}

/// Where the system grants fewer threads than are asked for, or none, members are stepped on those.
#[cfg(target_os = "linux")]
#[test]
fn threads_that_are_not_granted_are_done_without() {
    let here = with(ENSEMBLE);
    let all = here.leafwise(&["ensemble", "scene.toml", "--json", "--threads", "2"]);
    assert_eq!(all.code, Some(0), "{}", all.err);
    let refusing = refusing_threads(&here);
    for arguments in [
        &[
            "ensemble",
            "scene.toml",
            "--json",
            "--out",
            "one",
            "--threads",
            "1",
        ][..],
        &[
            "ensemble",
            "scene.toml",
            "--json",
            "--out",
            "many",
            "--threads",
            "100000",
        ],
        &["run", "scene.toml", "--json"],
    ] {
        let output = here
            .command(arguments)
            .env("LD_PRELOAD", &refusing)
            .output();
        let said = crate::support::Said::from(output.expect("the program starts"));
        assert_eq!(said.code, Some(0), "{arguments:?}: {}", said.err);
        said.says(&["Ctrl-C will not write a checkpoint"]);
        if arguments[0] == "ensemble" {
            assert_eq!(said.json()["statistics"], all.json()["statistics"]);
        }
    }
    let many = [
        "ensemble",
        "scene.toml",
        "--out",
        "more",
        "--threads",
        "100000",
    ];
    let said = here.leafwise(&many);
    assert_eq!(said.code, Some(0), "{}", said.err);
}

/// What never ends is refused before memory does.
#[cfg(target_os = "linux")]
#[test]
fn an_endless_scene_or_file_of_states_is_refused() {
    let here = with("[ensemble]\ninitial = { file = \"/dev/zero\" }\n");
    let said = here.leafwise(&["ensemble", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["cannot read /dev/zero", "a byte 0"]);
    let said = here.leafwise(&["run", "/dev/zero"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&["cannot read /dev/zero", "larger than 64 MiB"]);
}

/// On lattices that are stepped by templates: each member as it runs alone, its energy at its own parameters, and the way onto a
/// leaf refused.
#[test]
fn members_of_an_ensemble_of_lattices_run_alone_as_ordinary_runs() {
    for lengths in ["16", "[4, 5]"] {
        let (here, next, sums) = match lengths {
            "16" => ("i", "i+1", "i"),
            _ => ("i,j", "i,j+1", "i, j"),
        };
        let first = if lengths == "16" { "q[0]" } else { "q[0,0]" };
        let scene = format!(
            "[system]\nfamilies = {{ q = {lengths}, p = {lengths} }}\nparameters = {{ a = 1 }}\n\
             bracket = {{ \"q[{here}],p[{here}]\" = \"-1\" }}\n\
             hamiltonian = \"a + sum({sums}, p[{here}]^2/2 + a*(q[{next}] - q[{here}])^2/2)\"\n\
             [method]\nstepper = \"splitting\"\ntime-step = 0.1\n[run]\nsteps = 20\n\
             initial = {{ \"q[{here}]\" = \"i\", \"p[{here}]\" = \"0\" }}\n[ensemble]\nmembers = 5\nseed = 3\n\
             initial = {{ ball = 0.1 }}\nparameters = {{ a = {{ uniform = [0.5, 2.0] }} }}\nfinal-states = \"csv\"\n\
             record = {{ every = 5, observables = [\"energy\", \"{first}\", \"sum({sums}, q[{here}]^2)\"] }}\n"
        );
        let place = Place::with(&scene);
        let said = place.leafwise(&["ensemble", "scene.toml", "--quiet"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let states = place.read("runs/scene-ensemble/final_states.csv");
        for member in [0, 4] {
            let number = member.to_string();
            let said = place.leafwise(&["ensemble", "scene.toml", "--member", &number, "--json"]);
            assert_eq!(said.code, Some(0), "{}", said.err);
            let json = said.json();
            let state = json["final_state"].as_array().expect("a list").iter();
            let state: Vec<f64> = state.map(|x| x.as_f64().expect("a number")).collect();
            let row = states.lines().nth(1 + member).expect("a row");
            let row: Vec<&str> = row.split(',').collect();
            assert_eq!(row[..2], [number.as_str(), "done"]);
            let numbers: Vec<f64> = row[2..]
                .iter()
                .map(|x| x.parse().expect("a number"))
                .collect();
            let (a, behind) = (numbers[0], &numbers[1..]);
            assert_eq!(behind[..state.len()], state[..], "member {member}");
            // The energy, by the parameter of the member.
            let (q, p) = state.split_at(state.len() / 2);
            let columns = if lengths == "16" { 16 } else { 5 };
            let next = |site: usize| site / columns * columns + (site + 1) % columns;
            let bonds: f64 = (0..q.len())
                .map(|i| a * (q[next(i)] - q[i]) * (q[next(i)] - q[i]) / 2.0)
                .sum();
            let energy = a + bonds + p.iter().map(|p| p * p / 2.0).sum::<f64>();
            let found = behind[state.len()];
            assert!((found - energy).abs() < 1e-12 * energy, "{found} {energy}");
            assert_eq!(behind[state.len() + 1], q[0]);
        }
    }
    let on_leaf = "[system]\nfamilies = { s = { components = [\"x\", \"y\", \"z\"], length = 16 } }\n\
                   bracket = { lie-algebra = \"so3\" }\nhamiltonian = \"sum(i, s.x[i]*s.x[i+1])\"\n\
                   casimirs = { lengths = \"sum(i, s.x[i]^2 + s.y[i]^2 + s.z[i]^2)\" }\n\
                   [method]\nstepper = \"splitting\"\ntime-step = 0.1\n[run]\nsteps = 1\n\
                   initial = { \"s.x[i]\" = 1, \"s.y[i]\" = 0, \"s.z[i]\" = 0 }\n[ensemble]\nmembers = 2\ninitial = { leaf = 0.1 }\n";
    let said = Place::with(on_leaf).leafwise(&["ensemble", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["every site has a separate leaf", "draw from a ball"]);
}

#[test]
fn quantiles_are_drawn() {
    let members = "[ensemble]\nmembers = 20\ninitial = { ball = 0.1 }\n\
                   record = { every = 4, observables = [\"x1\"], quantiles = [0.05, 0.95] }\n";
    let here = with(members);
    assert_eq!(
        here.leafwise(&["ensemble", "scene.toml", "--quiet"]).code,
        Some(0)
    );
    let page = here.read("runs/scene-ensemble/report.html");
    assert!(page.contains("Thin lines, from below: the quantiles 5%, 95%."));
}

/// Of more members than a sketch keeps whole, each output tells how far a quantile's rank may be off.
#[test]
fn errors_of_ranks_stand_beside_quantiles() {
    let here = Place::with(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\n\
         hamiltonian = \"p^2/2\"\n[method]\nstepper = \"splitting\"\ntime-step = 0.1\n\
         [run]\ninitial = [1, 0]\nsteps = 1\n[ensemble]\nmembers = 20000\ninitial = { normal = 1.0 }\n\
         record = { every = 1, observables = [\"q\"], quantiles = [0.001, 0.5] }\nfinal-states = \"csv\"\n",
    );
    let said = here.leafwise(&["ensemble", "scene.toml", "--out", "out", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let told = said.json()["statistics"][1]["q"].clone();
    let errors = ["0.001", "0.5"].map(|p| told["rank_errors"][p].as_f64().expect("an error"));
    assert!(
        errors[0] < 5e-4 && errors[1] < 3e-3 && errors[1] > 0.0,
        "{errors:?}"
    );
    assert_eq!(told["rank_error"], errors[1]);
    let table = here.read("out/statistics.csv");
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows[0].ends_with(",q0.001,q0.5,q0.001_rank_error,q0.5_rank_error"));
    let cells: Vec<f64> = rows[2]
        .split(',')
        .filter_map(|cell| cell.parse().ok())
        .collect();
    let [.., low, median, of_low, of_median] = cells[..] else {
        panic!("{cells:?}");
    };
    assert_eq!([of_low, of_median], errors);
    // Against the members themselves.
    let states = here.read("out/final_states.csv");
    let mut rows = states.lines().map(|line| line.split(','));
    let column = rows.next().expect("headings").position(|name| name == "q");
    let column = column.expect("the coordinate");
    let mut members: Vec<f64> = rows
        .map(|mut row| row.nth(column).expect("a cell").parse().expect("q"))
        .collect();
    members.sort_by(f64::total_cmp);
    for (p, value, error) in [(0.001, low, of_low), (0.5, median, of_median)] {
        let rank = members.partition_point(|member| *member <= value) as f64 / 20_000.0;
        assert!(
            (rank - p).abs() <= error + f64::EPSILON,
            "{p} {rank} {error}"
        );
    }
    said.says(&["ranks", "0.1 ± ", "50 ± "]);
    assert!(
        here.read("out/report.html")
            .contains("of a sketch, their ranks 0.1 ± ")
    );
}

#[test]
fn rows_of_states_beyond_the_members_are_told() {
    let here = with("[ensemble]\nmembers = 2\ninitial = { file = \"states.csv\" }\n");
    here.write("states.csv", "1,3,3\n1,2,3\n1,1,3\n");
    let said = here.leafwise(&["ensemble", "scene.toml", "--out", "out", "--json"]);
    assert_eq!(said.json()["warnings"][0]["kind"], "unused-states");
    said.says(&[
        "1 row of states are given beyond those of the 2 members",
        "no `members`",
    ]);
    let all = here.leafwise(&[
        "ensemble",
        "scene.toml",
        "--out",
        "all",
        "--json",
        "--set",
        "ensemble.members=3",
    ]);
    let warnings = all.json()["warnings"].clone();
    assert!(
        warnings
            .as_array()
            .is_some_and(|all| all.iter().all(|one| one["kind"] != "unused-states"))
    );
}

#[test]
fn shards_that_are_not_there_are_told_as_such() {
    let here = with("[ensemble]\nmembers = 2\ninitial = { ball = 0.1 }\n");
    let said = here.leafwise(&["merge", "nothing", "--out", "out"]);
    assert_eq!(said.code, Some(1));
    said.says(&["cannot read nothing"]);
    let said = here.leafwise(&["ensemble", "scene.toml", "--shard", "1/0"]);
    assert_eq!(said.code, Some(2));
    said.says(&["there is no shard 1 of 0: there is at least one"]);
}

/// A spin of 4000 leaves the chart in its first step.
#[test]
fn members_that_fail_are_told_by_the_exit_code() {
    let file = "[ensemble]\ninitial = { file = \"states.csv\" }\n";
    let here = with(file);
    here.write("states.csv", "1,3,3\n1000,3000,3000\n1,2,3\n");
    let of = |here: &Place, arguments: &[&str]| {
        here.leafwise(&[&["ensemble", "scene.toml"][..], arguments].concat())
    };
    let said = of(&here, &["--out", "out", "--json"]);
    assert_eq!(said.code, Some(6), "{}", said.err);
    said.says(&["3 members, 1 of them failed, to t = 4", "member 1, step 1"]);
    assert_eq!(said.json()["failed"], 1);
    for column in ["energy", "spin"] {
        assert_eq!(said.json()["statistics"][0][column]["count"], 2);
    }
    // Told without a summary too, and of an ensemble that is there already.
    let again = of(&here, &["--out", "out", "--quiet"]);
    assert_eq!(again.code, Some(6), "{}", again.err);
    again.says(&["1 of 3 members failed"]);
    // A shard has made what it was asked for; the whole tells.
    let shard = of(&here, &["--out", "parts", "--shard", "1/1"]);
    assert_eq!(shard.code, Some(0), "{}", shard.err);
    let merged = here.leafwise(&["merge", "parts", "--out", "whole", "--scene", "scene.toml"]);
    assert_eq!(merged.code, Some(6), "{}", merged.err);
    let here = with(file);
    here.write("states.csv", "1000,3000,3000\n2000,3000,3000\n");
    assert_eq!(of(&here, &["--out", "out"]).code, Some(1));
}

/// What fails at a member's start is the member's failure, which is counted; it is no step that a run took.
#[test]
fn a_member_that_fails_is_no_warning_of_the_method() {
    let here = with("[ensemble]\ninitial = { file = \"states.csv\" }\n");
    here.write("states.csv", "1,3,3\n1000,3000,3000\n1,2,3\n");
    let said = here.leafwise(&["ensemble", "scene.toml", "--json"]);
    assert!(!said.err.contains("when it is repeated"), "{}", said.err);
}
