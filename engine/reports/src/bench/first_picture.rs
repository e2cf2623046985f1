//! From the start of the program to its first picture: once with nothing kept from earlier runs, and again.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use raxel_gpu::DeviceOptions;
use raxel_measure::Times;
use raxel_terminal::args::Size;
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::session::What;

/// Starts of each kind.
const STARTS: usize = 3;

/// Times from the start of a process to the written picture.
pub(super) struct FirstPicture {
    /// Neither this program nor the driver has compiled anything before.
    pub fresh: Times,
    /// The same start once more.
    pub again: Times,
}

/// Starts this program over and over, with caches of its own below `scratch`.
pub(super) fn first_picture(what: &What, size: Size, device: &DeviceOptions, scratch: &Path) -> Result<FirstPicture> {
    let mut times = FirstPicture { fresh: Times::default(), again: Times::default() };
    for start in 0..STARTS {
        let caches = scratch.join(format!("caches-{start}"));
        times.fresh.milliseconds.push(render(what, size, device, scratch, &caches)?);
        times.again.milliseconds.push(render(what, size, device, scratch, &caches)?);
    }
    Ok(times)
}

/// Renders one picture in a process of its own; milliseconds.
fn render(what: &What, size: Size, device: &DeviceOptions, scratch: &Path, caches: &Path) -> Result<f64> {
    let failed = |reason: String| Failure::new(Exit::Check, format!("the first picture: {reason}"));
    let unable = |error: std::io::Error| failed(error.to_string());
    let driver = caches.join("driver");
    fs::create_dir_all(&driver).map_err(unable)?;
    let mut command = Command::new(std::env::current_exe().map_err(unable)?);
    command.arg("render").arg("-o").arg(scratch.join("first.png"));
    command.args(["--size", &format!("{}x{}", size.0[0], size.0[1])]);
    command.args(&what.file);
    if what.is_demo() {
        command.args(["--at", "0s"]);
    }
    for (option, value) in [
        ("--world", what.world.as_ref().map(|path| path.as_os_str())),
        ("--device", device.device.as_ref().map(AsRef::as_ref)),
    ] {
        if let Some(value) = value {
            command.arg(option).arg(value);
        }
    }
    // The drivers' own caches count as kept: Mesa's, and NVIDIA's.
    command.env(raxel_cache::SWITCH, caches.join("raxel"));
    command.env("MESA_SHADER_CACHE_DIR", &driver).env("__GL_SHADER_DISK_CACHE_PATH", &driver);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let start = Instant::now();
    let output = command.output().map_err(unable)?;
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    if output.status.success() {
        Ok(milliseconds)
    } else {
        Err(failed(String::from_utf8_lossy(&output.stderr).into_owned()))
    }
}
