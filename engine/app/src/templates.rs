//! The starting points of `raxel new` and `raxel init`: files that raxel ships, and files of the templates' own.

/// A starting point for a new project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Template {
    /// A traced voxel world with sun, shadow and sky.
    #[value(alias = "primary")]
    Voxel,
    /// A voxel world lit as in the README's picture: global illumination, sky, mist, automatic exposure.
    Beauty,
    /// A voxel world with a glow around bright places: a chain of mips over the picture.
    Post,
    /// Two chemicals that spread and react: state that lasts from step to step; no world.
    Simulation,
    /// One pass that paints the screen; no world.
    Minimal,
}

/// Of the files that raxel ships: folders end in `/`.
const VOXEL: &[&str] = &[
    "graphs/primary.toml",
    "shaders/packet.comp",
    "shaders/packet_rest.comp",
    "shaders/primary.comp",
    "shaders/trace.comp",
    "worlds/valley.toml",
    "worlds/models/tree.vox",
    "worlds/models/pine.vox",
    "raxel.toml",
];

const BEAUTY: &[&str] = &[
    "graphs/beauty.toml",
    "graphs/light/face_cache.toml",
    "graphs/light/base/",
    "shaders/light/beauty/",
    "shaders/light/face_cache/",
    "shaders/light/sky/",
    "shaders/light/change.glsl",
    "shaders/light/display.comp",
    "shaders/light/frame.glsl",
    "shaders/light/moved.glsl",
    "shaders/light/path.glsl",
    "shaders/light/poses.comp",
    "shaders/light/remember.comp",
    "shaders/light/renew.glsl",
    "shaders/light/scene.glsl",
    "shaders/light/see.comp",
    "shaders/light/shade.comp",
    "shaders/light/stirred.glsl",
    "shaders/light/sun_history.comp",
    "shaders/light/watch.comp",
    "worlds/dusk.demo.toml",
    "worlds/valley.toml",
    "worlds/models/tree.vox",
    "worlds/models/pine.vox",
];

/// A file: its path in the project and its bytes.
pub(crate) type File = (&'static str, &'static [u8]);

macro_rules! own {
    ($($folder:literal: $($path:literal)*;)*) => { &[$($(
        ($path, include_bytes!(concat!("../templates/", $folder, "/", $path)).as_slice()),
    )*)*] };
}

const VOXEL_OWN: &[File] = own!["voxel": "README.md";];
const BEAUTY_OWN: &[File] = own!["beauty": "README.md" "raxel.toml";];
const POST_OWN: &[File] = own![
    "post": "README.md" "raxel.toml" "graphs/glow.toml" "shaders/add.comp" "shaders/bright.comp" "shaders/down.comp" "shaders/up.comp";
];
const SIMULATION_OWN: &[File] = own![
    "simulation": "README.md" "raxel.toml" "graphs/spots.toml" "shaders/react.comp" "shaders/show.comp";
];
const MINIMAL_OWN: &[File] = own!["minimal": "README.md" "raxel.toml" "graphs/primary.toml" "shaders/paint.comp";];
const EVERY: File = (".gitignore", include_bytes!("../templates/gitignore"));

impl Template {
    /// Its files. A file of the template's own stands for one that raxel ships.
    pub(crate) fn files(self) -> Vec<File> {
        let (shipped, own) = match self {
            Template::Voxel => (VOXEL, VOXEL_OWN),
            Template::Beauty => (BEAUTY, BEAUTY_OWN),
            Template::Post => (VOXEL, POST_OWN),
            Template::Simulation => (&[][..], SIMULATION_OWN),
            Template::Minimal => (&[][..], MINIMAL_OWN),
        };
        let named = |path: &str| {
            let is_it = |name: &&str| path == *name || (name.ends_with('/') && path.starts_with(*name));
            shipped.iter().any(is_it) && own.iter().all(|(replaced, _)| *replaced != path)
        };
        let shipped = raxel_shipped::FILES.iter().copied().filter(|(path, _)| named(path));
        shipped.chain(own.iter().copied()).chain([EVERY]).collect()
    }

    /// Whether its graph shows a world.
    pub(crate) fn has_world(self) -> bool {
        matches!(self, Template::Voxel | Template::Beauty | Template::Post)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A name that leads to no file would leave a hole in the project.
    #[test]
    fn every_name_is_shipped() {
        for name in VOXEL.iter().chain(BEAUTY) {
            let is_it = |path: &str| path == *name || (name.ends_with('/') && path.starts_with(name));
            assert!(raxel_shipped::FILES.iter().any(|(path, _)| is_it(path)), "{name}");
        }
        for template in <Template as clap::ValueEnum>::value_variants() {
            let mut paths: Vec<&str> = template.files().iter().map(|(path, _)| *path).collect();
            let all = paths.len();
            paths.sort_unstable();
            paths.dedup();
            assert_eq!(paths.len(), all, "{template:?} has a file twice");
            assert!(paths.contains(&"raxel.toml") && paths.contains(&"README.md"), "{template:?}");
        }
    }
}
