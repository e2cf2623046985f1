//! `raxel new --model FILE.vox`: a `MagicaVoxel` scene on a floor, as the world of a new project.

use std::path::Path;

use raxel_terminal::console::Console;
use raxel_terminal::failure::{Failure, Result};

use crate::verbs::world::import;

/// The files that a model adds to a project.
pub(crate) struct OwnModel {
    /// A bare TOML key: the name of the world and of the model.
    name: String,
    vox: Vec<u8>,
    /// Voxels along each axis.
    size: [u64; 3],
}

impl OwnModel {
    /// Reads a scene whole: a broken one makes no project.
    pub(crate) fn read(file: &Path, console: &Console) -> Result<Self> {
        let name = import::name_of(file)?;
        if ["valley", "tree", "pine"].contains(&name.as_str()) {
            return Err(Failure::usage(format!("a file of the template is called `{name}` already"))
                .help("give the model another name"));
        }
        let vox = import::read(file, console)?;
        let world = import::scene(&vox, file, 0, console)?;
        let Some(bounds) = world.info().bounds else {
            return Err(Failure::usage(format!("`{}` has no voxel", file.display())));
        };
        Ok(Self { name, vox, size: bounds.size() })
    }

    /// The model, its world, and the manifest with that world.
    pub(crate) fn files(&self, manifest: &str) -> [(String, Vec<u8>); 3] {
        let world = |line: &str| line.starts_with("world ");
        let mut lines: Vec<String> = manifest.lines().filter(|line| !world(line)).map(str::to_owned).collect();
        let at = lines.iter().position(|line| line.starts_with("graph ")).map_or(lines.len(), |at| at + 1);
        lines.insert(at, format!("world = \"{}.toml\"", self.name));
        [
            (format!("worlds/models/{}.vox", self.name), self.vox.clone()),
            (format!("worlds/{}.toml", self.name), self.world().into_bytes()),
            ("raxel.toml".to_owned(), (lines.join("\n") + "\n").into_bytes()),
        ]
    }

    /// A floor around the model, and a camera that sees all of the model.
    fn world(&self) -> String {
        let Self { name, size, .. } = self;
        // `origin` below is the place of the centre of the model's lowest layer.
        let [width, height, depth] = size.map(|side| side as f64);
        let middle = [0.0, height / 2.0, 0.0];
        // Half of the diagonal is the model's radius; at 45 degrees, 2.6 radii are just enough to see the whole sphere around it.
        let radius = (width * width + height * height + depth * depth).sqrt() / 2.0;
        let eye = [-1.25 * radius, middle[1] + radius, 2.1 * radius];
        let margin = (3.0 * width.max(depth)).min(256.0);
        let vector = |[x, y, z]: [f64; 3]| format!("[{x:.1}, {y:.1}, {z:.1}]");
        let corner = |[x, y, z]: [f64; 3]| format!("[{x:.0}, {y:.0}, {z:.0}]");
        format!(
            "#:schema ../.raxel/world.schema.json\n\
             name  = \"{name}\"\n\
             about = \"A model on a floor\"\n\n\
             [camera]\n\
             position = {}\n\
             look_at  = {}\n\
             fov      = 45.0                # degrees, from bottom to top\n\n\
             [materials]\n\
             floor = {{ albedo = \"#b9b2a3\", roughness = 0.9 }}\n\n\
             [models.{name}]\n\
             file = \"models/{name}.vox\"\n\n\
             [[build]]\n\
             op       = \"box\"\n\
             min      = {}\n\
             max      = {}\n\
             material = \"floor\"\n\n\
             [[build]]\n\
             op     = \"model\"\n\
             model  = \"{name}\"\n\
             origin = [0, 0, 0]\n",
            vector(eye),
            vector(middle),
            corner([-width / 2.0 - margin, -4.0, -depth / 2.0 - margin]),
            corner([width / 2.0 + margin, 0.0, depth / 2.0 + margin]),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_manifest_names_the_world_once() {
        let model = OwnModel { name: "mine".to_owned(), vox: Vec::new(), size: [3, 9, 3] };
        let manifest = "#:schema x\ngraph = \"beauty.toml\"\nworld = \"valley.toml\"   # why\nsize = [1, 1]\n";
        let [_, (world, text), (_, manifest)] = model.files(manifest);
        assert_eq!(manifest, b"#:schema x\ngraph = \"beauty.toml\"\nworld = \"mine.toml\"\nsize = [1, 1]\n");
        assert_eq!(world, "worlds/mine.toml");
        assert!(String::from_utf8(text).unwrap().contains("file = \"models/mine.vox\""));
    }
}
