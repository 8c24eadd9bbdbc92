//! Time to error: every contestant at the coarsest setting that reaches it.

use std::marker::PhantomData;
use std::time::Instant;

use leafwise::composition::Scheme;

use crate::contestants::{
    Adaptive, Contestant, HandDop853, HandGauss, HandSplitting, Kind, OdeSolvers, Ours, Solution,
};
use crate::document::{Table, time};
use crate::measure::{Quartiles, Run, interleaved};
use crate::problems::Problem;

/// Rounds of the interleaved measurement.
const ROUNDS: usize = 31;

/// Gauss 6 takes so many steps in a unit of time for the reference: what it errs by is then less than
/// what rounding does.
const REFERENCE_STEPS: f64 = 400.0;

/// The most steps in a unit of time that are tried.
const MOST_STEPS: f64 = 100.0;

/// The compositions that are tried.
const SCHEMES: [&str; 10] = [
    "triple-jump",
    "suzuki-4",
    "yoshida-6",
    "kahan-li-6",
    "kahan-li-8",
    "suzuki-umeno-8",
    "kahan-li-10",
    "sofroniou-spaletta-10",
    "blanes-moan-4",
    "blanes-moan-6",
];

/// A contestant at the setting that reaches an error.
pub struct Entry<'a> {
    contestant: &'a dyn Contestant,
    setting: usize,
    error: f64,
    solution: Solution,
}

fn others<P: Problem + 'static>() -> Vec<Box<dyn Contestant>> {
    let mut others: Vec<Box<dyn Contestant>> = vec![
        Box::new(OdeSolvers::<P>(PhantomData)),
        Box::new(HandGauss::<P, 3>::order_6()),
        Box::new(HandDop853::<P>(PhantomData)),
        Box::new(Adaptive::<P>::new("taylor")),
        Box::new(HandGauss::<P, 2>::order_4()),
        Box::new(HandGauss::<P, 1>::midpoint()),
    ];
    for name in SCHEMES {
        let scheme = Scheme::find(name).expect("a scheme");
        others.push(Box::new(HandSplitting::<P> {
            scheme: name,
            parts: scheme.parts(),
            problem: PhantomData,
        }));
    }
    others
}

/// Realization and Hamilton–Jacobi of these orders.
fn hamilton_jacobi<P: Problem + 'static>(orders: &[usize]) -> Vec<Box<dyn Contestant>> {
    let mut all: Vec<Box<dyn Contestant>> = Vec::new();
    for realization in P::REALIZATIONS {
        for hamiltonian in P::HAMILTONIANS {
            for m in orders {
                let method = format!(
                    "realization = {{ name = \"{realization}\" }}\n\
                     dynamics = {{ name = \"hamilton-jacobi\", order = {m}, \
                     hamiltonian = \"{hamiltonian}\" }}"
                );
                let of = match *hamiltonian {
                    "given" => String::new(),
                    other => format!(", {other}"),
                };
                all.push(Box::new(Ours::<P>::new(
                    format!("{realization} + HJ {m}{of}"),
                    Kind::HamiltonJacobi,
                    &method,
                    MOST_STEPS * P::TIME,
                )));
            }
        }
    }
    all
}

fn ours<P: Problem + 'static>(orders: &[usize]) -> Vec<Box<dyn Contestant>> {
    let mut ours = hamilton_jacobi::<P>(orders);
    let most = MOST_STEPS * P::TIME;
    for (stepper, value) in P::STEPPERS {
        for scheme in SCHEMES {
            let takes_factors = Scheme::find(scheme).is_some_and(|s| s.takes_factors());
            if takes_factors && !stepper.starts_with("splitting") {
                continue;
            }
            let method = format!("stepper = {value}\ncomposition = \"{scheme}\"");
            let name = format!("{stepper}, {scheme}");
            ours.push(Box::new(Ours::<P>::new(name, Kind::StepMap, &method, most)));
        }
    }
    for (name, value) in P::EXACT {
        let method = format!("stepper = {value}");
        let name = (*name).to_owned();
        ours.push(Box::new(Ours::<P>::new(name, Kind::StepMap, &method, most)));
    }
    ours
}

/// The largest difference; NaN where there is one.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, |m, d| if d > m || d.is_nan() { d } else { m })
}

/// The coarsest setting from which on the error stays below `target` for three settings.
pub fn reach<'a>(
    contestant: &'a dyn Contestant,
    reference: &[f64],
    target: f64,
) -> Option<Entry<'a>> {
    let mut found: Vec<(usize, f64, Solution)> = Vec::new();
    for setting in contestant.settings() {
        let solution = contestant.solve(setting);
        let error = solution
            .as_ref()
            .map_or(f64::INFINITY, |s| distance(&s.state, reference));
        match solution {
            Some(solution) if error <= target => found.push((setting, error, solution)),
            _ => found.clear(),
        }
        if found.len() == 3 {
            let (setting, error, solution) = found.swap_remove(0);
            return Some(Entry {
                contestant,
                setting,
                error,
                solution,
            });
        }
    }
    None
}

/// x(T) by two methods of different families, and how far they are apart.
fn reference<P: Problem + 'static>() -> (Vec<f64>, f64) {
    let dop853 = OdeSolvers::<P>(PhantomData).solve(112).expect("DOP853");
    let steps = (REFERENCE_STEPS * P::TIME) as usize;
    let gauss = HandGauss::<P, 3>::order_6().solve(steps).expect("Gauss 6");
    let apart = distance(&dop853.state, &gauss.state);
    (gauss.state, apart)
}

/// The tables of a problem.
pub fn tables<P: Problem + 'static>(targets: &[(f64, &[usize])]) -> String {
    let (reference, apart) = reference::<P>();
    let mut text = format!(
        "{} from {:?}, T = {}; the reference is known to {apart:.0e}.\n\n",
        P::TITLE,
        P::INITIAL,
        P::TIME
    );
    for (target, orders) in targets {
        let (others, ours) = (others::<P>(), ours::<P>(orders));
        let all = others.iter().chain(&ours);
        let entries: Vec<Entry<'_>> = all
            .filter_map(|contestant| reach(contestant.as_ref(), &reference, *target))
            .collect();
        text.push_str(&format!("Error {target:.0e}:\n\n"));
        let baselines = [
            others[0].name(),
            others[1].name(),
            others[2].name(),
            others[3].name(),
        ];
        let (entries, slow) = without_slow(entries, &baselines);
        if !slow.is_empty() {
            text.push_str(&format!(
                "More than {SLOW} times as slow as {}: {}.\n\n",
                baselines[0],
                slow.join(", ")
            ));
        }
        let race = race(&entries, &baselines);
        text.push_str(&format!("{race}\n"));
    }
    text
}

/// The table of a problem for each of three errors, without the slow.
fn beside_one_another<P: Problem + 'static>(
    all: &[Box<dyn Contestant>],
    baselines: &[String],
) -> String {
    let (reference, apart) = reference::<P>();
    let mut text = format!(
        "{}, T = {}; the reference is known to {apart:.0e}.\n\n",
        P::TITLE,
        P::TIME
    );
    for target in [1e-4, 1e-8, 1e-12] {
        let entries: Vec<Entry<'_>> = all
            .iter()
            .filter_map(|contestant| reach(contestant.as_ref(), &reference, target))
            .collect();
        let (entries, _) = without_slow(entries, baselines);
        let race = race(&entries, baselines);
        text.push_str(&format!("Error {target:.0e}:\n\n{race}\n"));
    }
    text
}

/// The methods without structure that choose their steps, beside each other and beside Hamilton–Jacobi of high orders.
pub fn adaptive<P: Problem + 'static>() -> String {
    let mut all: Vec<Box<dyn Contestant>> = vec![
        Box::new(OdeSolvers::<P>(PhantomData)),
        Box::new(HandDop853::<P>(PhantomData)),
        Box::new(Adaptive::<P>::new("taylor")),
        Box::new(Adaptive::<P>::new("dop853")),
    ];
    let baselines = [0, 1, 2].map(|at: usize| all[at].name());
    all.extend(hamilton_jacobi::<P>(&[8, 10, 12]));
    beside_one_another::<P>(&all, &baselines)
}

/// Gauss methods in coordinates with a constant tensor, beside `taylor` and other Poisson maps.
pub fn lifts<P: Problem + 'static>() -> String {
    let most = MOST_STEPS * P::TIME;
    let mut all: Vec<Box<dyn Contestant>> = vec![
        Box::new(Adaptive::<P>::new("taylor")),
        Box::new(HandDop853::<P>(PhantomData)),
    ];
    let baselines = [0, 1].map(|at: usize| all[at].name());
    for stages in [2, 4, 8, 16] {
        let method = format!(
            "realization = \"{}\"\ndynamics = {{ name = \"collective\", stages = {stages} }}",
            P::LIFT
        );
        let name = format!("{} + Gauss of {stages} stages", P::LIFT);
        all.push(Box::new(Ours::<P>::new(name, Kind::StepMap, &method, most)));
    }
    all.extend(hamilton_jacobi::<P>(&[8, 10]));
    for (stepper, value) in P::STEPPERS
        .iter()
        .filter(|(name, _)| name.starts_with("splitting"))
    {
        for scheme in ["blanes-moan-6", "kahan-li-8"] {
            let method = format!("stepper = {value}\ncomposition = \"{scheme}\"");
            let name = format!("{stepper}, {scheme}");
            all.push(Box::new(Ours::<P>::new(name, Kind::StepMap, &method, most)));
        }
    }
    beside_one_another::<P>(&all, &baselines)
}

/// Entries that take more than this many times what the first baseline takes are not measured further.
const SLOW: f64 = 10.0;

/// The entries to be measured, the baselines in any case, and the names of those that are too slow.
fn without_slow<'a>(
    entries: Vec<Entry<'a>>,
    baselines: &[String],
) -> (Vec<Entry<'a>>, Vec<String>) {
    let once = |entry: &Entry<'_>| {
        let started = Instant::now();
        std::hint::black_box(entry.contestant.solve(entry.setting));
        started.elapsed().as_secs_f64()
    };
    let seconds: Vec<f64> = entries.iter().map(|e| once(e).min(once(e))).collect();
    let first = entries
        .iter()
        .position(|e| e.contestant.name() == baselines[0]);
    let most = first.map_or(f64::INFINITY, |at| SLOW * seconds[at]);
    let (fast, slow): (Vec<_>, Vec<_>) =
        entries
            .into_iter()
            .zip(seconds)
            .partition(|(entry, seconds)| {
                *seconds <= most || baselines.contains(&entry.contestant.name())
            });
    (
        fast.into_iter().map(|(entry, _)| entry).collect(),
        slow.iter().map(|(e, _)| e.contestant.name()).collect(),
    )
}

/// Times all entries in turn, the fastest first in the table, with ratios to those `baselines` that
/// reach the error.
pub fn race(entries: &[Entry<'_>], baselines: &[String]) -> String {
    let mut runs: Vec<Run<'_>> = entries
        .iter()
        .map(|entry| -> Run<'_> {
            Box::new(|| {
                std::hint::black_box(entry.contestant.solve(entry.setting));
            })
        })
        .collect();
    let times = interleaved(&mut runs, ROUNDS);
    let seconds = |at: usize| times.seconds(at).median;
    let mut order: Vec<usize> = (0..entries.len()).collect();
    order.sort_by(|a, b| seconds(*a).total_cmp(&seconds(*b)));
    let find = |name: &String| entries.iter().position(|e| e.contestant.name() == *name);
    let baselines: Vec<(usize, String)> = baselines
        .iter()
        .filter_map(|name| Some((find(name)?, name)))
        .map(|(at, name)| (at, format!("over {name}")))
        .collect();
    let headings = ["method", "time"].into_iter();
    let headings = headings.chain(baselines.iter().map(|(_, heading)| heading.as_str()));
    let headings: Vec<&str> = headings
        .chain([
            "error",
            "steps or tolerance",
            "evaluations",
            "operations",
            "Casimir",
            "tensor defect",
        ])
        .collect();
    let mut table = Table::new(&headings);
    for at in order {
        let Entry {
            contestant,
            setting,
            error,
            solution,
        } = &entries[at];
        let (drift, defect) = match contestant.structure(*setting) {
            None => (String::new(), String::new()),
            Some((drift, defect)) => (
                format!("{drift:.0e}"),
                defect.map_or_else(|| "—".to_owned(), |d| format!("{d:.0e}")),
            ),
        };
        let name = match contestant.kind() {
            Kind::Other => contestant.name(),
            _ => format!("**{}**", contestant.name()),
        };
        let mut cells = vec![name, time(seconds(at))];
        cells.extend(
            baselines
                .iter()
                .map(|(baseline, _)| ratio(times.ratio(at, *baseline))),
        );
        cells.extend([
            format!("{error:.1e}"),
            contestant.tell(*setting),
            solution.evaluations.to_string(),
            solution
                .operations
                .map_or_else(String::new, |n| n.to_string()),
            drift,
            defect,
        ]);
        table.row(&cells);
    }
    table.finish()
}

/// A median with its quartiles.
pub fn ratio(quartiles: Quartiles) -> String {
    let Quartiles { low, median, high } = quartiles;
    format!("{median:.2} ({low:.2}–{high:.2})")
}
