//! Time that a device had for its work, for limits on how long the work may take.
//!
//! A software device computes on threads of this process. On a busy machine, or while the process is stopped, these threads get little
//! processor time. A limit in plain time would then call a slow device hung. So a limit counts the processor time of the busiest thread
//! there: an endless loop in a shader uses it up, and a thread that does not run cannot.

use std::time::{Duration, Instant};

use crate::choice::DeviceKind;
use crate::device::Device;

/// The interval between looks at the threads. Before the first look, time counts as it passes: most waits are shorter.
pub(crate) const LOOK: Duration = Duration::from_millis(250);

/// A software device whose threads sleep gets this many times its limit: a driver that waits for itself is hung, too.
const SLEEPING: u32 = 10;

/// The most that counts between two looks for a device whose threads sleep: the process may have been stopped in between.
const GAP: Duration = Duration::from_secs(1);

/// Runs while a device has something to do.
#[derive(Clone, Debug)]
pub struct Stopwatch {
    started: Instant,
    /// Only of a software device.
    threads: Option<Looks>,
}

/// The last look at the threads of a software device.
#[derive(Clone, Debug)]
struct Looks {
    first: Option<(Instant, Threads)>,
    last: Instant,
    /// Time of the busiest thread.
    worked: Duration,
    /// Time between looks.
    passed: Duration,
}

impl Device {
    /// A stopwatch for the work of this device, which starts now.
    pub fn stopwatch(&self) -> Stopwatch {
        Stopwatch::start(self.capabilities().kind)
    }
}

impl Stopwatch {
    fn start(kind: DeviceKind) -> Self {
        let started = Instant::now();
        let looks = Looks { first: None, last: started, worked: Duration::ZERO, passed: Duration::ZERO };
        Self { started, threads: (kind == DeviceKind::Cpu).then_some(looks) }
    }

    /// Time that has passed.
    pub fn passed(&self) -> Duration {
        self.started.elapsed()
    }

    /// Whether the device had as much time for its work as the limit says. To be asked about every quarter of a second.
    pub fn is_over(&mut self, limit: Duration) -> bool {
        self.is_over_at(Instant::now(), limit)
    }

    fn is_over_at(&mut self, now: Instant, limit: Duration) -> bool {
        let passed = now - self.started;
        let Some(looks) = self.threads.as_mut().filter(|_| passed >= LOOK) else { return passed >= limit };
        match looks.look(now) {
            Some(worked) => worked >= limit || looks.passed >= limit.saturating_mul(SLEEPING),
            None => passed >= limit,
        }
    }
}

impl Looks {
    /// The processor time of the busiest thread, if the system reports it.
    fn look(&mut self, now: Instant) -> Option<Duration> {
        let gap = now - self.last;
        if gap >= LOOK {
            let threads = Threads::now()?;
            self.last = now;
            self.passed += gap.min(GAP);
            let (at, first) = self.first.get_or_insert_with(|| (now, threads.clone()));
            self.worked = LOOK + threads.busiest_since(first).min(now - *at);
        }
        Some(self.worked)
    }
}

/// Processor time of each thread of this process.
#[derive(Clone, Debug)]
struct Threads(Vec<Thread>);

#[derive(Clone, Copy, Debug)]
struct Thread {
    id: u32,
    worked: Duration,
}

impl Threads {
    /// `None` where the system does not say: only Linux has this folder.
    fn now() -> Option<Self> {
        let threads = std::fs::read_dir("/proc/self/task").ok()?.flatten();
        // A thread may end while it is looked at.
        let threads = threads.filter_map(|thread| {
            let id = thread.file_name().to_str()?.parse().ok()?;
            // Nanoseconds on a processor, nanoseconds in wait for one, number of turns.
            let times = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
            let worked = Duration::from_nanos(times.split(' ').next()?.parse().ok()?);
            Some(Thread { id, worked })
        });
        let threads: Vec<Thread> = threads.collect();
        (!threads.is_empty()).then_some(Self(threads))
    }

    /// Time of the thread that has worked most since then.
    fn busiest_since(&self, before: &Self) -> Duration {
        let worked = |now: &Thread| {
            let then = before.0.iter().find(|then| then.id == now.id);
            now.worked.saturating_sub(then.map_or(Duration::ZERO, |then| then.worked))
        };
        self.0.iter().map(worked).max().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spin() {
        let start = Instant::now();
        while start.elapsed() < Duration::from_millis(20) {
            std::hint::spin_loop();
        }
    }

    const LIMIT: Duration = Duration::from_millis(400);

    #[test]
    fn a_gpu_has_the_time_that_passes() {
        let mut stopwatch = Stopwatch::start(DeviceKind::Discrete);
        let over = [LIMIT.checked_sub(Duration::from_nanos(1)).unwrap(), LIMIT]
            .map(|time| stopwatch.is_over_at(stopwatch.started + time, LIMIT));
        assert_eq!(over, [false, true]);
    }

    #[test]
    fn a_software_device_that_works_has_the_time_of_its_busiest_thread() {
        let mut stopwatch = Stopwatch::start(DeviceKind::Cpu);
        while !stopwatch.is_over(LIMIT) {
            spin();
        }
        // On a busy machine it takes longer.
        assert!(stopwatch.passed() >= LIMIT, "{stopwatch:?}");
    }

    /// Other tests of this process may work at the same time, on threads that come and go.
    #[test]
    fn what_two_threads_have_worked_is_not_added() {
        let thread = |id, milliseconds| Thread { id, worked: Duration::from_millis(milliseconds) };
        let before = Threads(vec![thread(1, 500), thread(2, 0), thread(3, 40)]);
        let now = Threads(vec![thread(1, 510), thread(2, 30), thread(4, 20)]);
        assert_eq!(now.busiest_since(&before), Duration::from_millis(30));
    }

    /// Nothing works between two looks, which are an hour apart, as after the process was stopped.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_software_device_that_sleeps_has_ten_times_as_much_and_a_stopped_process_loses_a_second() {
        let (mut stopwatch, limit) = (Stopwatch::start(DeviceKind::Cpu), Duration::from_secs(3));
        let start = stopwatch.started;
        // The threads of other tests may work while this one looks, but not for so long.
        let over = (1..100).find(|hour| stopwatch.is_over_at(start + *hour * Duration::from_secs(3600), limit));
        assert_eq!(over, Some(30));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_system_says_how_long_a_thread_has_worked() {
        let before = Threads::now().unwrap();
        let start = Instant::now();
        spin();
        while Threads::now().unwrap().busiest_since(&before) < Duration::from_millis(10) {
            spin();
            assert!(start.elapsed() < Duration::from_secs(60));
        }
    }
}
