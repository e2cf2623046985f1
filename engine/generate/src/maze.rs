//! A perfect maze: exactly one way between any two of its cells.

use raxel_world::Bounds;
use raxel_world::random::SplitMix64;

use crate::shape::{Shape, Span3, span_of_box};

/// Walls of a maze, standing on its floor plan.
pub struct Maze {
    bounds: Bounds,
    /// Plan squares along x: walls and cells in turn, so 2·cells + 1.
    width: usize,
    /// Plan square of each voxel column along x, and along z.
    squares: [Vec<u32>; 2],
    /// The wall squares of the plan, row by row along z.
    walls: Vec<bool>,
}

/// The settings of a maze.
#[derive(Clone, Copy, Debug)]
pub struct MazePlan {
    /// Smallest corner.
    pub origin: [i64; 3],
    /// Cells along x and z.
    pub cells: [u32; 2],
    /// Voxels along a cell.
    pub cell: u32,
    /// Voxels across a wall.
    pub wall: u32,
    /// Voxels that the walls are high.
    pub height: i64,
    /// Same seed, same maze.
    pub seed: u64,
}

impl MazePlan {
    /// Voxels that the maze covers.
    pub fn bounds(&self) -> Bounds {
        let extent = |cells: u32| i64::from(cells) * i64::from(self.cell + self.wall) + i64::from(self.wall);
        let size = [extent(self.cells[0]), self.height, extent(self.cells[1])];
        Bounds { min: self.origin, max: std::array::from_fn(|i| self.origin[i] + size[i]) }
    }
}

impl Maze {
    /// At most this many cells.
    pub const MAX_CELLS: u64 = 1 << 22;
    /// At most this many voxels along x and z.
    pub const MAX_EXTENT: u64 = 1 << 20;

    /// Carves the maze by a random depth-first walk ("recursive backtracker", with its own stack).
    pub fn new(plan: &MazePlan) -> Self {
        let [nx, nz] = plan.cells.map(|n| n as usize);
        let width = 2 * nx + 1;
        let mut walls = vec![true; width * (2 * nz + 1)];
        let square = |x: usize, z: usize| (2 * z + 1) * width + 2 * x + 1;
        let mut random = SplitMix64::new(plan.seed);
        let mut path = vec![(0usize, 0usize)];
        walls[square(0, 0)] = false;
        while let Some(&(x, z)) = path.last() {
            let next = [
                (x > 0).then(|| (x - 1, z)),
                (x + 1 < nx).then_some((x + 1, z)),
                (z > 0).then(|| (x, z - 1)),
                (z + 1 < nz).then_some((x, z + 1)),
            ];
            let open: Vec<_> = next.into_iter().flatten().filter(|&(x, z)| walls[square(x, z)]).collect();
            if open.is_empty() {
                path.pop();
                continue;
            }
            let (to_x, to_z) = open[random.index(open.len())];
            walls[square(to_x, to_z)] = false;
            // The square between two neighbours lies half-way in the plan.
            walls[usize::midpoint(square(x, z), square(to_x, to_z))] = false;
            path.push((to_x, to_z));
        }
        let squares = plan.cells.map(|cells| {
            let thickness = |s: u32| if s.is_multiple_of(2) { plan.wall } else { plan.cell };
            (0..=2 * cells).flat_map(|s| std::iter::repeat_n(s, thickness(s) as usize)).collect()
        });
        Self { bounds: plan.bounds(), width, squares, walls }
    }
}

impl Shape for Maze {
    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn span(&self, min: [i64; 3], edge: i64) -> Span3 {
        match span_of_box(&self.bounds, min, edge) {
            Span3::Outside => Span3::Outside,
            _ => Span3::Both,
        }
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the caller has found the cell inside the bounds"
    )]
    fn contains(&self, cell: [i64; 3]) -> bool {
        if span_of_box(&self.bounds, cell, 1) == Span3::Outside {
            return false;
        }
        let [x, z] = [0, 2].map(|i| (cell[i] - self.bounds.min[i]) as usize);
        self.walls[self.squares[1][z] as usize * self.width + self.squares[0][x] as usize]
    }

    fn mask(&self, min: [i64; 3]) -> u64 {
        // Walls are the same at every height: look once at the plan.
        let low = min[1].max(self.bounds.min[1]);
        let high = (min[1] + 4).min(self.bounds.max[1]);
        let slice = (0..16).fold(0u64, |slice, bit| {
            let (x, z) = (bit & 3, bit >> 2);
            slice | u64::from(self.contains([min[0] + x, low, min[2] + z])) << bit
        });
        (low..high).fold(0, |mask, y| mask | slice << (16 * (y - min[1])))
    }
}
