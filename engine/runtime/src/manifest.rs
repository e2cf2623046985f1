//! The manifest of a project, `raxel.toml` in its root: the files that run by default.

use raxel_diagnostics::table::{Node, read_document};
use raxel_diagnostics::{Diagnostic, FileError, Files, SourceMap, codes, files};
use raxel_language::{Keys, ReadKeys};
use serde_json::Value;

use crate::present::Viewport;

/// Project path of the manifest.
pub const PATH: &str = "raxel.toml";

/// The files that run by default.
#[derive(Clone, Debug, Default, PartialEq, Keys)]
#[keys(context = Project<'_>)]
pub struct Manifest {
    /// The graph that runs when the command names none, relative to graphs/. When left out, primary.toml or the only graph.
    ///
    /// Here as a project path, like `world` and `demo`.
    #[keys(read = named("graphs"))]
    pub graph: Option<String>,
    /// The world that graphs run over when the command names none, relative to worlds/. When left out, valley.toml or the only world.
    #[keys(read = named("worlds"))]
    pub world: Option<String>,
    /// The demo that `raxel run`, `render`, `control` and `bench film` open when the command names neither file nor world, relative to
    /// worlds/. `graph` and `world` when left out.
    #[keys(read = named("worlds"))]
    pub demo: Option<String>,
    /// Width and height of pictures and films in pixels, unless the command or a demo has its own; and of a window at first.
    #[keys(range = 1..=16384, told = [1280, 720])]
    pub size: Option<[u32; 2]>,
    /// Pixels of the picture for each pixel of the window, along each axis: 0.5 computes a quarter of the pixels.
    #[keys(range = Viewport::SCALES, told = 1.0)]
    pub scale: Option<f64>,
    /// Frames a second without a window, unless the command or a demo has its own.
    #[keys(range = 1e-3..=1000.0, told = 60.0, unit = "Hz")]
    pub fps: Option<f64>,
}

/// The files of a project, which its manifest names.
struct Project<'f> {
    files: &'f dyn Files,
}

/// Reads the manifest of the project whose files these are, with its warnings, or everything that is wrong with it. Without the file there
/// is no message.
pub fn read(files: &dyn Files, texts: &mut SourceMap) -> Result<(Manifest, Vec<Diagnostic>), Vec<Diagnostic>> {
    let text = match files::read_text(files, PATH, None, texts) {
        Ok(text) => text,
        Err(error) if error.code == codes::files::NOT_FOUND => return Ok((Manifest::default(), Vec::new())),
        Err(error) => return Err(vec![*error]),
    };
    read_document(PATH, &text, texts, |root| Manifest::read_whole(root, &Project { files }))
}

/// Reads the name of a file, relative to the folder of its kind; it must be there.
fn named(folder: &str) -> impl Fn(&Node<'_, '_>, &Project<'_>) -> Option<String> {
    move |node, project| {
        let (key, text) = (&node.name, node.string()?);
        let label = || format!("relative to `{folder}/`");
        let Some(path) = files::join(folder, &text) else {
            node.report(codes::files::OUTSIDE_ROOT, format!("`{text}` leads outside the project root"), label());
            return None;
        };
        let is_demo = path.ends_with(".demo.toml");
        if folder == "worlds" && is_demo != (key == "demo") {
            let what = if is_demo { "a demo, and no world" } else { "no demo: those end in `.demo.toml`" };
            node.report(codes::session::WRONG_DEFAULT, format!("the default {key} is {what}"), label());
            return None;
        }
        if let Err(error) = project.files.read(&path) {
            let found = match error {
                FileError::NotFound => files::not_found(project.files, &path, None, folder),
                error => error.diagnostic(&path, None),
            };
            let message = format!("the default {key} {}", found.message);
            let diagnostic =
                Diagnostic::error(codes::session::WRONG_DEFAULT, message).label(node.span.clone(), label());
            node.reporter().report(found.help.into_iter().fold(diagnostic, Diagnostic::help));
            return None;
        }
        Some(path)
    }
}

/// JSON schema of `raxel.toml`.
pub fn schema() -> Value {
    Manifest::form().document("raxel project")
}

#[cfg(test)]
mod tests {
    use raxel_diagnostics::{MemoryFiles, render};

    use super::*;

    fn read_text(text: &str) -> Result<Manifest, String> {
        let project = [("graphs/a.toml", ""), ("worlds/b.toml", ""), ("worlds/c.demo.toml", ""), (PATH, text)];
        let mut texts = SourceMap::default();
        read(&MemoryFiles::new(project), &mut texts)
            .map(|(manifest, _)| manifest)
            .map_err(|found| render::short(&found, &texts))
    }

    #[test]
    fn every_key_is_read() {
        let text =
            "graph = 'a.toml'\nworld = 'b.toml'\ndemo = 'c.demo.toml'\nsize = [320, 180]\nscale = 0.5\nfps = 24\n";
        let manifest = Manifest {
            graph: Some("graphs/a.toml".to_owned()),
            world: Some("worlds/b.toml".to_owned()),
            demo: Some("worlds/c.demo.toml".to_owned()),
            size: Some([320, 180]),
            scale: Some(0.5),
            fps: Some(24.0),
        };
        assert_eq!(read_text(text), Ok(manifest));
        assert_eq!(read_text(""), Ok(Manifest::default()));
        let none: [(&str, &str); 0] = [];
        assert_eq!(read(&MemoryFiles::new(none), &mut SourceMap::default()), Ok((Manifest::default(), Vec::new())));
        // The schema has the keys that are read.
        let keys = ["demo", "fps", "graph", "scale", "size", "world"];
        let schema = schema();
        assert!(schema["properties"].as_object().unwrap().keys().all(|key| keys.contains(&key.as_str())));
        assert_eq!(schema["properties"].as_object().unwrap().len(), keys.len());
    }

    #[test]
    fn a_misspelt_file_brings_the_one_that_was_meant() {
        let root = tempfile::tempdir().unwrap();
        for path in ["graphs/deep/primary.toml", "worlds/valley.toml", "worlds/valley.demo.toml"] {
            std::fs::create_dir_all(root.path().join(path).parent().unwrap()).unwrap();
            std::fs::write(root.path().join(path), "").unwrap();
        }
        for (text, meant) in [
            ("graph = 'primry.toml'", "deep/primary.toml"),
            ("world = 'vally.toml'", "valley.toml"),
            ("demo = 'valey.demo.toml'", "valley.demo.toml"),
        ] {
            std::fs::write(root.path().join(PATH), text).unwrap();
            let files = raxel_diagnostics::DiskFiles::new(root.path()).unwrap();
            let found = read(&files, &mut SourceMap::default()).unwrap_err();
            assert_eq!(found[0].help, [format!("did you mean `{meant}`?")], "{found:?}");
            assert!(found[0].message.contains("does not exist"), "{found:?}");
        }
    }

    #[test]
    fn every_mistake_has_its_place() {
        let text = "graph = 'x.toml'\nworld = 'c.demo.toml'\ndemo = 'b.toml'\nsize = [0, 180]\nscale = 99\nfps = 'fast'\ngrahp = 1\n";
        let found = read_text(text).unwrap_err();
        for line in 1..=7 {
            assert!(found.contains(&format!("raxel.toml:{line}:")), "line {line}: {found}");
        }
        assert_eq!(found.matches("RX0460").count(), 3, "{found}");
        assert!(read_text("graph = '../../a'").unwrap_err().contains("outside"), "a way out");
        assert!(read_text("graph = ").unwrap_err().contains("raxel.toml:1:"));
    }
}
