//! Random checked graphs, from a seed.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, Span};
use raxel_graph::checked::*;
use raxel_graph::plan::{
    BufferDesc, DeviceLimits, ImageDesc, MemoryModel, Observe, Plan, PlanInput, Present, Requirements, SourceSize,
    WorldInput, copy_name,
};
use raxel_shader::format::Format;
use raxel_shader::interface::{Access, Interface, LocalSize};
use raxel_shader::{Request, Shader};
use raxel_testing::Random;

/// The choices of a seed.
pub(crate) fn random(seed: u64) -> Random {
    Random::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5851_F42D_4C95_7F2D)
}

/// A graph and the input of its plan.
pub(crate) struct Case {
    pub graph: Arc<Graph>,
    pub present: Present,
    pub pinned: Vec<ResourceId>,
    pub observe: Observe,
    pub facts: [bool; 3],
    pub sources: BTreeMap<String, SourceSize>,
    pub memory: RandomMemory,
    pub alias: bool,
    pub poison: bool,
}

impl Case {
    pub(crate) fn holds(&self, fact: &Fact) -> bool {
        match fact {
            Fact::WorldHasEmission => self.facts[0],
            Fact::WorldHasTransparency => self.facts[1],
            _ => self.facts[2],
        }
    }

    pub(crate) fn runs(&self, pass: &Pass) -> bool {
        pass.runs_where(|fact| self.holds(fact))
    }

    pub(crate) fn plan(&self) -> Result<Plan, Vec<Diagnostic>> {
        let input = PlanInput {
            output: OUTPUT,
            present: self.present,
            pinned: &self.pinned,
            observe: self.observe,
            facts: &|fact| self.holds(fact),
            counts: &[],
            sources: &self.sources,
            world: WorldInput { extent: WORLD, materials: None },
            memory: &self.memory,
            alias: self.alias,
            poison: self.poison,
            limits: DeviceLimits::PORTABLE,
        };
        raxel_graph::plan(self.graph.clone(), &input)
    }
}

pub(crate) const OUTPUT: [u32; 2] = [64, 32];
/// Voxels of the world's bounds, no multiples of anything.
pub(crate) const WORLD: [u32; 3] = [37, 21, 9];
/// Texels of the image that is supplied.
pub(crate) const SOURCE_IMAGE: [u32; 3] = [16, 4, 8];

/// Texels per voxel.
const SCALES: [f64; 4] = [1.0, 0.5, 0.25, 0.0625];

/// Requirements that are a random function of the request.
pub(crate) struct RandomMemory {
    pub seed: u64,
    pub granularity: u64,
    pub kinds_apart: bool,
}

impl RandomMemory {
    fn requirements(&self, of: u64, buffer: bool) -> Requirements {
        let mut random = random(self.seed ^ of.wrapping_mul(0x0100_0000_01B3));
        let alignment = 16_u64 << random.below(6);
        let size = (1 + random.below(40_u64)) * 32;
        let type_bits = match (self.kinds_apart, buffer) {
            (true, true) => 0b1_0000,
            (true, false) => 0b0_0001,
            _ => random.pick(&[0b111, 0b011, 0b110, 0b100]),
        };
        Requirements { size: size.next_multiple_of(alignment), alignment, type_bits }
    }
}

impl MemoryModel for RandomMemory {
    fn image(&self, image: &ImageDesc) -> Requirements {
        let [w, h, d] = image.extent.map(u64::from);
        let of = w * 31 + h * 37 + d * 41 + u64::from(image.mips * 43 + image.layers * 47) + image.format as u64 * 53;
        self.requirements(of, false)
    }

    fn buffer(&self, buffer: &BufferDesc) -> Requirements {
        self.requirements(buffer.size, true)
    }

    fn granularity(&self) -> u64 {
        self.granularity
    }
}

/// A random graph. Most passes load contents stored before them, so few are culled.
pub(crate) fn case(seed: u64) -> Case {
    let mut random = random(seed);
    let r = &mut random;
    // Half of the graphs are chains of whole resources, which share memory; the others are as wild as can be.
    let tame = r.percent(50);
    let mut resources = resources(r, tame);
    let count = 1 + if r.percent(8) { r.below(24) } else { r.below(9) } + if tame { 2 } else { 0 };
    let mut passes = Vec::new();
    let mut stored: Vec<ResourceId> = Vec::new();
    for number in 0..count {
        let mut made = pass(r, number, &resources, &mut stored, tame);
        if !stored.is_empty() && r.percent(15) {
            passes.extend(queue(r, &mut made, &mut resources, &stored));
        }
        passes.push(made);
    }
    let clocks = clocks(r, &mut resources, &mut passes);
    let any = |r: &mut Random| ResourceId(r.below(resources.iter().filter(|of| !of.made).count() as u32));
    let present = stored.last().copied().filter(|_| r.percent(80)).unwrap_or_else(|| any(r));
    let of = &resources[present.0 as usize];
    let (mips, layers) = match &of.kind {
        ResourceKind::Target(target) => (target.mips.max(1), target.layers),
        ResourceKind::Buffer(_) => (1, 1),
    };
    let present = Present {
        resource: present,
        age: if r.percent(20) { r.below(of.history + 1) } else { 0 },
        mip: r.below(mips),
        layer: r.below(layers),
        after: r.percent(25).then(|| PassId(r.below(passes.len() as u32))),
        round: None,
    };
    let pinned = if r.percent(15) { vec![any(r)] } else { Vec::new() };
    let graph = Graph {
        name: format!("random {seed}"),
        about: String::new(),
        present: present.resource,
        params: Vec::new(),
        clocks,
        resources,
        loops: Vec::new(),
        passes,
        materials: Vec::new(),
        files: Vec::new(),
    };
    Case {
        graph: Arc::new(graph),
        present,
        pinned,
        facts: [r.percent(50), r.percent(50), r.percent(50)],
        sources: BTreeMap::from([
            ("world.tree64".to_owned(), 4096.into()),
            (copy_name("world.tree64"), 8192.into()),
            (copy_name("world.texture3d"), SourceSize { bytes: 64, image: Some(SOURCE_IMAGE) }),
            ("world.texture3d".to_owned(), SourceSize { bytes: 64, image: Some(SOURCE_IMAGE) }),
        ]),
        memory: RandomMemory { seed: r.bits(), granularity: r.pick(&[1, 1, 64, 1024]), kinds_apart: r.percent(30) },
        alias: r.percent(85),
        poison: r.percent(20),
        observe: if r.percent(20) { Observe::Everything } else { Observe::Shown },
    }
}

fn resources(r: &mut Random, tame: bool) -> Vec<Resource> {
    let count = if tame { 5 + r.below(9) } else { 1 + r.below(9) };
    let rarely = |percent: u32| if tame { percent / 4 } else { percent };
    let mut made: Vec<Resource> = Vec::new();
    for number in 0..count {
        let history = if r.percent(rarely(20)) { 1 + r.below(2) } else { 0 };
        let cleared = r.percent(20);
        let filled = r.percent(rarely(10));
        let kind = if r.percent(30) {
            let stride = 4 * (1 + r.below(4));
            let size = if number > 0 && r.percent(10) {
                BufferSize::Source("world.tree64".to_owned())
            } else {
                match r.below(8) {
                    0 => BufferSize::Elements { count: 3 + r.below(2000_u64), stride },
                    1 => BufferSize::World { scale: r.pick(&SCALES), per: 1 + r.below(3), stride },
                    2 if number > 0 => match counted(r, &made) {
                        Some(of) => BufferSize::Of { of, per: 1 + r.below(3), stride },
                        None => BufferSize::Bytes(64),
                    },
                    _ => BufferSize::Bytes((4 + r.below(60_u64)) * 16),
                }
            };
            let source = matches!(size, BufferSize::Source(_));
            ResourceKind::Buffer(Buffer {
                size,
                clear: (cleared && !source).then_some(7),
                init: (filled && !source).then_some(1),
            })
        } else {
            let volume = r.percent(10);
            let supplied = volume && r.percent(50);
            let extent = if supplied {
                Extent::Source
            } else if volume && r.percent(50) {
                Extent::World { scale: r.pick(&SCALES) }
            } else if volume {
                Extent::Fixed3([8 + r.below(8), 8, 8])
            } else if number > 0 && r.percent(50) {
                Extent::Output { scale: [0.5, 0.5] }
            } else {
                Extent::Fixed2([32 + r.below(32), 32])
            };
            ResourceKind::Target(Target {
                format: r.pick(&[Format::R32f, Format::Rgba8, Format::Rgba16f]),
                extent,
                source: supplied.then(|| "world.texture3d".to_owned()),
                mips: if supplied {
                    0
                } else if r.percent(30) {
                    r.below(4)
                } else {
                    1
                },
                layers: if !volume && r.percent(20) { 1 + r.below(3) } else { 1 },
                clear: (cleared && !supplied).then_some(Clear::Float([0.5; 4])),
                init: (filled && !supplied).then_some(Clear::Float([1.0; 4])),
                display: None,
            })
        };
        let source = kind.supplied_by().is_some();
        let (origin, history) = match source {
            true if r.percent(40) => (Origin::Copy, 0),
            true => (Origin::Source(r.pick(&[Access::Read, Access::Read, Access::ReadWrite])), 0),
            false => (Origin::Graph, history),
        };
        let keep = !source && r.percent(rarely(12));
        made.push(Resource { history, keep, origin, ..Resource::new(format!("r{number}"), kind, place()) });
    }
    made
}

/// A resource whose texels or elements can be counted. The judge of sizes knows no chains of `of`.
fn counted(r: &mut Random, resources: &[Resource]) -> Option<ResourceId> {
    let counted = |resource: &Resource| match &resource.kind {
        ResourceKind::Target(target) => target.source.is_none(),
        ResourceKind::Buffer(buffer) => {
            matches!(buffer.size, BufferSize::Elements { .. } | BufferSize::World { .. })
        }
    };
    let all: Vec<u32> = (0..resources.len() as u32).filter(|index| counted(&resources[*index as usize])).collect();
    (!all.is_empty()).then(|| ResourceId(r.pick(&all)))
}

/// Gives a third of the graphs one or two clocks: each drives passes that stand together, and turns some of what only they write.
fn clocks(r: &mut Random, resources: &mut [Resource], passes: &mut [Pass]) -> Vec<Clock> {
    let mut clocks = Vec::new();
    let mut at = 0;
    while clocks.len() < 2 && at < passes.len() && r.percent(35) {
        let id = ClockId(clocks.len() as u32);
        let first = at + r.below((passes.len() - at) as u32) as usize;
        let end = first + 1 + r.below(3.min((passes.len() - first) as u32)) as usize;
        for pass in &mut passes[first..end] {
            pass.every = Some(Every::Clock(id));
        }
        for (index, resource) in resources.iter_mut().enumerate() {
            let writes = |pass: &Pass| pass.accesses.iter().any(|a| a.resource.0 == index as u32 && a.access.writes());
            let of_clock = (first..end).any(|pass| writes(&passes[pass]));
            let of_others = (0..passes.len()).any(|pass| !(first..end).contains(&pass) && writes(&passes[pass]));
            if of_clock && !of_others && resource.kind.supplied_by().is_none() && r.percent(75) {
                resource.clock = Some(id);
                resource.history += r.below(3);
            }
        }
        clocks.push(Clock { name: format!("c{}", id.0), hz: 60.0, most: 1 + r.below(3), place: place() });
        at = end;
    }
    clocks
}

fn pass(r: &mut Random, number: u32, resources: &[Resource], stored: &mut Vec<ResourceId>, tame: bool) -> Pass {
    let mut accesses = Vec::new();
    let declared = resources.iter().filter(|of| !of.made).count() as u32;
    let any = |r: &mut Random| ResourceId(r.below(declared));
    for _ in 0..r.below(3) + u32::from(tame && !stored.is_empty()) {
        let resource = if stored.is_empty() || !tame && r.percent(10) {
            any(r)
        } else if tame {
            r.pick(&stored[stored.len().saturating_sub(3)..])
        } else {
            r.pick(stored)
        };
        let of = &resources[resource.0 as usize];
        let age = if of.history > 0 && r.percent(60) { r.below(of.history + 1) } else { 0 };
        let (usage, access) = match of.kind {
            ResourceKind::Target(_) if r.percent(50) => (Usage::SampledImage, Access::Read),
            ResourceKind::Target(_) => (Usage::StorageImage, Access::Read),
            ResourceKind::Buffer(_) if r.percent(20) => (Usage::UniformBuffer, Access::Read),
            ResourceKind::Buffer(_) => (Usage::StorageBuffer, Access::Read),
        };
        accesses.push(bound(r, resources, resource, age, access, usage));
    }
    let mut written = Vec::new();
    for _ in 0..=r.below(2) {
        let mut resource = any(r);
        for _ in 0..if tame { 6 } else { 1 } {
            if stored.contains(&resource) && r.percent(if tame { 95 } else { 50 }) {
                resource = any(r);
            }
        }
        let of = &resources[resource.0 as usize];
        let usage = match &of.kind {
            _ if !of.is_writable() => continue,
            ResourceKind::Target(_) => Usage::StorageImage,
            ResourceKind::Buffer(_) => Usage::StorageBuffer,
        };
        let access = if r.percent(75) { Access::Write } else { Access::ReadWrite };
        let mut stores = bound(r, resources, resource, 0, access, usage);
        if tame && !stored.contains(&resource) {
            (stores.mips, stores.layers, stores.access) = (Interval::ALL, Interval::ALL, Access::Write);
        }
        accesses.push(stores);
        written.push(resource);
    }
    let arguments: Vec<ResourceId> = stored
        .iter()
        .copied()
        .filter(|id| {
            let kind = &resources[id.0 as usize].kind;
            matches!(kind, ResourceKind::Buffer(Buffer { size: BufferSize::Bytes(_), .. }))
        })
        .collect();
    let mut dispatch = Dispatch::Threads([32, 8, 1]);
    let listed =
        |resource: &Resource| matches!(&resource.kind, ResourceKind::Buffer(buffer) if buffer.size.stride().is_some());
    let lists: Vec<u32> = (0..resources.len() as u32).filter(|index| listed(&resources[*index as usize])).collect();
    if !lists.is_empty() && r.percent(20) {
        dispatch = Dispatch::ElementsOf { buffer: ResourceId(r.pick(&lists)) };
    } else if !arguments.is_empty() && r.percent(30) {
        let buffer = r.pick(&arguments);
        dispatch = Dispatch::Indirect { buffer, offset: 0 };
        accesses.push(bound(r, resources, buffer, 0, Access::Read, Usage::IndirectArguments));
    }
    stored.extend(written);
    Pass {
        name: format!("p{number}"),
        shader: shader(),
        dispatch,
        accesses,
        push: if r.percent(70) { vec![moving(r)] } else { Vec::new() },
        uniforms: Vec::new(),
        specialization: Vec::new(),
        subgroup_size: None,
        made: false,
        in_loop: None,
        round: None,
        when: r
            .percent(if tame { 3 } else { 10 })
            .then(|| Condition {
                fact: if r.percent(50) { Fact::WorldHasEmission } else { Fact::WorldHasVoxels },
                negated: r.percent(50),
            })
            .into_iter()
            .collect(),
        every: r.percent(if tame { 3 } else { 8 }).then_some(Every::Frames(3)),
        place: place(),
    }
}

/// Makes a pass dispatch a queue that an earlier pass has stored: its arguments come from a pass in front, through a buffer of their
/// own. `None` where no such buffer is there, or where the pass is dispatched indirectly already.
fn queue(r: &mut Random, pass: &mut Pass, resources: &mut Vec<Resource>, stored: &[ResourceId]) -> Option<Pass> {
    let buffer = |id: &&ResourceId| {
        let kind = &resources[id.0 as usize].kind;
        matches!(kind, ResourceKind::Buffer(_)) && kind.supplied_by().is_none()
    };
    let queues: Vec<ResourceId> = stored.iter().filter(buffer).copied().collect();
    if queues.is_empty() || matches!(pass.dispatch, Dispatch::Indirect { .. }) {
        return None;
    }
    let queue = r.pick(&queues);
    let arguments = ResourceId(resources.len() as u32);
    let name = format!("{}.arguments", pass.name);
    let kind = ResourceKind::Buffer(Buffer { size: BufferSize::Bytes(16), clear: None, init: None });
    resources.push(Resource {
        name: name.clone(),
        kind,
        history: 0,
        keep: false,
        clock: None,
        made: true,
        warnings: Vec::new(),
        origin: Origin::Graph,
        place: place(),
    });
    let maker = Pass {
        name,
        dispatch: Dispatch::Groups([1; 3]),
        accesses: vec![
            bound(r, resources, queue, 0, Access::Read, Usage::StorageBuffer),
            bound(r, resources, arguments, 0, Access::Write, Usage::StorageBuffer),
        ],
        made: true,
        ..pass.clone()
    };
    pass.dispatch = Dispatch::Indirect { buffer: arguments, offset: 0 };
    pass.accesses.push(bound(r, resources, arguments, 0, Access::Read, Usage::IndirectArguments));
    Some(maker)
}

fn bound(
    r: &mut Random,
    resources: &[Resource],
    resource: ResourceId,
    age: u32,
    access: Access,
    usage: Usage,
) -> BoundAccess {
    let (mips, layers) = match &resources[resource.0 as usize].kind {
        ResourceKind::Target(target) => (target.mips.max(1), target.layers),
        ResourceKind::Buffer(_) => (1, 1),
    };
    let mut part = |end: u32| {
        if end == 1 || r.percent(50) {
            Interval::ALL
        } else {
            let first = r.below(end);
            Interval { first, count: r.below(end - first + 1) }
        }
    };
    let (mut mips, mut layers) = (part(mips), part(layers));
    if !matches!(usage, Usage::StorageImage | Usage::SampledImage) {
        (mips, layers) = (Interval::one(0), Interval::one(0));
    }
    BoundAccess { resource, age, mips, layers, access, usage, binding: None, sampler: None }
}

/// A push constant that is another in every frame.
fn moving(r: &mut Random) -> Fill {
    let from = r.pick(&[
        Builtin::FrameTime,
        Builtin::CameraCell,
        Builtin::CursorPosition,
        Builtin::InputDrag,
        Builtin::CameraFrac,
        Builtin::FrameIndex,
        Builtin::CameraFov,
        Builtin::FrameStill,
        Builtin::HistoryValid,
    ]);
    Fill { member: "value".to_owned(), offset: 0, ty: from.ty(), stride: 0, from: ValueOrigin::Builtin(from) }
}

fn place() -> Span {
    Span::new("graphs/random.toml", 0..0)
}

/// A shader that is never looked into.
pub(crate) fn shader() -> Arc<Shader> {
    let local = LocalSize { value: 8, spec_id: None };
    Arc::new(Shader {
        request: Request { path: "shaders/random.comp".into(), entry: "main".into(), defines: Vec::new() },
        spirv: Arc::from([]),
        interface: Interface {
            entry: "main".into(),
            local_size: [local, local, LocalSize::default()],
            ..Interface::default()
        },
        files: Vec::new(),
        key: [0; 32],
        module: [0; 32],
    })
}

/// The graph as text, for a seed that fails.
pub(crate) fn text(case: &Case) -> String {
    let graph = &case.graph;
    let mut out = String::new();
    let name = |id: ResourceId| &graph.resource(id).name;
    let _ = writeln!(out, "{:?}", graph.clocks);
    let _ = writeln!(out, "present {:?}, pinned {:?}, facts {:?}", case.present, case.pinned, case.facts);
    for resource in &graph.resources {
        let Resource { name, history, keep, clock, kind, .. } = resource;
        let _ = writeln!(out, "{name}: history {history} keep {keep} {clock:?} {kind:?}");
    }
    for pass in &graph.passes {
        let on = if case.runs(pass) { "" } else { " (off)" };
        let every = pass.every.map_or(String::new(), |every| format!(" ({every:?})"));
        let moves = if pass.push.is_empty() { "" } else { " (moves)" };
        let _ = write!(out, "{}{on}{every}{moves}:", pass.name);
        for a in &pass.accesses {
            let _ = write!(
                out,
                " {:?} {}@{} m{:?} l{:?} {:?};",
                a.access,
                name(a.resource),
                a.age,
                (a.mips.first, a.mips.count),
                (a.layers.first, a.layers.count),
                a.usage
            );
        }
        out.push('\n');
    }
    out
}
