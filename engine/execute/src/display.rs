//! Shows the debug target: a compute pass of the runtime's own that maps texels to a picture.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_graph::checked::{BufferSize, Display, DisplayMap, ResourceKind, Target};
use raxel_graph::plan::{ImageDesc, Plan, ResourceDesc};
use raxel_shader::format::Format;
use raxel_shader::interface::{BindingKind, Block, Scalar, ScalarKind, Type};
use raxel_shader::{Compiler, Request, Shader, ShaderProvider};

use super::error::ExecuteError;
use super::lens::{Comparison, Mismatch, Reference, ReferenceValues, Region};

/// The variant of the display shader that a debug target needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Variant {
    pub(super) scalar: ScalarKind,
    pub(super) source: SourceKind,
    /// It copies its input to the place of a reference, instead of showing it.
    pub(super) copies: bool,
}

/// The kinds of resources that the display shader reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum SourceKind {
    /// A 2-D image, layered or not.
    Flat,
    /// A 3-D image.
    Volume,
    /// A buffer.
    Buffer,
}

/// The push constants of the display shader (`display.comp`).
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Push {
    output_extent: [i32; 2],
    source_extent: [i32; 2],
    range: [f32; 2],
    map: u32,
    channel: u32,
    channels: u32,
    slice: u32,
    elements: u32,
    comparison: u32,
    origin: [f32; 2],
    step: [f32; 2],
    gain: f32,
    edge: i32,
    reference_channels: u32,
    reference_values: u32,
}

/// Workgroup size of the display shader, both axes.
pub(super) const GROUP: u32 = 8;

/// How the plan's debug target is shown.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the root of a number of 32 bits has 16")]
pub(super) fn describe(plan: &Plan) -> (Variant, Push) {
    let shown = plan.present;
    let output_extent = plan.output.map(u32::cast_signed);
    let planned = plan.resources.iter().find(|r| r.resource == shown.resource);
    if let Some(ResourceDesc::Image(desc) | ResourceDesc::SourceImage(_, desc)) = planned.map(|r| &r.desc) {
        let display = match &plan.graph.resource(shown.resource).kind {
            ResourceKind::Target(target) => target.display,
            ResourceKind::Buffer(_) => None,
        };
        return describe_image(desc, display, (shown.mip, shown.layer), plan.output);
    }
    let (words, width, scalar) = buffer_grid(plan);
    let bytes = match planned.map(|r| &r.desc) {
        Some(ResourceDesc::Buffer(desc)) => desc.size,
        _ => 0,
    };
    let elements = (bytes / 4 / u64::from(words)).min(1 << 30) as u32;
    let width = width.unwrap_or_else(|| f64::from(elements).sqrt().ceil() as u32).max(1);
    let map = match (scalar, words) {
        (ScalarKind::Float, 3..) => DisplayMap::Color,
        (ScalarKind::Float, _) => DisplayMap::Gray,
        (ScalarKind::Int | ScalarKind::Uint, _) => DisplayMap::Id,
    };
    let push = Push {
        output_extent,
        source_extent: [width.cast_signed(), elements.div_ceil(width).max(1).cast_signed()],
        range: [0.0, 1.0],
        map: map as u32,
        channel: 0,
        channels: words,
        elements,
        ..Push::default()
    };
    (Variant { scalar, source: SourceKind::Buffer, copies: false }, push)
}

/// How a layer or slice of a mip of an image is shown in `size` pixels. `display` is the graph's.
pub(super) fn describe_image(
    desc: &ImageDesc,
    display: Option<Display>,
    (mip, slice): (u32, u32),
    pixels: [u32; 2],
) -> (Variant, Push) {
    let display = display.unwrap_or_else(|| default_display(desc.format));
    let source = if desc.volume { SourceKind::Volume } else { SourceKind::Flat };
    let push = Push {
        output_extent: pixels.map(u32::cast_signed),
        source_extent: [desc.extent[0], desc.extent[1]].map(|texels| (texels >> mip).max(1).cast_signed()),
        range: display.range,
        map: display.map as u32,
        channel: display.channel.min(desc.format.channels() - 1),
        channels: desc.format.channels(),
        slice,
        ..Push::default()
    };
    (Variant { scalar: desc.format.scalar(), source, copies: false }, push)
}

/// The display of a target: by its file, otherwise by its format.
pub fn display_of(target: &Target) -> Display {
    target.display.unwrap_or_else(|| default_display(target.format))
}

impl Push {
    /// Shown in another way than the graph's.
    pub(super) fn with_display(self, display: &Display) -> Push {
        let channel = display.channel.min(self.channels.clamp(1, 4) - 1);
        Push { map: display.map as u32, range: display.range, channel, ..self }
    }

    /// A part of the source fills the picture.
    #[expect(clippy::cast_possible_truncation, reason = "shares of extents are small numbers")]
    pub(super) fn with_region(self, region: &Region) -> Push {
        // The shader shows the whole by integers, so that equal extents copy exactly.
        if *region == Region::WHOLE {
            return self;
        }
        let along = |axis: usize| {
            let texels = f64::from(self.source_extent[axis]);
            let step = texels * region.size / f64::from(self.output_extent[axis].max(1));
            [(texels * region.origin[axis]) as f32, step as f32]
        };
        let [[x, across], [y, down]] = [along(0), along(1)];
        Push { origin: [x, y], step: [across, down], ..self }
    }

    /// Shown together with a reference, which [`Self::mismatch`] has nothing against.
    #[expect(clippy::cast_possible_truncation, reason = "casts of floats saturate")]
    pub(super) fn with_reference(self, reference: &Reference, comparison: Comparison) -> Push {
        let push = Push { reference_channels: reference.channels, reference_values: reference.values as u32, ..self };
        match comparison {
            Comparison::Wipe(share) => {
                let edge = (share * f64::from(self.output_extent[0])).round() as i32;
                Push { comparison: 1, edge, ..push }
            }
            Comparison::Reference => Push { comparison: 2, ..push },
            Comparison::Difference(gain) => Push { comparison: 3, gain, ..push },
        }
    }

    /// Why the shown target cannot be compared with a reference.
    pub(super) fn mismatch(&self, variant: Variant, reference: &Reference) -> Option<Mismatch> {
        let shown = self.source_extent.map(i32::cast_unsigned);
        let same = match reference.values {
            ReferenceValues::Floats => variant.scalar == ScalarKind::Float,
            ReferenceValues::Integers => variant.scalar != ScalarKind::Float,
            ReferenceValues::Displayed => true,
        };
        match variant.source {
            SourceKind::Buffer => Some(Mismatch::Buffer),
            _ if shown != reference.extent => Some(Mismatch::Extent { shown, kept: reference.extent }),
            _ if !same => Some(Mismatch::Values),
            _ => None,
        }
    }

    /// The number of bytes of the shown buffer (a source's size is not in the plan).
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the root of a number of 32 bits has 16"
    )]
    pub(super) fn with_bytes(mut self, bytes: u64) -> Push {
        let elements = (bytes / 4 / u64::from(self.channels.max(1))).min(1 << 30) as u32;
        if elements != self.elements {
            let width = f64::from(elements).sqrt().ceil().max(1.0) as u32;
            self.elements = elements;
            self.source_extent = [width.cast_signed(), elements.div_ceil(width).max(1).cast_signed()];
        }
        self
    }
}

/// 32-bit words of an element, elements a row if there is a natural number of them, and the type of a word.
fn buffer_grid(plan: &Plan) -> (u32, Option<u32>, ScalarKind) {
    let resource = plan.present.resource;
    let scalar = declared_scalar(plan).unwrap_or(ScalarKind::Uint);
    match &plan.graph.resource(resource).kind {
        ResourceKind::Buffer(buffer) => match buffer.size {
            // One element per texel is shown where the texel is.
            BufferSize::Of { of, per: 1, stride } if stride >= 4 => {
                (stride / 4, plan.sizes[of.0 as usize].texels(0).map(|[width, ..]| width), scalar)
            }
            _ => (1, None, scalar),
        },
        ResourceKind::Target(_) => (1, None, scalar),
    }
}

/// The type of the buffer's words in the first shader that binds it.
fn declared_scalar(plan: &Plan) -> Option<ScalarKind> {
    plan.graph.passes.iter().find_map(|pass| {
        let access = pass.accesses.iter().find(|access| access.resource == plan.present.resource)?;
        match &pass.shader.interface.bindings.get(access.binding? as usize)?.kind {
            BindingKind::StorageBuffer(block) => block_scalar(block),
            _ => None,
        }
    })
}

fn block_scalar(block: &Block) -> Option<ScalarKind> {
    type_scalar(&block.members.last()?.ty)
}

fn type_scalar(ty: &Type) -> Option<ScalarKind> {
    match ty {
        Type::Scalar(scalar) | Type::Vector(scalar, _) | Type::Matrix { scalar, .. } => match scalar {
            Scalar::F32 => Some(ScalarKind::Float),
            Scalar::I32 => Some(ScalarKind::Int),
            _ => Some(ScalarKind::Uint),
        },
        Type::Array { element, .. } => type_scalar(element),
        Type::Struct(block) => block_scalar(block),
    }
}

/// The display of a target whose file does not define one.
fn default_display(format: Format) -> Display {
    let name = format.name();
    let map = match (format.scalar(), name.ends_with('f'), format.channels()) {
        (ScalarKind::Int | ScalarKind::Uint, ..) => DisplayMap::Id,
        (ScalarKind::Float, true, 3..) => DisplayMap::Color,
        (ScalarKind::Float, true, _) => DisplayMap::Gray,
        (ScalarKind::Float, false, 3..) if name.ends_with("_snorm") => DisplayMap::Normal,
        (ScalarKind::Float, false, _) => DisplayMap::Raw,
    };
    Display { map, range: [0.0, 1.0], channel: 0 }
}

/// Compiles one variant of the display shader.
pub(super) fn compile(variant: Variant) -> Result<Arc<Shader>, ExecuteError> {
    const PATH: &str = "shaders/display.comp";
    let mut defines = BTreeMap::new();
    let scalar = match variant.scalar {
        ScalarKind::Float => "RX_FLOAT",
        ScalarKind::Int => "RX_INT",
        ScalarKind::Uint => "RX_UINT",
    };
    defines.insert(scalar, "1");
    match variant.source {
        SourceKind::Flat => {}
        SourceKind::Volume => {
            defines.insert("RX_VOLUME", "1");
        }
        SourceKind::Buffer => {
            defines.insert("RX_BUFFER", "1");
        }
    }
    if variant.copies {
        defines.insert("RX_COPY", "1");
    }
    let request = Request {
        path: PATH.to_owned(),
        entry: "main".to_owned(),
        defines: defines.into_iter().map(|(name, value)| (name.to_owned(), value.to_owned())).collect(),
    };
    let compiler = Compiler::new(Arc::new(MemoryFiles::new([(PATH, include_str!("display.comp"))])));
    let mut texts = SourceMap::default();
    match compiler.shader(&request, &mut texts) {
        Ok((shader, _)) => Ok(shader),
        Err(diagnostics) => {
            Err(ExecuteError::Display(diagnostics.iter().map(|d| d.message.clone()).collect::<Vec<_>>().join("; ")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variant_compiles() {
        for scalar in [ScalarKind::Float, ScalarKind::Int, ScalarKind::Uint] {
            let sources = [SourceKind::Flat, SourceKind::Volume, SourceKind::Buffer];
            for (source, copies) in sources.into_iter().flat_map(|source| [(source, false), (source, true)]) {
                let shader = compile(Variant { scalar, source, copies }).expect("the display shader is ours");
                let bindings = shader.interface.bindings.iter().map(|binding| binding.binding).collect::<Vec<_>>();
                assert_eq!(bindings, if copies { vec![0, 2] } else { vec![0, 1, 2] });
                let push = shader.interface.push.as_ref().expect("it has a push block");
                assert_eq!(push.size as usize, size_of::<Push>());
                assert_eq!(shader.interface.local_size.map(|axis| axis.value), [GROUP, GROUP, 1]);
            }
        }
    }
}
