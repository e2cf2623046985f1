//! JSON Schema of world files, for editors. A test holds it to the keys that the reader asks for.

use raxel_diagnostics::schema::with_defaults;
use serde_json::{Value, json};

use super::camera::CAMERA_FOV;
use super::stream::StreamSettings;
use raxel_generate::{Menger, Scatter};
use raxel_layouts::instances::MAX_INSTANCES;
use raxel_world::MAX_MATERIALS;

const CELL_MIN: i64 = -(1 << 31);
const CELL_END: i64 = 1 << 31;

/// The schema of `worlds/*.toml` (draft 2020-12).
pub fn schema() -> Value {
    with_defaults(json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "raxel world",
        "description": "Materials and what is built of them, in order.",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "name": about("What the world is called; may be left out.", json!({ "type": "string" })),
            "about": about("One sentence about it; may be left out.", json!({ "type": "string" })),
            "seed": about("Any number: another makes another world of the same kind.", json!({ "type": "integer", "default": 0 })),
            "camera": { "$ref": "#/$defs/camera" },
            "cameras": {
                "description": "Other places to look from, by name: letters, digits, - and _.",
                "type": "object",
                "propertyNames": { "pattern": "^[A-Za-z_][A-Za-z0-9_-]*$" },
                "additionalProperties": { "$ref": "#/$defs/camera" }
            },
            "materials": {
                "description": "Materials by name.",
                "type": "object",
                "maxProperties": MAX_MATERIALS,
                "additionalProperties": { "$ref": "#/$defs/material" }
            },
            "models": {
                "description": ".vox files by name.",
                "type": "object",
                "additionalProperties": { "$ref": "#/$defs/model" }
            },
            "instances": {
                "description": "Models that stand in the world without being part of its voxels, and can move.",
                "type": "array",
                "maxItems": MAX_INSTANCES,
                "items": { "$ref": "#/$defs/instance" }
            },
            "stream": { "$ref": "#/$defs/stream" },
            "save": { "$ref": "#/$defs/save" },
            "build": {
                "description": "What is built, one operation after the other; an empty world when left out.",
                "type": "array",
                "items": { "oneOf": operations() }
            }
        },
        "$defs": {
            "camera": about("Where to look from.", camera()),
            "material": material(),
            "save": about("Where edits of the world are kept.", object(&["path"], vec![
                ("path", "The folder that edits are saved in, relative to the project.", json!({ "type": "string" })),
                ("sync", "Seconds that a power cut may cost.", json!({ "type": "number", "minimum": 0.001, "maximum": 3600, "default": 1.0 })),
                ("on_generator_change", "When the world is built otherwise than when the save was made: leave the save alone, or keep its chunks.", json!({ "enum": ["refuse", "keep"], "default": "refuse" })),
            ])),
            "model": object(&["file"], vec![
                ("file", "A .vox file, relative to worlds/.", json!({ "type": "string" })),
                ("frame", "Which frame of an animation, from 0.", json!({ "type": "integer", "minimum": 0, "maximum": u32::MAX, "default": 0 })),
            ]),
            "layer": object(&["material"], vec![
                ("material", "What it is made of.", name()),
                ("depth", "Voxels; the last layer goes down to the floor when left out.", whole(1)),
            ]),
            "band": object(&["material"], vec![
                ("material", "What the uppermost layer is made of here.", name()),
                ("above", "Only where the surface is at this height or higher, in voxels; at any when left out.", cell()),
                ("below", "Only where the surface is lower than this height, in voxels; at any when left out.", cell()),
                ("slope", "Only where a neighbouring column is at least so many voxels higher or lower; anywhere when left out.", whole(1)),
                ("depth", "Voxels; as deep as the first layer when left out.", whole(1)),
            ]),
            "water": object(&["material", "level"], vec![
                ("material", "What fills everything below the level that is not land.", name()),
                ("level", "The first height without water, in voxels.", cell()),
            ]),
            "caves": object(&["width"], vec![
                ("width", "How far two noises in space may be from 0: wider tunnels.", json!({ "type": "number", "minimum": 0, "maximum": 1 })),
                ("frequency", "Bends for each voxel of the way.", json!({ "type": "number", "exclusiveMinimum": 0, "maximum": 0.25, "default": 1.0 / 64.0 })),
                ("octaves", "How often finer bends are added.", json!({ "type": "integer", "minimum": 1, "maximum": 8, "default": 1 })),
                ("cover", "Voxels of land that stay above them; under water always at least 4.", json!({ "type": "integer", "minimum": 0, "default": 0 })),
                ("above", "Only at this height or higher, in voxels; at any when left out.", cell()),
                ("below", "Only lower than this height, in voxels; at any when left out.", cell()),
                ("seed", "Any number: another one, other caves.", json!({ "type": "integer", "default": 0 })),
            ]),
            "stream": about("The world is made around the camera while it moves, rather than all at once.", stream()),
            "instance": instance(),
            "slide": object(&["param", "along"], vec![
                ("param", "A number among the params of the graph.", json!({ "type": "string" })),
                ("along", "Voxels for each 1 of its value.", vector(3)),
                ("default", "The value, in units of the param, in graphs without that param; such graphs are refused when left out.", json!({ "type": "number" })),
            ]),
            "turn": object(&["param"], vec![
                ("param", "A number among the params of the graph: degrees to the left, seen from the end of the axis.", json!({ "type": "string" })),
                ("axis", "An axis of the world.", json!({ "enum": ["x", "y", "z"], "default": "y" })),
                ("about", "A point on the axis, in voxels; the middle of its own anchor when left out.", vector(3)),
                ("upright", "Goes around the axis without being turned itself.", json!({ "type": "boolean", "default": false })),
                ("default", "The value, in units of the param, in graphs without that param; such graphs are refused when left out.", json!({ "type": "number" })),
            ]),
            "river": object(&["bed", "width", "banks"], vec![
                ("bed", "Height of its bed, in voxels.", json!({ "type": "number" })),
                ("width", "Half the width of its bed, about, in voxels.", positive()),
                ("banks", "Voxels over which the land rises to its own height.", json!({ "type": "number", "minimum": 1 })),
                ("frequency", "Bends for each voxel of the way.", json!({ "type": "number", "exclusiveMinimum": 0, "maximum": 1, "default": 1.0 / 512.0 })),
                ("octaves", "How often finer bends are added.", json!({ "type": "integer", "minimum": 1, "maximum": 16, "default": 2 })),
                ("seed", "Any number: another one, another course.", json!({ "type": "integer", "default": 0 })),
            ]),
        }
    }))
}

fn camera() -> Value {
    object(
        &["position"],
        vec![
            ("position", "Where it starts, in voxels; Y is up.", vector(3)),
            ("look_at", "The place that it looks at, in voxels; instead of yaw and pitch.", vector(3)),
            (
                "yaw",
                "Turn to the left in degrees; 0 looks along −Z.",
                json!({ "type": "number", "minimum": -360, "maximum": 360, "default": 0 }),
            ),
            (
                "pitch",
                "Tilt upwards in degrees.",
                json!({ "type": "number", "minimum": -90, "maximum": 90, "default": 0 }),
            ),
            (
                "fov",
                "Vertical field of view in degrees, 1 to 179.",
                json!({ "type": "number", "minimum": CAMERA_FOV.start(), "maximum": CAMERA_FOV.end(), "default": 60 }),
            ),
        ],
    )
}

fn instance() -> Value {
    let degrees = || json!({ "type": "number", "minimum": -360, "maximum": 360, "default": 0 });
    object(
        &["model", "position"],
        vec![
            ("name", "What it is called; may be left out.", json!({ "type": "string" })),
            ("model", "One of [models].", json!({ "type": "string" })),
            ("position", "Where the anchor's cell goes, in voxels; fractions are allowed.", vector(3)),
            (
                "anchor",
                "The middle of its lowest layer, its smallest corner, or the origin of its file.",
                json!({ "enum": ["base", "corner", "origin"], "default": "base" }),
            ),
            ("yaw", "Degrees to the left, seen from above, about the middle of the anchor's cell.", degrees()),
            ("pitch", "Degrees about its own X axis, before yaw.", degrees()),
            ("roll", "Degrees about its own Z axis, before pitch.", degrees()),
            (
                "count",
                "How many of them along x, y and z: a grid, numbered along x first.",
                json!({
                    "type": "array", "items": { "type": "integer", "minimum": 1, "maximum": MAX_INSTANCES }, "minItems": 3, "maxItems": 3, "default": [1, 1, 1]
                }),
            ),
            (
                "step",
                "Voxels from one to the next of them along x, y and z; all stand in one place when left out.",
                vector(3),
            ),
            ("turn", "Turned by a param, about an axis of the world.", json!({ "$ref": "#/$defs/turn" })),
            ("slide", "Moved by a param, after it was turned.", json!({ "$ref": "#/$defs/slide" })),
        ],
    )
}

fn stream() -> Value {
    type Settings = StreamSettings;
    let memory = |least: u64, most: u64, default: u64| {
        json!({
            "oneOf": [
                { "type": "string", "pattern": "^[0-9]+ *[KMGT]iB$" },
                { "type": "integer", "minimum": least, "maximum": most },
            ],
            "default": format!("{} MiB", default >> 20),
        })
    };
    let voxels = |most: u32| json!({ "type": "integer", "minimum": 64, "maximum": most });
    let mut near = voxels(Settings::MOST_NEAR);
    near["default"] = json!(Settings::NEAR);
    object(
        &[],
        vec![
            ("near", "Voxels around the camera that are there one by one.", near),
            (
                "far",
                "Voxels around the camera that are there at all, beyond `near` in cells of 4, 16 and 64; `near` when left out, and at most 64 times as much.",
                voxels(Settings::MOST_FAR),
            ),
            (
                "height",
                "The lowest height that is loaded, in voxels, and one past the highest; all that is built when left out.",
                cells(2),
            ),
            (
                "gpu_memory",
                "Bytes of the buffer on the device.",
                memory(Settings::LEAST_MEMORY, Settings::MOST_GPU_MEMORY, Settings::GPU_MEMORY),
            ),
            (
                "cpu_memory",
                "Bytes of packed chunks that are kept on the host, so that going back makes nothing again; 0 keeps none.",
                memory(0, Settings::MOST_CPU_MEMORY, Settings::CPU_MEMORY),
            ),
            (
                "lamp_memory",
                "Bytes of the list of lamps (`world.lights`) on the device, in a world where a material gives off light.",
                memory(Settings::LEAST_LAMP_MEMORY, Settings::MOST_GPU_MEMORY, Settings::LAMP_MEMORY),
            ),
            (
                "upload",
                "Bytes that a frame of a window brings to the device, about; at most `gpu_memory`.",
                memory(Settings::LEAST_UPLOAD, Settings::MOST_GPU_MEMORY, Settings::UPLOAD),
            ),
            (
                "source",
                "A store that the world was baked to, in place of [[build]]: a folder of the project, or a URL. The world is built when left out.",
                json!({ "type": "string", "pattern": "^zarr:." }),
            ),
            (
                "threads",
                "Threads that make chunks; 0 is one for each core but one.",
                json!({ "type": "integer", "minimum": 0, "maximum": Settings::MOST_THREADS, "default": 0 }),
            ),
        ],
    )
}

fn material() -> Value {
    let unit = |default: f64| json!({ "type": "number", "minimum": 0, "maximum": 1, "default": default });
    let linear = json!({ "type": "number", "minimum": 0, "maximum": 1 });
    let color = json!({ "oneOf": [
        { "type": "string", "pattern": "^#[0-9a-fA-F]{6}$" },
        { "type": "array", "items": linear, "minItems": 3, "maxItems": 3 },
    ] });
    object(
        &["albedo"],
        vec![
            ("albedo", "\"#rrggbb\" in sRGB, or three linear numbers from 0 to 1.", color),
            ("roughness", "0 is a mirror, 1 is matt.", unit(1.0)),
            ("metallic", "0 is no metal, 1 is metal.", unit(0.0)),
            (
                "emission",
                "Strength of the light it gives off, in multiples of its albedo.",
                json!({ "type": "number", "minimum": 0, "maximum": 1e6, "default": 0 }),
            ),
            ("transparency", "0 is opaque, 1 is clear.", unit(0.0)),
        ],
    )
}

fn operations() -> Vec<Value> {
    let turn = json!({ "enum": [0, 90, 180, 270], "default": 0 });
    let anchor = || json!({ "enum": ["base", "corner", "origin"], "default": "base" });
    vec![
        operation(
            "box",
            "A box.",
            &[],
            [
                extent(3),
                vec![
                    ("shell", "Voxels of its walls when it is hollow; solid when left out.", whole(1)),
                    ("material", "What it is made of; left out only when subtracting.", one_or_more()),
                ],
            ]
            .concat(),
        ),
        operation(
            "sphere",
            "A ball or ellipsoid.",
            &["center", "radius"],
            vec![
                ("center", "In voxels.", vector(3)),
                ("radius", "In voxels: a number, or one for each axis.", json!({ "oneOf": [positive(), vector(3)] })),
                ("shell", "Voxels of its wall when it is hollow; solid when left out.", json!({ "type": "number", "minimum": 1 })),
                ("material", "What it is made of; left out only when subtracting.", one_or_more()),
            ],
        ),
        operation(
            "cylinder",
            "A cylinder, or a cone when its radii differ.",
            &["base", "radius", "height"],
            vec![
                ("base", "Centre of its base, in voxels.", vector(3)),
                ("radius", "In voxels.", positive()),
                ("top_radius", "In voxels; that of the base when left out.", positive()),
                ("height", "In voxels.", whole(1)),
                ("axis", "Along which it stands.", json!({ "enum": ["x", "y", "z"], "default": "y" })),
                ("material", "What it is made of; left out only when subtracting.", one_or_more()),
            ],
        ),
        operation(
            "menger",
            "A Menger sponge of 3^level voxels a side.",
            &["level"],
            vec![
                ("origin", "Its smallest corner, in voxels.", with(json!([0, 0, 0]), cells(3))),
                (
                    "level",
                    "How often it is divided.",
                    json!({ "type": "integer", "minimum": 0, "maximum": Menger::MAX_LEVEL }),
                ),
                ("material", "What it is made of; several go by scale, the coarsest first. Left out only when subtracting.", one_or_more()),
            ],
        ),
        operation(
            "maze",
            "The walls of a maze with one way between any two cells.",
            &["cells"],
            vec![
                ("origin", "Its smallest corner, in voxels.", with(json!([0, 0, 0]), cells(3))),
                (
                    "cells",
                    "How many along x and z.",
                    json!({ "type": "array", "items": whole(1), "minItems": 2, "maxItems": 2 }),
                ),
                (
                    "cell",
                    "Voxels along a cell.",
                    json!({ "type": "integer", "minimum": 1, "maximum": 4096, "default": 4 }),
                ),
                (
                    "wall",
                    "Voxels across a wall.",
                    json!({ "type": "integer", "minimum": 1, "maximum": 4096, "default": 1 }),
                ),
                ("height", "Voxels that the walls are high.", json!({ "type": "integer", "minimum": 1, "default": 8 })),
                ("seed", "Any number: another one, another maze. Its place in the file when left out.", json!({ "type": "integer" })),
                ("material", "What its walls are made of; left out only when subtracting.", one_or_more()),
            ],
        ),
        operation(
            "terrain",
            "Land from fractal noise.",
            &["amplitude", "layers"],
            [
                extent(2),
                vec![
                    ("base", "Height of the lowest land, in voxels.", json!({ "type": "number", "default": 0 })),
                    ("amplitude", "From the lowest land to the highest, in voxels.", positive()),
                    (
                        "exponent",
                        "A power of the heights from 0 to 1: above 1, low land becomes wider and high land steeper.",
                        json!({ "type": "integer", "minimum": 1, "maximum": 8, "default": 1 }),
                    ),
                    (
                        "frequency",
                        "Hills for each voxel of the way.",
                        json!({ "type": "number", "exclusiveMinimum": 0, "maximum": 1, "default": 1.0 / 128.0 }),
                    ),
                    (
                        "octaves",
                        "How often finer detail is added.",
                        json!({ "type": "integer", "minimum": 1, "maximum": 16, "default": 5 }),
                    ),
                    (
                        "lacunarity",
                        "How many times finer each time.",
                        json!({ "type": "number", "minimum": 1, "maximum": 8, "default": 2 }),
                    ),
                    (
                        "gain",
                        "Strength of each time, as a multiple of that of the time before.",
                        json!({ "type": "number", "minimum": 0, "maximum": 1, "default": 0.5 }),
                    ),
                    ("ridges", "Sharp crests instead of round hills.", json!({ "type": "boolean", "default": false })),
                    ("seed", "Any number: another one, another land. Its place in the file when left out.", json!({ "type": "integer" })),
                    ("river", "A valley that meanders through the land.", json!({ "$ref": "#/$defs/river" })),
                    ("floor", "The lowest voxel; 16 below the lowest land when left out.", cell()),
                    ("shell", "Only so many voxels below the surface, and what lies bare; all of them when left out.", whole(1)),
                    (
                        "layers",
                        "From the surface down.",
                        json!({ "type": "array", "minItems": 1, "items": { "$ref": "#/$defs/layer" } }),
                    ),
                    (
                        "bands",
                        "Another uppermost layer by height and slope; the first that fits.",
                        json!({ "type": "array", "items": { "$ref": "#/$defs/band" } }),
                    ),
                    ("water", "Lakes.", json!({ "$ref": "#/$defs/water" })),
                    ("caves", "Tunnels through the land.", json!({ "$ref": "#/$defs/caves" })),
                ],
            ]
            .concat(),
        ),
        operation(
            "model",
            "A model at a place.",
            &["model"],
            vec![
                ("model", "One of [models].", json!({ "type": "string" })),
                ("origin", "Where its anchor goes, in voxels.", with(json!([0, 0, 0]), cells(3))),
                ("rotation", "Degrees to the left about its anchor.", turn),
                ("anchor", "The middle of its lowest layer, its smallest corner, or the origin of its file.", anchor()),
            ],
        ),
        operation(
            "scatter",
            "A model at random places on the ground.",
            &["model"],
            [
                extent(2),
                vec![
                    ("model", "One of [models].", json!({ "type": "string" })),
                    ("count", "How many; instead of density and cell.", json!({ "type": "integer", "minimum": 1, "maximum": Scatter::MAX_COUNT })),
                    (
                        "density",
                        "How many a voxel of the area; instead of count.",
                        json!({ "type": "number", "exclusiveMinimum": 0, "maximum": 1 }),
                    ),
                    (
                        "cell",
                        "At most one in each cell of a grid of so many voxels, on the land of `terrain`; instead of count.",
                        json!({ "type": "integer", "minimum": 1, "maximum": 1 << 20 }),
                    ),
                    (
                        "chance",
                        "How likely a cell is to have one, from 0 to 1.",
                        json!({ "type": "number", "minimum": 0, "maximum": 1, "default": 1 }),
                    ),
                    ("on", "Materials that it stands on; any when left out.", one_or_more()),
                    (
                        "min_spacing",
                        "Least distance between two, in voxels.",
                        json!({ "type": "integer", "minimum": 0, "default": 0 }),
                    ),
                    ("sink", "Voxels that it is sunk into the ground.", json!({ "type": "integer", "default": 0 })),
                    (
                        "rotate",
                        "Whether each gets a random quarter turn.",
                        json!({ "type": "boolean", "default": true }),
                    ),
                    (
                        "anchor",
                        "The middle of its lowest layer, its smallest corner, or the origin of its file.",
                        anchor(),
                    ),
                    ("seed", "Any number: another one, other places. Its place in the file when left out.", json!({ "type": "integer" })),
                ],
            ]
            .concat(),
        ),
    ]
}

type Property = (&'static str, &'static str, Value);

fn operation(op: &str, text: &str, required: &[&str], own: Vec<Property>) -> Value {
    let mut properties = vec![
        ("op", "What is built.", json!({ "const": op })),
        (
            "mode",
            "Sets voxels, empties them, or recolours the solid ones.",
            json!({ "enum": ["add", "subtract", "paint"], "default": "add" }),
        ),
    ];
    properties.extend(own);
    let required: Vec<&str> = std::iter::once("op").chain(required.iter().copied()).collect();
    let mut schema = object(&required, properties);
    schema["description"] = json!(text);
    schema
}

/// `min`, `max`, `size`, `center`, of which two make a box.
fn extent(n: usize) -> Vec<Property> {
    vec![
        ("min", "The smallest voxel; with `max` or `size`, instead of `center`.", cells(n)),
        ("max", "One past the largest voxel; with `min`, instead of `size`.", cells(n)),
        (
            "size",
            "Voxels along each axis; with `min` or `center`, instead of `max`.",
            json!({ "type": "array", "items": whole(1), "minItems": n, "maxItems": n }),
        ),
        ("center", "The middle, in voxels; with `size`, instead of `min`.", cells(n)),
    ]
}

fn object(required: &[&str], properties: Vec<Property>) -> Value {
    let properties: serde_json::Map<String, Value> =
        properties.into_iter().map(|(key, text, schema)| (key.to_owned(), about(text, schema))).collect();
    json!({ "type": "object", "additionalProperties": false, "required": required, "properties": properties })
}

fn about(text: &str, mut schema: Value) -> Value {
    schema["description"] = json!(text);
    schema
}

fn with(default: Value, mut schema: Value) -> Value {
    schema["default"] = default;
    schema
}

fn whole(least: i64) -> Value {
    json!({ "type": "integer", "minimum": least })
}

fn positive() -> Value {
    json!({ "type": "number", "minimum": 0 })
}

fn name() -> Value {
    json!({ "type": "string" })
}

fn one_or_more() -> Value {
    json!({ "oneOf": [name(), { "type": "array", "items": name(), "minItems": 1 }] })
}

fn cell() -> Value {
    json!({ "type": "integer", "minimum": CELL_MIN, "maximum": CELL_END })
}

fn cells(n: usize) -> Value {
    json!({ "type": "array", "items": cell(), "minItems": n, "maxItems": n })
}

fn vector(n: usize) -> Value {
    json!({ "type": "array", "items": { "type": "number" }, "minItems": n, "maxItems": n })
}
