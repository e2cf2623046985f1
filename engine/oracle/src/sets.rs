//! Seeded sets of rays: ordinary ones, and those that tracers are known to fail on.

use raxel_world::{Bounds, World};

use crate::ray::Ray;

/// A small generator of random numbers, the same everywhere (`SplitMix64`, Steele et al., 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// From any seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// In 0…n − 1.
    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// In 0…1, a multiple of 2⁻²⁴ below 1.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    /// In −1…1.
    fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    fn vector(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| self.signed())
    }

    /// A direction, roughly uniform on the sphere.
    fn direction(&mut self) -> [f32; 3] {
        loop {
            let v = self.vector();
            let square: f32 = v.iter().map(|v| v * v).sum();
            if (0.01..1.0).contains(&square) {
                return v.map(|v| v / square.sqrt());
            }
        }
    }

    /// A cell of a box.
    fn cell(&mut self, [low, high]: [[i64; 3]; 2]) -> [i64; 3] {
        std::array::from_fn(|i| low[i] + self.below((high[i] - low[i]).max(1) as u64) as i64)
    }
}

/// A set of rays.
#[derive(Clone, Copy, Debug)]
pub struct RaySet {
    /// Name.
    pub name: &'static str,
    /// What it holds.
    pub about: &'static str,
    make: fn(&Box3, &World, &mut Random) -> Ray,
}

/// The box of a scene's solids: smallest, and one past the largest coordinates.
type Box3 = [[i64; 3]; 2];

/// Every set.
pub const ALL: &[RaySet] = &[
    RaySet { name: "pinhole", about: "a camera beside the scene, pixels of a 90° view", make: pinhole },
    RaySet { name: "incoherent", about: "any origin in and around the scene, any direction", make: incoherent },
    RaySet { name: "edges", about: "aimed at random places on edges of voxels", make: |b, _, r| aimed(b, r, 2) },
    RaySet { name: "corners", about: "aimed at corners of voxels", make: |b, _, r| aimed(b, r, 3) },
    RaySet {
        name: "lattice",
        about: "from middles, faces and corners along small integer vectors: all ties",
        make: lattice,
    },
    RaySet { name: "grazing", about: "1/1024 voxel beside a lattice plane, slopes of 1e-4 to 1e-7", make: grazing },
    RaySet { name: "zeros", about: "one or two components that are zero, of either sign", make: zeros },
    RaySet { name: "tiny", about: "components from 1e-45 (denormal) to 1e-6", make: tiny },
    RaySet { name: "faces", about: "origins exactly on faces, edges and corners of voxels", make: faces },
    RaySet { name: "inside", about: "origins in solid voxels and on their faces", make: inside },
    RaySet { name: "border", about: "origins on the border of the scene's box, in and out", make: border },
    RaySet { name: "far", about: "origins 1e4 to 2^30 voxels away, aimed at the scene", make: far },
    RaySet { name: "lengths", about: "directions 2^-60 to 2^60 long", make: lengths },
    RaySet { name: "invalid", about: "NaN, infinities, and no direction at all", make: invalid },
];

impl RaySet {
    /// The set of that name.
    pub fn find(name: &str) -> Option<&'static RaySet> {
        ALL.iter().find(|set| set.name == name)
    }

    /// `count` rays for a world, the same for the same seed.
    pub fn rays(&self, world: &World, count: usize, seed: u64) -> Vec<Ray> {
        let bounds = world.bounds().unwrap_or(Bounds { min: [0; 3], max: [64; 3] });
        let name = self.name.bytes().fold(seed, |hash, byte| hash.wrapping_mul(31).wrapping_add(u64::from(byte)));
        let mut random = Random::new(name);
        (0..count).map(|_| (self.make)(&[bounds.min, bounds.max], world, &mut random)).collect()
    }
}

/// A cell in the range of coordinates.
fn clamped(cell: [i64; 3]) -> [i32; 3] {
    cell.map(|c| c.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32)
}

/// The box with a margin of half its size and a few voxels.
fn around(b: &Box3) -> Box3 {
    let margin: [i64; 3] = std::array::from_fn(|i| (b[1][i] - b[0][i]) / 2 + 3);
    [std::array::from_fn(|i| b[0][i] - margin[i]), std::array::from_fn(|i| b[1][i] + margin[i])]
}

fn fraction(random: &mut Random) -> [f32; 3] {
    std::array::from_fn(|_| random.unit())
}

/// From an origin to a point, both as cell and fraction: the difference in `f32`.
fn towards(from: ([i64; 3], [f32; 3]), to: ([i64; 3], [f32; 3])) -> [f32; 3] {
    std::array::from_fn(|i| ((to.0[i] - from.0[i]) as f64 + f64::from(to.1[i]) - f64::from(from.1[i])) as f32)
}

fn pinhole(b: &Box3, _: &World, random: &mut Random) -> Ray {
    // One of 16 cameras.
    let mut camera = Random::new(random.below(16));
    let outside = around(b);
    let (cell, frac) = (camera.cell(outside), fraction(&mut camera));
    let middle: [i64; 3] = std::array::from_fn(|i| i64::midpoint(b[0][i], b[1][i]));
    let forward = towards((cell, frac), (middle, [0.5; 3])).map(|v| v / 200.0);
    let pixel: [f32; 3] = std::array::from_fn(|_| (random.below(1024) as f32 + 0.5) / 512.0 - 1.0);
    Ray::new(clamped(cell), frac, std::array::from_fn(|i| forward[i] + 0.4 * pixel[i]))
}

fn incoherent(b: &Box3, _: &World, random: &mut Random) -> Ray {
    Ray::new(clamped(random.cell(around(b))), fraction(random), random.direction())
}

fn aimed(b: &Box3, random: &mut Random, exact: usize) -> Ray {
    let from = (random.cell(around(b)), fraction(random));
    // All but 3 − `exact` coordinates of the target are integers.
    let mut place = [0.0; 3];
    for _ in exact..3 {
        place[random.below(3) as usize] = random.unit();
    }
    Ray::new(clamped(from.0), from.1, towards(from, (random.cell(*b), place)))
}

fn lattice(b: &Box3, _: &World, random: &mut Random) -> Ray {
    let frac = std::array::from_fn(|_| [0.0, 0.5, 0.25, 1.0][random.below(4) as usize]);
    let dir = std::array::from_fn(|_| random.below(9) as f32 - 4.0);
    Ray::new(clamped(random.cell(around(b))), frac, dir)
}

fn grazing(b: &Box3, _: &World, random: &mut Random) -> Ray {
    let flat = random.below(3) as usize;
    let mut ray = incoherent(b, &World::empty(), random);
    ray.frac[flat] = [1.0 / 1024.0, 1.0 - 1.0 / 1024.0][random.below(2) as usize];
    ray.dir[flat] = [1e-4, -1e-4, 1e-5, -1e-6, 1e-7, -1e-7][random.below(6) as usize];
    ray
}

fn zeros(b: &Box3, _: &World, random: &mut Random) -> Ray {
    let mut ray = incoherent(b, &World::empty(), random);
    for _ in 0..2 {
        ray.dir[random.below(3) as usize] = [0.0, -0.0][random.below(2) as usize];
    }
    if random.below(4) == 0 {
        ray.frac[random.below(3) as usize] = [0.0, 1.0][random.below(2) as usize];
    }
    ray
}

fn tiny(b: &Box3, _: &World, random: &mut Random) -> Ray {
    let mut ray = incoherent(b, &World::empty(), random);
    for _ in 0..2 {
        let size = [1e-45, 1e-40, 1e-38, 1e-30, 1e-20, 1e-12, 1e-9, 1e-7, 1e-6][random.below(9) as usize];
        ray.dir[random.below(3) as usize] = if random.below(2) == 0 { size } else { -size };
    }
    ray
}

fn faces(b: &Box3, _: &World, random: &mut Random) -> Ray {
    let mut ray = incoherent(b, &World::empty(), random);
    for _ in 0..=random.below(3) {
        ray.frac[random.below(3) as usize] = [0.0, 1.0][random.below(2) as usize];
    }
    ray
}

fn inside(b: &Box3, world: &World, random: &mut Random) -> Ray {
    let mut ray = faces(b, world, random);
    for _ in 0..64 {
        let cell = clamped(random.cell(*b));
        if world.voxel(cell.into()) != 0 {
            ray.cell = cell;
            // One voxel beside it: its face is the plane that the ray starts on.
            if random.below(2) == 0 {
                let axis = random.below(3) as usize;
                let side = random.below(2) == 0;
                ray.cell[axis] = ray.cell[axis].saturating_add(if side { 1 } else { -1 });
                ray.frac[axis] = if side { 0.0 } else { 1.0 };
            }
            break;
        }
    }
    ray
}

fn border(b: &Box3, _: &World, random: &mut Random) -> Ray {
    let mut ray = faces(b, &World::empty(), random);
    let axis = random.below(3) as usize;
    let planes = [b[0][axis] - 1, b[0][axis], b[1][axis] - 1, b[1][axis]];
    ray.cell[axis] = clamped([planes[random.below(4) as usize]; 3])[0];
    ray
}

fn far(b: &Box3, _: &World, random: &mut Random) -> Ray {
    let distance = [10_000, 1_000_000, 1 << 24, 1 << 30][random.below(4) as usize];
    let away = random.direction();
    let target = random.cell(*b);
    let cell: [i64; 3] = std::array::from_fn(|i| target[i] + (f64::from(away[i]) * f64::from(distance)) as i64);
    let from = (clamped(cell).map(i64::from), fraction(random));
    Ray::new(clamped(from.0), from.1, towards(from, (target, fraction(random))))
}

fn lengths(b: &Box3, _: &World, random: &mut Random) -> Ray {
    let mut ray = incoherent(b, &World::empty(), random);
    let length = (random.below(121) as f32 - 60.0).exp2();
    ray.dir = ray.dir.map(|d| d * length);
    ray
}

fn invalid(b: &Box3, _: &World, random: &mut Random) -> Ray {
    let mut ray = incoherent(b, &World::empty(), random);
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][random.below(3) as usize];
    match random.below(4) {
        0 => ray.dir = [0.0, -0.0, 0.0],
        1 => ray.dir = ray.dir.map(|_| 1e-40),
        2 => ray.frac[random.below(3) as usize] = bad,
        _ => ray.dir[random.below(3) as usize] = bad,
    }
    ray
}
