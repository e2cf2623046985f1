//! Tables that are laid over equal ones of another file: `extends`.

use raxel_diagnostics::names::closest;
use raxel_diagnostics::table::Table;
use raxel_diagnostics::{Code, Diagnostic, Spanned, codes};

/// Things that can be laid over an equal thing of the base, by name.
pub trait Layer {
    /// Its name, for messages.
    const WHAT: &'static str;
    /// Code of the message that the base has no table of this name.
    const UNKNOWN: Code;

    /// Its name.
    fn name(&self) -> &Spanned<String>;

    /// Whether it takes its equal out of the base.
    fn removed(&self) -> bool;

    /// Checks a table that is new over the base.
    fn added(&self, _: &mut Vec<Diagnostic>) {}

    /// Puts `above` over this.
    fn cover(&mut self, above: Self, found: &mut Vec<Diagnostic>);
}

/// A name with a value: that of the file on top counts.
impl<T> Layer for (Spanned<String>, T) {
    const WHAT: &'static str = "value";
    const UNKNOWN: Code = codes::graph::NOTHING_TO_OVERLAY;

    fn name(&self) -> &Spanned<String> {
        &self.0
    }

    fn removed(&self) -> bool {
        false
    }

    fn cover(&mut self, above: Self, _: &mut Vec<Diagnostic>) {
        *self = above;
    }
}

/// Lays things over those of the base, by name.
pub fn merge<T: Layer>(below: &mut Vec<T>, above: Vec<T>, found: &mut Vec<Diagnostic>) {
    for item in above {
        let same = below.iter().position(|other| other.name().value == item.name().value);
        match (same, item.removed()) {
            (Some(index), true) => drop(below.remove(index)),
            (Some(index), false) => below[index].cover(item, found),
            (None, false) => {
                item.added(found);
                below.push(item);
            }
            (None, true) => {
                let known = below.iter().map(|other| &other.name().value[..]);
                found.push(unknown(T::WHAT, T::UNKNOWN, item.name(), known));
            }
        }
    }
}

/// Lays a key over that of the base.
pub fn replace<T>(below: &mut Option<T>, above: Option<T>) {
    if above.is_some() {
        *below = above;
    }
}

/// Lays a table over that of the base.
pub fn cover<T: Layer>(below: &mut Option<T>, above: Option<T>, found: &mut Vec<Diagnostic>) {
    match (below, above) {
        (Some(below), Some(above)) => below.cover(above, found),
        (below, above) => replace(below, above),
    }
}

/// The diagnostic for a name that the base does not have.
pub fn unknown<'n>(what: &str, code: Code, name: &Spanned<String>, known: impl Iterator<Item = &'n str>) -> Diagnostic {
    let diagnostic = Diagnostic::error(code, format!("the base has no {what} `{}`", name.value))
        .label(name.span.clone(), format!("no such {what}"));
    match closest(&name.value, known) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None => diagnostic,
    }
}

/// Whether the table has `remove = true`, which may stand beside no keys but `beside`.
pub fn removes(table: &Table<'_, '_>, beside: &[&str]) -> bool {
    let Some(node) = table.get("remove") else { return false };
    let removed = node.boolean() == Some(true);
    if removed {
        for (key, other) in table.entries() {
            if !beside.contains(&key.as_str()) {
                table.reporter().report(
                    Diagnostic::error(
                        codes::files::CONFLICTING_KEYS,
                        format!("`{key}` and `remove` exclude each other: a removed entry has no `{key}`"),
                    )
                    .label(other.key_span, "this one")
                    .label(node.key_span.clone(), "and this one"),
                );
            }
        }
    }
    removed
}
