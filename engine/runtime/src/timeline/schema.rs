//! The JSON schema of demo files, for completion in editors.

use serde_json::{Value, json};

/// JSON schema of `worlds/*.demo.toml`.
pub fn schema() -> Value {
    let interpolation = |default: &str| {
        json!({
            "description": "How it gets from one key to the next.",
            "enum": ["step", "linear", "smooth"],
            "default": default,
        })
    };
    let vector = |description: &str| json!({ "description": description, "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3 });
    let time = json!({ "description": "Seconds from the start.", "type": "number", "minimum": 0 });
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "raxel demo",
        "description": "A world, a graph and a timeline.",
        "type": "object",
        "additionalProperties": false,
        "required": ["world", "graph", "duration"],
        "properties": {
            "name": { "description": "Its name; the file's when left out.", "type": "string" },
            "about": { "description": "One line about it.", "type": "string" },
            "world": { "description": "The world, relative to worlds/.", "type": "string" },
            "graph": { "description": "The graph, relative to graphs/.", "type": "string" },
            "duration": { "description": "Seconds.", "type": "number", "exclusiveMinimum": 0 },
            "fps": { "description": "Frames a second of a headless run.", "type": "number", "exclusiveMinimum": 0, "default": 30 },
            "loop": { "description": "Starts over at its end.", "type": "boolean", "default": false },
            "camera": {
                "description": "Camera keys in order of time.",
                "type": "array",
                "items": {
                    "type": "object",
                    "additionalProperties": false,
                    "required": ["time", "position"],
                    "properties": {
                        "time": time,
                        "position": vector("Voxels."),
                        "look_at": vector("The point it looks at, voxels."),
                        "yaw": { "description": "Degrees to the left of -Z.", "type": "number" },
                        "pitch": { "description": "Degrees upwards.", "type": "number", "minimum": -90, "maximum": 90 },
                        "fov": { "description": "Vertical field of view, degrees.", "type": "number", "minimum": 1, "maximum": 170, "default": 60 },
                        "interpolation": interpolation("smooth"),
                    },
                },
            },
            "tracks": {
                "description": "Params over time, by name.",
                "type": "object",
                "additionalProperties": {
                    "type": "object",
                    "additionalProperties": false,
                    "required": ["keys"],
                    "properties": {
                        "keys": {
                            "description": "[seconds, value] in order of time.",
                            "type": "array",
                            "minItems": 1,
                            "items": { "type": "array", "minItems": 2, "maxItems": 2 },
                        },
                        "interpolation": interpolation("linear"),
                    },
                },
            },
            "edits": {
                "description": "Edits of the world in order of time; those of one time are made in the order of the file.",
                "type": "array",
                "items": { "oneOf": super::edits::schemas(&time) },
            },
            "show": {
                "description": "Changes of the debug target in order of time.",
                "type": "array",
                "items": {
                    "type": "object",
                    "additionalProperties": false,
                    "required": ["time", "target"],
                    "properties": {
                        "time": time,
                        "target": { "description": "NAME, NAME@AGE, and after it any of ,mip=N ,layer=N ,after=PASS.", "type": "string" },
                    },
                },
            },
        },
    })
}
