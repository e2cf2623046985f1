//! Runs the tests with one fault after the other.

use std::collections::{BTreeMap, BTreeSet};
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
    /// Its time limit. A test that takes longer has noticed the fault.
    pub limit: Duration,
    /// Bytes of data that it may allocate. One that asks for more ends with an error, and has noticed.
    pub memory: u64,
}

impl Gate {
    /// A program that may allocate `memory` bytes, with the time that it takes without faults.
    ///
    /// # Errors
    /// Fails if the program fails without a fault.
    pub fn new(program: &Path, arguments: &[&str], folder: &Path, memory: u64) -> Result<Self> {
        let mut gate = Self {
            program: program.to_owned(),
            arguments: arguments.iter().map(|&argument| argument.to_owned()).collect(),
            folder: folder.to_owned(),
            limit: Duration::from_secs(600),
            memory,
        };
        let start = Instant::now();
        if gate.notices(usize::MAX)? {
            let command = [&[program.to_string_lossy().into_owned()][..], &gate.arguments].concat().join(" ");
            return Err(format!("`{command}` fails without a fault, or needs more than {memory} bytes").into());
        }
        // Other faults run beside it.
        gate.limit = 10 * start.elapsed() + Duration::from_secs(20);
        Ok(gate)
    }

    /// Whether it notices a fault.
    pub fn notices(&self, number: usize) -> Result<bool> {
        // The shell sets the limit before the program begins. It is one of data, not of addresses: a GPU driver reserves more addresses than
        // there is memory.
        let child = Command::new("sh")
            .args(["-c", r#"ulimit -d "$0" && exec "$@""#, &(self.memory >> 10).to_string()])
            .arg(&self.program)
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

/// The names of the tests that a test program runs. An ignored test notices nothing, so it is left out.
///
/// # Errors
/// Fails if the program does not list its tests.
pub fn tests_of(program: &Path) -> Result<Vec<String>> {
    let list = |which: &[&str]| -> Result<Vec<String>> {
        let output = Command::new(program).args(["--list", "--format", "terse"]).args(which).output()?;
        let text = String::from_utf8(output.stdout)?;
        Ok(text.lines().filter_map(|line| Some(line.strip_suffix(": test")?.to_owned())).collect())
    };
    let ignored: BTreeSet<String> = list(&["--ignored"])?.into_iter().collect();
    Ok(list(&[])?.into_iter().filter(|test| !ignored.contains(test)).collect())
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
