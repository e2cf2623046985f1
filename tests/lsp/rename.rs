//! A name is followed to all its uses, and changed in all of them.

use std::path::Path;

use serde_json::{Value, json};

use crate::common::{Project, RunRaxel};
use crate::{Editor, NOTE, NOTES, address, byte_at, edits_in, notes};

#[test]
fn names_are_followed_and_changed_across_shaders_and_graphs() {
    let (project, mut editor, graph, shader) = notes();
    let at = |text: &str, of: &str, skip: usize| {
        let byte = text.match_indices(of).nth(skip).unwrap().0;
        let line = text[..byte].matches('\n').count();
        json!({ "line": line, "character": text[..byte].rsplit('\n').next().unwrap().len() })
    };
    let rename = |editor: &mut Editor, file: &Path, position: &Value, new: &str| {
        let params = json!({ "textDocument": { "uri": address(file) }, "position": position, "newName": new });
        editor.ask("textDocument/rename", params)
    };
    // A parameter, and not the local of the same name elsewhere.
    let edit = rename(&mut editor, &shader, &at(NOTE, "near", 0), "close");
    let lines: Vec<u64> =
        edits_in(&edit, &shader).iter().map(|edit| edit["range"]["start"]["line"].as_u64().unwrap()).collect();
    assert_eq!(lines, [5, 6]);
    // A binding, from the shader and from a graph: in both, and in a graph that extends it.
    for (file, position) in [(&shader, at(NOTE, "outColor", 1)), (&graph, at(NOTES, "outColor", 0))] {
        let edit = rename(&mut editor, file, &position, "picture");
        assert_eq!(edits_in(&edit, &shader).len(), 2, "{edit}");
        assert_eq!(edits_in(&edit, &graph).len(), 1, "{edit}");
        assert_eq!(edits_in(&edit, &project.path("graphs/more.toml")).len(), 1, "{edit}");
    }
    // A param, in the graph that declares it and in the one that extends it.
    let edit = rename(&mut editor, &graph, &at(NOTES, "speed", 1), "rate");
    assert_eq!(edits_in(&edit, &graph).len(), 2, "{edit}");
    assert_eq!(edits_in(&edit, &project.path("graphs/more.toml")).len(), 1, "{edit}");
    let params = json!({ "textDocument": { "uri": address(&shader) }, "position": at(NOTE, "far", 1), "context": { "includeDeclaration": true } });
    assert_eq!(editor.ask("textDocument/references", params).as_array().map(Vec::len), Some(2));
    // An impossible name is refused with a reason, and half a text does not stop it.
    for (position, new, reason) in [
        (at(NOTE, "outColor", 0), "2d", "is no name"),
        (at(NOTE, "outColor", 0), "image2D", "is a name of GLSL"),
        (at(NOTE, "outColor", 0), "far", "is a name in"),
        (at(NOTE, "imageStore", 0), "store", "is a name of GLSL"),
    ] {
        let params = json!({ "textDocument": { "uri": address(&shader) }, "position": position, "newName": new });
        let refused = editor.refused("textDocument/rename", params);
        assert!(refused.contains(reason), "{refused}");
    }
    editor.change(&shader, "void main( { float a = ");
    let place = json!({ "textDocument": { "uri": address(&shader) }, "position": { "line": 0, "character": 19 }, "newName": "b" });
    editor.ask("textDocument/rename", place);
}

/// A graph may extend one of another folder and change its param; a world may move instances by it.
#[test]
fn a_param_is_renamed_in_every_folder_that_overrides_or_uses_it() {
    let project = Project::empty();
    project.write("shaders/note.comp", NOTE).write("graphs/base/note.toml", NOTES);
    let over = "extends = \"../base/note.toml\"\n[params.speed]\ndefault = 2.0\n";
    project.write("graphs/top/note.toml", over).write("graphs/top.toml", over.replace("..", "."));
    project.write("graphs/base/alone.toml", NOTES);
    project.write("worlds/note.toml", "[[instances]]\nturn = { param = \"speed\" }\n");
    project.write("worlds/shots/note.demo.toml", "graph = \"base/note.toml\"\n[tracks.speed]\nkeys = [[0, 1]]\n");
    let changed = ["graphs/base/note.toml", "graphs/top/note.toml", "graphs/top.toml", "worlds/shots/note.demo.toml"];
    for from in changed {
        let mut editor = Editor::start(&project);
        let (file, text) = (project.path(from), std::fs::read_to_string(project.path(from)).unwrap());
        let rename = |editor: &mut Editor| {
            let place = editor.place(&file, &text.replacen("speed", "spe|ed", 1));
            editor.answer(
                "textDocument/rename",
                json!({ "textDocument": place["textDocument"], "position": place["position"], "newName": "rate" }),
            )
        };
        editor.open(&file, &text);
        // The world may run over two graphs, whose params have nothing in common but their name.
        project.write("graphs/base/alone.toml", NOTES);
        let refused = rename(&mut editor);
        assert!(refused["error"]["message"].as_str().is_some_and(|told| told.contains("alone.toml")), "{refused}");
        std::fs::remove_file(project.path("graphs/base/alone.toml")).unwrap();
        let edit = &rename(&mut editor)["result"];
        for (path, count) in changed.into_iter().zip([2, 1, 1, 1]).chain([("worlds/note.toml", 1)]) {
            assert_eq!(edits_in(edit, &project.path(path)).len(), count, "{path}, from {from}: {edit}");
        }
    }
}

/// Makes the changes of a rename in the files.
fn apply(edit: &Value) {
    for (uri, edits) in edit["changes"].as_object().unwrap() {
        let path = Path::new(uri.strip_prefix("file://").unwrap());
        let mut text = std::fs::read_to_string(path).unwrap();
        let mut edits: Vec<(std::ops::Range<usize>, &str)> = edits
            .as_array()
            .unwrap()
            .iter()
            .map(|edit| {
                let place = byte_at(&text, &edit["range"]["start"])..byte_at(&text, &edit["range"]["end"]);
                (place, edit["newText"].as_str().unwrap())
            })
            .collect();
        edits.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
        for (place, new) in edits {
            text.replace_range(place, new);
        }
        std::fs::write(path, text).unwrap();
    }
}

#[test]
fn every_name_of_the_examples_can_be_changed() {
    let project = Project::shipped();
    project.copy_folder("textures");
    let mut editor = Editor::start(&project);
    let examples = std::fs::read_dir(project.path("graphs/examples")).unwrap();
    let mut graphs: Vec<_> = examples.map(|entry| entry.unwrap().path()).collect();
    graphs.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    graphs.sort();
    let mut changed = 0;
    for graph in &graphs {
        editor.open(graph, &std::fs::read_to_string(graph).unwrap());
        let document = json!({ "textDocument": { "uri": address(graph) } });
        let names = |editor: &mut Editor| {
            editor.ask("textDocument/documentSymbol", document.clone()).as_array().unwrap().clone()
        };
        for number in 0..names(&mut editor).len() {
            let symbol = &names(&mut editor)[number];
            let name = symbol["name"].as_str().unwrap();
            let params = json!({ "textDocument": { "uri": address(graph) }, "position": symbol["selectionRange"]["start"], "newName": format!("{name}_2") });
            let answer = editor.answer("textDocument/rename", params);
            if answer["error"].is_null() {
                assert!(!edits_in(&answer["result"], graph).is_empty(), "{name} of {}: {answer}", graph.display());
                apply(&answer["result"]);
                editor.change(graph, &std::fs::read_to_string(graph).unwrap());
                changed += 1;
            } else {
                // A block, or a param of two graphs by which one world moves its instances.
                let is_block = std::fs::read_to_string(graph).unwrap().contains(&format!("[blocks.{name}]"));
                let is_shared = answer["error"]["message"].as_str().unwrap().starts_with("`worlds/fair.toml` means");
                assert!(is_block || is_shared, "{name}: {answer}");
            }
        }
        editor.tell("textDocument/didClose", document);
    }
    assert!(changed > 100, "{changed}");
    let folder = project.root().canonicalize().unwrap();
    let paths =
        graphs.iter().map(|graph| graph.canonicalize().unwrap().strip_prefix(&folder).unwrap().display().to_string());
    let arguments: Vec<String> = std::iter::once("check".to_owned()).chain(paths).collect();
    project.raxel(&arguments.iter().map(String::as_str).collect::<Vec<_>>()).exits(0);
}

#[test]
fn members_are_followed_and_changed_across_shaders_and_graphs() {
    let (project, mut editor, graph, shader) = notes();
    let member = NOTE.find("float time").unwrap() + "float ".len();
    let use_of = NOTE.find("push.time").unwrap() + "push.".len();
    let key = NOTES.find("time =").unwrap();
    for (file, text, at) in [(&shader, NOTE, member), (&shader, NOTE, use_of), (&graph, NOTES, key)] {
        let line = text[..at].matches('\n').count();
        let character = text[..at].rsplit('\n').next().unwrap().len();
        let params = json!({ "textDocument": { "uri": address(file) }, "position": { "line": line, "character": character }, "newName": "seconds" });
        let edit = editor.ask("textDocument/rename", params);
        assert_eq!(edits_in(&edit, &shader).len(), 2, "{edit}");
        assert_eq!(edits_in(&edit, &graph).len(), 1, "{edit}");
        assert_eq!(edits_in(&edit, &project.path("graphs/more.toml")).len(), 1, "{edit}");
    }
}
