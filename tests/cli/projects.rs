//! Projects are made, listed, filled and cleaned.

use crate::common::{Project, RunRaxel, raxel, raxel_in};

#[test]
fn a_new_project_checks_and_a_full_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for template in ["voxel", "minimal"] {
        let path = folder.path().join(template);
        let name = path.to_str().unwrap();
        raxel(&["new", name, "--template", template]).exits(0);
        assert!(path.join(".raxel/graph.schema.json").is_file());
        let run = raxel_in(&path, &["check"]).exits(0);
        assert!(run.stdout.is_empty(), "{}", run.stdout);
        let again = raxel(&["new", name]).exits(2);
        assert!(again.stderr.contains("is not empty"));
        for file in ["raxel.toml", "README.md", "graphs/primary.toml", "shaders/primary.comp", "worlds/valley.toml"] {
            let Ok(text) = std::fs::read_to_string(path.join(file)) else { continue };
            for named in named_files(&text) {
                let folders = ["", "graphs", "shaders", "worlds"];
                assert!(folders.iter().any(|folder| path.join(folder).join(&named).exists()), "{file} names {named}");
            }
        }
    }
}

/// The paths with a folder that a text names, but those of the shader library and of a command that prints it.
fn named_files(text: &str) -> Vec<String> {
    let is_path = |c: char| c.is_alphanumeric() || "/._-*".contains(c);
    let words = text.split(|c: char| !is_path(c)).map(|word| word.trim_matches('.'));
    let is_file = |word: &&str| {
        let extension = word.rsplit_once('.').map(|(_, extension)| extension);
        word.contains('/') && !word.contains('*') && matches!(extension, Some("md" | "glsl" | "comp" | "toml"))
    };
    words.filter(is_file).filter(|word| !word.starts_with("raxel/")).map(str::to_owned).collect()
}

#[test]
fn the_manifest_says_what_runs_by_default() {
    let project = Project::shipped();
    project.write("raxel.toml", "graph = 'inspect.toml'\nworld = 'menger.toml'\nsize = [64, 36]\n");
    assert!(project.raxel(&["list"]).exits(0).stdout.contains("sky_depth"));
    let rendered = |args: &[&str]| {
        let run = project.raxel(&[&["render", "-o", "a.png", "--format", "json"], args].concat()).exits(0);
        run.json().into_iter().find(|line| line["reason"] == "rendered").unwrap()
    };
    let said = rendered(&[]);
    assert_eq!((&said["graph"], &said["size"]), (&"graphs/inspect.toml".into(), &serde_json::json!([64, 36])));
    // The command line wins, and a demo over graph and world.
    assert_eq!(rendered(&["graphs/rivals/naive.toml", "--size", "32x18"])["size"], serde_json::json!([32, 18]));
    project.write(
        "worlds/own.demo.toml",
        "world = 'menger.toml'\ngraph = 'rivals/naive.toml'\nduration = 1.0\nsize = [48, 27]\n",
    );
    project.write("raxel.toml", "graph = 'inspect.toml'\ndemo = 'own.demo.toml'\nsize = [64, 36]\n");
    let said = rendered(&[]);
    assert_eq!((&said["graph"], &said["size"]), (&"graphs/rivals/naive.toml".into(), &serde_json::json!([48, 27])));
    assert_eq!(rendered(&["--world", "worlds/menger.toml"])["graph"], "graphs/inspect.toml");
    project.raxel(&["check", "raxel.toml"]).exits(0);

    project.write("raxel.toml", "graph = 'none.toml'\n");
    for args in [&["check"][..], &["list"], &["render", "-o", "a.png"], &["graph"]] {
        let run = project.raxel(args).exits(3);
        let said = run.stdout + &run.stderr;
        assert!(said.contains("RX0460") && said.contains("raxel.toml:1:9"), "{args:?}: {said}");
    }
}

#[test]
fn a_folder_with_files_becomes_a_project_and_none_of_them_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("README.md"), "mine").unwrap();
    let init = || raxel_in(folder.path(), &["init", "--template", "minimal"]);
    init().exits(0);
    assert_eq!(std::fs::read_to_string(folder.path().join("README.md")).unwrap(), "mine");
    raxel_in(folder.path(), &["check"]).exits(0);
    // It is one now: nothing is written over, nothing half-made is left.
    std::fs::remove_file(folder.path().join("shaders/paint.comp")).unwrap();
    let again = init().exits(2);
    assert!(again.stderr.contains("graphs/primary.toml` is there already"), "{}", again.stderr);
    assert!(!folder.path().join("shaders/paint.comp").exists());
}

#[test]
fn a_graph_and_a_world_are_listed_by_name() {
    let project = Project::shipped();
    let list = ["list", "graphs/primary.toml", "--world", "worlds/valley.toml"];
    let text = project.raxel(&list).exits(0).stdout;
    // Columns are as wide as what stands in them.
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    for line in [
        "sky_strength f32 0.6 0…4 Sun and sky: Skylight Light from the whole sky; corners of the world see less of it.",
        "hit target rgba32i",
        "primary",
    ] {
        assert!(text.lines().any(|found| words(found) == words(line)), "{line:?} is not in\n{text}");
    }
    let json = project.raxel(&[&list[..], &["--format", "json"]].concat()).exits(0).stdout;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["present"], "color");
    assert_eq!(json["params"][0]["name"], "exposure");
    assert!(json["passes"].as_array().unwrap().iter().any(|pass| pass == "trace"), "{json}");
    assert_eq!(json["world"], "worlds/valley.toml");
    // A graph alone has no world to name.
    let alone = Project::empty();
    alone.write(
        "graphs/a.toml",
        r#"name = "a"
present = "a"
[targets.a]
format = "r32f"
init = 0.0
"#,
    );
    let json = alone.raxel(&["list", "--format", "json"]).exits(0).json();
    assert_eq!((&json[0]["name"], json[0].get("world")), (&"a".into(), None), "{json:?}");
    project.raxel(&["list", "graphs/none.toml"]).exits(3);
    // A world is listed with the project's graph, a demo with its own.
    let list = |args: &[&str]| project.raxel(&[&["list", "--format", "json"], args].concat()).exits(0).json().remove(0);
    let world = list(&["worlds/valley.toml"]);
    assert_eq!((&world["name"], &world["world"]), (&"primary".into(), &"worlds/valley.toml".into()), "{world}");
    let demo = list(&["worlds/dawn.demo.toml"]);
    assert_eq!((&demo["name"], &demo["world"]), (&"inspect".into(), &"worlds/valley.toml".into()), "{demo}");
    let over = list(&["worlds/dawn.demo.toml", "--world", "worlds/menger.toml"]);
    assert_eq!((&over["name"], &over["world"]), (&"inspect".into(), &"worlds/menger.toml".into()), "{over}");
    project.raxel(&["list", "worlds/valley.toml", "--world", "worlds/menger.toml"]).exits(2);
    // Choices stand for their numbers, units with what has them.
    let text = project.raxel(&["list", "graphs/examples/params.toml"]).exits(0).stdout;
    for line in ["pattern u32 Discs Discs | Stripes | Squares Pattern", "turn f32 30 0…360 ° Shape: Turned by"] {
        assert!(text.lines().any(|found| words(found) == words(line)), "{line:?} is not in\n{text}");
    }
    let render = |choice: &str| {
        let set = format!("pattern={choice}");
        project.raxel(&["render", "graphs/examples/params.toml", "--size", "32x18", "--set", &set, "-o", "p.png"])
    };
    render("Stripes").exits(0);
    let by_name = std::fs::read(project.path("p.png")).unwrap();
    render("1").exits(0);
    assert!(std::fs::read(project.path("p.png")).unwrap() == by_name);
    assert!(render("Stripe").exits(2).stderr.contains("did you mean `Stripes`?"));
}

#[test]
fn clean_removes_what_raxel_made_and_nothing_else() {
    let project = Project::empty();
    project.write(".raxel/cache/x", "1").write(".raxel/demo/valley.png", "1").write(".raxel/mine.txt", "1");
    project.raxel(&["clean"]).exits(0);
    assert!(!project.path(".raxel/cache").exists() && !project.path(".raxel/demo").exists());
    assert!(project.path(".raxel/mine.txt").exists());
    assert!(project.raxel(&["clean"]).exits(0).stderr.contains("nothing to remove"));
}

/// Two models without a scene graph are the frames of an animation.
#[test]
fn a_frame_of_an_animation_is_imported() {
    let project = Project::shipped();
    let mut content = Vec::new();
    for voxels in [&[[0u8, 0, 0, 1]][..], &[[0, 0, 0, 1], [1, 0, 0, 1], [2, 0, 0, 1]]] {
        for (id, body) in [
            (b"SIZE", [3u32, 1, 1].iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>()),
            (b"XYZI", (voxels.len() as u32).to_le_bytes().into_iter().chain(voxels.concat()).collect()),
        ] {
            content.extend(id);
            content.extend((body.len() as u32).to_le_bytes());
            content.extend([0; 4]);
            content.extend(body);
        }
    }
    let mut file = b"VOX \x96\0\0\0MAIN\0\0\0\0".to_vec();
    file.extend((content.len() as u32).to_le_bytes());
    file.extend(content);
    project.write("flame.vox", file);
    let solids = |world: &str| {
        project.raxel(&["world", "info", world, "--format", "json"]).exits(0).json()[0]["info"]["solids"].clone()
    };
    project.raxel(&["world", "import", "flame.vox"]).exits(0);
    assert_eq!(solids("worlds/flame.toml"), 1);
    project.raxel(&["world", "import", "flame.vox", "--frame", "1", "-o", "worlds/second.toml", "--force"]).exits(0);
    assert_eq!(solids("worlds/second.toml"), 3);
    let run = project.raxel(&["world", "import", "flame.vox", "--frame", "2", "--force"]).exits(3);
    assert!(run.stderr.contains("RX0324") && run.stderr.contains("2 frames, 0 to 1"), "{}", run.stderr);
}
