//! Sets whose rays come 8 × 8 at a time: pixels of a view, which share a beam, and rays of one direction.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "random numbers and pixels are small, and casts of floats saturate"
)]

use glam::{Mat4, Vec2, Vec3};
use raxel_ray::Ray;
use raxel_ray::camera::{Pinhole, Tile};

use super::place::{around, clamped, fraction, range_end, towards, wrapped, wrapped_from};
use super::{Random, RayTargets};

/// From within, from a solid voxel, or from some way off; towards a solid voxel or past it; rolled by any angle. No angle is asked for, as
/// sines differ between systems.
pub(super) fn tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let target = targets.solid(random);
    let cell = match random.below(8) {
        0 => targets.solid(random),
        1 | 2 => {
            let (direction, distance) = (random.direction(), [500.0, 5000.0, 15_000.0][random.index(3)]);
            std::array::from_fn(|i| target[i] + (direction[i] * distance) as i64)
        }
        _ => random.cell(around(&targets.bounds)),
    };
    // In a corner of its cell, or anywhere.
    let frac = match random.below(8) {
        0 => [0.0; 3],
        1 => std::array::from_fn(|_| [0.0, 1.0][random.index(2)]),
        _ => fraction(random),
    };
    let cell = clamped(cell);
    let aim = Vec3::from_array(towards((cell.map(i64::from), frac), (target, [0.5; 3])));
    let aim = match random.below(8) {
        0 | 1 => Vec3::from_array(random.direction()),
        // Along an axis or a diagonal: the tile may lie on the border of octants.
        2 => Vec3::from_array(std::array::from_fn(|_| random.below(3) as f32 - 1.0)),
        _ => aim,
    };
    let forward = aim.try_normalize().unwrap_or(Vec3::X);
    // Any direction that is not nearly the same.
    let up = Vec3::from_array(random.direction());
    let up = if up.cross(forward).length_squared() > 0.01 { up } else { forward.any_orthogonal_vector() };
    let right = forward.cross(up).normalize();
    let up = right.cross(forward);
    // Outputs of any size: the last tiles of a row or a column have any number of pixels.
    let size = [[16, 16], [64, 64], [320, 184], [1280, 720], [3840, 2160]][random.index(5)];
    let size = size.map(|side| side + random.below(16) as u32);
    // The last one is a field of view of 179 degrees: a pixel of a small output is wider than its distance.
    let half_height = [0.006, 0.18, 0.58, 1.2, 12.0, 114.0][random.index(6)];
    let first = size.map(|side| random.below(u64::from(side / Tile::SIDE)) as u32 * Tile::SIDE);
    tile_of((cell.map(i64::from), frac), [right, up, forward], size, half_height, first)
}

/// Views of a solid voxel from cameras that are beside it by differences of 32 bits, see [`super::rays::wrapped`].
pub(super) fn wrapped_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let (cell, target) = wrapped_from(targets, random, [20, 200, 3000]);
    view_of(random, cell, target)
}

/// Views of a solid voxel from cameras as in [`super::rays::range_ends`].
pub(super) fn range_end_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let (cell, target) = range_end(targets, random);
    view_of(random, cell, target)
}

/// Views of a solid voxel and its surroundings, from farther away than tiles are traced together or than beams reach: along one axis, or in
/// any direction.
pub(super) fn far_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let (target, distance) = (targets.solid(random), [9e3, 2e4, 1e5, 1e6, 16_777_216.0][random.index(5)]);
    let axis = random.index(3);
    let away = if random.below(2) == 0 {
        random.direction().map(|part| (f64::from(part) * distance) as i64)
    } else {
        let side = if random.below(2) == 0 { distance } else { -distance };
        std::array::from_fn(|a| if a == axis { side as i64 } else { random.below(9).cast_signed() - 4 })
    };
    let cell = clamped(std::array::from_fn(|a| target[a] + away[a])).map(i64::from);
    let frac = fraction(random);
    let forward = Vec3::from_array(towards((cell, frac), (target, [0.5; 3]))).try_normalize().unwrap_or(Vec3::X);
    let right = forward.any_orthonormal_vector();
    let (size, seen) = (TILE_SIZES[random.index(6)], [2.0, 30.0, 400.0][random.index(3)]);
    let first = tile_at(random, size, [0.5; 2]);
    tile_of((cell, frac), [right, right.cross(forward), forward], size, (seen / distance) as f32, first)
}

/// A view of a voxel from a cell, taken by differences of 32 bits.
fn view_of(random: &mut Random, cell: [i64; 3], target: [i64; 3]) -> Tile {
    let frac = fraction(random);
    let forward = Vec3::from_array(towards((cell, frac), (target, [0.5; 3]))).try_normalize().unwrap_or(Vec3::X);
    let right = forward.any_orthonormal_vector();
    let size = TILE_SIZES[random.index(6)];
    let half_height = [0.006, 0.18, 0.58][random.index(3)];
    let first = tile_at(random, size, [0.5; 2]);
    let mut tile = tile_of((cell, frac), [right, right.cross(forward), forward], size, half_height, first);
    tile.camera.cell = wrapped(cell).into();
    tile
}

/// Rays of one direction that begin there.
pub(super) fn wrapped_parallel(targets: &RayTargets, random: &mut Random) -> [Ray; Tile::RAYS] {
    let (cell, target) = wrapped_from(targets, random, [20, 200, 900]);
    let dir = towards((cell, [0.5; 3]), (target, fraction(random)));
    let dir = Vec3::from_array(dir).try_normalize().unwrap_or(Vec3::X).to_array();
    let along = [0, 1].map(|_| random.direction().map(f64::from));
    let first = std::array::from_fn(|a| -3.5 * (along[0][a] + along[1][a]));
    grid(cell, first, along).map(|(cell, frac)| Ray::new(wrapped(cell), frac, dir))
}

/// The tile at `first` of a view.
fn tile_of(
    origin: ([i64; 3], [f32; 3]),
    [right, up, forward]: [Vec3; 3],
    size: [u32; 2],
    half_height: f32,
    first: [u32; 2],
) -> Tile {
    let view_to_world = Mat4::from_cols(right.extend(0.0), up.extend(0.0), (-forward).extend(0.0), glam::Vec4::W);
    let tan_half_fov = Vec2::new(half_height * size[0] as f32 / size[1] as f32, half_height);
    let camera = Pinhole { cell: clamped(origin.0).into(), frac: origin.1.into(), view_to_world, tan_half_fov };
    Tile { camera, size, first }
}

/// A tile that holds, or lies beside, the place `at` (0 to 1) of a picture.
fn tile_at(random: &mut Random, size: [u32; 2], at: [f32; 2]) -> [u32; 2] {
    std::array::from_fn(|i| {
        let tiles = size[i] / Tile::SIDE;
        let middle = (at[i] * size[i] as f32) as u32 / Tile::SIDE;
        (middle + random.below(3) as u32).saturating_sub(1).min(tiles - 1) * Tile::SIDE
    })
}

/// Right, up and forward along axes, either way.
fn along_axes(random: &mut Random) -> [Vec3; 3] {
    let forward = random.index(3);
    let right = (forward + 1 + random.index(2)) % 3;
    let mut signed = |axis: usize| if random.below(2) == 0 { Vec3::AXES[axis] } else { -Vec3::AXES[axis] };
    let (forward, right) = (signed(forward), signed(right));
    [right, right.cross(forward), forward]
}

/// Odd sizes have pixels exactly at the centre, whose directions have components of zero.
const TILE_SIZES: [[u32; 2]; 6] = [[16, 16], [17, 17], [65, 33], [321, 183], [1280, 720], [3840, 2160]];

pub(super) fn octant_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let [right, up, forward] = along_axes(random);
    // Along an axis, or halfway to another one, where one axis is the border.
    let view = match random.below(3) {
        0 => [right, (up - forward).normalize(), (up + forward).normalize()],
        1 => [(right - forward).normalize(), up, (right + forward).normalize()],
        _ => [right, up, forward],
    };
    let size = TILE_SIZES[random.index(6)];
    let half_height = [0.006, 0.18, 0.58, 1.2][random.index(4)];
    let frac = if random.below(4) == 0 { [0.0; 3] } else { fraction(random) };
    let first = tile_at(random, size, [0.5; 2]);
    // Half of the views are turned by up to ten pixels, so that the border of octants is anywhere in a tile, also between any two pixels.
    let view = if random.below(2) == 0 {
        let ([right, up, forward], pixel) = (view, 2.0 * half_height / size[1] as f32);
        let [aside, above] = [0, 1].map(|_| 10.0 * pixel * random.signed());
        let forward = (forward + aside * right + above * up).normalize();
        let right = forward.cross(up).normalize();
        [right, right.cross(forward), forward]
    } else {
        view
    };
    tile_of((random.cell(around(&targets.bounds)), frac), view, size, half_height, first)
}

pub(super) fn grazing_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let view = along_axes(random);
    let [right, up, forward] = view;
    // Beside the upper or lower side of a solid voxel, some way off.
    let (solid, distance) = (targets.solid(random), [3.0_f32, 40.0, 600.0][random.index(3)]);
    let side = if random.below(2) == 0 { up } else { -up };
    let cell = std::array::from_fn(|i| solid[i] + (side[i] - distance * forward[i]) as i64);
    let beside = [0.0, 1.0 / 1024.0, 0.5, 1023.0 / 1024.0][random.index(4)];
    let frac = std::array::from_fn(|i| if up[i].abs() < 0.5 { random.unit() } else { beside });
    // Tilted by next to nothing, or by nothing.
    let tilt: f32 = [0.0, 1e-6, 1e-4, 1e-2][random.index(4)] * if random.below(2) == 0 { 1.0 } else { -1.0 };
    let ahead = (forward + tilt * up).normalize();
    let size = TILE_SIZES[random.index(6)];
    let half_height = [0.006, 0.18, 0.58][random.index(3)];
    let across = random.unit();
    let first = tile_at(random, size, [across, 0.5]);
    tile_of((cell, frac), [right, right.cross(ahead), ahead], size, half_height, first)
}

/// One row of the tile meets a solid voxel less than 1/25 voxel inside one of its edges. Either it is the nearest to the horizon, and meets the face
/// towards the camera; the other rows rise or sink away from there. Or it is the farthest of a tile of 16 × 16, and comes into the voxel just before the
/// face behind; the other rows pass above or below. Pixels are square or not.
pub(super) fn skimming_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let [right, up, forward] = along_axes(random);
    let target = targets.solid(random);
    // Halves are multiples of a tile.
    let size = [[64, 64], [320, 176], [1280, 720], [3840, 2160]][random.index(4)];
    let half_height = [0.0006, 0.006, 0.18, 0.58, 1.2, 114.0][random.index(6)];
    // The tile below the horizon, whose first row is the nearest, or the one above it. Both have a tile beside the central column.
    let (below, behind) = (random.below(2) == 0, random.below(4) == 0);
    let away = if behind { 15 } else { 0 };
    let row = if below { size[1] / 2 + away } else { size[1] / 2 - 1 - away };
    let first = [size[0] / 2, if below == behind { row + 1 - Tile::SIDE } else { row }];
    let mut tile = tile_of((target, [0.0; 3]), [right, up, forward], size, half_height, first);
    tile.camera.tan_half_fov.x *= [1.0, 0.125, 3.0, 8.0][random.index(4)];
    let column = first[0] + random.below(u64::from(Tile::SIDE)) as u32;
    let half = tile.camera.tan_half_fov;
    let rise = (1.0 - f64::from(2 * row + 1) / f64::from(size[1])) * f64::from(half.y);
    let aside = (f64::from(2 * column + 1) / f64::from(size[0]) - 1.0) * f64::from(half.x);
    // Where it is met: on the face towards the camera or behind, by the upper edge from below the horizon, and by the lower edge from above it.
    let inside = [1e-5, 1e-4, 1e-3, 1e-2, 0.04][random.index(5)];
    let height = if below { 0.5 - inside } else { inside - 0.5 };
    let (across, distance) = (f64::from(random.unit()) - 0.5, [0.6, 4.0, 60.0, 700.0, 8000.0][random.index(5)]);
    let place: [f64; 3] = std::array::from_fn(|i| {
        let [right, up, forward] = [right, up, forward].map(|axis| f64::from(axis[i]));
        let face = if behind { 0.5 } else { -0.5 };
        0.5 + across * right + height * up + face * forward - distance * (forward + rise * up + aside * right)
    });
    let (cell, frac) = at_place(target, place);
    (tile.camera.cell, tile.camera.frac) = (clamped(cell).into(), frac.into());
    tile
}

/// Cell and fraction, below 1, of a place relative to a cell.
fn at_place(cell: [i64; 3], place: [f64; 3]) -> ([i64; 3], [f32; 3]) {
    let whole = std::array::from_fn(|i| cell[i] + place[i].floor() as i64);
    (whole, place.map(|p| ((p - p.floor()) as f32).min(1.0 - f32::EPSILON)))
}

/// A solid voxel near the camera hides a corner of the tile, some rows or some columns; the other pixels look past it.
pub(super) fn hidden_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let [right, up, forward] = along_axes(random);
    let target = targets.solid(random);
    // The last tile of 40 × 20 has 8 × 4 pixels: one for each invocation of a packet.
    let size = [[16, 16], [40, 20], [328, 184], [1280, 720]][random.index(4)];
    let half_height = [0.18, 0.58, 1.2][random.index(3)];
    let first = size.map(|side| random.below(u64::from(side / Tile::SIDE)) as u32 * Tile::SIDE);
    let mut tile = tile_of((target, [0.0; 3]), [right, up, forward], size, half_height, first);
    let half = tile.camera.tan_half_fov;
    // The border of two pixels in a tile of 16 × 16 around.
    let [column, row] = first.map(|first| f64::from(first / 16 * 16) + 4.0 * random.below(5) as f64);
    let aside = (2.0 * column / f64::from(size[0]) - 1.0) * f64::from(half.x);
    let rise = (1.0 - 2.0 * row / f64::from(size[1])) * f64::from(half.y);
    // The target there: a corner of the face towards the camera, or some place on one of its edges.
    let mut side = || if random.below(2) == 0 { 0.5 } else { -0.5 };
    let mut place = [side(), side()];
    if let edge @ 0..2 = random.index(3) {
        place[edge] = f64::from(random.unit()) - 0.5;
    }
    let distance = [0.6, 4.0, 30.0][random.index(3)];
    let camera: [f64; 3] = std::array::from_fn(|i| {
        let [right, up, forward] = [right, up, forward].map(|axis| f64::from(axis[i]));
        let seen = 0.5 + place[0] * right + place[1] * up - 0.5 * forward;
        seen - distance * (forward + rise * up + aside * right)
    });
    let (cell, frac) = at_place(target, camera);
    (tile.camera.cell, tile.camera.frac) = (clamped(cell).into(), frac.into());
    tile
}

/// Half of a step of the lattice of origins.
const BESIDE_LATTICE: f32 = 1.0 / 33_554_432.0;

pub(super) fn lattice_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let size = [[16, 16], [17, 17], [33, 65], [64, 64], [1024, 512]][random.index(5)];
    let half_height = [0.25, 0.5, 1.0, 2.0][random.index(4)];
    let mut frac = std::array::from_fn(|_| [0.0, 0.25, 0.5, 1.0][random.index(4)]);
    match random.below(8) {
        // Outside of the cell, which counts as on its border.
        0 => frac[random.index(3)] = [-0.25, 1.25][random.index(2)],
        // Beside the lattice, by less than a step.
        1 => frac = frac.map(|place: f32| if place < 0.5 { place + BESIDE_LATTICE } else { place }),
        _ => {}
    }
    let (cell, at) = (random.cell(around(&targets.bounds)), [random.unit(), random.unit()]);
    let view = along_axes(random);
    let first = tile_at(random, size, at);
    tile_of((cell, frac), view, size, half_height, first)
}

/// 8 × 8 places: the first, relative to a cell, and the distances to the next one of a row, and of a column.
fn grid(cell: [i64; 3], first: [f64; 3], along: [[f64; 3]; 2]) -> [([i64; 3], [f32; 3]); Tile::RAYS] {
    std::array::from_fn(|i| {
        let (x, y) = (f64::from(i as u32 % Tile::SIDE), f64::from(i as u32 / Tile::SIDE));
        let place: [f64; 3] = std::array::from_fn(|a| first[a] + x * along[0][a] + y * along[1][a]);
        let at = std::array::from_fn(|a| cell[a] + place[a].floor() as i64);
        (at, place.map(|p| (p - p.floor()) as f32))
    })
}

pub(super) fn parallel(targets: &RayTargets, random: &mut Random) -> [Ray; Tile::RAYS] {
    let target = targets.solid(random);
    let mut dir = random.direction();
    // Flat along an axis, or two.
    for _ in 0..random.below(3) {
        dir[random.index(3)] *= [1e-2, 1e-4, 1e-8][random.index(3)];
    }
    let apart = [1.0 / 64.0, 0.25, 0.9, 2.7][random.index(4)];
    let (mut first, along) = if random.below(2) == 0 {
        // In the plane of a face.
        let (axis, middle) = (random.index(3), fraction(random).map(f64::from));
        let along = [1, 2].map(|turn| std::array::from_fn(|a| if a == (axis + turn) % 3 { apart } else { 0.0 }));
        let outside = if dir[axis] < 0.0 { 0.0 } else { 1.0 };
        (std::array::from_fn(|a| if a == axis { outside } else { middle[a] }), along)
    } else {
        let distance = [3.0, 60.0, 900.0][random.index(3)];
        let along = [0, 1].map(|_| random.direction().map(|v| apart * f64::from(v)));
        (std::array::from_fn(|a| 0.5 - distance * f64::from(dir[a])), along)
    };
    // The centre of the grid is about there.
    first = std::array::from_fn(|a| first[a] - 3.5 * (along[0][a] + along[1][a]));
    grid(target, first, along).map(|(cell, frac)| Ray::new(clamped(cell), frac, dir))
}

pub(super) fn parallel_ties(targets: &RayTargets, random: &mut Random) -> [Ray; Tile::RAYS] {
    let axis = random.index(3);
    let plane = [1, 2].map(|turn| std::array::from_fn(|a| if a == (axis + turn) % 3 { 1.0 } else { 0.0 }));
    if random.below(4) == 0 {
        // The same for each ray, as they are whole voxels apart.
        let ray = super::rays::unit_ties(targets, random);
        let [column, row] = [0, 1].map(|_| random.below(8) as f64);
        let first = std::array::from_fn(|a| f64::from(ray.frac[a]) - column * plane[0][a] - row * plane[1][a]);
        let places = grid(ray.cell.map(i64::from), first, plane);
        return places.map(|(cell, frac)| Ray::new(clamped(cell), frac, ray.dir));
    }
    let dir: [f32; 3] = std::array::from_fn(|_| random.below(3) as f32 - 1.0);
    let dir =
        if dir.iter().all(|&v| v == 0.0) { std::array::from_fn(|a| if a == axis { 1.0 } else { 0.0 }) } else { dir };
    let apart = [0.25, 0.5, 1.0][random.index(3)];
    let along = plane.map(|step: [f64; 3]| step.map(|part| apart * part));
    let beside = if random.below(8) == 0 { f64::from(BESIDE_LATTICE) } else { 0.0 };
    let first = std::array::from_fn(|_| beside + [0.0, 0.25, 0.5][random.index(3)]);
    let places = grid(random.cell(around(&targets.bounds)), first, along);
    places.map(|(cell, frac)| Ray::new(clamped(cell), frac, dir))
}

/// Fine grids around an edge, a corner or any place of a solid voxel, from beside it or from far off: of neighbouring rays one meets it and the next one passes.
/// That place is between rays, or that of a ray. In half of the grids one ray in eight begins elsewhere.
pub(super) fn parallel_edges(targets: &RayTargets, random: &mut Random) -> [Ray; Tile::RAYS] {
    let target = targets.solid(random);
    let mut dir = random.direction();
    for _ in 0..random.below(3) {
        dir[random.index(3)] *= [1e-1, 1e-2, 1e-4][random.index(3)];
    }
    let aim: [f64; 3] = std::array::from_fn(|_| [0.0, 1.0, f64::from(random.unit())][random.index(3)]);
    let apart = [1.0 / 256.0, 1.0 / 64.0, 1.0 / 8.0, 1.3][random.index(4)];
    let distance = [1.5, 60.0, 900.0, 4000.0, 2e4, 1e6][random.index(6)];
    let along = [0, 1].map(|_| random.direction().map(|v| apart * f64::from(v)));
    let [column, row] = if random.below(2) == 0 { [3.5; 2] } else { [0, 1].map(|_| random.below(8) as f64) };
    let first =
        std::array::from_fn(|a| aim[a] - distance * f64::from(dir[a]) - column * along[0][a] - row * along[1][a]);
    let moves = random.below(2) == 0;
    grid(target, first, along).map(|(cell, frac)| {
        let by = if moves && random.below(8) == 0 { elsewhere(random, &along) } else { [0.0; 3] };
        let (cell, frac) = at_place(cell, std::array::from_fn(|a| f64::from(frac[a]) + by[a]));
        Ray::new(clamped(cell), frac, dir)
    })
}

/// The first column or row meets a solid voxel less than 1/250 voxel inside of a face that is parallel to it. Its pixels are on the other side of the face: these rays begin up to
/// 1/60 pixel beside them. The others pass the voxel. In a steep view, one end of the voxel is several times as large as the other one, and the smaller
/// scale decides how far beside its pixel a ray may begin.
pub(super) fn parallel_beside(targets: &RayTargets, random: &mut Random) -> [Ray; Tile::RAYS] {
    let target = targets.solid(random);
    let across = random.index(3);
    let [along, third] = [[1, 2], [2, 1]][random.index(2)].map(|turn| (across + turn) % 3);
    let outwards = if random.below(2) == 0 { 1.0 } else { -1.0 };
    let mut dir = random.direction();
    dir[third] *= [0.0, 0.0, 1e-2, 1.0][random.index(4)];
    dir[across] *= [0.0, 1e-5, 1e-4, 3e-3, 1e-2][random.index(5)];
    let ahead = Vec3::from_array(dir).try_normalize().unwrap_or(Vec3::AXES[along]);
    let apart = [0.05, 0.25, 0.8, 0.8][random.index(4)];
    // In pixels, with a margin of a sixty-fourth of one and bounds of a hundred and twenty-eighth.
    let beside = match random.below(4) {
        0 => 0.016 * f64::from(random.unit()),
        _ => 0.006 + 0.0018 * f64::from(random.unit()),
    };
    let distance = [2.0, 10.0, 30.0, 300.0][random.index(4)];
    let mut aim = fraction(random).map(f64::from);
    // Close to an end of the face, more often than not.
    let near = [0.02, 0.1, 0.3, 1.0][random.index(4)] * aim[third];
    aim[third] = if random.below(2) == 0 { near } else { 1.0 - near };
    aim[across] = if outwards > 0.0 { 1.0 } else { 0.0 };
    let (mut columns, mut rows) = ([0.0; 3], [0.0; 3]);
    columns[across] = outwards * apart;
    rows[along] = [0.5, 1.0][random.index(2)] * apart;
    rows[third] = [0.0, f64::from(random.signed())][random.index(2)] * rows[along];
    let row = random.below(8) as f64;
    let first = std::array::from_fn(|a| aim[a] - distance * f64::from(ahead[a]) + beside * columns[a] - row * rows[a]);
    let turned = random.below(2) == 0;
    let mut number = 0;
    grid(target, first, if turned { [rows, columns] } else { [columns, rows] }).map(|(cell, frac)| {
        let (x, y) = (number % Tile::SIDE, number / Tile::SIDE);
        number += 1;
        let (column, row) = if turned { (y, x) } else { (x, y) };
        // The rays at the corners say where pixels are.
        let moves = column == 0 && (1..Tile::SIDE - 1).contains(&row);
        let by = if moves { beside + [1e-5, 1e-4, 1e-3][random.index(3)] } else { 0.0 };
        let (cell, frac) = at_place(cell, std::array::from_fn(|a| f64::from(frac[a]) - by * columns[a]));
        Ray::new(clamped(cell), frac, ahead.to_array())
    })
}

/// Some rays of a row or a column begin elsewhere along it: where the pixel of the other coordinate is, those of the first pixels anywhere, or where a tracer looks for them that
/// confuses products and quotients of w, or has a sign or a factor wrong. The grid lies so that one of them meets a solid voxel.
#[allow(clippy::float_cmp, reason = "these places are whole numbers")]
pub(super) fn parallel_moved(targets: &RayTargets, random: &mut Random) -> [Ray; Tile::RAYS] {
    let target = targets.solid(random);
    let dir = random.direction();
    let apart = [0.3, 0.8, 2.7][random.index(3)];
    let along = [0, 1].map(|_| random.direction().map(|v| apart * f64::from(v)));
    let distance = [2.0, 10.0, 60.0][random.index(3)];
    // Rows or columns, in one of the quarters of a tile; w is that of the views in trace_rays.comp.
    let (axis, rule) = (random.index(2), random.below(6));
    let [quarter, other] = [0, 1].map(|_| 8.0 * random.below(2) as f64);
    let w = [1.0, 2.0, 5.0, 40.0][random.index(4)];
    let anywhere = random.below(33) as f64 - 8.0;
    // From the places of a ray in its row and its column, in pixels of its 8 × 8.
    let moved = |place: [f64; 2]| {
        let (from, beside) = (place[axis] + quarter, place[1 - axis] + other);
        let to = match rule {
            0 if from == 0.0 => anywhere,
            1 => beside,
            2 => from / (w * w),
            3 => (256.0 / (from * w * w)).min(64.0),
            4 => 0.5 * from,
            5 => -from,
            _ => from,
        };
        let mut place = place;
        place[axis] = to - quarter;
        place
    };
    // Not the corners, which say where pixels are.
    let first_pixel = if rule == 0 { 0.0 } else { 1.0 };
    let mut chosen = [0, 1].map(|_| 1.0 + random.below(6) as f64);
    chosen[axis] *= first_pixel;
    let there = moved(chosen);
    let aim: [f64; 3] = fraction(random).map(f64::from);
    let origin: [f64; 3] = std::array::from_fn(|a| {
        aim[a] - distance * f64::from(dir[a]) - there[0] * along[0][a] - there[1] * along[1][a]
    });
    std::array::from_fn(|i| {
        let place = [i as u32 % Tile::SIDE, i as u32 / Tile::SIDE].map(f64::from);
        let stays = place.iter().all(|&at| at == 0.0 || at == f64::from(Tile::SIDE - 1)) || random.below(2) == 0;
        let [x, y] = if stays && place != chosen { place } else { moved(place) };
        let (cell, frac) = at_place(target, std::array::from_fn(|a| origin[a] + x * along[0][a] + y * along[1][a]));
        Ray::new(clamped(cell), frac, dir)
    })
}

/// Pixels in a plane along two axes, whose rays begin at different depths along the third one, as at the hits of an orthographic camera. In a view that does not change with depth,
/// all of them begin at their pixels. One ray in eight begins half a voxel further on each axis: at its pixel for a tracer that takes corners of cells for their centres.
pub(super) fn parallel_depths(targets: &RayTargets, random: &mut Random) -> [Ray; Tile::RAYS] {
    let target = targets.solid(random);
    let (depth, kind) = (random.index(3), random.below(8));
    let [side, other] = [[1, 2], [2, 1]][random.index(2)].map(|turn| (depth + turn) % 3);
    let mut dir = random.direction();
    let mut aim = fraction(random).map(f64::from);
    let mut apart = [1.0 / 16.0, 0.25, 1.0, 1.0][random.index(4)];
    let mut distance = [1.0, 4.0, 30.0][random.index(3)];
    if kind < 3 {
        (dir[side], dir[other]) = (0.0, 0.0);
        dir[depth] = dir[depth].signum();
    }
    if kind == 0 {
        // The slightest component there is, just before a plane, which the ray crosses on its way.
        dir[side] = random.signed().signum() * (-30.0_f32).exp2();
        let before = f64::from(f32::EPSILON) / 2.0 * [1.0, 1.0, 2.0][random.index(3)];
        aim[side] = if dir[side] < 0.0 { 1.0 + before } else { -before };
        (apart, distance) = (1.0, 300.0);
    } else if random.below(2) == 0 {
        // In corners of cells, seen along the depth.
        (aim[side], aim[other]) = (0.0, 0.0);
        dir = dir.map(f32::abs);
    }
    let plane = [side, other].map(|axis| std::array::from_fn(|a| if a == axis { apart } else { 0.0 }));
    let [column, row] = [0, 1].map(|_| random.below(8) as f64);
    let first: [f64; 3] = std::array::from_fn(|a| {
        let back = (distance * f64::from(dir[a])).round();
        aim[a] - back - column * plane[0][a] - row * plane[1][a]
    });
    let further = dir.map(|v| if v < 0.0 { -0.5 } else { 0.5 });
    if kind == 1 {
        // No direction, though it looks like one along the depth: nothing may be hit.
        dir[depth] *= [f32::INFINITY, f32::NAN][random.index(2)];
    }
    let last = Tile::SIDE - 1;
    let mut number = 0;
    grid(target, first, plane).map(|(cell, frac)| {
        let at = [number % Tile::SIDE, number / Tile::SIDE];
        number += 1;
        let mut by = [0.0; 3];
        // The rays at the corners say where pixels are.
        if at.iter().any(|at| ![0, last].contains(at)) {
            by = if kind != 0 && random.below(8) == 0 { further } else { by };
            by[depth] += random.below(9) as f64 - 4.0 + [0.0, f64::from(random.unit())][random.index(2)];
        }
        let (mut cell, mut frac) = at_place(cell, std::array::from_fn(|a| f64::from(frac[a]) + by[a]));
        if random.below(16) == 0 {
            // The same place, outside of a cell beside it: a tracer counts it as on the border of that cell.
            let (axis, beside) = (random.index(3), [-1, 1][random.index(2)]);
            cell[axis] += beside;
            frac[axis] -= beside as f32;
        }
        Ray::new(clamped(cell), frac, dir)
    })
}

/// In any direction; or to the place of another ray of its row or column, or by as much of the way to the next one as is just allowed, or just not.
fn elsewhere(random: &mut Random, along: &[[f64; 3]; 2]) -> [f64; 3] {
    if random.below(2) == 0 {
        let away = [0.002, 0.02, 1.0, 20.0][random.index(4)];
        return random.direction().map(|by| away * f64::from(by));
    }
    let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
    let rays = [sign / 130.0, sign / 100.0, f64::from(random.below(49) as u32) - 16.0][random.index(3)];
    along[random.index(2)].map(|by| rays * by)
}
