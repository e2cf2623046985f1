//! A diagnostic brings the edit that mends it.

use std::path::Path;

use serde_json::json;

use crate::{Editor, NOTES, address, byte_at, edits_in, notes};

/// The line that the first fix of a text changes, as it is after it.
fn first_fix(editor: &mut Editor, graph: &Path, wrong: &str) -> String {
    editor.change(graph, wrong);
    let found = loop {
        let found = editor.diagnostics(graph);
        if found.iter().any(|found| found["message"].as_str().unwrap().contains("did you mean")) {
            break found;
        }
    };
    let params = json!({
        "textDocument": { "uri": address(graph) },
        "range": found[0]["range"],
        "context": { "diagnostics": found },
    });
    let actions = editor.ask("textDocument/codeAction", params);
    let edit = &edits_in(&actions[0]["edit"], graph)[0];
    let line = wrong.lines().nth(usize::try_from(edit["range"]["start"]["line"].as_u64().unwrap()).unwrap()).unwrap();
    let column = |end: &str| usize::try_from(edit["range"][end]["character"].as_u64().unwrap()).unwrap();
    [&line[..column("start")], edit["newText"].as_str().unwrap(), &line[column("end")..]].concat()
}

/// The fix is written as the file writes it: relative to the folder of shaders, or to that of the graph.
#[test]
fn a_file_that_is_not_there_brings_the_name_of_one_that_is() {
    // The pass is called `note`, too.
    for wrong in ["nota.comp", "old/note.comp", "shaders/note.comp", "note"] {
        let (_project, mut editor, graph, _) = notes();
        let text = NOTES.replace("\"note.comp\"", &format!("{wrong:?}"));
        assert_ne!(text, NOTES);
        let fixed = first_fix(&mut editor, &graph, &text);
        assert_eq!(fixed.split('"').nth(1), Some("note.comp"), "{wrong}: {fixed}");
    }
    for wrong in ["note.toml", "../noet.toml"] {
        let (project, mut editor, ..) = notes();
        project.write("graphs/deep/deep.toml", "");
        let deep = project.path("graphs/deep/deep.toml");
        editor.open(&deep, "");
        assert_eq!(first_fix(&mut editor, &deep, &format!("extends = {wrong:?}\n")), "extends = \"../note.toml\"");
    }
}

/// The thing that the message names may stand in another line than the place that it points at, or within the name of a source.
#[test]
fn a_model_a_file_and_a_default_that_are_not_there_bring_their_fix() {
    let (project, mut editor, graph, _) = notes();
    project.copy_folder("textures");
    let wrong = NOTES.replace("[[passes]]", "[targets.page]\nsource = \"file.textures/tils.png\"\n[[passes]]");
    assert_eq!(first_fix(&mut editor, &graph, &wrong), "source = \"file.textures/tiles.png\"");

    let manifest = project.path("raxel.toml");
    std::fs::write(&manifest, "").unwrap();
    editor.open(&manifest, "");
    assert_eq!(first_fix(&mut editor, &manifest, "graph = \"noet.toml\"\n"), "graph = \"note.toml\"");
    assert_eq!(first_fix(&mut editor, &manifest, "grahp = \"note.toml\"\n"), "graph = \"note.toml\"");

    project.copy_folder("worlds/models");
    let world = "[models.pine]\nfile = \"models/pine.vox\"\n[[build]]\nop = \"model\"\nmodel = \"pine\"\n";
    project
        .write("worlds/trees.toml", world)
        .write("worlds/trees.demo.toml", "graph = \"note.toml\"\nworld = \"trees.toml\"\nduration = 1.0\n");
    let demo = project.path("worlds/trees.demo.toml");
    editor.open(&demo, &std::fs::read_to_string(&demo).unwrap());
    let wrong = NOTES.replace("[[passes]]", "[buffers.tree]\nsource = \"model.pien.tree64\"\n[[passes]]");
    assert_eq!(first_fix(&mut editor, &graph, &wrong), "source = \"model.pine.tree64\"");

    // A sound is named relative to the demo.
    let hears = |file: &str| {
        format!("graph = \"note.toml\"\nworld = \"trees.toml\"\nduration = 1.0\n[inputs]\nmicrophone = \"{file}\"\n")
    };
    let wrong = hears("../textures/nots.ogg");
    assert_eq!(first_fix(&mut editor, &demo, &wrong), "microphone = \"../textures/notes.ogg\"");
}

#[test]
fn diagnostics_bring_their_fix_and_push_values_their_type() {
    let (_project, mut editor, graph, _) = notes();
    let wrong = NOTES.replace("\"param.speed\"", "\"param.sped\"");
    assert_eq!(first_fix(&mut editor, &graph, &wrong), "push = { time = \"param.speed\" }");
    let all = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let hints =
        editor.ask("textDocument/inlayHint", json!({ "textDocument": { "uri": address(&graph) }, "range": all }));
    assert_eq!(hints.as_array().map(Vec::len), Some(1), "{hints}");
    assert_eq!((&hints[0]["label"], &hints[0]["position"]["line"]), (&json!(": float"), &json!(12)));
}

#[test]
fn what_a_shader_lacks_or_does_not_use_is_added_and_removed() {
    let (_project, mut editor, graph, _) = notes();
    let wrong = NOTES
        .replace("{ outColor = \"color\" }", "{ outColor = \"color\", extra = \"color\" }")
        .replace("{ time = \"param.speed\" }", "{ }");
    editor.change(&graph, &wrong);
    let found = loop {
        let found = editor.diagnostics(&graph);
        if found.len() == 2 {
            break found;
        }
    };
    let params = json!({
        "textDocument": { "uri": address(&graph) },
        "range": found[0]["range"],
        "context": { "diagnostics": found },
    });
    let actions = editor.ask("textDocument/codeAction", params);
    let mut titles: Vec<&str> =
        actions.as_array().unwrap().iter().map(|action| action["title"].as_str().unwrap()).collect();
    titles.sort_unstable();
    assert_eq!(titles, ["Add `time = 0.0` to `push`", "Remove `extra`"], "{actions}");
    for action in actions.as_array().unwrap() {
        let edits: Vec<_> = action["edit"]["changes"][address(&graph)].as_array().unwrap().clone();
        let edit = &edits[0];
        let mut text = wrong.clone();
        text.replace_range(
            byte_at(&text, &edit["range"]["start"])..byte_at(&text, &edit["range"]["end"]),
            edit["newText"].as_str().unwrap(),
        );
        let left = if action["title"] == "Remove `extra`" {
            "bind = { outColor = \"color\" }"
        } else {
            "push = { time = 0.0 }"
        };
        assert!(text.contains(left), "{text}");
    }
}
