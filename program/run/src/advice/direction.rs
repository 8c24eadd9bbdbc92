//! Hamilton's equations that run backwards in time.

use leafwise_core::system::Convention;

use super::{Advice, AdviceKind};
use leafwise_scene::compose::ComposedRun;

/// A pair of variables named q, p (or x, px) with q' = −∂H/∂p: the bracket's sign is that of the other
/// convention.
pub(super) fn advice(run: &ComposedRun) -> Option<Advice> {
    let system = run.system.expressions()?;
    let names = system.variables();
    let parameters = system.parameter_values();
    // Π_qp in ẋ = −Π ∇H: Hamilton's equations have −1.
    let reversed = |q: usize| {
        let p = partner(&names[q], names)?;
        let entry = system.tensor().get(&(q.min(p), q.max(p)))?;
        let value = entry.evaluate(&run.near, &parameters);
        let value = if q < p { value } else { -value };
        (value > 0.0).then_some((q, p))
    };
    let (q, p) = (0..names.len()).find_map(reversed)?;
    let (sign, convention, other, definition) = match system.convention() {
        Convention::HamiltonianFirst => ("positive", "{H, x}", "{x,H}", "{p, q}"),
        Convention::HamiltonianSecond => ("negative", "{x, H}", "{H,x}", "{q, p}"),
    };
    let (q, p) = (&names[q], &names[p]);
    Some(Advice {
        kind: AdviceKind::BackwardTime,
        message: format!(
            "{q}' is minus the derivative of H by {p}, so that Hamilton's equations run backwards in time: \
             {{{q}, {p}}} is {sign}, and x' = {convention} asks for {definition} = 1"
        ),
        change: format!("convention = \"{other}\""),
    })
}

/// The momentum that a position's name asks for: `p1` of `q1`, `px` of `x`.
fn partner(name: &str, names: &[String]) -> Option<usize> {
    let of_q = name.strip_prefix('q').map(|rest| format!("p{rest}"));
    let candidates = of_q.into_iter().chain([format!("p{name}")]);
    candidates
        .filter_map(|wanted| names.iter().position(|known| *known == wanted))
        .next()
}
