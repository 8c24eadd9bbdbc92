//! The boundary of a plugin, called as a host calls it: strides, failures, panics, NULL.

use std::ffi::{CStr, c_char, c_void};

use leafwise_plugin_sdk::abi::{
    LW_DISCARD, LW_ERROR, LW_FATAL, LW_OK, LW_UNSUPPORTED, LwCreate, LwError, LwInput, LwMapCall,
    LwOutput, LwPart, LwStatus, LwSystem,
};
use leafwise_plugin_sdk::{Create, Fail, Info, Part, System};

/// Π(y)·v = (y₂ v₂, −y₂ v₁): linear, so that places are told apart; other methods misbehave.
struct Planar;

impl Part for Planar {
    const INFO: Info = Info::new(c"test/planar", c"a plane");
    fn create(args: &Create<'_>) -> Result<Self, Fail> {
        args.real("absent").map(|_| Self).or(Ok(Self))
    }
}

impl System for Planar {
    fn dimension(&self) -> usize {
        2
    }
    fn tensor(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        out[0] = y[1] * v[1];
        out[1] = -y[1] * v[0];
        Ok(())
    }
    fn hamiltonian(&mut self, y: &[f64]) -> Result<f64, Fail> {
        if y[0] < 0.0 {
            return Err(Fail::outside(
                1.5,
                format!("y1 = {} is negative — déjà vu", y[0]),
            ));
        }
        Ok(y[0])
    }
    fn gradient(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        out[0] = y[std::hint::black_box(3)];
        Ok(())
    }
}

fn part() -> LwPart {
    leafwise_plugin_sdk::system_part::<Planar>()
}

fn functions() -> &'static LwSystem {
    // SAFETY: the constant table of a system.
    unsafe { &*part().functions.cast::<LwSystem>() }
}

/// An instance, ended with the value.
struct Planars(*mut c_void);

impl Planars {
    fn new() -> Self {
        let (mut instance, mut err) = (std::ptr::null_mut(), LwError::empty());
        let create = functions().life.create.expect("create is required");
        // SAFETY: as the ABI asks.
        let status = unsafe { create(&LwCreate::empty(), &mut instance, &mut err) };
        assert_eq!(status, LW_OK);
        Self(instance)
    }
}

impl Drop for Planars {
    fn drop(&mut self) {
        let destroy = functions().life.destroy.expect("destroy is required");
        // SAFETY: made by `create`, ended once.
        unsafe { destroy(self.0) };
    }
}

fn error(text: &mut [c_char]) -> LwError {
    let mut err = LwError::empty();
    err.capacity = text.len() as u32;
    err.message = text.as_mut_ptr();
    err.point = -1;
    err
}

fn words(text: &[c_char]) -> String {
    // SAFETY: the shims end every text with a NUL inside the buffer.
    unsafe { CStr::from_ptr(text.as_ptr()) }
        .to_str()
        .expect("UTF-8, cut at a character")
        .to_owned()
}

fn input(data: &[f64], dim: usize, point_stride: usize, coordinate_stride: usize) -> LwInput {
    LwInput {
        data: data.as_ptr(),
        dim,
        point_stride,
        coordinate_stride,
    }
}

#[test]
fn arrays_of_points_and_structures_of_arrays_give_the_same_numbers() {
    let instance = Planars::new();
    // Three points (y, v); the gaps of the second layout hold canaries.
    let points = [[1.0, 2.0], [3.0, 5.0], [7.0, 11.0]];
    let vectors = [[13.0, 17.0], [19.0, 23.0], [29.0, 31.0]];
    let expected: Vec<[f64; 2]> = (0..3)
        .map(|i| [points[i][1] * vectors[i][1], -points[i][1] * vectors[i][0]])
        .collect();
    for (point_stride, coordinate_stride) in [(2, 1), (1, 3), (5, 2), (2, 7)] {
        let place = |i: usize, j: usize| i * point_stride + j * coordinate_stride;
        let room = place(2, 1) + 1;
        let (mut y, mut v, mut out) =
            (vec![f64::NAN; room], vec![f64::NAN; room], vec![-1.0; room]);
        for i in 0..3 {
            for j in 0..2 {
                y[place(i, j)] = points[i][j];
                v[place(i, j)] = vectors[i][j];
            }
        }
        let mut call = LwMapCall::empty();
        call.count = 3;
        call.epsilon = 1.0;
        call.point = input(&y, 2, point_stride, coordinate_stride);
        call.v = input(&v, 2, point_stride, coordinate_stride);
        call.output = LwOutput {
            data: out.as_mut_ptr(),
            dim: 2,
            point_stride,
            coordinate_stride,
        };
        let mut err = LwError::empty();
        let tensor = functions().tensor.expect("tensor is required");
        // SAFETY: buffers of the stated sizes.
        assert_eq!(unsafe { tensor(instance.0, &call, &mut err) }, LW_OK);
        let mut untouched = out.clone();
        for i in 0..3 {
            for j in 0..2 {
                assert_eq!(
                    out[place(i, j)],
                    expected[i][j],
                    "{point_stride}, {coordinate_stride}"
                );
                untouched[place(i, j)] = -1.0;
            }
        }
        assert!(
            untouched.iter().all(|value| *value == -1.0),
            "a gap was written"
        );
    }
}

fn one_point(
    function: leafwise_plugin_sdk::abi::LwMapFn,
    instance: *mut c_void,
    y: &[f64],
    count: usize,
    err: *mut LwError,
) -> LwStatus {
    let mut out = vec![0.0; y.len()];
    let mut call = LwMapCall::empty();
    call.count = count;
    call.point = input(y, y.len() / count, y.len() / count, 1);
    call.output = LwOutput {
        data: out.as_mut_ptr(),
        dim: 1,
        point_stride: 1,
        coordinate_stride: 1,
    };
    // SAFETY: buffers of the stated sizes.
    unsafe { function.expect("present")(instance, &call, err) }
}

#[test]
fn a_point_outside_is_discarded_with_its_index_ratio_and_text() {
    let instance = Planars::new();
    let mut text = [0; 200];
    let mut err = error(&mut text);
    let y = [1.0, 0.0, -2.0, 0.0];
    let status = one_point(functions().hamiltonian, instance.0, &y, 2, &mut err);
    assert_eq!((status, err.point, err.ratio), (LW_DISCARD, 1, 1.5));
    assert_eq!(words(&text), "y1 = -2 is negative — déjà vu");
}

#[test]
fn a_text_longer_than_the_buffer_is_cut_at_a_character() {
    let instance = Planars::new();
    let whole = "y1 = -2 is negative — déjà vu";
    for capacity in 1..=whole.len() + 1 {
        let mut text = vec![0x55; capacity];
        let mut err = error(&mut text);
        let status = one_point(
            functions().hamiltonian,
            instance.0,
            &[-2.0, 0.0],
            1,
            &mut err,
        );
        assert_eq!(status, LW_DISCARD);
        let cut = words(&text);
        assert!(whole.starts_with(&cut));
        assert!(cut.len() + 4 >= capacity.min(whole.len() + 1), "{cut}");
    }
}

#[test]
fn a_panic_is_fatal_with_its_message() {
    let instance = Planars::new();
    let mut text = [0; 200];
    let mut err = error(&mut text);
    let status = one_point(functions().gradient, instance.0, &[1.0, 2.0], 1, &mut err);
    assert_eq!(status, LW_FATAL);
    assert_eq!(
        words(&text),
        "panic: index out of bounds: the len is 2 but the index is 3"
    );
}

#[test]
fn null_instances_and_functions_not_offered_are_told_apart() {
    let mut text = [0; 200];
    let mut err = error(&mut text);
    let status = one_point(
        functions().hamiltonian,
        std::ptr::null_mut(),
        &[1.0],
        1,
        &mut err,
    );
    assert_eq!(status, LW_ERROR);
    assert_eq!(words(&text), "a map was called with NULL");
    assert!(functions().hessian.is_none() && functions().casimir_gradients.is_none());
    assert_eq!(Fail::unsupported("x"), Fail::Unsupported("x".to_owned()));
    assert_ne!(LW_UNSUPPORTED, LW_ERROR);
}
