//! Bytes of targets come in files.

use std::fs;
use std::os::unix::fs::FileTypeExt;
use std::process::Command;

use serde_json::json;

use crate::common::{FullDisk, Project, Talk, command};
use crate::{Runs, SCENE, Stage};

#[test]
fn bytes_come_in_a_file() {
    for runs in [Runs::Requests, Runs::Window] {
        let mut stage = Stage::start(runs, &SCENE);
        stage.ask(json!({ "do": "pause" }));
        stage.pictured("a picture", |_| true);
        let path = stage.project.path("bytes");
        for request in [
            json!({ "do": "texels", "target": "depth" }),
            json!({ "do": "texels", "target": "hit" }),
            json!({ "do": "texels", "target": "normal" }),
            json!({ "do": "picture" }),
            json!({ "do": "buffer", "buffer": "world", "bytes": 64 }),
        ] {
            let mut text = stage.ask(request.clone());
            let data = text.as_object_mut().unwrap().remove("data").unwrap();
            let mut in_file = request.clone();
            in_file["path"] = json!(path);
            assert_eq!(stage.ask(in_file), text, "{request}");
            let expected = data_encoding::BASE64.decode(data.as_str().unwrap().as_bytes()).unwrap();
            assert!(!expected.is_empty() && fs::read(&path).unwrap() == expected, "{request}");
        }
        // Nothing else is left behind, and what cannot be written is refused.
        let files = fs::read_dir(stage.project.root()).unwrap().map(|entry| entry.unwrap().file_name());
        assert!(files.into_iter().all(|name| !name.to_string_lossy().starts_with(".raxel-")));
        let pipe = stage.project.path("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        for (path, said) in [
            (json!(pipe), "it is no regular file"),
            (json!("/dev/full"), "it is no regular file"),
            (json!(stage.project.root()), "it is a folder"),
            (json!(stage.project.path("none/bytes")), "does not exist"),
            (json!(""), "it names no file"),
        ] {
            let refused = stage.refused(json!({ "do": "texels", "target": "depth", "path": path }));
            assert!(refused.contains(said), "{refused}");
        }
        stage.ends();
    }
}

#[test]
fn a_full_disk_refuses_bytes_and_keeps_the_old_file() {
    let project = Project::shipped();
    let disk = FullDisk::with_room(1 << 10);
    let mut control = command(project.root(), &[&["control"][..], &SCENE].concat());
    let mut talk = Talk::start(disk.under(&mut control).env("RAXEL_CACHE", "off"));
    talk.ask(json!({ "do": "step" }));
    project.write("bytes", "old");
    let refused = talk.say(&json!({ "do": "texels", "target": "depth", "path": "bytes" }).to_string());
    let error = refused["error"].as_str().unwrap_or_default();
    assert!(error.contains("`bytes` cannot be written") && error.contains("No space left"), "{refused}");
    assert_eq!(fs::read_to_string(project.path("bytes")).unwrap(), "old");
    talk.ask(json!({ "do": "picture" }));
}
