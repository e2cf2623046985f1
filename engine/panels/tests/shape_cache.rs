//! An untouched panel looks the same as if every widget were made in every frame.

mod window;

use egui::epaint::Primitive;
use egui::{Context, Event, Modifiers, OutputCommand, PointerButton, Pos2, RawInput, Rect, Shape, Vec2, pos2};
use raxel_panels::view::{
    Brush, Compare, CompareMode, Effect, Inspected, Lane, Looking, PassState, Preset, Problem, Resource, Shown,
    Thumbnail, Timeline, Track, Use, WorldExtent,
};
use raxel_panels::{Action, Layout, Panel, split_input};
use raxel_picture::Sought;

use window::{Window, inspected, param};

/// After this number of frames of a tenth of a second, an untouched panel is drawn from its kept shapes.
const SETTLED: usize = 6;

/// A window with all panels, each in a dock of its own.
fn all_open() -> Window {
    let mut window = Window::new(&[]);
    let floating = Panel::ALL.iter().enumerate().map(|(index, panel)| {
        let at = [20.0 + 380.0 * (index % 5) as f32, 60.0 + 500.0 * (index / 5) as f32];
        let name = panel.title().to_lowercase();
        format!("{{ at = {at:?}, size = [360.0, 460.0], docks = {{ tabs = [\"{name}\"] }} }}")
    });
    let floating = floating.collect::<Vec<_>>().join(", ");
    window.panels.layout =
        Layout::read(&format!("floating = [{floating}]\ndocks = {{ tabs = [\"picture\"] }}")).unwrap();
    let tracks = vec![Track::new(Lane::Camera, "camera", vec![0.0, 5.0])];
    window.timeline = Some(Timeline { duration: 10.0, drives: true, tracks, ..Timeline::default() });
    // Without the list of pins, what comes after it is in sight.
    window.inspected = Some(Inspected { pins: Vec::new(), ..inspected() });
    window.compare = Compare { kept: Some("color, generation 3".to_owned()), gain: 2.0, ..Compare::default() };
    window
}

/// The output of a frame: the texts with their places, and all triangles.
type Drawn = (Vec<(String, Pos2)>, Vec<(Pos2, egui::Color32)>);

/// A window, and the same window with every widget made in every frame.
struct Twins {
    windows: [(Window, Context); 2],
    time: f64,
}

impl Twins {
    fn new() -> Self {
        let mut twins =
            Self { windows: [(all_open(), Context::default()), (all_open(), Context::default())], time: 0.0 };
        twins.windows[1].0.panels.whole = true;
        twins
    }

    /// The output of both in the next frame, this number of seconds later.
    fn frame(&mut self, seconds: f64) -> [Drawn; 2] {
        self.time += seconds;
        let time = self.time;
        self.windows.each_mut().map(|(window, context)| draw(window, context, time, Vec::new()).0)
    }

    /// Lets them settle, and returns their output then.
    fn settle(&mut self) -> Drawn {
        (0..SETTLED).for_each(|_| drop(self.frame(0.1)));
        let [kept, whole] = self.frame(0.1);
        assert!(kept == whole, "{}", difference(&kept, &whole));
        kept
    }
}

/// Draws a frame. Returns the output, the user's actions, and the text for the clipboard.
fn draw(window: &mut Window, context: &Context, time: f64, events: Vec<Event>) -> (Drawn, Vec<Action>, Vec<String>) {
    let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, Vec2::new(1940.0, 1080.0)));
    let input = RawInput { screen_rect, time: Some(time), events, ..RawInput::default() };
    window.actions.clear();
    let (mut drawn, mut copied) = (Drawn::default(), Vec::new());
    for turn in split_input(input) {
        let output = context.run(turn, |context| window.draw(context));
        copied.extend(output.platform_output.commands.into_iter().filter_map(|command| match command {
            OutputCommand::CopyText(text) => Some(text),
            _ => None,
        }));
        let text = |shape: &egui::epaint::ClippedShape| match &shape.shape {
            Shape::Text(text) => Some((text.galley.text().to_owned(), text.pos)),
            _ => None,
        };
        drawn.0 = output.shapes.iter().filter_map(text).collect();
        let painted = context.tessellate(output.shapes, output.pixels_per_point);
        drawn.1 = painted
            .into_iter()
            .filter_map(|painted| match painted.primitive {
                Primitive::Mesh(mesh) => Some(mesh),
                Primitive::Callback(_) => None,
            })
            .flat_map(|mesh| mesh.vertices)
            .map(|vertex| (vertex.pos, vertex.color))
            .collect();
    }
    (drawn, std::mem::take(&mut window.actions), copied)
}

/// The first text that two drawings do not have in common.
fn difference(a: &Drawn, b: &Drawn) -> String {
    let text = a.0.iter().zip(&b.0).find(|(a, b)| a != b);
    format!("{text:?}, {} and {} texts, {} and {} vertices", a.0.len(), b.0.len(), a.1.len(), b.1.len())
}

/// A named change of the view.
type Change = (&'static str, fn(&mut Window));

const CHANGES: &[Change] = &[
    ("another pass", |window| window.passes.push(("added", PassState::Ran, None))),
    ("a name", |window| window.passes[0].0 = "struck"),
    ("a state", |window| window.passes[1].1 = PassState::Off),
    ("times", |window| (0..3).for_each(|_| window.gpu.push(7.0))),
    ("a use", |window| window.resources[0].uses[1] = Use { writes: true, ..Use::default() }),
    ("another resource", |window| {
        let uses = vec![Use { reads: true, ..Use::default() }; 3];
        window.resources.push(Resource { name: "glow".to_owned(), uses, ..Resource::default() });
    }),
    ("memory", |window| "in block 0 at 0".clone_into(&mut window.resources[1].memory)),
    ("what is shown", |window| window.status.shown = Shown::after("depth", Some("struck".to_owned()))),
    ("what is locked", |window| window.status.locked = Shown::after("depth", Some("struck".to_owned()))),
    ("a thumbnail", |window| {
        let rgba = vec![90; 4 * 8 * 8].into();
        window.thumbnails = vec![Thumbnail { pass: 0, resource: 0, number: 1, size: [8, 8], rgba }];
    }),
    ("a value", |window| window.params[0].value = vec![3.5]),
    ("another param", |window| window.params.push(param("sun", vec![1.0], vec![1.0]))),
    ("a preset", |window| window.presets.push(Preset { name: "dusk".to_owned(), differing: Vec::new() })),
    ("keys are recorded", |window| window.records = true),
    ("a problem", |window| {
        window.problems.push(Problem { title: "a mistake".to_owned(), ..Problem::default() });
    }),
    ("a failure", |window| window.status.failed = Some(9)),
    ("a texel", |window| window.inspected.as_mut().unwrap().cursor.as_mut().unwrap().at = [9, 9]),
    ("a search", |window| {
        window.inspected.as_mut().unwrap().looking = Some(Looking { sought: Sought::Nan, looked: 1, slices: 64 });
    }),
    ("nothing is inspected", |window| window.inspected = None),
    ("a comparison", |window| window.compare.mode = CompareMode::Difference),
    ("a brush", |window| window.brush = Brush { effect: Effect::Add, ..window.brush }),
    ("steps", |window| window.steps = [4, 2]),
    ("a refusal", |window| window.refused = Some("the edit covers nothing".to_owned())),
    ("a material", |window| window.swatches[0].color = [1, 2, 3]),
    ("a smaller world", |window| window.world.extent = WorldExtent::Whole { chunks: 1, voxels: 2, lamps: 0 }),
    ("time", |window| window.timeline.as_mut().unwrap().time = 4.0),
    ("a key", |window| window.timeline.as_mut().unwrap().tracks[0].keys[1] = 6.0),
    ("a track", |window| {
        window.timeline.as_mut().unwrap().tracks.push(Track::new(Lane::Checks, "checks", vec![8.0]));
    }),
    ("the clock", |window| window.status.paused = true),
    ("fewer passes", |window| window.passes.truncate(2)),
];

#[test]
fn what_changes_shows_in_the_next_frame() {
    let mut twins = Twins::new();
    let mut before = twins.settle();
    for (name, change) in CHANGES {
        twins.windows.iter_mut().for_each(|(window, _)| change(window));
        for frame in 0..3 {
            let [kept, whole] = twins.frame(1.0 / 60.0);
            assert!(kept == whole, "{name}, frame {frame}: {}", difference(&kept, &whole));
            assert!(kept != before, "{name} is seen");
        }
        before = twins.settle();
    }
}

/// A window with two panels that has settled, with the place of a text in it.
fn settled(text: &str) -> (Window, Context, Pos2) {
    let (mut window, context) = (Window::new(&[Panel::Passes, Panel::Resources]), Context::default());
    let mut drawn = Drawn::default();
    for frame in 0..SETTLED {
        drawn = draw(&mut window, &context, frame as f64 / 10.0, Vec::new()).0;
    }
    let (_, at) = drawn.0.iter().find(|(found, _)| found == text).unwrap();
    (window, context, *at + egui::vec2(4.0, 4.0))
}

/// The pointer comes to a place, presses and lets go.
fn click(pos: Pos2) -> Vec<Event> {
    let button =
        |pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
    vec![Event::PointerMoved(pos), button(true), button(false)]
}

#[test]
fn a_click_on_a_panel_that_nobody_touched_is_not_lost() {
    let (mut window, context, at) = settled("hit");
    // All of it in one frame that took long.
    let events = [vec![Event::PointerMoved(pos2(900.0, 600.0))], click(at)].concat();
    let (_, actions, _) = draw(&mut window, &context, 1.0, events);
    assert!(actions.contains(&Action::Show(Shown::after("depth", Some("hit".to_owned())))), "{actions:?}");
}

#[test]
fn a_selected_text_is_copied_after_the_pointer_has_gone() {
    let (mut window, context, at) = settled("reads");
    for time in [1.0, 1.1] {
        draw(&mut window, &context, time, click(at));
    }
    for frame in 0..SETTLED {
        let away = vec![Event::PointerMoved(pos2(900.0, 600.0))];
        draw(&mut window, &context, 1.2 + frame as f64 / 10.0, away);
    }
    assert_eq!(draw(&mut window, &context, 2.0, vec![Event::Copy]).2, ["reads"]);
}
