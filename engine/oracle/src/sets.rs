//! Seeded sets of rays: ordinary ones, and those that tracers are known to fail on.

use glam::{Mat4, Vec2, Vec3};
use raxel_ray::Ray;
use raxel_ray::camera::{Pinhole, Tile};
use raxel_world::random::SplitMix64;
use raxel_world::{Bounds, World};

/// Random numbers, places and directions, the same everywhere.
#[derive(Clone, Debug)]
pub struct Random(SplitMix64);

impl Random {
    /// From any seed.
    pub fn new(seed: u64) -> Self {
        Self(SplitMix64::new(seed))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    /// In 0…n − 1, by the remainder: the sets that published figures were measured with are made this way.
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
    make: Make,
}

#[derive(Clone, Copy, Debug)]
enum Make {
    /// Ray by ray.
    Rays(fn(&RayTargets, &mut Random) -> Ray),
    /// The rays of a tile of pixels one after another.
    Tiles(fn(&RayTargets, &mut Random) -> Tile),
    /// Rays of one direction from 8 × 8 places in a plane, row by row.
    Grids(fn(&RayTargets, &mut Random) -> [Ray; Tile::RAYS]),
}

/// The box of a scene's solids: smallest, and one past the largest coordinates.
type Box3 = [[i64; 3]; 2];

/// What rays are aimed at: a world's box, and some of its solid voxels.
#[derive(Clone, Debug)]
pub struct RayTargets {
    bounds: Box3,
    solids: Vec<[i64; 3]>,
}

/// Solid voxels that are remembered at most.
const REMEMBERED: usize = 4096;

impl RayTargets {
    /// Of a world. The voxels are evenly spread over the order of the world's chunks.
    pub fn of(world: &World) -> Self {
        let bounds = world.bounds().unwrap_or(Bounds { min: [0; 3], max: [64; 3] });
        let every = (world.solids() as usize).div_ceil(REMEMBERED).max(1);
        let solids = world.voxels().step_by(every).map(|(voxel, _)| voxel.to_array().map(i64::from)).collect();
        Self { bounds: [bounds.min, bounds.max], solids }
    }

    /// A solid voxel; any cell of the box of an empty world.
    fn solid(&self, random: &mut Random) -> [i64; 3] {
        match self.solids.len() {
            0 => random.cell(self.bounds),
            n => self.solids[random.below(n as u64) as usize],
        }
    }
}

/// Every set.
pub const ALL: &[RaySet] = &[
    RaySet { name: "pinhole", about: "cameras beside the scene, pixels of a 90° view", make: Make::Rays(pinhole) },
    RaySet {
        name: "incoherent",
        about: "any origin in and around the scene, any direction",
        make: Make::Rays(incoherent),
    },
    RaySet { name: "bounce", about: "from faces of solid voxels in any direction outwards", make: Make::Rays(bounce) },
    RaySet {
        name: "edges",
        about: "aimed at random places on edges of the lattice",
        make: Make::Rays(|p, r| aimed(p, r, 2)),
    },
    RaySet { name: "corners", about: "aimed at corners of the lattice", make: Make::Rays(|p, r| aimed(p, r, 3)) },
    RaySet { name: "silhouettes", about: "aimed at edges and corners of solid voxels", make: Make::Rays(silhouettes) },
    RaySet {
        name: "lattice",
        about: "from middles, faces and corners along small integer vectors: all ties",
        make: Make::Rays(lattice),
    },
    RaySet {
        name: "near-ties",
        about: "the same, turned by a few units in the last place",
        make: Make::Rays(near_ties),
    },
    RaySet {
        name: "grazing",
        about: "1/1024 voxel beside a lattice plane, slopes of 1e-4 to 1e-7",
        make: Make::Rays(grazing),
    },
    RaySet { name: "zeros", about: "one or two components that are zero, of either sign", make: Make::Rays(zeros) },
    RaySet { name: "tiny", about: "components from 1e-45 (denormal) to 1e-6", make: Make::Rays(tiny) },
    RaySet { name: "faces", about: "origins exactly on faces, edges and corners of voxels", make: Make::Rays(faces) },
    RaySet { name: "inside", about: "origins in solid voxels and on their faces", make: Make::Rays(inside) },
    RaySet { name: "border", about: "origins on the border of the scene's box, in and out", make: Make::Rays(border) },
    RaySet {
        name: "outside",
        about: "origins outside the scene's box, pointing away and past it",
        make: Make::Rays(outside),
    },
    RaySet { name: "far", about: "origins 1e4 to 2^31 voxels away, aimed at the scene", make: Make::Rays(far) },
    RaySet {
        name: "far-pinhole",
        about: "cameras 1e4 to 2^31 voxels away, a narrow view",
        make: Make::Rays(far_pinhole),
    },
    RaySet { name: "lengths", about: "directions 2^-60 to 2^60 long", make: Make::Rays(lengths) },
    RaySet { name: "ends", about: "aimed at solids, ending (t_max) before, at or behind them", make: Make::Rays(ends) },
    RaySet { name: "tiles", about: "8 × 8 pixels of random views, which share a beam", make: Make::Tiles(tile) },
    RaySet {
        name: "octant-tiles",
        about: "8 × 8 pixels around the middle of views along an axis or a diagonal, so that rays of several octants meet",
        make: Make::Tiles(octant_tile),
    },
    RaySet {
        name: "grazing-tiles",
        about: "8 × 8 pixels around the horizon of views 1/1024 voxel beside a lattice plane, or in it",
        make: Make::Tiles(grazing_tile),
    },
    RaySet {
        name: "lattice-tiles",
        about: "8 × 8 pixels of views along an axis, from lattice points, with pixels in small integer ratios: ties",
        make: Make::Tiles(lattice_tile),
    },
    RaySet {
        name: "parallel",
        about: "8 × 8 rays of one direction, from a plane far off or from one beside a solid voxel",
        make: Make::Grids(parallel),
    },
    RaySet {
        name: "parallel-ties",
        about: "8 × 8 rays along an axis or a diagonal, from places 1/4 voxel to 1 apart: ties",
        make: Make::Grids(parallel_ties),
    },
    RaySet { name: "invalid", about: "NaN, infinities, and no direction at all", make: Make::Rays(invalid) },
];

impl RaySet {
    /// Rays of a block.
    pub const BLOCK: usize = 1024;

    /// The set of that name.
    pub fn find(name: &str) -> Option<&'static RaySet> {
        ALL.iter().find(|set| set.name == name)
    }

    /// The first `count` (at most [`RaySet::BLOCK`]) rays of a block: the same for the same targets, seed and number, whoever makes the
    /// blocks and in whatever order.
    pub fn block(&self, targets: &RayTargets, seed: u64, number: u64, count: usize) -> Vec<Ray> {
        let count = count.min(Self::BLOCK);
        let mut random = self.random(seed, number);
        match self.make {
            Make::Rays(make) => (0..count).map(|_| make(targets, &mut random)).collect(),
            Make::Grids(make) => {
                (0..count.div_ceil(Tile::RAYS)).flat_map(|_| make(targets, &mut random)).take(count).collect()
            }
            Make::Tiles(_) => {
                self.tiles(targets, seed, number, count).iter().flat_map(Tile::rays).take(count).collect()
            }
        }
    }

    /// The tiles that the first `count` rays of a block belong to, in order; none if the set is not made of tiles.
    pub fn tiles(&self, targets: &RayTargets, seed: u64, number: u64, count: usize) -> Vec<Tile> {
        let Make::Tiles(make) = self.make else { return Vec::new() };
        let mut random = self.random(seed, number);
        (0..count.min(Self::BLOCK).div_ceil(Tile::RAYS)).map(|_| make(targets, &mut random)).collect()
    }

    /// Whether its rays are those of tiles, one tile after another.
    pub fn is_of_tiles(&self) -> bool {
        matches!(self.make, Make::Tiles(_))
    }

    /// The random numbers of a block.
    fn random(&self, seed: u64, number: u64) -> Random {
        let name = self.name.bytes().fold(seed, |hash, byte| hash.wrapping_mul(31).wrapping_add(u64::from(byte)));
        // Seeds of neighbouring blocks are far apart in the generator's sequence.
        Random::new(Random::new(name ^ Random::new(number).bits()).bits())
    }

    /// `count` rays for a world: the blocks one after another.
    pub fn rays(&self, world: &World, count: usize, seed: u64) -> Vec<Ray> {
        let targets = RayTargets::of(world);
        let blocks = count.div_ceil(Self::BLOCK) as u64;
        let mut rays: Vec<Ray> =
            (0..blocks).flat_map(|number| self.block(&targets, seed, number, Self::BLOCK)).collect();
        rays.truncate(count);
        rays
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

/// The middle of the box.
fn middle(b: &Box3) -> [i64; 3] {
    std::array::from_fn(|i| i64::midpoint(b[0][i], b[1][i]))
}

fn pinhole(targets: &RayTargets, random: &mut Random) -> Ray {
    // One of 16 cameras.
    let mut camera = Random::new(random.below(16));
    let (cell, frac) = (camera.cell(around(&targets.bounds)), fraction(&mut camera));
    let aim = towards((cell, frac), (middle(&targets.bounds), [0.5; 3]));
    let length = aim.iter().map(|v| v * v).sum::<f32>().sqrt().max(1.0);
    let forward = aim.map(|v| v / length);
    let pixel: [f32; 3] = std::array::from_fn(|_| (random.below(1024) as f32 + 0.5) / 512.0 - 1.0);
    Ray::new(clamped(cell), frac, std::array::from_fn(|i| forward[i] + 0.7 * pixel[i]))
}

fn incoherent(targets: &RayTargets, random: &mut Random) -> Ray {
    Ray::new(clamped(random.cell(around(&targets.bounds))), fraction(random), random.direction())
}

/// As `rx_ray_from_face` begins a ray: in the neighbour's cube, exactly on the shared plane.
fn bounce(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut cell = targets.solid(random);
    let (axis, side) = (random.below(3) as usize, random.below(2) == 0);
    cell[axis] += if side { 1 } else { -1 };
    let mut frac = fraction(random);
    frac[axis] = if side { 0.0 } else { 1.0 };
    let mut dir = random.direction();
    dir[axis] = if side { dir[axis].abs() } else { -dir[axis].abs() };
    Ray::new(clamped(cell), frac, dir)
}

/// From anywhere around the scene to a point of a cell of which `exact` coordinates are integers.
fn aim(targets: &RayTargets, random: &mut Random, target: [i64; 3], exact: usize) -> Ray {
    let from = (random.cell(around(&targets.bounds)), fraction(random));
    let mut at = [0.0; 3];
    for _ in exact..3 {
        at[random.below(3) as usize] = random.unit();
    }
    Ray::new(clamped(from.0), from.1, towards(from, (target, at)))
}

fn aimed(targets: &RayTargets, random: &mut Random, exact: usize) -> Ray {
    let target = random.cell(targets.bounds);
    aim(targets, random, target, exact)
}

fn silhouettes(targets: &RayTargets, random: &mut Random) -> Ray {
    let corner = [0, 1, 2].map(|_| random.below(2) as i64);
    let solid = targets.solid(random);
    let exact = 2 + random.below(2) as usize;
    aim(targets, random, [0, 1, 2].map(|i| solid[i] + corner[i]), exact)
}

fn lattice(targets: &RayTargets, random: &mut Random) -> Ray {
    let frac = std::array::from_fn(|_| [0.0, 0.5, 0.25, 1.0][random.below(4) as usize]);
    let dir = std::array::from_fn(|_| random.below(9) as f32 - 4.0);
    Ray::new(clamped(random.cell(around(&targets.bounds))), frac, dir)
}

fn near_ties(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = lattice(targets, random);
    for _ in 0..2 {
        let d = &mut ray.dir[random.below(3) as usize];
        *d = f32::from_bits(d.to_bits().wrapping_add(random.below(7) as u32).wrapping_sub(3));
        // A zero has no neighbours but denormals and NaN.
        if !d.is_normal() {
            *d = 1.0;
        }
    }
    ray
}

fn grazing(targets: &RayTargets, random: &mut Random) -> Ray {
    let flat = random.below(3) as usize;
    let mut ray = incoherent(targets, random);
    ray.frac[flat] = [1.0 / 1024.0, 1.0 - 1.0 / 1024.0][random.below(2) as usize];
    ray.dir[flat] = [1e-4, -1e-4, 1e-5, -1e-6, 1e-7, -1e-7][random.below(6) as usize];
    // Half of them beside a face of a solid voxel.
    if random.below(2) == 0 {
        let plane = targets.solid(random)[flat] + [-1, 0, 1][random.below(3) as usize];
        ray.cell[flat] = clamped([plane; 3])[0];
    }
    ray
}

fn zeros(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    for _ in 0..2 {
        ray.dir[random.below(3) as usize] = [0.0, -0.0][random.below(2) as usize];
    }
    if random.below(4) == 0 {
        ray.frac[random.below(3) as usize] = [0.0, 1.0][random.below(2) as usize];
    }
    ray
}

fn tiny(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    for _ in 0..2 {
        let size = [1e-45, 1e-40, 1e-38, 1e-30, 1e-20, 1e-12, 1e-9, 1e-7, 1e-6][random.below(9) as usize];
        ray.dir[random.below(3) as usize] = if random.below(2) == 0 { size } else { -size };
    }
    ray
}

fn faces(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    for _ in 0..=random.below(3) {
        ray.frac[random.below(3) as usize] = [0.0, 1.0][random.below(2) as usize];
    }
    ray
}

fn inside(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = faces(targets, random);
    ray.cell = clamped(targets.solid(random));
    // One voxel beside it: its face is the plane that the ray starts on.
    if random.below(2) == 0 {
        let axis = random.below(3) as usize;
        let side = random.below(2) == 0;
        ray.cell[axis] = ray.cell[axis].saturating_add(if side { 1 } else { -1 });
        ray.frac[axis] = if side { 0.0 } else { 1.0 };
    }
    ray
}

fn border(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = faces(targets, random);
    let axis = random.below(3) as usize;
    let [low, high] = targets.bounds.map(|corner| corner[axis]);
    ray.cell[axis] = clamped([[low - 1, low, high - 1, high][random.below(4) as usize]; 3])[0];
    ray
}

fn outside(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    let axis = random.below(3) as usize;
    let up = random.below(2) == 0;
    let reach = 1 << random.below(24);
    let away = 1 + random.below(reach) as i64;
    let cell = if up { targets.bounds[1][axis] - 1 + away } else { targets.bounds[0][axis] - away };
    ray.cell[axis] = clamped([cell; 3])[0];
    // One in four points away, the others may hit.
    let d = ray.dir[axis].abs();
    let inwards = random.below(4) != 0;
    ray.dir[axis] = if up == inwards { -d } else { d };
    ray
}

/// An origin at one of several distances from a target, as far as coordinates reach.
fn away(random: &mut Random, target: [i64; 3]) -> ([i64; 3], [f32; 3]) {
    let distance = [1e4, 1e6, 16_777_216.0, 1_073_741_824.0, 4_294_967_296.0][random.below(5) as usize];
    let direction = random.direction();
    let cell = std::array::from_fn(|i| target[i] + (f64::from(direction[i]) * distance) as i64);
    (clamped(cell).map(i64::from), fraction(random))
}

fn far(targets: &RayTargets, random: &mut Random) -> Ray {
    let target = if random.below(2) == 0 { targets.solid(random) } else { random.cell(targets.bounds) };
    let from = away(random, target);
    Ray::new(clamped(from.0), from.1, towards(from, (target, fraction(random))))
}

fn far_pinhole(targets: &RayTargets, random: &mut Random) -> Ray {
    // One of 16 cameras.
    let from = away(&mut Random::new(random.below(16)), middle(&targets.bounds));
    let target = random.cell(around(&targets.bounds));
    Ray::new(clamped(from.0), from.1, towards(from, (target, [0.5; 3])))
}

fn lengths(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    let length = (random.below(121) as f32 - 60.0).exp2();
    ray.dir = ray.dir.map(|d| d * length);
    ray
}

/// Aimed at the middle of a solid voxel, which is one length of the direction away. Something may stand before it.
fn ends(targets: &RayTargets, random: &mut Random) -> Ray {
    let target = targets.solid(random);
    let from = (random.cell(around(&targets.bounds)), fraction(random));
    let ray = Ray::new(clamped(from.0), from.1, towards(from, (target, [0.5; 3])));
    // Half a voxel before the middle the ray is on the face, or nearly.
    let face = 1.0 - 0.5 / ray.dir.iter().fold(1.0f32, |most, d| most.max(d.abs()));
    let near = [1.0 - 1e-3, 1.0 - 1e-6, 1.0, 1.0 + 1e-6, 1.0 + 1e-3][random.below(5) as usize];
    let t_max = match random.below(4) {
        0 => 2.0 * random.unit(),
        1 => near,
        _ => face * near,
    };
    Ray { t_max, ..ray }
}

/// From within, from a solid voxel, or from some way off; towards a solid voxel or past it; rolled by any angle. No angle is asked for, as
/// sines differ between systems.
fn tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let target = targets.solid(random);
    let cell = match random.below(8) {
        0 => targets.solid(random),
        1 | 2 => {
            let (direction, distance) = (random.direction(), [500.0, 5000.0, 15_000.0][random.below(3) as usize]);
            std::array::from_fn(|i| target[i] + (direction[i] * distance) as i64)
        }
        _ => random.cell(around(&targets.bounds)),
    };
    let (cell, frac) = (clamped(cell), if random.below(4) == 0 { [0.0; 3] } else { fraction(random) });
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
    let size = [[16, 16], [64, 64], [320, 184], [1280, 720], [3840, 2160]][random.below(5) as usize];
    let half_height = [0.006, 0.18, 0.58, 1.2, 12.0][random.below(5) as usize];
    let first = size.map(|side| random.below(u64::from(side / Tile::SIDE)) as u32 * Tile::SIDE);
    tile_of((cell.map(i64::from), frac), [right, up, forward], size, half_height, first)
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
    let forward = random.below(3) as usize;
    let right = (forward + 1 + random.below(2) as usize) % 3;
    let mut signed = |axis: usize| if random.below(2) == 0 { Vec3::AXES[axis] } else { -Vec3::AXES[axis] };
    let (forward, right) = (signed(forward), signed(right));
    [right, right.cross(forward), forward]
}

/// Odd sizes have pixels exactly in the middle, whose directions have components of zero.
const TILE_SIZES: [[u32; 2]; 6] = [[16, 16], [17, 17], [65, 33], [321, 183], [1280, 720], [3840, 2160]];

fn octant_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let [right, up, forward] = along_axes(random);
    // Along an axis, or halfway to another one, where one axis is the border.
    let view = match random.below(3) {
        0 => [right, (up - forward).normalize(), (up + forward).normalize()],
        1 => [(right - forward).normalize(), up, (right + forward).normalize()],
        _ => [right, up, forward],
    };
    let size = TILE_SIZES[random.below(6) as usize];
    let half_height = [0.006, 0.18, 0.58, 1.2][random.below(4) as usize];
    let frac = if random.below(4) == 0 { [0.0; 3] } else { fraction(random) };
    let first = tile_at(random, size, [0.5; 2]);
    tile_of((random.cell(around(&targets.bounds)), frac), view, size, half_height, first)
}

fn grazing_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let view = along_axes(random);
    let [right, up, forward] = view;
    // Beside the upper or lower side of a solid voxel, some way off.
    let (solid, distance) = (targets.solid(random), [3.0_f32, 40.0, 600.0][random.below(3) as usize]);
    let side = if random.below(2) == 0 { up } else { -up };
    let cell = std::array::from_fn(|i| solid[i] + (side[i] - distance * forward[i]) as i64);
    let beside = [0.0, 1.0 / 1024.0, 0.5, 1023.0 / 1024.0][random.below(4) as usize];
    let frac = std::array::from_fn(|i| if up[i].abs() < 0.5 { random.unit() } else { beside });
    // Tilted by next to nothing, or by nothing.
    let tilt: f32 = [0.0, 1e-6, 1e-4, 1e-2][random.below(4) as usize] * if random.below(2) == 0 { 1.0 } else { -1.0 };
    let ahead = (forward + tilt * up).normalize();
    let size = TILE_SIZES[random.below(6) as usize];
    let half_height = [0.006, 0.18, 0.58][random.below(3) as usize];
    let across = random.unit();
    let first = tile_at(random, size, [across, 0.5]);
    tile_of((cell, frac), [right, right.cross(ahead), ahead], size, half_height, first)
}

fn lattice_tile(targets: &RayTargets, random: &mut Random) -> Tile {
    let size = [[16, 16], [17, 17], [33, 65], [64, 64], [1024, 512]][random.below(5) as usize];
    let half_height = [0.25, 0.5, 1.0, 2.0][random.below(4) as usize];
    let frac = std::array::from_fn(|_| [0.0, 0.25, 0.5][random.below(3) as usize]);
    let (cell, at) = (random.cell(around(&targets.bounds)), [random.unit(), random.unit()]);
    let view = along_axes(random);
    let first = tile_at(random, size, at);
    tile_of((cell, frac), view, size, half_height, first)
}

/// Rays of direction `dir` from 8 × 8 places: the first, relative to a cell, and what the next one of a row, and of a column, is away.
fn grid(cell: [i64; 3], first: [f64; 3], along: [[f64; 3]; 2], dir: [f32; 3]) -> [Ray; Tile::RAYS] {
    std::array::from_fn(|i| {
        let (x, y) = ((i as u32 % Tile::SIDE) as f64, (i as u32 / Tile::SIDE) as f64);
        let place: [f64; 3] = std::array::from_fn(|a| first[a] + x * along[0][a] + y * along[1][a]);
        let at = std::array::from_fn(|a| cell[a] + place[a].floor() as i64);
        Ray::new(clamped(at), place.map(|p| (p - p.floor()) as f32), dir)
    })
}

fn parallel(targets: &RayTargets, random: &mut Random) -> [Ray; Tile::RAYS] {
    let target = targets.solid(random);
    let mut dir = random.direction();
    // Flat along an axis, or two.
    for _ in 0..random.below(3) {
        dir[random.below(3) as usize] *= [1e-2, 1e-4, 1e-8][random.below(3) as usize];
    }
    let apart = [1.0 / 64.0, 0.25, 0.9, 2.7][random.below(4) as usize];
    let (mut first, along) = if random.below(2) == 0 {
        // In the plane of a face.
        let (axis, middle) = (random.below(3) as usize, fraction(random).map(f64::from));
        let along = [1, 2].map(|turn| std::array::from_fn(|a| if a == (axis + turn) % 3 { apart } else { 0.0 }));
        let outside = if dir[axis] < 0.0 { 0.0 } else { 1.0 };
        (std::array::from_fn(|a| if a == axis { outside } else { middle[a] }), along)
    } else {
        let distance = [3.0, 60.0, 900.0][random.below(3) as usize];
        let along = [0, 1].map(|_| random.direction().map(|v| apart * f64::from(v)));
        (std::array::from_fn(|a| 0.5 - distance * f64::from(dir[a])), along)
    };
    // The grid's middle, about, is where it was put.
    first = std::array::from_fn(|a| first[a] - 3.5 * (along[0][a] + along[1][a]));
    grid(target, first, along, dir)
}

fn parallel_ties(targets: &RayTargets, random: &mut Random) -> [Ray; Tile::RAYS] {
    let dir: [f32; 3] = std::array::from_fn(|_| random.below(3) as f32 - 1.0);
    let axis = random.below(3) as usize;
    let dir =
        if dir.iter().all(|&v| v == 0.0) { std::array::from_fn(|a| if a == axis { 1.0 } else { 0.0 }) } else { dir };
    let apart = [0.25, 0.5, 1.0][random.below(3) as usize];
    let along = [1, 2].map(|turn| std::array::from_fn(|a| if a == (axis + turn) % 3 { apart } else { 0.0 }));
    let first = std::array::from_fn(|_| [0.0, 0.25, 0.5][random.below(3) as usize]);
    grid(random.cell(around(&targets.bounds)), first, along, dir)
}

fn invalid(targets: &RayTargets, random: &mut Random) -> Ray {
    let mut ray = incoherent(targets, random);
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][random.below(3) as usize];
    match random.below(4) {
        0 => ray.dir = [0.0, -0.0, 0.0],
        1 => ray.dir = ray.dir.map(|_| 1e-40),
        2 => ray.frac[random.below(3) as usize] = bad,
        _ => ray.dir[random.below(3) as usize] = bad,
    }
    ray
}

#[cfg(test)]
mod tests {
    use glam::IVec3;

    use super::*;

    #[test]
    fn blocks_make_up_the_list_and_differ() {
        let world = crate::scenes::Scene::find("menger").expect("a scene").world(IVec3::ZERO, 1);
        let targets = RayTargets::of(&world);
        for set in ALL {
            let all = set.rays(&world, 2500, 9);
            let parts: Vec<Ray> = (0..3).flat_map(|number| set.block(&targets, 9, number, RaySet::BLOCK)).collect();
            // Debug text, since NaN is not equal to itself.
            assert_eq!(format!("{all:?}"), format!("{:?}", &parts[..2500]), "{}", set.name);
            assert_ne!(format!("{:?}", &all[..1024]), format!("{:?}", &all[1024..2048]), "{}", set.name);
            assert_ne!(format!("{all:?}"), format!("{:?}", set.rays(&world, 2500, 10)), "{}", set.name);
        }
    }

    #[test]
    fn names_are_unique() {
        for set in ALL {
            assert_eq!(RaySet::find(set.name).map(|found| found.about), Some(set.about));
        }
    }
}
