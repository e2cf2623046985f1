//! Devices that can less than the one that the tests run on (`common/lesser.rs`): a graph that fits is drawn, and what does not fit is refused with
//! the limit's name. Never does the driver see what it says it cannot do, and the validation layer stays silent.
//!
//! `cargo test --profile checked --test devices -- --ignored` tries every graph that ships.
#![cfg(target_os = "linux")]

mod common;

use std::path::{Path, PathBuf};

use common::{EXCEEDED, LEAST, Lesser, METAL, METAL_12, Project, Run, SLOW_DRIVER, SMALL, command, output};

/// What a device lacks: a format, a feature or memory; threads in a workgroup, shared bytes, bindings.
const REFUSED: [&str; 4] = ["RX0410", "RX0175", "RX0176", "RX0183"];

/// The shipped project, behind a library that lowers the device.
fn behind(lesser: &Lesser) -> (Project, PathBuf) {
    let project = Project::shipped();
    project.copy_folder("textures");
    let library = lesser.library(&project);
    (project, library)
}

fn run((project, library): &(Project, PathBuf), arguments: &[&str]) -> Run {
    let mut command = command(project.root(), arguments);
    output(command.env("LD_PRELOAD", library)).into()
}

/// Whether a graph runs on the device; if not, it says why.
fn fits(shipped: &(Project, PathBuf), graph: &str) -> bool {
    fits_over(
        shipped,
        graph,
        if graph.ends_with("lum_live.toml") { "worlds/meadow.toml" } else { "worlds/valley.toml" },
    )
}

fn fits_over(shipped: &(Project, PathBuf), graph: &str, world: &str) -> bool {
    let run = run(shipped, &["render", graph, "--world", world, "--size", "32x18", "--validate", "-o", "out.png"]);
    assert_ne!(run.code, EXCEEDED, "{graph}: {}", run.stderr);
    if run.code == 0 {
        return true;
    }
    assert_eq!(run.code, 3, "{graph}: {}", run.stderr);
    assert!(REFUSED.iter().any(|code| run.stderr.contains(code)), "{graph}: {}", run.stderr);
    false
}

/// Graphs that run on whatever has Vulkan 1.3.
const EVERYWHERE: [&str; 4] =
    ["graphs/primary.toml", "graphs/inspect.toml", "graphs/examples/queue.toml", "graphs/examples/world_size.toml"];

#[test]
fn graphs_without_demands_run_on_the_least_device() {
    let shipped = behind(&LEAST);
    for graph in EVERYWHERE {
        assert!(fits(&shipped, graph), "{graph}");
    }
    assert!(!fits(&shipped, "graphs/light/face_cache.toml"));
}

/// Over a world with models that move, where passes bind most.
#[test]
fn the_light_of_pictures_runs_on_a_small_device() {
    let shipped = behind(&SMALL);
    for graph in ["graphs/light/face_cache.toml", "graphs/beauty.toml"] {
        assert!(fits_over(&shipped, graph, "worlds/fair.toml"), "{graph}");
    }
}

/// A driver of Vulkan 1.2 does if it has the extensions that became a part of 1.3.
#[test]
fn vulkan_1_2_with_extensions_is_enough() {
    let shipped = behind(&METAL_12);
    for graph in EVERYWHERE.iter().chain(&["graphs/beauty.toml"]) {
        assert!(fits(&shipped, graph), "{graph}");
    }
    let found = run(&shipped, &["doctor", "--format", "json"]).exits(0).json();
    let devices = found.iter().find(|line| line["what"] == "devices").unwrap()["finding"].to_string();
    assert!(devices.contains("Vulkan 1.2): chosen"), "{devices}");
}

/// Subgroups of 4, 8 and 16 invocations: those of the software driver are as wide as its vectors, of 32 bits a lane. With wider ones it names sizes
/// of 32 and 64, and runs subgroups of 16: a driver that claims what it does not do, in the votes and ballots of packets.
#[test]
fn the_size_of_subgroups_changes_no_ray_and_no_picture() {
    let project = Project::shipped();
    let mut pictures = Vec::new();
    for (bits, rays) in [
        ("128", "this device has subgroups of 4\n"),
        ("256", "this device has subgroups of 8\n"),
        ("512", "this device has subgroups of 16\n"),
        ("1024", "in packets of 16 × 16, by subgroups of 32\n"),
        ("2048", "in packets of 16 × 16, by half of each subgroup of 64\n"),
    ] {
        let on = |arguments: &[&str]| -> Run {
            let mut command = command(project.root(), &[arguments, &["--device", "llvmpipe"]].concat());
            output(command.env("LP_NATIVE_VECTOR_WIDTH", bits)).into()
        };
        let said = on(&["doctor"]).exits(0).stdout;
        assert!(said.contains(rays), "{said}");
        if rays.starts_with("in packets") {
            // What votes and ballots decide; the other rows take minutes at these widths.
            let packets = "tree64:packet,tree64:parallel,tree64:parallel_any,flat64:refill";
            on(&["stress", "--rays", "1e4", "--scenes", "dust@near", "--layouts", packets]).exits(0);
        } else {
            on(&["stress", "--rays", "2e3", "--scenes", "dust", "--validate"]).exits(0);
        }
        let picture =
            ["render", "graphs/primary.toml", "--world", "worlds/valley.toml", "--size", "96x54", "-o", "p.png"];
        on(&picture).exits(0);
        pictures.push(std::fs::read(project.path("p.png")).unwrap());
    }
    assert!(pictures.iter().all(|picture| *picture == pictures[0]));
}

#[test]
fn the_doctor_says_what_a_graph_needs_and_the_device_lacks() {
    let shipped = behind(&SMALL);
    let good = run(&shipped, &["doctor", "--graph", "graphs/primary.toml", "--format", "json"]).exits(0).json();
    let graph = good.iter().find(|line| line["what"] == "graph").unwrap();
    assert_eq!(graph["state"], "ok", "{good:?}");
    let poor = ["doctor", "--graph", "graphs/rivals/light/gi_svgf.toml", "--format", "json"];
    let poor = run(&shipped, &poor).exits(3).json();
    let state = |what: &str| poor.iter().find(|line| line["what"] == what).map(|line| line["state"].clone()).unwrap();
    assert_eq!(state("storage images"), "bad", "{poor:?}");
    assert_eq!(state("storage buffers"), "ok", "{poor:?}");
    assert_eq!(state("graph"), "bad", "{poor:?}");
    // What is wrong in its files is said once.
    let none = run(&shipped, &["doctor", "--graph", "graphs/none.toml"]).exits(3).stderr;
    assert_eq!(none.matches("`graphs/none.toml` does not exist").count(), 1, "{none}");
}

/// Nobody waits for a driver that compiles for long without knowing for what. Where nobody watches, half a minute may pass.
#[test]
fn a_pipeline_that_takes_long_is_named() {
    let slow = behind(&SLOW_DRIVER);
    let render = ["render", "graphs/inspect.toml", "--size", "32x18", "-o", "out.png"];
    let told = run(&slow, &[&render[..], &["--verbose"]].concat()).exits(0).stderr;
    assert!(told.contains("the driver has compiled pass `inspect` for 1 s; pipelines left: 1\n"), "{told}");
    let quiet = run(&slow, &render).exits(0).stderr;
    assert!(!quiet.contains("the driver has compiled"), "{quiet}");
    // A program that drives the session reads it as an event. Its stdin has ended, so it quits at once.
    let events = run(&slow, &["control", "graphs/inspect.toml", "--size", "32x18"]).exits(0).json();
    let compiling = serde_json::json!({ "event": "compiling", "pass": "inspect", "seconds": 1, "left": 1 });
    assert_eq!(events.first(), Some(&compiling), "{events:?}");
    assert_eq!(events[1]["event"], "ready", "{events:?}");
}

#[test]
fn stress_leaves_out_what_the_device_cannot_run_and_is_right_in_the_rest() {
    let shipped = behind(&LEAST);
    let run = run(&shipped, &["stress", "--rays", "2e3", "--scenes", "dust"]);
    assert_ne!(run.code, EXCEEDED, "{}", run.stderr);
    assert!([0, 3, 4].contains(&run.code), "{} {}\n{}", run.code, run.stdout, run.stderr);
}

/// Which of all graphs that ship the device refuses.
fn refused(lesser: &Lesser) -> Vec<String> {
    let shipped = behind(lesser);
    let is_graph = |path: &String| {
        path.starts_with("graphs/")
            && !path.contains("/base/")
            && Path::new(path).extension().is_some_and(|e| e == "toml")
    };
    let graphs = shipped.0.files().into_iter().filter(is_graph);
    let refused: Vec<String> = graphs.filter(|graph| !fits(&shipped, graph)).collect();
    println!("{} refuses {}: {}", lesser.name, refused.len(), refused.join(" "));
    refused
}

#[test]
#[ignore = "minutes: every shipped graph"]
fn every_graph_runs_or_is_refused_by_the_least_device() {
    assert!(refused(&LEAST).len() <= 27);
}

#[test]
#[ignore = "minutes: every shipped graph"]
fn every_graph_runs_or_is_refused_by_a_small_device() {
    // Those that raxel is compared with may need more.
    let own = |graph: &String| !graph.starts_with("graphs/rivals/");
    assert_eq!(refused(&SMALL).into_iter().filter(own).collect::<Vec<_>>(), [""; 0]);
}

#[test]
#[ignore = "minutes: every shipped graph"]
fn every_graph_runs_or_is_refused_over_metal() {
    assert!(refused(&METAL).len() <= 8);
}
