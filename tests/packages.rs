//! The crates as packages. Each package has all of its files, and a program with only the packages renders a picture.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use common::{Run, output, repository};

/// The folder of each crate that can be published, and its manifest.
fn crates() -> Vec<(PathBuf, toml::Table)> {
    let workspace: toml::Table = fs::read_to_string(repository().join("Cargo.toml")).unwrap().parse().unwrap();
    let members = workspace["workspace"]["members"].as_array().unwrap().iter().map(|member| member.as_str().unwrap());
    let read = |folder: PathBuf| {
        let manifest: toml::Table = fs::read_to_string(folder.join("Cargo.toml")).unwrap().parse().unwrap();
        (folder, manifest)
    };
    let all = members.map(|member| repository().join(member)).chain([repository().to_owned()]).map(read);
    all.filter(|(_, manifest)| manifest["package"].get("publish").is_none()).collect()
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The path without `.` and `..`; links stay as they are.
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, component| {
        match component {
            std::path::Component::ParentDir => drop(plain.pop()),
            component => plain.push(component),
        }
        plain
    })
}

#[test]
fn no_crate_includes_a_file_from_outside() {
    let mut included = 0;
    for (folder, manifest) in crates() {
        // The root crate has its sources in `engine`, beside the other crates.
        let mut files = if folder == repository() {
            vec![folder.join("engine/lib.rs"), folder.join("engine/main.rs")]
        } else {
            vec![folder.join("build.rs")]
        };
        if folder != repository() {
            sources(&folder.join("src"), &mut files);
        }
        for file in files.into_iter().filter(|file| file.exists()) {
            let text = fs::read_to_string(&file).unwrap();
            let calls = ["include_str!(", "include_bytes!(", "include!("];
            for after in calls.iter().flat_map(|call| text.split(call).skip(1)) {
                // The first literal says where the path begins: here, or at an environment variable of the crate's own build.
                let call = after.split(')').next().unwrap();
                let Some(path) = call.split('"').nth(1).filter(|_| !call.contains("env!")) else { continue };
                included += 1;
                let path = plain(&file.parent().unwrap().join(path));
                assert!(path.starts_with(&folder), "{} includes {}", file.display(), path.display());
                if let Some(kept) = manifest["package"].get("include").and_then(toml::Value::as_array) {
                    let path = format!("/{}", path.strip_prefix(&folder).unwrap().display());
                    let is_kept = kept.iter().any(|kept| kept.as_str() == Some(&path));
                    assert!(is_kept, "`include` of {} lacks {path}", folder.display());
                }
            }
        }
    }
    assert!(included > 8, "{included}");
}

#[test]
fn every_crate_but_raxel_says_that_it_is_a_part() {
    for (folder, manifest) in crates().into_iter().filter(|(folder, _)| folder != repository()) {
        let text = fs::read_to_string(folder.join("src/lib.rs")).unwrap();
        let docs = text.lines().take_while(|line| line.starts_with("//!"));
        let says =
            docs.into_iter().any(|line| line.starts_with("//! A part of raxel. Programs use the crate `raxel`;"));
        assert!(says, "{} does not say what is promised", manifest["package"]["name"]);
    }
}

#[test]
fn every_crate_says_what_a_registry_asks_for() {
    let workspace: toml::Table = fs::read_to_string(repository().join("Cargo.toml")).unwrap().parse().unwrap();
    let version = workspace["workspace"]["package"]["version"].as_str().unwrap();
    for (name, dependency) in workspace["workspace"]["dependencies"].as_table().unwrap() {
        if dependency.get("path").is_some() {
            assert_eq!(dependency.get("version").and_then(toml::Value::as_str), Some(version), "{name}");
        }
    }
    let all = crates();
    assert!(all.len() > 30);
    for (folder, manifest) in all {
        let package = &manifest["package"];
        let name = package["name"].as_str().unwrap();
        assert!(package.get("description").is_some_and(|text| text.as_str().unwrap().len() > 10), "{name}");
        for key in ["license", "version", "rust-version"] {
            assert!(package.get(key).is_some(), "{name} has no {key}");
        }
        // crates.io refuses more keywords, and longer ones.
        let keywords = package.get("keywords").and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
        let short = |keyword: &toml::Value| keyword.as_str().is_some_and(|keyword| keyword.len() <= 20);
        assert!(keywords.len() <= 5 && keywords.iter().all(short), "{name}: {keywords:?}");
        assert!(name != "raxel" || !keywords.is_empty(), "the façade is to be found");
        // In tests the crates need each other in circles: by path alone, so that no package does.
        for (of, dependency) in manifest.get("dev-dependencies").and_then(toml::Value::as_table).into_iter().flatten() {
            let inherits = of.starts_with("raxel-") && dependency.get("path").is_none();
            assert!(!inherits, "{}: {of}", folder.display());
        }
    }
}

/// The package for Python and the extension for VS Code hold the licences themselves.
#[test]
fn copies_of_the_licences_are_copies() {
    for folder in ["python", "editors/vscode"] {
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let copy = fs::read(repository().join(folder).join(licence)).unwrap();
            assert!(copy == fs::read(repository().join(licence)).unwrap(), "{folder}/{licence}");
        }
    }
}

fn cargo(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).env("CARGO_TERM_COLOR", "never");
    command
}

#[test]
fn packages_hold_the_files_behind_links() {
    for (package, folder, file, least) in [
        ("raxel-shader", "library", "library/camera.glsl", 30),
        ("raxel-diagnostics", "pages", "pages/RX0113.md", 100),
        ("raxel-shipped", "worlds", "worlds/valley.toml", 30),
        ("raxel-shipped", "shaders", "shaders/light/beauty/compose.comp", 100),
    ] {
        let list = ["package", "--list", "--offline", "--allow-dirty", "-p", package];
        let listed = Run::from(output(&mut cargo(repository(), &list))).exits(0).stdout;
        let count = listed.lines().filter(|line| line.starts_with(&format!("{folder}/"))).count();
        assert!(listed.lines().any(|line| line == file) && count >= least, "{package}: {count} files in {folder}");
    }
}

const PROGRAM: &str = r#"
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut session = raxel::Session::open(raxel::Options { size: [64, 36], ..Default::default() })?;
    session.frame()?;
    let depth = session.read_target("depth")?;
    let hits = depth.floats().iter().filter(|texel| texel[0] < 1000.0).count();
    println!("{hits} of {}", depth.floats().len());
    Ok(())
}
"#;

/// `cargo package` of the whole workspace, unpacked into an empty folder: a program that depends on the unpacked crates alone.
/// `RAXEL_PACKAGES_TARGET` names a target folder that is kept.
#[test]
#[ignore = "compiles every dependency once more, which takes minutes"]
fn a_program_of_the_packages_alone_renders() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |path: &str| folder.path().join(path);
    let packaged = inside("packaged");
    let mut package = cargo(repository(), &["package", "--workspace", "--no-verify", "--allow-dirty", "--target-dir"]);
    Run::from(output(package.arg(&packaged))).exits(0);

    let mut patches = String::new();
    for (_, manifest) in crates() {
        let name = manifest["package"]["name"].as_str().unwrap();
        let file = packaged.join(format!("package/{name}-{}.crate", env!("CARGO_PKG_VERSION")));
        Run::from(output(Command::new("tar").arg("-C").arg(folder.path()).arg("-xzf").arg(file))).exits(0);
        let unpacked = inside(&format!("{name}-{}", env!("CARGO_PKG_VERSION")));
        patches += &format!("{name} = {{ path = {unpacked:?} }}\n");
    }
    let program = inside("program");
    let name = program.to_str().unwrap();
    common::raxel(&["new", name]).exits(0);
    fs::create_dir(program.join("src")).unwrap();
    fs::write(program.join("src/main.rs"), PROGRAM).unwrap();
    let dependency = format!("raxel = {:?}", env!("CARGO_PKG_VERSION"));
    let manifest = "[package]\nname = \"program\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\n";
    fs::write(program.join("Cargo.toml"), format!("{manifest}{dependency}\n\n[patch.crates-io]\n{patches}")).unwrap();
    // The versions that the repository is tested with.
    fs::copy(repository().join("Cargo.lock"), program.join("Cargo.lock")).unwrap();
    let target = std::env::var_os("RAXEL_PACKAGES_TARGET").map_or_else(|| inside("target"), PathBuf::from);
    let mut run = cargo(&program, &["run", "--quiet"]);
    run.env("CARGO_TARGET_DIR", target).stdout(Stdio::piped());
    let said = String::from_utf8(run.output().unwrap().stdout).unwrap();
    let (hits, all) = said.trim().split_once(" of ").unwrap_or_else(|| panic!("it said {said:?}"));
    let hits: u32 = hits.parse().unwrap();
    assert!(all == "2304" && hits > 500 && hits < 2304, "{said}");
}
