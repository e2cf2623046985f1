//! `tree64.glsl`.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "this is a shader's arithmetic, whose words have 32 bits and wrap"
)]

use raxel_layouts::Tree64Header;
use raxel_ray::{Hit, Ray};

use super::walk::Walk;

const FILLED: u32 = 0x8000_0000;
const UNIFORM: u32 = 0x4000_0000;
const LINKED: u32 = 0x2000_0000;

/// A world buffer of the layout `tree64`.
#[derive(Clone, Copy, Debug)]
pub struct Tree64<'a> {
    header: Tree64Header,
    words: &'a [u32],
}

/// Occupancy of the children of a node.
type Mask = u64;

/// A node of 16³ voxels or more.
#[derive(Clone, Copy, Debug)]
struct Node {
    mask: Mask,
    children: u32,
    material: u32,
}

fn child_of(q: [u32; 3], height: u32) -> u32 {
    let [x, y, z] = q.map(|q| q >> (2 * height - 2) & 3);
    x | z << 2 | y << 4
}

fn has_child(mask: Mask, child: u32) -> bool {
    mask >> child & 1 != 0
}

fn child_rank(mask: Mask, child: u32) -> u32 {
    (mask & ((1 << child) - 1)).count_ones()
}

fn free_octet(mask: Mask, child: u32) -> bool {
    mask >> (child & 0b10_1010) & 0x0033_0033 == 0
}

/// `rx_free_block`.
fn free_block(mask: Mask, child: u32, shift: u32) -> [u32; 3] {
    let one = (1u32 << shift) - 1;
    let (two, four) = (2 * one + 1, 4 * one + 3);
    let layers = (mask >> (child & 32)) as u32;
    if layers == 0 {
        return [four, two, four];
    }
    if (layers >> (child & 16)) as u16 == 0 {
        return [four, one, four];
    }
    [if free_octet(mask, child) { two } else { one }; 3]
}

impl<'a> Tree64<'a> {
    /// Reads a buffer that [`raxel_layouts::Layout::encode`] wrote.
    pub fn new(buffer: &'a [u32]) -> Self {
        let (header, words) = buffer.split_at(Tree64Header::WORDS as usize);
        Self { header: *bytemuck::from_bytes(bytemuck::cast_slice(header)), words }
    }

    fn mask_at(&self, word: usize) -> Mask {
        u64::from(self.words[word]) | u64::from(self.words[word + 1]) << 32
    }

    fn node(&self, at: u32) -> Node {
        let at = 4 * at as usize;
        Node { mask: self.mask_at(at), children: self.words[at + 2], material: self.words[at + 3] }
    }

    fn leaf(&self, leaf: u32) -> Mask {
        self.mask_at(2 * leaf as usize)
    }

    fn leaf_material(&self, material: u32, rank: u32, leaf: Mask, voxel: u32) -> u32 {
        if material & UNIFORM != 0 {
            return material & 0xffff;
        }
        self.linked_material(self.words[(material + rank) as usize], child_rank(leaf, voxel))
    }

    fn filled_material(&self, node: Node, child: u32) -> u32 {
        if node.material & LINKED == 0 {
            return node.material & 0xffff;
        }
        self.linked_material(node.children, child_rank(node.mask, child))
    }

    fn linked_material(&self, link: u32, rank: u32) -> u32 {
        if link & UNIFORM != 0 {
            return link & 0xffff;
        }
        // A palette of 2^(2^kind) materials, two a word, then 2^kind bits for each voxel; with kind 4, the 16 bits are the material.
        let word = |at: u32| self.words[at as usize];
        let (code, at) = (link >> 30 & 2 | link >> 29 & 1, link & 0x1fff_ffff);
        let kind = if code == 3 { 4 } else { code };
        let (bit, bits) = (rank << kind, 1 << kind);
        if kind == 4 {
            return word(at + bit / 32) >> (bit % 32) & 0xffff;
        }
        let index = word(at + (1 << bits >> 1) + bit / 32) >> (bit % 32) & ((1 << bits) - 1);
        word(at + index / 2) >> (16 * (index & 1)) & 0xffff
    }

    /// Material of a voxel, 0 for air: `rx_material`.
    pub fn material(&self, cell: [i32; 3]) -> u32 {
        let c = [0, 1, 2].map(|i| (cell[i] as u32).wrapping_sub(self.header.origin[i] as u32));
        if (c[0] | c[1] | c[2]) >> self.header.log2_size != 0 {
            return 0;
        }
        let mut node = self.node(self.header.root);
        let mut height = self.header.log2_size >> 1;
        loop {
            let child = child_of(c, height);
            if !has_child(node.mask, child) {
                return 0;
            }
            if node.material & FILLED != 0 {
                return self.filled_material(node, child);
            }
            let rank = child_rank(node.mask, child);
            if height == 2 {
                let leaf = self.leaf(node.children + rank);
                let voxel = child_of(c, 1);
                return if has_child(leaf, voxel) { self.leaf_material(node.material, rank, leaf, voxel) } else { 0 };
            }
            node = self.node(node.children + rank);
            height -= 1;
        }
    }

    /// First solid voxel along a ray: `rx_trace`.
    pub fn trace(&self, ray: &Ray) -> Option<Hit> {
        self.trace_from(ray, 0.0)
    }

    /// First solid voxel along a ray that passes only air up to the time `t_free`, in lengths of its direction: `rx_trace_from`.
    pub fn trace_from(&self, ray: &Ray, t_free: f32) -> Option<Hit> {
        let Tree64Header { origin, log2_size, bounds_min, bounds_last, .. } = self.header;
        let mut walk = Walk::begin(ray, origin, log2_size, t_free)?;
        let flip = walk.flip(3);
        let mirror = flip[0] | flip[2] << 2 | flip[1] << 4;

        let [low, high] = [bounds_min, bounds_last].map(|corner| [0, 1, 2].map(|i| corner[i].wrapping_sub(origin[i])));
        let limit = walk.limit(log2_size, low, high);
        let beyond = |q: [u32; 3]| (0..3).any(|i| q[i] > limit[i]);

        let rounds = if log2_size < 30 { 4 << log2_size } else { u32::MAX };
        let mut steps = 0;
        loop {
            if beyond(walk.q) {
                return None;
            }
            let mut height = log2_size >> 1;
            let mut chunk = self.header.root;
            let mut node = self.node(chunk);
            let mut moved = 0;
            let block = loop {
                if steps >= rounds {
                    return None;
                }
                if moved >> (2 * height) != 0 {
                    if beyond(walk.q) || walk.t > walk.t_end {
                        return None;
                    }
                    height = if moved < 64 { 3 } else { log2_size >> 1 };
                    node = self.node(if moved < 64 { chunk } else { self.header.root });
                }

                let mut child = child_of(walk.q, height) ^ mirror;
                let mut occupied = has_child(node.mask, child);
                while occupied && height > 2 && node.material & FILLED == 0 {
                    let at = node.children + child_rank(node.mask, child);
                    if height == 4 {
                        chunk = at;
                    }
                    height -= 1;
                    node = self.node(at);
                    child = child_of(walk.q, height) ^ mirror;
                    occupied = has_child(node.mask, child);
                }
                let (mut mask, mut shift) = (node.mask, 2 * height - 2);
                if occupied {
                    let filled = node.material & FILLED != 0;
                    let (mut rank, mut leaf, mut voxel) = (0, 0, 0);
                    if !filled {
                        rank = child_rank(node.mask, child);
                        leaf = self.leaf(node.children + rank);
                        voxel = child_of(walk.q, 1) ^ mirror;
                    }
                    if filled || has_child(leaf, voxel) {
                        let material = if filled {
                            self.filled_material(node, child)
                        } else {
                            self.leaf_material(node.material, rank, leaf, voxel)
                        };
                        let hit = walk.hit(ray, origin, log2_size)?;
                        return Some(Hit { material, steps: steps + 1, ..hit });
                    }
                    (mask, child, shift) = (leaf, voxel, 0);
                }

                let block = free_block(mask, child, shift);
                let before = walk.q;
                let sure = walk.step(block);
                moved = (before[0] ^ walk.q[0]) | (before[1] ^ walk.q[1]) | (before[2] ^ walk.q[2]);
                steps += 1;
                if !sure {
                    break block;
                }
            };
            walk.settle(ray, origin, log2_size, block);
        }
    }
}
