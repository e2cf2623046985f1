//! Showing, pinning and reading change nothing that frames compute: random graphs run while all of these change at random between frames.
//! Every read equals the state of an interpreter of the graph as written ([`crate::interpreter`]) at the end of that frame, or is refused.
//! At the end, all contents are bit for bit as without any reads.

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_execute::moment::Moment;
use raxel_execute::{Builtins, ExecuteError, FrameInputs};
use raxel_graph::checked::{Graph, ResourceId, ResourceKind, Value};
use raxel_graph::plan::Observe;
use raxel_graphfile::compile;
use raxel_shader::Compiler;

use crate::interpreter::{Contents, Given, Interpreter, is_touched, is_written};
use crate::lab::{Lab, Planned};
use crate::random::{FLOATS, FRAMES, GIVEN, OPEN, TIMES, graph_file, layouts, supply};
use crate::random_shaders::shaders;
use raxel_testing::Random;

/// The number of graphs in a normal test run. `RAXEL_OBSERVED=5000` runs 5000 graphs, with seeds from `RAXEL_OBSERVED_FROM` on.
const GRAPHS: u64 = 150;

/// The contents of each resource at the end of a frame: by age.
type Left = Vec<Vec<Contents>>;

/// How a graph is run.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    /// Everything can be read, and nothing is read before the last frame has run.
    Unseen,
    /// Everything can be read, and is.
    Everything,
    /// As in a window: shown and pinned resources can be read, memory is shared, and passes are culled.
    Shown,
}

#[derive(Debug, Default)]
struct Counts {
    graphs: u64,
    reads: u64,
    refused: u64,
    plans: u64,
    culled: u64,
}

fn moment(frame: u32) -> usize {
    // Frames 2 and 3 are alike, so that the memo has something to skip.
    if frame == 3 { 2 } else { frame as usize }
}

fn params(frame: u32) -> [f32; 2] {
    [(frame / 2) as f32 * 0.0625, 0.25]
}

/// Words of the source that all may read, which is written before frame 5.
const WRITTEN: [f32; 2] = [0.75, 0.25];

/// The contents after each frame of the graph as written. `None` if a dispatch has no workgroups: then `writeonly` bindings do not store as
/// they promise, and the contents are undefined.
fn interpret(graph: &Graph) -> Option<Vec<Left>> {
    let mut given = [0.5_f32; FLOATS].map(f32::to_bits).to_vec();
    let open = [0.25_f32; FLOATS].map(f32::to_bits).to_vec();
    let mut interpreter = Interpreter::new(graph, |source| if source == OPEN { open.clone() } else { given.clone() });
    let most = graph.clocks.first().map_or(0, |clock| clock.most);
    let reached = |moment: usize| (TIMES[moment] * 20.0 + 1e-6).floor() as u32 + 1;
    let mut frames = Vec::new();
    for frame in 0..FRAMES {
        if frame == 5 {
            given[3..5].copy_from_slice(&WRITTEN.map(f32::to_bits));
            interpreter
                .supply(|resource| resource.kind.supplied_by() == Some(GIVEN), |words| words.copy_from_slice(&given));
        }
        if frame == 6 {
            interpreter.supply(|resource| resource.source() == Some(OPEN), |words| words[0] = 0.375_f32.to_bits());
        }
        let before = if frame == 0 { 0 } else { reached(moment(frame - 1)) };
        let ticks = (reached(moment(frame)) - before).min(if frame == 0 { 1 } else { most });
        let time = moment(frame) as f32 * 0.125;
        interpreter.frame(&Given { frame, time, params: params(frame), ticks });
        let ages = |index: usize| 0..=graph.resources[index].history as usize;
        let of = |index: usize| ages(index).map(|age| interpreter.contents(index, age).clone()).collect();
        frames.push((0..graph.resources.len()).map(of).collect());
    }
    (!interpreter.starved).then_some(frames)
}

/// A running graph, and the facts about it.
struct Run<'a> {
    lab: &'a mut Lab,
    graph: &'a Arc<Graph>,
    way: Way,
    poison: bool,
    present: String,
    pinned: Vec<String>,
}

impl Run<'_> {
    /// Runs another plan from the next frame on.
    fn plan(&mut self, counts: &mut Counts) {
        let pinned: Vec<&str> = self.pinned.iter().map(String::as_str).collect();
        let how = Planned {
            present: &self.present,
            pinned: &pinned,
            observe: if self.way == Way::Shown { Observe::Shown } else { Observe::Everything },
            poison: self.poison,
            ..Planned::default()
        };
        let plan = self.lab.plan(self.graph, &how);
        counts.plans += 1;
        counts.culled += plan.culled.len() as u64;
        let prepared = self.lab.prepare(&plan).unwrap_or_else(|error| panic!("{error}"));
        self.lab.executor.swap(prepared);
    }

    /// Shows and pins other resources.
    fn look_elsewhere(&mut self, r: &mut Random) {
        let name = |index: usize| self.graph.resources[index].name.clone();
        let at = r.below(self.graph.resources.len());
        let age = r.below(self.graph.resources[at].history as usize + 1);
        self.present = if age > 0 { format!("{}@{age}", name(at)) } else { name(at) };
        self.pinned = (0..self.graph.resources.len()).filter(|_| r.percent(15)).map(name).collect();
    }

    /// Reads one mip of a resource, and says whether it was refused. `running` is what is presented and pinned in the last frame.
    fn read(&mut self, index: usize, age: usize, mip: usize, left: &Left) -> Result<bool, String> {
        let resource = &self.graph.resources[index];
        let id = ResourceId(index as u32);
        let wanted: &[u32] = &left[index][age][mip];
        let found = match resource.kind {
            ResourceKind::Target(_) => {
                self.lab.executor.read_target(id, age as u32, mip as u32, 0).map(|texels| texels.bytes)
            }
            ResourceKind::Buffer(_) => self.lab.executor.read_buffer(id, age as u32, 0..wanted.len() as u64 * 4),
        };
        let what = || format!("`{}@{age}`, mip {mip}, {:?}", resource.name, self.way);
        match found {
            Ok(bytes) if bytemuck::pod_collect_to_vec::<u8, u32>(&bytes) == wanted => Ok(false),
            Ok(bytes) => {
                let found = bytemuck::pod_collect_to_vec::<u8, f32>(&bytes);
                let wanted: Vec<f32> = wanted.iter().map(|word| f32::from_bits(*word)).collect();
                Err(format!("{} is\n{found:?}, and should be\n{wanted:?}", what()))
            }
            Err(
                error @ (ExecuteError::NotLive { .. }
                | ExecuteError::NotKept { .. }
                | ExecuteError::CulledWriter { .. }),
            ) => {
                let looked_at = self.pinned.contains(&resource.name);
                let supplied = resource.kind.supplied_by().is_some() && !is_touched(self.graph, index);
                let refusable = if self.way == Way::Shown { !looked_at } else { supplied };
                // Contents that later frames read are there in any case.
                let carried = (resource.history > 0 || resource.keep) && is_written(self.graph, index);
                if refusable && !carried { Ok(true) } else { Err(format!("{}: {error}", what())) }
            }
            Err(error) => Err(format!("{}: {error}", what())),
        }
    }

    fn run(&mut self, wanted: &[Left], r: &mut Random, counts: &mut Counts) -> Result<(), String> {
        let [given, open] = supply(self.lab, self.graph);
        self.plan(counts);
        self.lab.executor.reset_history();
        for frame in 0..FRAMES {
            let last = frame + 1 == FRAMES;
            if last && self.way == Way::Shown {
                self.pinned = self.graph.resources.iter().map(|resource| resource.name.clone()).collect();
                self.plan(counts);
            } else if self.way != Way::Unseen && frame > 0 && r.percent(35) {
                self.look_elsewhere(r);
                self.plan(counts);
            }
            let time = moment(frame) as f32 * 0.125;
            let builtins = Builtins { frame_index: frame, frame_time: time, ..Builtins::default() };
            let inputs = FrameInputs {
                builtins: &builtins,
                params: &params(frame).map(Value::F32),
                overrides: &[],
                clock: Moment::from(TIMES[moment(frame)]),
                disabled: &[],
            };
            if frame == 5 {
                given.write(4 * 3, bytemuck::bytes_of(&WRITTEN)).expect("it is there");
            }
            if frame == 6 {
                open.write(0, bytemuck::bytes_of(&[0.375_f32])).expect("it is there");
            }
            self.lab.executor.frame(&inputs).map_err(|error| error.to_string())?;
            for (index, ages) in wanted[frame as usize].iter().enumerate() {
                for (age, mips) in ages.iter().enumerate() {
                    for mip in 0..mips.len() {
                        if last || self.way != Way::Unseen && r.percent(25) {
                            let refused = self
                                .read(index, age, mip, &wanted[frame as usize])
                                .map_err(|wrong| format!("frame {frame}: {wrong}"))?;
                            counts.reads += 1;
                            counts.refused += u64::from(refused);
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

#[test]
fn observing_changes_nothing() {
    let setting = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().expect("a number of graphs"));
    let from = setting("RAXEL_OBSERVED_FROM").unwrap_or(0);
    let count = setting("RAXEL_OBSERVED").unwrap_or(GRAPHS);
    let mut lab = Lab::new();
    let texts = shaders();
    let shaders = Arc::new(MemoryFiles::new(texts.iter().map(|(path, text)| (path.as_str(), text.as_str()))));
    let compiler = Compiler::new(shaders);
    let sources = layouts();
    let mut counts = Counts::default();
    for seed in from..from + count {
        let mut r = Random::new(seed.wrapping_mul(0x9E6C_63D0_876A_68DE) ^ 0x0B5E_17ED);
        // The interpreter knows clocks, but not their phases.
        let toml = graph_file(&mut r).replace("clock.sim.phase", "frame.time");
        let files = MemoryFiles::new([("graphs/random.toml", toml.as_str())]);
        let (graph, _) = compile("graphs/random.toml", &files, &compiler, &sources, &mut SourceMap::default())
            .unwrap_or_else(|errors| panic!("seed {seed}\n{toml}\n{errors:#?}"));
        let graph = Arc::new(graph);
        let Some(wanted) = interpret(&graph) else { continue };
        counts.graphs += 1;
        for way in [Way::Unseen, Way::Everything, Way::Shown] {
            let memo = r.percent(70);
            lab.executor.set_memo(memo);
            let present = graph.resource(graph.present).name.clone();
            let poison = r.percent(50);
            let mut run = Run { lab: &mut lab, graph: &graph, way, poison, present, pinned: Vec::new() };
            let done = run.run(&wanted, &mut r, &mut counts);
            lab.executor.wait().unwrap_or_else(|error| panic!("{error}"));
            done.unwrap_or_else(|wrong| panic!("seed {seed}, memo {memo}, {wrong}\n{toml}"));
            let messages = lab.device.log().take();
            assert!(messages.is_empty(), "seed {seed}\n{toml}\nthe validation layer says: {messages:#?}");
        }
    }
    eprintln!("{counts:?}");
    // The graphs are worth the trouble.
    let enough = counts.graphs * 10 > count * 9 && counts.reads > 20 * count && counts.refused > count;
    assert!(enough && counts.culled > count, "of {count}: {counts:?}");
}
