//! Along arrays: the bits of one evaluation after the other, and nothing outside of the array.

use super::*;

/// So many of the slots that a program only reads are inputs, the others coefficients.
const INPUTS: usize = 8;

/// Where an input stands: in a row of the array that no output stands in, or in the row and place of an output; and how
/// far from the place.
type Seat = (bool, usize, isize);

fn seats() -> impl Strategy<Value = Vec<Seat>> {
    prop::collection::vec((any::<bool>(), 0_usize..12, -9_isize..10), INPUTS)
}

/// Results along an array are those at each of its places alone. Returns how many backends served the program.
fn check_along(code: &Code, numbers: &[f64], seats: &[Seat]) -> Result<usize, TestCaseError> {
    let (rows, margin, places) = (2, 9, 101);
    let row = places + 2 * margin;
    let start = |row_of: usize| (row_of * row + margin) as isize;
    let outputs: Vec<isize> = (0..code.outputs.len())
        .map(|output| start(rows + output))
        .collect();
    let inputs: Vec<isize> = seats
        .iter()
        .map(|&(is_replaced, choice, shift)| match is_replaced {
            true => outputs[choice % outputs.len()],
            false => start(choice % rows) + shift,
        })
        .collect();
    let first = |own: &[isize]| own.iter().copied().map(Distance::First).collect::<Vec<_>>();
    let Some(distances) = Distances::new(code, &first(&inputs), &first(&outputs)) else {
        return Ok(0);
    };
    let length = (rows + outputs.len()) * row;
    let array: Vec<f64> = numbers.iter().copied().cycle().take(length).collect();
    let at = |place: usize, distance: isize| place.strict_add_signed(distance);
    let bits = |x: f64| if x.is_nan() { f64::NAN } else { x }.to_bits();
    let mut expected: Vec<u64> = array.iter().copied().map(bits).collect();
    let mut slots = vec![f64::NAN; code.slots];
    for place in 0..places {
        slots[..FIXED as usize].copy_from_slice(&numbers[..FIXED as usize]);
        for (slot, &input) in slots.iter_mut().zip(&inputs) {
            *slot = array[at(place, input)];
        }
        run(code, &mut slots, 1);
        for (&slot, &output) in code.outputs.iter().zip(&outputs) {
            expected[at(place, output)] = bits(slots[slot as usize]);
        }
    }
    let mut served = 0;
    for lanes in [2, 4, 11, 32] {
        let mut slots = Aligned::filled(code.slots * lanes, f64::NAN);
        let coefficients = slots.chunks_exact_mut(lanes).zip(numbers);
        coefficients
            .take(FIXED as usize)
            .skip(INPUTS)
            .for_each(|(lanes, number)| lanes.fill(*number));
        for backend in backends(lanes) {
            let machine = MachineCode::compile_by(backend, code, lanes, Some(&distances));
            let Some(machine) = machine else {
                continue;
            };
            let mut room = machine.room();
            let mut found = array.clone();
            let mut reached = 0;
            // Two runs one after the other: nothing of the first may be left over.
            for end in [places / 2, places] {
                let passes = Passes::from(reached..end);
                reached += machine.run_along(&mut slots, &mut room, &mut found, &passes);
                prop_assert!((end - 31..=end).contains(&reached), "{:?}", backend);
            }
            let is_reached = |at: usize| {
                let before_outputs = at < rows * row;
                before_outputs || at % row < margin + reached || at % row >= margin + places
            };
            for at in (0..length).filter(|at| is_reached(*at)) {
                prop_assert_eq!(bits(found[at]), expected[at], "{:?}, at {}", backend, at);
            }
            for at in (0..length).filter(|at| !is_reached(*at)) {
                prop_assert_eq!(found[at].to_bits(), array[at].to_bits(), "{:?}", backend);
            }
            served += 1;
        }
    }
    Ok(served)
}

/// Machine code along arrays in so many cases, at least one of which is served where our own assembler is.
#[test]
fn programs_along_an_array_keep_the_bits_of_the_interpreter() {
    let config = || ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(60)
    };
    let served = [0, 0].map(Cell::new);
    let choice = (0_u8..52, any::<usize>(), any::<usize>(), any::<usize>());
    proptest!(config(), |(
        choices in prop::collection::vec(choice, 1..120),
        chosen in prop::collection::vec(any::<usize>(), 1..12),
        numbers in prop::collection::vec(number(), FIXED as usize * 37),
        seats in seats(),
    )| {
        let code = code(&choices, &chosen);
        let more = check_along(&code, &numbers, &seats)?;
        served[0].update(|all| all + more);
    });
    proptest!(config(), |(
        numbers in prop::collection::vec(argument(), FIXED as usize * 37),
        seats in seats(),
    )| {
        let more = check_along(&paired_code(), &numbers, &seats)?;
        served[1].update(|all| all + more);
    });
    #[cfg(all(target_arch = "x86_64", not(windows)))]
    if Width::best(2).is_some() {
        assert!(served.iter().all(|count| count.get() > 100), "{served:?}");
    }
}

/// p·x, x so far from a place of an array as 1 and the product as 70.
fn product_along() -> Kernel {
    let mut graph = Graph::new();
    let (x, parameter) = (graph.input(0), graph.parameter(0));
    let product = graph.multiply(&parameter, &x);
    Kernel::compile(&graph, &[product], 1, 1)
        .at_distances(&[Distance::First(1)], &[Distance::First(70)])
}

/// Places have no lanes of their own: along an array goes machine code whose coefficients are the same in all.
#[test]
fn coefficients_along_an_array_are_the_same_in_all_lanes() {
    let kernel = product_along();
    let ones = [1.0; 32];
    let along = |execution: Execution, parameters: [f64; 32]| {
        let mut workspace = kernel.workspace_for(32, execution);
        let mut array = [3.0; 140];
        let mut count = || kernel.evaluate_along(&mut workspace, &mut array, 0..64);
        let unprepared = count();
        kernel.prepare(&mut workspace, &parameters, &ones, &ones);
        let mut count = || kernel.evaluate_along(&mut workspace, &mut array, 0..64);
        (unprepared, count(), array)
    };
    let (_, count, array) = along(Execution::Compiled, [2.0; 32]);
    let is_product = |at: usize| (70..70 + count).contains(&at);
    assert!((0..140).all(|at| array[at] == if is_product(at) { 6.0 } else { 3.0 }));
    #[cfg(all(target_arch = "x86_64", not(windows)))]
    assert_eq!(count, if Width::best(2).is_some() { 64 } else { 0 });
    let mut apart = [2.0; 32];
    apart[31] = 4.0;
    assert_eq!(along(Execution::Compiled, apart).1, 0);
    let (unprepared, count, array) = along(Execution::Interpreted, [2.0; 32]);
    assert_eq!((unprepared, count, array), (0, 0, [3.0; 140]));
}

#[test]
#[should_panic(expected = "in the array")]
fn nothing_is_read_beyond_an_array() {
    let kernel = product_along();
    let mut workspace = kernel.workspace_for(32, Execution::Compiled);
    kernel.evaluate_along(&mut workspace, &mut [0.0; 133], 0..64);
}

#[test]
#[should_panic(expected = "in the array")]
fn no_output_stands_where_another_place_reads() {
    let kernel = product_along();
    let mut workspace = kernel.workspace_for(32, Execution::Compiled);
    kernel.evaluate_along(&mut workspace, &mut [0.0; 1000], 0..70);
}

/// The sums at sites i and j of a pair: sin(x_i − x_j) is added to the first and subtracted from the second. The distances are
/// those of x_i, of x_j and of both sums.
fn pair_along(distances: [isize; 4]) -> Kernel {
    let mut graph = Graph::compilable();
    let [x, y, at_x, at_y] = [0, 1, 2, 3].map(|at| graph.input(at));
    let apart = graph.subtract(&x, &y);
    let sine = graph.apply(Function::Sin, &apart).expect("a sine");
    let outputs = [graph.add(&at_x, &sine), graph.subtract(&at_y, &sine)];
    let [x, y, at_x, at_y] = distances;
    let sums = [Distance::First(at_x), Distance::Second(at_y)];
    let inputs = [[Distance::First(x), Distance::Second(y)], sums].concat();
    Kernel::compile(&graph, &outputs, 0, 4).at_distances(&inputs, &sums)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(128) })]

    /// Passes with a second place are one evaluation after the other: pass by pass, and place by place.
    #[test]
    fn passes_are_evaluations_one_after_the_other(
        places in 1_usize..12,
        ahead in 0_usize..9,
        stride in 0_usize..5,
        count in 0_usize..6,
        numbers in prop::collection::vec(prop_oneof![4 => -0.5..0.5, 1 => -1e3..1e3], 64),
    ) {
        let places = 8 * places;
        let rows = [0, 100, 300, 400_usize];
        let kernel = pair_along(rows.map(|row| row as isize));
        let mut workspace = kernel.workspace_for(8, Execution::Compiled);
        kernel.prepare(&mut workspace, &[], &[1.0; 8], &[1.0; 8]);
        let mut array: Vec<f64> = numbers.iter().cycle().take(600).copied().collect();
        let mut expected = array.clone();
        let passes = Passes { places: 0..places, ahead, stride, count, may_meet: false };
        let reached = kernel.evaluate_along(&mut workspace, &mut array, passes);
        #[cfg(all(target_arch = "x86_64", not(windows)))]
        prop_assert_eq!(reached, if Width::best(8).is_some() && count > 0 { places } else { 0 });
        for pass in (0..count).filter(|_| reached > 0) {
            for place in 0..places {
                let second = place + ahead + pass * stride;
                let [x, y, at_x, at_y] = rows;
                let sine = libm::sin(expected[x + place] - expected[y + second]);
                expected[at_x + place] += sine;
                expected[at_y + second] -= sine;
            }
        }
        let near = |(own, other): (&f64, &f64)| (own - other).abs() <= 1e-13 * (1.0 + other.abs());
        prop_assert!(array.iter().zip(&expected).all(near));
    }
}

/// Of every pass it is known whether what one place reads, or writes, is written beside the other.
#[test]
fn places_do_not_meet_in_any_pass() {
    // Sums at i from 300 on, and at j from 340 on less the distance to j.
    let kernel = pair_along([0, 100, 300, 340]);
    let mut workspace = kernel.workspace_for(8, Execution::Compiled);
    let mut run = |ahead: usize, stride: usize, count: usize| {
        let passes = Passes {
            places: 0..16,
            ahead,
            stride,
            count,
            may_meet: false,
        };
        let mut array = [0.0; 600];
        let run = || kernel.evaluate_along(&mut workspace, &mut array, passes);
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_ok()
    };
    assert!(run(0, 1, 100));
    // The coordinates of j are 16 behind the sums at i in the last pass, and then within them.
    assert!(run(0, 46, 5));
    assert!(!run(0, 47, 5));
    assert!(!run(200, 0, 1));
    assert!(run(216, 1, 2));
    assert!(!run(usize::MAX, 1, 2));
    assert!(!run(0, usize::MAX, 3));
    // Beyond the array.
    assert!(run(244, 0, 1));
    assert!(!run(245, 0, 1));
}

/// Of sublattices the numbers beside a place are written as they are: in place they may meet, with the values of one place after the
/// other.
#[test]
fn places_may_meet_where_what_others_read_is_left_as_it_is() {
    // x_i + m_i (x_{i−1} + x_{i+1}), with m_i = 1 at odd places and 0 at even ones.
    let mut graph = Graph::new();
    let [x, before, behind, mask] = [0, 1, 2, 3].map(|input| graph.input(input));
    let sum = graph.add(&before, &behind);
    let change = graph.multiply(&mask, &sum);
    let moved = graph.add(&x, &change);
    let kernel = Kernel::compile(&graph, &[moved], 0, 4);
    let inputs = [0, -1, 1, 100].map(Distance::First);
    let kernel = kernel.at_distances(&inputs, &[Distance::First(0)]);
    let mut workspace = kernel.workspace_for(8, Execution::Compiled);
    let mask = |at: usize| (at % 2) as f64;
    let numbers = (0..200).map(|at| {
        if at < 100 {
            1.0 + at as f64
        } else {
            mask(at - 100)
        }
    });
    let mut array: Vec<f64> = numbers.collect();
    let passes = |may_meet| Passes {
        may_meet,
        ..(1..65).into()
    };
    let apart = std::panic::AssertUnwindSafe(|| {
        kernel.evaluate_along(
            &mut kernel.workspace_for(8, Execution::Compiled),
            &mut [0.0; 200],
            passes(false),
        )
    });
    assert!(std::panic::catch_unwind(apart).is_err());
    let reached = kernel.evaluate_along(&mut workspace, &mut array, passes(true));
    assert_eq!(reached, 64);
    for (at, number) in array.iter().enumerate().take(65).skip(1) {
        // x_{i−1} + x_i + x_{i+1} = 3 (1 + i).
        let expected = if at % 2 == 1 { 3.0 } else { 1.0 } * (1.0 + at as f64);
        assert_eq!(*number, expected, "place {at}");
    }
}
