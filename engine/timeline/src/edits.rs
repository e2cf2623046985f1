//! `[[edits]]`: edits of the world at times of a demo.

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::table::{self, Node, Reporter, Table};
use raxel_diagnostics::{Diagnostic, Span, Spanned, codes};
use raxel_edit::{Brush, Operation, Scene, UNIT, fixed};
use raxel_language::{Keys, Value};
use raxel_layouts::instances::Axis;
use raxel_world::{AIR, Bounds, Mode, Orientation};
use raxel_worldfile::{CELLS, POSITIONS, QuarterTurns};

use crate::demo::Demo;
use crate::read::{Clock, time};
use crate::take::quoted;

/// An edit at a time. The names of materials and models are the world's to know.
#[derive(Clone, Debug, PartialEq)]
pub struct EditKey {
    /// Seconds.
    pub time: Spanned<f64>,
    /// The edit. Its material is not found yet.
    pub operation: Operation,
    /// The name of its material, if it has one.
    pub material: Option<Spanned<String>>,
    /// The name of its model, if it has one.
    pub model: Option<Spanned<String>>,
    /// Where it is written.
    pub span: Span,
}

const RADII: std::ops::RangeInclusive<f64> = 1.0 / UNIT as f64..=raxel_edit::MOST_RADIUS as f64;

/// An edit, as in a file.
#[derive(Keys)]
#[keys(context = Clock, into = EditKey)]
struct Edit {
    /// Seconds from the start.
    #[keys(read = time, range = 0.0..=f64::MAX, unit = "seconds")]
    time: Spanned<f64>,
    #[keys(flatten)]
    what: What,
    #[keys(span)]
    span: Span,
}

/// An edit that is made at once: one of a demo without a time.
#[derive(Keys)]
struct EditNow {
    #[keys(flatten)]
    what: What,
    #[keys(span)]
    span: Span,
}

#[derive(Keys)]
#[keys(tag = "op")]
enum What {
    /// One voxel.
    Set {
        /// The voxel.
        #[keys(range = CELLS, unit = "voxels")]
        at: [i64; 3],
        #[keys(flatten)]
        brush: Paint,
    },
    /// A box.
    Box {
        #[keys(flatten)]
        corners: Corners,
        #[keys(flatten)]
        brush: Paint,
    },
    /// A ball.
    Sphere {
        /// In voxels.
        #[keys(range = POSITIONS, unit = "voxels")]
        center: [f64; 3],
        /// Radius in voxels, at most 4096.
        #[keys(range = RADII, unit = "voxels")]
        radius: f64,
        #[keys(flatten)]
        brush: Paint,
    },
    /// A cylinder.
    Cylinder {
        /// Centre of its base, in voxels.
        #[keys(range = POSITIONS, unit = "voxels")]
        base: [f64; 3],
        /// Radius in voxels, at most 4096.
        #[keys(range = RADII, unit = "voxels")]
        radius: f64,
        /// In voxels.
        #[keys(range = 1..=1 << 16, unit = "voxels")]
        height: u32,
        /// Axis of the cylinder.
        #[keys(default = Axis::Y)]
        axis: Axis,
        #[keys(flatten)]
        brush: Paint,
    },
    /// A model of the world's file.
    Model {
        /// Name of the model.
        model: Spanned<String>,
        /// Place of the origin of its file, in voxels.
        #[keys(unit = "voxels")]
        origin: [i32; 3],
        /// Degrees to the left, seen from above.
        #[keys(default = QuarterTurns(0), unit = "degrees")]
        rotation: QuarterTurns,
        /// `add` makes voxels solid, `subtract` makes them air, `paint` gives solid ones the material.
        #[keys(default = Mode::Add)]
        mode: Mode,
    },
    /// Restores the voxels of the world file there.
    Restore {
        #[keys(flatten)]
        corners: Corners,
    },
}

/// The effect on the voxels.
#[derive(Keys)]
#[keys(check = painted(mode, material))]
struct Paint {
    /// `add` makes voxels solid, `subtract` makes them air, `paint` gives solid ones the material.
    #[keys(default = Mode::Add)]
    mode: Mode,
    /// Name of a material of the world. May be left out only with `subtract`.
    material: Option<Spanned<String>>,
}

/// `min`, and `max` or `size`.
#[derive(Keys)]
#[keys(check = closed(max, size))]
struct Corners {
    /// The smallest voxel.
    #[keys(range = CELLS, unit = "voxels")]
    min: [i64; 3],
    /// One past the largest voxel, instead of `size`.
    #[keys(range = CELLS, unit = "voxels", excludes("size", why = "one follows from the other"))]
    max: Option<[i64; 3]>,
    /// Voxels along each axis, instead of `max`.
    #[keys(range = 1..=1 << 32, unit = "voxels")]
    size: Option<[i64; 3]>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "a check gets references")]
fn painted(table: &Table<'_, '_>, mode: &Mode, material: Option<&Spanned<String>>) -> bool {
    if *mode == Mode::Subtract {
        return !table.conflict("mode", "material", "emptied voxels have no material");
    }
    material.is_some() || table.need("material").is_some()
}

fn closed(table: &Table<'_, '_>, max: Option<&[i64; 3]>, size: Option<&[i64; 3]>) -> bool {
    max.is_some() || size.is_some() || table.need("max").is_some()
}

impl Corners {
    fn bounds(&self) -> Bounds {
        let size = |size: [i64; 3]| std::array::from_fn(|axis| self.min[axis] + size[axis]);
        Bounds { min: self.min, max: self.size.map(size).or(self.max).unwrap_or(self.min) }
    }
}

impl Paint {
    /// Another material takes the place of this one when the world is known.
    fn brush(&self) -> Brush {
        match self.mode {
            Mode::Add => Brush::Add(1),
            Mode::Paint => Brush::Paint(1),
            Mode::Subtract => Brush::Subtract,
        }
    }
}

impl From<Edit> for EditKey {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a radius is in `RADII`")]
    fn from(Edit { time, what, span }: Edit) -> Self {
        let (mut material, mut named) = (None, None);
        let mut with = |paint: Paint| {
            let brush = paint.brush();
            material = paint.material;
            brush
        };
        let operation = match what {
            What::Set { at, brush } => {
                Operation::Box { bounds: Bounds { min: at, max: at.map(|c| c + 1) }, brush: with(brush) }
            }
            What::Box { corners, brush } => Operation::Box { bounds: corners.bounds(), brush: with(brush) },
            What::Restore { corners } => Operation::Restore { bounds: corners.bounds() },
            What::Sphere { center, radius, brush } => Operation::sphere(center, radius, with(brush)),
            What::Cylinder { base, radius, height, axis, brush } => Operation::Cylinder {
                axis: axis as u8,
                base: base.map(fixed),
                radius: fixed(radius) as u32,
                height,
                brush: with(brush),
            },
            What::Model { model, origin, rotation, mode } => Operation::Model {
                model: named.insert(model).value.clone(),
                orientation: Orientation::quarter_turns(rotation.0).to_vox(),
                position: origin,
                mode,
            },
        };
        Self { time, operation, material, model: named, span }
    }
}

/// An edit in the form of a demo's file, without its time. `None` for one that no file can say: chunks that an undo puts back, a model that
/// lies on its side, a material that the scene does not have.
pub(crate) fn written(operation: &Operation, scene: &Scene) -> Option<String> {
    let voxels = |steps: i64| steps as f64 / UNIT as f64;
    let paint = |brush: Brush| {
        let (mode, material) = match brush {
            Brush::Add(material) => ("add", Some(material)),
            Brush::Paint(material) => ("paint", Some(material)),
            Brush::Subtract => ("subtract", None),
        };
        let Some(material) = material else { return Some(format!("mode = \"{mode}\"")) };
        let material = &scene.materials.get(usize::from(material))?.name;
        Some(format!("mode = \"{mode}\"\nmaterial = {}", quoted(material)))
    };
    Some(match operation {
        Operation::Set { cell, material } => {
            let brush = if *material == AIR { Brush::Subtract } else { Brush::Add(*material) };
            format!("op = \"set\"\nat = {cell:?}\n{}", paint(brush)?)
        }
        Operation::Box { bounds: Bounds { min, max }, brush } => {
            format!("op = \"box\"\nmin = {min:?}\nmax = {max:?}\n{}", paint(*brush)?)
        }
        Operation::Restore { bounds: Bounds { min, max } } => {
            format!("op = \"restore\"\nmin = {min:?}\nmax = {max:?}")
        }
        Operation::Sphere { center, radius, brush } => {
            let (center, radius) = (center.map(voxels), voxels(i64::from(*radius)));
            format!("op = \"sphere\"\ncenter = {center:?}\nradius = {radius:?}\n{}", paint(*brush)?)
        }
        Operation::Cylinder { axis, base, radius, height, brush } => {
            let axis = ["x", "y", "z"].get(usize::from(*axis))?;
            let (base, radius) = (base.map(voxels), voxels(i64::from(*radius)));
            let place = format!("base = {base:?}\nradius = {radius:?}\nheight = {height}\naxis = \"{axis}\"");
            format!("op = \"cylinder\"\n{place}\n{}", paint(*brush)?)
        }
        Operation::Model { model, orientation, position, mode } => {
            let turns = (0..4).find(|turns| Orientation::quarter_turns(*turns).to_vox() == *orientation)?;
            let mode = match mode {
                Mode::Add => "add",
                Mode::Subtract => "subtract",
                Mode::Paint => "paint",
            };
            let place = format!("origin = {position:?}\nrotation = {}\nmode = \"{mode}\"", 90 * turns);
            format!("op = \"model\"\nmodel = {}\n{place}", quoted(model))
        }
        Operation::Put { .. } => return None,
    })
}

/// Reads the edits of the TOML array `edits`, written as in a demo but without times, for a scene. All must be right.
pub fn operations(text: &str, scene: &Scene) -> Result<Vec<Operation>, Vec<Diagnostic>> {
    let reporter = Reporter::new("edits");
    let document = table::parse(text, &reporter);
    let edits = document.as_ref().and_then(|document| {
        let root = Table::root(document, &reporter);
        Vec::<EditNow>::read(&root.need("edits")?, &(), &())
    });
    let found = reporter.into_diagnostics();
    let Some(edits) = edits.filter(|_| found.is_empty()) else { return Err(found) };
    let at_once = |edit: EditNow| {
        let time = Spanned::new(0.0, edit.span.clone());
        EditKey::from(Edit { time, what: edit.what, span: edit.span })
    };
    let resolved = edits.into_iter().map(at_once).map(|edit| edit.resolve(scene).map_err(|error| vec![*error]));
    resolved.collect()
}

/// Reads the edits: all must be right, and none earlier than the one before it.
pub(crate) fn in_order(node: &Node<'_, '_>, clock: &Clock) -> Option<Vec<EditKey>> {
    let keys = Vec::<EditKey>::read(node, &(), clock)?;
    for pair in keys.windows(2) {
        let [before, after] = [&pair[0].time, &pair[1].time];
        if after.value < before.value {
            let message = format!("edits must be in order of time: {} s stands after {} s", after.value, before.value);
            node.reporter().report(
                Diagnostic::error(codes::session::KEY_TIME, message)
                    .label(after.span.clone(), "this one")
                    .label(before.span.clone(), "after this one"),
            );
            return None;
        }
    }
    Some(keys)
}

impl EditKey {
    /// The edit in a world, or its mistake there.
    fn resolve(&self, scene: &Scene) -> Result<Operation, Box<Diagnostic>> {
        let mut operation = self.operation.clone();
        if let Some(material) = &self.material {
            let names = || scene.materials.iter().skip(1).map(|material| material.name.as_str());
            let index = scene
                .material(&material.value)
                .ok_or_else(|| missing(codes::world::UNKNOWN_MATERIAL, "material", material, names().collect()))?;
            operation = operation.with_material(index);
        }
        if let Some(model) = self.model.as_ref().filter(|model| scene.model(&model.value).is_none()) {
            let names = scene.models.iter().map(|model| model.name.as_str()).collect();
            return Err(missing(codes::world::UNKNOWN_MODEL, "model", model, names));
        }
        match operation.bounds(scene) {
            Ok(_) => Ok(operation),
            Err(error) => Err(Box::new(
                Diagnostic::error(codes::world::EDIT, error.to_string()).label(self.span.clone(), "this edit"),
            )),
        }
    }
}

#[allow(clippy::unnecessary_box_returns, reason = "it goes into a result whose error is boxed")]
fn missing(code: raxel_diagnostics::Code, what: &str, named: &Spanned<String>, names: Vec<&str>) -> Box<Diagnostic> {
    let diagnostic = Diagnostic::error(code, format!("the world has no {what} `{}`", named.value))
        .label(named.span.clone(), "named here");
    Box::new(match closest(&named.value, names.iter().copied()) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None if names.is_empty() => diagnostic,
        None => diagnostic.help(format!("it has {}", list(names.into_iter()))),
    })
}

impl Demo {
    /// Everything that is wrong with the edits, over the materials and models of a world.
    pub fn check_edits(&self, scene: &Scene) -> Vec<Diagnostic> {
        self.edits.iter().filter_map(|edit| edit.resolve(scene).err()).map(|error| *error).collect()
    }

    /// The edits that can be made, with their times, in order.
    pub fn script(&self, scene: &Scene) -> Vec<(f64, Operation)> {
        self.edits.iter().filter_map(|edit| Some((edit.time.value, edit.resolve(scene).ok()?))).collect()
    }
}
