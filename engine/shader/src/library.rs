//! The shader library that the binary brings along, so that a project works without a copy of it. A file of the same path in the
//! project's `shaders/include/` wins over the one in here.

/// Every file of the library: (name in `#include <…>`, text), in order of name.
pub const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/library_table.rs"));

/// The text of a library file, e.g. of `raxel/world.glsl`.
pub fn text(name: &str) -> Option<&'static str> {
    FILES.iter().find(|(file, _)| *file == name).map(|(_, text)| *text)
}

/// The template of `raxel/world/BINDING.glsl`; `NAME` in it stands for the name of the binding.
pub(crate) const WORLD_TEMPLATE: &str = "raxel/world/NAME.glsl";
const PLACEHOLDER: &str = "NAME";

/// The binding `pine` of `raxel/world/pine.glsl`, if that is what an include names.
pub(crate) fn world_binding(name: &str) -> Option<&str> {
    let (before, after) = WORLD_TEMPLATE.split_once(PLACEHOLDER)?;
    let binding = name.strip_prefix(before)?.strip_suffix(after)?;
    let first = binding.chars().next()?;
    let word = binding.chars().all(|c| c == '_' || c.is_ascii_alphanumeric());
    (word && !first.is_ascii_digit()).then_some(binding)
}

/// The text of `raxel/world/BINDING.glsl`.
pub(crate) fn for_binding(template: &str, binding: &str) -> String {
    template.replace(PLACEHOLDER, binding)
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
        assert!(super::text(super::WORLD_TEMPLATE).is_some());
    }

    #[test]
    fn a_world_is_included_by_the_name_of_its_binding() {
        assert_eq!(super::world_binding("raxel/world/pine_2.glsl"), Some("pine_2"));
        for other in
            ["raxel/world.glsl", "raxel/world/.glsl", "raxel/world/2.glsl", "raxel/world/a/b.glsl", "world/a.glsl"]
        {
            assert_eq!(super::world_binding(other), None, "{other}");
        }
        assert_eq!(super::for_binding("bool NAME_trace();", "pine"), "bool pine_trace();");
    }
}
