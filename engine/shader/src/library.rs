//! The shader library that the binary brings along, so that a project works without a copy of it. A file of the same path in the
//! project's `shaders/include/` wins over the one in here.

/// Every file of the library: (name in `#include <…>`, text), in order of name.
pub const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/library_table.rs"));

/// The text of a library file, e.g. of `raxel/world.glsl`.
pub fn text(name: &str) -> Option<&'static str> {
    FILES.iter().find(|(file, _)| *file == name).map(|(_, text)| *text)
}

/// The purpose of a library file: the first sentence of its text, without the full stop.
pub fn purpose(text: &str) -> String {
    let comment = text.lines().map_while(|line| line.strip_prefix("// "));
    let paragraph = comment.collect::<Vec<_>>().join(" ");
    // A full stop ends a sentence where a capital or a name follows it.
    let end = paragraph
        .match_indices(". ")
        .map(|(at, _)| at)
        .find(|at| paragraph[at + 2..].starts_with(|c: char| c.is_uppercase() || c == '`'));
    paragraph[..end.unwrap_or(paragraph.len())].trim_end_matches(['.', ':']).to_owned()
}

/// Whether shaders have no business with a file: other files of the library are made of it, and it changes without notice.
pub fn is_internal(name: &str) -> bool {
    name.split('/').any(|part| part == "internal")
}

/// The file that an include of this name may mean: one of the same name in another folder, or else one that is spelled almost so.
pub fn closest(requested: &str) -> Option<&'static str> {
    let last = |name: &str| name.rsplit('/').next().map(str::to_owned);
    let (from, names) = (last(requested), FILES.iter().map(|(name, _)| *name));
    let moved = names.clone().find(|name| requested.starts_with("raxel/") && last(name) == from);
    let spelled = || names.map(|name| (strsim::damerau_levenshtein(name, requested), name)).min();
    moved.or_else(|| spelled().filter(|(distance, _)| *distance <= 3).map(|(_, name)| name))
}

/// A function or struct of the library.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item {
    /// Name in `#include <…>` of the file that has it.
    pub file: &'static str,
    /// `rx_trace`, `RxHit`.
    pub name: String,
    /// The head of the function without its body, or the struct with its members.
    pub declaration: String,
    /// The comment in front of it, in one paragraph.
    pub about: String,
}

/// The functions of `<raxel/world.glsl>`: each layout, which is an internal file, has functions of these names.
const OF_WORLD: [&str; 5] = ["rx_trace", "rx_trace_from", "rx_material", "rx_material_properties", "rx_set"];
const WORLD: &str = "raxel/world.glsl";

/// Every function and struct that the library gives to shaders, in the order of the files: those whose name begins with `rx_` or `Rx`, without
/// those of internal files. A function with several sets of arguments is there several times, one that each layout has is there once.
pub fn items() -> Vec<Item> {
    let mut found: Vec<Item> = Vec::new();
    for item in FILES.iter().flat_map(|(file, text)| items_of(file, text)) {
        if !is_internal(item.file) {
            found.push(item);
        } else if OF_WORLD.contains(&item.name.as_str()) && found.iter().all(|known| known.name != item.name) {
            found.push(Item { file: WORLD, ..item });
        }
    }
    found.sort_by_key(|item| item.file);
    found
}

fn items_of(file: &'static str, text: &'static str) -> Vec<Item> {
    let mut found = Vec::new();
    let mut comment: Vec<&str> = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(words) = line.strip_prefix("//") {
            comment.push(words.trim());
            continue;
        }
        let about = std::mem::take(&mut comment).join(" ");
        if let Some(name) = line.strip_prefix("struct ").map(first_word).filter(|name| name.starts_with("Rx")) {
            let body = lines.by_ref().take_while(|line| !line.starts_with('}')).collect::<Vec<_>>().join("\n");
            let declaration = format!("struct {name} {{\n{body}\n}};");
            found.push(Item { file, name: name.to_owned(), declaration, about });
        } else if let Some(name) = function(line) {
            // The head may go on over several lines.
            let mut head = line.to_owned();
            while !head.contains(')') {
                let Some(more) = lines.next() else { break };
                head = format!("{head} {}", more.trim());
            }
            let declaration = head.split_once(')').map_or(head.clone(), |(before, _)| format!("{before})"));
            found.push(Item { file, name: name.to_owned(), declaration, about });
        }
    }
    found
}

/// The name of the function of the library that begins on this line.
fn function(line: &str) -> Option<&str> {
    let head = line.split_once('(')?.0;
    let (before, name) = head.rsplit_once(' ')?;
    let is_type = before.split(' ').all(|word| word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'));
    (name.starts_with("rx_") && is_type && before.starts_with(|c: char| c.is_ascii_alphabetic())).then_some(name)
}

fn first_word(text: &str) -> &str {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).next().unwrap_or_default()
}

/// The template of `raxel/world/BINDING.glsl`; `NAME` in it stands for the name of the binding.
pub(crate) const WORLD_TEMPLATE: &str = "raxel/world/NAME.glsl";
const PLACEHOLDER: &str = "NAME";

/// The binding `pine` of `raxel/world/pine.glsl`, if the include is one of these.
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
    fn an_include_of_a_file_that_has_moved_finds_it() {
        let moved = [
            ("raxel/tree64.glsl", "raxel/internal/layouts/tree64.glsl"),
            ("raxel/walk.glsl", "raxel/internal/walk.glsl"),
            ("raxel/bvh.glsl", "raxel/rivals/internal/layouts/bvh.glsl"),
            ("raxel/march.glsl", "raxel/rivals/march.glsl"),
            ("raxel/march/look.glsl", "raxel/internal/look.glsl"),
            ("raxel/march/dda.glsl", "raxel/rivals/march/dda.glsl"),
            ("raxel/wrold.glsl", "raxel/world.glsl"),
        ];
        for (old, new) in moved {
            assert_eq!(super::closest(old), Some(new), "{old}");
        }
        assert_eq!((super::closest("walk.glsl"), super::closest("raxel/none_of_these.glsl")), (None, None));
        assert!(
            super::is_internal("raxel/rivals/internal/store.glsl") && !super::is_internal("raxel/rivals/march.glsl")
        );
    }

    #[test]
    fn the_purpose_of_a_file_is_its_first_sentence() {
        assert_eq!(
            super::purpose("// One sentence over\n// two lines, e.g. this. Another one.\n#define A\n"),
            "One sentence over two lines, e.g. this"
        );
        assert_eq!(super::purpose("// Declares:\n//\n//     int a;\n"), "Declares");
        for (name, text) in super::FILES.iter().filter(|(name, _)| !super::is_internal(name)) {
            let purpose = super::purpose(text);
            assert!(
                purpose.len() > 10 && purpose.matches('(').count() == purpose.matches(')').count(),
                "{name}: {purpose}"
            );
        }
    }

    #[test]
    fn functions_and_structs_are_listed_with_what_is_said_of_them() {
        let items = super::items();
        let item = |name: &str, file: &str| items.iter().find(|item| item.name == name && item.file == file).unwrap();
        let direction = item("rx_camera_direction", "raxel/camera.glsl");
        assert_eq!(
            direction.declaration,
            "vec3 rx_camera_direction(mat4 view_to_world, vec2 tan_half_fov, vec2 pixel, vec2 size)"
        );
        assert!(direction.about.starts_with("Direction in world space, of length 1, through a place on the output."));
        assert!(item("RxHit", "raxel/ray.glsl").declaration.starts_with("struct RxHit {\n"));
        // Functions that all layouts have are documented with the file that selects one.
        let traces: Vec<&str> = items.iter().filter(|item| item.name == "rx_trace").map(|item| item.file).collect();
        assert_eq!(traces, [super::WORLD]);
        assert!(super::OF_WORLD.iter().all(|name| item(name, super::WORLD).declaration.contains(name)));
        assert!(items.iter().all(|item| !super::is_internal(item.file) && item.name != "RxWalk"));
        // A call or a line of a body is none.
        assert!(
            super::function("    return rx_trace(ray, hit);").is_none() && super::function("if (rx_x(1))").is_none()
        );
        assert!(items.iter().all(|item| item.declaration.contains(&item.name)));
        let silent: Vec<_> =
            items.iter().filter(|item| item.about.is_empty()).map(|item| (item.file, &item.name)).collect();
        assert!(silent.is_empty(), "write a comment above {silent:?}");
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
