//! The verbs about saves, over a save that a session left.

mod common;

use common::{Project, RunRaxel};
use raxel::edit::{Brush, Operation};
use raxel::{Options, Saves, Session};

/// A session over the quarry of a project, with its save open.
fn open(project: &Project) -> Session {
    let options = Options {
        project: Some(project.root().to_owned()),
        world: Some("worlds/quarry.toml".into()),
        size: [32, 18],
        saves: Saves::Write,
        ..Options::default()
    };
    Session::open(options).unwrap_or_else(|error| panic!("{error}"))
}

/// A project whose quarry was dug in: one checkpoint, and edits after it.
fn dug() -> Project {
    let project = Project::shipped();
    let mut session = open(&project);
    let slate = session.scene().material("slate").unwrap();
    for n in 0..6 {
        let center = [f64::from(n) * 30.0 - 60.0, 10.0, 0.0];
        session.edit(&[Operation::sphere(center, 9.0, Brush::Subtract)]).unwrap();
        session.edit(&[Operation::sphere(center, 4.0, Brush::Add(slate))]).unwrap();
        if n == 3 {
            session.checkpoint();
        }
    }
    session.frame().unwrap();
    project
}

#[test]
fn a_save_is_verified_compacted_packed_and_exported() {
    let project = dug();
    let json = |arguments: &[&str]| {
        let with_format: Vec<&str> = arguments.iter().copied().chain(["--format", "json"]).collect();
        project.raxel(&with_format).exits(0).json().remove(0)
    };
    let report = json(&["world", "verify", "worlds/quarry.toml"]);
    assert_eq!(report["newest"], 12);
    assert_eq!(report["applied"], 8);
    assert_eq!(report["damages"], serde_json::json!([]));
    let solids = |world: &str| json(&["world", "info", world])["info"]["solids"].as_u64().unwrap();
    // The file's own world, and the one with the edits.
    let as_built = solids("worlds/quarry.toml");
    project.raxel(&["world", "export", "worlds/quarry.toml", "-o", "dug.vox"]).exits(0);
    project.raxel(&["world", "import", "dug.vox"]).exits(0);
    assert!(solids("worlds/dug.toml") < as_built - 10_000);

    // First all edits go into the chunks, then replaced chunks are dropped.
    let saved = json(&["world", "save", "worlds/quarry.toml"]);
    assert_eq!(saved["applied"], 12);
    assert_eq!(saved["newest"], 12);
    assert!(saved["replaced"].as_u64().unwrap() > 0);
    let compacted = json(&["world", "compact", "worlds/quarry.toml"]);
    assert!(compacted["after"].as_u64() < compacted["before"].as_u64(), "{compacted}");
    assert_eq!(json(&["world", "verify", "worlds/quarry.toml"])["replaced"], 0);

    // One file, which is a save elsewhere.
    project.raxel(&["world", "pack", "worlds/quarry.toml", "-o", "quarry.save"]).exits(0);
    std::fs::remove_dir_all(project.path("saves/quarry")).unwrap();
    project.raxel(&["world", "verify", "worlds/quarry.toml"]).exits(2);
    project.write("saves/quarry/chunks.log", std::fs::read(project.path("quarry.save")).unwrap());
    assert_eq!(json(&["world", "verify", "worlds/quarry.toml"])["newest"], 12);

    // While another has the save open, it can be read and not be written.
    let session = open(&project);
    for verb in ["save", "compact"] {
        let refused = project.raxel(&["world", verb, "worlds/quarry.toml"]).exits(3);
        assert!(refused.stderr.contains("RX0352") && refused.stderr.contains("another process"), "{}", refused.stderr);
    }
    project.raxel(&["world", "verify", "worlds/quarry.toml"]).exits(0);
    drop(session);

    // A flipped byte within a chunk.
    let path = project.path("saves/quarry/chunks.log");
    let mut bytes = std::fs::read(&path).unwrap();
    let at = bytes.len() / 2;
    bytes[at] ^= 4;
    std::fs::write(&path, bytes).unwrap();
    let broken = project.raxel(&["world", "verify", "worlds/quarry.toml"]).exits(1);
    let said = format!("{}{}", broken.stdout, broken.stderr);
    assert!(said.contains("RX0355") && said.contains("the chunk at"), "{said}");
    let picture =
        project.raxel(&["render", "--world", "worlds/quarry.toml", "--size", "32x18", "-o", "p.png"]).exits(0);
    assert!(picture.stderr.contains("RX0355"), "{}", picture.stderr);

    // An output that cannot be written is named.
    for arguments in
        [&["world", "pack", "worlds/quarry.toml", "-o", "rest.save"][..], &["world", "compact", "worlds/quarry.toml"]]
    {
        let done = project.raxel(arguments).exits(0);
        assert!(done.stderr.contains("left out: chunks.log: bytes"), "{}", done.stderr);
    }
    project.raxel(&["world", "verify", "worlds/quarry.toml"]).exits(0);
}

#[test]
fn worlds_without_a_save_say_so() {
    let project = Project::shipped();
    let none = project.raxel(&["world", "verify", "worlds/valley.toml"]).exits(2);
    assert!(none.stderr.contains("has no save"), "{}", none.stderr);
    let nothing = project.raxel(&["world", "verify", "worlds/quarry.toml"]).exits(2);
    assert!(nothing.stderr.contains("nothing was saved yet"), "{}", nothing.stderr);
    project.edit("worlds/quarry.toml", "path = \"saves/quarry\"", "path = \"../elsewhere\"");
    let outside = project.raxel(&["check", "worlds/quarry.toml"]).exits(3);
    assert!(outside.stdout.contains("RX0005"), "{}", outside.stdout);
}

#[test]
fn a_save_has_a_folder_of_its_own() {
    let project = Project::shipped();
    let place = |path: &str| {
        let text = std::fs::read_to_string(project.path("worlds/quarry.toml")).unwrap();
        let start = text.find("path = \"").unwrap() + 8;
        let end = start + text[start..].find('"').unwrap();
        project.write("worlds/quarry.toml", format!("{}{path}{}", &text[..start], &text[end..]));
    };
    project.write("raxel.toml", "world = \"quarry.toml\"\n");
    // A file, a place in a file, and folders with other things in them.
    for (path, what) in [
        ("raxel.toml", "raxel.toml` is a file"),
        ("raxel.toml/save", "raxel.toml` is a file"),
        ("worlds", "holds other things and no save"),
    ] {
        place(path);
        let before = project.files();
        let checked = project.raxel(&["check", "worlds/quarry.toml"]).exits(3);
        assert!(checked.stdout.contains("RX0359") && checked.stdout.contains(what), "{path}\n{}", checked.stdout);
        for arguments in [
            &["world", "save", "worlds/quarry.toml"][..],
            &["render", "--world", "worlds/quarry.toml", "--size", "32x18", "-o", "p.png"],
        ] {
            let refused = project.raxel(arguments).exits(3);
            assert!(refused.stderr.contains("RX0359") && refused.stderr.contains(what), "{path}\n{}", refused.stderr);
        }
        assert_eq!(project.files(), before, "{path}");
    }
    // No folder yet, and a folder with hidden files only; then one with a save.
    project.write("saves/hidden/.gitignore", "*\n");
    for path in ["saves/none/yet", "saves/hidden"] {
        place(path);
        for _ in 0..2 {
            project.raxel(&["check", "worlds/quarry.toml"]).exits(0);
            drop(open(&project));
        }
    }
}
