//! What a declaration gives: readers with all their messages, schemas, lists of keys, merges.

use raxel_diagnostics::table::read_document;
use raxel_diagnostics::{Diagnostic, SourceMap, Span, codes};
use raxel_language::{
    ByName, Conflict, Describe, Keys, Layer, Named, Node, ReadKeys, Shape, Spanned, Table, Value, layer,
};
use serde_json::json;

fn read<T: ReadKeys>(text: &str) -> Result<T, Vec<Diagnostic>> {
    read_document("f.toml", text, &mut SourceMap::default(), |root| T::read_whole(root, &())).map(|(value, _)| value)
}

fn messages<T: ReadKeys>(text: &str) -> Vec<String> {
    match read::<T>(text) {
        Ok(_) => Vec::new(),
        Err(found) => found.into_iter().map(|found| found.message).collect(),
    }
}

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

/// A sign, whose keys are references to definitions.
#[derive(Debug, PartialEq, Keys)]
struct Sign {
    /// Its text.
    #[keys(shape = Shape::Schema(json!({ "$ref": "#/definitions/text" })))]
    text: Option<String>,
    /// Its arrow.
    #[keys(shape = Shape::Schema(json!({ "$ref": "#/definitions/text" })), excludes("text", why = "a sign is small"))]
    arrow: Option<String>,
    /// Its edge.
    #[keys(shape = Shape::Schema(json!({ "$ref": "#/definitions/text" })))]
    edge: Option<String>,
}

#[test]
fn both_keys_of_a_conflict_know_it() {
    assert_eq!(messages::<Sign>("text = 't'\narrow = 'a'"), ["`arrow` and `text` exclude each other: a sign is small"]);
    let form = Sign::form();
    let conflict = |with| vec![Conflict { with, why: "a sign is small" }];
    let conflicts: Vec<_> = form.keys.iter().map(|key| key.conflicts.clone()).collect();
    assert_eq!(conflicts, [conflict("arrow"), conflict("text"), Vec::new()]);
    let schema = form.schema();
    assert_eq!(schema["not"], json!({ "required": ["text", "arrow"] }));
    // A definition cannot know of the conflicts of those who refer to it.
    assert_eq!(schema["properties"]["text"]["description"], "Its text. Not beside `arrow`: a sign is small.");
    assert_eq!(schema["properties"]["edge"], json!({ "$ref": "#/definitions/text" }));
}

/// A place in a room of so many dimensions.
#[derive(Debug, PartialEq, Keys)]
#[keys(check = short(at))]
struct At<const N: usize> {
    /// Steps along each axis.
    #[keys(range = 0..=9)]
    at: [u32; N],
}

fn short<const N: usize>(table: &Table<'_, '_>, at: &[u32; N]) -> bool {
    let right = at.iter().sum::<u32>() < 10;
    if !right && let Some(node) = table.get("at") {
        node.bad_value::<()>("there is a wall");
    }
    right
}

/// Where something stands.
#[derive(Debug, PartialEq, Keys)]
#[keys(tag = "in")]
enum Stand {
    /// On the floor.
    Floor(At<2>),
    /// In the air.
    Air(At<3>),
}

#[test]
fn a_form_can_be_another_declaration_for_a_number_of_dimensions() {
    assert_eq!(read("in = 'floor'\nat = [1, 2]"), Ok(Stand::Floor(At { at: [1, 2] })));
    assert_eq!(read("in = 'air'\nat = [1, 2, 3]"), Ok(Stand::Air(At { at: [1, 2, 3] })));
    assert_eq!(messages::<Stand>("in = 'floor'\nat = [1, 2, 3]"), ["`at` needs 2 integers, not 3"]);
    assert_eq!(
        messages::<Stand>("in = 'air'\nat = [9, 9, 9]\nzzzz = 1"),
        ["there is a wall", "the file has no key `zzzz`"]
    );
    let forms = Stand::form().forms;
    assert_eq!(
        (forms[1].about, forms[1].keys[1].to_string()),
        ("In the air.", "at: array of 3 (integer in 0…9), needed. Steps along each axis.".to_owned())
    );
}

#[test]
fn shapes_say_how_many_and_which() {
    let some = Shape::array(Shape::Text, 1..);
    let either = Shape::Either(vec![Shape::Text, Shape::array(Shape::Text, 1..=4)]);
    assert_eq!(some.schema(), json!({ "type": "array", "items": { "type": "string" }, "minItems": 1 }));
    assert_eq!(either.schema()["oneOf"][1]["maxItems"], 4);
    assert_eq!(either.to_string(), "text, or array (text)");
}

/// A slider.
#[derive(Clone, Debug, Keys)]
#[keys(layer("slider", unknown = codes::graph::UNKNOWN_PARAM), over = one_beside, check = labelled(value, label))]
struct Slider {
    #[keys(entry)]
    name: Spanned<String>,
    /// Takes it away.
    #[keys(remove)]
    remove: bool,
    #[keys(flawed)]
    flawed: bool,
    /// Its value.
    value: Option<f64>,
    /// Text beside it.
    #[keys(excludes("icon", why = "there is room for one"))]
    label: Option<Spanned<String>>,
    /// Picture beside it.
    icon: Option<String>,
}

/// What stands beside a slider is one thing in the whole, too.
fn one_beside(below: &mut Slider, above: &Slider) {
    if above.label.is_some() || above.icon.is_some() {
        (below.label, below.icon) = (None, None);
    }
}

fn labelled(table: &Table<'_, '_>, value: Option<&f64>, label: Option<&Spanned<String>>) -> bool {
    let right = value.is_none_or(|value| *value < 9.0) || label.is_some();
    if !right && let Some(node) = table.get("value") {
        node.bad_value::<()>(format!("`{}` is large and has no label", table.name()));
    }
    right
}

fn sliders(text: &str) -> (Vec<Slider>, Vec<String>) {
    let mut read = Vec::new();
    let found = read_document("f.toml", text, &mut SourceMap::default(), |root| {
        read = ByName::read(&root.get("s")?, &(), &()).map(|sliders: ByName<Slider>| sliders.0)?;
        Some(())
    });
    (read, found.map_or_else(|found| found, |((), found)| found).into_iter().map(|found| found.message).collect())
}

#[test]
fn layers_are_read_whatever_is_wrong_with_them() {
    let (read, found) = sliders(
        r"[s.a]
value = 'x'
label = 'l'
[s.b]
label = 'l'
icon = 'i'
[s.c]
value = 1
vlaue = 2
[s.d]
[s.e]
remove = true
value = 1
[s.f]
value = 9
",
    );
    assert_eq!(
        found,
        [
            "`s.a.value` needs a number, not a string",
            "`label` and `icon` exclude each other: there is room for one",
            "`s.c` has no key `vlaue`",
            "`value` and `remove` exclude each other: a removed entry has no `value`",
            "`s.f` is large and has no label",
        ]
    );
    let flawed: Vec<_> = read.iter().map(|slider| (slider.name.value.as_str(), slider.flawed)).collect();
    assert_eq!(flawed, [("a", true), ("b", true), ("c", true), ("d", false), ("e", true), ("f", true)]);
    assert_eq!((read[0].value, read[0].label.as_ref().unwrap().value.as_str()), (None, "l"));
    assert!(read[4].remove && read[4].removed());
}

#[test]
fn layers_merge_key_by_key() {
    let (mut below, _) = sliders("[s.a]\nvalue = 1\nlabel = 'below'\n[s.b]\nvalue = 2\n[s.c]\n");
    let (above, _) = sliders(
        r"[s.d]
value = 4
[s.a]
value = 3
x = 0
[s.b]
remove = true
[s.bb]
remove = true
",
    );
    let mut found = Vec::new();
    layer::merge(&mut below, above, &mut found);
    let merged: Vec<_> = below.iter().map(|slider| (slider.name.value.as_str(), slider.value, slider.flawed)).collect();
    assert_eq!(merged, [("a", Some(3.0), true), ("c", None, false), ("d", Some(4.0), false)]);
    assert_eq!(below[0].label.as_ref().unwrap().value, "below");
    assert_eq!((found.len(), found[0].code), (1, codes::graph::UNKNOWN_PARAM));
    assert_eq!(found[0].message, "the base has no slider `bb`");
    assert_eq!(Slider::WHAT, "slider");
    let (mut below, _) = sliders("[s.a]\nlabel = 'text'\nvalue = 1\n");
    layer::merge(&mut below, sliders("[s.a]\nicon = 'sun'\n").0, &mut found);
    assert_eq!((&below[0].label, below[0].icon.as_deref(), below[0].value), (&None, Some("sun"), Some(1.0)));
    let form = Slider::form();
    assert!(form.keys.iter().all(|key| !key.needed), "a layer says what differs");
    assert_eq!(form.keys.iter().map(|key| key.name).collect::<Vec<_>>(), ["remove", "value", "label", "icon"]);
}

/// A plug, which is exchanged and not mended.
#[derive(Debug, Keys)]
#[keys(layer("plug", unknown = codes::graph::NOTHING_TO_OVERLAY, whole))]
struct Plug {
    #[keys(entry)]
    name: Spanned<String>,
    #[keys(remove)]
    remove: bool,
    /// Its pins.
    pins: Option<u32>,
    /// Its colour.
    color: Option<String>,
}

#[test]
fn a_whole_layer_replaces_its_equal() {
    let read = |text: &str| {
        let mut plugs = Vec::new();
        let _ = read_document("f.toml", text, &mut SourceMap::default(), |root| {
            plugs = ByName::read(&root.get("s")?, &(), &()).map(|plugs: ByName<Plug>| plugs.0)?;
            Some(())
        });
        plugs
    };
    let mut below = read("[s.a]\npins = 2\ncolor = 'red'\n[s.b]\n");
    let above = read("[s.a]\npins = 'x'\ncolor = 'blue'\n[s.b]\nremove = true\n");
    let mut found = Vec::new();
    layer::merge(&mut below, above, &mut found);
    assert_eq!((below.len(), &below[0].name.value[..], found.len()), (1, "a", 0));
    assert_eq!((below[0].pins, below[0].color.as_deref()), (None, Some("blue")), "pins of the base are gone");
}

/// A board, which says its name itself, with sliders on it.
#[derive(Clone, Debug, Keys)]
#[keys(layer("board", unknown = codes::graph::UNKNOWN_PASS), added = stays)]
struct Board {
    /// Its name.
    #[keys(name, rename = "title")]
    name: Spanned<String>,
    /// Takes it away.
    #[keys(remove)]
    remove: bool,
    #[keys(flawed)]
    flawed: bool,
    /// How wide it is.
    width: Option<f64>,
    /// What is on it.
    #[keys(read = by_name, shape = Shape::by_name(Shape::Table(Slider::form())))]
    sliders: Vec<Slider>,
    /// The large one.
    #[keys(cover, read = large, shape = Shape::Table(Slider::form()))]
    large: Option<Slider>,
}

fn by_name(node: &Node<'_, '_>) -> Option<Vec<Slider>> {
    ByName::read(node, &(), &()).map(|sliders: ByName<Slider>| sliders.0)
}

fn large(node: &Node<'_, '_>) -> Option<Slider> {
    Named::read_named(Spanned::new("large".to_owned(), node.key_span.clone()), &node.table()?, &())
}

fn stays(board: &Board, found: &mut Vec<Diagnostic>) {
    let removed = board.sliders.iter().filter(|slider| slider.remove);
    found.extend(removed.map(|slider| layer::unknown(Slider::WHAT, Slider::UNKNOWN, &slider.name, [].into_iter())));
}

#[test]
fn layers_have_layers_in_them() {
    let read = |text: &str| {
        let mut boards = Vec::new();
        let found = read_document("f.toml", text, &mut SourceMap::default(), |root| {
            boards = root.get("b")?.array()?.iter().filter_map(|node| Board::read(node, &(), &())).collect();
            Some(())
        });
        let found = found.map_or_else(|found| found, |((), found)| found);
        (boards, found.into_iter().map(|found| found.message).collect::<Vec<_>>())
    };
    let (mut below, found) = read(
        r"[[b]]
title = 'a'
width = 1
large.label = 'l'
[b.sliders.x]
value = 1
[[b]]
title = 'b'
",
    );
    assert_eq!(found, [""; 0]);
    let (above, found) = read(
        r"[[b]]
title = 'a'
large.value = 2
[b.sliders.x]
label = 'x'
[b.sliders.y]
[[b]]
title = 'b'
remove = true
[[b]]
title = 'c'
sliders.z.remove = true
",
    );
    assert_eq!(found, [""; 0]);
    let mut found = Vec::new();
    layer::merge(&mut below, above, &mut found);
    let names: Vec<_> = below.iter().map(|board| board.name.value.as_str()).collect();
    assert_eq!((names, below[0].width), (vec!["a", "c"], Some(1.0)));
    let x = &below[0].sliders[0];
    assert_eq!(
        (x.value, x.label.as_ref().map(|label| &label.value[..]), below[0].sliders.len()),
        (Some(1.0), Some("x"), 2)
    );
    let large = below[0].large.as_ref().expect("it is there in both");
    assert_eq!((large.value, large.label.as_ref().map(|label| &label.value[..])), (Some(2.0), Some("l")));
    let found: Vec<_> = found.iter().map(|found| found.message.as_str()).collect();
    assert_eq!(found, ["the base has no slider `z`"], "a board that is new has nothing to remove");
    assert!(read("[[b]]\n").0[0].flawed, "it has no name");
    let (flawed, found) = read("[[b]]\nwidth = 'w'\n[[b]]\ntitle = 'd'\nremove = true\nwidth = 1\n");
    assert_eq!(
        found,
        [
            "`b[0]` needs the key `title`",
            "`b[0].width` needs a number, not a string",
            "`width` and `remove` exclude each other: a removed entry has no `width`",
        ]
    );
    assert!(flawed[0].name.value.is_empty() && flawed.iter().all(|board| board.flawed));
    let form = Board::form();
    assert!(form.keys[0].needed && form.keys[0].name == "title" && !form.keys[1].needed);
}

/// A whole file.
#[derive(Debug, Keys)]
#[keys(layer)]
struct Desk {
    #[keys(skip)]
    opened: usize,
    /// Who sits at it.
    owner: Option<String>,
    /// How wide it is.
    #[keys(range = 0.0..=9.0)]
    width: Option<f64>,
    /// What is on it.
    #[keys(read = by_name, shape = Shape::by_name(Shape::Table(Slider::form())))]
    sliders: Vec<Slider>,
}

#[test]
fn a_whole_file_is_laid_over_another() {
    let mut below: Desk = read("owner = 'a'\nwidth = 1\n[sliders.x]\nvalue = 1\n").unwrap();
    let above: Desk = read("owner = 'b'\n[sliders.x]\nlabel = 'x'\n[sliders.y]\n").unwrap();
    below.opened = 3;
    let mut found = Vec::new();
    below.cover(above, &mut found);
    assert_eq!((below.owner.as_deref(), below.width, below.sliders.len()), (Some("b"), Some(1.0), 2));
    assert_eq!((below.sliders[0].value, below.opened, found.len()), (Some(1.0), 3, 0));
    assert_eq!(
        messages::<Desk>("owner = 1\nwidth = 10\nsliders = 2\nowwner = 3"),
        [
            "`owner` needs a string, not an integer",
            "`width` is 10; it must be in 0…9",
            "`sliders` needs a table, not an integer",
            "the file has no key `owwner`",
        ]
    );
    assert!(Desk::form().keys.iter().all(|key| !key.needed), "the other file may have it");
}

/// Seconds, as long as a film lasts.
struct Film {
    end: f64,
}

/// A cut.
#[derive(Debug, Keys)]
#[keys(context = Film, into = Cut)]
struct CutInFile {
    /// Seconds.
    #[keys(read = inside)]
    at: f64,
    #[keys(span)]
    span: Span,
}

#[derive(Debug, PartialEq)]
struct Cut(f64, std::ops::Range<usize>);

impl From<CutInFile> for Cut {
    fn from(cut: CutInFile) -> Self {
        Self(cut.at, cut.span.range)
    }
}

fn inside(node: &Node<'_, '_>, film: &Film) -> Option<f64> {
    node.number(0.0..=film.end)
}

/// A film.
#[derive(Debug, Keys)]
#[keys(context = Film)]
struct Cuts {
    /// In order of time.
    cuts: Vec<Cut>,
}

#[test]
fn what_reading_depends_on_is_handed_down() {
    let read = |text: &str| {
        read_document("f.toml", text, &mut SourceMap::default(), |root| Cuts::read_whole(root, &Film { end: 2.0 }))
    };
    assert_eq!(read("[[cuts]]\nat = 1\n").unwrap().0.cuts, [Cut(1.0, 0..8)]);
    assert_eq!(read("[[cuts]]\nat = 3\n").unwrap_err()[0].message, "`cuts[0].at` is 3; it must be in 0…2");
    assert!(matches!(Cut::shape(&()), Shape::Table(form) if form.keys[0].needed));
}
