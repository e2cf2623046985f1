//! The GLSL tracers of every layout on a device, against the exact tracer: what they hit must be equal, ties included.

use std::path::Path;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::IVec3;
use raxel_diagnostics::{DiskFiles, SourceMap};
use raxel_gpu::{
    Backing, Buffer, BufferInfo, CommandBuffer, ComputePipeline, Descriptors, Device, DeviceOptions, Location,
    PipelineInfo, Resource, Slot, Validation, download_buffer, upload, vk,
};
use raxel_oracle::metrics::Errors;
use raxel_oracle::port::Tree64;
use raxel_oracle::scenes::{self, Scene};
use raxel_oracle::{Hit, Ray, exact, sets};
use raxel_shader::interface::BindingKind;
use raxel_shader::{Compiler, Request, Shader, ShaderSource};
use raxel_world::World;
use raxel_world::layout::Layout;
use rayon::prelude::*;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct RayWords {
    cell: [i32; 3],
    t_max: f32,
    frac: [f32; 4],
    dir: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct HitWords {
    voxel: [i32; 3],
    found: u32,
    face: u32,
    material: u32,
    looked_up: u32,
    t: f32,
    uv: [f32; 2],
    steps: u32,
    unused: u32,
}

/// The tracer of one layout on the device.
struct Tracer {
    device: Arc<Device>,
    shader: Arc<Shader>,
    pipeline: ComputePipeline,
    layout: Layout,
}

fn open() -> Arc<Device> {
    Device::new(&DeviceOptions { device: None, validation: Validation::Required })
        .expect("a Vulkan device with the validation layer: mesa-vulkan-drivers and vulkan-validationlayers")
}

impl Tracer {
    fn new(device: &Arc<Device>, layout: Layout) -> Self {
        let files = DiskFiles::new(Path::new(env!("CARGO_MANIFEST_DIR"))).expect("the repository");
        let request = Request {
            path: "tests/shaders/trace_rays.comp".into(),
            entry: "main".into(),
            defines: vec![(format!("RX_LAYOUT_{}", layout.name().to_uppercase()), "1".into())],
        };
        let (shader, warnings) =
            Compiler::new(Arc::new(files)).shader(&request, &mut SourceMap::default()).expect("the shader compiles");
        assert_eq!(warnings, []);
        let slots: Vec<Slot> = shader
            .interface
            .bindings
            .iter()
            .map(|b| Slot { set: b.set, binding: b.binding, ty: vk::DescriptorType::STORAGE_BUFFER, count: 1 })
            .collect();
        let info =
            PipelineInfo { spirv: &shader.spirv, entry: "main", slots: &slots, push_bytes: 0, specialization: &[] };
        let pipeline = ComputePipeline::new(device, layout.name(), &info).expect("a pipeline");
        Self { device: device.clone(), shader, pipeline, layout }
    }

    /// Traces rays through a world.
    fn trace(&self, world: &World, rays: &[Ray]) -> Vec<HitWords> {
        let limit = u64::from(self.device.capabilities().limits.max_storage_buffer_range);
        let encoded = self.layout.encode(world, limit).expect("a small world");
        let words: Vec<RayWords> = rays
            .iter()
            .map(|ray| RayWords {
                cell: ray.cell,
                t_max: ray.t_max,
                frac: [ray.frac[0], ray.frac[1], ray.frac[2], 0.0],
                dir: [ray.dir[0], ray.dir[1], ray.dir[2], 0.0],
            })
            .collect();
        let put = |name, bytes| Arc::new(upload(&self.device, name, bytes, None).expect("an upload"));
        let world = put("world", bytemuck::cast_slice(&encoded.words));
        let rays = put("rays", bytemuck::cast_slice(&words));
        let size = (words.len() * size_of::<HitWords>()) as u64;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
        let info = BufferInfo { size, usage, location: Location::Device };
        let hits = Arc::new(Buffer::new(&self.device, "hits", &info, Backing::Own).expect("a buffer"));
        let resources: Vec<Vec<Resource>> = self
            .shader
            .interface
            .bindings
            .iter()
            .map(|binding| {
                assert!(matches!(binding.kind, BindingKind::StorageBuffer(_)));
                let buffer = match binding.name.as_str() {
                    "world" => &world,
                    "Rays" => &rays,
                    "Hits" => &hits,
                    other => panic!("unknown binding {other}"),
                };
                vec![Resource::Buffer(buffer.clone(), 0, buffer.size())]
            })
            .collect();
        let descriptors = Descriptors::new(&self.device, "trace", &self.pipeline, &resources).expect("descriptors");
        let mut commands = CommandBuffer::new(&self.device, "trace").expect("commands");
        commands.begin().expect("recording");
        commands.bind(&self.pipeline, &descriptors);
        commands.dispatch([(words.len() as u32).div_ceil(64), 1, 1]);
        let moment = commands.submit().expect("a submission");
        self.device.wait(moment, None).expect("the dispatch ends");
        let bytes = download_buffer(&self.device, &hits, 0, size, None).expect("a download");
        bytes.chunks_exact(size_of::<HitWords>()).map(bytemuck::pod_read_unaligned).collect()
    }
}

impl HitWords {
    fn hit(&self) -> Option<Hit> {
        let Self { voxel, face, material, t, uv, steps, .. } = *self;
        (self.found != 0).then_some(Hit { voxel, face, material, t, uv, steps })
    }
}

/// Compares a layout with the exact tracer in all sets and scenes.
fn conforms(layout: Layout, rays_a_set: usize) {
    let device = open();
    let tracer = Tracer::new(&device, layout);
    let mut all = 0;
    for (number, scene) in scenes::ALL.iter().enumerate() {
        // Every other scene lies far from the origin.
        let corner =
            if number % 2 == 0 { IVec3::new(-13, 5, -40) } else { IVec3::new(1 << 30, i32::MIN + 64, -(1 << 24)) };
        let world = scene.world(corner, 3);
        let buffer = Layout::Tree64.encode(&world, u64::MAX).expect("a small world").words;
        let rays: Vec<(&str, Ray)> = sets::ALL
            .iter()
            .flat_map(|s| s.rays(&world, rays_a_set, 77).into_iter().map(|ray| (s.name, ray)))
            .collect();
        let plain: Vec<Ray> = rays.iter().map(|(_, ray)| *ray).collect();
        let found = tracer.trace(&world, &plain);
        let errors: Errors = rays
            .par_iter()
            .zip(&found)
            .map(|((set, ray), words)| {
                let mut errors = Errors::default();
                let (answer, hit) = (exact::first_hit(&world, ray), words.hit());
                errors.add(ray, &answer, hit.as_ref());
                assert_eq!(errors.wrong(), 0, "{} {set} {ray:?}\nexact {answer:?}\nfound {hit:?}", scene.name);
                if let Some(hit) = hit {
                    assert_eq!(words.looked_up, hit.material, "{} {set} {ray:?}", scene.name);
                    // The port finds the same place on the face, but for the rounding of one division.
                    let port = Tree64::new(&buffer).trace(ray).expect("the port hits what the device hits");
                    let off = [0, 1].map(|i| (port.uv[i] - hit.uv[i]).abs());
                    assert!(off.iter().all(|off| *off < 1e-6), "{} {set} {ray:?}\n{port:?}\n{hit:?}", scene.name);
                }
                errors
            })
            .reduce(Errors::default, Errors::and);
        assert!(errors.hits * 10 > errors.rays || scene.name == "corners" || scene.name == "sparse", "{errors:?}");
        assert!(errors.t_error < 1e-5, "{}: t is off by {}", scene.name, errors.t_error);
        all += errors.rays;
    }
    assert!(all >= 90 * rays_a_set as u64);
    drop(tracer);
    assert_eq!(device.log().take(), [], "the validation layer is silent");
}

#[test]
fn tree64_hits_what_the_oracle_hits() {
    conforms(Layout::Tree64, 3000);
}

#[test]
fn chunks_hits_what_the_oracle_hits() {
    conforms(Layout::Chunks, 500);
}

#[test]
fn bvh_hits_what_the_oracle_hits() {
    conforms(Layout::Bvh, 1000);
}

#[test]
fn chunk_table_hits_what_the_oracle_hits() {
    conforms(Layout::ChunkTable, 500);
}

#[test]
fn brickmap_hits_what_the_oracle_hits() {
    conforms(Layout::Brickmap, 500);
}

#[test]
fn octree_hits_what_the_oracle_hits() {
    conforms(Layout::Octree, 500);
}

#[test]
fn svo_hits_what_the_oracle_hits() {
    conforms(Layout::Svo, 500);
}

#[test]
fn svdag_hits_what_the_oracle_hits() {
    conforms(Layout::Svdag, 500);
}

/// Pieces half a million voxels apart, with nothing between them but what a layout can skip.
#[test]
fn rays_cross_wide_empty_space() {
    let device = open();
    let mut voxels = Vec::new();
    for (piece, material) in [(IVec3::new(-260_000, 40, 7), 1), (IVec3::new(270_000, -3000, 199), 2)] {
        for i in 0..27 * 27 {
            voxels.push((piece + IVec3::new(i % 3, i / 3 % 27, i / 81), material));
        }
    }
    let world = World::from_voxels(scenes::materials(), voxels);
    let across = |i: i32| {
        let from = [-259_990, 40 + i % 27, 7 + i / 27 % 9];
        let to = [270_000, -3000 + i * 7 % 30, 199 + i * 5 % 12];
        Ray::new(from, [0.5, 0.25, 0.75], [0, 1, 2].map(|a| (to[a] - from[a]) as f32))
    };
    let rays: Vec<Ray> = (0..400).map(across).collect();
    // The layout `chunks` would take 17,000 steps of a linear search.
    for &layout in Layout::ALL.iter().filter(|layout| **layout != Layout::Chunks) {
        let mut errors = Errors::default();
        for (ray, words) in rays.iter().zip(Tracer::new(&device, layout).trace(&world, &rays)) {
            errors.add(ray, &exact::first_hit(&world, ray), words.hit().as_ref());
            assert_eq!(errors.wrong(), 0, "{} {ray:?} {words:?}", layout.name());
            assert!(words.found == 0 || words.steps < 400, "{}: {} steps", layout.name(), words.steps);
        }
        assert!(errors.hits > 100, "{}: {errors:?}", layout.name());
    }
}

/// Rays that begin in every voxel of boxes of 1, 2, 4, … 4096 materials hit the material that is there.
#[test]
fn voxels_are_of_their_materials() {
    let device = open();
    let materials = vec![raxel_world::Material::matt("any", [0.5; 3]); 4097];
    let mut voxels = Vec::new();
    for (slab, count) in (0..).zip([1, 2, 4, 16, 17, 256, 257, 4096]) {
        for i in 0..16 * 20 * 30 {
            let cell = IVec3::new(16 * slab + i % 16 - 70, i / 16 % 20 + 5, i / 320 - 9);
            voxels.push((cell, 1 + (i * 7 % count) as u16));
        }
    }
    let world = World::from_voxels(materials, voxels.iter().copied());
    let rays: Vec<Ray> = voxels.iter().map(|(cell, _)| Ray::new(cell.to_array(), [0.5; 3], [1.0, 0.0, 0.0])).collect();
    for &layout in Layout::ALL {
        for ((cell, material), words) in voxels.iter().zip(Tracer::new(&device, layout).trace(&world, &rays)) {
            let found = [words.found, words.material, words.looked_up];
            assert_eq!(found, [1, u32::from(*material), u32::from(*material)], "{} {cell}", layout.name());
        }
    }
}

#[test]
fn rays_end_at_t_max() {
    let device = open();
    let world = Scene::find("hills").expect("a scene").world(IVec3::ZERO, 1);
    let rays = sets::RaySet::find("pinhole").expect("a set").rays(&world, 2000, 5);
    for &layout in Layout::ALL {
        let tracer = Tracer::new(&device, layout);
        let free = tracer.trace(&world, &rays);
        let reached: Vec<(Ray, f32)> =
            rays.iter().zip(&free).filter(|(_, hit)| hit.found != 0).map(|(r, h)| (*r, h.t)).collect();
        assert!(reached.len() > 300);
        for (factor, hits) in [(0.999, false), (1.001, true)] {
            let cut: Vec<Ray> = reached.iter().map(|(ray, t)| Ray { t_max: t * factor, ..*ray }).collect();
            assert!(
                tracer.trace(&world, &cut).iter().all(|hit| (hit.found != 0) == hits),
                "{} {factor}",
                layout.name()
            );
        }
    }
}
