//! Brackets of classical equations, found and proved, and equations that have none.

use leafwise_core::diagnostics::{Verdict, check_casimir, check_jacobi};
use leafwise_core::{PoissonSystem, SystemFormulas};
use leafwise_expression::syntax::{Formula, Scope};
use leafwise_expression::{Arithmetic, Expression, Rational, Ring};
use leafwise_find::{Bracket, Equations, Kind, Options, Report, find};

fn equations(rows: &[(&str, &str)], parameters: &[(&str, Rational)]) -> Equations {
    let names: Vec<&str> = rows.iter().map(|(name, _)| *name).collect();
    let of: Vec<&str> = parameters.iter().map(|(name, _)| *name).collect();
    let scope = Scope::new().with_variables(&names).with_parameters(&of);
    let formula = |text: &str| {
        let parsed = Formula::parse(text).expect(text);
        parsed.resolve(&scope, None).expect(text).expect(text)
    };
    let field = rows.iter().map(|(_, text)| formula(text)).collect();
    let names = names.iter().map(|&name| name.to_owned()).collect();
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), value.clone()));
    Equations::new(names, parameters.collect(), field).expect("a formula for each variable")
}

fn search(rows: &[(&str, &str)]) -> Report {
    find(&equations(rows, &[]), Options::default()).expect("formulas of the algebra")
}

/// −Π ∇H − f of the paper's convention in a ring of its own: which components are not zero.
fn defects(system: &SystemFormulas, field: &[Expression]) -> Vec<usize> {
    let mut ring = Ring::new(field.len());
    let x: Vec<_> = (0..field.len()).map(|i| ring.variable(i)).collect();
    let variable = &mut |_: &mut Ring, at: usize| Ok(x[at].clone());
    let energy = system.hamiltonian().evaluate_in(&mut ring, variable).expect("a formula");
    let gradient = ring.gradient(&energy).expect("smooth");
    let rows = system.apply_tensor(&mut ring, &x, &gradient).expect("formulas");
    let mut wrong = Vec::new();
    for (at, (row, f)) in rows.iter().zip(field).enumerate() {
        let f = f.evaluate_in(&mut ring, &mut |_, at| Ok(x[at].clone())).expect("a formula");
        if !ring.add(row, &f).is_zero() {
            wrong.push(at);
        }
    }
    wrong
}

/// The bracket of equations, with Jacobi's identity, the motion and the Casimirs looked at once more.
fn bracket(rows: &[(&str, &str)]) -> Bracket {
    let report = search(rows);
    let bracket = report.bracket.unwrap_or_else(|| panic!("{:?} {:?}", report.refused, report.never));
    let field = equations(rows, &[]);
    assert!(defects(&bracket.system, field.field()).is_empty());
    is_proved(&bracket.system);
    bracket
}

fn is_proved(system: &SystemFormulas) {
    let near = system.near().to_vec();
    let checked = PoissonSystem::from(system.clone());
    let check = check_jacobi(&checked, &[], &near).expect("formulas");
    assert_eq!(check.verdict, Verdict::Proved);
    for casimir in 0..system.casimirs().len() {
        let check = check_casimir(&checked, casimir, &[], &near).expect("formulas");
        assert_eq!(check.verdict, Verdict::Proved);
    }
}

fn written(bracket: &Bracket, formula: &Expression) -> String {
    formula.written(bracket.system.variables(), &[])
}

fn entries(bracket: &Bracket) -> Vec<String> {
    let names = bracket.system.variables();
    let entries = bracket.entries.iter();
    let text = |(&(i, j), entry): (&(usize, usize), &Expression)| {
        format!("{{{}, {}}} = {}", names[i], names[j], written(bracket, entry))
    };
    entries.map(text).collect()
}

fn show(name: &str, rows: &[(&str, &str)]) {
    let start = std::time::Instant::now();
    let report = search(rows);
    println!("== {name}: {:?}", start.elapsed());
    for refused in &report.refused {
        println!("   {:?}: {} (proved {})", refused.kind, refused.reason, refused.is_proved);
    }
    println!("   integrals {} of degree {}, never {:?}", report.integrals.len(), report.degree, report.never);
    if let Some(b) = &report.bracket {
        println!("   {:?} family {}: {:?}", b.kind, b.family, entries(b));
        println!("   H = {}", written(b, &b.hamiltonian));
        for c in &b.casimirs { println!("   C = {}", written(b, c)); }
    }
}

#[test]
fn all() {
    show("hh", &[("q1","p1"),("q2","p2"),("p1","-q1-2*q1*q2"),("p2","-q2-q1^2+q2^2")]);
    show("lv resc", &[("a","a*(2*b+c/2+3*d-4)"),("b","b*(-a+c/2+3*d-1)"),("c","c*(-a-2*b+3*d+2)"),("d","d*(-a-2*b-c/2+4)")]);
    show("lv odd", &[("a","a*(b-c)"),("b","b*(c-a)"),("c","c*(a-b)")]);
    show("b5", &[("x","y*z"),("y","-x*z"),("z","-0.51*x*y")]);
    show("top", &[("m1","(1/2-2/3)*m2*m3+0.9*g2-0.2*g3"),("m2","(1-1/2)*m1*m3+0.3*g3-0.9*g1"),("m3","(2/3-1)*m1*m2+0.2*g1-0.3*g2"),("g1","g2*m3/2-g3*m2/1.5"),("g2","g3*m1-g1*m3/2"),("g3","g1*m2/1.5-g2*m1")]);
    show("top friction", &[("m1","(1/2-2/3)*m2*m3+0.9*g2-0.2*g3-0.1*m1"),("m2","(1-1/2)*m1*m3+0.3*g3-0.9*g1-0.1*m2"),("m3","(2/3-1)*m1*m2+0.2*g1-0.3*g2-0.1*m3"),("g1","g2*m3/2-g3*m2/1.5"),("g2","g3*m1-g1*m3/2"),("g3","g1*m2/1.5-g2*m1")]);
    // m' = m x a + p x b with a = m/I, I = (1, 1.5, 2), b = p/M, M = (1, 2, 1.6); p' = p x a.
    show("kirchhoff", &[("m1","m2*m3/2-m3*m2/1.5+p2*p3/1.6-p3*p2/2"),("m2","m3*m1-m1*m3/2+p3*p1-p1*p3/1.6"),("m3","m1*m2/1.5-m2*m1+p1*p2/2-p2*p1"),("p1","p2*m3/2-p3*m2/1.5"),("p2","p3*m1-p1*m3/2"),("p3","p1*m2/1.5-p2*m1")]);
    // i a1' = conj(a2) a3 ..., real parts x, imaginary y.
    show("three-wave", &[("x1","x3*y2-x2*y3"),("x2","x3*y1-x1*y3"),("x3","-x1*y2-x2*y1"),("y1","-x2*x3-y2*y3"),("y2","-x1*x3-y1*y3"),("y3","-x1*x2+y1*y2")]);
    show("toda", &[("a1","a1*(b2-b1)"),("a2","a2*(b3-b2)"),("b1","2*a1^2"),("b2","2*a2^2-2*a1^2"),("b3","-2*a2^2")]);
    show("may-leonard", &[("x","-x*(x-(y+z)/2)"),("y","-y*(y-(x+z)/2)"),("z","-z*(z-(x+y)/2)")]);
    show("may-leonard 2", &[("x","x*(1-x-y*1.5-z*0.5)"),("y","y*(1-y-1.5*z-0.5*x)"),("z","z*(1-z-1.5*x-0.5*y)")]);
    show("maxwell-bloch", &[("x","y"),("y","x*z"),("z","-x*y")]);
    show("rotor", &[("x","y*(z-0.3)/3-z*y/2"),("y","z*x-x*(z-0.3)/3"),("z","x*y/2-y*x")]);
    show("harmonic2", &[("x","u"),("y","v"),("u","-x"),("v","-y")]);
    show("lv2", &[("x","x*(1-y)"),("y","y*(x-1)")]);
    show("sir", &[("s","-s*i"),("i","s*i-i/2"),("r","i/2")]);
    show("planar", &[("x","y*(1+x^2)"),("y","-x*(1+x^2)")]);
    show("lorenz", &[("x","10*(y-x)"),("y","x*(28-z)-y"),("z","x*y-8*z/3")]);
    show("vdp", &[("x","y"),("y","(1-x^2)*y-x")]);
}
