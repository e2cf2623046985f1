//! Seeded sets of rays: ordinary ones, and rays on which tracers are known to fail.

mod place;
mod random;
mod rays;
mod tiles;

use raxel_ray::Ray;
use raxel_ray::camera::Tile;
use raxel_world::{Bounds, World};

pub use random::Random;

/// A set of rays.
#[derive(Clone, Copy, Debug)]
pub struct RaySet {
    /// Name.
    pub name: &'static str,
    /// Its rays.
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

/// The targets of rays: a world's box, and some of its solid voxels.
#[derive(Clone, Debug)]
pub struct RayTargets {
    bounds: Box3,
    solids: Vec<[i64; 3]>,
}

/// Solid voxels that are remembered at most.
const REMEMBERED: usize = 4096;

impl RayTargets {
    /// Of a world. The voxels are evenly spread over the order of the world's chunks.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a sample of the world's voxels is taken, and voxels are in memory"
    )]
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
            n => self.solids[random.index(n)],
        }
    }
}

/// Every set.
pub const ALL: &[RaySet] = &[
    RaySet {
        name: "pinhole",
        about: "cameras beside the scene, pixels of a 90° view",
        make: Make::Rays(rays::pinhole),
    },
    RaySet {
        name: "incoherent",
        about: "any origin in and around the scene, any direction",
        make: Make::Rays(rays::incoherent),
    },
    RaySet {
        name: "bounce",
        about: "from faces of solid voxels in any direction outwards",
        make: Make::Rays(rays::bounce),
    },
    RaySet {
        name: "edges",
        about: "aimed at random places on edges of the lattice",
        make: Make::Rays(|p, r| rays::aimed(p, r, 2)),
    },
    RaySet { name: "corners", about: "aimed at corners of the lattice", make: Make::Rays(|p, r| rays::aimed(p, r, 3)) },
    RaySet {
        name: "silhouettes",
        about: "aimed at edges and corners of solid voxels",
        make: Make::Rays(rays::silhouettes),
    },
    RaySet {
        name: "lattice",
        about: "from middles, faces and corners along small integer vectors: all ties",
        make: Make::Rays(rays::lattice),
    },
    RaySet {
        name: "near-ties",
        about: "the same, turned by a few units in the last place",
        make: Make::Rays(rays::near_ties),
    },
    RaySet {
        name: "grazing",
        about: "1/1024 or 2^-22 voxel beside a lattice plane, slopes of 1e-4 to 1e-7",
        make: Make::Rays(rays::grazing),
    },
    RaySet {
        name: "zeros",
        about: "one or two components that are zero, of either sign",
        make: Make::Rays(rays::zeros),
    },
    RaySet { name: "tiny", about: "components from 1e-45 (denormal) to 1e-6", make: Make::Rays(rays::tiny) },
    RaySet {
        name: "faces",
        about: "origins exactly on faces, edges and corners of voxels",
        make: Make::Rays(rays::faces),
    },
    RaySet { name: "inside", about: "origins in solid voxels and on their faces", make: Make::Rays(rays::inside) },
    RaySet {
        name: "border",
        about: "origins on the border of the scene's box, in and out",
        make: Make::Rays(rays::border),
    },
    RaySet {
        name: "outside",
        about: "origins outside the scene's box, pointing away and past it",
        make: Make::Rays(rays::outside),
    },
    RaySet { name: "far", about: "origins 1e4 to 2^31 voxels away, aimed at the scene", make: Make::Rays(rays::far) },
    RaySet {
        name: "far-pinhole",
        about: "cameras 1e4 to 2^31 voxels away, a narrow view",
        make: Make::Rays(rays::far_pinhole),
    },
    RaySet {
        name: "far-axes",
        about: "origins 1e4 to 2^31 voxels away along one axis, aimed at the scene; and in any direction, from where no float holds the cell",
        make: Make::Rays(rays::far_axes),
    },
    RaySet {
        name: "wrapped",
        about: "origins beside solids by differences of 32 bits: at the other end of the coordinates, if the scene is at one",
        make: Make::Rays(rays::wrapped),
    },
    RaySet { name: "lengths", about: "directions 2^-60 to 2^60 long", make: Make::Rays(rays::lengths) },
    RaySet {
        name: "ends",
        about: "aimed at solids, ending (t_max) before, at or behind them",
        make: Make::Rays(rays::ends),
    },
    RaySet {
        name: "tiles", about: "8 × 8 pixels of random views, which share a beam", make: Make::Tiles(tiles::tile)
    },
    RaySet {
        name: "octant-tiles",
        about: "8 × 8 pixels around the middle of views along an axis or a diagonal, so that rays of several octants meet",
        make: Make::Tiles(tiles::octant_tile),
    },
    RaySet {
        name: "grazing-tiles",
        about: "8 × 8 pixels around the horizon of views 1/1024 voxel beside a lattice plane, or in it",
        make: Make::Tiles(tiles::grazing_tile),
    },
    RaySet {
        name: "lattice-tiles",
        about: "8 × 8 pixels of views along an axis, from lattice points, with pixels in small integer ratios: ties",
        make: Make::Tiles(tiles::lattice_tile),
    },
    RaySet {
        name: "parallel",
        about: "8 × 8 rays of one direction, from a plane far off or from one beside a solid voxel",
        make: Make::Grids(tiles::parallel),
    },
    RaySet {
        name: "parallel-ties",
        about: "8 × 8 rays along an axis or a diagonal, from places 1/4 voxel to 1 apart: ties; or as `unit-ties`",
        make: Make::Grids(tiles::parallel_ties),
    },
    RaySet {
        name: "wrapped-tiles",
        about: "8 × 8 pixels of views of solids, from cameras as in `wrapped`",
        make: Make::Tiles(tiles::wrapped_tile),
    },
    RaySet {
        name: "wrapped-parallel",
        about: "8 × 8 rays of one direction, from places as in `wrapped`",
        make: Make::Grids(tiles::wrapped_parallel),
    },
    RaySet {
        name: "range-ends",
        about: "origins with one to three coordinates at the ends of their range, aimed at solids",
        make: Make::Rays(rays::range_ends),
    },
    RaySet {
        name: "range-end-tiles",
        about: "8 × 8 pixels of views of solids, from cameras as in `range-ends`",
        make: Make::Tiles(tiles::range_end_tile),
    },
    RaySet {
        name: "far-tiles",
        about: "8 × 8 pixels of narrow views of solids from 9e3 to 2^24 voxels away, along an axis or in any direction",
        make: Make::Tiles(tiles::far_tile),
    },
    RaySet {
        name: "skimming-tiles",
        about: "8 × 8 pixels of which one row meets a solid voxel just inside an edge, the others pass it; pixels square or not",
        make: Make::Tiles(tiles::skimming_tile),
    },
    RaySet {
        name: "hidden-tiles",
        about: "8 × 8 pixels of which a near solid voxel hides a corner, some rows or some columns, the others look past it",
        make: Make::Tiles(tiles::hidden_tile),
    },
    RaySet {
        name: "parallel-edges",
        about: "8 × 8 rays of one direction in a fine grid around an edge of a solid voxel; some begin off the grid, or where others do",
        make: Make::Grids(tiles::parallel_edges),
    },
    RaySet {
        name: "parallel-beside",
        about: "8 × 8 rays of one direction; the first column or row meets a voxel just inside a face, and begins beside its pixels",
        make: Make::Grids(tiles::parallel_beside),
    },
    RaySet {
        name: "parallel-moved",
        about: "8 × 8 rays of one direction; some begin elsewhere along a row or a column, where a wrong projection would look for them",
        make: Make::Grids(tiles::parallel_moved),
    },
    RaySet {
        name: "parallel-depths",
        about: "8 × 8 rays of one direction from pixels of a plane along two axes, at different depths along the third one",
        make: Make::Grids(tiles::parallel_depths),
    },
    RaySet {
        name: "unit-ties",
        about: "two planes that are crossed one unit of the lattice apart, or 2^-1 to 2^-14 of one, beside a solid",
        make: Make::Rays(rays::unit_ties),
    },
    RaySet {
        name: "slightest",
        about: "along an axis, and on the others 2^-28 to 2^-31 as fast, from planes of the lattice or the border of the scene: at the limit of directions",
        make: Make::Rays(rays::slightest),
    },
    RaySet {
        name: "longest",
        about: "directions 2^100 to 2^128 long; half of the rays end (t_max)",
        make: Make::Rays(rays::longest),
    },
    RaySet {
        name: "fractions",
        about: "places in the origin's cell that are outside of it, and count as on its border",
        make: Make::Rays(rays::fractions),
    },
    RaySet {
        name: "ended",
        about: "rays that end (t_max) where they begin or before, from solids and elsewhere",
        make: Make::Rays(rays::ended),
    },
    RaySet {
        name: "invalid",
        about: "NaN of any bits, infinities, and no direction at all",
        make: Make::Rays(rays::invalid),
    },
];

impl RaySet {
    /// Rays of a block.
    pub const BLOCK: usize = 1024;

    /// The set of that name.
    pub fn find(name: &str) -> Option<&'static RaySet> {
        ALL.iter().find(|set| set.name == name)
    }

    /// The first `count` (at most [`RaySet::BLOCK`]) rays of a block: the same for the same targets, seed and number, on any thread and in
    /// any order of blocks.
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
