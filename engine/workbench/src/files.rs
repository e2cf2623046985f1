//! The files of a project that a session can open.

use raxel_diagnostics::names::closest;
use raxel_runtime::Session;
use raxel_runtime::project::Project;
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

/// Lists the demos, worlds and graphs of a project. That reads folders, which may take longer than a frame, so another thread may do it.
#[derive(Clone, Debug)]
pub struct Lister {
    project: Project,
    /// Those that run.
    demo: Option<String>,
    world: Option<String>,
    graph: String,
}

impl Lister {
    /// Of the project of a session, and of what runs now.
    pub fn of(session: &Session) -> Self {
        Self {
            project: session.project().clone(),
            demo: session.demo().map(|demo| demo.file.clone()),
            world: session.world().path.clone(),
            graph: session.graph_path().to_owned(),
        }
    }

    /// All of them, as the folders have them now.
    pub fn list(&self) -> Vec<Openable> {
        let openable = |file: ProjectFile| {
            let runs = match &file {
                ProjectFile::Demo(path) => self.demo.as_ref() == Some(path),
                ProjectFile::World(path) => self.world.as_ref() == Some(path),
                ProjectFile::Graph(path) => self.graph == *path,
            };
            Openable { file, runs }
        };
        self.project.every_file().into_iter().map(openable).collect()
    }

    /// The file at a project path.
    ///
    /// # Errors
    /// The list has no such file: with the one that is named most like it.
    pub fn find(&self, path: &str) -> Result<ProjectFile, String> {
        let mut all = self.project.every_file();
        if let Some(at) = all.iter().position(|file| file.path() == path) {
            return Ok(all.swap_remove(at));
        }
        let like = closest(path, all.iter().map(ProjectFile::path));
        let like = like.map_or_else(String::new, |like| format!("; did you mean `{like}`?"));
        Err(format!("the project has no graph, world or demo `{path}`{like}"))
    }
}
