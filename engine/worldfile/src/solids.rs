//! Operations with a closed form: box, sphere, cylinder, Menger sponge, maze.

use raxel_diagnostics::table::Table;
use raxel_diagnostics::{Diagnostic, codes};

use raxel_generate::{Ball, Box3, Cylinder, Maze, MazePlan, Menger, Operation, Shape, Solid};
use raxel_world::Bounds;
use raxel_world::MaterialIndex;
use raxel_world::Mode;

use super::extent;
use super::materials::Palette;
use super::operations::{Seed, materials};

/// Longest edge or radius of a solid, in voxels.
const LENGTH: i64 = 1 << 32;

pub(super) fn read_box(table: &Table<'_, '_>, mode: Option<Mode>, palette: &Palette) -> Option<Operation> {
    let area = extent::read::<3>(table);
    let shell = match table.get("shell") {
        Some(node) => node.integer(1..=LENGTH).map(Some),
        None => Some(None),
    };
    let (mode, materials) = mode_and_materials(table, mode, palette);
    let (min, max) = area?;
    let shape = Box3 { bounds: Bounds { min, max }, shell: shell? };
    solid(table, Box::new(shape), mode?, materials?)
}

pub(super) fn read_sphere(table: &Table<'_, '_>, mode: Option<Mode>, palette: &Palette) -> Option<Operation> {
    let centre = table.need("center").and_then(|node| node.numbers::<3>(extent::POSITIONS));
    let radius = table.need("radius").and_then(|node| {
        let range = 0.5..=LENGTH as f64;
        if node.is_array() { node.numbers::<3>(range) } else { node.number(range).map(|r| [r; 3]) }
    });
    let shell = match table.get("shell") {
        Some(node) => node.number(1.0..=LENGTH as f64).map(Some),
        None => Some(None),
    };
    let (mode, materials) = mode_and_materials(table, mode, palette);
    let shape = Ball { centre: centre?, radius: radius?, shell: shell? };
    solid(table, Box::new(shape), mode?, materials?)
}

pub(super) fn read_cylinder(table: &Table<'_, '_>, mode: Option<Mode>, palette: &Palette) -> Option<Operation> {
    let base = table.need("base").and_then(|node| node.numbers::<3>(extent::POSITIONS));
    let radius = table.need("radius").and_then(|node| node.number(0.0..=LENGTH as f64));
    let top_radius = table.get("top_radius").map_or(radius, |node| node.number(0.0..=LENGTH as f64));
    let height = table.need("height").and_then(|node| node.integer(1..=LENGTH));
    let axis = table.get("axis").map_or(Some(1), |node| node.word(&[("x", 0), ("y", 1), ("z", 2)]));
    let (mode, materials) = mode_and_materials(table, mode, palette);
    let shape = Cylinder { axis: axis?, base: base?, radius: radius?, top_radius: top_radius?, height: height? };
    solid(table, Box::new(shape), mode?, materials?)
}

pub(super) fn read_menger(table: &Table<'_, '_>, mode: Option<Mode>, palette: &Palette) -> Option<Operation> {
    let origin = table.get("origin").map_or(Some([0; 3]), |node| node.integers::<_, 3>(extent::CELLS));
    let level = table.need("level").and_then(|node| node.integer(0..=Menger::MAX_LEVEL));
    let (mode, materials) = mode_and_materials(table, mode, palette);
    let shape = Menger::new(origin?, level?);
    solid(table, Box::new(shape), mode?, materials?)
}

pub(super) fn read_maze(table: &Table<'_, '_>, mode: Option<Mode>, palette: &Palette, seed: Seed) -> Option<Operation> {
    let origin = table.get("origin").map_or(Some([0; 3]), |node| node.integers::<_, 3>(extent::CELLS));
    let cells = table.need("cells").and_then(|node| {
        let cells = node.integers::<u32, 2>(1..=1 << 16)?;
        let count = u64::from(cells[0]) * u64::from(cells[1]);
        if count > Maze::MAX_CELLS {
            return node.bad_value(format!(
                "`{}` makes {count} cells; a maze has at most {}",
                node.name,
                Maze::MAX_CELLS
            ));
        }
        Some(cells)
    });
    let cell = table.get("cell").map_or(Some(4), |node| node.integer(1..=1 << 12));
    let wall = table.get("wall").map_or(Some(1), |node| {
        let wall = node.integer(1..=1 << 12)?;
        match cell {
            Some(cell) if wall > cell => {
                node.bad_value(format!("`{}` is {wall}, wider than the maze's `cell`, which is {cell}", node.name))
            }
            _ => Some(wall),
        }
    });
    let height = table.get("height").map_or(Some(8), |node| node.integer(1..=LENGTH));
    let seed = seed.read(table);
    let (mode, materials) = mode_and_materials(table, mode, palette);
    let plan = MazePlan { origin: origin?, cells: cells?, cell: cell?, wall: wall?, height: height?, seed: seed? };
    extent::inside_world(table, &plan.bounds())?;
    let size = plan.bounds().size();
    if size[0].max(size[2]) > Maze::MAX_EXTENT {
        table.reporter().report(
            Diagnostic::error(
                codes::world::TOO_LARGE,
                format!("this maze is {} × {} voxels; at most {} a side are built", size[0], size[2], Maze::MAX_EXTENT),
            )
            .label(table.span().clone(), ""),
        );
        return None;
    }
    solid(table, Box::new(Maze::new(&plan)), mode?, materials?)
}

/// The operation's materials; a mode that empties voxels takes none.
fn mode_and_materials(
    table: &Table<'_, '_>,
    mode: Option<Mode>,
    palette: &Palette,
) -> (Option<Mode>, Option<Vec<MaterialIndex>>) {
    if mode != Some(Mode::Subtract) {
        return (mode, table.need("material").and_then(|node| materials(palette, &node)));
    }
    if let Some(node) = table.get("material") {
        let mut diagnostic =
            Diagnostic::error(codes::files::CONFLICTING_KEYS, "an operation that subtracts has no `material`")
                .label(node.key_span, "of no use here");
        if let Some(mode) = table.get("mode") {
            diagnostic = diagnostic.label(mode.span, "this empties voxels");
        }
        table.reporter().report(diagnostic);
    }
    (mode, Some(Vec::new()))
}

fn solid(table: &Table<'_, '_>, shape: Box<dyn Shape>, mode: Mode, materials: Vec<MaterialIndex>) -> Option<Operation> {
    extent::inside_world(table, &shape.bounds())?;
    Some(Operation::Solid(Solid { shape, mode, materials }))
}
