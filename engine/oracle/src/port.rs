//! The GPU tracer of the layout `tree64` on the CPU: `shaders/include/raxel/walk.glsl` and `tree64.glsl`, function by function, with the
//! same names and the same `f32` and integer operations, over the same buffer. (`Walk::step` is `rx_walk_step` and, in doubt,
//! `rx_walk_settle`.)

use raxel_world::layout::Tree64Header;

use crate::ray::{FACE_INSIDE, Hit, Ray};

const WALK_ERROR: f32 = 1.0 / 1_048_576.0;
const NEVER: f32 = 1.0e38;
const FRAC_STEP: f32 = 1.0 / 16_777_216.0;
const DIR_STEP: f32 = 1.0 / 1_073_741_824.0;
const FILLED: u32 = 0x8000_0000;
const UNIFORM: u32 = 0x4000_0000;

/// The exact walk of a lattice ray through a cube; see `walk.glsl`.
#[derive(Clone, Copy, Debug, Default)]
struct Walk {
    q: [u32; 3],
    entry: [u32; 3],
    origin: [u32; 3],
    g_fixed: [u32; 3],
    d_fixed: [u32; 3],
    g: [f32; 3],
    h: [f32; 3],
    d: [f32; 3],
    inv: [f32; 3],
    t: f32,
    axes: u32,
    flip: [u32; 3],
}

fn lattice_component(bits: u32, top: u32) -> u32 {
    let exponent = bits >> 23 & 0xff;
    let shift = top - exponent;
    if exponent == 0 || shift > 30 { 0 } else { ((bits & 0x7f_ffff | 0x80_0000) << 7) >> shift }
}

fn lattice_top(dir: [f32; 3]) -> u32 {
    let exponent = |v: f32| v.to_bits() >> 23 & 0xff;
    exponent(dir[0]).max(exponent(dir[1])).max(exponent(dir[2]))
}

fn not_finite(v: [f32; 3]) -> bool {
    v.iter().any(|v| v.to_bits() & 0x7f80_0000 == 0x7f80_0000)
}

impl Walk {
    /// Whole part and 24-bit rest (to be subtracted) of how far plane `n_b` of axis `b` is ahead when plane `n_a` of `a` is crossed.
    fn ahead(&self, a: usize, n_a: u32, b: usize, n_b: u32) -> (i64, u32) {
        let (d_a, d_b) = (i64::from(self.d_fixed[a]), i64::from(self.d_fixed[b]));
        // The GPU's 64-bit words wrap as these do.
        let planes = i64::from(n_b).wrapping_mul(d_a).wrapping_sub(i64::from(n_a).wrapping_mul(d_b));
        let start = i64::from(self.g_fixed[b]) * d_a - i64::from(self.g_fixed[a]) * d_b;
        (planes.wrapping_sub(start >> 24), start as u32 & 0xff_ffff)
    }

    fn compare(&self, a: usize, n_a: u32, b: usize, n_b: u32) -> i32 {
        let (whole, rest) = self.ahead(a, n_a, b, n_b);
        if whole == 0 {
            return if rest == 0 { 0 } else { -1 };
        }
        if whole < 0 { -1 } else { 1 }
    }

    fn gap(&self, a: usize, n_a: u32, b: usize, n_b: u32) -> f32 {
        let (whole, rest) = self.ahead(a, n_a, b, n_b);
        let behind = whole < 0;
        let size = if behind { 0u32.wrapping_sub(whole as u32) } else { whole as u32 };
        let gap = size as f32 + (if behind { 1.0 } else { -1.0 }) * (rest as f32 * FRAC_STEP);
        ((if behind { -gap } else { gap }) / self.d_fixed[a] as f32).clamp(-1.0, 1.0)
    }

    fn count(&self, a: usize, n_a: u32, b: usize, mut low: u32, mut high: u32) -> u32 {
        for _ in 0..32 {
            if low >= high {
                break;
            }
            let middle = high - ((high - low) >> 1);
            if self.compare(a, n_a, b, middle) <= 0 {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        low
    }

    fn enter(&mut self, before: [bool; 3], last: u32) -> bool {
        let enter = self.origin.map(|origin| 0u32.wrapping_sub(origin));
        let mut a = before.iter().position(|before| *before).unwrap_or(0);
        for b in a + 1..3 {
            if before[b] && self.compare(a, enter[a], b, enter[b]) > 0 {
                a = b;
            }
        }
        let n_a = enter[a];
        let t = (n_a as f32 - self.g_fixed[a] as f32 * FRAC_STEP) / (self.d_fixed[a] as f32 * DIR_STEP);
        self.axes = 1 << a;
        (self.q[a], self.g[a], self.h[a]) = (0, 0.0, 1.0);
        for b in (0..3).filter(|&b| b != a) {
            let (d_b, start) = (self.d_fixed[b], self.origin[b]);
            if d_b == 0 {
                continue;
            }
            let mut high = last.wrapping_sub(start);
            if self.compare(a, n_a, b, high.wrapping_add(1)) <= 0 {
                return false;
            }
            let mut low = if before[b] { enter[b] } else { 0 };
            let x = t * (d_b as f32 * DIR_STEP) + self.g_fixed[b] as f32 * FRAC_STEP;
            let error = (x + 1.0) * (4.0 * WALK_ERROR);
            if x - error > low as f32 {
                low = low.max((x - error).min(4.294_967e9) as u32);
            }
            if x + error < high as f32 {
                high = high.min((x + error).max(0.0) as u32);
            }
            let count = self.count(a, n_a, b, low.min(high), high);
            if count != 0 && self.compare(a, n_a, b, count) == 0 {
                self.axes |= 1 << b;
            }
            self.q[b] = start.wrapping_add(count);
            self.g[b] = -self.gap(a, n_a, b, count);
            self.h[b] = self.gap(a, n_a, b, count.wrapping_add(1));
        }
        self.entry = self.q;
        true
    }

    fn begin(ray: &Ray, corner: [i32; 3], log2_size: u32) -> Option<Self> {
        let last = (1u32 << log2_size) - 1;
        let top = lattice_top(ray.dir);
        if top == 0 || not_finite(ray.dir) || not_finite(ray.frac) {
            return None;
        }
        let mut walk = Self::default();
        let (mut before, mut lost) = ([false; 3], false);
        for i in 0..3 {
            let bits = ray.dir[i].to_bits();
            let d = lattice_component(bits, top);
            let still = d == 0;
            let down = bits >> 31 != 0 && !still;
            let frac = (ray.frac[i].clamp(0.0, 1.0) * 16_777_216.0) as u32;
            let relative = (ray.cell[i] as u32).wrapping_sub(corner[i] as u32);
            walk.d_fixed[i] = d;
            walk.g_fixed[i] = if still {
                0
            } else if down {
                16_777_216 - frac
            } else {
                frac
            };
            walk.flip[i] = if down { last } else { 0 };
            walk.origin[i] = if down { last.wrapping_sub(relative) } else { relative };
            walk.g[i] = walk.g_fixed[i] as f32 * FRAC_STEP;
            walk.h[i] = (16_777_216 - walk.g_fixed[i]) as f32 * FRAC_STEP;
            walk.d[i] = d as f32 * DIR_STEP;
            walk.inv[i] = if still { 0.0 } else { 1.0 / walk.d[i].max(1.0e-20) };
            let (below, above) = (ray.cell[i] < corner[i], ray.cell[i] > corner[i].wrapping_add(last as i32));
            before[i] = if down { above } else { below };
            lost |= (if down { below } else { above }) || (still && before[i]);
        }
        walk.q = walk.origin;
        walk.entry = walk.origin;
        if lost || (before.contains(&true) && !walk.enter(before, last)) {
            return None;
        }
        Some(walk)
    }

    fn decide(&self, end: [u32; 3], a: &mut usize, low: &mut [u32; 3], high: &mut [u32; 3]) -> u32 {
        let minus = |x: [u32; 3], y: [u32; 3]| [0, 1, 2].map(|i| x[i].wrapping_sub(y[i]));
        let ends = minus(end, self.origin);
        let base = minus(self.entry, self.origin);
        let (here, block) = (minus(self.q, self.entry), minus(end, self.entry));
        let mut others = 7 & !(1u32 << *a);
        while others != 0 {
            let b = others.trailing_zeros() as usize;
            others &= others - 1;
            if high[b] == block[b] && self.compare(*a, ends[*a], b, ends[b]) < 0 {
                *a = b;
                *low = here;
                *high = block;
                others = 7 & !(1 << *a);
            }
        }
        let mut axes = 0;
        for b in (0..3).filter(|b| b != a) {
            let at = base[b];
            let count = self.count(*a, ends[*a], b, low[b].wrapping_add(at), high[b].wrapping_add(at));
            low[b] = count.wrapping_sub(at);
            if low[b] != here[b] && self.compare(*a, ends[*a], b, count) == 0 {
                axes |= 1 << b;
            }
        }
        axes
    }

    #[allow(clippy::float_cmp, reason = "asks which of the three is the minimum, and whether an axis stands still")]
    fn step(&mut self, shift: u32) {
        let end = self.q.map(|q| (q | ((1 << shift) - 1)) + 1);
        let block = [0, 1, 2].map(|i| end[i] - self.entry[i]);
        let times = [0, 1, 2]
            .map(|i| if self.inv[i] == 0.0 { NEVER } else { ((block[i] - 1) as f32 + self.h[i]) * self.inv[i] });
        let t = times[0].min(times[1].min(times[2]));
        let mut a = if times[0] == t {
            0
        } else if times[1] == t {
            1
        } else {
            2
        };
        let (mut low, mut high) = ([0; 3], [0; 3]);
        for i in 0..3 {
            let x = t * self.d[i] + self.g[i];
            let error = (x + 1.0) * WALK_ERROR;
            low[i] = ((x - error).max(0.0) as u32).max(self.q[i] - self.entry[i]);
            high[i] = ((x + error) as u32).min(block[i]).max(low[i]);
        }
        self.axes = 0;
        if (0..3).any(|i| i != a && low[i] != high[i]) {
            self.axes = self.decide(end, &mut a, &mut low, &mut high);
        }
        self.q = [0, 1, 2].map(|i| self.entry[i] + low[i]);
        self.q[a] = end[a];
        self.axes |= 1 << a;
        self.t = t;
    }

    /// The hit but for its material; `None` beyond the ray's end.
    fn hit(&self, ray: &Ray, corner: [i32; 3]) -> Option<Hit> {
        let voxel = [0, 1, 2].map(|i| corner[i].wrapping_add((self.q[i] ^ self.flip[i]) as i32));
        let mut place = ray.frac.map(|f| f.clamp(0.0, 1.0));
        let found = |face, t, uv| Some(Hit { voxel, face, material: 0, t, uv, steps: 0 });
        if self.axes == 0 {
            return found(FACE_INSIDE, 0.0, [place[0], place[1]]);
        }
        let (mut a, mut steepest) = (3, 0);
        for i in 0..3 {
            if self.axes & 1 << i != 0 && self.d_fixed[i] > steepest {
                (a, steepest) = (i, self.d_fixed[i]);
            }
        }
        let n = [0, 1, 2].map(|i| self.q[i].wrapping_sub(self.origin[i]));
        let lattice_t = (n[a] as f32 - self.g_fixed[a] as f32 * FRAC_STEP) / (steepest as f32 * DIR_STEP);
        let t = lattice_t * f32::from_bits((254u32.saturating_sub(lattice_top(ray.dir))).max(1) << 23);
        for b in (0..3).filter(|&b| b != a && self.d_fixed[b] != 0) {
            let mirrored = self.flip[b] != 0;
            let gap = self.gap(a, n[a], b, n[b].wrapping_add(u32::from(mirrored)));
            place[b] = (if mirrored { gap } else { -gap }).clamp(0.0, 1.0);
        }
        let uv = [[place[1], place[2]], [place[0], place[2]], [place[0], place[1]]][a];
        let face = 2 * a as u32 + u32::from(self.flip[a] != 0);
        if t <= ray.t_max { found(face, t, uv) } else { None }
    }

    fn t_end(ray: &Ray) -> f32 {
        if ray.t_max >= 1.0e37 {
            return 3.0e38;
        }
        ray.t_max * f32::from_bits(lattice_top(ray.dir).clamp(1, 253) << 23) * 1.0001 + 1.0e-3
    }
}

/// A world buffer of the layout `tree64`.
#[derive(Clone, Copy, Debug)]
pub struct Tree64<'a> {
    header: Tree64Header,
    words: &'a [u32],
}

/// Occupancy of the children of a node.
type Mask = u64;

/// A node of 16³ voxels or more.
#[derive(Clone, Copy, Debug)]
struct Node {
    mask: Mask,
    children: u32,
    material: u32,
}

fn child_of(q: [u32; 3], height: u32) -> u32 {
    let [x, y, z] = q.map(|q| q >> (2 * height - 2) & 3);
    x | z << 2 | y << 4
}

fn has_child(mask: Mask, child: u32) -> bool {
    mask >> child & 1 != 0
}

fn child_rank(mask: Mask, child: u32) -> u32 {
    (mask & ((1 << child) - 1)).count_ones()
}

fn free_octet(mask: Mask, child: u32) -> bool {
    mask >> (child & 42) & 0x0033_0033 == 0
}

impl<'a> Tree64<'a> {
    /// Reads a buffer that [`raxel_world::layout::Layout::encode`] wrote.
    pub fn new(buffer: &'a [u32]) -> Self {
        let (header, words) = buffer.split_at(Tree64Header::WORDS as usize);
        Self { header: *bytemuck::from_bytes(bytemuck::cast_slice(header)), words }
    }

    fn mask_at(&self, word: usize) -> Mask {
        u64::from(self.words[word]) | u64::from(self.words[word + 1]) << 32
    }

    fn node(&self, at: u32) -> Node {
        let at = 4 * at as usize;
        Node { mask: self.mask_at(at), children: self.words[at + 2], material: self.words[at + 3] }
    }

    fn leaf(&self, leaf: u32) -> Mask {
        self.mask_at(2 * leaf as usize)
    }

    fn leaf_material(&self, material: u32, rank: u32, leaf: Mask, voxel: u32) -> u32 {
        if material & (FILLED | UNIFORM) != 0 {
            return material & 0xffff;
        }
        let link = self.words[(material + rank) as usize];
        if link & UNIFORM != 0 {
            return link & 0xffff;
        }
        let half_word = link + child_rank(leaf, voxel);
        self.words[(half_word >> 1) as usize] >> ((half_word & 1) * 16) & 0xffff
    }

    /// Material of a voxel, 0 for air: `rx_material`.
    pub fn material(&self, cell: [i32; 3]) -> u32 {
        let c = [0, 1, 2].map(|i| (cell[i] as u32).wrapping_sub(self.header.origin[i] as u32));
        if (c[0] | c[1] | c[2]) >> self.header.log2_size != 0 {
            return 0;
        }
        let mut node = self.node(self.header.root);
        let mut height = self.header.log2_size >> 1;
        loop {
            let child = child_of(c, height);
            if !has_child(node.mask, child) {
                return 0;
            }
            if node.material & FILLED != 0 {
                return node.material & 0xffff;
            }
            let rank = child_rank(node.mask, child);
            if height == 2 {
                let leaf = self.leaf(node.children + rank);
                let voxel = child_of(c, 1);
                return if has_child(leaf, voxel) { self.leaf_material(node.material, rank, leaf, voxel) } else { 0 };
            }
            node = self.node(node.children + rank);
            height -= 1;
        }
    }

    /// First solid voxel along a ray: `rx_trace`.
    pub fn trace(&self, ray: &Ray) -> Option<Hit> {
        let log2_size = self.header.log2_size;
        let mut walk = Walk::begin(ray, self.header.origin, log2_size)?;
        let t_end = Walk::t_end(ray);
        let mirror = walk.flip[0] & 3 | (walk.flip[2] & 3) << 2 | (walk.flip[1] & 3) << 4;

        let mut ancestors = [0u32; 16];
        let mut height = log2_size >> 1;
        let mut at = self.header.root;
        let mut node = self.node(at);
        let rounds = if log2_size < 30 { 4 << log2_size } else { u32::MAX };
        for i in 1..rounds {
            let mut child = child_of(walk.q, height) ^ mirror;
            let mut occupied = has_child(node.mask, child);
            while occupied && height > 2 && node.material & FILLED == 0 {
                ancestors[height as usize] = at;
                at = node.children + child_rank(node.mask, child);
                height -= 1;
                node = self.node(at);
                child = child_of(walk.q, height) ^ mirror;
                occupied = has_child(node.mask, child);
            }
            let (mut mask, mut shift) = (node.mask, 2 * height - 2);
            if occupied {
                let (mut rank, mut leaf, mut voxel) = (0, 0, 0);
                if node.material & FILLED == 0 {
                    rank = child_rank(node.mask, child);
                    leaf = self.leaf(node.children + rank);
                    voxel = child_of(walk.q, 1) ^ mirror;
                }
                if node.material & FILLED != 0 || has_child(leaf, voxel) {
                    let material = self.leaf_material(node.material, rank, leaf, voxel);
                    return walk.hit(ray, self.header.origin).map(|hit| Hit { material, steps: i, ..hit });
                }
                (mask, child, shift) = (leaf, voxel, 0);
            }
            let before = walk.q;
            walk.step(shift + u32::from(free_octet(mask, child)));
            if (walk.q[0] | walk.q[1] | walk.q[2]) >> log2_size != 0 || walk.t > t_end {
                return None;
            }
            let changed = (before[0] ^ walk.q[0]) | (before[1] ^ walk.q[1]) | (before[2] ^ walk.q[2]);
            let top = changed.ilog2() / 2 + 1;
            if top > height {
                height = top;
                at = ancestors[height as usize];
                node = self.node(at);
            }
        }
        None
    }
}
