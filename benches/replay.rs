//! CPU time of a frame of 30 passes: our own share with nothing behind it, with a device behind it, and the same chain of dispatches
//! recorded with the crate `vk-graph`. Needs a Vulkan driver: `cargo bench --bench replay`.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a bench")]
#![allow(clippy::format_push_string, reason = "files are put together as they read")]

use std::collections::BTreeMap;
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_execute::moment::Moment;
use raxel_execute::{
    Builtins, DeviceMemory, Executor, ExecutorOptions, FrameInputs, Recorder, Replay, Sources, limits,
};
use raxel_gpu::{Device, DeviceOptions};
use raxel_graph::plan::{Plan, PlanInput};
use raxel_shader::Compiler;
use vk_graph::driver::ash::vk;
use vk_graph::driver::compute::{ComputePipeline, ComputePipelineInfo};
use vk_graph::driver::device::DeviceInfo;
use vk_graph::driver::image::{Image, ImageInfo};
use vk_graph::driver::shader::Shader;
use vk_graph::driver::sync::AccessType;

const PASSES: usize = 30;
const EXTENT: u32 = 8;

const LINK: &str = "#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) readonly uniform image2D before;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D after;
layout(push_constant) uniform Push { float add; float time; } push;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    imageStore(after, p, imageLoad(before, p) * 0.5 + push.add + push.time);
}";

/// Targets `t0` to `t30`; pass i reads target i and writes target i + 1.
fn graph_file() -> String {
    let mut toml = format!("name = \"chain\"\npresent = \"t{PASSES}\"\n");
    for i in 0..=PASSES {
        toml += &format!(
            "[targets.t{i}]\nformat = \"rgba32f\"\nsize = [{EXTENT}, {EXTENT}]\ninit = [0.0, 0.0, 0.0, 0.0]\n"
        );
    }
    for i in 0..PASSES {
        toml += &format!(
            "[[passes]]\nname = \"p{i}\"\nshader = \"link.comp\"\ndispatch = {{ threads = \"t{i}\" }}\n\
             bind = {{ before = \"t{i}\", after = \"t{}\" }}\n\
             [passes.push]\nadd = {{ type = \"f32\", value = 1.0 }}\ntime = {{ type = \"f32\", from = \"frame.time\" }}\n",
            i + 1
        );
    }
    toml
}

fn plan(device: &Arc<Device>) -> Arc<Plan> {
    let files = Arc::new(MemoryFiles::new([("graphs/chain.toml", graph_file().as_str()), ("shaders/link.comp", LINK)]));
    let compiler = Compiler::new(files.clone());
    let mut texts = SourceMap::default();
    let (graph, _) = raxel_graphfile::compile("graphs/chain.toml", &*files, &compiler, &Vec::new(), &mut texts)
        .unwrap_or_else(|errors| panic!("{errors:#?}"));
    let (sources, memory) = (BTreeMap::new(), DeviceMemory(device.clone()));
    let paper = PlanInput::on_paper(&graph, [EXTENT, EXTENT], &sources);
    let input = PlanInput { memory: &memory, limits: limits(device.capabilities()), ..paper };
    let plan = raxel_graph::plan(Arc::new(graph), &input).unwrap_or_else(|errors| panic!("{errors:#?}"));
    assert_eq!(plan.passes.len(), PASSES);
    Arc::new(plan)
}

/// An executor with the plan swapped in.
fn executor(device: &Arc<Device>, timings: bool, markers: bool) -> Executor {
    let options = ExecutorOptions { timings, markers, ..ExecutorOptions::default() };
    let mut executor = Executor::new(device.clone(), options).expect("a command pool");
    let prepared = executor.builder().prepare(plan(device), &Sources::new()).expect("it suits the device");
    executor.swap(prepared);
    executor
}

/// Wall time of a frame until the device has finished it: what times and crash markers cost the device.
fn finished_time(c: &mut Criterion, device: &Arc<Device>) {
    let mut group = c.benchmark_group("30 passes, finished by the device");
    for (name, timings, markers) in [
        ("plain", false, false),
        ("timings", true, false),
        ("markers", false, true),
        ("timings and markers", true, true),
    ] {
        let mut executor = executor(device, timings, markers);
        let mut builtins = Builtins::default();
        group.bench_function(name, |b| {
            b.iter(|| {
                builtins.frame_time += 1.0;
                executor.frame(&inputs(&builtins)).expect("it runs");
                executor.wait().expect("the device finishes");
            });
        });
    }
    group.finish();
}

/// A recorder with nothing behind it: what is left is our own work.
#[derive(Default)]
struct Null {
    calls: u64,
}

impl Recorder for Null {
    fn uniforms(&mut self, bytes: &[u8]) {
        self.calls += black_box(bytes).len() as u64;
    }
    fn barrier(&mut self, step: usize) {
        self.calls += black_box(step) as u64;
    }
    fn clear(&mut self, _: usize, resource: usize) {
        self.calls += black_box(resource) as u64;
    }
    fn copy(&mut self, resource: usize) {
        self.calls += black_box(resource) as u64;
    }
    fn bind(&mut self, pass: usize) {
        self.calls += black_box(pass) as u64;
    }
    fn push(&mut self, _: usize, bytes: &[u8]) {
        self.calls += black_box(bytes).len() as u64;
    }
    fn dispatch(&mut self, pass: usize) {
        self.calls += black_box(pass) as u64;
    }
    fn present(&mut self) {
        self.calls += 1;
    }
}

fn inputs(builtins: &Builtins) -> FrameInputs<'_> {
    FrameInputs { builtins, params: &[], overrides: &[], clock: Moment::START, disabled: &[] }
}

fn own_time(c: &mut Criterion, device: &Arc<Device>) {
    let plan = plan(device);
    let mut group = c.benchmark_group("30 passes");
    for (name, memo, moving) in
        [("raxel, no memo", false, true), ("raxel, all passes rerun", true, true), ("raxel, still frame", true, false)]
    {
        let mut replay = Replay::new(&plan, 0);
        replay.set_memo(memo);
        let mut builtins = Builtins::default();
        let mut frame = 0;
        group.bench_function(name, |b| {
            b.iter(|| {
                builtins.frame_time += if moving { 1.0 } else { 0.0 };
                replay.decide(frame, &inputs(&builtins));
                frame += 1;
                let mut recorder = Null::default();
                let counts = replay.walk(&mut recorder);
                black_box(recorder.calls);
                assert!(counts.dispatched == PASSES as u32 || !moving);
            });
        });
    }
    group.finish();
}

fn recorded_time(c: &mut Criterion, device: &Arc<Device>) {
    let mut executor = executor(device, false, false);
    let mut builtins = Builtins::default();
    let mut group = c.benchmark_group("30 passes, recorded and submitted");
    group.bench_function("raxel", |b| {
        b.iter_custom(|frames| {
            let mut nanoseconds = 0;
            for _ in 0..frames {
                builtins.frame_time += 1.0;
                nanoseconds += executor.frame(&inputs(&builtins)).expect("it runs").cpu_nanoseconds;
                executor.wait().expect("the device finishes");
            }
            Duration::from_nanos(nanoseconds)
        });
    });

    let spirv = {
        let files = Arc::new(MemoryFiles::new([("shaders/link.comp", LINK)]));
        let request = raxel_shader::Request {
            path: "shaders/link.comp".to_owned(),
            entry: "main".to_owned(),
            defines: Vec::new(),
        };
        let shader = raxel_shader::ShaderProvider::shader(&Compiler::new(files), &request, &mut SourceMap::default());
        shader.unwrap_or_else(|errors| panic!("{errors:#?}")).0.spirv.clone()
    };
    let device = vk_graph::driver::device::Device::create(DeviceInfo::default()).expect("the same driver");
    let shader = Shader::new_compute(&*spirv);
    let pipeline = ComputePipeline::create(&device, ComputePipelineInfo::default(), shader).expect("the same shader");
    let usage = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_DST;
    let info = ImageInfo::image_2d(EXTENT, EXTENT, vk::Format::R32G32B32A32_SFLOAT, usage);
    let images: Vec<Arc<Image>> =
        (0..=PASSES).map(|_| Arc::new(Image::create(&device, info).expect("the same image"))).collect();
    let mut pool = vk_graph::pool::hash::HashPool::new(&device);
    let mut time = 0.0f32;
    group.bench_function("vk-graph", |b| {
        b.iter_custom(|frames| {
            let mut total = Duration::ZERO;
            for _ in 0..frames {
                time += 1.0;
                let start = Instant::now();
                let mut graph = vk_graph::Graph::new();
                let nodes: Vec<_> = images.iter().map(|image| graph.bind_resource(image)).collect();
                for pair in nodes.windows(2) {
                    let push = [1.0, time];
                    graph
                        .begin_cmd()
                        .bind_pipeline(&pipeline)
                        .shader_resource_access(0, pair[0], AccessType::ComputeShaderReadOther)
                        .shader_resource_access(1, pair[1], AccessType::ComputeShaderWrite)
                        .record_cmd(move |cmd| {
                            cmd.push_constants(0, bytemuck::bytes_of(&push)).dispatch(1, 1, 1);
                        });
                }
                let mut fence = graph.finalize().queue_submit(&mut pool, 0, 0).expect("it runs");
                total += start.elapsed();
                fence.wait().expect("the device finishes");
            }
            total
        });
    });
    group.finish();
}

fn replay(c: &mut Criterion) {
    let device = Device::new(&DeviceOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    own_time(c, &device);
    finished_time(c, &device);
    recorded_time(c, &device);
}

criterion_group!(benches, replay);
criterion_main!(benches);
