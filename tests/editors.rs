//! The commands of `docs/editors.md` start the language server: the extension for VS Code, and Neovim.

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use common::{Run, output, repository};

/// Whether a program that a test needs is installed. If not, prints so.
fn is_here(program: &str) -> bool {
    let here = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
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

/// The lines of the page show a mistake in a graph, for the version of Neovim that is here.
#[test]
fn neovim_shows_a_mistake() {
    if !is_here("nvim") {
        return;
    }
    let version = Run::from(output(Command::new("nvim").arg("--version"))).exits(0).stdout;
    let minor = version.strip_prefix("NVIM v0.").and_then(|rest| rest.split('.').next()?.parse::<u32>().ok());
    let lines = &blocks("Neovim", "lua")[usize::from(minor.is_some_and(|minor| minor < 11))];
    let folder = tempfile::tempdir().unwrap();
    let inside = |path: &str| folder.path().join(path);
    fs::create_dir(inside("graphs")).unwrap();
    fs::write(inside("graphs/a.toml"), "name = 'a'\npresent = 'nothing'\n").unwrap();
    fs::write(inside("init.lua"), lines).unwrap();
    let told = "lua vim.wait(60000, function() return #vim.diagnostic.get(0) > 0 end) \
                for _, told in ipairs(vim.diagnostic.get(0)) do io.stderr:write(told.lnum .. ': ' .. told.message .. '\\n') end";
    let binary = Path::new(env!("CARGO_BIN_EXE_raxel")).parent().unwrap();
    let path = format!("{}:{}", binary.display(), std::env::var("PATH").unwrap());
    let mut editor = Command::new("nvim");
    editor.args(["--headless", "-u", "init.lua", "graphs/a.toml", "-c", told, "-c", "qa!"]).current_dir(folder.path());
    editor.env("PATH", path).env("HOME", folder.path()).env("XDG_STATE_HOME", folder.path()).stdin(Stdio::null());
    let run = Run::from(output(&mut editor)).exits(0);
    assert!(run.stderr.contains("1: ") && run.stderr.contains("`nothing`"), "{}{}", run.stdout, run.stderr);
}
