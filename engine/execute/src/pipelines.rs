//! Compute pipelines and samplers, kept for as long as a plan may ask for them again.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use raxel_gpu::{ComputePipeline, DescriptorSlot, Device, DeviceKind, PipelineInfo, Sampler, Sampling, vk};
use raxel_graph::checked::{Pass, Value};
use raxel_graph::plan::{PassPlan, Plan};
use raxel_shader::Shader;
use raxel_shader::interface::BindingKind;
use raxel_spirv::Module;

use super::display::{self, Variant};
use super::error::ExecuteError;
use super::making::{Compiling, Making, tell};
use super::retained::Retained;
use super::shared::lock;
use super::values;

/// The driver's inputs: module, specialization and the requested size of subgroups.
pub(super) type PipelineKey = ([u8; 32], Vec<(u32, u32)>, Option<u32>);

/// Bytes of pipelines that no plan uses: some ten edits of a shader that holds a whole tracer.
const BUDGET: u64 = 32 << 20;

/// Memory of the driver for a byte of SPIR-V, its own structures included. Measured on lavapipe, whose compiled tracers take the most: 6
/// MiB of SPIR-V kept by `raxel bench reload graphs/inspect.toml --edits 300` took 300 MiB.
const BYTES_PER_SPIRV_BYTE: u64 = 48;

/// Objects of a device that depend neither on sizes nor on resources.
pub(super) struct Pipelines {
    passes: Mutex<Retained<PipelineKey, ComputePipeline>>,
    displays: Mutex<HashMap<Variant, Arc<ComputePipeline>>>,
    samplers: Mutex<HashMap<Sampling, Arc<Sampler>>>,
    making: Making,
}

impl Pipelines {
    pub(super) fn new() -> Self {
        Self {
            passes: Mutex::new(Retained::new(BUDGET)),
            displays: Mutex::default(),
            samplers: Mutex::default(),
            making: Making::default(),
        }
    }

    /// The pipeline that the driver has worked on longest, if it has for a second.
    pub(super) fn compiling(&self) -> Option<Compiling> {
        self.making.longest()
    }

    /// A plan was swapped in: pipelines that no plan uses any more are kept to the budget.
    pub(super) fn swapped(&self) {
        lock(&self.passes).swapped();
    }

    /// A sampler.
    pub(super) fn sampler(&self, device: &Arc<Device>, sampling: Sampling) -> Result<Arc<Sampler>, ExecuteError> {
        let mut samplers = lock(&self.samplers);
        if let Some(sampler) = samplers.get(&sampling) {
            return Ok(sampler.clone());
        }
        let sampler = Arc::new(Sampler::new(device, sampling)?);
        samplers.insert(sampling, sampler.clone());
        Ok(sampler)
    }

    /// Says which pipelines of a plan there are already: from an earlier plan, or of another pass of this one.
    pub(super) fn tell_reused(&self, plan: &Plan) {
        let mut users: HashMap<PipelineKey, &str> = HashMap::new();
        let retained = lock(&self.passes);
        for planned in &plan.passes {
            let (pass, key) = keyed(plan, planned);
            if retained.has(&key) {
                tracing::debug!("kept the pipeline of pass `{}`", pass.name);
                continue;
            }
            match users.entry(key) {
                Entry::Occupied(user) => {
                    tracing::debug!("pass `{}` shares the pipeline of pass `{}`", pass.name, user.get());
                }
                Entry::Vacant(first) => {
                    first.insert(&pass.name);
                }
            }
        }
    }

    /// The pipelines of a plan that can be made, in no order. Passes whose modules and constants are equal share one, even if the modules
    /// come from different texts; the driver compiles several at a time.
    pub(super) fn of_plan(&self, device: &Arc<Device>, plan: &Plan) -> Vec<Arc<ComputePipeline>> {
        let mut seen = HashSet::new();
        let passes: Vec<(&Pass, PipelineKey)> = (plan.passes.iter())
            .map(|planned| keyed(plan, planned))
            .filter(|(_, key)| seen.insert(key.clone()))
            .collect();
        let known = {
            let retained = lock(&self.passes);
            passes.iter().filter(|(_, key)| retained.has(key)).count()
        };
        let unknown = passes.len() - known;
        let batch = self.making.batch(unknown);
        let next = AtomicUsize::new(0);
        let work = || {
            let mut made = Vec::new();
            while let Some((pass, key)) = passes.get(next.fetch_add(1, Ordering::Relaxed)) {
                let there = lock(&self.passes).get(key);
                if there.is_some() {
                    made.extend(there);
                    continue;
                }
                // A pass whose pipeline cannot be made asks for it by itself, and gets the error.
                made.extend(self.of_key(device, pass, key).ok());
                batch.done();
            }
            made
        };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        std::thread::scope(|scope| {
            let _ending = batch.until_dropped();
            if unknown > 0 {
                scope.spawn(|| {
                    self.making.watch(&batch, |compiling| tell(&format!("pass `{}`", compiling.pass), compiling));
                });
            }
            let others: Vec<_> = (1..cores.min(unknown)).map(|_| scope.spawn(work)).collect();
            let mut made = work();
            // Pipelines that a panicking thread did not make are left to the pass that asks for them.
            made.extend(others.into_iter().filter_map(|other| other.join().ok()).flatten());
            made
        })
    }

    /// The pipeline of a pass.
    pub(super) fn of_pass(
        &self,
        device: &Arc<Device>,
        pass: &Pass,
        specialization: &[(u32, Value)],
    ) -> Result<Arc<ComputePipeline>, ExecuteError> {
        self.of_key(device, pass, &key(pass, specialization))
    }

    fn of_key(
        &self,
        device: &Arc<Device>,
        pass: &Pass,
        key: &PipelineKey,
    ) -> Result<Arc<ComputePipeline>, ExecuteError> {
        if let Some(pipeline) = lock(&self.passes).get(key) {
            return Ok(pipeline);
        }
        let start = Instant::now();
        let _span = tracing::debug_span!("make pipeline", pass = pass.name.as_str()).entered();
        let begun = self.making.begin(&pass.name);
        let made = make_pipeline(device, &pass.name, &pass.shader, (&key.1, key.2));
        drop(begun);
        let pipeline = Arc::new(made.map_err(|error| match error {
            raxel_gpu::Error::CapabilityMissing { lacks, .. } => {
                ExecuteError::Capability { pass: pass.name.clone(), lacks: format!("`{lacks}`") }
            }
            error => error.into(),
        })?);
        tracing::debug!("made the pipeline of pass `{}` in {:.0} ms", pass.name, start.elapsed().as_secs_f64() * 1e3);
        let bytes = 4 * pass.shader.spirv.len() as u64 * BYTES_PER_SPIRV_BYTE;
        lock(&self.passes).insert(key.clone(), pipeline.clone(), bytes);
        Ok(pipeline)
    }

    /// The pipeline that shows a debug target.
    pub(super) fn display(&self, device: &Arc<Device>, variant: Variant) -> Result<Arc<ComputePipeline>, ExecuteError> {
        if let Some(pipeline) = lock(&self.displays).get(&variant) {
            return Ok(pipeline.clone());
        }
        let shader = display::compile(variant)?;
        let pipeline = Arc::new(make_pipeline(device, "display", &shader, (&[], None))?);
        lock(&self.displays).insert(variant, pipeline.clone());
        Ok(pipeline)
    }
}

/// A pass of a plan with the key of its pipeline.
fn keyed<'p>(plan: &'p Plan, planned: &PassPlan) -> (&'p Pass, PipelineKey) {
    let pass = plan.graph.pass(planned.pass);
    (pass, key(pass, &planned.specialization))
}

/// Equal keys, equal pipelines.
pub(super) fn key(pass: &Pass, specialization: &[(u32, Value)]) -> PipelineKey {
    let constants = specialization.iter().map(|(id, value)| (*id, values::specialization(value))).collect();
    (pass.shader.module, constants, pass.subgroup_size)
}

fn make_pipeline(
    device: &Arc<Device>,
    name: &str,
    shader: &Shader,
    (specialization, subgroup_size): (&[(u32, u32)], Option<u32>),
) -> raxel_gpu::Result<ComputePipeline> {
    let slots: Vec<DescriptorSlot> = shader
        .interface
        .bindings
        .iter()
        .filter_map(|binding| {
            let ty = match binding.kind {
                BindingKind::StorageImage { .. } => vk::DescriptorType::STORAGE_IMAGE,
                BindingKind::SampledImage { .. } => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
                BindingKind::StorageBuffer(_) => vk::DescriptorType::STORAGE_BUFFER,
                BindingKind::UniformBuffer(_) => vk::DescriptorType::UNIFORM_BUFFER,
                BindingKind::Unsupported(_) => return None,
            };
            Some(DescriptorSlot { set: binding.set, binding: binding.binding, ty, count: binding.count.max(1) })
        })
        .chain(shader.interface.prints.iter().map(|prints| DescriptorSlot {
            set: 0,
            binding: prints.binding,
            ty: vk::DescriptorType::STORAGE_BUFFER,
            count: 1,
        }))
        .collect();
    let opaque = if device.capabilities().kind == DeviceKind::Cpu { opaque(shader) } else { None };
    let info = PipelineInfo {
        spirv: opaque.as_deref().unwrap_or(&shader.spirv),
        entry: &shader.interface.entry,
        slots: &slots,
        push_bytes: shader.interface.push.as_ref().map_or(0, |block| block.size),
        specialization,
        subgroup_size,
    };
    ComputePipeline::new(device, name, &info)
}

/// The module for a software device. lavapipe would compile it again at each dispatch, for the values that its blocks have then.
fn opaque(shader: &Shader) -> Option<Vec<u32>> {
    Module::new(&shader.spirv, &shader.interface.entry).ok()?.with_opaque_uniforms()
}
