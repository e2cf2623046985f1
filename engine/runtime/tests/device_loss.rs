//! A frame that takes longer than the watchdog allows: the device is reopened, the pass is named and left out, and an edit of its shader
//! brings it back.
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use std::time::Duration;

use project::{Project, Sessions};
use raxel_execute::Progress;
use raxel_runtime::Options;
use raxel_runtime::reload::ReloadEvent;

/// Works for seconds on a software device, but not for ever: a thread of the driver that never ends would outlive the test. That
/// driver leaves a shader's loops after 65535 rounds, so a round is long and the pixels are many.
fn slow(steps: usize) -> String {
    let steps = "x = fract(x * 1.37 + 0.11);\n".repeat(steps);
    format!(
        r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D outColor;
void main() {{
    float x = float(gl_GlobalInvocationID.x);
    for (int i = 0; i < 60000; ++i) {{
        {steps}
    }}
    imageStore(outColor, ivec2(gl_GlobalInvocationID.xy), vec4(x));
}}
"
    )
}

fn losses(events: &[ReloadEvent]) -> Vec<(Option<&str>, bool)> {
    let lost = |event| match event {
        &ReloadEvent::DeviceRebuilt { ref suspect, off, .. } => Some((suspect.as_deref(), off)),
        _ => None,
    };
    events.iter().filter_map(lost).collect()
}

#[test]
fn a_hang_names_its_pass_and_leaves_it_out_until_its_shader_changes() {
    let project = Project::filled();
    // Software devices are given six times as much. A loaded machine slows the quick frames as much as the slow one.
    let mut session =
        Project::open_with(Options { watchdog: Duration::from_millis(250), size: [192, 192], ..project.options() });
    session.frame().unwrap();
    let opened = std::sync::Arc::as_ptr(session.device());

    project.write("shaders/fill.comp", slow(32));
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
    // The loss shows when a frame waits for the slow one.
    for _ in 0..4 {
        session.frame().unwrap();
    }
    let events = session.poll_reload();
    assert_eq!(losses(&events), [(Some("fill"), true)], "{events:#?}");
    assert_eq!(session.switched_off().collect::<Vec<_>>(), ["fill"]);
    assert_ne!(std::sync::Arc::as_ptr(session.device()), opened);

    project.write("shaders/fill.comp", project::fill("vec4(0.5)"));
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
    assert_eq!(session.switched_off().count(), 0);
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 0.5);
}

/// A shader that is as slow as the graph says.
fn counted() -> String {
    slow(128)
        .replace("void main()", "layout(push_constant) uniform PC { int rounds; } pc;\nvoid main()")
        .replace("i < 60000", "i < pc.rounds")
        .replace("vec4(x)", "vec4(pc.rounds < 2 ? 0.5 : x)")
}

fn wait_until_a_pass_works(session: &mut raxel_runtime::Session) {
    let began = std::time::Instant::now();
    // The marks say that the pass has begun.
    while !matches!(session.wait_picture(Duration::from_millis(20)), Ok(Progress::Working { pass: Some(_), .. })) {
        assert!(began.elapsed() < Duration::from_secs(60), "the slow pass is not slow");
    }
}

#[test]
fn a_pass_that_hung_is_tried_again_when_its_part_of_the_graph_changes_and_not_before() {
    let project = Project::filled();
    let graph = |rounds: u32, about: &str| {
        format!("{}[passes.push]\nrounds = {{ type = \"i32\", value = {rounds} }}\n", project::FILL_GRAPH).replacen(
            "name = \"fill\"",
            &format!("name = \"fill\"\nabout = \"{about}\""),
            1,
        )
    };
    project.write("shaders/fill.comp", counted());
    project.write("graphs/fill.toml", graph(1, "quick"));
    // Only `cancel` gives this device up, however slow the machine is.
    let mut session =
        Project::open_with(Options { watchdog: Duration::from_secs(600), size: [192, 192], ..project.options() });
    let reload = |session: &mut raxel_runtime::Session, text: &str| {
        project.write("graphs/fill.toml", text);
        let events = session.wait_reload(Duration::from_secs(60));
        assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
    };
    session.frame().unwrap();
    session.wait().unwrap();
    reload(&mut session, &graph(60_000, "slow"));
    session.frame().unwrap();
    wait_until_a_pass_works(&mut session);
    session.cancel().unwrap();
    assert_eq!(losses(&session.poll_reload()), [(Some("fill"), true)]);
    // The pass is below the line that changes, and is still the one that hung.
    reload(&mut session, &graph(60_000, "slow, as another line says"));
    assert_eq!(session.switched_off().collect::<Vec<_>>(), ["fill"]);
    reload(&mut session, &graph(1, "mended"));
    assert_eq!(session.switched_off().count(), 0);
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 0.5);
}

/// Work that the device still does is given up by whoever asks `works_on_replaced`.
#[test]
fn an_edit_of_a_dispatch_replaces_the_work_that_runs_and_an_edit_of_another_line_does_not() {
    let project = Project::filled();
    project.write("shaders/fill.comp", slow(128));
    // Only `cancel` gives this device up, however slow the machine is.
    let mut session =
        Project::open_with(Options { watchdog: Duration::from_secs(600), size: [192, 192], ..project.options() });
    session.frame().unwrap();
    wait_until_a_pass_works(&mut session);
    let reload = |session: &mut raxel_runtime::Session, text: String| {
        project.write("graphs/fill.toml", text);
        let events = session.wait_reload(Duration::from_secs(60));
        assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
    };
    reload(&mut session, project::FILL_GRAPH.replacen("name = \"fill\"", "name = \"fill\"\nabout = \"\"", 1));
    assert!(!session.works_on_replaced(), "its pass is what it was");
    let dispatch = "dispatch = { groups = [1, 1, 1] }";
    reload(&mut session, project::FILL_GRAPH.replace("dispatch = { threads = \"color\" }", dispatch));
    assert!(session.works_on_replaced(), "the pass has another dispatch now");
    session.cancel().unwrap();
    let events = session.poll_reload();
    assert!(matches!(losses(&events)[..], [(Some("fill"), false)]), "{events:#?}");
    assert_eq!(session.switched_off().count(), 0);
}

/// The frame that hangs has the old shader; the one that is given up with it is not the mended one.
#[test]
fn a_pass_that_was_mended_while_it_hung_is_not_left_out() {
    let project = Project::filled();
    // Only `cancel` gives this device up, however slow the machine is.
    let mut session =
        Project::open_with(Options { watchdog: Duration::from_secs(600), size: [192, 192], ..project.options() });
    // A machine that is through with the slow shader before it is mended gets more to do.
    let caught = [8, 32, 128, 512].into_iter().any(|steps| {
        session.frame().unwrap();
        session.wait().unwrap();
        project.write("shaders/fill.comp", slow(steps));
        let events = session.wait_reload(Duration::from_secs(60));
        assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
        session.frame().unwrap();
        assert!(!session.works_on_replaced(), "the shader is still the one of the file");
        project.write("shaders/fill.comp", project::fill("vec4(0.5)"));
        let events = session.wait_reload(Duration::from_secs(60));
        assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:#?}");
        session.works_on_replaced()
    });
    assert!(caught, "the slow shader is not slow");
    session.cancel().unwrap();
    let events = session.poll_reload();
    // It may have finished between two lines.
    assert!(matches!(losses(&events)[..], [(Some("fill") | None, false)]), "{events:#?}");
    assert_eq!(session.switched_off().count(), 0);
    session.frame().unwrap();
    assert_eq!(project::red(&mut session), 0.5);
}
