//! One declaration, and the reader, the schema and the list of keys that come from it.

use raxel_diagnostics::Span;
use raxel_language::{ByName, Keys, Node, Spanned, Table};
use serde_json::json;

use crate::{messages, read};

/// A room.
#[derive(Debug, PartialEq, Keys)]
#[keys(check = ordered(low, high))]
struct Room {
    /// Its name.
    ///
    /// Not for the schema.
    name: Option<String>,
    /// The floor.
    #[keys(range = -100.0..=100.0, unit = "metres")]
    low: Spanned<f64>,
    /// The ceiling.
    #[keys(range = -100.0..=100.0, unit = "metres")]
    high: Spanned<f64>,
    /// Its colour.
    #[keys(default = [1, 2, 3])]
    color: [u8; 3],
    /// Degrees to the left.
    #[keys(default = 180.0, map = f64::to_radians)]
    turn: f64,
    /// What is made here.
    #[keys(rename = "use", told = Purpose::LivingRoom)]
    purpose: Option<Purpose>,
    /// Even numbers.
    #[keys(read = even, range = 0..=8)]
    even: Option<u32>,
    /// Lamps.
    lamps: Vec<Lamp>,
    /// Doors, by name.
    doors: ByName<Door>,
    #[keys(flatten)]
    heating: Heating,
    #[keys(skip)]
    visits: usize,
}

/// A purpose.
#[derive(Clone, Copy, Debug, PartialEq, Keys)]
enum Purpose {
    LivingRoom,
    #[keys(rename = "bath")]
    Bathroom,
}

/// A lamp.
#[derive(Debug, PartialEq, Keys)]
#[keys(tag = "kind")]
enum Lamp {
    /// Hangs.
    Hanging {
        /// Of the cable.
        length: u32,
    },
    /// Stands.
    Standing {},
}

/// A door.
#[derive(Debug, PartialEq, Keys)]
struct Door {
    #[keys(entry)]
    name: Spanned<String>,
    /// How wide it is.
    width: f64,
}

/// What warms it.
#[derive(Debug, PartialEq, Keys)]
enum Heating {
    /// Fire.
    #[keys(key = "wood", excludes = "a room has one oven")]
    Oven {
        /// Logs a day.
        wood: u32,
    },
    /// Water.
    Water {
        /// Of the water.
        #[keys(excludes("cold", why = "it is warm or not"))]
        warm: Option<f64>,
        /// There is none.
        cold: Option<bool>,
    },
}

fn ordered(table: &Table<'_, '_>, low: &Spanned<f64>, high: &Spanned<f64>) -> bool {
    let right = low.value < high.value;
    if !right && let Some(node) = table.get("high") {
        node.bad_value::<()>(format!("`high` is below `low`, {}", low.value));
    }
    right
}

fn even(node: &Node<'_, '_>) -> Option<u32> {
    let number = node.integer(0..=8)?;
    if number % 2 == 0 { Some(number) } else { node.bad_value(format!("{number} is odd")) }
}

const ROOM: &str = r"low = 0
high = 3.5
turn = 90
use = 'bath'
even = 4
wood = 7
lamps = [{ kind = 'hanging', length = 2 }, { kind = 'standing' }]
[doors.b]
width = 1
[doors.a]
width = 2
";

#[test]
fn a_table_is_read_from_its_declaration() {
    let room: Room = read(ROOM).unwrap();
    let spanned = |value, at: std::ops::Range<usize>| Spanned::new(value, Span::new("f.toml", at));
    assert_eq!((&room.low, &room.high), (&spanned(0.0, 6..7), &spanned(3.5, 15..18)));
    assert_eq!((room.name, room.color, room.purpose, room.even), (None, [1, 2, 3], Some(Purpose::Bathroom), Some(4)));
    assert!((room.turn - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    assert_eq!(room.lamps, [Lamp::Hanging { length: 2 }, Lamp::Standing {}]);
    let doors: Vec<_> = room.doors.iter().map(|door| (door.name.value.as_str(), door.width)).collect();
    assert_eq!(doors, [("b", 1.0), ("a", 2.0)], "in the order of the file");
    assert_eq!(room.heating, Heating::Oven { wood: 7 });
    let room: Room = read("low = 0\nhigh = 1\nwarm = 40").unwrap();
    assert_eq!(room.heating, Heating::Water { warm: Some(40.0), cold: None });
    assert_eq!((room.lamps.len(), room.doors.len(), room.purpose, room.visits), (0, 0, None, 0));
    assert!((room.turn - std::f64::consts::PI).abs() < 1e-9, "a default is what the file would say");
}

#[test]
fn everything_wrong_is_reported_at_once() {
    let text = r"name = 1
low = 200
color = [1, 256, 'x']
use = 'bat'
even = 3
wood = 1
warm = 2
cold = true
lmps = 1
lamps = [{}, 3, { kind = 'hangin' }, { kind = 'hanging', lenght = 1 }]
[doors.a]
width = 'w'
";
    assert_eq!(
        messages::<Room>(text),
        [
            "`name` needs a string, not an integer",
            "`low` is 200; it must be in -100…100",
            "the file needs the key `high`",
            "`color[1]` is 256; it must be in 0…255",
            "`color[2]` needs an integer, not a string",
            "`use` cannot be `bat`",
            "3 is odd",
            "`lamps[0]` needs the key `kind`",
            "`lamps[1]` needs a table, not an integer",
            "`lamps[2].kind` cannot be `hangin`",
            "`lamps[3]` has no key `lenght`",
            "`doors.a.width` needs a number, not a string",
            "`wood` and `warm` exclude each other: a room has one oven",
            "`wood` and `cold` exclude each other: a room has one oven",
            "the file has no key `lmps`",
        ]
    );
    assert_eq!(
        messages::<Room>("low = 2\nhigh = 1\nwarm = 1\ncold = true"),
        ["`warm` and `cold` exclude each other: it is warm or not", "`high` is below `low`, 2",]
    );
    let found = read::<Room>("low = 0\nhigh = 1\nuse = 'bat'").unwrap_err();
    assert_eq!(found[0].help, ["did you mean `bath`?", "one of: `living_room`, `bath`"]);
    // A check does not run on values that are wrong themselves.
    assert_eq!(messages::<Room>("low = 2\nhigh = 'x'"), ["`high` needs a number, not a string"]);
}

#[test]
fn the_schema_follows_from_the_declaration() {
    let number = |about: &str| json!({ "description": about, "type": "number", "minimum": -100, "maximum": 100 });
    let table = |needed: &[&str], properties: serde_json::Value| json!({ "type": "object", "additionalProperties": false, "required": needed, "properties": properties });
    let mut hanging = table(
        &["kind", "length"],
        json!({
            "kind": { "description": "Hangs.", "const": "hanging" },
            "length": { "description": "Of the cable.", "type": "integer" },
        }),
    );
    hanging["description"] = json!("Hangs.");
    let mut standing = table(&["kind"], json!({ "kind": { "description": "Stands.", "const": "standing" } }));
    standing["description"] = json!("Stands.");
    let lamps = json!([hanging, standing]);
    let door = table(&["width"], json!({ "width": { "description": "How wide it is.", "type": "number" } }));
    let expected = json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "a room",
        "description": "A room.",
        "type": "object",
        "additionalProperties": false,
        "required": ["low", "high"],
        "properties": {
            "name": { "description": "Its name.", "type": "string" },
            "low": number("The floor."),
            "high": number("The ceiling."),
            "color": {
                "description": "Its colour. Default: `[1, 2, 3]`.",
                "type": "array",
                "items": { "type": "integer" },
                "minItems": 3,
                "maxItems": 3,
                "default": [1, 2, 3],
            },
            "turn": { "description": "Degrees to the left. Default: `180`.", "type": "number", "default": 180 },
            "use": {
                "description": "What is made here. Default: `\"living_room\"`.",
                "type": "string",
                "enum": ["living_room", "bath"],
                "default": "living_room",
            },
            "even": { "description": "Even numbers.", "type": "integer", "minimum": 0, "maximum": 8 },
            "lamps": { "description": "Lamps.", "type": "array", "items": { "oneOf": lamps } },
            "doors": { "description": "Doors, by name.", "type": "object", "additionalProperties": door },
            "wood": { "description": "Logs a day. Not beside `warm` or `cold`: a room has one oven.", "type": "integer" },
            "warm": {
                "description": "Of the water. Not beside `cold`: it is warm or not. Not beside `wood`: a room has one oven.",
                "type": "number",
            },
            "cold": {
                "description": "There is none. Not beside `warm`: it is warm or not. Not beside `wood`: a room has one oven.",
                "type": "boolean",
            },
        },
        "not": { "anyOf": [
            { "required": ["wood", "warm"] },
            { "required": ["wood", "cold"] },
            { "required": ["warm", "cold"] },
        ] },
    });
    assert_eq!(Room::form().document("a room"), expected);
}

#[test]
fn keys_are_listed_with_all_that_is_known_of_them() {
    let said: Vec<String> = Room::form().all_keys().iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "name: text. Its name.",
            "low: number in -100…100, metres, needed. The floor.",
            "high: number in -100…100, metres, needed. The ceiling.",
            "color: array of 3 (integer), [1,2,3] by default. Its colour.",
            "turn: number, 180 by default. Degrees to the left.",
            "use: living_room or bath, \"living_room\" by default. What is made here.",
            "even: integer in 0…8. Even numbers.",
            "lamps: array (table). Lamps.",
            "doors: by name (table). Doors, by name.",
            "wood: integer. Logs a day. Not beside `warm` or `cold`: a room has one oven.",
            "warm: number. Of the water. Not beside `cold`: it is warm or not. Not beside `wood`: a room has one oven.",
            "cold: true or false. There is none. Not beside `warm`: it is warm or not. Not beside `wood`: a room has one oven.",
        ]
    );
}
