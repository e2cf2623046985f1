//! World files as they are streamed: from the text to tiles near the origin and far away, at several levels of detail.

use std::sync::LazyLock;

use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_world::{ChunkPos, Content, MAX_LEVEL};
use raxel_worldfile as file;

use crate::bounds::Bounds;
use crate::{Mutation, Target, check, projects};

pub(crate) const TARGET: Target = Target {
    name: "world",
    run,
    bounds: Bounds { bytes: 256 << 20, ..Bounds::PARSER },
    mutation: Mutation::Toml(file::schema),
    seeds: &["worlds/meadow.toml", "worlds/frontier.toml", "worlds/terrain.toml", "worlds/quarry.toml"],
    longest: 16 << 10,
    quick: 400,
};

/// The file of the input.
pub(super) const PATH: &str = "worlds/main.toml";

/// A model that inputs may place.
pub(super) const MODELS: [(&str, &[u8]); 2] = [
    ("worlds/models/pine.vox", include_bytes!("../../models/pine.vox")),
    ("worlds/models/mushroom.vox", include_bytes!("../../models/mushroom.vox")),
];

/// A project with the models.
pub(super) fn project() -> MemoryFiles {
    static FILES: LazyLock<Vec<(String, Vec<u8>)>> =
        LazyLock::new(|| MODELS.iter().map(|(path, bytes)| ((*path).to_owned(), bytes.to_vec())).collect());
    MemoryFiles::new(FILES.iter().map(|(path, bytes)| (path.clone(), bytes)))
}

#[expect(clippy::cast_possible_truncation, reason = "heights are clamped")]
fn run(input: &[u8]) {
    let files = project();
    projects::add(&files, PATH, input);
    let main = String::from_utf8_lossy(input);
    let main = main.split(projects::MARK).next().unwrap_or_default();
    // A world that is not streamed would be built whole, and may be as large as memory: that is another target.
    if main.parse::<toml::Table>().is_ok_and(|table| !table.contains_key("stream")) {
        files.insert(PATH, format!("{main}\n[stream]\n"));
    }
    let mut texts = SourceMap::default();
    let Some(loaded) = check::outcome(file::load(PATH, &files, &mut texts), &texts) else { return };
    let stream = loaded.stream.expect("a world with `[stream]` is streamed");
    let tiles = &*stream.generator;
    let range = tiles.height_range();
    assert!(range.is_none_or(|[low, high]| low <= high), "{range:?}");
    let height = range.map_or(0, |[low, high]| (low.midpoint(high) >> 6).clamp(-(1 << 25), (1 << 25) - 1)) as i32;
    for (level, pos) in [
        (0, ChunkPos::new(0, 0, 0)),
        (0, ChunkPos::new(-1, height, 0)),
        (0, ChunkPos::new(-(1 << 25), -(1 << 25), (1 << 25) - 1)),
        (1, ChunkPos::new(0, height >> 2, 0)),
        (3, ChunkPos::new(0, 0, -1)),
        (MAX_LEVEL, ChunkPos::new(0, 0, 0)),
        (MAX_LEVEL, ChunkPos::new(-1, -1, -1)),
    ] {
        let made = || tiles.try_chunk(level, pos).expect("what is built is there");
        let tile = made();
        assert_eq!(tile, made(), "the same tile at level {level}, {pos:?}");
        let count = tiles.materials().len();
        let inside = match &tile {
            Content::Empty => true,
            Content::Full(material) => usize::from(*material) < count,
            Content::Chunk(_) => {
                tile.to_chunk().is_some_and(|chunk| chunk.iter().all(|(_, material)| usize::from(material) < count))
            }
        };
        assert!(inside, "a material that is none of {count} at level {level}, {pos:?}");
    }
}
