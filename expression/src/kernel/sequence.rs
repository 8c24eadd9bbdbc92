//! Kernels one after the other, and arithmetic between them, as one kernel.

use super::code::Instruction;
use super::compile::Kernel;
use super::draft::Draft;

/// A number of a [`Sequence`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Value(u32);

/// A kernel that evaluates others, every operation rounded as it is alone. No sum is rearranged between them, and each
/// number has the bits that it has where the kernels run one by one.
///
/// ```
/// use leafwise_expression::kernel::Sequence;
/// use leafwise_expression::{Arithmetic, Graph, Kernel};
///
/// let mut graph = Graph::new();
/// let x = graph.input(0);
/// let square = graph.multiply(&x, &x);
/// let kernel = Kernel::compile(&graph, &[square], 0, 1);
/// // (x² − 1)².
/// let mut sequence = Sequence::new(1, &[&kernel, &kernel]);
/// let x = sequence.input(0);
/// let square = sequence.evaluate(&kernel, &[x])[0];
/// let one = sequence.number(1.0);
/// let rest = sequence.subtract(square, one);
/// let again = sequence.evaluate(&kernel, &[rest]);
/// let whole = sequence.kernel(&again);
/// let mut workspace = whole.workspace(1);
/// whole.prepare(&mut workspace, &[], &[1.0], &[0.1]);
/// assert_eq!(whole.evaluate_rows(&mut workspace, &[[3.0]]), [[64.0]]);
/// ```
pub struct Sequence {
    parameters: usize,
    inputs: usize,
    step: Draft,
    coefficient: Draft,
}

impl Sequence {
    /// Nothing yet, over so many inputs; `kernels` are those that will be evaluated, each as often as it will be.
    ///
    /// # Panics
    /// When they have different parameters.
    pub fn new(inputs: usize, kernels: &[&Kernel]) -> Self {
        let parameters = kernels.first().map_or(0, |kernel| kernel.parameters);
        let is_same = kernels.iter().all(|kernel| kernel.parameters == parameters);
        assert!(is_same, "kernels of the same parameters");
        let coefficients: usize = kernels.iter().map(|kernel| kernel.coefficients).sum();
        Self {
            parameters,
            inputs,
            step: Draft::new(inputs + coefficients),
            coefficient: Draft::new(parameters + 2),
        }
    }

    /// An input.
    ///
    /// # Panics
    /// When there are not so many.
    pub fn input(&self, index: usize) -> Value {
        assert!(index < self.inputs, "one of the inputs");
        Value(index as u32)
    }

    /// A constant.
    pub fn number(&mut self, value: f64) -> Value {
        Value(self.step.number(value))
    }

    /// a + b.
    pub fn add(&mut self, Value(a): Value, Value(b): Value) -> Value {
        Value(self.step.push(|out| Instruction::Add { out, a, b }))
    }

    /// a − b.
    pub fn subtract(&mut self, Value(a): Value, Value(b): Value) -> Value {
        Value(self.step.push(|out| Instruction::Subtract { out, a, b }))
    }

    /// a·b.
    pub fn multiply(&mut self, Value(a): Value, Value(b): Value) -> Value {
        Value(self.step.push(|out| Instruction::Multiply { out, a, b }))
    }

    /// a/b.
    pub fn divide(&mut self, Value(a): Value, Value(b): Value) -> Value {
        Value(self.step.push(|out| Instruction::Divide { out, a, b }))
    }

    /// −a.
    pub fn negate(&mut self, Value(a): Value) -> Value {
        Value(self.step.push(|out| Instruction::Negate { out, a }))
    }

    /// |a|.
    pub fn magnitude(&mut self, Value(a): Value) -> Value {
        Value(self.step.push(|out| Instruction::Magnitude { out, a }))
    }

    /// The larger of a and b, b where one is no number.
    pub fn larger(&mut self, Value(a): Value, Value(b): Value) -> Value {
        Value(self.step.push(|out| Instruction::Larger { out, a, b }))
    }

    /// The smaller of a and b, b where one is no number.
    pub fn smaller(&mut self, Value(a): Value, Value(b): Value) -> Value {
        Value(self.step.push(|out| Instruction::Smaller { out, a, b }))
    }

    /// The outputs of a kernel.
    ///
    /// # Panics
    /// When there are not as many inputs as it has, or it is none of those that were announced.
    pub fn evaluate(&mut self, kernel: &Kernel, inputs: &[Value]) -> Vec<Value> {
        assert_eq!(inputs.len(), kernel.inputs, "one value an input");
        let own: Vec<u32> = (0..self.parameters as u32 + 2).collect();
        let coefficients = self.coefficient.append(&kernel.coefficient_code, &own);
        let first = self.inputs + self.coefficient.outputs.len();
        self.coefficient.outputs.extend(coefficients);
        let last = self.inputs + self.coefficient.outputs.len();
        assert!(last <= self.step.fixed(), "a kernel that was announced");
        let inputs = inputs.iter().map(|value| value.0);
        let given: Vec<u32> = inputs.chain(first as u32..last as u32).collect();
        let outputs = self.step.append(&kernel.step_code, &given);
        outputs.into_iter().map(Value).collect()
    }

    /// The kernel of these outputs.
    pub fn kernel(mut self, outputs: &[Value]) -> Kernel {
        self.step.outputs = outputs.iter().map(|value| value.0).collect();
        let coefficients = self.step.fixed() - self.inputs;
        Kernel::new(
            self.parameters,
            [self.inputs, coefficients],
            self.coefficient.finish(),
            self.step.finish(),
        )
    }
}
