//! Progress of a run, as a program shows it meanwhile.

/// Where a run stands.
#[derive(Clone, Copy, Debug)]
pub struct Status {
    /// Steps made, those of earlier sessions included.
    pub steps: u64,
    /// Steps to make.
    pub total: u64,
    /// t.
    pub time: f64,
    /// The time at the end, in place of a number of steps.
    pub until: Option<f64>,
    /// The largest |H(x_k) − H(x_0)| so far.
    pub energy_drift: f64,
}

/// An observer of a run; called between steps, about a thousand times a second at most.
pub trait Progress {
    /// Shows where the run stands.
    fn show(&mut self, status: &Status);

    /// Whether the run is to stop: it writes a checkpoint first.
    fn is_interrupted(&self) -> bool;
}

/// Shows nothing and never interrupts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quiet;

impl Progress for Quiet {
    fn show(&mut self, _status: &Status) {}

    fn is_interrupted(&self) -> bool {
        false
    }
}
