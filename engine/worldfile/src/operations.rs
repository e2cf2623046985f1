//! `[[build]]`: which operation a table describes, and the operations that place models.

use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Diagnostic, codes};

use raxel_generate::{Jittered, Operation, Placed, Scatter, place_anchor};
use raxel_world::MaterialIndex;
use raxel_world::Mode;
use raxel_world::random::mix;
use raxel_world::{Bounds, World};

use super::materials::Palette;
use super::models::{Model, Models};
use super::{extent, solids, terrain};

/// Words for [`Mode`].
pub(super) const MODES: &[(&str, Mode)] = &[("add", Mode::Add), ("subtract", Mode::Subtract), ("paint", Mode::Paint)];

/// Reads operations and gathers the materials that they need.
pub(super) struct OperationReader {
    palette: Palette,
    models: Models,
    seed: u64,
    /// The world has `[stream]`.
    streamed: bool,
}

/// The operations, by the word in the file.
#[derive(Clone, Copy)]
enum Kind {
    Box,
    Sphere,
    Cylinder,
    Menger,
    Maze,
    Terrain,
    Model,
    Scatter,
}

const KINDS: &[(&str, Kind)] = &[
    ("box", Kind::Box),
    ("sphere", Kind::Sphere),
    ("cylinder", Kind::Cylinder),
    ("menger", Kind::Menger),
    ("maze", Kind::Maze),
    ("terrain", Kind::Terrain),
    ("model", Kind::Model),
    ("scatter", Kind::Scatter),
];

/// Which point of a model its place is about.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    /// The middle of its lowest layer.
    Base,
    /// Its smallest corner.
    Corner,
    /// The origin of its own file.
    Origin,
}

const ANCHORS: &[(&str, Anchor)] = &[("base", Anchor::Base), ("corner", Anchor::Corner), ("origin", Anchor::Origin)];

impl OperationReader {
    pub(super) fn new(palette: Palette, models: Models, seed: u64, streamed: bool) -> Self {
        Self { palette, models, seed, streamed }
    }

    pub(super) fn into_parts(self) -> (Palette, Models) {
        (self.palette, self.models)
    }

    /// Reads one operation. Whatever is wrong with it has been reported when there is none.
    pub(super) fn read(&mut self, index: usize, table: &Table<'_, '_>) -> Option<Operation> {
        let kind = table.need("op")?.word(KINDS)?;
        let mode = table.get("mode").map_or(Some(Mode::Add), |node| node.word(MODES));
        let seed = Seed { world: self.seed, index };
        let palette = &self.palette;
        let operation = match kind {
            Kind::Box => solids::read_box(table, mode, palette),
            Kind::Sphere => solids::read_sphere(table, mode, palette),
            Kind::Cylinder => solids::read_cylinder(table, mode, palette),
            Kind::Menger => solids::read_menger(table, mode, palette),
            Kind::Maze => solids::read_maze(table, mode, palette, seed),
            Kind::Terrain => terrain::read(table, mode, palette, seed, self.streamed).map(Operation::Terrain),
            Kind::Model => self.read_model(table, mode),
            Kind::Scatter => self.read_scatter(table, mode, seed),
        };
        table.finish();
        operation
    }

    /// The model that a value names, with its materials in the palette.
    pub(super) fn model(&mut self, node: &Node<'_, '_>) -> Option<Model> {
        self.models.find(node, &mut self.palette)
    }

    fn read_model(&mut self, table: &Table<'_, '_>, mode: Option<Mode>) -> Option<Operation> {
        let model = table.need("model").and_then(|node| self.model(&node));
        let origin = table.get("origin").map_or(Some([0; 3]), |node| node.integers::<_, 3>(extent::CELLS));
        let turns = [("0", 0), ("90", 1), ("180", 2), ("270", 3)];
        let turns = table.get("rotation").map_or(Some(0), |node| {
            let degrees: u32 = node.integer(0..=270)?;
            match turns.iter().find(|(text, _)| *text == degrees.to_string()) {
                Some((_, turns)) => Some(*turns),
                None => node.bad_value(format!("`{}` is {degrees}; it must be 0, 90, 180 or 270", node.name)),
            }
        });
        let anchor = anchor(table);
        let (model, turns) = (model?, turns?);
        let placement = place_anchor(anchor_cell(anchor?, &model.voxels), turns, origin?);
        if let Some(bounds) = model.voxels.bounds() {
            extent::inside_world(table, &Placed::placed_bounds(&bounds, &placement))?;
        }
        Some(Operation::Place(Placed {
            model: model.voxels,
            materials: model.materials,
            placements: vec![placement],
            mode: mode?,
        }))
    }

    fn read_scatter(&mut self, table: &Table<'_, '_>, mode: Option<Mode>, seed: Seed) -> Option<Operation> {
        let model = table.need("model").and_then(|node| self.model(&node));
        let grid = table.get("cell").map(|node| node.integer(1..=1 << 20));
        let area = if grid.is_some() { extent::read_endless(table, self.streamed) } else { extent::read::<2>(table) };
        let how_many = match grid {
            Some(cell) => read_grid(table, cell),
            None => read_count(table, area),
        };
        let on = table.get("on").map_or(Some(Vec::new()), |node| materials(&self.palette, &node));
        let spacing = table.get("min_spacing").map_or(Some(0), |node| {
            let spacing = node.integer(0..=1 << 20)?;
            match grid.flatten() {
                Some(cell) if spacing >= cell => node
                    .bad_value(format!("`{}` is {spacing}; it must be less than `cell`, which is {cell}", node.name)),
                _ => Some(spacing),
            }
        });
        let sink = table.get("sink").map_or(Some(0), |node| node.integer(-(1 << 16)..=1 << 16));
        let turn = table.get("rotate").map_or(Some(true), |node| node.boolean());
        let anchor = anchor(table);
        let seed = seed.read(table);
        let (model, (min, max)) = (model?, area?);
        extent::inside_world(table, &Bounds { min: [min[0], 0, min[1]], max: [max[0], 0, max[1]] })?;
        let anchor = anchor_cell(anchor?, &model.voxels);
        let (on, spacing, sink, turn, seed, mode) = (on?, spacing?, sink?, turn?, seed?, mode?);
        let (model, materials) = (model.voxels, model.materials);
        match how_many? {
            HowMany::Count(count) => Some(Operation::Scatter(Scatter {
                model,
                materials,
                anchor,
                count,
                min,
                max,
                on,
                spacing,
                sink,
                turn,
                seed,
                mode,
            })),
            HowMany::Grid { cell, chance } => {
                let jittered =
                    Jittered { model, materials, anchor, cell, chance, min, max, on, spacing, sink, turn, seed, mode };
                let cells = jittered.cell_count();
                if !self.streamed && cells > u128::from(Jittered::MAX_CELLS) {
                    table.reporter().report(
                        Diagnostic::error(
                            codes::world::TOO_LARGE,
                            format!(
                                "this scatters over {cells} cells; a world that is built whole has at most {}",
                                Jittered::MAX_CELLS
                            ),
                        )
                        .label(table.span().clone(), "")
                        .help("take a larger `cell` or a smaller area, or give the world `[stream]`"),
                    );
                    return None;
                }
                Some(Operation::Jittered(jittered))
            }
        }
    }
}

/// How many models are scattered.
enum HowMany {
    Count(u64),
    Grid { cell: i64, chance: f64 },
}

/// `cell` with `chance`.
fn read_grid(table: &Table<'_, '_>, cell: Option<i64>) -> Option<HowMany> {
    table.conflict("cell", "count", "a grid has as many as its cells allow");
    table.conflict("cell", "density", "a grid has as many as its cells allow");
    let chance = table.get("chance").map_or(Some(1.0), |node| node.number(0.0..=1.0));
    Some(HowMany::Grid { cell: cell?, chance: chance? })
}

/// `count` or `density`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the count is in 1…`Scatter::MAX_COUNT`")]
fn read_count(table: &Table<'_, '_>, area: Option<([i64; 2], [i64; 2])>) -> Option<HowMany> {
    table.conflict("count", "density", "one follows from the other");
    if let Some(node) = table.get("chance") {
        node.report(
            codes::files::MISSING_KEY,
            format!("`{}` needs `cell`", node.name),
            "the chance of a cell of a grid",
        );
    }
    let most = Scatter::MAX_COUNT;
    let count = table.get("count").map(|node| node.integer(1..=most));
    let density = table.get("density").map(|node| (node.number(1e-9..=1.0), node));
    let count = match (count, density) {
        (Some(count), _) => count,
        (None, Some((density, node))) => density.zip(area).and_then(|(density, (min, max))| {
            let places = (max[0] - min[0]) as f64 * (max[1] - min[1]) as f64;
            let count = (density * places).round().max(1.0);
            if count > most as f64 {
                return node
                    .bad_value(format!("`{}` asks for {count} models; at most {most} are scattered", node.name));
            }
            Some(count as u64)
        }),
        (None, None) => {
            table.need("count");
            None
        }
    };
    count.map(HowMany::Count)
}

pub(super) fn anchor(table: &Table<'_, '_>) -> Option<Anchor> {
    table.get("anchor").map_or(Some(Anchor::Base), |node| node.word(ANCHORS))
}

pub(super) fn anchor_cell(anchor: Anchor, model: &World) -> [i64; 3] {
    let Some(bounds) = model.bounds() else { return [0; 3] };
    match anchor {
        Anchor::Base => {
            let middle = |i: usize| (bounds.min[i] + bounds.max[i]).div_euclid(2);
            [middle(0), bounds.min[1], middle(2)]
        }
        Anchor::Corner => bounds.min,
        Anchor::Origin => [0; 3],
    }
}

/// The seed of an operation: its own or its place in the file, mixed with the world's.
#[derive(Clone, Copy)]
pub(super) struct Seed {
    world: u64,
    index: usize,
}

impl Seed {
    pub(super) fn read(self, table: &Table<'_, '_>) -> Option<u64> {
        let own = table
            .get("seed")
            .map_or(Some(self.index as u64), |node| node.integer(i64::MIN..=i64::MAX).map(i64::cast_unsigned))?;
        Some(mix(self.world ^ mix(own)))
    }
}

/// One material or a list of them.
pub(super) fn materials(
    palette: &Palette,
    node: &raxel_diagnostics::table::Node<'_, '_>,
) -> Option<Vec<MaterialIndex>> {
    if !node.is_array() {
        return Some(vec![palette.find(node)?]);
    }
    let names = node.array()?;
    if names.is_empty() {
        node.report(codes::files::BAD_VALUE, format!("`{}` needs at least one material", node.name), "");
        return None;
    }
    let found: Vec<_> = names.iter().map(|name| palette.find(name)).collect();
    found.into_iter().collect()
}
