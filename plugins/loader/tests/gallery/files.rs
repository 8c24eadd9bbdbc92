//! Files that are no library, are not the one meant, or do harm when they are opened.

use std::fs;

use super::*;

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
    assert!(said().contains("it is not a regular file"));
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
            .contains("is writable by everyone (mode 0666)"),
        "{error}"
    );
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
