//! Slots and coefficients of one caller of a kernel, and what it does with them.

use std::sync::Arc;
use std::sync::atomic::{Ordering, compiler_fence};

use super::aligned::Aligned;
use super::compile::Kernel;
use super::distances::Passes;
use super::execution::{Compiled, Execution, MachineCodeSize, REPORT};
use super::interpreter::run;
use super::{MachineCode, Room};

/// Slots and coefficients of one caller of a [`Kernel`], for a fixed number of lanes.
///
/// Lane-wise layout: `inputs` and `outputs` are structures of arrays, coordinate j of lane w at
/// `[j*lanes + w]`. A lane's result has the same bits whatever the number of lanes.
#[derive(Clone, Debug)]
pub struct Workspace {
    lanes: usize,
    slots: Aligned,
    execution: Execution,
    /// Where the coefficient kernel runs, and its machine code.
    room: Aligned,
    coefficients: Option<Box<Machine>>,
    machine: Option<Machine>,
    /// `None` before the first evaluation along an array.
    along: Option<Box<AlongArray>>,
    reports: Reports,
}

/// Evaluations of which the kernel is told: of the first few at once, since many short runs are as much work as a long one.
#[derive(Clone, Copy, Debug)]
struct Reports {
    /// So many until it is told of `size`; 0 where it never is.
    until: u8,
    size: u8,
}

impl Reports {
    /// Counts an evaluation; returns of how many the kernel is to be told now, or 0.
    fn count(&mut self) -> u8 {
        if self.until == 0 {
            return 0;
        }
        self.until -= 1;
        if self.until > 0 {
            return 0;
        }
        let size = self.size;
        self.size = REPORT.min(2 * size);
        self.until = self.size;
        size
    }
}

/// Machine code for evaluations along an array, and whether coefficients are the same in all lanes.
#[derive(Clone, Debug)]
struct AlongArray {
    machine: Option<Machine>,
    /// Whether each coefficient is the same in all lanes, where that was looked at.
    are_same: Option<bool>,
}

/// Machine code and the memory it works in.
#[derive(Clone, Debug)]
struct Machine {
    code: Arc<MachineCode>,
    room: Room,
}

impl Machine {
    fn new(code: Arc<MachineCode>) -> Self {
        Self {
            room: code.room(),
            code,
        }
    }
}

impl Kernel {
    /// A workspace for `lanes` trajectories, its coefficients not yet prepared (all NaN).
    ///
    /// # Panics
    /// When `lanes` is 0.
    pub fn workspace(&self, lanes: usize) -> Workspace {
        self.workspace_for(lanes, Execution::default_of_process())
    }

    /// A workspace that runs both kernels in a given way.
    ///
    /// # Panics
    /// When `lanes` is 0.
    pub fn workspace_for(&self, lanes: usize, execution: Execution) -> Workspace {
        assert!(lanes > 0, "a kernel evaluates at least one lane");
        let mut slots = Aligned::filled(self.step_code.slots * lanes, f64::NAN);
        for &(slot, value) in &self.step_code.constants {
            slots[slot as usize * lanes..][..lanes].fill(value);
        }
        let machine = match execution {
            Execution::Interpreted => None,
            Execution::Compiled => self.compiled.get(&self.step_code, lanes, true),
            Execution::Adaptive => self.compiled.get(&self.step_code, lanes, false),
        };
        let first = match execution {
            Execution::Adaptive => 1,
            Execution::Interpreted | Execution::Compiled => 0,
        };
        Workspace {
            lanes,
            slots,
            execution,
            room: Aligned::filled(0, 0.0),
            coefficients: None,
            machine: machine.map(Machine::new),
            along: None,
            reports: Reports {
                until: first,
                size: first,
            },
        }
    }

    /// Runs the coefficient kernel: `parameters` as a structure of arrays over the lanes, one ε and
    /// h for each lane. Allocates when it first runs, and when machine code comes to pay. Returns whether a coefficient has changed.
    ///
    /// # Panics
    /// When a slice does not have `parameters × lanes` or `lanes` entries.
    pub fn prepare(
        &self,
        workspace: &mut Workspace,
        parameters: &[f64],
        epsilon: &[f64],
        h: &[f64],
    ) -> bool {
        let lanes = workspace.lanes;
        assert_eq!(
            parameters.len(),
            self.parameters * lanes,
            "one value a parameter and lane"
        );
        assert_eq!(
            (epsilon.len(), h.len()),
            (lanes, lanes),
            "one step size a lane"
        );
        workspace.forget_sameness();
        let code = &self.coefficient_code;
        if workspace.room.len() != code.slots * lanes {
            workspace.room = Aligned::filled(code.slots * lanes, 0.0);
        }
        let slots = &mut workspace.room;
        slots[..parameters.len()].copy_from_slice(parameters);
        slots[parameters.len()..][..lanes].copy_from_slice(epsilon);
        slots[parameters.len() + lanes..][..lanes].copy_from_slice(h);
        for &(slot, value) in &code.constants {
            slots[slot as usize * lanes..][..lanes].fill(value);
        }
        if workspace.coefficients.is_none() {
            let compiled = &self.compiled_coefficients;
            let found = compiled.once(code, lanes, workspace.execution);
            workspace.coefficients = found.map(|code| Box::new(Machine::new(code)));
        }
        match &mut workspace.coefficients {
            Some(machine) => machine.code.run(slots, &mut machine.room),
            None => run(code, slots, lanes),
        }
        let mut changes = false;
        for (at, &slot) in code.outputs.iter().enumerate() {
            let kept = &mut workspace.slots[(self.inputs + at) * lanes..][..lanes];
            let new = &slots[slot as usize * lanes..][..lanes];
            let mut pairs = kept.iter().zip(new);
            changes |= pairs.any(|(kept, new)| kept.to_bits() != new.to_bits());
            kept.copy_from_slice(new);
        }
        changes
    }

    /// Takes the coefficients of others in their order. They are kernels that this one evaluates, or one that shares
    /// its coefficients.
    ///
    /// # Panics
    /// When these are not as many, or of another number of lanes.
    pub fn prepare_from(&self, workspace: &mut Workspace, others: &[(&Self, &Workspace)]) {
        let lanes = workspace.lanes;
        workspace.forget_sameness();
        let own = &mut workspace.slots[self.inputs * lanes..][..self.coefficients * lanes];
        let mut rest = own;
        for (other, from) in others {
            assert_eq!(from.lanes, lanes, "as many lanes");
            let count = other.coefficients * lanes;
            let part = rest.split_off_mut(..count).expect("as many coefficients");
            part.copy_from_slice(&from.slots[other.inputs * lanes..][..count]);
        }
        assert!(rest.is_empty(), "all coefficients");
    }

    /// Runs the step kernel on `inputs` (inputs × lanes), writes `outputs` (outputs × lanes).
    ///
    /// # Panics
    /// When a slice has another length.
    pub fn evaluate(&self, workspace: &mut Workspace, inputs: &[f64], outputs: &mut [f64]) {
        let lanes = workspace.lanes;
        workspace.slots[..self.inputs * lanes].copy_from_slice(inputs);
        self.evaluate_in_place(workspace);
        assert_eq!(
            outputs.len(),
            self.outputs() * lanes,
            "one value an output and lane"
        );
        let (places, slots) = (&self.step_code.outputs, &workspace.slots);
        match lanes {
            // The common numbers of lanes: no call to copy a few numbers.
            1 => gather::<1>(places, slots, outputs),
            8 => gather::<8>(places, slots, outputs),
            _ => {
                for (&slot, out) in places.iter().zip(outputs.chunks_exact_mut(lanes)) {
                    out.copy_from_slice(&slots[slot as usize * lanes..][..lanes]);
                }
            }
        }
    }

    /// Runs the step kernel on rows of W numbers, one an input. Returns its outputs without a copy, a row of W numbers
    /// each.
    ///
    /// # Panics
    /// Unless the workspace has W lanes and there are as many rows as inputs.
    #[inline(always)]
    pub fn evaluate_rows<'own, const W: usize>(
        &self,
        workspace: &'own mut Workspace,
        inputs: &[[f64; W]],
    ) -> &'own [[f64; W]] {
        assert!(
            workspace.lanes == W && inputs.len() == self.inputs,
            "as many lanes as numbers a row, as many rows as inputs"
        );
        let Workspace {
            slots,
            machine,
            reports,
            ..
        } = workspace;
        let slots: &mut [f64] = slots;
        let own = &mut slots.as_chunks_mut::<W>().0[..inputs.len()];
        for (own, input) in own.iter_mut().zip(inputs) {
            *own = *input;
            apart::<W>();
        }
        match machine {
            Some(machine) => machine.code.run(slots, &mut machine.room),
            None => *machine = self.interpret(slots, W, reports),
        }
        let rows = slots.as_chunks_mut::<W>().0;
        for &(row, slot) in &self.strays {
            rows[row as usize] = rows[slot as usize];
        }
        &rows[self.first_output..][..self.step_code.outputs.len()]
    }

    /// The rows of the inputs, and those of the outputs of the last evaluation.
    ///
    /// # Panics
    /// When the workspace does not have W lanes.
    #[inline(always)]
    pub fn rows_mut<'own, const W: usize>(
        &self,
        workspace: &'own mut Workspace,
    ) -> (&'own mut [[f64; W]], &'own [[f64; W]]) {
        assert_eq!(workspace.lanes, W, "as many lanes as numbers a row");
        let rows = workspace.slots.as_chunks_mut::<W>().0;
        let (inputs, outputs) = rows.split_at_mut(self.first_output);
        (
            &mut inputs[..self.inputs],
            &outputs[..self.step_code.outputs.len()],
        )
    }

    /// Runs the step kernel on the rows of the inputs as they stand; returns its outputs as
    /// [`evaluate_rows`](Self::evaluate_rows) does.
    ///
    /// # Panics
    /// When the workspace does not have W lanes.
    #[inline(always)]
    pub fn evaluate_own_rows<'own, const W: usize>(
        &self,
        workspace: &'own mut Workspace,
    ) -> &'own [[f64; W]] {
        assert_eq!(workspace.lanes, W, "as many lanes as numbers a row");
        self.evaluate_in_place(workspace);
        let rows = workspace.slots.as_chunks_mut::<W>().0;
        for &(row, slot) in &self.strays {
            rows[row as usize] = rows[slot as usize];
        }
        &rows[self.first_output..][..self.step_code.outputs.len()]
    }

    /// Runs the step kernel on the inputs that stand in the workspace.
    #[inline]
    pub fn evaluate_in_place(&self, workspace: &mut Workspace) {
        let Workspace {
            lanes,
            slots,
            machine,
            reports,
            ..
        } = workspace;
        match machine {
            Some(machine) => machine.code.run(slots, &mut machine.room),
            None => *machine = self.interpret(slots, *lanes, reports),
        }
    }

    /// Runs the step kernel by the interpreter; returns machine code for the next time once that pays.
    #[cold]
    fn interpret(&self, slots: &mut [f64], lanes: usize, reports: &mut Reports) -> Option<Machine> {
        run(&self.step_code, slots, lanes);
        let evaluations = reports.count();
        if evaluations == 0 {
            return None;
        }
        let machine = self
            .compiled
            .report(&self.step_code, lanes, evaluations.into());
        machine.map(Machine::new)
    }

    /// Whether coefficients of so many lanes have machine code.
    #[cfg(all(test, feature = "jit"))]
    pub(super) fn has_compiled_coefficients(&self, lanes: usize) -> bool {
        let sizes = self.compiled_coefficients.describe();
        sizes.iter().any(|size| size.lanes == lanes)
    }

    /// Sizes and compilation times of the step kernel's machine code so far, for each number of lanes.
    pub fn machine_code(&self) -> Vec<MachineCodeSize> {
        self.compiled.describe()
    }

    /// The values of one output, a number a lane.
    pub fn output<'a>(&self, workspace: &'a Workspace, index: usize) -> &'a [f64] {
        let lanes = workspace.lanes;
        &workspace.slots[self.step_code.outputs[index] as usize * lanes..][..lanes]
    }
}

/// Between two coordinates of one lane: loads of both stay two loads. A load of 16 bytes over two stores of 8 that are on
/// their way to memory waits until they are there, and all that came before them is done. Between two rows of several
/// lanes: nothing.
#[inline(always)]
pub fn apart<const W: usize>() {
    if W == 1 {
        compiler_fence(Ordering::SeqCst);
    }
}

/// Copies the slots at `places`, W numbers each.
#[inline(always)]
fn gather<const W: usize>(places: &[u32], slots: &[f64], outputs: &mut [f64]) {
    let (slots, outputs) = (slots.as_chunks::<W>().0, outputs.as_chunks_mut::<W>().0);
    for (&place, output) in places.iter().zip(outputs) {
        *output = slots[place as usize];
    }
}

impl Workspace {
    /// Other coefficients may not be the same in all lanes.
    fn forget_sameness(&mut self) {
        if let Some(along) = &mut self.along {
            along.are_same = None;
        }
    }

    /// Runs the step kernel along an array where it is machine code already; returns at how many places it did.
    pub(super) fn run_along(
        &mut self,
        kernel: &Kernel,
        compiled: &Compiled,
        array: &mut [f64],
        passes: &Passes,
    ) -> usize {
        if self.machine.is_none() {
            return 0;
        }
        let (lanes, slots) = (self.lanes, &mut self.slots);
        let along = self.along.get_or_insert_with(|| {
            let code = compiled.get(&kernel.step_code, lanes, true);
            Box::new(AlongArray {
                machine: code.map(Machine::new),
                are_same: None,
            })
        });
        let are_same = *along.are_same.get_or_insert_with(|| {
            let rows = &slots[kernel.inputs * lanes..][..kernel.coefficients * lanes];
            let mut rows = rows.chunks_exact(lanes);
            rows.all(|row| row.iter().all(|own| own.to_bits() == row[0].to_bits()))
        });
        match along.machine.as_mut().filter(|_| are_same) {
            Some(Machine { code, room }) => code.run_along(slots, room, array, passes),
            None => 0,
        }
    }

    /// The number of lanes.
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// Whether the step kernel runs as machine code.
    pub fn is_compiled(&self) -> bool {
        self.machine.is_some()
    }

    /// The values of one input, a number a lane.
    pub fn input_mut(&mut self, index: usize) -> &mut [f64] {
        &mut self.slots[index * self.lanes..][..self.lanes]
    }
}
