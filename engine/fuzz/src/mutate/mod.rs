//! New inputs from old ones.

mod binary;
mod png;
mod save;
mod spirv;
mod store;
mod text;

use raxel_world::random::SplitMix64;

/// How inputs are changed.
#[derive(Clone, Copy, Debug)]
pub enum Mutation {
    /// Word by word, as text of one of our languages. The function gives the JSON schema of the language: its words are its keys and its
    /// named values.
    Toml(fn() -> serde_json::Value),
    /// Word by word, as text of another language, with these words of it.
    Words(&'static [&'static str]),
    /// Byte by byte.
    Binary,
    /// Chunk by chunk, as a PNG, with the checksums that belong to them.
    Png,
    /// Instruction by instruction, as a SPIR-V module.
    Spirv,
    /// Record by record, as the files of a save, with the checksums that belong to them.
    Save,
    /// As the document and a shard of a Zarr store, with the checksums that belong to them.
    Store,
}

impl Mutation {
    /// A changed input, with parts of another.
    pub(crate) fn apply(self, input: &[u8], other: &[u8], random: &mut SplitMix64) -> Vec<u8> {
        match self {
            Mutation::Toml(schema) => {
                let words = text::words_of(schema);
                text::mutated(&text::lossy(input), &text::lossy(other), &words, random).into_bytes()
            }
            Mutation::Words(words) => {
                text::pasted(&text::lossy(input), &text::lossy(other), words, random).into_bytes()
            }
            Mutation::Binary => binary::mutated(input, other, random),
            Mutation::Png => png::mutated(input, other, random),
            Mutation::Save => save::mutated(input, other, random),
            Mutation::Store => store::mutated(input, other, random),
            Mutation::Spirv => spirv::mutated(input, other, random),
        }
    }
}

/// One of some things.
fn pick<'a, T>(random: &mut SplitMix64, of: &'a [T]) -> Option<&'a T> {
    if of.is_empty() { None } else { of.get(random.index(of.len())) }
}
