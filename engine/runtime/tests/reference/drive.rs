//! Runs sessions and the interpreter side by side, with what users do between frames.

use std::ops::Range;
use std::time::Duration;

use raxel_execute::moment::Moment;
use raxel_graph::checked::Value;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::{Observe, Options, Session};
use raxel_testing::Random;

use crate::generate;
use crate::interpreter::{Exact, Given, Machine, exact};
use crate::model::{Graph, Pass};
use crate::project::{Project, Sessions};
use crate::shaders;
use crate::write;

const FRAMES: usize = 10;

struct Run {
    project: Project,
    session: Session,
    /// Everything can be read, or only the shown target.
    all: bool,
    fps: &'static str,
    salt: u32,
    loads: u32,
    seed: u64,
    /// The actions of this graph's run, for the message of a failure.
    log: Vec<String>,
    files: String,
}

/// Runs graphs one after the other in one session: each is a reload of the one before, and a reset.
pub(crate) fn run(seeds: Range<u64>) {
    let mut r = generate::random(seeds.start ^ 0x5EED);
    let project = Project::filled();
    let fps = r.pick(&["60", "30", "24", "29.97", "144"]);
    let all = r.percent(50);
    let options = Options {
        step: Some(1.0 / fps.parse::<f64>().expect("a number")),
        observe: if all { Observe::Everything } else { Observe::Shown },
        alias: r.percent(80),
        memo: r.percent(80),
        size: [8, 8],
        graph: Some("graphs/fill.toml".into()),
        ..project.options()
    };
    let session = Project::open_with(options);
    let mut run = Run { project, session, all, fps, salt: 1, loads: 0, seed: 0, log: Vec::new(), files: String::new() };
    for seed in seeds {
        run.graph(seed);
    }
}

impl Run {
    fn fail(&self, what: &str) -> ! {
        panic!(
            "seed {} ({} frames a second, {}): {what}\n{:#?}\n{}",
            self.seed,
            self.fps,
            if self.all { "everything can be read" } else { "what is shown can be read" },
            self.log,
            self.files
        );
    }

    /// Writes the graph and its shaders, and waits until they run.
    fn load(&mut self, graph: &mut Graph, r: &mut Random) {
        self.loads += 1;
        graph.name = format!("load {}", self.loads);
        self.files = String::new();
        let mut files = vec![("shaders/mix.glsl".to_owned(), shaders::include(self.salt))];
        for pass in &graph.passes {
            let (name, text) = shaders::shader(graph, pass);
            files.push((format!("shaders/{name}"), text));
        }
        if r.percent(40) {
            let (below, above) = write::layered(graph, r);
            files.push(("graphs/below.toml".to_owned(), below));
            files.push(("graphs/fill.toml".to_owned(), above));
        } else {
            files.push(("graphs/fill.toml".to_owned(), write::whole(graph)));
        }
        for (path, text) in &files {
            if path.starts_with("graphs/") {
                self.files += &format!("--- {path}\n{text}");
            }
            if std::fs::read_to_string(self.project.path(path)).is_ok_and(|there| there == *text) {
                continue;
            }
            self.project.write(path, text);
        }
        // Several files may be taken up one after the other; the last word is a build of all of them.
        let mut wrong: Option<String> = None;
        let mut patience = Duration::from_secs(60);
        for _ in 0..4 {
            let events = self.session.wait_reload(patience);
            for event in events {
                match event {
                    // Its file was written last.
                    ReloadEvent::Reloaded(_) if self.session.graph().name == graph.name => return,
                    ReloadEvent::Failed(failed) => {
                        let found = failed.diagnostics.iter().map(|found| (&found.message, &found.labels));
                        wrong = Some(format!("{:?}", found.collect::<Vec<_>>()));
                        patience = Duration::from_secs(3);
                    }
                    _ => {}
                }
            }
        }
        self.fail(&format!("does not load: {wrong:?}"));
    }

    fn graph(&mut self, seed: u64) {
        let mut r = generate::random(seed);
        (self.seed, self.log) = (seed, Vec::new());
        let mut graph = generate::graph(&mut r);
        self.session.set_debug_target(DebugTarget::default()).expect("the graph's own");
        // A graph that is the same as the one before is no reload.
        self.salt += 1;
        self.load(&mut graph, &mut r);
        self.session.reset();
        let mut machine = Machine::default();
        let (per, of) = exact(self.fps);
        let step: Exact = (of, per);
        let (mut origin, mut since) = ((0, 1), 0);
        self.session.pause(false);
        let (n, flag) = (graph.n, graph.flag);
        for name in ["n", "flag"] {
            self.session.unset_param(name).expect("the graph has it");
        }
        let mut given = Given { output: self.session.size(), time: (0, 1), salt: self.salt, n, flag };
        let mut shown = (graph.present, 0, 0);
        for frame in 0..FRAMES {
            let mut stepped = false;
            match r.below(24) {
                _ if frame == 0 => {}
                0 => {
                    given.n = generate::word(&mut r);
                    self.set("n", Value::U32(given.n));
                }
                1 => {
                    given.flag = !given.flag;
                    self.set("flag", Value::Bool(given.flag));
                }
                2 | 3 => {
                    let [w, h] = [4 * (1 + generate::word(&mut r) % 4), 4 * (1 + generate::word(&mut r) % 3)];
                    self.log.push(format!("{frame}: resize {w}x{h}"));
                    self.session.resize(w, h);
                    given.output = self.session.size();
                }
                4 => {
                    let scale = r.pick(&[0.5, 1.0, 2.0]);
                    self.log.push(format!("{frame}: scale {scale}"));
                    self.session.set_scale(scale);
                    given.output = self.session.size();
                }
                5 | 6 => {
                    let hundredths = r.below(500) as u128;
                    self.log.push(format!("{frame}: seek {hundredths}/100"));
                    self.session.seek(Moment::from(hundredths as f64 / 100.0));
                    (origin, since) = ((hundredths, 100), 0);
                }
                7 => {
                    self.log.push(format!("{frame}: reset"));
                    self.session.reset();
                    machine.reset();
                    (origin, since) = ((0, 1), 0);
                }
                8 | 9 => {
                    // A resource that no pass binds is part of no plan, until it is shown.
                    let bound: Vec<usize> = graph.passes.iter().flat_map(Pass::bound).collect();
                    let resource = r.pick(&bound);
                    let declared = &graph.resources[resource];
                    let (age, mip) = (r.below(declared.history + 1), r.below(declared.mips()));
                    shown = (resource, age, mip);
                    let target =
                        DebugTarget { age: age as u32, mip: mip as u32, ..DebugTarget::resource(&declared.name) };
                    self.log.push(format!("{frame}: show {target}"));
                    self.session.set_debug_target(target).expect("it is there");
                }
                10 => {
                    self.salt += 1;
                    self.log.push(format!("{frame}: salt {}", self.salt));
                    self.project.write("shaders/mix.glsl", shaders::include(self.salt));
                    self.wait_shaders();
                    given.salt = self.salt;
                    machine.edited(true);
                }
                11 => {
                    let pass = r.below(graph.passes.len());
                    graph.passes[pass].k += 1000;
                    self.log.push(format!("{frame}: k of {} is {}", graph.passes[pass].name, graph.passes[pass].k));
                    self.load(&mut graph, &mut r);
                    machine.edited(false);
                }
                12 | 13 => {
                    let paused = !self.session.clock().paused();
                    self.log.push(format!("{frame}: pause {paused}"));
                    self.session.pause(paused);
                }
                14..=16 if self.session.clock().paused() => {
                    self.log.push(format!("{frame}: step"));
                    self.session.step();
                    stepped = true;
                }
                _ => {}
            }
            // The first frame after a seek or a reset has its own time, also during a pause.
            if since == 0 || stepped || !self.session.clock().paused() {
                given.time = (origin.0 * step.1 + since * step.0 * origin.1, origin.1 * step.1);
                since += 1;
            }
            machine.frame(&graph, &given);
            if let Err(error) = self.session.frame() {
                self.fail(&format!("frame {frame}: {error:?}"));
            }
            self.compare(&graph, &machine, frame, shown, &mut r);
        }
        let messages = self.session.device().log().take();
        if !messages.is_empty() {
            self.fail(&format!("the validation layer says: {messages:#?}"));
        }
    }

    /// Waits until an edit of the shaders runs.
    fn wait_shaders(&mut self) {
        let mut last = Vec::new();
        for _ in 0..4 {
            // The reports of a frame come first.
            last = self.session.wait_reload(Duration::from_secs(60));
            if last.iter().any(|event| matches!(event, ReloadEvent::Reloaded(_))) {
                return;
            }
        }
        self.fail(&format!("no reload: {last:?}"));
    }

    fn set(&mut self, name: &str, value: Value) {
        self.log.push(format!("{name} = {value:?}"));
        self.session.set_param(name, value).expect("the graph has it");
    }

    /// The shown target, and a few others where all can be read.
    fn compare(
        &mut self,
        graph: &Graph,
        machine: &Machine,
        frame: usize,
        shown: (usize, usize, usize),
        r: &mut Random,
    ) {
        let mut looked = vec![shown];
        if self.all {
            for _ in 0..3 {
                let at = r.below(graph.resources.len());
                let declared = &graph.resources[at];
                // An earlier buffer has no name that it can be read by.
                let ages = if declared.is_target() { declared.history + 1 } else { 1 };
                looked.push((at, r.below(ages), r.below(declared.mips())));
            }
        }
        for (at, age, mip) in looked {
            let declared = &graph.resources[at];
            if !declared.is_target() && age > 0 {
                continue;
            }
            let (_, _, expected) = machine.texels(&declared.name, age, mip);
            let found: Vec<u32> = if declared.is_target() {
                match self.session.read_texels(&declared.name, age as u32, mip as u32, 0) {
                    Ok(texels) => texels.integers().expect("integers").iter().map(|texel| texel[0]).collect(),
                    Err(error) => self.fail(&format!("frame {frame}: {} {error:?}", declared.name)),
                }
            } else {
                match self.session.read_buffer(&declared.name, 0..expected.len() as u64 * 4) {
                    Ok(bytes) => bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
                    Err(error) => self.fail(&format!("frame {frame}: {} {error:?}", declared.name)),
                }
            };
            if found != *expected {
                let first = found.iter().zip(expected).position(|(a, b)| a != b);
                self.fail(&format!(
                    "frame {frame}: {}@{age} mip {mip} differs at {first:?} of {}: {:?} should be {:?}",
                    declared.name,
                    expected.len(),
                    &found[..found.len().min(4)],
                    &expected[..expected.len().min(4)]
                ));
            }
        }
        self.compare_picture(machine, graph, frame, shown);
    }

    /// The picture of a target shows each texel, nearest, by a colour that its number alone decides.
    fn compare_picture(
        &mut self,
        machine: &Machine,
        graph: &Graph,
        frame: usize,
        (at, age, mip): (usize, usize, usize),
    ) {
        if !graph.resources[at].is_target() {
            return;
        }
        let (w, h, texels) = machine.texels(&graph.resources[at].name, age, mip);
        let picture = match self.session.read_presented() {
            Ok(picture) => picture,
            Err(error) => self.fail(&format!("frame {frame}: no picture: {error:?}")),
        };
        let (width, height) = (picture.width, picture.height);
        let mut colours = std::collections::BTreeMap::new();
        for y in 0..height {
            for x in 0..width {
                let texel = texels[((y * h / height) * w + x * w / width) as usize];
                let place = ((y * width + x) * 4) as usize;
                let colour = &picture.rgba[place..place + 3];
                if *colours.entry(texel).or_insert(colour) != colour {
                    self.fail(&format!("frame {frame}: the picture shows {texel} in two colours"));
                }
            }
        }
    }
}
