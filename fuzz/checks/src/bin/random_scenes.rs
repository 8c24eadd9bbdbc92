//! Judges many random scenes and prints a table: `random-scenes --count 10000 --seed 1 --threads 2`, or one of them
//! with its text: `random-scenes --replay SEED:INDEX`.

#![allow(clippy::print_stdout, reason = "a program that prints a table")]

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use leafwise::core::Registry;
use leafwise_fuzz_checks::judge::{Verdict, judge};
use leafwise_fuzz_checks::scene::RandomScene;
use leafwise_fuzz_checks::source::{Source, random_bytes};
use leafwise_fuzz_checks::{Reached, lattices};

/// Enough for every choice of a scene.
const BYTES: usize = 1024;

/// Seconds after which a scene is reported as slow.
const SLOW: f64 = 10.0;

struct Arguments {
    count: u64,
    seed: u64,
    threads: u64,
    replay: Option<(u64, u64)>,
}

fn arguments() -> Result<Arguments, String> {
    let mut given = Arguments {
        count: 10_000,
        seed: 1,
        threads: 1,
        replay: None,
    };
    let mut words = std::env::args().skip(1);
    while let Some(name) = words.next() {
        let value = words.next().ok_or(format!("{name} needs a value"))?;
        let number = |text: &str| {
            text.parse()
                .map_err(|_| format!("{name}: not a whole number: {text}"))
        };
        match name.as_str() {
            "--count" => given.count = number(&value)?,
            "--seed" => given.seed = number(&value)?,
            "--threads" => given.threads = number(&value)?,
            "--replay" => {
                let (seed, index) = value.split_once(':').ok_or("--replay SEED:INDEX")?;
                given.replay = Some((number(seed)?, number(index)?));
            }
            _ => {
                return Err(format!(
                    "unknown {name}; --count, --seed, --threads, --replay SEED:INDEX"
                ));
            }
        }
    }
    Ok(given)
}

fn scene(seed: u64, index: u64) -> RandomScene {
    RandomScene::drawn(&mut Source::new(&random_bytes(seed, index, BYTES)))
}

/// Every so many scenes one is a long lattice.
const LATTICES: u64 = 16;

/// The verdict on a scene; a long lattice is compared with itself written out.
fn verdict(seed: u64, index: u64, registry: &Registry) -> Verdict {
    if index % LATTICES != LATTICES - 1 {
        return judge(&scene(seed, index), registry);
    }
    let checked = catch_unwind(AssertUnwindSafe(|| {
        lattices::check(&random_bytes(seed, index, BYTES))
    }));
    match checked {
        Ok(Ok(Reached::Comparison)) => Verdict::Confirmed,
        Ok(Ok(Reached::Refusal)) => Verdict::Refused("a lattice".to_owned()),
        Ok(Err(what)) => Verdict::Suspicious(format!("a lattice: {what}")),
        Err(_) => Verdict::Suspicious("a lattice panics".to_owned()),
    }
}

/// How many scenes came to each verdict, and the first of each kind.
#[derive(Default)]
struct Tally {
    verdicts: BTreeMap<Verdict, (u64, u64)>,
    suspicious: Vec<(u64, String)>,
    slowest: Vec<(f64, u64)>,
}

impl Tally {
    fn take(&mut self, index: u64, verdict: Verdict, seconds: f64) {
        let verdict = match verdict {
            Verdict::Suspicious(why) => {
                println!("suspicious {index}: {why}");
                self.suspicious.push((index, why.clone()));
                let kind = why.split(':').next().unwrap_or_default();
                Verdict::Suspicious(kind.chars().filter(|c| !c.is_ascii_digit()).collect())
            }
            other => other,
        };
        self.verdicts.entry(verdict).or_insert((0, index)).0 += 1;
        if seconds > SLOW {
            println!("slow {index}: {seconds:.1} s");
        }
        self.slowest.push((seconds, index));
        self.slowest.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.slowest.truncate(5);
    }

    fn print(&self, scenes: u64, seconds: f64) {
        println!("\n{scenes} scenes in {seconds:.0} s");
        for (verdict, (count, first)) in &self.verdicts {
            let (group, kind) = match verdict {
                Verdict::Refused(kind) => ("refused", kind.as_str()),
                Verdict::Failed(kind) => ("failed", kind.as_str()),
                Verdict::Warned(kind) => ("warned", kind.as_str()),
                Verdict::Confirmed => ("confirmed", ""),
                Verdict::Unresolved => ("unresolved", ""),
                Verdict::Suspicious(kind) => ("suspicious", kind.as_str()),
            };
            println!("{count:9}  {group:10}  {kind}  (first: {first})");
        }
        println!("slowest: {:.1?}", self.slowest);
    }
}

fn main() -> ExitCode {
    let given = match arguments() {
        Ok(given) => given,
        Err(message) => {
            println!("{message}");
            return ExitCode::from(2);
        }
    };
    let registry = Registry::with_builtin();
    if let Some((seed, index)) = given.replay {
        if index % LATTICES != LATTICES - 1 {
            println!("{}", scene(seed, index).text);
        }
        println!("{:?}", verdict(seed, index, &registry));
        return ExitCode::SUCCESS;
    }
    let (next, tally, started) = (
        AtomicU64::new(0),
        Mutex::new(Tally::default()),
        Instant::now(),
    );
    let work = || loop {
        let index = next.fetch_add(1, Ordering::Relaxed);
        if index >= given.count {
            return;
        }
        let begun = Instant::now();
        let verdict = verdict(given.seed, index, &registry);
        let mut tally = tally
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        tally.take(index, verdict, begun.elapsed().as_secs_f64());
        if (index + 1).is_multiple_of(given.count.div_ceil(10)) {
            tally.print(index + 1, started.elapsed().as_secs_f64());
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..given.threads {
            scope.spawn(work);
        }
    });
    let tally = tally
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    tally.print(given.count, started.elapsed().as_secs_f64());
    match tally.suspicious.is_empty() {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}
