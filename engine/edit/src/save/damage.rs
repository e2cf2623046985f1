//! The damages of the files of a save.

use std::collections::BTreeSet;
use std::fmt;
use std::ops::{Range, RangeInclusive};

use super::record::{Broken, Kind};

/// Damage to a file of a save.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Name of the file.
    pub file: String,
    /// The bytes that are lost; none when the file ends before them, or is gone.
    pub bytes: Range<u64>,
    /// The kind of these bytes.
    pub what: String,
    /// The file ends in a record that was being written when the program stopped. No edit that was acknowledged is lost.
    pub unfinished: bool,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, bytes, what, .. } = self;
        if bytes.is_empty() {
            return write!(f, "{file}: missing: {what}");
        }
        write!(f, "{file}: bytes {}…{} are lost: {what}", bytes.start, bytes.end)
    }
}

impl Damage {
    /// Bytes that are no record, behind the record of an edit.
    pub(super) fn broken(file: &str, broken: &Broken, last: Option<u64>) -> Self {
        let what = match (broken.record, last) {
            _ if broken.bytes.is_empty() => format!("records before byte {}", broken.bytes.start),
            (Some((Kind::Operations, seq, _)), _) => format!("edit {seq}"),
            (Some((Kind::Chunk | Kind::Base, seq, pos)), _) => {
                format!("the chunk at {}, {}, {} as edit {seq} left it", pos.x, pos.y, pos.z)
            }
            (Some((Kind::Commit, seq, _)), _) => format!("the end of the checkpoint of edit {seq}"),
            (Some((Kind::Head, ..)), _) => "the description of the save".to_owned(),
            (None, Some(seq)) => format!("what followed the record of edit {seq}"),
            (None, None) => "the beginning of the file".to_owned(),
        };
        Self { file: file.to_owned(), bytes: broken.bytes.clone(), what, unfinished: broken.short }
    }

    /// Something that the file lacks, and no other file has.
    pub(super) fn missing(file: &str, what: impl Into<String>) -> Self {
        Self { file: file.to_owned(), bytes: 0..0, what: what.into(), unfinished: false }
    }

    /// Edits that no file has.
    pub(super) fn edits(file: &str, edits: &RangeInclusive<u64>) -> Self {
        let (first, last) = (edits.start(), edits.end());
        Self::missing(file, if first == last { format!("edit {last}") } else { format!("edits {first}…{last}") })
    }
}

/// The parts of a range that are between some numbers.
pub(super) fn between(range: &RangeInclusive<u64>, numbers: &BTreeSet<u64>) -> Vec<RangeInclusive<u64>> {
    let mut next = *range.start();
    let mut parts = Vec::new();
    if range.is_empty() {
        return parts;
    }
    for &number in numbers.range(range.clone()) {
        parts.extend((next < number).then(|| next..=number - 1));
        next = number + 1;
    }
    parts.extend((next <= *range.end()).then(|| next..=*range.end()));
    parts
}
