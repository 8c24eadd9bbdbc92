//! Plugins that are wrong in one way each: what is said of them, and that nothing of them stays.
//!
//! The program that loads is this test's own process: that the next line runs shows that it lives.

#![cfg(unix)]

mod calls;
mod declarations;
mod files;
#[path = "../support/mod.rs"]
mod support;

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
