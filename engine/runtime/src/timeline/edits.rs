//! `[[edits]]`: edits of the world at times of a demo.

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::table::{Reporter, Table};
use raxel_diagnostics::{Diagnostic, Span, Spanned, codes};
use raxel_edit::{Brush, Operation, Scene, UNIT, fixed};
use raxel_world::{Bounds, Mode, Orientation};
use serde_json::{Value, json};

use super::demo::Demo;
use super::read::time;
use crate::editing::scene_of;
use crate::world::SessionWorld;

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

#[derive(Clone, Copy)]
enum Kind {
    Set,
    Box,
    Sphere,
    Cylinder,
    Model,
    Restore,
}

const KINDS: &[(&str, Kind)] = &[
    ("set", Kind::Set),
    ("box", Kind::Box),
    ("sphere", Kind::Sphere),
    ("cylinder", Kind::Cylinder),
    ("model", Kind::Model),
    ("restore", Kind::Restore),
];
const MODES: &[(&str, Mode)] = &[("add", Mode::Add), ("subtract", Mode::Subtract), ("paint", Mode::Paint)];
const AXES: &[(&str, u8)] = &[("x", 0), ("y", 1), ("z", 2)];
const CELLS: std::ops::RangeInclusive<i64> = -(1 << 31)..=1 << 31;
const POSITIONS: std::ops::RangeInclusive<f64> = -2_147_483_648.0..=2_147_483_648.0;
const RADII: std::ops::RangeInclusive<f64> = 1.0 / UNIT as f64..=raxel_edit::MOST_RADIUS as f64;

/// Reads one edit. Whatever is wrong with it has been reported when there is none.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a radius is in `RADII`")]
pub(super) fn read(table: &Table<'_, '_>, end: f64) -> Option<EditKey> {
    let time = table.need("time").and_then(|node| time(&node, end));
    let kind = table.need("op")?.word(KINDS)?;
    let mode = match kind {
        Kind::Restore => Some(Mode::Subtract),
        _ => table.get("mode").map_or(Some(Mode::Add), |node| node.word(MODES)),
    };
    let painted = matches!(mode, Some(Mode::Add | Mode::Paint)) && !matches!(kind, Kind::Model | Kind::Restore);
    let material = if painted {
        table.need_string("material").map(|(value, span)| Some(Spanned { value, span }))
    } else {
        Some(None)
    };
    // Another material takes its place when the world is known.
    let brush = mode.map(|mode| match mode {
        Mode::Add => Brush::Add(1),
        Mode::Paint => Brush::Paint(1),
        Mode::Subtract => Brush::Subtract,
    });
    let mut model = None;
    let operation = match kind {
        Kind::Set => table.need("at").and_then(|node| node.integers::<_, 3>(CELLS)).and_then(|at| {
            let at = Bounds { min: at, max: at.map(|c| c + 1) };
            brush.map(|brush| Operation::Box { bounds: at, brush })
        }),
        Kind::Box => bounds(table).zip(brush).map(|(bounds, brush)| Operation::Box { bounds, brush }),
        Kind::Restore => bounds(table).map(|bounds| Operation::Restore { bounds }),
        Kind::Sphere => {
            let center = position(table, "center");
            let radius = table.need("radius").and_then(|node| node.number(RADII));
            center.zip(radius).zip(brush).map(|((center, radius), brush)| Operation::sphere(center, radius, brush))
        }
        Kind::Cylinder => {
            let base = position(table, "base");
            let radius = table.need("radius").and_then(|node| node.number(RADII));
            let height = table.need("height").and_then(|node| node.integer(1..=1 << 16));
            let axis = table.get("axis").map_or(Some(1), |node| node.word(AXES));
            base.zip(radius).zip(height).zip(axis.zip(brush)).map(|(((base, radius), height), (axis, brush))| {
                let radius = fixed(radius) as u32;
                Operation::Cylinder { axis, base: base.map(fixed), radius, height, brush }
            })
        }
        Kind::Model => {
            let named = table.need_string("model").map(|(value, span)| Spanned { value, span });
            let origin = table.need("origin").and_then(|node| node.integers(i32::MIN..=i32::MAX));
            let turns = table.get("rotation").map_or(Some(0), |node| match node.integer(0..=270)? {
                degrees if degrees % 90 == 0 => Some(degrees / 90),
                degrees => node.bad_value(format!("`{}` is {degrees}; it must be 0, 90, 180 or 270", node.name)),
            });
            model.clone_from(&named);
            named.zip(origin).zip(turns.zip(mode)).map(|((named, origin), (turns, mode))| Operation::Model {
                model: named.value,
                orientation: Orientation::quarter_turns(turns).to_vox(),
                position: origin,
                mode,
            })
        }
    };
    table.finish();
    let span = table.span().clone();
    Some(EditKey { time: time?, operation: operation?, material: material?, model, span })
}

fn position(table: &Table<'_, '_>, key: &str) -> Option<[f64; 3]> {
    table.need(key).and_then(|node| node.numbers(POSITIONS))
}

/// `min`, and `max` or `size`.
fn bounds(table: &Table<'_, '_>) -> Option<Bounds> {
    let min = table.need("min").and_then(|node| node.integers::<_, 3>(CELLS));
    table.conflict("max", "size", "one follows from the other");
    let size = table.get("size").map(|node| node.integers::<_, 3>(1..=1 << 32));
    let max = match size {
        Some(size) => min.zip(size).map(|(min, size)| std::array::from_fn(|i| min[i] + size[i])),
        None => table.need("max").and_then(|node| node.integers::<_, 3>(CELLS)),
    };
    Some(Bounds { min: min?, max: max? })
}

/// The edits, if all are right and none is earlier than the one before it.
pub(super) fn in_order(reporter: &Reporter, keys: Vec<Option<EditKey>>) -> Option<Vec<EditKey>> {
    let keys: Vec<EditKey> = keys.into_iter().collect::<Option<_>>()?;
    for pair in keys.windows(2) {
        let [before, after] = [&pair[0].time, &pair[1].time];
        if after.value < before.value {
            let message = format!("edits must be in order of time: {} s stands after {} s", after.value, before.value);
            reporter.report(
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
    /// The edit in a world, or what is wrong with it there.
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
    /// Everything that is wrong with the edits in a world.
    pub fn check_edits_in(&self, world: &SessionWorld) -> Vec<Diagnostic> {
        self.check_edits(&scene_of(world))
    }

    fn check_edits(&self, scene: &Scene) -> Vec<Diagnostic> {
        self.edits.iter().filter_map(|edit| edit.resolve(scene).err()).map(|error| *error).collect()
    }

    /// The edits that can be made, with their times, in order.
    pub(crate) fn script(&self, scene: &Scene) -> Vec<(f64, Operation)> {
        self.edits.iter().filter_map(|edit| Some((edit.time.value, edit.resolve(scene).ok()?))).collect()
    }
}

/// The schemas of the edits, one for each `op`.
pub(super) fn schemas(time: &Value) -> Vec<Value> {
    let cells = |about: &str| json!({ "description": about, "type": "array", "items": { "type": "integer" }, "minItems": 3, "maxItems": 3 });
    let vector = |about: &str| json!({ "description": about, "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3 });
    let radius =
        json!({ "description": "In voxels, at most 4096.", "type": "number", "exclusiveMinimum": 0, "maximum": 4096 });
    let mode = json!({ "description": "Sets voxels, empties them, or recolours the solid ones.", "enum": ["add", "subtract", "paint"], "default": "add" });
    let material =
        json!({ "description": "A material of the world; left out only when subtracting.", "type": "string" });
    let corners = || {
        vec![
            ("min", cells("The smallest voxel.")),
            ("max", cells("One past the largest voxel, instead of `size`.")),
            ("size", cells("Voxels along each axis, instead of `max`.")),
        ]
    };
    let brush = || vec![("mode", mode.clone()), ("material", material.clone())];
    let of = |op: &str, about: &str, needed: &[&str], keys: Vec<Vec<(&str, Value)>>| {
        let mut properties = serde_json::Map::new();
        properties.insert("time".to_owned(), time.clone());
        properties.insert("op".to_owned(), json!({ "description": about, "const": op }));
        properties.extend(keys.into_iter().flatten().map(|(key, value)| (key.to_owned(), value)));
        let required: Vec<&str> = ["time", "op"].iter().chain(needed).copied().collect();
        json!({ "type": "object", "additionalProperties": false, "required": required, "properties": properties })
    };
    vec![
        of("set", "One voxel.", &["at"], vec![vec![("at", cells("The voxel."))], brush()]),
        of("box", "A box.", &["min"], vec![corners(), brush()]),
        of(
            "sphere",
            "A ball.",
            &["center", "radius"],
            vec![vec![("center", vector("In voxels.")), ("radius", radius.clone())], brush()],
        ),
        of(
            "cylinder",
            "A cylinder.",
            &["base", "radius", "height"],
            vec![
                vec![
                    ("base", vector("Centre of its base, in voxels.")),
                    ("radius", radius.clone()),
                    (
                        "height",
                        json!({ "description": "In voxels.", "type": "integer", "minimum": 1, "maximum": 65536 }),
                    ),
                    (
                        "axis",
                        json!({ "description": "Along which it stands.", "enum": ["x", "y", "z"], "default": "y" }),
                    ),
                ],
                brush(),
            ],
        ),
        of(
            "model",
            "A model of the world's file.",
            &["model", "origin"],
            vec![vec![
                ("model", json!({ "description": "Its name.", "type": "string" })),
                ("origin", cells("Where its origin goes, in voxels.")),
                (
                    "rotation",
                    json!({ "description": "Degrees to the left, seen from above.", "enum": [0, 90, 180, 270], "default": 0 }),
                ),
                ("mode", mode.clone()),
            ]],
        ),
        of("restore", "Back to what the world's file builds there.", &["min"], vec![corners()]),
    ]
}
