//! Random lattices: templates with offsets near and far, and what they mean written out site by site.

use crate::source::Source;
use crate::tree::Tree;

/// A family at an offset from the index of its template.
pub type Slot = (usize, i64);

/// A formula of a template over its slots.
#[derive(Clone, Debug)]
pub struct Template {
    /// The families and offsets that the variables of the formula stand for.
    pub slots: Vec<Slot>,
    /// The formula.
    pub formula: Tree,
}

/// An entry of the bracket: {a, b} at every site.
#[derive(Clone, Debug)]
pub struct Entry {
    pair: [Slot; 2],
    value: Template,
}

/// A lattice with what it means, apart from the program's own reading.
#[derive(Clone, Debug)]
pub struct RandomLattice {
    families: Vec<(&'static str, usize)>,
    /// How many of the families move: parameters of sites stand behind them.
    moving: usize,
    /// Whether site N − 1 is beside site 0.
    pub is_ring: bool,
    entries: Vec<Entry>,
    terms: Vec<Template>,
    observable: Template,
    /// The families' values at the start.
    initial: Vec<Start>,
    /// Whether every coordinate stays positive.
    is_positive: bool,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Canonical,
    LogCanonical,
    Toda,
    Spins,
}

impl RandomLattice {
    /// A lattice from bytes.
    pub fn drawn(source: &mut Source<'_>) -> Self {
        let is_ring = source.chance(128);
        let length = match source.below(8) {
            0 => 25 + source.below(176),
            _ => 25 + source.below(76),
        };
        let kind = source.pick(&[
            Kind::Canonical,
            Kind::Canonical,
            Kind::LogCanonical,
            Kind::Toda,
            Kind::Spins,
        ]);
        let shorter = length - usize::from(!is_ring && source.chance(128));
        let (mut families, moving) = match kind {
            Kind::Canonical => (vec![("q", length), ("p", length)], 2),
            Kind::LogCanonical => (vec![("x", length)], 1),
            Kind::Toda => (vec![("a", shorter), ("b", length)], 2),
            Kind::Spins => (vec![("x", length), ("y", length), ("z", length)], 3),
        };
        let has_field = source.chance(100);
        if has_field {
            families.push(("w", length));
        }
        let mut lattice = Self {
            families,
            moving,
            is_ring,
            entries: Vec::new(),
            terms: Vec::new(),
            observable: Template {
                slots: Vec::new(),
                formula: Tree::Number(0.0),
            },
            initial: Vec::new(),
            is_positive: matches!(kind, Kind::LogCanonical),
            kind,
        };
        lattice.entries = lattice.bracket(source);
        lattice.terms = lattice.hamiltonian(source);
        lattice.observable = lattice.coupling(source);
        lattice.initial = (lattice.families.iter())
            .map(|_| Start::drawn(source, lattice.is_positive))
            .collect();
        lattice
    }

    fn bracket(&self, source: &mut Source<'_>) -> Vec<Entry> {
        let x = |at: usize| Tree::Variable(at);
        let entry = |a: Slot, b: Slot, value: Template| Entry {
            pair: [a, b],
            value,
        };
        let constant = |value: f64| Template {
            slots: Vec::new(),
            formula: Tree::Number(value),
        };
        let product = |slots: &[Slot], factor: f64| Template {
            slots: slots.to_vec(),
            formula: (0..slots.len())
                .map(x)
                .fold(Tree::Number(factor), |product, slot| {
                    Tree::Product(vec![product, slot])
                }),
        };
        match self.kind {
            Kind::Canonical => {
                // Mostly pairs at one site.
                let beside = if source.chance(48) { offset(source) } else { 0 };
                vec![entry((0, 0), (1, beside), constant(-1.0))]
            }
            Kind::LogCanonical => {
                let mut entries = Vec::new();
                let mut known = Vec::new();
                for _ in 0..1 + source.below(2) {
                    let (start, apart) = (offset(source) / 2, positive_offset(source));
                    let length = self.length() as i64;
                    // An entry that meets itself on the ring is none, and two of a pair contradict each other.
                    let is_free = |k: i64| {
                        known
                            .iter()
                            .all(|other: &i64| *other != k && (*other + k) % length != 0)
                    };
                    if apart % length == 0 || 2 * apart % length == 0 || !is_free(apart % length) {
                        continue;
                    }
                    known.push(apart % length);
                    let ends = [(0, start), (0, start + apart)];
                    entries.push(entry(
                        ends[0],
                        ends[1],
                        product(&ends, source.decimal(0.2, 1.0).max(0.2)),
                    ));
                }
                entries
            }
            Kind::Toda => {
                let apart = positive_offset(source);
                if self.is_ring && apart % self.length() as i64 == 0 {
                    return vec![entry((0, 0), (1, 0), product(&[(0, 0)], -1.0))];
                }
                vec![
                    entry((0, 0), (1, 0), product(&[(0, 0)], -1.0)),
                    entry((0, 0), (1, apart), product(&[(0, 0)], 1.0)),
                ]
            }
            Kind::Spins => (0..3)
                .map(|c| entry((c, 0), ((c + 1) % 3, 0), product(&[((c + 2) % 3, 0)], -1.0)))
                .collect(),
        }
    }

    fn hamiltonian(&self, source: &mut Source<'_>) -> Vec<Template> {
        let alone = |family: usize, formula: Tree| Template {
            slots: vec![(family, 0)],
            formula,
        };
        let x = || Tree::Variable(0);
        let mut terms = match self.kind {
            Kind::Canonical => vec![alone(1, x().to(2).times(0.5))],
            Kind::LogCanonical => vec![alone(0, x())],
            Kind::Toda => vec![alone(1, x().to(2).times(0.5)), alone(0, x().to(2))],
            Kind::Spins => vec![alone(2, x().times(source.decimal(-1.0, 1.0)))],
        };
        for _ in 0..1 + source.below(3) {
            terms.push(self.coupling(source));
        }
        if self.families.len() > self.moving {
            let (own, field) = (source.below(self.moving), offset(source));
            terms.push(Template {
                slots: vec![(own, 0), (self.moving, field)],
                formula: Tree::Product(vec![
                    Tree::Variable(0).to(1 + source.below(2) as i32),
                    Tree::Variable(1),
                ])
                .times(0.3),
            });
        }
        terms
    }

    /// A term that couples two or three sites.
    fn coupling(&self, source: &mut Source<'_>) -> Template {
        let family = match self.kind {
            // Positions are coupled, now and then positions and momenta.
            Kind::Canonical if source.chance(220) => 0,
            _ => source.below(self.moving),
        };
        // Now and then the index is beside what it names.
        let start = if source.chance(64) { offset(source) } else { 0 };
        let slots = vec![(family, start), (family, start + offset(source))];
        let (u, v) = (|| Tree::Variable(0), || Tree::Variable(1));
        let apart = || Tree::Sum(vec![(false, v()), (true, u())]);
        let c = match source.decimal(-0.5, 0.5) {
            0.0 => 0.25,
            c => c,
        };
        let formula = match (self.kind, source.below(8)) {
            (Kind::Spins | Kind::LogCanonical, 0..=5) | (_, 0 | 1) => Tree::Product(vec![u(), v()]),
            (_, 2 | 3) => apart().to(2),
            (_, 4) => apart().to(4).times(0.25),
            (_, 5) => apart().under(leafwise::expression::Function::Cos),
            (_, 6) => apart()
                .to(2)
                .shifted(1.0)
                .under(leafwise::expression::Function::Sqrt),
            _ => {
                let far = (family, offset(source));
                let slots = vec![slots[0], slots[1], far];
                let formula = Tree::Product(vec![u(), v(), Tree::Variable(2)]).times(0.5 * c);
                return Template { slots, formula };
            }
        };
        Template {
            slots,
            formula: formula.times(c),
        }
    }

    /// N.
    pub fn length(&self) -> usize {
        self.families
            .iter()
            .map(|family| family.1)
            .max()
            .unwrap_or(0)
    }

    /// The largest distance between two sites that a template names.
    pub fn farthest(&self) -> u64 {
        let of_entries = self
            .entries
            .iter()
            .map(|e| e.pair.iter().chain(&e.value.slots).map(|s| s.1).collect());
        let of_terms = self
            .terms
            .iter()
            .map(|t| t.slots.iter().map(|s| s.1).collect());
        let all = of_entries.chain(of_terms);
        let apart = all.map(|all: Vec<i64>| {
            let (least, most) = (all.iter().min(), all.iter().max());
            most.zip(least)
                .map_or(0, |(most, least)| most.abs_diff(*least))
        });
        apart.max().unwrap_or(0)
    }

    /// The lines of `[system]` and of the initial state; the observable is called C.
    pub fn system(&self) -> String {
        let families: Vec<String> = (self.families[..self.moving].iter())
            .map(|(name, n)| format!("{name} = {n}"))
            .collect();
        let entries: Vec<String> = (self.entries.iter())
            .map(|e| {
                format!(
                    "\"{},{}\" = \"{}\"",
                    self.name(e.pair[0]),
                    self.name(e.pair[1]),
                    self.text(&e.value)
                )
            })
            .collect();
        // Some in one sum, others in sums of their own.
        let (together, apart) = self.terms.split_at(self.terms.len().div_ceil(2));
        let together: Vec<String> = together.iter().map(|term| self.text(term)).collect();
        let mut sums = vec![format!("sum(i, {})", together.join(" + "))];
        sums.extend(
            apart
                .iter()
                .map(|term| format!("sum(i, {})", self.text(term))),
        );
        let parameters = match self.families.len() > self.moving {
            true => format!(
                "parameters = {{ \"w[i]\" = \"{}\" }}\n",
                self.initial[self.moving].text()
            ),
            false => String::new(),
        };
        format!(
            "[system]\nfamilies = {{ {} }}\n{parameters}bracket = {{ {} }}\nboundary = \"{}\"\nhamiltonian = \"{}\"\n",
            families.join(", "),
            entries.join(", "),
            if self.is_ring { "periodic" } else { "open" },
            sums.join(" + "),
        )
    }

    /// The lines of `[run]`.
    pub fn run(&self, steps: usize) -> String {
        let initial: Vec<String> = (self.families[..self.moving].iter().zip(&self.initial))
            .map(|((name, _), start)| format!("\"{name}[i]\" = \"{}\"", start.text()))
            .collect();
        format!(
            "[run]\ninitial = {{ {} }}\nsteps = {steps}\nrecord = {{ observables = [{{ C = \"sum(i, {})\" }}] }}\n",
            initial.join(", "),
            self.text(&self.observable)
        )
    }

    /// Whether the bracket is that of spins.
    pub fn has_spins(&self) -> bool {
        self.kind == Kind::Spins
    }

    fn name(&self, (family, offset): Slot) -> String {
        let name = self.families[family].0;
        // On a ring an offset is written the shorter way round.
        let length = self.length() as i64;
        let offset = match self.is_ring {
            true => (offset + length / 2).rem_euclid(length) - length / 2,
            false => offset,
        };
        match offset {
            0 => format!("{name}[i]"),
            offset => format!("{name}[i{offset:+}]"),
        }
    }

    fn text(&self, template: &Template) -> String {
        let names: Vec<String> = template.slots.iter().map(|slot| self.name(*slot)).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        template.formula.text(&names)
    }

    /// The coordinate of a slot at a site, `None` beyond an open end.
    fn place(&self, (family, offset): Slot, site: usize) -> Option<usize> {
        let start: usize = self.families[..family].iter().map(|family| family.1).sum();
        let length = self.families[family].1;
        let at = site as i64 + offset;
        let at = if self.is_ring {
            at.rem_euclid(length as i64)
        } else {
            at
        };
        usize::try_from(at)
            .ok()
            .filter(|at| *at < length)
            .map(|at| start + at)
    }

    /// The coordinates of a template at a site, `None` where one is beyond an open end.
    fn places(&self, slots: &[Slot], site: usize) -> Option<Vec<usize>> {
        slots.iter().map(|slot| self.place(*slot, site)).collect()
    }

    /// Adds ∂/∂x of a sum over sites to `slopes`; its value.
    fn sum(&self, template: &Template, x: &[f64], slopes: &mut [f64]) -> f64 {
        let mut sum = 0.0;
        for site in 0..self.length() {
            let Some(places) = self.places(&template.slots, site) else {
                continue;
            };
            let own: Vec<f64> = places.iter().map(|at| x[*at]).collect();
            let value = template.formula.dual(&own);
            sum += value.value();
            for (at, place) in places.iter().enumerate() {
                slopes[*place] += value.slope(at);
            }
        }
        sum
    }

    /// ẋ = {H, x}, site by site.
    pub fn field(&self, x: &[f64]) -> Vec<f64> {
        let mut slopes = vec![0.0; x.len()];
        for term in &self.terms {
            self.sum(term, x, &mut slopes);
        }
        let mut field = vec![0.0; x.len()];
        for entry in &self.entries {
            for site in 0..self.length() {
                let pair = self.places(&entry.pair, site);
                let (Some(pair), Some(places)) = (pair, self.places(&entry.value.slots, site))
                else {
                    continue;
                };
                let own: Vec<f64> = places.iter().map(|at| x[*at]).collect();
                let value = entry.value.formula.value(&own);
                field[pair[0]] -= value * slopes[pair[1]];
                field[pair[1]] += value * slopes[pair[0]];
            }
        }
        field
    }

    /// The state at the start, parameters of sites behind the coordinates.
    pub fn state(&self) -> Vec<f64> {
        let families = self.families.iter().zip(&self.initial);
        families
            .flat_map(|((_, length), start)| (0..*length).map(|site| start.at(site)))
            .collect()
    }

    /// H and the observable.
    pub fn values(&self, x: &[f64]) -> [f64; 2] {
        let mut slopes = vec![0.0; x.len()];
        let energy = self
            .terms
            .iter()
            .map(|term| self.sum(term, x, &mut slopes))
            .sum();
        [energy, self.sum(&self.observable, x, &mut slopes)]
    }

    /// Σ |terms| of both, which their round-off is in proportion to.
    pub fn size(&self, x: &[f64]) -> f64 {
        let one = |template: &Template| -> f64 {
            let of_site = |site| {
                let places = self.places(&template.slots, site)?;
                let own: Vec<f64> = places.iter().map(|at| x[*at]).collect();
                Some(template.formula.value(&own).abs())
            };
            (0..self.length()).filter_map(of_site).sum()
        };
        self.terms.iter().chain([&self.observable]).map(one).sum()
    }
}

/// Mostly near, often up to 40, of either sign.
fn offset(source: &mut Source<'_>) -> i64 {
    let offset = positive_offset(source);
    if source.chance(80) { -offset } else { offset }
}

fn positive_offset(source: &mut Source<'_>) -> i64 {
    match source.below(3) {
        0 => 1 + source.below(2) as i64,
        1 => 3 + source.below(10) as i64,
        _ => 1 + source.below(40) as i64,
    }
}

/// Values that differ at every site: a + b sin(ci + d).
#[derive(Clone, Debug)]
struct Start {
    mean: f64,
    width: f64,
    rate: f64,
    phase: f64,
}

impl Start {
    /// Well away from 0 where they are to be positive.
    fn drawn(source: &mut Source<'_>, is_positive: bool) -> Self {
        let (mean, width) = if is_positive { (1.0, 0.3) } else { (0.1, 0.8) };
        Self {
            mean,
            width,
            rate: source.decimal(0.5, 3.0),
            phase: source.decimal(0.0, 6.0),
        }
    }

    fn text(&self) -> String {
        let Self {
            mean,
            width,
            rate,
            phase,
        } = self;
        format!("{mean:?} + {width:?}*sin({rate:?}*i + {phase:?})")
    }

    fn at(&self, site: usize) -> f64 {
        self.mean + self.width * libm::sin(self.rate * site as f64 + self.phase)
    }
}
