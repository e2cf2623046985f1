//! Readers of layouts that know only the formats, as the shaders in `shaders/include/raxel/` document them.

use std::collections::BTreeMap;

use raxel_layouts::{Flat64Header, HashedChunksHeader, Tree64Header};
use raxel_rivals::{BrickmapHeader, SvdagHeader, SvoHeader};
use raxel_world::child_cell;

pub(crate) type Voxels = BTreeMap<[i32; 3], u16>;

/// Smallest corner of a cube, in voxels.
pub(crate) type Corner = [i64; 3];

fn split<H: bytemuck::AnyBitPattern>(buffer: &[u32]) -> (H, &[u32]) {
    let (header, words) = buffer.split_at(size_of::<H>() / 4);
    (bytemuck::pod_read_unaligned(bytemuck::cast_slice(header)), words)
}

fn mask64(words: &[u32], at: usize) -> u64 {
    u64::from(words[at]) | u64::from(words[at + 1]) << 32
}

fn half_word(words: &[u32], at: usize) -> u16 {
    (words[at / 2] >> (16 * (at % 2))) as u16
}

/// Numbers of the set bits.
fn bits(mask: u64) -> impl Iterator<Item = u32> {
    (0..64).filter(move |bit| mask >> bit & 1 == 1)
}

/// Corner of an octree child of `size` voxels.
fn octant(corner: Corner, number: u32, size: i64) -> Corner {
    std::array::from_fn(|i| corner[i] + size * i64::from(number >> i & 1))
}

/// Corner of one of 4 x 4 x 4 cells of `size` voxels.
fn cell64(corner: Corner, bit: u32, size: i64) -> Corner {
    let cell = child_cell(bit);
    std::array::from_fn(|i| corner[i] + size * i64::from(cell[i]))
}

fn fill(voxels: &mut Voxels, corner: Corner, size: i64, material: u16) {
    for i in 0..size * size * size {
        let cell = [corner[0] + i % size, corner[1] + i / size % size, corner[2] + i / size / size];
        let cell = cell.map(|c| i32::try_from(c).expect("a coordinate"));
        assert_eq!(voxels.insert(cell, material), None, "{cell:?} twice");
    }
}

/// Entries of the smallest cubes of a hash table, with their corners. Every larger cube must be there too, once.
fn table_entries(
    words: &[u32],
    at: u32,
    log2_slots: u32,
    level: u32,
    log2_size: u32,
    origin: [i32; 3],
) -> Vec<(Corner, u32)> {
    let slots: Vec<&[u32]> =
        words[at as usize..][..4 << log2_slots].chunks(4).filter(|slot| slot[3] != u32::MAX).collect();
    assert!(2 * slots.len() <= 1 << log2_slots, "more than half of the slots are taken");
    let mut cubes: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for slot in &slots {
        cubes.entry(slot[0] >> 27).or_default().push([slot[0] & 0x07ff_ffff, slot[1], slot[2]]);
    }
    let places = cubes.remove(&level).unwrap_or_default();
    for above in (level + 3..log2_size).step_by(3) {
        let mut expected: Vec<[u32; 3]> = places.iter().map(|cell| cell.map(|c| c >> (above - level))).collect();
        expected.sort_unstable();
        expected.dedup();
        let mut found = cubes.remove(&above).unwrap_or_default();
        found.sort_unstable();
        assert_eq!(found, expected, "cubes of 2^{above}");
    }
    assert!(cubes.is_empty(), "{cubes:?}");
    let of_level = slots.iter().filter(|slot| slot[0] >> 27 == level);
    of_level
        .map(|slot| {
            let cell = [slot[0] & 0x07ff_ffff, slot[1], slot[2]];
            (std::array::from_fn(|i| i64::from(origin[i]) + (i64::from(cell[i]) << level)), slot[3])
        })
        .collect()
}

pub(crate) fn tree64(buffer: &[u32]) -> Voxels {
    let (header, words) = split::<Tree64Header>(buffer);
    let mut voxels = Voxels::new();
    let root = std::array::from_fn(|i| words[4 * header.root as usize + i]);
    tree64_node(words, root, header.log2_size / 2, header.origin.map(i64::from), 1, &mut voxels);
    voxels
}

/// Reads a node of height `height` with all that is below it. Cells are cubes of `edge` voxels: 1 in a world, more in a tile of a higher level.
pub(crate) fn tree64_node(words: &[u32], node: [u32; 4], height: u32, corner: Corner, edge: i64, voxels: &mut Voxels) {
    let [.., children, material] = node;
    let [filled, uniform, linked] = [31, 30, 29].map(|bit| material >> bit & 1 == 1);
    let size = 1_i64 << (2 * height - 2);
    for (rank, child) in bits(mask64(&node, 0)).enumerate() {
        let corner = cell64(corner, child, size);
        let first = 4 * (children as usize + rank);
        if filled {
            let material = if linked { linked_material(words, children, rank) } else { material as u16 };
            fill(voxels, corner.map(|c| c / edge), size / edge, material);
        } else if height > 2 {
            tree64_node(words, std::array::from_fn(|i| words[first + i]), height - 1, corner, edge, voxels);
        } else {
            let link = if uniform { material } else { words[material as usize + rank] };
            for (rank, voxel) in bits(mask64(words, 2 * (children as usize + rank))).enumerate() {
                fill(voxels, cell64(corner, voxel, 1), 1, linked_material(words, link, rank));
            }
        }
    }
}

pub(crate) fn chunk_table(buffer: &[u32]) -> Voxels {
    let (header, words) = split::<HashedChunksHeader>(buffer);
    let mut voxels = Voxels::new();
    for (corner, at) in table_entries(words, header.table_at, header.log2_slots, 5, header.log2_size, header.origin) {
        let at = at as usize;
        let mut masks = [0; 8];
        for i in 0..32 * 32 * 32 {
            let material = half_word(words, 2 * (at + 16) + i);
            if material != 0 {
                let local = [i & 31, i >> 5 & 31, i >> 10];
                let node = local.map(|c| c >> 4);
                let block = local.map(|c| c >> 2 & 3);
                masks[node[0] | node[1] << 1 | node[2] << 2] |= 1 << (block[0] | block[2] << 2 | block[1] << 4);
                fill(&mut voxels, std::array::from_fn(|i| corner[i] + local[i] as i64), 1, material);
            }
        }
        for (node, mask) in masks.into_iter().enumerate() {
            assert_eq!(mask64(words, at + 2 * node), mask, "mask {node} of the chunk at {corner:?}");
        }
    }
    voxels
}

pub(crate) fn octree(buffer: &[u32]) -> Voxels {
    let (header, words) = split::<HashedChunksHeader>(buffer);
    let mut voxels = Voxels::new();
    for (corner, at) in table_entries(words, header.table_at, header.log2_slots, 5, header.log2_size, header.origin) {
        octree_node(&words[at as usize..], 0, 0, corner, &mut voxels);
    }
    voxels
}

/// Reads every node of a chunk, those in filled ones too; gives its material and whether all of it is solid.
fn octree_node(nodes: &[u32], depth: u32, index: usize, corner: Corner, voxels: &mut Voxels) -> u32 {
    let first = (0..depth).map(|d| 8usize.pow(d)).sum::<usize>();
    let node = nodes[first + index];
    if depth == 5 {
        if node != 0 {
            assert_eq!(node & 0xffff, 0x1ff);
            fill(voxels, corner, 1, (node >> 16) as u16);
        }
        return node;
    }
    if node == 0 {
        for below in depth + 1..=5 {
            let first = (0..below).map(|d| 8usize.pow(d)).sum::<usize>();
            let count = 8usize.pow(below - depth);
            assert!(nodes[first + index * count..][..count].iter().all(|node| *node == 0), "below an empty node");
        }
        return 0;
    }
    let children: [u32; 8] = std::array::from_fn(|n| {
        octree_node(nodes, depth + 1, 8 * index + n, octant(corner, n as u32, 16 >> depth), voxels)
    });
    let mask = (0..8).filter(|&n| children[n] != 0).fold(0, |mask, n| mask | 1 << n);
    let alike = children.iter().all(|child| *child == children[0] && child >> 8 & 1 == 1);
    let material = children.iter().find(|child| **child != 0).map_or(0, |child| child >> 16);
    assert_eq!(node, material << 16 | u32::from(alike) << 8 | mask, "depth {depth}, node {index}");
    node
}

pub(crate) fn brickmap(buffer: &[u32]) -> Voxels {
    let (header, words) = split::<BrickmapHeader>(buffer);
    let mut voxels = Voxels::new();
    let sectors = if header.log2_slots == 0 {
        brickmap_grid(&header, words)
    } else {
        table_entries(words, header.table_at, header.log2_slots, 6, header.log2_size, header.origin)
    };
    for (corner, at) in sectors {
        for number in 0..8 {
            let at = at as usize + 3 * number as usize;
            for (rank, bit) in bits(mask64(words, at)).enumerate() {
                let brick = words[at + 2] as usize + 17 * rank;
                let corner = cell64(octant(corner, number, 32), bit, 8);
                brickmap_brick(words, brick, corner, &mut voxels);
            }
        }
    }
    voxels
}

fn brickmap_brick(words: &[u32], brick: usize, corner: Corner, voxels: &mut Voxels) {
    let link = words[brick + 16];
    let mut rank = 0;
    for tile in 0..8 {
        for bit in bits(mask64(words, brick + 2 * tile)) {
            let material = if link >> 31 == 1 { link as u16 } else { half_word(words, link as usize + rank) };
            fill(voxels, cell64(octant(corner, tile as u32, 4), bit, 1), 1, material);
            rank += 1;
        }
    }
    assert!(rank > 0, "an empty brick at {corner:?}");
}

/// The sectors of a grid; its claims about empty space must be true, and as strong as possible.
fn brickmap_grid(header: &BrickmapHeader, words: &[u32]) -> Vec<(Corner, u32)> {
    let cell = |corner: [i32; 3]| [0, 1, 2].map(|i| (i64::from(corner[i]) - i64::from(header.origin[i])) >> 6);
    if header.bounds_last[0] < header.bounds_min[0] {
        assert_eq!(words[header.table_at as usize] >> 31, 1);
        return Vec::new();
    }
    let (first, last) = (cell(header.bounds_min), cell(header.bounds_last));
    let size = [0, 1, 2].map(|i| last[i] - first[i] + 1);
    let cells = (0..size[0] * size[1] * size[2]).map(|i| {
        let local = [i % size[0], i / size[0] % size[1], i / size[0] / size[1]];
        ([0, 1, 2].map(|a| first[a] + local[a]), words[(i64::from(header.table_at) + i) as usize])
    });
    let cells: Vec<([i64; 3], u32)> = cells.collect();
    let sectors: Vec<[i64; 3]> = cells.iter().filter(|(_, word)| word >> 31 == 0).map(|(cell, _)| *cell).collect();
    let free = |cell: [i64; 3], log2: u32| {
        let cube = |cell: [i64; 3]| cell.map(|c| c >> (log2 - 6));
        sectors.iter().all(|sector| cube(*sector) != cube(cell))
    };
    for &(cell, word) in cells.iter().filter(|(_, word)| word >> 31 == 1) {
        let log2 = word & 0x7fff_ffff;
        assert!(free(cell, log2), "{cell:?} says that 2^{log2} voxels are empty");
        assert!(log2 + 1 >= header.log2_size || !free(cell, log2 + 1), "{cell:?} could say 2^{}", log2 + 1);
    }
    let corner = |cell: [i64; 3]| std::array::from_fn(|i| i64::from(header.origin[i]) + 64 * cell[i]);
    cells.into_iter().filter(|(_, word)| word >> 31 == 0).map(|(cell, word)| (corner(cell), word)).collect()
}

pub(crate) fn svo(buffer: &[u32]) -> Voxels {
    let (header, words) = split::<SvoHeader>(buffer);
    let mut voxels = Voxels::new();
    let mut upper = vec![(header.root as usize, header.log2_size, header.origin.map(i64::from))];
    while let Some((at, height, corner)) = upper.pop() {
        let [node, link] = [words[at], words[at + 1]];
        if height == 6 {
            svo_node(words, link as usize, node, 6, corner, &mut voxels);
            continue;
        }
        assert!(node < 256, "{node:#x} above chunks");
        for (rank, child) in bits(u64::from(node)).enumerate() {
            upper.push((link as usize + 2 * rank, height - 1, octant(corner, child, 1 << (height - 1))));
        }
    }
    voxels
}

fn svo_node(words: &[u32], chunk: usize, node: u32, height: u32, corner: Corner, voxels: &mut Voxels) {
    let size = 1 << (height - 1);
    for (rank, child) in bits(u64::from(node & 0xff)).enumerate() {
        let corner = octant(corner, child, size);
        let at = (node >> 9) as usize + rank;
        if node >> 8 & 1 == 1 {
            fill(voxels, corner, size, (node >> 16) as u16);
        } else if height == 1 {
            fill(voxels, corner, 1, half_word(words, 2 * chunk + at));
        } else {
            assert_ne!(words[chunk + at] & 0xff, 0, "an empty node is stored");
            svo_node(words, chunk, words[chunk + at], height - 1, corner, voxels);
        }
    }
}

pub(crate) fn svdag(buffer: &[u32]) -> Voxels {
    let (header, words) = split::<SvdagHeader>(buffer);
    let mut voxels = Voxels::new();
    let mut upper = vec![(header.root as usize, header.log2_size, header.origin.map(i64::from))];
    while let Some((at, height, corner)) = upper.pop() {
        if height > 6 {
            for (rank, child) in bits(u64::from(words[at])).enumerate() {
                upper.push((words[at + 1 + rank] as usize, height - 1, octant(corner, child, 1 << (height - 1))));
            }
            continue;
        }
        let mut found = Vec::new();
        svdag_node(words, words[at] as usize, 6, corner, &mut found);
        let attributes = &words[header.attributes_at as usize..];
        for (number, corner) in found.into_iter().enumerate() {
            fill(&mut voxels, corner, 1, svdag_material(attributes, words[at + 1], number));
        }
    }
    voxels
}

/// The voxels of a subtree in order; the node's own number of them must be right.
fn svdag_node(words: &[u32], at: usize, height: u32, corner: Corner, found: &mut Vec<Corner>) {
    if height == 2 {
        found.extend(bits(mask64(words, at)).map(|bit| cell64(corner, bit, 1)));
        return;
    }
    let before = found.len();
    for (rank, child) in bits(u64::from(words[at] & 0xff)).enumerate() {
        svdag_node(words, words[at + 1 + rank] as usize, height - 1, octant(corner, child, 1 << (height - 1)), found);
    }
    assert_eq!((words[at] >> 8) as usize, found.len() - before, "voxels of the node at word {at}");
}

fn svdag_material(attributes: &[u32], link: u32, number: usize) -> u16 {
    if link >> 31 == 1 {
        return link as u16;
    }
    let block = attributes[link as usize + number / 64];
    match block >> 28 {
        8.. => block as u16,
        kind => packed_material(attributes, (block & 0x0fff_ffff) as usize, kind, number % 64),
    }
}

/// The material of one of the voxels that are packed from a word on.
fn packed_material(words: &[u32], at: usize, kind: u32, number: usize) -> u16 {
    let index = |at: usize| {
        let bit = number << kind;
        words[at + bit / 32] >> (bit % 32) & ((1 << (1 << kind)) - 1)
    };
    match kind {
        4 => index(at) as u16,
        0 => half_word(words, 2 * at + index(at + 1) as usize),
        1 => half_word(words, 2 * at + index(at + 2) as usize),
        2 => half_word(words, 2 * at + index(at + 8) as usize),
        kind => panic!("voxels are packed by kind {kind}"),
    }
}

/// The material of a voxel of a leaf, by the leaf's link.
pub(crate) fn linked_material(words: &[u32], link: u32, rank: usize) -> u16 {
    let [uniform, low, high] = [30, 29, 31].map(|bit| link >> bit & 1);
    let kind = [0, 1, 2, 4][(2 * high + low) as usize];
    if uniform == 1 { link as u16 } else { packed_material(words, (link & 0x1fff_ffff) as usize, kind, rank) }
}

/// A record of the layout `flat64` with its block of 16³, counted from the corner of the cube.
type Record = (Corner, [u32; 4]);

fn flat64_records(buffer: &[u32]) -> (Flat64Header, &[u32], Vec<Record>) {
    let (header, words) = split::<Flat64Header>(buffer);
    let last =
        |axis: usize| i64::from(header.bounds_last[axis].max(header.origin[axis])) - i64::from(header.origin[axis]);
    let size = [0, 1, 2].map(|axis| (last(axis) >> 4) + 1);
    let (along_z, along_y) = (i64::from(header.strides & 0xffff), i64::from(header.strides >> 16));
    let mut records = Vec::new();
    for (y, z) in (0..size[1]).flat_map(|y| (0..size[2]).map(move |z| (y, z))) {
        for x in 0..size[0] {
            let at = 4 * (i64::from(header.records_at) + x + along_z * z + along_y * y) as usize;
            records.push(([x, y, z], std::array::from_fn(|i| words[at + i])));
        }
    }
    (header, words, records)
}

/// The blocks of 16³ with their radii.
pub(crate) fn flat64_radii(buffer: &[u32]) -> Vec<([i64; 3], u32)> {
    flat64_records(buffer).2.into_iter().map(|(block, record)| (block, record[3])).collect()
}

pub(crate) fn flat64(buffer: &[u32]) -> Voxels {
    let (header, words, records) = flat64_records(buffer);
    let mut voxels = Voxels::new();
    for (block, record) in records {
        let corner = std::array::from_fn(|i| i64::from(header.origin[i]) + 16 * block[i]);
        for (rank, bit) in bits(mask64(&record, 0)).enumerate() {
            let leaf = record[2].wrapping_add(1 + rank as u32);
            let link = words[(header.links_at + leaf - header.leaves_at) as usize];
            for (rank, voxel) in bits(mask64(words, 2 * leaf as usize)).enumerate() {
                let material = linked_material(words, link, rank);
                fill(&mut voxels, cell64(cell64(corner, bit, 4), voxel, 1), 1, material);
            }
        }
    }
    voxels
}
