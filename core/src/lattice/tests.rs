//! Sweeps in place have the bits of sweeps by the interpreter, which takes copies.

use std::cell::Cell;
use std::collections::BTreeSet;

use leafwise_expression::{Arithmetic, Execution, Function, Term};
use proptest::prelude::*;

use super::wavefront::PART;
use super::{
    Axis, Cells, Field, LatticeGeometry, LatticeProgram, PartSites, Proxy, StageBuilder, SweptPart,
    wavefront,
};

/// How far code looks at most.
const REACH: usize = 3;

/// Of a lattice: its length in cells beside so many blocks of 32, whether it is a ring, what each family lacks, and the
/// sites of a cell.
type Drawn = (usize, isize, bool, Vec<usize>, usize);

fn drawn() -> impl Strategy<Value = Drawn> {
    let lacking = prop::collection::vec(0_usize..3, 0..3);
    (0_usize..4, -5_isize..6, any::<bool>(), lacking, 1_usize..4)
}

/// The lattice of cells, `None` where there is none.
fn rows((blocks, more, periodic, lacking, period): &Drawn) -> Option<LatticeGeometry> {
    let cells = (32 * blocks).checked_add_signed(*more)?;
    let length = cells * period;
    let lengths = lacking
        .iter()
        .map(|lacks| length.checked_sub(if *periodic { 0 } else { *lacks }));
    let lengths: Option<Vec<usize>> = std::iter::once(Some(length)).chain(lengths).collect();
    let families = ["x", "y", "z"].map(str::to_owned).into_iter().zip(lengths?);
    let sites = LatticeGeometry::chain(families.collect(), *periodic);
    Some(Cells::new(sites, *period)?.rows().clone())
}

/// What is done with a number so far and another one, which stands in a field, a family and so far away along each axis.
type Operation = (u8, usize, usize, [isize; 3]);

/// Values of one stage, and the field that takes them: a new one, or the state in some families.
type Drafted = (Vec<Operation>, Option<usize>);

fn stages() -> impl Strategy<Value = Vec<Drafted>> {
    let reach = REACH as isize;
    let shift = [(); 3].map(|()| prop_oneof![1 => Just(0), 1 => -reach..=reach]);
    let operation = (0_u8..9, any::<usize>(), any::<usize>(), shift);
    let operations = prop::collection::vec(operation, 1..8);
    prop::collection::vec((operations, prop::option::of(any::<usize>())), 1..4)
}

/// Stages over a proxy, and the state.
fn write(proxy: &LatticeGeometry, stages: &[Drafted]) -> (StageBuilder, Field) {
    let mut builder = StageBuilder::new(proxy.dimension());
    let (state, x) = builder.unwritten();
    let mut fields = vec![x];
    let offsets = proxy.offsets();
    for (operations, updated) in stages {
        let mut values = Vec::with_capacity(proxy.dimension());
        for coordinate in 0..proxy.dimension() {
            let (family, site) = proxy.locate(coordinate);
            let read = |field: usize, other: usize, shift: [isize; 3]| -> Option<Term> {
                let other = (family + other) % proxy.families.len();
                let length = proxy.families[other].1;
                let at = proxy.beside(site, shift)?;
                let field = &fields[field % fields.len()];
                (at < length).then(|| field[offsets[other] + at].clone())
            };
            let graph = &mut builder.graph;
            let mut value = graph.parameter(0);
            for &(kind, field, other, shift) in operations {
                let Some(operand) = read(field, other, shift) else {
                    continue;
                };
                value = match kind {
                    0..=2 => graph.add(&value, &operand),
                    3 | 4 => graph.multiply(&value, &operand),
                    5 | 6 => graph.subtract(&operand, &value),
                    7 => {
                        let sine = graph.apply(Function::Sin, &operand).expect("code");
                        graph.multiply(&sine, &value)
                    }
                    // An output that is an input.
                    _ => operand,
                };
            }
            let is_kept = updated.is_some_and(|chosen| (family + chosen) % 3 == 0);
            values.push((!is_kept).then_some(value));
        }
        match updated {
            Some(_) => builder.update(state, values),
            None => {
                let values = values.into_iter().flatten().collect();
                fields.push(builder.store(values));
            }
        }
        builder.finish_stage();
    }
    (builder, state)
}

/// All fields' bits after so many rounds, NaN being one number, and at how many sites stages went in place.
fn evolve(
    program: &LatticeProgram,
    state: Field,
    execution: Execution,
    rounds: usize,
) -> (Vec<u64>, usize) {
    let stages = 0..program.stages();
    let prepare = |stage| program.prepare_for(execution, stage, &[0.75], [1.0; 2]);
    let mut prepared: Vec<_> = stages.map(prepare).collect();
    let mut fields = program.empty_fields();
    for (at, value) in fields.get_mut(state).iter_mut().enumerate() {
        *value = ((at * 7919 + 31) % 1009) as f64 / 1009.0 - 0.5;
    }
    let mut in_place = 0;
    for _ in 0..rounds {
        for (stage, prepared) in prepared.iter_mut().enumerate() {
            in_place += program.sweep(stage, prepared, &mut fields);
        }
    }
    let bits = |x: &f64| if x.is_nan() { f64::NAN } else { *x }.to_bits();
    let fields = (0..program.fields()).map(|field| fields.get(Field(field)));
    (fields.flatten().map(bits).collect(), in_place)
}

#[test]
fn sweeps_in_place_keep_the_bits_of_copies() {
    let chains = drawn().prop_map(|drawn| rows(&drawn));
    keep_their_bits(chains);
}

/// Planes and boxes with axes that close or end, some shorter than a proxy.
#[test]
fn sweeps_along_several_axes_keep_the_bits_of_copies() {
    let axis = (1_usize..24, any::<bool>());
    let axis = axis.prop_map(|(length, periodic)| Axis { length, periodic });
    let axes = prop_oneof![
        2 => prop::collection::vec(axis.clone(), 2),
        1 => prop::collection::vec(axis, 3),
    ];
    let planes = axes.prop_map(|axes| {
        let names = ["x", "y"].map(str::to_owned);
        Some(LatticeGeometry::along(names, axes))
    });
    keep_their_bits(planes);
}

/// Draws lattices and stages; half of the cases go in place.
fn keep_their_bits(lattices: impl Strategy<Value = Option<LatticeGeometry>>) {
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(200)
    };
    let in_place = Cell::new(0);
    proptest!(config, |(drawn in lattices, stages in stages(), rounds in prop_oneof![4 => 1_usize..3, 1 => Just(150)])| {
        let Some(geometry) = drawn else {
            return Ok(());
        };
        let proxy = geometry.proxy([REACH; 3]);
        let (proxy, width) = proxy.unwrap_or_else(|| (geometry.clone(), [0; 3]));
        let (builder, state) = write(&proxy, &stages);
        let proxy = Proxy { geometry: &proxy, width };
        let program = LatticeProgram::compile(&geometry, proxy, &builder, 1);
        let program = program.expect("code that looks as far as the proxy has room for");
        let (expected, none) = evolve(&program, state, Execution::Interpreted, rounds);
        prop_assert_eq!(none, 0);
        for execution in [Execution::Compiled, Execution::Adaptive] {
            let (found, sites) = evolve(&program, state, execution, rounds);
            prop_assert!(found == expected, "{execution:?} on {geometry:?}");
            in_place.update(|cases| cases + usize::from(sites > 0));
        }
    });
    if cfg!(all(feature = "jit", target_arch = "x86_64", not(windows))) {
        assert!(in_place.get() > 100, "{} cases in place", in_place.get());
    }
}

/// All fields' bits after two rounds of all stages, part by part in the order of a wave; `None` where a stage has no parts.
fn evolve_in_a_wave(program: &LatticeProgram, state: Field) -> Option<Vec<u64>> {
    let stages: Vec<usize> = (0..program.stages()).chain(0..program.stages()).collect();
    let parts: Option<Vec<_>> = stages.iter().map(|stage| program.parts(*stage)).collect();
    let order = wavefront(&parts?);
    let all = 0..program.stages();
    let execution = Execution::Compiled;
    let prepare = |stage| program.prepare_for(execution, stage, &[0.75], [1.0; 2]);
    let mut prepared: Vec<_> = all.map(prepare).collect();
    let mut fields = program.empty_fields();
    for (at, value) in fields.get_mut(state).iter_mut().enumerate() {
        *value = ((at * 7919 + 31) % 1009) as f64 / 1009.0 - 0.5;
    }
    for SweptPart { sweep, part } in order {
        let stage = stages[sweep];
        program.run_part((stage, part), &mut prepared[stage], &mut fields);
    }
    let bits = |x: &f64| if x.is_nan() { f64::NAN } else { *x }.to_bits();
    let fields = (0..program.fields()).map(|field| fields.get(Field(field)));
    Some(fields.flatten().map(bits).collect())
}

/// Rings, tori and boxes of several parts.
#[test]
fn waves_of_sweeps_keep_the_bits_of_sweeps_one_after_the_other() {
    let lengths = prop_oneof![
        Just(vec![20_000]),
        Just(vec![130, 71]),
        Just(vec![24, 23, 40]),
        Just(vec![9, 41, 60]),
    ];
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(150)
    };
    let in_waves = Cell::new(0);
    proptest!(config, |(lengths in lengths, stages in stages())| {
        let axes = lengths.iter().map(|length| Axis { length: *length, periodic: true });
        let names = ["x", "y"].map(str::to_owned);
        let geometry = LatticeGeometry::along(names, axes.collect());
        let (proxy, width) = geometry.proxy([REACH; 3]).expect("shorter");
        let (builder, state) = write(&proxy, &stages);
        let proxy = Proxy { geometry: &proxy, width };
        let program = LatticeProgram::compile(&geometry, proxy, &builder, 1);
        let program = program.expect("code that looks as far as the proxy has room for");
        let Some(found) = evolve_in_a_wave(&program, state) else {
            return Ok(());
        };
        let (expected, _) = evolve(&program, state, Execution::Compiled, 2);
        prop_assert!(found == expected, "{geometry:?}");
        in_waves.update(|cases| cases + 1);
    });
    assert!(in_waves.get() > 25, "{} cases in waves", in_waves.get());
}

/// Each part comes once, behind all parts of earlier sweeps that it has to do with, and the later sweep begins before the earlier
/// one has ended.
#[test]
fn a_part_comes_when_all_that_it_has_to_do_with_has_come() {
    let part = (
        0_usize..12,
        1_usize..3,
        prop::collection::vec(0_usize..12, 0..3),
    );
    let sweep = prop::collection::vec(part, 1..12);
    proptest!(|(sweeps in prop::collection::vec(sweep, 1..5))| {
        let part = |(start, count, read): &(usize, usize, Vec<usize>)| {
            let mut sites = PartSites::default();
            sites.write(start * PART..(start + count) * PART);
            read.iter().for_each(|at| sites.read(at * PART..at * PART + 1));
            sites
        };
        let touched = |(start, count, read): &(usize, usize, Vec<usize>)| -> BTreeSet<usize> {
            (*start..start + count).chain(read.iter().copied()).collect()
        };
        let written = |(start, count, _): &(usize, usize, Vec<usize>)| -> BTreeSet<usize> {
            (*start..start + count).collect()
        };
        let parts: Vec<Vec<PartSites>> = sweeps.iter().map(|own| own.iter().map(part).collect()).collect();
        let order = wavefront(&parts);
        prop_assert_eq!(order.len(), sweeps.iter().map(Vec::len).sum::<usize>());
        for (at, own) in order.iter().enumerate() {
            prop_assert!(!order[..at].contains(own));
            let of = &sweeps[own.sweep][own.part];
            for later in &order[at..] {
                let other = &sweeps[later.sweep][later.part];
                let is_apart = written(of).is_disjoint(&touched(other)) && written(other).is_disjoint(&touched(of));
                prop_assert!(later.sweep >= own.sweep || is_apart);
            }
        }
    });
    let ring = |at: usize| {
        let mut sites = PartSites::default();
        sites.write(at * PART..(at + 1) * PART);
        for at in [(at + 1) % 16, (at + 15) % 16] {
            sites.read(at * PART..at * PART + 1);
        }
        sites
    };
    let order = wavefront(&vec![(0..16).map(ring).collect::<Vec<_>>(); 4]);
    let first = order.iter().position(|own| own.sweep == 3);
    assert!(first.is_some_and(|first| first < 20), "{order:?}");
}
