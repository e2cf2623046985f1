//! Other files are opened; presets, values and cameras are written into files and restored.

use serde_json::{Value, json};

use crate::common::Project;
use crate::{Runs, SCENE, Stage};

#[test]
fn another_file_opens_in_place_of_what_runs() {
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &SCENE);
        let broken = stage.read("graphs/inspect.toml").replace("outDepth = \"depth\"", "outDepth = \"dept\"");
        stage.project.write("graphs/broken.toml", &broken);
        let files = stage.ask(json!({ "do": "files" }))["files"].clone();
        for (kind, path, runs) in [
            ("graph", "graphs/inspect.toml", true),
            ("graph", "graphs/broken.toml", false),
            ("world", "worlds/menger.toml", true),
            ("demo", "worlds/sponge.demo.toml", false),
        ] {
            let file = json!({ "kind": kind, "path": path, "runs": runs });
            assert!(files.as_array().unwrap().contains(&file), "{file}: {files}");
        }
        let refused = stage.refused(json!({ "do": "open", "path": "graphs/inspekt.toml" }));
        assert!(refused.contains("did you mean `graphs/inspect.toml`"), "{refused}");
        // With mistakes, the old files run on.
        let wrong = stage.ask(json!({ "do": "open", "path": "graphs/broken.toml" }));
        assert_eq!((&wrong["opened"], &wrong["diagnostics"][0]["code"]), (&json!(false), &json!("RX0100")), "{wrong}");
        assert_eq!(stage.ask(json!({ "do": "info" }))["graph"], "graphs/inspect.toml");
        let opened = stage.ask(json!({ "do": "open", "path": "worlds/sponge.demo.toml" }));
        assert_eq!((&opened["opened"], &opened["diagnostics"]), (&json!(true), &json!([])), "{opened}");
        let info = stage.ask(json!({ "do": "info" }));
        assert_eq!((&info["demo"], &info["graph"]), (&json!("worlds/sponge.demo.toml"), &json!("graphs/inspect.toml")));
        // A graph ends the demo, and runs over its world.
        stage.project.write("graphs/broken.toml", broken.replace("\"dept\"", "\"depth\""));
        assert_eq!(stage.ask(json!({ "do": "open", "path": "graphs/broken.toml" }))["opened"], json!(true));
        let info = stage.ask(json!({ "do": "info" }));
        assert_eq!((&info["demo"], &info["world"]), (&Value::Null, &json!("worlds/menger.toml")));
        assert_eq!(info["graph"], "graphs/broken.toml");
        stage.ends();
    }
}

/// A graph that inherits the param `sky_depth`.
fn with_child(project: &Project) {
    project.write("graphs/child.toml", "extends = \"inspect.toml\"\nname = \"child\"\n");
}

const CHILD: [&str; 5] = ["graphs/child.toml", "--world", "worlds/menger.toml", "--size", "32x18"];

#[test]
fn presets_are_kept_and_applied() {
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &SCENE);
        assert_eq!(stage.ask(json!({ "do": "presets" }))["presets"], json!([]));
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 50 }));
        let saved = stage.ask(json!({ "do": "save_preset", "name": "far" }));
        assert_eq!(saved["path"], ".raxel/presets.toml", "{saved}");
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 70 }));
        let far = json!([{ "name": "far", "values": { "sky_depth": [50.0] } }]);
        assert_eq!(stage.ask(json!({ "do": "presets" }))["presets"], far);
        let applied = stage.ask(json!({ "do": "apply_preset", "name": "far" }));
        assert_eq!((&applied["changed"], &applied["left"]), (&json!(["sky_depth"]), &json!([])), "{applied}");
        assert_eq!(stage.ask(json!({ "do": "info" }))["params"][0]["value"], json!(50.0));
        // A user adds a param that the graph does not have.
        stage.project.edit(".raxel/presets.toml", "sky_depth = ", "gone = [1]\nsky_depth = ");
        let applied = stage.ask(json!({ "do": "apply_preset", "name": "far" }));
        assert_eq!((&applied["changed"], &applied["left"]), (&json!([]), &json!(["gone"])), "{applied}");
        for wrong in ["apply_preset", "delete_preset"] {
            let refused = stage.refused(json!({ "do": wrong, "name": "fahr" }));
            assert!(refused.contains("no preset `fahr`") && refused.contains("`far`"), "{refused}");
        }
        assert!(stage.refused(json!({ "do": "save_preset", "name": " " })).contains("`name` is empty"));
        let before = stage.read(".raxel/presets.toml");
        stage.ask(json!({ "do": "delete_preset", "name": "far" }));
        assert_eq!(stage.ask(json!({ "do": "presets" }))["presets"], json!([]));
        assert_eq!(stage.ask(json!({ "do": "undo_write" }))["files"], json!([".raxel/presets.toml"]));
        assert_eq!(stage.read(".raxel/presets.toml"), before);
        // A file that is no table of presets stays as it is.
        stage.project.write(".raxel/presets.toml", "\"graphs/inspect.toml\" = 3\n");
        assert!(stage.refused(json!({ "do": "save_preset", "name": "far" })).contains("must be a table"));
        stage.ends();
    }
}

#[test]
fn values_are_written_into_files_and_restored() {
    for runs in [Runs::Requests, Runs::Window] {
        let project = Project::shipped();
        with_child(&project);
        let mut stage = Stage::over(project, runs, &CHILD);
        let [child, inspect] = ["graphs/child.toml", "graphs/inspect.toml"].map(|path| stage.read(path));
        assert_eq!(stage.ask(json!({ "do": "undo_write" }))["files"], json!([]));
        let refused = stage.refused(json!({ "do": "write_params", "params": ["sky_dpeth"] }));
        assert!(refused.contains("did you mean `sky_depth`"), "{refused}");
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 50 }));
        let written = stage.write(json!({ "do": "write_params", "params": ["sky_depth"] }));
        let file = json!([{ "path": "graphs/child.toml", "params": ["sky_depth"], "changed": true }]);
        assert_eq!((&written["files"], &written["refused"]), (&file, &json!([])), "{written}");
        assert_eq!(stage.read("graphs/child.toml"), format!("{child}\n[params.sky_depth]\ndefault = 50.0\n"));
        // The param follows its file from here on.
        let value = |stage: &mut Stage| stage.ask(json!({ "do": "info" }))["params"][0]["value"].clone();
        stage.talk.reloaded(|| {
            stage.project.edit("graphs/child.toml", "50.0", "51.0");
        });
        assert_eq!(value(&mut stage), json!(51.0));
        assert!(stage.refused(json!({ "do": "undo_write" })).contains("edited since"));
        stage.project.write("graphs/child.toml", &child);
        stage.ask(json!({ "do": "wait_reload", "seconds": 60, "after": written["generation"].as_u64().unwrap() + 2 }));

        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 52 }));
        let written = stage.write(json!({ "do": "write_params", "params": ["sky_depth"], "to": "declared" }));
        assert_eq!(written["files"][0]["path"], "graphs/inspect.toml", "{written}");
        assert_eq!(stage.read("graphs/inspect.toml"), inspect.replacen("default = 0.0", "default = 52.0", 1));
        assert_eq!(stage.read("graphs/child.toml"), child);
        // The file is restored, and the session has the value as before the write.
        let undone = stage.write(json!({ "do": "undo_write" }));
        assert_eq!(undone["files"], json!(["graphs/inspect.toml"]));
        assert_eq!(stage.read("graphs/inspect.toml"), inspect);
        assert_eq!(value(&mut stage), json!(52.0));

        let world = stage.read("worlds/menger.toml");
        stage.ask(json!({ "do": "camera", "position": [1, 2, 3], "yaw": 30, "pitch": 0, "fov": 60 }));
        for wrong in ["", "a b", "a.b"] {
            let refused = stage.refused(json!({ "do": "write_camera", "name": wrong }));
            assert!(refused.contains("cannot be the name of a camera"), "{refused}");
        }
        let written = stage.write(json!({ "do": "write_camera", "name": "roof" }));
        assert_eq!((&written["path"], &written["changed"]), (&json!("worlds/menger.toml"), &json!(true)));
        let lines = "[cameras.roof]\nposition = [1.0, 2.0, 3.0]\nyaw = 30.0\npitch = 0.0\nfov = 60.0\n";
        assert!(stage.read("worlds/menger.toml").contains(lines), "{}", stage.read("worlds/menger.toml"));
        stage.ask(json!({ "do": "camera", "name": "roof" }));
        stage.write(json!({ "do": "undo_write" }));
        assert_eq!(stage.read("worlds/menger.toml"), world);
        stage.ends();
    }
}

/// A graph that needs no world.
const PLAIN_GRAPH: &str = include_str!("../fixtures/control_work/plain.toml");

const PLAIN_SHADER: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8) uniform writeonly image2D color;
void main() { imageStore(color, ivec2(gl_GlobalInvocationID.xy), vec4(1.0)); }
";

#[test]
fn the_empty_world_has_no_file_for_a_camera() {
    let project = Project::empty();
    project.write("graphs/plain.toml", PLAIN_GRAPH).write("shaders/plain.comp", PLAIN_SHADER);
    let mut stage = Stage::over(project, Runs::Requests, &["graphs/plain.toml", "--size", "32x18"]);
    assert_eq!(stage.ask(json!({ "do": "info" }))["world"], Value::Null);
    assert!(stage.refused(json!({ "do": "write_camera", "name": "a" })).contains("empty world"));
    assert!(stage.refused(json!({ "do": "record_params" })).contains("a demo needs a world"));
    for request in [
        json!({ "do": "keys" }),
        json!({ "do": "move_key", "track": "camera", "key": 0, "to": 1 }),
        json!({ "do": "delete_key", "track": "camera", "key": 0 }),
        json!({ "do": "write_key" }),
    ] {
        let refused = stage.refused(request);
        assert!(refused.contains("no demo runs") && refused.contains("`open` opens one"), "{refused}");
    }
    stage.ends();
}

#[test]
fn a_value_that_is_set_after_the_write_stays() {
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &SCENE);
        let before = stage.read("graphs/inspect.toml");
        let value = |stage: &mut Stage| stage.ask(json!({ "do": "info" }))["params"][0]["value"].clone();
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 50 }));
        let written = stage.ask(json!({ "do": "write_params", "params": ["sky_depth"] }));
        stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 60 }));
        let told = stage.ask(json!({ "do": "wait_reload", "seconds": 60, "after": written["generation"] }));
        assert_eq!(told["reloaded"], json!(true), "{told}");
        assert_eq!(value(&mut stage), json!(60.0));
        // Nor does undo take it.
        stage.write(json!({ "do": "undo_write" }));
        assert_eq!((stage.read("graphs/inspect.toml"), value(&mut stage)), (before, json!(60.0)));
        stage.ends();
    }
}

#[test]
fn files_that_were_edited_since_are_not_restored() {
    for runs in [Runs::Requests, Runs::Window] {
        let project = Project::shipped();
        let more = "[params.more]\ntype = \"f32\"\ndefault = 1.0\nrange = [0.0, 10.0]\n";
        project.write("graphs/child.toml", format!("extends = \"inspect.toml\"\nname = \"child\"\n\n{more}"));
        let mut stage = Stage::over(project, runs, &CHILD);
        let [child, inspect] = ["graphs/child.toml", "graphs/inspect.toml"].map(|path| stage.read(path));
        let write = |stage: &mut Stage| {
            stage.ask(json!({ "do": "set", "param": "sky_depth", "value": 50 }));
            stage.ask(json!({ "do": "set", "param": "more", "value": 2 }));
            let request = json!({ "do": "write_params", "params": ["sky_depth", "more"], "to": "declared" });
            let written = stage.ask(request);
            assert_eq!(written["files"].as_array().unwrap().len(), 2, "{written}");
            ["graphs/child.toml", "graphs/inspect.toml"].map(|path| stage.read(path))
        };

        // Refused, until one of them is as it was written.
        let [written_child, written_inspect] = write(&mut stage);
        stage.project.edit("graphs/child.toml", "default = 2.0", "default = 3.0");
        stage.project.edit("graphs/inspect.toml", "default = 50.0", "default = 51.0");
        let refused = stage.refused(json!({ "do": "undo_write" }));
        assert!(refused.contains("child.toml has been edited since"), "{refused}");
        assert!(refused.contains("inspect.toml has been edited since"), "{refused}");
        stage.project.write("graphs/child.toml", &written_child).write("graphs/inspect.toml", &written_inspect);
        let undone = stage.ask(json!({ "do": "undo_write" }));
        let files = json!(["graphs/inspect.toml", "graphs/child.toml"]);
        assert_eq!((&undone["files"], &undone["refused"]), (&files, &json!([])), "{undone}");
        assert_eq!([stage.read("graphs/child.toml"), stage.read("graphs/inspect.toml")], [child, inspect.clone()]);

        // The answer names the file that stays.
        write(&mut stage);
        stage.project.edit("graphs/child.toml", "default = 2.0", "default = 3.0");
        let undone = stage.ask(json!({ "do": "undo_write" }));
        assert_eq!(undone["files"], json!(["graphs/inspect.toml"]), "{undone}");
        let refused = undone["refused"].as_array().unwrap();
        assert!(refused.len() == 1 && refused[0].as_str().unwrap().contains("child.toml has been edited"), "{undone}");
        assert!(stage.read("graphs/child.toml").contains("default = 3.0"));
        assert_eq!(stage.read("graphs/inspect.toml"), inspect);
        assert_eq!(stage.ask(json!({ "do": "undo_write" }))["files"], json!([]));
        stage.ends();
    }
}
