//! Limits of one input: memory and processor time, both counted, so that a busy machine changes nothing. No panic is allowed, not even a caught one.

use std::cell::Cell;
use std::panic::{set_hook, take_hook};
use std::sync::Once;
use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};

/// The limits of an input of n bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    /// Bytes that may be allocated at a time, for any input.
    pub bytes: u64,
    /// Bytes that may be allocated besides for each byte of the input.
    pub bytes_per_byte: u64,
    /// Processor time.
    pub time: Duration,
}

impl Bounds {
    /// Of parsers: 32 MiB, 4 KiB a byte and 4 seconds. The time is a hundred times that of any input.
    pub(crate) const PARSER: Bounds = Bounds { bytes: 32 << 20, bytes_per_byte: 4 << 10, time: Duration::from_secs(4) };
}

/// Runs something on this thread. Panics when it uses more than is allowed.
pub(crate) fn within(bounds: &Bounds, length: usize, run: impl FnOnce()) {
    let start = processor_time();
    let used = allocation_counter::measure(run).bytes_max;
    let time = processor_time().saturating_sub(start);
    let allowed = bounds.bytes + bounds.bytes_per_byte * length as u64;
    assert!(used <= allowed, "{used} bytes were allocated at a time for {length}; {allowed} are allowed");
    assert!(time <= bounds.time, "{length} bytes took {time:?} of processor time; {:?} are allowed", bounds.time);
}

thread_local! {
    static PANICS: Cell<u32> = const { Cell::new(0) };
}

/// Runs something on this thread. Panics when something in it has panicked with a message, even if that was caught: a user would read of it.
pub(crate) fn without_panics(run: impl FnOnce()) {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let previous = take_hook();
        set_hook(Box::new(move |info| {
            PANICS.set(PANICS.get() + 1);
            previous(info);
        }));
    });
    PANICS.set(0);
    run();
    assert!(PANICS.get() == 0, "a panic was caught, and its message was printed");
}

/// Makes this thread do all work itself instead of sharing it with others. So all work is counted, and its order is always the same. Call it
/// once on a thread that runs targets.
///
/// # Panics
/// When the thread was made so before.
pub fn alone() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
    // The thread belongs to the pool for as long as it lives.
    std::mem::forget(pool.expect("a thread is made to work alone once"));
}

#[expect(clippy::cast_possible_truncation, reason = "a part of a second has less than 2³² nanoseconds")]
fn processor_time() -> Duration {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec.unsigned_abs(), now.tv_nsec.unsigned_abs() as u32)
}
