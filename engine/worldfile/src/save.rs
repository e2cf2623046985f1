//! `[save]`: where edits of the world are kept.

use std::time::Duration;

use raxel_diagnostics::table::Table;
use raxel_diagnostics::{Span, codes, files};

/// Where and how edits are saved.
#[derive(Clone, Debug, PartialEq)]
pub struct SaveSettings {
    /// Project path of the folder.
    pub path: String,
    /// Where that is written.
    pub place: Span,
    /// Time after which an edit is on the disk, even if the power fails.
    pub sync: Duration,
    /// What happens when the world is built otherwise than when the save was made.
    pub on_generator_change: OnGeneratorChange,
}

/// What happens when the world is built otherwise than when its save was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnGeneratorChange {
    /// The save is not opened.
    Refuse,
    /// The edited chunks stay as they are.
    Keep,
}

pub(super) fn read(table: &Table<'_, '_>) -> Option<SaveSettings> {
    let folder = table.need("path").and_then(|node| {
        let text = node.string()?;
        let path = files::join("", &text).filter(|path| !path.is_empty());
        if path.is_none() {
            node.report(codes::files::OUTSIDE_ROOT, format!("`{text}` is not a folder inside the project"), "");
        }
        Some((path?, node.span.clone()))
    });
    let sync = table.get("sync").map_or(Some(1.0), |node| node.number(0.001..=3600.0));
    let words = [("refuse", OnGeneratorChange::Refuse), ("keep", OnGeneratorChange::Keep)];
    let change = table.get("on_generator_change").map_or(Some(OnGeneratorChange::Refuse), |node| node.word(&words));
    table.finish();
    let (path, place) = folder?;
    Some(SaveSettings { path, place, sync: Duration::from_secs_f64(sync?), on_generator_change: change? })
}
