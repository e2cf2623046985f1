//! What a declaration gives: readers with all their messages, schemas, lists of keys, merges.

mod forms;
mod layers;
mod rooms;

use raxel_diagnostics::table::read_document;
use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_language::ReadKeys;

fn read<T: ReadKeys>(text: &str) -> Result<T, Vec<Diagnostic>> {
    read_document("f.toml", text, &mut SourceMap::default(), |root| T::read_whole(root, &())).map(|(value, _)| value)
}

fn messages<T: ReadKeys>(text: &str) -> Vec<String> {
    match read::<T>(text) {
        Ok(_) => Vec::new(),
        Err(found) => found.into_iter().map(|found| found.message).collect(),
    }
}
