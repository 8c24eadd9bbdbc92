//! Numbered tasks on several threads, taken in by number: no result depends on the threads.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::Duration;

use crate::{RunError, RunOutcome};

/// How often its owner looks at the work.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Tasks that wait for one before them, at most, for each thread.
const WAITING: usize = 4;

/// Request to the owner of the work: take a result in, or look whether to go on.
pub(crate) enum Turn<T> {
    /// Take the next result in.
    Take(T),
    /// Look whether it shall go on: progress, checkpoints, interruptions.
    Look,
}

/// Works through `count` tasks; `None` of a task means that it was told to `stop`. Each thread has tools of its own, which it keeps
/// from one task to the next. `turn` tells whether to go on. Returns how many threads there were, and how it ended.
pub(crate) fn in_order<Tools: Default, T: Send>(
    (count, threads): (u64, NonZeroUsize),
    stop: &AtomicBool,
    work: impl Fn(&mut Tools, u64) -> Result<Option<T>, RunError> + Sync,
    mut turn: impl FnMut(Turn<T>) -> Result<bool, RunError>,
) -> (usize, Result<RunOutcome, RunError>) {
    let (next, taken) = (AtomicU64::new(0), AtomicU64::new(0));
    let (sender, receiver) = channel::<(u64, Result<Option<T>, RunError>)>();
    let most_waiting = (threads.get().saturating_mul(WAITING)) as u64;
    let next_task = |tools: &mut Tools| {
        let task = next.fetch_add(1, Ordering::Relaxed);
        if task >= count {
            return None;
        }
        // Tasks far ahead of the slowest wait, so that few results are held in memory.
        while task > taken.load(Ordering::Relaxed).saturating_add(most_waiting) {
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        Some((task, work(tools, task)))
    };
    let serve = || {
        let mut tools = Tools::default();
        while let Some((task, result)) = next_task(&mut tools) {
            let is_over = !matches!(result, Ok(Some(_)));
            if sender.clone().send((task, result)).is_err() || is_over {
                return;
            }
        }
    };
    std::thread::scope(|scope| {
        // As many as there are tasks, and as many as the system grants; without any, tasks are done here.
        let wanted = 0..count.min(threads.get() as u64);
        let spawn = |_| Builder::new().spawn_scoped(scope, serve).ok();
        let workers: Vec<_> = wanted.map_while(spawn).collect();
        let (mut waiting, mut own) = (BTreeMap::new(), Tools::default());
        let (mut at, mut is_stuck) = (0, false);
        let mut attempt = || -> Result<RunOutcome, RunError> {
            let mut goes_on = turn(Turn::Look)?;
            loop {
                if at == count {
                    return Ok(RunOutcome::Done);
                }
                if !goes_on {
                    return Ok(RunOutcome::Interrupted);
                }
                let received = if workers.is_empty() {
                    next_task(&mut own).ok_or(RecvTimeoutError::Disconnected)
                } else {
                    receiver.recv_timeout(LOOK_EVERY)
                };
                match received {
                    Ok((task, Ok(Some(result)))) => {
                        waiting.insert(task, result);
                        is_stuck = false;
                    }
                    Ok((_, Err(error))) => return Err(error),
                    Ok((_, Ok(None))) => {}
                    // A worker that panicked leaves its task out: the panic goes on below.
                    Err(_) if workers.iter().all(|worker| worker.is_finished()) && is_stuck => {
                        return Ok(RunOutcome::Interrupted);
                    }
                    Err(_) => is_stuck = true,
                }
                while let Some(result) = waiting.remove(&at) {
                    turn(Turn::Take(result))?;
                    at += 1;
                    taken.store(at, Ordering::Relaxed);
                }
                goes_on = turn(Turn::Look)?;
            }
        };
        let outcome = attempt();
        stop.store(true, Ordering::Relaxed);
        (workers.len().max(1), outcome)
    })
}
