//! The file of an entry: eight bytes of magic, the BLAKE3 of name and payload, the payload.

/// The extension of the files.
pub(crate) const ENDING: &str = "kept";

/// The last byte is the version of the file format.
const MAGIC: [u8; 8] = *b"raxelc\0\x01";

const HEADER: usize = MAGIC.len() + blake3::OUT_LEN;

/// The hash covers the name, so a copied or renamed file does not pass for another entry.
fn hash(name: &str, payload: &[u8]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(name.len() as u64).to_le_bytes());
    hasher.update(name.as_bytes());
    hasher.update(payload);
    hasher.finalize()
}

pub(crate) fn encode(name: &str, payload: &[u8]) -> Vec<u8> {
    [&MAGIC[..], hash(name, payload).as_bytes(), payload].concat()
}

/// The payload, or the fault.
pub(crate) fn decode<'b>(name: &str, bytes: &'b [u8]) -> Result<&'b [u8], &'static str> {
    let Some((header, payload)) = bytes.split_at_checked(HEADER) else { return Err("it is cut off") };
    let (magic, expected) = header.split_at(MAGIC.len());
    if magic != MAGIC {
        return Err("raxel has not written it");
    }
    if hash(name, payload).as_bytes() == expected { Ok(payload) } else { Err("it is damaged") }
}
