//! The panels, driven by their accessibility tree: what a user sees by name, clicks, and what comes of it.

use egui::Vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use raxel_panels::view::{
    Brush, Busy, Compare, CompareMode, Compiling, ComponentKind, Effect, Figures, FileKind, FirstPicture, Lane,
    Loading, Looking, Map, Param, PassState, PassWriters, Preset, Problem, Shape, Shown, TexelWriter, Thumbnail,
    Timeline, Track, Use, WorldExtent,
};
use raxel_panels::{Action, Layout, Panel, Panels, WriteTo};
use raxel_picture::{NotFinite, Sought};

mod window;

use window::{Window, inspected, param};

impl Window {
    fn harness(mut self, width: f32, height: f32) -> Harness<'static, Window> {
        self.panels.whole = true;
        let size = Vec2::new(width, height);
        let mut harness =
            Harness::builder().with_size(size).build_state(|ctx, window: &mut Window| window.draw(ctx), self);
        harness.run_steps(3);
        harness
    }
}

/// Clicks the widget of this name, and returns the user's actions.
#[track_caller]
fn click(harness: &mut Harness<'_, Window>, name: &str) -> Vec<Action> {
    harness.state_mut().actions.clear();
    harness.get_by_label(name).click();
    // One for each event, and more for what opens to find its size.
    harness.run_steps(6);
    harness.state().actions.iter().filter(|action| !matches!(action, Action::Peek(_))).cloned().collect()
}

/// The places of the lines of a label with this text.
fn texts(harness: &Harness<'_, Window>, text: &str) -> Vec<egui::Rect> {
    let label = egui::accesskit::Role::Label;
    harness
        .query_all_by_value(text)
        .filter(|node| node.accesskit_node().role() == label)
        .map(|node| node.rect())
        .collect()
}

#[test]
fn the_frame_says_how_the_world_does() {
    let mut harness = Window::new(&[Panel::Frame]).harness(1280.0, 720.0);
    harness.get_by_label("2,097,152 voxels in 300 chunks");
    harness.get_by_label("1 emissive voxel");
    harness.get_by_label("world.tree64 1.0 MiB, 0.50 bytes a voxel");
    harness.get_by_label("world.lights 4.0 KiB");
    harness.get_by_label("3 edits to undo, 1 to redo");
    harness.state_mut().world.extent = WorldExtent::Around(Loading {
        there: [40, 50],
        device: [3 << 20, 8 << 20],
        host: [1536, 2048],
        found_made: [7, 9],
        publications: 12_345,
        lamps: 0,
    });
    harness.run_steps(2);
    harness.get_by_label("40 of 50 chunks, 3.0 MiB of 8.0 MiB");
    harness.get_by_label("1.5 KiB of 2.0 KiB packed, 7 found, 9 made");
    harness.get_by_label("12,345 publications, 0 lamps");
    harness.get_by_label("world.tree64 1.0 MiB");
}

/// A clock runs a pass several times in a frame: there are more dispatches than passes.
#[test]
fn the_frame_counts_dispatches_and_not_passes() {
    let mut window = Window::new(&[Panel::Frame]);
    window.ran = [6, 1, 2];
    let harness = window.harness(1280.0, 720.0);
    harness.get_by_label("6 dispatched, 1 unchanged, 2 not due or off");
}

#[test]
fn a_pass_is_locked_by_a_click_and_says_why_it_did_not_run() {
    let mut harness = Window::new(&[Panel::Passes]).harness(1280.0, 720.0);
    let shown = Shown::after("depth", Some("hit".to_owned()));
    assert_eq!(click(&mut harness, "hit"), [Action::Show(shown.clone())]);
    // The target under the resting pointer is shown, too: that does not lock it.
    harness.state_mut().status.shown = shown.clone();
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "hit"), [Action::Show(shown.clone())]);
    harness.state_mut().status.locked = shown;
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "hit"), [Action::ShowDefault]);
    for said in ["unchanged", "when: no", "2.000", "3.000"] {
        assert!(harness.query_all_by_label(said).next().is_some(), "{said}");
    }
}

#[test]
fn a_pass_shows_the_part_that_it_writes() {
    let mut window = Window::new(&[Panel::Passes, Panel::Inspect]);
    window.resources[0].uses[0] = Use { writes: true, mip: 3, layer: 1, ..Use::default() };
    let mut harness = window.harness(1280.0, 720.0);
    let shown = Shown { mip: 3, layer: 1, ..Shown::after("depth", Some("hit".to_owned())) };
    assert_eq!(click(&mut harness, "hit"), [Action::Show(shown.clone())]);
    // Another mip of the same point is still locked.
    harness.state_mut().status.locked = Shown { mip: 2, ..shown.clone() };
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "hit"), [Action::ShowDefault]);
    harness.state_mut().panels.layout.open(Panel::Resources);
    harness.run_steps(3);
    assert_eq!(click(&mut harness, "depth after hit"), [Action::Show(shown)]);
}

#[test]
fn the_output_of_a_pass_shows_while_the_pointer_rests_on_it() {
    let mut harness = Window::new(&[Panel::Passes]).harness(1280.0, 720.0);
    harness.get_by_label("hit").hover();
    harness.run_steps(30);
    let shown = Shown::after("depth", Some("hit".to_owned()));
    assert_eq!(harness.state().actions, [Action::Peek(Some(shown))], "once, after a rest");
    harness.hover_at(egui::pos2(900.0, 600.0));
    harness.run_steps(3);
    assert_eq!(harness.state().actions.last(), Some(&Action::Peek(None)));
}

#[test]
fn a_cell_of_the_matrix_shows_a_resource_after_a_pass() {
    let mut harness = Window::new(&[Panel::Resources]).harness(1280.0, 720.0);
    let actions = click(&mut harness, "depth after shade");
    assert_eq!(actions, [Action::Show(Shown::after("depth", Some("shade".to_owned())))]);
    assert!(harness.state().panels.layout.is_open(Panel::Inspect), "and opens what it holds");
    // Nothing can be shown after a pass that is left out.
    assert_eq!(click(&mut harness, "depth after bloom"), []);
}

#[test]
fn params_are_set_reset_and_written() {
    let mut harness = Window::new(&[Panel::Params]).harness(1280.0, 720.0);
    assert_eq!(click(&mut harness, "fog"), [Action::SetParam("fog".to_owned(), vec![1.0])]);
    assert_eq!(click(&mut harness, "reset exposure"), [Action::ResetParam("exposure".to_owned())]);
    assert_eq!(click(&mut harness, "Write to file"), [Action::WriteParams(vec!["exposure".to_owned()], WriteTo::Own)]);
    assert!(harness.query_by_label("Write to base").is_none(), "the graph's own file declares it");
    assert_eq!(click(&mut harness, "Reset all"), [Action::ResetParam("exposure".to_owned())]);
    // A param of a base is overridden in the graph's own file, or written into the base for all graphs over it.
    harness.state_mut().params[0].file = "graphs/base.toml".to_owned();
    harness.run_steps(2);
    let exposure = || vec!["exposure".to_owned()];
    assert_eq!(click(&mut harness, "Write to file"), [Action::WriteParams(exposure(), WriteTo::Own)]);
    assert_eq!(click(&mut harness, "Write to base"), [Action::WriteParams(exposure(), WriteTo::Declared)]);
    harness.get_by_label("Write to base").hover();
    harness.run_steps(60);
    assert!(harness.query_by_label_contains("exposure into graphs/base.toml").is_some());
    // A write can be undone.
    assert!(harness.query_by_label("Undo write").is_none());
    harness.state_mut().status.written = vec!["graphs/base.toml".to_owned()];
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "Undo write"), [Action::UndoWrite]);
    // A value that is as in the file, or is the demo's, has no buttons to write and to reset it.
    harness.state_mut().params[0].driven = true;
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "Write to file"), []);
    assert_eq!(click(&mut harness, "reset fog"), []);
}

#[test]
fn params_stand_in_groups_with_units_and_named_choices() {
    let mut window = Window::new(&[Panel::Params]);
    window.params[0].group = Some("Camera".to_owned());
    window.params[0].unit = Some("EV".to_owned());
    let names = ["Reinhard", "AgX"].map(str::to_owned).to_vec();
    let tone = Param {
        kind: ComponentKind::Uint,
        choices: names,
        range: Some([0.0, 1.0]),
        ..param("tone", vec![1.0], vec![1.0])
    };
    let camera = Some("Camera".to_owned());
    window.params.push(Param { group: camera, tooltip: Some("The curve of the film.".to_owned()), ..tone });
    window.params.push(Param { color: true, ..param("ground", vec![0.5; 3], vec![0.5; 3]) });
    let mut harness = window.harness(1280.0, 720.0);
    // A slider and its number both have the label.
    let y = |harness: &Harness<'_, Window>, name: &str| {
        harness.query_all_by_label(name).next().map(|node| node.rect().center().y)
    };
    // The group has both of its params, though another stands between them in the file.
    let rows = ["Camera", "exposure", "tone", "fog", "ground"].map(|name| y(&harness, name));
    assert!(rows.is_sorted(), "{rows:?}");
    assert!(harness.query_by_value("2.0 EV").is_some(), "the number has its unit");
    harness.get_by_label("tone").hover();
    harness.run_steps(60);
    assert!(harness.query_by_label_contains("The curve of the film.").is_some());
    click(&mut harness, "tone");
    assert_eq!(click(&mut harness, "Reinhard"), [Action::SetParam("tone".to_owned(), vec![0.0])]);
    // A closed group hides its params.
    click(&mut harness, "Camera");
    harness.run_steps(30);
    assert!(harness.query_by_label("exposure").is_none() && harness.query_by_label("fog").is_some());
}

#[test]
fn what_goes_wrong_opens_by_itself_and_its_place_is_copied() {
    let mut harness = Window::new(&[]).harness(1280.0, 720.0);
    let place = "graphs/a.toml:7:12";
    let window = harness.state_mut();
    window.status.failed = Some(17);
    window.status.generation = 16;
    window.problems = vec![Problem {
        error: true,
        place: Some(place.to_owned()),
        title: "RX0100: there is no target `colour`".to_owned(),
        text: "error[RX0100]".to_owned(),
    }];
    harness.run_steps(3);
    assert!(harness.query_all_by_label("showing generation 16, 17 failed").count() == 2, "in the bar and in the panel");
    assert_eq!(click(&mut harness, place), [Action::Copy(place.to_owned())]);
    assert_eq!(click(&mut harness, "edit"), [Action::Edit(place.to_owned())]);
    // Mended, the panel goes.
    let window = harness.state_mut();
    (window.status.failed, window.problems) = (None, Vec::new());
    harness.run_steps(3);
    assert!(!harness.state().panels.layout.is_open(Panel::Problems));
    // The panel below it comes back.
    harness.state_mut().panels.layout.open(Panel::Frame);
    for failed in [18, 19] {
        let window = harness.state_mut();
        window.status.failed = Some(failed);
        window.problems = vec![Problem { title: "RX0100".to_owned(), ..Problem::default() }];
        harness.run_steps(3);
        assert!(harness.state().panels.layout.is_open(Panel::Problems));
    }
    let window = harness.state_mut();
    (window.status.failed, window.problems) = (None, Vec::new());
    harness.run_steps(3);
    assert!(harness.state().panels.layout.is_open(Panel::Frame));
}

#[test]
fn a_demo_shows_its_timeline_at_first_and_a_graph_shows_none() {
    let mut window = Window::new(&[]);
    window.panels = Panels::new(Layout::default());
    let mut harness = window.harness(1280.0, 720.0);
    assert!(harness.query_by_label("Record camera").is_none());
    harness.state_mut().timeline = Some(Timeline { name: "valley".to_owned(), duration: 8.0, ..Timeline::default() });
    harness.run_steps(3);
    assert!(harness.query_by_label("Record camera").is_some());
}

#[test]
fn many_problems_are_capped() {
    let mut window = Window::new(&[Panel::Problems]);
    window.problems = (0..70).map(|n| Problem { title: format!("mistake {n}"), ..Problem::default() }).collect();
    let harness = window.harness(1280.0, 20_000.0);
    assert!(harness.query_by_label("and 20 more").is_some());
    assert!(harness.query_by_label("mistake 49").is_some() && harness.query_by_label("mistake 50").is_none());
}

#[test]
fn a_texel_and_the_numbers_of_a_channel_are_read() {
    let mut window = Window::new(&[Panel::Inspect]);
    window.inspected = Some(inspected());
    let mut harness = window.harness(1280.0, 720.0);
    for said in [
        "NaN in r",
        "infinite in r",
        "NaN in g",
        "2",
        "texel 3, 4",
        "pinned",
        "0x7e00",
        "0x3400",
        "count u32",
        "42",
        "used u32",
        "6",
    ] {
        assert!(harness.query_all_by_label(said).next().is_some(), "{said}");
    }
    // A count of nothing is no button, and only the chosen channel has counts.
    assert!(harness.query_by_label("infinite in g").is_none());
    let find = |sought, channel, forward| [Action::Find { sought, channel, forward }];
    assert_eq!(click(&mut harness, "next NaN in g"), find(Sought::Nan, 1, true));
    assert_eq!(click(&mut harness, "previous infinite in r"), find(Sought::Infinite, 0, false));
    assert_eq!(click(&mut harness, "next largest in r"), find(Sought::Largest, 0, true));
    assert_eq!(click(&mut harness, "pin 1"), [Action::ChoosePin(1)]);
    assert_eq!(click(&mut harness, "Unpin"), [Action::Unpin(2)]);
    let inspected = harness.state_mut().inspected.as_mut().unwrap();
    inspected.not_finite = vec![NotFinite::default(); 2];
    inspected.looking = Some(Looking { sought: Sought::Nan, looked: 3, slices: 64 });
    (inspected.pins, inspected.pinned) = (Vec::new(), None);
    harness.run_steps(2);
    assert!(harness.query_by_label("looking for NaN: slice 3 of 64").is_some());
    assert_eq!(click(&mut harness, "Stop"), [Action::StopFind]);
    // There is none in this slice, and may be one in another.
    assert_eq!(click(&mut harness, "next NaN in r"), find(Sought::Nan, 0, true));
    assert_eq!(click(&mut harness, "Pin a texel"), [Action::Pin([3, 4])]);
    let own = Map { map: 0, range: None, channel: 0 };
    assert_eq!(click(&mut harness, "own map"), [Action::Display(Some(own))]);
    assert_eq!(click(&mut harness, "CSV"), [Action::WriteTable]);
}

/// The writers of the pinned texel are asked for by a button, and each line opens in the editor.
#[test]
fn the_writers_of_the_pinned_texel_are_listed() {
    let mut window = Window::new(&[Panel::Inspect]);
    window.inspected = Some(inspected());
    let mut harness = window.harness(1280.0, 20_000.0);
    assert!(harness.query_by_label("(9, 1, 0)").is_none());
    assert_eq!(click(&mut harness, "Who wrote it"), [Action::FindWriters(true)]);
    let none = "No pass that may write it has run with these shaders.";
    harness.state_mut().inspected.as_mut().unwrap().writers = Some(Vec::new());
    harness.run_steps(2);
    assert!(harness.query_by_label(none).is_some());
    let place = "shaders/shade.comp:41";
    let write = |invocation| TexelWriter {
        place: Some(place.to_owned()),
        invocation,
        workgroup: [1, 0, 0],
        values: vec!["0.5".to_owned(), "7".to_owned()],
    };
    let pass =
        |pass: &str, count, writes| PassWriters { pass: pass.to_owned(), frame: 12, count, race: count > 1, writes };
    harness.state_mut().inspected.as_mut().unwrap().writers = Some(vec![
        pass("clear", 0, Vec::new()),
        pass("shade", 1, vec![write([9, 1, 0])]),
        pass("sum", 300, vec![TexelWriter { place: None, ..write([3, 4, 5]) }; 256]),
    ]);
    harness.run_steps(2);
    let race = "Several invocations wrote it: without a barrier between them, the device decides which value is left.";
    for said in ["did not write it in frame 12", "in frame 12", "300 times in frame 12", race, "(9, 1, 0)", "0.5  7"] {
        assert!(harness.query_all_by_label(said).next().is_some(), "{said}");
    }
    assert!(harness.query_by_label("and 288 more").is_some() && harness.query_by_label(none).is_none());
    assert_eq!(harness.query_all_by_label("(3, 4, 5)").count(), 12);
    assert_eq!(click(&mut harness, place), [Action::Copy(place.to_owned())]);
    assert_eq!(click(&mut harness, "edit"), [Action::Edit(place.to_owned())]);
    assert_eq!(click(&mut harness, "Who wrote it"), [Action::FindWriters(false)]);
}

/// Everything that can be seen and read of a window, in order: its role, its text, its state, and its place, in points.
fn seen(harness: &Harness<'_, Window>) -> String {
    let mut text = String::new();
    for node in harness.root().children_recursive() {
        let node = node.accesskit_node();
        // A node that only holds others together has no place, and the lines of a text are its value.
        let Some(rect) = node.bounding_box().filter(|_| node.role() != egui::accesskit::Role::TextRun) else {
            continue;
        };
        let place = [rect.x0, rect.y0, rect.width(), rect.height()].map(|points| format!("{points:.0}")).join(" ");
        let mut line = format!("{:?} at {place}", node.role());
        line.extend(node.label().map(|label| format!(" {label:?}")));
        line.extend(node.value().map(|value| format!(" = {value:?}")));
        line.extend(node.numeric_value().map(|value| format!(" = {value}")));
        line.extend(node.toggled().map(|toggled| format!(" {toggled:?}")));
        if node.is_disabled() {
            line.push_str(" disabled");
        }
        text.push_str(&line);
        text.push('\n');
    }
    text
}

#[test]
fn each_panel_is_laid_out_as_it_was() {
    for panel in Panel::ALL {
        let mut window = Window::new(&[panel]);
        window.inspected = Some(inspected());
        window.problems = vec![Problem { title: "a mistake".to_owned(), ..Problem::default() }];
        let tracks = vec![Track::new(Lane::Camera, "camera", vec![0.0, 5.0])];
        window.timeline = Some(Timeline { duration: 10.0, time: 2.5, tracks, ..Timeline::default() });
        insta::assert_snapshot!(panel.title(), seen(&window.harness(1280.0, 720.0)));
    }
}

#[test]
fn a_demo_is_paused_looped_and_given_back() {
    let mut window = Window::new(&[Panel::Timeline]);
    window.timeline = Some(Timeline {
        duration: 10.0,
        time: 2.5,
        tracks: vec![Track::new(Lane::Camera, "camera", vec![0.0, 5.0])],
        ..Timeline::default()
    });
    let mut harness = window.harness(1280.0, 720.0);
    assert_eq!(click(&mut harness, "Record camera"), [Action::RecordKey]);
    assert_eq!(click(&mut harness, "camera key 2 at 5.00 s"), [Action::Seek(5.0)]);
    assert_eq!(click(&mut harness, "loop"), [Action::Loop(true)]);
    assert_eq!(click(&mut harness, "Pause demo"), [Action::Pause]);
    assert_eq!(click(&mut harness, "Give back"), [Action::HandBack]);
}

/// Two keys of a param in a demo of ten seconds; gives where the second one is, and the points of a second.
fn re_timed() -> (Harness<'static, Window>, egui::Pos2, f32) {
    let mut window = Window::new(&[Panel::Timeline]);
    let lane = Lane::Param("fog".to_owned());
    let tracks = vec![Track::new(lane, "fog", vec![2.0, 4.0])];
    window.timeline = Some(Timeline { duration: 10.0, drives: true, tracks, ..Timeline::default() });
    let harness = window.harness(1280.0, 720.0);
    let [first, second] =
        ["fog key 1 at 2.00 s", "fog key 2 at 4.00 s"].map(|name| harness.get_by_label(name).rect().center());
    (harness, second, (second.x - first.x) / 2.0)
}

fn drag(harness: &mut Harness<'_, Window>, from: egui::Pos2, to: egui::Pos2) {
    harness.drag_at(from);
    harness.run_steps(2);
    harness.hover_at(from + (to - from) * 0.5);
    harness.run_steps(2);
    harness.hover_at(to);
    harness.run_steps(2);
    harness.drop_at(to);
    harness.run_steps(2);
}

#[test]
fn a_caption_is_dragged_as_a_whole_and_a_check_is_not() {
    let mut window = Window::new(&[Panel::Timeline]);
    let captions = Track { lasting: vec![2.0], ..Track::new(Lane::Captions, "captions", vec![1.0]) };
    let tracks = vec![captions, Track::new(Lane::Checks, "checks", vec![4.0, 6.0])];
    window.timeline = Some(Timeline { duration: 10.0, drives: true, tracks, ..Timeline::default() });
    let mut harness = window.harness(1280.0, 720.0);
    let [caption, check, later] = ["captions key 1 at 1.00 s", "checks key 1 at 4.00 s", "checks key 2 at 6.00 s"]
        .map(|name| harness.get_by_label(name).rect().center());
    let second = (later.x - check.x) / 2.0;
    // Its begin is in the bar's row, and any place of the bar takes all of it.
    let begin = egui::pos2(check.x - 3.0 * second, caption.y);
    let inside = begin + egui::vec2(1.5 * second, 0.0);
    drag(&mut harness, check, check + egui::vec2(second, 0.0));
    let moves = |harness: &Harness<'_, Window>| {
        let moved = |action: &Action| matches!(action, Action::MoveKey { .. });
        harness.state().actions.iter().filter(|action| moved(action)).cloned().collect::<Vec<_>>()
    };
    assert_eq!(moves(&harness), []);
    // It stays on screen to its end, however far it is pulled.
    for (from, by, end) in [(begin, 20.0, 8.0), (inside, 20.0, 8.0), (inside, 1.0, 2.0)] {
        harness.state_mut().actions.clear();
        drag(&mut harness, from, from + egui::vec2(by * second, 0.0));
        let moved = moves(&harness);
        let [Action::MoveKey { lane: Lane::Captions, key: 0, to }] = moved.as_slice() else { panic!("{moved:?}") };
        assert!((to - end).abs() < 0.02, "{to} instead of {end}");
        // The file has it, and then has the old time again.
        for time in [*to, 1.0] {
            harness.state_mut().timeline.as_mut().unwrap().tracks[0].keys = vec![time];
            harness.run_steps(2);
        }
    }
    harness.state_mut().actions.clear();
    harness.hover_at(inside);
    harness.drag_at(inside);
    harness.run_steps(2);
    harness.drop_at(inside);
    harness.run_steps(2);
    let asked = harness.state().actions.clone();
    let [Action::Seek(to)] = asked.as_slice() else { panic!("{asked:?}") };
    assert!((to - 2.5).abs() < 0.05, "{to}");
    assert_eq!(click(&mut harness, "checks key 1 at 4.00 s"), [Action::Seek(4.0)]);
}

#[test]
fn a_key_is_dragged_to_another_time_and_stays_between_its_neighbours() {
    let (mut harness, at, second) = re_timed();
    drag(&mut harness, at, at + egui::vec2(3.0 * second, 0.0));
    let moved: Vec<_> = harness.state().actions.clone();
    let [Action::MoveKey { lane: Lane::Param(name), key: 1, to }] = moved.as_slice() else { panic!("{moved:?}") };
    assert!(name == "fog" && (to - 7.0).abs() < 0.05, "{to}");
    // Until the file has it, it stays where it was dropped; then it is where the file says.
    let x = |harness: &Harness<'_, Window>| harness.get_by_label_contains("fog key 2").rect().center().x;
    assert!((x(&harness) - at.x - 3.0 * second).abs() < 2.0);
    harness.state_mut().timeline.as_mut().unwrap().tracks[0].keys[1] = 6.0;
    harness.run_steps(2);
    assert!((x(&harness) - at.x - 2.0 * second).abs() < 2.0);

    // Not beyond the key before it.
    let (mut harness, at, second) = re_timed();
    drag(&mut harness, at, at - egui::vec2(3.5 * second, 0.0));
    let Some(Action::MoveKey { to, .. }) = harness.state().actions.last() else { panic!() };
    assert!((to - 2.01).abs() < 1e-9, "{to}");
}

#[test]
fn a_drag_beside_the_keys_scrubs() {
    let (mut harness, at, second) = re_timed();
    let from = at + egui::vec2(2.0 * second, 0.0);
    drag(&mut harness, from, from + egui::vec2(second, 0.0));
    let seeks: Vec<f64> = harness
        .state()
        .actions
        .iter()
        .map(|action| if let Action::Seek(to) = action { *to } else { panic!("{action:?}") })
        .collect();
    assert!(seeks.is_sorted() && (seeks.last().unwrap() - 7.0).abs() < 0.05, "{seeks:?}");
}

#[test]
fn the_camera_goes_home_and_to_the_places_of_the_world() {
    let mut harness = Window::new(&[Panel::World]).harness(1280.0, 720.0);
    assert_eq!(click(&mut harness, "Home"), [Action::Home]);
    assert_eq!(click(&mut harness, "roof"), [Action::Camera("roof".to_owned())]);
    assert_eq!(click(&mut harness, "Copy camera as TOML"), [Action::CopyCamera]);
    // Under the name that stands in the empty field.
    assert_eq!(click(&mut harness, "Write to world"), [Action::WriteCamera("camera".to_owned())]);
    let field = harness.get_by_label("name");
    field.focus();
    field.type_text("north roof");
    harness.run_steps(4);
    assert_eq!(click(&mut harness, "Write to world"), [], "a key of TOML has no spaces");
}

#[test]
fn a_long_label_ends_within_its_panel() {
    let mut window = Window::new(&[Panel::Params]);
    let label = "Most samples averaged on a face that nothing has lit for a long while";
    window.params = [false, true]
        .map(|driven| Param { label: label.to_owned(), driven, ..param("most", vec![1.0], vec![1.0]) })
        .to_vec();
    let harness = window.harness(1280.0, 720.0);
    let labels = texts(&harness, label);
    assert!(labels.len() == 2 && labels.iter().all(|rect| rect.right() <= 1280.0), "{labels:?}");
    assert!(harness.get_by_label("demo").rect().right() <= 1280.0);
}

#[test]
fn a_narrow_panel_of_params_leaves_labels_whole() {
    let label = "Light of the sun at noon";
    let width = |size: f32| {
        let mut window = Window::new(&[Panel::Params]);
        window.panels.layout = side_by_side("picture", "params", 1.0 - size / 1280.0);
        window.params = vec![Param { label: label.to_owned(), ..param("sun", vec![1.0], vec![1.0]) }];
        let harness = window.harness(1280.0, 720.0);
        let [found] = texts(&harness, label)[..] else { panic!() };
        assert!(found.right() <= 1280.0, "{found:?}");
        found.width()
    };
    assert!((width(200.0) - width(600.0)).abs() < 1.0, "{} {}", width(200.0), width(600.0));
}

/// Two tabs beside each other. The left one has this share of the window.
fn side_by_side(left: &str, right: &str, share: f32) -> Layout {
    let tabs = |tab: &str| format!("{{ tabs = [\"{tab}\"] }}");
    let text =
        format!("docks = {{ across = {{ share = {share:?}, left = {}, right = {} }} }}", tabs(left), tabs(right));
    Layout::read(&text).unwrap()
}

#[test]
fn a_press_that_resizes_a_dock_is_not_the_pictures() {
    for (panel, across) in [(Panel::Inspect, true), (Panel::Passes, true), (Panel::Timeline, false)] {
        let harness = || {
            let mut window = Window::new(&[panel]);
            window.timeline = Some(Timeline { duration: 10.0, ..Timeline::default() });
            window.harness(1280.0, 720.0)
        };
        // A line through the centre of the window, from the picture outwards.
        let outwards = if panel == Panel::Passes { -1.0 } else { 1.0 };
        let middle = if across { 640.0 } else { 360.0 };
        let at = |along: f32| if across { egui::pos2(along, 400.0) } else { egui::pos2(600.0, along) };
        let still = harness();
        let taken = |along: f32| still.state().panels.has_pointer(&still.ctx, at(along));
        let edge = (0..400).map(|step| middle + outwards * step as f32).find(|along| taken(*along)).unwrap();
        let mut resized = 0;
        for step in -12..20 {
            let mut harness = harness();
            let from = edge + outwards * step as f32;
            let before = harness.state().panels.layout.clone();
            drag(&mut harness, at(from), at(from - 60.0 * outwards));
            let changed = harness.state().panels.layout != before;
            assert!(taken(from) || !changed, "{panel:?}: {step} points from the edge resizes and is not taken");
            resized += usize::from(changed);
        }
        assert!(resized > 0, "{panel:?}: its edge resizes");
    }
}

#[test]
fn a_panel_is_a_tab_a_window_or_a_part_of_the_window() {
    let mut window = Window::new(&[]);
    window.panels.layout = Layout::read(
        "docks = { across = { share = 0.7, left = { tabs = [\"picture\"] }, right = { tabs = [\"params\", \"inspect\"], front = 1 } } }\n\
         floating = [{ at = [100.0, 200.0], size = [420.0, 200.0], docks = { tabs = [\"frame\"] } }]",
    )
    .unwrap();
    window.inspected = Some(inspected());
    let mut harness = window.harness(1280.0, 720.0);
    // The tab in front is drawn, the one behind is not; the floating panel is where the file says.
    assert!(texts(&harness, "reading").is_empty() && harness.query_by_label("Write to file").is_none());
    harness.get_by_label("2,097,152 voxels in 300 chunks");
    let free =
        |harness: &Harness<'_, Window>, x, y| !harness.state().panels.has_pointer(&harness.ctx, egui::pos2(x, y));
    assert!(!free(&harness, 300.0, 300.0) && !free(&harness, 1100.0, 300.0) && free(&harness, 300.0, 600.0));
    // A click on the name of the hidden one brings it to the front, one more closes it.
    click(&mut harness, "Params");
    harness.get_by_label("Write to file");
    click(&mut harness, "Params");
    assert!(harness.query_by_label("Write to file").is_none() && harness.state().panels.layout.is_open(Panel::Inspect));
    // The drawn layout is the kept one.
    let layout = harness.state().panels.layout.clone();
    let again = Layout::read(&layout.write()).unwrap();
    assert_eq!(again, layout);
}

#[test]
fn a_layout_is_brought_back_to_the_first() {
    let mut harness = Window::new(&[Panel::World, Panel::Frame]).harness(1280.0, 720.0);
    click(&mut harness, "Reset layout");
    let layout = &harness.state().panels.layout;
    assert!(layout.is_open(Panel::Passes) && layout.is_open(Panel::Params) && !layout.has(Panel::Frame), "{layout:?}");
}

#[test]
fn the_first_layout_leaves_most_of_the_picture_free() {
    let mut window = Window::new(&[]);
    window.panels.layout = Layout::default();
    window.panels.layout.beside = true;
    let harness = window.harness(1280.0, 720.0);
    let (free, whole) = (harness.state().panels.picture(&harness.ctx), harness.ctx.content_rect());
    assert!(free.width() >= 0.59 * whole.width(), "{free:?}");
}

#[test]
fn two_panels_share_a_side() {
    let mut harness = Window::new(&[Panel::Params]).harness(1280.0, 720.0);
    click(&mut harness, "Inspect");
    let y = |harness: &Harness<'_, Window>, name: &str| harness.get_by_label(name).rect().center().y;
    let inspect = |harness: &Harness<'_, Window>| texts(harness, "reading")[0].center().y;
    assert!(y(&harness, "Write to file") < 130.0 && inspect(&harness) > 300.0, "{}", inspect(&harness));
    click(&mut harness, "Params");
    assert!(harness.query_by_label("Write to file").is_none());
    assert!(inspect(&harness) < 150.0);
}

#[test]
fn land_that_is_made_around_the_camera_has_no_bounds() {
    let mut window = Window::new(&[Panel::World]);
    let harness = window.harness(1280.0, 720.0);
    harness.get_by_label("2,097,152");
    harness.get_by_label("[-64, 0, -64] to [64, 128, 64]");
    window = Window::new(&[Panel::World]);
    window.world.extent = WorldExtent::Around(Loading::default());
    let harness = window.harness(1280.0, 720.0);
    harness.get_by_label("none: made around the camera");
    assert!(harness.query_by_label("voxels").is_none());
}

#[test]
fn the_brush_has_shape_effect_size_and_material() {
    let mut harness = Window::new(&[Panel::World]).harness(1280.0, 720.0);
    let brush = Brush::default();
    assert_eq!(click(&mut harness, "Undo"), [], "there is nothing to undo");
    assert_eq!(click(&mut harness, "paint"), [Action::Brush(Brush { effect: Effect::Paint, ..brush })]);
    assert_eq!(click(&mut harness, "box"), [Action::Brush(Brush { shape: Shape::Box, ..brush })]);
    assert!(harness.query_by_label("height").is_none() && harness.query_by_label("stone 1").is_none());
    let window = harness.state_mut();
    window.brush = Brush { effect: Effect::Add, shape: Shape::Cylinder, ..brush };
    (window.steps, window.refused) = ([3, 1], Some("the edit covers nothing".to_owned()));
    harness.run_steps(2);
    let brush = harness.state().brush;
    assert_eq!(click(&mut harness, "Undo"), [Action::Undo]);
    assert_eq!(click(&mut harness, "Redo"), [Action::Redo]);
    assert_eq!(click(&mut harness, "stone 2"), [Action::Brush(Brush { material: Some(2), ..brush })]);
    assert!(harness.query_by_label("the last edit was not made: the edit covers nothing").is_some());
    assert!(harness.query_all_by_label("height").next().is_some());
    // A long palette is searched.
    assert!(harness.query_by_label("stone 37").is_none(), "it is farther down");
    let search = harness.query_all_by_role(egui::accesskit::Role::TextInput).last().unwrap();
    search.focus();
    search.type_text("NE 37");
    harness.run_steps(4);
    assert_eq!(click(&mut harness, "stone 37"), [Action::Brush(Brush { material: Some(37), ..brush })]);
}

#[test]
fn everything_can_be_hidden_and_works_in_any_window() {
    let every = |width, height| {
        for panel in Panel::ALL {
            let mut harness = Window::new(&[panel]).harness(width, height);
            harness.state_mut().panels.toggle();
            harness.run_steps(2);
            assert!(harness.query_by_label("Passes").is_none(), "hidden");
        }
    };
    // A pixel; 1280 × 720 at a scale of 300 %; a small window; a large one.
    for (width, height) in [(1.0, 1.0), (427.0, 240.0), (640.0, 400.0), (3840.0, 2160.0)] {
        every(width, height);
    }
    // In a narrow window a panel is reached by its name, and takes the place of the one before.
    let mut harness = Window::new(&[Panel::Passes, Panel::Params]).harness(427.0, 240.0);
    assert!(harness.query_by_label("Write to file").is_some() && harness.query_by_label("hit").is_none());
    click(&mut harness, "Passes");
    assert!(harness.query_by_label("Write to file").is_none() && harness.query_by_label("hit").is_some());
}

#[test]
fn a_window_that_was_small_for_a_moment_leaves_the_docks_as_they_were() {
    let mut harness = Window::new(&[Panel::Params]).harness(1280.0, 720.0);
    let left = |harness: &Harness<'_, Window>| harness.get_by_label("Write to file").rect().left();
    let before = left(&harness);
    for (width, height) in [(64.0, 64.0), (1280.0, 720.0)] {
        harness.set_size(Vec2::new(width, height));
        harness.run_steps(4);
    }
    assert!((left(&harness) - before).abs() < 1.0, "{before} {}", left(&harness));
}

#[test]
fn a_device_that_works_for_long_can_be_interrupted() {
    let mut window = Window::new(&[]);
    window.status.busy = Some(Busy { pass: Some("spin".to_owned()), seconds: 4 });
    let mut harness = window.harness(1280.0, 720.0);
    assert!(harness.query_by_label("the device has worked on `spin` for 4 s").is_some());
    assert_eq!(click(&mut harness, "Cancel"), [Action::Cancel]);
}

#[test]
fn a_pipeline_that_takes_long_is_named_in_the_bar() {
    let mut harness = Window::new(&[]).harness(1280.0, 720.0);
    assert!(harness.query_by_label_contains("compiled").is_none());
    harness.state_mut().status.compiling = Some(Compiling { pass: "spin".to_owned(), seconds: 4, left: 3 });
    harness.run_steps(2);
    harness.get_by_label("the driver has compiled `spin` for 4 s; pipelines left: 3");
}

#[test]
fn a_window_without_a_picture_says_that_it_makes_one() {
    let mut harness = Window::new(&[]).harness(1280.0, 720.0);
    assert!(harness.query_by_label("making the first picture").is_none());
    harness.state_mut().status.picture = FirstPicture::Awaited;
    harness.run_steps(2);
    harness.get_by_label("making the first picture");
}

#[test]
fn a_pass_that_is_off_is_named_in_the_bar() {
    let mut harness = Window::new(&[]).harness(1280.0, 720.0);
    assert!(harness.query_by_label_contains("off until").is_none());
    harness.state_mut().passes[0].1 = PassState::Off;
    harness.run_steps(2);
    harness.get_by_label("`hit` is off until its shader or graph changes");
    harness.state_mut().passes[1].1 = PassState::Off;
    harness.run_steps(2);
    harness.get_by_label("`hit` and 1 more are off until their shaders or graph change");
}

#[test]
fn a_narrow_window_shows_a_side_that_has_a_panel() {
    let harness = Window::new(&[Panel::Passes]).harness(640.0, 400.0);
    harness.get_by_label("hit");
}

/// An open panel of a wide window is a tab in a narrow one.
#[test]
fn a_narrow_window_has_a_tab_for_each_open_panel() {
    let mut harness = Window::new(&[Panel::Passes, Panel::Params, Panel::Frame]).harness(640.0, 400.0);
    let front = |harness: &Harness<'_, Window>| {
        [("hit", Panel::Passes), ("fog", Panel::Params), ("2,097,152 voxels in 300 chunks", Panel::Frame)]
            .into_iter()
            .filter(|(text, _)| harness.query_all_by_label(text).next().is_some())
            .map(|(_, panel)| panel)
            .collect::<Vec<_>>()
    };
    assert_eq!(front(&harness), [Panel::Params]);
    for (panel, name) in [(Panel::Frame, "Frame"), (Panel::Passes, "Passes"), (Panel::Params, "Params")] {
        // The names in the bar stand above those of the tabs.
        let lowest = harness.query_all_by_label(name).max_by(|a, b| a.rect().top().total_cmp(&b.rect().top())).unwrap();
        let at = lowest.rect().center();
        harness.drag_at(at);
        harness.drop_at(at);
        harness.run_steps(6);
        assert_eq!(front(&harness), [panel], "after a click at {at:?}");
    }
    let open = |harness: &Harness<'_, Window>, panel| harness.state().panels.layout.has(panel);
    assert!([Panel::Passes, Panel::Params, Panel::Frame].iter().all(|panel| open(&harness, *panel)));
}

#[test]
fn the_picture_is_under_the_panels_or_beside_them() {
    let mut harness = Window::new(&[Panel::Passes, Panel::Params]).harness(1280.0, 720.0);
    let whole = harness.ctx.content_rect();
    let picture = |harness: &Harness<'_, Window>| harness.state().panels.picture(&harness.ctx);
    assert_eq!(picture(&harness), whole);
    assert_eq!(click(&mut harness, "Beside"), []);
    let beside = picture(&harness);
    assert!(beside.width() < 0.6 * whole.width() && beside.top() > 10.0 && whole.contains_rect(beside), "{beside:?}");
    let taken = |harness: &Harness<'_, Window>, at| harness.state().panels.has_pointer(&harness.ctx, at);
    assert!(!taken(&harness, beside.center()) && taken(&harness, beside.left_center() - egui::vec2(20.0, 0.0)));
    harness.state_mut().panels.layout.close(Panel::Passes);
    harness.run_steps(3);
    let wider = picture(&harness);
    assert!(wider.left() < 1.0 && wider.width() > beside.width(), "{wider:?} {beside:?}");
    harness.state_mut().panels.layout.close(Panel::Params);
    harness.run_steps(3);
    let below = picture(&harness);
    assert!(below.width() > 1270.0 && below.top() > 10.0, "only the bar is left: {below:?}");
    harness.state_mut().panels.toggle();
    harness.run_steps(2);
    assert_eq!(picture(&harness), whole, "nothing is drawn");
}

#[test]
fn a_kept_picture_is_compared_in_the_ways_that_are_asked_for() {
    let mut harness = Window::new(&[Panel::Compare]).harness(1280.0, 720.0);
    harness.get_by_label("Nothing is kept yet.");
    assert_eq!(click(&mut harness, "Keep"), [Action::Keep]);
    let kept = Some("color, generation 3, 320 × 180".to_owned());
    harness.state_mut().compare = Compare { kept, mode: CompareMode::Wipe, ..Compare::default() };
    harness.run_steps(2);
    harness.get_by_label("color, generation 3, 320 × 180");
    assert_eq!(click(&mut harness, "difference"), [Action::CompareMode(CompareMode::Difference)]);
    assert_eq!(click(&mut harness, "kept picture"), [Action::Flip]);
    assert_eq!(click(&mut harness, "Measure"), [Action::Measure]);
    harness.state_mut().compare.figures = Figures::Found {
        of: "color, generation 4".to_owned(),
        flip: 0.5,
        rmse: 0.25,
        max: 2.0,
        differing: [1234, 57_600],
    };
    harness.run_steps(2);
    for said in ["0.500000", "0.250000", "2.000000", "1,234 of 57,600"] {
        harness.get_by_label(said);
    }
    // A live target is measured while it is shown.
    harness.state_mut().compare.live = true;
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "Measure"), [Action::Measure]);
    harness.state_mut().compare.mode = CompareMode::Off;
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "Measure"), []);
    harness.state_mut().compare.mode = CompareMode::Wipe;
    // A target that cannot be compared has a message, and no figures.
    harness.state_mut().compare.refused = Some("the shown target is 4×4, the kept picture 8×8".to_owned());
    harness.run_steps(2);
    harness.get_by_label("the shown target is 4×4, the kept picture 8×8");
    assert_eq!(click(&mut harness, "Measure"), []);
    assert_eq!(click(&mut harness, "×"), [Action::ForgetKept]);
}

#[test]
fn a_picture_is_loaded_from_a_file_that_was_named() {
    let mut harness = Window::new(&[Panel::Compare]).harness(1280.0, 720.0);
    assert_eq!(click(&mut harness, "Load"), [], "no file is named");
    let field = harness.get_by_role(egui::accesskit::Role::TextInput);
    field.focus();
    field.type_text(" shots/a.png ");
    harness.run_steps(3);
    assert_eq!(click(&mut harness, "Load"), [Action::KeepFile("shots/a.png".to_owned())]);
}

#[test]
fn the_graph_is_a_picture_whose_nodes_are_inspected_by_a_click() {
    let mut harness = Window::new(&[Panel::Graph]).harness(1280.0, 720.0);
    let hit = Shown::after("depth", Some("hit".to_owned()));
    assert_eq!(click(&mut harness, "pass hit"), [Action::Show(hit.clone())]);
    assert!(harness.state().panels.layout.is_open(Panel::Inspect));
    assert_eq!(click(&mut harness, "depth as hit leaves it"), [Action::Show(hit)]);
    // A pass that writes nothing shows nothing, and all stand from left to right.
    assert_eq!(click(&mut harness, "pass bloom"), []);
    let left = |name: &str| harness.get_by_label(name).rect().left();
    assert!(left("pass hit") < left("depth as hit leaves it"));
    assert!(left("depth as hit leaves it") < left("pass shade"));
    assert!(left("pass shade") < left("color as shade leaves it"));
}

/// A thumbnail makes its node larger, and stands over its name; it changes with its number, and goes with its target.
#[test]
fn a_target_in_the_picture_of_a_graph_has_a_thumbnail() {
    let mut window = Window::new(&[Panel::Graph]);
    let thumbnail = |number, red: u8| Thumbnail {
        pass: 0,
        resource: 0,
        number,
        size: [48, 27],
        rgba: [red, 0, 0, 255].repeat(48 * 27).into(),
    };
    window.thumbnails = vec![thumbnail(1, 200)];
    let mut harness = window.harness(1280.0, 720.0);
    harness.run_steps(3);
    let height = |harness: &Harness<'_, Window>, name: &str| harness.get_by_label(name).rect().height();
    assert!(height(&harness, "depth as hit leaves it") > height(&harness, "color as shade leaves it") + 20.0);
    let textures = |harness: &Harness<'_, Window>| {
        let manager = harness.ctx.tex_manager();
        let manager = manager.read();
        manager.allocated().filter(|(_, meta)| meta.name == "thumbnail").count()
    };
    assert_eq!(textures(&harness), 1);
    harness.state_mut().thumbnails = vec![thumbnail(2, 90), Thumbnail { pass: 1, resource: 1, ..thumbnail(3, 10) }];
    harness.run_steps(3);
    assert_eq!(textures(&harness), 2);
    let hit = Shown::after("depth", Some("hit".to_owned()));
    assert_eq!(click(&mut harness, "depth as hit leaves it"), [Action::Show(hit)]);
    harness.state_mut().panels.layout.close(Panel::Graph);
    harness.run_steps(3);
    assert_eq!(textures(&harness), 0, "a closed panel has none");
}

#[test]
fn the_picture_of_a_graph_follows_a_drag_and_zooms_at_the_pointer() {
    let mut harness = Window::new(&[Panel::Graph]).harness(1280.0, 720.0);
    let place = |harness: &Harness<'_, Window>, name: &str| harness.get_by_label(name).rect();
    let before = place(&harness, "pass hit");
    let ground = before.center() + Vec2::new(0.0, 60.0);
    harness.drag_at(ground);
    harness.run_steps(2);
    harness.hover_at(ground + Vec2::new(50.0, 10.0));
    harness.run_steps(2);
    harness.drop_at(ground + Vec2::new(50.0, 10.0));
    harness.run_steps(2);
    let moved = place(&harness, "pass hit");
    assert!((moved.center() - before.center() - Vec2::new(50.0, 10.0)).length() < 7.0, "{before} {moved}");
    let pointer = moved.center();
    harness.hover_at(pointer);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: Vec2::new(0.0, -100.0),
        modifiers: egui::Modifiers::NONE,
    });
    harness.run_steps(20);
    let smaller = place(&harness, "pass hit");
    assert!(smaller.width() < moved.width() * 0.8 && (smaller.center() - pointer).length() < 3.0, "{smaller} {moved}");
}

#[test]
fn presets_are_kept_set_and_deleted() {
    let mut window = Window::new(&[Panel::Params]);
    window.presets = vec![
        Preset { name: "dusk".to_owned(), differing: vec!["exposure: 2, then 0.5".to_owned()] },
        Preset { name: "noon".to_owned(), ..Preset::default() },
    ];
    let mut harness = window.harness(1280.0, 720.0);
    assert_eq!(click(&mut harness, "Keep values"), [], "it has no name");
    assert_eq!(click(&mut harness, "dusk"), [Action::ApplyPreset("dusk".to_owned())]);
    harness.get_by_label("noon").click_secondary();
    harness.run_steps(6);
    assert_eq!(click(&mut harness, "Delete noon"), [Action::DeletePreset("noon".to_owned())]);
    let field = harness.get_by_role(egui::accesskit::Role::TextInput);
    field.focus();
    field.type_text("dawn");
    harness.run_steps(3);
    assert_eq!(click(&mut harness, "Keep values"), [Action::SavePreset("dawn".to_owned())]);
    harness.state_mut().presets.push(Preset { name: "dawn".to_owned(), ..Preset::default() });
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "Replace"), [Action::SavePreset("dawn".to_owned())]);
}

#[test]
fn a_file_of_the_project_is_found_by_words_and_opened() {
    let mut harness = Window::new(&[Panel::Params]).harness(1280.0, 720.0);
    assert_eq!(click(&mut harness, "Open"), [Action::ListFiles]);
    let listed = |harness: &mut Harness<'_, Window>| {
        harness.state_mut().panels.switch();
        harness.state_mut().actions.clear();
        harness.run_steps(4);
    };
    let press = |harness: &mut Harness<'_, Window>, keys: &[egui::Key]| {
        for key in keys {
            harness.key_press(*key);
            harness.run_steps(3);
        }
        std::mem::take(&mut harness.state_mut().actions)
    };
    listed(&mut harness);
    harness.get_by_label("graphs/test.toml (open)");
    assert_eq!(click(&mut harness, "worlds/a.toml"), [Action::Open(FileKind::World, "worlds/a.toml".to_owned())]);
    assert!(!harness.state().panels.is_switching());
    // Words in any order leave the files that have them; arrows choose among them, and Enter opens.
    listed(&mut harness);
    harness.get_by_label("file to open").type_text("TOML graphs");
    harness.run_steps(4);
    assert!(harness.query_by_label("worlds/a.toml").is_none());
    let open = |path: &str| [Action::Open(FileKind::Graph, path.to_owned())];
    assert_eq!(press(&mut harness, &[egui::Key::ArrowDown, egui::Key::Enter]), open("graphs/test.toml"));
    // Escape leaves everything as it is, and a filter without a match has a message.
    listed(&mut harness);
    harness.get_by_label("file to open").type_text("nothing");
    harness.run_steps(4);
    harness.get_by_label("No file of the project has this in its path.");
    assert_eq!(press(&mut harness, &[egui::Key::Enter, egui::Key::Escape]), []);
    assert!(!harness.state().panels.is_switching());
}

#[test]
fn a_param_that_a_demo_drives_is_moved_while_it_is_recorded() {
    let mut window = Window::new(&[Panel::Params]);
    window.params[1].driven = true;
    let mut harness = window.harness(1280.0, 720.0);
    assert_eq!(click(&mut harness, "fog"), [], "the demo has it");
    assert_eq!(click(&mut harness, "Record"), [Action::Record(true)]);
    harness.state_mut().records = true;
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "fog"), [Action::SetParam("fog".to_owned(), vec![1.0])]);
    assert_eq!(click(&mut harness, "Record"), [Action::Record(false)]);
}
