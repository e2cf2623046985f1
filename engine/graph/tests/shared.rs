//! What a workgroup shares fits the device or is refused.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(missing_docs, reason = "a test")]

mod hand;

use std::sync::Arc;

use hand::Hand;
use raxel_graph::plan::Limits;
use raxel_shader::format::Format;

#[test]
fn shared_variables_must_fit() {
    let mut hand = Hand::new("shared");
    hand.target("color", Format::R32f, |_, _| {});
    let pass = hand.pass("tile", &["w color"]);
    let mut shader = (*pass.shader).clone();
    shader.interface.shared_bytes = 20_000;
    pass.shader = Arc::new(shader);
    hand.limits = Limits { shared_memory: 20_000, ..Limits::PORTABLE };
    assert!(hand.plan("color").is_ok());
    hand.limits = Limits::PORTABLE;
    let found = hand.plan("color").unwrap_err();
    assert_eq!((found.len(), found[0].code.as_str()), (1, "RX0180"));
    assert_eq!(found[0].message, "pass `tile` shares 20000 bytes in a workgroup, but the device allows 16384");
}
