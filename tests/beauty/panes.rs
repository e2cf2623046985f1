//! Panes: what they show, and the light that comes through them.

use raxel::Session;

use crate::common::Project;
use crate::scenes::{cuboid, frames, open, world};
use crate::{MATERIALS, SIZE, after, luminance, mean};

/// Root mean square of the differences between a target in motion and at rest over its mean, and the ratio of both means. The camera moves to where it stands by
/// `step` voxels in each of 16 frames.
fn motion(session: &mut Session, target: &str, step: [f64; 3]) -> [f64; 2] {
    let (end, step) = (*session.camera(), glam::DVec3::from_array(step));
    session.pin(target).unwrap();
    for frame in 1..=16 {
        let mut camera = end;
        camera.translate(step * f64::from(frame - 16));
        session.set_camera(camera);
        frames(session, 1);
    }
    let moving = session.read_target(target).unwrap().floats();
    let rest = after(session, target, 96);
    let square = moving.iter().zip(&rest).map(|(a, b)| (luminance(a) - luminance(b)).powi(2)).sum::<f64>();
    [(square / rest.len() as f64).sqrt() / mean(&rest), mean(&moving) / mean(&rest)]
}

/// The average follows what a pane shows, which moves over the picture more slowly than the pane.
#[test]
fn what_a_pane_shows_stays_sharp_in_motion() {
    let project = Project::shipped();
    let glass = "\nglass = { albedo = [0.95, 0.95, 0.95], roughness = 0.02, transparency = 0.9 }";
    let stripes = (-4..4).map(|i| cuboid("black", [16 * i, 2, -41], [16 * i + 8, 40, -39], ""));
    let build: Vec<String> = [
        cuboid("lawn", [-60, 0, -60], [60, 2, 20], ""),
        cuboid("stone", [-60, 2, -42], [60, 40, -40], ""),
        cuboid("glass", [-20, 2, -5], [20, 30, -4], ""),
    ]
    .into_iter()
    .chain(stripes)
    .collect();
    world(&project, &format!("{MATERIALS}{glass}"), &build, [0.5, 12.5, 0.5], [0.5, 12.5, -40.0], 60.0);
    let params = [("clouds", 0.0), ("air", 0.0), ("mist", 0.0), ("sun_azimuth", 180.0)];
    let mut session = open(&project, "graphs/beauty_glass.toml", SIZE, &params);
    let [error, ratio] = motion(&mut session, "average", [0.21, 0.05, 0.0]);
    // 0.34 and 0.89 where the average follows the pane.
    assert!(error < 0.28 && (ratio - 1.0).abs() < 0.08, "error {error}, {ratio} times as bright in motion");
}

/// Sunlight through panes has a mean over frames in motion, which follows the surfaces that it falls on.
#[test]
fn sunlight_through_panes_has_little_noise_in_motion() {
    let project = Project::shipped();
    let glass = "\nglass = { albedo = [0.9, 0.4, 0.3], roughness = 0.02, transparency = 0.9 }";
    // Panes far above the lawn, so that most of it is in half shadow.
    let panes = (-30..30).map(|i| cuboid("glass", [4 * i, 200, -300], [4 * i + 2, 201, 300], ""));
    let build: Vec<String> = std::iter::once(cuboid("lawn", [-40, 0, -40], [40, 3, 40], "")).chain(panes).collect();
    world(&project, &format!("{MATERIALS}{glass}"), &build, [0.5, 7.5, 3.5], [0.5, 3.0, 0.5], 40.0);
    let mut session = open(&project, "graphs/beauty_glass.toml", SIZE, &[("clouds", 0.0), ("sun_elevation", 80.0)]);
    let [error, ratio] = motion(&mut session, "stained", [0.05, 0.02, 0.0]);
    // 0.83 without earlier frames.
    assert!(error < 0.5 && (ratio - 1.0).abs() < 0.05, "error {error}, {ratio} times as bright in motion");
}

/// A mean over frames of sunlight through a pane leaves no trail when the pane goes.
#[test]
fn sunlight_through_a_pane_goes_with_the_pane() {
    let project = Project::shipped();
    let glass = "\nglass = { albedo = [0.9, 0.4, 0.3], roughness = 0.02, transparency = 0.9 }";
    let build = [cuboid("lawn", [-40, 0, -40], [40, 3, 40], ""), cuboid("glass", [-30, 60, -30], [30, 61, 30], "")];
    world(&project, &format!("{MATERIALS}{glass}"), &build, [0.5, 13.5, 20.5], [0.5, 3.0, 0.5], 60.0);
    let mut session = open(&project, "graphs/beauty_glass.toml", SIZE, &[("clouds", 0.0), ("sun_elevation", 80.0)]);
    let lit = |texels: &[[f32; 4]]| texels.iter().map(|texel| f64::from(texel[0])).sum::<f64>();
    let here = lit(&after(&mut session, "stained", 16));
    let pane = raxel_edit::Operation::sphere([0.0, 60.5, 0.0], 50.0, raxel_edit::Brush::Subtract);
    assert!(session.edit(&[pane]).unwrap() > 0);
    let left = lit(&after(&mut session, "stained", 4)) / here;
    assert!(here > 0.0 && left < 0.02, "{left} of the light is left");
}
