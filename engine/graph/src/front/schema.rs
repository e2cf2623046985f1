//! The JSON Schema (draft 7) of a graph file, for editors: completion, hover texts, mistakes underlined while typing. What can only
//! be known with the shaders at hand the compiler says.

use raxel_diagnostics::schema::with_defaults;
use raxel_language::{Describe, Keys, Shape};
use raxel_shader::format::Format;
use serde_json::{Value, json};

use crate::front::model::{Choices, Clock, Literal, Param};
use crate::front::parse::{DISPLAY_MAPS, MOST_CHOICES};
use crate::front::resolve::FACTS;
use crate::ir::checked::{Builtin, LARGEST_SUBGROUP, MOST_ROUNDS, MOST_STILL, RoundIndex};
use crate::ir::value::ValueType;

/// The schema of `graphs/*.toml`.
pub fn schema() -> Value {
    with_defaults(json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "raxel graph",
        "description": "A compute render graph: targets, buffers, params, blocks and passes.",
        "type": "object",
        "additionalProperties": false,
        // A graph that extends another may have that one's name.
        "anyOf": [{ "required": ["name"] }, { "required": ["extends"] }],
        "properties": {
            "name": text("Name of the graph: needed, unless it extends another."),
            "about": text("What it shows, in one line; may be left out."),
            "present": text("The target or buffer that is shown by default: needed, unless the graph that it extends says it."),
            "extends": text("Another graph file, relative to this one, of which only the differences are written here; left out where a graph stands by itself. Tables are laid over each other by name, key by key; passes by `name`."),
            "params": named("Live values: sliders in the window, tracks in a demo, `--set` on the command line.", "param"),
            "clocks": named("Rhythms of their own, apart from the frames: passes with `every` of a clock run once for each of its ticks.", "clock"),
            "targets": named("Images that passes read and write.", "target"),
            "buffers": named("Storage buffers. They share their names with the targets.", "buffer"),
            "blocks": named("Values that are written once: each table fills every push-constant or uniform block of its name (the name of the instance, or of the block), as far as the pass gives no values of its own.", "fills"),
            "loops": named("Groups of passes that are repeated in each frame: those with `loop = \"NAME\"`, which stand together.", "loop"),
            "passes": {
                "description": "Compute dispatches, in the order in which they run.",
                "type": "array",
                "items": definition_of("pass"),
            },
        },
        "definitions": {
            "param": Param::form().definition(),
            "clock": Clock::form().definition(),
            "target": target(),
            "buffer": buffer(),
            "loop": repeated(),
            "pass": pass(),
            "bind": bind(),
            "fills": fills("Values by member; members of structs in nested tables or by quoted path, e.g. \"sun.direction\"."),
            "member": member(),
            "from": from(),
            "literal": literal("A number, a boolean, or an array of them: as many as a vector has components, columns of a matrix, elements of an array. Instead of `from`."),
            "counts": counts("One, two or three numbers: x, y, z."),
            "remove": flag("Takes it out of the graph that `extends` names.", false),
            "history": {
                "description": "How many earlier frames (ticks, with a clock) are kept, to be read as `NAME@1`, `NAME@2`, …",
                "type": "integer",
                "minimum": 0,
                "maximum": 16,
                "default": 0,
            },
        },
    }))
}

fn text(about: &str) -> Value {
    json!({ "description": about, "type": "string" })
}

fn flag(about: &str, default: bool) -> Value {
    json!({ "description": about, "type": "boolean", "default": default })
}

/// What a value is when it is left out.
fn with(default: Value, mut value: Value) -> Value {
    value["default"] = default;
    value
}

fn definition_of(definition: &str) -> Value {
    json!({ "$ref": format!("#/definitions/{definition}") })
}

/// A table of tables that are named by the author.
fn named(about: &str, definition: &str) -> Value {
    json!({
        "description": about,
        "type": "object",
        "propertyNames": { "pattern": "^[A-Za-z0-9_-]{1,64}$" },
        "additionalProperties": definition_of(definition),
    })
}

/// A table with those keys and no others.
fn table(about: &str, properties: &Value) -> Value {
    json!({ "description": about, "type": "object", "additionalProperties": false, "properties": properties })
}

/// What is declared in the definitions of the schema.
pub fn reference(definition: &str) -> Shape {
    Shape::Schema(definition_of(definition))
}

// A reference has no description of its own, and `allOf`, which could give it one, makes Taplo run out of stack: what needs one is
// written out.

fn literal(about: &str) -> Value {
    let mut schema = Literal::shape(&()).schema();
    schema["description"] = about.into();
    schema
}

impl Describe for Literal {
    type Limits = ();

    fn shape((): &()) -> Shape {
        Shape::Schema(json!({
            "anyOf": [
                { "type": ["number", "boolean"] },
                { "type": "array", "items": definition_of("literal") },
            ],
        }))
    }
}

impl Describe for Choices {
    type Limits = ();

    fn shape((): &()) -> Shape {
        let name = json!({ "type": "string", "minLength": 1 });
        Shape::Schema(json!({ "type": "array", "items": name, "minItems": 2, "maxItems": MOST_CHOICES }))
    }
}

fn counts(about: &str) -> Value {
    let count = json!({ "type": "integer", "minimum": 1, "maximum": u32::MAX });
    json!({ "description": about, "type": "array", "items": count, "minItems": 1, "maxItems": 3 })
}

fn fills(about: &str) -> Value {
    json!({ "description": about, "type": "object", "additionalProperties": definition_of("member") })
}

fn words<'w>(about: &str, words: impl Iterator<Item = &'w str>) -> Value {
    json!({ "description": about, "type": "string", "enum": words.collect::<Vec<_>>() })
}

fn integer(about: &str, minimum: u64, maximum: u64) -> Value {
    json!({ "description": about, "type": "integer", "minimum": minimum, "maximum": maximum })
}

fn pair(about: &str) -> Value {
    json!({ "description": about, "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 })
}

/// What a param can be: anything but a matrix.
pub fn param_types() -> Shape {
    Shape::Words(ValueType::words().filter(|word| *word != "mat4").collect())
}

fn target() -> Value {
    table(
        "An image.",
        &json!({
            "source": text("What supplies it from outside, and passes only read: `world.texture3d`, `model.NAME.texture3d`, or a file of the project, e.g. `file.textures/grass.png` (.png or .exr). Left out where passes write it."),
            "copy": text("What fills it when that changes, at creation and on reset, and passes may write: `world.texture3d` or `model.NAME.texture3d`. Left out where nothing does."),
            "slices": integer("Of a file: it is a strip of so many pictures, one below the other, that are the slices of a 3-D image. A 2-D image when left out.", 1, 2048),
            "encoding": with(json!("linear"), words("Of a file: `srgb` brings its colours into linear light, `linear` takes the numbers as they are.", ["linear", "srgb"].into_iter())),
            "format": words("Texel format, named by GLSL's own layout qualifier. Needed, unless a `source` or `copy` fills it: a file has a format of its own, and can be brought into others.", Format::ALL.iter().map(|f| f.name())),
            "size": size(),
            "mips": {
                "description": "Number of mips; \"full\" goes down to one texel. Those of a file are made by a box filter.",
                "default": 1,
                "anyOf": [{ "type": "integer", "minimum": 1, "maximum": 17 }, { "const": "full" }],
            },
            "layers": with(json!(1), integer("Number of array layers.", 1, 2048)),
            "history": definition_of("history"),
            "clear": literal("Fills it at the start of each frame: one number, or one a channel. When left out, nothing does."),
            "init": literal("Fills it at creation and on reset: one number, or one a channel; the contents then survive from frame to frame. When left out, they do not."),
            "keep": flag("Has memory of its own and keeps its contents from frame to frame (with `clear`: until it is cleared).", false),
            "clock": text("The clock whose ticks turn its history and its clears, instead of the frames. Only passes of that clock write it."),
            "display": display(),
            "remove": definition_of("remove"),
        }),
    )
}

fn size() -> Value {
    let texels = json!({ "type": "integer", "minimum": 1, "maximum": 65_536 });
    let scale = json!({ "type": "number", "minimum": 0.0001, "maximum": 64 });
    json!({
        "description": "A part of the output (0.5), texels ([w, h] or [w, h, d]), or a part of another target or of the world. The output when left out.",
        "anyOf": [
            scale,
            { "type": "array", "items": texels, "minItems": 2, "maxItems": 3 },
            table("A part of another target, of the world, or of the output.", &json!({
                "of": text("The other target, or `world`: three dimensions, one texel per voxel of the world's bounds, rounded up. The output when left out."),
                "scale": {
                    "description": "The part, as a multiple: one number for every axis, or two for width and height of the output.",
                    "default": 1,
                    "anyOf": [scale, { "type": "array", "items": scale, "minItems": 2, "maxItems": 2 }],
                },
            })),
        ],
    })
}

fn display() -> Value {
    let maps = || DISPLAY_MAPS.iter().map(|(word, _)| *word);
    json!({
        "description": "How it becomes a picture; by the map of its format when left out.",
        "anyOf": [
            words("The map.", maps()),
            table("The map with its settings.", &json!({
                "map": words("The map. When left out: `id` for integers, `gray` for one or two channels, `raw` for normalised formats, `color` for other floats.", maps()),
                "range": with(json!([0.0, 1.0]), pair("Values of texels that are shown as the ends of the map.")),
                "channel": with(json!(0), integer("The channel that maps of one channel show, from 0.", 0, 3)),
            })),
        ],
    })
}

fn buffer() -> Value {
    table(
        "A storage buffer.",
        &json!({
            "size": {
                "description": "Bytes, a number of elements, or elements for each texel of a target or of a part of the world, or for each element of another buffer. Needed, unless `values`, `source` or `copy` say it.",
                "anyOf": [
                    { "type": "integer", "minimum": 4 },
                    table("Elements.", &json!({
                        "count": { "description": "Number of elements, instead of `of`.", "type": "integer", "minimum": 1 },
                        "of": text("Elements for each texel of this target, each element of this buffer, or each voxel of the bounds of the `world`; instead of `count`."),
                        "scale": { "description": "With `of = \"world\"`: texels per voxel on every axis, rounded up.", "type": "number", "minimum": 0.0001, "maximum": 64, "default": 1 },
                        "per": with(json!(1), integer("Elements for each of them.", 1, 1 << 16)),
                        "stride": integer("Bytes of an element, a multiple of 4: needed.", 4, 1 << 20),
                    })),
                ],
            },
            "values": {
                "description": "What is in it: numbers, or arrays of as many as a vector has components. Passes only read it. Instead of `size`.",
                "type": "array",
                "items": definition_of("literal"),
                "minItems": 1,
                "maxItems": 4096,
            },
            "type": with(json!("f32"), words("Type of the values; laid out as std430 does, a `vec3` in 16 bytes, a `bool` as a `uint`.", ValueType::words())),
            "source": text("What supplies it from outside, and passes only read: `world.tree64` or another layout, `model.NAME.tree64`, or the bytes of a file, e.g. `file.data/table.bin`. Or `world.edits` or `world.poses`, which passes write: what they do to the world, and where its instances go. Left out where passes write it."),
            "copy": text("What fills it when that changes, at creation and on reset, and passes may write: `world.octree` or another layout, or `model.NAME.octree`. Left out where nothing does."),
            "clear": { "description": "32-bit pattern that fills it at the start of each frame. When left out, nothing does.", "type": "integer" },
            "init": { "description": "32-bit pattern that fills it at creation and on reset; the contents then survive from frame to frame. When left out, they do not.", "type": "integer" },
            "history": definition_of("history"),
            "keep": flag("Has memory of its own and keeps its contents from frame to frame (with `clear`: until it is cleared).", false),
            "clock": text("The clock whose ticks turn its history and its clears, instead of the frames. Only passes of that clock write it."),
            "warnings": warnings(),
            "remove": definition_of("remove"),
        }),
    )
}

fn warnings() -> Value {
    json!({
        "description": "What is said while a word of it is not 0: passes count there what should not be, e.g. what found no room. Nothing when left out.",
        "type": "array",
        "items": table("A count that should be 0.", &json!({
            "offset": { "description": "Where in the buffer the count is, a `uint`: bytes, a multiple of 4.", "type": "integer", "minimum": 0, "default": 0 },
            "says": { "description": "What is counted and what it means for the picture, e.g. \"faces found no slot\"; the count follows it. Needed.", "type": "string", "minLength": 1 },
            "help": text("What can be done about it; may be left out."),
        })),
        "maxItems": 16,
    })
}

fn repeated() -> Value {
    table(
        "Passes that are repeated.",
        &json!({
            "count": {
                "description": "Number of rounds: needed.",
                "anyOf": [
                    { "type": "integer", "minimum": 0, "maximum": MOST_ROUNDS },
                    { "type": "string", "pattern": "^param\\.[A-Za-z0-9_-]+$", "description": "A param of type `i32` or `u32` with a range." },
                    table("From mip to mip.", &json!({ "mips": text("The target: a round for each step from one of its mips to the next. Needed in this form.") })),
                ],
            },
            "order": with(json!("up"), words("Whether `loop.index` goes from 0 up or down to 0.", ["up", "down"].into_iter())),
            "swap": {
                "description": "Pairs of names that change places after each round, for later rounds and for all later passes; none when left out.",
                "type": "array",
                "items": { "type": "array", "items": { "type": "string" }, "minItems": 2, "maxItems": 2 },
            },
            "remove": definition_of("remove"),
        }),
    )
}

/// A number, or one that follows the round of a loop.
fn mip(about: &str) -> Value {
    let rounds = RoundIndex::ALL.map(|index| json!({ "const": index.name(), "description": index.about() }));
    let mut any = vec![json!({ "type": "integer", "minimum": 0, "maximum": 16 })];
    any.extend(rounds);
    json!({ "description": about, "anyOf": any })
}

fn pass() -> Value {
    let sizes: Vec<u32> = (0..=LARGEST_SUBGROUP.ilog2()).map(|log2| 1 << log2).collect();
    table(
        "One compute dispatch of one shader.",
        &json!({
            "name": text("Its name: needed."),
            "shader": text("The shader, relative to shaders/: needed."),
            "entry": with(json!("main"), text("The entry point.")),
            "defines": {
                "description": "Preprocessor definitions.",
                "type": "object",
                "additionalProperties": { "type": ["string", "number", "boolean"] },
            },
            "specialization": {
                "description": "Specialization constants by name: written values, or what is fixed while a plan runs, such as `buffer.NAME.count`.",
                "type": "object",
                "additionalProperties": { "anyOf": [{ "type": ["number", "boolean"] }, definition_of("from")] },
            },
            "subgroup": {
                "description": "Invocations in a subgroup that the device is asked for, if it has subgroups of that size. Those that it makes by itself when left out.",
                "enum": sizes,
            },
            "dispatch": dispatch(),
            "bind": {
                "description": "GLSL name = resource. `NAME@1` is the last frame of NAME.",
                "type": "object",
                "additionalProperties": definition_of("bind"),
            },
            "push": fills("The push constants: every member of the shader's block."),
            "uniforms": {
                "description": "Uniform blocks that raxel fills, by GLSL name.",
                "type": "object",
                "additionalProperties": definition_of("fills"),
            },
            "loop": text("The loop that repeats it; it runs once when left out."),
            "when": when(),
            "every": {
                "description": "Runs at a rhythm of its own; in every frame when left out.",
                "anyOf": [
                    text("The clock that it runs by: once a tick, several times in a frame or not at all."),
                    table("So many times a second, at most once a frame.", &json!({ "hz": { "description": "Times a second: needed in this form.", "type": "number", "minimum": 0.001, "maximum": 10_000 } })),
                    table("Every so many frames.", &json!({ "frames": integer("Runs in frames whose index this divides: needed in this form.", 1, u32::MAX.into()) })),
                    table("Until nothing has changed for so long.", &json!({ "still": integer("Runs while `frame.still`, a number of frames, is less than this: needed in this form.", 1, u64::from(MOST_STILL)) })),
                ],
            },
            "before": text("Over a graph that `extends` names: puts the pass before this one. A new pass goes to the end when left out, one of that graph stays."),
            "after": text("Over a graph that `extends` names: puts the pass after this one. A new pass goes to the end when left out, one of that graph stays."),
            "remove": definition_of("remove"),
        }),
    )
}

fn dispatch() -> Value {
    json!({
        "description": "How many workgroups: [x, y, z], or as many as cover some threads. Needed.",
        "anyOf": [
            definition_of("counts"),
            table("Threads.", &json!({
                "threads": {
                    "description": "One thread per texel of a target, one per element of a buffer (`rx_thread()` of `raxel/thread.glsl` is its index), one per voxel of the bounds of the `world`, or [x, y, z] threads. Needed in this form.",
                    "anyOf": [{ "type": "string" }, definition_of("counts")],
                },
                "mip": with(json!(0), mip("The mip, from 0, whose texels are meant.")),
            })),
            table("Workgroups.", &json!({
                "groups": {
                    "description": "Workgroups, or one for each texel or tile of a target. Needed in this form.",
                    "anyOf": [{ "type": "string" }, definition_of("counts")],
                },
                "tile": with(json!([1, 1, 1]), counts("Texels of a workgroup.")),
                "mip": with(json!(0), mip("The mip, from 0, whose texels are meant.")),
            })),
            table("Threads of a queue.", &json!({
                "count": text("The buffer that holds the number of threads, one `uint`. raxel makes the workgroups of it; `rx_thread()` of `raxel/thread.glsl` is the index. Needed in this form."),
                "offset": { "description": "Where in the buffer, in bytes, a multiple of 4.", "type": "integer", "minimum": 0, "multipleOf": 4, "default": 0 },
            })),
            table("Workgroups read from a buffer.", &json!({
                "indirect": text("The buffer: three `uint`s. Needed in this form."),
                "offset": { "description": "Where in the buffer, in bytes, a multiple of 4.", "type": "integer", "minimum": 0, "multipleOf": 4, "default": 0 },
            })),
        ],
    })
}

fn bind() -> Value {
    json!({
        "anyOf": [
            text("The resource."),
            table("A resource with its view.", &json!({
                "target": text("The resource: needed."),
                "mip": mip("The mip, from 0. A storage image is one (0 when left out), a sampled image all of them."),
                "layer": integer("One layer of many, from 0, as a plain 2-D image; all of them when left out.", 0, 65_535),
                "filter": with(json!("nearest"), words("Filter of a sampled image.", ["nearest", "linear"].into_iter())),
                "wrap": with(json!("clamp"), words("What lies beyond the edge of a sampled image.", ["clamp", "repeat"].into_iter())),
                "partial": flag("The shader stores only some of the texels (or bytes) that are read later: what was there before shows through. Without it, a `writeonly` binding is taken to store all of them.", false),
                "remove": definition_of("remove"),
            })),
        ],
    })
}

fn member() -> Value {
    json!({
        "anyOf": [
            definition_of("from"),
            definition_of("literal"),
            table("A member with its type, checked against the shader.", &json!({
                "type": {
                    "description": "Its type; an array as `vec4[8]`. Needed in this form.",
                    "anyOf": [
                        words("", ValueType::words()),
                        { "type": "string", "pattern": format!("^({})\\[[0-9]+\\]$", ValueType::words().collect::<Vec<_>>().join("|")) },
                    ],
                },
                "from": definition_of("from"),
                "value": definition_of("literal"),
                "offset": integer("Its offset in bytes; it is not checked when left out.", 0, u32::MAX.into()),
                "remove": definition_of("remove"),
            })),
            definition_of("fills"),
        ],
    })
}

fn from() -> Value {
    let builtins: Vec<Value> =
        Builtin::ALL.iter().map(|builtin| json!({ "const": builtin.name(), "description": builtin.about() })).collect();
    let mut any = vec![
        json!({ "type": "string", "pattern": "^param\\.[A-Za-z0-9_-]+$", "description": "A param." }),
        json!({ "type": "string", "pattern": "^target\\.[A-Za-z0-9_-]+\\.size$", "description": "Extent of a target in texels." }),
        json!({ "type": "string", "pattern": "^buffer\\.[A-Za-z0-9_-]+\\.count$", "description": "Number of elements of a buffer." }),
        json!({ "type": "string", "pattern": "^clock\\.[A-Za-z0-9_-]+\\.(tick|delta|phase)$", "description": "Of a clock: the number of the tick (u32), the seconds between ticks (f32), the part of them that has passed since the last one (f32)." }),
        json!({ "type": "string", "pattern": "^material\\..+$", "description": "Index of a named material of the world, a `u32`." }),
    ];
    any.extend(builtins);
    any.extend(RoundIndex::ALL.map(|index| json!({ "const": index.name(), "description": index.about() })));
    json!({ "description": "Where the value comes from, instead of `value`.", "anyOf": any })
}

fn when() -> Value {
    let facts: Vec<String> = FACTS.iter().flat_map(|(fact, _)| [(*fact).to_owned(), format!("!{fact}")]).collect();
    json!({
        "description": "Runs only while this holds; `!` negates. Always when left out.",
        "anyOf": [
            { "enum": facts },
            { "type": "string", "pattern": "^!?param\\.[A-Za-z0-9_-]+$", "description": "A param of type bool." },
            { "const": "always", "description": "Takes the condition of the base away." },
        ],
    })
}
