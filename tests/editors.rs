//! The settings of `docs/editors.md` start the language server: the extension for VS Code, and Neovim, Helix and Emacs in a terminal. An editor
//! that is not installed is left out.

mod common;

use std::cell::Cell;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{Run, output, repository};
use tempfile::TempDir;

/// Whether a program that a test needs is installed. If not, prints so.
fn is_here(program: &str) -> bool {
    // tmux has no `--version`, and the others have no `-V` that ends.
    let version = if program == "tmux" { "-V" } else { "--version" };
    let here = Command::new(program).arg(version).stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    if !here {
        eprintln!("`{program}` is not installed: nothing to try");
    }
    here
}

/// The fenced blocks of a language in a section of `docs/editors.md`.
fn blocks(section: &str, language: &str) -> Vec<String> {
    let page = fs::read_to_string(repository().join("docs/editors.md")).unwrap();
    let (_, after) = page.split_once(&format!("## {section}\n")).unwrap_or_else(|| panic!("a section {section}"));
    let section = after.split("\n## ").next().unwrap();
    let fence = format!("```{language}");
    section.split(&fence).skip(1).map(|block| block.split("\n```").next().unwrap().to_owned()).collect()
}

/// Its tests start the server that the extension asks for, and speak to it.
#[test]
fn the_extension_for_vs_code_passes_its_tests() {
    if !is_here("node") {
        return;
    }
    let mut tests = Command::new("node");
    tests.args(["--test", "test/"]).current_dir(repository().join("editors/vscode")).stdin(Stdio::null());
    let run = Run::from(output(tests.env("RAXEL", env!("CARGO_BIN_EXE_raxel")).env("RAXEL_CACHE", "off"))).exits(0);
    assert!(run.stdout.contains("fail 0") && !run.stdout.contains("pass 0"), "{}", run.stdout);
}

/// The task of the page finds what `raxel check` prints, as the extension's own matcher does.
#[test]
fn the_problem_matchers_are_one() {
    let manifest = fs::read_to_string(repository().join("editors/vscode/package.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    let task: serde_json::Value = serde_json::from_str(&blocks("VS Code", "json")[0]).unwrap();
    let own = &manifest["contributes"]["problemMatchers"][0];
    for key in ["owner", "fileLocation", "pattern"] {
        assert_eq!(own[key], task["problemMatcher"][key], "{key}");
    }
    assert_eq!(manifest["version"], env!("CARGO_PKG_VERSION"));
}

/// An editor in a terminal of tmux, over a project whose graph and shader each have a mistake.
struct Terminal {
    folder: TempDir,
    /// Editors so far. Each has a server of tmux of its own, since one that ends still takes commands for a moment.
    starts: Cell<u32>,
}

/// The graph of that project, and its shader.
const FILES: [(&str, &str); 2] = [
    (
        "graphs/a.toml",
        "name = 'a'\npresent = 'nothing'\n[[passes]]\nname = 'x'\nshader = 'x.comp'\ndispatch = [1, 1, 1]\n",
    ),
    (
        "shaders/x.comp",
        "#version 460\nlayout(local_size_x = 8) in;\nvoid main() {\n    float wide = vec3(1);\n    float length = 1;\n}\n",
    ),
];

/// The mistakes of the graph and of the shader, as messages say them, and the answers of the server to those who ask.
const NO_TARGET: &str = "no target or buffer `nothing`";
const NO_FLOAT: &str = "cannot convert";
const OF_PRESENT: &str = "shown by default";

impl Terminal {
    /// A project with these settings of an editor.
    fn over(settings: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in FILES.iter().chain(settings) {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        Self { folder, starts: Cell::new(0) }
    }

    fn tmux(&self) -> Command {
        let folder = self.folder.path();
        let binary = Path::new(env!("CARGO_BIN_EXE_raxel")).parent().unwrap();
        let mut tmux = Command::new("tmux");
        tmux.args(["-u", "-f", "/dev/null", "-L", &self.starts.get().to_string()])
            .current_dir(folder)
            .stdin(Stdio::null())
            .env_remove("TMUX");
        tmux.env("PATH", format!("{}:{}", binary.display(), std::env::var("PATH").unwrap()));
        tmux.env("TMUX_TMPDIR", folder)
            .env("HOME", folder)
            .env("XDG_CONFIG_HOME", folder)
            .env("XDG_STATE_HOME", folder);
        tmux.env("XDG_CACHE_HOME", folder)
            .env("XDG_DATA_HOME", folder)
            .env("LC_ALL", "C.UTF-8")
            .env("RAXEL_CACHE", "off");
        tmux
    }

    /// Starts an editor, in place of the one before.
    fn start(&self, editor: &str) {
        let _ = output(self.tmux().arg("kill-server"));
        self.starts.set(self.starts.get() + 1);
        let start = ["new-session", "-d", "-x", "200", "-y", "50", editor];
        Run::from(output(self.tmux().args(start))).exits(0);
    }

    /// Presses keys, by tmux's names.
    fn press(&self, keys: &[&str]) {
        Run::from(output(self.tmux().arg("send-keys").args(keys))).exits(0);
    }

    fn enter(&self, text: &str) {
        Run::from(output(self.tmux().args(["send-keys", "-l", text]))).exits(0);
    }

    fn screen(&self) -> String {
        Run::from(output(self.tmux().args(["capture-pane", "-p"]))).exits(0).stdout
    }

    /// Waits until the editor shows a text.
    #[track_caller]
    fn shows(&self, text: &str) {
        self.becomes(text, |screen| screen.contains(text));
    }

    /// Waits until something holds of the screen.
    #[track_caller]
    fn becomes(&self, what: &str, holds: impl Fn(&str) -> bool) {
        let start = Instant::now();
        loop {
            let screen = self.screen();
            if holds(&screen) {
                return;
            }
            assert!(start.elapsed() < Duration::from_secs(90), "no `{what}` in\n{}", screen.trim_end());
            std::thread::sleep(Duration::from_millis(100));
        }
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.tmux().arg("kill-server").stderr(Stdio::null()).status();
    }
}

/// The lines of the page for the version of Neovim that is here.
#[test]
fn neovim_shows_mistakes_completes_and_explains() {
    if !is_here("nvim") || !is_here("tmux") {
        return;
    }
    let version = Run::from(output(Command::new("nvim").arg("--version"))).exits(0).stdout;
    let minor = version.strip_prefix("NVIM v0.").and_then(|rest| rest.split('.').next()?.parse::<u32>().ok());
    let lines = &blocks("Neovim", "lua")[usize::from(minor.is_some_and(|minor| minor < 11))];
    let terminal = Terminal::over(&[("init.lua", lines)]);
    terminal.start("nvim -n -u init.lua shaders/x.comp +4");
    let show = |terminal: &Terminal| {
        terminal.enter(
            ":lua vim.wait(90000, function() return #vim.diagnostic.get(0) > 0 end) vim.diagnostic.open_float()",
        );
        terminal.press(&["Enter"]);
    };
    show(&terminal);
    terminal.shows(NO_FLOAT);
    terminal.start("nvim -n -u init.lua graphs/a.toml +2");
    show(&terminal);
    terminal.shows(NO_TARGET);
    terminal.enter(":lua vim.lsp.buf.hover()");
    terminal.press(&["Enter"]);
    terminal.shows(OF_PRESENT);
    // Neovim sets it from 0.8 on.
    terminal.enter(":set omnifunc=v:lua.vim.lsp.omnifunc");
    terminal.press(&["Enter"]);
    terminal.enter("Gospec");
    terminal.shows("INSERT");
    terminal.press(&["C-x", "C-o"]);
    terminal.shows("specialization");
}

#[test]
fn helix_shows_mistakes_completes_and_explains() {
    // Debian names it `hx`, as Helix itself does; others `helix`.
    let Some(editor) = ["hx", "helix"].into_iter().find(|program| is_here(program)).filter(|_| is_here("tmux")) else {
        return;
    };
    let terminal = Terminal::over(&[("helix/languages.toml", &blocks("Helix", "toml")[0])]);
    let health = |language: &str| {
        let mut health = Command::new(editor);
        health.args(["--health", language]).env("XDG_CONFIG_HOME", terminal.folder.path());
        Run::from(output(&mut health)).exits(0).stdout
    };
    for language in ["toml", "glsl"] {
        assert!(health(language).contains("raxel: "), "{}", health(language));
    }
    terminal.start(&format!("{editor} shaders/x.comp"));
    terminal.shows("●");
    terminal.enter("]d");
    terminal.shows(NO_FLOAT);
    terminal.start(&format!("{editor} graphs/a.toml"));
    terminal.shows("●");
    terminal.enter("]d");
    terminal.shows(NO_TARGET);
    terminal.enter("gh k");
    terminal.shows(OF_PRESENT);
    terminal.press(&["Escape"]);
    // Escape and the next key in one would be another key.
    terminal.becomes("no explanation", |screen| !screen.contains(OF_PRESENT));
    terminal.enter("geo");
    terminal.shows(" INS ");
    terminal.enter("spec");
    terminal.shows("specialization");
}

#[test]
fn emacs_shows_mistakes_completes_and_explains() {
    if !is_here("emacs") || !is_here("tmux") {
        return;
    }
    let version = Run::from(output(Command::new("emacs").arg("--version"))).exits(0).stdout;
    let major = version.strip_prefix("GNU Emacs ").and_then(|rest| rest.split('.').next()?.parse::<u32>().ok());
    if major.is_none_or(|major| major < 29) {
        eprintln!("this Emacs has no Eglot: nothing to try");
        return;
    }
    // The package `glsl-mode` comes from an archive. What matters is the name of its mode.
    let mode = "(define-derived-mode glsl-mode prog-mode \"GLSL\")";
    let init = blocks("Emacs", "elisp").join("\n");
    let terminal = Terminal::over(&[("mode.el", mode), ("init.el", &init)]);
    let show = |terminal: &Terminal, file: &str| {
        terminal.start(&format!("emacs -nw -q -l mode.el -l init.el {file}"));
        terminal.shows("[eglot:");
        let mistakes = |screen: &str| screen.split("Flymake[").nth(1).is_some_and(|count| !count.starts_with('0'));
        terminal.becomes("number of mistakes", mistakes);
        terminal.press(&["M-x"]);
        terminal.enter("flymake-show-buffer-diagnostics");
        terminal.press(&["Enter"]);
    };
    show(&terminal, "shaders/x.comp");
    terminal.shows(NO_FLOAT);
    show(&terminal, "graphs/a.toml");
    terminal.shows(NO_TARGET);
    terminal.press(&["C-x", "1", "M-<", "C-n"]);
    terminal.shows(OF_PRESENT);
    terminal.press(&["M->"]);
    terminal.enter("spec");
    terminal.press(&["C-M-i"]);
    terminal.shows("specialization");
}
