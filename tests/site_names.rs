//! Sites by their names are those by their numbers: the same states, values and refusals, bit by bit.

use std::cell::Cell;
use std::collections::HashSet;

use leafwise::core::Registry;
use leafwise::scene::{ComposedRun, compose};
use leafwise_expression::syntax::{INDEX_NAMES, Scope};
use leafwise_tests::scenes::{composed, document, end};
use proptest::prelude::*;

/// A text with `#2#` where the name or number of the site 2 stands, and `LENGTH` for that of the chain.
struct Template(&'static str);

/// A chain of neighbours, written out, with single sites in bracket, H, a definition, forces, noise and parameters.
const CHAIN: Template = Template(
    "[system]\nfamilies = { x = LENGTH }\nboundary = \"open\"\n\
     bracket = { \"x[i],x[i+1]\" = \"x[i]*x[i+1]\", \"x[#0#],x[#2#]\" = \"0.5*x[#0#]*x[#2#]\" }\n\
     define = { first = \"x[#1#] - 0.3*x[#0#]\" }\n\
     hamiltonian = \"sum(i, x[i] - a[i]*ln(x[i])) + 0.1*first^2 + 0.2*x[#2#+1]\"\n\
     forces = { \"x[#2#]\" = \"0.01*x[#1#]\" }\n\
     noise = [{ hamiltonian = \"x[#3#]\", strength = \"0.01\" }]\n\
     [system.parameters]\n\"a[i]\" = \"1 + 0.1*i\"\n\"a[#3#]\" = \"2.5 + a0\"\na0 = 0.125\n\
     [method]\nrealization = { name = \"karasev-truncated\", order = 2 }\ndynamics = \"one-form\"\ntime-step = 0.02\n\
     [run]\nsteps = 10\nseed = 4\n\
     record = { states = [\"x[#1#]\", \"x[#2#..N]\"], observables = [\"energy\", \"x[#0#]\", { d = \"x[#2#] - x[#3#] + first\" }] }\n\
     initial = { \"x[i]\" = \"1 + 0.2*sin(i)\", \"x[#1#]\" = 1.5 }\n",
);

/// Bodies in loops over pairs.
const BODIES: Template = Template(
    "[system]\nfamilies = { q = { components = [\"x\", \"y\"], length = LENGTH }, p = { components = [\"x\", \"y\"], length = LENGTH } }\n\
     bracket = \"canonical\"\n\
     hamiltonian = \"sum(i, dot(p[i], p[i])/(2*m[i])) - sum(i<j, m[i]*m[j]/sqrt((q.x[i] - q.x[j])^2 + (q.y[i] - q.y[j])^2 + 0.1))\"\n\
     [system.parameters]\n\"m[i]\" = \"1/N\"\n\"m[#3#]\" = 0.5\n\
     [method]\nstepper = \"splitting\"\ntime-step = 0.01\n\
     [run]\nsteps = 20\nstop = \"norm(q[#0#]) > 100\"\n\
     record = { states = [\"q.x[#1#]\", \"p[#2#]\"], observables = [\"energy\", \"q.y[#0#]\", { d = \"norm(q[#2#] - q[#3#])\" }, { e = \"sum(i, q.x[i]) + q.x[#1#]\" }] }\n\
     [run.initial]\n\"q.x[i]\" = \"cos(2.4*i)\"\n\"q.y[i]\" = \"sin(1.3*i)\"\n\"p.x[i]\" = 0\n\"p.y[i]\" = \"0.1*cos(i)\"\n\"p.y[#2#]\" = 0.25\n",
);

/// A long chain, whose formulas repeat from site to site.
const LONG: Template = Template(
    "[system]\nfamilies = { q = LENGTH, p = LENGTH }\nbracket = \"canonical\"\n\
     hamiltonian = \"sum(i, p[i]^2/2 + a[i]*(1 - cos(q[i+1] - q[i])))\"\n\
     [system.parameters]\n\"a[i]\" = 1\n\"a[#3#]\" = 0.5\n\
     [method]\nstepper = \"splitting\"\ntime-step = 0.02\n\
     [run]\nsteps = 10\nstop = \"q[#0#] > 50\"\n\
     record = { states = [\"q[#1#]\", \"p[#2#..N]\"], observables = [\"energy\", \"q[#0#]\", { d = \"sum(i, p[i]) + q[#2#]*p[#3#]\" }] }\n\
     initial = { \"q[i]\" = \"sin(i)\", \"p[i]\" = 0, \"p[#1#]\" = 1.5 }\n",
);

impl Template {
    /// The text with these words for sites, and for the length of a chain.
    fn written(&self, sites: &dyn Fn(usize) -> String, length: &str) -> String {
        let mut pieces = self.0.replace("LENGTH", length);
        for site in 0..4 {
            pieces = pieces.replace(&format!("#{site}#"), &sites(site));
        }
        pieces
    }
}

/// Names that brackets can hold.
fn names(count: usize) -> impl Strategy<Value = Vec<String>> {
    let name = "[A-Za-zÄéß_][A-Za-z0-9_]{0,5}".prop_filter("a name of a site", |name: &String| {
        Scope::check_name(name).is_ok() && !INDEX_NAMES.contains(&name.as_str())
    });
    // Names that variables, parameters and families have too, and some that begin as `N` does.
    let shared = prop::sample::select(vec!["q", "x", "a0", "first", "N1", "Neptune", "e", "t"]);
    let name = prop_oneof![4 => name, 1 => shared.prop_map(str::to_owned)];
    prop::collection::vec(name, 3 * count).prop_filter_map("as many names", move |drawn| {
        let mut seen = HashSet::new();
        let own: Vec<String> = drawn
            .into_iter()
            .filter(|name| seen.insert(name.clone()))
            .collect();
        (own.len() >= count).then(|| own[..count].to_vec())
    })
}

/// What a run records at its initial state.
fn recorded(run: &ComposedRun) -> Vec<u64> {
    let functions = run.recorded_functions().expect("code");
    let values = functions.values(1, &run.system.parameter_values());
    let bits = |value: &f64| value.to_bits();
    values
        .expect("code")
        .at(&run.plan.initial)
        .iter()
        .map(bits)
        .collect()
}

/// The state at the end, those that are recorded, and the names of columns.
fn compare(template: &Template, names: &[String]) -> Result<(), TestCaseError> {
    let list: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    let by_names = template.written(
        &|site| names[site].clone(),
        &format!("[{}]", list.join(", ")),
    );
    let by_numbers = template.written(&|site| site.to_string(), &names.len().to_string());
    let (named, numbered) = (composed(&by_names), composed(&by_numbers));
    let bits = |state: &[f64]| state.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    prop_assert_eq!(bits(&named.plan.initial), bits(&numbered.plan.initial));
    prop_assert_eq!(recorded(&named), recorded(&numbered));
    prop_assert_eq!(bits(&end(&named)), bits(&end(&numbered)));
    let columns: Vec<String> = (numbered.plan.states.names().iter())
        .map(|name| {
            let (family, site) = name.split_once('[').expect("a site");
            let site: usize = site.trim_end_matches(']').parse().expect("a number");
            format!("{family}[{}]", names[site])
        })
        .collect();
    prop_assert_eq!(named.plan.states.names(), columns);
    Ok(())
}

#[test]
fn runs_by_names_of_sites_are_those_by_their_numbers() {
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(8)
    };
    let ran = Cell::new(0);
    let drawn = (names(5), names(24), names(40));
    proptest!(config, |((few, bodies, many) in drawn)| {
        for (template, names) in [(CHAIN, few), (BODIES, bodies), (LONG, many)] {
            compare(&template, &names)?;
            ran.update(|ran| ran + 1);
        }
    });
    assert!(ran.get() >= 24, "{} runs", ran.get());
}

/// A slip in any of the places is told there, with the site that is meant; it never stands for all sites.
#[test]
fn a_slip_in_a_name_is_told_where_it_stands() {
    let names: Vec<String> = ["Sun", "Mercury", "Venus", "Earth", "Mars"]
        .map(str::to_owned)
        .into();
    let list = format!("{names:?}");
    let mut slips = 0;
    for template in [CHAIN, BODIES, LONG] {
        let whole = template.written(&|site| names[site].clone(), &list);
        for at in 0..4 {
            for (place, _) in whole.match_indices(&format!("[{}", names[at])) {
                let end = place + 1 + names[at].len();
                let text = format!("{}x{}", &whole[..end], &whole[end..]);
                let refusal = match leafwise::scene::SceneDocument::parse_with(
                    "scene",
                    &text,
                    &[],
                    &Registry::with_builtin(),
                ) {
                    Err(errors) => errors.to_string(),
                    Ok(document) => match compose(&document, &Registry::with_builtin()) {
                        Ok(_) => panic!("{}x is taken:\n{text}", names[at]),
                        Err(refusal) => refusal.to_string(),
                    },
                };
                let named = refusal.contains(&names[at]);
                assert!(named, "{}x: {refusal}", names[at]);
                slips += 1;
            }
        }
    }
    assert!(slips >= 30, "{slips} slips");
}

/// Lists that are none, told by what is wrong with them.
#[test]
fn wrong_lists_of_names_are_refused() {
    let text = |families: &str| {
        format!(
            "[system]\nfamilies = {families}\nbracket = {{ \"q[i],p[i]\" = \"1\" }}\nhamiltonian = \"sum(i, p[i]^2 + q[i]^2)\"\n\
             [method]\nstepper = \"rk4\"\ntime-step = 0.1\n[run]\nsteps = 1\ninitial = {{ \"q[i]\" = 1, \"p[i]\" = 0 }}\n"
        )
    };
    let refused = |families: &str| {
        let registry = Registry::with_builtin();
        let read =
            leafwise::scene::SceneDocument::parse_with("scene", &text(families), &[], &registry);
        match read.map(|document| compose(&document, &registry)) {
            Err(errors) => errors.to_string(),
            Ok(Err(refusal)) => refusal.to_string(),
            Ok(Ok(_)) => panic!("{families} is taken"),
        }
    };
    for (families, told) in [
        (r#"{ q = ["A", "B"], p = ["A", "A"] }"#, "as before"),
        (r#"{ q = ["A", "A"], p = 2 }"#, "declared twice"),
        (r#"{ q = ["A", "i"], p = 2 }"#, "cannot name a site"),
        (r#"{ q = ["A", "N"], p = 2 }"#, "cannot name a site"),
        (r#"{ q = ["A", "1b"], p = 2 }"#, "cannot name a site"),
        (r#"{ q = ["A", "b.c"], p = 2 }"#, "cannot name a site"),
        (r#"{ q = ["A", "sin"], p = 2 }"#, "cannot name a site"),
        (r#"{ q = ["A", "B"], p = 3 }"#, "at most 2"),
        (r#"{ q = ["A", 2], p = 2 }"#, "must be"),
        (
            r#"{ q = ["A", "B"], p = [2, 1] }"#,
            "all families have the same",
        ),
    ] {
        let refusal = refused(families);
        assert!(refusal.contains(told), "{families}: {refusal}");
    }
    let document = document(&text(r#"{ q = ["A", "B"], p = 2 }"#), &[]);
    assert!(compose(&document, &Registry::with_builtin()).is_ok());
}
