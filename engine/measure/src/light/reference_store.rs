//! Keeps references on disk, in `.raxel/cache/light` of the project, so that they are made once. The name is a hash of everything that they
//! depend on.

use std::fs;
use std::path::{Path, PathBuf};

use raxel_runtime::Session;

use super::reference::{About, References};
use super::{DeviceName, Effort, Picture, Scene};

/// Where a reference lies, or will.
pub(super) struct Place {
    path: PathBuf,
}

impl Place {
    /// Of the reference that a session of its graph would make: by device and driver, effort, ε, camera, params, graph, shaders, the files of the world,
    /// and every voxel of one that is not streamed.
    pub(super) fn of(session: &Session, scene: &Scene, effort: &Effort) -> Self {
        let mut hasher = blake3::Hasher::new();
        let mut part = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        let device = DeviceName::of(session.device());
        part(device.name.as_bytes());
        part(device.driver.as_bytes());
        part(format!("{:?} {:?} {:?} {:?}", effort.size, effort.goal, effort.most_paths, scene.epsilon).as_bytes());
        part(format!("{:?}", session.camera()).as_bytes());
        part(&serde_json::to_vec(&**session.graph()).unwrap_or_default());
        for pass in &session.graph().passes {
            part(&pass.shader.key);
        }
        for param in session.params() {
            let value = session.param(&param.name).ok();
            part(format!("{} {value:?}", param.name).as_bytes());
        }
        for file in &session.world().loaded().files {
            part(&fs::read(session.project().on_disk(file)).unwrap_or_default());
        }
        if let Some(streamed) = session.world().streamed() {
            part(format!("{:?} {:?}", streamed.settings, streamed.generator.fingerprint()).as_bytes());
        }
        let world = session.world().voxels();
        part(format!("{:?}", world.materials()).as_bytes());
        for (cell, material) in world.voxels() {
            hasher.update(bytemuck::bytes_of(&cell.to_array()));
            hasher.update(&material.to_le_bytes());
        }
        let name = format!(".raxel/cache/light/{}.reference", hasher.finalize().to_hex());
        Self { path: session.project().on_disk(&name) }
    }

    /// The kept references, if they are whole: their pictures have the recorded hashes.
    pub(super) fn read(&self, scene: &str) -> Option<References> {
        let bytes = fs::read(&self.path).ok()?;
        let line = bytes.iter().position(|byte| *byte == b'\n')?;
        let mut about: About = serde_json::from_slice(&bytes[..line]).ok()?;
        let texels: Vec<f32> =
            bytes[line + 1..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        let pixels = about.size[0] as usize * about.size[1] as usize;
        if pixels.checked_mul(2 * 3) != Some(texels.len()) {
            return None;
        }
        let half = |texels: &[f32]| Picture {
            size: about.size,
            texels: texels.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect(),
        };
        let halves = [half(&texels[..3 * pixels]), half(&texels[3 * pixels..])];
        if [halves[0].hash(), halves[1].hash()] != about.hashes {
            return None;
        }
        // The same view may have another name.
        scene.clone_into(&mut about.scene);
        about.kept = true;
        Some(References { halves, about })
    }

    /// Keeps a reference. A folder that cannot be written costs the next run its time, and this one nothing.
    pub(super) fn write(&self, references: &References) {
        let Ok(mut bytes) = serde_json::to_vec(&references.about) else { return };
        bytes.push(b'\n');
        for half in &references.halves {
            bytes.extend(half.texels.iter().flatten().flat_map(|channel| channel.to_le_bytes()));
        }
        let folder = self.path.parent().unwrap_or(Path::new("."));
        // A run that is broken off leaves no half of a file under the name.
        let part = self.path.with_extension(format!("{}.part", std::process::id()));
        let written = fs::create_dir_all(folder).and_then(|()| fs::write(&part, bytes));
        if written.and_then(|()| fs::rename(&part, &self.path)).is_err() {
            let _ = fs::remove_file(&part);
        }
    }
}
