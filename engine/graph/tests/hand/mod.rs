//! Checked graphs written by hand, for tests of the back end alone.
#![allow(dead_code, reason = "each test uses a part")]

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, Span};
use raxel_graph::checked::*;
use raxel_graph::plan::{DeviceLimits, Observe, Plan, PlanInput, Present, WorldInput};
use raxel_graph::{EstimatedMemory, ValueType};
use raxel_shader::format::Format;
use raxel_shader::interface::{Access, Interface, LocalSize, Scalar};
use raxel_shader::{Request, Shader};

/// A graph in the making; resources and passes are named.
pub(crate) struct Hand {
    pub graph: Graph,
    pub facts: bool,
    pub after: Option<&'static str>,
    pub alias: bool,
    pub poison: bool,
    pub output: [u32; 2],
    pub world: [u32; 3],
    pub materials: Option<Vec<String>>,
    pub limits: DeviceLimits,
    pub pinned: Vec<&'static str>,
    pub observe: Observe,
    pub counts: Vec<(ParamId, u32)>,
}

/// An access: `r` load, `w` store, `x` both, `s` sampled, `u` uniform, `i` indirect arguments; then a resource (`color@1`, `pyramid:2`).
pub(crate) type Bind = &'static str;

impl Hand {
    pub(crate) fn new(name: &str) -> Hand {
        let graph = Graph {
            name: name.to_owned(),
            about: String::new(),
            present: ResourceId(0),
            params: Vec::new(),
            clocks: Vec::new(),
            resources: Vec::new(),
            loops: Vec::new(),
            passes: Vec::new(),
            materials: Vec::new(),
            files: Vec::new(),
        };
        Hand {
            graph,
            facts: true,
            after: None,
            alias: true,
            poison: false,
            output: [320, 180],
            world: [100, 60, 40],
            materials: None,
            limits: DeviceLimits::PORTABLE,
            pinned: Vec::new(),
            observe: Observe::Shown,
            counts: Vec::new(),
        }
    }

    pub(crate) fn target(&mut self, name: &str, format: Format, edit: impl FnOnce(&mut Target, &mut u32)) -> &mut Hand {
        let mut target = Target {
            format,
            extent: Extent::Output { scale: [1.0; 2] },
            source: None,
            mips: 1,
            layers: 1,
            clear: None,
            init: None,
            display: None,
        };
        let mut history = 0;
        edit(&mut target, &mut history);
        self.resource(name, ResourceKind::Target(target), history)
    }

    pub(crate) fn buffer(&mut self, name: &str, size: BufferSize, clear: Option<u32>) -> &mut Hand {
        self.resource(name, ResourceKind::Buffer(Buffer { size, clear, init: None }), 0)
    }

    fn resource(&mut self, name: &str, kind: ResourceKind, history: u32) -> &mut Hand {
        let place = Span::new("graphs/hand.toml", 0..0);
        let origin = kind.supplied_by().map_or(Origin::Graph, |_| Origin::Source(Access::Read));
        self.graph.resources.push(Resource { origin, history, ..Resource::new(name, kind, place) });
        self
    }

    /// A clock of 60 ticks a second.
    pub(crate) fn clock(&mut self, name: &str, most: u32) -> ClockId {
        let place = Span::new("graphs/hand.toml", 0..0);
        self.graph.clocks.push(Clock { name: name.to_owned(), hz: 60.0, most, place });
        ClockId(self.graph.clocks.len() as u32 - 1)
    }

    /// A pass that takes `frame.time`, so its output changes in every frame.
    pub(crate) fn pass(&mut self, name: &str, binds: &[Bind]) -> &mut Pass {
        let pass = self.still_pass(name, binds);
        pass.push.push(from(ValueOrigin::Builtin(Builtin::FrameTime)));
        pass
    }

    /// A pass that takes only its bindings.
    pub(crate) fn still_pass(&mut self, name: &str, binds: &[Bind]) -> &mut Pass {
        let accesses = binds.iter().map(|bind| self.bind(bind)).collect::<Vec<_>>();
        let indirect = accesses.iter().find(|a| a.usage == Usage::IndirectArguments);
        let stored = accesses.iter().find(|a| a.usage == Usage::StorageImage && a.access.writes());
        let dispatch = match (indirect, stored) {
            (Some(buffer), _) => Dispatch::Indirect { buffer: buffer.resource, offset: 0 },
            (None, Some(target)) => Dispatch::ThreadsOf { target: target.resource, mip: target.mips.first },
            (None, None) => Dispatch::Threads([64, 1, 1]),
        };
        self.graph.passes.push(Pass {
            name: name.to_owned(),
            shader: shader(name),
            dispatch,
            accesses,
            push: Vec::new(),
            uniforms: Vec::new(),
            specialization: Vec::new(),
            subgroup_size: None,
            made: false,
            in_loop: None,
            round: None,
            when: Vec::new(),
            every: None,
            place: Span::new("graphs/hand.toml", 0..0),
        });
        self.graph.passes.last_mut().expect("one was pushed")
    }

    fn bind(&self, bind: &str) -> BoundAccess {
        let (how, name) = bind.split_once(' ').expect("`how name`");
        let (name, mip) = name.split_once(':').map_or((name, None), |(name, mip)| (name, mip.parse().ok()));
        let (name, age) = name.split_once('@').map_or((name, 0), |(name, age)| (name, age.parse().expect("an age")));
        let resource = self.graph.find_resource(name).expect("a resource of that name");
        let image = matches!(self.graph.resource(resource).kind, ResourceKind::Target(_));
        let storage = if image { Usage::StorageImage } else { Usage::StorageBuffer };
        let (access, usage) = match how {
            "r" => (Access::Read, storage),
            "w" => (Access::Write, storage),
            "x" => (Access::ReadWrite, storage),
            "s" => (Access::Read, Usage::SampledImage),
            "u" => (Access::Read, Usage::UniformBuffer),
            "i" => (Access::Read, Usage::IndirectArguments),
            _ => panic!("no access is called {how}"),
        };
        let mips = mip.map_or(Interval::ALL, Interval::one);
        BoundAccess { resource, age, mips, layers: Interval::ALL, access, usage, binding: None, sampler: None }
    }

    pub(crate) fn plan(&self, shown: &str) -> Result<Plan, Vec<Diagnostic>> {
        self.with_input(shown, raxel_graph::plan)
    }

    pub(crate) fn with_input<T>(&self, shown: &str, use_: impl FnOnce(Arc<Graph>, &PlanInput) -> T) -> T {
        let graph = Arc::new(self.graph.clone());
        let (name, age) = shown.split_once('@').map_or((shown, 0), |(name, age)| (name, age.parse().expect("an age")));
        let present = Present {
            resource: graph.find_resource(name).expect("a resource of that name"),
            age,
            mip: 0,
            layer: 0,
            after: self.after.map(|pass| graph.find_pass(pass).expect("a pass of that name")),
            round: None,
        };
        let pinned: Vec<_> = self.pinned.iter().filter_map(|name| graph.find_resource(name)).collect();
        let sources = BTreeMap::from([("world.tree64".to_owned(), (5 << 20).into())]);
        let input = PlanInput {
            output: self.output,
            present,
            pinned: &pinned,
            observe: self.observe,
            facts: &|_| self.facts,
            counts: &self.counts,
            sources: &sources,
            world: WorldInput { extent: self.world, materials: self.materials.as_deref() },
            memory: &EstimatedMemory,
            alias: self.alias,
            poison: self.poison,
            limits: self.limits,
        };
        use_(graph.clone(), &input)
    }
}

/// A push constant.
pub(crate) fn from(from: ValueOrigin) -> Fill {
    Fill { member: "value".to_owned(), offset: 0, ty: ValueType::scalar(Scalar::F32), stride: 0, from }
}

/// A shader that is never looked into, with workgroups of 8 × 8.
pub(crate) fn shader(name: &str) -> Arc<Shader> {
    let local = LocalSize { value: 8, spec_id: None };
    Arc::new(Shader {
        request: Request { path: format!("shaders/{name}.comp"), entry: "main".into(), defines: Vec::new() },
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

/// Primary hits, a blurred half-size light buffer, history, a list of work dispatched indirectly; one pass too many, one switched off.
pub(crate) fn showcase() -> Hand {
    let mut hand = Hand::new("showcase");
    hand.graph.about += "first hit, light, history";
    hand.facts = false;
    hand.target("hit", Format::Rg32ui, |_, _| {})
        .target("light", Format::Rgba16f, |target, _| target.extent = Extent::Output { scale: [0.5; 2] })
        .target("blurred", Format::Rgba16f, |target, _| target.extent = Extent::Output { scale: [0.5; 2] })
        .target("probes", Format::Rgba16f, |target, _| target.extent = Extent::Fixed3([32; 3]))
        .target("color", Format::Rgba16f, |target, history| {
            target.clear = Some(Clear::Float([0.0, 0.3, 0.8, 1.0]));
            *history = 1;
        })
        .target("heat", Format::R32f, |_, _| {})
        .buffer("world", BufferSize::Source("world.tree64".to_owned()), None)
        .buffer("tiles", BufferSize::Bytes(4096), Some(0));
    hand.pass("primary", &["r world", "w hit"]);
    hand.pass("gather", &["r hit", "x tiles"]);
    hand.pass("light", &["i tiles", "r tiles", "r world", "r hit", "w light"]);
    hand.pass("emission", &["x light", "w probes"]).when =
        vec![Condition { fact: Fact::WorldHasEmission, negated: false }];
    hand.pass("blur", &["s light", "w blurred"]);
    hand.pass("shade", &["r hit", "s blurred", "s probes", "s color@1", "x color"]);
    hand.pass("heat", &["r hit", "w heat"]);
    hand
}
