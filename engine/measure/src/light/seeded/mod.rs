//! Scenes by a seed: rooms, streets, caves and land that no system was tuned on. The same seed gives the same files, byte for byte.
//!
//! A scene is a world file with a camera, and params of its sun and sky. About half of all have a model that turns and slides, and each moves its
//! camera, its sun or its models. The exact ray caster finds a place for the camera: in air, and before something lit.

mod draw;
mod kinds;
mod view;

use std::fmt::Write;
use std::sync::Arc;

use glam::{DVec3, IVec3};
use raxel_diagnostics::MemoryFiles;
use raxel_runtime::load::Loader;
use raxel_world::{Material, World, vox};

use self::draw::Draw;
use self::kinds::Draft;
use self::view::View;
use super::{CameraMotion, Motion, Scene};

/// Where the files of scenes lie in a project.
pub const FOLDER: &str = ".raxel/cache/light/worlds";

/// Params that turn and slide the models of a scene.
const TURN: &str = "judge_turn";
const SLIDE: &str = "judge_slide";

/// Worlds that are drawn for one scene until a camera is found in one. Most have one at once.
const WORLDS: u64 = 64;

/// The kinds of scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneKind {
    /// Walls all around, lamps, sometimes windows.
    Room,
    /// Houses by day and by night.
    Street,
    /// Hollows in rock.
    Cave,
    /// Hills under the sky, bounded or streamed.
    Land,
}

impl SceneKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Room, Self::Street, Self::Cave, Self::Land];

    /// Its name on the command line and in names of scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Room => "room",
            Self::Street => "street",
            Self::Cave => "cave",
            Self::Land => "land",
        }
    }

    fn draft(self, draw: &mut Draw) -> Draft {
        match self {
            Self::Room => kinds::room(draw),
            Self::Street => kinds::street(draw),
            Self::Cave => kinds::cave(draw),
            Self::Land => kinds::land(draw),
        }
    }
}

/// A scene with the files that it is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Seeded {
    /// The scene to judge.
    pub scene: Scene,
    /// The world file, and its model if it has one: names in [`FOLDER`], and bytes.
    pub files: Vec<(String, Vec<u8>)>,
}

impl Seeded {
    /// The world file.
    pub fn text(&self) -> String {
        self.files.first().map_or_else(String::new, |(_, bytes)| String::from_utf8_lossy(bytes).into_owned())
    }
}

/// No world of a scene has a place for a camera.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no camera was found for `{name}` in {WORLDS} worlds; another seed has other worlds")]
pub struct NoView {
    /// The scene.
    pub name: String,
}

/// So many scenes of a seed, the kinds in turn. The scene of a kind and number is the same, independent of the others that are asked for.
///
/// # Errors
/// When no camera is found for one of them.
pub fn scenes(seed: u64, count: u32, kinds: &[SceneKind]) -> Result<Vec<Seeded>, NoView> {
    let turns = u32::try_from(kinds.len().max(1)).unwrap_or(1);
    let of = |i: u32| kinds.get((i % turns) as usize).map(|kind| one(*kind, seed, i / turns));
    (0..count).filter_map(of).collect()
}

/// One scene of a seed.
fn one(kind: SceneKind, seed: u64, number: u32) -> Result<Seeded, NoView> {
    let name = format!("{}-{seed}-{number}", kind.name());
    for attempt in 0..WORLDS {
        let mut draw = Draw::new([seed, kind as u64, u64::from(number), attempt]);
        let draft = kind.draft(&mut draw);
        let instances = draw.chance(0.5);
        let model = (instances || draft.scattered).then(|| model(&mut draw));
        let model_file = format!("{name}.vox");
        let models = if model.is_some() {
            format!("\n[models]\nthing = {{ file = \"{model_file}\" }}\n")
        } else {
            String::new()
        };
        let bare = draft.text.file("name = \"seeded\"", &models);
        let mut files = vec![("world.toml".to_owned(), bare.into_bytes())];
        files.extend(model.clone().map(|bytes| (model_file.clone(), bytes)));
        let loader = Loader::with_files(Arc::new(MemoryFiles::new(files)));
        let Ok(world) = loader.world("world.toml").result else { continue };
        let Some(view) = view::find(world.newest(), world.voxels().materials(), &draft, &mut draw) else { continue };

        let mut tables = camera(&view) + &models;
        if instances {
            tables += &placed(&view, &mut draw);
        }
        let scene = Scene {
            world: format!("{FOLDER}/{name}.toml"),
            params: params(&draft),
            motion: motion(&draft, instances, &mut draw),
            instance_params: if instances { vec![TURN.to_owned(), SLIDE.to_owned()] } else { Vec::new() },
            name: name.clone(),
            ..Scene::default()
        };
        let text = draft.text.file(&head(&scene), &tables);
        let mut files = vec![(format!("{name}.toml"), text.into_bytes())];
        files.extend(model.map(|bytes| (model_file, bytes)));
        return Ok(Seeded { scene, files });
    }
    Err(NoView { name })
}

/// The params of the sun and the sky.
#[expect(clippy::cast_possible_truncation, reason = "multiples of 1/64 below 1000 are exact")]
fn params(draft: &Draft) -> Vec<(String, f32)> {
    let light = draft.light;
    let all = [
        ("sun_azimuth", light.azimuth),
        ("sun_elevation", light.elevation),
        ("sun_strength", light.sun),
        ("sky_strength", light.sky),
    ];
    all.map(|(name, value)| (name.to_owned(), value as f32)).to_vec()
}

/// Everything that moves: the models, the sun, the camera. Something always does.
#[expect(clippy::cast_possible_truncation, reason = "multiples of 1/64 below 1000 are exact")]
fn motion(draft: &Draft, instances: bool, draw: &mut Draw) -> Motion {
    let mut params = Vec::new();
    if instances {
        params.push((TURN.to_owned(), (draw.one(&[-1.0, 1.0]) * draw.number(15.0, 120.0)) as f32));
        if draw.chance(0.6) {
            params.push((SLIDE.to_owned(), draw.number(-12.0, 12.0) as f32));
        }
    }
    if draft.light.sun > 0.0 && draw.chance(0.3) {
        params.push(("sun_azimuth".to_owned(), draw.number(-12.0, 12.0) as f32));
    }
    let camera = match draw.int(0, 3) {
        0 if !params.is_empty() => CameraMotion::By([0.0; 3]),
        1 => CameraMotion::By([draw.number(-40.0, 40.0), draw.number(-8.0, 8.0), draw.number(-40.0, 40.0)]),
        _ => CameraMotion::Sideways,
    };
    Motion { camera, params }
}

/// One to three models that stand before the camera.
fn placed(view: &View, draw: &mut Draw) -> String {
    let camera = view.camera();
    let [right, up, forward] = [DVec3::X, DVec3::Y, DVec3::NEG_Z].map(|axis| camera.rotation() * axis);
    let mut text = String::new();
    for _ in 0..draw.int(1, 3) {
        let far = (view.depth * draw.number(0.4, 0.75)).clamp(8.0, 60.0);
        let beside = right * (far * draw.number(-0.4, 0.4)) + up * (far * draw.number(-0.2, 0.1));
        let place = DVec3::from_array(view.position) + forward * far + beside;
        let position = place.to_array().map(|at| (at * 4.0).round() / 4.0);
        let along = [draw.number(-1.0, 1.0), 0.0, draw.number(-1.0, 1.0)];
        let (yaw, axis) = (draw.int(0, 359), draw.one(&["x", "y", "y", "y", "z"]));
        let _ = write!(
            text,
            "\n[[instances]]\nmodel    = \"thing\"\nposition = {position:?}\nyaw      = {yaw}\n\
             turn     = {{ param = \"{TURN}\", axis = \"{axis}\", default = 0.0 }}\n\
             slide    = {{ param = \"{SLIDE}\", along = {along:?}, default = 0.0 }}\n"
        );
    }
    text
}

/// A block, a ball or a cage, some with a lamp inside.
fn model(draw: &mut Draw) -> Vec<u8> {
    let linear = |color: [u8; 3]| color.map(|c| (f32::from(c) / 255.0).powi(2));
    let mut materials = vec![
        Material::air(),
        Material::matt("a", linear(draw.color(40, 240))),
        Material::matt("b", linear(draw.color(40, 240))),
    ];
    let mut lamp = Material::matt("lamp", linear(draw.color(180, 255)));
    lamp.emission = draw.int(4, 40) as f32;
    materials.push(lamp);
    let half: [i32; 3] = std::array::from_fn(|_| draw.int(1, 4));
    let (shape, lit) = (draw.int(0, 2), draw.chance(0.5));
    let mut voxels = Vec::new();
    for x in -half[0]..=half[0] {
        for y in -half[1]..=half[1] {
            for z in -half[2]..=half[2] {
                let at = [x, y, z];
                let edges = (0..3).filter(|axis| at[*axis].abs() == half[*axis]).count();
                let round: f64 = (0..3).map(|axis| (f64::from(at[axis]) / (f64::from(half[axis]) + 0.5)).powi(2)).sum();
                let solid = match shape {
                    0 => true,
                    1 => round <= 1.0,
                    _ => edges >= 2,
                };
                if solid {
                    voxels.push((IVec3::from_array(at), if (x + y + z).rem_euclid(4) == 0 { 2 } else { 1 }));
                } else if lit && at == [0; 3] {
                    voxels.push((IVec3::ZERO, 3));
                }
            }
        }
    }
    if lit && shape != 2 {
        // A cap that shines.
        voxels.push((IVec3::new(0, half[1] + 1, 0), 3));
    }
    // A model this small has no reason to be refused; without voxels it would be a mistake of its file.
    vox::export(&World::from_voxels(materials, voxels)).unwrap_or_default()
}

/// The first lines of a world file: its motions, its camera, its name.
fn head(scene: &Scene) -> String {
    let mut set = String::new();
    for (name, value) in &scene.params {
        let _ = write!(set, " --set {name}={value}");
    }
    let mut moves = match scene.motion.camera {
        CameraMotion::Sideways => "the camera sideways".to_owned(),
        CameraMotion::By([0.0, 0.0, 0.0]) => "not the camera".to_owned(),
        CameraMotion::By(by) => format!("the camera by {by:?} voxels a second"),
    };
    for (name, rate) in &scene.motion.params {
        let _ = write!(moves, ", {name} by {rate} a second");
    }
    format!(
        "# A random scene of `raxel bench light`. What moves: {moves}.\n\
         #     raxel run graphs/light/face_cache.toml --world {}{set}\nname = \"{}\"\n",
        scene.world, scene.name
    )
}

fn camera(view: &View) -> String {
    let View { position, yaw, pitch, fov, .. } = view;
    format!("\n[camera]\nposition = {position:?}\nyaw      = {yaw:?}\npitch    = {pitch:?}\nfov      = {fov:?}\n")
}

#[cfg(test)]
mod tests;
