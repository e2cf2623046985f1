//! Commands and pieces of files that pages show and no test follows step by step. A command has a verb, options, files and names that
//! exist. A piece of TOML has the keys of a file, a piece of GLSL compiles, and a piece of Python runs. `tests/book.rs` follows the pages
//! that a reader copies from.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap, render};
use raxel_shader::{Compiler, Request, ShaderProvider};
use rayon::prelude::*;
use serde_json::Value;

use crate::common::markdown::{self, Block, spans};
use crate::common::{output, raxel, repository};
use crate::reference::Reference;
use crate::schemas;

/// Pages outside of `docs`.
pub(crate) const OTHERS: [&str; 5] =
    ["README.md", "examples/README.md", "graphs/examples/README.md", "python/README.md", "editors/vscode/README.md"];
/// Names of files that stand for those of a reader.
const OF_READERS: [&str; 8] = ["a", "big", "bloom", "church", "flight", "hill", "mine", "take"];
/// The names that pieces of GLSL use without declaring them.
const GIVEN: &str = "RxHit hit; vec3 sun; vec3 light; float exposure; float depth; ivec2 pixel; ivec2 cursor;";

type Faults = Vec<String>;

#[track_caller]
fn fails_with(faults: &Faults) {
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

fn read(page: &str) -> String {
    std::fs::read_to_string(repository().join(page)).unwrap_or_else(|error| panic!("{page}: {error}"))
}

/// All pages but the lab, which keeps old results.
fn pages() -> BTreeSet<String> {
    let pages = OTHERS.map(str::to_owned).into_iter().chain(markdown::pages("docs"));
    pages.filter(|page| !page.starts_with("docs/lab/")).collect()
}

/// Pages whose blocks are no pieces of files: pages of diagnostics show mistakes, the shader library is generated, and editors have files of
/// their own.
const NO_PIECES: [&str; 3] = ["docs/errors/", "docs/shader-library.md", "docs/editors.md"];

/// The blocks of a language in all pages, each with its page. It leaves out the blocks that `tests/book.rs` writes to files.
fn pieces(language: &str) -> Vec<(String, Block)> {
    let pages = pages().into_iter().filter(|page| !NO_PIECES.iter().any(|other| page.starts_with(other)));
    let blocks =
        pages.flat_map(|page| markdown::blocks(&read(&page)).into_iter().map(move |block| (page.clone(), block)));
    let is_piece = |block: &Block| block.value("file").or(block.value("append")).is_none();
    blocks.filter(|(_, block)| block.language() == language && is_piece(block)).collect()
}

/// A call of raxel on a page.
struct Call {
    /// Page and line.
    at: String,
    /// The words after `raxel`.
    words: Vec<String>,
    /// Whether it is a command to run, and not a mention in a sentence.
    whole: bool,
}

/// The calls of a page, in blocks and in sentences.
fn calls(page: &str) -> Vec<Call> {
    let text = read(page);
    let mut texts: Vec<(usize, String, bool)> = Vec::new();
    for block in markdown::blocks(&text).into_iter().filter(|block| block.language() == "sh") {
        let mut open: Option<(usize, String)> = None;
        for (index, line) in block.text.lines().enumerate() {
            let (number, begun) = open.take().unwrap_or((block.number + 1 + index, String::new()));
            match line.strip_suffix('\\') {
                Some(part) => open = Some((number, begun + part)),
                None => texts.push((number, begun + line, true)),
            }
        }
    }
    for line in markdown::lines(&text).into_iter().filter(|line| !line.fenced) {
        texts.extend(spans(&line.text).map(|span| (line.number, span.to_owned(), false)));
    }
    let mut found = Vec::new();
    for (number, text, whole) in texts {
        for mut words in commands(&text) {
            words.drain(..words.iter().take_while(|word| is_assignment(word)).count());
            let program = words.first().map_or("", String::as_str);
            // The launcher itself runs `./raxel test`; `tests/docs/map.rs` looks it up.
            let runs_tests = program == "./raxel" && words.get(1).is_some_and(|verb| verb == "test");
            if program.rsplit('/').next() == Some("raxel") && words.len() > 1 && !runs_tests {
                found.push(Call { at: format!("{page}:{number}"), words: words.split_off(1), whole });
            }
        }
    }
    found
}

fn is_assignment(word: &str) -> bool {
    word.split_once('=').is_some_and(|(name, _)| name.chars().all(|c| c == '_' || c.is_ascii_uppercase()))
}

/// The commands of a line of a shell: words without their quotes.
fn commands(line: &str) -> Vec<Vec<String>> {
    let (mut found, mut word, mut quote) = (vec![Vec::new()], None::<String>, None);
    for c in line.chars() {
        match quote {
            Some(open) if c == open => quote = None,
            None if c == '"' || c == '\'' => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            None if c == '#' && word.is_none() => break,
            None if c.is_whitespace() || "|&;<>".contains(c) => {
                found.last_mut().unwrap().extend(word.take());
                if !c.is_whitespace() {
                    found.push(Vec::new());
                }
            }
            _ => word.get_or_insert_default().push(c),
        }
    }
    found.last_mut().unwrap().extend(word);
    found
}

/// The values of an option that may be repeated.
fn values<'w>(words: &'w [String], option: &str) -> impl Iterator<Item = &'w str> {
    words.windows(2).filter(move |two| two[0] == option).map(|two| two[1].as_str())
}

/// The verb and its options are known, each with a value that it takes.
fn wrong_options(call: &Call) -> Option<String> {
    // A placeholder such as `VERB`, and the launcher's own `help`.
    if ["VERB", "…", "help"].contains(&call.words[0].as_str()) {
        return None;
    }
    let mut words: Vec<&str> = call.words.iter().map(String::as_str).collect();
    // raxel reads the options in front of `--help` before it prints help.
    words.push("--help");
    let run = raxel(&words);
    let said = run.stderr.lines().next().unwrap_or_default();
    // A sentence may name an option without its value, or with a letter for it.
    let mention = !call.whole && (said.contains("a value is required") || said.contains("invalid value 'T'"));
    (run.code != 0 && !mention).then(|| said.to_owned())
}

/// Files of the repository that a call names are there.
fn missing_files(words: &[String]) -> Option<String> {
    let folders = ["graphs/", "shaders/", "worlds/", "textures/", "examples/"];
    let output = |index: usize| index > 0 && ["-o", "--reference"].contains(&words[index - 1].as_str());
    let named = words.iter().enumerate().filter(|(index, _)| !output(*index)).flat_map(|(_, word)| word.split(','));
    for path in named.filter(|word| folders.iter().any(|folder| word.starts_with(folder))) {
        // A camera of a world stands behind a colon.
        let path = path.split(':').next().unwrap();
        let name = path.rsplit('/').next().unwrap().split('.').next().unwrap();
        let stands_for_others = OF_READERS.contains(&name) || name.contains('*') || name == "NAME";
        if !stands_for_others && !repository().join(path).exists() {
            return Some(format!("{path} does not exist"));
        }
    }
    None
}

/// Params, cameras and targets that a call names are those of its graph and its world. `listed` keeps what `raxel list` says.
fn unknown_names(words: &[String], listed: &mut BTreeMap<Vec<String>, BTreeSet<String>>) -> Option<String> {
    let is_graph = |word: &&String| word.starts_with("graphs/") && repository().join(word.as_str()).is_file();
    let graph = words.get(1).filter(is_graph)?;
    let world = values(words, "--world").next().filter(|world| repository().join(world).is_file());
    if !["render", "run"].contains(&words[0].as_str()) || world.is_none() && values(words, "--world").next().is_some() {
        return None;
    }
    let mut list = vec!["list".to_owned(), graph.clone()];
    list.extend(world.into_iter().flat_map(|world| ["--world".to_owned(), world.to_owned()]));
    let names = listed.entry(list.clone()).or_insert_with(|| {
        let run = raxel(&list.iter().map(String::as_str).collect::<Vec<_>>()).exits(0);
        let rows = run.stdout.lines().filter(|line| line.starts_with("  "));
        rows.filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
    });
    let params = values(words, "--set").map(|set| set.split('=').next().unwrap());
    let cameras = values(words, "--camera").filter(|camera| !camera.contains(','));
    let targets = values(words, "--target").map(|target| target.split([',', '@']).next().unwrap());
    let mut all = params.chain(cameras).chain(targets).chain(values(words, "--after"));
    all.find(|name| !names.contains(name.split('[').next().unwrap())).map(|name| format!("{graph} has no {name}"))
}

#[test]
fn commands_have_verbs_options_files_and_names_that_exist() {
    let (mut faults, mut count, mut listed) = (Faults::new(), 0, BTreeMap::new());
    for page in pages() {
        let calls = calls(&page);
        count += calls.len();
        let wrong: Vec<Option<String>> = calls.par_iter().map(wrong_options).collect();
        // Pages of the book run in projects of their own, where `tests/book.rs` follows them; those of diagnostics have examples.
        let own_files = page.starts_with("docs/book/") || page.starts_with("docs/errors/");
        for (call, wrong) in calls.iter().zip(wrong) {
            let fault = wrong
                .or_else(|| (!own_files).then(|| missing_files(&call.words)).flatten())
                .or_else(|| (!own_files).then(|| unknown_names(&call.words, &mut listed)).flatten());
            faults.extend(fault.map(|fault| format!("{}: raxel {}: {fault}", call.at, call.words.join(" "))));
        }
    }
    fails_with(&faults);
    assert!(count > 400, "{count} commands");
}

/// The place in a piece of a key or a word that its schema does not know.
fn misfit(reference: &Reference<'_>, schema: &Value, value: &Value, path: &str) -> Option<String> {
    let schema = reference.resolved(schema);
    for forms in ["anyOf", "oneOf"].into_iter().filter_map(|key| schema[key].as_array()) {
        let misfits: Vec<_> = forms.iter().map(|form| misfit(reference, form, value, path)).collect();
        if misfits.iter().all(Option::is_some) {
            // The form that fits best is the one that the author meant.
            return misfits.into_iter().flatten().max_by_key(String::len);
        }
    }
    if value.is_object() && reference.resolved(&schema["items"])["properties"].is_object() {
        // `[passes.push]` goes on with the last table of an array.
        return misfit(reference, &schema["items"], value, path);
    }
    let is = |kind: &Value| match kind.as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("boolean") => value.is_boolean(),
        Some("integer" | "number") => value.is_number(),
        _ => true,
    };
    let kinds = schema["type"].as_array().map_or(std::slice::from_ref(&schema["type"]), Vec::as_slice);
    let words = schema["enum"].as_array();
    let constant = &schema["const"];
    if !kinds.iter().any(is)
        || words.is_some_and(|words| !words.contains(value))
        || !constant.is_null() && constant != value
    {
        return Some(path.to_owned());
    }
    match value {
        Value::Object(entries) => entries.iter().find_map(|(key, value)| {
            let path = format!("{path}.{key}");
            match (&schema["properties"][key], &schema["additionalProperties"]) {
                (Value::Null, Value::Bool(false)) => Some(path),
                (Value::Null, Value::Object(_)) => misfit(reference, &schema["additionalProperties"], value, &path),
                (known, _) => misfit(reference, known, value, &path),
            }
        }),
        Value::Array(values) => values.iter().find_map(|value| misfit(reference, &schema["items"], value, path)),
        _ => None,
    }
}

/// Every table that a schema describes.
fn tables<'s>(schema: &'s Value, found: &mut Vec<&'s Value>) {
    match schema {
        Value::Object(entries) => {
            found.extend(schema["properties"].is_object().then_some(schema));
            entries.values().for_each(|value| tables(value, found));
        }
        Value::Array(values) => values.iter().for_each(|value| tables(value, found)),
        _ => {}
    }
}

/// A piece is the beginning of a file, or some lines of a table in it.
#[test]
fn pieces_of_toml_have_the_keys_of_a_file() {
    let schemas = schemas();
    let mut faults = Faults::new();
    let pieces = pieces("toml");
    assert!(pieces.len() > 40, "{} pieces", pieces.len());
    for (page, block) in pieces {
        let table = match block.text.parse::<toml::Table>() {
            Ok(table) => serde_json::to_value(table).unwrap(),
            Err(error) => {
                let before = &block.text[..error.span().map_or(0, |span| span.start)];
                let line = block.number + 1 + before.matches('\n').count();
                faults.push(format!("{page}:{line}: {}", error.message()));
                continue;
            }
        };
        let mut misfits = Vec::new();
        for (_, schema) in &schemas {
            let mut all = Vec::new();
            tables(schema, &mut all);
            misfits.extend(all.into_iter().map(|place| misfit(&Reference { schema }, place, &table, "")));
        }
        if misfits.iter().all(Option::is_some) {
            let deepest = misfits.into_iter().flatten().max_by_key(|path| path.matches('.').count()).unwrap();
            let key = deepest.rsplit('.').next().unwrap();
            let line = block.text.lines().position(|line| line.contains(key)).unwrap_or(0);
            faults.push(format!(
                "{page}:{}: no file of raxel has `{}` here",
                block.number + 1 + line,
                deepest.trim_start_matches('.')
            ));
        }
    }
    fails_with(&faults);
}

/// Whether a line declares a function without its body.
fn is_prototype(line: &str) -> bool {
    let head = line.split('(').next().unwrap().split_whitespace().count();
    line.ends_with(");") && head == 2 && !line.contains('=')
}

/// A piece is a shader without its head, some statements, or declarations of the library.
#[test]
fn pieces_of_glsl_compile() {
    let mut faults = Faults::new();
    let pieces = pieces("glsl");
    assert!(pieces.len() > 8, "{} pieces", pieces.len());
    for (page, block) in pieces {
        let code: Vec<&str> = block.text.lines().map(|line| line.split("//").next().unwrap().trim_end()).collect();
        let (directives, rest): (Vec<&str>, Vec<&str>) = code.iter().partition(|line| line.starts_with('#'));
        let rest: Vec<&str> = rest.into_iter().filter(|line| !line.is_empty()).collect();
        if !rest.is_empty() && rest.iter().all(|line| is_prototype(line)) {
            let files = raxel_shader::library::FILES;
            let is_there = |line: &str| files.iter().any(|(_, text)| text.contains(line.trim_end_matches(';')));
            let gone = rest.iter().find(|line| !is_there(line));
            let gone = gone.map(|line| format!("{page}:{}: the library does not declare {line}", block.number));
            faults.extend(gone);
            continue;
        }
        let directives = directives.into_iter().filter(|line| !line.starts_with("#version"));
        let given = ["#version 460", "#include <raxel/world.glsl>", "#include <raxel/print.glsl>"];
        let head: Vec<&str> = given.into_iter().chain(directives).collect();
        let (head, rest) = (head.join("\n"), rest.join("\n"));
        let size = if rest.contains("local_size_x") { "" } else { "layout(local_size_x = 8) in;" };
        let body = if rest.contains("void main()") { rest } else { format!("void main() {{ {GIVEN}\n{rest}\n}}") };
        let shader = format!("{head}\n{size}\n{body}\n");
        let compiler = Compiler::new(Arc::new(MemoryFiles::new([("shaders/piece.comp", shader.as_str())])));
        let defines = ["RX_LAYOUT_TREE64", "RX_LAYOUT_TREE64_pine"].map(|name| (name.to_owned(), "1".to_owned()));
        let request =
            Request { path: "shaders/piece.comp".to_owned(), entry: "main".to_owned(), defines: defines.into() };
        let mut texts = SourceMap::default();
        if let Err(found) = compiler.shader(&request, &mut texts) {
            faults.push(format!("{page}:{}: {}", block.number, render::human(&found, &texts, false)));
        }
    }
    fails_with(&faults);
}

/// Python compiles a piece; one that needs no other package runs in a new project.
#[test]
fn pieces_of_python_run() {
    let python = |folder: &Path, arguments: &[&str]| {
        let mut python = Command::new("python3");
        python.args(arguments).current_dir(folder).stdin(Stdio::null()).env("PYTHONDONTWRITEBYTECODE", "1");
        python.env("PYTHONPATH", repository().join("python")).env("RAXEL", env!("CARGO_BIN_EXE_raxel"));
        output(&mut python)
    };
    let pieces = pieces("python");
    assert!(pieces.len() > 3, "{} pieces", pieces.len());
    let mut faults = Faults::new();
    for (page, block) in pieces {
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path().join("project");
        raxel(&["new", project.to_str().unwrap()]).exits(0);
        std::fs::write(project.join("piece.py"), &block.text).unwrap();
        let runs = block.text.lines().any(|line| line == "import raxel");
        let arguments: &[&str] = if runs { &["piece.py"] } else { &["-m", "py_compile", "piece.py"] };
        let said = python(&project, arguments);
        if !said.status.success() {
            faults.push(format!("{page}:{}: {}", block.number, String::from_utf8_lossy(&said.stderr)));
        }
    }
    fails_with(&faults);
}
