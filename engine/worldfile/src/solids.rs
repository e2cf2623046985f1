//! Operations with a closed form: box, sphere, cylinder, Menger sponge, maze.

use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Diagnostic, codes};
use raxel_generate::{Ball, Box3, Cylinder, Maze, MazePlan, Menger, Operation};
use raxel_language::{Describe, Keys, Shape};
use raxel_layouts::instances::Axis;
use raxel_world::Bounds;

use super::extent::{CELLS, Corners, Extent, POSITIONS};
use super::materials::Materials;
use super::operations::{Site, bounded, painted};
use super::reading::Reading;

/// Longest edge or radius of a solid, in voxels.
const LENGTH: i64 = 1 << 32;
/// Radii of a ball.
const RADII: std::ops::RangeInclusive<f64> = 0.5..=LENGTH as f64;

/// `op = "box"`.
#[derive(Keys)]
#[keys(context = Reading<'_>, check = bounded(extent), check = painted())]
pub(super) struct BoxKeys {
    #[keys(flatten)]
    extent: Extent<3>,
    /// Thickness of the walls of a hollow box, in voxels. Solid when left out.
    #[keys(range = 1..=LENGTH)]
    shell: Option<i64>,
    /// Material. May be left out only with `subtract`.
    #[keys(absent = Materials::default())]
    material: Materials,
}

impl BoxKeys {
    pub(super) fn operation(self, site: &Site<'_>) -> Option<Operation> {
        let Corners { min, max } = self.extent.corners(site.table, false)?;
        site.solid(Box3 { bounds: Bounds { min, max }, shell: self.shell }, self.material)
    }
}

/// `op = "sphere"`.
#[derive(Keys)]
#[keys(context = Reading<'_>, check = painted())]
pub(super) struct SphereKeys {
    /// In voxels.
    #[keys(range = POSITIONS)]
    center: [f64; 3],
    /// Radius in voxels: one number, or one for each axis.
    #[keys(read = radius, shape = Shape::Either(vec![f64::shape(&RADII.into()), <[f64; 3]>::shape(&RADII.into())]))]
    radius: [f64; 3],
    /// Thickness of the wall of a hollow sphere, in voxels. Solid when left out.
    #[keys(range = 1.0..=LENGTH as f64)]
    shell: Option<f64>,
    /// Material. May be left out only with `subtract`.
    #[keys(absent = Materials::default())]
    material: Materials,
}

impl SphereKeys {
    pub(super) fn operation(self, site: &Site<'_>) -> Option<Operation> {
        let shape = Ball { centre: self.center, radius: self.radius, shell: self.shell };
        site.solid(shape, self.material)
    }
}

fn radius(node: &Node<'_, '_>, _: &Reading<'_>) -> Option<[f64; 3]> {
    if node.is_array() { node.numbers(RADII) } else { node.number(RADII).map(|radius| [radius; 3]) }
}

/// `op = "cylinder"`.
#[derive(Keys)]
#[keys(context = Reading<'_>, check = painted())]
pub(super) struct CylinderKeys {
    /// Centre of its base, in voxels.
    #[keys(range = POSITIONS)]
    base: [f64; 3],
    /// In voxels.
    #[keys(range = 0.0..=LENGTH as f64)]
    radius: f64,
    /// Radius at the top, in voxels. That of the base when left out.
    #[keys(range = 0.0..=LENGTH as f64)]
    top_radius: Option<f64>,
    /// In voxels.
    #[keys(range = 1..=LENGTH)]
    height: i64,
    /// Axis of the cylinder.
    #[keys(default = Axis::Y)]
    axis: Axis,
    /// Material. May be left out only with `subtract`.
    #[keys(absent = Materials::default())]
    material: Materials,
}

impl CylinderKeys {
    pub(super) fn operation(self, site: &Site<'_>) -> Option<Operation> {
        let Self { base, radius, top_radius, height, axis, material } = self;
        let top_radius = top_radius.unwrap_or(radius);
        site.solid(Cylinder { axis: axis as usize, base, radius, top_radius, height }, material)
    }
}

/// `op = "menger"`.
#[derive(Keys)]
#[keys(context = Reading<'_>, check = painted())]
pub(super) struct MengerKeys {
    /// Smallest corner, in voxels.
    #[keys(range = CELLS, default = [0; 3])]
    origin: [i64; 3],
    /// How often the cube is divided: 3^level voxels a side.
    #[keys(range = 0..=Menger::MAX_LEVEL)]
    level: u32,
    /// Material, or materials by scale, the coarsest first. May be left out only with `subtract`.
    #[keys(absent = Materials::default())]
    material: Materials,
}

impl MengerKeys {
    pub(super) fn operation(self, site: &Site<'_>) -> Option<Operation> {
        site.solid(Menger::new(self.origin, self.level), self.material)
    }
}

/// `op = "maze"`.
#[derive(Keys)]
#[keys(context = Reading<'_>, check = few(cells), check = thin(cell, wall), check = painted())]
pub(super) struct MazeKeys {
    /// Smallest corner, in voxels.
    #[keys(range = CELLS, default = [0; 3])]
    origin: [i64; 3],
    /// How many cells along x and z.
    #[keys(range = 1..=1 << 16)]
    cells: [u32; 2],
    /// Edge of a cell, in voxels.
    #[keys(range = 1..=1 << 12, default = 4)]
    cell: u32,
    /// Thickness of a wall, in voxels.
    #[keys(range = 1..=1 << 12, default = 1)]
    wall: u32,
    /// Height of the walls, in voxels.
    #[keys(range = 1..=LENGTH, default = 8)]
    height: i64,
    /// Any number: another one makes another maze. The place of the operation in the file when left out.
    seed: Option<i64>,
    /// Material of the walls. May be left out only with `subtract`.
    #[keys(absent = Materials::default())]
    material: Materials,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "a check gets a reference to each field")]
fn few(table: &Table<'_, '_>, _: &Reading<'_>, cells: &[u32; 2]) -> bool {
    let count = u64::from(cells[0]) * u64::from(cells[1]);
    let right = count <= Maze::MAX_CELLS;
    if !right && let Some(node) = table.get("cells") {
        let most = Maze::MAX_CELLS;
        node.bad_value::<()>(format!("`{}` makes {count} cells; a maze has at most {most}", node.name));
    }
    right
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "a check gets a reference to each field")]
fn thin(table: &Table<'_, '_>, _: &Reading<'_>, cell: &u32, wall: &u32) -> bool {
    if wall > cell
        && let Some(node) = table.get("wall")
    {
        let message = format!("`{}` is {wall}, wider than the maze's `cell`, which is {cell}", node.name);
        node.bad_value::<()>(message);
    }
    wall <= cell
}

impl MazeKeys {
    pub(super) fn operation(self, site: &Site<'_>) -> Option<Operation> {
        let Self { origin, cells, cell, wall, height, seed, material } = self;
        let plan = MazePlan { origin, cells, cell, wall, height, seed: site.seed(seed) };
        site.inside_world(&plan.bounds())?;
        let size = plan.bounds().size();
        if size[0].max(size[2]) > Maze::MAX_EXTENT {
            let (across, deep, most) = (size[0], size[2], Maze::MAX_EXTENT);
            site.table.reporter().report(
                Diagnostic::error(
                    codes::world::TOO_LARGE,
                    format!("this maze is {across} × {deep} voxels; at most {most} a side are built"),
                )
                .label(site.table.span().clone(), ""),
            );
            return None;
        }
        site.solid(Maze::new(&plan), material)
    }
}
