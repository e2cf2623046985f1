//! Poses as compute shaders write them: a count, and records of twelve words. The twin of `shaders/include/raxel/poses.glsl`.

use super::{COORDINATES, Instances, MAX_INSTANCES, Pose};

/// Records that one frame can write.
pub const CAPACITY: usize = MAX_INSTANCES;

/// Words before the records: their count, and three that are not used.
pub const HEADER_WORDS: usize = 4;

/// Words of a record: kind, index of the instance, cell, place in the cell, turn.
pub const RECORD_WORDS: usize = 12;

/// Bytes of the buffer.
pub const BYTES: u64 = 4 * (HEADER_WORDS + CAPACITY * RECORD_WORDS) as u64;

const RESTORE: u32 = 0;
const ANGLES: u32 = 1;
const QUATERNION: u32 = 2;

/// The valid records of a buffer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseRecords {
    /// Index of an instance and its pose; `None` returns it to the world's file and to params. By index, each at most once.
    pub poses: Vec<(usize, Option<Pose>)>,
    /// The number of records beyond the room of the buffer.
    pub lost: u64,
    /// Number of records that are wrong.
    pub wrong: u64,
    /// The fault of the first of them.
    pub why: Option<WrongPose>,
}

/// The faults of a record.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WrongPose {
    /// It is no pose.
    #[error(
        "a record with the first word {word:#010x} is not a pose: the functions of <raxel/poses.glsl> write none like it"
    )]
    Unknown {
        /// The first word.
        word: u32,
    },
    /// There is no such instance.
    #[error("a pose is for instance {index}; the world has {count}")]
    Instance {
        /// The index.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// A number is infinite or none.
    #[error("the pose of instance {index} has a number that is not finite")]
    NotFinite {
        /// Index of the instance.
        index: u32,
    },
    /// Its quaternion has no length.
    #[error("the pose of instance {index} has a quaternion of zeros, which is not a rotation")]
    NoTurn {
        /// Index of the instance.
        index: u32,
    },
    /// It reaches too far.
    #[error(
        "instance {index} would reach {reach:.0} voxels from the origin of the world; at most {COORDINATES} are allowed"
    )]
    Range {
        /// Index of the instance.
        index: u32,
        /// How far.
        reach: f64,
    },
}

impl PoseRecords {
    /// Reads the words of the buffer. Nothing in them is taken on trust. Of different records for one instance, the last one by its words
    /// counts, in any order of writing.
    pub fn read(words: &[u32], instances: &Instances) -> Self {
        let wanted = words.first().map_or(0, |wanted| *wanted as usize);
        let (records, _) = words.get(HEADER_WORDS..).unwrap_or_default().as_chunks::<RECORD_WORDS>();
        let there = wanted.min(records.len());
        let mut sorted = records[..there].to_vec();
        sorted.sort_unstable_by_key(|record| (record[1], *record));
        let mut read = Self { lost: (wanted - there) as u64, ..Self::default() };
        for record in &sorted {
            match pose(record, instances) {
                Ok(found) => {
                    if read.poses.last().is_some_and(|last| last.0 == found.0) {
                        read.poses.pop();
                    }
                    read.poses.push(found);
                }
                Err(why) => {
                    read.wrong += 1;
                    read.why.get_or_insert(why);
                }
            }
        }
        read
    }
}

fn pose(record: &[u32; RECORD_WORDS], instances: &Instances) -> Result<(usize, Option<Pose>), WrongPose> {
    let [word, index, cx, cy, cz, rest @ ..] = *record;
    let count = instances.list.len();
    let instance = instances.list.get(index as usize).ok_or(WrongPose::Instance { index, count })?;
    let [fx, fy, fz, turn @ ..] = rest.map(|word| f64::from(f32::from_bits(word)));
    let cell = [cx, cy, cz].map(|word| f64::from(word.cast_signed()));
    let position = [cell[0] + fx, cell[1] + fy, cell[2] + fz];
    if word == RESTORE {
        return Ok((index as usize, None));
    }
    if position.iter().chain(&turn).any(|v| !v.is_finite()) {
        return Err(WrongPose::NotFinite { index });
    }
    let reach = instances.models[instance.model].reach(position);
    if reach > COORDINATES as f64 {
        return Err(WrongPose::Range { index, reach });
    }
    let pose = match word {
        ANGLES => Pose::new(position, [turn[0], turn[1], turn[2]]),
        QUATERNION => Pose::turned(position, turn).ok_or(WrongPose::NoTurn { index })?,
        word => return Err(WrongPose::Unknown { word }),
    };
    Ok((index as usize, Some(pose)))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::IVec3;

    use super::*;
    use crate::instances::{Instance, InstanceModel};
    use raxel_world::random::mix;
    use raxel_world::{Material, World};

    fn instances() -> Instances {
        let materials = vec![Material::air(), Material::matt("a", [0.5; 3])];
        let voxels = Arc::new(World::from_voxels(materials, [(IVec3::ZERO, 1), (IVec3::new(4, 0, 0), 1)]));
        let pose = Pose::new([0.0; 3], [0.0; 3]);
        let one = Instance { name: None, model: 0, anchor: [0; 3], pose, motions: Vec::new() };
        Instances { models: vec![InstanceModel { voxels, materials: Arc::from([0, 1]) }], list: vec![one; 5] }
    }

    fn record(kind: u32, index: u32, cell: [i32; 3], frac: [f32; 3], turn: [f32; 4]) -> [u32; RECORD_WORDS] {
        let mut words = [kind, index].into_iter().chain(cell.map(i32::cast_unsigned));
        let mut floats = frac.into_iter().chain(turn).map(f32::to_bits);
        std::array::from_fn(|_| words.next().or_else(|| floats.next()).unwrap_or(0))
    }

    fn words(count: u32, records: &[[u32; RECORD_WORDS]]) -> Vec<u32> {
        [&[count, 0, 0, 0][..], records.as_flattened()].concat()
    }

    #[test]
    fn records_are_read_in_one_order_whoever_wrote_first() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let mut records = vec![
            record(ANGLES, 3, [-7, 2, 1 << 29], [0.5, -0.25, 0.0], [90.0, 0.0, 180.0, 0.0]),
            record(QUATERNION, 0, [1, 2, 3], [0.0; 3], [0.0, 3.0 * half, 0.0, 3.0 * half]),
            record(RESTORE, 1, [0; 3], [f32::NAN; 3], [0.0; 4]),
            record(ANGLES, 4, [8; 3], [0.0; 3], [0.0; 4]),
            record(ANGLES, 4, [9; 3], [0.0; 3], [0.0; 4]),
        ];
        let quarter = Pose::new([1.0, 2.0, 3.0], [90.0, 0.0, 0.0]);
        for turn in 0..records.len() {
            records.rotate_left(turn);
            let read = PoseRecords::read(&words(5, &records), &instances());
            assert_eq!((read.lost, read.wrong, read.why), (0, 0, None));
            let [(0, Some(first)), (1, None), (3, third), (4, fourth)] = read.poses[..] else {
                panic!("{:?}", read.poses)
            };
            assert_eq!(first, quarter, "a quarter turn by a quaternion is one of whole numbers");
            let far = f64::from(1 << 29);
            assert_eq!(third, Some(Pose::new([-6.5, 1.75, far], [90.0, 0.0, 180.0])));
            assert_eq!(fourth, Some(Pose::new([9.0; 3], [0.0; 3])));
        }
        assert_eq!(PoseRecords::read(&words(0, &records), &instances()), PoseRecords::default());
    }

    #[test]
    fn what_is_wrong_or_too_much_is_counted() {
        let good = record(ANGLES, 2, [1, 2, 3], [0.0; 3], [0.0; 4]);
        for (bad, why) in [
            (record(3, 0, [0; 3], [0.0; 3], [0.0; 4]), "0x00000003 is not a pose"),
            (record(ANGLES, 5, [0; 3], [0.0; 3], [0.0; 4]), "instance 5; the world has 5"),
            (record(ANGLES, u32::MAX, [0; 3], [0.0; 3], [0.0; 4]), "instance 4294967295; the world has 5"),
            (record(ANGLES, 1, [0; 3], [f32::NAN, 0.0, 0.0], [0.0; 4]), "instance 1 has a number that is not finite"),
            (record(ANGLES, 1, [0; 3], [0.0; 3], [0.0, f32::INFINITY, 0.0, 0.0]), "is not finite"),
            (record(ANGLES, 1, [0; 3], [1.0e38, 0.0, 0.0], [0.0; 4]), "would reach"),
            (record(ANGLES, 1, [(1 << 30) - 3, 0, 0], [0.0; 3], [0.0; 4]), "would reach 1073741831 voxels"),
            (record(ANGLES, 1, [i32::MIN; 3], [0.0; 3], [0.0; 4]), "would reach"),
            (record(QUATERNION, 1, [0; 3], [0.0; 3], [0.0; 4]), "quaternion of zeros"),
        ] {
            let read = PoseRecords::read(&words(2, &[good, bad]), &instances());
            assert_eq!((read.poses.len(), read.wrong, read.lost), (1, 1, 0), "{why}");
            let said = read.why.unwrap().to_string();
            assert!(said.contains(why), "{said}");
        }
        let read = PoseRecords::read(&words(u32::MAX, &[good]), &instances());
        assert_eq!((read.poses.len(), read.lost), (1, u64::from(u32::MAX) - 1));
        // No words make it panic.
        for seed in 0..3000 {
            let words: Vec<u32> = (0..seed % 80).map(|i| mix(seed * 96 + i) as u32 >> (mix(i ^ seed) % 32)).collect();
            let read = PoseRecords::read(&words, &instances());
            assert!(read.poses.iter().all(|(index, _)| *index < 5));
        }
    }
}
