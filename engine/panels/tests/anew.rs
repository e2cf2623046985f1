//! A window that is opened again, as after the loss of a device, has an egui context of its own.

use raxel_panels::{Layout, Panels};

#[test]
fn a_window_that_is_opened_anew_looks_as_before() {
    let mut panels = Panels::new(Layout::read("zoom = 1.5").unwrap());
    for _ in 0..2 {
        let context = egui::Context::default();
        for _ in 0..2 {
            let _ = context.run(egui::RawInput::default(), |context| {
                panels.waiting(context, "It waits", &[]);
            });
        }
        let text = context.style().visuals.override_text_color;
        assert_eq!((context.zoom_factor().to_bits(), text.is_some()), (1.5_f32.to_bits(), true));
    }
}
