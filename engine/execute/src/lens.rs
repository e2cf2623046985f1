//! How the debug target is looked at: which part of it is shown, and what it is compared with.

use std::sync::Arc;

use raxel_gpu::{Buffer, Descriptors, Device};
use raxel_graph::checked::Display;
use raxel_shader::interface::ScalarKind;

use super::display::Push;
use super::error::ExecuteError;
use super::executor::Executor;
use super::prepare::{Builder, PreparedDisplay};
use super::report::Texels;

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

/// What the numbers of a reference are.
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
}

/// How the debug target is shown, instead of as the graph says.
pub(super) struct Lens {
    display: Option<Display>,
    region: Region,
    compared: Option<Compared>,
    /// How often something else was to be shown, or a copy of it to be taken: what the memo knows of the picture no longer holds.
    changes: u64,
}

/// What the debug target is compared with.
struct Compared {
    reference: Arc<Reference>,
    comparison: Comparison,
    /// Of the running plan, once a frame needs them.
    sets: Option<Vec<Descriptors>>,
}

/// What the shader that shows the debug target is told.
pub(super) struct Look<'a> {
    pub(super) push: Push,
    /// For each copy of the debug target.
    pub(super) sets: &'a [Descriptors],
    /// How often that has changed, where it is not, or was not always, what the plan was prepared for.
    pub(super) changes: Option<u64>,
}

impl Default for Lens {
    fn default() -> Self {
        Self { display: None, region: Region::WHOLE, compared: None, changes: 0 }
    }
}

impl Lens {
    /// Another plan runs.
    pub(super) fn swapped(&mut self) {
        if let Some(compared) = &mut self.compared {
            compared.sets = None;
        }
    }

    /// What the next frame shows, and whether a copy of it is taken.
    pub(super) fn look<'a>(
        &'a mut self,
        device: &Arc<Device>,
        display: &'a PreparedDisplay,
        captured: bool,
    ) -> Result<Look<'a>, ExecuteError> {
        self.changes += u64::from(captured);
        let mut push = self.display.map_or(display.push, |shown| display.push.with_display(&shown));
        push = push.with_region(&self.region);
        let mut sets = &display.sets;
        if let Some(compared) = &mut self.compared
            && push.mismatch(display.variant, &compared.reference).is_none()
        {
            push = push.with_reference(&compared.reference, compared.comparison);
            sets = match &mut compared.sets {
                Some(sets) => sets,
                none => none.insert(display.sets_with(device, &compared.reference.buffer)?),
            };
        }
        let changed = self.display.is_some() || self.changes > 0;
        Ok(Look { push, sets, changes: changed.then_some(self.changes) })
    }
}

impl Executor {
    /// Shows the debug target in another way than the graph says, from the next frame on.
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
        match (&mut self.lens.compared, compared) {
            (None, None) => return,
            (Some(known), Some((reference, comparison))) if Arc::ptr_eq(&known.reference, &reference) => {
                if known.comparison == comparison {
                    return;
                }
                known.comparison = comparison;
            }
            (known, compared) => {
                *known = compared.map(|(reference, comparison)| Compared { reference, comparison, sets: None });
            }
        }
        self.lens.changes += 1;
    }

    /// Why what is shown cannot be compared with the reference that was given; `None` where it can, or nothing runs.
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
