//! Rays through instances that stand where the world file puts them.

use std::fs;

use raxel_layouts::instances::Rotation;
use raxel_oracle::Ray;
use raxel_oracle::sets::Random;

use crate::project::assert_silent;
use crate::{RAYS, bytes, hits, judge, judge_some, load, open, project, random_instances, rays_for};

#[test]
fn every_ray_hits_what_whole_numbers_say() {
    for (seed, origin) in [[0, 0, 0], [-999_999_000, 5, 1_000_003], [-63, 70, 130]].into_iter().enumerate() {
        let seed = seed as u64;
        let project = project(origin, seed, &random_instances(origin, seed));
        let loaded = load(&project);
        let frames = loaded.instances.frames(|_| None);
        let rays = rays_for(&loaded, &frames);
        assert_eq!(rays.len(), RAYS);
        fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();
        let mut session = open(&project);
        let found = hits(&mut session);
        let [world, lattice, free] = judge(&session, &frames, &rays, &found);
        assert!(world > 300 && lattice > 150 && free > 300, "{world} {lattice} {free} of {RAYS}");
        assert_silent(&session);
    }
}

#[test]
fn thousands_of_them_are_exact() {
    let instances = r#"[[instances]]
model = "crate"
position = [-200, -3, -200]
yaw = 30
count = [32, 1, 32]
step = [12.5, 0, 12.75]
[[instances]]
model = "crate"
position = [-200, 20, -200]
count = [32, 3, 32]
step = [13, 15, 14]
"#;
    let project = project([0; 3], 9, instances);
    let loaded = load(&project);
    assert_eq!(loaded.instances.list.len(), 4096);
    let frames = loaded.instances.frames(|_| None);
    assert!(frames[..1024].iter().all(|frame| matches!(frame.turn, Rotation::Free(_))));
    // From above all of them, at one of them.
    let mut random = Random::new(12);
    let rays: Vec<Ray> = (0..RAYS)
        .map(|_| {
            let target = frames[random.below(4096) as usize].cell;
            let mut around = |range: i32| random.below(range as u64) as i32 - range / 2;
            let cell = [target[0] + around(600), 320 + around(200), target[2] + around(600)];
            let dir = std::array::from_fn(|axis| (target[axis] - cell[axis]) as f32 + around(7) as f32 / 3.0);
            Ray::new(cell, [random.unit(), random.unit(), random.unit()], dir)
        })
        .collect();
    fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();
    let mut session = open(&project);
    let found = hits(&mut session);
    let [_, lattice, free] = judge_some(&session, &frames, &rays, &found);
    assert!(lattice > 100 && free > 3, "{lattice} {free}");
    assert_silent(&session);
}
