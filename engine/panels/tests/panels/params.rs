//! Params and presets.

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use raxel_panels::view::{ComponentKind, Param, Preset};
use raxel_panels::{Action, Layout, Panel, WriteTo};

use crate::window::{Window, param};
use crate::{click, texts};

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

#[test]
fn buttons_beside_fields_end_within_a_narrow_panel() {
    let harness = Window::new(&[Panel::Params, Panel::World]).harness(1000.0, 900.0);
    for button in ["Keep values", "Write to world"] {
        let rect = harness.get_by_label(button).rect();
        assert!(rect.right() <= 1000.0, "{button} {rect}");
    }
}

/// Two tabs beside each other. The left one has this share of the window.
fn side_by_side(left: &str, right: &str, share: f32) -> Layout {
    let tabs = |tab: &str| format!("{{ tabs = [\"{tab}\"] }}");
    let text =
        format!("docks = {{ across = {{ share = {share:?}, left = {}, right = {} }} }}", tabs(left), tabs(right));
    Layout::read(&text).unwrap()
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
