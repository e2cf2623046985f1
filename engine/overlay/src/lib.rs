//! egui's drawings, in the form that the overlay of a window takes: textures by number, triangles in points. Nothing is copied.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

use egui::epaint::{ClippedPrimitive, ImageData, ImageDelta, Primitive, Vertex};
use egui::{TextureFilter, TextureId};
use raxel_gpu::{OverlayMesh, OverlayVertex, TexturePatch};

/// The number that a texture has in an overlay.
pub fn texture(id: TextureId) -> u64 {
    match id {
        TextureId::Managed(id) | TextureId::User(id) => id,
    }
}

/// The texels that egui makes or changes.
#[expect(clippy::cast_possible_truncation, reason = "egui's textures have some thousand texels a side")]
pub fn patch(delta: &ImageDelta) -> TexturePatch<'_> {
    let ImageData::Color(image) = &delta.image;
    TexturePatch {
        position: delta.pos.map(|at| at.map(|texel| texel as u32)),
        size: image.size.map(|texels| texels as u32),
        rgba: bytemuck::cast_slice(&image.pixels),
        linear: delta.options.magnification == TextureFilter::Linear,
    }
}

/// The tessellated triangles, in order. egui's callbacks are left out.
pub fn meshes(painted: &[ClippedPrimitive]) -> Vec<OverlayMesh<'_>> {
    painted.iter().filter_map(mesh).collect()
}

fn mesh(clipped: &ClippedPrimitive) -> Option<OverlayMesh<'_>> {
    let (clip, Primitive::Mesh(mesh)) = (clipped.clip_rect, &clipped.primitive) else { return None };
    Some(OverlayMesh {
        clip: [clip.left(), clip.top(), clip.right(), clip.bottom()],
        texture: texture(mesh.texture_id),
        vertices: bytemuck::cast_slice::<Vertex, OverlayVertex>(&mesh.vertices),
        indices: &mesh.indices,
    })
}
