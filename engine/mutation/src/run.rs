//! Runs the tests with one fault after the other.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use wait_timeout::ChildExt as _;

use crate::build::Result;

/// Every fault meets the same random inputs. The first one that fails ends the test, and is not kept for the faults after it.
const RANDOM_INPUTS: [(&str, &str); 3] =
    [("PROPTEST_RNG_SEED", "1"), ("PROPTEST_MAX_SHRINK_ITERS", "0"), ("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "1")];

/// A program that must notice faults.
pub struct Gate {
    /// The program.
    pub program: PathBuf,
    /// Its arguments.
    pub arguments: Vec<String>,
    /// Where it runs.
    pub folder: PathBuf,
    /// How long it may take. One that takes longer has noticed.
    pub limit: Duration,
}

impl Gate {
    /// A program, with the time that it takes without faults.
    pub fn new(program: &Path, arguments: &[&str], folder: &Path) -> Result<Self> {
        let arguments = arguments.iter().map(|&argument| argument.to_owned()).collect();
        let mut gate =
            Self { program: program.to_owned(), arguments, folder: folder.to_owned(), limit: Duration::from_secs(600) };
        let start = Instant::now();
        if gate.notices(usize::MAX)? {
            return Err(format!("{} fails without a fault", program.display()).into());
        }
        // Other faults run beside it.
        gate.limit = 10 * start.elapsed() + Duration::from_secs(20);
        Ok(gate)
    }

    /// Whether it notices a fault.
    pub fn notices(&self, number: usize) -> Result<bool> {
        let child = Command::new(&self.program)
            .args(&self.arguments)
            .current_dir(&self.folder)
            .env("RAXEL_MUTANT", number.to_string())
            .envs(RANDOM_INPUTS)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()?;
        let mut child = Running(child);
        Ok(!child.0.wait_timeout(self.limit)?.is_some_and(|status| status.success()))
    }
}

/// A child that does not outlive its run.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs every gate for every fault, until one notices. Gives which were noticed, and names each survivor at once.
///
/// # Errors
/// Says so when a gate does not run.
pub fn run(
    gates: &[Gate],
    faults: &[usize],
    jobs: usize,
    survived: &(dyn Fn(usize) + Sync),
) -> Result<BTreeMap<usize, bool>> {
    let (next, noticed, failed) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()), Mutex::new(None));
    let lock = "no thread panics with it";
    let work = || {
        while let Some(&number) = faults.get(next.fetch_add(1, Ordering::Relaxed)) {
            let mut result = false;
            for gate in gates {
                match gate.notices(number) {
                    Ok(notices) => result = notices,
                    Err(error) => *failed.lock().expect(lock) = Some(error.to_string()),
                }
                if result {
                    break;
                }
            }
            if !result {
                survived(number);
            }
            let mut noticed = noticed.lock().expect(lock);
            noticed.insert(number, result);
            if noticed.len().is_multiple_of(50) {
                eprintln!("{} of {}", noticed.len(), faults.len());
            }
        }
    };
    std::thread::scope(|scope| (0..jobs.max(1)).for_each(|_| drop(scope.spawn(work))));
    match failed.into_inner().expect(lock) {
        Some(error) => Err(error.into()),
        None => Ok(noticed.into_inner().expect(lock)),
    }
}
