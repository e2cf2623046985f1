//! `raxel explain CODE`: the page of a diagnostic, compiled in from `docs/errors/`.

use raxel_diagnostics::codes;
use raxel_diagnostics::names::closest;
use raxel_terminal::args::Messages;
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Failure, Result};
use serde_json::json;

/// Explains a diagnostic's code, or lists every code.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel explain RX0011")]
pub(crate) struct Args {
    /// The code, e.g. RX0011 (`11` will do). Without one, every code is listed.
    code: Option<String>,

    #[command(flatten)]
    pub messages: Messages,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    let Some(asked) = &args.code else {
        for (code, page) in codes::all() {
            match console.format() {
                Format::Json => console::json(&json!({ "code": code, "title": title(page) })),
                _ => console::data(&format!("{code}  {}\n", title(page))),
            }
        }
        return Ok(());
    };
    let wanted = normalise(asked);
    let Some((code, page)) = codes::all().find(|(code, _)| code.as_str() == wanted) else {
        let failure = Failure::usage(format!("there is no diagnostic `{asked}`"));
        return Err(match closest(&wanted, codes::all().map(|(code, _)| code.as_str())) {
            Some(code) => failure.help(format!("did you mean `{code}`?")),
            None => failure.help("`raxel explain` lists every code"),
        });
    };
    match console.format() {
        Format::Json => console::json(&json!({ "code": code, "title": title(page), "page": page })),
        _ => console::data(&format!("{}\n", page.trim_end())),
    }
    Ok(())
}

/// `11`, `rx11` and `RX0011` are the same code.
fn normalise(asked: &str) -> String {
    let upper = asked.trim().to_uppercase();
    let digits = upper.strip_prefix("RX").unwrap_or(&upper);
    if !digits.is_empty() && digits.len() <= 4 && digits.bytes().all(|b| b.is_ascii_digit()) {
        format!("RX{digits:0>4}")
    } else {
        upper
    }
}

/// The heading of a page without its code.
fn title(page: &str) -> &str {
    let heading = page.lines().next().unwrap_or_default().trim_start_matches('#').trim();
    heading.split_once(": ").map_or(heading, |(_, title)| title)
}

#[cfg(test)]
mod tests {
    use super::normalise;

    #[test]
    fn codes_may_be_written_short() {
        for asked in ["11", "0011", "rx11", "RX0011", " Rx0011 "] {
            assert_eq!(normalise(asked), "RX0011");
        }
        assert_eq!(normalise("hello"), "HELLO");
        assert_eq!(normalise("RX00111"), "RX00111");
    }
}
