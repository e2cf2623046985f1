//! Where panels are: docks, tabs, sides, narrow windows.

use egui::Vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use raxel_panels::view::{Lane, Problem, Timeline, Track};
use raxel_panels::{Layout, Panel};

use crate::window::{Window, inspected};
use crate::{click, drag, texts};

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

/// One line of a bar is short: a notice may be longer, and a button stands behind it.
#[test]
fn a_notice_that_has_no_room_in_the_bar_is_whole_below_it() {
    for (width, is_in_bar) in [(1600.0, true), (900.0, false), (400.0, false)] {
        let mut window = Window::new(&[]);
        let notice = "kept color, 640 × 360; X goes through ways of comparing, V shows it alone";
        window.status.notice = Some(notice.to_owned());
        let harness = window.harness(width, 400.0);
        let seen = texts(&harness, notice);
        assert_eq!(seen.len(), 1, "at {width}");
        assert!(seen[0].left() >= 0.0 && seen[0].right() <= width, "{} at {width}", seen[0]);
        assert_eq!(seen[0].top() < 20.0, is_in_bar, "{} at {width}", seen[0]);
    }
}
