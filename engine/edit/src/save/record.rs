//! The records that the files of a save are made of.
//!
//! A record is a header of 44 bytes and its payload, all numbers little-endian: the magic `RXV2`; the kind (u8) and three zeros; the bytes
//! of the payload (u32); the number of the edit (u64); a position in chunks (x, y, z, i32 each; zeros where it means nothing); the sum of
//! the record before it in the file; the CRC-32C of the payload; the CRC-32C of the header before it, which is the sum of the record. So
//! each record's sum covers all records before it, and a reader notices a record that was cut out of a file.
//!
//! If a reader meets bytes that are no record, it goes on at the next header with a right checksum. So damage costs only the records
//! that it hits.
//!
//! Format 1 had the magic `RXV1` and no sum of the record before. The heads of files are written so to this day: a program that knows
//! format 1 alone reads in them that the save is newer.

use std::io;

use raxel_world::ChunkPos;

/// Bytes of a header in each format.
const HEADERS: [([u8; 4], usize); 2] = [(*b"RXV1", 40), (*b"RXV2", HEADER)];

/// Bytes of a header.
pub(super) const HEADER: usize = 44;

/// Largest number of an edit, a journal or a generation that is read: no save gets so far, and the next ones are numbers too.
pub(super) const LARGEST: u64 = 1 << 62;

/// The kinds of records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The world that the save belongs to.
    Head = 1,
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
        [Self::Head, Self::Operations, Self::Chunk, Self::Base, Self::Commit]
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
    /// Its sum.
    pub(super) sum: u32,
    /// Its end in the file.
    pub(super) end: u64,
}

/// Bytes of a file that are no whole record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Broken {
    /// Empty where records were cut out.
    pub(super) bytes: std::ops::Range<u64>,
    /// The record, as far as its header is readable.
    pub(super) record: Option<(Kind, u64, ChunkPos)>,
    /// The file ends before the record does: it was being written when the program or the machine stopped, or the file was cut off.
    pub(super) short: bool,
}

/// Refuses an edit that no record can hold: the length of a payload has 32 bits. A checkpoint saves the chunks of such an edit.
pub(super) fn check_length(seq: u64, bytes: usize) -> io::Result<()> {
    if u32::try_from(bytes).is_ok() {
        return Ok(());
    }
    let most = u32::MAX;
    let message = format!("edit {seq} takes {bytes} bytes in the journal, and a record has at most {most}");
    Err(io::Error::new(io::ErrorKind::FileTooLarge, message))
}

/// Appends a record to bytes, behind a record with the sum `before`. Gives its own sum.
pub(super) fn write(out: &mut Vec<u8>, before: u32, kind: Kind, seq: u64, pos: ChunkPos, payload: &[u8]) -> u32 {
    put(out, Some(before), kind, seq, pos, payload)
}

/// Appends the first record of a file to bytes: twice, so that no single byte takes it away. Gives its sum.
pub(super) fn write_head(out: &mut Vec<u8>, seq: u64, payload: &[u8]) -> u32 {
    put(out, None, Kind::Head, seq, ChunkPos::new(0, 0, 0), payload);
    put(out, None, Kind::Head, seq, ChunkPos::new(0, 0, 0), payload)
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "`check_length` has refused edits that are longer, and a packed chunk has less than 1 MiB"
)]
fn put(out: &mut Vec<u8>, before: Option<u32>, kind: Kind, seq: u64, pos: ChunkPos, payload: &[u8]) -> u32 {
    let start = out.len();
    out.extend(HEADERS[usize::from(before.is_some())].0);
    out.extend([kind as u8, 0, 0, 0]);
    out.extend((payload.len() as u32).to_le_bytes());
    out.extend(seq.to_le_bytes());
    [pos.x, pos.y, pos.z].iter().for_each(|c| out.extend(c.to_le_bytes()));
    out.extend(before.into_iter().flat_map(u32::to_le_bytes));
    out.extend(crc32c::crc32c(payload).to_le_bytes());
    let sum = crc32c::crc32c(&out[start..]);
    out.extend(sum.to_le_bytes());
    out.extend(payload);
    sum
}

/// Reads the records of a file in order, and the bytes between them.
pub(super) fn read(bytes: &[u8]) -> impl Iterator<Item = Result<Record<'_>, Broken>> {
    // The sum of the record before; none behind broken ones.
    let (mut at, mut before) = (0, Some(0));
    std::iter::from_fn(move || {
        let rest = bytes.get(at..).filter(|rest| !rest.is_empty())?;
        let start = at as u64;
        let Some(header) = Header::read(rest) else {
            let meant = Header::guess(rest);
            let short = rest.len() < meant.as_ref().map_or(header_bytes(rest), |header| header.bytes + header.len);
            // To the next header that is right.
            let next = (1..rest.len()).find(|&next| Header::read(&rest[next..]).is_some());
            at += next.unwrap_or(rest.len());
            before = None;
            let record = meant.map(|header| (header.kind, header.seq, header.pos));
            return Some(Err(Broken { bytes: start..at as u64, record, short: short && next.is_none() }));
        };
        let named = Some((header.kind, header.seq, header.pos));
        if let (Some(before), Some(said)) = (before.take(), header.before)
            && before != said
        {
            // The record itself is read next.
            return Some(Err(Broken { bytes: start..start, record: None, short: false }));
        }
        let Some(payload) = rest.get(header.bytes..header.bytes + header.len) else {
            at = bytes.len();
            return Some(Err(Broken { bytes: start..at as u64, record: named, short: true }));
        };
        at += header.bytes + header.len;
        // The header is right, and so is the sum that the next one has to name.
        before = Some(header.sum);
        if crc32c::crc32c(payload) != header.crc {
            return Some(Err(Broken { bytes: start..at as u64, record: named, short: false }));
        }
        let Header { kind, seq, pos, sum, .. } = header;
        Some(Ok(Record { kind, seq, pos, payload, sum, end: at as u64 }))
    })
}

/// Bytes of the header that begins here, right or wrong.
fn header_bytes(bytes: &[u8]) -> usize {
    HEADERS.iter().find(|(magic, _)| bytes.starts_with(magic)).map_or(HEADER, |(_, bytes)| *bytes)
}

struct Header {
    /// Its own bytes.
    bytes: usize,
    kind: Kind,
    len: usize,
    seq: u64,
    pos: ChunkPos,
    before: Option<u32>,
    crc: u32,
    sum: u32,
}

impl Header {
    /// The contents of a header that has one wrong byte: the byte whose change makes its checksum right.
    fn guess(bytes: &[u8]) -> Option<Self> {
        let mut header = bytes.get(..HEADER).unwrap_or(bytes).to_vec();
        // Any other byte may be the wrong one if the first ones are right.
        let right = HEADERS.iter().any(|(magic, _)| header.starts_with(magic));
        let tried = if right { header.len() } else { header.len().min(4) };
        (0..tried).find_map(|at| {
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
        let first = bytes.first_chunk()?;
        let (_, size) = HEADERS.into_iter().find(|(magic, _)| magic == first)?;
        let header = bytes.get(..size)?;
        let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
        let sum = word(size - 4);
        if crc32c::crc32c(&header[..size - 4]) != sum {
            return None;
        }
        let coordinate = |at: usize| word(at).cast_signed();
        let seq = u64::from(word(12)) | u64::from(word(16)) << 32;
        if seq > LARGEST {
            return None;
        }
        Some(Self {
            bytes: size,
            kind: Kind::of(header[4])?,
            len: word(8) as usize,
            seq,
            pos: ChunkPos::new(coordinate(20), coordinate(24), coordinate(28)),
            before: (size == HEADER).then(|| word(32)),
            crc: word(size - 8),
            sum,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edit_that_is_longer_than_a_record_can_say_is_refused() {
        let longest = u32::MAX as usize;
        assert!(check_length(1, longest).is_ok());
        let error = check_length(7, longest + 1).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        assert!(error.to_string().starts_with("edit 7 takes 4294967296 bytes"), "{error}");
    }
}
