//! scratch
use leafwise::core::*;
use leafwise::expression::syntax::*;
use std::time::Instant;
fn sys()->PoissonSystem{
    let names=["x1","x2","x3"];
    let scope=Scope::new().with_variables(&names).with_parameters(&["I1","I2","I3"]);
    let f=|s:&str| Formula::parse(s).unwrap().resolve(&scope,None).unwrap().unwrap();
    PoissonSystem::new(names.iter().map(|s|s.to_string()).collect(),
      [("I1",1.0),("I2",0.75),("I3",1.25)].iter().map(|(n,v)|system::Parameter{name:n.to_string(),value:*v}).collect(),
      [((0,1),f("-x3")),((1,2),f("-x1")),((0,2),f("x2"))],
      f("x1^2/(2*I1)+x2^2/(2*I2)+x3^2/(2*I3)"), vec![], Convention::HamiltonianFirst).unwrap()
}
#[test] fn go(){
    let r=Registry::with_builtin();
    for (n,m,e,h) in [(2,2,0.1,1.0),(6,2,0.1,2.0),(6,2,0.1,1.0),(10,4,0.1,1.0)] {
        let t=Instant::now();
        let s=sys();
        let real=r.realization("karasev-truncated").unwrap().build(&s,&PartParameters::new().with("order",n)).unwrap();
        let dy=r.dynamics("hamilton-jacobi").unwrap().build(&PartParameters::new().with("order",m)).unwrap();
        let me=Method::compose(&s,real,dy).unwrap();
        let mut i=Integrator::new(&me,&s.parameter_values(),e,h,&[1.0,3.0,3.0]);
        i.step().unwrap();
        println!("n={n} m={m} {:?} {:?}\n newton {} residual {} coef {}",i.state(),t.elapsed(),me.newton().operations(),me.newton().residual_operations(),me.newton().coefficient_operations());
        let g=me.bisection().generating_function().unwrap();
        println!("terms {:?}",g.coefficients.iter().map(|c|c.terms().len()).collect::<Vec<_>>());
        for k in 1..=1000000u64 { i.step().unwrap(); if [1000,3000,10000,30000,100000,300000,1000000].contains(&k) {let x=i.state(); let c=i.compensation(); println!("{k} {:e}", (x.iter().zip(c).map(|(v,c)|v*v+2.0*v*c).sum::<f64>()-19.0)/19.0);} }
    }
}
