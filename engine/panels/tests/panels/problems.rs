//! Problems, and what the bar says.

use egui_kittest::kittest::Queryable as _;
use raxel_panels::view::{Busy, Compiling, FirstPicture, PassState, Problem};
use raxel_panels::{Action, Panel};

use crate::click;
use crate::window::Window;

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
fn many_problems_are_capped() {
    let mut window = Window::new(&[Panel::Problems]);
    window.problems = (0..70).map(|n| Problem { title: format!("mistake {n}"), ..Problem::default() }).collect();
    let harness = window.harness(1280.0, 20_000.0);
    assert!(harness.query_by_label("and 20 more").is_some());
    assert!(harness.query_by_label("mistake 49").is_some() && harness.query_by_label("mistake 50").is_none());
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
fn a_take_that_is_recorded_is_named_in_the_bar() {
    let mut window = Window::new(&[]);
    window.status.recording = Some(12);
    let harness = window.harness(1280.0, 720.0);
    harness.get_by_label("recording 12 s");
}
