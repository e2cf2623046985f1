//! The CPU cost of the panels in a frame: layout, text and triangles, with no panel open, with all, and with each alone. While a graph
//! runs, its times change in each frame, and a demo goes on. While it is paused, nothing changes.
//!
//! `cargo bench -p raxel-panels --bench panels`

#![allow(missing_docs, reason = "a benchmark")]

#[path = "../tests/window/mod.rs"]
mod window;

use criterion::{Criterion, criterion_group, criterion_main};
use egui::{Context, RawInput, Rect, Vec2};
use raxel_panels::view::{Compare, Lane, PassState, Problem, Resource, Timeline, Track};
use raxel_panels::{Layout, Panel, Samples};

use window::{Window, inspected, param};

/// Passes of a large graph, which has as many params and resources.
const PASSES: usize = 40;

/// A window over a large graph with these panels open, each where it is seen.
fn opened(panels: &[Panel]) -> Window {
    let mut window = Window::new(panels);
    let pass = |number: usize| (&*format!("trace_{number}").leak(), PassState::Ran, Some(number));
    window.passes = (0..PASSES).map(pass).collect();
    let mut times = Samples::default();
    (0..240).for_each(|frame| times.push(1.0 + f64::from(frame * 37 % 101) * 0.01));
    (window.times, window.gpu) = (vec![times.clone(); PASSES], times);
    // Every third pass writes all of them, every third one reads them.
    let uses = window.resources[0].uses.clone();
    let resource = |number| Resource {
        name: format!("target_{number}"),
        uses: uses.iter().copied().cycle().take(PASSES).collect(),
        ..window.resources[0].clone()
    };
    window.resources = (0..PASSES).map(resource).collect();
    window.params = (0..PASSES).map(|number| param(&format!("param_{number}"), vec![1.0], vec![0.5])).collect();
    window.timeline = Some(Timeline {
        duration: 10.0,
        tracks: (0..8)
            .map(|_| Track::new(Lane::Camera, "camera", (0..20).map(|key| f64::from(key) / 2.0).collect()))
            .collect(),
        ..Timeline::default()
    });
    window.inspected = Some(inspected());
    window.compare = Compare { kept: Some("target_1, generation 3".to_owned()), gain: 1.0, ..Compare::default() };
    let problem = |number| Problem { title: format!("mistake {number}"), ..Problem::default() };
    window.problems = (0..5).map(problem).collect();
    if !panels.is_empty() {
        // Each in a dock of its own, rather than behind others: more than a user sees at once.
        let floating = panels.iter().enumerate().map(|(index, panel)| {
            let at = [20.0 + 100.0 * (index % 5) as f32, 60.0 + 200.0 * (index / 5) as f32];
            let name = panel.title().to_lowercase();
            format!("{{ at = {at:?}, size = [400.0, 300.0], docks = {{ tabs = [\"{name}\"] }} }}")
        });
        let floating = floating.collect::<Vec<_>>().join(", ");
        window.panels.layout =
            Layout::read(&format!("timeline = false\nfloating = [{floating}]\ndocks = {{ tabs = [\"picture\"] }}"))
                .unwrap();
    }
    window
}

/// The change of the values between two frames.
#[derive(Clone, Copy, PartialEq)]
enum Values {
    /// They stay.
    Still,
    /// Each pass took another time, and the demo went on.
    Run,
}

fn bench(criterion: &mut Criterion, name: &str, panels: &[Panel], values: Values) {
    let (mut window, ctx) = (opened(panels), Context::default());
    let mut number = 0_u32;
    let mut frame = || {
        number += 1;
        if values == Values::Run {
            for times in window.times.iter_mut().chain([&mut window.gpu]) {
                times.push(1.0 + f64::from(number * 37 % 101) * 0.01);
            }
            if let Some(timeline) = &mut window.timeline {
                timeline.time = f64::from(number % 600) / 60.0;
            }
        }
        let screen_rect = Some(Rect::from_min_size(egui::Pos2::ZERO, Vec2::new(1920.0, 1080.0)));
        let output = ctx.run(RawInput { screen_rect, ..RawInput::default() }, |ctx| window.draw(ctx));
        window.actions.clear();
        ctx.tessellate(output.shapes, output.pixels_per_point)
    };
    // Panels find their sizes in the first frames.
    for _ in 0..60 {
        frame();
    }
    criterion.bench_function(name, |bencher| bencher.iter(&mut frame));
}

fn frames(criterion: &mut Criterion) {
    for (word, values) in [("paused", Values::Still), ("running", Values::Run)] {
        bench(criterion, &format!("{word}/no panel"), &[], values);
        bench(criterion, &format!("{word}/all panels"), &Panel::ALL, values);
        for panel in Panel::ALL {
            bench(criterion, &format!("{word}/{}", panel.title()), &[panel], values);
        }
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
