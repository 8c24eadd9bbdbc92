//! Which flows a step takes, and how long each.

/// The flow of a piece over a part of the step's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// Its number.
    pub piece: usize,
    /// What it takes of t.
    pub part: f64,
}

/// The flows of φ¹_{γt/2} ∘ … ∘ φʳ_{γt} ∘ … ∘ φ¹_{γt/2} for each γ of `factors`, one after the other; flows
/// of one piece that meet are one.
pub fn strang(order: &[usize], factors: &[f64]) -> Vec<Flow> {
    let mut flows: Vec<Flow> = Vec::new();
    let Some((middle, outer)) = order.split_last() else {
        return flows;
    };
    for factor in factors {
        let half = |piece: &usize| Flow {
            piece: *piece,
            part: 0.5 * factor,
        };
        let whole = Flow {
            piece: *middle,
            part: *factor,
        };
        let halves = outer.iter().map(half);
        for flow in halves.clone().chain([whole]).chain(halves.rev()) {
            match flows.last_mut() {
                Some(last) if last.piece == flow.piece => last.part += flow.part,
                _ => flows.push(flow),
            }
        }
    }
    flows
}

#[cfg(test)]
mod tests {
    use super::{Flow, strang};

    #[test]
    fn half_flows_that_meet_are_one() {
        let flow = |piece, part| Flow { piece, part };
        assert_eq!(
            strang(&[1, 0], &[1.0]),
            [flow(1, 0.5), flow(0, 1.0), flow(1, 0.5)]
        );
        let triple = strang(&[2, 1, 0], &[0.75, -0.5, 0.75]);
        let pieces: Vec<usize> = triple.iter().map(|flow| flow.piece).collect();
        assert_eq!(pieces, [2, 1, 0, 1, 2, 1, 0, 1, 2, 1, 0, 1, 2]);
        assert_eq!(triple[4], flow(2, 0.125));
        assert_eq!(strang(&[3], &[0.75, -0.5, 0.75]), [flow(3, 1.0)]);
        assert_eq!(strang(&[], &[1.0]), []);
    }
}
