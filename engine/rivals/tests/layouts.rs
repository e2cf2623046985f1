//! Encodings hold exactly the world's voxels, in the documented format and size, or say why they cannot.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod decode;
#[path = "layouts/follow.rs"]
mod follow;
#[path = "layouts/tiles.rs"]
mod tiles;

use decode::Voxels;
use glam::IVec3;
use proptest::prelude::*;
use raxel_layouts::{Encoded, Layout, LayoutError, MATERIAL_WORDS, Tree64Header};
use raxel_rivals::{BvhHeader, ChunksHeader, LAYOUTS};
use raxel_world::{Material, World, child_cell};

fn palette(count: usize) -> Vec<Material> {
    let mut palette = vec![Material::air()];
    palette.extend((0..count).map(|i| Material::matt(format!("m{i}"), [i as f32 / 256.0; 3])));
    palette
}

fn world(voxels: &Voxels, materials: usize) -> World {
    World::from_voxels(palette(materials), voxels.iter().map(|(cell, material)| (IVec3::from_array(*cell), *material)))
}

fn encode(layout: Layout, world: &World) -> Encoded {
    layout.encode(world, u64::MAX).expect("it fits")
}

/// Every voxel of a list of chunks, by its format alone.
fn chunks_voxels(buffer: &[u32]) -> Voxels {
    let (header, words) = buffer.split_at(ChunksHeader::WORDS as usize);
    let header: &ChunksHeader = bytemuck::from_bytes(bytemuck::cast_slice(header));
    let mut voxels = Voxels::new();
    let count = header.chunk_count as usize;
    for entry in words[header.chunks_at as usize + count..][..4 * count].chunks(4) {
        for i in 0..32 * 32 * 32 {
            let material = (words[entry[3] as usize + i / 2] >> (16 * (i % 2))) as u16;
            if material != 0 {
                let local = [i % 32, i / 32 % 32, i / 1024];
                voxels.insert(std::array::from_fn(|a| entry[a] as i32 * 32 + local[a] as i32), material);
            }
        }
    }
    voxels
}

/// Every voxel of a tree of boxes, by its format alone; each lies in the boxes above it.
fn bvh_voxels(buffer: &[u32]) -> Voxels {
    let (header, words) = buffer.split_at(BvhHeader::WORDS as usize);
    let header: &BvhHeader = bytemuck::from_bytes(bytemuck::cast_slice(header));
    let mut voxels = Voxels::new();
    let mut nodes = 0;
    let mut blocks = 0;
    let mut todo = vec![(header.nodes_at as usize, [0; 3], [u32::MAX; 3], 1)];
    while let Some((at, low, last, depth)) = todo.pop() {
        assert!(depth <= 32, "deeper than the shader's stack");
        nodes += 1;
        let node = &words[at..at + 8];
        let within = |corner: &[u32]| (0..3).all(|i| (low[i]..=last[i]).contains(&corner[i]));
        assert!(within(&node[..3]) && within(&node[4..7]), "{node:?} in {low:?} to {last:?}");
        let (low, last): ([u32; 3], [u32; 3]) = (node[..3].try_into().unwrap(), node[4..7].try_into().unwrap());
        if node[7] & 3 != 3 {
            todo.extend([(at + 8, low, last, depth + 1), (node[3] as usize, low, last, depth + 1)]);
            continue;
        }
        for block in words[node[3] as usize..][..6 * (node[7] >> 2) as usize].chunks(6) {
            blocks += 1;
            let mask = u64::from(block[3]) | u64::from(block[4]) << 32;
            for (rank, bit) in (0..64).filter(|bit| mask >> bit & 1 == 1).enumerate() {
                let cell: [u32; 3] = std::array::from_fn(|i| block[i] + child_cell(bit)[i]);
                assert!((0..3).all(|i| (low[i]..=last[i]).contains(&cell[i])), "{cell:?} in {low:?} to {last:?}");
                let half = block[5] as usize + rank;
                let uniform = block[5] >> 31 == 1;
                let material = if uniform { block[5] as u16 } else { (words[half / 2] >> (16 * (half % 2))) as u16 };
                voxels.insert(
                    std::array::from_fn(|i| (i64::from(header.origin[i]) + i64::from(cell[i])) as i32),
                    material,
                );
            }
        }
    }
    assert_eq!([nodes, blocks], [header.node_count, header.block_count]);
    voxels
}

fn voxels_of(layout: Layout, encoded: &Encoded) -> Voxels {
    match layout.name() {
        "tree64" => decode::tree64(&encoded.words),
        "chunks" => chunks_voxels(&encoded.words),
        "bvh" => bvh_voxels(&encoded.words),
        "chunk_table" => decode::chunk_table(&encoded.words),
        "brickmap" => decode::brickmap(&encoded.words),
        "octree" => decode::octree(&encoded.words),
        "svo" => decode::svo(&encoded.words),
        "svdag" => decode::svdag(&encoded.words),
        "flat64" => decode::flat64(&encoded.words),
        "texture3d" => unreachable!("tests/texture3d.rs reads its image"),
        name => panic!("a decoder of `{name}`"),
    }
}

/// The layouts that hold worlds of any width.
fn sparse() -> impl Iterator<Item = Layout> {
    LAYOUTS.iter().copied().filter(|layout| !layout.has_image())
}

/// Whether the world lies in the layout's window, if it has one.
fn fits(layout: Layout, world: &World) -> bool {
    let (Some(window), Some(bounds)) = (layout.window(), world.bounds()) else { return true };
    (0..3).all(|axis| bounds.max[axis] - (bounds.min[axis] & !63) <= window[axis] as i64)
}

fn check(voxels: &Voxels, materials: usize) {
    let world = world(voxels, materials);
    for layout in sparse() {
        if !fits(layout, &world) {
            assert!(matches!(layout.encode(&world, u64::MAX), Err(LayoutError::TooWide { .. })), "{}", layout.name());
            continue;
        }
        let encoded = encode(layout, &world);
        assert!(&voxels_of(layout, &encoded) == voxels, "{}", layout.name());
        assert_eq!(encoded.geometry_bytes + encoded.attribute_bytes, 4 * encoded.words.len() as u64);
    }
}

fn filled(corner: [i32; 3], size: [i32; 3], material: impl Fn([i32; 3]) -> u16) -> Voxels {
    let cells = (0..size[0] * size[1] * size[2]).map(|i| [i % size[0], i / size[0] % size[1], i / size[0] / size[1]]);
    cells.map(|c| (std::array::from_fn(|a| corner[a] + c[a]), material(c))).collect()
}

#[test]
fn full_and_mixed_blocks_keep_their_materials() {
    check(&filled([0; 3], [64; 3], |_| 2), 3);
    check(&filled([0; 3], [16; 3], |_| 2), 3);
    check(&filled([-16; 3], [48; 3], |c| 1 + (c[0] / 16) as u16), 3);
    check(&filled([60, 0, -3], [9, 20, 70], |c| 1 + ((c[0] * 7 + c[1] * 3 + c[2]) % 5) as u16), 5);
    check(&filled([0; 3], [20; 3], |c| 1 + (c[0] * 400 + c[1] * 20 + c[2]) as u16), 8000);
}

#[test]
fn the_ends_of_the_coordinates_are_kept() {
    for corner in [[i32::MIN; 3], [i32::MAX - 2; 3], [i32::MIN, 0, i32::MAX - 2]] {
        let voxels = filled(corner, [3; 3], |_| 1);
        check(&voxels, 1);
        for layout in sparse() {
            let words = encode(layout, &world(&voxels, 1)).words;
            // The cube ends where the coordinates do, or before.
            let ends = |i: usize| i64::from(words[i].cast_signed()) + (1 << words[3]);
            assert!((0..3).all(|i| ends(i) <= 1 << 31), "{}", layout.name());
        }
    }
    check(&Voxels::from([([-(1 << 29); 3], 1), ([(1 << 29) - 1; 3], 1)]), 1);
}

#[test]
fn an_empty_world_is_encoded() {
    check(&Voxels::new(), 0);
    for &layout in LAYOUTS {
        let empty = World::empty();
        for encoded in [layout.encode(&empty, u64::MAX), layout.encode_writable(&empty, u64::MAX)] {
            let words = encoded.expect("it fits").words;
            assert_eq!(words[..4], [0, 0, 0, 6], "{}", layout.name());
            let is_solid = (4..7).all(|i| words[i].cast_signed() <= words[i + 4].cast_signed());
            // An image has room that a copy may fill.
            assert!(!is_solid || layout.has_image(), "{}", layout.name());
        }
    }
    let words = encode(Layout::TREE64, &World::empty()).words;
    // The empty root.
    assert_eq!(words.len() as u32, Tree64Header::WORDS + MATERIAL_WORDS + 4);
}

#[test]
fn materials_stand_where_the_header_says() {
    let world = world(&filled([0; 3], [2; 3], |_| 3), 3);
    for &layout in LAYOUTS {
        let words = encode(layout, &world).words;
        let last = (Tree64Header::WORDS + 3 * MATERIAL_WORDS) as usize;
        assert_eq!(words[last], world.materials()[3].albedo[0].to_bits(), "{}", layout.name());
        assert_eq!(words[last + 3], 1.0f32.to_bits(), "{}", layout.name());
    }
}

#[test]
fn what_does_not_fit_is_said_before_it_is_made() {
    let small = world(&filled([0; 3], [3; 3], |_| 1), 1);
    for &layout in LAYOUTS {
        let bytes = 4 * encode(layout, &small).words.len() as u64;
        assert_eq!(layout.encode(&small, bytes).map(|encoded| encoded.words.len() as u64 * 4), Ok(bytes));
        let error = layout.encode(&small, bytes - 1).expect_err("it is one byte too large");
        assert_eq!(error, LayoutError::TooLarge { layout: layout.name(), bytes, limit: bytes - 1 });
        let text = error.to_string();
        assert!(text.contains(&bytes.to_string()) && text.contains(&(bytes - 1).to_string()), "{text}");
    }
    let wide = world(&Voxels::from([([-(1 << 29) - 1, 0, 0], 1), ([1 << 29, 0, 0], 1)]), 1);
    for &layout in LAYOUTS {
        assert!(matches!(layout.encode(&wide, u64::MAX), Err(LayoutError::TooWide { limit: 0x4000_0000, .. })));
    }
}

#[test]
fn addresses_of_32_bits_reach_every_word_of_the_largest_buffer() {
    assert_eq!(raxel_layouts::ADDRESSABLE, 4 * (u64::from(u32::MAX) + 1));
}

#[test]
fn equal_chunks_are_stored_once() {
    let one = filled([5; 3], [30; 3], |c| 1 + (c[0] & 1) as u16);
    let mut many = Voxels::new();
    for i in 0..8 {
        many.extend(one.iter().map(|(cell, material)| ([cell[0] + 64 * i, cell[1], cell[2]], *material)));
    }
    check(&many, 2);
    // A tree of boxes holds the place of every block, and a grid has a record for every place.
    for &layout in LAYOUTS.iter().filter(|layout| ![raxel_rivals::BVH, Layout::FLAT64].contains(layout)) {
        let sizes = [&one, &many].map(|voxels| encode(layout, &world(voxels, 2)).words.len());
        assert!(sizes[1] < sizes[0] + 1024, "{}: {sizes:?}", layout.name());
    }
}

/// A free radius promises that many empty blocks, in every direction of its octant, and is as large as it can be.
#[test]
fn free_radii_are_exact() {
    let mut voxels = Voxels::new();
    for i in 0..60i32 {
        voxels.insert([(i * 37) % 500 - 100, (i * 53) % 300, (i * 91) % 400 + 9], 1);
    }
    let world = world(&voxels, 1);
    let words = encode(Layout::FLAT64, &world).words;
    let corner = world.bounds().unwrap().min.map(|min| min & !63);
    let occupied: std::collections::HashSet<[i64; 3]> =
        voxels.keys().map(|cell| std::array::from_fn(|i| (i64::from(cell[i]) - corner[i]) >> 4)).collect();
    let mut radii_found = [0; 16];
    for (block, radii) in decode::flat64_radii(&words) {
        for octant in 0..8 {
            // How far the nearest occupied block ahead is, in the largest of its three distances.
            let ahead = |axis: usize, at: i64| (at - block[axis]) * if octant >> axis & 1 == 1 { -1 } else { 1 };
            let distances = occupied.iter().map(|at| [0, 1, 2].map(|axis| ahead(axis, at[axis])));
            let nearest = distances.filter(|ahead| *ahead != [0; 3] && ahead.iter().all(|d| *d >= 0));
            let nearest = nearest.filter_map(|ahead| ahead.into_iter().max()).min().unwrap_or(16);
            let radius = radii >> (4 * octant) & 15;
            assert_eq!(i64::from(radius), (nearest - 1).min(15), "{block:?} {octant}");
            radii_found[radius as usize] += 1;
        }
    }
    assert!(radii_found[0] > 0 && radii_found[3] > 0, "{radii_found:?}");
}

/// For each octant of directions: what brings a cell of the world, inverted on axes that its rays go down, to the bits of a cell of the window; the bits of
/// the first and the last cell that are solid, in the order in which its rays go.
#[test]
fn octants_say_where_rays_begin_and_end() {
    let world = world(&Voxels::from([([-70, 5, 300], 1), ([200, 130, 301], 1)]), 1);
    let bounds = world.bounds().expect("two voxels");
    let words = encode(Layout::FLAT64, &world).words;
    let at = (raxel_layouts::Flat64Header::WORDS + 2 * MATERIAL_WORDS) as usize;
    for octant in 0..8 {
        let quads = &words[at + 12 * octant..][..12];
        let down = |axis: usize| octant >> axis & 1 == 1;
        for axis in 0..3 {
            let side = [2048, 1024, 2048][axis];
            let [min, last] = [bounds.min[axis], bounds.max[axis] - 1];
            let origin = i64::from(words[axis].cast_signed());
            let (first, last) = if down(axis) { (last, min) } else { (min, last) };
            for (cell, bits) in [(first, quads[4 + axis]), (last, quads[8 + axis])] {
                let (inverted, local) =
                    if down(axis) { (!cell, side - 1 - (cell - origin)) } else { (cell, cell - origin) };
                assert_eq!(bits, 0x4b40_2000 + local as u32, "{octant} {axis}");
                assert_eq!(bits, quads[axis].wrapping_add(inverted as u32), "{octant} {axis}");
            }
        }
        let field = |axis: usize, bits: u32| if down(axis) { bits } else { 0 };
        assert_eq!(quads[3], field(0, 2047) | field(2, 2047 << 11) | field(1, 1023 << 22), "{octant}");
    }
}

#[test]
fn geometry_is_shared_by_what_is_made_of_other_materials() {
    let one = filled([3; 3], [40; 3], |c| 1 + ((c[0] + 2 * c[1] + 3 * c[2]) % 3) as u16);
    let mut many = Voxels::new();
    for i in 0..8 {
        many.extend(one.iter().map(|(cell, material)| ([cell[0] + 64 * i, cell[1], cell[2]], material + i as u16)));
    }
    check(&many, 10);
    let bytes = [&one, &many].map(|voxels| encode(raxel_rivals::SVDAG, &world(voxels, 10)).geometry_bytes);
    assert!(bytes[1] < bytes[0] + 8 * 16, "{bytes:?}");
}

/// Bytes of places do not depend on materials, and bytes of materials are the palette and what each layout says about one material.
#[test]
fn bytes_of_places_and_of_materials_are_told_apart() {
    // No block, node or brick is full.
    let mut one = filled([0; 3], [40; 3], |_| 1);
    one.retain(|[x, y, z], _| (7 * x + 3 * y + z) % 5 == 0);
    let many = one.keys().map(|cell| (*cell, 1 + (cell[0] + 2 * cell[1] + cell[2]) as u16 % 7)).collect();
    let cubes =
        |edge: i32| one.keys().map(|cell| cell.map(|c| c / edge)).collect::<std::collections::HashSet<_>>().len();
    let palette = u64::from(4 * MATERIAL_WORDS) * 8;
    for &layout in LAYOUTS {
        let [one, many] = [&one, &many].map(|voxels| encode(layout, &world(voxels, 7)));
        assert_eq!(one.geometry_bytes, many.geometry_bytes, "{}", layout.name());
        let of_material = match layout.name() {
            // A link for each leaf, and for each brick.
            "flat64" => 4 * cubes(4) as u64,
            "brickmap" => 4 * cubes(8) as u64,
            // A word of the only instance.
            "svdag" => 4,
            _ => 0,
        };
        // tree64 and flat64 end with a whole quad.
        let room = if [Layout::TREE64, Layout::FLAT64].contains(&layout) { 12 } else { 0 };
        let least = palette + of_material;
        assert!((least..=least + room).contains(&one.attribute_bytes), "{}: {}", layout.name(), one.attribute_bytes);
    }
}

/// The goal for shells of gentle terrain: at most 0.31 bytes a voxel say where it is.
#[test]
fn a_shell_of_terrain_is_small() {
    let mut shell = Voxels::new();
    for (x, z) in (0..192).flat_map(|x| (0..192).map(move |z| (x, z))) {
        let (u, v) = (x as f32 / 160.0, z as f32 / 140.0);
        let top = 60.0 + 30.0 * u.sin() * v.cos() + 4.0 * (3.1 * u + v).sin();
        for y in top as i32 - 8..=top as i32 {
            shell.insert([x, y, z], if y == top as i32 { 1 } else { 2 });
        }
    }
    let world = world(&shell, 2);
    let encoded = encode(Layout::TREE64, &world);
    let a_voxel = encoded.geometry_bytes as f64 / world.solids() as f64;
    assert!(a_voxel < 0.31, "{a_voxel} bytes a voxel");
}

#[test]
fn blocks_are_the_rust_headers() {
    for &layout in LAYOUTS {
        assert_eq!(raxel_rivals::layout(layout.name()), Some(layout));
        let block = layout.block();
        let array = block.last().expect("members");
        let elements = if [Layout::TREE64, Layout::FLAT64].contains(&layout) {
            ("quads", "uvec4", 16)
        } else {
            ("words", "uint", 4)
        };
        assert_eq!((array.name, array.ty, array.stride), (elements.0, elements.1, Some(elements.2)));
        // std430: every member at its alignment, and none overlaps the next.
        for pair in block.windows(2) {
            let (align, size) = if pair[0].ty == "ivec3" { (16, 12) } else { (4, 4) };
            assert_eq!(pair[0].offset % align, 0, "{:?}", pair[0]);
            assert!(pair[0].offset + size <= pair[1].offset, "{pair:?}");
        }
    }
    assert_eq!(raxel_rivals::layout("octtree"), None);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn random_worlds_are_kept(
        boxes in prop::collection::vec((prop::array::uniform3(-90i32..90), prop::array::uniform3(1i32..24), 1u16..6), 1..12),
    ) {
        let mut voxels = Voxels::new();
        for (corner, size, material) in boxes {
            voxels.extend(filled(corner, size, |_| material));
        }
        check(&voxels, 6);
    }
}

/// A writable copy shares no chunk: it is as large as a world whose chunks all differ, and its bounds hold every voxel of its chunks.
#[test]
fn writable_copies_have_every_chunk_for_themselves() {
    let voxels = |x: i32| (0..3).map(move |i| (IVec3::new(x + 5, 7 + i, 9), 1));
    let world = World::from_voxels(palette(1), (0..4).flat_map(|chunk| voxels(64 * chunk)));
    for layout in [raxel_rivals::CHUNKS, raxel_rivals::CHUNK_TABLE, Layout::OCTREE] {
        assert!(layout.has_set());
        let shared = layout.encode(&world, u64::MAX).unwrap().words;
        let copy = layout.encode_writable(&world, u64::MAX).unwrap();
        let kept: Voxels =
            (0..4).flat_map(|chunk| voxels(64 * chunk)).map(|(cell, material)| (cell.to_array(), material)).collect();
        assert_eq!(voxels_of(layout, &copy), kept, "{}", layout.name());
        let copy = copy.words;
        let chunk = if layout == Layout::OCTREE { 37_449 } else { 16_384 };
        assert!(
            copy.len() >= shared.len() + 3 * chunk,
            "{}: {} words, {} shared",
            layout.name(),
            copy.len(),
            shared.len()
        );
        // bounds_min and bounds_last of the header.
        let box_of = |words: &[u32]| [4, 5, 6, 8, 9, 10].map(|word| words[word] as i32);
        assert_eq!(box_of(&shared), [5, 7, 9, 197, 9, 9], "{}", layout.name());
        assert_eq!(box_of(&copy), [0, 0, 0, 223, 31, 31], "{}", layout.name());
        // The limit is held against what the copy takes.
        let limit = 4 * shared.len() as u64;
        assert!(layout.encode(&world, limit).is_ok() && layout.encode_writable(&world, limit).is_err());
    }
    let copy = raxel_rivals::TEXTURE3D.encode_writable(&world, u64::MAX).unwrap().words;
    assert_eq!([4, 5, 6, 8, 9, 10].map(|word| copy[word]), [0, 0, 0, 255, 63, 63]);
    for layout in [Layout::TREE64, raxel_rivals::BVH, raxel_rivals::BRICKMAP, raxel_rivals::SVO, raxel_rivals::SVDAG] {
        assert!(!layout.has_set());
        assert_eq!(layout.encode_writable(&world, u64::MAX), layout.encode(&world, u64::MAX));
    }
    for layout in LAYOUTS {
        assert!(layout.encode_writable(&World::empty(), u64::MAX).is_ok(), "{}", layout.name());
    }
}
