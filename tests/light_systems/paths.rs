//! Paths and rays: sorting, ends and short cuts change no light.

use raxel::{Options, Session, Validation, Value};
use raxel_measure::light::{Bench, Effort};

use crate::common::{LIGHT, Project, graph_in};
use crate::scenes::{DARK, cuboid, effort, frames, open, scene, systems, world};
use crate::{luminance, room};

/// Path tracers go on for as long as one looks, and the texels of `surface_cache` have their ticks.
const RESTLESS: [&str; 5] = ["reference", "reference_centre", "wavefront", "wavefront_sorted", "surface_cache"];

#[test]
fn a_still_camera_under_still_light_stops_working() {
    let project = Project::shipped();
    room(&project);
    for graph in systems(&project) {
        let name = graph.rsplit('/').next().unwrap().trim_end_matches(".toml");
        if RESTLESS.contains(&name) {
            continue;
        }
        let mut session = open(&project, &graph, [16, 9], &DARK);
        frames(&mut session, 513);
        let done = frames(&mut session, 1);
        assert_eq!(session.frame().unwrap().dispatched, 0, "{graph}");
        assert_eq!(frames(&mut session, 1), done, "{graph}");
        // A change wakes it.
        session.set_param("sky_strength", Value::F32(0.5)).unwrap();
        assert!(session.frame().unwrap().dispatched > 0, "{graph}");
    }
}

#[test]
fn first_hits_by_way_of_half_resolution_change_no_byte() {
    let project = Project::shipped();
    std::fs::copy(project.path("worlds/menger.toml"), project.path("worlds/test.toml")).unwrap();
    // Sides that 2 does not divide.
    let light = |graph: &str| frames(&mut open(&project, graph, [61, 35], &[]), 3);
    assert_eq!(light("graphs/rivals/light/halfres.toml"), light("graphs/rivals/light/sun_history.toml"));
}

/// The place of a path in its queue changes only the time.
#[test]
fn sorting_rays_changes_no_byte() {
    let project = Project::shipped();
    std::fs::copy(project.path("worlds/menger.toml"), project.path("worlds/test.toml")).unwrap();
    let mut sessions =
        ["wavefront", "wavefront_sorted"].map(|name| open(&project, &graph_in(LIGHT, name), [61, 35], &[]));
    let [light, sorted] = sessions.each_mut().map(|session| frames(session, 3));
    assert_eq!(light, sorted);
    // There is a pass more in each of the 12 rounds.
    let [passes, sorted] = sessions.each_mut().map(|session| session.frame().unwrap().dispatched);
    assert!(sorted >= passes + 12, "{sorted} and {passes} dispatches");
}

/// Without lamps, paths of a picture end early, with the same light.
#[test]
fn paths_that_end_early_lose_no_light() {
    let project = Project::shipped();
    let wall = "wall = { albedo = [0.7, 0.6, 0.5] }";
    // A yard that is seen from within, lit by the sky and a high sun.
    let build = [
        cuboid("wall", [-1, -1, -1], [13, 9, 13], "shell = 1"),
        "[[build]]\nop = \"box\"\nmin = [3, 8, 3]\nmax = [10, 9, 10]\nmode = \"subtract\"\n".to_owned(),
    ];
    world(&project, wall, &build, [1.5, 4.5, 11.5], [8.0, 0.0, 4.0], 60.0);
    let light = || {
        let params = [("sun_strength", 2.0), ("sky_strength", 1.0), ("sun_elevation", 75.0)];
        let mut session = open(&project, "graphs/light/face_cache.toml", [48, 27], &params);
        session.pin("queue").unwrap();
        let light = luminance(&frames(&mut session, 128));
        let lamps = session.read_buffer("queue", 44..48).unwrap();
        (light, u32::from_le_bytes(lamps.try_into().unwrap()))
    };
    let (long, lamps) = light();
    assert_eq!(lamps, 0);
    let update = "name     = \"update\"\n";
    project.edit("graphs/light/face_cache.toml", update, &format!("{update}defines  = {{ SHORT_PATHS = 1 }}\n"));
    let (short, _) = light();
    assert!((short / long - 1.0).abs() < 0.03, "{short} by short paths, {long} by long ones");
    assert!((short - long).abs() > 0.0, "no path ended earlier");
}

/// Light of paths in a lamp's room. Half of the long paths end at each place, and a lottery picks some of the rays to lamps that would
/// bring little light.
#[test]
fn paths_and_rays_that_are_left_out_lose_no_light() {
    let project = Project::shipped();
    room(&project);
    let light = || {
        let mut session = open(&project, "graphs/light/face_cache.toml", [48, 27], &DARK);
        luminance(&frames(&mut session, 160))
    };
    let shipped = light();
    project.edit("shaders/light/face_cache/update.comp", "#define PATH_DEEP 5u\n", "");
    project.edit("shaders/light/face_cache/update.comp", "#define PATH_LAMP_LEAST (0.3 * queue.bright)\n", "");
    let all = light();
    assert!((shipped / all - 1.0).abs() < 0.03, "{shipped} as shipped, {all} by all paths and rays");
    assert!((shipped - all).abs() > 0.0, "none was left out");
}

#[test]
fn cubes_of_an_octree_are_where_the_voxels_are() {
    let project = Project::shipped();
    let [mut cubes, mut exact] = ["graphs/rivals/light/views/octree_view.toml", "graphs/inspect.toml"].map(|graph| {
        Session::open(Options {
            project: Some(project.root().into()),
            graph: Some(graph.into()),
            world: Some("worlds/menger.toml".into()),
            size: [96, 54],
            pinned: vec![if graph.ends_with("inspect.toml") { "hit" } else { "empty" }.to_owned()],
            validation: Validation::Required,
            ..Options::default()
        })
        .unwrap()
    });
    exact.frame().unwrap();
    let hit: Vec<bool> =
        exact.read_target("hit").unwrap().integers().unwrap().iter().map(|texel| texel[1] != 7).collect();
    let mut met = |level: u32| -> Vec<bool> {
        cubes.set_param("level", Value::U32(level)).unwrap();
        cubes.frame().unwrap();
        let texels = cubes.read_target("empty").unwrap();
        texels.integers().unwrap().iter().map(|texel| texel[0] != 6).collect()
    };
    let voxels = met(0);
    // The view's steps are those of floats: a ray along an edge may go on the other side of it.
    let other = voxels.iter().zip(&hit).filter(|(a, b)| a != b).count();
    assert!(other <= hit.len() / 200, "{other} of {} rays", hit.len());
    // A cube holds its voxels, so what a voxel hides its cube hides too.
    let mut before = voxels;
    for level in [1, 3, 5] {
        let now = met(level);
        let lost = before.iter().zip(&now).filter(|(smaller, larger)| **smaller && !**larger).count();
        assert!(lost <= hit.len() / 200, "level {level}: {lost} rays meet nothing");
        assert!(now.iter().filter(|met| **met).count() < hit.len(), "some rays meet nothing at all");
        before = now;
    }
}

#[test]
fn references_are_made_once_for_what_they_follow_from() {
    let project = Project::shipped();
    room(&project);
    let scene = scene();
    let run = |paths: u32| {
        let mut bench = Bench::new(Effort { keep: true, ..effort(&project, [16, 9], 1, paths) });
        bench.references(&scene).unwrap()
    };
    let (made, again) = (run(16), run(16));
    assert!(!made.about.kept && again.about.kept);
    assert_eq!((made.halves, &made.about.hashes), (again.halves, &again.about.hashes));
    assert_eq!((made.about.dark, made.about.paths), (again.about.dark, again.about.paths));
    // Another effort, another voxel, another shader: another reference.
    assert!(!run(32).about.kept && run(32).about.kept);
    project.edit("worlds/test.toml", "max = [5, 4, 5]", "max = [5, 5, 5]");
    assert!(!run(16).about.kept && run(16).about.kept);
    project.edit(
        "shaders/light/reference.comp",
        "const uint MOST_VERTICES = 256u;",
        "const uint MOST_VERTICES = 255u;",
    );
    assert!(!run(16).about.kept && run(16).about.kept);
    // A broken reference is made again.
    let folder = project.path(".raxel/cache/light");
    let files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 4, "{files:?}");
    for file in files {
        let bytes = std::fs::read(&file).unwrap();
        std::fs::write(&file, &bytes[..bytes.len() - 4]).unwrap();
    }
    assert!(!run(16).about.kept && run(16).about.kept);
}
