//! The view of the debug target: the shown part of it, and the reference that it is compared with.

use std::sync::Arc;

use raxel_gpu::{
    Backing, Barrier, Buffer, BufferInfo, ComputePipeline, Descriptors, Device, Location, Recording, Resource,
    Sampling, vk,
};
use raxel_graph::checked::{Display, Interval, ResourceKind};
use raxel_graph::plan::{CopySelector, Lifetime, Present, ResourceDesc, Step};
use raxel_shader::interface::ScalarKind;

use super::display::{self, Push, SourceKind};
use super::error::ExecuteError;
use super::executor::Executor;
use super::physical;
use super::prepare::{Builder, Prepared, PreparedDisplay};
use super::report::Texels;
use super::rotations::copy_of;
use super::shared::Shared;

/// A part of the debug target that fills the picture, as shares of its extent along each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Its top left corner: 0 to 1 - [`Self::size`].
    pub origin: [f64; 2],
    /// Its width and its height, above 0 and at most 1.
    pub size: f64,
}

impl Region {
    /// All of it.
    pub const WHOLE: Region = Region { origin: [0.0; 2], size: 1.0 };
}

/// The type of the numbers of a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReferenceValues {
    /// Floats, in the unit of the debug target.
    Floats,
    /// Integers.
    Integers,
    /// Colours as a screen shows them: 0 to 1, sRGB-encoded.
    Displayed,
}

/// A picture on the device that the debug target is compared with.
pub struct Reference {
    pub(super) buffer: Arc<Buffer>,
    pub(super) extent: [u32; 2],
    pub(super) channels: u32,
    pub(super) values: ReferenceValues,
}

impl Reference {
    /// Its extent in texels.
    pub fn extent(&self) -> [u32; 2] {
        self.extent
    }
}

/// How the debug target and a reference are shown together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Comparison {
    /// The debug target left of an edge, the reference right of it. The edge is a share of the picture's width.
    Wipe(f64),
    /// The reference alone.
    Reference,
    /// The debug target minus the reference, times this.
    Difference(f32),
}

/// Why the debug target cannot be compared with a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Mismatch {
    /// They have different extents.
    #[error("the shown target is {}×{}, the kept picture {}×{}", shown[0], shown[1], kept[0], kept[1])]
    Extent {
        /// Of the shown target, in texels.
        shown: [u32; 2],
        /// Of the kept picture, in texels.
        kept: [u32; 2],
    },
    /// One holds floats, the other integers.
    #[error("the shown target and the kept picture do not both hold floats, or both integers")]
    Values,
    /// A buffer is shown.
    #[error("a buffer cannot be compared with a picture")]
    Buffer,
    /// The debug target is shown within a frame, where a live target has not its last contents yet.
    #[error("the shown target is taken within the frame, but a live target has its contents only at its end")]
    Early,
    /// The live target is not in the plan, or the device has no room for a copy of it.
    #[error("the live target has no contents that can be compared")]
    Absent,
}

/// How the debug target is shown, instead of the graph's way.
pub(super) struct Lens {
    display: Option<Display>,
    region: Region,
    compared: Option<Compared>,
    /// A target of the running graph that is compared with, instead of a reference from elsewhere.
    live: Option<(Present, Comparison)>,
    /// Why it cannot be.
    refused: Option<Mismatch>,
    /// The number of changes of the view, and of requested copies: the memo's knowledge of the picture is stale after each.
    changes: u64,
}

/// The reference of the debug target.
struct Compared {
    reference: Arc<Reference>,
    comparison: Comparison,
    /// Of the running plan, once a frame needs them.
    sets: Option<Vec<Descriptors>>,
    /// The step that fills the reference in each frame, if it is a live target.
    filler: Option<Filler>,
}

/// Copies a target of the running plan to a reference, before the debug target is shown.
pub(super) struct Filler {
    /// Index of the target into the plan's resources.
    resource: usize,
    /// Selects its current copy.
    selector: CopySelector,
    age: u32,
    pipeline: Arc<ComputePipeline>,
    /// For each copy of the target.
    sets: Vec<Descriptors>,
    push: Push,
    groups: [u32; 3],
}

/// The inputs of the shader that shows the debug target.
pub(super) struct Look<'a> {
    pub(super) push: Push,
    /// For each copy of the debug target.
    pub(super) sets: &'a [Descriptors],
    /// The step that fills the reference before.
    pub(super) filler: Option<&'a Filler>,
    /// The number of changes, if the view is not, or was not always, the one that the plan was prepared for.
    pub(super) changes: Option<u64>,
}

impl Default for Lens {
    fn default() -> Self {
        Self { display: None, region: Region::WHOLE, compared: None, live: None, refused: None, changes: 0 }
    }
}

impl Lens {
    /// Another plan runs.
    pub(super) fn swapped(&mut self) {
        if self.live.is_some() {
            (self.compared, self.refused) = (None, None);
        } else if let Some(compared) = &mut self.compared {
            compared.sets = None;
        }
    }

    /// Makes the objects that compare with a live target, once for a plan.
    pub(super) fn prepare_live(&mut self, shared: &Shared, running: &Prepared) -> Result<(), ExecuteError> {
        let Some((part, comparison)) = self.live.filter(|_| self.compared.is_none() && self.refused.is_none()) else {
            return Ok(());
        };
        match Filler::new(shared, running, &part)? {
            Ok((filler, reference)) => {
                let reference = Arc::new(reference);
                self.compared = Some(Compared { reference, comparison, sets: None, filler: Some(filler) });
            }
            Err(refused) => self.refused = Some(refused),
        }
        Ok(())
    }

    /// The view of the next frame, and whether a copy of it is taken. `moves`: the frame before has written something.
    pub(super) fn look<'a>(
        &'a mut self,
        device: &Arc<Device>,
        display: &'a PreparedDisplay,
        (captured, moves): (bool, bool),
    ) -> Result<Look<'a>, ExecuteError> {
        self.changes += u64::from(captured || (moves && self.live.is_some()));
        let mut push = self.display.map_or(display.push, |shown| display.push.with_display(&shown));
        push = push.with_region(&self.region);
        let mut sets = &display.sets;
        let mut filler = None;
        if let Some(compared) = &mut self.compared
            && push.mismatch(display.variant, &compared.reference).is_none()
        {
            push = push.with_reference(&compared.reference, compared.comparison);
            sets = match &mut compared.sets {
                Some(sets) => sets,
                none => none.insert(display.sets_with(device, &compared.reference.buffer)?),
            };
            filler = compared.filler.as_ref();
        }
        let changed = self.display.is_some() || self.changes > 0;
        Ok(Look { push, sets, filler, changes: changed.then_some(self.changes) })
    }
}

impl Filler {
    /// With the reference that it fills, or why the target cannot be compared with.
    fn new(
        shared: &Shared,
        running: &Prepared,
        part: &Present,
    ) -> Result<Result<(Filler, Reference), Mismatch>, ExecuteError> {
        let (device, plan) = (&shared.device, running.plan());
        if plan.present.after.is_some() {
            return Ok(Err(Mismatch::Early));
        }
        let planned = plan.resources.iter().position(|planned| planned.resource == part.resource);
        let Some(resource) = planned else { return Ok(Err(Mismatch::Absent)) };
        let (ResourceDesc::Image(desc) | ResourceDesc::SourceImage(_, desc)) = &plan.resources[resource].desc else {
            return Ok(Err(Mismatch::Buffer));
        };
        let is_kept = !matches!(plan.resources[resource].lifetime, Lifetime::Transient { .. });
        if !is_kept || part.age >= running.resources[resource].count() {
            return Ok(Err(Mismatch::Absent));
        }
        let display = match &plan.graph.resource(part.resource).kind {
            ResourceKind::Target(target) => target.display,
            ResourceKind::Buffer(_) => None,
        };
        let extent = [desc.extent[0], desc.extent[1]].map(|texels| (texels >> part.mip).max(1));
        let (variant, push) = display::describe_image(desc, display, (part.mip, part.layer), extent);
        let variant = display::Variant { copies: true, ..variant };
        let channels = desc.format.channels();
        let size = u64::from(extent[0]) * u64::from(extent[1]) * u64::from(channels) * 4;
        if size > u64::from(device.capabilities().limits.max_storage_buffer_range) {
            return Ok(Err(Mismatch::Absent));
        }
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let info = BufferInfo { size, usage, location: Location::Device };
        let Ok(buffer) = Buffer::new(device, "live target to compare with", &info, Backing::Own) else {
            return Ok(Err(Mismatch::Absent));
        };
        let buffer = Arc::new(buffer);
        let ty = match variant.source {
            SourceKind::Volume => vk::ImageViewType::TYPE_3D,
            _ => vk::ImageViewType::TYPE_2D_ARRAY,
        };
        let physical = &running.resources[resource];
        let sampler = shared.pipelines.sampler(device, Sampling::default())?;
        let mut sources = Vec::new();
        for image in (0..physical.count() as usize).filter_map(|copy| physical.image(copy)) {
            if !image.info().usage.contains(vk::ImageUsageFlags::SAMPLED) {
                return Ok(Err(Mismatch::Absent));
            }
            let view = physical::view(device, image, ty, Interval::one(part.mip), Interval::ALL)?;
            sources.push(Resource::SampledImage(view, sampler.clone()));
        }
        let pipeline = shared.pipelines.display(device, variant)?;
        let set = |source: Resource| {
            let elements =
                [vec![source], vec![Resource::Buffer { buffer: buffer.clone(), offset: 0, size: buffer.size() }]];
            Ok(Descriptors::new(device, "copy of a live target", &pipeline, &elements)?)
        };
        let sets = sources.into_iter().map(set).collect::<Result<Vec<_>, ExecuteError>>()?;
        let step = plan.steps.iter().position(|step| *step == Step::Present).unwrap_or(0);
        let filler = Filler {
            resource,
            selector: plan.selector(step, part.resource),
            age: part.age,
            pipeline,
            sets,
            push,
            groups: [extent[0].div_ceil(display::GROUP), extent[1].div_ceil(display::GROUP), 1],
        };
        let values = match desc.format.scalar() {
            ScalarKind::Float => ReferenceValues::Floats,
            ScalarKind::Int | ScalarKind::Uint => ReferenceValues::Integers,
        };
        Ok(Ok((filler, Reference { buffer, extent, channels, values })))
    }

    /// Fills the reference. Everything before is waited for, and everything after waits.
    pub(super) fn record(
        &self,
        recording: &mut Recording<'_>,
        running: &Prepared,
        rotation: impl Fn(CopySelector) -> u64,
    ) {
        let copy = copy_of(rotation(self.selector), self.age, running.resources[self.resource].count());
        recording.barrier(&Barrier::full());
        recording.bind(&self.pipeline, &self.sets[copy]);
        recording.push(&self.pipeline, bytemuck::bytes_of(&self.push));
        recording.dispatch(self.groups);
        recording.barrier(&Barrier::full());
    }
}

impl Executor {
    /// Shows the debug target in another way than the graph's, from the next frame on.
    pub fn set_display(&mut self, display: Option<Display>) {
        // A plan that was prepared for the graph's own way has the key of that one.
        self.lens.changes += u64::from(self.lens.display != display);
        self.lens.display = display;
    }

    /// Shows a part of the debug target, from the next frame on.
    pub fn set_region(&mut self, region: Region) {
        self.lens.changes += u64::from(self.lens.region != region);
        self.lens.region = region;
    }

    /// Shows the debug target together with a reference, from the next frame on, as long as the two can be compared ([`Self::mismatch`]).
    pub fn set_comparison(&mut self, compared: Option<(Arc<Reference>, Comparison)>) {
        if self.lens.live.take().is_some() {
            (self.lens.compared, self.lens.refused) = (None, None);
            self.lens.changes += 1;
        }
        match (&mut self.lens.compared, compared) {
            (None, None) => return,
            (Some(known), Some((reference, comparison))) if Arc::ptr_eq(&known.reference, &reference) => {
                if known.comparison == comparison {
                    return;
                }
                known.comparison = comparison;
            }
            (known, compared) => {
                *known = compared.map(|(reference, comparison)| Compared {
                    reference,
                    comparison,
                    sets: None,
                    filler: None,
                });
            }
        }
        self.lens.changes += 1;
    }

    /// Shows the debug target together with another target of the running graph, as both are at the end of each frame, from the next frame
    /// on and as long as the two can be compared ([`Self::live_mismatch`]). The plan must keep that target to the end of the frame. The
    /// target replaces a reference.
    pub fn compare_live(&mut self, live: (Present, Comparison)) {
        if self.lens.live == Some(live) {
            return;
        }
        self.lens.changes += 1;
        match (&mut self.lens.compared, self.lens.live) {
            (Some(compared), Some((known, _))) if known == live.0 => compared.comparison = live.1,
            (compared, _) => (*compared, self.lens.refused) = (None, None),
        }
        self.lens.live = Some(live);
    }

    /// Why the shown target cannot be compared with the live target; `None` where it can, or nothing runs.
    pub fn live_mismatch(&self) -> Option<Mismatch> {
        self.lens.live?;
        self.lens.refused.or_else(|| self.mismatch(&self.lens.compared.as_ref()?.reference))
    }

    /// Why the shown target cannot be compared with the given reference; `None` where it can, or nothing runs.
    pub fn mismatch(&self, reference: &Reference) -> Option<Mismatch> {
        let display = &self.running.as_ref()?.display;
        display.push.mismatch(display.variant, reference)
    }
}

impl Builder {
    /// Puts texels on the device to be compared with. Waits for the copy; meant for a thread of its own.
    pub fn reference(&self, texels: &Texels) -> Result<Reference, ExecuteError> {
        let channels = texels.format.channels() as usize;
        let integers = texels.scalar() != ScalarKind::Float;
        let words: Vec<u32> = match texels.integers().filter(|_| integers) {
            Some(texels) => texels.iter().flat_map(|texel| texel[..channels].iter().copied()).collect(),
            None => (texels.floats().iter())
                .flat_map(|texel| texel[..channels].iter().map(|value| value.to_bits()).collect::<Vec<_>>())
                .collect(),
        };
        let values = if integers { ReferenceValues::Integers } else { ReferenceValues::Floats };
        self.reference_of((&words, texels.format.channels()), [texels.width, texels.height], values)
    }

    /// Puts a picture on the device to be compared with: rows from the top, red, green, blue. Waits as [`Self::reference`].
    pub fn reference_picture(
        &self,
        pixels: &[[f32; 3]],
        extent: [u32; 2],
        values: ReferenceValues,
    ) -> Result<Reference, ExecuteError> {
        let words: Vec<u32> = pixels.as_flattened().iter().map(|value| value.to_bits()).collect();
        self.reference_of((&words, 3), extent, values)
    }

    fn reference_of(
        &self,
        (words, channels): (&[u32], u32),
        extent: [u32; 2],
        values: ReferenceValues,
    ) -> Result<Reference, ExecuteError> {
        let buffer = self.upload_buffer(bytemuck::cast_slice(words), "picture to compare with")?;
        Ok(Reference { buffer, extent, channels, values })
    }
}
