//! Edits as compute shaders write them: a count, and records of eight words. The twin of `shaders/include/raxel/edits.glsl`.

use raxel_world::{AIR, Bounds, MaterialIndex};

use crate::operation::{Brush, EditError, Operation};
use crate::scene::Scene;

/// Records that one frame can write.
pub const CAPACITY: usize = 4096;

/// Words before the records: their count, and three that are not used.
pub const HEADER_WORDS: usize = 4;

/// Words of a record.
pub(crate) const RECORD_WORDS: usize = 8;

/// Bytes of the buffer.
pub const BYTES: u64 = 4 * (HEADER_WORDS + CAPACITY * RECORD_WORDS) as u64;

const RESTORE: u32 = 0;
const BOX: u32 = 1;
const SPHERE: u32 = 2;
const SET: u32 = 3;

/// The contents of the buffer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Records {
    /// Valid operations, in an order that does not depend on the order of the writers.
    pub operations: Vec<Operation>,
    /// Number of records without room.
    pub lost: u64,
    /// Number of invalid records.
    pub wrong: u64,
    /// Why the first of them is invalid.
    pub why: Option<WrongRecord>,
}

/// Why a record is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WrongRecord {
    /// It is no edit.
    #[error(
        "a record with the first word {word:#010x} is not an edit: the functions of <raxel/edits.glsl> write none like it"
    )]
    Unknown {
        /// The first word.
        word: u32,
    },
    /// Its material does not fit.
    #[error("a record has material {material}; there is no such palette index")]
    Material {
        /// The word.
        material: u32,
    },
    /// It is a ball, and its radius is below 0. GLSL does not define the conversion of a float that is not finite; most devices make that
    /// negative, too.
    #[error("a ball has a radius that is negative or not finite")]
    Radius,
    /// It is an edit that cannot be made.
    #[error(transparent)]
    Edit(#[from] EditError),
}

impl Records {
    /// Reads and checks the words of the buffer. Equal records count once.
    pub fn read(words: &[u32], scene: &Scene) -> Self {
        let wanted = words.first().map_or(0, |wanted| *wanted as usize);
        let (records, _) = words.get(HEADER_WORDS..).unwrap_or_default().as_chunks::<RECORD_WORDS>();
        let there = wanted.min(records.len());
        let mut sorted = records[..there].to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        let mut read = Self { lost: (wanted - there) as u64, ..Self::default() };
        for record in &sorted {
            match operation(record).and_then(|operation| Ok(operation.bounds(scene).map(|_| operation)?)) {
                Ok(operation) => read.operations.push(operation),
                Err(why) => {
                    read.wrong += 1;
                    read.why.get_or_insert(why);
                }
            }
        }
        read
    }
}

fn operation(record: &[u32; RECORD_WORDS]) -> Result<Operation, WrongRecord> {
    let [word, material, rest @ ..] = *record;
    let unknown = WrongRecord::Unknown { word };
    let index = MaterialIndex::try_from(material).map_err(|_| WrongRecord::Material { material })?;
    let brush = match word >> 8 {
        0 => Brush::Subtract,
        1 => Brush::Add(index),
        2 => Brush::Paint(index),
        _ => return Err(unknown),
    };
    let rest = rest.map(u32::cast_signed);
    let cell = [rest[0], rest[1], rest[2]];
    let [ax, ay, az, bx, by, bz] = rest.map(i64::from);
    let bounds = Bounds { min: [ax, ay, az], max: [bx + 1, by + 1, bz + 1] };
    let center = [ax, ay, az].map(|cell| cell * crate::operation::UNIT + crate::operation::UNIT / 2);
    match (word & 0xff, brush) {
        (RESTORE, Brush::Subtract) => Ok(Operation::Restore { bounds }),
        (BOX, brush) => Ok(Operation::Box { bounds, brush }),
        (SPHERE, brush) => match u32::try_from(rest[3]) {
            Ok(radius) => Ok(Operation::Sphere { center, radius, brush }),
            Err(_) => Err(WrongRecord::Radius),
        },
        (SET, Brush::Subtract) => Ok(Operation::Set { cell, material: AIR }),
        (SET, Brush::Add(material)) => Ok(Operation::Set { cell, material }),
        _ => Err(unknown),
    }
}

#[cfg(test)]
mod tests {
    use raxel_world::Material;
    use raxel_world::random::mix;

    use super::*;

    fn scene() -> Scene {
        Scene { materials: vec![Material::air(); 4], models: Vec::new() }
    }

    fn words(count: u32, records: &[[u32; RECORD_WORDS]]) -> Vec<u32> {
        [&[count, 0, 0, 0][..], records.as_flattened()].concat()
    }

    #[test]
    fn records_are_read_in_one_order_whoever_wrote_first() {
        let minus = |n: i32| n.cast_unsigned();
        let mut records = vec![
            [SET | 1 << 8, 3, minus(-5), 6, 7, 0, 0, 0],
            [SET, 0, 1, 2, 3, 0, 0, 0],
            [SPHERE | 2 << 8, 2, minus(-1), 0, 0, 640, 0, 0],
            [BOX | 1 << 8, 1, 0, 0, minus(-8), 9, 9, minus(-8)],
            [RESTORE, 0, 4, 4, 4, 4, 4, 4],
            [RESTORE, 0, 4, 4, 4, 4, 4, 4],
        ];
        let expected = vec![
            Operation::Restore { bounds: Bounds { min: [4; 3], max: [5; 3] } },
            Operation::Set { cell: [1, 2, 3], material: AIR },
            Operation::Box { bounds: Bounds { min: [0, 0, -8], max: [10, 10, -7] }, brush: Brush::Add(1) },
            Operation::Set { cell: [-5, 6, 7], material: 3 },
            Operation::Sphere { center: [-128, 128, 128], radius: 640, brush: Brush::Paint(2) },
        ];
        for turn in 0..records.len() {
            records.rotate_left(turn);
            let read = Records::read(&words(6, &records), &scene());
            assert_eq!(read, Records { operations: expected.clone(), ..Records::default() });
        }
        assert_eq!(Records::read(&words(0, &records), &scene()), Records::default(), "what is left of earlier frames");
    }

    #[test]
    fn what_is_wrong_or_too_much_is_counted() {
        let good = [SET | 1 << 8, 1, 0, 0, 0, 0, 0, 0];
        for (bad, why) in [
            ([77, 0, 0, 0, 0, 0, 0, 0], "0x0000004d is not an edit"),
            ([SET | 2 << 8, 1, 0, 0, 0, 0, 0, 0], "is not an edit"),
            ([SET | 1 << 8, 70_000, 0, 0, 0, 0, 0, 0], "material 70000"),
            ([SET | 1 << 8, 9, 0, 0, 0, 0, 0, 0], "uses material 9; the world has 4"),
            ([SPHERE, 0, 0, 0, 0, 0, 0, 0], "its radius is 0"),
            ([SPHERE, 0, 0, 0, 0, (-3_i32 * 256).cast_unsigned(), 0, 0], "negative or not finite"),
            ([BOX, 0, 5, 5, 5, 4, 9, 9], "covers nothing"),
            ([BOX, 0, 0, 0, 0, 1 << 30, 1 << 30, 1 << 30], "reaches over"),
        ] {
            let read = Records::read(&words(2, &[good, bad]), &scene());
            assert_eq!((read.operations.len(), read.wrong, read.lost), (1, 1, 0));
            let said = read.why.unwrap().to_string();
            assert!(said.contains(why), "{said}");
        }
        let read = Records::read(&words(u32::MAX, &[good]), &scene());
        assert_eq!((read.operations.len(), read.lost), (1, u64::from(u32::MAX) - 1));
        // No words make it panic.
        for seed in 0..2000 {
            let words: Vec<u32> = (0..seed % 60).map(|i| mix(seed * 64 + i) as u32 >> (mix(i ^ seed) % 32)).collect();
            let _ = Records::read(&words, &scene());
        }
    }
}
