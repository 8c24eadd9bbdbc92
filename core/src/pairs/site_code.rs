//! The code of one site, and the loop over sites.

use leafwise_expression::{Graph, Kernel, Term, Workspace};

use crate::error::BuildError;

/// The number of places that are evaluated at a time.
const BLOCK: usize = 64;

/// The code of one site: of rows of inputs, over all sites and points, to rows of results.
#[derive(Clone, Debug)]
pub(super) struct SiteCode {
    kernel: Kernel,
    /// The row of each input of the kernel.
    rows: Vec<usize>,
}

impl SiteCode {
    /// Code that `write` writes of so many rows.
    ///
    /// # Errors
    /// Those of `write`.
    pub(super) fn new(
        rows: usize,
        parameters: usize,
        write: impl FnOnce(&mut Graph, &[Term]) -> Result<Vec<Term>, BuildError>,
    ) -> Result<Self, BuildError> {
        let mut graph = Graph::compilable();
        let inputs: Vec<Term> = (0..rows).map(|at| graph.input(at)).collect();
        let terms = write(&mut graph, &inputs)?;
        graph.unless_refused(())?;
        let (kernel, rows) = Kernel::compile_used(&graph, &terms, parameters);
        Ok(Self { kernel, rows })
    }

    /// The operations of one evaluation at one site.
    pub(super) fn work(&self) -> u64 {
        self.kernel.step_operations().work()
    }

    /// A workspace for these parameters.
    pub(super) fn workspace(&self, parameters: &[f64]) -> Workspace {
        let mut workspace = self.kernel.workspace(BLOCK);
        let spread = |value: &f64| std::iter::repeat_n(*value, BLOCK);
        let parameters: Vec<f64> = parameters.iter().flat_map(spread).collect();
        let ones = [1.0; BLOCK];
        self.kernel
            .prepare(&mut workspace, &parameters, &ones, &ones);
        workspace
    }

    /// Evaluates it at `places` places. `row` gives the numbers of an input's row, as many as places; `write` takes the
    /// numbers of a result from a place on.
    pub(super) fn evaluate<'a>(
        &self,
        workspace: &mut Workspace,
        places: usize,
        row: impl Fn(usize) -> &'a [f64],
        mut write: impl FnMut(usize, usize, &[f64]),
    ) {
        for place in (0..places).step_by(BLOCK) {
            let count = BLOCK.min(places - place);
            for (input, own) in self.rows.iter().enumerate() {
                let from = &row(*own)[place..][..count];
                let (own, beyond) = workspace.input_mut(input).split_at_mut(count);
                own.copy_from_slice(from);
                beyond.fill(from[0]);
            }
            self.kernel.evaluate_in_place(workspace);
            for output in 0..self.kernel.outputs() {
                write(
                    output,
                    place,
                    &self.kernel.output(workspace, output)[..count],
                );
            }
        }
    }
}
