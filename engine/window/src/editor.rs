//! The user's editor, opened at a place of a file.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Child, Command};

/// Editors that windows have opened and that may still run.
#[derive(Default)]
pub(super) struct Editors(Vec<Child>);

impl Editors {
    /// Opens a place, `path:line:column`, of a project at `root` in the editor that `VISUAL` or `EDITOR` names; one that runs in a terminal would
    /// have none here.
    pub(crate) fn open(&mut self, root: &Path, place: &str) -> Result<(), String> {
        let editor = ["VISUAL", "EDITOR"].into_iter().filter_map(std::env::var_os).find(|editor| !editor.is_empty());
        let Some(editor) = editor else {
            return Err("neither VISUAL nor EDITOR is set; a click on the place copies it".to_owned());
        };
        let editor = editor.to_string_lossy();
        let [program, arguments @ ..] = &arguments(&editor, root, place)[..] else {
            return Err("VISUAL and EDITOR name no program".to_owned());
        };
        let child = Command::new(program).args(arguments).spawn();
        let child = child.map_err(|error| format!("{}: {error}", program.to_string_lossy()))?;
        self.0.retain_mut(|editor| matches!(editor.try_wait(), Ok(None)));
        self.0.push(child);
        Ok(())
    }
}

/// The program with its arguments. `editor` may have arguments of its own, as in `code --wait`.
fn arguments(editor: &str, root: &Path, place: &str) -> Vec<OsString> {
    let mut words: Vec<OsString> = editor.split_whitespace().map(OsString::from).collect();
    let Some(program) = words.first() else { return words };
    let program = Path::new(program).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut parts = place.split(':');
    let (path, line, column) =
        (parts.next().unwrap_or_default(), parts.next().unwrap_or("1"), parts.next().unwrap_or("1"));
    let path = root.join(path);
    let whole = || OsString::from(format!("{}:{line}:{column}", path.display()));
    match program.as_str() {
        "code" | "code-insiders" | "codium" | "cursor" => words.extend(["-g".into(), whole()]),
        "hx" | "helix" | "subl" | "zed" => words.push(whole()),
        _ => words.extend([format!("+{line}").into(), path.clone().into_os_string()]),
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_editor_is_told_the_line_in_its_own_way() {
        let asked = |editor: &str| {
            let words = arguments(editor, Path::new("/p"), "shaders/a.comp:12:5");
            words.into_iter().map(|word| word.into_string().unwrap()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(asked("gvim"), "gvim +12 /p/shaders/a.comp");
        assert_eq!(asked("/usr/bin/emacsclient -n"), "/usr/bin/emacsclient -n +12 /p/shaders/a.comp");
        assert_eq!(asked("code --wait"), "code --wait -g /p/shaders/a.comp:12:5");
        assert_eq!(asked("hx"), "hx /p/shaders/a.comp:12:5");
        assert_eq!(asked("  "), "");
    }
}
