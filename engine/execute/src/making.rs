//! Pipelines in the making. Some drivers need minutes for a shader that holds a whole tracer, so a progress report names the pipelines that
//! they work on.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::SLOW;
use super::shared::lock;

/// Seconds after which a pipeline that the driver still compiles is reported; later, each further minute.
const TOLD_AFTER: [u64; 5] = [1, 5, 15, 30, 60];

/// A pipeline that takes the driver long.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Compiling {
    /// The pass that the pipeline is for.
    pub pass: String,
    /// The time that the driver has worked on it.
    pub elapsed: Duration,
    /// Pipelines of the plan that are not there yet, this one included.
    pub left: usize,
}

/// The pipelines that the driver works on.
#[derive(Default)]
pub(super) struct Making {
    state: Mutex<State>,
    /// A plan has all its pipelines.
    ended: Condvar,
}

#[derive(Default)]
struct State {
    entries: Vec<Entry>,
    /// Pipelines of plans that are not there yet.
    left: usize,
    next: u64,
}

struct Entry {
    number: u64,
    pass: String,
    since: Instant,
    /// The number of reports: at `TOLD_AFTER` and its doublings, and at each minute after them.
    told: u64,
}

/// A pipeline that is in the making for as long as this lives.
pub(super) struct Begun<'m> {
    making: &'m Making,
    number: u64,
}

/// Pipelines of a plan that are to be made.
pub(super) struct Batch<'m> {
    making: &'m Making,
    /// Changed while the state is locked.
    left: AtomicUsize,
}

/// Ends a batch.
pub(super) struct Ending<'b>(&'b Batch<'b>);

impl Making {
    /// So many pipelines are to be made.
    pub(super) fn batch(&self, count: usize) -> Batch<'_> {
        lock(&self.state).left += count;
        Batch { making: self, left: AtomicUsize::new(count) }
    }

    /// The driver begins a pipeline.
    pub(super) fn begin(&self, pass: &str) -> Begun<'_> {
        let mut state = lock(&self.state);
        let number = state.next;
        state.next += 1;
        state.entries.push(Entry { number, pass: pass.to_owned(), since: Instant::now(), told: 0 });
        Begun { making: self, number }
    }

    /// The pipeline that the driver has worked on longest, if it has for a second.
    pub(super) fn longest(&self) -> Option<Compiling> {
        let state = lock(&self.state);
        let entry = state.entries.iter().min_by_key(|entry| entry.since)?;
        let elapsed = entry.since.elapsed();
        (elapsed >= Duration::from_secs(TOLD_AFTER[0])).then(|| Compiling {
            pass: entry.pass.clone(),
            elapsed,
            left: state.left.max(state.entries.len()),
        })
    }

    /// Calls `tell` with pipelines that take long, until the batch has ended.
    pub(super) fn watch(&self, batch: &Batch<'_>, tell: impl Fn(&Compiling)) {
        let mut state = lock(&self.state);
        while batch.left.load(Ordering::Relaxed) > 0 {
            let now = Instant::now();
            let left = state.left.max(state.entries.len());
            let mut due = Vec::new();
            let mut next = Duration::from_secs(TOLD_AFTER[0]);
            for entry in &mut state.entries {
                let elapsed = now.saturating_duration_since(entry.since);
                if elapsed >= told_after(entry.told) {
                    while elapsed >= told_after(entry.told) {
                        entry.told += 1;
                    }
                    due.push(Compiling { pass: entry.pass.clone(), elapsed, left });
                }
                next = next.min(told_after(entry.told).saturating_sub(elapsed));
            }
            drop(state);
            due.iter().for_each(&tell);
            state = lock(&self.state);
            if batch.left.load(Ordering::Relaxed) > 0 {
                let waited = self.ended.wait_timeout(state, next.max(Duration::from_millis(10)));
                state = waited.unwrap_or_else(PoisonError::into_inner).0;
            }
        }
    }
}

/// When the telling of that number is due.
fn told_after(told: u64) -> Duration {
    let at = usize::try_from(told).ok().and_then(|index| TOLD_AFTER.get(index).copied());
    let minutes = told.saturating_sub(TOLD_AFTER.len() as u64).saturating_add(2);
    Duration::from_secs(at.unwrap_or_else(|| minutes.saturating_mul(60)))
}

impl Batch<'_> {
    fn leave(&self, most: usize) {
        let mut state = lock(&self.making.state);
        let left = self.left.load(Ordering::Relaxed);
        let leaves = left.min(most);
        self.left.store(left - leaves, Ordering::Relaxed);
        state.left = state.left.saturating_sub(leaves);
        if left == leaves {
            self.making.ended.notify_all();
        }
    }

    /// The batch ends when the result is dropped.
    pub(super) fn until_dropped(&self) -> Ending<'_> {
        Ending(self)
    }

    /// One of them is there, or cannot be made.
    pub(super) fn done(&self) {
        self.leave(1);
    }
}

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.0.leave(usize::MAX);
    }
}

impl Drop for Begun<'_> {
    fn drop(&mut self) {
        lock(&self.making.state).entries.retain(|entry| entry.number != self.number);
    }
}

/// Makes a pipeline that belongs to no plan. Meanwhile a thread tells if that takes long, as it does for the pipelines of plans: with its name, e.g.
/// "tracer `tree64`", and how many are `left`, this one included.
pub fn watched<T>(name: &str, left: usize, make: impl FnOnce() -> T) -> T {
    let making = Making::default();
    let batch = making.batch(left);
    std::thread::scope(|scope| {
        let _ending = batch.until_dropped();
        scope.spawn(|| making.watch(&batch, |compiling| tell(name, compiling)));
        let _begun = making.begin(name);
        make()
    })
}

/// Tells of a pipeline that takes long. `named` says what it is for.
pub(super) fn tell(named: &str, compiling: &Compiling) {
    let (pass, seconds, left) = (compiling.pass.as_str(), compiling.elapsed.as_secs(), compiling.left);
    tracing::info!(target: SLOW, event = "compiling", pass, seconds, left, "the driver has compiled {named} for {seconds} s; pipelines left: {left}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_told_at_growing_times() {
        let times: Vec<u64> = (0..8).map(|told| told_after(told).as_secs()).collect();
        assert_eq!(times, [1, 5, 15, 30, 60, 120, 180, 240]);
    }

    #[test]
    fn a_pipeline_is_named_while_the_driver_works_on_it_and_not_before_a_second() {
        let making = Making::default();
        let batch = making.batch(3);
        let told = Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            scope.spawn(|| making.watch(&batch, |compiling| lock(&told).push(compiling.clone())));
            let quick = making.begin("quick");
            assert_eq!(making.longest(), None);
            drop(quick);
            batch.done();
            let slow = making.begin("slow");
            std::thread::sleep(Duration::from_millis(1300));
            let compiling = making.longest().expect("it takes more than a second");
            assert_eq!((compiling.pass.as_str(), compiling.left), ("slow", 2));
            drop(slow);
            assert_eq!(making.longest(), None);
            batch.done();
            batch.done();
        });
        let told = told.into_inner().unwrap();
        assert_eq!(told.iter().map(|one| (one.pass.as_str(), one.left)).collect::<Vec<_>>(), [("slow", 2)]);
    }

    #[test]
    fn what_a_pipeline_of_no_plan_makes_is_given_back_at_once() {
        let start = Instant::now();
        assert_eq!(watched("tracer `quick`", 40, || 7), 7);
        assert!(start.elapsed() < Duration::from_secs(1));
    }

    #[test]
    fn a_batch_that_was_not_made_leaves_the_count() {
        let making = Making::default();
        let batch = making.batch(2);
        drop(batch.until_dropped());
        assert_eq!(lock(&making.state).left, 0);
    }
}
