//! The picture of the graph, and the files of the project.

use egui::Vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use raxel_panels::view::{FileKind, Shown, Thumbnail};
use raxel_panels::{Action, Panel};

use crate::click;
use crate::window::Window;

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

/// In a low dock, all of a graph is too small for its names: it opens around the shown target, and a double click shows all.
#[test]
fn a_large_graph_opens_where_its_names_can_be_read() {
    let mut window = Window::new(&[Panel::Graph]);
    let resources = std::mem::take(&mut window.resources);
    window.resources = (0..12)
        .flat_map(|copy| {
            resources.iter().map(move |resource| {
                let name = if copy == 0 { resource.name.clone() } else { format!("{}-{copy}", resource.name) };
                raxel_panels::view::Resource { name, ..resource.clone() }
            })
        })
        .collect();
    // Two clicks of a double click are close to each other.
    window.panels.whole = true;
    let builder = Harness::builder().with_size(Vec2::new(1280.0, 400.0)).with_step_dt(1.0 / 60.0);
    let mut harness = builder.build_state(|ctx, window: &mut Window| window.draw(ctx), window);
    harness.run_steps(3);
    let node = |harness: &Harness<'_, Window>| harness.get_by_label("color as shade leaves it").rect();
    let first = node(&harness);
    // As it is drawn, the node has 116 × 22 points.
    assert!(first.width() > 116.0 * 0.69 && first.height() > 22.0 * 0.69, "{first}");
    let ground = egui::pos2(640.0, 390.0);
    for _ in 0..2 {
        harness.drag_at(ground);
        harness.drop_at(ground);
    }
    harness.run_steps(8);
    let whole = node(&harness);
    assert!(whole.width() < first.width() * 0.8, "{first} {whole}");
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
