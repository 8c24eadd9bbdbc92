//! A realization as a table of functions.

use std::cell::UnsafeCell;
use std::ffi::c_void;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use leafwise_core::{
    Accuracy, BuildError, ChartMaps, Ends, Evaluator, RealizationData, RealizationMaps, StepError,
};
use leafwise_plugin_abi::{
    LW_ERROR, LW_FLAG_COTANGENT_CHART, LW_FLAG_EXACT, LW_FLAG_REVERSIBLE, LwError,
    LwHostRealization, LwMapCall, LwRealization, LwStatus,
};

use super::points::{Buffers, Shape, batches, fail};

/// Compiled maps of a realization: compiled once, for all instances that it is lent to.
#[derive(Clone, Debug)]
pub(crate) struct RealizationToLend {
    realization: Arc<dyn RealizationData>,
    maps: RealizationMaps,
    chart: Option<ChartMaps>,
}

impl RealizationToLend {
    /// Compiles the maps of a realization for a system with so many parameters.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] where it offers neither code nor numbers,
    /// [`BuildError::Algebra`] where its code has no derivative.
    pub(crate) fn new(
        realization: &Arc<dyn RealizationData>,
        parameters: usize,
    ) -> Result<Self, BuildError> {
        Ok(Self {
            realization: Arc::clone(realization),
            maps: RealizationMaps::new(realization.as_ref(), parameters)?,
            chart: ChartMaps::of(realization.as_ref(), parameters)?,
        })
    }

    /// The realization for one instance, for these values of the system's parameters.
    pub(crate) fn lend(&self, parameters: &[f64]) -> HostRealization {
        HostRealization::new(self.clone(), parameters.to_vec())
    }

    /// The chart about the section, where there is one.
    pub(crate) fn chart(&self) -> Option<&ChartMaps> {
        self.chart.as_ref()
    }
}

/// The realization of one instance, lent from `create` to `destroy`.
pub(crate) struct HostRealization {
    shared: Box<Shared>,
}

/// The realization behind the plugin's pointers.
struct Shared {
    raw: LwHostRealization,
    functions: LwRealization,
    source: RealizationToLend,
    parameters: Vec<f64>,
    is_called: AtomicBool,
    state: UnsafeCell<State>,
}

struct State {
    evaluators: Option<Evaluators>,
    buffers: Buffers,
    /// Base, offset and increment.
    ends: Vec<f64>,
    /// Dβ̂ and D(α̂ − β̂).
    tangents: Vec<f64>,
    /// (x, p), for its chart.
    pair: Vec<f64>,
}

/// Evaluators for one ε.
struct Evaluators {
    epsilon: u64,
    maps: Box<dyn Evaluator>,
    chart: Option<Box<dyn Evaluator>>,
}

// SAFETY: the pointers lead to the box itself and to constant functions; the state is reached behind
// `is_called` only.
unsafe impl Send for HostRealization {}

impl HostRealization {
    fn new(source: RealizationToLend, parameters: Vec<f64>) -> Self {
        let realization = &source.realization;
        let (d, space) = (realization.dimension(), realization.space_dimension());
        let mut raw = LwHostRealization::empty();
        match realization.accuracy() {
            Accuracy::Exact => raw.flags |= LW_FLAG_EXACT,
            Accuracy::Order(n) => raw.order = i32::try_from(n).unwrap_or(i32::MAX),
        }
        if realization.points_are_pairs() {
            raw.flags |= LW_FLAG_COTANGENT_CHART;
            if realization.abilities().is_reversible {
                raw.flags |= LW_FLAG_REVERSIBLE;
            }
        }
        let evaluators = Evaluators::new(&source, &parameters, 1.0);
        let functions = table(&source, !realization.points_are_pairs());
        let mut shared = Box::new(Shared {
            raw,
            functions,
            parameters,
            is_called: AtomicBool::new(false),
            state: UnsafeCell::new(State {
                evaluators: Some(evaluators),
                buffers: Buffers::default(),
                ends: vec![0.0; 3 * d],
                tangents: vec![0.0; 2 * d * space],
                pair: vec![0.0; 2 * d],
            }),
            source,
        });
        shared.raw.functions = &raw const shared.functions;
        shared.raw.instance = (&raw mut *shared).cast();
        Self { shared }
    }

    /// The pointer that `create` is given.
    pub(crate) fn raw(&self) -> *const LwHostRealization {
        &raw const self.shared.raw
    }
}

impl Evaluators {
    fn new(source: &RealizationToLend, parameters: &[f64], epsilon: f64) -> Self {
        Self {
            epsilon: epsilon.to_bits(),
            maps: source.maps.evaluator(parameters, epsilon),
            chart: source
                .chart
                .as_ref()
                .map(|chart| chart.evaluator(parameters, epsilon)),
        }
    }
}

/// The functions that this realization has; a chart where its points are not pairs.
fn table(source: &RealizationToLend, needs_chart: bool) -> LwRealization {
    let mut table = LwRealization::empty();
    table.space_dimension = Some(space_dimension);
    table.alpha = Some(alpha);
    table.beta = Some(beta);
    table.sigma = Some(sigma);
    table.ends = Some(ends);
    if source.maps.has_jacobian() {
        table.alpha_jacobian = Some(alpha_jacobian);
        table.beta_with_jacobian = Some(beta_with_jacobian);
        table.ends_jacobian = Some(ends_jacobian);
    }
    if let Some(own) = source.chart.as_ref().filter(|_| needs_chart) {
        table.chart = Some(chart);
        if own.has_jacobian() {
            table.chart_jacobian = Some(chart_jacobian);
        }
    }
    table
}

/// The realization behind a plugin's first argument.
///
/// # Safety
/// `instance` is that of an [`LwHostRealization`] that is still lent.
unsafe fn shared<'a>(instance: *mut c_void) -> &'a Shared {
    // SAFETY: passed on to the caller.
    unsafe { &*instance.cast::<Shared>() }
}

unsafe extern "C" fn space_dimension(instance: *mut c_void) -> usize {
    // SAFETY: the contract of the table.
    unsafe { shared(instance) }
        .source
        .realization
        .space_dimension()
}

/// The evaluators and buffers of a call.
struct Maps<'a> {
    realization: &'a dyn RealizationData,
    evaluators: &'a mut Evaluators,
    ends: &'a mut [f64],
    tangents: &'a mut [f64],
    pair: &'a mut [f64],
}

impl Maps<'_> {
    fn ends(&mut self, z: &[f64]) -> Result<(), StepError> {
        self.evaluators.maps.values(z, self.ends)
    }

    /// Dβ̂ and D(α̂ − β̂) at z, after the values there.
    fn tangents(&mut self, z: &[f64]) -> Result<(&[f64], &[f64]), StepError> {
        self.ends(z)?;
        self.evaluators.maps.jacobians(z, self.tangents)?;
        Ok(self.tangents.split_at(self.tangents.len() / 2))
    }

    fn beta(&self, out: &mut [f64]) {
        let ends = Ends::of(self.ends);
        for (i, out) in out.iter_mut().enumerate() {
            *out = ends.target(i);
        }
    }

    /// χ, with the pair (x, p) that it is to be evaluated at.
    fn chart(&mut self, x: &[f64], p: &[f64]) -> Result<(&mut dyn Evaluator, &[f64]), StepError> {
        let (first, second) = self.pair.split_at_mut(x.len());
        first.copy_from_slice(x);
        second.copy_from_slice(p);
        let chart = self.evaluators.chart.as_mut().ok_or(StepError::NoTangent)?;
        Ok((chart.as_mut(), self.pair))
    }
}

/// Evaluates one function at the points of a call.
///
/// # Safety
/// The contract of the table: the instance is lent, the call and the error are what the interface
/// says.
unsafe fn evaluate(
    instance: *mut c_void,
    call: *const LwMapCall,
    err: *mut LwError,
    shape: impl FnOnce(usize, usize) -> Shape,
    mut function: impl FnMut(&mut Maps<'_>, [&[f64]; 2], &mut [f64]) -> Result<(), StepError>,
) -> LwStatus {
    // SAFETY: passed on to the caller.
    let shared = unsafe { shared(instance) };
    if shared.is_called.swap(true, Ordering::Acquire) {
        let text = "the realization is called from two threads at once";
        // SAFETY: passed on to the caller.
        return unsafe { fail(err, LW_ERROR, -1, 0.0, text) };
    }
    // SAFETY: nobody else is between the two changes of `is_called`.
    let state = unsafe { &mut *shared.state.get() };
    // SAFETY: passed on to the caller; a NULL call is refused by `batches`.
    let epsilon = unsafe { call.as_ref() }.map_or(1.0, |call| call.epsilon);
    let known = state
        .evaluators
        .take()
        .filter(|evaluators| evaluators.epsilon == epsilon.to_bits());
    let mut evaluators =
        known.unwrap_or_else(|| Evaluators::new(&shared.source, &shared.parameters, epsilon));
    let realization = shared.source.realization.as_ref();
    let mut evaluator = Maps {
        realization,
        evaluators: &mut evaluators,
        ends: &mut state.ends,
        tangents: &mut state.tangents,
        pair: &mut state.pair,
    };
    let shape = shape(realization.dimension(), realization.space_dimension());
    // SAFETY: passed on to the caller.
    let status = unsafe {
        let buffers = &mut state.buffers;
        batches(call, err, (shape, 1), buffers, |point, v, _, out| {
            function(&mut evaluator, [point, v], out)
        })
    };
    state.evaluators = Some(evaluators);
    shared.is_called.store(false, Ordering::Release);
    status
}

/// One point and no vector.
fn of_space(point: usize, output: usize) -> Shape {
    Shape {
        point,
        v: 0,
        w: 0,
        output,
    }
}

/// A pair (x, p).
fn of_pair(d: usize, output: usize) -> Shape {
    Shape {
        point: d,
        v: d,
        w: 0,
        output,
    }
}

macro_rules! maps {
    ($($name:ident: $shape:expr, $evaluate:expr;)*) => {$(
        unsafe extern "C" fn $name(
            instance: *mut c_void,
            call: *const LwMapCall,
            err: *mut LwError,
        ) -> LwStatus {
            // SAFETY: the contract of the table.
            unsafe { evaluate(instance, call, err, $shape, $evaluate) }
        }
    )*};
}

maps! {
    alpha: |d, s| of_space(s, d), |maps, [z, _], out| {
        maps.ends(z)?;
        let ends = Ends::of(maps.ends);
        out.iter_mut().enumerate().for_each(|(i, out)| *out = ends.source(i));
        Ok(())
    };
    beta: |d, s| of_space(s, d), |maps, [z, _], out| {
        maps.ends(z)?;
        maps.beta(out);
        Ok(())
    };
    sigma: of_space, |maps, [x, _], out| {
        maps.realization.section(x, out);
        Ok(())
    };
    ends: |d, s| of_space(s, 3 * d), |maps, [z, _], out| {
        maps.ends(z)?;
        out.copy_from_slice(maps.ends);
        Ok(())
    };
    alpha_jacobian: |d, s| of_space(s, d * s), |maps, [z, _], out| {
        let (target, increment) = maps.tangents(z)?;
        let sum = target.iter().zip(increment).map(|(t, i)| t + i);
        out.iter_mut().zip(sum).for_each(|(out, v)| *out = v);
        Ok(())
    };
    beta_with_jacobian: |d, s| of_space(s, d + d * s), |maps, [z, _], out| {
        let (value, jacobian) = out.split_at_mut(maps.realization.dimension());
        jacobian.copy_from_slice(maps.tangents(z)?.0);
        maps.beta(value);
        Ok(())
    };
    ends_jacobian: |d, s| of_space(s, 2 * d * s), |maps, [z, _], out| {
        maps.tangents(z)?;
        out.copy_from_slice(maps.tangents);
        Ok(())
    };
    chart: of_pair, |maps, [x, p], out| {
        let (chart, pair) = maps.chart(x, p)?;
        chart.values(pair, out)
    };
    chart_jacobian: |d, s| of_pair(d, s * 2 * d), |maps, [x, p], out| {
        let (chart, pair) = maps.chart(x, p)?;
        chart.jacobians(pair, out)
    };
}
