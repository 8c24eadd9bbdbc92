//! What the test files share.

#![allow(dead_code, reason = "each test file uses a part of it")]

pub mod build;
pub mod orbits;

use std::path::Path;
use std::time::Duration;

use leafwise_core::Registry;
use leafwise_plugin_loader::{
    LoadedPlugin, Loader, PluginError, PluginRequest, ProbeCommand, SearchPath,
};

/// The probe that this package ships, as patient as the busiest machine needs it.
pub fn probe() -> ProbeCommand {
    ProbeCommand {
        time_limit: Duration::from_secs(3600),
        ..ProbeCommand::new(env!("CARGO_BIN_EXE_leafwise-plugin-probe"), [])
    }
}

/// The same with a short time limit, for what never ends.
pub fn impatient() -> ProbeCommand {
    ProbeCommand {
        time_limit: Duration::from_millis(1500),
        ..probe()
    }
}

/// Loads one file in this process, tried in a child process first where there is a probe.
pub fn load(
    path: &Path,
    probe: Option<ProbeCommand>,
    registry: &mut Registry,
) -> Result<LoadedPlugin, PluginError> {
    let loader = Loader::new(SearchPath::default());
    let loader = match probe {
        Some(probe) => loader.with_probe(probe),
        None => loader,
    };
    loader.load(&PluginRequest::new(path), Path::new("/"), registry)
}

/// A registry with the built-in parts that are linked into this test.
pub fn built_in() -> Registry {
    use {leafwise_collective as _, leafwise_hamilton_jacobi as _};
    use {leafwise_karasev as _, leafwise_so3 as _};
    Registry::with_builtin()
}
