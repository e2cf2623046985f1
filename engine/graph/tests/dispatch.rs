//! Dispatches that follow a target or the world: how many workgroups each makes.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod hand;

use hand::Hand;
use raxel_graph::checked::{Dispatch, Extent, ResourceId};
use raxel_shader::format::Format;

/// Workgroups of the only pass, whose shader has workgroups of 8 × 8.
fn groups(dispatch: impl Fn(ResourceId) -> Dispatch) -> Option<[u32; 3]> {
    let mut hand = Hand::new("dispatch");
    hand.target("color", Format::Rgba16f, |target, _| {
        target.extent = Extent::Fixed2([100, 33]);
        target.mips = 3;
    });
    hand.pass("paint", &["w color"]);
    let target = hand.graph.find_resource("color").unwrap();
    hand.graph.passes[0].dispatch = dispatch(target);
    hand.world = [100, 60, 40];
    hand.plan("color").unwrap_or_else(|found| panic!("{found:#?}")).passes[0].groups
}

#[test]
fn a_workgroup_for_each_texel_or_tile() {
    assert_eq!(groups(|target| Dispatch::GroupsOf { target, mip: 0, tile: [1; 3] }), Some([100, 33, 1]));
    // Tiles that reach over the edge count.
    assert_eq!(groups(|target| Dispatch::GroupsOf { target, mip: 0, tile: [16, 16, 1] }), Some([7, 3, 1]));
    assert_eq!(groups(|target| Dispatch::GroupsOf { target, mip: 2, tile: [16, 8, 1] }), Some([2, 1, 1]));
}

#[test]
fn a_thread_for_each_voxel_of_the_world() {
    assert_eq!(groups(|_| Dispatch::ThreadsOfWorld), Some([13, 8, 40]));
}
