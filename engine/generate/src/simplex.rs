//! `OpenSimplex2` noise at several places at once.
//!
//! The function is that of fastnoise-lite 1.1 (J. Peck, MIT licence), whose crate the tests hold it to, bit by bit: the same operations in
//! the same order for each place, in 64-bit coordinates and 32-bit values. The code computes both sides of each branch and selects one. So a compiler
//! can handle as many places at once as the processor has lanes. On the plane it is simplex noise; in space the sum over two cubic lattices, shifted
//! by half a cell.
#![expect(
    clippy::cast_possible_truncation,
    reason = "lattice cells wrap in 32 bits by design, and the gradients are 32-bit floats"
)]
#![allow(clippy::inline_always, reason = "arrays stay in registers only where nothing is called")]
#![allow(clippy::needless_bitwise_bool, reason = "a lazy operator is a branch")]

/// One factor of a hash for each axis.
const PRIMES: [i32; 3] = [501_125_321, 1_136_930_381, 1_720_413_743];
const MIX: i32 = 0x27d4_eb2d;

/// Directions on the plane: 24 of them, 7.5° + 15° n from the second axis on, five times over; then every third.
const PLANE: [[f32; 2]; 128] = plane();

/// Directions in space: the centres of a cube's edges, five times over; then the corners of a tetrahedron.
const SPACE: [[f32; 3]; 64] = space();

/// The sine of 7.5° + 15° n in the first quarter.
const SINES: [f32; 6] = [0.130_526_19, 0.382_683_43, 0.608_761_4, 0.793_353_3, 0.923_879_5, 0.991_444_9];

const fn plane() -> [[f32; 2]; 128] {
    let mut directions = [[0.0; 2]; 128];
    let mut n = 0;
    while n < 128 {
        let turn = if n < 120 { n % 24 } else { 3 * (n - 120) + 1 };
        let (sine, cosine) = (SINES[turn % 6], SINES[5 - turn % 6]);
        directions[n] = match turn / 6 {
            0 => [sine, cosine],
            1 => [cosine, -sine],
            2 => [-sine, -cosine],
            _ => [-cosine, sine],
        };
        n += 1;
    }
    directions
}

const fn space() -> [[f32; 3]; 64] {
    let mut directions = [[0.0; 3]; 64];
    let mut n = 0;
    while n < 60 {
        let a = if n & 1 == 0 { 1.0 } else { -1.0 };
        let b = if n >> 1 & 1 == 0 { 1.0 } else { -1.0 };
        directions[n] = match n % 12 / 4 {
            0 => [0.0, a, b],
            1 => [a, 0.0, b],
            _ => [a, b, 0.0],
        };
        n += 1;
    }
    [directions[60], directions[61], directions[62], directions[63]] =
        [[1.0, 1.0, 0.0], [0.0, -1.0, 1.0], [-1.0, 1.0, 0.0], [0.0, -1.0, -1.0]];
    directions
}

/// A whole number that is added to and taken away from a smaller one to round it, and leaves it in the lowest bits: 1.5 · 2⁵².
const ROUND: f64 = 6_755_399_441_055_744.0;
/// Coordinates below which that is so for all lattices.
const NEAR: f64 = 1e9;

/// All bits where the condition holds, and none elsewhere, as a comparison leaves them in a register.
#[inline(always)]
fn mask<const N: usize>(holds: impl Fn(usize) -> bool) -> [u32; N] {
    std::array::from_fn(|n| if holds(n) { u32::MAX } else { 0 })
}

/// One of two values.
#[inline(always)]
fn either(mask: u32, yes: f32, no: f32) -> f32 {
    f32::from_bits(yes.to_bits() & mask | no.to_bits() & !mask)
}

/// A value, or nothing.
#[inline(always)]
fn only(mask: u32, value: f32) -> f32 {
    f32::from_bits(value.to_bits() & mask)
}

/// One where something holds, else nothing.
#[inline(always)]
fn one_where(holds: bool) -> f64 {
    f64::from_bits(u64::from(holds).wrapping_neg() & 1.0f64.to_bits())
}

/// Whether [`ROUND`] serves for the lattice around all places.
#[inline(always)]
fn are_near<const N: usize, const AXES: usize>(places: &[[f64; N]; AXES]) -> bool {
    let sums: [f64; N] = std::array::from_fn(|n| places.iter().fold(0.0, |sum, axis| sum + axis[n].abs()));
    sums.iter().sum::<f64>() < NEAR
}

/// Whole parts towards zero, as 64-bit values and as whole numbers; `near` as in [`are_near`].
#[inline(always)]
fn truncated<const N: usize>(values: [f64; N], near: bool) -> ([f64; N], [i32; N]) {
    if !near {
        return truncated_far(values);
    }
    let nearest: [f64; N] = std::array::from_fn(|n| (values[n] + ROUND) - ROUND);
    let whole: [f64; N] = std::array::from_fn(|n| {
        let beyond = one_where((values[n] >= 0.0) & (nearest[n] > values[n]));
        let before = one_where((values[n] < 0.0) & (nearest[n] < values[n]));
        nearest[n] - beyond + before
    });
    (whole, whole.map(|whole| (whole + ROUND).to_bits() as i32))
}

#[cold]
fn truncated_far<const N: usize>(values: [f64; N]) -> ([f64; N], [i32; N]) {
    let whole = values.map(|value| value as i32);
    (whole.map(f64::from), whole)
}

/// The largest whole numbers below; of whole numbers less than zero, the ones before.
#[inline(always)]
fn floors<const N: usize>(values: [f64; N], near: bool) -> ([f64; N], [i32; N]) {
    if !near {
        return floors_far(values);
    }
    let nearest: [f64; N] = std::array::from_fn(|n| (values[n] + ROUND) - ROUND);
    let whole: [f64; N] = std::array::from_fn(|n| {
        let is_beyond = (nearest[n] > values[n]) | ((values[n] < 0.0) & (nearest[n] >= values[n]));
        nearest[n] - one_where(is_beyond)
    });
    (whole, whole.map(|whole| (whole + ROUND).to_bits() as i32))
}

#[cold]
fn floors_far<const N: usize>(values: [f64; N]) -> ([f64; N], [i32; N]) {
    let whole = values.map(|value| value as i32 - i32::from(value < 0.0));
    (whole.map(f64::from), whole)
}

/// The direction that a hash names, of `count`, which is a power of two.
#[inline(always)]
fn direction<const N: usize>(hashes: [i32; N], shift: u32, count: usize) -> [usize; N] {
    let mixed = hashes.map(|hash| hash.wrapping_mul(MIX));
    mixed.map(|hash| ((hash ^ hash >> 15).cast_unsigned() >> shift) as usize & (count - 1))
}

/// The direction on the plane that a hash names.
#[inline(always)]
fn one_direction(hash: i32) -> [f32; 2] {
    PLANE[direction([hash], 1, PLANE.len())[0]]
}

/// The direction at a corner of the lattice on the plane, times the way from there. `one` where all hashes are the same.
#[inline(always)]
fn along_plane<const N: usize>(hashes: [i32; N], one: bool, x: [f32; N], y: [f32; N]) -> [f32; N] {
    if one {
        let [a, b] = one_direction(hashes[0]);
        return std::array::from_fn(|n| x[n] * a + y[n] * b);
    }
    let which = direction(hashes, 1, PLANE.len());
    let [a, b]: [[f32; N]; 2] = std::array::from_fn(|axis| which.map(|n| PLANE[n][axis]));
    std::array::from_fn(|n| x[n] * a[n] + y[n] * b[n])
}

/// The same in space.
#[inline(always)]
fn along_space<const N: usize>(hashes: [i32; N], [x, y, z]: [[f32; N]; 3]) -> [f32; N] {
    let which = direction(hashes, 2, SPACE.len());
    let [a, b, c]: [[f32; N]; 3] = std::array::from_fn(|axis| which.map(|n| SPACE[n][axis]));
    std::array::from_fn(|n| x[n] * a[n] + y[n] * b[n] + z[n] * c[n])
}

/// The contribution of a corner: its falloff to the fourth power, or nothing without falloff.
#[inline(always)]
fn share<const N: usize>(falloff: [f32; N], along: [f32; N]) -> [f32; N] {
    let there: [u32; N] = mask(|n| falloff[n] > 0.0);
    let square: [f32; N] = std::array::from_fn(|n| falloff[n] * falloff[n]);
    std::array::from_fn(|n| only(there[n], square[n] * square[n] * along[n]))
}

/// Noise on the plane.
#[inline(always)]
pub(super) fn plane_noise<const N: usize>(seed: i32, x: [f64; N], y: [f64; N]) -> [f32; N] {
    const SKEW: f64 = 0.5 * (1.732_050_807_568_877_2 - 1.0);
    const BACK: f32 = (3.0 - 1.732_050_8) / 6.0;
    let skew: [f64; N] = std::array::from_fn(|n| (x[n] + y[n]) * SKEW);
    let skewed = |axis: [f64; N]| std::array::from_fn(|n| axis[n] + skew[n]);
    let (x, y): ([f64; N], [f64; N]) = (skewed(x), skewed(y));
    let near = are_near(&[x, y]);
    let ((cell_x, i), (cell_y, j)) = (floors(x, near), floors(y, near));
    let x: [f32; N] = std::array::from_fn(|n| (x[n] - cell_x[n]) as f32);
    let y: [f32; N] = std::array::from_fn(|n| (y[n] - cell_y[n]) as f32);
    let back: [f32; N] = std::array::from_fn(|n| (x[n] + y[n]) * BACK);
    let x0: [f32; N] = std::array::from_fn(|n| x[n] - back[n]);
    let y0: [f32; N] = std::array::from_fn(|n| y[n] - back[n]);
    let falloff: [f32; N] = std::array::from_fn(|n| 0.5 - x0[n] * x0[n] - y0[n] * y0[n]);
    let (i, j) = (i.map(|i| i.wrapping_mul(PRIMES[0])), j.map(|j| j.wrapping_mul(PRIMES[1])));
    let (next_i, next_j) = (i.map(|i| i.wrapping_add(PRIMES[0])), j.map(|j| j.wrapping_add(PRIMES[1])));

    // Places in a row share a cell of all but the finest octaves, and then its four corners.
    let one = (0..N).fold(0, |other, n| other | (i[n] ^ i[0]) | (j[n] ^ j[0])) == 0;
    let here = share(falloff, along_plane(std::array::from_fn(|n| seed ^ i[n] ^ j[n]), one, x0, y0));
    // Of the two corners beside, the one on this side of the diagonal.
    let above: [u32; N] = mask(|n| y0[n] > x0[n]);
    let x1: [f32; N] = std::array::from_fn(|n| x0[n] + either(above[n], BACK, BACK - 1.0));
    let y1: [f32; N] = std::array::from_fn(|n| y0[n] + either(above[n], BACK - 1.0, BACK));
    let along = if one {
        let [yes, no] = [i[0] ^ next_j[0], next_i[0] ^ j[0]].map(|corner| one_direction(seed ^ corner));
        std::array::from_fn(|n| {
            let [a, b] = [0, 1].map(|axis| either(above[n], yes[axis], no[axis]));
            x1[n] * a + y1[n] * b
        })
    } else {
        let hashes: [i32; N] = std::array::from_fn(|n| {
            let above = above[n].cast_signed();
            seed ^ ((i[n] ^ next_j[n]) & above | (next_i[n] ^ j[n]) & !above)
        });
        along_plane(hashes, false, x1, y1)
    };
    let near: [f32; N] = std::array::from_fn(|n| 0.5 - x1[n] * x1[n] - y1[n] * y1[n]);
    let beside = share(near, along);
    let far: [f32; N] = std::array::from_fn(|n| {
        (2.0 * (1.0 - 2.0 * BACK) * (1.0 / BACK - 2.0)) * back[n]
            + ((-2.0 * (1.0 - 2.0 * BACK) * (1.0 - 2.0 * BACK)) + falloff[n])
    });
    let hashes: [i32; N] = std::array::from_fn(|n| seed ^ next_i[n] ^ next_j[n]);
    let (x2, y2) = (x0.map(|x| x + (2.0 * BACK - 1.0)), y0.map(|y| y + (2.0 * BACK - 1.0)));
    let opposite = share(far, along_plane(hashes, one, x2, y2));
    std::array::from_fn(|n| (here[n] + beside[n] + opposite[n]) * 99.836_85)
}

/// Noise in space.
#[inline(always)]
pub(super) fn space_noise<const N: usize>(mut seed: i32, [x, y, z]: [[f64; N]; 3]) -> [f32; N] {
    const MINUS: u32 = 1 << 31;
    let near = are_near(&[x, y, z]);
    let turned: [f64; N] = std::array::from_fn(|n| (x[n] + y[n] + z[n]) * (2.0 / 3.0));
    // Steps of the way from the nearest corner, that corner's part of the hash, and whether the way goes on to smaller numbers.
    let mut at = [[0.0f32; N]; 3];
    let mut lattice = [[0i32; N]; 3];
    let mut minus = [[0u32; N]; 3];
    for (axis, values) in [x, y, z].into_iter().enumerate() {
        let values: [f64; N] = std::array::from_fn(|n| turned[n] - values[n]);
        let (whole, numbers) = truncated(values.map(|value| value + if value >= 0.0 { 0.5 } else { -0.5 }), near);
        at[axis] = std::array::from_fn(|n| (values[n] - whole[n]) as f32);
        lattice[axis] = numbers.map(|number| number.wrapping_mul(PRIMES[axis]));
        minus[axis] = mask(|n| -1.0 - at[axis][n] <= -1.0);
    }
    let signed = |minus: u32, value: f32| f32::from_bits(value.to_bits() ^ minus & MINUS);
    let mut ways: [[f32; N]; 3] =
        std::array::from_fn(|axis| std::array::from_fn(|n| signed(minus[axis][n], -at[axis][n])));
    let [x, y, z] = at;
    let mut falloff: [f32; N] = std::array::from_fn(|n| (0.6 - x[n] * x[n]) - (y[n] * y[n] + z[n] * z[n]));
    let mut value = [0.0f32; N];
    for second in [false, true] {
        let [i, j, k] = lattice;
        let here = share(falloff, along_space(std::array::from_fn(|n| seed ^ i[n] ^ j[n] ^ k[n]), at));
        // The next corner is along the axis that the place is furthest away on.
        let [a, b, c] = ways;
        let x_first: [u32; N] = mask(|n| (a[n] >= b[n]) & (a[n] >= c[n]));
        let y_first: [u32; N] = mask(|n| (b[n] > a[n]) & (b[n] >= c[n]));
        let along = [x_first, y_first, std::array::from_fn(|n| !(x_first[n] | y_first[n]))];
        let most: [f32; N] = std::array::from_fn(|n| either(x_first[n], a[n], either(y_first[n], b[n], c[n])));
        let far: [f32; N] = std::array::from_fn(|n| falloff[n] + most[n] + most[n] - 1.0);
        let next: [[f32; N]; 3] = std::array::from_fn(|axis| {
            std::array::from_fn(|n| at[axis][n] + only(along[axis][n], signed(minus[axis][n], 1.0)))
        });
        let mut hashes = [seed; N];
        for axis in 0..3 {
            hashes = std::array::from_fn(|n| {
                // The prime, or the number that it is subtracted from.
                let (plus, step) = (!minus[axis][n].cast_signed(), PRIMES[axis]);
                let step = (step ^ plus).wrapping_sub(plus) & along[axis][n].cast_signed();
                hashes[n] ^ lattice[axis][n].wrapping_add(step)
            });
        }
        let beside = share(far, along_space(hashes, next));
        value = std::array::from_fn(|n| value[n] + here[n] + beside[n]);
        if second {
            break;
        }
        for axis in 0..3 {
            ways[axis] = ways[axis].map(|way| 0.5 - way);
            at[axis] = std::array::from_fn(|n| signed(minus[axis][n], ways[axis][n]));
            lattice[axis] =
                std::array::from_fn(|n| lattice[axis][n].wrapping_add(minus[axis][n].cast_signed() & PRIMES[axis]));
            minus[axis] = minus[axis].map(|minus| !minus);
        }
        let [a, b, c] = ways;
        falloff = std::array::from_fn(|n| falloff[n] + (0.75 - a[n]) - (b[n] + c[n]));
        seed = !seed;
    }
    value.map(|value| value * 32.694_283)
}

#[cfg(test)]
mod tests {
    use fastnoise_lite::{FastNoiseLite, NoiseType};

    use super::*;

    fn reference(seed: i32) -> FastNoiseLite {
        let mut noise = FastNoiseLite::with_seed(seed);
        noise.set_noise_type(Some(NoiseType::OpenSimplex2));
        noise.set_frequency(Some(1.0));
        noise
    }

    /// Places near the origin and out to 2³⁰, between cells, on them, and a little beside.
    fn places() -> Vec<[f64; 3]> {
        let mut state = 1u64;
        let mut random = || {
            state = raxel_world::random::mix(state);
            (state >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
        };
        let reaches = [0.0, 1e-9, 0.5, 3.0, 100.0, 1e5, 5e8, 9.9e8, 1.0737e9, 1.0741e9];
        let mut places: Vec<[f64; 3]> = Vec::new();
        for reach in reaches {
            for n in 0..4000 {
                let place = [reach * random(), reach * random(), reach * random()];
                places.push(match n % 4 {
                    0 => place.map(f64::round),
                    1 => place.map(|c| (8.0 * c).round() / 8.0),
                    2 => [place[0], place[0], place[1]],
                    _ => place,
                });
            }
        }
        for whole in -20..20 {
            for near in [-1e-12, -0.0, 0.0, 1e-12] {
                places.push([f64::from(whole) + near, -f64::from(whole) - near, near]);
                places.push([f64::from(whole) / 2.0 + near, near, f64::from(whole) / 2.0]);
            }
        }
        places
    }

    fn agree<const N: usize>() {
        for seed in [0, 1, -7, i32::MIN, 0x1234_5678] {
            let reference = reference(seed);
            for group in places().chunks_exact(N) {
                let [x, y, z]: [[f64; N]; 3] = std::array::from_fn(|axis| std::array::from_fn(|n| group[n][axis]));
                let (plane, space) = (plane_noise(seed, x, y), space_noise(seed, [x, y, z]));
                for n in 0..N {
                    let [x, y, z] = group[n];
                    let found = [plane[n], space[n]].map(f32::to_bits);
                    let expected = [reference.get_noise_2d(x, y), reference.get_noise_3d(x, y, z)].map(f32::to_bits);
                    assert_eq!(found, expected, "seed {seed} at {:?}, {N} at once", group[n]);
                }
            }
        }
    }

    #[test]
    fn every_bit_is_that_of_the_library_one_by_one() {
        agree::<1>();
    }

    #[test]
    fn every_bit_is_that_of_the_library_in_fours_and_eights() {
        agree::<4>();
        agree::<8>();
    }

    #[test]
    fn neighbours_in_a_row_agree_where_worlds_end() {
        for origin in [0.0, 1_073_741_000.0, -1_073_741_824.0] {
            for frequency in [0.0007, 0.016, 0.1024] {
                let reference = reference(5);
                for row in 0..64 {
                    let x: [f64; 8] =
                        std::array::from_fn(|n| (origin + 8.0 * f64::from(row) + n as f64 + 0.5) * frequency);
                    let y: [f64; 8] = [(origin - f64::from(row) + 0.5) * frequency; 8];
                    let z = [f64::from(row) * frequency; 8];
                    let (plane, space) = (plane_noise(5, x, y), space_noise(5, [x, z, y]));
                    for n in 0..8 {
                        assert_eq!(plane[n].to_bits(), reference.get_noise_2d(x[n], y[n]).to_bits());
                        assert_eq!(space[n].to_bits(), reference.get_noise_3d(x[n], z[n], y[n]).to_bits());
                    }
                }
            }
        }
    }
}
