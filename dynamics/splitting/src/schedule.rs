//! Which flows a step takes, and how long each.

/// The flow of a piece over a part of the step's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// Its number.
    pub piece: usize,
    /// Part of the step's time t that the flow takes.
    pub part: f64,
}

/// Strang's product as χ*_{t/2} ∘ χ_{t/2}.
pub const STRANG: [f64; 2] = [0.5, 0.5];

/// The flows of χ_{α_1 t}, χ*_{α_2 t}, χ_{α_3 t}, … one after the other. Here χ = φʳ ∘ … ∘ φ¹ takes the pieces in
/// their `order`, and its adjoint χ* = φ¹ ∘ … ∘ φʳ backwards. Flows of one piece that meet are one, parts that are 0
/// are none.
pub fn passes(order: &[usize], parts: &[f64]) -> Vec<Flow> {
    let mut flows: Vec<Flow> = Vec::new();
    for (at, part) in parts.iter().enumerate().filter(|(_, part)| **part != 0.0) {
        let count = order.len();
        for k in 0..count {
            let piece = order[if at % 2 == 0 { k } else { count - 1 - k }];
            match flows.last_mut() {
                Some(last) if last.piece == piece => last.part += part,
                _ => flows.push(Flow { piece, part: *part }),
            }
        }
    }
    flows
}

#[cfg(test)]
mod tests {
    use super::{Flow, STRANG, passes};

    #[test]
    fn flows_that_meet_are_one() {
        let flow = |piece, part| Flow { piece, part };
        assert_eq!(
            passes(&[1, 0], &STRANG),
            [flow(1, 0.5), flow(0, 1.0), flow(1, 0.5)]
        );
        let triple = passes(&[2, 1, 0], &[0.375, 0.375, -0.25, -0.25, 0.375, 0.375]);
        let pieces: Vec<usize> = triple.iter().map(|flow| flow.piece).collect();
        assert_eq!(pieces, [2, 1, 0, 1, 2, 1, 0, 1, 2, 1, 0, 1, 2]);
        assert_eq!(triple[4], flow(2, 0.125));
        assert_eq!(
            passes(&[3], &[0.375, 0.375, -0.25, -0.25, 0.375, 0.375]),
            [flow(3, 1.0)]
        );
        assert_eq!(passes(&[], &STRANG), []);
        assert_eq!(passes(&[2, 1], &[0.0, 1.0]), [flow(1, 1.0), flow(2, 1.0)]);
    }
}
