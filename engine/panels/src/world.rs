//! The world, the camera and the brush.

use egui::{DragValue, Grid, Ui};
use raxel_diagnostics::names::grouped;

use crate::action::Action;
use crate::brush;
use crate::shape_cache::Content;
use crate::view::{Editing, Solids, World};

/// The name of a camera where none is typed.
const UNNAMED: &str = "camera";

/// The share of the panel that values have.
const VALUES: f32 = 0.55;

/// Texts of fields.
#[derive(Debug, Default)]
pub(crate) struct Fields {
    /// The name under which a camera is written.
    camera: String,
    /// The text that the palette is searched by.
    search: String,
}

/// All that the panel shows.
pub(crate) fn content<'v>(world: &'v World<'_>) -> impl Content + use<'v> {
    let World { path, solid, position, angles, speed, cameras, editing } = world;
    // The outline is drawn over the picture.
    let Editing { brush, materials, steps, refused, under, outline: _ } = editing;
    let camera = (position, angles, speed, cameras.as_slice());
    ((path, solid), camera, (brush, *materials, steps, refused, under))
}

/// Draws the panel.
pub(crate) fn show(ui: &mut Ui, world: &World<'_>, fields: &mut Fields, actions: &mut Vec<Action>) {
    // Values break into lines where the panel is narrow.
    let room = (ui.available_width() * VALUES).max(60.0);
    Grid::new("world").num_columns(2).max_col_width(room).show(ui, |ui| {
        ui.weak("world");
        ui.label(world.path.as_deref().unwrap_or("none"));
        ui.end_row();
        if let Some(Solids { count, min, max }) = world.solid {
            ui.weak("voxels");
            ui.label(grouped(count));
            ui.end_row();
            ui.weak("bounds");
            ui.label(format!("{min:?} to {max:?}"));
        } else {
            ui.weak("bounds");
            ui.label("none: made around the camera");
        }
        ui.end_row();
        ui.weak("camera");
        let [x, y, z] = world.position;
        ui.monospace(format!("{x:.2}, {y:.2}, {z:.2}"));
        ui.end_row();
        let [yaw, pitch, fov] = world.angles;
        // The same direction by one number, however it was reached.
        let yaw = (yaw + 180.0).rem_euclid(360.0) - 180.0;
        ui.weak("yaw, pitch, fov");
        ui.monospace(format!("{yaw:.1}°, {pitch:.1}°, {fov:.1}°"));
        ui.end_row();
        let label = ui.weak("voxels a second");
        let mut speed = world.speed;
        let drag = DragValue::new(&mut speed)
            .range(0.1..=100_000.0)
            .speed(world.speed * 0.01)
            .max_decimals(1)
            .clamp_existing_to_range(false);
        if ui.add(drag).labelled_by(label.id).on_hover_text("The wheel over the picture sets it, too").changed() {
            actions.push(Action::Speed(speed));
        }
        ui.end_row();
    });
    ui.separator();
    ui.horizontal_wrapped(|ui| {
        if ui.button("Home").on_hover_text("Where the camera began; the Home key").clicked() {
            actions.push(Action::Home);
        }
        for camera in &world.cameras {
            if ui.button(camera).on_hover_text("A camera of the world's file").clicked() {
                actions.push(Action::Camera(camera.clone()));
            }
        }
    });
    ui.separator();
    if ui.button("Copy camera as TOML").on_hover_text("The C key").clicked() {
        actions.push(Action::CopyCamera);
    }
    if world.path.is_some() {
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("name");
            let field = egui::TextEdit::singleline(&mut fields.camera).desired_width(100.0);
            ui.add(field.hint_text(egui::RichText::new(UNNAMED).weak())).labelled_by(label.id);
            let name = if fields.camera.is_empty() { UNNAMED } else { &fields.camera };
            let good = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
            let hint = format!("Writes [cameras.{name}] into the world's file; one of that name is replaced");
            let button = ui.add_enabled(good, egui::Button::new("Write to world"));
            let button =
                button.on_hover_text(hint).on_disabled_hover_text("A name is made of a to z, A to Z, 0 to 9, _ and -");
            if button.clicked() {
                actions.push(Action::WriteCamera(name.to_owned()));
            }
        });
    }
    ui.separator();
    brush::show(ui, &world.editing, &mut fields.search, actions);
}
