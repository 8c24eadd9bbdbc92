//! One compiled kernel.

use std::fmt;
use std::ptr::null_mut;
use std::time::Instant;

use super::assignment::{Arguments, has_formulas};
#[cfg(all(target_arch = "x86_64", not(windows)))]
use super::avx;
use super::executable::{Executable, Written};
use super::operation::Action;
#[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
use super::portable;
use super::program::Program;
use crate::analytic::AnalyticFunction;
use crate::kernel::aligned::Aligned;
use crate::kernel::code::{Code, Instruction};
use crate::kernel::distances::{Distances, Passes};

/// The largest program in bytes of slots: offsets have 31 bits.
const MOST_BYTES: usize = 1 << 30;

/// Backend that writes machine code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Backend {
    /// Our own assembler, so many lanes an instruction.
    #[cfg(all(target_arch = "x86_64", not(windows)))]
    Avx(avx::Width),
    /// Cranelift.
    #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
    Portable,
}

impl Backend {
    /// The fastest for so many lanes on this machine, `None` where none serves it.
    pub(super) fn best(lanes: usize) -> Option<Self> {
        #[cfg(all(target_arch = "x86_64", not(windows)))]
        if let Some(width) = avx::Width::best(lanes) {
            return Some(Self::Avx(width));
        }
        let _ = lanes;
        #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
        if portable::is_available() {
            return Some(Self::Portable);
        }
        None
    }

    /// How many numbers it holds in registers.
    fn registers(self) -> usize {
        match self {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Self::Avx(width) => width.registers() - 1,
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Self::Portable => 15,
        }
    }

    /// How many places of an array it takes at a time.
    fn places(self) -> usize {
        match self {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Self::Avx(width) => width.lanes(),
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Self::Portable => 1,
        }
    }

    /// Whether it has fused products.
    pub(super) fn fuses(self) -> bool {
        match self {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Self::Avx(_) => is_x86_feature_detected!("fma"),
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Self::Portable => false,
        }
    }

    /// The same for formulas in the place of calls.
    fn for_formulas(self) -> Self {
        match self {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Self::Avx(width) => Self::Avx(width.for_formulas()),
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Self::Portable => self,
        }
    }

    /// Whether it calls two functions of a pair at once.
    fn calls_pairs(self) -> bool {
        match self {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Self::Avx(_) => true,
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Self::Portable => false,
        }
    }

    fn write(
        self,
        program: &Program,
        lanes: usize,
        functions: &[AnalyticFunction],
        distances: Option<&Distances>,
    ) -> Option<Written> {
        match self {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Self::Avx(width) => avx::write(program, lanes, width, functions, distances),
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Self::Portable if distances.is_some() => None,
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Self::Portable => portable::write(program, lanes, functions),
        }
    }
}

/// Whether an instruction calls a function, which keeps no registers.
#[cfg(all(target_arch = "x86_64", not(windows)))]
fn calls(instruction: &Instruction) -> bool {
    matches!(Action::of(*instruction), Action::Call(_))
}

/// `fn(slots, scratch, first, end, second) -> reached`: the last four mean nothing in code that moves along no array.
type Entry = unsafe extern "C" fn(*mut f64, *mut f64, *mut f64, *mut f64, *mut f64) -> *mut f64;

/// One program as machine code.
struct Compiled {
    entry: Entry,
    /// How many numbers all lanes have in slots.
    slots: usize,
    /// The memory that it works in, as it is before the first run.
    scratch: Vec<f64>,
    /// Where in that memory the largest sizes since the last run that was not right stand, and what each is to be below.
    limits: Vec<(usize, f64)>,
    /// How many places of an array it takes at a time, and what it reads and writes there; of code that moves along one.
    along: Option<(usize, Distances)>,
    bytes: usize,
    /// Memory of the code that `entry` points into.
    _memory: Box<dyn Executable>,
}

impl Compiled {
    /// Runs it; returns whether its results are right.
    ///
    /// # Panics
    /// When `slots` or `scratch` has another length than the code was compiled for.
    #[inline]
    fn run(&self, slots: &mut [f64], scratch: &mut [f64]) -> bool {
        assert!(
            slots.len() == self.slots
                && scratch.len() == self.scratch.len()
                && self.along.is_none(),
            "the memory of another kernel"
        );
        // SAFETY: the code reads and writes the `self.slots` numbers from its first argument on and as many as
        // `self.scratch` has from its second one on; its memory lives as long as `self`.
        unsafe {
            (self.entry)(
                slots.as_mut_ptr(),
                scratch.as_mut_ptr(),
                null_mut(),
                null_mut(),
                null_mut(),
            )
        };
        let mut limits = self.limits.iter();
        let is_right = limits.all(|&(at, bound)| scratch[at] < bound);
        if !is_right {
            self.forget_sizes(scratch);
        }
        is_right
    }

    /// How many places of an array it takes at a time; 0 where it moves along none.
    fn at_once(&self) -> usize {
        self.along.as_ref().map_or(0, |along| along.0)
    }

    /// Runs it from the place `first` of an array to before `end`, the second place so far ahead. Returns where it is then:
    /// before the end where results are not right.
    ///
    /// # Safety
    /// `slots` and `scratch` have the lengths that the code was compiled for. From `first` to before `end` there is at
    /// least one place, and a multiple of what the code takes at once. All that stands at its distances from these places,
    /// and from those so far ahead, is in one array that nothing else refers to.
    unsafe fn run_along(
        &self,
        slots: &mut [f64],
        scratch: &mut [f64],
        [first, end]: [*mut f64; 2],
        ahead: usize,
    ) -> *mut f64 {
        let second = first.wrapping_add(ahead);
        let [slots, own] = [slots.as_mut_ptr(), scratch.as_mut_ptr()];
        // SAFETY: the code reads and writes slots and scratch memory as in `run`, and what stands at its distances from the
        // places, in the array as the caller says.
        let reached = unsafe { (self.entry)(slots, own, first, end, second) };
        if reached != end {
            self.forget_sizes(scratch);
        }
        reached
    }

    #[cold]
    fn forget_sizes(&self, scratch: &mut [f64]) {
        for &(at, _) in &self.limits {
            scratch[at] = 0.0;
        }
    }
}

/// After arguments that formulas near 0 do not serve they are not tried again for so many runs.
pub(super) const FAR: u32 = 64;

/// The machine code of one program for one number of lanes.
pub(crate) struct MachineCode {
    any: Compiled,
    /// The same without calls of pairs of functions, for arguments near 0.
    near: Option<Compiled>,
    seconds: f64,
    /// The functions whose addresses stand in the code.
    _functions: Box<[AnalyticFunction]>,
}

/// The memory that one caller's runs work in.
#[derive(Clone, Debug)]
pub(crate) struct Room {
    any: Aligned,
    near: Aligned,
    /// So many runs until arguments are taken to be near 0 again.
    until_near: u32,
}

#[cfg(test)]
impl Room {
    /// Whether the next run takes formulas near 0 first.
    pub(super) fn takes_formulas(&self) -> bool {
        self.until_near == 0
    }
}

impl MachineCode {
    /// Whether this machine has a compiler.
    pub(crate) fn is_available() -> bool {
        Backend::best(1).is_some()
    }

    /// Compiles `code` for `lanes` lanes, along an array if there are distances; `None` where the platform cannot or
    /// forbids it.
    pub(crate) fn compile(
        code: &Code,
        lanes: usize,
        distances: Option<&Distances>,
    ) -> Option<Self> {
        let backend = match Backend::best(lanes)? {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Backend::Avx(width) if code.instructions.iter().any(calls) => {
                Backend::Avx(width.with_calls(lanes))
            }
            backend => backend,
        };
        Self::compile_by(backend, code, lanes, distances)
    }

    /// After how many evaluations the code has saved the time that it took to compile, for programs
    /// of any size: both grow with the number of operations.
    pub(crate) fn evaluations_to_pay(lanes: usize) -> u64 {
        match Backend::best(lanes) {
            #[cfg(all(target_arch = "x86_64", not(windows)))]
            Some(Backend::Avx(_)) => 256,
            #[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
            Some(Backend::Portable) => 4096,
            None => u64::MAX,
        }
    }

    /// The same by a given backend.
    pub(super) fn compile_by(
        backend: Backend,
        code: &Code,
        lanes: usize,
        distances: Option<&Distances>,
    ) -> Option<Self> {
        let start = Instant::now();
        let slots = code.slots.checked_mul(lanes)?;
        if slots * size_of::<f64>() > MOST_BYTES {
            return None;
        }
        let functions: Box<[AnalyticFunction]> = code
            .instructions
            .iter()
            .filter_map(|instruction| match instruction {
                Instruction::ApplyAnalytic { function, .. } => Some(*function),
                _ => None,
            })
            .collect();
        let compile = |backend: Backend, arguments: Arguments| {
            let (registers, by_pairs) = (backend.registers(), backend.calls_pairs());
            let mut program = Program::new(code, arguments, registers, by_pairs);
            if let Some(distances) = distances {
                program = program.along(distances);
            }
            let written = backend.write(&program, lanes, &functions, distances)?;
            #[cfg(test)]
            if REFUSES.get() {
                return None;
            }
            // SAFETY: every backend writes a function of this signature in the platform's C convention.
            let entry = unsafe { std::mem::transmute::<*const u8, Entry>(written.memory.start()) };
            Some(Compiled {
                entry,
                slots,
                scratch: written.scratch,
                limits: written.limits,
                along: distances.map(|distances| (backend.places(), distances.clone())),
                bytes: written.bytes,
                _memory: written.memory,
            })
        };
        let formulas = (backend.fuses() && has_formulas(code)).then(|| backend.for_formulas());
        // Along an array both take as many places at a time.
        let along = formulas.filter(|_| distances.is_some());
        let any = compile(along.unwrap_or(backend), Arguments::Any)?;
        let near = formulas.map(|backend| compile(backend, Arguments::NearZero));
        Some(Self {
            any,
            near: near.flatten(),
            seconds: start.elapsed().as_secs_f64(),
            _functions: functions,
        })
    }

    /// Memory that [`MachineCode::run`] works in.
    pub(crate) fn room(&self) -> Room {
        let near = self.near.as_ref().map_or(&[][..], |near| &near.scratch);
        Room {
            any: Aligned::from(&self.any.scratch[..]),
            near: Aligned::from(near),
            until_near: 0,
        }
    }

    /// Runs the program on `slots`, slot s of lane w at `[s*lanes + w]`.
    ///
    /// # Panics
    /// When `slots` or `room` is that of another code.
    #[inline]
    pub(crate) fn run(&self, slots: &mut [f64], room: &mut Room) {
        if let Some(near) = &self.near {
            if room.until_near > 0 {
                room.until_near -= 1;
            } else if near.run(slots, &mut room.near) {
                return;
            } else {
                room.until_near = FAR;
            }
        }
        self.any.run(slots, &mut room.any);
    }

    /// Runs the program at the places of an array one after the other, pass after pass, each with the coefficients of one
    /// lane or another. Returns at how many places it did in each pass: at all but for less than it takes at a time.
    ///
    /// # Panics
    /// When `slots` or `room` is that of another code. Also when an input or output would not be in the array.
    pub(crate) fn run_along(
        &self,
        slots: &mut [f64],
        room: &mut Room,
        array: &mut [f64],
        passes: &Passes,
    ) -> usize {
        let (lanes, distances) = self.any.along.as_ref().expect("code along an array");
        let near = self.near.as_ref();
        assert!(
            slots.len() == self.any.slots
                && room.any.len() == self.any.scratch.len()
                && room.near.len() == near.map_or(0, |near| near.scratch.len())
                && near.is_none_or(|near| near.at_once() == *lanes),
            "the memory of another kernel"
        );
        let count = passes.places.len() - passes.places.len() % lanes;
        if count == 0 {
            return 0;
        }
        assert!(
            distances.fit(passes, array.len()),
            "all inputs and outputs are in the array"
        );
        // `fit` says that all places are in the array.
        let first = array.as_mut_ptr().wrapping_add(passes.places.start);
        let end = first.wrapping_add(count);
        for pass in 0..passes.count {
            let ahead = passes.ahead + pass * passes.stride;
            let mut at = first;
            while at != end {
                if let Some(near) = near.filter(|_| room.until_near == 0) {
                    // SAFETY: lengths are checked above; `fit` says that everything is in the array, the places to `end` are
                    // a multiple of `lanes`, and so are those to each place that the code gives back.
                    at = unsafe { near.run_along(slots, &mut room.near, [at, end], ahead) };
                    if at == end {
                        break;
                    }
                    room.until_near = FAR;
                }
                let left = (end.addr() - at.addr()) / size_of::<f64>();
                let own = match near {
                    Some(_) => left.min(room.until_near as usize * lanes),
                    None => left,
                };
                let until = at.wrapping_add(own);
                // SAFETY: as above; `until` is a multiple of `lanes` behind `at`, which is before `end`.
                unsafe { self.any.run_along(slots, &mut room.any, [at, until], ahead) };
                at = until;
                room.until_near -= room.until_near.min((own / lanes) as u32);
            }
        }
        count
    }

    /// The length of the code.
    pub(crate) fn bytes(&self) -> usize {
        self.any.bytes + self.near.as_ref().map_or(0, |near| near.bytes)
    }

    /// How long the compilation took.
    pub(crate) fn seconds(&self) -> f64 {
        self.seconds
    }
}

impl fmt::Debug for MachineCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MachineCode")
            .field("bytes", &self.bytes())
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
thread_local! {
    /// Makes this thread's compilations fail where memory becomes executable, which a platform may forbid.
    pub(super) static REFUSES: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}
