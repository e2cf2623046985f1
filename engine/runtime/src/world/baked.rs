//! Worlds that were baked: the sources of streamed worlds that come from stores.

use std::path::Path;
use std::sync::Arc;

use raxel_bake::{OpenError, SourceError, ZarrSource};
use raxel_diagnostics::{Diagnostic, Files, codes};
use raxel_world::ChunkProvider;

/// Opens the store at an address, which is relative to the folder of the project when it is a folder.
pub(super) fn open(address: &str, files: &dyn Files) -> Result<Arc<dyn ChunkProvider>, Box<Diagnostic>> {
    let source = ZarrSource::open(address, files.root().unwrap_or(Path::new(".")));
    source.map(|source| Arc::new(source) as _).map_err(|error| Box::new(refused(&error)))
}

fn refused(error: &SourceError) -> Diagnostic {
    match error {
        SourceError::Open(error) => store_refused(error),
        SourceError::Store { .. } => Diagnostic::error(codes::world::STORE_FAILING, error.to_string()),
        SourceError::Nothing { .. } => Diagnostic::error(codes::world::STORE_UNREADABLE, error.to_string())
            .help("`raxel world bake WORLD --out ADDRESS` bakes a world"),
        SourceError::Unreadable { .. } => Diagnostic::error(codes::world::STORE_UNREADABLE, error.to_string()),
    }
}

/// Why no store can be opened at an address.
pub fn store_refused(error: &OpenError) -> Diagnostic {
    let diagnostic = Diagnostic::error(codes::world::STORE_ADDRESS, error.to_string());
    match error {
        OpenError::NeedsCloud(_) => diagnostic
            .help("`cargo build --release --features cloud`, or RAXEL_FEATURES=cloud ./raxel, builds one with it"),
        OpenError::Unknown(_) | OpenError::Failed { .. } => diagnostic,
    }
}
