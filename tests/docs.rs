//! Documentation that the code could contradict is generated from it, and its examples are run.
//!
//! ```sh
//! RAXEL_WRITE_DOCS=1 cargo test --profile checked --test docs
//! ```
//!
//! writes the generated parts: everything after `## Every key`, the figures about layouts, and the index of diagnostics.

mod common;
#[path = "docs/map.rs"]
mod map;

use std::fmt::Write;
use std::path::Path;

use common::{Project, markdown, repository};
use raxel::layouts::LayoutError;
use raxel::rivals;
use raxel_diagnostics::{DiskFiles, SourceMap};
use serde_json::{Map, Value};

const MARK: &str = "## Every key\n";

/// Compares a file with what it should be, or writes it.
fn settle(path: &str, expected: &str) {
    let file = repository().join(path);
    if std::env::var_os("RAXEL_WRITE_DOCS").is_some() {
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, expected).unwrap();
    }
    let found = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(found == expected, "{path} is not up to date; see the head of tests/docs.rs");
}

#[test]
fn file_references_follow_the_schemas() {
    for (path, schema) in [
        ("docs/graph-file.md", raxel::graphfile::schema()),
        ("docs/world-file.md", raxel::worldfile::schema()),
        ("docs/demo-file.md", raxel::runtime::timeline::schema()),
        ("docs/project-file.md", raxel::runtime::manifest::schema()),
    ] {
        let text = std::fs::read_to_string(repository().join(path)).unwrap();
        let (head, _) = text.split_once(MARK).unwrap();
        settle(path, &format!("{head}{MARK}{}", Reference { schema: &schema }.text()));
    }
}

/// The schemas with their names.
fn schemas() -> [(&'static str, Value); 4] {
    [
        ("graph", raxel::graphfile::schema()),
        ("world", raxel::worldfile::schema()),
        ("demo", raxel::runtime::timeline::schema()),
        ("project", raxel::runtime::manifest::schema()),
    ]
}

/// What an editor shows when the cursor rests on a key.
#[test]
fn every_key_says_what_it_is() {
    fn walk(reference: &Reference<'_>, at: &Value, path: &str) {
        for (key, value) in at["properties"].as_object().into_iter().flatten() {
            assert!(!reference.about(value).is_empty(), "{path}.{key} has no description");
        }
        match at {
            Value::Object(entries) => {
                entries.iter().for_each(|(key, value)| walk(reference, value, &format!("{path}.{key}")));
            }
            Value::Array(elements) => elements.iter().for_each(|value| walk(reference, value, path)),
            _ => {}
        }
    }
    for (name, schema) in &schemas() {
        walk(&Reference { schema }, schema, name);
    }
}

/// Units of the numbers in files, and words that tell what a number without one is.
const UNITS: [&str; 23] = [
    "voxel",
    "second",
    "degree",
    "byte",
    "pixel",
    "texel",
    "frame",
    "tick",
    "`unit`",
    "units of the param",
    "thread",
    "round",
    "element",
    "components",
    "number of",
    "how many",
    "how often",
    "so many",
    "multiple",
    "from 0",
    "0 to 1",
    "0 is",
    "any number",
];

/// What an editor shows of a key says what holds when it is left out, and what a number counts.
#[test]
fn every_key_says_its_default_and_its_unit() {
    fn is_number(reference: &Reference<'_>, value: &Value) -> bool {
        let value = reference.resolved(value);
        let types = [&value["type"]].into_iter().chain(value["type"].as_array().into_iter().flatten());
        let own = types.filter_map(Value::as_str).any(|name| name == "number" || name == "integer");
        let forms = ["anyOf", "oneOf"].into_iter().filter_map(|key| value[key].as_array()).flatten();
        own || value["items"].is_object() && is_number(reference, &value["items"])
            || forms.into_iter().any(|form| is_number(reference, form))
    }
    fn walk(reference: &Reference<'_>, at: &Value, path: &str, silent: &mut Vec<String>) {
        let needed = |key: &str| at["required"].as_array().is_some_and(|all| all.iter().any(|one| one == key));
        for (key, value) in at["properties"].as_object().into_iter().flatten() {
            let (about, resolved) = (reference.about(value).to_lowercase(), reference.resolved(value));
            // A table says of its own keys what holds without them.
            let tables = |value: &Value| reference.resolved(value)["type"] == "object";
            let has_tables = tables(value)
                || resolved["items"].is_object()
                    && (tables(&resolved["items"]) || resolved["items"]["oneOf"].is_array());
            let absent = ["left out", "without", "instead", "needed", "default: `"];
            if !needed(key) && !has_tables && !absent.iter().any(|word| about.contains(word)) {
                silent.push(format!("{path}.{key} when it is left out: {about}"));
            }
            if is_number(reference, value) && !UNITS.iter().any(|unit| about.contains(unit)) {
                silent.push(format!("{path}.{key} has no unit: {about}"));
            }
        }
        match at {
            Value::Object(entries) => {
                entries.iter().for_each(|(key, value)| walk(reference, value, &format!("{path}.{key}"), silent));
            }
            Value::Array(elements) => elements.iter().for_each(|value| walk(reference, value, path, silent)),
            _ => {}
        }
    }
    let mut silent = Vec::new();
    for (name, schema) in &schemas() {
        walk(&Reference { schema }, schema, name, &mut silent);
    }
    assert!(silent.is_empty(), "{}", silent.join("\n"));
}

/// Taplo, which completes TOML in VS Code and Helix, runs out of stack over `allOf`.
#[test]
fn no_schema_is_too_deep_for_taplo() {
    for (name, schema) in schemas() {
        assert!(!schema.to_string().contains("\"allOf\""), "{name}");
    }
}

/// A clone has them, so that editors complete and check the files of a project that nothing was built of yet.
#[test]
fn the_schemas_travel() {
    for (name, schema) in schemas() {
        settle(&format!(".raxel/{name}.schema.json"), &format!("{schema:#}\n"));
    }
}

/// A line of a comment. What is indented is code; elsewhere, `<` begins no tag of HTML.
fn as_markdown(line: &str) -> String {
    if line.starts_with("     ") {
        return format!("    {}", line.trim());
    }
    let parts = line.trim().split('`').enumerate();
    parts
        .map(|(i, part)| if i % 2 == 0 { part.replace('<', "\\<") } else { part.to_owned() })
        .collect::<Vec<_>>()
        .join("`")
}

/// Everything of the library that begins with `rx_`, as the library says it, but for the files that are internal to it.
#[test]
fn the_page_of_the_shader_library_is_the_library() {
    let mut text = "# The shader library\n\nWhat `#include <raxel/…>` brings along, generated from the files themselves. \
                    `raxel shaders --library FILE` prints one, `raxel shaders --library` lists them. What a folder `internal` has is not here: no shader\n\
                    includes it, and it changes without notice. `raxel/rivals` has the marchers of [other renderers](rivals/README.md).\nA file of the same path in a project's `shaders/include/` wins over it.\n"
        .to_owned();
    let items = raxel_shader::library::items();
    for (file, source) in
        raxel_shader::library::FILES.iter().filter(|(file, _)| !raxel_shader::library::is_internal(file))
    {
        let head: Vec<String> = source.lines().map_while(|line| line.strip_prefix("//")).map(as_markdown).collect();
        let _ = write!(text, "\n## `{file}`\n\n{}\n", head.join("\n").trim());
        for item in items.iter().filter(|item| item.file == *file) {
            let _ = write!(text, "\n### `{}`\n\n```glsl\n{}\n```\n", item.name, item.declaration);
            if !item.about.is_empty() {
                let _ = write!(text, "\n{}\n", item.about);
            }
        }
    }
    settle("docs/shader-library.md", &text);
}

#[test]
fn the_page_of_layouts_says_what_they_cost() {
    let path = "docs/layouts.md";
    let text = std::fs::read_to_string(repository().join(path)).unwrap();
    let mark = "## Bytes a voxel\n";
    let head = text.split(mark).next().unwrap();
    for layout in rivals::LAYOUTS {
        assert!(head.contains(&format!("\n## `{}`\n", layout.name())), "{path} has no section about {}", layout.name());
    }
    settle(path, &format!("{head}{mark}{}", layouts()));
}

/// Bytes a voxel of the shipped worlds in every layout, and what is in the layouts' headers.
fn layouts() -> String {
    const NAMES: [&str; 4] = ["menger", "monument", "valley", "terrain"];
    // The size of a larger buffer is known without making it.
    const LIMIT: u64 = 128 << 20;
    let files = DiskFiles::new(repository()).unwrap();
    let mut rows: Vec<String> = rivals::LAYOUTS.iter().map(|layout| format!("| `{}` |", layout.name())).collect();
    for name in NAMES {
        let loaded = raxel::worldfile::load(&format!("worlds/{name}.toml"), &files, &mut SourceMap::default());
        let world = loaded.unwrap().0.world;
        for (layout, row) in rivals::LAYOUTS.iter().zip(&mut rows) {
            let a_voxel = |bytes: u64| bytes as f64 / world.solids() as f64;
            let _ = match layout.encode(&world, LIMIT) {
                Ok(encoded) => {
                    let (geometry, materials) = (a_voxel(encoded.geometry_bytes), a_voxel(encoded.attribute_bytes));
                    write!(row, " {geometry:.2} + {materials:.2} |")
                }
                Err(LayoutError::TooLarge { bytes, .. }) => write!(row, " {:.2} |", a_voxel(bytes)),
                Err(error) => panic!("{name}: {error}"),
            };
        }
    }
    let mut text =
        format!("\nGeometry + materials; the sum where the buffer is over 128 MiB.\n\n| | {} |\n", NAMES.join(" | "));
    let _ = writeln!(text, "|---|{}\n{}", "---|".repeat(NAMES.len()), rows.join("\n"));
    text += "\n## Headers\n\nAfter `materials_at`, and the array of what follows the header:\n\n| | |\n|---|---|\n";
    for layout in rivals::LAYOUTS {
        let block = layout.block();
        let after = block.iter().skip_while(|member| member.name != "materials_at").skip(1);
        let members: Vec<String> = after
            .map(|member| format!("`{} {}{}`", member.ty, member.name, if member.stride.is_some() { "[]" } else { "" }))
            .collect();
        let _ = writeln!(text, "| `{}` | {} |", layout.name(), members.join(", "));
    }
    text
}

/// What codes with these beginnings are about.
const SUBJECTS: [(&str, &str); 5] = [
    ("RX00", "Files and TOML"),
    ("RX01", "Graphs"),
    ("RX02", "Shaders"),
    ("RX03", "Worlds, edits and saves"),
    ("RX04", "Projects, demos, instances, stores and runs"),
];

#[test]
fn every_diagnostic_is_in_the_index() {
    let listed = common::raxel(&["explain"]).exits(0).stdout;
    let mut text = "# Diagnostics\n\nEach error and warning has a code and a page. `raxel explain CODE` prints the page.\n\n\
                    raxel reports all mistakes at once. It prints the first twenty, errors before warnings, and counts the rest. With `--format \
                    json`,\nthe count is the last line: `{\"reason\":\"more-diagnostics\",\"errors\":99980,\"warnings\":0}`.\n"
        .to_owned();
    let mut subject = "";
    for line in listed.lines() {
        let (code, title) = line.split_once("  ").unwrap();
        let group = &code[..4];
        if group != subject {
            subject = group;
            let (_, about) =
                SUBJECTS.iter().find(|(known, _)| *known == group).unwrap_or_else(|| panic!("{code} has no subject"));
            let _ = write!(text, "\n## {about}\n\n");
        }
        let _ = writeln!(text, "* [{code}]({code}.md) {title}");
    }
    settle("docs/errors/README.md", &text);
}

#[test]
fn every_example_has_its_row_and_its_picture() {
    let page = std::fs::read_to_string(repository().join("graphs/examples/README.md")).unwrap();
    for file in std::fs::read_dir(repository().join("graphs/examples")).unwrap() {
        let file = file.unwrap().path();
        if file.extension().is_some_and(|extension| extension == "toml") {
            let name = file.file_stem().unwrap().to_string_lossy();
            assert!(page.contains(&format!("[{name}.toml]({name}.toml)")), "{name} has no row");
            assert!(repository().join(format!("docs/examples/{name}.png")).exists(), "{name} has no picture");
        }
    }
}

#[test]
fn the_example_of_the_graph_reference_is_right() {
    let project = Project::empty();
    let text = std::fs::read_to_string(repository().join("docs/graph-file.md")).unwrap();
    let mut graphs = Vec::new();
    for block in markdown::blocks(&text) {
        let content = block.text;
        let path = content.lines().next().unwrap().trim_start_matches(['#', '/', ' ']);
        // What names no file is a piece of one.
        if !path.starts_with("graphs/") && !path.starts_with("shaders/") {
            assert!(content.parse::<toml::Table>().is_ok(), "{content} is a piece of a graph");
            continue;
        }
        // GLSL wants its version first.
        project.write(path, content.split_once('\n').unwrap().1);
        graphs.extend(path.starts_with("graphs/").then(|| path.to_owned()));
    }
    assert_eq!(graphs.len(), 2);
    for graph in &graphs {
        project.raxel(&["check", graph]).exits(0);
        project.raxel(&["render", graph, "--frames", "2", "--size", "40x30", "-o", "p.png", "--validate"]).exits(0);
    }
}

/// A JSON schema as Markdown tables.
struct Reference<'s> {
    schema: &'s Value,
}

/// What a definition with more forms than this has, a table of its own lists.
const FEW: usize = 8;

impl Reference<'_> {
    fn text(&self) -> String {
        let mut text = String::new();
        self.tables("The file", self.schema, &mut text);
        for (name, definition) in self.schema["definitions"].as_object().into_iter().flatten() {
            self.values(name, definition, &mut text);
        }
        text
    }

    /// The table of an object, and then those of the objects in it.
    fn tables(&self, name: &str, object: &Value, text: &mut String) {
        let Some(properties) = object["properties"].as_object() else { return };
        let _ = write!(text, "\n### {name}\n\n| key | value | meaning |\n|---|---|---|\n");
        for (key, value) in properties {
            let needed = object["required"].as_array().is_some_and(|all| all.iter().any(|one| one == key));
            let about = self.about(value).replace('|', "\\|").replace('\n', " ");
            let shape = self.shape(value, 0).replace('|', "\\|");
            let said = about.to_lowercase().contains("needed");
            let _ = writeln!(text, "| `{key}` | {shape} | {about}{} |", if needed && !said { " Needed." } else { "" });
        }
        for (key, value) in properties {
            for (place, form, inner) in self.inner(value) {
                let title = match (name == "The file", place) {
                    (true, Place::Itself) => format!("`[{key}]`"),
                    (true, Place::Named) => format!("`[{key}.NAME]`"),
                    (true, Place::Each) => format!("`[[{key}]]`"),
                    (false, Place::Named) => format!("`{key}.NAME`"),
                    (false, Place::Itself | Place::Each) => format!("`{key}`"),
                };
                let within = if name == "The file" { String::new() } else { format!(" in {name}") };
                self.tables(&format!("{title}{form}{within}"), inner, text);
            }
        }
    }

    /// The words that a definition lists.
    fn values(&self, name: &str, definition: &Value, text: &mut String) {
        let forms = definition["anyOf"].as_array().map_or(&[][..], Vec::as_slice);
        if forms.len() <= FEW {
            return;
        }
        let _ = write!(text, "\n### Values of `{name}`\n\n| value | meaning |\n|---|---|\n");
        for form in forms {
            let word = form["const"].as_str().map_or_else(|| self.shape(form, 0), |word| format!("`{word}`"));
            let _ = writeln!(text, "| {word} | {} |", self.about(form));
        }
    }

    fn resolved<'v>(&'v self, value: &'v Value) -> &'v Value {
        match self.definition(value) {
            Some((_, definition)) => self.resolved(definition),
            None => value,
        }
    }

    /// The definition that a value refers to, and its name.
    fn definition<'v>(&'v self, value: &'v Value) -> Option<(&'v str, &'v Value)> {
        let path = value["$ref"].as_str()?.trim_start_matches('#');
        Some((path.rsplit('/').next()?, self.schema.pointer(path)?))
    }

    fn about<'v>(&'v self, value: &'v Value) -> &'v str {
        value["description"].as_str().or_else(|| self.resolved(value)["description"].as_str()).unwrap_or_default()
    }

    /// Objects with keys of their own in a value, one level down: where they are, and which of several forms each is.
    fn inner<'v>(&'v self, value: &'v Value) -> Vec<(Place, String, &'v Value)> {
        let value = self.resolved(value);
        let mut found = Vec::new();
        for (place, object) in
            [(Place::Itself, value), (Place::Named, &value["additionalProperties"]), (Place::Each, &value["items"])]
        {
            let objects = self.objects(object);
            let several = objects.len() > 1;
            for object in objects {
                found.push((place, if several { self.form(object) } else { String::new() }, object));
            }
        }
        found
    }

    /// The forms of a value that are objects with keys.
    fn objects<'v>(&'v self, value: &'v Value) -> Vec<&'v Value> {
        let value = self.resolved(value);
        let forms = value["anyOf"].as_array().into_iter().chain(value["oneOf"].as_array()).flatten();
        let all = std::iter::once(value).chain(forms.map(|form| self.resolved(form)));
        all.filter(|object| object["properties"].as_object().is_some_and(|keys| !keys.is_empty())).collect()
    }

    /// What tells a form from the others: a key with one value, or one that only this form needs.
    fn form(&self, object: &Value) -> String {
        let keys = object["properties"].as_object().into_iter().flatten();
        let telling = keys.filter_map(|(key, value)| match self.resolved(value)["const"].as_str() {
            Some(word) => Some(format!(" with `{key} = \"{word}\"`")),
            None => self.about(value).contains("Needed in this form").then(|| format!(" with `{key}`")),
        });
        telling.into_iter().next().unwrap_or_default()
    }

    /// A value's type in words.
    fn shape(&self, value: &Value, depth: u32) -> String {
        if let Some((name, definition)) = self.definition(value)
            && definition["anyOf"].as_array().is_some_and(|forms| forms.len() > FEW)
        {
            return format!("[a value](#values-of-{name})");
        }
        let value = self.resolved(value);
        let empty = Map::new();
        let object = value.as_object().unwrap_or(&empty);
        if let Some(words) = object.get("enum").and_then(Value::as_array) {
            return words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(" ");
        }
        if let Some(word) = object.get("const") {
            return format!("`{word}`");
        }
        for either in ["anyOf", "oneOf"] {
            if let Some(forms) = object.get(either).and_then(Value::as_array) {
                let mut shapes: Vec<String> = forms.iter().map(|form| self.shape(form, depth + 1)).collect();
                shapes.dedup();
                return shapes.join(" or ");
            }
        }
        match object.get("type") {
            Some(Value::String(name)) if name == "array" => match object.get("items") {
                Some(items) if !self.objects(items).is_empty() => "array of tables".to_owned(),
                // A value that may be an array of such values.
                Some(items)
                    if self
                        .definition(items)
                        .is_some_and(|(name, all)| all.to_string().contains(&format!("/{name}\""))) =>
                {
                    "array".to_owned()
                }
                Some(items) if depth < 3 => {
                    let counts = ["minItems", "maxItems"].map(|key| object.get(key).and_then(Value::as_u64));
                    let count = match counts {
                        [Some(least), Some(most)] if least == most => format!("{least} × "),
                        [Some(least), Some(most)] if most <= 4 => format!("{least} to {most} × "),
                        _ => "array of ".to_owned(),
                    };
                    format!("{count}{}", self.shape(items, depth + 1))
                }
                _ => "array".to_owned(),
            },
            Some(Value::String(name)) if name == "object" => {
                match object.get("properties").and_then(Value::as_object) {
                    Some(keys) if depth > 0 => {
                        format!("{{ {} }}", keys.keys().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", "))
                    }
                    None if !self.objects(&value["additionalProperties"]).is_empty() => "tables by name".to_owned(),
                    _ => "table".to_owned(),
                }
            }
            Some(Value::String(name)) if name == "string" && object.contains_key("pattern") => {
                written(object["pattern"].as_str().unwrap_or_default())
            }
            Some(Value::String(name)) if name == "string" => "text".to_owned(),
            Some(Value::String(name)) => format!("{name}{}", range(value)),
            Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(" or "),
            _ => "any value".to_owned(),
        }
    }
}

/// Where an object stands in the value of a key.
#[derive(Clone, Copy)]
enum Place {
    /// It is the value.
    Itself,
    /// Under a name that the author gives.
    Named,
    /// In an array.
    Each,
}

/// The limits of a number. Those of its type alone are left out.
fn range(value: &Value) -> String {
    let limit = |key: &str| value[key].as_f64().filter(|limit| limit.abs() < 4e9 || *limit < 1e19 && limit.abs() > 5e9);
    let shown = |number: f64| {
        let exponent = number.abs().log10();
        if number.abs() >= 1e7 && number.abs().log2().fract() == 0.0 {
            format!("{}2^{}", if number < 0.0 { "−" } else { "" }, number.abs().log2())
        } else if number != 0.0 && !(-4.0..7.0).contains(&exponent) {
            format!("{number:e}")
        } else {
            number.to_string().replace('-', "−")
        }
    };
    match (limit("minimum").map(shown), limit("maximum").map(shown)) {
        (Some(least), Some(most)) => format!(" ({least} to {most})"),
        (Some(least), None) => format!(" (at least {least})"),
        (None, Some(most)) => format!(" (at most {most})"),
        (None, None) => String::new(),
    }
}

/// A pattern as an author would write what fits it.
fn written(pattern: &str) -> String {
    let mut text = pattern.trim_matches(['^', '$']).to_owned();
    for (part, words) in [
        ("[A-Za-z0-9_-]+", "NAME"),
        ("[0-9]+ *[KMGT]iB", "512 MiB"),
        ("[0-9a-fA-F]{6}", "rrggbb"),
        ("[0-9]+", "N"),
        (".+", "NAME"),
        ("zarr:.", "zarr:…"),
        ("\\", ""),
    ] {
        text = text.replace(part, words);
    }
    if let Some(rest) = text.strip_prefix("!?") {
        return format!("`{rest}` `!{rest}`");
    }
    let Some((head, (words, tail))) = text.split_once('(').and_then(|(head, rest)| Some((head, rest.split_once(')')?)))
    else {
        return format!("`{text}`");
    };
    let words: Vec<&str> = words.split('|').collect();
    let words = if words.len() > 4 { vec!["TYPE"] } else { words };
    words.iter().map(|word| format!("`{head}{word}{tail}`")).collect::<Vec<_>>().join(" ")
}

/// Pages that name tests: a path of the repository, then functions in it.
#[test]
fn tests_that_pages_name_exist() {
    let mut named = 0;
    for page in ["docs/promises.md", "docs/faults.md"] {
        let text = std::fs::read_to_string(repository().join(page)).unwrap();
        for line in text.lines().filter(|line| line.starts_with("| ")) {
            let Some(cell) = line.trim_end_matches([' ', '|']).rsplit(" | ").next() else { continue };
            let mut source = None;
            for code in cell.split('`').skip(1).step_by(2) {
                if Path::new(code).extension().is_some_and(|extension| extension == "rs") {
                    let path = repository().join(code);
                    source =
                        Some(std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{page}: {code}: {error}")));
                } else if code.contains('_')
                    && code.chars().all(|c| c == '_' || c.is_ascii_lowercase() || c.is_ascii_digit())
                {
                    let source = source.as_ref().unwrap_or_else(|| panic!("{page}: `{code}` has no file before it"));
                    assert!(source.contains(&format!("fn {code}(")), "{page}: `{code}` is not there");
                    named += 1;
                }
            }
        }
    }
    assert!(named > 50, "{named} tests are named");
}
