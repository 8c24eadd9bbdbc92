//! The methods that are compared on a scene.

use leafwise_core::dynamics::Generating;
use leafwise_core::part::{Family, ParameterSetting, PartInfo, PartKind, Settings};
use leafwise_core::registry::CompositionPart;
use leafwise_core::{Accuracy, Pieces};
use leafwise_scene::compose::Stepping;
use leafwise_scene::document::{MethodParts, MethodTable, PartUse};

use super::candidate::{Bench, Candidate};

/// A method on a scene, or why it does not fit.
pub struct Entry {
    /// The method as asked for.
    pub method: MethodTable,
    /// It built.
    pub candidate: Result<Candidate, String>,
}

/// The orders m at which Hamilton–Jacobi is tried when none are asked for.
const ORDERS: [usize; 6] = [2, 4, 6, 8, 10, 12];

/// Number of monomials in dS's last term above which no higher order is tried by itself. With each order their number
/// grows two- to fourfold, and the time to form them ten- to thirtyfold.
const MOST_MONOMIALS: usize = 300;

/// On a lattice: where an evaluation costs this many times that of order 2.
const MOST_WORK: u64 = 16;

/// Implicit steppers solve dense systems: beyond this dimension they are not tried.
const LARGEST_DENSE: usize = 96;

/// Why a method was not built, where whoever asked for the catalogue had no time left.
pub(super) const UNBUILT: &str = "the time ended before it was formed";

/// Catalogue while it is made: its scene, the orders asked for and the methods so far.
pub(super) struct Catalogue<'a> {
    bench: &'a Bench<'a>,
    /// The orders asked for.
    orders: Option<&'a [usize]>,
    /// Told each method before it is built; whether it is.
    progress: &'a mut dyn FnMut(&str) -> bool,
    entries: Vec<Entry>,
}

/// Builds the methods for a scene: its own, every exact realization and Karasev's series under Hamilton–Jacobi,
/// collective integrators, those of lifts among them, compositions, splitting, baselines. With `orders`, only methods
/// of these declared orders are kept beside the scene's own, and Hamilton–Jacobi is built at each of them. Calls
/// `progress` with each method before it is built. Where that returns `false`, the method is not built, the scene's own
/// apart.
pub fn catalogue(
    bench: &Bench<'_>,
    orders: Option<&[usize]>,
    progress: &mut dyn FnMut(&str) -> bool,
) -> Vec<Entry> {
    let mut catalogue = Catalogue {
        bench,
        orders,
        progress,
        entries: Vec::new(),
    };
    catalogue.fill();
    catalogue.entries
}

impl Catalogue<'_> {
    fn fill(&mut self) {
        let own = self.bench.own_method();
        if let Some(own) = &own {
            (self.progress)(&own.to_string());
            let candidate = Candidate::build(self.bench, own);
            self.entries.push(Entry {
                method: own.clone(),
                candidate,
            });
        }
        let cheapest = self.cheapest();
        for realization in self.realizations(cheapest.as_ref(), own.as_ref()) {
            for made in self.hamiltonians() {
                self.rising_orders(&realization, *made);
            }
        }
        self.truncations();
        if let Some(realization) = &cheapest {
            self.collective(realization);
        }
        self.lifts();
        if let Some(realization) = cheapest {
            let made = self.hamiltonians()[0];
            for order in [2, 4] {
                let dynamics = made.hamilton_jacobi(self.bench, order);
                let base = MethodTable::pair(realization.clone(), dynamics);
                self.compositions(&base, order);
            }
        }
        for family in [Family::Splitting, Family::Poisson] {
            let steppers = self.bench.registry().family(family).into_iter();
            for stepper in steppers.flat_map(compared) {
                let base = MethodTable::stepper(stepper.clone());
                let candidate = self.build(&base);
                // A setting for systems of a kind is no method of the others.
                let misfit = candidate.as_ref().is_err_and(|reason| reason != UNBUILT);
                if misfit && !stepper.parameters.is_empty() {
                    continue;
                }
                let pieces = candidate.as_ref().ok().map(|c| c.run.method.map().pieces());
                self.add_built(base.clone(), candidate);
                // One piece is the motion itself.
                let is_exact = family == Family::Splitting && pieces == Some(1);
                if let Some(pieces) = pieces.filter(|_| !is_exact) {
                    self.compositions(&base, 2);
                    if family == Family::Splitting {
                        self.factors(&stepper, pieces);
                    }
                }
            }
        }
        self.baselines();
    }

    /// Whether a declared order is asked for.
    fn wants(&self, order: usize) -> bool {
        self.orders.is_none_or(|orders| orders.contains(&order))
    }

    fn build(&mut self, method: &MethodTable) -> Result<Candidate, String> {
        if (self.progress)(&method.to_string()) {
            Candidate::build(self.bench, method)
        } else {
            Err(UNBUILT.to_owned())
        }
    }

    /// Builds a method and adds it unless it is there; tells whether it fits the scene.
    fn add(&mut self, method: MethodTable) -> bool {
        let candidate = self.build(&method);
        let fits = candidate.is_ok();
        self.add_built(method, candidate);
        fits
    }

    fn add_built(&mut self, method: MethodTable, candidate: Result<Candidate, String>) {
        let is_there = |entry: &Entry| match (&entry.candidate, &candidate) {
            (Ok(known), Ok(new)) => known.method == new.method,
            _ => entry.method == method,
        };
        let is_wanted = match &candidate {
            Ok(candidate) => self.wants(candidate.properties.order),
            Err(_) => true,
        };
        if is_wanted && !self.entries.iter().any(is_there) {
            self.entries.push(Entry { method, candidate });
        }
    }

    /// The exact realization that a scene with `realization = "auto"` takes.
    fn cheapest(&mut self) -> Option<PartUse> {
        let method = MethodTable::pair(PartUse::named("auto"), hamilton_jacobi(self.bench, 2));
        let candidate = self.build(&method).ok()?;
        let MethodParts::Pair { realization, .. } = candidate.method.parts else {
            return None;
        };
        Some(realization)
    }

    /// The realizations that Hamilton–Jacobi is tried over.
    fn realizations(
        &mut self,
        cheapest: Option<&PartUse>,
        own: Option<&MethodTable>,
    ) -> Vec<PartUse> {
        let mut realizations: Vec<PartUse> = cheapest.cloned().into_iter().collect();
        if let Some(MethodParts::Pair { realization, .. }) = own.map(|own| &own.parts) {
            realizations.push(realization.clone());
        }
        let parts = self.bench.registry().parts().into_iter();
        let names = parts.filter(|p| p.kind == PartKind::Realization);
        for part in names.map(|p| PartUse::named(p.name)) {
            let method = MethodTable::pair(part.clone(), hamilton_jacobi(self.bench, 2));
            let built = self.build(&method);
            if built.is_ok_and(|built| accuracy(&built) == Some(Accuracy::Exact)) {
                realizations.push(part);
            }
        }
        let mut kept: Vec<PartUse> = Vec::new();
        for realization in realizations {
            if !kept.iter().any(|known| same(known, &realization)) {
                kept.push(realization);
            }
        }
        kept
    }

    /// Hamiltonians that Hamilton–Jacobi is made from: H, and before it H less multiples of Casimirs where that is
    /// shorter.
    fn hamiltonians(&self) -> &'static [Made] {
        let own = self.bench.own();
        let is_lattice = matches!(own.method, Stepping::Lattice(_));
        let is_given = is_lattice || own.system.has_forces();
        let formulas = own.system.expressions().filter(|_| !is_given);
        let shorter = formulas.and_then(|system| system.energy_casimir().ok().flatten());
        match shorter {
            None => &[Made::OfH],
            Some(_) => &[Made::OfEnergyCasimir, Made::OfH],
        }
    }

    /// Hamilton–Jacobi of rising orders: those asked for, or until dS is too long.
    fn rising_orders(&mut self, realization: &PartUse, made: Made) {
        let of_order = |order: usize| {
            MethodTable::pair(realization.clone(), made.hamilton_jacobi(self.bench, order))
        };
        if let Some(orders) = self.orders {
            for order in orders.iter().filter(|m| m.is_multiple_of(2)) {
                self.add(of_order(*order));
            }
            return;
        }
        let mut of_order_two = None;
        for order in ORDERS {
            let method = of_order(order);
            let built = self.build(&method);
            // Truncated after n, a realization gains nothing from m above 2⌊n/2⌋ + 2.
            let is_wasted = match built.as_ref().ok().and_then(accuracy) {
                Some(Accuracy::Order(n)) => order > 2 * (n / 2),
                _ => false,
            };
            let is_long = is_wasted || self.is_long(&built, &mut of_order_two);
            self.add_built(method, built);
            // With forces all orders are one.
            if is_long || self.bench.own().system.has_forces() {
                break;
            }
        }
    }

    /// Karasev's series after n = m for each order, where the dynamics is not too long.
    fn truncations(&mut self) {
        let mut of_order_two = None;
        for order in ORDERS {
            let realization = self.bench.of_order(PartKind::Realization, order);
            let method = MethodTable::pair(realization, hamilton_jacobi(self.bench, order));
            let built = self.build(&method);
            let is_long = self.is_long(&built, &mut of_order_two);
            self.add_built(method, built);
            if is_long {
                break;
            }
        }
    }

    /// Whether a higher order is not worth a try, or the present one does not fit.
    fn is_long(&self, built: &Result<Candidate, String>, of_order_two: &mut Option<u64>) -> bool {
        let Ok(built) = built else {
            return true;
        };
        let work = lattice_work(built);
        *of_order_two = of_order_two.or(work);
        let heavy = match (work, *of_order_two) {
            (Some(work), Some(first)) => work > MOST_WORK * first,
            _ => false,
        };
        heavy || monomials(built) > MOST_MONOMIALS
    }

    fn collective(&mut self, realization: &PartUse) {
        let parts = self.bench.registry().compared(PartKind::Dynamics);
        for dynamics in parts.into_iter().flat_map(compared) {
            self.add(MethodTable::pair(realization.clone(), dynamics));
        }
    }

    /// Dynamics in coordinates in which the tensor is constant.
    fn lifts(&mut self) {
        let own = self.bench.own();
        if matches!(own.method, Stepping::Lattice(_)) || own.system.has_forces() {
            return;
        }
        for tried in self.bench.registry().over_lifts(&own.system) {
            let realization = PartUse::named(tried.realization.name);
            let dynamics = with(tried.dynamics, &tried.settings);
            self.add(MethodTable::pair(realization, dynamics));
        }
    }

    /// Compositions of a base that raise its order.
    fn compositions(&mut self, base: &MethodTable, order: usize) {
        for part in self.composition_parts() {
            if part.order > order && part.factors.is_none() {
                self.add(base.clone().composed(PartUse::named(part.info.name)));
            }
        }
    }

    /// Compositions of a splitting's factors; of three pieces in every order.
    fn factors(&mut self, stepper: &PartUse, pieces: usize) {
        let mut steppers = vec![stepper.clone()];
        if pieces == 3 {
            steppers.extend(ORDERS_OF_THREE.map(|order| stepper.clone().with("pieces", order)));
        }
        for part in self.composition_parts() {
            let own = match part.factors {
                None => 0,
                Some(Pieces::Any) => steppers.len(),
                // It puts the pieces in order by itself.
                Some(_) => 1,
            };
            for stepper in &steppers[..own] {
                let base = MethodTable::stepper(stepper.clone());
                self.add(base.composed(PartUse::named(part.info.name)));
            }
        }
    }

    fn composition_parts(&self) -> Vec<CompositionPart> {
        let registry = self.bench.registry();
        let parts = registry.compared(PartKind::Composition).into_iter();
        parts
            .filter_map(|info| registry.composition(info.name).ok())
            .collect()
    }

    fn baselines(&mut self) {
        let is_small = self.bench.own().dimension() <= LARGEST_DENSE;
        let registry = self.bench.registry();
        let mut baselines = registry.family(Family::Explicit);
        // A jet takes formulas.
        if self.bench.own().system.expressions().is_some() {
            baselines.extend(registry.family(Family::Series));
        }
        if is_small {
            baselines.extend(registry.family(Family::Implicit));
        }
        for baseline in baselines.into_iter().flat_map(compared) {
            self.add(MethodTable::stepper(baseline));
        }
    }
}

/// A part with each of the settings at which it is compared.
fn compared(part: &PartInfo) -> Vec<PartUse> {
    let settings = part.compared.map_or(&[][..], |compared| compared.settings);
    settings
        .iter()
        .map(|settings| with(part, settings))
        .collect()
}

/// A part with its settings.
fn with(part: &PartInfo, settings: &Settings) -> PartUse {
    let named = PartUse::named(part.name);
    let settings = settings.iter();
    settings.fold(named, |part, (name, value)| part.with(name, *value))
}

/// Hamiltonian that a Hamilton–Jacobi series is made from: H, or H less multiples of Casimirs.
#[derive(Clone, Copy)]
enum Made {
    OfH,
    OfEnergyCasimir,
}

impl Made {
    fn hamilton_jacobi(self, bench: &Bench<'_>, order: usize) -> PartUse {
        let part = hamilton_jacobi(bench, order);
        match self {
            Self::OfH => part,
            Self::OfEnergyCasimir => part.with("hamiltonian", "energy-casimir"),
        }
    }
}

/// Hamilton–Jacobi of an order; with forces the dynamics that takes them, whatever the order.
fn hamilton_jacobi(bench: &Bench<'_>, order: usize) -> PartUse {
    match bench.registry().of_forces() {
        Ok(part) if bench.own().system.has_forces() => PartUse::named(part.name),
        _ => bench.of_order(PartKind::Dynamics, order),
    }
}

/// The same part with the same parameters where both give them.
fn same(a: &PartUse, b: &PartUse) -> bool {
    let agrees = |(name, value): &(String, ParameterSetting)| {
        b.parameter(name).is_none_or(|other| other == value)
    };
    a.name == b.name && a.parameters.iter().all(agrees)
}

fn accuracy(candidate: &Candidate) -> Option<Accuracy> {
    match &candidate.run.method {
        Stepping::Lattice(lattice) => Some(lattice.base.method()?.realization().accuracy()),
        stepping => Some(stepping.written()?.realization().accuracy()),
    }
}

/// The monomials of dS's last term, or the nodes of its code; 0 where dS is not known.
fn monomials(candidate: &Candidate) -> usize {
    let written = candidate.run.method.written();
    let generating = written.and_then(|method| method.bisection().generating_function());
    match generating {
        Some(Generating::Polynomials(function)) => function
            .gradients
            .last()
            .map_or(0, |last| last.iter().map(|p| p.terms().len()).sum()),
        Some(Generating::Code(code)) => code.graph.len(),
        None => 0,
    }
}

/// Orders of three pieces, one of each two that are the reverse of each other. Reversal exchanges χ and χ*, and a
/// symmetric composition of them errs by about as much. Two pieces have one such order; four have twelve, which would
/// cost more to try than they gain.
const ORDERS_OF_THREE: [&str; 3] = ["1 2 3", "1 3 2", "2 1 3"];

/// Operations of one evaluation on a lattice.
fn lattice_work(candidate: &Candidate) -> Option<u64> {
    match &candidate.run.method {
        Stepping::Lattice(lattice) => Some(lattice.base.map().cost().work),
        _ => None,
    }
}
