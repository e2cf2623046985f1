//! The size of a resource, and the values that sizes decide.

use crate::ir::checked::{Value, ValueOrigin};

/// Size of a resource for one output size and one world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Size {
    /// Of one copy of a target.
    Image {
        /// Texels of mip 0; the third is 1 unless the target is 3-D.
        extent: [u32; 3],
        /// The target is 3-D.
        volume: bool,
        /// Mips, the full chain counted out.
        mips: u32,
        /// Array layers.
        layers: u32,
    },
    /// Of one copy of a buffer.
    Buffer {
        /// Bytes; `None` for a source that is not supplied yet.
        bytes: Option<u64>,
        /// Elements; 0 where the file gives bytes alone, and for a source.
        elements: u64,
    },
}

impl Size {
    /// Number of mips; 1 for a buffer.
    pub fn mips(&self) -> u32 {
        match *self {
            Size::Image { mips, .. } => mips,
            Size::Buffer { .. } => 1,
        }
    }

    /// Number of layers; 1 for a buffer.
    pub fn layers(&self) -> u32 {
        match *self {
            Size::Image { layers, .. } => layers,
            Size::Buffer { .. } => 1,
        }
    }

    /// Threads that cover one mip: texels, with depth or layers as the third axis. `None` for a buffer.
    pub fn texels(&self, mip: u32) -> Option<[u32; 3]> {
        match *self {
            Size::Image { extent, volume, layers, .. } => {
                let [w, h, d] = extent.map(|axis| axis.checked_shr(mip).unwrap_or(0).max(1));
                Some([w, h, if volume { d } else { layers }])
            }
            Size::Buffer { .. } => None,
        }
    }

    /// Mip and layer of each picture that a target consists of: all layers, or slices of a 3-D target, mip after mip. None of a buffer.
    pub fn slices(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let layers = match *self {
            Size::Image { .. } => {
                (0..self.mips()).map(|mip| self.texels(mip).map_or(0, |[_, _, layers]| layers)).collect()
            }
            Size::Buffer { .. } => Vec::new(),
        };
        (0..).zip(layers).flat_map(|(mip, layers)| (0..layers).map(move |layer| [mip, layer]))
    }

    /// Elements of a buffer, texels of a target's mip 0.
    pub(crate) fn elements(&self) -> u64 {
        match self {
            Size::Image { .. } => product(self.texels(0).unwrap_or([1; 3])),
            Size::Buffer { elements, .. } => *elements,
        }
    }

    /// Bytes of a buffer, as far as they are known.
    pub fn bytes(&self) -> Option<u64> {
        match *self {
            Size::Image { .. } => None,
            Size::Buffer { bytes, .. } => bytes,
        }
    }
}

/// The value of a source that sizes decide, or the file; `None` for a value that changes from frame to frame.
pub(crate) fn constant(source: &ValueOrigin, sizes: &[Size], materials: &[u32]) -> Option<Value> {
    Some(match source {
        ValueOrigin::Value(value) => *value,
        ValueOrigin::ExtentOf(target) => {
            let [x, y, z] = sizes[target.0 as usize]
                .texels(0)
                .unwrap_or([1; 3])
                .map(|axis| i32::try_from(axis).unwrap_or(i32::MAX));
            Value::IVec4([x, y, z, 1])
        }
        ValueOrigin::CountOf(buffer) => {
            Value::U32(u32::try_from(sizes[buffer.0 as usize].elements()).unwrap_or(u32::MAX))
        }
        ValueOrigin::Material(at) => Value::U32(materials.get(*at as usize).copied().unwrap_or(0)),
        ValueOrigin::Param(_) | ValueOrigin::Builtin(_) | ValueOrigin::Clock(..) | ValueOrigin::Round(_) => {
            return None;
        }
    })
}

/// Product of the axes; saturates.
pub(crate) fn product(axes: [u32; 3]) -> u64 {
    axes.into_iter().fold(1, |product: u64, axis| product.saturating_mul(axis.into()))
}

/// Number of mips down to one texel: ⌊log₂(longest axis)⌋ + 1.
pub fn full_chain(extent: [u32; 3]) -> u32 {
    let longest = extent.into_iter().max().unwrap_or(1).max(1);
    u32::BITS - longest.leading_zeros()
}
