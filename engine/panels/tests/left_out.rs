//! Passes that do not run now: what can be asked to be shown after them, and before.

use egui::Vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use raxel_panels::view::{Pass, PassState, Resource, Shown, Use, View};
use raxel_panels::{Action, Layout, Panel, Panels};

/// The requests of a click on a cell of the matrix, with the left button and then with the right one.
fn asked(cell: &str) -> [Vec<Action>; 2] {
    let pass = |name: &'static str, state| Pass {
        name,
        after: name,
        times: None,
        state,
        groups: "",
        place: "graphs/a.toml:7",
        output: None,
    };
    let uses = vec![Use::default(); 4];
    let resources = [Resource { name: "color".to_owned(), uses, ..Resource::default() }];
    let states = [PassState::Ran, PassState::Condition, PassState::Unused, PassState::Unused];
    let mut layout = Layout::default();
    layout.open(Panel::Resources);
    [false, true].map(|right| {
        let show = |context: &egui::Context, (panels, actions): &mut (Panels, Vec<Action>)| {
            let names = ["see", "night", "light", "blur"];
            let passes = names.into_iter().zip(states).map(|(name, state)| pass(name, state)).collect();
            actions.extend(panels.show(context, &View { passes, resources: &resources, ..View::default() }));
        };
        let mut panels = Panels::new(layout.clone());
        panels.whole = true;
        let state = (panels, Vec::new());
        let mut harness = Harness::builder().with_size(Vec2::new(1280.0, 720.0)).build_state(show, state);
        harness.run_steps(3);
        let found = harness.get_by_label(cell);
        if right {
            found.click_secondary();
        } else {
            found.click();
        }
        harness.run_steps(4);
        harness.state().1.clone()
    })
}

fn shown_after(pass: &str) -> Vec<Action> {
    vec![Action::Show(Shown::after("color", Some(pass.to_owned())))]
}

#[test]
fn what_is_unused_is_shown_when_it_is_asked_for() {
    assert_eq!(asked("color after blur"), [shown_after("blur"), shown_after("light")]);
}

#[test]
fn a_pass_that_never_runs_is_no_place_in_the_frame() {
    assert_eq!(asked("color after night"), [vec![], vec![]]);
    // Before the next one is after the one that runs before both.
    assert_eq!(asked("color after light"), [shown_after("light"), shown_after("see")]);
}
