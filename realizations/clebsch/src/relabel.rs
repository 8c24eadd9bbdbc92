//! Which variables of a system are which of an algebra's, by their structure constants.

use leafwise_expression::Rational;

use crate::constants::Constants;

/// x_i = s_i y_{π(i)} with s_i = ±1, and {x_i, x_j} = t {y, y}.
#[derive(Clone, Debug)]
pub struct Relabelling {
    /// π(i) and s_i.
    pub picks: Vec<(usize, Rational)>,
    /// t.
    pub unit: Rational,
}

/// Most assignments that are tried.
const MOST_TRIALS: usize = 1 << 18;

/// The first relabelling by which `found` are the structure constants `known`.
pub fn relabelling(found: &Constants, known: &Constants) -> Option<Relabelling> {
    if found.dimension() != known.dimension() {
        return None;
    }
    let mut search = Search {
        found,
        known,
        places: Vec::new(),
        is_used: vec![false; known.dimension()],
        trials: 0,
    };
    let unit = search.extend(None)?;
    let picks = search.places.into_iter();
    let picks = picks.map(|(place, is_minus)| {
        let sign = if is_minus { -1 } else { 1 };
        (place, Rational::from_integer(sign))
    });
    Some(Relabelling {
        picks: picks.collect(),
        unit,
    })
}

struct Search<'a> {
    found: &'a Constants,
    known: &'a Constants,
    /// π(i) and whether s_i = −1, of the variables assigned so far.
    places: Vec<(usize, bool)>,
    is_used: Vec<bool>,
    trials: usize,
}

impl Search<'_> {
    /// Assigns the variables that are left, given t where it is known; returns t.
    fn extend(&mut self, unit: Option<Rational>) -> Option<Rational> {
        let d = self.known.dimension();
        if self.places.len() == d {
            return unit;
        }
        // In their own order first.
        let next = self.places.len();
        for step in 0..d {
            let place = (next + step) % d;
            if self.is_used[place] {
                continue;
            }
            for is_minus in [false, true] {
                self.trials += 1;
                if self.trials > MOST_TRIALS {
                    return None;
                }
                self.places.push((place, is_minus));
                self.is_used[place] = true;
                let mut own = unit.clone();
                if self.agrees(&mut own)
                    && let Some(unit) = self.extend(own)
                {
                    return Some(unit);
                }
                self.places.pop();
                self.is_used[place] = false;
            }
        }
        None
    }

    /// Whether the brackets among the assigned variables agree as far as they are known.
    fn agrees(&self, unit: &mut Option<Rational>) -> bool {
        let last = self.places.len() - 1;
        (0..last).all(|i| (i + 1..=last).all(|j| self.bracket_agrees(i, j, last, unit)))
    }

    fn bracket_agrees(&self, i: usize, j: usize, last: usize, unit: &mut Option<Rational>) -> bool {
        let ((a, minus_a), (b, minus_b)) = (self.places[i], self.places[j]);
        let (found, known) = (self.found.bracket(i, j), self.known.bracket(a, b));
        if j == last && found.len() != known.len() {
            return false;
        }
        // What was known before is not compared again.
        let assigned = found.iter().filter(|(k, _)| **k <= last);
        for (k, c) in assigned.filter(|(k, _)| j == last || **k == last) {
            let (place, minus) = self.places[*k];
            let Some(own) = known.get(&place) else {
                return false;
            };
            // s_i s_j t c⁰ y = c s_k y.
            let ratio = c.checked_div(own).expect("no constant is 0");
            let ratio = if minus_a ^ minus_b ^ minus {
                -ratio
            } else {
                ratio
            };
            match unit {
                Some(unit) if *unit != ratio => return false,
                _ => *unit = Some(ratio),
            }
        }
        true
    }
}
