//! The tables *Every key* of the guides, made from a JSON schema: titles as TOML has them, types and ranges in words.

use std::fmt::Write;

use serde_json::{Map, Value};

/// A JSON schema as Markdown tables.
pub(crate) struct Reference<'s> {
    /// The schema of a file.
    pub schema: &'s Value,
}

/// A definition with more forms than this has them in a table of its own.
const FEW: usize = 8;

impl Reference<'_> {
    /// All tables of the file.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        self.tables("The file", self.schema, &mut text);
        for (name, definition) in self.schema["definitions"].as_object().into_iter().flatten() {
            self.values(name, definition, &mut text);
        }
        let mut anchors: Vec<&str> = text.split("<a id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        anchors.sort_unstable();
        assert!(anchors.windows(2).all(|two| two[0] != two[1]), "two keys have one anchor: {anchors:?}");
        text
    }

    /// The table of an object, and then those of the objects in it.
    fn tables(&self, name: &str, object: &Value, text: &mut String) {
        let Some(properties) = object["properties"].as_object() else { return };
        let _ = write!(text, "\n### {name}\n\n| key | value | meaning |\n|---|---|---|\n");
        for (key, value) in properties {
            let needed = object["required"].as_array().is_some_and(|all| all.iter().any(|one| one == key));
            let about = self.about(value).replace('|', "\\|").replace('\n', " ");
            let shape = self.shape(value, 0).replace('|', "\\|");
            let said = about.to_lowercase().contains("needed");
            let needed = if needed && !said { " Needed." } else { "" };
            let _ = writeln!(text, "| <a id=\"{}\"></a>`{key}` | {shape} | {about}{needed} |", anchor(name, key));
        }
        for (key, value) in properties {
            for (place, form, inner) in self.inner(value) {
                let title = match (name == "The file", place) {
                    (true, Place::Itself) => format!("`[{key}]`"),
                    (true, Place::Named) => format!("`[{key}.NAME]`"),
                    (true, Place::Each) => format!("`[[{key}]]`"),
                    (false, Place::Named) => format!("`{key}.NAME`"),
                    (false, Place::Itself | Place::Each) => format!("`{key}`"),
                };
                let within = if name == "The file" { String::new() } else { format!(" in {name}") };
                self.tables(&format!("{title}{form}{within}"), inner, text);
            }
        }
    }

    /// The words that a definition lists.
    fn values(&self, name: &str, definition: &Value, text: &mut String) {
        let forms = definition["anyOf"].as_array().map_or(&[][..], Vec::as_slice);
        if forms.len() <= FEW {
            return;
        }
        let _ = write!(text, "\n### Values of `{name}`\n\n| value | meaning |\n|---|---|\n");
        for form in forms {
            let word = form["const"].as_str().map_or_else(|| self.shape(form, 0), |word| format!("`{word}`"));
            let _ = writeln!(text, "| {word} | {} |", self.about(form));
        }
    }

    /// The target of a reference.
    pub(crate) fn resolved<'v>(&'v self, value: &'v Value) -> &'v Value {
        match self.definition(value) {
            Some((_, definition)) => self.resolved(definition),
            None => value,
        }
    }

    /// The definition that a value refers to, and its name.
    fn definition<'v>(&'v self, value: &'v Value) -> Option<(&'v str, &'v Value)> {
        let path = value["$ref"].as_str()?.trim_start_matches('#');
        Some((path.rsplit('/').next()?, self.schema.pointer(path)?))
    }

    /// The description of a value.
    pub(crate) fn about<'v>(&'v self, value: &'v Value) -> &'v str {
        value["description"].as_str().or_else(|| self.resolved(value)["description"].as_str()).unwrap_or_default()
    }

    /// Objects with keys of their own in a value, one level down: where they are, and which of several forms each is.
    fn inner<'v>(&'v self, value: &'v Value) -> Vec<(Place, String, &'v Value)> {
        let value = self.resolved(value);
        let mut found = Vec::new();
        for (place, object) in
            [(Place::Itself, value), (Place::Named, &value["additionalProperties"]), (Place::Each, &value["items"])]
        {
            let objects = self.objects(object);
            let several = objects.len() > 1;
            for object in objects {
                found.push((place, if several { self.form(object) } else { String::new() }, object));
            }
        }
        found
    }

    /// The forms of a value that are objects with keys.
    fn objects<'v>(&'v self, value: &'v Value) -> Vec<&'v Value> {
        let value = self.resolved(value);
        let forms = value["anyOf"].as_array().into_iter().chain(value["oneOf"].as_array()).flatten();
        let all = std::iter::once(value).chain(forms.map(|form| self.resolved(form)));
        all.filter(|object| object["properties"].as_object().is_some_and(|keys| !keys.is_empty())).collect()
    }

    /// The mark of a form: a key with one value, or one that only this form needs.
    fn form(&self, object: &Value) -> String {
        let keys = object["properties"].as_object().into_iter().flatten();
        let telling = keys.filter_map(|(key, value)| match self.resolved(value)["const"].as_str() {
            Some(word) => Some(format!(" with `{key} = \"{word}\"`")),
            None => self.about(value).contains("Needed in this form").then(|| format!(" with `{key}`")),
        });
        telling.into_iter().next().unwrap_or_default()
    }

    /// A value's type in words.
    fn shape(&self, value: &Value, depth: u32) -> String {
        if let Some((name, definition)) = self.definition(value)
            && definition["anyOf"].as_array().is_some_and(|forms| forms.len() > FEW)
        {
            return format!("[a value](#values-of-{name})");
        }
        let value = self.resolved(value);
        let empty = Map::new();
        let object = value.as_object().unwrap_or(&empty);
        if let Some(words) = object.get("enum").and_then(Value::as_array) {
            return words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(" ");
        }
        if let Some(word) = object.get("const") {
            return format!("`{word}`");
        }
        for either in ["anyOf", "oneOf"] {
            if let Some(forms) = object.get(either).and_then(Value::as_array) {
                let mut shapes: Vec<String> = forms.iter().map(|form| self.shape(form, depth + 1)).collect();
                shapes.dedup();
                return shapes.join(" or ");
            }
        }
        match object.get("type") {
            Some(Value::String(name)) if name == "array" => match object.get("items") {
                Some(items) if !self.objects(items).is_empty() => "array of tables".to_owned(),
                // A value that may be an array of such values.
                Some(items)
                    if self
                        .definition(items)
                        .is_some_and(|(name, all)| all.to_string().contains(&format!("/{name}\""))) =>
                {
                    "array".to_owned()
                }
                Some(items) if depth < 3 => {
                    let counts = ["minItems", "maxItems"].map(|key| object.get(key).and_then(Value::as_u64));
                    let count = match counts {
                        [Some(least), Some(most)] if least == most => format!("{least} × "),
                        [Some(least), Some(most)] if most <= 4 => format!("{least} to {most} × "),
                        _ => "array of ".to_owned(),
                    };
                    format!("{count}{}", self.shape(items, depth + 1))
                }
                _ => "array".to_owned(),
            },
            Some(Value::String(name)) if name == "object" => {
                match object.get("properties").and_then(Value::as_object) {
                    Some(keys) if depth > 0 => {
                        format!("{{ {} }}", keys.keys().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", "))
                    }
                    None if !self.objects(&value["additionalProperties"]).is_empty() => "tables by name".to_owned(),
                    _ => "table".to_owned(),
                }
            }
            Some(Value::String(name)) if name == "string" && object.contains_key("pattern") => {
                written(object["pattern"].as_str().unwrap_or_default())
            }
            Some(Value::String(name)) if name == "string" => "text".to_owned(),
            Some(Value::String(name)) => format!("{name}{}", range(value)),
            Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(" or "),
            _ => "any value".to_owned(),
        }
    }
}

/// The anchor of a key: the words of its table's title, and the key.
fn anchor(title: &str, key: &str) -> String {
    let title = if title == "The file" { "" } else { title };
    let words = title.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(|word| !word.is_empty());
    std::iter::once("key").chain(words).chain([key]).map(str::to_lowercase).collect::<Vec<_>>().join("-")
}

/// The place of an object in the value of a key.
#[derive(Clone, Copy)]
enum Place {
    /// It is the value.
    Itself,
    /// Under a name that the author gives.
    Named,
    /// In an array.
    Each,
}

/// The limits of a number. Those of its type alone are left out.
fn range(value: &Value) -> String {
    let limit = |key: &str| value[key].as_f64().filter(|limit| limit.abs() < 4e9 || *limit < 1e19 && limit.abs() > 5e9);
    let shown = |number: f64| {
        let exponent = number.abs().log10();
        if number.abs() >= 1e7 && number.abs().log2().fract() == 0.0 {
            format!("{}2^{}", if number < 0.0 { "−" } else { "" }, number.abs().log2())
        } else if number != 0.0 && !(-4.0..7.0).contains(&exponent) {
            format!("{number:e}")
        } else {
            number.to_string().replace('-', "−")
        }
    };
    match (limit("minimum").map(shown), limit("maximum").map(shown)) {
        (Some(least), Some(most)) => format!(" ({least} to {most})"),
        (Some(least), None) => format!(" (at least {least})"),
        (None, Some(most)) => format!(" (at most {most})"),
        (None, None) => String::new(),
    }
}

/// A pattern as an author would write what fits it.
fn written(pattern: &str) -> String {
    let mut text = pattern.trim_matches(['^', '$']).to_owned();
    for (part, words) in [
        ("[A-Za-z0-9_-]+", "NAME"),
        ("[0-9]+ *[KMGT]iB", "512 MiB"),
        ("[0-9a-fA-F]{6}", "rrggbb"),
        ("[0-9]+", "N"),
        (".+", "NAME"),
        ("zarr:.", "zarr:…"),
        ("\\", ""),
    ] {
        text = text.replace(part, words);
    }
    if let Some(rest) = text.strip_prefix("!?") {
        return format!("`{rest}` `!{rest}`");
    }
    let Some((head, (words, tail))) = text.split_once('(').and_then(|(head, rest)| Some((head, rest.split_once(')')?)))
    else {
        return format!("`{text}`");
    };
    let words: Vec<&str> = words.split('|').collect();
    let words = if words.len() > 4 { vec!["TYPE"] } else { words };
    words.iter().map(|word| format!("`{head}{word}{tail}`")).collect::<Vec<_>>().join(" ")
}
