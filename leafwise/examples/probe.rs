//! Probe.
#![allow(clippy::print_stdout, missing_docs)]
use leafwise::core::*;
use leafwise::verify::Problem;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let registry = Registry::with_builtin();
    let problem = Problem::of_library(&a[1]).unwrap();
    let n: i64 = a[3].parse().unwrap();
    let m: i64 = a[4].parse().unwrap();
    let given = if n > 0 { PartParameters::new().with("order", n) } else { PartParameters::new() };
    let r = match registry.realization(&a[2]).unwrap().build(&problem.system, &given) { Ok(r)=>r, Err(e)=>{println!("{e}");return;} };
    let started = Instant::now();
    let d = registry.dynamics("hamilton-jacobi").unwrap().build(&PartParameters::new().with("order", m)).unwrap();
    let b = d.bisection(&problem.system, &r);
    let t1 = started.elapsed().as_secs_f64();
    match &b { Ok(b) => { if let Some(g)=b.generating_function() { println!("products {} terms of S: {:?}, dS {:?}", g.ring.spent(), g.coefficients.iter().map(|p| p.terms().len()).collect::<Vec<_>>(), g.gradients.iter().map(|g| g.iter().map(|p| p.terms().len()).sum::<usize>()).collect::<Vec<_>>()); } }, Err(e)=>{println!("{e}");return;} }
    let method = Method::compose(&problem.system, r, d);
    let t2 = started.elapsed().as_secs_f64();
    match method { Ok(m) => println!("{} {}: algebra {t1:.2} s, all {t2:.2} s, newton {:?} residual {:?}", a[1], m.describe(), m.newton().map(|k| k.operations().to_string()), m.newton().map(|k| k.residual_operations().to_string())), Err(e)=>println!("{e}") }
}
