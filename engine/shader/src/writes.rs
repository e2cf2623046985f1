//! A shader's writes of a texel, where they are recorded: the words that say which texel, and the meaning of the records.

use std::ops::Range;
use std::sync::Arc;

use raxel_spirv::{PrintedScalar, PrintedType, RECORD_HEAD, RECORDS, TexelWrites, WatchedImage, WriteKind};
use serde::Serialize;

use crate::format::ScalarKind;
use crate::sources::Sources;

/// Words of a record's values: the number of the write, and what it writes.
const VALUES: usize = 5;

/// The writes of a shader to its storage images.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Writes {
    /// The writes, in the order of the module.
    pub sites: Vec<Site>,
    #[serde(skip)]
    texel: Range<u32>,
    #[serde(skip)]
    images: Vec<WatchedImage>,
    #[serde(skip)]
    first_word: u32,
}

/// One line that writes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Site {
    /// File and line, counted from 1, when the source is known.
    pub line: Option<(Arc<str>, u32)>,
    #[serde(skip)]
    kind: WriteKind,
    #[serde(skip)]
    value: PrintedType,
}

/// A descriptor of a storage image that the watched texel is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WatchedDescriptor {
    /// Its descriptor set.
    pub set: u32,
    /// Its binding.
    pub binding: u32,
    /// Its index in an array of descriptors.
    pub element: u32,
    /// The texel's layer or slice in the view that is bound there.
    pub layer: u32,
}

/// The records of a texel's writes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedWrites {
    /// How often it was written.
    pub count: u32,
    /// The first writes, in the order in which they were recorded.
    pub writes: Vec<RecordedWrite>,
}

/// A write by one invocation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedWrite {
    /// File and line, counted from 1, when the source is known.
    pub line: Option<(Arc<str>, u32)>,
    /// `gl_GlobalInvocationID`.
    pub invocation: [u32; 3],
    /// The value, as the shader has it.
    pub value: Written,
    /// Whether an atomic operation wrote it.
    pub atomic: bool,
}

/// A written value before it becomes one of the target's format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The type of its components.
    pub scalar: ScalarKind,
    /// The bits of its components.
    pub words: Vec<u32>,
}

impl Writes {
    pub(crate) fn of(writes: &TexelWrites, sources: &Sources<'_>) -> Self {
        let known = |(file, line): &(String, u32)| sources.text(file).map(|_| (file.as_str().into(), *line));
        let site = |site: &raxel_spirv::WriteSite| Site {
            line: site.line.as_ref().and_then(known),
            kind: site.kind,
            value: site.value,
        };
        Self {
            sites: writes.sites.iter().map(site).collect(),
            texel: writes.texel_word..writes.end_word,
            images: writes.images.clone(),
            first_word: writes.first_word,
        }
    }

    /// The words to put into the buffer before a run, so that it records the writes of a texel: the word at which they begin, and the words.
    /// `None` if the shader has none of the descriptors.
    pub fn watch(&self, at: [u32; 2], descriptors: &[WatchedDescriptor]) -> Option<(u32, Vec<u32>)> {
        let Range { start, end } = self.texel;
        let mut words = vec![0; (end - start) as usize];
        words[..2].copy_from_slice(&at);
        for descriptor in descriptors {
            let is_in = |image: &&WatchedImage| {
                [image.set, image.binding] == [descriptor.set, descriptor.binding] && descriptor.element < image.count
            };
            if let Some(image) = self.images.iter().find(is_in) {
                words[(image.first_word + descriptor.element - start) as usize] = descriptor.layer.saturating_add(1);
            }
        }
        words[2..].iter().any(|word| *word != 0).then_some((start, words))
    }

    /// The records in the words of the buffer. Words beyond their end count as zeros.
    pub fn recorded(&self, words: &[u32]) -> RecordedWrites {
        let at = self.first_word as usize;
        let reached = words.get(at).copied().unwrap_or(0);
        let head = RECORD_HEAD as usize;
        let kept = words.get(at + 1..).unwrap_or(&[]).chunks_exact(head + VALUES).take(reached.min(RECORDS) as usize);
        let mut count = reached;
        let mut writes = Vec::new();
        for record in kept {
            let (head, values) = record.split_at(head);
            let Some(site) = self.sites.get(values[0] as usize) else { continue };
            match site.kind.written([values[1], values[2], values[3], values[4]]) {
                Some(words) => writes.push((head[0], site.record([head[1], head[2], head[3]], words))),
                None => count -= 1,
            }
        }
        writes.sort_by_key(|(order, _)| *order);
        RecordedWrites { count, writes: writes.into_iter().map(|(_, write)| write).collect() }
    }
}

impl Site {
    fn record(&self, invocation: [u32; 3], words: [u32; 4]) -> RecordedWrite {
        let scalar = match self.value.scalar {
            PrintedScalar::Float => ScalarKind::Float,
            PrintedScalar::Int => ScalarKind::Int,
            PrintedScalar::Uint | PrintedScalar::Bool => ScalarKind::Uint,
        };
        let words = words[..(self.value.components as usize).min(words.len())].to_vec();
        let atomic = self.kind != WriteKind::Store;
        RecordedWrite { line: self.line.clone(), invocation, value: Written { scalar, words }, atomic }
    }
}

impl Written {
    /// Its components as text, at most so many.
    pub fn texts(&self, channels: usize) -> Vec<String> {
        let text = |word: &u32| match self.scalar {
            ScalarKind::Float => f32::from_bits(*word).to_string(),
            ScalarKind::Int => word.cast_signed().to_string(),
            ScalarKind::Uint => word.to_string(),
        };
        self.words.iter().take(channels).map(text).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn writes() -> Writes {
        let value = |scalar, components| PrintedType { scalar, components };
        let site = |line, kind, value| Site { line: Some(("a.comp".into(), line)), kind, value };
        let image = |binding, count, first_word| WatchedImage { set: 0, binding, count, first_word };
        Writes {
            sites: vec![
                site(3, WriteKind::Store, value(PrintedScalar::Float, 4)),
                site(4, WriteKind::CompareExchange, value(PrintedScalar::Int, 1)),
            ],
            texel: 1..7,
            images: vec![image(0, 1, 4), image(2, 2, 5)],
            first_word: 7,
        }
    }

    #[test]
    fn the_words_of_a_texel_name_its_descriptors() {
        let at = |binding, element, layer| WatchedDescriptor { set: 0, binding, element, layer };
        let watch = |descriptors: &[WatchedDescriptor]| writes().watch([8, 9], descriptors);
        assert_eq!(watch(&[at(0, 0, 0)]), Some((1, vec![8, 9, 0, 1, 0, 0])));
        assert_eq!(watch(&[at(2, 1, 6), at(0, 0, 2)]), Some((1, vec![8, 9, 0, 3, 0, 7])));
        assert_eq!(watch(&[at(1, 0, 0), at(2, 2, 0)]), None, "there are no such descriptors");
        assert_eq!(watch(&[]), None);
    }

    #[test]
    fn records_are_read_in_their_order() {
        let one = 1f32.to_bits();
        let mut words = vec![0; 7];
        words.push(3);
        words.extend([2, 5, 6, 7, 0, one, 0, 0, one]);
        words.extend([0, 1, 2, 3, 1, 4, u32::MAX, 4, 0]);
        // A comparison that fails writes nothing.
        words.extend([1, 1, 2, 3, 1, 4, 9, 5, 0]);
        let RecordedWrites { count, writes } = writes().recorded(&words);
        let seen: Vec<_> = writes
            .iter()
            .map(|write| (write.line.as_ref().unwrap().1, write.invocation, write.value.texts(3)))
            .collect();
        let texts = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
        assert_eq!(count, 2);
        assert_eq!(seen, [(4, [1, 2, 3], texts(&["-1"])), (3, [5, 6, 7], texts(&["1", "0", "0"]))]);
        assert_eq!(super::tests::writes().recorded(&[]), RecordedWrites { count: 0, writes: Vec::new() });
    }
}
