//! World files as they are built whole, and the same files streamed: both have the same voxels. Numbers are brought near zero, as a whole
//! world may be as large as memory.

use raxel_diagnostics::SourceMap;
use raxel_world::ChunkPos;
use raxel_worldfile as file;
use toml::{Table, Value};

use super::world::{PATH, project};
use crate::bounds::Bounds;
use crate::{Mutation, Target, check, projects};

pub(crate) const TARGET: Target = Target {
    name: "world_whole",
    run,
    bounds: Bounds { bytes: 512 << 20, ..Bounds::PARSER },
    mutation: Mutation::Toml(file::schema),
    seeds: &["worlds/meadow.toml", "worlds/hall.toml", "worlds/menger.toml", "worlds/pool.toml", "worlds/flock.toml"],
    longest: 16 << 10,
    quick: 150,
};

/// No number is larger.
const MOST: i64 = 70;

/// No sponge has more levels: it reaches over a chunk. Each level has 20 times as many voxels, this target looks at every one, and a file may build
/// dozens of sponges.
const MOST_LEVELS: i64 = 4;

fn run(input: &[u8]) {
    let Ok(text) = std::str::from_utf8(input) else { return };
    let (main, rest) = text.split_once(projects::MARK).unwrap_or((text, ""));
    let Ok(mut table) = main.parse::<Table>() else { return };
    table.remove("stream");
    for (key, value) in &mut table {
        // Heights of cameras and colours of materials build nothing.
        if ["build", "models", "instances"].contains(&key.as_str()) {
            near_zero(value);
        }
    }
    let files = project();
    if !rest.is_empty() {
        projects::add(&files, "worlds/other.toml", format!("{}{rest}", projects::MARK).as_bytes());
    }
    files.insert(PATH, table.to_string());
    let mut texts = SourceMap::default();
    let Some(whole) = check::outcome(file::load(PATH, &files, &mut texts), &texts) else { return };
    let world = &whole.world;
    assert_eq!(world.voxels().count() as u64, world.solids());
    assert!(world.voxels().all(|(_, material)| usize::from(material) < world.materials().len()));

    // Scatters by count or density look at everything that was built before, and cannot be streamed.
    files.insert(PATH, format!("{table}\n[stream]\n"));
    let mut texts = SourceMap::default();
    let Some(streamed) = check::outcome(file::load(PATH, &files, &mut texts), &texts) else { return };
    let stream = streamed.stream.expect("a world with `[stream]` is streamed");
    let around = |(pos, _): (ChunkPos, _)| [pos, pos.beside(3), pos.beside(2)];
    let places = world.chunks().flat_map(around).take(24);
    for pos in places {
        let made = stream.generator.try_chunk(0, pos).expect("what is built is there").to_chunk();
        let there = world.chunk(pos);
        let same = match (there, &made) {
            (None, None) => true,
            (Some(there), Some(made)) => there.iter().eq(made.iter()),
            _ => false,
        };
        assert!(same, "the chunk at {pos:?} is another when the world is streamed");
    }
}

fn near_zero(value: &mut Value) {
    match value {
        Value::Integer(number) => *number = (*number).clamp(-MOST, MOST),
        Value::Float(number) if number.is_finite() => *number = number.clamp(-MOST as f64, MOST as f64),
        Value::Array(elements) => elements.iter_mut().for_each(near_zero),
        Value::Table(fields) => {
            if let Some(Value::Integer(levels)) = fields.get_mut("level") {
                *levels = (*levels).min(MOST_LEVELS);
            }
            fields.iter_mut().for_each(|(_, value)| near_zero(value));
        }
        _ => {}
    }
}
