//! Kernels as Rust source: what somebody with a computer algebra system would paste into a program.

use std::fmt::Write as _;
use std::path::Path;

use leafwise::core::solver::NewtonKernel;
use leafwise::expression::kernel::{Code, Instruction};
use leafwise::expression::pairs::{EXPONENTIAL_MINUS_1, EXPONENTIAL_MINUS_1_MIRRORED};
use leafwise::expression::{Function, Kernel, Side};
use leafwise_benches::STEP_CASES;

/// Writes the formulas of every case into a folder: what `-- formulas` does, after a change of what
/// kernels hold.
///
/// # Panics
/// Where the folder cannot be written.
pub fn write_all(folder: &Path) {
    std::fs::create_dir_all(folder).expect("a folder for the formulas");
    for case in &STEP_CASES {
        let run = case.composed();
        let method = run.method.written().expect("a written method");
        let newton = method.newton().expect("one kernel");
        let text = formulas(case.formulas, newton);
        let path = folder.join(format!("{}.rs", case.formulas));
        std::fs::write(&path, &text).expect("the folder of the formulas");
    }
}

/// The formulas of a method as an implementation of `Formulas`, for a type of the given name.
///
/// # Panics
/// Where the method calls a function that has no name here.
fn formulas(name: &str, newton: &NewtonKernel) -> String {
    let (full, residual) = (newton.kernel(), newton.residual_kernel());
    let d = full.inputs();
    let most_chords = newton.most_chords();
    let kernels: Vec<(&str, &Kernel)> = [("full", full), ("residual", residual)]
        .into_iter()
        .chain(newton.start().map(|start| ("start", start)))
        .collect();
    let fields = kernels
        .iter()
        .map(|(what, kernel)| format!("{what}: [f64; {}]", kernel.coefficients()));
    let fields = fields.collect::<Vec<_>>().join(", ");
    let mut text = format!(
        "// Written by `cargo bench -p leafwise-benches --bench performance -- formulas`.\n\
         pub struct {name} {{ {fields} }}\n\
         impl {name} {{\npub fn new(parameters: &[f64; {}], epsilon: f64, h: f64) -> Self {{\n",
        full.parameters(),
    );
    for (what, kernel) in &kernels {
        let code = kernel.coefficient_code();
        let parameters = kernel.parameters();
        let inputs: Vec<String> = (0..parameters)
            .map(|i| format!("parameters[{i}]"))
            .chain(["epsilon".to_owned(), "h".to_owned()])
            .collect();
        let _ = writeln!(text, "let {what} = {{\n{}[", body(code, &inputs));
        for slot in &code.outputs {
            let _ = write!(text, "s{slot}, ");
        }
        text.push_str("]\n};\n");
    }
    let names: Vec<&str> = kernels.iter().map(|(what, _)| *what).collect();
    let start = match newton.start() {
        None => String::new(),
        Some(start) => format!(
            "const HAS_SERIES: bool = true;\n#[inline(always)]\n\
             fn odd(&self, y: &[f64; {d}]) -> [f64; {d}] {{\nlet c = &self.start;\n{}{}\n}}\n",
            step_body(start),
            outputs(start, 0, d),
        ),
    };
    let bases = if newton.base_is_point() { 0 } else { d };
    let jacobians = bases + 2 * d;
    let _ = write!(
        text,
        "Self {{ {} }}\n}}\n}}\nimpl Formulas<{d}> for {name} {{\n\
         const MOST_CHORDS: u32 = {most_chords};\n{start}#[inline(always)]\n\
         fn residual(&self, y: &[f64; {d}]) -> Residual<{d}> {{\nlet c = &self.residual;\n{}{}\n}}\n\
         #[inline(always)]\nfn full(&self, y: &[f64; {d}]) -> Full<{d}> {{\nlet c = &self.full;\n\
         {}Full {{ residual: {}, target: {}, change: {} }}\n}}\n}}\n",
        names.join(", "),
        step_body(residual),
        residual_of(residual, (d, bases), jacobians),
        step_body(full),
        residual_of(full, (d, bases), jacobians + 2 * d * d),
        matrix(full, jacobians, d),
        matrix(full, jacobians + d * d, d),
    );
    text
}

fn step_body(kernel: &Kernel) -> String {
    let inputs: Vec<String> = (0..kernel.inputs())
        .map(|i| format!("y[{i}]"))
        .chain((0..kernel.coefficients()).map(|i| format!("c[{i}]")))
        .collect();
    body(kernel.step_code(), &inputs)
}

fn outputs(kernel: &Kernel, from: usize, count: usize) -> String {
    let slots = &kernel.step_code().outputs[from..from + count];
    let names: Vec<String> = slots.iter().map(|slot| format!("s{slot}")).collect();
    format!("[{}]", names.join(", "))
}

/// The guard stands behind everything else, where there is one.
fn residual_of(kernel: &Kernel, (d, bases): (usize, usize), guard: usize) -> String {
    let half = (kernel.outputs() - guard) / 2;
    let [first, last] = [guard, guard + half].map(|from| outputs(kernel, from, half));
    let base = match bases {
        0 => "*y".to_owned(),
        _ => outputs(kernel, 0, d),
    };
    format!(
        "Residual {{ base: {base}, offset: {}, increment: {}, guard: [largest(&{first}), largest(&{last})] }}",
        outputs(kernel, bases, d),
        outputs(kernel, bases + d, d)
    )
}

fn matrix(kernel: &Kernel, from: usize, d: usize) -> String {
    let rows: Vec<String> = (0..d)
        .map(|row| outputs(kernel, from + row * d, d))
        .collect();
    format!("[{}]", rows.join(", "))
}

/// One `let` an instruction; a slot that is used again is shadowed. Several on a line.
fn body(code: &Code, inputs: &[String]) -> String {
    let mut lets: Vec<String> = inputs
        .iter()
        .enumerate()
        .map(|(slot, input)| format!("let s{slot} = {input};"))
        .collect();
    lets.extend(
        code.constants
            .iter()
            .map(|(slot, value)| format!("let s{slot} = {value:?}_f64;")),
    );
    let mut rest = code.instructions.as_slice();
    while let Some((instruction, after)) = rest.split_first() {
        match after
            .split_first()
            .and_then(|(next, after)| Some((both(instruction, next)?, after)))
        {
            Some((text, after)) => {
                lets.push(text);
                rest = after;
            }
            None => {
                lets.push(statement(instruction));
                rest = after;
            }
        }
    }
    let lines: Vec<String> = lets.chunks(6).map(|line| line.join(" ")).collect();
    lines.join("\n") + "\n"
}

/// eᶻ − 1 and e⁻ᶻ − 1 of one argument.
fn both(instruction: &Instruction, next: &Instruction) -> Option<String> {
    let of = |instruction: &Instruction, wanted| match *instruction {
        Instruction::ApplyAnalytic {
            function,
            order: 0,
            out,
            a,
        } => (function == wanted).then_some((out, a)),
        _ => None,
    };
    let (up, a) = of(instruction, EXPONENTIAL_MINUS_1)?;
    let (down, same) = of(next, EXPONENTIAL_MINUS_1_MIRRORED)?;
    (a == same).then(|| format!("let (s{up}, s{down}) = exp_m1_mirrored(s{a});"))
}

fn statement(instruction: &Instruction) -> String {
    match *instruction {
        Instruction::Add { out, a, b } => format!("let s{out} = s{a} + s{b};"),
        Instruction::Subtract { out, a, b } => format!("let s{out} = s{a} - s{b};"),
        Instruction::Multiply { out, a, b } => format!("let s{out} = s{a} * s{b};"),
        Instruction::Divide { out, a, b } => format!("let s{out} = s{a} / s{b};"),
        Instruction::Negate { out, a } => format!("let s{out} = -s{a};"),
        Instruction::Magnitude { out, a } => format!("let s{out} = s{a}.abs();"),
        Instruction::Larger { out, a, b } => {
            format!("let s{out} = if s{a} > s{b} {{ s{a} }} else {{ s{b} }};")
        }
        Instruction::Smaller { out, a, b } => {
            format!("let s{out} = if s{a} < s{b} {{ s{a} }} else {{ s{b} }};")
        }
        Instruction::Keep { side, out, a, b } => {
            let relation = if side == Side::Above { ">" } else { "<=" };
            format!("let s{out} = if s{a} {relation} 0.0 {{ s{b} }} else {{ 0.0 }};")
        }
        Instruction::ApplyTwo { function, .. } => panic!("{function:?} has no name here"),
        Instruction::Power { out, a, b } => format!("let s{out} = libm::pow(s{a}, s{b});"),
        Instruction::Apply { function, out, a } => {
            let name = match function {
                Function::Exp => "exp",
                Function::Ln => "log",
                Function::Sqrt => "sqrt",
                Function::Sin => "sin",
                Function::Cos => "cos",
                Function::Sinh => "sinh",
                Function::Cosh => "cosh",
                other => panic!("{other} has no name here"),
            };
            format!("let s{out} = libm::{name}(s{a});")
        }
        Instruction::ApplyAnalytic { function, .. } => panic!("{function:?} has no name here"),
    }
}
