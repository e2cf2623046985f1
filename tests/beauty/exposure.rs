//! Exposure and grade.

use raxel::{Session, Value};

use crate::common::Project;
use crate::scenes::{cuboid, frames, open, world};
use crate::{BEAUTY, MATERIALS, SIZE, after, lawn, luminance, mean, scenes};

/// The present exposure.
fn exposure(session: &mut Session) -> f64 {
    let bytes = session.read_buffer("eye", 0..4).unwrap();
    f64::from(f32::from_le_bytes(bytes.try_into().unwrap()))
}

fn seconds(session: &mut Session, rate: u32, seconds: u32) -> f64 {
    session.set_debug_target(raxel::DebugTarget::resource("color")).unwrap();
    frames(session, rate * seconds);
    exposure(session)
}

/// The eye gets used to the dark in some seconds, and to light in about one, as fast at any frame rate. A night is dark and can be read.
#[test]
fn the_exposure_follows_the_light_as_fast_at_any_frame_rate() {
    let project = Project::shipped();
    lawn(&project, &[]);
    // Sunlight alone: its rays show a change at once, and the light that faces keep follows over some frames.
    let light = |session: &mut Session, strength: f32| {
        session.set_param("sun_strength", Value::F32(strength)).unwrap();
    };
    let follow = |rate: u32| {
        let fog = [("clouds", 0.0), ("air", 0.0), ("mist", 0.0), ("sky_strength", 0.0), ("sun_strength", 4.0)];
        let mut session = scenes::open_at(&project, BEAUTY, SIZE, &fog, f64::from(rate));
        let bright = seconds(&mut session, rate, 2);
        light(&mut session, 0.04);
        let soon = seconds(&mut session, rate, 1);
        let dark = seconds(&mut session, rate, 7);
        light(&mut session, 4.0);
        let back = seconds(&mut session, rate, 1);
        [bright, soon, dark, back]
    };
    let (fast, slow) = (follow(60), follow(20));
    for (fast, slow) in fast.iter().zip(slow) {
        assert!((fast / slow - 1.0).abs() < 0.04, "{fast} at 60 frames a second, {slow} at 20");
    }
    let way = |now: f64| (now / fast[0]).log2() / (fast[2] / fast[0]).log2();
    assert!(fast[2] > 10.0 * fast[0], "{fast:?}");
    assert!((0.3..0.8).contains(&way(fast[1])) && way(fast[3]) < 0.2, "{fast:?}");
    assert_eq!(slow, follow(20));

    let shown = |elevation: f32, moon: f32| {
        let params = [("clouds", 0.0), ("sun_elevation", elevation), ("moon_phase", moon)];
        mean(&after(&mut open(&project, BEAUTY, SIZE, &params), "color", 24))
    };
    let (day, moon, night) = (shown(32.0, 0.8), shown(-9.0, 1.0), shown(-9.0, 0.0));
    assert!(
        night > 0.005 && 1.5 * night < moon && 1.5 * moon < day,
        "{night} without a moon, {moon} with one, {day} by day"
    );
}

/// More frames of one moment, as `--settle` makes them, change no exposure: a settled picture has that of its film.
#[test]
fn the_exposure_stands_still_where_time_does() {
    let project = Project::shipped();
    lawn(&project, &[]);
    let mut session = open(&project, BEAUTY, SIZE, &[]);
    let before = seconds(&mut session, 60, 1);
    session.set_param("sun_strength", Value::F32(0.2)).unwrap();
    frames(&mut session, 4);
    let on_its_way = exposure(&mut session);
    for _ in 0..40 {
        session.again();
        frames(&mut session, 1);
    }
    assert!(on_its_way > 1.01 * before, "{on_its_way}, {before} in more light");
    assert_eq!(exposure(&mut session), on_its_way);
}

/// After a jump of the camera, the exposure is right at once, and it stays: noise and single bright pixels do not move it.
#[test]
fn the_exposure_is_right_after_a_jump() {
    let project = Project::shipped();
    let room = [
        cuboid("stone", [99, 2, -6], [112, 12, 7], "shell = 1"),
        cuboid("lamp", [104, 10, 0], [105, 11, 1], ""),
        cuboid("stone", [106, 3, 3], [108, 7, 5], ""),
    ];
    lawn(&project, &room);
    let mut session = open(&project, BEAUTY, SIZE, &[("lamp_strength", 0.2)]);
    let outside = seconds(&mut session, 60, 1);
    session.set_camera(raxel::Camera { cell: [101, 6, 5].into(), yaw: -0.8, ..*session.camera() });
    let mut inside = Vec::new();
    for _ in 0..90 {
        frames(&mut session, 1);
        inside.push(exposure(&mut session));
    }
    let settled = inside[89];
    assert!(settled > 3.0 * outside, "{settled} inside, {outside} outside");
    let range = |values: &[f64]| values.iter().fold(0.0, |most, value| f64::max(most, (value / settled).log2().abs()));
    assert!(range(&inside[0..1]) < 0.6 && range(&inside[8..]) < 0.15 && range(&inside[30..]) < 0.05, "{inside:?}");
    // A step is no jump.
    session.set_camera(raxel::Camera { cell: [101, 6, 4].into(), ..*session.camera() });
    let step = seconds(&mut session, 60, 1);
    assert!((step / settled).log2().abs() < 0.2, "{step} after a step, {settled} before");
}

/// Sharpness, contrast and saturation do as they are called, and 0, 1 and 1 leave the tone curve alone.
#[test]
fn the_grade_sharpens_and_adds_contrast_and_colour() {
    let project = Project::shipped();
    // Stripes about as wide as a pixel.
    let stripes = (-13..13).map(|n| cuboid("stone", [3 * n, 2, -40], [3 * n + 1, 3, 40], ""));
    let build: Vec<_> = std::iter::once(cuboid("lawn", [-40, 0, -40], [40, 3, 40], "")).chain(stripes).collect();
    world(&project, MATERIALS, &build, [0.5, 14.5, 14.5], [0.5, 4.0, -8.0], 60.0);
    let mut session = open(&project, BEAUTY, SIZE, &[("bloom", 0.0)]);
    frames(&mut session, 20);
    let mut shown = |sharpness: f32, contrast: f32, saturation: f32| {
        for (name, value) in [("sharpness", sharpness), ("contrast", contrast), ("saturation", saturation)] {
            session.set_param(name, Value::F32(value)).unwrap();
        }
        after(&mut session, "color", 1)
    };
    let step =
        |texels: &[[f32; 4]]| texels.windows(2).map(|two| (luminance(&two[0]) - luminance(&two[1])).abs()).sum::<f64>();
    let colour = |texels: &[[f32; 4]]| {
        texels.iter().map(|t| f64::from((t[0].max(t[1]).max(t[2])) - t[0].min(t[1]).min(t[2]))).sum::<f64>()
    };
    let spread = |texels: &[[f32; 4]]| {
        let middle = mean(texels);
        texels.iter().map(|texel| (luminance(texel) - middle).powi(2)).sum::<f64>()
    };
    let plain = shown(0.0, 1.0, 1.0);
    let (sharp, contrast, vivid, gray) =
        (shown(1.0, 1.0, 1.0), shown(0.0, 1.6, 1.0), shown(0.0, 1.0, 1.5), shown(0.0, 1.0, 0.0));
    // The picture goes on to be averaged meanwhile, which takes away noise: from frame to frame it gets smoother.
    assert!(step(&sharp) > 1.05 * step(&plain), "{} of {}", step(&sharp), step(&plain));
    assert!(spread(&contrast) > 1.2 * spread(&plain), "{} of {}", spread(&contrast), spread(&plain));
    assert!(
        colour(&vivid) > 1.2 * colour(&plain) && colour(&gray) < 0.1 * colour(&plain),
        "{} {} {}",
        colour(&vivid),
        colour(&gray),
        colour(&plain)
    );
}
