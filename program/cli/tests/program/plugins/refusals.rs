//! Which plugins are found, listed and refused, and in what words.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::process::Command;

use super::build::Workshop;
use super::{command, leafwise, scene};
use crate::support::{Place, Said};

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
    let library = workshop.compile("steps");
    let system = "library = \"rigid-body\"";
    let method = "stepper = \"steps/heun\"";
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
    // Only the search path says what a bare name means.
    fs::copy(&library, here.path("libplanted.so")).expect("a writable folder");
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
        (
            &["check", "folder"],
            4,
            "a file of that name is in this folder",
        ),
        (
            &["check", "libplanted.so"],
            4,
            "a file of that name is in this folder, which is not searched: give a path with a `/`",
        ),
        (
            &["probe", good, "--no-plugins"],
            4,
            "plugins are switched off",
        ),
        (
            &["check", "notes.txt"],
            4,
            "a file of that name is in this folder",
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

/// A pipe beside a library is not read: its writer might never come.
#[test]
fn listing_does_not_wait_for_a_pipe() {
    let (here, workshop) = (Place::new(), Workshop::new());
    workshop.compile("still");
    let side = workshop.path("still.plugin.toml");
    let made = Command::new("mkfifo").arg(&side).status();
    assert!(made.expect("mkfifo").success());
    // Who reads the pipe all the same finds what is no side file, and ends.
    let mut writer = Command::new("sh")
        .args(["-c", r#"echo nothing > "$0""#])
        .arg(&side)
        .spawn()
        .expect("a shell");
    let mut listing = command(&here, &["plugin", "list", "--json"]);
    let output = listing
        .env("LEAFWISE_PLUGIN_PATH", workshop.path(""))
        .output();
    // Fails only where it has ended.
    drop(writer.kill());
    writer.wait().expect("an end");
    let said = Said::from(output.expect("the program starts"));
    assert_eq!(said.code, Some(0), "{}", said.err);
    let error = said.json()["plugins"][0]["error"].clone();
    let error = error.as_str().expect("a reason");
    assert!(
        error.contains("it is not a regular file of at most"),
        "{error}"
    );
}

/// The child that tries a library opens only what nobody else may replace.
#[test]
fn the_probe_looks_at_permissions_itself() {
    use std::os::unix::fs::PermissionsExt;
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("prints");
    let path = library.to_str().expect("UTF-8");
    let with = |mode: u32| {
        fs::set_permissions(&library, fs::Permissions::from_mode(mode)).expect("our own file");
        leafwise(&here, &["plugin", "probe", path])
    };
    let report = |said: &Said| {
        let line = said
            .out
            .lines()
            .find_map(|line| line.split_once("leafwise-plugin-probe:"));
        let (_, json) = line.expect("a report");
        serde_json::from_str::<serde_json::Value>(json).expect("JSON")
    };
    let said = with(0o755);
    assert_eq!(report(&said), serde_json::Value::Null, "{}", said.out);
    let ran = |said: &Said| {
        said.out.contains("all rights reserved") || said.err.contains("all rights reserved")
    };
    assert!(ran(&said), "its own words are missing");
    let said = with(0o757);
    assert!(
        report(&said).to_string().contains("writable"),
        "{}",
        said.out
    );
    assert!(!ran(&said), "it was opened: {}{}", said.out, said.err);
}

/// The SHA-256 that a scene gives must be that of the file.
#[test]
fn a_scene_may_say_which_file_it_means() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("steps");
    let with = |sha256: &str| {
        let method = "stepper = \"steps/heun\"";
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

#[test]
fn a_path_that_is_not_unicode_is_told_and_not_printed_as_json() {
    let here = Place::new();
    let folder = here.path(".").join(OsStr::from_bytes(b"a\xff"));
    let mut command = command(&here, &["plugin", "list", "--json"]);
    let output = command.env("LEAFWISE_PLUGIN_PATH", &folder).output();
    let said = Said::from(output.expect("the program starts"));
    assert_eq!((said.code, said.out.as_str()), (Some(1), ""));
    said.says(&["cannot write the result", "path contains invalid UTF-8"]);
}
