//! The nearest known name to a misspelt one.

/// Names longer than this are not compared: the comparison is quadratic in the length.
const LONGEST_COMPARED: usize = 64;

/// Names from other languages and notations, with the ones used here.
const ALIASES: [(&str, &str); 37] = [
    ("log", "ln"),
    ("fabs", "abs"),
    ("sgn", "sign"),
    ("signum", "sign"),
    ("fmin", "min"),
    ("fmax", "max"),
    ("ceiling", "ceil"),
    ("fmod", "mod"),
    ("arctan2", "atan2"),
    ("step", "heaviside"),
    ("theta", "heaviside"),
    ("piecewise", "if"),
    ("where", "if"),
    ("select", "if"),
    ("tgamma", "gamma"),
    ("gammaln", "lgamma"),
    ("loggamma", "lgamma"),
    ("lg", "log10"),
    ("ld", "log2"),
    ("diff", "D"),
    ("derivative", "D"),
    ("elliptick", "ellipk"),
    ("elliptice", "ellipe"),
    ("arcsin", "asin"),
    ("arccos", "acos"),
    ("arctan", "atan"),
    ("arcsinh", "asinh"),
    ("arccosh", "acosh"),
    ("arctanh", "atanh"),
    ("arsinh", "asinh"),
    ("arcosh", "acosh"),
    ("artanh", "atanh"),
    ("tg", "tan"),
    ("sh", "sinh"),
    ("ch", "cosh"),
    ("th", "tanh"),
    ("Sum", "sum"),
];

/// Functions of other languages, with how they are written here.
const WRITTEN: [(&str, &str); 28] = [
    ("cosec", "csc(x)"),
    ("cotan", "cot(x)"),
    ("ln10", "ln(10)"),
    ("digamma", "lgamma(x, 1)"),
    ("psi", "lgamma(x, 1)"),
    ("besselj0", "j0(x)"),
    ("besselj1", "j1(x)"),
    ("round", "floor(x + 1/2)"),
    ("frac", "x - floor(x)"),
    ("rem", "mod(x, y)"),
    ("clip", "max(a, min(x, b))"),
    ("clamp", "max(a, min(x, b))"),
    ("acot", "atan(1/x)"),
    ("coth", "1/tanh(x)"),
    ("sech", "1/cosh(x)"),
    ("csch", "1/sinh(x)"),
    ("pow", "x^y"),
    ("power", "x^y"),
    ("square", "x^2"),
    ("sqr", "x^2"),
    ("cbrt", "x^(1/3)"),
    ("hypot", "sqrt(x^2 + y^2)"),
    ("log1p", "ln(1 + x)"),
    ("exp2", "exp(x*ln(2))"),
    ("exp10", "exp(x*ln(10))"),
    ("expm1", "exp(x) - 1"),
    ("sinc", "sin(x)/x"),
    ("sigmoid", "1/(1 + exp(-x))"),
];

/// Functions of other languages that no misspelling is: they begin or end like those that there are.
const ELSEWHERE: [&str; 6] = ["rint", "trunc", "int", "beta", "besselj", "gammainc"];

/// How a function known elsewhere as `name` is written here.
pub(super) fn written(name: &str) -> Option<&'static str> {
    let lower = name.to_lowercase();
    let found = WRITTEN.iter().find(|(other, _)| *other == lower);
    found.map(|(_, ours)| *ours)
}

/// Whether a function of this name is known elsewhere.
pub(super) fn is_elsewhere(name: &str) -> bool {
    ELSEWHERE.contains(&name.to_lowercase().as_str())
}

/// The constant that a name stands for elsewhere.
pub(super) fn constant(name: &str) -> Option<&'static str> {
    match name {
        "π" | "Pi" => Some("pi"),
        "e" => Some("exp(1)"),
        _ => None,
    }
}

/// The name used here for a function known elsewhere as `name`.
pub(super) fn alias(name: &str) -> Option<&'static str> {
    ALIASES
        .iter()
        .find(|(other, _)| *other == name)
        .map(|(_, ours)| *ours)
}

/// The candidate nearest to `name`: the same letters in another case, or one slip of the keyboard
/// (two from five letters on). `None` when every candidate would be far-fetched.
pub(super) fn nearest<'a>(
    name: &str,
    candidates: impl Iterator<Item = &'a str>,
) -> Option<&'a str> {
    let length = name.chars().count();
    if length > LONGEST_COMPARED {
        return None;
    }
    let lower = name.to_lowercase();
    let mut best: Option<(usize, f64, &str)> = None;
    for candidate in candidates.filter(|candidate| candidate.len() <= 4 * LONGEST_COMPARED) {
        let distance = if candidate.to_lowercase() == lower {
            0
        } else {
            strsim::damerau_levenshtein(name, candidate)
        };
        let shorter = length.min(candidate.chars().count());
        let allowed = match shorter {
            0 => 0,
            1 => usize::from(length > 1 || distance == 0),
            2..5 => 1,
            _ => 2,
        };
        if distance > allowed {
            continue;
        }
        let similarity = strsim::jaro_winkler(name, candidate);
        let nearer = best.is_none_or(|(least, most_similar, _)| {
            distance < least || (distance == least && similarity > most_similar)
        });
        if nearer {
            best = Some((distance, similarity, candidate));
        }
    }
    best.map(|(_, _, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn suggested(name: &str, known: &[&'static str]) -> Option<&'static str> {
        nearest(name, known.iter().copied())
    }

    #[test]
    fn slips_are_recognized_and_other_names_are_not() {
        assert_eq!(suggested("x4", &["x1", "x2"]), Some("x1"));
        assert_eq!(suggested("omgea", &["alpha", "omega"]), Some("omega"));
        assert_eq!(suggested("PI", &["N", "pi"]), Some("pi"));
        assert_eq!(suggested("xx", &["x", "pi"]), Some("x"));
        assert_eq!(suggested("y", &["x", "z"]), None);
        assert_eq!(suggested("mass", &["spin", "energy"]), None);
        assert_eq!(suggested(&"x".repeat(100_000), &["x"]), None);
    }
}
