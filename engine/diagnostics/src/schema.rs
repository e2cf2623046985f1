//! Pieces that the JSON schemas of project files share.

use serde_json::Value;

/// The schema with each `default` added to the description of its key. Editors show descriptions while the cursor rests on a key; defaults they only
/// put in.
pub fn with_defaults(mut schema: Value) -> Value {
    tell(&mut schema);
    schema
}

fn tell(node: &mut Value) {
    match node {
        Value::Object(entries) => {
            if let (Some(default), Some(about)) = (entries.get("default"), entries.get("description"))
                && let (false, Some(about)) = (default.is_object(), about.as_str())
            {
                let written =
                    if default.is_array() { default.to_string().replace(',', ", ") } else { default.to_string() };
                let about = format!("{about} Default: `{written}`.");
                entries.insert("description".to_owned(), about.into());
            }
            entries.values_mut().for_each(tell);
        }
        Value::Array(elements) => elements.iter_mut().for_each(tell),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn descriptions_tell_defaults() {
        let told = with_defaults(json!({
            "description": "A file.",
            "properties": {
                "fps": { "description": "Frames a second.", "type": "number", "default": 60 },
                "mode": { "description": "What it does.", "enum": ["add"], "default": "add" },
                "name": { "description": "Its name.", "type": "string" },
                // A key that is called so.
                "default": { "description": "A value.", "type": "array", "default": [1, 2] },
                "description": { "description": "A text." },
            },
        }));
        let about = |key: &str| told["properties"][key]["description"].as_str().unwrap().to_owned();
        assert_eq!(about("fps"), "Frames a second. Default: `60`.");
        assert_eq!(about("mode"), "What it does. Default: `\"add\"`.");
        assert_eq!(about("name"), "Its name.");
        assert_eq!(about("default"), "A value. Default: `[1, 2]`.");
        assert_eq!(told["description"], "A file.");
    }
}
