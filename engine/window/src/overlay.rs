//! egui between the window's events and the presenter: input in, triangles out.

use std::time::Instant;

use egui::epaint::ClippedPrimitive;
use egui::{Context, FullOutput, Popup, Pos2, TexturesDelta, ViewportId, pos2};
use egui_winit::State;
use raxel_overlay::{meshes, patch, texture};
use raxel_panels::{Action, Panels, split_input};
use raxel_runtime::present::{OverlayFrame, PresentError, Presenter};
use winit::event::{KeyEvent, WindowEvent};
use winit::keyboard::{Key, NamedKey};
use winit::window::Window;

/// The interface of one window on one device.
pub(crate) struct Overlay {
    context: Context,
    state: State,
    /// Texels that the presenter has not been given yet.
    textures: TexturesDelta,
    /// The drawings over the next picture.
    painted: Vec<ClippedPrimitive>,
    pixels_per_point: f32,
    /// When something that moves wants to be drawn again.
    again: Option<Instant>,
}

impl Overlay {
    /// For a window. `most` is the largest side of a texture that the device can make.
    #[expect(clippy::cast_possible_truncation, reason = "scales of screens are small numbers")]
    pub(crate) fn new(window: &Window, most: usize) -> Self {
        let context = Context::default();
        let scale = window.scale_factor() as f32;
        let state = State::new(context.clone(), ViewportId::ROOT, window, Some(scale), window.theme(), Some(most));
        Self {
            context,
            state,
            textures: TexturesDelta::default(),
            painted: Vec::new(),
            pixels_per_point: scale,
            again: None,
        }
    }

    /// Notes an event. True when it is meant for a panel, and the camera and the keys must not follow it.
    pub(crate) fn take(&mut self, window: &Window, event: &WindowEvent) -> bool {
        let writes = self.context.wants_keyboard_input();
        if let WindowEvent::KeyboardInput { event: KeyEvent { logical_key: Key::Named(NamedKey::Tab), .. }, .. } = event
            && !writes
        {
            // Else it would go from widget to widget; in the window it goes from target to target.
            return false;
        }
        // Escape closes an open menu or list, and nothing more.
        let closes = Popup::is_any_open(&self.context)
            && matches!(event, WindowEvent::KeyboardInput { event, .. } if event.logical_key == Key::Named(NamedKey::Escape));
        self.state.on_window_event(window, event).consumed || closes
    }

    /// A pixel of the window in points, as the panels count.
    #[expect(clippy::cast_possible_truncation, reason = "pixels of a window are small numbers")]
    fn point(&self, [x, y]: [f64; 2]) -> Pos2 {
        pos2(x as f32, y as f32) / self.context.pixels_per_point()
    }

    /// Whether a pointer at this pixel of the window is over a panel, or takes hold of an edge of one.
    pub(crate) fn has_pointer(&self, panels: &Panels, pixel: [f64; 2]) -> bool {
        panels.has_pointer(&self.context, self.point(pixel))
    }

    /// The place of the picture beside the panels, in pixels of the window: its top left, and its extent. `None` if it fills the window.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "casts of floats saturate, and points of a window are small numbers"
    )]
    pub(crate) fn picture(&self, panels: &Panels) -> Option<[[u32; 2]; 2]> {
        let area = panels.picture(&self.context);
        if area == self.context.content_rect() {
            return None;
        }
        let pixel = |point: Pos2| [point.x, point.y].map(|at| (at * self.context.pixels_per_point()).round() as u32);
        let (from, to) = (pixel(area.min), pixel(area.max));
        Some([from, [0, 1].map(|axis| to[axis].saturating_sub(from[axis]).max(1))])
    }

    /// Whether something of a panel is dragged or pressed.
    pub(crate) fn is_held(&self) -> bool {
        self.context.is_using_pointer()
    }

    /// Draws the interface, to be shown over the next picture. Returns the user's requests, in order.
    pub(crate) fn draw(&mut self, window: &Window, mut content: impl FnMut(&Context) -> Vec<Action>) -> Vec<Action> {
        let mut actions = Vec::new();
        let mut output = FullOutput::default();
        for input in split_input(self.state.take_egui_input(window)) {
            // egui may draw the same twice before it is content; then the second counts.
            let mut asked = Vec::new();
            output.append(self.context.run(input, |context| asked = content(context)));
            actions.append(&mut asked);
        }
        self.state.handle_platform_output(window, output.platform_output);
        let delay = output.viewport_output.get(&ViewportId::ROOT).map(|output| output.repaint_delay);
        self.again = delay.and_then(|delay| Instant::now().checked_add(delay));
        self.pixels_per_point = output.pixels_per_point;
        self.painted = self.context.tessellate(output.shapes, output.pixels_per_point);
        self.textures.append(output.textures_delta);
        actions
    }

    /// Whether something that moves wants to be drawn again now.
    pub(crate) fn is_due(&self) -> bool {
        self.again.is_some_and(|at| at <= Instant::now())
    }

    /// Puts a text on the clipboard.
    pub(crate) fn copy(&mut self, text: String) {
        self.state.set_clipboard_text(text);
    }

    /// Gives the presenter new texels, and the drawings over its picture to `present`. Textures that are no longer used go after.
    pub(crate) fn present<T>(
        &mut self,
        presenter: &mut Presenter,
        present: impl FnOnce(&mut Presenter, &OverlayFrame<'_>) -> Result<T, PresentError>,
    ) -> Result<T, PresentError> {
        for (id, delta) in self.textures.set.drain(..) {
            presenter.set_texture(texture(id), &patch(&delta))?;
        }
        let meshes = meshes(&self.painted);
        let frame = OverlayFrame { pixels_per_point: self.pixels_per_point, meshes: &meshes };
        let result = present(presenter, &frame);
        for id in self.textures.free.drain(..) {
            presenter.free_texture(texture(id));
        }
        result
    }
}
