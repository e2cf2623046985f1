//! Layout `texture3d`: see `shaders/include/raxel/rivals/internal/layouts/texture3d.glsl` for the format.

use raxel_world::CHUNK_EDGE;
use raxel_world::MaterialIndex;
use raxel_world::World;
use rayon::prelude::*;

use raxel_layouts::{
    Access, Encoded, EncodedImage, Encoding, EncodingLimits, Extent, Layout, LayoutError, MATERIAL_WORDS, buffer,
    check_size, layout_header,
};

/// A dense 3-D image with mips.
pub const LAYOUT: Layout = Layout::new(&ENCODING);

static ENCODING: Encoding =
    Encoding { image: Some(encode_image), has_set: true, ..Encoding::new("texture3d", Texture3dHeader::block, encode) };

layout_header! {
    /// Header of the layout `texture3d`; the voxels are in its image. Addresses (`…_at`) count words from the first word behind the
    /// header.
    Texture3dHeader {
        /// Texels of mip 0, multiples of 64.
        size: [i32; 3],
        /// Mips, down to one texel.
        mip_count: u32,
    }
}

/// The buffer: header and materials. The bytes of the image count as geometry.
fn encode(world: &World, limits: EncodingLimits, access: Access) -> Result<Encoded, LayoutError> {
    let Shape { mut extent, size, mip_count, image_bytes } = shape(world, limits)?;
    if access == Access::Write {
        extent.bounds_min = extent.origin;
        extent.bounds_last = std::array::from_fn(|i| extent.origin[i] + (size[i] - 1).cast_signed());
    }
    let words = Texture3dHeader::WORDS as usize + MATERIAL_WORDS as usize * world.materials().len();
    check_size(LAYOUT, 4 * words as u64, limits.buffer_bytes)?;
    let header = Texture3dHeader {
        size: size.map(u32::cast_signed),
        mip_count,
        ..Texture3dHeader::of(&extent, world.materials())
    };
    let buffer = buffer(&header, world.materials(), words);
    let header_bytes = 4 * u64::from(Texture3dHeader::WORDS);
    let attribute_bytes = 4 * buffer.len() as u64 - header_bytes;
    Ok(Encoded { words: buffer, geometry_bytes: header_bytes + image_bytes, attribute_bytes })
}

/// The image.
fn encode_image(world: &World, limits: EncodingLimits) -> Result<EncodedImage, LayoutError> {
    let Shape { extent, size, mip_count, .. } = shape(world, limits)?;
    Ok(EncodedImage { size, mips: mips(voxels(world, extent.origin, size), size, mip_count) })
}

struct Shape {
    extent: Extent,
    /// Texels of mip 0.
    size: [u32; 3],
    mip_count: u32,
    /// Of all mips.
    image_bytes: u64,
}

/// The image's size, if a device with these limits can hold it.
fn shape(world: &World, limits: EncodingLimits) -> Result<Shape, LayoutError> {
    let layout = LAYOUT;
    let extent = extent(world)?;
    let size = image_size(&extent);
    let span = size.into_iter().max().unwrap_or(0);
    if span > u64::from(limits.image_side) {
        return Err(LayoutError::TooWide { layout: layout.name(), span, limit: limits.image_side.into() });
    }
    let size = size.map(|axis| axis as u32);
    let mip_count = u32::BITS - size.into_iter().max().unwrap_or(1).leading_zeros();
    // 2⁹⁰ texels are more than 64 bits can count.
    let image_bytes = (0..mip_count).fold(0_u64, |sum, mip| sum.saturating_add(mip_bytes(mip_size(size, mip))));
    if image_bytes > limits.image_bytes.min(isize::MAX as u64) {
        let (layout, limit) = (layout.name(), limits.image_bytes);
        return Err(LayoutError::ImageTooLarge { layout, bytes: image_bytes, limit });
    }
    Ok(Shape { extent, size, mip_count, image_bytes })
}

/// As [`Extent::of`], with the smallest power of two, so that an image that begins at the cube's corner has little to waste.
fn extent(world: &World) -> Result<Extent, LayoutError> {
    let mut extent = Extent::of(world, LAYOUT)?;
    if let Some(bounds) = world.bounds() {
        let low = bounds.min.map(|min| min & !63);
        let span = (0..3).map(|i| (bounds.max[i] - low[i]).cast_unsigned()).max().unwrap_or(1);
        extent.log2_size = span.next_power_of_two().trailing_zeros().max(6);
        extent.origin = low.map(|low| low.min((1 << 31) - (1 << extent.log2_size)) as i32);
    }
    Ok(extent)
}

/// Texels from the cube's corner to the last chunk of the world.
fn image_size(extent: &Extent) -> [u64; 3] {
    std::array::from_fn(|i| {
        let last = i64::from(extent.bounds_last[i]) - i64::from(extent.origin[i]);
        (last + 1).max(1).cast_unsigned().next_multiple_of(CHUNK_EDGE as u64)
    })
}

fn mip_size(size: [u32; 3], mip: u32) -> [u32; 3] {
    size.map(|axis| (axis >> mip).max(1))
}

fn mip_bytes(size: [u32; 3]) -> u64 {
    size.into_iter().fold(size_of::<MaterialIndex>() as u64, |bytes, axis| bytes.saturating_mul(axis.into()))
}

/// Mip 0.
fn voxels(world: &World, origin: [i32; 3], size: [u32; 3]) -> Vec<MaterialIndex> {
    let [width, height, depth] = size.map(|axis| axis as usize);
    let slab = width * height * CHUNK_EDGE as usize;
    let mut by_slab = vec![Vec::new(); depth / CHUNK_EDGE as usize];
    for (pos, chunk) in world.chunks() {
        let corner: [usize; 3] =
            std::array::from_fn(|i| pos.origin()[i].wrapping_sub(origin[i]).cast_unsigned() as usize);
        by_slab[corner[2] / CHUNK_EDGE as usize].push((corner, chunk));
    }
    let mut texels = vec![0; slab * by_slab.len()];
    texels.par_chunks_exact_mut(slab).zip(&by_slab).for_each(|(texels, chunks)| {
        for (corner, chunk) in chunks {
            for ([x, y, z], material) in chunk.iter() {
                texels[corner[0] + x as usize + width * (corner[1] + y as usize + height * z as usize)] = material;
            }
        }
    });
    texels
}

/// Every mip, from mip 0.
fn mips(mip0: Vec<MaterialIndex>, size: [u32; 3], mip_count: u32) -> Vec<Vec<MaterialIndex>> {
    let mut mips = vec![mip0];
    // A pyramid in which the far end is rounded up, so that nothing is lost on the way; mips are cut out of it.
    let mut whole_size = size.map(|axis| axis as usize);
    let mut whole: Option<Vec<MaterialIndex>> = None;
    for mip in 1..mip_count {
        let (next, next_size) = halved(whole.as_deref().unwrap_or(&mips[0]), whole_size);
        mips.push(cut(&next, next_size, mip_size(size, mip).map(|axis| axis as usize)));
        (whole, whole_size) = (Some(next), next_size);
    }
    mips
}

/// The level above: of eight texels the first that is not 0.
fn halved(texels: &[MaterialIndex], [w, h, d]: [usize; 3]) -> (Vec<MaterialIndex>, [usize; 3]) {
    let size = [w.div_ceil(2), h.div_ceil(2), d.div_ceil(2)];
    let mut result = vec![0; size[0] * size[1] * size[2]];
    result.par_chunks_exact_mut(size[0] * size[1]).enumerate().for_each(|(z, slice)| {
        for (y, row) in slice.chunks_exact_mut(size[0]).enumerate() {
            for from_z in 2 * z..(2 * z + 2).min(d) {
                for from_y in 2 * y..(2 * y + 2).min(h) {
                    let from = &texels[w * (from_y + h * from_z)..][..w];
                    for (to, pair) in row.iter_mut().zip(from.chunks(2)) {
                        let first = pair.iter().copied().find(|material| *material != 0).unwrap_or(0);
                        *to = if *to == 0 { first } else { *to };
                    }
                }
            }
        }
    });
    (result, size)
}

/// The part at the near end of every axis.
fn cut(texels: &[MaterialIndex], [w, h, _]: [usize; 3], size: [usize; 3]) -> Vec<MaterialIndex> {
    let mut result = Vec::with_capacity(size.into_iter().product());
    for z in 0..size[2] {
        for y in 0..size[1] {
            result.extend_from_slice(&texels[w * (y + h * z)..][..size[0]]);
        }
    }
    result
}
