//! Streamed worlds in a session: every picture equals that of the exact tracer over the wanted tiles.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

#[path = "../common/mod.rs"]
mod common;

mod edits;
mod flights;
mod lamps;
mod pictures;

use std::path::PathBuf;

use common::Project;
use glam::IVec3;
use raxel::{Camera, Options, Session, Validation};
use raxel_oracle::Oracle;
use raxel_oracle::camera::Pinhole;
use raxel_stream::{TileKey, streaming_range};
use raxel_testing::union;
use rayon::prelude::*;

const SIZE: [u32; 2] = [95, 57];
const MISS: [i32; 4] = [0, 0, 0, -1];

/// A small part of the shipped endless world, far enough for two levels above the voxels.
fn project() -> Project {
    let project = Project::shipped();
    project.edit("worlds/frontier.toml", "near       = 384", "near = 128");
    project.edit("worlds/frontier.toml", "far        = 24576", "far = 1000");
    project.edit("worlds/frontier.toml", "\"256 MiB\"", "\"100 MiB\"");
    project
}

fn options(project: &Project, graph: &str) -> Options {
    let path = |path: String| -> Option<PathBuf> { Some(project.path(&path)) };
    Options {
        project: Some(project.root().into()),
        graph: path(format!("graphs/{graph}.toml")),
        world: path("worlds/frontier.toml".to_owned()),
        size: SIZE,
        validation: Validation::Required,
        ..Options::default()
    }
}

fn open(project: &Project, graph: &str, pinned: &[&str]) -> Session {
    let pinned = pinned.iter().map(|name| (*name).to_owned()).collect();
    let session =
        Session::open(Options { pinned, ..options(project, graph) }).unwrap_or_else(|error| panic!("{error}"));
    assert!(session.warnings().is_empty(), "{:?}", session.warnings());
    session
}

fn silent(session: &Session) {
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
}

/// A camera's view of the tiles that it wants.
fn exact(session: &Session, camera: &Camera) -> Vec<[i32; 4]> {
    let streamed = session.world().streamed().expect("it is streamed");
    let tiles = session.world().tiles().expect("it is streamed");
    exact_of(session, camera, &streaming_range(streamed, tiles).tiles(camera.cell))
}

/// A camera's view of some tiles.
fn exact_of(session: &Session, camera: &Camera, shown: &[TileKey]) -> Vec<[i32; 4]> {
    let world = union(&**session.world().tiles().expect("it is streamed"), shown).unwrap();
    let pinhole = Pinhole {
        cell: camera.cell,
        frac: camera.frac,
        view_to_world: camera.view_to_world(),
        tan_half_fov: camera.tan_half_fov(f64::from(SIZE[0]) / f64::from(SIZE[1])),
    };
    let oracle = Oracle::new(&world);
    let hit = |ray: &_| {
        let Some(hit) = oracle.first_hit(ray).hit else { return MISS };
        let [x, y, z] = hit.voxel;
        [x, y, z, (hit.face + 8 * u32::from(hit.material)).cast_signed()]
    };
    pinhole.rays(SIZE).par_iter().map(hit).collect()
}

fn hits(session: &mut Session) -> Vec<[i32; 4]> {
    let texels = session.read_target("hit").unwrap().integers().expect("integers");
    texels.iter().map(|hit| hit.map(u32::cast_signed)).collect()
}

/// Near the origin, further on, turned about, at the other end of the world and back.
fn cameras(first: &Camera) -> Vec<Camera> {
    let mut cameras = vec![*first];
    let mut at = |cell: [i32; 3], yaw: f64, pitch: f64| {
        cameras.push(Camera { cell: IVec3::from_array(cell), yaw, pitch, ..*first });
    };
    at([130, 150, -200], 2.0, -0.3);
    at([130, 150, -200], 5.0, -0.8);
    at([1 << 29, 260, -(1 << 29) - 77], 1.0, -0.4);
    at([40, 160, 60], 0.5, -1.2);
    cameras
}

/// The number of pixels that see a voxel. Every pixel equals its exact ray.
fn assert_exact(session: &mut Session) -> usize {
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    let camera = *session.camera();
    let (found, expected) = (hits(session), exact(session, &camera));
    let wrong = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
    assert_eq!(wrong, 0, "{wrong} of {} pixels", found.len());
    silent(session);
    expected.iter().filter(|hit| **hit != MISS).count()
}
