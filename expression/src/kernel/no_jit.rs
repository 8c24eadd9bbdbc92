//! In place of the just-in-time compiler where there is none.

use super::code::Code;
use super::distances::{Distances, Passes};

/// Machine code: none.
#[derive(Debug)]
pub(super) enum MachineCode {}

/// The memory that machine code works in: none.
#[derive(Clone, Debug)]
pub(super) enum Room {}

impl MachineCode {
    pub(super) fn is_available() -> bool {
        false
    }

    pub(super) fn compile(
        _code: &Code,
        _lanes: usize,
        _distances: Option<&Distances>,
    ) -> Option<Self> {
        None
    }

    pub(super) fn evaluations_to_pay(_lanes: usize) -> u64 {
        u64::MAX
    }

    pub(super) fn room(&self) -> Room {
        match *self {}
    }

    pub(super) fn run(&self, _slots: &mut [f64], _room: &mut Room) {
        match *self {}
    }

    pub(super) fn run_along(
        &self,
        _slots: &mut [f64],
        _room: &mut Room,
        _array: &mut [f64],
        _passes: &Passes,
    ) -> usize {
        match *self {}
    }

    pub(super) fn bytes(&self) -> usize {
        match *self {}
    }

    pub(super) fn seconds(&self) -> f64 {
        match *self {}
    }
}
