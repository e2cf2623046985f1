//! Edits of real files while a session runs, in every way in which editors save. On a real device with the validation layer on: no
//! message may come.
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use std::fs;
use std::thread::sleep;
use std::time::Duration;

use project::{Project, Sessions};
use raxel_diagnostics::Severity;
use raxel_graph::checked::Value;
use raxel_runtime::Options;
use raxel_runtime::reload::ReloadEvent;

/// A way in which an editor saves `text` over the file.
type Save = fn(&std::path::Path, &str);

const SAVES: &[(&str, Save)] = &[
    ("in place", |path, text| fs::write(path, text).unwrap()),
    ("renamed over", |path, text| {
        let new = path.with_extension("tmp");
        fs::write(&new, text).unwrap();
        fs::rename(&new, path).unwrap();
    }),
    ("truncated, then written in pieces", |path, text| {
        use std::io::Write;
        let mut file = fs::File::create(path).unwrap();
        for piece in text.as_bytes().chunks(text.len().div_ceil(4)) {
            sleep(Duration::from_millis(25));
            file.write_all(piece).unwrap();
            file.flush().unwrap();
        }
    }),
    ("deleted, then made again", |path, text| {
        fs::remove_file(path).unwrap();
        sleep(Duration::from_millis(40));
        fs::write(path, text).unwrap();
    }),
    ("moved away as a backup, then made again", |path, text| {
        fs::rename(path, path.with_extension("bak")).unwrap();
        fs::write(path, text).unwrap();
    }),
];

#[test]
fn every_way_of_saving_reloads_once_and_without_an_error() {
    let project = Project::filled();
    let mut session = project.open();
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 0.25);
    for (index, (how, save)) in SAVES.iter().enumerate() {
        let red = (index + 1) as f32 / 8.0;
        save(&project.path("shaders/fill.comp"), &project::fill(&format!("vec4({red})")));
        let events = session.wait_reload(Duration::from_secs(60));
        match events.as_slice() {
            [ReloadEvent::Reloaded(reloaded)] => {
                assert_eq!(reloaded.changed, ["shaders/fill.comp"], "{how}");
                assert_eq!(reloaded.rebuilt.shaders, ["shaders/fill.comp"], "{how}");
            }
            events => panic!("{how}: {events:#?}"),
        }
        session.frame().unwrap();
        assert_eq!(project::red(&mut session), red, "{how}");
        assert!(session.wait_reload(Duration::from_millis(150)).is_empty(), "{how}: more came");
    }
    project::assert_silent(&session);
}

#[test]
fn a_save_without_a_change_is_no_edit() {
    let project = Project::filled();
    let mut session = project.open();
    let text = fs::read_to_string(project.path("shaders/fill.comp")).unwrap();
    for _ in 0..3 {
        fs::write(project.path("shaders/fill.comp"), &text).unwrap();
    }
    fs::write(project.path("shaders/unrelated.comp"), "nothing").unwrap();
    assert!(session.wait_reload(Duration::from_millis(400)).is_empty());
}

#[test]
fn texts_that_make_the_same_module_make_no_pipeline() {
    let project = Project::filled();
    let shader = |value: &str| project::fill(value).replace("//INCLUDE", "#include \"value.glsl\"");
    let include = |value: &str| format!("#define VALUE {value}\n");
    project.write("shaders/include/value.glsl", include("0.25"));
    project.write("shaders/fill.comp", shader("vec4(VALUE)"));
    let mut session = project.open();
    assert_eq!(project::red_after_frame(&mut session), 0.25);
    let made = |session: &raxel_runtime::Session| session.device().pipeline_counts().made;
    let edit = |session: &mut raxel_runtime::Session, path: &str, text: &str| {
        let before = made(session);
        project.write(path, text);
        let events = session.wait_reload(Duration::from_secs(60));
        let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
        let new = reloaded.rebuilt.shaders.len();
        (project::red_after_frame(session), new, made(session) - before)
    };
    let comment = format!("// What it is filled with.\n{}", include("0.25"));
    assert_eq!(edit(&mut session, "shaders/include/value.glsl", &comment), (0.25, 0, 0));
    let unused = format!("{}float twice(float x) {{ return 2.0 * x; }}\n", include("0.25"));
    assert_eq!(edit(&mut session, "shaders/include/value.glsl", &unused), (0.25, 0, 0));
    assert_eq!(edit(&mut session, "shaders/include/value.glsl", &include("0.5")), (0.5, 1, 1));
    assert_eq!(edit(&mut session, "shaders/fill.comp", &shader("vec4(VALUE + 0.25)")), (0.75, 1, 1));
    project::assert_silent(&session);
}

#[test]
fn passes_of_equal_modules_and_constants_share_a_pipeline() {
    let pass = |name: &str, more: &str| {
        format!(
            "[[passes]]\nname = \"{name}\"\nshader = \"add.comp\"\n{more}dispatch = {{ threads = \"color\" }}\nbind = {{ outColor = \"color\" }}\n"
        )
    };
    let graph = |passes: &[String]| {
        let head = r#"name = "fill"
present = "color"
[targets.color]
format = "rgba32f"
clear = [0.0, 0.0, 0.0, 0.0]
"#;
        format!("{head}{}", passes.concat())
    };
    let run = |passes: &[String]| {
        let project = Project::filled();
        let text = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const float ADDED = 1.0;
layout(rgba32f) uniform image2D outColor;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(outColor, pixel, imageLoad(outColor, pixel) + ADDED);
}
";
        project.write("shaders/add.comp", text);
        project.write("graphs/fill.toml", graph(passes));
        let mut session = project.open();
        let red = project::red_after_frame(&mut session);
        project::assert_silent(&session);
        (red, session.device().pipeline_counts().made)
    };
    let of = |added: f32| format!("specialization = {{ ADDED = {added:?} }}\n");
    let (red, one) = run(&[pass("a", &of(2.0))]);
    assert_eq!(red, 2.0);
    // The constant, the default of the shader, defines that change nothing: what the driver is given counts.
    let equal =
        [pass("a", &of(2.0)), pass("b", &of(2.0)), pass("c", &format!("{}defines = {{ UNUSED = 1 }}\n", of(2.0)))];
    assert_eq!(run(&equal), (6.0, one));
    let different = [pass("a", &of(2.0)), pass("b", &of(3.0)), pass("c", &of(2.0))];
    assert_eq!(run(&different), (7.0, one + 1));
}

/// The gesture of live coding: a term is commented out, and in again. Neither costs more than the compilation of its shader, and what the graph
/// has gathered stays, also where no other pass touches it.
#[test]
fn a_term_is_commented_out_and_in_again_without_a_loss() {
    let shader = |term: &str| {
        format!(
            r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D outColor;
layout(rgba32f) uniform image2D sum;
layout(push_constant) uniform PC {{ float add; }} pc;
void main() {{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    vec4 color = vec4(0.0);
    {term}
    imageStore(outColor, pixel, color);
}}
"
        )
    };
    let whole = "color = imageLoad(sum, pixel) + pc.add; imageStore(sum, pixel, color);";
    let graph = include_str!("fixtures/reload/gather.toml");
    let project = Project::filled();
    project.write("graphs/gather.toml", graph);
    project.write("shaders/gather.comp", shader(whole));
    let options = Options {
        graph: Some("graphs/gather.toml".into()),
        unused: Severity::Warning,
        observe: raxel_runtime::Observe::Shown,
        ..project.options()
    };
    let mut session = Project::open_with(options);
    for frame in 1..=3 {
        assert_eq!(project::red_after_frame(&mut session), frame as f32);
    }
    let mut edit = |term: &str| {
        project.write("shaders/gather.comp", shader(term));
        let events = session.wait_reload(Duration::from_secs(60));
        let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
        assert_eq!(reloaded.rebuilt.shaders, ["shaders/gather.comp"]);
        assert!(reloaded.diagnostics.iter().all(|found| !found.is_error()));
        let codes = reloaded.diagnostics.iter().map(|found| found.code.as_str().to_owned()).collect::<Vec<_>>();
        (codes, [(); 2].map(|()| project::red_after_frame(&mut session)))
    };
    let (said, shown) = edit(&format!("// {whole}"));
    assert!(said.iter().any(|code| code == "RX0121") && said.iter().any(|code| code == "RX0118"), "{said:?}");
    assert_eq!(shown, [0.0, 0.0], "the picture goes on without the term");
    assert_eq!(edit(whole), (Vec::new(), [4.0, 5.0]), "the sum is as it was");
    project::assert_silent(&session);
}

#[test]
fn an_error_is_told_once_and_the_last_picture_stays() {
    let project = Project::filled();
    let mut session = project.open();
    session.frame().unwrap();
    project.write("shaders/fill.comp", project::fill("vec4(nonsense)"));
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Failed(failed)] = events.as_slice() else { panic!("{events:#?}") };
    assert!(failed.diagnostics[0].message.contains("nonsense"), "{:#?}", failed.diagnostics);
    assert!(failed.texts.get("shaders/fill.comp").is_some());
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 0.25);
    assert!(session.wait_reload(Duration::from_millis(200)).is_empty());
    // The fix.
    project.write("shaders/fill.comp", project::fill("vec4(0.5)"));
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 0.5);
    // Taking the edit back before it was an edit: the same text as what runs.
    project.write("shaders/fill.comp", project::fill("vec4(broken)"));
    session.wait_reload(Duration::from_secs(60));
    project.write("shaders/fill.comp", project::fill("vec4(0.5)"));
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
    assert!(reloaded.rebuilt.shaders.is_empty(), "{:?}", reloaded.rebuilt);
    project::assert_silent(&session);
}

#[test]
fn a_missing_include_is_waited_for() {
    let project = Project::filled();
    let mut session = project.open();
    let with_include = project::fill("vec4(VALUE)").replace("//INCLUDE", "#include \"value.glsl\"");
    project.write("shaders/fill.comp", &with_include);
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(matches!(events.as_slice(), [ReloadEvent::Failed(_)]), "{events:#?}");
    // In a folder that does not exist yet.
    project.write("shaders/include/value.glsl", "#define VALUE 0.75\n");
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 0.75);
    // An include is an input like any other.
    project.write("shaders/include/value.glsl", "#define VALUE 1.0\n");
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
    assert_eq!(reloaded.changed, ["shaders/include/value.glsl"]);
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 1.0);
    project::assert_silent(&session);
}

#[test]
fn a_graph_edit_keeps_history_clock_params_and_camera() {
    let project = Project::filled();
    project.write("shaders/count.comp", project::COUNT);
    project.write("graphs/count.toml", project::COUNT_GRAPH);
    let mut session = project.open_graph("graphs/count.toml");
    session.set_param("add", Value::F32(2.0)).unwrap();
    let mut camera = *session.camera();
    camera.yaw = 1.0;
    session.set_camera(camera);
    for _ in 0..3 {
        session.frame().unwrap();
    }
    assert_eq!(project::red(&mut session), 6.0);
    // A new range and a new target: no shader compiles, nothing that was there is lost.
    let edited = project::COUNT_GRAPH.replace("range = [0.0, 8.0]", "range = [0.0, 9.0]")
        + "\n[targets.spare]\nformat = \"r32f\"\n";
    project.write("graphs/count.toml", &edited);
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
    assert!(reloaded.rebuilt.graph && !reloaded.rebuilt.world && reloaded.rebuilt.shaders.is_empty());
    assert!(reloaded.resources.kept.contains(&"sum".to_owned()), "{:?}", reloaded.resources);
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 8.0);
    assert_eq!(session.clock().now().unwrap().index, 3);
    assert_eq!(session.param("add").unwrap(), Value::F32(2.0));
    assert_eq!(session.camera().yaw, 1.0);
    // Another format is another resource: it starts over. Both files are saved at once, and become one edit.
    project.write("graphs/count.toml", edited.replace("format = \"rgba32f\"", "format = \"rgba16f\""));
    project.write("shaders/count.comp", project::COUNT.replace("rgba32f", "rgba16f"));
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
    assert_eq!(reloaded.changed, ["graphs/count.toml", "shaders/count.comp"]);
    assert!(reloaded.resources.created.contains(&"sum".to_owned()), "{:?}", reloaded.resources);
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 2.0);
    project::assert_silent(&session);
}

#[test]
fn the_newest_of_quick_edits_wins() {
    let project = Project::filled();
    let mut session = project.open();
    for red in [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75] {
        project.write("shaders/fill.comp", project::fill(&format!("vec4({red})")));
        sleep(Duration::from_millis(7));
    }
    let mut events = Vec::new();
    while project::red_after_frame(&mut session) != 0.75 {
        let more = session.wait_reload(Duration::from_secs(60));
        assert!(!more.is_empty(), "the last edit never came");
        events.extend(more);
    }
    assert!(events.iter().all(|event| matches!(event, ReloadEvent::Reloaded(_))), "{events:#?}");
    project::assert_silent(&session);
}

#[test]
fn polling_sees_edits_too() {
    let project = Project::filled();
    let mut session = Project::open_with(Options { poll: true, ..project.options() });
    // File times may be as coarse as the poll.
    sleep(Duration::from_millis(20));
    project.write("shaders/fill.comp", project::fill("vec4(0.5)"));
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
    assert_eq!(project::red_after_frame(&mut session), 0.5);
}

#[test]
fn a_debug_target_that_is_edited_away_gives_way_to_the_graphs_own() {
    let project = Project::filled();
    let graph = std::fs::read_to_string(project.path("graphs/fill.toml")).unwrap();
    let spare = "\n[targets.spare]\nformat = \"r32f\"\n";
    project.write("graphs/fill.toml", format!("{graph}{spare}"));
    let mut session = project.open();
    session.set_debug_target_text("spare").unwrap();
    session.frame().unwrap();
    project.write("graphs/fill.toml", &graph);
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
    let codes: Vec<_> = reloaded.diagnostics.iter().map(|d| d.code.as_str()).collect();
    assert!(codes.contains(&"RX0405"), "{:#?}", reloaded.diagnostics);
    assert_eq!(project::red_after_frame(&mut session), 0.25);
    project::assert_silent(&session);
}

const FOLLOWS_GRAPH: &str = include_str!("fixtures/reload/follows.toml");

const FOLLOW_SHADER: &str = include_str!("fixtures/reload/follow.comp");

/// An edit of the world resizes what follows its bounds, which starts again, and renumbers its materials; all else stays.
#[test]
fn what_follows_the_world_follows_its_edits() {
    let project = Project::filled();
    project.write("graphs/follows.toml", FOLLOWS_GRAPH);
    project.write("shaders/follow.comp", FOLLOW_SHADER);
    project.write("worlds/box.toml", project::box_world(4));
    let mut session = Project::open_with(Options {
        graph: Some("graphs/follows.toml".into()),
        world: Some("worlds/box.toml".into()),
        ..project.options()
    });
    session.frame().unwrap();
    session.frame().unwrap();
    assert_eq!(project::texel(&mut session), [2.0, 4.0, 1.0, 7.0]);
    let lamp = "[materials]\nlamp = { albedo = \"#ffffff\" }\n";
    project.write("worlds/box.toml", project::box_world(7).replace("[materials]\n", lamp));
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
    assert_eq!(
        (&reloaded.resources.kept[..], &reloaded.resources.created[..]),
        (&["color".to_owned()][..], &["cells".to_owned()][..])
    );
    session.frame().unwrap();
    assert_eq!(project::texel(&mut session), [3.0, 16.0, 2.0, 0.0]);
    // A world without the material is refused, at the place where the graph names it, and the old one runs on.
    project.write("worlds/box.toml", project::box_world(3).replace("red", "blue"));
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Failed(failed)] = events.as_slice() else { panic!("{events:#?}") };
    let found = &failed.diagnostics[0];
    assert_eq!(found.message, "the world has no material `red`");
    assert_eq!((found.code.as_str(), &found.labels[0].span.file[..]), ("RX0181", "graphs/follows.toml"));
    assert!(found.help[0].contains("`blue`"), "{found:?}");
    session.frame().unwrap();
    assert_eq!(project::texel(&mut session), [4.0, 16.0, 2.0, 7.0]);
    project::assert_silent(&session);
}

#[test]
fn world_and_demo_edits_reload_what_they_concern() {
    let project = Project::filled();
    project.write("graphs/world.toml", project::WORLD_GRAPH);
    project.write("shaders/world.comp", project::WORLD_SHADER);
    project.write("worlds/box.toml", project::box_world(4));
    project.write("worlds/box.demo.toml", project::box_demo(0.25));
    let mut session = project.open_demo("worlds/box.demo.toml");
    session.frame().unwrap();
    assert_eq!(project::texel(&mut session), [64.0, 0.25, 0.0, 0.0]);
    project.write("worlds/box.toml", project::box_world(2));
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
    assert!(reloaded.rebuilt.world && !reloaded.rebuilt.graph && !reloaded.rebuilt.demo);
    session.frame().unwrap();
    assert_eq!(project::texel(&mut session), [8.0, 0.25, 0.0, 0.0]);
    project.write("worlds/box.demo.toml", project::box_demo(0.5));
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Reloaded(reloaded)] = events.as_slice() else { panic!("{events:#?}") };
    assert!(reloaded.rebuilt.demo && !reloaded.rebuilt.world && !reloaded.rebuilt.graph);
    session.frame().unwrap();
    assert_eq!(project::texel(&mut session), [8.0, 0.5, 0.0, 0.0]);
    // A graph edit that the demo does not fit is an error that names both files.
    project.write(
        "graphs/world.toml",
        project::WORLD_GRAPH.replace("params.gain", "params.loss").replace("param.gain", "param.loss"),
    );
    let events = session.wait_reload(Duration::from_secs(60));
    let [ReloadEvent::Failed(failed)] = events.as_slice() else { panic!("{events:#?}") };
    assert!(failed.diagnostics.iter().any(|d| d.code.as_str() == "RX0403"), "{:#?}", failed.diagnostics);
    project::assert_silent(&session);
}

#[test]
fn a_shader_is_told_whether_there_is_a_history() {
    let project = Project::filled();
    project.write("graphs/valid.toml", project::VALID_GRAPH);
    project.write("shaders/valid.comp", project::VALID);
    let mut session =
        Project::open_with(Options { graph: Some(project.path("graphs/valid.toml")), ..project.options() });
    // The value, the number of frames that nothing changed in, and those since the history was cleared.
    let frame = |session: &mut raxel_runtime::Session| {
        session.frame().unwrap();
        let texel = session.read_target("sum").unwrap().floats()[0];
        [texel[0], texel[1], texel[2]]
    };
    assert_eq!([frame(&mut session), frame(&mut session)], [[0.0, 0.0, 1.0], [1.0, 1.0, 2.0]]);
    session.reset();
    assert_eq!([frame(&mut session), frame(&mut session)], [[0.0, 0.0, 1.0], [1.0, 1.0, 2.0]]);

    // Another size clears it, with one message, even if the window is dragged many times.
    for (size, said) in [([24, 8], true), ([32, 8], false)] {
        session.resize(size[0], size[1]);
        assert_eq!(
            [frame(&mut session), frame(&mut session)].map(|[valid, _, sum]| [valid, sum]),
            [[0.0, 1.0], [1.0, 2.0]]
        );
        let events = session.poll_reload();
        match events.as_slice() {
            [ReloadEvent::HistoryCleared { size: of, resources }] if said => {
                assert_eq!((of, resources.as_slice()), (&size, &["sum".to_owned()][..]));
            }
            [] if !said => {}
            events => panic!("{events:#?}"),
        }
    }

    // An edit that leaves the target as it is keeps its contents; one that replaces it does not.
    project.write("graphs/valid.toml", format!("{}# kept\n", project::VALID_GRAPH));
    assert!(matches!(session.wait_reload(Duration::from_secs(60)).as_slice(), [ReloadEvent::Reloaded(_)]));
    assert_eq!(frame(&mut session)[0], 1.0);
    let longer = project::VALID_GRAPH.replace("history = 1", "history = 2");
    project.write("graphs/valid.toml", &longer);
    assert!(matches!(session.wait_reload(Duration::from_secs(60)).as_slice(), [ReloadEvent::Reloaded(_)]));
    let valid = [frame(&mut session), frame(&mut session), frame(&mut session)].map(|texel| texel[0]);
    assert_eq!(valid, [0.0, 0.0, 1.0], "two frames back");
    project::assert_silent(&session);
}
