//! Python with packages of the Python Package Index, which are installed once for all tests into the build folder.

use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use wait_timeout::ChildExt as _;

/// How long pip may take.
const INSTALLING: Duration = Duration::from_secs(300);
/// How long anything else may take.
const RUNNING: Duration = Duration::from_secs(120);

/// A Python that has the packages. `None`, with the reason printed, where they cannot be had.
pub(crate) struct Python {
    packages: PathBuf,
}

impl Python {
    /// `name` is that of the folder of the packages; `packages` are what pip is asked for, versions included.
    pub(crate) fn with(name: &str, packages: &[&str]) -> Option<Self> {
        match Self::install(name, packages) {
            Ok(python) => Some(python),
            Err(reason) => {
                eprintln!("skipped: Python with {} cannot be had: {reason}", packages.join(", "));
                None
            }
        }
    }

    fn install(name: &str, packages: &[&str]) -> Result<Self, String> {
        let root = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let folder = root.join(format!("python-{name}"));
        if folder.join("complete").exists() {
            return Ok(Self { packages: folder });
        }
        // Others may do the same at the same time: the first one that is done is used.
        let made = tempfile::Builder::new().prefix("python-").tempdir_in(root).map_err(|error| error.to_string())?;
        let mut pip = Command::new("python3");
        pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input", "--target"]);
        pip.arg(made.path()).args(packages).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let child = pip.spawn().map_err(|error| format!("python3: {error}"))?;
        let (status, said) = finish(child, INSTALLING).map_err(|reason| format!("pip: {reason}"))?;
        if !status.success() {
            return Err(format!("pip: {}", said.trim_end().lines().last().unwrap_or_default()));
        }
        std::fs::write(made.path().join("complete"), "").map_err(|error| error.to_string())?;
        let made = made.keep();
        match std::fs::rename(&made, &folder) {
            Ok(()) => {}
            Err(error) if matches!(error.kind(), ErrorKind::AlreadyExists | ErrorKind::DirectoryNotEmpty) => {
                let _ = std::fs::remove_dir_all(&made);
            }
            Err(error) => return Err(error.to_string()),
        }
        Ok(Self { packages: folder })
    }

    /// A command line of this Python.
    pub(crate) fn command(&self) -> Command {
        let mut command = Command::new("python3");
        command.env("PYTHONPATH", &self.packages).env("PYTHONDONTWRITEBYTECODE", "1").stdin(Stdio::null());
        command
    }

    /// Runs a script, which must succeed.
    pub(crate) fn run(&self, script: &str, arguments: &[&str], environment: &[(&str, &str)]) {
        let mut command = self.command();
        command.args(["-c", script]).args(arguments).envs(environment.iter().copied());
        let child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let (status, said) = finish(child, RUNNING).unwrap();
        assert!(status.success(), "{said}");
    }
}

/// Waits for a process, at most this long, and returns its stderr.
fn finish(mut child: Child, at_most: Duration) -> Result<(ExitStatus, String), String> {
    let mut stderr = child.stderr.take().expect("it is piped");
    let reader = std::thread::spawn(move || {
        let mut said = Vec::new();
        let _ = stderr.read_to_end(&mut said);
        String::from_utf8_lossy(&said).into_owned()
    });
    let status = child.wait_timeout(at_most).map_err(|error| error.to_string())?;
    if status.is_none() {
        let _ = child.kill();
        let _ = child.wait();
    }
    let said = reader.join().unwrap_or_default();
    status.map(|status| (status, said)).ok_or_else(|| format!("it was not done after {} s", at_most.as_secs()))
}
