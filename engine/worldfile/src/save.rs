//! `[save]`: where edits of the world are kept.

use raxel_diagnostics::table::Node;
use raxel_diagnostics::{Spanned, codes, files};
use raxel_language::Keys;

/// Where edits of the world are saved.
#[derive(Clone, Debug, PartialEq, Keys)]
pub struct SaveSettings {
    /// The folder of the save, relative to the project.
    #[keys(read = folder)]
    pub path: Spanned<String>,
    /// Seconds of edits that a power cut may lose.
    #[keys(range = 0.001..=3600.0, default = 1.0)]
    pub sync: f64,
    /// The behaviour if the world file builds other voxels than when the save was made: `refuse` the save, or `keep` its chunks.
    #[keys(default = OnGeneratorChange::Refuse)]
    pub on_generator_change: OnGeneratorChange,
}

/// The behaviour when the world is built otherwise than when its save was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub enum OnGeneratorChange {
    /// The save is not opened.
    Refuse,
    /// The edited chunks stay as they are.
    Keep,
}

fn folder(node: &Node<'_, '_>) -> Option<Spanned<String>> {
    let text = node.string()?;
    let path = files::join("", &text).filter(|path| !path.is_empty());
    if path.is_none() {
        node.report(codes::files::OUTSIDE_ROOT, format!("`{text}` is not a folder inside the project"), "");
    }
    Some(Spanned::new(path?, node.span.clone()))
}
