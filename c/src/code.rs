//! How a call ended.

/// How a call ended. Codes 0 to 3 are the program's exit codes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum LeafwiseCode {
    /// Done; all outputs are written.
    LEAFWISE_DONE = 0,
    /// A step failed: diverged, left its chart, did not converge. An integrator stays at the last state that it reached.
    LEAFWISE_STEP_FAILED = 1,
    /// An argument that is none: NULL, an unknown handle, a wrong length, text that is not UTF-8, a file that cannot be read.
    LEAFWISE_USAGE = 2,
    /// A scene that is not valid; the message says where.
    LEAFWISE_INVALID_SCENE = 3,
    /// The integrator steps in another thread.
    LEAFWISE_BUSY = 4,
    /// A derivative that the scene's method does not offer, and steps of a scene whose events change the state.
    LEAFWISE_UNSUPPORTED = 5,
    /// A mistake of this library.
    LEAFWISE_MISTAKE = 6,
    /// Samples that find no memory.
    LEAFWISE_NO_MEMORY = 7,
}
