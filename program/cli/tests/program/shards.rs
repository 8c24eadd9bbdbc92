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

/// Three shards of the ensemble, and a place that has them.
fn in_shards() -> Place {
    let here = place();
    for number in 1..=3 {
        let made = shard(&here, &["--shard", &format!("{number}/3"), "--quiet"]);
        assert_eq!(made.code, Some(0), "{}", made.err);
    }
    here
}

#[test]
fn a_join_into_one_of_its_shards_leaves_the_shard_as_it_is() {
    let here = in_shards();
    let of_shard = |name: &str| here.read(&format!("shards/shard-2-of-3/{name}"));
    let before = ["manifest.json", "final_states.csv"].map(of_shard);
    for into in ["shards/shard-2-of-3", "shards/../shards/shard-2-of-3/"] {
        let refused = here.leafwise(&["merge", "shards", "--out", into, "--force"]);
        assert_eq!(refused.code, Some(2), "{}", refused.err);
        refused.says(&["is one of the shards that are joined", "--out DIR"]);
    }
    assert!(before == ["manifest.json", "final_states.csv"].map(of_shard));
    let merged = here.leafwise(&["merge", "shards", "--out", "merged"]);
    assert_eq!(merged.code, Some(0), "{}", merged.err);
}

#[test]
fn shards_with_a_part_of_their_files_are_told_of() {
    for (file, said) in [
        ("scene.toml", "it is not a whole scene"),
        (
            "checkpoint.bin",
            "shards/shard-2-of-3/checkpoint.bin is damaged",
        ),
        (
            "final_states.csv",
            "shards/shard-2-of-3/final_states.csv is damaged",
        ),
    ] {
        let here = in_shards();
        let path = here.path(&format!("shards/shard-2-of-3/{file}"));
        let bytes = std::fs::read(&path).expect("a file of the shard");
        std::fs::write(&path, &bytes[..bytes.len() / 3]).expect("written");
        let refused = here.leafwise(&["merge", "shards", "--out", "merged"]);
        assert_eq!(refused.code, Some(2), "{file}: {}", refused.err);
        refused.says(&[said, "make that shard again with --force"]);
        // The advice cures.
        let again = shard(&here, &["--shard", "2/3", "--force", "--quiet"]);
        assert_eq!(again.code, Some(0), "{file}: {}", again.err);
        let merged = here.leafwise(&["merge", "shards", "--out", "merged"]);
        assert_eq!(merged.code, Some(0), "{file}: {}", merged.err);
    }
}

#[test]
fn a_checkpoint_older_than_its_manifest_is_gone_on_from() {
    let here = in_shards();
    let whole = || here.leafwise(&["ensemble", "scene.toml", "--out", "whole", "--quiet"]);
    assert_eq!(whole().code, Some(0));
    let files = ["statistics.csv", "windows.csv", "final_states.csv"];
    let all = || files.map(|file| here.read(&format!("whole/{file}")));
    let before = all();
    let old = here.path("shards/shard-1-of-3/checkpoint.bin");
    std::fs::copy(old, here.path("whole/checkpoint.bin")).expect("copied");
    let again = whole();
    assert_eq!(again.code, Some(0), "{}", again.err);
    assert!(before == all());
    let told = here.leafwise(&["ensemble", "scene.toml", "--out", "whole"]);
    assert_eq!(told.code, Some(0), "{}", told.err);
    told.says(&["nothing was computed"]);
}

/// The members of another seed are not joined to these.
#[test]
fn a_checkpoint_of_another_scene_is_not_joined() {
    let here = in_shards();
    for number in 1..=3 {
        let set = ["--set", "ensemble.seed=9"];
        let place = format!("{number}/3");
        let arguments = [
            "ensemble",
            "scene.toml",
            "--out",
            "others",
            "--shard",
            &place,
            "--quiet",
        ];
        let made = here.leafwise(&[&arguments, &set[..]].concat());
        assert_eq!(made.code, Some(0), "{}", made.err);
    }
    let [own, other] = ["shards", "others"].map(|of| here.path(&format!("{of}/shard-2-of-3")));
    std::fs::copy(other.join("checkpoint.bin"), own.join("checkpoint.bin")).expect("copied");
    let refused = here.leafwise(&["merge", "shards", "--out", "merged"]);
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&[
        "shard-2-of-3/checkpoint.bin is damaged",
        "it is of another scene",
    ]);
}

#[test]
fn rows_behind_the_end_are_no_end() {
    let here = place();
    let whole = || here.leafwise(&["ensemble", "scene.toml", "--out", "whole"]);
    assert_eq!(whole().code, Some(0));
    let rows = here.read("whole/final_states.csv") + "1,2\n";
    here.write("whole/final_states.csv", &rows);
    let refused = whole();
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&["other data follow its last row", "--force"]);
}

#[test]
fn a_removal_that_fails_leaves_nothing_that_looks_whole() {
    let here = place();
    let whole = |force: &[&str]| {
        let arguments = ["ensemble", "scene.toml", "--out", "whole"];
        here.leafwise(&[&arguments, force].concat())
    };
    assert_eq!(whole(&[]).code, Some(0));
    // A folder in the place of a file cannot be removed.
    let file = here.path("whole/final_states.csv");
    std::fs::remove_file(&file).expect("removed");
    std::fs::create_dir(&file).expect("a folder");
    let refused = whole(&["--force"]);
    assert_eq!(refused.code, Some(1), "{}", refused.err);
    let manifest = here.read("whole/manifest.json");
    assert!(manifest.contains("\"outcome\": \"running\""), "{manifest}");
    assert_ne!(whole(&[]).code, Some(0));
    std::fs::remove_dir(&file).expect("removed");
    assert_eq!(whole(&["--force"]).code, Some(0));
}

#[test]
fn what_is_no_shard_is_refused() {
    let here = place();
    for (asked, said) in [
        (["--shard", "4/3"], "shards are counted from 1 to 3"),
        (["--shard", "0/3"], "shards are counted from 1 to 3"),
        (["--shard", "three"], "`three` is not a shard"),
        (["--shard", "1/0"], "there is at least one"),
        (["--members", "0..65"], "both bounds are multiples of 64"),
        (["--members", "0-64"], "`0-64` is not a range of members"),
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
