//! The buffer of `source = "world.instances"`.

use raxel_world::Material;

use super::bvh::{self, NODE_WORDS};
use super::frame::{Frame, Rotation};
use super::lamps::Lamps;
use super::{Instance, Instances};
use crate::block::words_and_quads;
use crate::{BlockMember, Layout, LayoutError, Tree64Header};

/// Words of the header: how many instances there are, the quad of the first one, how many have lamps, and the quad where the list of these begins.
const HEADER_WORDS: usize = 4;
/// Words of an instance.
const INSTANCE_WORDS: usize = 32;
/// Words of a quad.
const QUAD: usize = 4;
/// Bit of the shape of an instance in a free frame.
const FREE: u32 = 1 << 16;

/// The buffer of instances that shaders read: a part that changes when they move, and their models behind it.
#[derive(Clone, Debug)]
pub struct InstanceBuffer {
    instances: Vec<Instance>,
    models: Vec<ModelTree>,
    /// The trees of all models, and behind them the lamps.
    trees: Vec<u32>,
    lamps: LampList,
}

/// Where the lamps of instances are listed.
#[derive(Clone, Debug)]
struct LampList {
    /// Instances with lamps.
    count: u32,
    /// The first quad, from the end of the part that moves.
    at: usize,
    /// The power of each model.
    of_models: Vec<f32>,
}

/// A model in the layout `tree64`.
#[derive(Clone, Copy, Debug)]
struct ModelTree {
    header: Tree64Header,
    /// Its first quad, from the end of the part that moves.
    at: usize,
}

impl InstanceBuffer {
    pub(super) fn new(instances: &Instances, palette: &[Material], limit: u64) -> Result<Self, LayoutError> {
        let mut trees = Vec::new();
        let mut models = Vec::new();
        for model in &instances.models {
            let encoded = Layout::TREE64.encode(&model.voxels, limit)?;
            let (header, body) = encoded.words.split_at(Tree64Header::WORDS as usize);
            let header: Tree64Header = bytemuck::pod_read_unaligned(bytemuck::cast_slice(header));
            models.push(ModelTree { header, at: trees.len() / QUAD });
            let first = trees.len();
            trees.extend_from_slice(body);
            // The unused word of a material is the index of the world's material. Behind the palette are the nodes.
            for (index, &of_world) in model.materials.iter().take(model.voxels.materials().len()).enumerate() {
                trees[first + 8 * index + 7] = u32::from(of_world);
            }
            trees.resize(trees.len().next_multiple_of(QUAD), 0);
        }
        let corners: Vec<[i32; 3]> = models.iter().map(|model| model.header.origin).collect();
        let Lamps { count, words, of_models } = Lamps::new(instances, palette, &corners);
        let lamps = LampList { count, at: trees.len() / QUAD, of_models };
        trees.extend(words);
        let buffer = Self { instances: instances.list.clone(), models, trees, lamps };
        let bytes = 4 * (buffer.moving_words() + buffer.trees.len()) as u64;
        if bytes > limit {
            return Err(LayoutError::TooLarge { layout: "instances", bytes, limit });
        }
        Ok(buffer)
    }

    /// The whole buffer.
    pub fn words(&self, frames: &[Frame]) -> Vec<u32> {
        let mut words = self.moving(frames);
        words.extend_from_slice(&self.trees);
        // An array without an element is none: shaders look at the count.
        words.resize(words.len().max(HEADER_WORDS + QUAD), 0);
        words
    }

    /// The words at its start: all that depends on where instances stand.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "an encoding is addressed in 32 bits, and cells wrap in 32 bits"
    )]
    pub fn moving(&self, frames: &[Frame]) -> Vec<u32> {
        let boxes: Vec<_> = self
            .instances
            .iter()
            .zip(frames)
            .map(|(instance, frame)| {
                let [low, last] = self.about_anchor(instance);
                frame.bounds(low, last).map(|corner| corner.map(|c| c.clamp(i64::from(i32::MIN), i64::from(i32::MAX))))
            })
            .collect();
        let nodes = bvh::build(&boxes);
        let mut words = Vec::with_capacity(self.moving_words());
        let trees_at = (self.moving_words() - HEADER_WORDS) / QUAD;
        let lamps_at = (trees_at + self.lamps.at) as u32;
        words.extend([boxes.len() as u32, (nodes.len() / QUAD) as u32, self.lamps.count, lamps_at]);
        words.extend(nodes);
        for (instance, frame) in self.instances.iter().zip(frames) {
            self.put(instance, frame, trees_at, &mut words);
        }
        words
    }

    fn moving_words(&self) -> usize {
        let count = self.instances.len();
        HEADER_WORDS + NODE_WORDS * (2 * count).saturating_sub(1) + INSTANCE_WORDS * count
    }

    /// The box of the solid voxels of an instance's model, counted from its anchor.
    fn about_anchor(&self, instance: &Instance) -> [[i64; 3]; 2] {
        let header = &self.models[instance.model].header;
        [header.bounds_min, header.bounds_last]
            .map(|corner| std::array::from_fn(|i| i64::from(corner[i]) - instance.anchor[i]))
    }

    /// The words of an instance. Rays cross the cube of its tree: in the world if the instance is on the world's lattice, otherwise in the
    /// model's frame, counted from the anchor.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "an encoding is addressed in 32 bits, and cells wrap in 32 bits"
    )]
    fn put(&self, instance: &Instance, frame: &Frame, trees_at: usize, words: &mut Vec<u32>) {
        let ModelTree { header, at } = &self.models[instance.model];
        let last = (1_i64 << header.log2_size) - 1;
        let cube: [i64; 3] = std::array::from_fn(|i| i64::from(header.origin[i]) - instance.anchor[i]);
        let [low, high] = self.about_anchor(instance);
        let (corner, [low, high], turn) = match frame.turn {
            Rotation::Quarter(orientation) => {
                let [corner, _] = frame.bounds(cube, cube.map(|c| c + last));
                (corner, frame.bounds(low, high), u32::from(orientation.inverse().to_vox()) << 8)
            }
            Rotation::Free(_) => {
                (cube, [low, high], FREE | u32::from(raxel_world::Orientation::IDENTITY.to_vox()) << 8)
            }
        };
        let rows = match frame.turn {
            Rotation::Quarter(_) => [[0; 3]; 3],
            Rotation::Free(rows) => rows,
        };
        let word = |v: i64| (v as i32).cast_unsigned();
        let mut quad = |v: [i64; 3], w: u32| words.extend([word(v[0]), word(v[1]), word(v[2]), w]);
        let root = header.root as usize;
        quad(corner, header.log2_size | turn);
        quad(std::array::from_fn(|i| low[i] - corner[i]), (trees_at + at) as u32);
        quad(std::array::from_fn(|i| high[i] - corner[i]), root as u32);
        quad(header.origin.map(i64::from), frame.fraction[0]);
        quad(frame.cell.map(i64::from), frame.fraction[1]);
        let last_words = [frame.fraction[2], self.lamps.of_models[instance.model].to_bits(), 0];
        for (row, last) in rows.iter().zip(last_words) {
            quad(row.map(i64::from), last);
        }
    }

    /// The members of the buffer block that a shader must declare, in order.
    pub fn block() -> Vec<BlockMember> {
        words_and_quads::<HEADER_WORDS>(["count", "first", "lamps", "lamps_at"])
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::IVec3;
    use raxel_world::{Material, MaterialIndex, Orientation, World};

    use super::super::{Instance, InstanceModel, Instances, Pose};
    use super::*;

    #[test]
    fn materials_behind_the_palette_of_a_model_change_nothing() {
        let palette = vec![Material::air(), Material::matt("a", [0.5; 3])];
        let voxels = Arc::new(World::from_voxels(palette, [(IVec3::ZERO, 1)]));
        let words = |materials: &[MaterialIndex]| {
            let models = vec![InstanceModel { voxels: voxels.clone(), materials: materials.into() }];
            Instances { models, list: Vec::new() }.encode(&[], u64::MAX).expect("it fits").words(&[])
        };
        assert_eq!(words(&[0, 9]), words(&[0, 9, 7, 7, 7, 7, 7, 7]));
        assert_ne!(words(&[0, 9]), words(&[0, 8]));
    }

    /// Two voxels of a palette of `materials` materials.
    fn model(materials: u16) -> InstanceModel {
        let palette = (0..materials).map(|i| Material::matt(format!("m{i}"), [0.5; 3])).collect();
        let voxels = World::from_voxels(palette, [(IVec3::new(2, 3, 4), 1), (IVec3::new(5, 3, 9), 1)]);
        InstanceModel { voxels: Arc::new(voxels), materials: (0..materials).map(|i| 7 * i).collect() }
    }

    fn instance(model: usize, anchor: [i64; 3], pose: Pose) -> Instance {
        Instance { name: None, model, anchor, pose, motions: Vec::new() }
    }

    /// By the format of `shaders/include/raxel/instances.glsl`, quad by quad.
    #[test]
    fn instances_are_written_as_shaders_read_them() {
        let list = vec![
            instance(1, [2, 3, 4], Pose::new([100.0, -20.0, 7.0], [0.0; 3])),
            instance(0, [0; 3], Pose::new([0.25, 0.0, 0.0], [0.0; 3])),
            instance(0, [2, 3, 4], Pose::new([10.0, 20.0, 30.0], [90.0, 0.0, 0.0])),
        ];
        let instances = Instances { models: vec![model(2), model(4)], list };
        let buffer = instances.encode(&[], u64::MAX).expect("it fits");
        let words = buffer.words(&instances.frames(|_| None));
        let quad = |at: usize| words[HEADER_WORDS + QUAD * at..][..QUAD].to_vec();
        let of = |v: [i32; 3], w: u32| [&v.map(i32::cast_unsigned)[..], &[w]].concat();
        // Five nodes of a tree over three boxes, and the models behind eight quads of each instance.
        let (first, trees) = (10, 10 + 3 * 8);
        let lamps_at = (words.len() - HEADER_WORDS) / QUAD;
        assert_eq!(words[..HEADER_WORDS], [3, first as u32, 0, lamps_at as u32]);
        let (half, unit) = (1 << 23, 1 << 23);
        let turn = |rows| u32::from(Orientation::from_rows(rows).expect("a turn").inverse().to_vox()) << 8;
        let none = turn([[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
        let left = turn([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]);
        // A model has eight words for each material, then its nodes; the first tree is as long as the second one begins behind it.
        let second = quad(first + 1)[3] as usize;
        let at = |instance: usize, of: usize| quad(first + 8 * instance + of);
        let expected = [
            (0, [98, -23, 3], 6 | none, [2, 3, 4], second, [5, 3, 9], 8, half, [100, -20, 7]),
            (1, [0, 0, 0], 6 | FREE | none, [2, 3, 4], trees, [5, 3, 9], 4, half + half / 2, [0, 0, 0]),
            (2, [6, 17, -31], 6 | left, [4, 3, 58], trees, [9, 3, 61], 4, half, [10, 20, 30]),
        ];
        for (i, corner, kind, low, tree, high, root, fraction, cell) in expected {
            let quads = [0, 1, 2, 3, 4].map(|quad| at(i, quad));
            let [low, high] = [of(low, tree as u32), of(high, root)];
            assert_eq!(quads, [of(corner, kind), low, high, of([0; 3], fraction), of(cell, half)], "instance {i}");
            let entry = if i == 1 { unit } else { 0 };
            let rows = [of([entry, 0, 0], half), of([0, entry, 0], 0), of([0, 0, entry], 0)];
            assert_eq!([5, 6, 7].map(|quad| at(i, quad)), rows, "instance {i}");
        }
        // Materials of the world, in the last word of each of the model's.
        let palette =
            |tree: usize, count: u32| (0..count).map(|i| quad(tree + 2 * i as usize + 1)[3]).collect::<Vec<_>>();
        assert_eq!((palette(trees, 2), palette(second, 4)), (vec![0, 7], vec![0, 7, 14, 21]));
        // The leaf of the first instance has the box of its voxels.
        let leaf = (0..5).map(|node| [quad(2 * node), quad(2 * node + 1)]).find(|[a, b]| b[3] == 3 && a[3] == 0);
        assert_eq!(leaf, Some([of([100, -20, 7], 0), of([103, -20, 12], 3)]));

        let bytes = 4 * words.len() as u64;
        assert!(instances.encode(&[], bytes).is_ok());
        let error = instances.encode(&[], bytes - 1).expect_err("a byte too much");
        assert_eq!(error, LayoutError::TooLarge { layout: "instances", bytes, limit: bytes - 1 });
        // An array without an element is none.
        let none = Instances::default();
        assert_eq!(none.encode(&[], 100).expect("it fits").words(&[]), [0; HEADER_WORDS + QUAD]);
    }
}
