//! The dense image holds exactly the world's voxels, and each texel of a mip says whether its cube has any.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::collections::HashMap;

use glam::IVec3;
use proptest::prelude::*;
use raxel_layouts::{EncodedImage, EncodingLimits, Layout, LayoutError};
use raxel_rivals::Texture3dHeader;
use raxel_world::{Material, World};

const LAYOUT: Layout = raxel_rivals::TEXTURE3D;

fn world(voxels: &[(IVec3, u16)]) -> World {
    let materials = (0..10).map(|i| if i == 0 { Material::air() } else { Material::matt(format!("m{i}"), [0.5; 3]) });
    World::from_voxels(materials.collect(), voxels.iter().copied())
}

fn encode(world: &World) -> (Texture3dHeader, EncodedImage) {
    let encoded = LAYOUT.encode(world, u64::MAX).expect("it fits");
    let image = LAYOUT.encode_image(world, u64::MAX.into()).expect("it fits").expect("this layout has an image");
    assert_eq!(encoded.geometry_bytes + encoded.attribute_bytes, 4 * encoded.words.len() as u64 + image.bytes());
    let header = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&encoded.words[..Texture3dHeader::WORDS as usize]));
    (header, image)
}

/// Checks every texel of every mip against the world.
fn check(world: &World) {
    let (header, image) = encode(world);
    assert_eq!(header.size, image.size.map(|axis| axis as i32));
    assert_eq!(header.mip_count as usize, image.mips.len());
    let origin = header.origin.map(i64::from);
    if let Some(bounds) = world.bounds() {
        for (i, &low) in origin.iter().enumerate() {
            let end = low + i64::from(header.size[i]);
            assert!(low <= bounds.min[i] && bounds.max[i] <= end, "{header:?}");
            assert!(end - low <= 1 << header.log2_size && low + (1 << header.log2_size) <= 1 << 31, "{header:?}");
        }
    }
    // Solid voxels by texel of each mip.
    for (mip, texels) in image.mips.iter().enumerate() {
        let size = image.size.map(|axis| (axis >> mip).max(1) as usize);
        assert_eq!(texels.len(), size[0] * size[1] * size[2], "mip {mip}");
        let mut solid: HashMap<usize, Vec<u16>> = HashMap::new();
        for (cell, material) in world.voxels() {
            let at: [usize; 3] = std::array::from_fn(|i| (i64::from(cell[i]) - origin[i]) as usize >> mip);
            // The remainder at the far end has no texel.
            if (0..3).all(|i| at[i] < size[i]) {
                solid.entry(at[0] + size[0] * (at[1] + size[1] * at[2])).or_default().push(material);
            }
        }
        assert_eq!(texels.iter().filter(|texel| **texel != 0).count(), solid.len(), "mip {mip}");
        for (at, solid) in &solid {
            assert!(solid.contains(&texels[*at]), "mip {mip}: {} {solid:?}", texels[*at]);
        }
        if mip == 0 {
            assert_eq!(solid.len() as u64, world.solids());
        }
    }
    assert_eq!(image.mips.last().map(Vec::len), Some(1));
}

#[test]
fn mips_are_an_octree_of_what_is_solid() {
    check(&World::empty());
    check(&world(&[(IVec3::ZERO, 1)]));
    // Three chunks wide: the third has no texel in mip 7, and all three share the only one of mip 8.
    check(&world(&[(IVec3::new(5, 0, 0), 1), (IVec3::new(191, 3, 70), 2), (IVec3::new(300, 130, 1), 3)]));
    check(&world(&[(IVec3::new(-1, -65, 64), 4)]));
    // The only voxel of a cube of 256 is in the odd chunk at the end of an axis that has no texel in mip 7.
    for axis in 0..3 {
        let (mut odd, mut far) = (IVec3::ZERO, IVec3::ZERO);
        odd[axis] = 130;
        far[(axis + 1) % 3] = 300;
        check(&world(&[(odd, 1), (far, 2)]));
    }
}

#[test]
fn worlds_at_the_ends_of_the_coordinates_begin_where_the_cube_does() {
    for corner in [i32::MIN, i32::MAX - 90, i32::MAX - 190] {
        let ends = [IVec3::splat(corner), IVec3::new(corner + 90, corner, corner + 66)];
        check(&world(&ends.map(|cell| (cell, 1))));
    }
    // Three chunks at the end: the cube of four cannot begin where they do.
    let last = [i32::MAX - 190, i32::MAX].map(IVec3::splat);
    let world = world(&last.map(|cell| (cell, 1)));
    check(&world);
    assert_eq!(encode(&world).0.origin, [i32::MAX - 255; 3]);
}

#[test]
fn what_a_device_cannot_hold_is_said_with_both_numbers() {
    let long = world(&[(IVec3::ZERO, 1), (IVec3::new(2000, 0, 0), 1)]);
    let limits = EncodingLimits { buffer_bytes: 1 << 20, image_side: 1024, image_bytes: 1 << 30 };
    let error = LAYOUT.encode(&long, limits).expect_err("2001 voxels are more than 1024");
    assert_eq!(error, LayoutError::TooWide { layout: "texture3d", span: 2048, limit: 1024 });
    assert_eq!(LAYOUT.encode_image(&long, limits).expect_err("so is the image"), error);

    let usual = EncodingLimits { buffer_bytes: 7, image_side: 2048, image_bytes: 1 << 32 };
    assert_eq!(EncodingLimits::from(7), usual);

    let exact = encode(&long).1.bytes();
    let limits = |image_bytes| EncodingLimits { image_side: 2048, image_bytes, ..limits };
    assert_eq!(LAYOUT.encode_image(&long, limits(exact)).unwrap().unwrap().bytes(), exact);
    let error = LAYOUT.encode_image(&long, limits(exact - 1)).expect_err("one byte too many");
    assert_eq!(error, LayoutError::ImageTooLarge { layout: "texture3d", bytes: exact, limit: exact - 1 });
    assert!(error.to_string().contains(&format!("{exact} bytes")), "{error}");

    // As wide as a world can be: refused by a number, not by running out of memory.
    let wide = world(&[(IVec3::splat(-(1 << 29)), 1), (IVec3::splat((1 << 29) - 1), 1)]);
    let limits = EncodingLimits { buffer_bytes: u64::MAX, image_side: u32::MAX, image_bytes: u64::MAX };
    assert!(matches!(LAYOUT.encode(&wide, limits), Err(LayoutError::ImageTooLarge { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    #[test]
    fn random_worlds_are_kept(
        voxels in prop::collection::vec((prop::array::uniform3(-150i32..150), 1u16..9), 1..60),
    ) {
        let voxels: Vec<(IVec3, u16)> =
            voxels.into_iter().map(|(cell, material)| (IVec3::from_array(cell), material)).collect();
        check(&world(&voxels));
    }
}
