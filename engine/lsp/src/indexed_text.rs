//! A text with what was read from it: names, locals, declarations, includes, words of TOML. Each is read at its first use, and kept as long as the
//! text stays the same.

use std::collections::HashMap;
use std::ops::{Deref, Range};
use std::sync::OnceLock;

use super::glsl::{Declaration, declarations, without_comments};
use super::scopes::{Local, code_of, identifiers, locals};
use super::toml_names::{TomlWord, words};

/// A text of a project or of the shader library.
#[derive(Debug, Default)]
pub(super) struct IndexedText {
    text: String,
    code: OnceLock<String>,
    names: OnceLock<HashMap<String, Vec<NamePlace>>>,
    locals: OnceLock<Vec<Local>>,
    declarations: OnceLock<Vec<Declaration>>,
    includes: OnceLock<Vec<String>>,
    words: OnceLock<Vec<TomlWord>>,
}

/// Where a name stands in a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct NamePlace {
    pub place: Range<usize>,
    /// It stands behind a dot.
    pub is_member: bool,
    /// It stands in a line of the preprocessor.
    pub in_directive: bool,
}

impl IndexedText {
    pub(crate) fn new(text: String) -> Self {
        Self { text, ..Self::default() }
    }

    /// The code of a shader without comments and directives, of the same length.
    pub(crate) fn code(&self) -> &str {
        self.code.get_or_init(|| code_of(&self.text))
    }

    /// Every place of a name in a shader, in order. Comments and the names of included files are left out.
    pub(crate) fn places(&self, name: &str) -> &[NamePlace] {
        self.names.get_or_init(|| self.read_names()).get(name).map_or(&[], Vec::as_slice)
    }

    /// The parameters and locals of a shader.
    pub(crate) fn locals(&self) -> &[Local] {
        self.locals.get_or_init(|| locals(self.code()))
    }

    /// The declarations of a shader outside of its functions.
    pub(crate) fn declarations(&self) -> &[Declaration] {
        self.declarations.get_or_init(|| declarations(&self.text))
    }

    /// The files that a shader includes, as it writes them.
    pub(crate) fn includes(&self) -> &[String] {
        self.includes.get_or_init(|| self.text.lines().filter_map(include).map(str::to_owned).collect())
    }

    /// Every key and text of a TOML file.
    pub(crate) fn words(&self) -> &[TomlWord] {
        self.words.get_or_init(|| words(&self.text))
    }

    fn read_names(&self) -> HashMap<String, Vec<NamePlace>> {
        let blank = |line: &str| match include(line) {
            Some(_) => " ".repeat(line.len()),
            None => line.to_owned(),
        };
        let with_macros: String = without_comments(&self.text).split_inclusive('\n').map(blank).collect();
        let code = self.code();
        let mut found: HashMap<String, Vec<NamePlace>> = HashMap::new();
        for (name, place, is_member) in identifiers(&with_macros) {
            let in_directive = code.get(place.clone()) != Some(name);
            found.entry(name.to_owned()).or_default().push(NamePlace { place, is_member, in_directive });
        }
        found
    }
}

impl Deref for IndexedText {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

/// The file that a line includes.
fn include(line: &str) -> Option<&str> {
    let rest = line.trim_start().strip_prefix("#include")?.trim();
    let inner = rest.strip_prefix('"').or_else(|| rest.strip_prefix('<'))?;
    inner.split(['"', '>']).next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_with_their_places() {
        let text = "#include <sum/sum.glsl>\n#define TWICE(x) sum(x) // sum\nfloat a = sum(b.sum);\n";
        let found = IndexedText::new(text.to_owned());
        let sums = found.places("sum");
        assert!(sums.iter().all(|sum| &text[sum.place.clone()] == "sum"));
        let kinds: Vec<_> = sums.iter().map(|sum| (sum.in_directive, sum.is_member)).collect();
        assert_eq!(kinds, [(true, false), (false, false), (false, true)]);
        assert_eq!(found.includes(), ["sum/sum.glsl"]);
        assert_eq!(found.places("glsl"), []);
    }
}
