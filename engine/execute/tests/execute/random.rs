//! Random graphs on the device, under synchronization validation: the layer must stay silent. The texels must not depend on shared
//! memory (filled before its use), nor on kept valid results.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_execute::moment::Moment;
use raxel_execute::{Builtins, ExternalResource, FrameInputs};
use raxel_graph::SourceLayout;
use raxel_graph::checked::Graph;
use raxel_graphfile::compile;
use raxel_shader::Compiler;
use raxel_shader::interface::{Access, Block, Member, Scalar, Type};
use raxel_testing::Random;

use crate::lab::{Lab, Planned};
use crate::random_shaders::Kind::{self, *};
use crate::random_shaders::{READS, WRITES, shader_name, shaders};

/// Graphs of the normal test run.
const GRAPHS: u64 = 60;
/// Graphs of the run with `--ignored`.
const MANY: u64 = 3000;
pub(crate) const FRAMES: u32 = 8;
/// Seconds of the frames: at 20 ticks a second, 1, 1, 2, (0, a still frame,) 0, 3, 1 and 4 ticks are due.
pub(crate) const TIMES: [f64; 8] = [0.0, 0.05, 0.15, 0.15, 0.16, 0.31, 0.36, 0.58];

#[derive(Clone, Copy, PartialEq)]
enum Sort {
    Target {
        mips: usize,
    },
    Floats,
    Arguments,
    /// Floats written in the file.
    Table,
    /// Supplied by the test as [`GIVEN`]; passes only read it.
    Given,
    /// Supplied by the test as [`OPEN`]; passes may write it.
    Open,
    /// A copy of [`GIVEN`].
    Copy,
}

/// Sources of [`FLOATS`] numbers. The test writes parts of both between frames.
pub(crate) const GIVEN: &str = "test.given";
pub(crate) const OPEN: &str = "test.open";
pub(crate) const FLOATS: usize = 64;

struct Thing {
    name: String,
    sort: Sort,
    history: usize,
    clock: bool,
}

/// A graph file. Most passes read the output of passes before them.
pub(crate) fn graph_file(r: &mut Random) -> String {
    let mut toml = "name = \"random\"\n".to_owned();
    let mut things: Vec<Thing> = Vec::new();
    // More than half of the graphs are chains, whose targets share memory; the others are as wild as can be.
    let chain = r.percent(60);
    let clocked = r.percent(35);
    let count = 4 + r.below(9) + if chain { 3 } else { 0 };
    let mut tables = String::new();
    for number in 0..count {
        let (name, sort) = match r.below(10) {
            _ if number == 0 => (format!("r{number}"), Sort::Target { mips: 1 }),
            0..2 => {
                let sorts = [Sort::Floats, Sort::Floats, Sort::Table, Sort::Given, Sort::Copy, Sort::Open];
                let sort = sorts[r.below(sorts.len())];
                // Two names of one buffer that passes write are refused.
                let twice = sort == Sort::Open && things.iter().any(|thing| thing.sort == Sort::Open);
                (format!("r{number}"), if twice { Sort::Copy } else { sort })
            }
            2 => (format!("r{number}"), Sort::Arguments),
            3 if !chain => (format!("r{number}"), Sort::Target { mips: 2 }),
            _ => (format!("r{number}"), Sort::Target { mips: 1 }),
        };
        let supplied = match sort {
            Sort::Table => format!("type = \"f32\"\nvalues = [0.5, {}, 0.125]\n", r.below(8)),
            Sort::Given => format!("source = \"{GIVEN}\"\n"),
            Sort::Open => format!("source = \"{OPEN}\"\n"),
            Sort::Copy => format!("copy = \"{GIVEN}\"\n"),
            Sort::Target { .. } | Sort::Floats | Sort::Arguments => String::new(),
        };
        if !supplied.is_empty() {
            let _ = write!(tables, "[buffers.{name}]\n{supplied}");
            things.push(Thing { name, sort, history: 0, clock: false });
            continue;
        }
        let history = if r.percent(if chain { 3 } else { 12 }) { 1 + r.below(2) } else { 0 };
        if let Sort::Target { mips } = sort {
            let size = ["[8, 8]", "[16, 8]", "[16, 16]", "[64, 32]"][r.below(4)];
            let _ = write!(tables, "[targets.{name}]\nformat = \"r32f\"\nsize = {size}\nmips = {mips}\n");
        } else {
            let size = if sort == Sort::Arguments { 12 } else { 64 << r.below(6) };
            let _ = write!(tables, "[buffers.{name}]\nsize = {size}\n");
        }
        let fill = if sort == (Sort::Target { mips: 1 }) { "0.5" } else { "1" };
        if r.percent(15) {
            let _ = writeln!(tables, "clear = {fill}");
        } else if r.percent(if chain { 1 } else { 6 }) {
            let _ = writeln!(tables, "init = {fill}");
        }
        if history > 0 {
            let _ = writeln!(tables, "history = {history}");
        }
        if r.percent(6) {
            tables += "keep = true\n";
        }
        // Only passes of the clock may write what turns with it.
        let clock = clocked && number > 0 && r.percent(35);
        if clock {
            tables += "clock = \"sim\"\n";
        }
        things.push(Thing { name, sort, history, clock });
    }
    let suits = |thing: &Thing, kind: Kind| match thing.sort {
        Sort::Target { .. } => matches!(kind, Sampled | ReadImage | WriteImage | ReadWriteImage),
        Sort::Floats | Sort::Open | Sort::Copy => matches!(kind, ReadBuffer | WriteBuffer),
        Sort::Table | Sort::Given => kind == ReadBuffer,
        Sort::Arguments => kind == WriteArguments,
    };
    let mut written: Vec<usize> = Vec::new();
    let mut shown = None;
    let passes = 2 + r.below(8);
    // Passes of a clock stand together.
    let first = r.below(passes);
    let ticking = if clocked { first..first + 1 + r.below(2) } else { 0..0 };
    for number in 0..passes {
        let ticks = ticking.contains(&number);
        let mut bound: Vec<(Kind, String)> = Vec::new();
        let mut taken: BTreeSet<usize> = BTreeSet::new();
        for _ in 0..r.below(3) + usize::from(chain) {
            let late = written.len().saturating_sub(3);
            let at = if written.is_empty() || r.percent(10) {
                r.below(things.len())
            } else {
                written[late + r.below(written.len() - late)]
            };
            let thing = &things[at];
            let fitting: Vec<Kind> = READS.into_iter().filter(|kind| suits(thing, *kind)).collect();
            let Some(&kind) = fitting.get(r.below(fitting.len())) else { continue };
            if bound.len() == 2 || !taken.insert(at) {
                continue;
            }
            let age = if thing.history > 0 && r.percent(70) { 1 + r.below(thing.history) } else { 0 };
            let name = if age == 0 { thing.name.clone() } else { format!("{}@{age}", thing.name) };
            bound.push((kind, bind(r, thing, kind, &name)));
        }
        bound.sort_by_key(|(kind, _)| *kind);
        let mut stores: Vec<(Kind, String)> = Vec::new();
        let mut stored = Vec::new();
        for _ in 0..=r.below(2) {
            let mut at = r.below(things.len());
            for _ in 0..if chain { 8 } else { 1 } {
                if written.contains(&at) && r.percent(if chain { 100 } else { 60 }) {
                    at = r.below(things.len());
                }
            }
            let thing = &things[at];
            if thing.clock != ticks && (thing.clock || r.percent(60)) {
                continue;
            }
            let fitting: Vec<Kind> = WRITES.into_iter().filter(|kind| suits(thing, *kind)).collect();
            let Some(&kind) = fitting.get(if r.percent(75) { 0 } else { r.below(fitting.len()) }) else { continue };
            if !taken.insert(at) {
                continue;
            }
            stores.push((kind, bind(r, thing, kind, &thing.name)));
            stored.push(at);
        }
        if stores.is_empty() {
            continue;
        }
        stores.sort_by_key(|(kind, _)| *kind);
        bound.extend(stores);
        let arguments: Vec<usize> =
            written.iter().copied().filter(|at| things[*at].sort == Sort::Arguments && !taken.contains(at)).collect();
        let dispatch = if !arguments.is_empty() && r.percent(50) {
            format!("{{ indirect = \"{}\" }}", things[arguments[r.below(arguments.len())]].name)
        } else {
            "[1, 1, 1]".to_owned()
        };
        let kinds: Vec<Kind> = bound.iter().map(|(kind, _)| *kind).collect();
        let _ = write!(
            tables,
            "[[passes]]\nname = \"p{number}\"\nshader = \"{}\"\ndispatch = {dispatch}\n",
            shader_name(&kinds)
        );
        if ticks {
            tables += "every = \"sim\"\n";
        } else if r.percent(if chain { 2 } else { 10 }) {
            let _ = writeln!(tables, "every = {{ frames = {} }}", 2 + r.below(2));
        }
        tables += "[passes.bind]\n";
        for (at, (_, bind)) in bound.iter().enumerate() {
            let _ = writeln!(tables, "b{at} = {bind}");
        }
        // Some passes change from frame to frame, some now and then. Most depend on their inputs only.
        let from = match r.below(4) {
            // A constant resource shares no memory.
            _ if chain && number == 0 => "frame.time",
            0 if clocked => "clock.sim.phase",
            0 => "frame.time",
            1 => "param.knob",
            _ => "param.still",
        };
        let _ = writeln!(tables, "[passes.push]\nadd = \"{from}\"");
        if let Some(target) = stored.iter().find(|at| matches!(things[**at].sort, Sort::Target { .. })) {
            shown = Some(*target);
        }
        written.extend(stored);
    }
    let shown = shown.unwrap_or_else(|| {
        tables += r#"[[passes]]
name = "last"
shader = "w.comp"
dispatch = [1, 1, 1]
bind = { b0 = "r0" }
push = { add = "frame.time" }
"#;
        0
    });
    let _ = writeln!(toml, "present = \"{}\"", things[shown].name);
    for param in ["knob", "still"] {
        let _ = write!(toml, "[params.{param}]\ntype = \"f32\"\ndefault = 0.25\n");
    }
    if clocked {
        let _ = write!(toml, "[clocks.sim]\nhz = 20\nmost = {}\n", 1 + r.below(3));
    }
    toml + &tables
}

fn bind(r: &mut Random, thing: &Thing, kind: Kind, name: &str) -> String {
    match thing.sort {
        Sort::Target { mips: 2 } if kind != Sampled || r.percent(50) => {
            format!("{{ target = \"{name}\", mip = {} }}", r.below(2))
        }
        _ if WRITES.contains(&kind) && r.percent(8) => format!("{{ target = \"{name}\", partial = true }}"),
        _ => format!("\"{name}\""),
    }
}

/// The shown texels of each frame.
fn run(lab: &mut Lab, graph: &Arc<Graph>, alias: bool, memo: bool, poison: bool) -> (Vec<Vec<[f32; 4]>>, u32) {
    let shown = graph.resource(graph.present).name.clone();
    let [given, open] = supply(lab, graph);
    let plan = lab.plan(graph, &Planned { alias, poison, present: &shown, ..Planned::default() });
    let shared = plan.blocks.len() as u32;
    let prepared = lab.prepare(&plan).unwrap_or_else(|error| panic!("{error}"));
    lab.executor.swap(prepared);
    lab.executor.set_memo(memo);
    lab.executor.reset_history();
    let mut frames = Vec::new();
    for frame in 0..FRAMES {
        // Frames 2 and 3 are alike, so that the memo has something to skip.
        let moment = if frame == 3 { 2 } else { frame };
        let builtins = Builtins { frame_index: frame, frame_time: moment as f32 * 0.125, ..Builtins::default() };
        let params = [raxel_graph::checked::Value::F32((frame / 2) as f32 * 0.0625)];
        let inputs = FrameInputs {
            builtins: &builtins,
            params: &params,
            overrides: &[],
            clock: Moment::from(TIMES[moment as usize]),
            disabled: &[],
        };
        // The copies are filled again, and what passes made of the open source is written over in part.
        if frame == 5 {
            given.write(4 * 3, bytemuck::bytes_of(&[0.75_f32, 0.25])).expect("it is there");
        }
        if frame == 6 {
            open.write(0, bytemuck::bytes_of(&[0.375_f32])).expect("it is there");
        }
        lab.executor.frame(&inputs).unwrap_or_else(|error| panic!("{error}"));
        frames.push(lab.floats(&shown, 0, 0, 0));
    }
    (frames, shared)
}

/// Supplies a graph with its sources, fresh ones, so that every run finds the same.
pub(crate) fn supply(lab: &mut Lab, graph: &Graph) -> [Arc<ExternalResource>; 2] {
    let builder = lab.executor.builder();
    let source = |name: &str, value: f32| {
        let buffer = builder.upload_buffer(bytemuck::cast_slice(&[value; FLOATS]), name).expect("it fits");
        builder.source(name, Some(buffer), None)
    };
    let sources = [source(GIVEN, 0.5), source(OPEN, 0.25)];
    for resource in &graph.resources {
        if let Some(source) = sources.iter().find(|source| resource.kind.supplied_by() == Some(source.name())) {
            lab.sources.insert(&resource.name, source.clone());
        }
    }
    sources
}

/// The sources' facts for the compiler.
pub(crate) fn layouts() -> Vec<SourceLayout> {
    let layout = |name: &str, access| {
        let element = Box::new(Type::Scalar(Scalar::F32));
        let values = Member {
            name: "values".to_owned(),
            offset: 0,
            ty: Type::Array { element, len: None, stride: 4 },
            place: None,
        };
        let block = Block { name: "Block".to_owned(), size: 0, members: vec![values] };
        SourceLayout { name: name.to_owned(), block, image: None, access, collected: None }
    };
    vec![layout(GIVEN, Access::Read), layout(OPEN, Access::ReadWrite)]
}

fn judge(seeds: std::ops::Range<u64>) {
    let mut lab = Lab::new();
    let texts = shaders();
    let shaders = Arc::new(MemoryFiles::new(texts.iter().map(|(path, text)| (path.as_str(), text.as_str()))));
    let compiler = Compiler::new(shaders);
    let sources = layouts();
    let mut supplied = [0_u32; 3];
    let (mut blocks, mut lively) = (0, 0);
    for seed in seeds.clone() {
        let toml = graph_file(&mut Random::new(seed.wrapping_mul(0xD1B5_4A32_D192_ED03)));
        let files = MemoryFiles::new([("graphs/random.toml", toml.as_str())]);
        let (graph, _) = compile("graphs/random.toml", &files, &compiler, &sources, &mut SourceMap::default())
            .unwrap_or_else(|errors| panic!("seed {seed}\n{toml}\n{errors:#?}"));
        let graph = Arc::new(graph);
        let (slow, _) = run(&mut lab, &graph, false, false, false);
        let (fast, shared) = run(&mut lab, &graph, true, true, seed % 2 == 0);
        lab.executor.wait().unwrap_or_else(|error| panic!("{error}"));
        let messages = lab.device.log().take();
        assert!(messages.is_empty(), "seed {seed}\n{toml}\nthe validation layer says: {messages:#?}");
        for (frame, (slow, fast)) in slow.iter().zip(&fast).enumerate() {
            assert_eq!(slow, fast, "seed {seed}, frame {frame}\n{toml}");
        }
        for (count, word) in supplied.iter_mut().zip(["values = ", OPEN, "copy = "]) {
            *count += u32::from(toml.contains(word));
        }
        blocks += shared;
        lively += u32::from(slow.windows(2).any(|pair| pair[0] != pair[1]));
    }
    // The graphs are worth the trouble.
    let count = (seeds.end - seeds.start) as u32;
    assert!(supplied.iter().all(|graphs| graphs * 20 > count), "{supplied:?} graphs with tables, open sources, copies");
    assert!(blocks * 5 > count && lively * 3 > count, "{blocks} shared blocks, {lively} pictures that change");
}

#[test]
fn random_graphs_are_silent_and_right() {
    judge(0..GRAPHS);
}

#[test]
#[ignore = "takes minutes"]
fn many_random_graphs_are_silent_and_right() {
    judge(GRAPHS..GRAPHS + MANY);
}
