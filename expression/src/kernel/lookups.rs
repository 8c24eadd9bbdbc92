//! Code of tables. It has the cell and the place in it once for each argument, and each coefficient once for each point.
//!
//! Sums go over one axis after the other, the last first. Derivatives of other orders at the point share all that is common.

use rustc_hash::FxHashMap;

use super::code::Instruction;
use super::draft::Draft;
use crate::analytic::AnalyticFunction;
use crate::table::{Lookup, MOST_AXES, Part, TableFunction};

/// Axis of an argument: its ends, nodes, period, and the places between coefficients.
type AxisKey = ([u64; 2], usize, bool, usize);

/// A table, the slots of a place, the orders, and the axis and coefficient that a sum begins with.
type SumKey = (
    TableFunction,
    u32,
    [u32; MOST_AXES],
    [u8; MOST_AXES],
    usize,
    usize,
);

/// The slots of what tables are evaluated of.
#[derive(Default)]
pub(super) struct LookupSlots {
    parts: FxHashMap<(AxisKey, u32), u32>,
    coefficients: FxHashMap<(TableFunction, usize, u32), u32>,
    /// p! times the B-splines of a degree p, by the slot of the place in the cell.
    splines: FxHashMap<(u32, u8), Vec<u32>>,
    /// u + m, and m − u.
    shifted: FxHashMap<(u32, usize, bool), u32>,
    /// Their derivatives of an order.
    weights: FxHashMap<(u32, u8, u8), Vec<u32>>,
    /// Sums over the axes from one on, by their orders and the first coefficient.
    sums: FxHashMap<SumKey, u32>,
}

/// A lookup at a point: the slots of its cell's place and of its places in the cell.
struct PointSlots {
    lookup: Lookup,
    place: u32,
    fractions: [u32; MOST_AXES],
}

impl LookupSlots {
    pub(super) fn emit(&mut self, code: &mut Draft, lookup: Lookup, point: &[u32]) -> u32 {
        let table = lookup.table();
        let mut fractions = [0; MOST_AXES];
        let mut place = None;
        for (axis, &x) in point.iter().enumerate() {
            fractions[axis] = self.part(code, table, axis, Part::Fraction(axis), x);
            let own = self.part(code, table, axis, Part::Place(axis), x);
            place = Some(match place {
                None => own,
                Some(a) => code.push(|out| Instruction::Add { out, a, b: own }),
            });
        }
        let place = place.unwrap_or_default();
        let sum = self.sum(
            code,
            &PointSlots {
                lookup,
                place,
                fractions,
            },
            0,
            0,
        );
        // The B-splines are p! times as large, and the axes' units are cells.
        let mut scale = 1.0;
        for (axis, order) in lookup.orders().iter().enumerate() {
            for p in 1..=table.degree() - order {
                scale /= f64::from(p);
            }
            for _ in 0..*order {
                scale /= table.spacing(axis);
            }
        }
        self.times(code, sum, scale)
    }

    fn times(&mut self, code: &mut Draft, a: u32, factor: f64) -> u32 {
        if factor == 1.0 {
            return a;
        }
        let b = code.number(factor);
        code.push(|out| Instruction::Multiply { out, a, b })
    }

    /// A function of one argument: of equal axes of several tables it is one.
    fn part(
        &mut self,
        code: &mut Draft,
        table: TableFunction,
        axis: usize,
        part: Part,
        x: u32,
    ) -> u32 {
        let own = &table.axes()[axis];
        let stride = match part {
            Part::Place(_) => table.stride(axis),
            _ => 0,
        };
        let ends = [own.first, own.last].map(f64::to_bits);
        // Even and odd degrees have other cells.
        let key = (
            ends,
            2 * own.nodes + usize::from(table.degree() % 2),
            own.is_periodic,
            stride,
        );
        if let Some(known) = self.parts.get(&(key, x)) {
            return *known;
        }
        let slot = self.apply_part(code, table, part, x);
        self.parts.insert((key, x), slot);
        slot
    }

    fn apply_part(&mut self, code: &mut Draft, table: TableFunction, part: Part, a: u32) -> u32 {
        code.push(|out| Instruction::ApplyAnalytic {
            function: AnalyticFunction::of_table(table),
            order: part.code(),
            out,
            a,
        })
    }

    /// Σ over the axes from `axis` on, of the coefficients from `offset` behind the place on.
    fn sum(&mut self, code: &mut Draft, point: &PointSlots, axis: usize, offset: usize) -> u32 {
        let table = point.lookup.table();
        let own = point.lookup.orders();
        let Some(order) = own.get(axis) else {
            let key = (table, offset, point.place);
            if let Some(known) = self.coefficients.get(&key) {
                return *known;
            }
            let slot = self.apply_part(code, table, Part::Coefficient(offset), point.place);
            self.coefficients.insert(key, slot);
            return slot;
        };
        let mut orders = [0; MOST_AXES];
        orders[axis..own.len()].copy_from_slice(&own[axis..]);
        let key = (table, point.place, point.fractions, orders, axis, offset);
        if let Some(known) = self.sums.get(&key) {
            return *known;
        }
        let weights = self.weights(code, point.fractions[axis], table.degree() - order, *order);
        let mut sum = None;
        for (j, b) in weights.into_iter().enumerate() {
            let a = self.sum(code, point, axis + 1, offset + j * table.stride(axis));
            let product = code.push(|out| Instruction::Multiply { out, a, b });
            sum = Some(match sum {
                None => product,
                Some(a) => code.push(|out| Instruction::Add { out, a, b: product }),
            });
        }
        let sum = sum.unwrap_or_default();
        self.sums.insert(key, sum);
        sum
    }

    /// The m-fold differences of the B-splines of degree p, p! times as large: derivatives of those of degree p + m.
    fn weights(&mut self, code: &mut Draft, u: u32, p: u8, order: u8) -> Vec<u32> {
        if let Some(known) = self.weights.get(&(u, p, order)) {
            return known.clone();
        }
        let mut row = self.splines(code, u, p);
        for _ in 0..order {
            let mut next = Vec::with_capacity(row.len() + 1);
            let a = row[0];
            next.push(code.push(|out| Instruction::Negate { out, a }));
            for two in row.windows(2) {
                let (a, b) = (two[0], two[1]);
                next.push(code.push(|out| Instruction::Subtract { out, a, b }));
            }
            next.extend(row.last());
            row = next;
        }
        self.weights.insert((u, p, order), row.clone());
        row
    }

    /// w_j^p = (u + p − j) w_{j−1}^{p−1} + (j + 1 − u) w_j^{p−1} for j = 0 … p, w⁰ = 1.
    fn splines(&mut self, code: &mut Draft, u: u32, p: u8) -> Vec<u32> {
        if p == 0 {
            return vec![code.number(1.0)];
        }
        if let Some(known) = self.splines.get(&(u, p)) {
            return known.clone();
        }
        let before = self.splines(code, u, p - 1);
        let mut row = Vec::with_capacity(usize::from(p) + 1);
        for j in 0..=usize::from(p) {
            let left = j.checked_sub(1).map(|at| (at, usize::from(p) - j, false));
            let right = (j < before.len()).then_some((j, j + 1, true));
            let mut sum = None;
            for (at, whole, is_below) in [left, right].into_iter().flatten() {
                let factor = self.shifted(code, u, whole, is_below);
                // Of degree 0 it is 1.
                let product = match (p, before[at]) {
                    (1, _) => factor,
                    (_, a) => code.push(|out| Instruction::Multiply { out, a, b: factor }),
                };
                sum = Some(match sum {
                    None => product,
                    Some(a) => code.push(|out| Instruction::Add { out, a, b: product }),
                });
            }
            row.extend(sum);
        }
        self.splines.insert((u, p), row.clone());
        row
    }

    /// u + m, or m − u.
    fn shifted(&mut self, code: &mut Draft, u: u32, whole: usize, is_below: bool) -> u32 {
        if whole == 0 {
            return u;
        }
        let number = code.number(whole as f64);
        match self.shifted.get(&(u, whole, is_below)) {
            Some(known) => *known,
            None => {
                let slot = match is_below {
                    false => code.push(|out| Instruction::Add {
                        out,
                        a: u,
                        b: number,
                    }),
                    true => code.push(|out| Instruction::Subtract {
                        out,
                        a: number,
                        b: u,
                    }),
                };
                self.shifted.insert((u, whole, is_below), slot);
                slot
            }
        }
    }
}
