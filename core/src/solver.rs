//! Step maps, and the [solver](leafwise_solver) behind their steps: one path for both.

pub(crate) use crate::step_map::MakeCheck;
pub use crate::step_map::{
    Arranged, CodeStepMap, FactorProduct, Factored, MapAbilities, Poles, ProductStepper,
    ShadowTerms, StepMap, Walls, WithoutPoles, keeping_signs, kept_signs,
};
pub use leafwise_solver::{
    Anderson, Branch, ByTangents, Compensated, CorrectionMethod, CorrectionSize, DenseFactors,
    Differential, ExplicitMap, Extrapolation, Inverse, Iteration, Lanes, LinearSolve,
    MANY_EQUATIONS, MOST_EQUATIONS, MOST_VARIABLES, MapProperties, NewtonKernel, NewtonStepper,
    Pieces, Setting, SolverStatistics, StepCheck, StepRecord, StepReport, Stepper, Structure,
    Trajectories, add_finite, are_finite, check_equations, check_variables, elimination_operations,
    judge, one_by_one, product, substitution_operations,
};
pub(crate) use leafwise_solver::{
    Checked, Crossing, NumericSolver, Progress, Solve, Solved, StartCode, Uncoupled, add,
    by_parameters, looks, one_step,
};
