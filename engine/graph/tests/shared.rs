//! The shared memory of a workgroup and the bindings of a pass fit the device or are refused.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(missing_docs, reason = "a test")]

mod hand;

use std::sync::Arc;

use hand::Hand;
use raxel_graph::plan::DeviceLimits;
use raxel_shader::format::{Format, ScalarKind};
use raxel_shader::interface::{Access, Binding, BindingKind, ByteRanges, Dim};
use raxel_shader::prints::Prints;

#[test]
fn shared_variables_must_fit() {
    let mut hand = Hand::new("shared");
    hand.target("color", Format::R32f, |_, _| {});
    let pass = hand.pass("tile", &["w color"]);
    let mut shader = (*pass.shader).clone();
    shader.interface.shared_bytes = 20_000;
    pass.shader = Arc::new(shader);
    hand.limits = DeviceLimits { shared_memory: 20_000, ..DeviceLimits::PORTABLE };
    assert!(hand.plan("color").is_ok());
    hand.limits = DeviceLimits::PORTABLE;
    let found = hand.plan("color").unwrap_err();
    assert_eq!((found.len(), found[0].code.as_str()), (1, "RX0180"));
    assert_eq!(found[0].message, "pass `tile` shares 20000 bytes in a workgroup, but the device allows 16384");
}

#[test]
fn what_a_pass_binds_must_fit() {
    let mut hand = Hand::new("bindings");
    hand.target("color", Format::R32f, |_, _| {});
    let pass = hand.pass("wide", &["w color"]);
    let mut shader = (*pass.shader).clone();
    // An image, and an array of four.
    shader.interface.bindings = [(0, 1), (1, 4)]
        .map(|(binding, count)| Binding {
            name: format!("image{binding}"),
            set: 0,
            binding,
            count,
            kind: BindingKind::StorageImage {
                format: Some(Format::R32f),
                dim: Dim::D2,
                arrayed: false,
                scalar: ScalarKind::Float,
            },
            access: Access::Write,
            reads: ByteRanges::default(),
            place: None,
        })
        .to_vec();
    pass.shader = Arc::new(shader);
    let found = hand.plan("color").unwrap_err();
    assert_eq!((found.len(), found[0].code.as_str()), (1, "RX0183"));
    assert_eq!(found[0].message, "pass `wide` binds 5 storage images, but the device allows 4");
    assert_eq!(found[0].notes, ["the limit is `maxPerStageDescriptorStorageImages` = 4"]);
    hand.limits.bindings.storage_images = 5;
    assert!(hand.plan("color").is_ok());
    hand.limits.bindings.resources = 4;
    let found = hand.plan("color").unwrap_err();
    assert_eq!(found[0].message, "pass `wide` binds 5 resources, but the device allows 4");
    // Prints and other records go into a buffer of their own.
    let pass = &mut hand.graph.passes[0];
    let mut shader = (*pass.shader).clone();
    shader.interface.prints = Some(Prints::default());
    pass.shader = Arc::new(shader);
    (hand.limits.bindings.resources, hand.limits.bindings.storage_buffers) = (6, 1);
    assert!(hand.plan("color").is_ok());
    hand.limits.bindings.storage_buffers = 0;
    let found = hand.plan("color").unwrap_err();
    assert_eq!(found[0].message, "pass `wide` binds 1 storage buffers, but the device allows 0");
    assert_eq!(found[0].notes.len(), 2, "{found:?}");
}
