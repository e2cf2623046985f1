//! The shader library that the binary brings along, so that a project works without a copy of it. A file of the same path in the
//! project's `shaders/include/` wins over the one in here.

/// Every file of the library: (name in `#include <…>`, text), in order of name.
pub const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/library_table.rs"));

/// The text of a library file, e.g. of `raxel/world.glsl`.
pub fn text(name: &str) -> Option<&'static str> {
    FILES.iter().find(|(file, _)| *file == name).map(|(_, text)| *text)
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_are_what_includes_say() {
        for (name, text) in super::FILES {
            assert!(name.starts_with("raxel/") && !name.contains(['\\', '<']), "{name}");
            assert_eq!(super::text(name), Some(*text));
        }
        assert_eq!(super::text("raxel/none.glsl"), None);
    }
}
