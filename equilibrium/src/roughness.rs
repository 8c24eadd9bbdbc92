//! How well splines through part of the nodes of ψ meet the others: where ψ is noisy or its grid coarse, badly.

use leafwise_expression::TableFunction;
use leafwise_expression::table::TableAxis;

use crate::equilibrium::Equilibrium;

/// The part that is left of an error with twice the nodes, at order 2, where there are too few nodes to see it.
const FALL: f64 = 0.25;

impl Equilibrium {
    /// An estimate of the error of ψ's table within the edge, as a part of ψ's range from the axis to the edge.
    ///
    /// A spline through every second node is off by e₂ at the others, one through every fourth by e₄. Where ψ is smooth e₂/e₄ is
    /// the next factor too, and the estimate is e₂²/e₄. Noise is met no better by more nodes, and the estimate is e₂. `None` for
    /// a grid with too few nodes for a spline through every second one.
    pub fn roughness(&self) -> Option<f64> {
        let second = self.missed(2)?;
        let [axis, edge] = self.file().psi_range;
        let fall = match self.missed(4) {
            Some(fourth) if fourth > 0.0 => (second / fourth).min(1.0),
            Some(_) => 1.0,
            None => FALL,
        };
        Some(second * fall / (edge - axis).abs())
    }

    /// By how much a spline through every `each`-th node misses ψ within the edge.
    fn missed(&self, each: usize) -> Option<f64> {
        let file = self.file();
        let [along_r, along_z] = file.nodes;
        let kept = file.nodes.map(|nodes| (nodes - 1) / each + 1);
        let place = |[first, last]: [f64; 2], nodes: usize, at: usize| {
            first + (last - first) * at as f64 / (nodes - 1) as f64
        };
        let axis = |name: &str, ends: [f64; 2], nodes: usize, kept: usize| TableAxis {
            name: name.to_owned(),
            first: ends[0],
            last: place(ends, nodes, (kept - 1) * each),
            nodes: kept,
            is_periodic: false,
        };
        let axes = vec![
            axis("R", file.r, along_r, kept[0]),
            axis("Z", file.z, along_z, kept[1]),
        ];
        let psi = |i: usize, j: usize| file.psi[i * along_z + j];
        let part = |at: usize| (at / kept[1] * each, at % kept[1] * each);
        let numbers: Vec<f64> = (0..kept[0] * kept[1])
            .map(part)
            .map(|(i, j)| psi(i, j))
            .collect();
        let table = TableFunction::new("psi", axes, self.degree(), &numbers).ok()?;
        let [axis, edge] = file.psi_range;
        let mut worst = 0.0_f64;
        for i in 0..(kept[0] - 1) * each {
            for j in 0..(kept[1] - 1) * each {
                let s = (psi(i, j) - axis) / (edge - axis);
                if s <= 1.0 {
                    let point = [place(file.r, along_r, i), place(file.z, along_z, j)];
                    worst = worst.max((table.value().at(&point) - psi(i, j)).abs());
                }
            }
        }
        Some(worst)
    }
}
