//! Conflicts, forms and shapes, and values that reading depends on.

use raxel_diagnostics::table::read_document;
use raxel_diagnostics::{SourceMap, Span};
use raxel_language::{Conflict, Describe, Keys, Node, ReadKeys, Shape, Table};
use serde_json::json;

use crate::{messages, read};

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
