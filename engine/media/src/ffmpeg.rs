//! ffmpeg and ffprobe, which read videos and sounds. Both are found on the path.

use std::io::{ErrorKind, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// The longest time to decode a file.
const PATIENCE: Duration = Duration::from_secs(30);

/// Longest answer of ffprobe, in bytes.
const MOST_SAID: u64 = 1 << 16;

/// Options that read a file: no file leads to another one or to the network, as a list of files would.
pub(crate) const LOCAL: [&str; 4] =
    ["-protocol_whitelist", "file", "-format_whitelist", "mov,matroska,avi,gif,wav,w64,mp3,ogg,flac,aac,aiff,asf"];

/// Whether a name has one of these endings, which are lower case.
pub(crate) fn ends_in(path: &str, extensions: &[&str]) -> bool {
    let extension = path.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase());
    extension.is_some_and(|extension| extensions.contains(&extension.as_str()))
}

/// ffprobe's answer about a stream, a line for each entry: `name=value`.
pub(crate) fn probe(disk: &Path, stream: &str, more: &[&str], entries: &str) -> Result<String, String> {
    let mut command = Command::new("ffprobe");
    command.args(["-v", "error"]).args(LOCAL).args(["-select_streams", stream]).args(more);
    command.args(["-show_entries", entries, "-of", "default=noprint_wrappers=1"]).arg(disk);
    let output = run("ffprobe", command, MOST_SAID, PATIENCE)?;
    let said = String::from_utf8_lossy(&output.bytes).into_owned();
    if said.is_empty() && !output.error.is_empty() {
        return Err(format!("ffprobe says: {}", output.error));
    }
    Ok(said)
}

/// The output of ffmpeg for a file, at most this number of bytes.
pub(crate) fn decode(disk: &Path, form: &[&str], most: u64) -> Result<Vec<u8>, String> {
    let mut command = Command::new("ffmpeg");
    command.args(["-hide_banner", "-v", "error", "-nostdin"]).args(LOCAL).arg("-i").arg(disk).args(form).arg("-");
    let output = run("ffmpeg", command, most, PATIENCE)?;
    if output.bytes.is_empty() && !output.error.is_empty() {
        return Err(format!("ffmpeg says: {}", output.error));
    }
    Ok(output.bytes)
}

/// Why a program cannot be started.
pub(crate) fn missing(program: &str, error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => format!("{program} is not installed; `apt-get install ffmpeg`"),
        _ => format!("{program} cannot be started: {error}"),
    }
}

/// The output of a program.
struct Output {
    bytes: Vec<u8>,
    /// The end of the first line on stderr, behind its last colon.
    error: String,
}

/// Runs a program until it ends, has written `most` bytes, or has taken too long.
fn run(program: &str, mut command: Command, most: u64, patience: Duration) -> Result<Output, String> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| missing(program, &error))?;
    let (sender, received) = channel();
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    let read = move || {
        let errors = std::thread::spawn(move || {
            let (mut said, mut pipe) = (Vec::new(), stderr?);
            pipe.by_ref().take(MOST_SAID).read_to_end(&mut said).ok()?;
            // A program that finds its pipe full would wait for ever.
            std::io::copy(&mut pipe, &mut std::io::sink()).ok()?;
            Some(said)
        });
        let mut bytes = Vec::new();
        let read = stdout.map_or(Ok(0), |pipe| pipe.take(most).read_to_end(&mut bytes));
        // The listener may be gone.
        let _ = sender.send(read.map(|_| bytes));
        errors.join().ok().flatten().unwrap_or_default()
    };
    let reader = std::thread::Builder::new().name("raxel-ffmpeg".to_owned()).spawn(read);
    let read = match &reader {
        Ok(_) => received.recv_timeout(patience),
        Err(_) => Err(RecvTimeoutError::Disconnected),
    };
    // It has ended by itself, or the rest is not needed.
    let _ = child.kill();
    let _ = child.wait();
    let bytes = match read {
        Ok(read) => read.map_err(|error| error.to_string())?,
        Err(RecvTimeoutError::Timeout) => return Err(format!("{program} took longer than {} s", patience.as_secs())),
        Err(RecvTimeoutError::Disconnected) => return Err(format!("{program} cannot be read")),
    };
    let said = reader.ok().and_then(|reader| reader.join().ok()).unwrap_or_default();
    let said = String::from_utf8_lossy(&said);
    let error = said.lines().next().map_or("", |line| line.rsplit_once(": ").map_or(line, |(_, why)| why)).to_owned();
    Ok(Output { bytes, error })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn a_program_that_is_stuck_is_ended() {
        let error = run("sh", shell("echo a; exec sleep 600"), 100, Duration::from_millis(200)).err();
        assert_eq!(error.as_deref(), Some("sh took longer than 0 s"));
        let error = run("sh", Command::new("/nowhere/at/all"), 100, PATIENCE).err().unwrap();
        assert!(error.starts_with("sh is not installed"), "{error}");
    }

    #[test]
    fn what_a_program_writes_without_end_is_cut() {
        let output = run("sh", shell("exec yes"), 100, PATIENCE).unwrap();
        assert_eq!((output.bytes.len(), output.error.as_str()), (100, ""));
        let errors = "i=0; while [ $i -lt 20000 ]; do echo \"a.wav: line $i\" >&2; i=$((i+1)); done; echo b";
        let output = run("sh", shell(errors), 100, PATIENCE).unwrap();
        assert_eq!((output.bytes.as_slice(), output.error.as_str()), (b"b\n".as_slice(), "line 0"));
    }
}
