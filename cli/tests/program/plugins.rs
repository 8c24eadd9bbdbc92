//! Plugins on the command line and in scenes.

#![cfg(unix)]

#[path = "../../../plugins/loader/tests/support/build.rs"]
mod build;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use build::{Workshop, rust_example};

use crate::support::{Place, Said, wait_for};

/// The program with folders of its own for its cache, and no plugins of this machine.
fn command(here: &Place, arguments: &[&str]) -> Command {
    let mut command = here.command(arguments);
    command
        .env("XDG_CACHE_HOME", here.path("cache"))
        .env("XDG_DATA_HOME", here.path("data"))
        .env_remove("LEAFWISE_PLUGIN_PATH")
        .env_remove("LEAFWISE_NO_PLUGINS");
    command
}

fn leafwise(here: &Place, arguments: &[&str]) -> Said {
    let output = command(here, arguments).output();
    Said::from(output.expect("the program starts"))
}

/// A scene with the plugins given, a system, a method and a start.
fn scene(plugins: &[&Path], system: &str, method: &str, initial: &str) -> String {
    let plugins: Vec<String> = plugins
        .iter()
        .map(|path| format!("{:?}", path.display().to_string()))
        .collect();
    format!(
        "plugins = [{}]\n[system]\n{system}\n[method]\n{method}\ntime-step = 0.05\n\
         [run]\ninitial = {initial}\nsteps = 200\n",
        plugins.join(", ")
    )
}

#[test]
fn a_system_by_formulas_has_all_that_a_library_system_has() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("formulas");
    let system = "library = \"formulas/pendulum\"\nparameters = { strength = 2.0 }";
    let method = "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 6 }";
    here.write("scene.toml", &scene(&[&library], system, method, "[1, 0]"));
    let said = leafwise(&here, &["run", "scene.toml", "--explain", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["S_5", "since the tensor is constant"]);
    // The same formulas in the scene itself, to the same bits.
    let inline = "variables = [\"q\", \"v\"]\nparameters = { strength = 2.0 }\n\
                  bracket = { \"q,v\" = \"-1\" }\n\
                  hamiltonian = \"v^2/2 - strength*cos(q)\"";
    here.write("inline.toml", &scene(&[], inline, method, "[1, 0]"));
    let own = leafwise(&here, &["run", "inline.toml", "--json"]);
    assert_eq!(own.json()["final_state"], said.json()["final_state"]);
    // Without its library, the name says where to look.
    here.write("without.toml", &scene(&[], system, method, "[1, 0]"));
    let without = leafwise(&here, &["check", "without.toml"]);
    assert_eq!(without.code, Some(3));
    without.says(&[
        "unknown library system `formulas/pendulum`",
        "a name with a `/` is that of a plugin's part",
        "plugins = [\"./libformulas.so\"]",
    ]);
    let wrong = leafwise(
        &here,
        &[
            "check",
            "scene.toml",
            "--set",
            "system.parameters.strenght=1",
        ],
    );
    assert_eq!(wrong.code, Some(3));
    wrong.says(&["did you mean `strength`?"]);
}

#[test]
fn list_and_describe_tell_where_parts_come_from() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("formulas");
    let path = library.to_str().expect("UTF-8");
    let said = leafwise(&here, &["list", "--json", "--plugin", path]);
    let listed = said.json();
    let systems = listed["systems"].as_array().expect("systems");
    let own = systems
        .iter()
        .find(|entry| entry["name"] == "formulas/pendulum");
    let own = own.expect("the plugin's system");
    assert_eq!(own["origin"]["kind"], "library");
    assert_eq!(own["origin"]["path"], path);
    let said = leafwise(&here, &["describe", "formulas/energy", "--plugin", path]);
    assert!(
        said.out.contains(path) && said.out.contains("abi 1.0"),
        "{}",
        said.out
    );
    // Without being asked for, nothing is loaded.
    let said = leafwise(&here, &["describe", "formulas/energy"]);
    assert_eq!(said.code, Some(2));
}

#[test]
fn a_refused_plugin_is_underlined_and_ends_with_code_4() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let system = "library = \"rigid-body\"";
    let method = "stepper = \"gallery/still\"";
    for (name, text) in [
        (
            "wrong_maths",
            "bisection identity alpha(x,0)=x on so(3)* violated",
        ),
        ("crashes", "probe: child killed by signal 11 (SIGSEGV)"),
        ("flushes", "floating-point environment changed"),
        ("null_function", "required function `alpha` is NULL"),
    ] {
        let library = workshop.compile(name);
        here.write(
            "scene.toml",
            &scene(&[&library], system, method, "[1, 3, 3]"),
        );
        let said = leafwise(&here, &["run", "scene.toml"]);
        assert_eq!(said.code, Some(4), "{}", said.err);
        said.says(&[text, "scene.toml:1:12", "refused"]);
    }
    assert!(!here.path("runs").exists());
    let said = leafwise(&here, &["list", "--plugin", "./nothing.so", "--json"]);
    assert_eq!(said.code, Some(4));
    let json = said.json();
    assert_eq!(json["outcome"], "refused");
    assert_eq!(json["error"]["refusal"], "no-such-file");
    here.write("text.so", "just some text");
    let said = leafwise(&here, &["list", "--plugin", "./text.so", "--json"]);
    assert_eq!(
        said.json()["error"]["refusal"]["not-a-library"]["first"][0],
        106
    );
}

/// A library that was cut short kills the process that opens it: that is not this program.
#[test]
fn a_truncated_library_does_not_end_the_program() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let whole = fs::read(workshop.compile("still")).expect("the library");
    let path = here.path("cut.so");
    fs::write(&path, &whole[..whole.len() / 4]).expect("a writable folder");
    let said = leafwise(&here, &["list", "--plugin", "./cut.so"]);
    assert_eq!(said.code, Some(4), "{}", said.err);
    said.says(&["probe: child killed by signal 7 (SIGBUS)"]);
}

#[test]
fn plugins_can_be_forbidden() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("still");
    let system = "library = \"rigid-body\"";
    let method = "stepper = \"gallery/still\"";
    here.write(
        "scene.toml",
        &scene(&[&library], system, method, "[1, 3, 3]"),
    );
    let refused = "plugins are switched off (--no-plugins, or LEAFWISE_NO_PLUGINS is set)";
    let said = leafwise(&here, &["check", "scene.toml", "--no-plugins"]);
    assert_eq!(said.code, Some(4));
    said.says(&[refused]);
    let with = |value: &str| {
        let mut command = command(&here, &["check", "scene.toml"]);
        let output = command.env("LEAFWISE_NO_PLUGINS", value).output();
        Said::from(output.expect("the program starts"))
    };
    assert_eq!(with("1").code, Some(4));
    with("1").says(&[refused]);
    assert_eq!(with("0").code, Some(0));
    assert_eq!(with("").code, Some(0));
}

/// Every bad argument has its own words and one of the documented codes.
#[test]
fn bad_arguments_of_the_plugin_commands_are_told_apart() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("still");
    let good = library.to_str().expect("UTF-8");
    here.write("notes.txt", "just some text");
    here.write("text.so", "just some text");
    here.write("empty.so", "");
    fs::create_dir(here.path("folder")).expect("a writable folder");
    for (arguments, code, text) in [
        (
            &["check"][..],
            2,
            "the following required arguments were not provided:\n  <PATH>",
        ),
        (
            &["check", ""],
            2,
            "a value is required for '<PATH>' but none was supplied",
        ),
        (&["check", good, good], 2, "unexpected argument"),
        (
            &["check", "--bogus", good],
            2,
            "unexpected argument '--bogus' found",
        ),
        (&["list", good], 2, "unexpected argument"),
        (
            &["list", "--bogus"],
            2,
            "unexpected argument '--bogus' found",
        ),
        (&["chekc", good], 2, "unrecognized subcommand 'chekc'"),
        (
            &["check", "./missing.so"],
            4,
            "missing.so: there is no such file",
        ),
        (
            &["check", "missing"],
            4,
            "plugin missing: no folder of the search path holds it: ",
        ),
        (&["check", "folder"], 4, "something of that name lies here"),
        (
            &["check", "notes.txt"],
            4,
            "something of that name lies here",
        ),
        (
            &["check", "./folder"],
            4,
            "folder: it is not a regular file",
        ),
        (
            &["check", "/dev/null"],
            4,
            "/dev/null: it is not a regular file",
        ),
        (
            &["check", "./text.so"],
            4,
            "not a shared library (first bytes [6a, 75, ",
        ),
        (
            &["check", "./empty.so"],
            4,
            "not a shared library (the file is empty)",
        ),
        (
            &["check", good, "--no-plugins"],
            4,
            "plugins are switched off",
        ),
    ] {
        let arguments: Vec<&str> = [&["plugin"], arguments].concat();
        let said = leafwise(&here, &arguments);
        assert_eq!(said.code, Some(code), "{arguments:?}: {}", said.err);
        said.says(&[text]);
        assert_eq!(said.out, "", "{arguments:?}");
    }
    // With --json the reason is a value too.
    for (path, reason) in [("./missing.so", "no-such-file"), ("./folder", "not-a-file")] {
        let said = leafwise(&here, &["plugin", "check", path, "--json"]);
        assert_eq!(said.json()["error"]["refusal"], reason);
    }
    // Listing loads nothing and so refuses nothing, but says that nothing is looked for.
    let said = leafwise(&here, &["plugin", "list", "--no-plugins"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(
        said.out.contains("plugins are switched off"),
        "{}",
        said.out
    );
    let said = leafwise(&here, &["plugin", "list", "--no-plugins", "--json"]);
    assert_eq!(said.json()["switched_off"], true);
}

#[test]
fn names_are_looked_for_in_the_search_path_and_read_without_being_run() {
    let (here, workshop) = (Place::new(), Workshop::new());
    workshop.compile("still");
    workshop.compile("crashes");
    let folder = workshop.path("");
    workshop.write(
        "still.plugin.toml",
        "id = \"gallery\"\nversion = \"0.1.0\"\n\
         parts = [{ id = \"gallery/still\", kind = \"step-map\", summary = \"stands still\" }]\n",
    );
    let with = |arguments: &[&str]| {
        let mut command = command(&here, arguments);
        let output = command.env("LEAFWISE_PLUGIN_PATH", &folder).output();
        Said::from(output.expect("the program starts"))
    };
    let said = with(&["plugin", "list"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    for text in [
        "libcrashes.so",
        "libstill.so",
        "gallery 0.1.0",
        "stands still",
    ] {
        assert!(
            said.out.contains(text),
            "`{text}` is missing from:\n{}",
            said.out
        );
    }
    let json = with(&["plugin", "list", "--json"]).json();
    assert_eq!(
        json["plugins"][1]["side_file"]["parts"][0]["id"],
        "gallery/still"
    );
    let said = with(&["list", "steppers", "--plugin", "still"]);
    assert!(said.out.contains("gallery/still"), "{}", said.out);
    // Nothing of the folder is loaded that is not named.
    let said = with(&["list", "steppers"]);
    assert!(!said.out.contains("gallery/still"), "{}", said.out);
    assert_eq!(with(&["list", "--plugin", "absent"]).code, Some(4));
}

/// The SHA-256 that a scene gives must be that of the file.
#[test]
fn a_scene_may_say_which_file_it_means() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("still");
    let with = |sha256: &str| {
        let method = "stepper = \"gallery/still\"";
        let text = scene(&[], "library = \"rigid-body\"", method, "[1, 3, 3]");
        let plugin = format!(
            "[{{ path = {:?}, sha256 = \"{sha256}\" }}]",
            library.display()
        );
        here.write(
            "scene.toml",
            &text.replace("plugins = []", &format!("plugins = {plugin}")),
        );
        leafwise(&here, &["check", "scene.toml", "--json"])
    };
    let said = with("00");
    assert_eq!(said.code, Some(4));
    let found = said.json()["error"]["refusal"]["hash"]["found"].clone();
    assert_eq!(with(found.as_str().expect("the file's hash")).code, Some(0));
}

/// A system in C, a realization in Rust, the program's own dynamics: they run, and do what they declare.
#[test]
fn parts_of_two_libraries_run_and_pass_verify() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let system = workshop.compile("../../../examples/c/gyrostat");
    let realization = rust_example();
    let text = scene(
        &[&system, &realization],
        "library = \"example-c/gyrostat\"\nparameters = { rotor = 0.25 }",
        "realization = { name = \"example/so3-rodrigues\", path = \"numbers\" }\n\
         dynamics = { name = \"hamilton-jacobi\", order = 2 }",
        "[0.3, 1.0, -0.7]",
    );
    here.write(
        "scene.toml",
        &text.replace("time-step = 0.05", "time-step = 0.1"),
    );
    let said = leafwise(&here, &["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let spin = said.json()["drift"]["spin"].as_f64().expect("the Casimir");
    assert!(spin <= 200.0 * f64::EPSILON, "{spin:e}");
    let manifest = here.read("runs/scene/manifest.json");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    let plugins = manifest["plugins"].as_array().expect("the libraries");
    assert_eq!(plugins.len(), 2);
    for plugin in plugins {
        assert_eq!(plugin["sha256"].as_str().map(str::len), Some(64));
        assert_eq!(plugin["abi"], "1.0");
    }
    assert_eq!(manifest["system"]["path"], "numbers");
    assert_eq!(manifest["parts"][0]["path"], "numbers");
    assert_eq!(manifest["path"], "numbers, by calls; workers");
    let said = leafwise(&here, &["check", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert_eq!(said.json()["jacobi"]["verdict"], "numerically zero");
    let verify = ["verify", "scene.toml", "--json", "--html", "page.html"];
    let said = leafwise(&here, &verify);
    let json = said.json();
    let rows = json["rows"].as_array().expect("rows");
    let broken: Vec<_> = rows.iter().filter(|row| row["met"] != true).collect();
    assert_eq!(said.code, Some(0), "{broken:#?}");
    let own = rows.iter().filter(|row| {
        let map = row["map"].as_str().unwrap_or_default();
        map.contains("example/so3-rodrigues") && map.contains("hamilton-jacobi")
    });
    let own: Vec<_> = own.collect();
    assert!(!own.is_empty(), "{rows:#?}");
    for row in own {
        assert_eq!(row["declared"]["structure"], "exact");
        assert_eq!(row["measured"]["judgements"]["structure"], "met", "{row:#}");
        assert_eq!(row["measured"]["judgements"]["order"], "met", "{row:#}");
    }
    // What does not fit is told in full here, and a reason at a time to a reader.
    let refused = json["refused"].as_array().expect("combinations");
    let lacking = |entry: &&serde_json::Value| {
        let reason = entry["reason"].as_str().unwrap_or_default();
        reason.contains("needs formulas of the system")
    };
    assert!(refused.iter().filter(lacking).count() > 10, "{refused:#?}");
    let page = here.read("page.html");
    let reason = "formulas of the system are needed, and example-c/gyrostat offers only numbers";
    assert_eq!(page.matches(reason).count(), 1);
    assert!(page.contains("<b>constant, darboux-magnetic, "), "{page}");
}

/// What a call costs is not counted: methods are compared by time, where that was measured.
#[test]
fn methods_on_a_system_of_numbers_are_compared_by_time() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let system = workshop.compile("../../../examples/c/gyrostat");
    let method = "realization = \"karasev-collocated\"\n\
                  dynamics = { name = \"hamilton-jacobi\", order = 2 }";
    let of_library = "library = \"example-c/gyrostat\"";
    here.write(
        "scene.toml",
        &scene(&[&system], of_library, method, "[0.3, 1.0, -0.7]"),
    );
    let compare = |more: &[&str]| {
        let only = "karasev-collocated+hamilton-jacobi:2,gauss:2,rk4";
        let common = [
            "compare",
            "scene.toml",
            "--only",
            only,
            "--steps",
            "100,200",
        ];
        let said = leafwise(&here, &[&common, more].concat());
        assert_eq!(said.code, Some(0), "{}", said.err);
        said
    };
    let json = compare(&["--json"]).json();
    assert_eq!(json["fronts_by"], "time");
    let points = json["points"].as_array().expect("points");
    assert_eq!(points.len(), 6, "{points:#?}");
    let is_of = |point: &serde_json::Value, front: &str| point["front"][front] == true;
    assert!(
        points.iter().any(|point| is_of(point, "all")),
        "{points:#?}"
    );
    assert!(
        points.iter().any(|point| is_of(point, "poisson")),
        "{points:#?}"
    );
    for point in points {
        assert_eq!(point["front"]["all"], point["front"]["wall"], "{point:#}");
    }
    let said = compare(&[]);
    assert!(
        said.out
            .contains("the operations of this system's functions are not known"),
        "{}",
        said.out
    );
    assert!(said.out.contains("karasev-collocated"), "{}", said.out);
    let said = compare(&["--repeat", "0"]);
    assert!(
        said.out.contains("--repeat 3 measures times"),
        "{}",
        said.out
    );
}

/// Which parts computed by formulas and which by calls is read off the manifest.
#[test]
fn a_manifest_tells_the_path_that_was_taken() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let gyrostat = workshop.compile("../../../examples/c/gyrostat");
    let steps = workshop.compile("steps");
    let rust = rust_example();
    let rodrigues = |path: &str| {
        format!(
            "realization = {{ name = \"example/so3-rodrigues\", path = \"{path}\" }}\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}"
        )
    };
    let collocated = "realization = \"karasev-collocated\"\n\
                      dynamics = { name = \"hamilton-jacobi\", order = 2 }";
    let composed = format!("{collocated}\ncomposition = \"suzuki-4\"");
    let (body, own) = ("rigid-body", "example-c/gyrostat");
    let compiled = "expressions, compiled to straight-line code";
    for (system, method, path, parts) in [
        (
            body,
            rodrigues("expressions"),
            format!("{compiled}; one kernel; "),
            &["expressions"; 2][..],
        ),
        (
            body,
            rodrigues("numbers"),
            format!(
                "numbers, by calls: realization; {compiled}: system, dynamic approximation; workers; "
            ),
            &["numbers", "expressions"],
        ),
        (
            own,
            rodrigues("expressions"),
            format!(
                "numbers, by calls: system, dynamic approximation; {compiled}: realization; workers; "
            ),
            &["expressions", "numbers"],
        ),
        (
            own,
            collocated.to_owned(),
            "numbers, by calls; fused".to_owned(),
            &["numbers"; 2],
        ),
        (
            own,
            composed,
            "numbers, by calls; fused".to_owned(),
            &["numbers"; 2],
        ),
        (
            own,
            "stepper = \"rk4\"".to_owned(),
            "numbers, by calls; a step map of its own".to_owned(),
            &["numbers"],
        ),
        (
            body,
            "stepper = \"steps/heun\"".to_owned(),
            format!("numbers, by calls: stepper; {compiled}: system; a step map of its own; "),
            &["numbers"],
        ),
    ] {
        let libraries = [&gyrostat, &steps, &rust].map(|library| library.as_path());
        let system = format!("library = \"{system}\"");
        here.write(
            "scene.toml",
            &scene(&libraries, &system, &method, "[0.3, 1, -0.7]"),
        );
        let said = leafwise(&here, &["run", "scene.toml", "--force"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let manifest = here.read("runs/scene/manifest.json");
        let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
        let said = manifest["path"].as_str().expect("a path");
        assert!(said.starts_with(&path), "{said}\nand not\n{path}");
        assert!(said == path || path.ends_with("; "), "{said}");
        for (part, path) in manifest["parts"]
            .as_array()
            .expect("parts")
            .iter()
            .zip(parts)
        {
            assert_eq!(part["path"], *path, "{part:#}");
        }
    }
}

/// What was begun with one file of a plugin is not continued with another.
#[test]
fn a_run_is_not_continued_with_another_file_of_a_plugin() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("formulas");
    let system = "library = \"formulas/pendulum\"";
    let method = "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }";
    let text = scene(&[&library], system, method, "[1, 0]");
    let text = text.replace("steps = 200", "steps = 20000000\nrecord = { every = 1000 }");
    here.write("scene.toml", &text);
    let mut child = command(&here, &["run", "scene.toml"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    // Written behind the first checkpoint.
    let manifest = here.path("runs/scene/manifest.json");
    wait_for(|| manifest.exists(), "the manifest");
    child.kill().expect("killed");
    child.wait().expect("an end");
    let first = fs::read(&library).expect("the library");
    let other = workshop.compile_with("formulas", &["-O1"]);
    assert_ne!(fs::read(other).expect("the library"), first);
    let said = leafwise(&here, &["run", "scene.toml"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&[
        "holds a run begun with another",
        "libformulas.so",
        "--force",
    ]);
    fs::remove_file(&library).expect("our own file");
    fs::write(&library, first).expect("a writable folder");
    let said = leafwise(&here, &["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["resumed at step"]);
}

/// What is wrong with a part's mathematics is told, with the instrument that found it.
#[test]
fn a_check_finds_what_a_part_declares_and_is_not() {
    let (here, workshop) = (Place::new(), Workshop::new());
    for (name, quantity) in [
        ("still", "order"),
        ("not_poisson", "Jacobi's identity"),
        ("not_exact", "alpha is Poisson"),
    ] {
        let library = workshop.compile(name);
        let path = library.to_str().expect("UTF-8");
        let said = leafwise(&here, &["plugin", "check", path, "--json"]);
        assert_eq!(said.code, Some(5), "{}{}", said.out, said.err);
        let json = said.json();
        assert_eq!(json["outcome"], "not met");
        let findings = json["parts"][0]["findings"].as_array().expect("findings");
        let broken = findings.iter().find(|f| f["judgement"] == "not-met");
        assert_eq!(
            broken.expect("one is broken")["quantity"],
            quantity,
            "{json:#}"
        );
        let said = leafwise(&here, &["plugin", "check", path]);
        assert_eq!(said.code, Some(5));
        assert!(said.out.contains("FAILS  "), "{}", said.out);
    }
    let library = workshop.compile("wrong_maths");
    let path = library.to_str().expect("UTF-8");
    let said = leafwise(&here, &["plugin", "check", path, "--json"]);
    assert_eq!(said.code, Some(4), "{}", said.err);
    let said = leafwise(&here, &["plugin", "check", path, "--no-plugins"]);
    assert_eq!(said.code, Some(4), "{}", said.err);
}

#[test]
fn the_examples_pass_their_check() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let c = workshop.compile("../../../examples/c/gyrostat");
    let rust = rust_example();
    let check = |library: &Path| {
        let path = library.to_str().expect("UTF-8");
        let said = leafwise(&here, &["plugin", "check", path]);
        assert_eq!(said.code, Some(0), "{}{}", said.out, said.err);
        said.out
    };
    let has = |text: &str, pieces: &[&str]| {
        for piece in pieces {
            assert!(text.contains(piece), "`{piece}` is missing from:\n{text}");
        }
    };
    let pieces = [
        "example-c 1.0.0",
        "Jacobi's identity",
        "Casimir spin",
        "Hessian of H",
    ];
    has(&check(&c), &pieces);
    let pieces = [
        "example/so3-rodrigues, a realization",
        "alpha is Poisson",
        "{alpha, beta} = 0",
        "rigid-body (numbers)",
        "rigid-body (expressions)",
        "the same bits on 16 lanes",
        "Casimir population",
    ];
    has(&check(&rust), &pieces);
}

/// The fenced blocks of `docs/plugins.md` as one script: commands as they stand, scenes written to the
/// file that their first line names.
fn page_as_script(root: &Path) -> String {
    let page = fs::read_to_string(root.join("docs/plugins.md")).expect("the page");
    let mut script = String::from("set -e\ntop=$PWD\n");
    let mut open: Option<&str> = None;
    for line in page.lines() {
        match (open, line.strip_prefix("```")) {
            (None, Some("sh")) => open = Some("sh"),
            (None, Some(kind)) => open = Some(kind),
            (Some("toml"), Some(_)) => {
                script.push_str("EOF\n");
                open = None;
            }
            (Some(_), Some(_)) => open = None,
            (Some("toml"), None) => match line.strip_prefix("# ") {
                Some(file) => script.push_str(&format!("cat > \"$top/{file}\" <<'EOF'\n")),
                None => script.push_str(&format!("{line}\n")),
            },
            (Some("sh"), None) => script.push_str(&format!("{line}\n")),
            _ => {}
        }
    }
    script
}

/// From nothing to a loaded part, by the page's own words.
#[test]
fn every_command_of_the_page_works_as_written() {
    let here = Place::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let root = root.canonicalize().expect("the checkout");
    std::os::unix::fs::symlink(&root, here.path("leafwise")).expect("a link");
    fs::create_dir(here.path("bin")).expect("a folder");
    let program = env!("CARGO_BIN_EXE_leafwise");
    std::os::unix::fs::symlink(program, here.path("bin/leafwise")).expect("a link");
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("sh")
        .args(["-c", &page_as_script(&root)])
        .current_dir(here.path("."))
        .env("PATH", format!("{}:{path}", here.path("bin").display()))
        .env("XDG_CACHE_HOME", here.path("cache"))
        .env("XDG_DATA_HOME", here.path("data"))
        .env_remove("LEAFWISE_PLUGIN_PATH")
        .env_remove("LEAFWISE_NO_PLUGINS")
        .env_remove("CARGO_TARGET_DIR")
        .output();
    let said = Said::from(output.expect("a shell"));
    assert_eq!(said.code, Some(0), "{}{}", said.out, said.err);
    let count = |text: &str| said.out.matches(text).count() + said.err.matches(text).count();
    assert_eq!(
        count("nothing that is declared is broken"),
        3,
        "{}",
        said.out
    );
    assert_eq!(count("done: 1 000 steps"), 2, "{}", said.out);
    assert!(count("my/oscillator") >= 2, "{}", said.out);
    for manifest in [
        "my-plugin/runs/my/manifest.json",
        "runs/gyrostat/manifest.json",
    ] {
        let manifest: serde_json::Value = serde_json::from_str(&here.read(manifest)).expect("JSON");
        assert_eq!(manifest["path"], "numbers, by calls; fused");
        assert_eq!(manifest["plugins"][0]["abi"], "1.0");
    }
}
