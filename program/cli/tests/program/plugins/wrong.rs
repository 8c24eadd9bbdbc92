//! Parts that would give wrong numbers, end the program or spoil its output.

use std::fs;

use super::build::Workshop;
use super::{command, leafwise, scene};
use crate::support::{Place, Said};

/// A realization of another tensor, and a map of another motion, are refused at their place.
#[test]
fn parts_made_for_another_system_are_refused() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let libraries = ["motions", "not_exact", "still", "steps"].map(|name| workshop.compile(name));
    let libraries = libraries.each_ref().map(|library| library.as_path());
    let hamilton = "dynamics = { name = \"hamilton-jacobi\", order = 2 }";
    let pair = |realization: &str| format!("realization = \"{realization}\"\n{hamilton}");
    let body = ("rigid-body", "[1, 3, 3]");
    let prey = ("lotka-volterra-periodic", "[1, 1.5, 0.7]");
    let under = "realization = \"so3-cayley\"\ndynamics = \"motions/energy\"".to_owned();
    for (system, method, text) in [
        (
            body,
            pair("motions/log-canonical"),
            "motions/log-canonical does not fit this system: it realizes another tensor",
        ),
        (
            prey,
            pair("gallery/not-exact"),
            "gallery/not-exact does not fit this system: it realizes another tensor",
        ),
        (
            body,
            "stepper = \"motions/turn\"".to_owned(),
            "motions/turn does not fit this system: it follows another motion",
        ),
        (
            body,
            "stepper = \"gallery/still\"".to_owned(),
            "gallery/still does not fit this system: it follows another motion",
        ),
        (
            body,
            under,
            "motions/energy does not fit this system: it follows another motion",
        ),
    ] {
        let (name, initial) = system;
        let library = format!("library = \"{name}\"");
        here.write("scene.toml", &scene(&libraries, &library, &method, initial));
        let said = leafwise(&here, &["run", "scene.toml"]);
        assert_eq!(said.code, Some(3), "{method}: {}{}", said.out, said.err);
        said.says(&[text, "scene.toml:"]);
    }
    // What fits runs, also where the flow rests.
    for initial in ["[1, 3, 3]", "[0, 0, 2]", "[1e-30, 3e-30, 2e-30]"] {
        let method = "stepper = \"steps/heun\"";
        let text = scene(&libraries, "library = \"rigid-body\"", method, initial);
        here.write("scene.toml", &text);
        let said = leafwise(&here, &["run", "scene.toml", "--force"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
    }
    let ours = pair("gallery/not-exact");
    let text = scene(&libraries, "library = \"rigid-body\"", &ours, "[1, 3, 3]");
    here.write("scene.toml", &text);
    let said = leafwise(&here, &["check", "scene.toml"]);
    assert_eq!(said.code, Some(0), "its tensor is this one: {}", said.err);
}

/// Functions that accept a tensor which they do not realize are told; formulas cannot refuse one, and
/// what nothing was measured of is not passed.
#[test]
fn a_check_tells_what_is_accepted_and_what_was_not_measured() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("not_exact");
    let path = library.to_str().expect("UTF-8");
    let said = leafwise(&here, &["plugin", "check", path, "--json"]);
    assert_eq!(said.code, Some(5), "{}", said.err);
    let json = said.json();
    let findings = json["parts"][0]["findings"].as_array().expect("findings");
    let accepted = findings.iter().find(|finding| {
        finding["quantity"] == "accepts only tensors that it realizes"
            && finding["problem"] == "lotka-volterra-periodic"
    });
    assert_eq!(accepted.expect("a finding")["judgement"], "not-met");
    let library = workshop.compile("motions");
    let path = library.to_str().expect("UTF-8");
    let said = leafwise(&here, &["plugin", "check", path]);
    assert_eq!(said.code, Some(5), "{}{}", said.out, said.err);
    for text in [
        "no measurement contradicts what is declared",
        "nothing could be measured of motions/log-canonical, motions/turn, motions/energy: offer a system",
        "on none of the 4 problems of its dimension; offer a system of its tensor",
        "formulas do not say for which system they are meant; offer a system",
    ] {
        assert!(
            said.out.contains(text),
            "`{text}` is missing from:\n{}",
            said.out
        );
    }
}

/// A call that ends the process ends it with code 1 and a word.
#[test]
fn a_part_that_ends_the_program_does_not_say_how_it_ended() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("leaves_later");
    let system = "library = \"gallery/leaves-later\"";
    let text = scene(&[&library], system, "stepper = \"rk4\"", "[2.5, 1, 1]");
    here.write("scene.toml", &text);
    let said = leafwise(&here, &["run", "scene.toml"]);
    assert_eq!(said.code, Some(1), "{}", said.err);
    said.says(&["gallery/leaves-later ended the program from within a call"]);
    let text = scene(&[&library], system, "stepper = \"rk4\"", "[0.5, 1, 1]");
    here.write("scene.toml", &text.replace("steps = 200", "steps = 2"));
    let said = leafwise(&here, &["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
}

/// A check counts where it came to its end.
#[test]
fn a_check_that_a_library_ends_is_no_check() {
    let (here, workshop) = (Place::new(), Workshop::new());
    // The trial stays near x1 = 3/4, the measurements do not.
    let when = "-DWHEN=fabs(x - 0.75) > 0.01";
    for (leave, text) in [
        (
            "-DLEAVE=exit(0)",
            "ended with exit status: 1, before it was done",
        ),
        (
            "-DLEAVE=_exit(0)",
            "ended with exit status: 0, before it was done",
        ),
        (
            "-DLEAVE=raise(SIGKILL)",
            "ended with signal: 9 (SIGKILL), before it was done",
        ),
    ] {
        let options = ["-O3", "-ffp-contract=off", when, leave];
        let library = workshop.compile_with("leaves_later", &options);
        let path = library.to_str().expect("UTF-8");
        let said = leafwise(&here, &["plugin", "check", path]);
        assert_eq!(said.code, Some(4), "{leave}: {}{}", said.out, said.err);
        said.says(&[text]);
        let said = leafwise(&here, &["plugin", "check", path, "--json"]);
        assert_eq!(said.code, Some(4), "{leave}: {}", said.err);
        let refusal = &said.json()["error"]["refusal"]["not-measured"];
        assert!(refusal["how"].is_string(), "{refusal}");
        fs::remove_file(&library).expect("our own file");
    }
}

/// A check tries the library anew, whatever passed before.
#[test]
fn a_check_does_not_believe_what_passed_before() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("crashes_if_told");
    let path = library.to_str().expect("UTF-8");
    let with = |arguments: &[&str]| {
        let mut command = command(&here, arguments);
        let output = command.env("GALLERY_CRASHES", "1").output();
        Said::from(output.expect("the program starts"))
    };
    assert_eq!(leafwise(&here, &["list", "--plugin", path]).code, Some(0));
    let said = with(&["plugin", "check", path]);
    assert_eq!(said.code, Some(4), "{}", said.err);
    said.says(&["probe: child killed by signal 6 (SIGABRT)"]);
}

/// What a library prints does not stand among the results.
#[test]
fn a_library_prints_beside_the_results() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("prints");
    let path = library.to_str().expect("UTF-8");
    let said = leafwise(&here, &["list", "--json", "--plugin", path]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(said.json()["steppers"].is_array());
    said.says(&["GALLERY 0.1, all rights reserved"]);
}

/// The command that repeats a run loads what it needs, and the page says which files that were.
#[test]
fn a_run_says_which_libraries_it_needs() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("steps");
    let path = library.to_str().expect("UTF-8");
    let method = "stepper = \"steps/heun\"";
    let text = scene(&[], "library = \"rigid-body\"", method, "[1, 3, 3]");
    here.write("scene.toml", &text);
    let said = leafwise(&here, &["run", "scene.toml"]);
    assert_eq!(said.code, Some(3));
    said.says(&[
        "a name with a `/` is that of a plugin's part",
        "./libsteps.so",
    ]);
    let said = leafwise(&here, &["run", "scene.toml", "--plugin", path]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let manifest = here.read("runs/scene/manifest.json");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    let repeated = format!("leafwise run scene.toml --plugin {path}");
    assert_eq!(manifest["command"], repeated);
    let sha256 = manifest["plugins"][0]["sha256"].as_str().expect("a hash");
    let page = here.read("runs/scene/report.html");
    for text in [&repeated[..], sha256, "steps/heun: "] {
        assert!(page.contains(text), "`{text}` is missing");
    }
    for arguments in [&["new", "x.toml"][..], &["stress", "--list"]] {
        let said = leafwise(&here, &[arguments, &["--plugin", path]].concat());
        assert_eq!(said.code, Some(2), "{arguments:?}");
        said.says(&["`--plugin` has no meaning here"]);
    }
}

/// Calls that change how the program rounds, too few of them for one to be failed: no number is passed as good.
#[test]
#[cfg(target_arch = "x86_64")]
fn a_run_whose_rounding_a_library_changed_is_no_success() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("rounds_later");
    let system = "library = \"gallery/rounds-later\"";
    let with = |initial: &str| {
        let text = scene(&[&library], system, "stepper = \"rk4\"", initial);
        here.write("scene.toml", &text.replace("steps = 200", "steps = 1"));
        leafwise(&here, &["run", "scene.toml", "--force"])
    };
    // It rounds upwards from x1 = 2 on.
    let said = with("[0.5, 1, 1]");
    assert_eq!(said.code, Some(0), "{}", said.err);
    let said = with("[2.5, 1, 1]");
    assert_eq!(said.code, Some(1), "{}{}", said.out, said.err);
    said.says(&[
        "gallery/rounds-later",
        "numbers computed since then are not reliable",
        "1 step to t = 0.05",
    ]);
}

/// What a dying library said last is what it says, not where it was.
#[test]
fn a_library_that_dies_is_quoted_without_a_backtrace() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let library = workshop.compile("backtraces");
    let path = library.to_str().expect("UTF-8");
    let mut command = command(&here, &["list", "--plugin", path]);
    let output = command.env("RUST_BACKTRACE", "full").output();
    let said = Said::from(output.expect("the program starts"));
    assert_eq!(said.code, Some(4), "{}", said.err);
    said.says(&[
        "probe: child killed by signal 6 (SIGABRT)",
        "what it died of | backtrace: 0",
    ]);
}
