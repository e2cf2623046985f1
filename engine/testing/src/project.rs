//! A project in a temporary folder.

use std::ops::Deref;
use std::path::Path;

use crate::folder::{Folder, copy, files, repository};

/// A project that is gone when the test ends. What a test does with it beside its files is a trait of that test: the tests of the binary run
/// raxel in it, those of sessions open it.
pub struct Project(Folder);

impl Deref for Project {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Project {
    /// A project without a file.
    pub fn empty() -> Self {
        let folder = Folder::default();
        for sub in ["graphs", "shaders", "worlds"] {
            std::fs::create_dir(folder.path(sub)).unwrap();
        }
        Self(folder)
    }

    /// A copy of the repository's graphs, shaders and worlds.
    pub fn shipped() -> Self {
        let project = Self::empty();
        for folder in ["graphs", "shaders", "worlds"] {
            project.copy_folder(folder);
        }
        project
    }

    /// A copy of a folder of the repository that is a project.
    pub fn copy_of(folder: &str) -> Self {
        let project = Self::empty();
        copy(&repository().join(folder), project.root());
        project
    }

    /// The path of every file of it, in order, without the `.raxel` folder.
    pub fn files(&self) -> Vec<String> {
        let inside = |path: &String| !Path::new(path).iter().any(|part| part == ".raxel");
        files(self.root()).into_iter().map(|(path, _)| path).filter(inside).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_has_the_files_that_it_was_made_of() {
        let project = Project::empty();
        assert!(project.files().is_empty());
        project.copy_file("graphs/primary.toml").write(".raxel/graph.schema.json", "{}");
        assert_eq!(project.files(), ["graphs/primary.toml"]);
        let shipped = Project::shipped().files();
        assert!(shipped.contains(&"graphs/primary.toml".to_owned()) && shipped.len() > 300, "{}", shipped.len());
        let copied = Project::copy_of("graphs/examples").files();
        assert!(copied.contains(&"mips.toml".to_owned()), "{copied:?}");
    }
}
