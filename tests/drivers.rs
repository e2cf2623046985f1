//! A second driver: SwiftShader. It shares no code with lavapipe, which runs all other tests. Results of whole numbers are the same on
//! both. Results of floats differ by rounding. docs/lab/drivers.md has the differences and their reasons.
//!
//! SwiftShader comes with Chromium (Debian: `apt-get install chromium`) and with Google Chrome. `RAXEL_SECOND_DRIVER` names the manifest of another driver; where
//! it is set, a driver that is not there is an error. `./raxel test` says when there is none.
//!
//! `cargo test --profile checked --test drivers -- --ignored` tries every example.
#![cfg(target_os = "linux")]

mod common;

use std::path::{Path, PathBuf};

use common::{Project, Run, RunRaxel, command, output};

/// The places of SwiftShader in browsers. The launcher `raxel` has the same list.
const MANIFESTS: [&str; 2] =
    ["/usr/lib/chromium/vk_swiftshader_icd.json", "/opt/google/chrome/vk_swiftshader_icd.json"];

/// The manifest of the second driver; `None`, with a message on stderr, where there is none.
fn second() -> Option<PathBuf> {
    let named = std::env::var_os("RAXEL_SECOND_DRIVER").map(PathBuf::from);
    if let Some(named) = &named {
        assert!(named.exists(), "RAXEL_SECOND_DRIVER: {} is not there", named.display());
    }
    let found = named.or_else(|| MANIFESTS.iter().map(PathBuf::from).find(|manifest| manifest.exists()));
    if found.is_none() {
        eprintln!("skipped: no second Vulkan driver is here: {}", MANIFESTS.join(", "));
    }
    found
}

/// Runs the binary in a project on the second driver, or on lavapipe.
fn on(driver: Option<&Path>, project: &Project, arguments: &[&str]) -> Run {
    let mut command = command(project.root(), arguments);
    match driver {
        Some(manifest) => command.env("VK_DRIVER_FILES", manifest).env_remove("RAXEL_DEVICE"),
        None => command.env("RAXEL_DEVICE", "llvmpipe"),
    };
    output(&mut command).into()
}

/// The largest difference of two pictures that is rounding: one step of 8 bits.
const STEP: &str = "0.00393";

/// A frame of a graph on both drivers, and how far the two are apart. `Err` names the differences beyond rounding.
fn apart(driver: &Path, project: &Project, graph: &str, world: &str) -> Result<(), String> {
    let render = |driver: Option<&Path>, to: &str| {
        let run =
            on(driver, project, &["render", graph, "--world", world, "--size", "64x36", "--frames", "2", "-o", to]);
        if run.code == 0 { Ok(()) } else { Err(format!("exit code {}: {}", run.code, run.stderr)) }
    };
    render(Some(driver), "second.png")?;
    render(None, "first.png")?;
    let compared = project.raxel(&["compare", "first.png", "second.png", "--max", STEP]);
    if compared.code == 0 { Ok(()) } else { Err(format!("{}{}", compared.stdout, compared.stderr)) }
}

/// The driver is the second one, not the one that all other tests run on.
#[test]
fn rays_are_exact_on_a_second_driver() {
    let Some(driver) = second() else { return };
    let project = Project::shipped();
    let said = on(Some(&driver), &project, &["doctor"]).exits(0).stdout;
    assert!(!said.contains("llvmpipe"), "{said}");
    on(Some(&driver), &project, &["stress", "--rays", "1e3", "--scenes", "dust", "--layouts", "tree64"]).exits(0);
}

#[test]
fn a_picture_differs_by_rounding_alone_on_a_second_driver() {
    let Some(driver) = second() else { return };
    let project = Project::shipped();
    for graph in ["graphs/primary.toml", "graphs/inspect.toml", "graphs/examples/queue.toml"] {
        apart(&driver, &project, graph, "worlds/valley.toml").unwrap_or_else(|error| panic!("{graph}: {error}"));
    }
}

/// Examples whose pictures differ by more: docs/lab/drivers.md says why.
const APART: [&str; 1] = ["graphs/examples/rounds.toml"];

#[test]
#[ignore = "minutes: every example on a driver that compiles slowly"]
fn examples_differ_by_rounding_alone_on_a_second_driver() {
    let Some(driver) = second() else { return };
    let project = Project::shipped();
    project.copy_folder("textures");
    let mut found = Vec::new();
    for graph in project.files().into_iter().filter(|path| {
        Path::new(path).parent() == Some(Path::new("graphs/examples"))
            && Path::new(path).extension().is_some_and(|extension| extension == "toml")
    }) {
        // The light of pictures: its pipelines take this driver longer than a test may.
        if graph == "graphs/examples/fair.toml" {
            continue;
        }
        if let Err(error) = apart(&driver, &project, &graph, "worlds/valley.toml") {
            println!("{graph}: {error}");
            found.push(graph);
        }
    }
    assert_eq!(found, APART);
}
