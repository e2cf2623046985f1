//! The scenes that lighting is judged in: with names, of any world, and random ones.

use std::fs;
use std::path::Path;

use raxel_diagnostics::names::{closest, list};
use raxel_graph::checked::Value;
use raxel_measure::light::seeded::{self, FOLDER, SceneKind, Seeded};
use raxel_measure::light::{CameraMotion, Epsilon, Scene};
use raxel_runtime::camera::Camera;
use raxel_runtime::project::Project;
use raxel_runtime::world::SessionWorld;
use raxel_terminal::args::each_once;
use raxel_terminal::console::Console;
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::OfflineProject;
use raxel_terminal::session::{assigned, named_camera};

use super::Args;

/// A scene that has a name: world, camera (position and target) where it is not the world's, params.
type Known = (&'static str, &'static str, Option<[[f64; 3]; 2]>, &'static [(&'static str, f32)]);

/// Open land by day, the same at eye level, a closed room with one lamp, streets with ten thousand, bars of all sizes, and a dark room under a light as bright as can be.
const KNOWN: [Known; 6] = [
    ("valley", "worlds/valley.toml", None, &[]),
    ("near", "worlds/valley.toml", Some([[22.0, 48.0, 4.0], [97.0, 27.0, -77.0]]), &[]),
    ("room", "worlds/light/room.toml", None, &[]),
    ("lamps", "worlds/light/lamps.toml", None, &[("sun_strength", 0.0), ("sky_strength", 0.02)]),
    ("menger", "worlds/menger.toml", None, &[]),
    ("leak", "worlds/light/leak.toml", None, &[("sun_strength", 1000.0), ("sky_strength", 1000.0)]),
];

/// The scenes that are asked for, or all that have names. Files of random scenes are written.
pub(super) fn find(args: &Args, systems: &[String], offline: &OfflineProject, console: &Console) -> Result<Vec<Scene>> {
    let mut scenes: Vec<Scene> =
        args.scenes.iter().map(|name| named_or_world(name, offline, console)).collect::<Result<_>>()?;
    match &args.world {
        Some(world) => scenes.push(seen(world, args, offline, console)?),
        None if !args.eye.is_empty() => {
            return Err(Failure::usage("`--camera` and `--look-at` need `--world`").help("--world worlds/NAME.toml"));
        }
        None => {}
    }
    if args.seed.is_some() {
        let random = of_seed(args)?;
        write(&random, &offline.project)?;
        console.detail(&format!("{} random scenes in {FOLDER}", random.len()));
        scenes.extend(random.into_iter().map(|seeded| seeded.scene));
    }
    if scenes.is_empty() {
        scenes = KNOWN.iter().map(scene).collect();
    }
    let mut changes = Changes::read(args)?;
    changes.check(systems, &scenes, offline)?;
    for scene in &mut scenes {
        scene.set.clone_from(&changes.set);
        scene.motion.params.retain(|(name, _)| changes.moves.iter().all(|(other, _)| other != name));
        scene.motion.params.extend(changes.moves.iter().cloned());
        scene.motion.camera = changes.camera.unwrap_or(scene.motion.camera);
        scene.epsilon = args.epsilon.unwrap_or(scene.epsilon);
    }
    Ok(scenes)
}

/// Random scenes of the seed.
pub(super) fn of_seed(args: &Args) -> Result<Vec<Seeded>> {
    let kinds: Vec<SceneKind> =
        SceneKind::ALL.into_iter().filter(|kind| args.kinds.iter().any(|name| name == kind.name())).collect();
    seeded::scenes(args.seed.unwrap_or_default(), args.count, &each_once(kinds))
        .map_err(|error| Failure::new(Exit::Project, error.to_string()))
}

/// Whether a scene is a random one.
pub(super) fn is_random(scene: &Scene) -> bool {
    scene.world.starts_with(FOLDER)
}

fn write(random: &[Seeded], project: &Project) -> Result {
    let folder = project.on_disk(FOLDER);
    let failed = |path: &Path, error: std::io::Error| {
        Failure::new(Exit::Project, format!("`{}` cannot be written: {error}", path.display()))
    };
    fs::create_dir_all(&folder).map_err(|error| failed(&folder, error))?;
    for (name, bytes) in random.iter().flat_map(|seeded| &seeded.files) {
        let path = folder.join(name);
        fs::write(&path, bytes).map_err(|error| failed(&path, error))?;
    }
    Ok(())
}

/// The values of `--set` and `--move`.
struct Changes {
    set: Vec<(String, String)>,
    moves: Vec<(String, f32)>,
    camera: Option<CameraMotion>,
}

impl Changes {
    fn read(args: &Args) -> Result<Self> {
        let mut changes = Self { set: Vec::new(), moves: Vec::new(), camera: None };
        for text in &args.set {
            let (name, value) = assigned("--set", text)?;
            changes.set.push((name.to_owned(), value.to_owned()));
        }
        for text in &args.moves {
            let (name, rate) = assigned("--move", text)?;
            let numbers: Option<Vec<f32>> =
                rate.split(',').map(|n| n.trim().parse().ok().filter(|n: &f32| n.is_finite())).collect();
            match (name, numbers.as_deref()) {
                ("camera", Some([x, y, z])) => {
                    changes.camera = Some(CameraMotion::By([*x, *y, *z].map(f64::from)));
                }
                ("camera", _) => {
                    return Err(Failure::usage(format!("`--move {text}` has not three numbers"))
                        .help("--move camera=X,Y,Z, in voxels a second"));
                }
                (_, Some([rate])) => changes.moves.push((name.to_owned(), *rate)),
                _ => {
                    return Err(Failure::usage(format!("`--move {text}`: `{rate}` is not a number"))
                        .help("--move NAME=RATE, in units of the param a second"));
                }
            }
        }
        Ok(changes)
    }

    /// Names must be params of a system, of the path tracer, or of the motions of a world's instances. Those that move must be numbers.
    fn check(&mut self, systems: &[String], scenes: &[Scene], offline: &OfflineProject) -> Result {
        if self.set.is_empty() && self.moves.is_empty() {
            return Ok(());
        }
        // The run of a broken graph reports its mistakes.
        let graphs: Vec<_> = systems.iter().filter_map(|path| offline.loader.graph(path).result.ok()).collect();
        let params = || graphs.iter().flat_map(|graph| &graph.params);
        let instances = || scenes.iter().flat_map(|scene| &scene.instance_params).map(String::as_str);
        let known = |option: &str, name: &str| -> Result {
            if params().any(|param| param.name == name) || instances().any(|param| param == name) {
                return Ok(());
            }
            let names = || each_once(params().map(|param| param.name.as_str()).chain(instances()).collect());
            let failure = Failure::usage(format!("`{option} {name}`: no system has a param `{name}`"));
            Err(match closest(name, names().iter().copied()) {
                Some(close) => failure.help(format!("did you mean `{close}`?")),
                None => failure.help(format!("params: {}", list(names().iter().copied()))),
            })
        };
        for (name, _) in &self.set {
            known("--set", name)?;
        }
        for (name, _) in &self.moves {
            known("--move", name)?;
            let number = |value: &Value| matches!(value, Value::F32(_) | Value::I32(_));
            if params().any(|param| param.name == *name && !number(&param.default)) {
                return Err(Failure::usage(format!("`--move {name}`: `{name}` is not one number, so it cannot move")));
            }
        }
        Ok(())
    }
}

fn scene(&(name, world, view, params): &Known) -> Scene {
    let camera = view.map(|[position, target]| {
        let mut camera = Camera::at(position);
        camera.look_at(target);
        camera
    });
    let params = params.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    Scene {
        name: name.to_owned(),
        world: world.to_owned(),
        camera,
        params,
        epsilon: Epsilon::NAMED,
        ..Scene::default()
    }
}

/// A scene by its name, or `WORLD` or `WORLD:CAMERA`.
fn named_or_world(named: &str, offline: &OfflineProject, console: &Console) -> Result<Scene> {
    if let Some(known) = KNOWN.iter().find(|known| known.0 == named) {
        return Ok(scene(known));
    }
    let (file, camera) = named.split_once(':').map_or((named, None), |(file, camera)| (file, Some(camera)));
    let path = offline.project.path_of(file.as_ref()).ok().filter(|path| offline.project.on_disk(path).is_file());
    let Some(path) = path else {
        let names = || KNOWN.iter().map(|known| known.0);
        let failure = Failure::new(Exit::Project, format!("there is no scene or world `{named}`"));
        return Err(match closest(named, names()) {
            Some(close) => failure.help(format!("did you mean `{close}`?")),
            None => failure.help(format!("scenes: {}; or the file of a world", list(names()))),
        });
    };
    let world = offline.world(&path, console)?;
    let camera = camera.map(|name| named_camera(&world, name)).transpose()?;
    let name = named.trim_end_matches(".toml").replace(".toml:", "-").replace(['/', '\\', ':'], "-");
    Ok(of_world(name.trim_start_matches("worlds-").to_owned(), path, camera, &world))
}

/// The scene of `--world`, `--camera` and `--look-at`.
fn seen(named: &Path, args: &Args, offline: &OfflineProject, console: &Console) -> Result<Scene> {
    let path = offline.project.path_of(named).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let world = offline.world(&path, console)?;
    let camera = (!args.eye.is_empty()).then(|| args.eye.of(world.first_camera(), &world)).transpose()?;
    let name = super::super::labels::stem(&path).to_owned();
    Ok(of_world(name, path, camera, &world))
}

fn of_world(name: String, path: String, camera: Option<Camera>, world: &SessionWorld) -> Scene {
    let params = world.instances().list.iter().flat_map(|instance| &instance.motions);
    let instance_params = each_once(params.map(|motion| motion.param.clone()).collect());
    Scene { name, world: path, camera, instance_params, ..Scene::default() }
}
