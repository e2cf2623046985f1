//! `walk.glsl`.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "this is a shader's arithmetic, whose words have 32 bits and wrap"
)]

use raxel_ray::{FACE_INSIDE, Hit, Ray};

const WALK_ERROR: f32 = 1.0 / 1_048_576.0;
const NEVER: f32 = 1.0e38;
const FAR: f32 = 3.0e38;
const ROUND: f32 = 12_582_912.0;
const FRAC_STEP: f32 = 1.0 / 16_777_216.0;
const DIR_STEP: f32 = 1.0 / 1_073_741_824.0;
/// G of an axis that the ray does not move along.
const STILL: u32 = 8_388_608;
const WORD_STEP: f32 = 1.0 / 4_294_967_296.0;

/// `uvec3`.
type Cell = [u32; 3];

/// Applies an operation to each axis.
fn each<T>(of: impl FnMut(usize) -> T) -> [T; 3] {
    [0, 1, 2].map(of)
}

/// `a - b`.
fn minus(a: Cell, b: Cell) -> Cell {
    each(|i| a[i].wrapping_sub(b[i]))
}

/// `RxWalk`: the walk of a lattice ray through a cube.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Walk {
    /// The current cell.
    pub(super) q: Cell,
    axes: u32,
    down: u32,
    d: [f32; 3],
    inv: [f32; 3],
    entry: Cell,
    start: [f32; 3],
    first: [f32; 3],
    base: f32,
    /// Time of the last step since the frame.
    pub(super) t: f32,
    /// Time since the frame after which no hit can be within the ray's end.
    pub(super) t_end: f32,
}

/// `RxExact`: the integers of a ray.
#[derive(Clone, Copy, Debug)]
struct Exact {
    origin: Cell,
    g: Cell,
    d: Cell,
}

impl Exact {
    /// `rx_walk_ahead`: whole part and 24-bit rest (to be subtracted) of how far plane `n_b` of axis `b` is ahead when plane `n_a` of `a`
    /// is crossed.
    fn ahead(&self, a: usize, n_a: u32, b: usize, n_b: u32) -> (i64, u32) {
        let (d_a, d_b) = (i64::from(self.d[a]), i64::from(self.d[b]));
        // The GPU's 64-bit words wrap as these do.
        let planes = i64::from(n_b).wrapping_mul(d_a).wrapping_sub(i64::from(n_a).wrapping_mul(d_b));
        let start = i64::from(self.g[b]) * d_a - i64::from(self.g[a]) * d_b;
        (planes.wrapping_sub(start >> 24), start as u32 & 0xff_ffff)
    }

    /// `rx_walk_compare`.
    fn compare(&self, (a, n_a, next_a): (usize, u32, u32), (b, n_b, next): (usize, u32, u32)) -> i32 {
        let (whole, rest) = self.ahead(a, n_a, b, n_b);
        let whole = whole - i64::from(next_a) * i64::from(self.d[b]) + i64::from(next) * i64::from(self.d[a]);
        if whole == 0 {
            return if rest == 0 { 0 } else { -1 };
        }
        if whole < 0 { -1 } else { 1 }
    }

    /// `rx_walk_first`: of the axes in a set, that whose plane (or the `next` behind it) is crossed first, or with `sign` −1 last.
    fn first(&self, axes: [bool; 3], planes: Cell, next: u32, sign: i32) -> usize {
        let later = |a: usize, b: usize| {
            if self.compare((a, planes[a], next), (b, planes[b], next)) * sign < 0 { b } else { a }
        };
        (0..3).filter(|&axis| axes[axis]).reduce(later).unwrap_or(0)
    }

    /// `rx_walk_gap`.
    fn gap(&self, (a, n_a): (usize, u32), (b, n_b, next): (usize, u32, bool)) -> f32 {
        let (whole, rest) = self.ahead(a, n_a, b, n_b);
        let whole = whole + i64::from(next) * i64::from(self.d[a]);
        let behind = whole < 0;
        let size = if behind { 0u32.wrapping_sub(whole as u32) } else { whole as u32 };
        let gap = size as f32 + (if behind { 1.0 } else { -1.0 }) * (rest as f32 * FRAC_STEP);
        ((if behind { -gap } else { gap }) / self.d[a] as f32).clamp(-1.0, 1.0)
    }

    /// `rx_walk_count`.
    fn count(&self, a: usize, n_a: u32, b: usize, mut low: u32, mut high: u32) -> u32 {
        for _ in 0..32 {
            if low >= high {
                break;
            }
            let middle = high - ((high - low) >> 1);
            if self.compare((a, n_a, 0), (b, middle, 0)) <= 0 {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        low
    }
}

/// `rx_lattice_component`.
fn lattice_component(bits: u32, top: u32) -> u32 {
    let exponent = bits >> 23 & 0xff;
    let shift = top - exponent;
    if exponent == 0 || shift > 30 { 0 } else { ((bits & 0x7f_ffff | 0x80_0000) << 7) >> shift }
}

/// `rx_lattice_top`.
fn lattice_top(dir: [f32; 3]) -> u32 {
    let exponent = |v: f32| v.to_bits() >> 23 & 0xff;
    exponent(dir[0]).max(exponent(dir[1])).max(exponent(dir[2]))
}

/// `rx_not_finite`.
fn not_finite(v: [f32; 3]) -> bool {
    v.iter().any(|v| v.to_bits() & 0x7f80_0000 == 0x7f80_0000)
}

/// `rx_walk_scale`.
fn walk_scale(dir: [f32; 3]) -> f32 {
    f32::from_bits(lattice_top(dir).clamp(1, 254) << 23)
}

/// `rx_walk_lengths`.
fn walk_lengths(dir: [f32; 3], t: f32) -> f32 {
    let top = lattice_top(dir);
    let lengths = t * f32::from_bits(254_u32.saturating_sub(top).max(1) << 23);
    if top > 253 { lengths * 0.5 } else { lengths }
}

impl Walk {
    /// `rx_walk_flip`.
    pub(super) fn flip(&self, last: u32) -> Cell {
        self.down().map(|down| if down { last } else { 0 })
    }

    /// `rx_walk_down`.
    fn down(&self) -> [bool; 3] {
        each(|i| self.down >> i & 1 != 0)
    }

    /// `rx_walk_exact`.
    fn exact(&self, ray: &Ray, corner: [i32; 3], last: u32) -> Exact {
        let d = self.d.map(|d| (d * 1_073_741_824.0) as u32);
        let down = self.down();
        let g = each(|i| {
            let frac = (ray.frac[i].clamp(0.0, 1.0) * 16_777_216.0) as u32;
            match (d[i], down[i]) {
                (0, _) => STILL,
                (_, true) => 16_777_216 - frac,
                (_, false) => frac,
            }
        });
        let origin = each(|i| {
            let relative = (ray.cell[i] as u32).wrapping_sub(corner[i] as u32);
            if down[i] { last.wrapping_sub(relative) } else { relative }
        });
        Exact { origin, g, d }
    }

    /// `rx_walk_frame`.
    fn frame(&mut self, g: [f32; 3], h: [f32; 3], since: f32) {
        self.entry = self.q;
        self.start = g.map(|g| g - 0.5);
        self.first = each(|i| if self.inv[i] == 0.0 { NEVER } else { h[i] * self.inv[i] });
        self.t_end -= since - self.base;
        self.base = since;
        self.t = 0.0;
    }

    /// `rx_walk_skip`.
    fn skip(&mut self, e: &Exact, quarters: u32) {
        let (mut g, mut h) = ([0.0; 3], [0.0; 3]);
        for i in 0..3 {
            let product = u64::from(e.d[i]) * u64::from(quarters);
            let start = e.g[i] << 8;
            let (rest, carry) = (product as u32).overflowing_add(start);
            let cells = (product >> 32) as u32;
            self.q[i] = e.origin[i].wrapping_add(cells).wrapping_add(u32::from(carry)).wrapping_add(e.g[i] >> 24);
            g[i] = rest as f32 * WORD_STEP;
            h[i] = if rest == 0 { 1.0 } else { 0u32.wrapping_sub(rest) as f32 * WORD_STEP };
        }
        self.axes = 8;
        self.frame(g, h, quarters as f32 * 0.25);
    }

    /// `rx_walk_cross`.
    fn cross(&mut self, e: &Exact, a: usize, n_a: u32, low: Cell, high: Cell) {
        let t = (n_a as f32 - e.g[a] as f32 * FRAC_STEP) / self.d[a];
        self.axes = 1 << a;
        let mut counts = [0; 3];
        counts[a] = n_a;
        let mut g = e.g.map(|g| g as f32 * FRAC_STEP);
        let mut h = e.g.map(|g| (16_777_216 - g) as f32 * FRAC_STEP);
        (g[a], h[a]) = (0.0, 1.0);
        for b in (0..3).filter(|&b| b != a) {
            let mut count = low[b];
            if e.d[b] != 0 {
                let (mut least, mut most) = (count, high[b]);
                let x = t * self.d[b] + g[b];
                let error = (x + 1.0) * (4.0 * WALK_ERROR);
                if x - error > least as f32 {
                    least = least.max((x - error).min(4_294_967_040.0) as u32);
                }
                if x + error < most as f32 {
                    most = most.min((x + error).max(0.0) as u32);
                }
                count = e.count(a, n_a, b, least.min(most), most);
                if count == u32::MAX && e.compare((a, n_a, 0), (b, count, 1)) <= 0 {
                    count = 0;
                }
                if count != 0 && e.compare((a, n_a, 0), (b, count, 0)) == 0 {
                    self.axes |= 1 << b;
                }
                g[b] = -e.gap((a, n_a), (b, count, false));
                h[b] = e.gap((a, n_a), (b, count, true));
            }
            counts[b] = count;
        }
        self.q = each(|i| e.origin[i].wrapping_add(counts[i]));
        self.frame(g, h, t);
    }

    /// `rx_walk_enter`.
    fn enter(&mut self, e: &Exact, before: [bool; 3], last: u32) -> bool {
        let enter = minus([0; 3], e.origin);
        let a = e.first(before, enter, 0, -1);
        let in_last = minus([last; 3], e.origin);
        let left = |b: usize| e.compare((a, enter[a], 0), (b, in_last[b], 1)) <= 0;
        if (0..3).any(|b| b != a && e.d[b] != 0 && left(b)) {
            return false;
        }
        let low = each(|i| if before[i] { enter[i] } else { 0 });
        self.cross(e, a, enter[a], low, in_last);
        true
    }

    /// `rx_walk_begin`.
    pub(super) fn begin(ray: &Ray, corner: [i32; 3], log2_size: u32, t_free: f32) -> Option<Self> {
        let last = (1u32 << log2_size) - 1;
        let top = lattice_top(ray.dir);
        let valid = top != 0 && !not_finite(ray.dir) && !not_finite(ray.frac);
        let bits = ray.dir.map(f32::to_bits);
        let d_fixed = bits.map(|bits| lattice_component(bits, top));
        let still = d_fixed.map(|d| d == 0);
        let down = each(|i| bits[i] >> 31 != 0 && !still[i]);
        let mut w = Self { down: (0..3).fold(0, |bits, i| bits | u32::from(down[i]) << i), ..Self::default() };
        w.d = d_fixed.map(|d| d as f32 * DIR_STEP);
        w.inv = each(|i| if still[i] { 0.0 } else { 1.0 / w.d[i].max(1.0e-20) });
        let e = w.exact(ray, corner, last);
        w.base = 0.0;
        let scale = walk_scale(ray.dir);
        w.t_end = if ray.t_max >= 1.0e37 { FAR } else { ray.t_max * scale * 1.0001 + 1.0e-3 };

        let below = each(|i| ray.cell[i] < corner[i]);
        let above = each(|i| ray.cell[i] > corner[i].wrapping_add(last as i32));
        let before = each(|i| if down[i] { above[i] } else { below[i] });
        let past = each(|i| if down[i] { below[i] } else { above[i] });
        let lost = (0..3).any(|i| past[i] || (still[i] && before[i]));
        if !valid || lost {
            return None;
        }

        let skip = t_free * scale * 0.999_998 - 0.25;
        if skip > 0.25 && skip < 1.0e9 {
            w.skip(&e, (skip * 4.0) as u32);
            let come = each(|i| w.q[i] < e.origin[i]);
            if (w.q[0] | w.q[1] | w.q[2]) >> log2_size == 0 && come == before {
                return Some(w);
            }
        }
        w.axes = 0;
        w.q = e.origin;
        w.frame(e.g.map(|g| g as f32 * FRAC_STEP), e.g.map(|g| (16_777_216 - g) as f32 * FRAC_STEP), 0.0);
        (!before.contains(&true) || w.enter(&e, before, last)).then_some(w)
    }

    /// `rx_walk_step`, and `rx_walk_to` in it.
    #[allow(clippy::float_cmp, reason = "asks which of the three is the minimum")]
    pub(super) fn step(&mut self, block: [u32; 3]) -> bool {
        let last = each(|i| self.q[i] | block[i]);
        let times = each(|i| last[i].wrapping_sub(self.entry[i]) as f32 * self.inv[i] + self.first[i]);
        let t = times[0].min(times[1].min(times[2]));
        let x = times[0] == t;
        let y = !x && times[1] == t;
        let leaves = [x, y, !x && !y];
        let place = each(|i| t * self.d[i] + self.start[i]);
        let rounded = place.map(|place| place + ROUND);
        let cell = rounded.map(|rounded| rounded - ROUND);
        let off = each(|i| (place[i] - cell[i]).abs());
        let most = place.map(|place| (0.5 - 1.5 * WALK_ERROR) - WALK_ERROR * place);
        if (0..3).any(|i| off[i] > most[i] && !leaves[i]) {
            return false;
        }
        let there = |i: usize| self.entry[i].wrapping_add(rounded[i].to_bits().wrapping_sub(ROUND.to_bits()));
        self.q = each(|i| if leaves[i] { last[i].wrapping_add(1) } else { there(i) });
        self.axes = (0..3).fold(0, |axes, i| axes | u32::from(leaves[i]) << i);
        self.t = t;
        true
    }

    /// `rx_walk_settle`.
    pub(super) fn settle(&mut self, ray: &Ray, corner: [i32; 3], log2_size: u32, block: [u32; 3]) {
        let e = self.exact(ray, corner, (1 << log2_size) - 1);
        let here = minus(self.q, e.origin);
        let in_last = minus(each(|i| self.q[i] | block[i]), e.origin);
        let a = e.first(e.d.map(|d| d != 0), in_last, 1, 1);
        self.cross(&e, a, in_last[a].wrapping_add(1), here, in_last.map(|last| last.saturating_add(1)));
    }

    /// `rx_walk_limit`.
    pub(super) fn limit(&self, log2_size: u32, low: [i32; 3], high: [i32; 3]) -> Cell {
        let (last, down) = ((1u32 << log2_size) - 1, self.down());
        each(|i| (if down[i] { last.wrapping_sub(low[i] as u32) } else { high[i] as u32 }).min(last))
    }

    /// `rx_walk_hit`: all of a hit but its material; `None` beyond the ray's end.
    pub(super) fn hit(&self, ray: &Ray, corner: [i32; 3], log2_size: u32) -> Option<Hit> {
        let last = (1 << log2_size) - 1;
        let flip = self.flip(last);
        let voxel = each(|i| corner[i].wrapping_add((self.q[i] ^ flip[i]) as i32));
        let mut place = ray.frac.map(|f| f.clamp(0.0, 1.0));
        let found = |face, t, uv| Some(Hit { voxel, face, material: 0, t, uv, steps: 0 });
        if self.axes == 0 {
            let ended = ray.t_max < 0.0;
            return found(FACE_INSIDE, 0.0, [place[0], place[1]]).filter(|_| !ended);
        }
        let (mut a, mut steepest) = (0, 0.0);
        for i in 0..3 {
            if self.axes & 1 << i != 0 && self.d[i] > steepest {
                (a, steepest) = (i, self.d[i]);
            }
        }
        let face = 2 * a as u32 + (self.down >> a & 1);

        let e = self.exact(ray, corner, last);
        let n = minus(self.q, e.origin);
        let lattice_t = (n[a] as f32 - e.g[a] as f32 * FRAC_STEP) / steepest;
        let t = walk_lengths(ray.dir, lattice_t);
        for b in (0..3).filter(|&b| b != a && e.d[b] != 0) {
            let mirrored = self.down >> b & 1 != 0;
            place[b] = e.gap((a, n[a]), (b, n[b], mirrored)).abs();
        }
        let uv = [[place[1], place[2]], [place[0], place[2]], [place[0], place[1]]][a];
        if ray.t_max >= FAR || t <= ray.t_max { found(face, t, uv) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of a ray through empty blocks of `shift`, and those of them that floating point could not decide.
    fn steps(ray: &Ray, log2_size: u32, shift: u32) -> (u32, u32) {
        let mut walk = Walk::begin(ray, [0; 3], log2_size, 0.0).expect("it begins in the cube");
        let (mut steps, mut settled) = (0, 0);
        while (walk.q[0] | walk.q[1] | walk.q[2]) >> log2_size == 0 {
            steps += 1;
            let block = [(1 << shift) - 1; 3];
            if !walk.step(block) {
                walk.settle(ray, [0; 3], log2_size, block);
                settled += 1;
            }
        }
        (steps, settled)
    }

    #[test]
    fn rays_along_the_axes_need_no_integers() {
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let dir = each(|i| if i == axis { sign } else { 0.0 });
                for frac in [0.0, 0.3, 1.0] {
                    assert_eq!(steps(&Ray::new([128; 3], [frac; 3], dir), 8, 0).1, 0, "{dir:?} {frac}");
                }
            }
        }
    }

    #[test]
    fn few_steps_of_other_rays_do() {
        let mut random = crate::sets::Random::new(5);
        let (mut all, mut settled) = (0, 0);
        for _ in 0..2000 {
            let dir = each(|_| random.below(2_000_001) as f32 * 1e-6 - 1.0);
            let found = steps(&Ray::new([512; 3], [0.25, 0.5, 0.75], dir), 10, 0);
            (all, settled) = (all + found.0, settled + found.1);
        }
        assert!(all > 1_000_000 && settled * 200 < all, "{settled} of {all}");
    }
}
