//! The JSON schema (draft 7) of keys.

use raxel_diagnostics::schema::with_defaults;
use serde_json::{Map, Value, json};

use crate::{Form, Key, Shape, Word};

impl Form {
    /// The schema of a whole file. Descriptions contain the defaults, too.
    pub fn document(&self, title: &str) -> Value {
        let mut schema = self.definition();
        schema["$schema"] = json!("http://json-schema.org/draft-07/schema#");
        schema["title"] = json!(title);
        with_defaults(schema)
    }

    /// The schema of the table, with its description.
    pub fn definition(&self) -> Value {
        described(self.about, self.schema())
    }

    /// The schema of the table; of one with several forms, of each, with its description.
    pub fn schema(&self) -> Value {
        if self.forms.is_empty() {
            return table(self.keys.iter());
        }
        let form = |form: &Form| described(form.about, table(self.keys.iter().chain(&form.keys)));
        json!({ "oneOf": self.forms.iter().map(form).collect::<Vec<_>>() })
    }
}

fn described(about: &str, mut schema: Value) -> Value {
    schema["description"] = json!(about);
    schema
}

fn table<'k>(keys: impl Iterator<Item = &'k Key> + Clone) -> Value {
    let needed: Vec<&str> = keys.clone().filter(|key| key.needed).map(|key| key.name).collect();
    let conflicts = conflicts(&keys.clone().collect::<Vec<_>>());
    let properties: Map<String, Value> = keys.map(|key| (key.name.to_owned(), key.schema())).collect();
    let mut schema = json!({ "type": "object", "additionalProperties": false, "properties": properties });
    if !needed.is_empty() {
        schema["required"] = json!(needed);
    }
    match conflicts.as_slice() {
        [] => {}
        [pair] => schema["not"] = pair.clone(),
        pairs => schema["not"] = json!({ "anyOf": pairs }),
    }
    schema
}

/// The pairs of these keys that cannot stand together, each as the schema of a table that has both.
fn conflicts(keys: &[&Key]) -> Vec<Value> {
    let mut pairs = Vec::new();
    for (index, key) in keys.iter().enumerate() {
        let excluded = |other: &&&Key| key.conflicts.iter().any(|conflict| conflict.with == other.name);
        let others = keys[index + 1..].iter().filter(excluded);
        pairs.extend(others.map(|other| json!({ "required": [key.name, other.name] })));
    }
    pairs
}

impl Key {
    /// The schema of its value, with its description. A reference has the description of its definition, which does not know of conflicts.
    pub fn schema(&self) -> Value {
        let mut schema = self.shape.schema();
        if schema.get("$ref").is_none() || !self.conflicts.is_empty() {
            schema["description"] = json!(self.description());
        }
        if let Some(default) = &self.default {
            schema["default"] = default.clone();
        }
        schema
    }
}

impl Shape {
    /// The schema of a value.
    pub fn schema(&self) -> Value {
        match self {
            Shape::Text => json!({ "type": "string" }),
            Shape::Flag => json!({ "type": "boolean" }),
            Shape::Integer { least, most } => {
                ranged("integer", least.map(|least| json!(least)), most.map(|most| json!(most)))
            }
            Shape::Number { least, most } => ranged("number", least.map(number), most.map(number)),
            Shape::Words(words) => one_of(words),
            Shape::Word(word) => json!({ "const": word }),
            Shape::Array { of, least, most } => {
                let mut schema = json!({ "type": "array", "items": of.schema() });
                for (name, count) in [("minItems", least), ("maxItems", most)] {
                    if let Some(count) = count {
                        schema[name] = json!(count);
                    }
                }
                schema
            }
            Shape::Table(form) => form.schema(),
            Shape::ByName(of) => json!({ "type": "object", "additionalProperties": of.schema() }),
            Shape::Either(shapes) => json!({ "oneOf": shapes.iter().map(Shape::schema).collect::<Vec<_>>() }),
            Shape::Schema(schema) => schema.clone(),
        }
    }
}

/// One of these words. A schema of draft 7 has no place for their meanings: `x-taplo` is where Taplo shows them from.
fn one_of(words: &[Word]) -> Value {
    let names: Vec<&str> = words.iter().map(|word| &*word.name).collect();
    let mut schema = json!({ "type": "string", "enum": names });
    if words.iter().any(|word| !word.about.is_empty()) {
        let meanings: Vec<&str> = words.iter().map(|word| word.about.as_str()).collect();
        schema["x-taplo"] = json!({ "docs": { "enumValues": meanings } });
    }
    schema
}

fn ranged(name: &str, least: Option<Value>, most: Option<Value>) -> Value {
    let mut schema = json!({ "type": name });
    if let Some(least) = least {
        schema["minimum"] = least;
    }
    if let Some(most) = most {
        schema["maximum"] = most;
    }
    schema
}

/// A number without a point if it is whole, as people write it.
#[expect(clippy::cast_possible_truncation, reason = "the number is whole, and small")]
pub(crate) fn number(value: f64) -> Value {
    if value.fract() == 0.0 && value.abs() < 1e15 { json!(value as i64) } else { json!(value) }
}
