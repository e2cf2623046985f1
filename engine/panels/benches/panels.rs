//! What the panels cost a frame on the processor: layout, text and triangles, with no panel open and with all of them.
//!
//! `cargo bench -p raxel-panels --bench panels`

#![allow(missing_docs, reason = "a benchmark")]

#[path = "../tests/window/mod.rs"]
mod window;

use criterion::{Criterion, criterion_group, criterion_main};
use egui::{Context, RawInput, Rect, Vec2};
use raxel_panels::view::{Lane, PassState, Timeline, Track};
use raxel_panels::{Layout, Panel};

use window::{Window, param};

/// Passes of a large graph, which has as many params and resources.
const PASSES: usize = 40;

/// A window over a large graph with these panels open, each where it is seen.
fn opened(panels: &[Panel]) -> Window {
    let mut window = Window::new(panels);
    let (resource, pass) = (window.resources[0].clone(), window.passes[0]);
    window.passes = vec![(pass.0, PassState::Ran, Some(0)); PASSES];
    window.resources = vec![resource; PASSES];
    for resource in &mut window.resources {
        resource.uses = (0..PASSES).map(|pass| resource.uses[pass % resource.uses.len()]).collect();
    }
    window.params = (0..PASSES).map(|number| param(&format!("param_{number}"), vec![1.0], vec![0.5])).collect();
    window.timeline = Some(Timeline {
        duration: 10.0,
        tracks: (0..8)
            .map(|_| Track::new(Lane::Camera, "camera", (0..20).map(|key| f64::from(key) / 2.0).collect()))
            .collect(),
        ..Timeline::default()
    });
    if !panels.is_empty() {
        // Each in a dock of its own, rather than behind others: more than a user sees at once.
        let floating = panels.iter().enumerate().map(|(index, panel)| {
            let at = [20.0 + 100.0 * (index % 5) as f32, 60.0 + 200.0 * (index / 5) as f32];
            let name = panel.title().to_lowercase();
            format!("{{ at = {at:?}, size = [400.0, 300.0], docks = {{ tabs = [\"{name}\"] }} }}")
        });
        let floating = floating.collect::<Vec<_>>().join(", ");
        window.panels.layout =
            Layout::read(&format!("floating = [{floating}]\ndocks = {{ tabs = [\"picture\"] }}")).unwrap();
    }
    window
}

fn frames(criterion: &mut Criterion) {
    for (name, panels) in [("no panel", &[][..]), ("all panels", &Panel::ALL[..])] {
        let (mut window, ctx) = (opened(panels), Context::default());
        let mut frame = || {
            let screen_rect = Some(Rect::from_min_size(egui::Pos2::ZERO, Vec2::new(1920.0, 1080.0)));
            let output = ctx.run(RawInput { screen_rect, ..RawInput::default() }, |ctx| window.draw(ctx));
            window.actions.clear();
            ctx.tessellate(output.shapes, output.pixels_per_point)
        };
        // Panels find their sizes in the first frames.
        for _ in 0..10 {
            frame();
        }
        criterion.bench_function(name, |bencher| bencher.iter(&mut frame));
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
