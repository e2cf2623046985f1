//! A texture for voxel faces: four tiles with joints between them, sRGB, that repeats without a seam.

/// Texels along a side.
pub(crate) const SIDE: usize = 128;

/// Texels of the joint between two tiles.
const JOINT: usize = 4;

/// sRGB, three bytes a texel, rows from the top.
pub(crate) fn tiles() -> Vec<u8> {
    (0..SIDE * SIDE).flat_map(|index| texel(index % SIDE, index / SIDE)).collect()
}

fn texel(x: usize, y: usize) -> [u8; 3] {
    let half = SIDE / 2;
    let (inside_x, inside_y) = (x % half, y % half);
    let grain = speckle(x, y, 7) % 24;
    if inside_x < JOINT || inside_y < JOINT {
        return [96, 92, 86].map(|channel: u8| channel + grain / 3);
    }
    let edge = [inside_x - JOINT, inside_y - JOINT, half - 1 - inside_x, half - 1 - inside_y];
    let bevel = edge.into_iter().min().unwrap_or(0).min(4) as u8;
    // Each tile has a shade of its own; the one at the top left is dark.
    let base: [u8; 3] = match (x / half, y / half) {
        (0, 0) => [92, 70, 62],
        (1, 1) => [176, 128, 96],
        (1, _) => [196, 148, 110],
        _ => [184, 138, 104],
    };
    base.map(|channel| channel + 4 * bevel + grain)
}

/// A number that looks random, for each texel.
fn speckle(x: usize, y: usize, salt: u32) -> u8 {
    let mut hash = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77) ^ salt;
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
    hash = (hash ^ (hash >> 12)).wrapping_mul(0x297a_2d39);
    (hash >> 24) as u8
}
