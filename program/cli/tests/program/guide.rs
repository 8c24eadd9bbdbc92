//! The guide: its scenes run, and its commands print what stands below them.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{BODY, Place, scenes};

/// A fenced block of a page.
struct Block {
    /// Page and line, for messages.
    place: String,
    /// What stands behind the fence: `toml`, `console`, `console slow`.
    kind: String,
    lines: Vec<String>,
}

fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pages: Vec<PathBuf> = fs::read_dir(root.join("docs/guide"))
        .expect("the guide")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    pages.sort();
    assert!(pages.len() >= 6, "{pages:?}");
    pages.push(root.join("README.md"));
    pages
}

fn blocks(kind: &str) -> Vec<Block> {
    let mut found = Vec::new();
    for page in pages() {
        let text = fs::read_to_string(&page).expect("a page");
        let mut open: Option<Block> = None;
        for (at, line) in text.lines().enumerate() {
            let fence = line.trim_start().strip_prefix("```");
            match (&mut open, fence) {
                (None, Some(info)) => {
                    open = Some(Block {
                        place: format!("{}:{}", page.display(), at + 1),
                        kind: info.trim().to_owned(),
                        lines: Vec::new(),
                    });
                }
                (Some(block), None) => block.lines.push(line.to_owned()),
                (Some(_), Some(_)) => found.extend(open.take()),
                (None, None) => {}
            }
        }
        assert!(open.is_none(), "{}: a fence is open", page.display());
    }
    found.retain(|block| block.kind == kind);
    found
}

/// The rigid body with another `[method]`.
fn body_with(method: &str) -> String {
    let (before, rest) = BODY.split_once("[method]").expect("a method");
    let (_, after) = rest.split_once("[run]").expect("a run");
    format!("{before}{method}\n[run]{after}")
}

#[test]
fn every_scene_of_the_guide_runs() {
    let scenes = blocks("toml");
    assert!(scenes.len() >= 8, "{} scenes", scenes.len());
    for block in scenes {
        let text = block.lines.join("\n");
        let scene = if text.contains("[system]") {
            text
        } else if text.contains("[method]") {
            body_with(&text)
        } else {
            format!("{BODY}{text}\n")
        };
        let here = Place::with(&scene);
        let said = here.leafwise(&["check", "scene.toml"]);
        assert_eq!(said.code, Some(0), "{}\n{}", block.place, said.err);
        let run = ["run", "scene.toml", "--set", "run.steps=5", "--quiet"];
        let said = here.leafwise(&run);
        assert_eq!(said.code, Some(0), "{}\n{}", block.place, said.err);
    }
}

/// Units of what differs between machines.
const UNITS: [&str; 4] = ["ns", "µs", "ms", "s"];

/// A line as words, times left out.
fn words(line: &str) -> Vec<&str> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let is_unit = |at: usize| words.get(at).is_some_and(|word| UNITS.contains(word));
    let kept = |at: &usize| !is_unit(*at) && !is_unit(at + 1);
    (0..words.len()).filter(kept).map(|at| words[at]).collect()
}

/// Runs a command; every line below it must be printed, in that order.
fn prints(here: &Place, place: &str, command: &str, expected: &[String]) {
    let mut arguments = command.split_whitespace();
    assert_eq!(arguments.next(), Some("leafwise"), "{place}");
    let arguments: Vec<&str> = arguments.collect();
    let said = here.leafwise(&arguments);
    assert_eq!(said.code, Some(0), "{place}: {command}\n{}", said.err);
    let text = format!("{}\n{}", said.out, said.err);
    let mut printed = text.lines();
    for line in expected {
        if line.trim().is_empty() || line.trim() == "…" {
            continue;
        }
        assert!(
            printed.any(|other| words(other) == words(line)),
            "{place}: {command} does not print, or not in this order:\n{line}\nbut\n{text}"
        );
    }
}

/// Copies a folder with all that it holds.
fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let target = to.join(entry.file_name());
        match entry.path().is_dir() {
            true => copy(&entry.path(), &target),
            false => drop(fs::copy(entry.path(), target).expect("a copy")),
        }
    }
}

fn print_what_stands_below_them(kind: &str, least: usize) {
    let here = Place::new();
    copy(&scenes(), &here.path("scenes"));
    let mut commands = 0;
    for block in blocks(kind) {
        let mut lines = block.lines.iter().map(|line| line.trim_start()).peekable();
        while let Some(line) = lines.next() {
            let Some(command) = line.strip_prefix("$ ") else {
                continue;
            };
            let mut expected = Vec::new();
            while let Some(line) = lines.next_if(|line| !line.starts_with("$ ")) {
                expected.push(line.to_owned());
            }
            prints(&here, &block.place, command, &expected);
            commands += 1;
        }
    }
    assert!(commands >= least, "{commands} commands");
}

#[test]
fn the_page_of_keys_is_what_the_program_prints() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/keys.md");
    let said = Place::new().leafwise(&["schema", "--markdown"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(
        fs::read_to_string(page).expect("the page") == said.out,
        "docs/guide/keys.md is out of date; run `cargo run -p leafwise-cli -- schema --markdown > docs/guide/keys.md`"
    );
}

#[test]
fn every_command_of_the_guide_prints_what_stands_below_it() {
    print_what_stands_below_them("console", 4);
}

#[test]
#[ignore = "minutes in an optimized build"]
fn every_slow_command_of_the_guide_prints_what_stands_below_it() {
    print_what_stands_below_them("console slow", 8);
}
