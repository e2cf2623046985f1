//! Poison: the value that fills transient memory before its first use, when a plan is made for validation. A pass that is believed to store
//! every texel and leaves some out then shows at once.

use raxel_shader::format::Format;
use raxel_shader::interface::ScalarKind;

use crate::ir::checked::Clear;
use crate::ir::plan::{ResourceDesc, ResourcePlan};

/// The word that integers and buffers are filled with.
const WORD: u32 = 0xDEAD_BEEF;

/// NaN where a format has it, magenta where colours are normalised, 0xDEADBEEF (its low bits) in integers and buffers.
pub(crate) fn poison(resource: &ResourcePlan) -> Clear {
    match &resource.desc {
        ResourceDesc::Image(image) | ResourceDesc::SourceImage(_, image) => texel(image.format),
        ResourceDesc::Buffer(_) | ResourceDesc::Source(_) => Clear::Uint([WORD; 4]),
    }
}

fn texel(format: Format) -> Clear {
    let bits = format.bytes() * 8 / format.channels();
    let mask = if bits < 32 { (1 << bits) - 1 } else { u32::MAX };
    let floats = format.name().ends_with('f');
    match format.scalar() {
        ScalarKind::Float if floats => Clear::Float([f32::NAN; 4]),
        ScalarKind::Float => Clear::Float([1.0, 0.0, 1.0, 1.0]),
        // Positive in every width.
        ScalarKind::Int => Clear::Int([(WORD & mask >> 1).cast_signed(); 4]),
        ScalarKind::Uint if format == Format::Rgb10A2ui => Clear::Uint([WORD & 0x3ff, WORD & 0x3ff, WORD & 0x3ff, 3]),
        ScalarKind::Uint => Clear::Uint([WORD & mask; 4]),
    }
}
