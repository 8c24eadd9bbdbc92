//! The observable `shadow-energy`: H̃, the energy that a run's map keeps to a higher order than H.

use leafwise_core::{BuildError, PoissonSystem, Shadow, StepMap, Structure};
use leafwise_expression::Expression;

use super::Refusal;
use super::bodies::MOST_SITES_OF_HIGH_ORDER;
use super::dense::WRITTEN_LIMIT;
use super::observables::{Observable, RecordedFormula, ShadowNumbers, shadow_order};
use super::own_columns::SHADOW_ENERGY;
use super::stepping::Stepping;
use crate::document::{Located, SceneDocument};

/// Products of terms that its first term may take: seconds.
const FIRST_PRODUCTS: u64 = 1 << 20;

/// The same of a second one that is not asked for: a tenth of a second.
const PRODUCTS: u64 = 1 << 18;

/// The same where one is: a minute.
const MOST_PRODUCTS: u64 = 1 << 26;

/// The order of shadow energies in loops.
const ORDER_IN_LOOPS: usize = 4;

/// How far behind H the search for the first term goes.
const LAST: usize = 24;

/// Largest cost of the default order, in evaluations of H.
const ENERGIES: u64 = 2;

/// H̃ = F_1 + t F_2 + … of a map, cut where its own order is p: its error is of order tᵖ.
#[derive(Clone, Debug)]
pub struct ShadowEnergy {
    /// F_1, F_2, ….
    pub shadow: Shadow,
    /// The order m of the map: that of H itself.
    pub order_of_map: usize,
    /// p.
    pub order: usize,
    /// The order that the map keeps H̃ to at most, 2⌊n/2⌋ + 2 over a realization of order n, where that is below p.
    pub limit: Option<usize>,
    /// Σ t^{k−1} F_k.
    pub value: Expression,
    /// Costs of an evaluation of H and of one of H̃, in arithmetic operations; an elementary function counts as ten.
    pub operations: [u64; 2],
}

/// Why there is none.
#[derive(Debug)]
pub struct NoShadow {
    /// Reason why there is no shadow energy, in words.
    pub message: String,
    /// Advice: a remedy to try.
    pub help: String,
}

impl From<BuildError> for NoShadow {
    fn from(error: BuildError) -> Self {
        Self {
            message: format!("the shadow Hamiltonian cannot be formed: {error}"),
            help: "record another observable".to_owned(),
        }
    }
}

impl ShadowEnergy {
    /// Shadow energy of a map with steps t = εh, of an order p. Where none is asked for, p is m + 4 if H̃ of both
    /// orders m + 2 and m + 4 takes at most twice the operations of H. Else p is m + 2.
    ///
    /// # Errors
    /// [`NoShadow`] where the map is known to have none as a formula, or p is no order of it.
    pub fn of(
        system: &PoissonSystem,
        map: &dyn StepMap,
        t: f64,
        asked: Option<usize>,
    ) -> Result<Self, NoShadow> {
        let Some(formulas) = system.expressions() else {
            return Err(NoShadow {
                message: "a system of numbers has no formula of its shadow Hamiltonian".to_owned(),
                help: match map.abilities().shadow_energy {
                    Some(_) => format!(
                        "its values are known: record = {{ observables = [\"energy\", \"{SHADOW_ENERGY}\"] }}"
                    ),
                    None => "write its tensor and Hamiltonian as formulas".to_owned(),
                },
            });
        };
        if system.has_forces() {
            return Err(NoShadow {
                message: "a motion with forces is the flow of no Hamiltonian, and its steps have no shadow Hamiltonian"
                    .to_owned(),
                help: format!("record `energy`, or take {} out", formulas.forces().words()),
            });
        }
        let products = match asked {
            None => PRODUCTS,
            Some(_) => MOST_PRODUCTS,
        };
        let form = |last: usize| map.shadow(formulas, last, products);
        let (m, first) = Self::first(map, |last| map.shadow(formulas, last, FIRST_PRODUCTS))?;
        let limit = match map.properties().structure {
            Structure::Order(n) => Some(2 * (n / 2) + 2),
            Structure::Exact | Structure::Leaves | Structure::Contact | Structure::None => None,
        };
        let operations = |formula: &Expression| -> Result<u64, NoShadow> {
            Ok(formulas
                .observable_kernel(&[formula])?
                .step_operations()
                .work())
        };
        let cut = |shadow: Shadow, order: usize| -> Result<Option<Self>, NoShadow> {
            let Some(value) = shadow.value(t, order).map_err(BuildError::from)? else {
                return Ok(None);
            };
            Ok(Some(Self {
                shadow,
                order_of_map: m,
                order,
                limit: limit.filter(|limit| *limit < order),
                operations: [operations(formulas.hamiltonian())?, operations(&value)?],
                value,
            }))
        };
        let too_long = |order: usize| NoShadow {
            message: format!("the formulas of a shadow Hamiltonian of order {order} grow too long"),
            help: format!("give a lower order, {} at least", m + 2),
        };
        if let Some(order) = asked {
            if order < m + 2 || order > m + 8 || !(order - m).is_multiple_of(2) {
                return Err(NoShadow {
                    message: format!(
                        "`{}` has no shadow Hamiltonian of order {order}",
                        map.describe()
                    ),
                    help: format!(
                        "H itself is of order {m}; give {}, {}, … or {}",
                        m + 2,
                        m + 4,
                        m + 8
                    ),
                });
            }
            let shadow = form(order - 1)?.ok_or_else(|| too_long(order))?;
            return cut(shadow, order)?.ok_or_else(|| too_long(order));
        }
        let least = cut(first, m + 2)?.ok_or_else(|| too_long(m + 2))?;
        let is_short = |shadow: &Self| {
            let [energy, own] = shadow.operations;
            own <= ENERGIES * energy
        };
        if is_short(&least)
            && let Some(longer) = form(m + 3)?
            && let Some(longer) = cut(longer, m + 4)?
            && is_short(&longer)
        {
            return Ok(longer);
        }
        Ok(least)
    }

    /// m, with the shadow up to F_{m+1}, the first that is not 0.
    fn first(
        map: &dyn StepMap,
        form: impl Fn(usize) -> Result<Option<Shadow>, BuildError>,
    ) -> Result<(usize, Shadow), NoShadow> {
        // Declared orders are lower bounds.
        let mut last = map.properties().order + 1;
        while last <= LAST {
            let Some(shadow) = form(last)? else {
                if last > map.properties().order + 1 {
                    break;
                }
                return Err(NoShadow {
                    message: format!(
                        "`{}` has no formula of its shadow Hamiltonian, or too long a one",
                        map.describe()
                    ),
                    help: "it is known for hamilton-jacobi over a realization with a chart, for splitting, and for \
                           compositions of either"
                        .to_owned(),
                });
            };
            let first = map.properties().order.max(1);
            if let Some(k) = shadow.terms().into_iter().find(|k| *k > first) {
                return Ok((k - 1, shadow));
            }
            last += 1;
        }
        Err(NoShadow {
            message: format!(
                "the shadow Hamiltonian of `{}` is H itself, up to order {}: over an exact realization there is no error, \
                 and here the realization causes it",
                map.describe(),
                last - 1
            ),
            help: "record `energy`".to_owned(),
        })
    }
}

/// Which observable is the run's shadow energy, first of them where there are several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordedShadow {
    /// Its place among the observables.
    pub at: usize,
    /// m.
    pub order_of_map: usize,
    /// p.
    pub order: usize,
    /// The order that H̃ is kept to at most, where that is below p.
    pub limit: Option<usize>,
}

/// Puts the formulas of shadow energies in the place of H, which stands for them before there is a map.
pub(super) fn with_shadows(
    document: &SceneDocument,
    system: &PoissonSystem,
    method: &Stepping,
    observables: &mut [Observable],
) -> Result<Option<RecordedShadow>, Refusal> {
    let mut recorded = None;
    let asked = &document.run.record.observables;
    for (at, (asked, observable)) in asked.iter().zip(observables).enumerate() {
        let Some(order) = shadow_order(&asked.formula.value) else {
            continue;
        };
        let refuse = |no: NoShadow| refusal(document, &asked.formula, no);
        let of_a = |what: &str| NoShadow {
            message: format!("`{SHADOW_ENERGY}` is not offered {what}"),
            help: "record `energy`".to_owned(),
        };
        if method.lattice().is_some() {
            let what = format!(
                "on a lattice of more than {WRITTEN_LIMIT} coordinates: its terms are brackets within brackets, each of which \
                 reaches farther sites, and they are formed of every site written out"
            );
            return Err(refuse(of_a(&what)));
        }
        if method.noise().is_some() {
            return Err(refuse(of_a(
                "with noise: every step follows another Hamiltonian",
            )));
        }
        if document.method.pace.is_some() {
            return Err(refuse(of_a("with a pace: its steps are not of the time")));
        }
        let t = document.method.step.time_step();
        if system.opaque().is_some() && document.system.numbers.is_none() {
            let (shadow, formula) = in_loops(method, t, order).map_err(refuse)?;
            recorded.get_or_insert(RecordedShadow { at, ..shadow });
            let name = asked.heading().to_owned();
            *observable = Observable::Formula { name, formula };
            continue;
        }
        let shadow = ShadowEnergy::of(system, method.map(), t, order).map_err(refuse)?;
        recorded.get_or_insert(RecordedShadow {
            at,
            order_of_map: shadow.order_of_map,
            order: shadow.order,
            limit: shadow.limit,
        });
        *observable = Observable::Formula {
            name: asked.heading().to_owned(),
            formula: RecordedFormula::Written(shadow.value),
        };
    }
    Ok(recorded)
}

/// H̃ of sums over pairs in loops, to the order 4 of Strang's product.
///
/// # Errors
/// [`NoShadow`] for another map, and for another order.
fn in_loops(
    method: &Stepping,
    t: f64,
    asked: Option<usize>,
) -> Result<(RecordedShadow, RecordedFormula), NoShadow> {
    let energy = method.map().abilities().shadow_energy;
    let Some(make) = energy.filter(|_| asked.is_none_or(|order| order == ORDER_IN_LOOPS)) else {
        return Err(NoShadow {
            message: format!(
                "`{SHADOW_ENERGY}` of sums over pairs in loops is that of `splitting` of order {ORDER_IN_LOOPS}: later terms, as those of a \
                 composition, are brackets within brackets of more than two levels, formed of every body written out: of fewer than \
                 {MOST_SITES_OF_HIGH_ORDER} bodies"
            ),
            help: "record `energy`, or take stepper = \"splitting\" alone".to_owned(),
        });
    };
    let recorded = RecordedShadow {
        at: 0,
        order_of_map: 2,
        order: ORDER_IN_LOOPS,
        limit: None,
    };
    let numbers = ShadowNumbers { make, t };
    Ok((recorded, RecordedFormula::Shadow(numbers)))
}

fn refusal(document: &SceneDocument, text: &Located<String>, no: NoShadow) -> Refusal {
    let place = document.place_in_formula(text, 0..text.value.len());
    Box::new(document.diagnostic(&place, no.message, "here", Some(no.help)))
}
