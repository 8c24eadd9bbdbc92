//! Long times: cost against the largest errors of the invariants over T = 10⁶.

use std::time::Instant;

use leafwise::core::Walk;
use leafwise_benches::composed;

use crate::document::{Table, time};
use crate::hand::dop853;
use crate::hand::gauss::{gauss_4, gauss_6};
use crate::problems::{LotkaVolterra, Problem, RigidBody};

/// T.
const TIME: f64 = 1e6;

/// Invariants are looked at so often: every method is there at these instants.
const INSTANTS: usize = 10_000;

/// A system with its field and invariants by hand.
struct System<const D: usize> {
    title: &'static str,
    library: &'static str,
    initial: [f64; D],
    field: fn(&[f64; D]) -> [f64; D],
    energy: fn(&[f64; D]) -> f64,
    casimirs: &'static [fn(&[f64; D]) -> f64],
    /// Realization and orders of Hamilton–Jacobi with numbers of steps a unit of time.
    realization: &'static str,
    hamilton_jacobi: &'static [(usize, f64)],
    /// Numbers of steps a unit of time of the compositions of a splitting.
    splittings: &'static [(&'static str, f64)],
    /// The realization by coordinates with a constant tensor, and numbers of stages with steps a unit of time.
    lift: &'static str,
    lifted: &'static [(usize, f64)],
    /// Those of the Gauss methods of orders 4 and 6.
    gauss: [f64; 2],
}

/// What a run shows.
struct Found {
    method: String,
    setting: String,
    seconds: f64,
    operations: Option<u64>,
    energy: f64,
    casimirs: f64,
}

/// The largest relative errors of the invariants so far.
struct Watch<'a, const D: usize> {
    system: &'a System<D>,
    energy: f64,
    casimirs: f64,
}

impl<'a, const D: usize> Watch<'a, D> {
    fn of(system: &'a System<D>) -> Self {
        Self {
            system,
            energy: 0.0,
            casimirs: 0.0,
        }
    }

    fn look(&mut self, x: &[f64; D]) {
        let apart = |function: fn(&[f64; D]) -> f64| {
            let first = function(&self.system.initial);
            ((function(x) - first) / first).abs()
        };
        let larger = |a: f64, b: f64| if b > a || b.is_nan() { b } else { a };
        let energy = apart(self.system.energy);
        let casimirs = self.system.casimirs.iter().map(|c| apart(*c));
        let casimirs = casimirs.fold(self.casimirs, larger);
        self.energy = larger(self.energy, energy);
        self.casimirs = casimirs;
    }

    /// The errors of a run; `leg` goes on over the time between two instants, `None` where it cannot.
    fn run(
        mut self,
        method: String,
        setting: String,
        mut leg: impl FnMut(&mut [f64; D]) -> Option<()>,
        operations: impl FnOnce() -> Option<u64>,
    ) -> Option<Found> {
        let mut x = self.system.initial;
        let started = Instant::now();
        for _ in 0..INSTANTS {
            leg(&mut x)?;
            self.look(&x);
        }
        Some(Found {
            method,
            setting,
            seconds: started.elapsed().as_secs_f64(),
            operations: operations(),
            energy: self.energy,
            casimirs: self.casimirs,
        })
    }
}

impl<const D: usize> System<D> {
    /// A `[method]` table of ours in so many steps between two instants.
    fn ours(&self, name: &str, method: &str, steps: usize, setting: String) -> Option<Found> {
        let run = composed(&format!(
            "[system]\nlibrary = \"{}\"\n[method]\n{method}\ntime-step = 0.1\n[run]\ninitial = {:?}\nsteps = 1\n",
            self.library, self.initial
        ));
        let parameters = run.system.parameter_values();
        let step = TIME / (INSTANTS * steps) as f64;
        let map = run.method.map();
        let walk = Walk::new(map, &parameters, 1.0, step, &self.initial);
        let walk = std::cell::RefCell::new(walk);
        let leg = |x: &mut [f64; D]| {
            let mut walk = walk.borrow_mut();
            for _ in 0..steps {
                walk.step().ok()?;
            }
            x.copy_from_slice(walk.state());
            Some(())
        };
        let operations = || walk.borrow().statistics().operations;
        Watch::of(self).run(format!("**{name}**"), setting, leg, operations)
    }

    fn all(&self) -> Vec<Found> {
        let between = TIME / INSTANTS as f64;
        let mut found = Vec::new();
        for (name, rate) in self.splittings {
            let method = format!("stepper = \"splitting\"\ncomposition = \"{name}\"");
            let steps = (rate * between) as usize;
            let title = format!("splitting, {name}");
            found.extend(self.ours(&title, &method, steps, format!("{rate} steps")));
        }
        for (order, rate) in self.hamilton_jacobi {
            let realization = self.realization;
            let method = format!(
                "realization = \"{realization}\"\ndynamics = {{ name = \"hamilton-jacobi\", order = {order} }}"
            );
            let steps = (rate * between) as usize;
            let title = format!("{realization} + HJ {order}");
            found.extend(self.ours(&title, &method, steps, format!("{rate} steps")));
        }
        for (stages, rate) in self.lifted {
            let realization = self.lift;
            let method = format!(
                "realization = \"{realization}\"\ndynamics = {{ name = \"collective\", stages = {stages} }}"
            );
            let steps = (rate * between) as usize;
            let title = format!("{realization} + Gauss of {stages} stages");
            found.extend(self.ours(&title, &method, steps, format!("{rate} steps")));
        }
        for tolerance in [1e-6, 1e-9, 1e-12, 1e-15] {
            let method = format!("stepper = {{ name = \"taylor\", tolerance = {tolerance:e} }}");
            let setting = format!("tolerance {tolerance:.0e}");
            found.extend(self.ours("taylor", &method, 1, setting));
        }
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let leg = |x: &mut [f64; D]| {
                *x = dop853::integrate(self.field, *x, between, tolerance)?.0;
                Some(())
            };
            let (name, setting) = (
                "DOP853 by hand".to_owned(),
                format!("tolerance {tolerance:.0e}"),
            );
            found.extend(Watch::of(self).run(name, setting, leg, || None));
        }
        let [of_4, of_6] = self.gauss;
        let (gauss_4, gauss_6) = (gauss_4(), gauss_6());
        let steps = (of_4 * between) as usize;
        let leg = |x: &mut [f64; D]| {
            *x = gauss_4
                .integrate(self.field, *x, between / steps as f64, steps)
                .0;
            Some(())
        };
        let setting = format!("{of_4} steps");
        found.extend(Watch::of(self).run("Gauss 4 by hand".to_owned(), setting, leg, || None));
        let steps = (of_6 * between) as usize;
        let leg = |x: &mut [f64; D]| {
            *x = gauss_6
                .integrate(self.field, *x, between / steps as f64, steps)
                .0;
            Some(())
        };
        let setting = format!("{of_6} steps");
        found.extend(Watch::of(self).run("Gauss 6 by hand".to_owned(), setting, leg, || None));
        found.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        found
    }

    fn table(&self) -> String {
        let mut table = Table::new(&[
            "method",
            "steps a unit of time, or tolerance",
            "time",
            "operations",
            "energy",
            "Casimirs",
        ]);
        for found in self.all() {
            table.row(&[
                found.method,
                found.setting,
                time(found.seconds),
                found
                    .operations
                    .map_or_else(String::new, |n| format!("{n:.1e}")),
                format!("{:.0e}", found.energy),
                format!("{:.0e}", found.casimirs),
            ]);
        }
        format!(
            "{} from {:?}:\n\n{}",
            self.title,
            self.initial,
            table.finish()
        )
    }
}

const BODY: System<3> = System {
    title: RigidBody::TITLE,
    library: RigidBody::LIBRARY,
    initial: RigidBody::INITIAL,
    field: RigidBody::field,
    energy: |x| x[0] * x[0] / 2.0 + x[1] * x[1] / 1.5 + x[2] * x[2] / 2.5,
    casimirs: &[|x| x[0] * x[0] + x[1] * x[1] + x[2] * x[2]],
    realization: "so3-exponential",
    hamilton_jacobi: &[(6, 4.0), (10, 4.0)],
    splittings: &[("blanes-moan-4", 2.0), ("blanes-moan-6", 4.0)],
    lift: "clebsch",
    lifted: &[(4, 2.0), (8, 1.0)],
    gauss: [4.0, 4.0],
};

const VOLTERRA: System<3> = System {
    title: LotkaVolterra::TITLE,
    library: LotkaVolterra::LIBRARY,
    initial: LotkaVolterra::INITIAL,
    field: LotkaVolterra::field,
    energy: |x| 2.0 * x[0] + x[1] + 2.0 * x[2] + libm::log(x[1]) - 2.0 * libm::log(x[2]),
    casimirs: &[|x| 2.0 * libm::log(x[0]) + libm::log(x[1]) + libm::log(x[2])],
    realization: "log-canonical",
    hamilton_jacobi: &[(6, 8.0)],
    splittings: &[("blanes-moan-4", 8.0), ("kahan-li-8", 8.0)],
    lift: "logarithms",
    lifted: &[(8, 2.5), (8, 5.0)],
    gauss: [16.0, 16.0],
};

const TOP: System<6> = System {
    title: "Heavy top",
    library: "heavy-top",
    initial: [0.5, 1.0, 1.5, 0.6, 0.0, 0.8],
    field: |x| {
        let [m1, m2, m3, g1, g2, g3] = *x;
        let [w1, w2, w3] = [m1, m2 / 0.75, m3 / 1.25];
        [
            m2 * w3 - m3 * w2 + g2,
            m3 * w1 - m1 * w3 + 0.3 * g3 - g1,
            m1 * w2 - m2 * w1 - 0.3 * g2,
            g2 * w3 - g3 * w2,
            g3 * w1 - g1 * w3,
            g1 * w2 - g2 * w1,
        ]
    },
    energy: |x| x[0] * x[0] / 2.0 + x[1] * x[1] / 1.5 + x[2] * x[2] / 2.5 + 0.3 * x[3] + x[5],
    casimirs: &[
        |x| x[3] * x[3] + x[4] * x[4] + x[5] * x[5],
        |x| x[0] * x[3] + x[1] * x[4] + x[2] * x[5],
    ],
    realization: "lie-poisson",
    hamilton_jacobi: &[(4, 4.0)],
    splittings: &[("blanes-moan-4", 4.0), ("blanes-moan-6", 4.0)],
    lift: "clebsch",
    lifted: &[(8, 1.0), (8, 2.0)],
    gauss: [4.0, 4.0],
};

/// The tables.
pub fn tables() -> String {
    format!(
        "T = 10⁶; the largest errors of energy and Casimirs relative to their first values, at {INSTANTS} instants.\n\n\
         {}\n{}\n{}",
        BODY.table(),
        TOP.table(),
        VOLTERRA.table()
    )
}
