//! The panels of the frame, the world and the passes.

use egui_kittest::kittest::Queryable as _;
use raxel_panels::view::{Brush, Effect, Loading, Shape, Shown, Use, WorldExtent};
use raxel_panels::{Action, Panel};

use crate::window::Window;
use crate::{click, texts};

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
fn values_of_the_world_end_within_a_narrow_panel() {
    let harness = Window::new(&[Panel::World]).harness(1000.0, 720.0);
    let bounds = texts(&harness, "[-64, 0, -64] to [64, 128, 64]");
    assert!(bounds.len() == 1 && bounds[0].right() <= 1000.0, "{bounds:?}");
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
