//! The picture of `graphs/beauty.toml` beside its light: land around finite worlds, clouds, the night, sharpening and the grade.

#![allow(clippy::float_cmp, reason = "levels and kinds of land are exact")]

mod common;
#[path = "light/scenes.rs"]
mod scenes;

use common::Project;
use raxel::{Session, Value};
use scenes::{DARK, cuboid, frames, open, world};

const BEAUTY: &str = "graphs/beauty.toml";
const SIZE: [u32; 2] = [48, 27];
const MATERIALS: &str = "black = { albedo = [0.0, 0.0, 0.0] }
lawn = { albedo = [0.2, 0.5, 0.1] }
stone = { albedo = [0.6, 0.6, 0.6] }
polished = { albedo = [0.9, 0.9, 0.9], roughness = 0.05, metallic = 1.0 }
lamp = { albedo = [1.0, 0.9, 0.8], emission = 30.0 }";

fn luminance(texel: &[f32; 4]) -> f64 {
    0.2126 * f64::from(texel[0]) + 0.7152 * f64::from(texel[1]) + 0.0722 * f64::from(texel[2])
}

fn mean(texels: &[[f32; 4]]) -> f64 {
    texels.iter().map(luminance).sum::<f64>() / texels.len() as f64
}

/// The texels of a target after `count` frames.
fn after(session: &mut Session, target: &str, count: u32) -> Vec<[f32; 4]> {
    session.pin(target).unwrap();
    frames(session, count);
    session.read_target(target).unwrap().floats()
}

fn at(texels: &[[f32; 4]], x: u32, y: u32) -> [f32; 4] {
    texels[(y * SIZE[0] + x) as usize]
}

/// A lawn of 80 × 80 with its top at y = 3, seen from above its centre towards its edge and beyond.
fn lawn(project: &Project, more: &[String]) {
    let build = [vec![cuboid("lawn", [-40, 0, -40], [40, 3, 40], "")], more.to_vec()].concat();
    world(project, MATERIALS, &build, [0.5, 20.5, 0.5], [0.5, 6.0, -40.0], 60.0);
}

fn ground_none(session: &mut Session) {
    session.set_param("ground", Value::U32(0)).unwrap();
}

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

/// All layers of a target.
fn layers(session: &mut Session, target: &str, count: u32) -> Vec<[f32; 4]> {
    (0..count).flat_map(|layer| session.read_texels(target, 0, 0, layer).unwrap().floats()).collect()
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

/// A camera that moves sees lit mist from ever another side, and mist scatters forwards. Mist that a wall hid comes into view. Neither
/// makes the mist brighter or darker.
#[test]
fn lit_mist_is_as_bright_in_motion_as_at_rest() {
    let project = Project::shipped();
    let build = [
        cuboid("lawn", [-40, 0, -40], [40, 3, 40], ""),
        cuboid("stone", [-40, 3, 0], [0, 30, 2], ""),
        cuboid("lamp", [-6, 14, 3], [-5, 15, 4], ""),
    ];
    world(&project, MATERIALS, &build, [0.5, 15.5, 40.5], [0.5, 15.5, 0.5], 60.0);
    let night = [("clouds", 0.0), ("mist", 20.0), ("mist_floor", 400.0), DARK[0], DARK[1]];
    let mut session = open(&project, BEAUTY, SIZE, &night);
    for target in ["seen", "hit"] {
        session.pin(target).unwrap();
    }
    for step in 0..24 {
        session.set_camera(raxel::Camera { cell: [step - 4, 15, 40].into(), ..*session.camera() });
        frames(&mut session, 1);
    }
    let [moving, hits] = ["seen", "hit"].map(|target| session.read_target(target).unwrap().floats());
    let grain_in_motion = grain(&mut session);
    let rest = after(&mut session, "seen", 200);
    let beside = |texels: &[[f32; 4]]| {
        texels.iter().zip(&hits).filter(|(_, hit)| hit[3] < 0.0).map(|(texel, _)| luminance(texel)).sum::<f64>()
    };
    let ratio = beside(&moving) / beside(&rest);
    // 0.62 with eight frames in the mean of all slices, 1.67 where the mean takes over what a wall hid.
    assert!((ratio - 1.0).abs() < 0.25, "before the sky, the mist is {ratio} times as bright in motion as at rest");
    // Slices share their noise while they have few frames, and each shows its own light in the end.
    assert!(grain_in_motion < 0.75, "of the grain of the air, {grain_in_motion} is left in motion");
    let grain_at_rest = grain(&mut session);
    assert!((grain_at_rest - 1.0).abs() < 0.02, "of the grain of the air, {grain_at_rest} is left at rest");
}

/// The differences between columns of the first eight slices of lit air, with shared noise over those without.
fn grain(session: &mut Session) -> f64 {
    let [own, soft] = ["air_lamps", "air_lamps_soft"].map(|target| {
        session.pin(target).unwrap();
        let texels = layers(session, target, 8);
        let rows = texels.chunks(40).flat_map(|row| row.windows(2));
        rows.map(|pair| (luminance(&pair[0]) - luminance(&pair[1])).powi(2)).sum::<f64>()
    });
    (soft / own).sqrt()
}

/// The mean of earlier frames has a range around the light of the present ones. At a lamp, which is many times as bright as what is around it, this range has an end too.
#[test]
fn lamps_do_not_flare_in_motion() {
    let project = Project::shipped();
    let lamps = (0..3).map(|i| cuboid("lamp", [9 * i - 12, 5, -20], [9 * i - 9, 9, -19], ""));
    let build: Vec<String> = std::iter::once(cuboid("stone", [-40, 0, -40], [40, 3, 40], "")).chain(lamps).collect();
    world(&project, MATERIALS, &build, [0.5, 6.5, 0.5], [0.5, 6.5, -20.0], 60.0);
    let mut session = open(&project, BEAUTY, SIZE, &[DARK[0], DARK[1], ("lamp_strength", 4.0)]);
    for target in ["seen", "average"] {
        session.pin(target).unwrap();
    }
    let mut camera = *session.camera();
    for _ in 0..16 {
        camera.translate(glam::DVec3::new(0.13, 0.07, 0.0));
        session.set_camera(camera);
        frames(&mut session, 1);
        let mut brightest = |target: &str| {
            let texels = session.read_target(target).unwrap().floats();
            texels.iter().flat_map(|texel| texel[..3].to_vec()).fold(0.0, f32::max)
        };
        let (now, mean) = (brightest("seen"), brightest("average"));
        assert!(now > 50.0 && mean < 2.05 * now, "{mean} in the mean, {now} now");
    }
}

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

/// Behind a wall, the mist of a picture has the light from right before the wall. This light does not stay where the wall gives the view free.
#[test]
fn mist_behind_a_wall_has_its_own_light_once_it_is_seen() {
    const SLICES: u32 = 32;
    let project = Project::shipped();
    let lamp = |x: i32| cuboid("lamp", [x, 6, -11], [x + 2, 9, -10], "");
    let build = [cuboid("stone", [-60, 3, -13], [-4, 40, -11], ""), lamp(-7), lamp(-14)];
    lawn(&project, &build);
    let mut session = open(&project, BEAUTY, SIZE, &[DARK[0], DARK[1], ("mist", 20.0)]);
    session.pin("air_lamps").unwrap();
    let mut camera = raxel::Camera { cell: [-8, 7, 0].into(), pitch: 0.0, ..*session.camera() };
    for _ in 0..16 {
        camera.translate(glam::DVec3::new(0.25, 0.0, 0.0));
        session.set_camera(camera);
        frames(&mut session, 1);
    }
    let moving = layers(&mut session, "air_lamps", SLICES);
    frames(&mut session, 48);
    let rest = layers(&mut session, "air_lamps", SLICES);
    // Slices well behind the wall in columns that see past it.
    let seen = (7 * 40 * 24..12 * 40 * 24).filter(|i| moving[*i][3] > 0.0 && rest[*i][3] > 0.0);
    let [mut late, mut right] = [0.0, 0.0];
    for i in seen {
        late += luminance(&moving[i]);
        right += luminance(&rest[i]);
    }
    assert!(right > 0.0 && late < 2.0 * right, "{late} in motion, {right} at rest");
}

/// A rough metal mirrors a wide cone by one ray a frame, and pixels side by side mirror nearly the same.
#[test]
fn a_rough_metal_is_smooth_in_its_first_frame() {
    let project = Project::shipped();
    let materials = format!("{MATERIALS}\ngold = {{ albedo = [0.96, 0.78, 0.38], roughness = 0.3, metallic = 1.0 }}");
    let lamps = (0..5).map(|i| cuboid("lamp", [6 * i - 14, 9, -14], [6 * i - 12, 11, -12], ""));
    let build: Vec<String> = std::iter::once(cuboid("gold", [-20, 0, -20], [20, 3, 20], "")).chain(lamps).collect();
    world(&project, &materials, &build, [0.2, 8.8, 14.2], [0.1, 3.0, 0.4], 60.0);
    let first = after(&mut open(&project, BEAUTY, SIZE, &[("clouds", 0.0)]), "gloss", 1);
    let near = |x, y| (luminance(&at(&first, x, y)) - luminance(&at(&first, x + 1, y))).abs();
    let rows = SIZE[1] * 2 / 3..SIZE[1];
    let rough: f64 =
        rows.clone().map(|y| (0..SIZE[0] - 1).map(|x| near(x, y)).sum::<f64>() / f64::from(SIZE[0] - 1)).sum::<f64>()
            / rows.len() as f64;
    // 0.44 where each pixel has its own ray alone.
    assert!(rough < 0.25 * mean(&first), "pixels side by side differ by {rough}, their mean is {}", mean(&first));
}

/// The ground goes on where a lawn ends, with its level, its colour and its light; without ground, the void is another.
#[test]
fn ground_goes_on_at_the_level_and_in_the_colour_of_the_border() {
    let project = Project::shipped();
    lawn(&project, &[]);
    let mut session = open(&project, BEAUTY, SIZE, &[("clouds", 0.0), ("air", 0.0), ("mist", 0.0)]);
    let land = after(&mut session, "land", 1);
    let near = |a: f32, b: f32| (a - b).abs() < 1e-3;
    assert!(
        near(land[0][0], 0.2) && near(land[0][1], 0.5) && near(land[0][2], 0.1) && near(land[0][3], 3.0),
        "{land:?}"
    );
    session.pin("hit").unwrap();
    let seen = after(&mut session, "seen", 16);
    let hits = session.read_target("hit").unwrap().floats();
    let edge = (0..SIZE[1]).find(|y| at(&hits, 24, *y)[3] >= 0.0).unwrap();
    assert!(edge > 2 && edge < SIZE[1] - 3, "the lawn begins in row {edge}");
    // Beside the border, on both sides of it. The ground has patches of a tenth and more.
    let [ground, grass] = [edge - 2, edge + 2].map(|y| luminance(&at(&seen, 24, y)));
    assert!((ground / grass - 1.0).abs() < 0.2, "ground {ground}, lawn {grass}");
    ground_none(&mut session);
    let green = |texels: &[[f32; 4]]| at(texels, 24, edge - 2)[1] / at(texels, 24, edge - 2)[0];
    let (ground, void) = (green(&seen), green(&after(&mut session, "seen", 4)));
    assert!(ground > 1.5 && void < 1.3, "green of red: ground {ground}, void {void}");
}

/// A world that shows walls at its border stands on a plane at its lowest level, and a streamed one has no land around it.
#[test]
fn a_cube_stands_on_plain_ground_and_a_streamed_world_has_none() {
    let project = Project::shipped();
    world(
        &project,
        MATERIALS,
        &[cuboid("stone", [0, 5, 0], [20, 30, 20], "")],
        [60.5, 20.5, 60.5],
        [10.0, 15.0, 10.0],
        60.0,
    );
    let land = after(&mut open(&project, BEAUTY, SIZE, &[]), "land", 1);
    assert!(land[0][3] == 5.0 && land[1][0] == 1.0, "{land:?}");
    project.write("worlds/test.toml", std::fs::read_to_string(project.path("worlds/frontier.toml")).unwrap());
    let land = after(&mut open(&project, BEAUTY, SIZE, &[]), "land", 1);
    assert_eq!(land[1][0], 0.0, "{land:?}");
}

/// A wall at the edge of the lawn throws its shadow over the ground, and a mirror shows the ground.
#[test]
fn the_world_shades_the_ground_and_mirrors_show_it() {
    let project = Project::shipped();
    let fog = [("clouds", 0.0), ("air", 0.0), ("mist", 0.0)];
    let shade = |wall: bool| {
        let wall = if wall { vec![cuboid("stone", [-40, 3, -40], [40, 40, -39], "")] } else { Vec::new() };
        lawn(&project, &wall);
        // From beyond the wall, whose shadow falls towards -z: the sun stands in the south.
        project.edit("worlds/test.toml", "position = [0.5, 20.5, 0.5]", "position = [0.5, 20.5, -60.5]");
        project.edit("worlds/test.toml", "look_at = [0.5, 6.0, -40.0]", "look_at = [0.5, 0.0, -75.0]");
        let sun = [("sun_azimuth", 180.0), ("sun_elevation", 30.0)];
        let seen = after(&mut open(&project, BEAUTY, SIZE, &[&fog[..], &sun].concat()), "seen", 4);
        luminance(&at(&seen, 24, 20))
    };
    let (open_ground, shaded) = (shade(false), shade(true));
    assert!(shaded > 0.0 && shaded < 0.5 * open_ground, "{shaded} in the shadow, {open_ground} without it");

    let mirror = cuboid("polished", [-40, 3, -40], [40, 60, -39], "");
    lawn(&project, &[mirror]);
    project.edit("worlds/test.toml", "position = [0.5, 20.5, 0.5]", "position = [0.5, 40.5, 30.5]");
    project.edit("worlds/test.toml", "look_at = [0.5, 6.0, -40.0]", "look_at = [0.5, 32.0, -39.0]");
    let mut session = open(&project, BEAUTY, SIZE, &fog);
    let green = |texel: [f32; 4]| f64::from(texel[1] / texel[2]);
    let with = green(at(&after(&mut session, "gloss", 2), 24, 13));
    ground_none(&mut session);
    let without = green(at(&after(&mut session, "gloss", 2), 24, 13));
    assert!(with > 1.5 * without, "green of blue: {with} with ground, {without} without");
}

/// Without clouds their other params change no bit, and under a whole sky of them the land gets less sun. The share that a march towards
/// the sun lets through is the share that comes through to the place.
#[test]
fn clouds_dim_the_sun_as_much_as_they_hide_it() {
    let project = Project::shipped();
    let build = [cuboid("stone", [-40, 0, -40], [40, 1, 40], "")];
    world(&project, MATERIALS, &build, [0.5, 30.5, 0.5], [0.5, 0.0, 1.0], 60.0);
    let light = |params: &[(&str, f32)]| after(&mut open(&project, BEAUTY, SIZE, params), "radiance", 2);
    let clear = light(&[("clouds", 0.0)]);
    assert_eq!(clear, light(&[("clouds", 0.0), ("cloud_height", 90.0)]));
    let dim = light(&[("clouds", 1.0)]);
    assert!(mean(&dim) < 0.7 * mean(&clear), "{} of {}", mean(&dim), mean(&clear));

    // Mist before black stone.
    let black = [cuboid("black", [-40, 0, -40], [40, 1, 40], "")];
    world(&project, MATERIALS, &black, [0.5, 30.5, 0.5], [0.5, 0.0, 1.0], 60.0);
    let mist = |clouds: f32| {
        let params = [("clouds", clouds), ("mist", 40.0), ("sky_strength", 0.0)];
        mean(&after(&mut open(&project, BEAUTY, SIZE, &params), "seen", 2))
    };
    let (dim, clear) = (mist(1.0), mist(0.0));
    assert!(clear > 0.0 && dim < 0.7 * clear, "mist {dim} of {clear}");

    // Straight up at the sun, from many places under the clouds: the first has another cloud above it than the next.
    let sky = [("sun_elevation", 90.0), ("clouds", 0.75), ("sky_strength", 0.0), ("ground_drop", 0.0)];
    let (mut seen, mut falls) = (Vec::new(), Vec::new());
    for place in [0, 300, 700, 1100, 1500, 1900] {
        let slab = [cuboid("stone", [place - 4, 0, -4], [place + 5, 1, 5], "")];
        let x = f64::from(place) + 0.5;
        world(&project, MATERIALS, &slab, [x, 30.5, 0.5], [x, 480.0, 0.6], 10.0);
        let clouds = after(&mut open(&project, BEAUTY, SIZE, &sky), "clouds", 1);
        seen.push(f64::from(clouds[clouds.len() / 2 + 12][3]));
        world(&project, MATERIALS, &slab, [x, 30.5, 0.5], [x, 0.0, 0.6], 10.0);
        let bright = |clouds: f32| {
            let sky = [("sun_elevation", 90.0), ("clouds", clouds), ("sky_strength", 0.0)];
            luminance(&at(&after(&mut open(&project, BEAUTY, SIZE, &sky), "radiance", 1), 24, 13))
        };
        falls.push(bright(0.75) / bright(0.0));
    }
    assert!(
        seen.iter().copied().fold(1.0, f64::min) < 0.5 && seen.iter().copied().fold(0.0, f64::max) > 0.7,
        "{seen:?}"
    );
    for (seen, falls) in seen.iter().zip(&falls) {
        assert!((seen - falls).abs() < 0.25, "{seen} is seen through the clouds, {falls} comes through");
    }
}

/// By day the moon and its phase change no bit. By night it lights the land, from its own side, and stars are in the sky.
#[test]
fn by_night_the_moon_lights_the_land_and_stars_shine() {
    let project = Project::shipped();
    let build = [cuboid("stone", [-40, 0, -40], [40, 1, 40], ""), cuboid("stone", [-1, 1, -8], [2, 12, -7], "")];
    world(&project, MATERIALS, &build, [0.5, 30.5, 14.5], [0.5, 0.0, -8.0], 60.0);
    let light = |params: &[(&str, f32)]| after(&mut open(&project, BEAUTY, SIZE, params), "radiance", 2);
    let day = light(&[]);
    assert_eq!(day, light(&[("moon_phase", 0.0), ("moon_azimuth", 10.0)]));
    let night = |more: &[(&str, f32)]| light(&[&[("sun_elevation", -9.0), ("clouds", 0.0)], more].concat());
    let (full, new) = (night(&[("moon_phase", 1.0)]), night(&[("moon_phase", 0.0)]));
    assert!(
        mean(&new) > 0.0 && mean(&full) > 4.0 * mean(&new),
        "{} by a full moon, {} by none",
        mean(&full),
        mean(&new)
    );
    assert!(mean(&full) < 0.1 * mean(&day), "{} by night, {} by day", mean(&full), mean(&day));
    // The post's shadow falls to the other side.
    let (east, west) = (night(&[("moon_azimuth", 90.0)]), night(&[("moon_azimuth", 270.0)]));
    let side = |texels: &[[f32; 4]], left: bool| {
        let columns = if left { 14..23 } else { 26..35 };
        columns.map(|x| luminance(&at(texels, x, 13))).sum::<f64>()
    };
    assert!(side(&east, true) < 0.9 * side(&east, false), "{} {}", side(&east, true), side(&east, false));
    assert!(side(&west, false) < 0.9 * side(&west, true), "{} {}", side(&west, true), side(&west, false));

    world(&project, MATERIALS, &build, [0.5, 30.5, 14.5], [0.5, 90.0, -15.0], 60.0);
    let sky = |elevation: f32| {
        let seen =
            after(&mut open(&project, BEAUTY, SIZE, &[("clouds", 0.0), ("sun_elevation", elevation)]), "seen", 1);
        let mut light: Vec<f64> = seen.iter().map(luminance).collect();
        light.sort_by(f64::total_cmp);
        light[light.len() - 4] / light[light.len() / 2]
    };
    assert!(sky(-9.0) > 4.0 && sky(40.0) < 2.0, "{} by night, {} by day", sky(-9.0), sky(40.0));
}

/// Light of a lamp that is off is nearly gone from the average after ten frames.
#[test]
fn a_dead_lamp_leaves_the_average() {
    let project = Project::shipped();
    let build = [
        cuboid("stone", [-1, -1, -1], [13, 9, 13], "shell = 1"),
        cuboid("stone", [3, 0, 3], [5, 4, 5], ""),
        cuboid("lamp", [6, 7, 6], [8, 8, 8], ""),
    ];
    world(&project, MATERIALS, &build, [1.5, 4.5, 11.5], [8.0, 0.0, 4.0], 60.0);
    let mut session = open(&project, BEAUTY, SIZE, &[]);
    let before = mean(&after(&mut session, "average", 40));
    session.set_param("lamp_strength", Value::F32(0.0)).unwrap();
    let left = mean(&after(&mut session, "average", 11)) / before;
    assert!(left < 0.045, "{:.1} % of the light is left", 100.0 * left);
}

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
