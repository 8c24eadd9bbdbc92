//! An ensemble in shards, as schedulers run them.

use crate::support::{BODY, Place, Said};

fn place() -> Place {
    Place::with(&format!(
        "{BODY}[ensemble]\nmembers = 200\ninitial = {{ ball = 0.1 }}\nfinal-states = \"csv\"\n"
    ))
}

fn shard(here: &Place, asked: &[&str]) -> Said {
    let mut arguments = vec!["ensemble", "scene.toml", "--out", "shards"];
    arguments.extend(asked);
    here.leafwise(&arguments)
}

#[test]
fn an_arrays_tasks_are_merged_to_the_bytes_of_one_process() {
    let here = place();
    let whole = here.leafwise(&["ensemble", "scene.toml", "--out", "whole", "--quiet"]);
    assert_eq!(whole.code, Some(0), "{}", whole.err);
    for task in ["2", "3", "1"] {
        let mut command = here.command(&[
            "ensemble",
            "scene.toml",
            "--out",
            "shards",
            "--shard",
            "slurm",
        ]);
        command
            .env("SLURM_ARRAY_TASK_ID", task)
            .env("SLURM_ARRAY_TASK_MIN", "1")
            .env("SLURM_ARRAY_TASK_MAX", "3")
            .env("SLURM_ARRAY_TASK_COUNT", "3");
        let said = Said::from(command.output().expect("a task"));
        assert_eq!(said.code, Some(0), "{}", said.err);
        said.says(&[&format!("done: shard {task} of 3, members")]);
    }
    let again = shard(&here, &["--shard", "2/3", "--json"]).json();
    assert_eq!(again["members"], serde_json::json!([64, 128]));
    let merged = here.leafwise(&["merge", "shards", "--out", "merged", "--json"]);
    assert_eq!(merged.code, Some(0), "{}", merged.err);
    assert_eq!(merged.json()["members"], 200);
    for file in [
        "statistics.csv",
        "windows.csv",
        "final_states.csv",
        "scene.toml",
    ] {
        let [a, b] = ["whole", "merged"].map(|of| here.read(&format!("{of}/{file}")));
        assert!(a == b, "{file} differs");
    }
    let manifest = here.read("merged/manifest.json");
    assert!(manifest.contains("\"scene\": \"scene.toml\""), "{manifest}");
}

#[test]
fn what_is_no_shard_is_refused() {
    let here = place();
    for (asked, said) in [
        (["--shard", "4/3"], "shards are counted from 1 to 3"),
        (["--shard", "0/3"], "shards are counted from 1 to 3"),
        (["--shard", "three"], "`three` is no shard"),
        (["--shard", "1/0"], "there is at least one"),
        (["--members", "0..65"], "both bounds are multiples of 64"),
        (["--members", "0-64"], "`0-64` is no range of members"),
        (["--members", "64..256"], "both bounds are multiples of 64"),
    ] {
        let refused = shard(&here, &asked);
        assert_eq!(refused.code, Some(2), "{}", refused.err);
        assert!(refused.err.contains(said), "{said}\n{}", refused.err);
    }
    let mut outside = here.command(&["ensemble", "scene.toml", "--shard", "slurm"]);
    let outside = Said::from(
        outside
            .env_remove("SLURM_ARRAY_TASK_ID")
            .output()
            .expect("an end"),
    );
    assert_eq!(outside.code, Some(2));
    outside.says(&["SLURM_ARRAY_TASK_ID is not set"]);
    // A part of an array is submitted again: its bounds do not say how many shards there are.
    let mut part = here.command(&["ensemble", "scene.toml", "--shard", "slurm"]);
    part.env("SLURM_ARRAY_TASK_ID", "7")
        .env("SLURM_ARRAY_TASK_MIN", "3")
        .env("SLURM_ARRAY_TASK_MAX", "7")
        .env("SLURM_ARRAY_TASK_COUNT", "2");
    let part = Said::from(part.output().expect("an end"));
    assert_eq!(part.code, Some(2));
    part.says(&["--shard slurm/1000"]);
}

#[test]
fn members_that_are_missing_are_told_with_the_array_that_makes_them() {
    let here = place();
    let one = shard(&here, &["--shard", "1/4", "--quiet"]);
    assert_eq!(one.code, Some(0), "{}", one.err);
    let merged = here.leafwise(&["merge", "shards", "--out", "merged"]);
    assert_eq!(merged.code, Some(5), "{}", merged.err);
    merged.says(&[
        "136 members are missing: 64 to 199",
        "--array=2-4 with --shard slurm/4",
    ]);
    assert!(!here.path("merged").exists());
    // Another scene in the place of a shard.
    let other = shard(&here, &["--shard", "1/4", "--set", "run.steps=7"]);
    assert_eq!(other.code, Some(2), "{}", other.err);
    other.says(&["run.steps: 40 → 7"]);
}
