//! Documentation that the code could contradict is generated from it, and its examples are run.
//!
//! ```sh
//! RAXEL_WRITE_DOCS=1 cargo test --profile checked --test docs
//! ```
//!
//! writes the generated parts: everything after `## Every key` and `## Every name`, the figures about layouts, and the index of diagnostics.

mod common;
#[path = "docs/map.rs"]
mod map;
#[path = "docs/pieces.rs"]
mod pieces;
#[path = "docs/reference.rs"]
mod reference;
#[path = "docs/rivals_apart.rs"]
mod rivals_apart;
#[path = "docs/rust_api.rs"]
mod rust_api;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use common::{Project, RunRaxel, markdown, repository};
use raxel_diagnostics::{DiskFiles, SourceMap};
use raxel_layouts::LayoutError;
use raxel_rivals as rivals;
use reference::Reference;
use serde_json::Value;

const MARK: &str = "## Every key\n";

/// Compares a file with its expected text, or writes it.
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
        ("docs/graph-file.md", raxel_graphfile::schema()),
        ("docs/world-file.md", raxel_worldfile::schema()),
        ("docs/demo-file.md", raxel_runtime::timeline::schema()),
        ("docs/project-file.md", raxel_runtime::manifest::schema()),
    ] {
        let text = std::fs::read_to_string(repository().join(path)).unwrap();
        let (head, _) = text.split_once(MARK).unwrap();
        settle(path, &format!("{head}{MARK}{}", Reference { schema: &schema }.text()));
    }
}

/// The schemas with their names.
fn schemas() -> [(&'static str, Value); 4] {
    [
        ("graph", raxel_graphfile::schema()),
        ("world", raxel_worldfile::schema()),
        ("demo", raxel_runtime::timeline::schema()),
        ("project", raxel_runtime::manifest::schema()),
    ]
}

/// An editor's text for a key under the cursor.
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

/// Units of the numbers in files, and words that explain a number without one.
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

/// An editor's text for a key has its default and the unit of a number.
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
            // A table's own keys have their defaults.
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

/// The meanings that editors show are those of the guide.
#[test]
fn the_conditions_of_the_guide_mean_the_same_in_the_schema() {
    let schema = raxel_graphfile::schema();
    let guide = std::fs::read_to_string(repository().join("docs/graph-file.md")).unwrap();
    let known = &schema["definitions"]["pass"]["properties"]["when"]["anyOf"][0];
    let words = known["enum"].as_array().unwrap().iter();
    let meanings = known["x-taplo"]["docs"]["enumValues"].as_array().unwrap().iter();
    let pairs = words.zip(meanings).map(|(word, meaning)| (word.as_str().unwrap(), meaning.as_str().unwrap()));
    let facts: Vec<_> = pairs.filter(|(word, _)| !word.starts_with('!')).collect();
    assert_eq!(facts.len(), 6);
    for (word, meaning) in facts {
        let holds = meaning.strip_prefix("`bool`. Holds if ").and_then(|rest| rest.strip_suffix('.')).unwrap();
        assert!(guide.contains(&format!("\n| `{word}` | {holds} |\n")), "{word}: {meaning}");
    }
}

/// Taplo, which completes TOML in VS Code and Helix, runs out of stack over `allOf`.
#[test]
fn no_schema_is_too_deep_for_taplo() {
    for (name, schema) in schemas() {
        assert!(!schema.to_string().contains("\"allOf\""), "{name}");
    }
}

/// A clone has the schemas, so editors complete and check the files of a project before anything is built.
#[test]
fn the_schemas_travel() {
    for (name, schema) in schemas() {
        settle(&format!(".raxel/{name}.schema.json"), &format!("{schema:#}\n"));
    }
}

/// A line of a comment. Indented text is code; elsewhere, `<` begins no tag of HTML.
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

/// Bytes a voxel of the shipped worlds in every layout, and the members of the layouts' headers.
fn layouts() -> String {
    const NAMES: [&str; 4] = ["menger", "monument", "valley", "terrain"];
    // The size of a larger buffer is known without making it.
    const LIMIT: u64 = 128 << 20;
    let files = DiskFiles::new(repository()).unwrap();
    let mut rows: Vec<String> = rivals::LAYOUTS.iter().map(|layout| format!("| `{}` |", layout.name())).collect();
    for name in NAMES {
        let loaded = raxel_worldfile::load(&format!("worlds/{name}.toml"), &files, &mut SourceMap::default());
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

/// The subjects of codes with these beginnings.
const SUBJECTS: [(&str, &str); 5] = [
    ("RX00", "Files and TOML"),
    ("RX01", "Graphs"),
    ("RX02", "Shaders"),
    ("RX03", "Worlds, edits and saves"),
    ("RX04", "Projects, demos, instances, stores and runs"),
];
/// Codes that belong to another subject than their beginning says.
const MOVED: [(&str, &str); 2] = [("RX0490", "RX03"), ("RX0491", "RX01")];

/// `./raxel test` runs clippy with warnings as errors, so a public item without docs fails it in every crate.
#[test]
fn public_items_have_docs_in_every_crate() {
    let manifest = |path: &Path| std::fs::read_to_string(path).unwrap().parse::<toml::Table>().unwrap();
    let workspace = manifest(&repository().join("Cargo.toml"));
    assert_eq!(workspace["workspace"]["lints"]["rust"]["missing_docs"].as_str(), Some("warn"));
    let launcher = std::fs::read_to_string(repository().join("raxel")).unwrap();
    assert!(launcher.contains("cargo clippy --profile checked \"$@\" --all-targets --quiet -- -D warnings"));
    let folders = std::fs::read_dir(repository().join("engine")).unwrap().map(|entry| entry.unwrap().path());
    let manifests: Vec<_> = folders.map(|folder| folder.join("Cargo.toml")).filter(|path| path.is_file()).collect();
    assert!(manifests.len() > 30, "{manifests:?}");
    for path in manifests {
        let lints = manifest(&path).get("lints").and_then(|lints| lints.get("workspace")?.as_bool());
        assert_eq!(lints, Some(true), "{}", path.display());
    }
}

#[test]
fn the_page_of_the_rust_api_has_every_name() {
    let path = "docs/book/look-up/rust.md";
    let page = std::fs::read_to_string(repository().join(path)).unwrap();
    let mark = "## Every name\n";
    let (head, _) = page.split_once(mark).unwrap();
    settle(path, &format!("{head}{mark}{}", rust_api::tables()));
}

#[test]
fn every_verb_is_on_the_page_of_the_command_line() {
    let help = common::raxel(&["help"]).exits(0).stdout;
    let (_, verbs) = help.split_once("Commands:\n").unwrap();
    let verbs = verbs.lines().take_while(|line| !line.is_empty()).filter_map(|line| line.split_whitespace().next());
    let verbs: Vec<&str> = verbs.filter(|verb| *verb != "help").collect();
    assert!(verbs.len() > 20, "{verbs:?}");
    let page = std::fs::read_to_string(repository().join("docs/book/look-up/commands.md")).unwrap();
    let (_, table) = page.split_once("## Verbs\n").unwrap();
    let (table, _) = table.split_once("\n## ").unwrap();
    let left_out: Vec<&&str> = verbs.iter().filter(|verb| !table.contains(&format!("`{verb}"))).collect();
    assert!(left_out.is_empty(), "docs/book/look-up/commands.md leaves out {left_out:?}");
}

#[test]
fn every_diagnostic_is_in_the_index() {
    let listed = common::raxel(&["explain"]).exits(0).stdout;
    let mut text = "# Diagnostics\n\nEach error and warning has a code and a page. `raxel explain CODE` prints the page.\n\n\
                    raxel reports all mistakes at once. It prints the first twenty, errors before warnings, and counts the rest. With `--format \
                    json`,\nthe count is the last line: `{\"reason\":\"more-diagnostics\",\"errors\":99980,\"warnings\":0}`.\n"
        .to_owned();
    let mut lists: BTreeMap<&str, String> = BTreeMap::new();
    for line in listed.lines() {
        let (code, title) = line.split_once("  ").unwrap();
        let subject = MOVED.iter().find(|(moved, _)| *moved == code).map_or(&code[..4], |(_, subject)| subject);
        let _ = writeln!(lists.entry(subject).or_default(), "* [{code}]({code}.md) {title}");
        let page = std::fs::read_to_string(repository().join(format!("docs/errors/{code}.md"))).unwrap();
        let (heading, body) = page.split_once("\n\n").unwrap();
        assert_eq!(heading, format!("# {code}: {title}"));
        assert!(
            !body.starts_with("```") && body.contains("```"),
            "{code}: a page says what is wrong, and has an example"
        );
    }
    for (subject, list) in lists {
        let (_, about) = SUBJECTS.iter().find(|(known, _)| *known == subject).expect("every code has a subject");
        let _ = write!(text, "\n## {about}\n\n{list}");
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
        // A text that names no file is a piece of one.
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
