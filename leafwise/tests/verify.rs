//! Measurements judge declarations: right ones hold, and one order more than the truth is caught.

mod units;

use std::num::NonZeroUsize;
use std::sync::Arc;

use leafwise::core::{
    MapAbilities, MapProperties, Method, Origin, Part, PartParameters, Registry, SolverStatistics,
    StepError, StepMap, Stepper, Structure,
};
use leafwise::scene::SceneDocument;
use leafwise::verify::{
    Judgement, Measured, Problem, Progress, Refused, Row, SurveyOptions, measure, survey,
};

/// Karasev's truncation of order n under Hamilton–Jacobi of order m.
fn truncated(problem: &Problem, n: i64, m: i64) -> Arc<dyn StepMap> {
    let registry = Registry::with_builtin();
    let order = |order: i64| PartParameters::new().with("order", order);
    let realization = registry.realization("karasev-truncated").expect("built in");
    let dynamics = registry.dynamics("hamilton-jacobi").expect("built in");
    let method = Method::compose(
        &problem.system,
        realization
            .build(&problem.system, &order(n))
            .expect("any tensor"),
        dynamics.build(&order(m)).expect("an even order"),
    );
    Arc::new(method.expect("the parts fit"))
}

/// A map that declares something else.
struct Declares(Arc<dyn StepMap>, MapProperties);

impl StepMap for Declares {
    fn dimension(&self) -> usize {
        self.0.dimension()
    }
    fn properties(&self) -> MapProperties {
        self.1
    }
    fn describe(&self) -> String {
        self.0.describe()
    }
    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        self.0.stepper(lanes, parameters, epsilon, h)
    }
}

fn measured(problem: &Problem, map: &dyn StepMap) -> Measured {
    let horizon = 20.0 * problem.time_step;
    let flow = problem.flow(&Registry::with_builtin(), horizon);
    let flow = flow.expect("the flow exists");
    measure(problem, map, (&flow, horizon), None).expect("small steps succeed")
}

/// A row of what was measured.
fn row(problem: &Problem, measured: Measured) -> Row {
    Row {
        problem: problem.name.clone(),
        map: "a map".to_owned(),
        is_own: false,
        declared_order: 4,
        smooth_order: None,
        declared_structure: "order 4".to_owned(),
        measured: Some(measured),
        failure: None,
        seconds: 0.0,
    }
}

/// The paper's Lotka–Volterra system with its own step: few defects of n = 8 lie between round-off
/// and the range where powers of t rule.
fn steep() -> Problem {
    let mut problem = Problem::of_library("lotka-volterra").expect("in the library");
    problem.time_step = 0.2;
    problem
}

#[test]
fn what_is_declared_of_a_long_truncation_holds() {
    for n in [4, 6, 8] {
        let problem = steep();
        let map = truncated(&problem, n, 8);
        assert_eq!(map.properties().structure, Structure::Order(n as usize));
        let found = measured(&problem, map.as_ref());
        assert_eq!(
            found.judgements[1],
            Judgement::Met,
            "n = {n}: {:?}",
            found.structure
        );
        // Over a shorter time the flow can be told from its limit.
        let problem = Problem::of_library("lotka-volterra").expect("in the library");
        let found = measured(&problem, map.as_ref());
        let context = format!("n = {n}: {:?} {:?}", found.order, found.structure);
        assert_eq!(found.judgements, [Judgement::Met; 3], "{context}");
    }
}

/// The truth is n for even n, and for even m.
#[test]
fn one_order_more_than_the_truth_is_caught() {
    for problem in [
        steep(),
        Problem::of_library("lotka-volterra-periodic").expect("there"),
    ] {
        for n in [2, 4, 6, 8] {
            let map = truncated(&problem, n, 2);
            let truth = map.properties();
            let structure = Structure::Order(n as usize + 1);
            let boasts = Declares(map, MapProperties { structure, ..truth });
            let found = measured(&problem, &boasts);
            let context = format!("{} n = {n}: {:?}", problem.name, found.structure);
            assert_ne!(found.judgements[1], Judgement::Met, "{context}");
            if n < 8 {
                assert_eq!(found.judgements[1], Judgement::NotMet, "{context}");
            }
        }
    }
    let problem = Problem::of_library("lotka-volterra-periodic").expect("in the library");
    for m in [2, 4, 6] {
        let map = truncated(&problem, 8, m);
        let truth = map.properties();
        let order = truth.order + 1;
        let found = measured(&problem, &Declares(map, MapProperties { order, ..truth }));
        assert_eq!(
            found.judgements[0],
            Judgement::NotMet,
            "m = {m}: {:?}",
            found.order
        );
    }
}

/// A map with the shadow Hamiltonian of another.
struct Shadowed(Arc<dyn StepMap>, Arc<dyn StepMap>);

impl StepMap for Shadowed {
    fn dimension(&self) -> usize {
        self.0.dimension()
    }
    fn properties(&self) -> MapProperties {
        self.0.properties()
    }
    fn describe(&self) -> String {
        self.0.describe()
    }
    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        self.0.stepper(lanes, parameters, epsilon, h)
    }
    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities {
            shadow: self.1.abilities().shadow,
            ..MapAbilities::default()
        }
    }
}

/// H + t^m F_{m+1} is kept to order m + 2, to 2⌊n/2⌋ + 2 over a realization of order n, and to m with the F_{m+1} of another map.
#[test]
fn a_shadow_energy_is_kept_to_the_order_of_its_map() {
    for name in ["rigid-body", "lotka-volterra-periodic"] {
        let problem = Problem::of_library(name).expect("in the library");
        let registry = Registry::with_builtin();
        let splitting = registry.stepper("splitting").expect("built in");
        let splitting = splitting.build(&problem.system, &PartParameters::new());
        let splitting = splitting.expect("it has pieces");
        let jacobi = truncated(&problem, 8, 2);
        for (map, declared) in [
            (Arc::clone(&splitting), 4),
            (Arc::clone(&jacobi), 4),
            (truncated(&problem, 8, 4), 6),
            (truncated(&problem, 2, 4), 4),
        ] {
            let found = measured(&problem, map.as_ref());
            let kept = found.shadow_energy.expect("a short formula");
            assert_eq!(
                (kept.declared, kept.judgement),
                (declared, Judgement::Met),
                "{name}: {}: {:?}",
                map.describe(),
                kept.order
            );
        }
        let wrong = Shadowed(splitting, jacobi);
        let found = measured(&problem, &wrong);
        let kept = found.shadow_energy.as_ref().expect("a short formula");
        assert_eq!(
            kept.judgement,
            Judgement::NotMet,
            "{name}: {:?}",
            kept.order
        );
        assert_eq!(found.judgements, [Judgement::Met; 3]);
        assert!(!row(&problem, found).is_met());
    }
}

/// Where coordinates are 0 they hold what a step puts into them alone, and entries of the tensor with them: orders of
/// defects are those of the map there as elsewhere.
#[test]
fn an_order_is_that_of_the_map_where_coordinates_are_zero() {
    let mut problem = Problem::of_library("guiding-centre").expect("in the library");
    assert_eq!(problem.initial[1..3], [0.0, 0.0]);
    for place in [[0.0, 0.0], [0.02, 0.3]] {
        problem.initial[1..3].copy_from_slice(&place);
        for n in [2, 4] {
            let map = truncated(&problem, n, 2);
            let truth = map.properties();
            let found = measured(&problem, map.as_ref());
            let context = format!("{place:?} n = {n}: {:?}", found.structure);
            assert_eq!(found.judgements[1], Judgement::Met, "{context}");
            let structure = Structure::Order(n as usize + 1);
            let boasts = Declares(map, MapProperties { structure, ..truth });
            let found = measured(&problem, &boasts);
            assert_ne!(found.judgements[1], Judgement::Met, "{context}");
        }
    }
}

/// A map that bears only small steps.
struct Limited {
    map: Arc<dyn StepMap>,
    largest: f64,
}

impl StepMap for Limited {
    fn dimension(&self) -> usize {
        self.map.dimension()
    }
    fn properties(&self) -> MapProperties {
        self.map.properties()
    }
    fn describe(&self) -> String {
        self.map.describe()
    }
    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let stepper = self.map.stepper(lanes, parameters, epsilon, h);
        if (epsilon * h).abs() <= self.largest {
            stepper
        } else {
            Box::new(Fails(stepper, StepError::LeftChart { ratio: 2.0 }))
        }
    }
}

struct Fails(Box<dyn Stepper>, StepError);

impl Stepper for Fails {
    fn increment(
        &mut self,
        _: &[f64],
        _: &[f64],
        _: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        outcome.fill(Err(self.1.clone()));
    }
    fn restart(&mut self) {}
    fn statistics(&self) -> SolverStatistics {
        self.0.statistics()
    }
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    fn restore(&mut self, _: &[f64]) -> Result<(), usize> {
        Ok(())
    }
}

#[test]
fn a_step_that_is_too_large_breaks_no_promise() {
    let problem = Problem::of_library("rigid-body").expect("in the library");
    let map = truncated(&problem, 4, 4);
    let largest = 0.3 * problem.time_step;
    let found = measured(&problem, &Limited { map, largest });
    assert_eq!(found.judgements, [Judgement::Met; 3]);
    assert_eq!(found.time_step, problem.time_step / 4.0);
    assert!(
        found
            .too_large
            .is_some_and(|why| why.contains("left the realization's chart"))
    );
}

#[test]
fn a_map_that_fails_at_every_step_fails() {
    let problem = Problem::of_library("rigid-body").expect("in the library");
    let map = truncated(&problem, 4, 4);
    let horizon = problem.time_step;
    let outcome = measure(
        &problem,
        &Limited { map, largest: 0.0 },
        (&problem.initial, horizon),
        None,
    );
    assert_eq!(outcome.err(), Some(StepError::LeftChart { ratio: 2.0 }));
}

/// A map that fails between two steps.
struct Hole(Arc<dyn StepMap>, [f64; 2]);

impl StepMap for Hole {
    fn dimension(&self) -> usize {
        self.0.dimension()
    }
    fn properties(&self) -> MapProperties {
        self.0.properties()
    }
    fn describe(&self) -> String {
        self.0.describe()
    }
    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let stepper = self.0.stepper(lanes, parameters, epsilon, h);
        let t = (epsilon * h).abs();
        if t < self.1[0] || t > self.1[1] {
            stepper
        } else {
            let error = StepError::NoConvergence {
                evaluations: 200,
                correction: 1.0,
            };
            Box::new(Fails(stepper, error))
        }
    }
}

/// What is too large for a solve fails at every larger step; a solve that fails between steps that succeed is
/// broken, whatever the others show.
#[test]
fn a_solve_that_fails_between_steps_that_succeed_is_no_step_that_is_too_large() {
    let problem = Problem::of_library("rigid-body").expect("in the library");
    let t = problem.time_step;
    let found = |from: f64, to: f64| {
        let map = truncated(&problem, 4, 4);
        measured(&problem, &Hole(map, [from * t, to * t]))
    };
    let broken = found(0.3, 0.9);
    assert_eq!(broken.judgements, [Judgement::Met; 3]);
    let why = broken.broken_solve.clone().expect("a hole");
    assert!(why.contains("succeeds: no convergence"), "{why}");
    assert!(!row(&problem, broken).is_met());
    let too_large = found(0.3, f64::INFINITY);
    assert!(too_large.too_large.is_some() && too_large.broken_solve.is_none());
    assert!(row(&problem, too_large).is_met());
}

/// {q, p} = f(z) and {q, p} = z: z rests, and a Gauss method is symplectic on each of its planes. Over so(3)*, and
/// where the tensor depends on what moves, it is not.
#[test]
fn gauss_methods_are_poisson_maps_where_the_tensor_depends_on_what_rests() {
    let problem = |bracket: &str| {
        let text = format!(
            "[system]\nvariables = [\"q\", \"p\", \"z\"]\nbracket = {{ \"q,p\" = \"{bracket}\" }}\n\
             hamiltonian = \"p^2/2 + q^4/4 + q^2/2 + z*q\"\n[method]\nstepper = \"gauss\"\n\
             time-step = 0.1\n[run]\ninitial = [0.5, 0.7, 1.3]\nsteps = 1\n"
        );
        let document = SceneDocument::parse("leaves.toml", &text, &Registry::with_builtin());
        Problem::of_scene(&document.expect("a scene")).expect("a problem")
    };
    let registry = Registry::with_builtin();
    for name in ["gauss", "implicit-midpoint"] {
        let built = |problem: &Problem| {
            let part = registry.stepper(name).expect("built in");
            let map = part.build(&problem.system, &PartParameters::new());
            map.expect("any tensor")
        };
        for bracket in ["z", "1 + sin(z)^2"] {
            let problem = problem(bracket);
            let map = built(&problem);
            assert_eq!(
                map.properties().structure,
                Structure::Exact,
                "{name}, {bracket}"
            );
            let found = measured(&problem, map.as_ref());
            assert_eq!(
                found.judgements,
                [Judgement::Met; 3],
                "{name}, {bracket}: {found:?}"
            );
        }
        let body = Problem::of_library("rigid-body").expect("in the library");
        for problem in [problem("1 + q^2"), body] {
            let map = built(&problem);
            let truth = map.properties();
            assert_eq!(truth.structure, Structure::None, "{name}");
            let structure = Structure::Exact;
            let boasts = Declares(map, MapProperties { structure, ..truth });
            assert_eq!(measured(&problem, &boasts).judgements[1], Judgement::NotMet);
        }
    }
}

#[test]
fn a_scene_is_verified_with_its_own_method() {
    let text = "[system]\nlibrary = \"rigid-body\"\n[method]\nstepper = \"splitting\"\n\
                composition = \"kahan-li-6\"\ntime-step = 0.1\n[run]\ninitial = [1, 3, 3]\nsteps = 1\n";
    let document =
        SceneDocument::parse("own.toml", text, &Registry::with_builtin()).expect("a scene");
    let registry = Registry::with_builtin();
    let problem = Problem::with_method(&document, &registry);
    let problem = problem.expect("a problem");
    // Nothing else is measured but what the reference flow is taken by.
    let gauss = Part::Stepper(registry.stepper("gauss").expect("built in"));
    let mut registry = Registry::empty();
    registry
        .register(gauss, Origin::built_in("a test", "1"))
        .expect("a new name");
    let options = SurveyOptions {
        full: false,
        threads: NonZeroUsize::MIN,
    };
    let survey = survey(&registry, &[problem], &options, &mut Recorded::default()).expect("a flow");
    assert!(survey.is_met());
    let own: Vec<_> = survey.rows.iter().filter(|row| row.is_own).collect();
    assert_eq!(own.len(), 1);
    assert!(own[0].map.contains("kahan-li-6"), "{}", own[0].map);
    assert_eq!(own[0].declared_order, 6);
}

/// Charge over mass is 5e7 in SI units, and terms of that size cancel in the tensor: a defect that does not fall with the step is
/// round-off. A map of order 4 that declares itself exact is caught there too.
#[test]
fn round_off_of_cancelled_terms_is_no_broken_structure() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/tokamak_losses.toml");
    let (text, registry) = (
        std::fs::read_to_string(file).expect("a scene"),
        Registry::with_builtin(),
    );
    let document = SceneDocument::parse(file, &text, &registry).expect("a scene");
    let problem = Problem::with_method(&document, &registry).expect("a problem");
    let own = problem.own.as_ref().expect("the scene's method");
    let judged = measured(&problem, own.map.as_ref()).judgements[1];
    assert!(
        matches!(judged, Judgement::Met | Judgement::Undecided),
        "{judged:?}"
    );
    let part = registry.stepper("rk4").expect("built in");
    let rk4 = part
        .build(&problem.system, &PartParameters::new())
        .expect("any system");
    let exact = MapProperties {
        structure: Structure::Exact,
        ..rk4.properties()
    };
    let judged = measured(&problem, &Declares(rk4, exact)).judgements[1];
    assert_eq!(judged, Judgement::NotMet);
}

/// What a survey tells, in its order.
#[derive(Default)]
struct Recorded(Vec<String>);

impl Progress for Recorded {
    fn problem(&mut self, name: &str, _: usize) {
        self.0.push(name.to_owned());
    }
    fn refused(&mut self, refused: &Refused) {
        self.0.push(refused.combination.clone());
    }
    fn row(&mut self, row: &Row) {
        self.0.push(row.map.clone());
    }
}

/// Everything but times.
fn without_times(rows: &[Row]) -> Vec<String> {
    let without = |row: &Row| {
        let mut row = row.clone();
        row.seconds = 0.0;
        if let Some(measured) = &mut row.measured {
            measured.nanoseconds_per_step = 0.0;
        }
        format!("{row:?}")
    };
    rows.iter().map(without).collect()
}

#[test]
fn a_survey_does_not_depend_on_its_threads() {
    // One that is refused, and enough of each kind for three threads.
    let built_in = Registry::with_builtin();
    let mut registry = Registry::empty();
    let mut take = |part: Part| {
        let origin = Origin::built_in("a test", "1");
        registry.register(part, origin).expect("a new name");
    };
    for name in ["so3-exponential", "karasev-truncated", "darboux-magnetic"] {
        take(Part::Realization(
            built_in.realization(name).expect("built in"),
        ));
    }
    for name in ["hamilton-jacobi", "collective"] {
        take(Part::Dynamics(built_in.dynamics(name).expect("built in")));
    }
    for name in ["gauss", "splitting", "rk4"] {
        take(Part::Stepper(built_in.stepper(name).expect("built in")));
    }
    let problems = [Problem::of_library("rigid-body").expect("in the library")];
    let run = |threads: usize| {
        let options = SurveyOptions {
            full: false,
            threads: NonZeroUsize::new(threads).expect("not 0"),
        };
        let mut told = Recorded::default();
        let survey = survey(&registry, &problems, &options, &mut told).expect("a flow");
        assert!(survey.is_met());
        (without_times(&survey.rows), survey.refused, told.0)
    };
    let (rows, refused, told) = run(1);
    assert!(rows.len() > 5, "{} rows", rows.len());
    assert!(
        told.len() > rows.len() && !refused.is_empty(),
        "{told:?} {refused:?}"
    );
    assert_eq!((rows, refused, told), run(3));
}
