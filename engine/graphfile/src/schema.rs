//! The JSON Schema (draft 7) of a graph file, for editors: completion, hover texts, mistakes underlined while typing. The compiler reports
//! mistakes that show only with the shaders at hand.

use raxel_diagnostics::schema::with_defaults;
use raxel_graph::ValueType;
use raxel_graph::checked::{Builtin, DisplayMap, LARGEST_SUBGROUP, MOST_ROUNDS, RoundIndex};
use raxel_language::{Describe, Form, Keys, Shape, Word, describe};
use raxel_shader::format::Format;
use serde_json::{Value, json};

use crate::model::{
    Bind, Buffer, BufferSize, Choices, Clock, Dispatch, Display, Elements, Every, File, Literal, Loop, Member, Mip,
    MipSteps, Param, Pass, RelativeSize, Rhythm, Rounds, Scale, Size, Target, Warning,
};
use crate::parse::resources::{LONGEST_AXIS, MOST_MIPS, MOST_WARNINGS, SCALES};
use crate::parse::{LONGEST_ARRAY, MOST_CHOICES};
use crate::resolve::{FACTS, KnownFact};

/// The schema of `graphs/*.toml`.
pub fn schema() -> Value {
    let mut schema = File::form().document("raxel graph");
    // A graph that extends another may have that one's name.
    schema["anyOf"] = json!([{ "required": ["name"] }, { "required": ["extends"] }]);
    schema["definitions"] = with_defaults(json!({
        "param": Param::form().definition(),
        "clock": Clock::form().definition(),
        "target": Target::form().definition(),
        "buffer": Buffer::form().definition(),
        "loop": Loop::form().definition(),
        "pass": Pass::form().definition(),
        "bind": { "anyOf": [text("The resource."), Bind::form().definition()] },
        "fills": described("Values by member; members of structs in nested tables or by quoted path, e.g. \"sun.direction\".", &Shape::by_name(reference("member"))),
        "member": member(),
        "from": from(),
        "literal": described("A number, a boolean, or an array: the components of a vector, the columns of a matrix, the elements of an array.", &Literal::shape(&())),
        "counts": counts("One, two or three numbers: x, y, z."),
        "remove": flag("Removes it from the graph that `extends` names.", false),
    }));
    schema
}

fn text(about: &str) -> Value {
    json!({ "description": about, "type": "string" })
}

fn flag(about: &str, default: bool) -> Value {
    json!({ "description": about, "type": "boolean", "default": default })
}

/// The value with its default.
fn with(default: Value, mut value: Value) -> Value {
    value["default"] = default;
    value
}

fn definition_of(definition: &str) -> Value {
    json!({ "$ref": format!("#/definitions/{definition}") })
}

/// A table of tables that are named by the author.
pub(crate) fn named(definition: &str) -> Shape {
    Shape::Schema(json!({
        "type": "object",
        "propertyNames": { "pattern": "^[A-Za-z0-9_-]{1,64}$" },
        "additionalProperties": definition_of(definition),
    }))
}

/// A table with those keys and no others.
fn table(about: &str, properties: &Value) -> Value {
    json!({ "description": about, "type": "object", "additionalProperties": false, "properties": properties })
}

/// A reference to one of the schema's definitions.
pub(crate) fn reference(definition: &str) -> Shape {
    Shape::Schema(definition_of(definition))
}

// A reference has no description of its own, and `allOf`, which could give it one, makes Taplo run out of stack: a shape that needs one is
// written out.

fn described(about: &str, shape: &Shape) -> Value {
    let mut schema = shape.schema();
    schema["description"] = about.into();
    schema
}

fn counts(about: &str) -> Value {
    let count = json!({ "type": "integer", "minimum": 1, "maximum": u32::MAX });
    json!({ "description": about, "type": "array", "items": count, "minItems": 1, "maxItems": 3 })
}

/// The types of a param: all but a matrix.
pub(crate) fn param_types() -> Shape {
    Shape::words(ValueType::words().filter(|word| *word != "mat4"))
}

/// The types of a member, and arrays of them.
pub(crate) fn member_types() -> Shape {
    let words: Vec<&str> = ValueType::words().collect();
    let array = format!("^({})\\[[0-9]+\\]$", words.join("|"));
    either(&[Shape::words(words).schema(), json!({ "type": "string", "pattern": array })])
}

/// The types of a buffer's value.
pub(crate) fn value_types() -> Shape {
    Shape::words(ValueType::words())
}

pub(crate) fn formats() -> Shape {
    Shape::words(Format::ALL.iter().map(|format| format.name()))
}

pub(crate) fn mip_counts() -> Shape {
    either(&[u32::shape(&(1..=MOST_MIPS).into()).schema(), json!({ "const": "full" })])
}

pub(crate) fn displays() -> Shape {
    let map = described("The map.", &DisplayMap::shape(&()));
    either(&[map, Display::form().definition()])
}

/// An array with something in it.
pub(crate) fn listed_values() -> Shape {
    Shape::array(reference("literal"), 1..=LONGEST_ARRAY)
}

pub(crate) fn listed_warnings() -> Shape {
    Shape::Schema(json!({ "type": "array", "items": Warning::form().definition(), "maxItems": MOST_WARNINGS }))
}

pub(crate) fn pairs_of_names() -> Shape {
    Shape::array(Shape::array(Shape::Text, 2..=2), ..)
}

describe! {
    Literal => either(&[
        json!({ "type": ["number", "boolean"] }),
        json!({ "type": "array", "items": definition_of("literal") }),
    ]);
    Choices => {
        let name = Shape::Schema(json!({ "type": "string", "minLength": 1 }));
        Shape::array(name, 2..=MOST_CHOICES)
    };
    Size => either(&[
        f64::shape(&SCALES.into()).schema(),
        json!({ "type": "array", "items": u32::shape(&(1..=LONGEST_AXIS).into()).schema(), "minItems": 2, "maxItems": 3 }),
        RelativeSize::form().definition(),
    ]);
    Scale => either(&[f64::shape(&SCALES.into()).schema(), <[f64; 2]>::shape(&SCALES.into()).schema()]);
    BufferSize => either(&[json!({ "type": "integer", "minimum": 4 }), Elements::form().definition()]);
    Every => either(&[
        text("The clock: the pass runs once for each tick."),
        rhythm("So many times a second, at most once a frame.", "hz"),
        rhythm("Once in this many frames.", "frames"),
        rhythm("Until nothing has changed for so long.", "still"),
    ]);
    Rounds => either(&[
        u32::shape(&(0..=MOST_ROUNDS).into()).schema(),
        json!({ "type": "string", "pattern": "^param\\.[A-Za-z0-9_-]+$", "description": "A param of type `i32` or `u32` with a range." }),
        MipSteps::form().definition(),
    ]);
    // A number, or one that follows the round of a loop.
    Mip => {
        let level = u32::shape(&(0..=MOST_MIPS - 1).into()).schema();
        let rounds = RoundIndex::ALL.map(|index| json!({ "const": index.name(), "description": index.about() }));
        either(&std::iter::once(level).chain(rounds).collect::<Vec<_>>())
    };
    Dispatch => either(&[
        definition_of("counts"),
        table("Threads.", &json!({
            "threads": {
                "description": "One thread for each texel of a target, element of a buffer, or voxel of the bounds of the `world`; or [x, y, z] threads. `rx_thread()` of `raxel/thread.glsl` is the index of an element. Needed in this form.",
                "anyOf": [{ "type": "string" }, definition_of("counts")],
            },
            "mip": mip(),
        })),
        table("Workgroups.", &json!({
            "groups": {
                "description": "[x, y, z] workgroups, or one for each texel or tile of a target. Needed in this form.",
                "anyOf": [{ "type": "string" }, definition_of("counts")],
            },
            "tile": with(json!([1, 1, 1]), counts("Texels of a workgroup.")),
            "mip": mip(),
        })),
        table("Threads of a queue.", &json!({
            "count": text("The buffer that holds the number of threads, one `uint`. raxel computes the workgroups. `rx_thread()` of `raxel/thread.glsl` is the index. Needed in this form."),
            "offset": { "description": "Place in the buffer, in bytes, a multiple of 4.", "type": "integer", "minimum": 0, "multipleOf": 4, "default": 0 },
        })),
        table("Workgroups read from a buffer.", &json!({
            "indirect": text("The buffer that holds the workgroups along x, y and z: three `uint`s. Needed in this form."),
            "offset": { "description": "Place in the buffer, in bytes, a multiple of 4.", "type": "integer", "minimum": 0, "multipleOf": 4, "default": 0 },
        })),
    ]);
}

/// Values of several forms.
fn either(forms: &[Value]) -> Shape {
    Shape::Schema(json!({ "anyOf": forms }))
}

fn mip() -> Value {
    with(json!(0), described("The mip whose texels are counted, from 0.", &Mip::shape(&())))
}

pub(crate) fn definitions() -> Shape {
    Shape::by_name(Shape::Schema(json!({ "type": ["string", "number", "boolean"] })))
}

pub(crate) fn constants() -> Shape {
    Shape::by_name(either(&[json!({ "type": ["number", "boolean"] }), definition_of("from")]))
}

pub(crate) fn subgroup_sizes() -> Shape {
    let sizes: Vec<u32> = (0..=LARGEST_SUBGROUP.ilog2()).map(|log2| 1 << log2).collect();
    Shape::Schema(json!({ "enum": sizes }))
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
            Member::form().definition(),
            definition_of("fills"),
        ],
    })
}

fn from() -> Value {
    let typed = |ty: ValueType, about: &str| format!("`{}`: {about}", ty.word());
    let of_builtin =
        |builtin: &Builtin| json!({ "const": builtin.name(), "description": typed(builtin.ty(), builtin.about()) });
    let builtins: Vec<Value> = Builtin::ALL.iter().map(of_builtin).collect();
    let mut any = vec![
        json!({ "type": "string", "pattern": "^param\\.[A-Za-z0-9_-]+$", "description": "Value of a param." }),
        json!({ "type": "string", "pattern": "^target\\.[A-Za-z0-9_-]+\\.size$", "description": "`ivec2` or `ivec3`: extent of a target in texels." }),
        json!({ "type": "string", "pattern": "^buffer\\.[A-Za-z0-9_-]+\\.count$", "description": "`u32`: number of elements of a buffer." }),
        json!({ "type": "string", "pattern": "^clock\\.[A-Za-z0-9_-]+\\.(tick|delta|phase)$", "description": "Of a clock. `u32`: number of the tick. `f32`: seconds between ticks, or the part of them since the last tick." }),
        json!({ "type": "string", "pattern": "^material\\..+$", "description": "`u32`: index of a named material of the world." }),
    ];
    any.extend(builtins);
    any.extend(
        RoundIndex::ALL
            .map(|index| json!({ "const": index.name(), "description": format!("`u32`: {}", index.about()) })),
    );
    json!({ "description": "Source of the value.", "anyOf": any })
}

/// Conditions that ask about the world.
pub(crate) fn facts_of_worlds() -> Shape {
    let mut words = words_of_facts(|known| known.name.starts_with("world."));
    words.push(Word { name: "always".into(), about: ALWAYS.to_owned() });
    Shape::Words(words)
}

/// The conditions of `when`.
pub(crate) fn conditions() -> Shape {
    either(&[
        Shape::Words(words_of_facts(|_| true)).schema(),
        json!({ "type": "string", "pattern": "^!?param\\.[A-Za-z0-9_-]+$", "description": "A param of type bool." }),
        json!({ "const": "always", "description": ALWAYS }),
    ])
}

/// The meaning of the word `always`.
const ALWAYS: &str = "Takes the condition of the base away.";

/// Facts and their negations.
fn words_of_facts(asked: impl Fn(&KnownFact) -> bool) -> Vec<Word> {
    let both = |KnownFact { name, holds, .. }: &KnownFact| {
        let negation = format!("`bool`. Holds unless {holds}.");
        [
            Word { name: (*name).into(), about: format!("`bool`. Holds if {holds}.") },
            Word { name: format!("!{name}").into(), about: negation },
        ]
    };
    FACTS.iter().filter(|known| asked(known)).flat_map(both).collect()
}
