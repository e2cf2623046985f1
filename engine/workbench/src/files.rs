//! The files of a project that a session can open.

use raxel_diagnostics::names::closest;
use raxel_runtime::Session;
use raxel_runtime::reload::ProjectFile;

/// A file that can be opened in place of what runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Openable {
    /// The file.
    pub file: ProjectFile,
    /// It runs now.
    pub runs: bool,
}

impl Openable {
    /// Its kind in one word: `graph`, `world` or `demo`.
    pub fn kind(&self) -> &'static str {
        match self.file {
            ProjectFile::Demo(_) => "demo",
            ProjectFile::World(_) => "world",
            ProjectFile::Graph(_) => "graph",
        }
    }
}

/// The demos, worlds and graphs of a session's project.
pub fn list(session: &Session) -> Vec<Openable> {
    let demo = session.demo().map(|demo| demo.file.as_str());
    let world = session.world().path.as_deref();
    let openable = |file: ProjectFile| {
        let runs = match &file {
            ProjectFile::Demo(path) => demo == Some(path),
            ProjectFile::World(path) => world == Some(path),
            ProjectFile::Graph(path) => session.graph_path() == path,
        };
        Openable { file, runs }
    };
    session.project().every_file().into_iter().map(openable).collect()
}

/// The file at a project path.
///
/// # Errors
/// The list has no such file: with the one that is named most like it.
pub fn find(session: &Session, path: &str) -> Result<ProjectFile, String> {
    let mut all = session.project().every_file();
    if let Some(at) = all.iter().position(|file| file.path() == path) {
        return Ok(all.swap_remove(at));
    }
    let like = closest(path, all.iter().map(ProjectFile::path));
    let like = like.map_or_else(String::new, |like| format!("; did you mean `{like}`?"));
    Err(format!("the project has no graph, world or demo `{path}`{like}"))
}
