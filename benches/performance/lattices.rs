//! The Volterra lattice on a ring: time to error against DOP853, and time and memory by length.

use std::process::Command;

use leafwise::composition::Scheme;
use leafwise::core::Walk;
use leafwise::scene::ComposedRun;
use leafwise_benches::composed;
use ode_solvers::dop_shared::OutputType;
use ode_solvers::{DVector, Dop853, System};

use crate::accuracy::{Entry, race, reach};
use crate::contestants::{Contestant, Kind, Solution, step_numbers, tell_tolerance, tolerances};
use crate::document::{Table, time};
use crate::hand::splitting::{Flows, exponential, integrate};
use crate::measure::Quartiles;

/// Sites of the comparison.
const SITES: usize = 1024;

/// T.
const TIME: f64 = 50.0;

/// The wave that the scene starts from.
fn initial() -> Vec<f64> {
    let site = |i: usize| 2.0 * std::f64::consts::PI * i as f64 / SITES as f64;
    (0..SITES).map(|i| 1.0 + 0.1 * libm::sin(site(i))).collect()
}

/// The scene of a ring of any length, with a `[method]` table.
fn scene(sites: usize, method: &str) -> ComposedRun {
    composed(&format!(
        "[system]\nlibrary = \"volterra-lattice\"\nfamilies = {{ x = {sites} }}\n\
         [method]\n{method}\ntime-step = 0.1\n\
         [run]\ninitial = {{ \"x[i]\" = \"1 + 0.1*sin(2*pi*i/N)\" }}\nsteps = 1\n"
    ))
}

struct Ring;

/// ẋ_i = x_i (x_{i+1} − x_{i−1}).
impl System<f64, DVector<f64>> for Ring {
    fn system(&self, _time: f64, x: &DVector<f64>, slope: &mut DVector<f64>) {
        let (x, slope) = (x.as_slice(), slope.as_mut_slice());
        let last = x.len() - 1;
        slope[0] = x[0] * (x[1] - x[last]);
        for (i, window) in x.windows(3).enumerate() {
            slope[i + 1] = window[1] * (window[2] - window[0]);
        }
        slope[last] = x[last] * (x[0] - x[last - 1]);
    }
}

struct Dop853OfRing;

impl Contestant for Dop853OfRing {
    fn name(&self) -> String {
        "`ode_solvers` DOP853".to_owned()
    }

    fn kind(&self) -> Kind {
        Kind::Other
    }

    fn settings(&self) -> Vec<usize> {
        tolerances()
    }

    fn tell(&self, setting: usize) -> String {
        tell_tolerance(setting)
    }

    fn solve(&self, setting: usize) -> Option<Solution> {
        let tolerance = libm::pow(10.0, -(setting as f64) / 8.0);
        let initial = DVector::from_vec(initial());
        let mut solver = Dop853::new(Ring, 0.0, TIME, TIME, initial, tolerance, tolerance);
        solver.set_output(OutputType::Sparse);
        let statistics = solver.integrate().ok()?;
        Some(Solution {
            state: solver.y_out().last()?.as_slice().to_vec(),
            evaluations: statistics.num_eval.into(),
            operations: None,
        })
    }
}

/// Half of H lies on the even sites and moves the odd ones, and the other way round.
impl Flows for Ring {
    type State = Vec<f64>;
    const PIECES: usize = 2;

    #[inline(always)]
    fn flow(piece: usize, x: &mut Vec<f64>, time: f64) {
        let last = x.len() - 1;
        if piece == 1 {
            x[0] *= exponential(time * (x[1] - x[last]));
        }
        for i in (1 + piece..last).step_by(2) {
            x[i] *= exponential(time * (x[i + 1] - x[i - 1]));
        }
        if piece == 0 {
            x[last] *= exponential(time * (x[0] - x[last - 1]));
        }
    }
}

struct HandSplittingOfRing(&'static str);

impl Contestant for HandSplittingOfRing {
    fn name(&self) -> String {
        format!("splitting by hand, {}", self.0)
    }

    fn kind(&self) -> Kind {
        Kind::Other
    }

    fn settings(&self) -> Vec<usize> {
        step_numbers(0.1 * TIME, 100.0 * TIME)
    }

    fn solve(&self, setting: usize) -> Option<Solution> {
        let parts = Scheme::find(self.0)?.parts();
        let mut state = initial();
        integrate::<Ring>(&parts, &mut state, TIME / setting as f64, setting);
        Some(Solution {
            state,
            evaluations: (parts.len() / 2 * setting) as u64,
            operations: None,
        })
    }
}

struct OursOfRing {
    name: String,
    kind: Kind,
    run: ComposedRun,
}

impl OursOfRing {
    fn new(name: &str, kind: Kind, method: &str) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            run: scene(SITES, method),
        }
    }

    fn walk(&self, steps: usize) -> Walk {
        let map = self.run.method.map();
        Walk::new(map, &[], 1.0, TIME / steps as f64, &self.run.plan.initial)
    }
}

impl Contestant for OursOfRing {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn kind(&self) -> Kind {
        self.kind
    }

    fn settings(&self) -> Vec<usize> {
        step_numbers(0.1 * TIME, 100.0 * TIME)
    }

    fn solve(&self, setting: usize) -> Option<Solution> {
        let mut walk = self.walk(setting);
        for _ in 0..setting {
            walk.step().ok()?;
        }
        let statistics = walk.statistics();
        Some(Solution {
            state: walk.state().to_vec(),
            evaluations: statistics.evaluations,
            operations: statistics.operations,
        })
    }

    /// Σ ln x over the even and over the odd sites, relative to the sum of the summands' sizes.
    fn structure(&self, setting: usize) -> Option<(f64, Option<f64>)> {
        let casimirs = |x: &[f64]| {
            [0, 1].map(|parity| {
                let logarithms = x.iter().skip(parity).step_by(2).map(|x| libm::log(*x));
                logarithms.fold((0.0, 0.0), |(sum, size), l| (sum + l, size + l.abs()))
            })
        };
        let mut walk = self.walk(setting);
        let before = casimirs(walk.state());
        let mut drift = 0.0_f64;
        for _ in 0..setting {
            walk.step().ok()?;
            for (now, before) in casimirs(walk.state()).iter().zip(before) {
                drift = drift.max((now.0 - before.0).abs() / before.1);
            }
        }
        Some((drift, None))
    }
}

fn contestants() -> Vec<Box<dyn Contestant>> {
    let mut all: Vec<Box<dyn Contestant>> = vec![Box::new(Dop853OfRing)];
    for scheme in [
        "suzuki-4",
        "blanes-moan-4",
        "blanes-moan-6",
        "kahan-li-6",
        "yoshida-6",
        "kahan-li-8",
    ] {
        all.push(Box::new(HandSplittingOfRing(scheme)));
        let composition = format!("composition = \"{scheme}\"");
        let splitting = format!("stepper = \"splitting\"\n{composition}");
        let name = format!("splitting, {scheme}");
        all.push(Box::new(OursOfRing::new(&name, Kind::StepMap, &splitting)));
        if scheme.starts_with("blanes-moan") {
            continue;
        }
        let method = format!(
            "realization = {{ name = \"karasev-truncated\", order = 2 }}\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\n{composition}"
        );
        let name = format!("karasev-truncated 2 + HJ 2, {scheme}");
        all.push(Box::new(OursOfRing::new(
            &name,
            Kind::HamiltonJacobi,
            &method,
        )));
    }
    all
}

/// The ring of 1024 sites.
pub fn accuracy() -> String {
    let all = contestants();
    let finest = Dop853OfRing.solve(112).expect("DOP853").state;
    let splitting = HandSplittingOfRing("kahan-li-8");
    let other = splitting
        .solve(40 * TIME as usize)
        .expect("splitting")
        .state;
    let apart = crate::accuracy::distance(&finest, &other);
    let entries: Vec<Entry<'_>> = all
        .iter()
        .filter_map(|contestant| reach(contestant.as_ref(), &other, 1e-4))
        .collect();
    format!(
        "N = {SITES}, T = {TIME}, error 1e-4 (maximum norm); the reference is known to {apart:.0e}.\n\n{}\n",
        race(&entries, &[Dop853OfRing.name()])
    )
}

/// Steps in one measurement of a length.
const STEPS: usize = 10;

/// The argument by which the program measures one length in a process of its own.
pub const SIZE_ARGUMENT: &str = "lattice-of";

/// Time and memory by length, each length in a process of its own.
pub fn sizes() -> String {
    let mut table = Table::new(&[
        "sites",
        "scene to first step",
        "a step",
        "a site and step",
        "memory at most",
        "bytes a site",
    ]);
    let program = std::env::current_exe().expect("this program");
    for sites in [1_000, 10_000, 100_000, 1_000_000] {
        let output = Command::new(&program)
            .args([SIZE_ARGUMENT, &sites.to_string()])
            .output()
            .expect("this program again");
        let text = String::from_utf8_lossy(&output.stdout);
        let numbers: Vec<f64> = text
            .split_whitespace()
            .map(|word| word.parse().expect("a number"))
            .collect();
        let [first, step, memory] = numbers.as_slice().try_into().expect("three numbers");
        table.row(&[
            sites.to_string(),
            time(first),
            time(step),
            time(step / f64::from(sites)),
            format!("{:.0} MB", memory / 1e6),
            format!("{:.0}", memory / f64::from(sites)),
        ]);
    }
    format!(
        "`splitting`, `suzuki-4`, T/N = 0.1:\n\n{}\n",
        table.finish()
    )
}

/// One length: seconds to the first step, seconds a step, the largest resident memory in bytes.
pub fn measure_size(sites: usize) -> [f64; 3] {
    let started = std::time::Instant::now();
    let run = scene(sites, "stepper = \"splitting\"\ncomposition = \"suzuki-4\"");
    let mut walk = run.walk();
    walk.step().expect("a step");
    let first = started.elapsed().as_secs_f64();
    let times = (0..STEPS).map(|_| {
        let started = std::time::Instant::now();
        walk.step().expect("a step");
        started.elapsed().as_secs_f64()
    });
    let step = Quartiles::of(times.collect()).median;
    [first, step, peak_memory()]
}

/// The largest resident memory of this process in bytes, where the system tells; else NaN.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kilobytes.map_or(f64::NAN, |kilobytes| kilobytes * 1024.0)
}
