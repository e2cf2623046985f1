//! Reads the lines of the program ahead, up to a limit: then the pipe fills, and the program waits.

use std::io::{self, BufRead, Read};
use std::sync::mpsc::{Receiver, sync_channel};

use super::refusal::Refusal;

/// Lines that are read ahead.
const AHEAD: usize = 16;

/// Most bytes of a line, without its end.
const LONGEST: u64 = 4 << 20;

/// Reads lines on another thread, and calls `wake` there after each line and at the end. A line that cannot be a request is a refusal.
pub(super) fn listen(
    mut input: impl BufRead + Send + 'static,
    wake: impl Fn() + Send + 'static,
) -> Receiver<Result<String, Refusal>> {
    let (sender, lines) = sync_channel(AHEAD);
    std::thread::spawn(move || {
        // An input that cannot be read has ended.
        while let Ok(Some(line)) = next(&mut input) {
            if sender.send(line).is_err() {
                return;
            }
            wake();
        }
        drop(sender);
        wake();
    });
    lines
}

/// The next line; `None` at the end.
fn next(input: &mut impl BufRead) -> io::Result<Option<Result<String, Refusal>>> {
    let mut line = Vec::new();
    input.take(LONGEST + 1).read_until(b'\n', &mut line)?;
    if line.is_empty() {
        return Ok(None);
    }
    if line.len() as u64 > LONGEST && !line.ends_with(b"\n") {
        input.skip_until(b'\n')?;
        let help = vec!["split it into several requests".to_owned()];
        return Ok(Some(Err(Refusal { error: format!("the line has more than {LONGEST} bytes"), help })));
    }
    Ok(Some(String::from_utf8(line).map_err(|_| Refusal::new("the line is not UTF-8"))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_is_too_long_is_refused_and_the_next_is_read() {
        let long = |bytes: u64| vec![b' '; usize::try_from(bytes).unwrap()];
        let text = [&long(LONGEST)[..], b"\n", &long(3 * LONGEST), b"\n\xff\n{}\n[]"].concat();
        let mut input = text.as_slice();
        let mut line = || next(&mut input).unwrap();
        assert_eq!(line().unwrap().unwrap().len() as u64, LONGEST + 1);
        let refusal = line().unwrap().unwrap_err();
        assert_eq!(refusal.error, "the line has more than 4194304 bytes");
        assert_eq!(line().unwrap().unwrap_err().error, "the line is not UTF-8");
        assert_eq!([line().unwrap().unwrap(), line().unwrap().unwrap()], ["{}\n", "[]"]);
        assert_eq!(line(), None);
    }
}
