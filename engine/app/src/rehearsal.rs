//! HLSL is compiled in a child process first: this binary again, called with a word that is no verb.

use std::io::{Read, Write};
use std::process::{Command, ExitCode, Stdio};

const WORD: &str = "rehearse-hlsl";

/// Makes this process outlive any HLSL.
pub(crate) fn install() {
    raxel_shader::rehearse_hlsl_with(in_a_child);
}

/// The child's whole run, if this process is one.
pub(crate) fn of_this_process() -> Option<ExitCode> {
    let mut arguments = std::env::args().skip(1);
    if arguments.next().as_deref() != Some(WORD) {
        return None;
    }
    let entry = arguments.next().unwrap_or_default();
    let mut text = String::new();
    if std::io::stdin().read_to_string(&mut text).is_ok() {
        raxel_shader::rehearse_hlsl(&entry, &text);
    }
    Some(ExitCode::SUCCESS)
}

fn in_a_child(entry: &str, text: &str) -> bool {
    let Ok(program) = std::env::current_exe() else { return true };
    let mut command = Command::new(program);
    command.args([WORD, entry]).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
    // A system that starts no process leaves the text to this one.
    let Ok(mut child) = command.spawn() else { return true };
    if let Some(mut input) = child.stdin.take() {
        // It fails when the child is gone already, which its exit status says better.
        let _ = input.write_all(text.as_bytes());
    }
    child.wait().is_ok_and(|status| status.success())
}
