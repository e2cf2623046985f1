//! The outline of a document: the tables of a TOML file, the declarations of a shader.

use std::ops::Range;

use lsp_types::{CompletionItemKind, DocumentSymbol, SymbolKind};

use super::documents::{self, Document};
use super::glsl::{Declaration, DeclarationKind};
use super::names::{declared, named_passes};

/// The declarations of a document, in its order.
pub(super) fn symbols(document: &Document) -> Vec<DocumentSymbol> {
    let text = &document.text;
    if !document.is_toml() {
        let symbol =
            |found: &Declaration| symbol(text, &found.name, symbol_kind(found.kind), &found.whole, &found.place);
        return text.declarations().iter().map(symbol).collect();
    }
    let kinds =
        ["params", "clocks", "targets", "buffers", "blocks", "loops", "materials", "models", "cameras", "tracks"];
    let tables = kinds
        .iter()
        .flat_map(|kind| declared(text, kind).into_iter().map(|(name, place)| (name, SymbolKind::VARIABLE, place)));
    let passes = named_passes(text).into_iter().map(|(name, place)| (name, SymbolKind::FUNCTION, place));
    let mut found: Vec<_> = tables.chain(passes).collect();
    found.sort_by_key(|(_, _, place)| place.start);
    found.into_iter().map(|(name, kind, place)| symbol(text, name, kind, &place, &place)).collect()
}

#[expect(deprecated, reason = "the struct has a field that nobody may fill, and no constructor")]
fn symbol(text: &str, name: &str, kind: SymbolKind, whole: &Range<usize>, place: &Range<usize>) -> DocumentSymbol {
    DocumentSymbol {
        name: name.to_owned(),
        detail: None,
        kind,
        tags: None,
        deprecated: None,
        range: documents::range(text, whole),
        selection_range: documents::range(text, place),
        children: None,
    }
}

fn symbol_kind(kind: DeclarationKind) -> SymbolKind {
    match kind {
        DeclarationKind::Function => SymbolKind::FUNCTION,
        DeclarationKind::Struct => SymbolKind::STRUCT,
        DeclarationKind::Push | DeclarationKind::Binding => SymbolKind::INTERFACE,
        DeclarationKind::Constant => SymbolKind::CONSTANT,
    }
}

/// The same kind, where a name is completed.
pub(super) fn completion_kind(kind: DeclarationKind) -> CompletionItemKind {
    match kind {
        DeclarationKind::Function => CompletionItemKind::FUNCTION,
        DeclarationKind::Struct => CompletionItemKind::STRUCT,
        DeclarationKind::Push | DeclarationKind::Binding => CompletionItemKind::INTERFACE,
        DeclarationKind::Constant => CompletionItemKind::CONSTANT,
    }
}
