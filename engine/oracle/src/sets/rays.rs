//! Sets that are made ray by ray.
#![expect(clippy::cast_possible_truncation, reason = "random numbers are small, and casts of floats saturate")]

use raxel_ray::Ray;

use super::place::{self, around, clamped, fraction, middle, range_end, towards, wrapped_from};
use super::{Random, RayTargets};

pub(super) fn pinhole(targets: &RayTargets, random: &mut Random) -> Ray {
    // One of 16 cameras.
    let mut camera = Random::new(random.below(16));
    let (cell, frac) = (camera.cell(around(&targets.bounds)), fraction(&mut camera));
    let aim = towards((cell, frac), (middle(&targets.bounds), [0.5; 3]));
    let length = aim.iter().map(|v| v * v).sum::<f32>().sqrt().max(1.0);
    let forward = aim.map(|v| v / length);
    let pixel: [f32; 3] = std::array::from_fn(|_| (random.below(1024) as f32 + 0.5) / 512.0 - 1.0);
    Ray::new(clamped(cell), frac, std::array::from_fn(|i| forward[i] + 0.7 * pixel[i]))
}

pub(super) fn incoherent(targets: &RayTargets, random: &mut Random) -> Ray {
    Ray::new(clamped(random.cell(around(&targets.bounds))), fraction(random), random.direction())
}

/// As `rx_ray_from_face` begins a ray: in the neighbour's cube, exactly on the shared plane.
pub(super) fn bounce(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut cell = targets.solid(random);
    let (axis, side) = (random.index(3), random.below(2) == 0);
    cell[axis] += if side { 1 } else { -1 };
    let mut frac = fraction(random);
    frac[axis] = if side { 0.0 } else { 1.0 };
    let mut dir = random.direction();
    dir[axis] = if side { dir[axis].abs() } else { -dir[axis].abs() };
    Ray::new(clamped(cell), frac, dir)
}

/// From anywhere around the scene to a point of a cell that has `exact` integer coordinates.
fn aim(targets: &RayTargets, random: &mut Random, target: [i64; 3], exact: usize) -> Ray {
    let from = (random.cell(around(&targets.bounds)), fraction(random));
    let mut at = [0.0; 3];
    for _ in exact..3 {
        at[random.index(3)] = random.unit();
    }
    Ray::new(clamped(from.0), from.1, towards(from, (target, at)))
}

pub(super) fn aimed(targets: &RayTargets, random: &mut Random, exact: usize) -> Ray {
    let target = random.cell(targets.bounds);
    aim(targets, random, target, exact)
}

pub(super) fn silhouettes(targets: &RayTargets, random: &mut Random) -> Ray {
    let corner = [0, 1, 2].map(|_| random.below(2).cast_signed());
    let solid = targets.solid(random);
    let exact = 2 + random.index(2);
    aim(targets, random, [0, 1, 2].map(|i| solid[i] + corner[i]), exact)
}

pub(super) fn lattice(targets: &RayTargets, random: &mut Random) -> Ray {
    let frac = std::array::from_fn(|_| [0.0, 0.5, 0.25, 1.0][random.index(4)]);
    let dir = std::array::from_fn(|_| random.below(9) as f32 - 4.0);
    Ray::new(clamped(random.cell(around(&targets.bounds))), frac, dir)
}

pub(super) fn near_ties(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = lattice(targets, random);
    for _ in 0..2 {
        let d = &mut ray.dir[random.index(3)];
        *d = f32::from_bits(d.to_bits().wrapping_add(random.below(7) as u32).wrapping_sub(3));
        // A zero has no neighbours but denormals and NaN.
        if !d.is_normal() {
            *d = 1.0;
        }
    }
    ray
}

pub(super) fn grazing(targets: &RayTargets, random: &mut Random) -> Ray {
    let flat = random.index(3);
    let mut ray = incoherent(targets, random);
    // Four steps of the lattice of origins, or many.
    let beside = [1.0 / 1024.0, (-22.0_f32).exp2()][random.index(2)];
    ray.frac[flat] = [beside, 1.0 - beside][random.index(2)];
    ray.dir[flat] = [1e-4, -1e-4, 1e-5, -1e-6, 1e-7, -1e-7][random.index(6)];
    // Half of them beside a face of a solid voxel.
    if random.below(2) == 0 {
        let plane = targets.solid(random)[flat] + [-1, 0, 1][random.index(3)];
        ray.cell[flat] = clamped([plane; 3])[0];
    }
    ray
}

pub(super) fn zeros(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    for _ in 0..2 {
        ray.dir[random.index(3)] = [0.0, -0.0][random.index(2)];
    }
    if random.below(4) == 0 {
        ray.frac[random.index(3)] = [0.0, 1.0][random.index(2)];
    }
    ray
}

pub(super) fn tiny(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    for _ in 0..2 {
        let size = [1e-45, 1e-40, 1e-38, 1e-30, 1e-20, 1e-12, 1e-9, 1e-7, 1e-6][random.index(9)];
        ray.dir[random.index(3)] = if random.below(2) == 0 { size } else { -size };
    }
    ray
}

pub(super) fn faces(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    for _ in 0..=random.below(3) {
        ray.frac[random.index(3)] = [0.0, 1.0][random.index(2)];
    }
    ray
}

pub(super) fn inside(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = faces(targets, random);
    ray.cell = clamped(targets.solid(random));
    // One voxel beside it: its face is the plane that the ray starts on.
    if random.below(2) == 0 {
        let axis = random.index(3);
        let side = random.below(2) == 0;
        ray.cell[axis] = ray.cell[axis].saturating_add(if side { 1 } else { -1 });
        ray.frac[axis] = if side { 0.0 } else { 1.0 };
    }
    ray
}

pub(super) fn border(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = faces(targets, random);
    let axis = random.index(3);
    let [low, high] = targets.bounds.map(|corner| corner[axis]);
    ray.cell[axis] = clamped([[low - 1, low, high - 1, high][random.index(4)]; 3])[0];
    ray
}

pub(super) fn outside(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    let axis = random.index(3);
    let up = random.below(2) == 0;
    let reach = 1 << random.below(24);
    let away = 1 + random.below(reach).cast_signed();
    let cell = if up { targets.bounds[1][axis] - 1 + away } else { targets.bounds[0][axis] - away };
    ray.cell[axis] = clamped([cell; 3])[0];
    // One in four points away, the others may hit.
    let d = ray.dir[axis].abs();
    let inwards = random.below(4) != 0;
    ray.dir[axis] = if up == inwards { -d } else { d };
    ray
}

/// Distances of far targets, in voxels. The tree of instances is searched by floats up to 2^29.
const AWAY: [f64; 6] = [1e4, 1e6, 16_777_216.0, 268_435_456.0, 1_073_741_824.0, 4_294_967_296.0];

/// An origin at one of several distances from a target, as far as coordinates reach.
fn away(random: &mut Random, target: [i64; 3]) -> ([i64; 3], [f32; 3]) {
    let distance = AWAY[random.index(AWAY.len())];
    let direction = random.direction();
    let cell = std::array::from_fn(|i| target[i] + (f64::from(direction[i]) * distance) as i64);
    (clamped(cell).map(i64::from), fraction(random))
}

pub(super) fn far(targets: &RayTargets, random: &mut Random) -> Ray {
    let target = if random.below(2) == 0 { targets.solid(random) } else { random.cell(targets.bounds) };
    let from = away(random, target);
    Ray::new(clamped(from.0), from.1, towards(from, (target, fraction(random))))
}

/// As [`far`], but far away along one axis only, so that errors of that distance show. Half of the distances are arbitrary.
pub(super) fn far_axes(targets: &RayTargets, random: &mut Random) -> Ray {
    if random.below(4) == 0 {
        return past_floats(targets, random);
    }
    let target = targets.solid(random);
    let mut cell = random.cell(around(&targets.bounds));
    let (axis, most) = (random.index(3), AWAY[random.index(AWAY.len())]);
    let distance = if random.below(2) == 0 { most } else { most * f64::from(random.unit()) } as i64;
    cell[axis] = target[axis] + if random.below(2) == 0 { distance } else { -distance };
    let from = (clamped(cell).map(i64::from), fraction(random));
    Ray::new(clamped(from.0), from.1, towards(from, (target, fraction(random))))
}

/// A tracer may keep a cell in a float of 1.5 * 2^23 and more, whose low bits it is. This far up, or this far down, the sum is the bits of a NaN.
const NOT_A_NUMBER: [i64; 2] = [0x3440_0000, 0x4b40_4000];

/// In any direction, from so far away along one axis, or equally far along two, that no float holds the cell.
fn past_floats(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    let distance = NOT_A_NUMBER[random.index(2)] + random.below(1 << 23).cast_signed();
    for _ in 0..=random.below(2) {
        let axis = random.index(3);
        ray.cell[axis] =
            clamped([i64::from(ray.cell[axis]) + if random.below(2) == 0 { distance } else { -distance }; 3])[0];
    }
    ray
}

/// Along an axis past a solid voxel or into it, and on the others as slowly as the lattice of directions can express, or too slowly for it.
/// From planes of the lattice, where the slightest motion decides the cell, and from so far away that it comes to cells.
pub(super) fn slightest(targets: &RayTargets, random: &mut Random) -> Ray {
    let target = targets.solid(random);
    let main = random.index(3);
    // Some come to the voxel's cell on the other axes at the very moment in which they have crossed all planes that there are.
    let at_once = random.below(8) == 0;
    let distance = if at_once { 1 << 32 } else { [2, 40, 1 << 20, 1 << 32][random.index(4)] };
    let (mut cell, mut frac, mut dir) = (target, [0.0; 3], [0.0; 3]);
    for (axis, ((cell, dir), frac)) in cell.iter_mut().zip(&mut dir).zip(&mut frac).enumerate() {
        let up = random.below(2) == 0;
        let sign = if up { 1 } else { -1 };
        let size = if at_once { 1.0 } else { 1.0 + random.unit() };
        if axis == main {
            *cell -= sign * distance;
            *dir = sign as f32 * size;
        } else {
            // The lattice ends at 2^-30 of the power of two in the largest component.
            let exponent = 28 + random.below(4);
            let beside = random.below(3).cast_signed() - 1;
            *cell += if at_once { -sign * (distance >> exponent) } else { beside };
            *dir = if random.below(4) == 0 { 0.0 } else { sign as f32 * size * (-(exponent as f32)).exp2() };
        }
        let place = [0.0, 1.0, 0.5, random.unit()][random.index(4)];
        *frac = if at_once { f32::from(u8::from(!up)) } else { place };
        // On the border of the scene's box, about to leave it.
        if axis != main && !at_once && random.below(4) == 0 {
            let [low, high] = targets.bounds.map(|corner| corner[axis]);
            (*cell, *frac) = if up { (high - 1, 1.0) } else { (low, 0.0) };
        }
    }
    Ray::new(clamped(cell), frac, dir)
}

pub(super) fn far_pinhole(targets: &RayTargets, random: &mut Random) -> Ray {
    // One of 16 cameras.
    let from = away(&mut Random::new(random.below(16)), middle(&targets.bounds));
    let target = random.cell(around(&targets.bounds));
    Ray::new(clamped(from.0), from.1, towards(from, (target, [0.5; 3])))
}

/// Origins that a difference of 32 bits would put beside the scene. If the scene is at an end of the coordinates, the origin is often at
/// the other end, from where nothing is hit.
pub(super) fn wrapped(targets: &RayTargets, random: &mut Random) -> Ray {
    let (cell, target) = wrapped_from(targets, random, [3, 40, 3000]);
    let frac = fraction(random);
    Ray::new(place::wrapped(cell), frac, towards((cell, frac), (target, fraction(random))))
}

pub(super) fn lengths(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    let length = (random.below(121) as f32 - 60.0).exp2();
    ray.dir = ray.dir.map(|d| d * length);
    ray
}

pub(super) fn longest(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    // The lattice has its last exponent for one in four.
    let exponent = if random.below(4) == 0 { 127.5 + 0.49 * random.unit() } else { 100.0 + 27.99 * random.unit() };
    let length = exponent.exp2();
    ray.dir = ray.dir.map(|d| d * length);
    // Half of them end 16 to 256 voxels away: nearer, times have no normal float.
    let end = (16.0 + 240.0 * random.unit()) / length;
    if random.below(2) == 0 { Ray { t_max: end, ..ray } } else { ray }
}

pub(super) fn fractions(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = if random.below(2) == 0 { incoherent(targets, random) } else { inside(targets, random) };
    ray.frac[random.index(3)] = 2.0 * random.unit() - 0.5;
    ray
}

pub(super) fn ended(targets: &RayTargets, random: &mut Random) -> Ray {
    let ray = if random.below(2) == 0 { incoherent(targets, random) } else { inside(targets, random) };
    Ray { t_max: [-1.0, -1.0e-2, -1.0e-30, -0.0, 0.0, 1.0e-30][random.index(6)], ..ray }
}

/// Where a scene is at an end of the coordinates, differences to the other end take all 32 bits, and one more.
pub(super) fn range_ends(targets: &RayTargets, random: &mut Random) -> Ray {
    let (cell, target) = range_end(targets, random);
    let from = (cell, fraction(random));
    Ray::new(clamped(from.0), from.1, towards(from, (target, fraction(random))))
}

/// Crosses plane n of axis a and plane m of axis b at times as near as two can be without being one: with directions p and q (p a power of
/// two, q odd and below it) that are y and x multiples of 2^-24 away, p x = q y ± 1. With p = 64 the sum that separates them is ±1, with
/// 128 it is ±1/2, and so on.
pub(super) fn unit_ties(targets: &RayTargets, random: &mut Random) -> Ray {
    const CELL: i64 = 1 << 24;
    let p = 1_i64 << [6, 6, 7, 8, 12, 20][random.index(6)];
    let q = 2 * random.below(p.cast_unsigned() / 2).cast_signed() + 1;
    let off = if random.below(2) == 0 { 1 } else { -1 };
    // Of an odd number, three bits are its own inverse; each round doubles them.
    let inverse = (0..3).fold(q, |inverse, _| (inverse * (2 - q * inverse)).rem_euclid(p));
    // Half of them up to 48 voxels away, the others nearer, where a walk in floating point has the smallest margin for its error.
    let most = 48 * CELL.cast_unsigned() / p.cast_unsigned();
    let most = if random.below(2) == 0 { most } else { most.min(1 << random.below(19)) };
    let y = (-off * inverse).rem_euclid(p) + p * (1 + random.below(most).cast_signed());
    let distances = [y, (q * y + off) / p];
    let target = targets.solid(random);
    let (mut cell, mut frac, mut dir) = (target, fraction(random), [0.0; 3]);
    let first = random.index(3);
    let axes = [first, (first + 1 + random.index(2)) % 3];
    for (axis, (distance, size)) in axes.into_iter().zip(distances.into_iter().zip([p, q])) {
        // The plane at that distance, and whether the solid is behind it.
        let plane = (distance + CELL - 1) / CELL;
        let place = (plane * CELL - distance) as f32 / CELL as f32;
        let cells = plane - random.below(2).cast_signed();
        let up = random.below(2) == 0;
        cell[axis] += if up { -cells } else { cells };
        frac[axis] = if up { place } else { 1.0 - place };
        dir[axis] = if up { size as f32 } else { -size as f32 } / p as f32;
    }
    Ray::new(clamped(cell), frac, dir)
}

/// Aimed at the centre of a solid voxel, which is one length of the direction away. Something may stand before it.
pub(super) fn ends(targets: &RayTargets, random: &mut Random) -> Ray {
    let target = targets.solid(random);
    let from = (random.cell(around(&targets.bounds)), fraction(random));
    let ray = Ray::new(clamped(from.0), from.1, towards(from, (target, [0.5; 3])));
    // Half a voxel before the centre the ray is on the face, or nearly.
    let face = 1.0 - 0.5 / ray.dir.iter().fold(1.0f32, |most, d| most.max(d.abs()));
    let near = [1.0 - 1e-3, 1.0 - 1e-6, 1.0, 1.0 + 1e-6, 1.0 + 1e-3][random.index(5)];
    let t_max = match random.below(4) {
        0 => 2.0 * random.unit(),
        1 => near,
        _ => face * near,
    };
    Ray { t_max, ..ray }
}

pub(super) fn invalid(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    // A NaN may have any bits behind its exponent.
    let any_nan = f32::from_bits(0x7f80_0001 | random.bits() as u32);
    let bad = [f32::NAN, any_nan, f32::INFINITY, f32::NEG_INFINITY][random.index(4)];
    match random.below(4) {
        0 => ray.dir = [0.0, -0.0, 0.0],
        1 => ray.dir = ray.dir.map(|_| 1e-40),
        2 => ray.frac[random.index(3)] = bad,
        _ => ray.dir[random.index(3)] = bad,
    }
    ray
}
