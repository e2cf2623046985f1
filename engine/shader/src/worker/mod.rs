//! Compiling in child processes. glslang can be made to follow a null pointer (about one in a thousand random small edits of an HLSL shader),
//! to work for hours (types whose written-out size doubles with each line) and to take all memory; a thread cannot be protected
//! from any of these. A program that must survive every text calls [`isolate`] first thing in `main`: from then on shaders are compiled by children that
//! it starts of itself, which stay for the next shader, and are ended and replaced when they break down or reach a limit.
//!
//! On Unix the limits are the kernel's: processor time and address space. Elsewhere a child is ended after [`MAX_WAIT`], and its memory has
//! no limit.

mod child;
mod parent;
mod protocol;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::OnceLock;
use std::time::Duration;

use serde::{Deserialize, Serialize};

pub(crate) use parent::{Stopped, compile};

/// The limits of one shader. The largest shader of the repository takes a hundredth of the default.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompileLimits {
    /// Seconds of processor time.
    pub seconds: u32,
    /// Bytes of address space, the compiler's own included.
    pub bytes: u64,
}

impl Default for CompileLimits {
    fn default() -> Self {
        Self { seconds: 10, bytes: 2 << 30 }
    }
}

/// Longest wait for a shader, also where the system counts no processor time, and however busy the machine is.
pub const MAX_WAIT: Duration = Duration::from_secs(120);

/// The only argument of a child.
const ARGUMENT: &str = "--raxel-shader-compiler";

/// The program of the children, and their limits.
struct Isolation {
    program: PathBuf,
    limits: CompileLimits,
}

static ISOLATION: OnceLock<Isolation> = OnceLock::new();

/// Compiles every shader of this process in children from now on. To be called first thing in `main`; when it gives an exit code, this
/// process is such a child, has done its work, and must end with it. A system that starts no processes leaves the work to this one.
#[must_use = "the process must end when there is an exit code"]
pub fn isolate() -> Option<ExitCode> {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().is_some_and(|argument| argument == ARGUMENT) && arguments.next().is_none() {
        return Some(child::serve());
    }
    // The link leads to this program also when its file has been replaced since.
    let link = PathBuf::from("/proc/self/exe");
    let program = if link.exists() { Some(link) } else { std::env::current_exe().ok() };
    if let Some(program) = program {
        isolate_by(program, CompileLimits::default());
    }
    None
}

/// The same for a program whose `main` belongs to something else: the children are `program`, which calls [`isolate`] and is built of the same
/// sources (the binary `raxel` is one). The first call of either function counts.
pub fn isolate_by(program: PathBuf, limits: CompileLimits) {
    let _ = ISOLATION.set(Isolation { program, limits });
}
