//! Light of lamps on surfaces and in mist, while the camera moves and when they go out.

use raxel::{Session, Value};

use crate::common::Project;
use crate::scenes::{DARK, cuboid, frames, open, world};
use crate::{BEAUTY, MATERIALS, SIZE, after, at, lawn, layers, luminance, mean};

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
