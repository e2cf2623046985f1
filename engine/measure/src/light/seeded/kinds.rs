//! The contents of a random room, street, cave and land.

use super::draw::{Draw, Text};

/// A world before a camera is found in it.
pub(super) struct Draft {
    pub text: Text,
    /// Boxes in which a camera may stand.
    pub stands: Vec<[[f64; 3]; 2]>,
    /// Degrees up or down that a camera may look.
    pub pitch: [f64; 2],
    /// Heights above the ground, for cameras that stand on it: the box then gives only the place.
    pub above: Option<[f64; 2]>,
    /// Smallest part of the rays that must hit something.
    pub solid: f64,
    /// Params of the sun and the sky.
    pub light: Light,
    /// The model is scattered over the land.
    pub scattered: bool,
}

/// The light of a world besides its lamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Light {
    pub azimuth: f64,
    pub elevation: f64,
    pub sun: f64,
    pub sky: f64,
}

impl Light {
    fn day(draw: &mut Draw) -> Self {
        let (azimuth, elevation) = (draw.number(60.0, 300.0), draw.number(6.0, 75.0));
        Self { azimuth, elevation, sun: draw.number(1.0, 4.0), sky: draw.number(0.25, 1.0) }
    }

    /// Without a sun, under a sky as dark as one of 64 steps lets it be.
    fn night(draw: &mut Draw) -> Self {
        let azimuth = draw.number(60.0, 300.0);
        Self { azimuth, elevation: -6.0, sun: 0.0, sky: draw.one(&[0.0, 0.015_625, 0.031_25]) }
    }
}

/// A closed room, or one with windows: partitions with doors, pillars, furniture, lamps.
pub(super) fn room(draw: &mut Draw) -> Draft {
    let mut text = Text::default();
    let [width, height, depth] = [draw.int(24, 72), draw.int(12, 30), draw.int(24, 72)];
    for wall in ["wall", "floor", "other"] {
        text.material(wall, draw.color(70, 235));
    }
    for thing in ["thing_a", "thing_b", "thing_c"] {
        text.material(thing, draw.color(20, 245));
    }
    let lamp = draw.color(170, 255);
    text.lamp("lamp", lamp, f64::from(draw.int(4, 120)));
    let (outer, inner) = ([-2, -2, -2], [width, height, depth]);
    text.cuboid("wall", outer, inner.map(|side| side + 2));
    text.hole([0; 3], inner);
    text.paint("floor", [-2, -2, -2], [width + 2, 0, depth + 2]);
    let painted = draw.one(&[[-2, 0], [width, width + 2]]);
    text.paint("other", [painted[0], 0, -2], [painted[1], height + 2, depth + 2]);
    for _ in 0..draw.int(0, 3) {
        partition(draw, &mut text, [width, height, depth]);
    }
    for _ in 0..draw.int(0, 5) {
        let [x, z] = [draw.int(2, width - 3), draw.int(2, depth - 3)].map(f64::from);
        let radius = draw.number(1.0, 3.0);
        text.op(&format!(
            "op = \"cylinder\", base = [{x:?}, 0.0, {z:?}], radius = {radius:?}, height = {height}, material = \"other\""
        ));
    }
    for _ in 0..draw.int(3, 14) {
        let size = [draw.int(1, 10), draw.int(1, height / 2), draw.int(1, 10)];
        let min = [draw.int(0, width - 1 - size[0]), 0, draw.int(0, depth - 1 - size[2])];
        let material = draw.one(&["thing_a", "thing_b", "thing_c"]);
        text.cuboid(material, min, std::array::from_fn(|axis| min[axis] + size[axis]));
    }
    let windows = draw.chance(0.4);
    if windows {
        for _ in 0..draw.int(1, 4) {
            let (y, z) = (draw.int(2, height - 8), draw.int(1, depth - 10));
            text.hole([width, y, z], [width + 2, y + draw.int(3, 6), z + draw.int(2, 9)]);
        }
    }
    for _ in 0..draw.int(i32::from(!windows), 5) {
        let side = draw.int(1, 4);
        let y = if draw.chance(0.6) { height - 1 } else { draw.int(1, height - 2) };
        let min = [draw.int(0, width - side), y, draw.int(0, depth - side)];
        text.light("lamp", min, [min[0] + side, y + 1, min[2] + side]);
    }
    let light = if windows && draw.chance(0.8) { Light::day(draw) } else { Light::night(draw) };
    let most = inner.map(|side| f64::from(side) - 2.0);
    Draft {
        text,
        stands: vec![[[2.0, 2.0, 2.0], most]],
        pitch: [-30.0, 20.0],
        above: None,
        solid: 0.9,
        light,
        scattered: false,
    }
}

/// A wall across a room, with a door.
fn partition(draw: &mut Draw, text: &mut Text, [width, height, depth]: [i32; 3]) {
    let thick = draw.int(1, 2);
    let door = [draw.int(3, 8), draw.int(4, height - 2)];
    let (along_x, at, way) = if draw.chance(0.5) {
        (true, draw.int(6, depth - 8), draw.int(1, width - 10))
    } else {
        (false, draw.int(6, width - 8), draw.int(1, depth - 10))
    };
    let place = |along: [i32; 2], up: i32| {
        if along_x {
            [[along[0], 0, at], [along[1], up, at + thick]]
        } else {
            [[at, 0, along[0]], [at + thick, up, along[1]]]
        }
    };
    let [min, max] = place([0, if along_x { width } else { depth }], height);
    text.cuboid("wall", min, max);
    let [min, max] = place([way, way + door[0]], door[1]);
    text.hole(min, max);
}

/// Houses along streets, with lit windows and lanterns by night.
pub(super) fn street(draw: &mut Draw) -> Draft {
    const HALF: i32 = 96;
    let mut text = Text::default();
    let night = draw.chance(0.5);
    text.material("road", draw.color(60, 120));
    let houses = ["house_a", "house_b", "house_c", "house_d"];
    for house in houses {
        text.material(house, draw.color(80, 240));
    }
    text.material("roof", draw.color(40, 150));
    text.material("pole", [60, 60, 64]);
    text.lamp("lantern", draw.color(180, 255), f64::from(draw.int(6, 60)));
    text.lamp("window", draw.color(160, 255), draw.number(1.0, 8.0));
    text.cuboid("road", [-HALF, -3, -HALF], [HALF, 0, HALF]);
    let (block, street) = (draw.int(24, 44), draw.int(8, 18));
    let step = block + street;
    let mut corners = Vec::new();
    let mut x = -HALF + street / 2;
    while x + block <= HALF {
        let mut z = -HALF + street / 2;
        while z + block <= HALF {
            corners.push([x, z]);
            z += step;
        }
        x += step;
    }
    for &[x, z] in &corners {
        let inset = draw.int(0, 3);
        let [min, max] = [[x + inset, z + inset], [x + block - inset, z + block - inset]];
        let height = draw.int(8, 56);
        text.cuboid(draw.one(&houses), [min[0], 0, min[1]], [max[0], height, max[1]]);
        text.cuboid("roof", [min[0] - 1, height, min[1] - 1], [max[0] + 1, height + 1, max[1] + 1]);
        // Rows of windows on the two sides along z: niches, and some that are lit.
        let (wide, rise, gap) = (draw.int(2, 4), draw.int(3, 5), draw.int(5, 8));
        let mut y = 3;
        while y + rise < height {
            let mut along = min[1] + 2;
            while along + wide < max[1] {
                for (outside, face) in [([min[0], min[0] + 1], min[0] + 1), ([max[0] - 1, max[0]], max[0] - 2)] {
                    text.hole([outside[0], y, along], [outside[1], y + rise, along + wide]);
                    if night && draw.chance(0.2) {
                        text.light("window", [face, y, along], [face + 1, y + rise, along + wide]);
                    }
                }
                along += gap;
            }
            y += gap + 2;
        }
    }
    for &[x, z] in &corners {
        // At the corner of each block, in the street.
        let [x, z] = [x - 2, z - 2];
        let height = draw.int(6, 10);
        text.cuboid("pole", [x, 0, z], [x + 1, height, z + 1]);
        if night {
            text.light("lantern", [x, height, z], [x + 1, height + 1, z + 1]);
        }
    }
    let light = if night { Light::night(draw) } else { Light::day(draw) };
    let reach = f64::from(HALF) - 8.0;
    Draft {
        text,
        stands: vec![[[-reach, 2.0, -reach], [reach, 14.0, reach]]],
        pitch: [-15.0, 15.0],
        above: None,
        solid: 0.6,
        light,
        scattered: false,
    }
}

/// Hollows in rock that run into each other, with crystals that glow, some with a shaft to the sky.
pub(super) fn cave(draw: &mut Draw) -> Draft {
    let mut text = Text::default();
    text.material("rock", draw.color(60, 150));
    text.material("vein", draw.color(90, 220));
    let crystals = ["crystal_a", "crystal_b"];
    for crystal in crystals {
        text.lamp(crystal, draw.color(90, 255), f64::from(draw.int(3, 60)));
    }
    text.cuboid("rock", [-72, -40, -72], [72, 40, 72]);
    for _ in 0..draw.int(4, 10) {
        let y = draw.int(-36, 34);
        text.paint("vein", [-72, y, -72], [72, y + draw.int(1, 4), 72]);
    }
    let mut at = [0.0_f64; 3];
    let mut hollows = Vec::new();
    for _ in 0..draw.int(8, 20) {
        let radius = draw.number(5.0, 13.0);
        text.op(&format!("op = \"sphere\", mode = \"subtract\", center = {at:?}, radius = {radius:?}"));
        hollows.push((at, radius));
        let reach = [54.0, 24.0, 54.0];
        let step = [radius * 1.25, radius * 0.5, radius * 1.25];
        at = std::array::from_fn(|axis| {
            (at[axis] + draw.number(-step[axis], step[axis])).clamp(-reach[axis], reach[axis])
        });
    }
    for _ in 0..draw.int(4, 16) {
        // Boulders and pillars that stay.
        let (middle, radius) = draw.one(&hollows);
        let from = [middle[0] + draw.number(-radius, radius), -40.0, middle[2] + draw.number(-radius, radius)];
        let (thick, height) = (draw.number(1.0, 2.5), draw.int(20, 80));
        text.op(&format!(
            "op = \"cylinder\", base = {from:?}, radius = {thick:?}, height = {height}, material = \"rock\""
        ));
    }
    let shaft = draw.chance(0.4);
    if shaft {
        let (middle, _) = draw.one(&hollows);
        let radius = draw.number(3.0, 9.0);
        text.op(&format!(
            "op = \"cylinder\", mode = \"subtract\", base = {middle:?}, radius = {radius:?}, height = 100"
        ));
    }
    for _ in 0..draw.int(2 * i32::from(!shaft), 24) {
        let (middle, radius) = draw.one(&hollows);
        let spread = 0.6 * radius;
        let min: [i32; 3] = middle.map(|center| draw.int(whole(center - spread), whole(center + spread)));
        let size = [draw.int(1, 2), draw.int(1, 4), draw.int(1, 2)];
        let crystal = draw.one(&crystals);
        text.light(crystal, min, std::array::from_fn(|axis| min[axis] + size[axis]));
    }
    let light = if shaft && draw.chance(0.8) { Light::day(draw) } else { Light::night(draw) };
    let stands = hollows.iter().map(|(middle, radius)| {
        let spread = 0.5 * radius;
        [middle.map(|center| center - spread), middle.map(|center| center + spread)]
    });
    Draft { text, stands: stands.collect(), pitch: [-35.0, 25.0], above: None, solid: 0.8, light, scattered: false }
}

#[expect(clippy::cast_possible_truncation, reason = "places of a cave are within 100 voxels")]
fn whole(number: f64) -> i32 {
    number.floor() as i32
}

/// Land with bands of materials, water and caves; half of all are streamed.
pub(super) fn land(draw: &mut Draw) -> Draft {
    let mut text = Text::default();
    text.material("grass", draw.color(70, 170));
    text.material("earth", draw.color(60, 140));
    text.material("rock", draw.color(90, 180));
    text.material("high", draw.color(190, 250));
    text.material("shore", draw.color(150, 220));
    text.material("water", draw.color(50, 170));
    let streamed = draw.chance(0.5);
    let area = if streamed { String::new() } else { "min = [-112, -112], max = [112, 112], ".to_owned() };
    if streamed {
        text.stream = Some(
            "[stream]\nnear = 128\nfar = 2048\ngpu_memory = \"96 MiB\"\nlamp_memory = \"8 MiB\"\ncpu_memory = \"128 MiB\"\n\n"
                .to_owned(),
        );
    }
    let amplitude = draw.int(20, 120);
    let (frequency, octaves) = (f64::from(draw.int(4, 14)) / 1024.0, draw.int(3, 6));
    let (exponent, ridges) = (draw.int(1, 3), draw.chance(0.3));
    let high = draw.int(amplitude / 2, amplitude);
    let slope = draw.int(2, 4);
    let mut terrain = format!(
        "op = \"terrain\", {area}base = 0.0, amplitude = {amplitude}.0, frequency = {frequency:?}, octaves = {octaves}, \
         exponent = {exponent}, ridges = {ridges}, floor = -24, layers = [{{ material = \"grass\", depth = 1 }}, \
         {{ material = \"earth\", depth = 3 }}, {{ material = \"rock\" }}], bands = [{{ material = \"high\", above = {high}, \
         depth = 2 }}, {{ material = \"rock\", slope = {slope} }}, {{ material = \"shore\", below = {} }}]",
        amplitude / 6 + 2
    );
    if draw.chance(0.5) {
        terrain += &format!(", water = {{ material = \"water\", level = {} }}", amplitude / 6);
    }
    if draw.chance(0.3) {
        terrain += ", caves = { width = 0.125, frequency = 0.015625 }";
    }
    text.op(&terrain);
    let scattered = draw.chance(0.7);
    if scattered {
        let cell = draw.int(14, 40);
        text.op(&format!(
            "op = \"scatter\", {area}model = \"thing\", cell = {cell}, chance = 0.7, on = [\"grass\", \"shore\"]"
        ));
    }
    let light = if draw.chance(0.35) {
        // The land itself has no lamps: some light of the sky stays.
        let night = Light::night(draw);
        Light { sky: night.sky.max(0.015_625), ..night }
    } else {
        Light::day(draw)
    };
    Draft {
        text,
        stands: vec![[[-70.0, 0.0, -70.0], [70.0, 0.0, 70.0]]],
        pitch: [-30.0, 5.0],
        above: Some([2.0, 40.0]),
        solid: 0.4,
        light,
        scattered,
    }
}
