//! Events of the files while the window was open, reported once each on stderr.

use raxel_runtime::FrameError;
use raxel_runtime::reload::ReloadEvent;
use raxel_terminal::console::{self, Console, Format, To};
use serde_json::json;

/// The effect of the loss of a device on the state of a graph.
pub(super) const STARTED_OVER: &str = "targets and buffers start over at `init`, histories and simulations with them";

/// Reports the events and keeps the title's part of them.
pub(crate) struct ReloadLog<'a> {
    console: &'a Console,
    /// Generation that runs.
    pub shown: u64,
    /// A newer generation that is wrong.
    pub failed: Option<u64>,
}

impl<'a> ReloadLog<'a> {
    /// Nothing has happened yet.
    pub(crate) fn new(console: &'a Console) -> Self {
        Self { console, shown: 0, failed: None }
    }

    /// Something happened.
    pub(crate) fn tell(&mut self, event: &ReloadEvent) {
        let json = self.console.format() == Format::Json;
        match event {
            ReloadEvent::Reloaded(reloaded) => {
                (self.shown, self.failed) = (reloaded.generation, None);
                self.console.diagnostics(&reloaded.diagnostics, &reloaded.texts, To::Stderr);
                if json {
                    return console::event(&json!({
                        "reason": "reloaded",
                        "generation": reloaded.generation,
                        "changed": reloaded.changed,
                        "opened": reloaded.opened,
                        "milliseconds": reloaded.milliseconds,
                        "kept": reloaded.resources.kept,
                        "created": reloaded.resources.created,
                        "dropped": reloaded.resources.dropped,
                    }));
                }
                self.console.message(&format!(
                    "{} {} in {:.0} ms, gen {}",
                    if reloaded.opened { "opened" } else { "reloaded" },
                    reloaded.changed.join(", "),
                    reloaded.milliseconds,
                    reloaded.generation
                ));
                let resources = &reloaded.resources;
                if !resources.created.is_empty() || !resources.dropped.is_empty() {
                    self.console.detail(&format!(
                        "kept: {}; new: {}; gone: {}",
                        list(&resources.kept),
                        list(&resources.created),
                        list(&resources.dropped)
                    ));
                }
            }
            ReloadEvent::Failed(failed) => {
                self.failed = Some(failed.generation);
                self.console.diagnostics(&failed.diagnostics, &failed.texts, To::Stderr);
                if json {
                    return console::event(&json!({
                        "reason": "reload-failed",
                        "generation": failed.generation,
                        "showing": self.shown,
                        "changed": failed.changed,
                    }));
                }
                self.console.message(&format!("gen {} failed: showing gen {}", failed.generation, self.shown));
            }
            ReloadEvent::HistoryCleared { size, resources } => {
                if json {
                    return console::event(
                        &json!({ "reason": "history-cleared", "size": size, "resources": resources }),
                    );
                }
                self.console.message(&format!("note: {}", history_cleared(*size, resources)));
            }
            // The window shows the mistakes, too, and the device of the files that run then.
            ReloadEvent::NotOpened(_) | ReloadEvent::Opened => {}
            ReloadEvent::DeviceRebuilt { suspect, off, milliseconds } => {
                let fate = fate(suspect.as_deref(), *off);
                self.console.message(&format!(
                    "the device was lost and is open again after {milliseconds:.0} ms{fate}; {STARTED_OVER}"
                ));
            }
        }
    }

    /// A debug target or size that no plan can be made for.
    pub(crate) fn refused(&self, error: &FrameError) {
        if let FrameError::Plan { diagnostics, texts } = error {
            self.console.diagnostics(diagnostics, texts, To::Stderr);
        }
    }
}

/// The effect of another size, in words.
pub(super) fn history_cleared([width, height]: [u32; 2], resources: &[String]) -> String {
    let verb = if resources.len() == 1 { "starts" } else { "start" };
    format!("at {width}×{height} the history of {} {verb} over", list(resources))
}

/// The fate of the pass that a device was lost with, to follow other words.
fn fate(suspect: Option<&str>, off: bool) -> String {
    match suspect {
        Some(pass) if off => {
            format!("; pass `{pass}` is switched off until its shader or its part of the graph changes")
        }
        Some(pass) => format!("; pass `{pass}` runs as it is now"),
        None => String::new(),
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
