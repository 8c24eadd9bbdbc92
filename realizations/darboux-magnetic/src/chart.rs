//! Positions, momenta and the vector potential.

use std::collections::BTreeMap;

use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::syntax::{Formula, Scope};
use leafwise_expression::{Arithmetic, Expression, Polynomial, Rational, Ring};

/// The part's name.
pub(crate) const NAME: &str = "darboux-magnetic";

/// A position x and its momentum p with {x, p} = `sign`, and the component of the potential there.
#[derive(Clone, Debug)]
pub struct CanonicalPair {
    /// The variable x.
    pub position: usize,
    /// The variable p.
    pub momentum: usize,
    /// s = {x, p} = ±1.
    pub sign: Rational,
    /// A, a function of the positions: P = p − A.
    pub potential: Expression,
}

/// The Darboux chart (x, p) ↦ (x, P = p − A(x)) of a magnetic bracket.
#[derive(Clone, Debug)]
pub struct MagneticChart {
    /// The pairs, by position.
    pub pairs: Vec<CanonicalPair>,
}

type Entries = BTreeMap<(usize, usize), Polynomial>;

impl MagneticChart {
    /// Reads the potential, one component a position in the order of the variables, separated by
    /// `;`. Verifies {P_i, P_j} = 0 in exact algebra.
    ///
    /// # Errors
    /// Returns [`BuildError::DoesNotFit`] when the bracket is not magnetic or a pair of momenta
    /// does not commute. Returns [`BuildError::Parameter`] when the potential is missing, is no
    /// formula or has another number of components. Returns [`BuildError::Algebra`] where a formula
    /// has no normal form.
    pub fn new(system: &SystemFormulas, potential: &str) -> Result<Self, BuildError> {
        let mut ring = Ring::new(system.dimension());
        let mut entries = Entries::new();
        for (&at, entry) in system.tensor() {
            let value = entry.evaluate_in(&mut ring, &mut |ring, i| Ok(ring.variable(i)))?;
            if !value.is_zero() {
                entries.insert(at, value);
            }
        }
        let places = canonical_pairs(system, &ring, &entries)?;
        let potentials = parse(system, &places, potential)?;
        let pairs: Vec<CanonicalPair> = places
            .into_iter()
            .zip(potentials)
            .map(|((position, momentum, sign), potential)| CanonicalPair {
                position,
                momentum,
                sign,
                potential,
            })
            .collect();
        verify(system, &mut ring, &entries, &pairs)?;
        Ok(Self { pairs })
    }
}

/// The position of each pair is the variable with one nonzero bracket, ±1; of two such variables,
/// the first.
fn canonical_pairs(
    system: &SystemFormulas,
    ring: &Ring,
    entries: &Entries,
) -> Result<Vec<(usize, usize, Rational)>, BuildError> {
    let d = system.dimension();
    let name = |at: usize| &system.variables()[at];
    let mut partners = vec![Vec::new(); d];
    for &(i, j) in entries.keys() {
        partners[i].push(j);
        partners[j].push(i);
    }
    let mut taken = vec![false; d];
    let mut pairs = Vec::with_capacity(d / 2);
    for position in 0..d {
        let &[momentum] = partners[position].as_slice() else {
            continue;
        };
        if taken[position] {
            continue;
        }
        let entry = &entries[&(position.min(momentum), position.max(momentum))];
        let sign = ring.as_rational(entry).filter(|value| value.abs().is_one());
        let Some(sign) = sign.filter(|_| !taken[momentum]) else {
            return Err(does_not_fit(format!(
                "{{{}, {}}} is not 1 or -1, as the bracket of a position with its momentum is",
                name(position),
                name(momentum)
            )));
        };
        taken[position] = true;
        taken[momentum] = true;
        let sign = if position < momentum { sign } else { -sign };
        pairs.push((position, momentum, sign));
    }
    if let Some(stranger) = taken.iter().position(|taken| !taken) {
        return Err(does_not_fit(format!(
            "`{}` is neither a position, whose only bracket is 1 or -1, nor the momentum of one",
            name(stranger)
        )));
    }
    Ok(pairs)
}

fn parse(
    system: &SystemFormulas,
    pairs: &[(usize, usize, Rational)],
    potential: &str,
) -> Result<Vec<Expression>, BuildError> {
    let names = |which: fn(&(usize, usize, Rational)) -> usize| -> Vec<&str> {
        let name = |pair| system.variables()[which(pair)].as_str();
        pairs.iter().map(name).collect()
    };
    let (positions, momenta) = (names(|pair| pair.0), names(|pair| pair.1));
    let refuse = |reason: String| BuildError::Parameter {
        part: NAME,
        parameter: "potential".to_owned(),
        value: format!("\"{potential}\""),
        expected: format!(
            "{reason}; write the {} components of A, formulas of {} for the momenta {}, \
             separated by `;`, so that the momenta minus A commute",
            pairs.len(),
            positions.join(", "),
            momenta.join(", ")
        ),
    };
    if potential.trim().is_empty() {
        return Err(refuse("the vector potential is missing".to_owned()));
    }
    let components: Vec<&str> = potential.split(';').collect();
    if components.len() != pairs.len() {
        return Err(refuse(format!("{} components are given", components.len())));
    }
    let parameters: Vec<&str> = system
        .parameters()
        .iter()
        .map(|p| p.name.as_str())
        .collect();
    let scope = Scope::new()
        .with_variables(system.variables())
        .with_parameters(&parameters);
    let mut expressions = Vec::with_capacity(pairs.len());
    for (component, momentum) in components.iter().zip(&momenta) {
        let place = |error: String| refuse(format!("the component for {momentum}: {error}"));
        let formula = Formula::parse(component.trim()).map_err(|error| place(error.to_string()))?;
        let resolved = formula.resolve(&scope, None);
        let expression = resolved
            .map_err(|error| place(error.to_string()))?
            .ok_or_else(|| place("it names a site outside its family".to_owned()))?;
        let foreign = |at: &usize| pairs.iter().any(|pair| pair.1 == *at);
        if let Some(at) = expression.variables().into_iter().find(foreign) {
            let name = &system.variables()[at];
            return Err(place(format!("it depends on the momentum {name}")));
        }
        expressions.push(expression);
    }
    Ok(expressions)
}

/// {P_i, P_j} = {p_i, p_j} − {p_i, A_j} − {A_i, p_j} = B_ij + s_i ∂_i A_j − s_j ∂_j A_i.
fn verify(
    system: &SystemFormulas,
    ring: &mut Ring,
    entries: &Entries,
    pairs: &[CanonicalPair],
) -> Result<(), BuildError> {
    let mut potentials = Vec::with_capacity(pairs.len());
    for pair in pairs {
        let potential = &pair.potential;
        potentials.push(potential.evaluate_in(ring, &mut |ring, at| Ok(ring.variable(at)))?);
    }
    for (i, a) in pairs.iter().enumerate() {
        for (j, b) in pairs.iter().enumerate().skip(i + 1) {
            let (first, second) = (a.momentum.min(b.momentum), a.momentum.max(b.momentum));
            let field = entries.get(&(first, second)).cloned().unwrap_or_default();
            let sign = Rational::from_integer(if a.momentum < b.momentum { 1 } else { -1 });
            let rest = [
                (sign, field),
                (a.sign.clone(), ring.derivative(&potentials[j], a.position)?),
                (-&b.sign, ring.derivative(&potentials[i], b.position)?),
            ];
            let rest = ring.combine(&rest);
            if !rest.is_zero() {
                return Err(not_commuting(system, a, b));
            }
        }
    }
    Ok(())
}

fn not_commuting(system: &SystemFormulas, a: &CanonicalPair, b: &CanonicalPair) -> BuildError {
    let name = |at: usize| &system.variables()[at];
    let [p, q, x, y] = [a.momentum, b.momentum, a.position, b.position].map(name);
    let joint = if a.sign.is_negative() { "+" } else { "-" };
    let lead = if b.sign.is_negative() { "-" } else { "" };
    does_not_fit(format!(
        "{{{p}, {q}}} is not {lead}dA({p})/d{y} {joint} dA({q})/d{x}, so that {p} - A({p}) and \
         {q} - A({q}) do not commute"
    ))
}

fn does_not_fit(reason: String) -> BuildError {
    BuildError::DoesNotFit { part: NAME, reason }
}
