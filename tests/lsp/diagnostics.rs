//! Mistakes are told while they are typed, and answers do not wait for them.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::common::Project;
use crate::{Editor, NOTE, NOTES, address};

#[test]
fn mistakes_are_told_as_they_are_typed_and_taken_back() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    let (graph, shader) = (project.path("graphs/inspect.toml"), project.path("shaders/inspect.comp"));
    let text = std::fs::read_to_string(&graph).unwrap();
    // Nothing is saved: the text of the editor counts.
    editor.open(&graph, &text.replacen("present", "presnet", 1));
    let found = editor.diagnostics(&graph);
    let wrong = found.iter().find(|found| found["message"].as_str().unwrap().contains("presnet")).unwrap();
    assert_eq!(wrong["source"], "raxel");
    let line = text.lines().position(|line| line.starts_with("present")).unwrap();
    assert_eq!(wrong["range"]["start"], json!({ "line": line, "character": 0 }));
    assert!(wrong["message"].as_str().unwrap().contains("did you mean `present`?"), "{wrong}");
    editor.change(&graph, &text);
    assert_eq!(editor.diagnostics(&graph), [json!(null); 0]);

    // A mistake in a shader is reported in the shader; where two files disagree, both places are named.
    let source = std::fs::read_to_string(&shader).unwrap();
    editor.open(&shader, &source.replace("float sky_depth;", "int sky_depth;"));
    let found = editor.diagnostics(&graph);
    let related = found[0]["relatedInformation"].as_array().unwrap();
    assert!(related.iter().any(|place| place["location"]["uri"] == json!(address(&shader))), "{found:?}");
    editor.change(&shader, &source.replace("void main", "void mian"));
    assert!(!editor.diagnostics(&shader).is_empty());
    editor.ask("shutdown", json!(null));
    editor.tell("exit", json!(null));
    assert!(editor.child.finish().success());
}

/// TOML has single quotes, too.
#[test]
fn a_shader_is_checked_with_a_graph_that_names_it_in_single_quotes() {
    let project = Project::empty();
    project.write("graphs/one.toml", include_str!("../fixtures/lsp/single_quotes.toml"));
    let shader = project.path("shaders/fill.comp");
    let text = include_str!("../fixtures/lsp/single_quotes.comp");
    project.write("shaders/fill.comp", text);
    let mut editor = Editor::start(&project);
    editor.open(&shader, text);
    let found = editor.diagnostics(&shader);
    assert!(found[0]["message"].as_str().unwrap().contains("imageStore"), "{found:?}");
}

#[test]
fn requests_are_answered_while_every_shader_is_compiled() {
    let project = Project::shipped();
    let mut editor = Editor::start_with(&project, json!({ "window": { "workDoneProgress": true } }));
    let [shader, library] = ["shaders/inspect.comp", "shaders/include/raxel/world.glsl"].map(|path| project.path(path));
    let [text, included] = [&shader, &library].map(|path| std::fs::read_to_string(path).unwrap());
    // Nearly every shader includes the second, and nothing is kept of earlier compilations.
    editor.open(&library, &format!("{included}// changed\n"));
    editor.open(&shader, &text.replace("void main()", "void main(wrong)"));
    let progress = |editor: &mut Editor| loop {
        let message = editor.from.next();
        if message["method"] == "$/progress" {
            break message["params"]["value"]["kind"].as_str().unwrap().to_owned();
        }
    };
    assert_eq!(progress(&mut editor), "begin");
    let document = json!({ "uri": address(&shader) });
    let request = json!({ "textDocument": document });
    editor.send(&json!({ "jsonrpc": "2.0", "id": 77, "method": "textDocument/documentSymbol", "params": request }));
    let first = editor.from.next();
    assert_eq!(first["id"], json!(77), "diagnostics came first: {first}");
    assert_eq!(progress(&mut editor), "end");
    assert!(editor.diagnostics(&shader).iter().any(|found| found["severity"] == json!(1)));
}

/// Errors that the compiler finds in an edited shader come before its graphs are checked, and the check has them too. All else comes with the check.
#[test]
fn the_errors_of_an_edited_shader_come_first() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    // Four graphs run it: the server waits for a quiet moment before it checks them again.
    let shader = project.path("shaders/light/beauty/gloss.comp");
    let text = std::fs::read_to_string(&shader).unwrap();
    let wrong = |text: &str| format!("{text}float wrong = nowhere;\n");
    let codes = |found: &[Value]| found.iter().map(|found| found["code"].to_string()).collect::<BTreeSet<_>>();
    let [error, warning] = ["\"RX0210\"", "\"RX0211\""].map(str::to_owned);
    editor.open(&shader, &wrong(&text));
    let first = editor.diagnostics(&shader);
    assert_eq!(codes(&first), BTreeSet::from([error.clone()]), "{first:?}");

    // The error moves, and there is a warning too.
    let warned = text.replacen("#include", "#extension GL_NV_nothing : warn\n#include", 1);
    editor.change(&shader, &wrong(&warned));
    let looked = editor.diagnostics(&shader);
    assert_eq!(codes(&looked), BTreeSet::from([error.clone()]), "{looked:?}");
    assert_eq!(looked[0]["message"], first[0]["message"]);
    assert_ne!(looked[0]["range"], first[0]["range"]);
    let checked = editor.diagnostics(&shader);
    assert_eq!(codes(&checked), BTreeSet::from([error, warning.clone()]), "{checked:?}");
    assert!(checked.contains(&looked[0]), "{looked:?}\n{checked:?}");

    // Errors of the compiler are taken back at once.
    editor.change(&shader, &wrong(&text));
    assert_eq!(editor.diagnostics(&shader), first);
    editor.change(&shader, &warned);
    assert_eq!(editor.diagnostics(&shader), [json!(null); 0]);
    let checked = editor.diagnostics(&shader);
    assert_eq!(codes(&checked), BTreeSet::from([warning]), "{checked:?}");
    // All else is taken back by the check.
    editor.change(&shader, &text);
    assert_eq!(editor.diagnostics(&shader), [json!(null); 0]);
}

/// A shader that only a graph in a folder runs.
#[test]
fn a_shader_is_checked_with_the_graphs_that_run_it() {
    let project = Project::empty();
    project.write("graphs/deep/note.toml", NOTES).write("graphs/other.toml", NOTES.replace("note.comp", "other.comp"));
    project.write("shaders/note.comp", NOTE).write("shaders/other.comp", "no shader");
    let mut editor = Editor::start(&project);
    let shader = project.path("shaders/note.comp");
    for (wrong, count) in
        [(NOTE.replace("twice;", "thrice;"), 1), (NOTE.to_owned(), 0), (NOTE.replace("far(p", "fur(p"), 1)]
    {
        editor.open(&shader, &wrong);
        let found = loop {
            let found = editor.diagnostics(&shader);
            if found.len() == count {
                break found;
            }
        };
        let names =
            |found: &Value| ["thrice", "fur"].iter().any(|name| found["message"].as_str().unwrap().contains(name));
        assert!(found.iter().all(names), "{found:?}");
    }
}
