//! The rays of camera.glsl on a device and of the oracle are the same bits.

mod common;

use common::Project;
use raxel_gpu::Validation;
use raxel_oracle::camera::Pinhole;
use raxel_runtime::camera::Camera;
use raxel_runtime::{Options, Session};

const GRAPH: &str = include_str!("fixtures/camera/rays.toml");

const SHADER: &str = include_str!("fixtures/camera/rays.comp");

#[test]
fn a_device_and_the_oracle_make_the_same_rays() {
    let project = Project::empty();
    project.write("graphs/rays.toml", GRAPH).write("shaders/rays.comp", SHADER);
    for (size, fov, angles) in
        [([317, 211], 0.3, [0.0, 0.0]), ([64, 640], 1.1, [2.0, -1.3]), ([1920, 5], 2.8, [-0.4, 0.01])]
    {
        let options = Options {
            project: Some(project.root().into()),
            graph: Some(project.path("graphs/rays.toml")),
            size,
            validation: Validation::Required,
            ..Options::default()
        };
        let mut session = Session::open(options).expect("the graph runs");
        let mut camera = Camera::at([1000.25, -3.5, 7.75]);
        (camera.fov, camera.yaw, camera.pitch) = (fov, angles[0], angles[1]);
        session.set_camera(camera);
        session.frame().expect("a frame");
        let texels = session.read_target("direction").expect("the target");
        let pinhole = Pinhole {
            cell: camera.cell,
            frac: camera.frac,
            view_to_world: camera.view_to_world(),
            tan_half_fov: camera.tan_half_fov(f64::from(size[0]) / f64::from(size[1])),
        };
        let found: Vec<[u32; 4]> = texels.bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
        let rays = pinhole.rays(size);
        assert_eq!(found.len(), rays.len());
        for (i, (found, ray)) in found.iter().zip(&rays).enumerate() {
            assert_eq!(found[..3], ray.dir.map(f32::to_bits), "pixel {i} of {size:?}: {ray:?}");
        }
        assert_eq!(session.device().log().take(), []);
    }
}
