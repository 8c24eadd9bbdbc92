//! Every backend computes the bits of the interpreter, and gives its memory back.

mod along;

use std::cell::Cell;

use proptest::prelude::*;

#[cfg(all(target_arch = "x86_64", not(windows)))]
use super::avx::Width;
use super::machine::{Backend, FAR, MachineCode, REFUSES};
use crate::analytic::AnalyticFunction;
use crate::arithmetic::Arithmetic;
use crate::expression::{Binary, Function, Side};
use crate::graph::{Graph, StepSize};
use crate::kernel::aligned::Aligned;
use crate::kernel::code::{Code, Instruction};
use crate::kernel::distances::{Distance, Distances, Passes};
use crate::kernel::interpreter::run;
use crate::kernel::{Execution, Kernel};
use crate::pairs::{EXPONENTIAL_MINUS_1, EXPONENTIAL_MINUS_1_MIRRORED, SINE, VERSINE};

/// Slots that a program only reads.
const FIXED: u32 = 12;

const SQUARE: AnalyticFunction = AnalyticFunction::new("square", |order, s| match order {
    0 => s * s,
    1 => 2.0 * s,
    2 => 2.0,
    _ => 0.0,
});

/// Both members of two pairs.
const PAIRED: [AnalyticFunction; 4] = [
    EXPONENTIAL_MINUS_1,
    EXPONENTIAL_MINUS_1_MIRRORED,
    SINE,
    VERSINE,
];

/// What an instruction does, and the instructions that its operands and result replace.
type Choice = (u8, usize, usize, usize);

/// A program whose results stand in slots of their own, taken again where `reuse` says so.
fn code(choices: &[Choice], outputs: &[usize]) -> Code {
    let mut written: Vec<u32> = Vec::new();
    let mut code = Code {
        slots: FIXED as usize,
        ..Code::default()
    };
    for &(kind, first, second, reuse) in choices {
        let operand = |choice: usize| {
            let at = choice % (FIXED as usize + written.len());
            let fixed = at.checked_sub(written.len());
            fixed.map_or_else(|| written[at], |slot| slot as u32)
        };
        let (a, b) = (operand(first), operand(second));
        let out = if reuse % 4 == 0 && !written.is_empty() {
            written[reuse / 4 % written.len()]
        } else {
            code.slots += 1;
            code.slots as u32 - 1
        };
        if !written.contains(&out) {
            written.push(out);
        }
        code.instructions.push(match kind {
            0..=7 => Instruction::Add { out, a, b },
            8..=15 => Instruction::Subtract { out, a, b },
            16..=23 => Instruction::Multiply { out, a, b },
            24..=27 => Instruction::Divide { out, a, b },
            28..=29 => Instruction::Negate { out, a },
            40..=41 => Instruction::Magnitude { out, a },
            42..=43 => Instruction::Larger { out, a, b },
            44..=45 => Instruction::Smaller { out, a, b },
            46..=49 => Instruction::Keep {
                side: if kind < 48 { Side::Above } else { Side::Below },
                out,
                a,
                b,
            },
            50..=51 => Instruction::ApplyTwo {
                function: Binary::ALL[first % Binary::ALL.len()].1,
                out,
                a,
                b,
            },
            30 => Instruction::Power { out, a, b },
            31 => Instruction::ApplyAnalytic {
                function: SQUARE,
                order: first as u32 % 4,
                out,
                a,
            },
            36..=39 => Instruction::ApplyAnalytic {
                function: PAIRED[second % PAIRED.len()],
                order: u32::from(reuse % 8 == 7),
                out,
                a,
            },
            _ => match Function::ALL[second % Function::ALL.len()] {
                Function::Special(special, _) => Instruction::ApplyAnalytic {
                    function: special.analytic(),
                    order: first as u32 % 3,
                    out,
                    a,
                },
                function => Instruction::Apply { function, out, a },
            },
        });
    }
    code.outputs = outputs
        .iter()
        .map(|choice| written[choice % written.len()])
        .collect();
    code.outputs.push(0);
    code
}

fn backends(lanes: usize) -> Vec<Backend> {
    let mut backends = Vec::new();
    #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
    backends.push(Backend::Portable);
    #[cfg(all(target_arch = "x86_64", not(windows)))]
    {
        let widths = [Width::One, Width::Two, Width::Four, Width::Eight];
        let several = [Width::Sixteen, Width::ThirtyTwo];
        let best = Width::best(lanes);
        let most = best.map_or(0, Width::lanes);
        let widest = best.map_or(0, |width| width.with_calls(lanes).lanes());
        let several = several.into_iter().filter(|width| width.lanes() <= widest);
        let usable = widths.into_iter().filter(|width| width.lanes() <= most);
        let usable = usable.chain(several);
        // One number at a time serves one lane alone.
        let usable = usable.filter(|width| (width.lanes() == 1) == (lanes == 1));
        backends.extend(usable.map(Backend::Avx));
    }
    backends
}

fn number() -> impl Strategy<Value = f64> {
    let special = [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY]
        .into_iter()
        .chain([f64::MIN_POSITIVE / 4.0, f64::from_bits(1), f64::MAX, -1.0]);
    prop_oneof![
        6 => -3.0..3.0,
        1 => any::<f64>(),
        1 => proptest::sample::select(special.collect::<Vec<f64>>()),
    ]
}

/// The place of one of the two among all functions.
fn sine_or_cosine() -> impl Strategy<Value = usize> {
    let places = Function::ALL.iter().enumerate();
    let wanted = places.filter(|(_, f)| matches!(f, Function::Sin | Function::Cos));
    proptest::sample::select(wanted.map(|(at, _)| at).collect::<Vec<usize>>())
}

/// The outputs' bits; the payload of a NaN is not part of a result.
fn outputs(code: &Code, slots: &[f64], lanes: usize) -> Vec<u64> {
    let of_slot = |slot: &u32| slots[*slot as usize * lanes..][..lanes].to_vec();
    let canonical = |x: f64| if x.is_nan() { f64::NAN } else { x };
    let values = code.outputs.iter().flat_map(of_slot);
    values.map(|x| canonical(x).to_bits()).collect()
}

fn check(code: &Code, numbers: &[f64]) -> Result<(), TestCaseError> {
    for lanes in [1, 2, 3, 4, 5, 8, 11, 16, 21, 37] {
        let mut start = Aligned::filled(code.slots * lanes, f64::NAN);
        let fixed = FIXED as usize * lanes;
        start[..fixed].copy_from_slice(&numbers[..fixed]);
        let mut slots = start.clone();
        run(code, &mut slots, lanes);
        let expected = outputs(code, &slots, lanes);
        for backend in backends(lanes) {
            let machine = MachineCode::compile_by(backend, code, lanes, None);
            let machine = machine.expect("this machine has a compiler");
            let mut room = machine.room();
            let mut slots = start.clone();
            // Twice: nothing of the first run may be left over.
            for _ in 0..2 {
                machine.run(&mut slots, &mut room);
                let found = outputs(code, &slots, lanes);
                prop_assert_eq!(found, expected.clone(), "{:?}, {} lanes", backend, lanes);
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn every_backend_computes_the_bits_of_the_interpreter(
        choices in prop::collection::vec((0_u8..52, any::<usize>(), any::<usize>(), any::<usize>()), 1..200),
        chosen in prop::collection::vec(any::<usize>(), 1..12),
        numbers in prop::collection::vec(number(), FIXED as usize * 37),
    ) {
        check(&code(&choices, &chosen), &numbers)?;
    }

    /// Sines and cosines of few arguments, which are computed two at once.
    #[test]
    fn sines_and_cosines_of_one_argument_keep_their_bits(
        choices in prop::collection::vec(
            (prop_oneof![0_u8..24, 33_u8..36], 0_usize..4, sine_or_cosine(), any::<usize>()), 1..60
        ),
        chosen in prop::collection::vec(any::<usize>(), 1..12),
        numbers in prop::collection::vec(number(), FIXED as usize * 37),
    ) {
        check(&code(&choices, &chosen), &numbers)?;
    }

    /// Functions that crates evaluate in pairs, of few arguments: the two are often computed at once.
    #[test]
    fn pairs_of_analytic_functions_keep_their_bits(
        choices in prop::collection::vec(
            (prop_oneof![0_u8..24, 36_u8..40], 0_usize..4, any::<usize>(), any::<usize>()), 1..60
        ),
        chosen in prop::collection::vec(any::<usize>(), 1..12),
        numbers in prop::collection::vec(number(), FIXED as usize * 37),
    ) {
        check(&code(&choices, &chosen), &numbers)?;
    }

    /// More results alive than any machine has registers, and no calls, which would empty them.
    #[test]
    fn results_without_a_register_keep_their_bits(
        choices in prop::collection::vec((prop_oneof![9 => 0_u8..30, 1 => 46_u8..50], any::<usize>(), any::<usize>(), Just(1)), 300..500),
        chosen in prop::collection::vec(any::<usize>(), 60..90),
        numbers in prop::collection::vec(number(), FIXED as usize * 37),
    ) {
        check(&code(&choices, &chosen), &numbers)?;
    }
}

/// Both members of two pairs of the inputs 0 and 1, and of what the first gives.
fn paired_code() -> Code {
    let apply = |function: AnalyticFunction, out: u32, a: u32| Instruction::ApplyAnalytic {
        function,
        order: 0,
        out,
        a,
    };
    let [up, down, sine, versine] = PAIRED;
    let instructions = vec![
        apply(up, FIXED, 0),
        apply(sine, FIXED + 1, 1),
        apply(down, FIXED + 2, 0),
        apply(versine, FIXED + 3, 1),
        apply(up, FIXED + 4, 0),
        apply(versine, FIXED + 5, FIXED + 2),
    ];
    Code {
        instructions,
        constants: Vec::new(),
        outputs: (FIXED..FIXED + 6).collect(),
        slots: FIXED as usize + 6,
    }
}

/// An argument near 0, at most a quarter, or one of those on either side of where formulas near 0 end.
fn argument() -> impl Strategy<Value = f64> {
    let bounds = [0.55_f64, 0.785].into_iter();
    let ends = bounds.flat_map(|b| [b.next_down(), b, b.next_up(), -b, -b.next_down()]);
    let special = ends.chain([0.0, -0.0, f64::NAN, f64::INFINITY, 3.0, -40.0]);
    prop_oneof![
        12 => -0.25..0.25,
        1 => proptest::sample::select(special.collect::<Vec<f64>>()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Formulas near 0 serve where all arguments are, calls where one is not, to the same bits.
    #[test]
    fn formulas_near_zero_keep_the_bits_of_calls(
        numbers in prop::collection::vec(argument(), FIXED as usize * 37),
    ) {
        check(&paired_code(), &numbers)?;
    }
}

/// One lane that is far from 0 sends all to the calls, and formulas are tried again later.
#[test]
fn formulas_serve_arguments_near_zero_and_come_back() {
    let code = paired_code();
    for lanes in [1, 3, 8, 16, 37] {
        for backend in backends(lanes).into_iter().filter(|own| own.fuses()) {
            let machine = MachineCode::compile_by(backend, &code, lanes, None).expect("a compiler");
            let mut room = machine.room();
            let mut slots = Aligned::filled(code.slots * lanes, 0.2);
            machine.run(&mut slots, &mut room);
            assert!(room.takes_formulas(), "{backend:?}, {lanes} lanes");
            slots[lanes - 1] = -0.55;
            machine.run(&mut slots, &mut room);
            assert!(!room.takes_formulas(), "{backend:?}, {lanes} lanes");
            slots[lanes - 1] = 0.0;
            (0..FAR).for_each(|_| machine.run(&mut slots, &mut room));
            assert!(room.takes_formulas(), "{backend:?}, {lanes} lanes");
            machine.run(&mut slots, &mut room);
            assert!(room.takes_formulas(), "{backend:?}, {lanes} lanes");
        }
    }
}

/// sin x · cos x and x³ as a kernel of two outputs.
fn small_kernel() -> Kernel {
    let mut graph = Graph::new();
    let x = graph.input(0);
    let sine = graph.apply(Function::Sin, &x).expect("code");
    let cosine = graph.apply(Function::Cos, &x).expect("code");
    let product = graph.multiply(&sine, &cosine);
    let cube = graph.integer_power(&x, 3).expect("code");
    Kernel::compile(&graph, &[product, cube], 0, 1)
}

/// The outputs of so many evaluations over `lanes` lanes, and whether machine code computed the last.
fn evaluations(kernel: &Kernel, execution: Execution, lanes: usize) -> (Vec<u64>, bool) {
    let mut workspace = kernel.workspace_for(lanes, execution);
    kernel.prepare(&mut workspace, &[], &vec![1.0; lanes], &vec![1.0; lanes]);
    let mut bits = Vec::new();
    let mut values = vec![0.0; 2 * lanes];
    for round in 0..600 {
        let inputs: Vec<f64> = (0..lanes)
            .map(|w| f64::from(round) / 64.0 + w as f64)
            .collect();
        kernel.evaluate(&mut workspace, &inputs, &mut values);
        bits.extend(values.iter().map(|v| v.to_bits()));
    }
    (bits, workspace.is_compiled())
}

/// Where memory cannot be made executable the interpreter goes on, to the same bits, and nothing says that there is machine
/// code.
#[test]
fn a_compilation_that_fails_leaves_the_interpreter() {
    for lanes in [1, 8, 11] {
        let compiled = small_kernel();
        let (expected, is_compiled) = evaluations(&compiled, Execution::Compiled, lanes);
        assert!(is_compiled && !compiled.machine_code().is_empty());
        for execution in [Execution::Compiled, Execution::Adaptive] {
            let kernel = small_kernel();
            REFUSES.set(true);
            let (found, is_compiled) = evaluations(&kernel, execution, lanes);
            REFUSES.set(false);
            assert!(!is_compiled && kernel.machine_code().is_empty());
            assert!(found == expected, "{execution:?}, {lanes} lanes");
            // It is not tried again.
            assert!(!evaluations(&kernel, execution, lanes).1);
        }
    }
}

/// Coefficients have the interpreter's bits, as machine code from the first on or once that pays.
#[test]
fn coefficients_keep_their_bits_as_machine_code() {
    let mut graph = Graph::new();
    let (x, parameter) = (graph.input(0), graph.parameter(0));
    let h = graph.step_size(StepSize::H);
    let sine = graph.apply(Function::Sin, &parameter).expect("code");
    let root = graph.apply(Function::Exp, &h).expect("code");
    let product = graph.multiply(&sine, &root);
    let output = graph.multiply(&product, &x);
    for lanes in [1, 2, 8, 11] {
        let bits = |execution: Execution| -> (Vec<u64>, bool) {
            let kernel = Kernel::compile(&graph, std::slice::from_ref(&output), 1, 1);
            let most = MachineCode::evaluations_to_pay(lanes);
            let mut bits = Vec::new();
            for round in 0..=most {
                // A stepper of its own each, as those of a sweep.
                let mut workspace = kernel.workspace_for(lanes, execution);
                let parameters: Vec<f64> =
                    (0..lanes).map(|w| round as f64 / 64.0 + w as f64).collect();
                let ones = vec![1.0; lanes];
                kernel.prepare(&mut workspace, &parameters, &ones, &ones);
                let mut values = vec![0.0; lanes];
                kernel.evaluate(&mut workspace, &ones, &mut values);
                bits.extend(values.iter().map(|v| v.to_bits()));
            }
            (bits, kernel.has_compiled_coefficients(lanes))
        };
        let (expected, is_compiled) = bits(Execution::Interpreted);
        assert!(!is_compiled);
        for execution in [Execution::Compiled, Execution::Adaptive] {
            let (found, is_compiled) = bits(execution);
            assert!(is_compiled, "{execution:?}, {lanes} lanes");
            assert!(found == expected, "{execution:?}, {lanes} lanes");
        }
    }
}

/// Bytes of this process that can be executed.
#[cfg(target_os = "linux")]
fn executable_bytes() -> u64 {
    let maps = std::fs::read_to_string("/proc/self/maps").expect("this process");
    let size = |line: &str| {
        let (range, rest) = line.split_once(' ')?;
        let (start, end) = range.split_once('-')?;
        let address = |text| u64::from_str_radix(text, 16).ok();
        rest.starts_with("r-x")
            .then(|| Some(address(end)? - address(start)?))?
    };
    maps.lines().filter_map(size).sum()
}

#[test]
#[cfg(target_os = "linux")]
fn dropped_code_gives_its_memory_back() {
    let choices: Vec<Choice> = (0..50).map(|at| (at as u8 % 30, at, 7 * at, 1)).collect();
    let code = code(&choices, &[3, 49]);
    let before = executable_bytes();
    let rounds = 2_000;
    for _ in 0..rounds {
        drop(MachineCode::compile(&code, 8, None).expect("a compiler"));
    }
    // Other tests of this process hold a few pages of their own.
    let held = executable_bytes().saturating_sub(before);
    assert!(held < rounds / 2 * 4096, "{held} bytes");
}
