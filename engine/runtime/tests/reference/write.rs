//! Writes a graph as files: one, or one that extends another that differs.

use std::fmt::Write as _;

use crate::model::{Every, Float, Graph, How, Int, Kind, Pass, Resource, Size};
use crate::shaders::shader;
use raxel_testing::Random;

fn resource(graph: &Graph, resource: &Resource) -> String {
    let mut text = match &resource.kind {
        Kind::Target { size, mips } => {
            let size = match size {
                Size::Output => String::new(),
                Size::Half => "size = 0.5\n".to_owned(),
                Size::Fixed([w, h]) => format!("size = [{w}, {h}]\n"),
            };
            format!("[targets.{}]\nformat = \"r32ui\"\nmips = {mips}\n{size}", resource.name)
        }
        Kind::Words(words) => format!("[buffers.{}]\nsize = {}\n", resource.name, words * 4),
        Kind::Of(target) => {
            format!(
                "[buffers.{}]\nsize = {{ of = \"{}\", stride = 4 }}\n",
                resource.name, graph.resources[*target].name
            )
        }
    };
    for (key, value) in [("clear", resource.clear), ("init", resource.init)] {
        if let Some(value) = value {
            let _ = writeln!(text, "{key} = {value}");
        }
    }
    if resource.history > 0 {
        let _ = writeln!(text, "history = {}", resource.history);
    }
    if resource.keep {
        text += "keep = true\n";
    }
    if resource.clock {
        text += "clock = \"sim\"\n";
    }
    text
}

fn pass(graph: &Graph, pass: &Pass, place: &str) -> String {
    let mut text = format!(
        "[[passes]]\nname = \"{}\"\n{place}shader = \"{}\"\ndispatch = [1, 1, 1]\n",
        pass.name,
        shader(graph, pass).0
    );
    match pass.every {
        Every::Frame => {}
        Every::Frames(frames) => {
            let _ = writeln!(text, "every = {{ frames = {frames} }}");
        }
        Every::Hz(hz) => {
            let _ = writeln!(text, "every = {{ hz = {hz} }}");
        }
        Every::Still(still) => {
            let _ = writeln!(text, "every = {{ still = {still} }}");
        }
        Every::Clock => text += "every = \"sim\"\n",
    }
    if pass.in_loop {
        text += "loop = \"rounds\"\n";
    }
    if let Some(when) = pass.when {
        let _ = writeln!(text, "when = \"{}param.flag\"", if when { "" } else { "!" });
    }
    text += "[passes.bind]\n";
    for (at, read) in pass.reads.iter().enumerate() {
        let age = if read.age > 0 { format!("@{}", read.age) } else { String::new() };
        let name = format!("{}{age}", graph.resources[read.resource].name);
        let _ = writeln!(text, "b{at} = {}", bind(&name, read.mip, false));
    }
    for (slot, write) in pass.writes.iter().enumerate() {
        let bind = bind(&graph.resources[write.resource].name, write.mip, write.how == How::Part);
        let _ = writeln!(text, "b{} = {bind}", pass.reads.len() + slot);
    }
    let a = match pass.a {
        Int::Value(value) => format!("{{ type = \"u32\", value = {value} }}"),
        Int::N => "\"param.n\"".to_owned(),
        Int::FrameIndex => "\"frame.index\"".to_owned(),
        Int::FrameStill => "\"frame.still\"".to_owned(),
        Int::HistoryValid => "\"history.valid\"".to_owned(),
        Int::Tick => "\"clock.sim.tick\"".to_owned(),
        Int::LoopIndex => "\"loop.index\"".to_owned(),
    };
    let b = match pass.b {
        Float::Value(value) => format!("{{ type = \"f32\", value = {value:?} }}"),
        Float::Time => "\"frame.time\"".to_owned(),
        Float::Phase => "\"clock.sim.phase\"".to_owned(),
        Float::Delta => "\"clock.sim.delta\"".to_owned(),
    };
    let _ = writeln!(text, "[passes.push]\na = {a}\nb = {b}\nk = {{ type = \"u32\", value = {} }}", pass.k);
    if let Some(Some(u)) = pass.common.map(|block| block.u) {
        let _ = writeln!(text, "[passes.uniforms.both]\nu = {{ type = \"u32\", value = {u} }}");
    }
    text
}

fn bind(name: &str, mip: usize, partial: bool) -> String {
    match (mip, partial) {
        (0, false) => format!("\"{name}\""),
        (mip, false) => format!("{{ target = \"{name}\", mip = {mip} }}"),
        (0, true) => format!("{{ target = \"{name}\", partial = true }}"),
        (mip, true) => format!("{{ target = \"{name}\", mip = {mip}, partial = true }}"),
    }
}

fn head(graph: &Graph) -> String {
    let mut text = format!(
        r#"name = "{}"
present = "{}"
[params.n]
type = "u32"
default = {}
[params.flag]
type = "bool"
default = {}
"#,
        graph.name, graph.resources[graph.present].name, graph.n, graph.flag
    );
    if let Some(clock) = &graph.clock {
        let _ = write!(text, "[clocks.sim]\nhz = {}\nmost = {}\n", clock.hz, clock.most);
    }
    if graph.passes.iter().any(|pass| pass.in_loop) {
        let _ = write!(text, "[loops.rounds]\ncount = {}\n", graph.rounds);
    }
    if graph.passes.iter().any(|pass| pass.common.is_some()) {
        let _ = write!(text, "[blocks.both]\nu = {{ type = \"u32\", value = {} }}\nv = \"param.n\"\n", graph.common);
    }
    text
}

/// The graph in one file.
pub(crate) fn whole(graph: &Graph) -> String {
    let resources = graph.resources.iter().map(|r| resource(graph, r));
    let passes = graph.passes.iter().map(|p| pass(graph, p, ""));
    head(graph) + &resources.chain(passes).collect::<String>()
}

/// The graph as one that extends another: what stands below differs in values, lacks a pass and has one too many.
pub(crate) fn layered(graph: &Graph, r: &mut Random) -> (String, String) {
    let mut below = graph.clone();
    let mut above = format!("extends = \"below.toml\"\nname = \"{}\"\n", graph.name);
    if r.percent(50) {
        below.n = below.n.wrapping_add(1) % 1000;
        let _ = write!(above, "[params.n]\ndefault = {}\n", graph.n);
    }
    let target = r.below(graph.resources.len());
    let under = &mut below.resources[target];
    if let (Some(clear), true) = (under.clear, r.percent(70)) {
        under.clear = Some(clear / 2);
        let table = if under.is_target() { "targets" } else { "buffers" };
        let _ = write!(above, "[{table}.{}]\nclear = {clear}\n", under.name);
    }
    let changed = r.below(graph.passes.len());
    below.passes[changed].k += 77;
    let moved = r.percent(50).then(|| r.below(graph.passes.len())).filter(|at| {
        // A neighbour says where it goes, and a loop, a clock and the block's users stay below.
        *at != changed
            && graph.passes[*at].common.is_none()
            && !graph.passes[*at].in_loop
            && graph.passes[*at].every != Every::Clock
            && graph.passes.len() > 1
    });
    let name = &graph.passes[changed].name;
    let _ = write!(
        above,
        "[[passes]]\nname = \"{name}\"\n[passes.push]\nk = {{ type = \"u32\", value = {} }}\n",
        graph.passes[changed].k
    );
    let mut extra = None;
    if r.percent(50) {
        let mut spare = graph.passes[r.below(graph.passes.len())].clone();
        (spare.name, spare.in_loop, spare.every) = ("spare".to_owned(), false, Every::Frame);
        let clocked = |resource: usize| graph.resources[resource].clock;
        if !spare.writes.iter().any(|write| clocked(write.resource)) && spare.a != Int::LoopIndex {
            extra = Some(spare);
            above += "[[passes]]\nname = \"spare\"\nremove = true\n";
        }
    }
    if let Some(at) = moved {
        let place = if at + 1 < graph.passes.len() {
            format!("before = \"{}\"\n", graph.passes[at + 1].name)
        } else {
            format!("after = \"{}\"\n", graph.passes[at - 1].name)
        };
        above += &pass(graph, &graph.passes[at], &place);
        below.passes.remove(at);
    }
    below.passes.extend(extra);
    (whole(&below), above)
}
