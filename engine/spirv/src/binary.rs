//! The bytes of a `.spv` file and the words of a module.

use crate::error::{ModuleError, broken};

/// Largest module that is read, in words: 16 MiB.
pub(crate) const MAX_WORDS: usize = 4 << 20;

/// Words before the first instruction: magic number, version, generator, id bound, schema.
pub(crate) const HEADER_WORDS: usize = 5;

/// Turns the bytes of a `.spv` file into words.
///
/// # Errors
/// When the file is empty, larger than 16 MiB, or no whole number of words.
pub fn words_of(bytes: &[u8]) -> Result<Vec<u32>, ModuleError> {
    if bytes.is_empty() {
        return broken("the file is empty");
    }
    if bytes.len() > MAX_WORDS * 4 {
        return Err(ModuleError::Unsupported(format!(
            "the file has {} bytes, more than the {} of the largest module raxel reads",
            bytes.len(),
            MAX_WORDS * 4
        )));
    }
    if !bytes.len().is_multiple_of(4) {
        return broken(format!("the file has {} bytes, which is not a multiple of 4", bytes.len()));
    }
    Ok(bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect())
}

/// The bytes of a `.spv` file.
pub fn bytes_of(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
