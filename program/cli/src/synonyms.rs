//! Everyday words, and where the guide explains what is meant.

use crate::guide::{Explained, PAGES, folded, named, part, readable};

/// Words for what a part of the guide explains under another name.
struct Synonym {
    words: &'static [&'static str],
    /// The page.
    page: &'static str,
    /// A part of the page: words of its heading, or a name in the first column of a table.
    at: &'static str,
    /// Text that stands there, for the test.
    #[cfg_attr(not(test), expect(dead_code, reason = "of the test"))]
    says: &'static str,
}

const fn leads(
    words: &'static [&'static str],
    page: &'static str,
    at: &'static str,
    says: &'static str,
) -> Synonym {
    Synonym {
        words,
        page,
        at,
        says,
    }
}

/// A word may stand in several rows: all parts are printed. The book's search reads these rows too (`tools/book.py`).
const SYNONYMS: [Synonym; 58] = [
    leads(
        &["plot", "figure", "figures", "pdf"],
        "read-the-report",
        "figures for a paper",
        "leafwise plot",
    ),
    leads(
        &["orbit", "periodic", "floquet"],
        "orbits",
        "periodic orbits",
        "Newton",
    ),
    leads(
        &[
            "continuation",
            "bifurcation",
            "bifurcations",
            "branch",
            "fold",
            "family",
            "halo",
        ],
        "orbits",
        "families",
        "tangent",
    ),
    leads(
        &["equilibrium", "fixed", "stability", "stable", "unstable"],
        "orbits",
        "equilibria",
        "Newton",
    ),
    leads(
        &["sign", "signs", "backward", "backwards", "reversed"],
        "define-a-system",
        "the sign",
        "{H, x}",
    ),
    leads(
        &["backward", "backwards", "negative"],
        "keys",
        "time-step",
        "backwards",
    ),
    leads(
        &["sign", "reversed"],
        "read-the-report",
        "backward-time",
        "convention",
    ),
    leads(
        &["units", "unit", "si"],
        "define-a-system",
        "units",
        "Units are yours",
    ),
    leads(
        &["friction", "drag", "dissipation", "dissipative"],
        "forces",
        "damping",
        "rate",
    ),
    leads(&["friction", "drag"], "forces", "forces", "friction*p"),
    leads(
        &["friction", "drag", "viscous", "viscosity"],
        "forces",
        "friction that leaves the leaf",
        "viscous fluid",
    ),
    leads(
        &["boozer", "stellarator", "stellarators", "netcdf", "boozmn"],
        "equilibria",
        "stellarators: boozer coordinates",
        "Boozer",
    ),
    leads(
        &[
            "fit",
            "fitting",
            "estimate",
            "estimation",
            "observations",
            "regression",
        ],
        "gradients",
        "parameters from observations",
        "Fit",
    ),
    leads(
        &[
            "restart",
            "resume",
            "checkpoint",
            "checkpoints",
            "continue",
            "extend",
            "crash",
            "interrupt",
        ],
        "read-the-report",
        "interrupted, resumed",
        "checkpoint",
    ),
    leads(
        &["exit", "exit code", "exit codes", "return code", "status"],
        "commands",
        "commands",
        "interrupted, with a checkpoint",
    ),
    leads(
        &[
            "adaptive",
            "adaptive step",
            "adaptive steps",
            "variable step",
            "step size control",
        ],
        "time",
        "a pace: variable steps",
        "adaptive step",
    ),
    leads(
        &[
            "n-body",
            "nbody",
            "n body",
            "two-body",
            "bodies",
            "gravity",
            "planets",
            "stars",
            "molecular dynamics",
        ],
        "lattices",
        "many bodies",
        "pairs",
    ),
    leads(
        &["n-body", "nbody", "n body", "planets", "rebound", "mercury"],
        "from-rebound",
        "what becomes of the words",
        "leapfrog",
    ),
    leads(
        &[
            "species",
            "population",
            "populations",
            "predator",
            "ecology",
            "library",
            "examples",
        ],
        "define-a-system",
        "systems of the library",
        "lotka-volterra",
    ),
    leads(
        &["section", "crossing", "surface of section"],
        "events",
        "a poincaré section",
        "crosses",
    ),
    leads(
        &["numpy", "array", "arrays"],
        "tables",
        "files",
        "numpy.save",
    ),
    leads(
        &["numpy", "pandas", "dataframe"],
        "start",
        "in python",
        "leafwise",
    ),
    leads(
        &["numpy", "solve_ivp", "odeint"],
        "from-scipy",
        "what becomes of the arguments",
        "NumPy",
    ),
    leads(
        &["field", "magnetic field", "lorentz", "charge"],
        "define-a-system",
        "shorter brackets",
        "magnetic field",
    ),
    leads(
        &["field", "grid data", "interpolation"],
        "tables",
        "a potential at nodes",
        "values",
    ),
    leads(
        &["vary", "scan", "parameter study", "bifurcation"],
        "sweeps",
        "sweeps",
        "grid",
    ),
    leads(
        &[
            "accuracy",
            "precision",
            "tolerance",
            "tolerances",
            "error",
            "rtol",
            "atol",
        ],
        "choose",
        "order and step",
        "error that you need",
    ),
    leads(
        &["accuracy", "precision", "tolerance", "tolerances"],
        "commands",
        "commands",
        "tune",
    ),
    leads(
        &["energy drift", "energy error", "conservation", "conserved"],
        "read-the-report",
        "drifts",
        "largest drift",
    ),
    leads(
        &[
            "fail",
            "fails",
            "failure",
            "diverged",
            "divergence",
            "convergence",
            "newton",
            "nan",
        ],
        "read-the-report",
        "failed steps",
        "no convergence",
    ),
    leads(
        &["dense", "dense output", "interpolate", "resample", "t_eval"],
        "time",
        "samples at given times",
        "a shorter step",
    ),
    leads(
        &[
            "stop",
            "terminate",
            "terminal",
            "callback",
            "callbacks",
            "trigger",
            "event",
        ],
        "events",
        "a condition that ends the run",
        "The run ends where",
    ),
    leads(
        &[
            "bounce",
            "collision",
            "collisions",
            "kick",
            "wall",
            "impact",
            "billiard",
        ],
        "events",
        "bounces, kicks",
        "changes the state",
    ),
    leads(
        &["temperature", "thermostat", "stochastic", "brownian"],
        "noise",
        "langevin dynamics",
        "temperature",
    ),
    leads(
        &["threads", "parallel", "cores", "slurm", "mpi"],
        "clusters",
        "clusters: ensembles",
        "merge",
    ),
    leads(
        &["time-dependent", "nonautonomous", "driven", "drive"],
        "time",
        "a hamiltonian that names the time",
        "names the time",
    ),
    leads(
        &["orientation", "quaternion", "attitude", "euler angles"],
        "define-a-system",
        "systems of the library",
        "quaternion",
    ),
    leads(
        &["orientation", "quaternion", "satellite"],
        "forces",
        "a torque on a body",
        "quaternion",
    ),
    leads(
        &[
            "random",
            "monte carlo",
            "sampling",
            "distribution",
            "uncertainty",
        ],
        "ensembles",
        "initial states",
        "normally distributed",
    ),
    leads(
        &[
            "invariant",
            "invariants",
            "first integral",
            "constant of motion",
            "conserved quantity",
        ],
        "define-a-system",
        "casimirs",
        "a run watches it",
    ),
    leads(
        &["ode", "rhs", "right-hand side", "vector field"],
        "find",
        "in a scene",
        "equations",
    ),
    leads(
        &["state error", "error estimate", "phase error"],
        "read-the-report",
        "drifts",
        "--error",
    ),
    leads(
        &["gpu", "cuda", "pde", "stiff", "delay"],
        "other-tools",
        "when another tool",
        "processor",
    ),
    leads(
        &["jupyter", "notebook", "ipython"],
        "start",
        "in python",
        "notebook",
    ),
    leads(
        &["boundary", "periodic boundary", "open boundary"],
        "define-a-system",
        "lattices",
        "The boundary is periodic",
    ),
    leads(
        &["leapfrog", "verlet", "symplectic", "integrator"],
        "choose",
        "three questions",
        "go on with question 2",
    ),
    leads(
        &["step size", "stepsize", "dt", "h", "step"],
        "keys",
        "time-step",
        "time-step",
    ),
    leads(
        &["step size", "stepsize", "dt", "step"],
        "choose",
        "order and step",
        "step",
    ),
    leads(
        &[
            "angle", "angles", "degrees", "degree", "radians", "pi", "log", "exp", "sin", "cos",
            "sqrt", "function",
        ],
        "formulas",
        "functions",
        "sqrt",
    ),
    leads(
        &[
            "save", "saved", "output", "outputs", "csv", "results", "files", "write",
        ],
        "read-the-report",
        "the run directory",
        "samples.csv",
    ),
    leads(
        &["save", "memory", "disk", "every"],
        "read-the-report",
        "which states are recorded",
        "every",
    ),
    leads(
        &["speed", "fast", "faster", "slow", "performance", "cost"],
        "choose-a-method",
        "let it be measured",
        "tune",
    ),
    leads(
        &["threads", "thread", "parallel", "cores"],
        "commands",
        "--threads n",
        "all",
    ),
    leads(&["period"], "orbits", "periodic orbits", "period"),
    leads(&["pace"], "time", "a pace: variable steps", "pace"),
    leads(
        &[
            "pendulum",
            "oscillator",
            "kepler",
            "top",
            "spins",
            "vortices",
        ],
        "define-a-system",
        "systems of the library",
        "pendulum",
    ),
    leads(
        &["magnet", "magnetic", "charges"],
        "define-a-system",
        "shorter brackets",
        "magnetic field",
    ),
    leads(
        &["cite", "citation", "licence", "license"],
        "commands",
        "citation",
        "CITATION.cff",
    ),
];

/// Words of a question that name no subject.
const SMALL: [&str; 40] = [
    "a", "an", "and", "are", "at", "be", "by", "can", "do", "does", "for", "from", "get", "have",
    "how", "i", "in", "into", "is", "it", "make", "me", "mean", "my", "of", "on", "one", "or",
    "run", "set", "the", "there", "this", "to", "two", "use", "what", "which", "with", "you",
];

/// The parts of the guide that explain what an everyday word stands for.
fn synonyms(word: &str) -> Vec<Explained> {
    let meant = SYNONYMS.iter().filter(|own| own.words.contains(&word));
    meant.flat_map(|own| part(own.page, own.at)).collect()
}

/// Parts of the pages that explain a word.
///
/// 1. The page of that name, alone.
/// 2. Parts of which it is an everyday word.
/// 3. Rows of tables that begin with the word, and sections whose headings have it.
/// 4. For a question of several words without these, the same of its longest parts that are known.
pub fn explained(word: &str) -> Vec<Explained> {
    let word = folded(word.trim());
    let whole = of_word(&word);
    let parts: Vec<&str> = word
        .split(|c: char| !(c.is_alphanumeric() || "-_.".contains(c)))
        .collect();
    let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    if !whole.is_empty() || parts.len() < 2 {
        return whole;
    }
    (1..parts.len())
        .rev()
        .map(|length| {
            let mut found = Vec::new();
            for words in parts.windows(length) {
                if words.iter().any(|word| !SMALL.contains(word)) {
                    add(&mut found, of_word(&words.join(" ")));
                }
            }
            found
        })
        .find(|found| !found.is_empty())
        .unwrap_or_default()
}

/// Adds parts that are not there yet.
fn add(found: &mut Vec<Explained>, parts: impl IntoIterator<Item = Explained>) {
    for part in parts {
        if found.iter().all(|known| known.text != part.text) {
            found.push(part);
        }
    }
}

/// Parts that explain a word or a phrase as it stands, in the singular or the plural, with or without hyphens.
fn of_word(word: &str) -> Vec<Explained> {
    let word = word.to_owned();
    if let Some((page, text)) = PAGES.into_iter().find(|(name, _)| *name == word) {
        return vec![Explained {
            page,
            text: readable(text),
        }];
    }
    let mut found: Vec<Explained> = Vec::new();
    for form in forms(&word) {
        add(&mut found, synonyms(&form));
    }
    add(&mut found, named(&word));
    for form in forms(&word) {
        if found.is_empty() {
            add(&mut found, named(&form));
        }
    }
    found
}

/// A word, with spaces and with hyphens, and each in the singular; `time step` and `time-step` of `timestep`.
fn forms(word: &str) -> Vec<String> {
    let mut forms = vec![word.to_owned(), word.replace(['-', '_'], " ")];
    forms.push(forms[1].replace(' ', "-"));
    if let Some(rest) = word.strip_prefix("time")
        && rest.starts_with("step")
    {
        forms.push(format!("time-{rest}"));
    }
    for at in 0..forms.len() {
        forms.extend(forms[at].strip_suffix('s').map(str::to_owned));
    }
    forms
}

#[cfg(test)]
mod tests {
    use super::{SYNONYMS, explained};
    use crate::guide::{PAGES, part};

    /// Each leads to a part that contains the answer, and is found by each of its words.
    #[test]
    fn everyday_words_lead_to_their_answers() {
        for own in &SYNONYMS {
            let parts = part(own.page, own.at);
            let text: String = parts.iter().map(|part| part.text.as_str()).collect();
            assert!(text.contains(own.says), "{}: {}: {text}", own.page, own.at);
            for word in own.words {
                let found = explained(word);
                let is_led = found
                    .iter()
                    .any(|found| parts.iter().any(|part| part.text == found.text));
                assert!(is_led, "{word}");
            }
        }
    }

    #[test]
    fn the_words_of_newcomers_are_known() {
        for word in [
            "sign",
            "units",
            "friction",
            "drag",
            "fit",
            "restart",
            "checkpoint",
            "exit codes",
            "negative",
            "backward",
            "adaptive",
            "n-body",
            "gravity",
            "planets",
            "species",
            "poincare",
            "Poincaré",
            "POINCARE",
            "numpy",
            "field",
            "vary",
            "accuracy",
            "tolerance",
            "energy drift",
            "resume",
            "Exit Code",
            "step-size control",
            "dense output",
            "failed steps",
            "collision",
            "temperature",
            "threads",
            "time-dependent",
            "quaternion",
            "timestep",
            "time-steps",
            "seeds",
            "pendulum",
            "magnet",
            "degrees",
            "save",
            "memory",
            "speed",
            "cite",
            "initial values",
            "continue a run",
            "how do I add friction?",
            "exit code 6",
            "use from C",
            "sweep two parameters",
            "stop at an event",
            "units of time-step",
        ] {
            assert!(!explained(word).is_empty(), "{word}");
        }
    }

    #[test]
    fn every_kind_of_advice_is_explained() {
        let page = PAGES.iter().find(|(name, _)| *name == "read-the-report");
        let (_, text) = page.expect("a page");
        let kinds = text.lines().filter_map(|line| {
            let kind = line.strip_prefix("| `")?.split('`').next()?;
            line.matches('|').nth(3).map(|_| kind)
        });
        let mut count = 0;
        for kind in kinds {
            let found = explained(kind);
            assert!(found.iter().any(|part| part.text.contains(kind)), "{kind}");
            count += 1;
        }
        assert!(count > 20, "{count} rows");
    }

    #[test]
    fn words_lead_to_pages_rows_and_sections() {
        assert_eq!(explained("formulas").len(), 1);
        let row = explained("backward-time");
        assert!(
            row[0].text.contains("the other `convention`"),
            "{}",
            row[0].text
        );
        let sections = explained("torque");
        for page in ["forces", "keys"] {
            assert!(sections.iter().any(|part| part.page == page), "{page}");
        }
        for unknown in ["xyzzy", "xyzzy plugh", "how is the xyzzy"] {
            assert!(explained(unknown).is_empty(), "{unknown}");
        }
    }
}
