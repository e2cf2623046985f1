//! Cameras, new projects and worlds of other programs.

use crate::common::{Project, Run, RunRaxel, command, output, raxel, raxel_in};
use crate::{MENGER, common, decoded, menger};

#[test]
fn the_camera_can_be_put_anywhere() {
    let folder = tempfile::tempdir().unwrap();
    let take = |name: &str, camera: &[&str]| {
        let path = folder.path().join(name);
        menger(&[camera, &["-o", path.to_str().unwrap()]].concat()).exits(0);
        decoded(&path)
    };
    let hinted = take("hint.png", &[]);
    let moved = take("moved.png", &["--camera", "-80,200,-60", "--look-at", "40,40,40"]);
    assert!(hinted != moved);
    // The same place by another name.
    assert!(moved == take("again.png", &["--camera=-80.0,2e2,-60", "--look-at=40,40,40"]));
}

#[test]
fn a_camera_of_the_world_has_a_name() {
    let project = Project::shipped();
    let camera = "[cameras.corner]\nposition = [-80, 200, -60]\nlook_at = [40, 40, 40]\nfov = 45\n\n[materials]";
    project.edit("worlds/menger.toml", "[materials]", camera);
    let take = |camera: &[&str], code| {
        let run = project.raxel(&[&MENGER[..], camera, &["-o", "a.png"]].concat()).exits(code);
        (run.stderr, decoded(&project.path("a.png")))
    };
    let (_, named) = take(&["--camera", "corner"], 0);
    assert!(named == take(&["--camera=-80,200,-60", "--look-at=40,40,40"], 0).1);
    let (said, _) = take(&["--camera", "korner"], 2);
    assert!(said.contains("has no camera `korner`") && said.contains("did you mean `corner`?"), "{said}");
}

#[test]
fn a_new_project_renders_with_the_binary_alone() {
    let folder = tempfile::tempdir().unwrap();
    for template in ["voxel", "minimal"] {
        let project = folder.path().join(template);
        raxel_in(folder.path(), &["new", template, "--template", template]).exits(0);
        raxel_in(&project, &["render", "-o", "p.png", "--size", "64x36", "--validate"]).exits(0);
        assert_eq!(decoded(&project.join("p.png")).dimensions(), (64, 36));
        // From a folder inside it, too.
        raxel_in(&project.join("graphs"), &["render", "-o", "q.png", "--size", "64x36"]).exits(0);
        let read = |path: &str| std::fs::read(project.join(path)).unwrap();
        assert!(read("p.png") == read("graphs/q.png"));
    }
}

#[test]
fn the_doctor_finds_nothing_wrong_where_the_tests_run() {
    let run = raxel(&["doctor"]).exits(0);
    for line in ["devices", "shader compiler", "rendering", "project"] {
        assert!(run.stdout.contains(line), "{}", run.stdout);
    }
    let found = raxel(&["doctor", "--format", "json"]).exits(0).json();
    assert!(found.iter().all(|finding| finding["state"] != "bad"));

    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    for (place, state, words) in [("file/in", "missing", "cannot be written"), ("new/in", "ok", " files, ")] {
        let place = folder.path().join(place);
        let mut doctor = command(common::repository(), &["doctor", "--format", "json"]);
        let found = Run::from(output(doctor.env("RAXEL_CACHE", &place))).exits(0).json();
        let cache = found.iter().find(|finding| finding["what"] == "cache").unwrap();
        assert_eq!(cache["state"], state, "{cache}");
        assert!(cache["finding"].as_str().unwrap().contains(words), "{cache}");
    }
}

#[test]
fn worlds_go_out_and_come_in() {
    let project = Project::shipped();
    let said = project.raxel(&["world", "info", "worlds/menger.toml", "--format", "json"]).exits(0).json();
    let solids = said[0]["info"]["solids"].as_u64().unwrap();
    assert!(solids > 1000);
    let said = project.raxel(&["world", "export", "worlds/menger.toml", "-o", "cube.vox"]).exits(0).stderr;
    assert!(!said.contains("instance"), "{said}");
    project.raxel(&["world", "import", "cube.vox"]).exits(0);
    let imported = project.raxel(&["world", "info", "worlds/cube.toml", "--format", "json"]).exits(0).json();
    assert_eq!(imported[0]["info"]["solids"].as_u64().unwrap(), solids);
    project.raxel(&["check", "worlds/cube.toml"]).exits(0);
    project.raxel(&["world", "import", "cube.vox"]).exits(2);
    project.raxel(&["world", "import", "cube.vox", "--force"]).exits(0);

    let said = project.raxel(&["world", "export", "worlds/flock.toml", "-o", "flock.vox"]).exits(0).stderr;
    assert!(said.contains("without its 512 instances"), "{said}");

    let before = project.files();
    project.write("broken.vox", b"VOX nonsense");
    project.raxel(&["world", "import", "broken.vox"]).exits(3);
    project.raxel(&["world", "import", "missing.vox"]).exits(3);
    project.raxel(&["world", "export", "worlds/none.toml", "-o", "x.vox"]).exits(3);
    std::fs::remove_file(project.path("broken.vox")).unwrap();
    assert_eq!(project.files(), before);
}
