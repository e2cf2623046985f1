//! The JSON schema of demo files, for completion in editors.

use raxel_diagnostics::schema::with_defaults;
use raxel_worldfile::CAMERA_FOV;
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
    with_defaults(json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "raxel demo",
        "description": "A world, a graph and a timeline.",
        "type": "object",
        "additionalProperties": false,
        "required": ["world", "graph", "duration"],
        "properties": {
            "name": { "description": "Its name; the file's when left out.", "type": "string" },
            "about": { "description": "One line about it; may be left out.", "type": "string" },
            "world": { "description": "The world, relative to worlds/.", "type": "string" },
            "graph": { "description": "The graph, relative to graphs/.", "type": "string" },
            "duration": { "description": "Seconds that it lasts.", "type": "number", "exclusiveMinimum": 0 },
            "fps": { "description": "Frames a second of a headless run.", "type": "number", "exclusiveMinimum": 0, "default": 30 },
            "size": { "description": "Pixels of a headless run, width and height.", "type": "array", "items": { "type": "integer", "minimum": 1, "maximum": 16384 }, "minItems": 2, "maxItems": 2, "default": [1280, 720] },
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
                        "position": vector("Where it is, in voxels."),
                        "look_at": vector("The point it looks at, in voxels; instead of yaw and pitch."),
                        "yaw": { "description": "Degrees to the left of -Z; with pitch, instead of `look_at`.", "type": "number" },
                        "pitch": { "description": "Degrees upwards; with yaw, instead of `look_at`.", "type": "number", "minimum": -90, "maximum": 90 },
                        "fov": { "description": "Vertical field of view in degrees, 1 to 179.", "type": "number", "minimum": CAMERA_FOV.start(), "maximum": CAMERA_FOV.end(), "default": 60 },
                        "interpolation": interpolation("smooth"),
                        "cut": { "description": "The camera jumps here: curves end, and what passes keep from frame to frame starts over.", "type": "boolean", "default": false },
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
                "description": "Edits of the world in order of time; those of one time are made in the order of the file. None when left out.",
                "type": "array",
                "items": { "oneOf": super::edits::schemas(&time) },
            },
            "graphs": {
                "description": "Changes of the graph in order of time. What passes keep from frame to frame starts over, and the new graph's own picture is shown.",
                "type": "array",
                "items": {
                    "type": "object",
                    "additionalProperties": false,
                    "required": ["time", "graph"],
                    "properties": {
                        "time": time,
                        "graph": { "description": "The graph from then on, relative to graphs/.", "type": "string" },
                    },
                },
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
                        "target": { "description": "NAME, NAME@AGE, and after it any of ,mip=N ,layer=N ,after=PASS (of a loop the last round; PASS[2] is that of index 2).", "type": "string" },
                    },
                },
            },
            "caption": {
                "description": "Lines of text over the picture, in order of time.",
                "type": "array",
                "items": {
                    "type": "object",
                    "additionalProperties": false,
                    "required": ["time", "until", "text"],
                    "properties": {
                        "time": time,
                        "until": { "description": "Seconds from the start at which it is gone.", "type": "number", "minimum": 0 },
                        "text": { "description": "One line.", "type": "string" },
                        "place": { "description": "Where in the picture.", "enum": ["bottom", "top"], "default": "bottom" },
                    },
                },
            },
            "check": {
                "description": "What must hold when `raxel test` runs the demo: about a picture, or about a pass.",
                "type": "array",
                "items": {
                    "type": "object",
                    "additionalProperties": false,
                    "properties": {
                        "frame": { "description": "The frame that is looked at, from 0: needed for a picture, or `time`.", "type": "integer", "minimum": 0 },
                        "time": { "description": "The same in seconds, instead of `frame`.", "type": "number", "minimum": 0 },
                        "target": { "description": "What is looked at, as in `show`; what the demo shows when left out.", "type": "string" },
                        "reference": { "description": "The picture it must be like: a PNG relative to worlds/. `raxel test --write` writes it. Needed for a picture.", "type": "string" },
                        "flip": { "description": "Largest mean FLIP error, 0 to 1: needed for a picture.", "type": "number", "minimum": 0, "maximum": 1 },
                        "pass": { "description": "The pass that must be fast, instead of a picture.", "type": "string" },
                        "below_ms": { "description": "Most milliseconds of GPU time, median of all frames: needed for a pass.", "type": "number", "exclusiveMinimum": 0 },
                    },
                },
            },
        },
    }))
}
