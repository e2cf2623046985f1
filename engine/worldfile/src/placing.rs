//! Operations that place models.

use raxel_diagnostics::table::Table;
use raxel_diagnostics::{Diagnostic, codes};
use raxel_generate::{Jittered, Operation, Placed, Scatter, Scattered, place_anchor};
use raxel_language::Keys;
use raxel_world::{Bounds, World};

use super::extent::{CELLS, Corners, Extent};
use super::materials::Materials;
use super::models::Model;
use super::operations::{QuarterTurns, Site};
use super::reading::Reading;

/// Which point of a model its place is about.
#[derive(Clone, Copy, Keys)]
pub(super) enum Anchor {
    /// The centre of its lowest layer.
    Base,
    /// Its smallest corner.
    Corner,
    /// The origin of its own file.
    Origin,
}

impl Anchor {
    /// The cell of a model that it is.
    pub(super) fn cell(self, model: &World) -> [i64; 3] {
        let Some(bounds) = model.bounds() else { return [0; 3] };
        match self {
            Self::Base => {
                let middle = |i: usize| (bounds.min[i] + bounds.max[i]).div_euclid(2);
                [middle(0), bounds.min[1], middle(2)]
            }
            Self::Corner => bounds.min,
            Self::Origin => [0; 3],
        }
    }
}

/// `op = "model"`.
#[derive(Keys)]
#[keys(context = Reading<'_>)]
pub(super) struct ModelKeys {
    /// Name of one of [models].
    model: Model,
    /// Place of the anchor, in voxels.
    #[keys(range = CELLS, default = [0; 3])]
    origin: [i64; 3],
    /// Degrees to the left about the anchor.
    #[keys(default = QuarterTurns(0))]
    rotation: QuarterTurns,
    /// Point of the model: the centre of its lowest layer, its smallest corner, or the origin of its file.
    #[keys(default = Anchor::Base)]
    anchor: Anchor,
}

impl ModelKeys {
    pub(super) fn operation(self, site: &Site<'_>) -> Option<Operation> {
        let Self { model: Model { voxels, materials }, origin, rotation, anchor } = self;
        let placement = place_anchor(anchor.cell(&voxels), rotation.0, origin);
        if let Some(bounds) = voxels.bounds() {
            site.inside_world(&Placed::placed_bounds(&bounds, &placement))?;
        }
        Some(Operation::Place(Placed { model: voxels, materials, placements: vec![placement], mode: site.mode }))
    }
}

/// `op = "scatter"`.
#[derive(Keys)]
#[keys(
    context = Reading<'_>,
    check = bounded(extent),
    check = counted(cell, count, density),
    check = apart(cell, min_spacing)
)]
pub(super) struct ScatterKeys {
    /// Name of one of [models].
    model: Model,
    #[keys(flatten)]
    extent: Extent<2>,
    /// How many models. Instead of `density` and `cell`.
    #[keys(range = 1..=Scatter::MAX_COUNT, excludes("density", why = "one follows from the other"))]
    count: Option<u64>,
    /// How many models for each voxel of the area. Instead of `count`.
    #[keys(range = 1e-9..=1.0)]
    density: Option<f64>,
    /// Edge of the cells of a grid, in voxels. Each cell has at most one model, on the land of `terrain`. Instead of `count`.
    #[keys(range = 1..=1 << 20, excludes("count", "density", why = "a grid has as many as its cells allow"))]
    cell: Option<i64>,
    /// Probability that a cell has a model, from 0 to 1.
    #[keys(range = 0.0..=1.0, default = 1.0)]
    chance: f64,
    /// Materials that a model may stand on. All when left out.
    #[keys(absent = Materials::default())]
    on: Materials,
    /// Least distance between two models, in voxels.
    #[keys(range = 0..=1 << 20, default = 0)]
    min_spacing: i64,
    /// Depth of a model in the ground, in voxels.
    #[keys(range = -(1 << 16)..=1 << 16, default = 0)]
    sink: i64,
    /// Whether each model gets a random quarter turn.
    #[keys(default = true)]
    rotate: bool,
    /// Point of the model: the centre of its lowest layer, its smallest corner, or the origin of its file.
    #[keys(default = Anchor::Base)]
    anchor: Anchor,
    /// Any number: another one makes other places. The place of the operation in the file when left out.
    seed: Option<i64>,
}

/// A grid in a streamed world has no end.
fn corners(table: &Table<'_, '_>, reading: &Reading<'_>, extent: &Extent<2>) -> Option<Corners<2>> {
    extent.corners(table, reading.streamed && table.get("cell").is_some())
}

fn bounded(table: &Table<'_, '_>, reading: &Reading<'_>, extent: &Extent<2>) -> bool {
    corners(table, reading, extent).is_some()
}

fn counted(
    table: &Table<'_, '_>,
    _: &Reading<'_>,
    cell: Option<&i64>,
    count: Option<&u64>,
    density: Option<&f64>,
) -> bool {
    if cell.is_none()
        && let Some(node) = table.get("chance")
    {
        let message = format!("`{}` needs `cell`", node.name);
        node.report(codes::files::MISSING_KEY, message, "the chance of a cell of a grid");
    }
    cell.is_some() || count.is_some() || density.is_some() || table.need("count").is_some()
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "a check gets a reference to each field")]
fn apart(table: &Table<'_, '_>, _: &Reading<'_>, cell: Option<&i64>, spacing: &i64) -> bool {
    let Some(cell) = cell.filter(|cell| spacing >= cell) else { return true };
    if let Some(node) = table.get("min_spacing") {
        let message = format!("`{}` is {spacing}; it must be less than `cell`, which is {cell}", node.name);
        node.bad_value::<()>(message);
    }
    false
}

impl ScatterKeys {
    pub(super) fn operation(self, site: &Site<'_>) -> Option<Operation> {
        let area = corners(site.table, site.reading, &self.extent)?;
        let Corners { min, max } = area;
        site.inside_world(&Bounds { min: [min[0], 0, min[1]], max: [max[0], 0, max[1]] })?;
        let Model { voxels: model, materials } = self.model;
        let scattered = Scattered {
            anchor: self.anchor.cell(&model),
            model,
            materials,
            min,
            max,
            on: self.on.0,
            spacing: self.min_spacing,
            sink: self.sink,
            turn: self.rotate,
            seed: site.seed(self.seed),
            mode: site.mode,
        };
        let Some(cell) = self.cell else {
            let count = self.count.or_else(|| models_of(self.density?, area, site.table))?;
            return Some(Operation::Scatter(Scatter { scattered, count }));
        };
        let jittered = Jittered { scattered, cell, chance: self.chance };
        let (cells, most) = (jittered.cell_count(), Jittered::MAX_CELLS);
        if !site.reading.streamed && cells > u128::from(most) {
            let message = format!("this scatters over {cells} cells; a world that is built whole has at most {most}");
            site.table.reporter().report(
                Diagnostic::error(codes::world::TOO_LARGE, message)
                    .label(site.table.span().clone(), "")
                    .help("take a larger `cell` or a smaller area, or give the world `[stream]`"),
            );
            return None;
        }
        Some(Operation::Jittered(jittered))
    }
}

/// How many models a density is in an area.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the count is in 1…`Scatter::MAX_COUNT`")]
fn models_of(density: f64, Corners { min, max }: Corners<2>, table: &Table<'_, '_>) -> Option<u64> {
    let places = (max[0] - min[0]) as f64 * (max[1] - min[1]) as f64;
    let (count, most) = ((density * places).round().max(1.0), Scatter::MAX_COUNT);
    if count > most as f64 {
        let node = table.get("density")?;
        return node.bad_value(format!("`{}` asks for {count} models; at most {most} are scattered", node.name));
    }
    Some(count as u64)
}
