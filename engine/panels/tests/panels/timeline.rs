//! The timeline of a demo.

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use raxel_panels::view::{Lane, Timeline, Track};
use raxel_panels::{Action, Layout, Panel, Panels};

use crate::window::Window;
use crate::{click, drag};

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
