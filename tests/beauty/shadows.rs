//! Shadows of the sun, and the mist that it shines through, at rest and while it moves.

use raxel::{Session, Value};

use crate::common::Project;
use crate::scenes::{cuboid, frames, open, world};
use crate::{BEAUTY, MATERIALS, SIZE, after, layers, mean};

/// Each frame looks through another place of a pixel. A mean of many frames must not carry light from pixel to pixel, or shadows spread over the faces that they lie on.
#[test]
fn a_shadow_at_rest_stays_sharp() {
    let project = Project::shipped();
    let post = cuboid("stone", [0, 3, 0], [1, 5, 1], "");
    let build = [cuboid("lawn", [-20, 0, -20], [20, 3, 20], ""), post];
    world(&project, MATERIALS, &build, [2.2, 4.8, 1.2], [1.9, 3.0, -0.4], 60.0);
    let mut session = open(&project, BEAUTY, SIZE, &[("sun_elevation", 35.0), ("sun_azimuth", 235.0)]);
    // Pixels that see the sun in part: the edges of the shadow.
    let in_part = |sun: &[[f32; 4]]| {
        let most = sun.iter().map(|texel| texel[0]).fold(0.0, f32::max);
        sun.iter().filter(|texel| (0.1 * most..0.9 * most).contains(&texel[0])).count()
    };
    let soon = in_part(&after(&mut session, "sun", 8));
    let later = in_part(&after(&mut session, "sun", 92));
    assert!(soon > 16 && 2 * later < 3 * soon, "{soon} pixels in half shadow after 8 frames, {later} after 100");
}

/// The average over frames follows light that changes, also where a pixel differs much from those beside it.
#[test]
fn the_average_follows_light_that_changes() {
    let project = Project::shipped();
    let stripes = (-20..20).map(|i| cuboid("black", [2 * i, 2, -40], [2 * i + 1, 3, 40], ""));
    let build: Vec<String> = std::iter::once(cuboid("stone", [-40, 0, -40], [40, 3, 40], "")).chain(stripes).collect();
    world(&project, MATERIALS, &build, [0.5, 20.5, 0.5], [0.3, 3.0, -0.4], 60.0);
    let params = [("sky_strength", 0.0), ("air", 0.0), ("mist", 0.0), ("clouds", 0.0)];
    let mut session = open(&project, BEAUTY, SIZE, &params);
    session.pin("average").unwrap();
    for step in 0..16 {
        session.set_param("sun_strength", Value::F32(1.05f32.powi(step))).unwrap();
        frames(&mut session, 1);
    }
    let moving = mean(&session.read_target("average").unwrap().floats());
    let rest = mean(&after(&mut session, "average", 48));
    // 0.084 without what follows the light.
    assert!((moving / rest - 1.0).abs() < 0.06, "{moving} while the light changes, {rest} at rest");
}

/// The contents of `count` layers of a target while the sun moves by `degrees` a frame, and after 96 frames at rest: the root mean square
/// of the differences of the first channel, and their mean, in the texels that are not nearly 0 or `most`.
fn lag(session: &mut Session, target: &str, count: u32, degrees: f32, most: f32) -> [f64; 2] {
    session.pin(target).unwrap();
    for step in 0..24u8 {
        session.set_param("sun_azimuth", Value::F32(235.0 - degrees * f32::from(23 - step))).unwrap();
        frames(session, 1);
    }
    let moving = layers(session, target, count);
    frames(session, 96);
    let rest = layers(session, target, count);
    let partly = moving.iter().zip(&rest).filter(|(_, rest)| (0.1 * most..0.9 * most).contains(&rest[0]));
    let differences: Vec<f64> = partly.map(|(moving, rest)| f64::from(moving[0] - rest[0]) / f64::from(most)).collect();
    let texels = differences.len() as f64;
    assert!(texels > 200.0, "only {texels} texels of `{target}` see the sun in part");
    let square: f64 = differences.iter().map(|difference| difference * difference).sum();
    [(square / texels).sqrt(), differences.iter().sum::<f64>() / texels]
}

/// Pixels in half shadow have few rays in a frame, and share them with those around them. So while the sun moves, its shadows look like those at rest.
#[test]
fn half_shadows_of_a_moving_sun_look_like_those_at_rest() {
    let project = Project::shipped();
    // A board far above the lawn.
    let build = [cuboid("lawn", [-40, 0, -40], [40, 3, 40], ""), cuboid("stone", [-211, 260, 0], [-121, 262, 160], "")];
    world(&project, MATERIALS, &build, [0.2, 6.8, 1.2], [0.1, 3.0, -0.4], 40.0);
    let mut session = open(&project, BEAUTY, SIZE, &[("sun_elevation", 60.0), ("clouds", 0.0)]);
    let [error, bias] = lag(&mut session, "sun", 1, 0.02, 60f32.to_radians().sin());
    // 0.14 with the rays of each pixel alone, and doubt within one pixel.
    assert!(error < 0.1 && bias.abs() < 0.06, "error {error}, bias {bias}");
}

/// The air follows a sun that moves fast within a few frames.
#[test]
fn shafts_in_the_mist_do_not_lag_behind_a_moving_sun() {
    let project = Project::shipped();
    let slats = (-8..8).map(|i| cuboid("stone", [12 * i, 60, -40], [12 * i + 6, 61, 60], ""));
    let build: Vec<String> = std::iter::once(cuboid("lawn", [-40, 0, -40], [40, 3, 40], "")).chain(slats).collect();
    world(&project, MATERIALS, &build, [0.2, 14.8, 36.2], [0.1, 14.0, -40.4], 60.0);
    let mut session = open(&project, BEAUTY, SIZE, &[("sun_elevation", 50.0), ("clouds", 0.0), ("mist", 6.0)]);
    let [error, bias] = lag(&mut session, "air_sun", 20, 0.3, 1.0);
    // 0.22 with one ray in each of twelve frames, taken over linearly.
    assert!(error < 0.165 && bias.abs() < 0.03, "error {error}, bias {bias}");
}
