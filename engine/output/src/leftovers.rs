//! Files that a signal must not leave behind. A process that a signal ends (Ctrl-C, `kill`, a closed terminal) runs no destructors. So
//! this module lists the files that destructors would remove, and removes them before the signal has its usual effect.

use std::collections::BTreeMap;
#[cfg(unix)]
use std::sync::MutexGuard;
use std::sync::{Mutex, PoisonError};

type Undo = Box<dyn FnOnce() + Send>;

/// The number of the last one, and each with its number.
type List = (u64, BTreeMap<u64, Undo>);

/// The steps to undo, in the order in which they were listed.
static LISTED: Mutex<List> = Mutex::new((0, BTreeMap::new()));

/// Something that is undone when a signal ends the process; dropped, it no longer is.
#[derive(Debug)]
pub struct Listed(u64);

/// Lists something to undo. It must not wait for anything.
pub fn on_stop(undo: impl FnOnce() + Send + 'static) -> Listed {
    let mut listed = LISTED.lock().unwrap_or_else(PoisonError::into_inner);
    listed.0 += 1;
    let number = listed.0;
    listed.1.insert(number, Box::new(undo));
    Listed(number)
}

impl Drop for Listed {
    fn drop(&mut self) {
        LISTED.lock().unwrap_or_else(PoisonError::into_inner).1.remove(&self.0);
    }
}

/// Undoes everything, the last first. While the result is there, no [`Listed`] can be dropped: a thread that finds its files gone comes no further.
#[cfg(unix)]
fn undo_all() -> MutexGuard<'static, List> {
    let mut listed = LISTED.lock().unwrap_or_else(PoisonError::into_inner);
    while let Some((_, undo)) = listed.1.pop_last() {
        undo();
    }
    listed
}

/// Waits for signals on a thread of its own. A signal that is ignored (`nohup`, a job in the background of a script) stays ignored.
#[cfg(unix)]
pub fn watch_signals() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = ignored_signals();
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    // Without them signals end the process as they always do.
    let Ok(mut signals) = signal_hook::iterator::Signals::new(wanted) else { return };
    std::thread::spawn(move || {
        for signal in &mut signals {
            let _held = undo_all();
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        }
    });
}

/// A bit for each signal that this process ignores; none where the system has no such list.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

/// Nothing: this system has no signals.
#[cfg(not(unix))]
pub fn watch_signals() {}
