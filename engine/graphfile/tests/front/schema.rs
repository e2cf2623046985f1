//! The schema for editors and the reader of the compiler know the same keys.

use std::collections::BTreeSet;

use raxel_diagnostics::Diagnostic;
use raxel_graphfile::schema;
use serde_json::Value;

use crate::files::{GRAPH, Project};

/// Where an unknown key is put, and the pointer to the same table in the schema (several, where a table may be one of several).
const TABLES: [(&str, &[&str]); 15] = [
    ("zzzzzzzz = 1", &[""]),
    ("[params.x]\nzzzzzzzz = 1", &["/definitions/param"]),
    ("[clocks.x]\nzzzzzzzz = 1", &["/definitions/clock"]),
    ("[targets.x]\nzzzzzzzz = 1", &["/definitions/target"]),
    ("[targets.x.size]\nzzzzzzzz = 1", &["/definitions/target/properties/size/anyOf/2"]),
    ("[targets.x.display]\nzzzzzzzz = 1", &["/definitions/target/properties/display/anyOf/1"]),
    ("[buffers.x]\nzzzzzzzz = 1", &["/definitions/buffer"]),
    ("[buffers.x.size]\nzzzzzzzz = 1", &["/definitions/buffer/properties/size/anyOf/1"]),
    ("[loops.x]\nzzzzzzzz = 1", &["/definitions/loop"]),
    ("[loops.x.count]\nzzzzzzzz = 1", &["/definitions/loop/properties/count/anyOf/2"]),
    ("[[passes]]\nname = \"p\"\nzzzzzzzz = 1", &["/definitions/pass"]),
    (
        "[[passes]]\nname = \"p\"\ndispatch = { zzzzzzzz = 1 }",
        &[
            "/definitions/pass/properties/dispatch/anyOf/1",
            "/definitions/pass/properties/dispatch/anyOf/2",
            "/definitions/pass/properties/dispatch/anyOf/3",
            "/definitions/pass/properties/dispatch/anyOf/4",
        ],
    ),
    ("[[passes]]\nname = \"p\"\nbind = { x = { zzzzzzzz = 1 } }", &["/definitions/bind/anyOf/1"]),
    ("[[passes]]\nname = \"p\"\npush = { x = { type = \"f32\", zzzzzzzz = 1 } }", &["/definitions/member/anyOf/2"]),
    (
        "[[passes]]\nname = \"p\"\nevery = { zzzzzzzz = 1 }",
        &[
            "/definitions/pass/properties/every/anyOf/1",
            "/definitions/pass/properties/every/anyOf/2",
            "/definitions/pass/properties/every/anyOf/3",
        ],
    ),
];

/// A table lists the keys that its reader asks for when it has an unknown one.
fn asked(text: &str) -> BTreeSet<String> {
    let mut project = Project::new();
    project.put("graphs/x.toml", text);
    let found: Vec<Diagnostic> = project.compile("graphs/x.toml").0.unwrap_err();
    let unknown =
        found.iter().find(|d| d.message.ends_with("has no key `zzzzzzzz`")).unwrap_or_else(|| panic!("{text}"));
    let list = unknown.help[0].strip_prefix("known keys: ").unwrap();
    list.split(", ").map(|key| key.trim_matches('`').to_owned()).filter(|key| key != "zzzzzzzz").collect()
}

#[test]
fn schema_and_reader_have_the_same_keys() {
    let schema = schema();
    for (text, pointers) in TABLES {
        let mut keys = BTreeSet::new();
        for pointer in pointers {
            let table = schema.pointer(pointer).unwrap_or_else(|| panic!("{pointer}"));
            assert_eq!(table["additionalProperties"], Value::Bool(false), "{pointer}");
            keys.extend(table["properties"].as_object().unwrap().keys().cloned());
        }
        assert_eq!(asked(text), keys, "{text}");
    }
}

#[test]
fn every_reference_leads_somewhere() {
    fn walk(schema: &Value, at: &Value) {
        match at {
            Value::Object(entries) => {
                if let Some(Value::String(reference)) = entries.get("$ref") {
                    assert!(schema.pointer(&reference[1..]).is_some(), "{reference}");
                }
                entries.values().for_each(|value| walk(schema, value));
            }
            Value::Array(elements) => elements.iter().for_each(|value| walk(schema, value)),
            _ => {}
        }
    }
    let schema = schema();
    walk(&schema, &schema);
}

/// A validator of as much of JSON Schema as the schema uses; `Err` names the place that fails.
fn validate(schema: &Value, rule: &Value, value: &toml::Value, at: &str) -> Result<(), String> {
    let fail = |why: &str| Err(format!("{at}: {why}: {value}"));
    if let Some(reference) = rule["$ref"].as_str() {
        return validate(schema, schema.pointer(&reference[1..]).unwrap(), value, at);
    }
    if let Some(any) = rule["anyOf"].as_array() {
        let outcomes: Vec<_> = any.iter().map(|rule| validate(schema, rule, value, at)).collect();
        if outcomes.iter().all(Result::is_err) {
            return Err(outcomes.into_iter().filter_map(Result::err).collect::<Vec<_>>().join("\n"));
        }
    }
    let is = match value {
        toml::Value::String(_) => "string",
        toml::Value::Integer(_) => "integer",
        toml::Value::Float(_) => "number",
        toml::Value::Boolean(_) => "boolean",
        toml::Value::Array(_) => "array",
        _ => "object",
    };
    let types: Vec<&str> = match &rule["type"] {
        Value::String(one) => vec![one],
        Value::Array(many) => many.iter().filter_map(Value::as_str).collect(),
        _ => vec![is],
    };
    let number = is == "integer" && types.contains(&"number");
    if !types.contains(&is) && !number {
        return fail(&format!("is no {types:?}"));
    }
    if let Some(words) = rule["enum"].as_array()
        && !words.iter().any(|word| word.as_str() == value.as_str())
    {
        return fail("is none of the words");
    }
    for key in rule["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        if value.get(key).is_none() {
            return fail(&format!("has no {key}"));
        }
    }
    if rule.get("const").is_some_and(|word| word.as_str() != value.as_str()) {
        return fail("is another word");
    }
    if let (Some(pattern), Some(word)) = (rule["pattern"].as_str(), value.as_str()) {
        // Of a pattern only the literal beginning is compared.
        let start = pattern.trim_start_matches(['^', '!', '?']).replace("\\.", ".");
        let start = start.split(['[', '(']).next().unwrap_or_default();
        if !word.trim_start_matches('!').starts_with(start) || (start.is_empty() && !word.contains('[')) {
            return fail("is not of the pattern");
        }
    }
    if let (Some(minimum), Some(number)) = (rule["minimum"].as_f64(), value.as_integer())
        && (number as f64) < minimum
    {
        return fail("is too small");
    }
    if let toml::Value::Array(elements) = value {
        let most = rule["maxItems"].as_u64().unwrap_or(u64::MAX);
        if elements.len() as u64 > most || (elements.len() as u64) < rule["minItems"].as_u64().unwrap_or(0) {
            return fail("has another length");
        }
        for (index, element) in elements.iter().enumerate().filter(|_| rule.get("items").is_some()) {
            validate(schema, &rule["items"], element, &format!("{at}[{index}]"))?;
        }
    }
    if let toml::Value::Table(entries) = value {
        for (key, value) in entries {
            let at = format!("{at}.{key}");
            match rule["properties"].get(key).unwrap_or(&rule["additionalProperties"]) {
                Value::Bool(false) => return Err(format!("{at}: unknown key")),
                Value::Null => {}
                rule => validate(schema, rule, value, &at)?,
            }
        }
    }
    Ok(())
}

#[test]
fn graphs_without_a_mistake_are_valid() {
    let schema = schema();
    let shipped = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs");
    let mut texts = vec![("base".to_owned(), GRAPH.to_owned())];
    let folders = [shipped.clone(), shipped.join("examples"), shipped.join("bench")];
    for entry in folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap()) {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            texts.push((path.display().to_string(), std::fs::read_to_string(&path).unwrap()));
        }
    }
    assert!(texts.len() > 3);
    for (name, text) in texts {
        let value = toml::Value::Table(text.parse().unwrap());
        validate(&schema, &schema, &value, &name).unwrap_or_else(|why| panic!("{why}"));
    }
}

#[test]
fn the_schema_refuses_what_the_compiler_refuses() {
    let schema = schema();
    for (old, new) in [
        (r#"format = "rg32ui""#, r#"format = "rg32u""#),
        ("size = 0.5", "size = [1, 2, 3, 4]"),
        ("history = 1", "history = -1"),
        (r#"from = "camera.cell""#, r#"from = "camera.cel""#),
        (r#"when = "world.has_emission""#, r#"when = "world.emission""#),
        ("dispatch = [4, 4]", "dispatch = [4, 0]"),
        ("layers = 4", "layer = 4"),
        ("name    = \"base\"\n", ""),
    ] {
        let text = GRAPH.replace(old, new);
        assert_ne!(text, GRAPH);
        let value = toml::Value::Table(text.parse().unwrap());
        assert!(validate(&schema, &schema, &value, "").is_err(), "{new}");
        let mut project = Project::new();
        project.put("graphs/base.toml", &text);
        assert!(project.compile("graphs/base.toml").0.is_err(), "{new}");
    }
}
