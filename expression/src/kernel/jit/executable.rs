//! Memory that can be run, and the machine code that a backend writes into it.

/// Memory with a function in it, freed on drop.
pub(super) trait Executable: Send + Sync {
    /// Where the function starts: `fn(slots, scratch, first, end) -> reached` in the platform's C convention.
    fn start(&self) -> *const u8;
}

/// Machine code that a backend makes of a program.
pub(super) struct Written {
    pub(super) memory: Box<dyn Executable>,
    /// The length of the code.
    pub(super) bytes: usize,
    /// The scratch memory that it needs, as it is before the first run.
    pub(super) scratch: Vec<f64>,
    /// Where in it sizes stand after a run, 0 at first, and what each is to be below.
    pub(super) limits: Vec<(usize, f64)>,
}
