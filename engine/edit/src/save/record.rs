//! The records that the files of a save are made of.
//!
//! A record is a header of 40 bytes and its payload, all numbers little-endian: the magic `RXV1`; the kind (u8) and three zeros; the bytes
//! of the payload (u32); the number of the edit (u64); a position in chunks (x, y, z, i32 each; zeros where it means nothing); the
//! CRC-32C of the payload; the CRC-32C of the header before it. A reader that meets bytes that are no record goes on at the next header
//! whose checksum is right: damage costs the records that it is in, and no other.

use raxel_world::ChunkPos;

/// First bytes of every record.
pub(super) const MAGIC: [u8; 4] = *b"RXV1";

/// Bytes of a header.
pub(super) const HEADER: usize = 40;

/// What a record is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// What the save belongs to.
    Meta = 1,
    /// The operations of one step.
    Operations = 2,
    /// A chunk, packed.
    Chunk = 3,
    /// The chunk is the base's again.
    Base = 4,
    /// All chunks before it hold the edits up to its number.
    Commit = 5,
}

impl Kind {
    fn of(byte: u8) -> Option<Self> {
        [Self::Meta, Self::Operations, Self::Chunk, Self::Base, Self::Commit]
            .into_iter()
            .find(|kind| *kind as u8 == byte)
    }
}

/// A record that was read and checked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record<'a> {
    pub(super) kind: Kind,
    pub(super) seq: u64,
    pub(super) pos: ChunkPos,
    pub(super) payload: &'a [u8],
}

/// Bytes of a file that are no whole record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Broken {
    pub(super) bytes: std::ops::Range<u64>,
    /// What the record is, as far as its header tells.
    pub(super) record: Option<(Kind, u64, ChunkPos)>,
    /// The file ends in it: it was being written when the program or the machine stopped.
    pub(super) at_end: bool,
}

/// Appends a record to bytes.
pub(super) fn write(out: &mut Vec<u8>, kind: Kind, seq: u64, pos: ChunkPos, payload: &[u8]) {
    let start = out.len();
    out.extend(MAGIC);
    out.extend([kind as u8, 0, 0, 0]);
    out.extend((payload.len() as u32).to_le_bytes());
    out.extend(seq.to_le_bytes());
    [pos.x, pos.y, pos.z].iter().for_each(|c| out.extend(c.to_le_bytes()));
    out.extend(crc32c::crc32c(payload).to_le_bytes());
    let crc = crc32c::crc32c(&out[start..]);
    out.extend(crc.to_le_bytes());
    out.extend(payload);
}

/// Reads the records of a file in order, and what is between them.
pub(super) fn read(bytes: &[u8]) -> impl Iterator<Item = Result<Record<'_>, Broken>> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let rest = bytes.get(at..).filter(|rest| !rest.is_empty())?;
        let start = at as u64;
        let Some(header) = Header::read(rest) else {
            // To the next header that is right.
            let next = (1..rest.len()).find(|&next| Header::read(&rest[next..]).is_some());
            at += next.unwrap_or(rest.len());
            let record = Header::guess(rest).map(|header| (header.kind, header.seq, header.pos));
            return Some(Err(Broken { bytes: start..at as u64, record, at_end: next.is_none() }));
        };
        let named = Some((header.kind, header.seq, header.pos));
        let Some(payload) = rest.get(HEADER..HEADER + header.len) else {
            at = bytes.len();
            return Some(Err(Broken { bytes: start..at as u64, record: named, at_end: true }));
        };
        at += HEADER + header.len;
        if crc32c::crc32c(payload) != header.crc {
            let at_end = at == bytes.len();
            return Some(Err(Broken { bytes: start..at as u64, record: named, at_end }));
        }
        Some(Ok(Record { kind: header.kind, seq: header.seq, pos: header.pos, payload }))
    })
}

struct Header {
    kind: Kind,
    len: usize,
    seq: u64,
    pos: ChunkPos,
    crc: u32,
}

impl Header {
    /// What a header says that has one wrong byte: the one whose change makes its checksum right.
    fn guess(bytes: &[u8]) -> Option<Self> {
        let mut header = *bytes.first_chunk::<HEADER>()?;
        (0..HEADER).find_map(|at| {
            let byte = header[at];
            let found = (1..=255).find_map(|change| {
                header[at] = byte ^ change;
                Self::read(&header)
            });
            header[at] = byte;
            found
        })
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let header = bytes.first_chunk::<HEADER>()?;
        let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
        if header[..4] != MAGIC || crc32c::crc32c(&header[..36]) != word(36) {
            return None;
        }
        let coordinate = |at: usize| word(at) as i32;
        Some(Self {
            kind: Kind::of(header[4])?,
            len: word(8) as usize,
            seq: u64::from(word(12)) | u64::from(word(16)) << 32,
            pos: ChunkPos::new(coordinate(20), coordinate(24), coordinate(28)),
            crc: word(32),
        })
    }
}
