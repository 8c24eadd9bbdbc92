//! A call into a library allocates nothing, nor does a call of the library back into the host.

#![cfg(unix)]

mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use leafwise_core::{EndMaps, PartParameters, Registry};
use support::build::{Workshop, rust_example};
use support::load;

/// Counts what this thread allocates.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every request is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: passed on to the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: passed on to the caller.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of a hundred calls, after a first one.
fn allocations(mut call: impl FnMut()) -> u64 {
    call();
    let before = ALLOCATIONS.get();
    (0..100).for_each(|_| call());
    ALLOCATIONS.get() - before
}

#[test]
fn calls_allocate_nothing() {
    let counted = ALLOCATIONS.get();
    drop(std::hint::black_box(vec![0.0; 3]));
    assert_eq!(ALLOCATIONS.get(), counted + 1, "allocations are counted");

    let workshop = Workshop::new();
    let mut registry = Registry::empty();
    load(&rust_example(), None, &mut registry).expect("the example in Rust");
    let gyrostat = workshop.compile("../../../examples/c/gyrostat");
    load(&gyrostat, None, &mut registry).expect("the example in C");
    load(&workshop.compile("steps"), None, &mut registry).expect("step maps");

    let system = registry.system("example-c/gyrostat").expect("the gyrostat");
    let system = system.build(&PartParameters::new()).expect("its defaults");
    let values = system.parameter_values();
    let mut numbers = system.numbers().expect("numbers").evaluator(&values);
    let (y, v, mut out) = ([1.0; 6], [2.0; 3], [0.0; 6]);
    let of_system = allocations(|| {
        numbers.tensor(&y, &v, &mut out).expect("values");
        numbers.gradient(&y, &mut out).expect("values");
        numbers.hessian(&y, &v, &mut out).expect("values");
    });
    assert_eq!(of_system, 0);

    let part = registry
        .realization("example/so3-rodrigues")
        .expect("a realization");
    let numbers = PartParameters::new().with("path", "numbers");
    let realization = part.build(&system, &numbers).expect("it fits");
    let Some(EndMaps::Numbers(numbers)) = realization.abilities().ends else {
        panic!("numbers");
    };
    let mut evaluator = numbers.evaluator(&values, 0.5);
    let (z, mut ends, mut tangents) = ([0.1; 6], [0.0; 9], [0.0; 36]);
    let of_realization = allocations(|| {
        evaluator.values(&z, &mut ends).expect("values");
        evaluator.jacobians(&z, &mut tangents).expect("values");
    });
    assert_eq!(of_realization, 0);

    // Heun's rule calls the host's tensor and gradient, here the gyrostat's own.
    let part = registry.stepper("steps/heun").expect("Heun's rule");
    let map = part
        .build(&system, &PartParameters::new())
        .expect("it fits");
    let lanes = 4;
    let parameters: Vec<f64> = values.iter().flat_map(|v| [*v; 4]).collect();
    let mut stepper = map.stepper(lanes, &parameters, 1.0, 0.1);
    let (x, low, mut increment) = ([0.5; 12], [0.0; 12], [0.0; 12]);
    let mut outcome = [const { Ok(()) }; 4];
    let of_step = allocations(|| stepper.increment(&x, &low, &mut increment, &mut outcome));
    assert_eq!(outcome, [const { Ok(()) }; 4]);
    assert_eq!(of_step, 0);
}
