//! A session without a window: a param is swept, a target is read back as numbers, pictures are written.
//!
//! `cargo run --release --example headless`, in a folder with a project: it writes `sweep-0.png` to `sweep-3.png`.

use std::error::Error;
use std::path::Path;

use raxel::output::{Pending, write_picture};
use raxel::{Options, Session, Value};

fn main() -> Result<(), Box<dyn Error>> {
    // The project around the current folder, its default graph and world.
    let options = Options { size: [320, 180], ..Options::default() };
    let mut session = Session::open(options)?;

    for step in 0_u8..4 {
        session.set_param("sun_elevation", Value::F32(5.0 + 15.0 * f32::from(step)))?;
        session.frame()?;

        // The texels as they are: distances in voxels, and 0 for the sky.
        let depth = session.read_target("depth")?;
        let hits = depth.floats().into_iter().map(|texel| texel[0]).filter(|distance| *distance > 0.0);
        let nearest = hits.fold(f32::INFINITY, f32::min);
        println!("step {step}: the nearest voxel is {nearest:.1} voxels away");

        // The picture as it is displayed.
        let picture = session.read_presented()?;
        write_picture(Pending::new(Path::new(&format!("sweep-{step}.png")))?, &picture)?;
    }
    Ok(())
}
