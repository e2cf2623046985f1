//! The scenes that lighting is judged in.

use raxel_diagnostics::names::{closest, list};
use raxel_measure::light::Scene;
use raxel_runtime::camera::Camera;
use raxel_terminal::console::Console;
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::OfflineProject;
use raxel_terminal::session::named_camera;

/// A scene that has a name: world, camera (position and what it looks at) where it is not the world's, params.
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

/// The scenes that are named, or all that have names.
pub(super) fn find(named: &[String], front: &OfflineProject, console: &Console) -> Result<Vec<Scene>> {
    if named.is_empty() {
        return Ok(KNOWN.iter().map(scene).collect());
    }
    let find = |name: &String| match KNOWN.iter().find(|known| known.0 == name) {
        Some(known) => Ok(scene(known)),
        None => of_world(name, front, console),
    };
    named.iter().map(find).collect()
}

fn scene(&(name, world, view, params): &Known) -> Scene {
    let camera = view.map(|[position, target]| {
        let mut camera = Camera::at(position);
        camera.look_at(target);
        camera
    });
    let params = params.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    Scene { name: name.to_owned(), world: world.to_owned(), camera, params }
}

/// `WORLD` or `WORLD:CAMERA`.
fn of_world(named: &str, front: &OfflineProject, console: &Console) -> Result<Scene> {
    let (file, camera) = named.split_once(':').map_or((named, None), |(file, camera)| (file, Some(camera)));
    let path = front.project.path_of(file.as_ref()).ok().filter(|path| front.project.on_disk(path).is_file());
    let Some(path) = path else {
        let names = || KNOWN.iter().map(|known| known.0);
        let failure = Failure::new(Exit::Project, format!("there is no scene or world `{named}`"));
        return Err(match closest(named, names()) {
            Some(close) => failure.help(format!("did you mean `{close}`?")),
            None => failure.help(format!("scenes: {}; or the file of a world", list(names()))),
        });
    };
    let world = front.world(&path, console)?;
    let camera = camera.map(|name| named_camera(&world, name)).transpose()?;
    let name = named.trim_end_matches(".toml").replace(".toml:", "-").replace(['/', '\\', ':'], "-");
    let name = name.trim_start_matches("worlds-").to_owned();
    Ok(Scene { name, world: path, camera, params: Vec::new() })
}
