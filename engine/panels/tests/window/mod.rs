//! The data of the panels' tests: a small graph of three passes, one of them left out.

#![allow(dead_code, reason = "each test file uses a part of this")]

use raxel_panels::view::{
    Brush, Compare, ComponentKind, Editing, FileKind, Frame, Inspected, Magnified, Map, Param, Pass, PassState,
    PassTexel, Pinned, Preset, Problem, ProjectFile, Resource, Shown, Solids, Status, Swatch, Table, Texel,
    TexelHistory, Thumbnail, Timeline, Use, World, WorldExtent, WorldStatistics, Zoom,
};
use raxel_panels::{Action, Layout, Panel, Panels, Samples, View};
use raxel_picture::{Statistics, not_finite};

/// A window with a small graph of three passes, one of them left out.
pub(crate) struct Window {
    pub panels: Panels,
    pub gpu: Samples,
    /// Of each pass; where they are missing, those of the GPU.
    pub times: Vec<Samples>,
    /// Passes with their outcomes and outputs.
    pub passes: Vec<(&'static str, PassState, Option<usize>)>,
    pub resources: Vec<Resource>,
    pub params: Vec<Param>,
    pub presets: Vec<Preset>,
    pub records: bool,
    pub thumbnails: Vec<Thumbnail>,
    pub problems: Vec<Problem>,
    pub inspected: Option<Inspected>,
    pub magnified: Magnified,
    pub compare: Compare,
    pub status: Status,
    pub timeline: Option<Timeline>,
    pub brush: Brush,
    pub steps: [usize; 2],
    /// As in [`Frame::ran`].
    pub ran: [u32; 3],
    pub refused: Option<String>,
    pub swatches: Vec<Swatch>,
    pub actions: Vec<Action>,
    pub world: WorldStatistics,
    pub files: Vec<ProjectFile>,
}

impl Window {
    /// With these panels open.
    pub(crate) fn new(open: &[Panel]) -> Self {
        let mut layout = Layout::empty();
        layout.timeline = false;
        open.iter().for_each(|panel| layout.open(*panel));
        let mut gpu = Samples::default();
        [1.0, 2.0, 3.0].into_iter().for_each(|ms| gpu.push(ms));
        let none = Use::default();
        let (reads, writes) = (Use { reads: true, ..none }, Use { writes: true, ..none });
        let resource = |name: &str, uses: [Use; 3]| Resource {
            name: name.to_owned(),
            about: "rgba16f 320 × 180".to_owned(),
            memory: "own memory".to_owned(),
            uses: uses.to_vec(),
            ..Resource::default()
        };
        let shown = Shown::after("color", None);
        Self {
            panels: Panels::new(layout),
            gpu,
            times: Vec::new(),
            passes: vec![
                ("hit", PassState::Ran, Some(0)),
                ("shade", PassState::Skipped, Some(1)),
                ("bloom", PassState::Condition, None),
            ],
            resources: vec![resource("depth", [writes, reads, none]), resource("color", [none, writes, none])],
            params: vec![
                param("exposure", vec![2.0], vec![1.0]),
                Param { kind: ComponentKind::Bool, range: None, ..param("fog", vec![0.0], vec![0.0]) },
            ],
            presets: Vec::new(),
            records: false,
            thumbnails: Vec::new(),
            problems: Vec::new(),
            inspected: None,
            magnified: Magnified::default(),
            compare: Compare::default(),
            status: Status {
                graph: "test".to_owned(),
                graph_file: "graphs/test.toml".to_owned(),
                locked: shown.clone(),
                shown,
                is_default: true,
                ..Status::default()
            },
            timeline: None,
            brush: Brush::default(),
            steps: [0, 0],
            ran: [0; 3],
            refused: None,
            swatches: (1..=40)
                .map(|n| Swatch { material: n, name: format!("stone {n}"), color: [200, 90, 40] })
                .collect(),
            actions: Vec::new(),
            world: WorldStatistics {
                extent: WorldExtent::Whole { chunks: 300, voxels: 2 << 20, lamps: 1 },
                sources: vec![("world.tree64".to_owned(), 1 << 20), ("world.lights".to_owned(), 4096)],
                edits: [3, 1],
            },
            files: [
                (FileKind::Demo, "worlds/a.demo.toml"),
                (FileKind::World, "worlds/a.toml"),
                (FileKind::Graph, "graphs/other.toml"),
                (FileKind::Graph, "graphs/test.toml"),
            ]
            .map(|(kind, path)| ProjectFile { kind, path: path.to_owned(), runs: path == "graphs/test.toml" })
            .to_vec(),
        }
    }

    /// Draws it, and notes the user's actions.
    pub(crate) fn draw(&mut self, ctx: &egui::Context) {
        let pass = |(index, (name, state, output)): (usize, &(&'static str, PassState, Option<usize>))| Pass {
            name,
            after: name,
            times: (*state == PassState::Ran).then(|| self.times.get(index).unwrap_or(&self.gpu)),
            state: *state,
            groups: "40 × 23 × 1",
            place: "graphs/a.toml:7",
            output: *output,
        };
        let view = View {
            status: self.status.clone(),
            frame: Frame {
                gpu: Some(&self.gpu),
                scale: 1.0,
                scales: [0.0625, 4.0],
                ran: self.ran,
                world: self.world.clone(),
                ..Frame::default()
            },
            passes: self.passes.iter().enumerate().map(pass).collect(),
            resources: &self.resources,
            params: self.params.clone(),
            presets: self.presets.clone(),
            records: self.records,
            thumbnails: self.thumbnails.clone(),
            checks_bounds: false,
            problems: &self.problems,
            world: World {
                path: Some("worlds/a.toml".to_owned()),
                solid: matches!(self.world.extent, WorldExtent::Whole { .. }).then_some(Solids {
                    count: 2 << 20,
                    min: [-64, 0, -64],
                    max: [64, 128, 64],
                }),
                cameras: vec!["roof".to_owned()],
                editing: Editing {
                    brush: self.brush,
                    materials: &self.swatches,
                    steps: self.steps,
                    refused: self.refused.clone(),
                    under: Some("stone 3 at 1, 2, 3, 4.0 voxels away".to_owned()),
                    outline: vec![[[600.0, 300.0], [700.0, 300.0]]],
                },
                ..World::default()
            },
            timeline: self.timeline.clone(),
            inspected: self.inspected.as_ref(),
            magnified: self.magnified.clone(),
            compare: self.compare.clone(),
            files: Some(&self.files),
        };
        self.actions.extend(self.panels.show(ctx, &view));
    }
}

/// A number from 0 to 8.
pub(crate) fn param(name: &str, value: Vec<f64>, default: Vec<f64>) -> Param {
    Param {
        name: name.to_owned(),
        label: name.to_owned(),
        value,
        default,
        range: Some([0.0, 8.0]),
        file: "graphs/test.toml".to_owned(),
        ..Param::default()
    }
}

/// A pinned texel of two equal channels.
fn pin(number: u32, at: [u32; 2], value: &str) -> Pinned {
    Pinned { number, texel: Some(Texel { at, values: vec![[value.to_owned(), "0x7e00".to_owned()]; 2] }) }
}

/// A target with texels that are read, and a buffer, at once.
pub(crate) fn inspected() -> Inspected {
    Inspected {
        shown: Shown::after("color", None),
        mips: 3,
        layers: 1,
        channels: vec!["r", "g"],
        used: Some(Map { map: 0, range: Some([0.0, 1.0]), channel: 0 }),
        statistics: Statistics::of([0.25, f32::NAN, f32::INFINITY].into_iter()),
        not_finite: not_finite(
            &[[0.25, f32::NAN, 0.0, 0.0], [f32::NAN, f32::NAN, 0.0, 0.0], [f32::INFINITY, 0.0, 0.0, 0.0]],
            2,
        ),
        extent: [320, 180],
        cursor: Some(Texel {
            at: [3, 4],
            values: vec![["0.25".to_owned(), "0x3400".to_owned()], ["7".to_owned(), "0x4700".to_owned()]],
        }),
        pins: vec![pin(1, [60, 40], "0.5"), pin(2, [20, 30], "NaN")],
        active: 2,
        pinned: Some(Texel { at: [20, 30], values: vec![["NaN".to_owned(), "0x7e00".to_owned()]; 2] }),
        history: Some(TexelHistory {
            writes: [("clear", "0"), ("shade", "NaN")]
                .map(|(pass, value)| PassTexel { pass: pass.to_owned(), values: vec![value.to_owned(); 2] })
                .into(),
            frames: (0..60).map(|frame| (frame != 20).then_some((frame % 30) as f32)).collect(),
        }),
        zoom: Some(Zoom {
            colors: (0..Zoom::SIDE * Zoom::SIDE)
                .map(|index| (index % Zoom::SIDE > 1).then_some([90, 160, 220]))
                .collect(),
        }),
        table: Some(Table {
            columns: vec!["count u32".to_owned()],
            total: 9,
            first: 5,
            rows: vec![vec!["42".to_owned()]],
            head: vec![["used u32".to_owned(), "6".to_owned()]],
        }),
        ..Inspected::default()
    }
}
