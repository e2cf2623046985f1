//! The graph above the chunks. Its leaves are instances: a chunk's geometry with a chunk's materials. Equal subtrees are one here
//! too, and equal means that the materials are equal as well.

use std::collections::HashMap;

use raxel_layouts::parts::octree_path;

/// Words of an instance: its topmost node, its materials.
const INSTANCE_WORDS: usize = 2;
/// Materials of nothing.
const NO_MATERIALS: u32 = 0x8000_0000;

/// Word of an instance's topmost node from the first node, and its link to materials.
type Instance = (u32, u32);

/// Children by octree child number, as indices of the level below.
type Node = Vec<(u8, u32)>;

/// The different subtrees above chunks.
pub(super) struct Upper {
    instances: Vec<Instance>,
    /// Levels of nodes from just above the chunks to the root.
    levels: Vec<Vec<Node>>,
}

impl Upper {
    /// From every chunk's cell in a cube of 2^`height` chunks a side.
    pub(crate) fn of(uses: impl Iterator<Item = ([u32; 3], Instance)>, height: u32) -> Self {
        let mut uses: Vec<(u128, Instance)> = uses.map(|(cell, instance)| (octree_path(cell), instance)).collect();
        uses.sort_unstable();
        let (instances, mut below) = distinct(uses);
        let mut levels = Vec::new();
        for _ in 0..height {
            let mut nodes: Vec<(u128, Node)> = Vec::new();
            for (path, child) in below {
                if nodes.last().is_none_or(|(parent, _)| *parent != path >> 3) {
                    nodes.push((path >> 3, Vec::new()));
                }
                if let Some((_, children)) = nodes.last_mut() {
                    children.push(((path & 7) as u8, child));
                }
            }
            let (level, ids) = distinct(nodes);
            levels.push(level);
            below = ids;
        }
        // An empty world has an empty root.
        match levels.last_mut() {
            Some(top) if top.is_empty() => top.push(Vec::new()),
            _ => {}
        }
        let instances = if instances.is_empty() { vec![(0, NO_MATERIALS)] } else { instances };
        Self { instances, levels }
    }

    pub(crate) fn instances(&self) -> usize {
        self.instances.len()
    }

    pub(crate) fn words(&self) -> usize {
        let nodes = self.levels.iter().flatten().map(|children| 1 + children.len());
        nodes.sum::<usize>() + INSTANCE_WORDS * self.instances.len()
    }

    /// Writes everything, the root first. `at` is the address of the words, `geometry_at` that of the first node inside chunks.
    pub(crate) fn write(&self, words: &mut [u32], at: usize, geometry_at: usize) {
        let mut next = 0;
        let mut places: Vec<Vec<u32>> = vec![Vec::new(); self.levels.len()];
        for (level, places) in self.levels.iter().zip(&mut places).rev() {
            for node in level {
                places.push((at + next) as u32);
                next += 1 + node.len();
            }
        }
        let instances_at = next;
        for (level, nodes) in self.levels.iter().enumerate() {
            for (node, &place) in nodes.iter().zip(&places[level]) {
                let words = &mut words[place as usize - at..];
                words[0] = node.iter().fold(0, |mask, (number, _)| mask | 1 << number);
                for (word, &(_, child)) in words[1..].iter_mut().zip(node) {
                    *word = match level {
                        0 => (at + instances_at + INSTANCE_WORDS * child as usize) as u32,
                        _ => places[level - 1][child as usize],
                    };
                }
            }
        }
        for (words, &(node, materials)) in words[instances_at..].chunks_exact_mut(INSTANCE_WORDS).zip(&self.instances) {
            words.copy_from_slice(&[geometry_at as u32 + node, materials]);
        }
    }
}

/// The different values in the order of their first use, and the index of each one's.
fn distinct<T: Clone + Eq + std::hash::Hash>(values: Vec<(u128, T)>) -> (Vec<T>, Vec<(u128, u32)>) {
    let mut known: HashMap<T, u32> = HashMap::new();
    let mut different = Vec::new();
    let ids = values.into_iter().map(|(path, value)| {
        let id = *known.entry(value).or_insert_with_key(|value| {
            different.push(value.clone());
            different.len() as u32 - 1
        });
        (path, id)
    });
    let ids = ids.collect();
    (different, ids)
}
