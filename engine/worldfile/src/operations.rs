//! `[[build]]`: the operation of a table, and the keys that all of them share.

use raxel_diagnostics::table::{Node, Table};
use raxel_diagnostics::{Diagnostic, Span, codes};
use raxel_generate::{self as generate, Operation, Solid};
use raxel_language::{Describe, Json, Keys, ReadKeys, Shape, Value};
use raxel_world::{Bounds, Mode};
use serde_json::json;

use super::extent::{Extent, inside_world};
use super::materials::Materials;
use super::placing::{ModelKeys, ScatterKeys};
use super::reading::Reading;
use super::solids::{BoxKeys, CylinderKeys, MazeKeys, MengerKeys, SphereKeys};
use super::terrain::TerrainKeys;

/// An operation.
#[derive(Keys)]
#[keys(context = Reading<'_>)]
struct Build {
    /// `add` makes voxels solid, `subtract` makes them air, `paint` gives solid ones the material.
    #[keys(default = Mode::Add)]
    mode: Mode,
    #[keys(flatten)]
    what: What,
}

#[derive(Keys)]
#[keys(tag = "op", context = Reading<'_>)]
enum What {
    /// A box.
    Box(BoxKeys),
    /// A ball or ellipsoid.
    Sphere(SphereKeys),
    /// A cylinder, or a cone when its radii differ.
    Cylinder(CylinderKeys),
    /// A Menger sponge of 3^level voxels a side.
    Menger(MengerKeys),
    /// The walls of a maze with one way between any two cells.
    Maze(MazeKeys),
    /// Land from fractal noise.
    Terrain(TerrainKeys),
    /// A model at a place.
    Model(ModelKeys),
    /// A model at random places on the ground.
    Scatter(ScatterKeys),
}

/// Turns to the left by 90°, 0 to 3 of them; in files as degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuarterTurns(pub u32);

impl Describe for QuarterTurns {
    type Limits = ();

    fn shape((): &()) -> Shape {
        Shape::Schema(json!({ "enum": [0, 90, 180, 270] }))
    }

    fn written(&self) -> Json {
        json!(self.0 * 90)
    }
}

impl<C: ?Sized> Value<C> for QuarterTurns {
    fn read(node: &Node<'_, '_>, (): &(), _: &C) -> Option<Self> {
        match node.integer(0..=270)? {
            degrees if degrees % 90 == 0 => Some(Self(degrees / 90)),
            degrees => node.bad_value(format!("`{}` is {degrees}; it must be 0, 90, 180 or 270", node.name)),
        }
    }
}

/// Reads `[[build]]`: each operation that is right, and where it stands.
pub(super) fn read(node: &Node<'_, '_>, reading: &Reading<'_>) -> Option<Vec<(Operation, Span)>> {
    let mut operations = Vec::new();
    for (index, table) in node.array()?.iter().filter_map(Node::table).enumerate() {
        if let Some(Build { mode, what }) = Build::read_keys(&table, reading) {
            let site = Site { table: &table, reading, mode, index };
            operations.extend(what.operation(&site).map(|operation| (operation, table.span().clone())));
        }
        table.finish();
    }
    Some(operations)
}

/// The shape of `[[build]]`.
pub(super) fn declared() -> Shape {
    Shape::array(Shape::Table(Build::form()), ..)
}

impl What {
    fn operation(self, site: &Site<'_>) -> Option<Operation> {
        match self {
            Self::Box(keys) => keys.operation(site),
            Self::Sphere(keys) => keys.operation(site),
            Self::Cylinder(keys) => keys.operation(site),
            Self::Menger(keys) => keys.operation(site),
            Self::Maze(keys) => keys.operation(site),
            Self::Terrain(keys) => keys.operation(site),
            Self::Model(keys) => keys.operation(site),
            Self::Scatter(keys) => keys.operation(site),
        }
    }
}

/// The place of an operation in its file, and its effect there.
pub(super) struct Site<'s> {
    pub(super) table: &'s Table<'s, 's>,
    pub(super) reading: &'s Reading<'s>,
    pub(super) mode: Mode,
    index: usize,
}

impl Site<'_> {
    pub(super) fn seed(&self, own: Option<i64>) -> u64 {
        self.reading.seed(own, self.index)
    }

    /// Reports a part outside of the world.
    pub(super) fn inside_world(&self, bounds: &Bounds) -> Option<()> {
        inside_world(self.table, bounds)
    }

    pub(super) fn solid(&self, shape: impl generate::Shape + 'static, materials: Materials) -> Option<Operation> {
        self.inside_world(&shape.bounds())?;
        Some(Operation::Solid(Solid { shape: Box::new(shape), mode: self.mode, materials: materials.0 }))
    }
}

/// Whether an operation has an end.
pub(super) fn bounded<const N: usize>(table: &Table<'_, '_>, _: &Reading<'_>, extent: &Extent<N>) -> bool {
    extent.corners(table, false).is_some()
}

/// Whether an operation has a material, unless it empties voxels.
pub(super) fn painted(table: &Table<'_, '_>, _: &Reading<'_>) -> bool {
    let (mode, material) = (table.get("mode"), table.get("material"));
    if table.peek("mode", |node| node.word(Mode::WORDS)) != Some(Mode::Subtract) {
        return material.is_some() || table.need("material").is_some();
    }
    let Some(material) = material else { return true };
    let mut diagnostic =
        Diagnostic::error(codes::files::CONFLICTING_KEYS, "an operation that subtracts has no `material`")
            .label(material.key_span, "of no use here");
    if let Some(mode) = mode {
        diagnostic = diagnostic.label(mode.span, "this empties voxels");
    }
    table.reporter().report(diagnostic);
    false
}
