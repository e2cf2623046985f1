//! A device under validation, and graphs written in the test that uses them.

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_execute::moment::Moment;
use raxel_execute::{
    Builtins, DeviceMemory, ExecuteError, Executor, ExecutorOptions, ExternalResource, FrameInputs, FrameReport,
    Prepared, Sources, limits,
};
use raxel_gpu::{Device, DeviceOptions, Validation};
use raxel_graph::checked::{Builtin, Fact, Graph, ResourceId};
use raxel_graph::plan::{Observe, Plan, PlanInput, Present, WorldInput};
use raxel_graph::{SourceLayout, plan};
use raxel_graphfile::compile;
use raxel_shader::Compiler;
use raxel_shader::format::Format;
use raxel_shader::interface::{Access, Block, Member, Scalar, Type};

/// A device with an executor. When it is dropped, any message of the validation layer fails the test.
pub(crate) struct Lab {
    pub device: Arc<Device>,
    pub executor: Executor,
    pub sources: Sources,
    pub expect_messages: bool,
}

/// How a graph is planned.
pub(crate) struct Planned<'a> {
    pub output: [u32; 2],
    /// Voxels of the world along each axis.
    pub world: [u32; 3],
    pub present: &'a str,
    pub pinned: &'a [&'a str],
    pub observe: Observe,
    pub alias: bool,
    pub counts: &'a [(raxel_graph::checked::ParamId, u32)],
    pub poison: bool,
}

impl Default for Planned<'_> {
    fn default() -> Self {
        Planned {
            output: [8, 4],
            world: [16; 3],
            present: "color",
            pinned: &[],
            observe: Observe::Shown,
            alias: true,
            poison: false,
            counts: &[],
        }
    }
}

impl Lab {
    pub(crate) fn new() -> Lab {
        Lab::with(ExecutorOptions::default())
    }

    pub(crate) fn with(options: ExecutorOptions) -> Lab {
        let device = Device::new(&DeviceOptions { device: None, validation: Validation::Required });
        let device =
            device.expect("these tests need a Vulkan driver and the validation layer: ./raxel test installs both");
        let executor = Executor::new(device.clone(), options).expect("the device has a command pool");
        Lab { device, executor, sources: Sources::new(), expect_messages: false }
    }

    pub(crate) fn plan(&self, graph: &Arc<Graph>, how: &Planned<'_>) -> Arc<Plan> {
        let find = |name: &str| graph.find_resource(name).unwrap_or_else(|| panic!("no resource `{name}`"));
        let pinned: Vec<ResourceId> = how.pinned.iter().map(|name| find(name)).collect();
        let sizes = self.sources.sizes();
        let facts = |_: &Fact| true;
        let input = PlanInput {
            output: how.output,
            present: present(graph, how.present),
            pinned: &pinned,
            observe: how.observe,
            facts: &facts,
            counts: how.counts,
            sources: &sizes,
            world: WorldInput { extent: how.world, materials: Some(&["air", "stone", "lamp"].map(str::to_owned)) },
            memory: &DeviceMemory(self.device.clone()),
            alias: how.alias,
            poison: how.poison,
            limits: limits(self.device.capabilities()),
        };
        Arc::new(plan(graph.clone(), &input).unwrap_or_else(|errors| panic!("{errors:#?}")))
    }

    /// Supplies a buffer of the graph with bytes, as the source `test.words`.
    pub(crate) fn supply(&mut self, resource: &str, bytes: &[u8]) -> Arc<ExternalResource> {
        let builder = self.executor.builder();
        let buffer = builder.upload_buffer(bytes, "test words").expect("it fits");
        let source = builder.source("test.words", Some(buffer), None);
        self.sources.insert(resource, source.clone());
        source
    }

    pub(crate) fn prepare(&self, plan: &Arc<Plan>) -> Result<Prepared, ExecuteError> {
        self.executor.builder().prepare(plan.clone(), &self.sources)
    }

    /// Compiles, plans, prepares, swaps in.
    pub(crate) fn load(&mut self, files: &[(&str, &str)], how: &Planned<'_>) -> Arc<Plan> {
        let plan = self.plan(&graph(files), how);
        let prepared = self.prepare(&plan).unwrap_or_else(|error| panic!("{error}"));
        self.executor.swap(prepared);
        plan
    }

    pub(crate) fn frame(&mut self) -> FrameReport {
        self.frame_with(&Builtins::default(), &[])
    }

    pub(crate) fn frame_with(&mut self, builtins: &Builtins, params: &[raxel_graph::checked::Value]) -> FrameReport {
        let inputs = FrameInputs { builtins, params, overrides: &[], clock: Moment::START, disabled: &[] };
        self.executor.frame(&inputs).unwrap_or_else(|error| panic!("{error}"))
    }

    pub(crate) fn floats(&mut self, name: &str, age: u32, mip: u32, layer: u32) -> Vec<[f32; 4]> {
        let resource = self.find(name);
        self.executor.read_target(resource, age, mip, layer).unwrap_or_else(|error| panic!("{error}")).floats()
    }

    pub(crate) fn integers(&mut self, name: &str, mip: u32, layer: u32) -> Vec<[u32; 4]> {
        let resource = self.find(name);
        let texels = self.executor.read_target(resource, 0, mip, layer).unwrap_or_else(|error| panic!("{error}"));
        texels.integers().expect("an integer format")
    }

    pub(crate) fn words(&mut self, name: &str) -> Vec<u32> {
        let resource = self.find(name);
        let plan = self.executor.plan().expect("a plan runs").clone();
        let size = plan
            .resources
            .iter()
            .find(|r| r.resource == resource)
            .map(|r| match &r.desc {
                raxel_graph::plan::ResourceDesc::Buffer(desc) => desc.size,
                other => panic!("{other:?} is not a buffer"),
            })
            .expect("the buffer is live");
        let bytes = self.executor.read_buffer(resource, 0, 0..size).unwrap_or_else(|error| panic!("{error}"));
        bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect()
    }

    pub(crate) fn find(&self, name: &str) -> ResourceId {
        let plan = self.executor.plan().expect("a plan runs");
        plan.graph.find_resource(name).unwrap_or_else(|| panic!("no resource `{name}`"))
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        if self.expect_messages || std::thread::panicking() || self.device.is_lost() {
            return;
        }
        self.executor.wait().unwrap_or_else(|error| panic!("{error}"));
        let messages = self.device.log().take();
        assert!(messages.is_empty(), "the validation layer says: {messages:#?}");
    }
}

/// Compiles `graphs/test.toml` of the given files, with the source `test.words`: an array of `uint`, and an `r16ui` image.
pub(crate) fn graph(files: &[(&str, &str)]) -> Arc<Graph> {
    graph_with(files, Access::Read)
}

/// The same, with what passes may do with the source.
pub(crate) fn graph_with(files: &[(&str, &str)], access: Access) -> Arc<Graph> {
    let files = Arc::new(MemoryFiles::new(files.iter().copied()));
    let element = Box::new(Type::Scalar(Scalar::U32));
    let words =
        Member { name: "words".to_owned(), offset: 0, ty: Type::Array { element, len: None, stride: 4 }, place: None };
    let block = Block { name: "Words".to_owned(), size: 0, members: vec![words] };
    let name = "test.words".to_owned();
    let sources = vec![SourceLayout { name, block, image: Some(Format::R16ui), access, collected: None }];
    let mut texts = SourceMap::default();
    let compiler = Compiler::new(files.clone());
    match compile("graphs/test.toml", &*files, &compiler, &sources, &mut texts) {
        Ok((graph, _)) => Arc::new(graph),
        Err(errors) => panic!("{errors:#?}"),
    }
}

/// `name`, `name@age` or `name:layer`.
fn present(graph: &Graph, text: &str) -> Present {
    let number = |text: &str| text.parse().expect("a number");
    let (name, age) = text.split_once('@').map_or((text, 0), |(name, age)| (name, number(age)));
    let (name, layer) = name.split_once(':').map_or((name, 0), |(name, layer)| (name, number(layer)));
    let resource = graph.find_resource(name).unwrap_or_else(|| panic!("no resource `{name}`"));
    Present { resource, age, mip: 0, layer, after: None, round: None }
}

/// `frame.index` and `frame.time` as a session would set them.
pub(crate) fn at(frame: u32) -> Builtins {
    let builtins = Builtins { frame_index: frame, frame_time: frame as f32, ..Builtins::default() };
    assert_eq!(builtins.value(Builtin::FrameIndex), raxel_graph::checked::Value::U32(frame));
    builtins
}
