//! New inputs from old ones.

mod binary;
mod spirv;
mod text;

use raxel_world::random::SplitMix64;

/// How inputs are changed.
#[derive(Clone, Copy, Debug)]
pub enum Mutation {
    /// Word by word, as text of one of our languages. The function gives the JSON schema of the language: its words are its keys and its
    /// named values.
    Toml(fn() -> serde_json::Value),
    /// Byte by byte.
    Binary,
    /// Instruction by instruction, as a SPIR-V module.
    Spirv,
}

impl Mutation {
    /// A changed input, with parts of another.
    pub(crate) fn apply(self, input: &[u8], other: &[u8], random: &mut SplitMix64) -> Vec<u8> {
        match self {
            Mutation::Toml(schema) => {
                let words = text::words_of(schema);
                let lossy = |bytes| String::from_utf8_lossy(bytes).into_owned();
                text::mutated(&lossy(input), &lossy(other), &words, random).into_bytes()
            }
            Mutation::Binary => binary::mutated(input, other, random),
            Mutation::Spirv => spirv::mutated(input, other, random),
        }
    }
}

/// One of some things.
fn pick<'a, T>(random: &mut SplitMix64, of: &'a [T]) -> Option<&'a T> {
    if of.is_empty() { None } else { of.get(random.below(of.len() as u64) as usize) }
}
