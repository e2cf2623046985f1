//! Every code, by range. The range shows which part of raxel found the error.

/// `RX00xx`: files and TOML (missing, unreadable, not UTF-8, syntax, unknown key, wrong type).
pub mod files;
/// `RX01xx`: the graph (names, bindings, push layouts, sizes, dispatch, order).
pub mod graph;
/// `RX04xx`: projects, demos, command line, device.
pub mod session;
/// `RX02xx`: shaders (include, compile, SPIR-V, reflection).
pub mod shader;
/// `RX03xx`: worlds and models.
pub mod world;

/// Every code with its page, in order.
pub fn all() -> impl Iterator<Item = (crate::Code, &'static str)> {
    [files::ALL, graph::ALL, shader::ALL, world::ALL, session::ALL].into_iter().flatten().copied()
}

/// The page of a code, in Markdown: what `raxel explain` prints. Upper and lower case are the same.
pub fn explain(code: &str) -> Option<&'static str> {
    all().find(|(known, _)| known.as_str().eq_ignore_ascii_case(code.trim())).map(|(_, page)| page)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn every_page_has_a_code_and_a_title() {
        let mut declared = BTreeSet::new();
        for (code, page) in super::all() {
            assert!(declared.insert(format!("{code}.md")), "{code} is declared twice");
            let title = page.lines().next().unwrap_or_default();
            assert!(title.starts_with(&format!("# {code}: ")), "{code}: {title:?}");
            assert!(page.lines().count() > 2, "{code} says nothing");
        }
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/errors");
        for entry in std::fs::read_dir(folder).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let index = name == "README.md";
            assert!(index || declared.contains(&name), "docs/errors/{name} is the page of no code");
        }
    }

    #[test]
    fn explains_in_any_case() {
        assert!(super::explain("rx0011").unwrap().starts_with("# RX0011: "));
        assert_eq!(super::explain("RX9999"), None);
    }
}
