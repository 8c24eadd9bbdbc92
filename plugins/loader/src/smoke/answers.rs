//! Answers of an instance, asked again beside other instances.

use std::sync::Barrier;
use std::thread;

use leafwise_plugin_abi::LwMapFn;

use super::function::{Function, Points, same};
use crate::foreign::Instance;
use crate::platform;
use crate::smoke_failure::SmokeFailure;

/// Instances that are called at the same time.
const THREADS: usize = 3;

/// How often each of them is asked everything: more often where the library's own data change from
/// call to call, which may be scratch space that instances share.
const ROUNDS: usize = 8;
const ROUNDS_OF_SUSPECTS: usize = 400;

/// How often the points stand in a batch then, so that calls last long enough to overlap; those of large
/// systems do so by themselves, and are asked less often.
const REPEATED: usize = 16;
const LARGE: usize = 256;
const ROUNDS_OF_LARGE: usize = 2;

/// A function at some points, and what it gave.
#[derive(Clone, Debug)]
struct Answer {
    name: String,
    function: LwMapFn,
    results: usize,
    epsilon: f64,
    h: f64,
    points: Points,
    expected: Vec<Vec<f64>>,
}

impl Answer {
    fn new(function: &Function<'_>, points: &Points, expected: &[Vec<f64>]) -> Self {
        Self {
            name: function.name.to_owned(),
            function: function.function,
            results: function.results,
            epsilon: function.epsilon,
            h: function.h,
            points: points.clone(),
            expected: expected.to_vec(),
        }
    }

    fn function(&self) -> Function<'_> {
        Function {
            name: &self.name,
            function: self.function,
            results: self.results,
            epsilon: self.epsilon,
            h: self.h,
        }
    }

    fn is_large(&self) -> bool {
        self.points
            .point
            .first()
            .is_some_and(|point| point.len() > LARGE)
    }

    /// The same for all points several times, beginning with the point `first`: so that instances on
    /// several threads have different points in the same places.
    fn repeated(&self, first: usize) -> Self {
        let count = self.expected.len();
        let times = if self.is_large() { 1 } else { REPEATED };
        let order: Vec<usize> = (0..count * times).map(|at| (first + at) % count).collect();
        Self {
            points: self.points.in_order(&order),
            expected: order.iter().map(|at| self.expected[*at].clone()).collect(),
            ..self.clone()
        }
    }

    /// Whether an instance gives the same answer, to the bit.
    fn is_given_by(&self, instance: &mut Instance) -> bool {
        let found = self.function().once(instance, &self.points);
        matches!(found, Ok(Some(found))
            if found.iter().zip(&self.expected).all(|(a, b)| same(a, b)))
    }
}

/// An instance that is tried, with its answers.
pub(super) struct Tester {
    pub instance: Instance,
    answers: Vec<Answer>,
}

impl Tester {
    pub(super) fn new(instance: Instance) -> Self {
        Self {
            instance,
            answers: Vec::new(),
        }
    }

    /// [`Function::checked`] of the instance; what it answers is kept.
    pub(super) fn try_at(
        &mut self,
        function: &Function<'_>,
        points: &Points,
    ) -> Result<Option<Vec<Vec<f64>>>, SmokeFailure> {
        let found = function.checked(&mut self.instance, points)?;
        if let Some(answer) = &found {
            self.answers.push(Answer::new(function, points, answer));
        }
        Ok(found)
    }

    /// Asks another instance the same, whatever it answers.
    pub(super) fn ask(&self, other: &mut Instance) {
        for answer in &self.answers {
            drop(answer.function().once(other, &answer.points));
        }
    }

    /// Checks that the answers are the same once other instances have been made and called.
    pub(super) fn again(&mut self) -> Result<(), SmokeFailure> {
        let Self { instance, answers } = self;
        match answers.iter().find(|answer| !answer.is_given_by(instance)) {
            None => Ok(()),
            Some(answer) => Err(SmokeFailure::DependsOnOthers {
                function: answer.name.clone(),
            }),
        }
    }

    /// The functions whose calls at other points leave other bytes in the library's own data. A counter
    /// does that too; scratch space there is shared by all instances.
    pub(super) fn writes_static_data(&mut self) -> Vec<String> {
        let mut found: Vec<String> = Vec::new();
        let Self { instance, answers } = self;
        for answer in answers.iter() {
            let Some(address) = answer.function.map(|function| function as *const ()) else {
                continue;
            };
            let mut after = |points: &Points| {
                drop(answer.function().once(instance, points));
                platform::static_data(address)
            };
            let last = answer.points.point.len().saturating_sub(1);
            let (at_first, at_last) = (
                after(&answer.points.alone(0)),
                after(&answer.points.alone(last)),
            );
            if at_first != at_last && !found.contains(&answer.name) {
                found.push(answer.name.clone());
            }
        }
        found
    }

    /// Checks that instances made and called on several threads at the same time give the same answers.
    pub(super) fn in_parallel(
        &self,
        make: &(dyn Fn() -> Option<Instance> + Sync),
        is_suspect: bool,
    ) -> Result<(), SmokeFailure> {
        let rounds = match is_suspect {
            _ if self.answers.iter().any(Answer::is_large) => ROUNDS_OF_LARGE,
            true => ROUNDS_OF_SUSPECTS,
            false => ROUNDS,
        };
        let start = Barrier::new(THREADS);
        let answers = &self.answers;
        let wrong = |thread: usize| -> Option<String> {
            let own: Vec<Answer> = answers.iter().map(|a| a.repeated(thread)).collect();
            start.wait();
            let mut instance = make()?;
            let mut all = (0..rounds).flat_map(|_| &own);
            let wrong = all.find(|answer| !answer.is_given_by(&mut instance));
            wrong.map(|answer| answer.name.clone())
        };
        let found = thread::scope(|scope| {
            let wrong = &wrong;
            let threads: Vec<_> = (0..THREADS)
                .map(|thread| scope.spawn(move || wrong(thread)))
                .collect();
            let ended = threads.into_iter().filter_map(|thread| thread.join().ok());
            ended.flatten().next()
        });
        match found {
            None => Ok(()),
            Some(function) => Err(SmokeFailure::NotParallel { function }),
        }
    }
}
