//! `docs/plugins.md` run as it stands.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::{Place, Said};

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
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
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
        count("no measurement contradicts what is declared"),
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
