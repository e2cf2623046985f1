//! The child's part: compiles the requests on its stdin until that ends.

use std::io::{self, Stdin, Stdout};
use std::process::ExitCode;

use super::CompileLimits;
use super::protocol::{Order, Reply, read, write};
use crate::front_end::{self, Included, Job};

/// Serves the parent until it is gone.
pub(super) fn serve() -> ExitCode {
    let mut pipes = (io::stdin(), io::stdout());
    if write(&Reply::Hello(front_end::VERSION.to_owned()), &mut pipes.1).is_err() {
        return ExitCode::FAILURE;
    }
    while let Ok(Order::Compile(job, limits)) = read(&mut pipes.0) {
        restrict(limits);
        if compile(&job, &mut pipes).is_err() {
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn compile(job: &Job, pipes: &mut (Stdin, Stdout)) -> io::Result<()> {
    let outcome = front_end::compile(job, &mut |include| -> Included {
        write(&Reply::Include(include), &mut pipes.1).ok()?;
        match read(&mut pipes.0) {
            Ok(Order::Included(answer)) => answer,
            _ => None,
        }
    });
    write(&Reply::Done(outcome), &mut pipes.1)
}

/// Lets the kernel end this process when the next shader takes more than its limits. Time of the process before that does not count.
#[cfg(unix)]
fn restrict(limits: CompileLimits) {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    use rustix::time::{ClockId, clock_gettime};

    let taken = clock_gettime(ClockId::ProcessCPUTime).tv_sec.unsigned_abs();
    // The kernel counts whole seconds.
    let seconds = taken + u64::from(limits.seconds) + 1;
    for (resource, value) in [(Resource::Cpu, seconds), (Resource::As, limits.bytes), (Resource::Core, 0)] {
        let maximum = getrlimit(resource).maximum;
        let current = Some(maximum.map_or(value, |maximum| maximum.min(value)));
        // A limit that cannot be set leaves the parent's patience.
        let _ = setrlimit(resource, Rlimit { current, maximum });
    }
}

#[cfg(not(unix))]
fn restrict(_: CompileLimits) {}
