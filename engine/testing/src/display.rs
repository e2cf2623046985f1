//! A screen without a monitor, for tests of windows.

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::child::{LIMIT, Running, Said, line, output};

/// A display with no window manager: the window is at the top left.
pub struct Display {
    xvfb: Running,
    /// The value of `DISPLAY`.
    pub name: String,
    frame_buffer: tempfile::TempDir,
}

impl Display {
    /// Starts one; it ends with the test.
    pub fn start() -> Self {
        let frame_buffer = tempfile::tempdir().unwrap();
        // ./raxel test installs it.
        let mut xvfb = Running::start(
            Command::new("Xvfb")
                // When its last client goes, a server that resets drops every client that connects at that moment.
                .args(["-noreset", "-displayfd", "1", "-screen", "0", "640x480x24", "-nolisten", "tcp", "-fbdir"])
                .arg(frame_buffer.path())
                .stdout(Stdio::piped())
                .stderr(Stdio::null()),
        );
        // It writes its number when it is ready.
        let number = Said::by(xvfb.0.stdout.take().unwrap(), line).next();
        Self { xvfb, name: format!(":{}", number.trim()), frame_buffer }
    }

    /// Ends the server under its clients.
    pub fn end(&mut self) {
        self.xvfb.0.kill().expect("it runs");
        self.xvfb.finish();
    }

    /// The top left of the screen: red, green, blue of each pixel. The file has the format of xwd.
    pub fn pixels(&self, width: usize, height: usize) -> Vec<[u8; 3]> {
        let file = fs::read(self.frame_buffer.path().join("Xvfb_screen0")).unwrap();
        let word = |i: usize| u32::from_be_bytes(file[i * 4..i * 4 + 4].try_into().unwrap()) as usize;
        let (header, bits, line, colors) = (word(0), word(11), word(12), word(19));
        assert_eq!(bits, 32);
        let start = header + colors * 12;
        let pixel = |x: usize, y: usize| {
            let at = start + y * line + x * 4;
            [file[at + 2], file[at + 1], file[at]]
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
    }

    /// Runs xdotool on it, and returns its output.
    pub fn xdotool(&self, arguments: &[&str]) -> String {
        // ./raxel test installs it.
        let output = output(Command::new("xdotool").args(arguments).env("DISPLAY", &self.name));
        String::from_utf8(output.stdout).unwrap()
    }
}

/// Waits until something holds.
#[track_caller]
pub fn eventually(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < LIMIT, "{what}: not within {} s", LIMIT.as_secs());
        std::thread::sleep(Duration::from_millis(50));
    }
}
