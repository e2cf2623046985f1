//! The JSON Schema (draft 7) of a graph file, for editors: completion, hover texts, mistakes underlined while typing. What can only
//! be known with the shaders at hand the compiler says.

use raxel_diagnostics::schema::with_defaults;
use raxel_graph::ValueType;
use raxel_graph::checked::{Builtin, DisplayMap, LARGEST_SUBGROUP, MOST_ROUNDS, RoundIndex};
use raxel_language::{Describe, Form, Keys, Shape};
use raxel_shader::format::Format;
use serde_json::{Value, json};

use crate::model::{
    Bind, Buffer, BufferSize, Choices, Clock, Display, Elements, Literal, Loop, Mip, MipSteps, Param, Part, Rhythm,
    Rounds, Scale, Size, Target, Warning,
};
use crate::parse::resources::{LONGEST_AXIS, LONGEST_HISTORY, MOST_MIPS, MOST_WARNINGS, SCALES};
use crate::parse::{LONGEST_ARRAY, MOST_CHOICES};
use crate::resolve::FACTS;

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
            "target": Target::form().definition(),
            "buffer": Buffer::form().definition(),
            "loop": Loop::form().definition(),
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
                "maximum": LONGEST_HISTORY,
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

/// What a param can be: anything but a matrix.
pub fn param_types() -> Shape {
    Shape::Words(ValueType::words().filter(|word| *word != "mat4").collect())
}

/// What a buffer's value can be.
pub fn value_types() -> Shape {
    Shape::Words(ValueType::words().collect())
}

pub fn formats() -> Shape {
    Shape::Words(Format::ALL.iter().map(|format| format.name()).collect())
}

pub fn mip_counts() -> Shape {
    Shape::Schema(json!({ "anyOf": [{ "type": "integer", "minimum": 1, "maximum": MOST_MIPS }, { "const": "full" }] }))
}

pub fn displays() -> Shape {
    let mut map = DisplayMap::shape(&()).schema();
    map["description"] = "The map.".into();
    Shape::Schema(json!({ "anyOf": [map, Display::form().definition()] }))
}

/// An array with something in it.
pub fn listed_values() -> Shape {
    Shape::Schema(
        json!({ "type": "array", "items": definition_of("literal"), "minItems": 1, "maxItems": LONGEST_ARRAY }),
    )
}

pub fn listed_warnings() -> Shape {
    Shape::Schema(json!({ "type": "array", "items": Warning::form().definition(), "maxItems": MOST_WARNINGS }))
}

pub fn pairs_of_names() -> Shape {
    let pair = json!({ "type": "array", "items": { "type": "string" }, "minItems": 2, "maxItems": 2 });
    Shape::Schema(json!({ "type": "array", "items": pair }))
}

/// Values of several forms.
macro_rules! either {
    ($($value:ty: [$($form:expr),* $(,)?];)*) => {$(
        impl Describe for $value {
            type Limits = ();

            fn shape((): &()) -> Shape {
                Shape::Schema(json!({ "anyOf": [$($form),*] }))
            }
        }
    )*};
}

either! {
    Size: [
        f64::shape(&SCALES.into()).schema(),
        json!({ "type": "array", "items": u32::shape(&(1..=LONGEST_AXIS).into()).schema(), "minItems": 2, "maxItems": 3 }),
        Part::form().definition(),
    ];
    Scale: [f64::shape(&SCALES.into()).schema(), <[f64; 2]>::shape(&SCALES.into()).schema()];
    BufferSize: [json!({ "type": "integer", "minimum": 4 }), Elements::form().definition()];
    Rounds: [
        u32::shape(&(0..=MOST_ROUNDS).into()).schema(),
        json!({ "type": "string", "pattern": "^param\\.[A-Za-z0-9_-]+$", "description": "A param of type `i32` or `u32` with a range." }),
        MipSteps::form().definition(),
    ];
}

/// A number, or one that follows the round of a loop.
impl Describe for Mip {
    type Limits = ();

    fn shape((): &()) -> Shape {
        let rounds = RoundIndex::ALL.map(|index| json!({ "const": index.name(), "description": index.about() }));
        let mut any = vec![u32::shape(&(0..=MOST_MIPS - 1).into()).schema()];
        any.extend(rounds);
        Shape::Schema(json!({ "anyOf": any }))
    }
}

fn mip(about: &str) -> Value {
    let mut schema = Mip::shape(&()).schema();
    schema["description"] = about.into();
    schema
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
                    rhythm("So many times a second, at most once a frame.", "hz"),
                    rhythm("Every so many frames.", "frames"),
                    rhythm("Until nothing has changed for so long.", "still"),
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
    json!({ "anyOf": [text("The resource."), Bind::form().definition()] })
}

/// One form of a rhythm.
fn rhythm(about: &'static str, key: &str) -> Value {
    let keys = Rhythm::form().keys.into_iter().filter(|known| known.name == key).collect();
    Form { about, keys, forms: Vec::new() }.definition()
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

/// Conditions that ask about the world.
pub fn facts_of_worlds() -> Shape {
    let known = FACTS.iter().filter(|(fact, _)| fact.starts_with("world."));
    let mut words: Vec<String> = known.flat_map(|(fact, _)| [(*fact).to_owned(), format!("!{fact}")]).collect();
    words.push("always".to_owned());
    Shape::Schema(json!({ "enum": words }))
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
