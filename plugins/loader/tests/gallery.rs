//! Plugins that are wrong in one way each: what is said of them, and that nothing of them stays.
//!
//! The program that loads is this test's own process: that the next line runs shows that it lives.

#![cfg(unix)]

mod support;

use std::fs;
use std::path::Path;

use leafwise_core::Registry;
use leafwise_plugin_loader::{PluginError, ProbeCommand, Refusal, SmokeFailure};
use support::build::Workshop;
use support::{impatient, load, probe};

/// The refusal of a file; the registry, which held one part, is as it was.
#[track_caller]
fn refusal(path: &Path, probe: Option<ProbeCommand>) -> PluginError {
    let workshop = Workshop::new();
    let mut registry = Registry::empty();
    load(&workshop.compile("still"), None, &mut registry).expect("a good plugin");
    let before = registry.parts();
    let error = load(path, probe, &mut registry).expect_err("a bad plugin");
    assert_eq!(registry.parts(), before);
    assert_eq!(error.plugin, path);
    error
}

/// Refuses one fixture the same way in the child process and, where that is safe, in this one.
#[track_caller]
fn refused(name: &str, text: &str) -> Refusal {
    let workshop = Workshop::new();
    let path = workshop.compile(name);
    let here = refusal(&path, None);
    assert!(
        here.to_string().contains(text),
        "`{text}` is missing from: {here}"
    );
    assert_eq!(refusal(&path, Some(probe())), here);
    here.refusal
}

/// Refuses one fixture in the child process only: it would end or stop this one.
#[track_caller]
fn refused_by_probe(name: &str, text: &str) -> Refusal {
    refused_by(probe(), name, text)
}

/// Refuses one fixture that never ends, after a short time.
#[track_caller]
fn cut_off_by_probe(name: &str, text: &str) -> Refusal {
    refused_by(impatient(), name, text)
}

#[track_caller]
fn refused_by(probe: ProbeCommand, name: &str, text: &str) -> Refusal {
    let error = refusal(&Workshop::new().compile(name), Some(probe));
    assert!(
        error.to_string().contains(text),
        "`{text}` is missing from: {error}"
    );
    error.refusal
}

/// What the loader says of a fixture whose part breaks the contract when it is called.
#[track_caller]
fn fails(name: &str, text: &str) -> SmokeFailure {
    match refused(name, text) {
        Refusal::Smoke { part, failure } => {
            assert_eq!(part, format!("gallery/{}", name.replace('_', "-")));
            failure
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_good_plugin_is_registered_with_its_origin() {
    let workshop = Workshop::new();
    let path = workshop.compile("still");
    let mut registry = Registry::empty();
    let plugin = load(&path, Some(probe()), &mut registry).expect("a good plugin");
    assert_eq!(plugin.declaration.id, "gallery");
    assert_eq!(
        plugin.tried[0].problems,
        ["so(3)*", "log-canonical", "canonical, d = 3"]
    );
    assert!(plugin.tried[0].writing_static_data.is_empty());
    assert_eq!(registry.origin("gallery/still"), Some(&plugin.origin()));
    assert_eq!(plugin.path, path);
    assert_eq!(plugin.sha256.len(), 64);
    // Asked for again, it is there already.
    load(&path, None, &mut registry).expect("the same plugin");
    assert_eq!(registry.parts().len(), 1);
}

#[test]
fn wrong_magic() {
    let refusal = refused("wrong_magic", "bad magic [58, 49, 41, 46, 57, 49, 53, 45]");
    assert!(matches!(refusal, Refusal::BadMagic { .. }));
}

#[test]
fn another_version_of_the_interface() {
    let text = "plugin ABI 7.0, host supports 1.0 to 1.0";
    assert_eq!(
        refused("other_major", text),
        Refusal::Abi { major: 7, minor: 0 }
    );
    let text = "plugin ABI 1.5, host supports 1.0 to 1.0";
    assert_eq!(
        refused("newer_minor", text),
        Refusal::Abi { major: 1, minor: 5 }
    );
}

#[test]
fn no_entry_of_this_version() {
    let refusal = refused(
        "only_v3",
        "no entry point leafwise_plugin_entry_v1 (it offers v3)",
    );
    assert_eq!(refusal, Refusal::NoEntryPoint { offers: vec![3] });
    let text = "no entry point leafwise_plugin_entry_v1: not a Leafwise plugin";
    assert_eq!(
        refused("no_entry", text),
        Refusal::NoEntryPoint { offers: vec![] }
    );
}

#[test]
fn a_null_entry() {
    assert_eq!(
        refused("null_entry", "entry returned NULL"),
        Refusal::NullEntry
    );
}

#[test]
fn a_required_function_that_is_null() {
    let text = "part gallery/zero: required function `alpha` is NULL";
    assert!(matches!(
        refused("null_function", text),
        Refusal::MissingFunction { .. }
    ));
}

#[test]
fn older_and_shorter_structs_load_without_what_they_do_not_know() {
    let workshop = Workshop::new();
    let mut registry = Registry::empty();
    let path = workshop.compile("shorter");
    let plugin = load(&path, Some(probe()), &mut registry).expect("an older plugin");
    assert_eq!(plugin.declaration.license, None);
    let part = &plugin.declaration.parts[0];
    assert_eq!(part.flags.self_adjoint(), None);
    assert_eq!(registry.parts().len(), 1);
}

#[test]
fn files_that_are_no_libraries() {
    let workshop = Workshop::new();
    let said = |path: &Path| refusal(path, Some(probe()));
    let error = said(&workshop.write("text.so", "just some text"));
    let first = b"just som".to_vec();
    assert_eq!(error.refusal, Refusal::NotALibrary { first });
    let text = "not a shared library (first bytes [6a, 75, 73, 74, 20, 73, 6f, 6d])";
    assert!(error.to_string().ends_with(text), "{error}");
    let error = said(&workshop.write("empty.so", ""));
    assert!(
        error
            .to_string()
            .ends_with("not a shared library (the file is empty)")
    );
    let error = said(&workshop.path("missing.so"));
    assert_eq!(error.refusal, Refusal::NoSuchFile);
    assert!(
        error
            .to_string()
            .ends_with("missing.so: there is no such file")
    );
}

#[test]
fn an_unresolved_symbol_is_named() {
    let refusal = refused("unresolved", "undefined symbol: nosuch");
    assert!(matches!(refusal, Refusal::Open { .. }));
}

/// A file that was cut short, by a full disk say: its head is that of a library, and opening it
/// touches pages that are not there.
#[test]
fn a_truncated_library_kills_the_child_only() {
    let workshop = Workshop::new();
    let whole = fs::read(workshop.compile("still")).expect("the library");
    let path = workshop.write("truncated.so", &whole[..whole.len() / 4]);
    let error = refusal(&path, Some(probe()));
    match error.refusal {
        Refusal::ProbeKilled { signal: 7, .. } => {
            assert!(
                error
                    .to_string()
                    .contains("probe: child killed by signal 7 (SIGBUS)")
            );
        }
        ref other => panic!("{other}"),
    }
}

#[test]
fn a_constructor_that_crashes_or_leaves_ends_the_child_only() {
    let text = "probe: child killed by signal 11 (SIGSEGV)";
    let refusal = refused_by_probe("crashes", text);
    assert!(matches!(refusal, Refusal::ProbeKilled { signal: 11, .. }));
    let text = "probe: child ended with exit code 9 and no report; it wrote: no licence found";
    assert!(matches!(
        refused_by_probe("exits", text),
        Refusal::ProbeExited { code: 9, .. }
    ));
}

#[test]
fn what_never_returns_is_stopped() {
    let refusal = cut_off_by_probe("hangs", "probe: no report within 1.5 s");
    assert_eq!(refusal, Refusal::ProbeTimedOut { seconds: 1.5 });
    cut_off_by_probe("spins", "probe: no report within 1.5 s");
}

#[test]
fn a_fatal_call_tells_its_reason() {
    let text = "increment: fatal: panic: index out of bounds: the len is 0 but the index is 3";
    assert!(matches!(fails("fatal", text), SmokeFailure::Call { .. }));
}

#[test]
fn results_that_are_not_finite() {
    let text = "increment: non-finite output at point 0 coordinate 0";
    assert!(matches!(
        fails("not_finite", text),
        SmokeFailure::NotFinite { .. }
    ));
}

#[test]
fn wrong_mathematics() {
    let text = "bisection identity alpha(x,0)=x on so(3)* violated: [0.375, 0.5, 0.625]";
    match refused("wrong_maths", text) {
        Refusal::Smoke { failure, .. } => {
            let SmokeFailure::Identity { expected, .. } = failure else {
                panic!("{failure:?}");
            };
            assert_eq!(expected, [0.75, 1.0, 1.25]);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn writing_where_nothing_belongs() {
    let text = "increment: canary: it wrote past the end of its output";
    assert!(matches!(
        fails("overruns", text),
        SmokeFailure::Overwritten { .. }
    ));
    let text = "increment: canary: it wrote into the gaps between its results";
    assert!(matches!(
        fails("ignores_strides", text),
        SmokeFailure::Overwritten { .. }
    ));
}

#[test]
fn writing_to_an_input() {
    let text = "hamiltonian: canary: it wrote to its input `point`";
    assert!(matches!(
        fails("writes_input", text),
        SmokeFailure::Overwritten { .. }
    ));
}

/// Instances are called on several threads at once: what a call keeps in static memory is overwritten
/// by the others.
#[test]
fn memory_that_instances_share() {
    let text =
        "gradient: instances called on several threads at once gave other answers than one alone";
    assert!(matches!(
        fails("static_scratch", text),
        SmokeFailure::NotParallel { .. }
    ));
    let text =
        "gradient: an instance gave another answer once another one had been made and called";
    assert!(matches!(
        fails("static_parameters", text),
        SmokeFailure::DependsOnOthers { .. }
    ));
}

/// Static data that change are told, and are no failure where the answers stay.
#[test]
fn a_counter_in_static_memory() {
    let workshop = Workshop::new();
    let path = workshop.compile("counts_calls");
    let plugin = load(&path, Some(probe()), &mut Registry::empty()).expect("a good plugin");
    assert_eq!(plugin.tried[0].writing_static_data, ["gradient"]);
}

/// The child process calls everything that the program calls: names and promises too.
#[test]
fn names_and_promises_are_asked_for_in_the_child() {
    let workshop = Workshop::new();
    let with = |name: &str, option: &str| {
        let path = workshop.compile_with(name, &["-O3", "-ffp-contract=off", option]);
        let is_endless = option.contains("for (;;)");
        let probe = if is_endless { impatient() } else { probe() };
        refusal(&path, Some(probe)).to_string()
    };
    let name = "-DNAMES=\"a\", \"b\", (const char *)1";
    for (name, option, text) in [
        ("names", name, "probe: child killed by signal 11 (SIGSEGV)"),
        (
            "promises",
            "-DCALL=__builtin_trap()",
            "probe: child killed by signal",
        ),
        (
            "promises",
            "-DCALL=for (;;)",
            "probe: no report within 1.5 s",
        ),
        (
            "promises",
            "-DCALL=promised->order = -5",
            "properties: error: properties: order -5 is less than 1",
        ),
        (
            "promises",
            "-DCALL=promised->structure = -7",
            "properties: error: properties: structure -7 is unknown",
        ),
        (
            "promises",
            "-DCALL=promised->flags = ~0u",
            "it is declared self-adjoint and not self-adjoint",
        ),
    ] {
        let said = with(name, option);
        assert!(said.contains(text), "`{text}` is missing from: {said}");
    }
}

/// A system's names obey the rules of a scene's.
#[test]
fn names_that_no_formula_could_use() {
    let workshop = Workshop::new();
    for (names, text) in [
        (
            r#""x", "sin", "z""#,
            "the variable `sin` cannot be called so: ",
        ),
        (
            r#""x", "<b>y</b>", "z""#,
            "the variable `<b>y</b>` cannot be called so: ",
        ),
        (
            r#""x", "y\nz", "z""#,
            "the variable `y\\nz` cannot be called so: ",
        ),
        (r#""x", "\xff", "z""#, "the name of variable 2 is not UTF-8"),
        (
            r#""x", "same", "same""#,
            "has the name of another variable, Casimir or parameter",
        ),
        (
            r#""x", "spin", "z""#,
            "the Casimir `spin` has the name of another variable",
        ),
        (
            r#""x", "rotor", "z""#,
            "the variable `rotor` has the name of another variable",
        ),
        (
            r#""time", "y", "z""#,
            "the variable `time` has a name that samples and formulas have",
        ),
        (
            r#""x", "energy", "z""#,
            "the variable `energy` has a name that samples",
        ),
    ] {
        let option = format!("-DNAMES={names}");
        let path = workshop.compile_with("names", &["-O3", "-ffp-contract=off", &option]);
        let said = refusal(&path, Some(probe())).to_string();
        assert!(said.contains(text), "`{text}` is missing from: {said}");
    }
}

#[test]
fn a_number_of_casimirs_that_cannot_be() {
    let text = "18446744073709551615 Casimirs are more than 1048576";
    assert!(matches!(
        fails("endless_casimirs", text),
        SmokeFailure::Shape { .. }
    ));
}

/// Only LW_UNSUPPORTED says that a part does not serve a problem.
#[test]
fn a_part_that_cannot_be_made() {
    let text = "create: error: the table of inertia is missing";
    assert!(matches!(
        fails("cannot_create", text),
        SmokeFailure::Call { .. }
    ));
}

/// A process that a library leaves behind may hold the child's pipes open for ever.
#[test]
fn a_report_is_taken_when_it_arrives() {
    let workshop = Workshop::new();
    let path = workshop.compile("forks");
    load(&path, Some(probe()), &mut Registry::empty()).expect("a good plugin");
}

#[test]
fn a_side_file_that_cannot_be_used() {
    let workshop = Workshop::new();
    let path = workshop.compile("still");
    let side = workshop.path("still.plugin.toml");
    let said = || {
        let error = load(&path, None, &mut Registry::empty()).expect_err("refused");
        error.to_string()
    };
    workshop.write("still.plugin.toml", "id = \"other\"\n");
    assert!(said().contains("its id is `other`, and the library's `gallery`"));
    workshop.write("still.plugin.toml", "id = \"gallery\"\nversion = \"9\"\n");
    assert!(said().contains("its version is `9`, and the library's `0.1.0`"));
    // A pipe without a writer would be waited for.
    fs::remove_file(&side).expect("our own file");
    let made = std::process::Command::new("mkfifo").arg(&side).status();
    assert!(made.expect("mkfifo").success());
    assert!(said().contains("it is no regular file"));
}

/// The hash is that of the file that was opened.
#[test]
fn a_file_replaced_while_it_is_opened() {
    let workshop = Workshop::new();
    let path = workshop.compile("replaced");
    load(&path, None, &mut Registry::empty()).expect("nothing takes its place");
    let workshop = Workshop::new();
    let path = workshop.compile_with("replaced", &["-O1"]);
    fs::rename(
        workshop.compile("still"),
        workshop.path("libreplaced.so.next"),
    )
    .expect("ours");
    let error = load(&path, None, &mut Registry::empty()).expect_err("it was replaced");
    assert_eq!(error.refusal, Refusal::Changed);
}

#[test]
fn a_map_that_remembers() {
    let text = "increment: two calls at the same points gave different answers";
    assert!(matches!(
        fails("remembers", text),
        SmokeFailure::NotRepeatable { .. }
    ));
}

#[test]
fn an_id_that_is_taken() {
    let text = "it offers two parts called `gallery/twin`";
    assert!(matches!(
        refused("two_of_one_id", text),
        Refusal::TwoOfOneId { .. }
    ));
    // Another file with the id of the plugin that `refusal` loaded first.
    let workshop = Workshop::new();
    let copy = workshop.compile_with("still", &["-O1"]);
    let error = refusal(&copy, Some(probe()));
    let Refusal::Duplicate { id, .. } = &error.refusal else {
        panic!("{error}");
    };
    assert_eq!(id, "gallery/still");
    assert!(
        error
            .to_string()
            .contains("a stepper of this name is there already"),
        "{error}"
    );
}

#[test]
#[cfg(target_arch = "x86_64")]
fn a_library_that_changes_how_the_host_rounds() {
    let text = "floating-point environment changed when it was opened (control word 0x1f80 -> \
                0x9fc0: subnormal numbers become 0); build it without -Ofast";
    assert!(matches!(
        refused("flushes", text),
        Refusal::FloatingPoint { flushes: true, .. }
    ));
    let failure = fails(
        "rounds_up",
        "floating-point environment changed when it was called",
    );
    assert!(matches!(failure, SmokeFailure::FloatingPoint { .. }));
    // The host's arithmetic is as it was.
    let tiny = std::hint::black_box(1e-310);
    assert_eq!(std::hint::black_box(tiny * 0.5), 5e-311);
    assert_eq!(std::hint::black_box(1.0 + f64::EPSILON / 4.0), 1.0);
}

/// What the constructor of `flushes` stands for.
#[test]
#[cfg(target_arch = "x86_64")]
fn a_library_linked_with_fast_mathematics() {
    let workshop = Workshop::new();
    let path = workshop.compile_with("still", &["-Ofast"]);
    let error = refusal(&path, Some(probe()));
    assert!(
        matches!(error.refusal, Refusal::FloatingPoint { .. }),
        "{error}"
    );
}

#[test]
fn a_library_that_others_may_write() {
    use std::os::unix::fs::PermissionsExt;
    let workshop = Workshop::new();
    let path = workshop.compile("still");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o666)).expect("our own file");
    let error = refusal(&path, Some(probe()));
    assert!(matches!(
        error.refusal,
        Refusal::WritableByOthers { mode: 0o666, .. }
    ));
    assert!(
        error
            .to_string()
            .contains("may be written by everyone (mode 0666)"),
        "{error}"
    );
}

#[test]
fn a_formula_that_cannot_be_read() {
    let text = "part gallery/wrong-formula: formula `increment.2`: unknown name `y1`";
    assert!(matches!(
        refused("wrong_formula", text),
        Refusal::Formula { .. }
    ));
}

#[test]
fn another_file_than_the_one_meant() {
    let workshop = Workshop::new();
    let path = workshop.compile("still");
    let mut request = leafwise_plugin_loader::PluginRequest::new(&path);
    let loader = leafwise_plugin_loader::Loader::new(Default::default());
    let mut registry = Registry::empty();
    let mut with = |sha256: &str, registry: &mut Registry| {
        request.sha256 = Some(sha256.to_owned());
        loader.load(&request, Path::new("/"), registry)
    };
    let error = with(&"0".repeat(64), &mut registry).expect_err("another file");
    let Refusal::Hash { found, .. } = error.refusal else {
        panic!("{error}");
    };
    assert!(registry.parts().is_empty());
    with(&found.to_uppercase(), &mut registry).expect("the file meant");
    // The side file's word counts as much.
    workshop.write(
        "still.plugin.toml",
        format!("sha256 = \"{}\"\n", "1".repeat(64)),
    );
    let error = load(&path, None, &mut Registry::empty()).expect_err("another file");
    assert!(matches!(error.refusal, Refusal::Hash { .. }));
}

#[test]
fn nothing_is_loaded_where_loading_is_off() {
    let path = Workshop::new().compile("still");
    let request = leafwise_plugin_loader::PluginRequest::new(&path);
    let mut registry = Registry::empty();
    let loader = leafwise_plugin_loader::Loader::off();
    let error = loader
        .load(&request, Path::new("/"), &mut registry)
        .expect_err("it is off");
    assert_eq!(error.refusal, Refusal::SwitchedOff);
    assert!(registry.parts().is_empty());
}

/// Files that passed the probe are not tried again; a missing probe shows which ones are.
#[test]
fn the_probe_is_asked_once_for_a_file() {
    let workshop = Workshop::new();
    let path = workshop.compile("still");
    let cache = workshop.path("cache");
    let with = |probe: ProbeCommand| {
        let loader = leafwise_plugin_loader::Loader::new(Default::default());
        let loader = loader.with_probe(probe).with_probe_cache(cache.clone());
        let request = leafwise_plugin_loader::PluginRequest::new(&path);
        loader.load(&request, Path::new("/"), &mut Registry::empty())
    };
    let missing = || ProbeCommand::new("/nonexistent/probe", []);
    let error = with(missing()).expect_err("there is no probe");
    assert!(matches!(error.refusal, Refusal::ProbeNotStarted { .. }));
    with(probe()).expect("a good plugin");
    with(missing()).expect("known to be good");
    let mut longer = fs::read(&path).expect("the library");
    longer.push(0);
    // In its place, not into it: the library is in memory.
    fs::rename(workshop.write("other", longer), &path).expect("a writable folder");
    let error = with(missing()).expect_err("another file now");
    assert!(matches!(error.refusal, Refusal::ProbeNotStarted { .. }));
}
