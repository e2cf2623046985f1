//! A project: a folder with `graphs/`, `shaders/` and `worlds/`. It is found from any path inside it.

use std::path::{Component, Path, PathBuf};

use raxel_diagnostics::{Diagnostic, DiskFiles, FileError, SourceMap, codes, names};

use crate::manifest::{self, Manifest};
use crate::reload::ProjectFile;

/// The depth of the search for files in `graphs` and `worlds`. A link back to a folder above must not lead into an endless search.
const DEPTH: usize = 4;

/// A project on disk. Every path that raxel shows or keeps is relative to its root, with `/` separators.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Project {
    root: PathBuf,
}

impl Project {
    /// The project with this root folder, which must exist.
    pub fn at(root: &Path) -> Result<Self, Box<Diagnostic>> {
        match root.canonicalize() {
            Ok(root) if root.is_dir() => Ok(Self { root }),
            Ok(_) => Err(Box::new(Diagnostic::error(
                codes::session::NO_PROJECT,
                format!("`{}` is not a folder, so it is not a project", root.display()),
            ))),
            Err(error) => Err(Box::new(Diagnostic::error(
                codes::session::NO_PROJECT,
                format!("`{}` is not a project: {error}", root.display()),
            ))),
        }
    }

    /// The project around a path: the nearest folder upwards with a folder `graphs/`.
    pub fn around(path: &Path) -> Result<Self, Box<Diagnostic>> {
        let start = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let found = start.ancestors().find(|folder| folder.join("graphs").is_dir());
        match found {
            Some(root) => Self::at(root),
            None => Err(Box::new(
                Diagnostic::error(
                    codes::session::NO_PROJECT,
                    format!("`{}` is in no project: no folder above it has a `graphs` folder", path.display()),
                )
                .help("`raxel new DIR` makes a project, `raxel init` makes one of the current folder"),
            )),
        }
    }

    /// The project around a file. For a file in no project, the file's folder is the root.
    pub fn around_file(file: &Path) -> Result<Self, Box<Diagnostic>> {
        Self::around(file).or_else(|error| match file.parent() {
            Some(folder) if file.is_file() => {
                Self::at(if folder.as_os_str().is_empty() { Path::new(".") } else { folder })
            }
            _ => Err(error),
        })
    }

    /// The root folder, absolute, without symbolic links.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The path on disk of a project path.
    pub fn on_disk(&self, path: &str) -> PathBuf {
        self.root.join(path)
    }

    /// The project path of a file that a user names, relative to the current folder or to the root.
    pub fn path_of(&self, named: &Path) -> Result<String, Box<Diagnostic>> {
        let here = std::path::absolute(named).unwrap_or_else(|_| named.to_owned());
        // The file itself may not exist (yet), and may be a link: only the folder is made canonical.
        let canonical =
            |path: &Path| -> Option<PathBuf> { Some(path.parent()?.canonicalize().ok()?.join(path.file_name()?)) };
        let from_here = canonical(&here).and_then(|path| self.relative(&path));
        let from_root = || if named.is_relative() { self.relative(&canonical(&self.root.join(named))?) } else { None };
        let exists = |path: &String| self.on_disk(path).exists();
        from_here
            .clone()
            .filter(exists)
            .or_else(|| from_root().filter(exists))
            .or(from_here)
            .or_else(from_root)
            .ok_or_else(|| {
                let no_file =
                    |reason| FileError::Io(String::from(reason)).diagnostic(&named.display().to_string(), None);
                Box::new(if here.canonicalize().is_ok_and(|real| real == self.root) {
                    no_file("it is a folder")
                } else if named.to_str().is_none() {
                    no_file("its name is not UTF-8")
                } else {
                    Diagnostic::error(
                        codes::files::OUTSIDE_ROOT,
                        format!("`{}` is outside the project `{}`", named.display(), self.root.display()),
                    )
                })
            })
    }

    fn relative(&self, path: &Path) -> Option<String> {
        let inside = path.strip_prefix(&self.root).ok()?;
        let parts: Option<Vec<&str>> = inside
            .components()
            .map(|part| match part {
                Component::Normal(name) => name.to_str(),
                _ => None,
            })
            .collect();
        parts.filter(|parts| !parts.is_empty()).map(|parts| parts.join("/"))
    }

    /// Project paths of all graphs, in order of name.
    pub fn graphs(&self) -> Vec<String> {
        self.list("graphs", is_toml)
    }

    /// Project paths of all graphs in a folder such as `graphs/bench`, in order of name.
    pub fn graphs_in(&self, folder: &str) -> Vec<String> {
        self.list(folder, is_toml)
    }

    /// Project paths of all worlds, in order of name.
    pub fn worlds(&self) -> Vec<String> {
        self.list("worlds", |name| is_toml(name) && !name.ends_with(".demo.toml"))
    }

    /// Project paths of all demos, in order of name.
    pub fn demos(&self) -> Vec<String> {
        self.list("worlds", |name| name.ends_with(".demo.toml"))
    }

    /// Every demo, world and graph, those in folders below included: by kind, and each kind in order of path.
    pub fn every_file(&self) -> Vec<ProjectFile> {
        let mut worlds = self.list_below("worlds", DEPTH);
        let demos: Vec<String> = worlds.extract_if(.., |path| path.ends_with(".demo.toml")).collect();
        let graphs = self.list_below("graphs", DEPTH).into_iter().map(ProjectFile::Graph);
        demos
            .into_iter()
            .map(ProjectFile::Demo)
            .chain(worlds.into_iter().map(ProjectFile::World))
            .chain(graphs)
            .collect()
    }

    /// The TOML files of a folder, and of those in it up to a depth.
    fn list_below(&self, folder: &str, depth: usize) -> Vec<String> {
        let mut found = self.list(folder, is_toml);
        if depth > 0 {
            let inner = self.list(folder, |name| !is_toml(name));
            found.extend(inner.iter().flat_map(|folder| self.list_below(folder, depth - 1)));
        }
        found
    }

    /// Reads the project's manifest. The error has all mistakes and the texts that they point into.
    pub fn manifest(&self) -> Result<Manifest, (Vec<Diagnostic>, SourceMap)> {
        let mut texts = SourceMap::default();
        // A folder that cannot be read has no manifest; the reader of its files reports the reason.
        let Ok(files) = DiskFiles::new(&self.root) else { return Ok(Manifest::default()) };
        match manifest::read(&files, &mut texts) {
            Ok((manifest, _)) => Ok(manifest),
            Err(found) => Err((found, texts)),
        }
    }

    /// The manifest, without its mistakes: the opener of a project has reported them before.
    fn said(&self) -> Manifest {
        self.manifest().unwrap_or_default()
    }

    /// The default graph: that of the manifest, else `graphs/primary.toml`, else the only graph.
    pub fn default_graph(&self) -> Result<String, Box<Diagnostic>> {
        self.said().graph.map_or_else(|| choose("graph", "graphs/primary.toml", self.graphs()), Ok)
    }

    /// The default world: that of the manifest, else `worlds/valley.toml`, else the only world.
    pub fn default_world(&self) -> Result<String, Box<Diagnostic>> {
        self.said().world.map_or_else(|| choose("world", "worlds/valley.toml", self.worlds()), Ok)
    }

    fn list(&self, folder: &str, wanted: impl Fn(&str) -> bool) -> Vec<String> {
        let Ok(entries) = std::fs::read_dir(self.root.join(folder)) else { return Vec::new() };
        let mut found: Vec<String> = entries
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| !name.starts_with('.') && wanted(name))
            .map(|name| format!("{folder}/{name}"))
            .collect();
        found.sort();
        found
    }
}

fn is_toml(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|extension| extension == "toml")
}

/// The preferred file if it is there, else the only one.
fn choose(what: &str, preferred: &str, mut found: Vec<String>) -> Result<String, Box<Diagnostic>> {
    if found.iter().any(|path| path == preferred) {
        return Ok(preferred.to_owned());
    }
    if found.len() == 1 {
        return Ok(found.remove(0));
    }
    let diagnostic = Diagnostic::error(
        codes::session::NO_CHOICE,
        if found.is_empty() {
            format!("the project has no {what}, and none is named")
        } else {
            format!("the project has {} {what}s, and none is named", found.len())
        },
    );
    Err(Box::new(if found.is_empty() {
        diagnostic.help(format!("make `{preferred}`"))
    } else {
        diagnostic.help(format!("name one of {}", names::list(found.iter().map(String::as_str))))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_is_found_from_inside() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(folder.path().join("p/graphs")).unwrap();
        std::fs::create_dir_all(folder.path().join("p/worlds/models")).unwrap();
        std::fs::write(folder.path().join("p/graphs/a.toml"), "").unwrap();
        let root = folder.path().join("p").canonicalize().unwrap();
        for inside in ["p", "p/graphs/a.toml", "p/worlds/models", "p/graphs/not-yet.toml"] {
            assert_eq!(Project::around(&folder.path().join(inside)).unwrap().root(), root, "{inside}");
        }
        assert_eq!(Project::around(folder.path()).unwrap_err().code, codes::session::NO_PROJECT);

        let project = Project::at(&root).unwrap();
        assert_eq!(project.path_of(&root.join("graphs/a.toml")).unwrap(), "graphs/a.toml");
        assert_eq!(project.path_of(Path::new("graphs/a.toml")).unwrap(), "graphs/a.toml");
        assert_eq!(project.path_of(folder.path()).unwrap_err().code, codes::files::OUTSIDE_ROOT);

        // The root itself is inside, but no file. Every path that is shown is text.
        let refused = project.path_of(&root).unwrap_err();
        assert_eq!((refused.code, refused.message.ends_with("it is a folder")), (codes::files::UNREADABLE, true));
        #[cfg(unix)]
        {
            let name = std::os::unix::ffi::OsStrExt::from_bytes(&b"graphs/\xff.toml"[..]);
            let refused: Box<Diagnostic> = project.path_of(Path::new::<std::ffi::OsStr>(name)).unwrap_err();
            assert_eq!(refused.code, codes::files::UNREADABLE);
            assert!(refused.message.ends_with("its name is not UTF-8"), "{}", refused.message);
        }

        // A file in no project is one by itself.
        std::fs::write(folder.path().join("alone.toml"), "").unwrap();
        let alone = Project::around_file(&folder.path().join("alone.toml")).unwrap();
        assert_eq!(alone.root(), folder.path().canonicalize().unwrap());
    }

    #[test]
    fn every_file_is_listed_by_kind() {
        let folder = tempfile::tempdir().unwrap();
        let project = Project::at(folder.path()).unwrap();
        assert_eq!(project.every_file(), []);
        for path in ["graphs/b.toml", "graphs/more/a.toml", "worlds/w.toml", "worlds/w.demo.toml", "worlds/m/m.vox"] {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        let graph = |path: &str| ProjectFile::Graph(path.to_owned());
        let (demo, world) = ("worlds/w.demo.toml".to_owned(), "worlds/w.toml".to_owned());
        let expected = [ProjectFile::Demo(demo), ProjectFile::World(world), graph("graphs/b.toml")];
        assert_eq!(project.every_file(), [&expected[..], &[graph("graphs/more/a.toml")]].concat());
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(folder.path(), folder.path().join("graphs/loop")).unwrap();
            assert!(project.every_file().len() >= 4, "a link in a circle ends");
        }
    }

    #[test]
    fn the_only_graph_is_the_default() {
        let folder = tempfile::tempdir().unwrap();
        let project = Project::at(folder.path()).unwrap();
        let write = |path: &str| {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        };
        assert_eq!(project.default_graph().unwrap_err().code, codes::session::NO_CHOICE);
        write("graphs/x.toml");
        write("graphs/.x.toml.swp");
        assert_eq!(project.default_graph().unwrap(), "graphs/x.toml");
        write("graphs/y.toml");
        assert_eq!(project.default_graph().unwrap_err().help, ["name one of `graphs/x.toml`, `graphs/y.toml`"]);
        write("graphs/primary.toml");
        assert_eq!(project.default_graph().unwrap(), "graphs/primary.toml");
        write("worlds/x.demo.toml");
        assert!(project.default_world().is_err());

        // The manifest comes first; one with a mistake has no defaults, and has its own errors.
        write("worlds/w.toml");
        write("worlds/valley.toml");
        std::fs::write(folder.path().join("raxel.toml"), "graph = 'y.toml'\nworld = 'w.toml'\n").unwrap();
        assert_eq!(project.default_graph().unwrap(), "graphs/y.toml");
        assert_eq!(project.default_world().unwrap(), "worlds/w.toml");
        std::fs::write(folder.path().join("raxel.toml"), "graph = 'z.toml'\n").unwrap();
        assert_eq!(project.manifest().unwrap_err().0[0].code, codes::session::WRONG_DEFAULT);
    }
}
