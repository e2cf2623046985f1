//! Devices with lower limits than the one that runs the tests (`common/lesser.rs`). raxel draws a graph that fits, and refuses any other with the
//! limit's name. The driver never gets a request beyond its limits, and the validation layer stays silent.
//!
//! `cargo test --profile checked --test devices -- --ignored` tries every graph that ships.
#![cfg(target_os = "linux")]

mod common;

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use common::{
    ACCELERATOR, ADRENO_7, DEVICES, Display, EXCEEDED, Feature, INTEL_XE, KnownDevice, LEAST, Lesser, MALI_G52, METAL,
    METAL_12, POWERVR, Project, RASPBERRY_4, Run, RunRaxel, Running, SMALL, TOO_OLD, WINDOWLESS, command, eventually,
    output, random_device, repository,
};
use raxel_diagnostics::Diagnostic;
use raxel_terminal::offline::OfflineProject;
use raxel_testing::Random;
use serde_json::json;

/// What a device lacks: a format, a feature or memory; texels, layers, bytes of a buffer; workgroups, threads in one, pushed bytes, bytes of a block,
/// shared bytes, bindings.
const REFUSED: [&str; 10] =
    ["RX0410", "RX0170", "RX0171", "RX0173", "RX0174", "RX0175", "RX0176", "RX0177", "RX0180", "RX0183"];

/// The shipped project, behind a library that lowers the device.
fn behind<'a>(lesser: impl Into<Lesser<'a>>) -> (Project, PathBuf) {
    let lesser: Lesser<'_> = lesser.into();
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
    fits_over(shipped, graph, world_of(graph))
}

/// The world that a graph is drawn over.
fn world_of(graph: &str) -> &'static str {
    if graph.ends_with("lum_live.toml") { "worlds/meadow.toml" } else { "worlds/valley.toml" }
}

fn fits_over(shipped: &(Project, PathBuf), graph: &str, world: &str) -> bool {
    let run = run(shipped, &["render", graph, "--world", world, "--size", "32x18", "--validate", "-o", "out.png"]);
    assert_ne!(run.code, EXCEEDED, "{graph}: {}", run.stderr);
    if run.code == 0 {
        return true;
    }
    assert_refused(graph, &run);
    false
}

/// The reason is a limit, a feature or a format. Each error has a help.
fn assert_refused(graph: &str, run: &Run) {
    assert_eq!(run.code, 3, "{graph}: {}", run.stderr);
    let errors = run.stderr.matches("error[").count();
    let known = REFUSED.iter().map(|code| run.stderr.matches(&format!("error[{code}]")).count()).sum::<usize>();
    assert!(errors > 0 && errors == known, "{graph}: {}", run.stderr);
    assert_eq!(run.stderr.matches("\nhelp: ").count(), errors, "{graph}: {}", run.stderr);
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

/// Subgroups of 4, 8 and 16 invocations: those of the software driver are as wide as its vectors, of 32 bits a lane. With wider vectors it claims
/// sizes of 32 and 64, but runs subgroups of 16. So the votes and ballots of packets meet a driver whose claims are false. Newer ones (Mesa 25)
/// end the process there.
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
        if rays.starts_with("in packets") && !said.contains("llvmpipe Mesa 22.") {
            println!("vectors of {bits} bits are left out");
            continue;
        }
        if rays.starts_with("in packets") {
            // Rows that depend on votes and ballots. The other rows take minutes at these widths.
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

/// A clock of 36 bits begins again at 0 every hour, here in every frame: the first pass takes its time all the same.
#[test]
fn times_go_on_when_the_clock_begins_again() {
    let shipped = behind(&INTEL_XE);
    let picture = ["render", "graphs/primary.toml", "--world", "worlds/menger.toml", "--size", "96x54", "-o", "p.png"];
    let rendered = run(&shipped, &[&picture[..], &["--time", "--format", "json"]].concat()).exits(0).json();
    let passes = rendered.iter().find_map(|line| line["passes"].as_array()).expect("times of passes");
    let times: Vec<f64> = passes.iter().filter_map(|pass| pass["milliseconds"].as_f64()).collect();
    assert!(!times.is_empty() && times.iter().all(|time| *time > 0.0), "{rendered:?}");
}

/// A window over a driver of Vulkan 1.2 shows what `render` writes. A queue that does not draw cannot bring a picture to a window, nor can a driver
/// that knows no windows; both are named.
#[test]
fn a_window_opens_on_a_device_of_vulkan_1_2_and_says_why_it_does_not_on_others() {
    let display = Display::start();
    let open = |(project, library): &(Project, PathBuf)| {
        let scene = ["graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "160x90"];
        let run = [&["run"], &scene[..], &["--no-panels", "--present-with", "own", "--validate"]].concat();
        let mut command = command(project.root(), &run);
        command.env("LD_PRELOAD", library).env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        command.stderr(File::create(project.path("log")).unwrap());
        Running::start(&mut command)
    };
    let log = |(project, _): &(Project, PathBuf)| std::fs::read_to_string(project.path("log")).unwrap();
    let shipped = behind(&METAL_12);
    run(
        &shipped,
        &["render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "160x90", "-o", "p.png"],
    )
    .exits(0);
    let picture: Vec<[u8; 3]> =
        image::open(shipped.0.path("p.png")).unwrap().into_rgb8().pixels().map(|pixel| pixel.0).collect();
    let mut child = open(&shipped);
    eventually("the picture", || child.ended() || display.pixels(160, 90) == picture);
    assert!(!child.ended(), "{}", log(&shipped));
    drop(child);
    for (lesser, why) in
        [(ACCELERATOR, "its queue computes and does not draw"), (WINDOWLESS, "its driver has no VK_KHR_swapchain")]
    {
        let shipped = behind(&lesser);
        let mut child = open(&shipped);
        eventually("an end", || child.ended());
        assert_eq!(child.finish().code(), Some(4), "{}", log(&shipped));
        let said = log(&shipped);
        assert!(said.contains(&format!(" cannot present to this window: {why}\n")), "{said}");
        assert!(said.contains("help: without `--present-with own`, another device may present"), "{said}");
        let doctor = run(&shipped, &["doctor"]).exits(0).stdout;
        assert!(doctor.contains(&format!("the device cannot present: {why}; ")), "{doctor}");
    }
}

/// A pass whose module has its needs in the text: a type, the size of the workgroup by constants, and shared memory.
const PLANTED_GRAPH: &str = include_str!("fixtures/devices/planted.toml");
const PLANTED_SHADER: &str = include_str!("fixtures/devices/planted.comp");

/// A device that claims more than it has, so that raxel asks for it: each request ends the program, with its name.
#[test]
fn what_a_module_or_a_pipeline_needs_and_the_device_lacks_ends_the_program() {
    let whole = KnownDevice { shared_memory: 32768, ..METAL };
    for (lesser, said) in [
        (whole, None),
        (
            KnownDevice { without: &[Feature::Int64], ..whole },
            Some("a module declares the capability 11, which the device lacks"),
        ),
        (KnownDevice { invocations: 256, ..whole }, Some("asked for 512 invocations in a workgroup of 256")),
        (
            KnownDevice { workgroup: [256, 1024, 64], ..whole },
            Some("asked for 512 invocations along an axis of a workgroup of 256"),
        ),
        (KnownDevice { shared_memory: 16384, ..whole }, Some("asked for 24000 bytes of shared memory of 16384")),
    ] {
        let project = Project::empty();
        project.write("graphs/planted.toml", PLANTED_GRAPH).write("shaders/plant.comp", PLANTED_SHADER);
        let library = Lesser { claims: &whole, ..Lesser::from(&lesser) }.library(&project);
        let run = run(&(project, library), &["render", "graphs/planted.toml", "--size", "8x8", "-o", "out.png"]);
        match said {
            None => assert_eq!(run.code, 0, "{}", run.stderr),
            Some(said) => assert!(run.code == EXCEEDED && run.stderr.contains(said), "{said}: {}", run.stderr),
        }
    }
}

/// All of them in one go, each with what to do.
#[test]
fn every_format_that_the_device_lacks_is_named() {
    let shipped = behind(&KnownDevice { name: "a device with few formats", formats: false, ..METAL });
    let graph = "graphs/light/views/sph.toml";
    let run = run(&shipped, &["render", graph, "--world", "worlds/tank.toml", "--size", "32x18", "-o", "out.png"]);
    assert_refused(graph, &run);
    for format in ["`r8ui` for target `walls`", "`r16f` for target `field`"] {
        assert!(run.stderr.contains(format), "{}", run.stderr);
    }
    assert_eq!(run.stderr.matches("`raxel explain RX0410` lists them").count(), 2, "{}", run.stderr);
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
    // Features, formats, subgroups and memory, of a device that has them and of one that lacks them.
    let sun = ["doctor", "--graph", "graphs/bench/sun.toml", "--world", "worlds/menger.toml", "--format", "json"];
    let lacking = run(&shipped, &sun).exits(3).json();
    let has = |found: &[serde_json::Value], what: &str, state: &str, finding: &str| {
        let is_it = |line: &&serde_json::Value| line["what"] == what && line["state"] == state;
        found.iter().filter(is_it).any(|line| line["finding"].as_str().unwrap().contains(finding))
    };
    assert!(has(&lacking, "shader feature", "bad", "`Int64` in pass `"), "{lacking:?}");
    assert!(has(&lacking, "shader feature", "bad", "; the device lacks it"), "{lacking:?}");
    assert!(has(&lacking, "subgroup size", "missing", "the device runs the pass with its own size, 16"), "{lacking:?}");
    let menger = ["doctor", "--graph", "graphs/primary.toml", "--world", "worlds/menger.toml", "--format", "json"];
    let good = run(&shipped, &menger).exits(0).json();
    assert!(has(&good, "stored format", "ok", "in target `"), "{good:?}");
    assert!(has(&good, "source", "ok", "for `world.tree64`; the device has "), "{good:?}");
    assert!(has(&good, "memory", "ok", "with its sources; the device has "), "{good:?}");
    let bare = behind(&KnownDevice { name: "a device with few formats", formats: false, ..METAL });
    let views = ["doctor", "--graph", "graphs/light/views/sph.toml", "--world", "worlds/tank.toml", "--format", "json"];
    let formats = run(&bare, &views).exits(3).json();
    assert!(has(&formats, "stored format", "bad", "`r16f` in target `field`; the device lacks it"), "{formats:?}");
    // raxel reports a mistake in its files once.
    let none = run(&shipped, &["doctor", "--graph", "graphs/none.toml"]).exits(3).stderr;
    assert_eq!(none.matches("`graphs/none.toml` does not exist").count(), 1, "{none}");
}

#[test]
fn the_doctor_says_how_much_memory_a_world_takes() {
    let told = |lesser: &KnownDevice, world: &str, code: i32| {
        let shipped = behind(lesser);
        let found = run(&shipped, &["doctor", "--world", world, "--format", "json"]).exits(code).json();
        let of_world = |line: &serde_json::Value| {
            let what = line["what"].as_str()?;
            let is_it = ["tree64", "octree", "flat64", "streamed world", "world"].contains(&what);
            is_it.then(|| (what.to_owned(), line["state"].as_str().unwrap().to_owned(), line["finding"].to_string()))
        };
        found.iter().filter_map(of_world).collect::<Vec<_>>()
    };
    let whole = told(&METAL, "worlds/valley.toml", 0);
    assert_eq!(
        whole.iter().map(|(what, state, _)| (&**what, &**state)).collect::<Vec<_>>(),
        [("tree64", "ok"), ("octree", "ok"), ("flat64", "ok")]
    );
    assert!(whole[0].2.contains("for `worlds/valley.toml`; the device has "), "{whole:?}");
    let small = told(&KnownDevice { buffer_range: 4096, ..METAL }, "worlds/valley.toml", 3);
    assert!(small.iter().all(|(_, state, _)| state != "ok") && small.last().unwrap().0 == "world", "{small:?}");
    let streamed = told(&METAL, "worlds/frontier.toml", 0);
    assert!(streamed.len() == 1 && streamed[0].0 == "streamed world", "{streamed:?}");
    assert!(streamed[0].2.contains("`gpu_memory` is 256.0 MiB"), "{streamed:?}");
}

/// A driver that is slow at compiling.
const SLOW_DRIVER: Lesser<'_> = Lesser { has: &METAL, claims: &METAL, pipeline_milliseconds: 1600 };

/// While a driver compiles for long, raxel says which pass it waits for. Without `--verbose`, half a minute may pass first.
#[test]
fn a_pipeline_that_takes_long_is_named() {
    let slow = behind(SLOW_DRIVER);
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

/// The tracers of `raxel stress` too, and how many are still to be made.
#[test]
fn a_tracer_whose_pipeline_takes_long_is_named() {
    let slow = behind(SLOW_DRIVER);
    let stress =
        ["stress", "--rays", "64", "--scenes", "dust@near", "--layouts", "tree64,flat64,tree64:cpu", "--verbose"];
    let told = run(&slow, &stress).exits(0).stderr;
    for (tracer, left) in [("tree64", 2), ("flat64", 1)] {
        let line = format!("the driver has compiled tracer `{tracer}` for 1 s; pipelines left: {left}\n");
        assert!(told.contains(&line), "{told}");
    }
}

/// The wait for a submission ends with exit code 5 and the reason.
#[test]
fn a_tracer_that_takes_longer_than_the_watchdog_ends_the_run() {
    let project = Project::shipped();
    let stress = ["stress", "--rays", "2e6", "--scenes", "dust@near", "--layouts", "tree64", "--watchdog", "0.001"];
    let hung: Run = output(&mut command(project.root(), &stress)).into();
    let told = hung.exits(5).stderr;
    assert!(told.contains("the device did not finish within 0.001 s\nhelp: "), "{told}");
}

#[test]
fn stress_leaves_out_what_the_device_cannot_run_and_is_right_in_the_rest() {
    let shipped = behind(&LEAST);
    let run = run(&shipped, &["stress", "--rays", "2e3", "--scenes", "dust"]);
    assert_eq!(run.code, 0, "{}\n{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("the device lacks `Int64`, which `tree64:packet` needs"), "{}", run.stdout);
    assert!(run.stdout.contains(", all hit alike"), "{}", run.stdout);
}

/// Nothing but the version is amiss, and the error says so for each device that the loader lists.
#[test]
fn a_device_that_is_too_old_is_refused_by_its_version() {
    for lesser in TOO_OLD {
        let shipped = behind(&lesser);
        let render = run(&shipped, &["render", "graphs/inspect.toml", "--size", "32x18", "-o", "out.png"]).exits(4);
        assert!(render.stderr.contains("Vulkan 1.1): rejected, it lacks Vulkan 1.2"), "{}", render.stderr);
        assert!(render.stderr.contains("help: a newer driver may do"), "{}", render.stderr);
        let doctor = run(&shipped, &["doctor"]).exits(4);
        assert!(doctor.stdout.contains("Vulkan 1.1): rejected, it lacks Vulkan 1.2"), "{}", doctor.stdout);
    }
}

/// The reported subgroups of a device choose how camera rays are traced. The picture is the same.
#[test]
fn the_picture_is_the_same_on_every_device() {
    let mut first = None;
    for lesser in DEVICES {
        let shipped = behind(&lesser);
        assert!(fits(&shipped, "graphs/primary.toml"), "{}", lesser.name);
        let picture = std::fs::read(shipped.0.path("out.png")).unwrap();
        assert!(*first.get_or_insert_with(|| picture.clone()) == picture, "{}", lesser.name);
    }
}

/// A graph that wants more than small devices have of nearly everything, and one whose shared array is as long as a constant says.
const LARGE_GRAPH: &str = r#"
name = "large"
present = "color"
[targets.color]
format = "r16"
[targets.fine]
format = "r32f"
[[passes]]
name = "make"
shader = "make.comp"
dispatch = { threads = "fine" }
bind = { outFine = "fine" }
[[passes]]
name = "plant"
shader = "plant.comp"
dispatch = { threads = "color" }
bind = { outColor = "color", fine = { target = "fine", filter = "linear" } }
specialization = { THREADS = 512, LENGTH = 6000 }
"#;

/// The shader of its first pass.
const MAKE: &str = "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(r32f) uniform writeonly image2D outFine;\n\
                    void main() { imageStore(outFine, ivec2(gl_GlobalInvocationID.xy), vec4(1)); }\n";

/// `raxel check --device` needs no Vulkan, and says what the start on that device says.
#[test]
fn a_check_for_a_device_reports_the_errors_of_the_start_on_it() {
    let errors = |text: &str| -> Vec<String> {
        let found = text.split("\n\n").filter(|block| block.contains("error["));
        found.map(|block| block[block.find("error[").unwrap()..].trim_end().to_owned()).collect()
    };
    let shader = PLANTED_SHADER
        .replace("rgba8)", "r16)")
        .replace("shared uint", "uniform sampler2D fine;\nshared uint")
        .replace("vec4(all[0])", "vec4(all[0]) + textureLod(fine, vec2(0.5), 0.0)");
    let (mut refused, mut said) = (0, String::new());
    for device in [LEAST, SMALL, METAL, ADRENO_7, MALI_G52, POWERVR, RASPBERRY_4] {
        let shipped = behind(&device);
        let project = &shipped.0;
        project.write("graphs/large.toml", LARGE_GRAPH);
        project.write("shaders/plant.comp", &shader).write("shaders/make.comp", MAKE);
        for graph in [
            "graphs/large.toml",
            "graphs/primary.toml",
            "graphs/light/face_cache.toml",
            "graphs/bench/sun.toml",
            "graphs/rivals/light/gi_svgf.toml",
        ] {
            let over = [graph, "--world", "worlds/menger.toml"];
            // Without the library and without a driver.
            let mut check = command(project.root(), &[&["check"], &over[..], &["--device", device.name]].concat());
            let check = Run::from(output(check.env("VK_DRIVER_FILES", "/nowhere").env("VK_ICD_FILENAMES", "/nowhere")));
            let start = run(&shipped, &[&["render"], &over[..], &["--size", "32x18", "-o", "out.png"]].concat());
            assert_ne!(start.code, EXCEEDED, "{graph}: {}", start.stderr);
            assert_eq!(
                (check.code, errors(&check.stdout)),
                (start.code, errors(&start.stderr)),
                "{graph} on {}",
                device.name
            );
            assert!(!check.stdout.contains("RX0163"), "{}", check.stdout);
            refused += usize::from(start.code == 3);
            said += &check.stdout;
        }
    }
    assert!(refused > 10, "{refused}");
    // The length of the shared array is that of the pass.
    assert!(said.contains("pass `plant` shares 24000 bytes in a workgroup, but the device allows 16384"), "{said}");
    for code in ["RX0175", "RX0180", "RX0183", "RX0410"] {
        assert!(said.contains(&format!("error[{code}]")), "{code}: {said}");
    }
}

/// The constants of a pass give its shared array its length: a number, a boolean, and the size of the workgroup.
#[test]
fn shared_arrays_count_as_long_as_the_constants_of_the_pass_make_them() {
    let project = Project::shipped();
    for (length, constants, bytes) in [
        ("WIDE ? 8192 : 4", "WIDE = true", Some(32768)),
        ("WIDE ? 8192 : 4", "WIDE = false", None),
        ("THREADS > 64u ? 5000 : 4", "THREADS = 65", Some(20000)),
        ("gl_WorkGroupSize.x * 64", "THREADS = 100", Some(25600)),
        ("gl_WorkGroupSize.x * 64", "THREADS = 64", None),
    ] {
        let bools = "layout(constant_id = 2) const bool WIDE = false;\nshared uint";
        let shader = PLANTED_SHADER.replace("shared uint", bools).replace("[LENGTH]", &format!("[{length}]"));
        let shader = shader.replace("uint64_t", "uint").replace("<< 40", "<< 4").replace(">> 40", ">> 4");
        let graph = PLANTED_GRAPH.replace("THREADS = 512, LENGTH = 6000", constants);
        project.write("graphs/planted.toml", &graph).write("shaders/plant.comp", &shader);
        let run = project.raxel(&["check", "graphs/planted.toml", "--device", LEAST.name]);
        let said = bytes.map(|bytes| format!("shares {bytes} bytes in a workgroup, but the device allows 16384"));
        assert_eq!(run.code, if said.is_some() { 3 } else { 0 }, "{length}, {constants}: {}", run.stdout);
        assert!(run.stdout.contains(said.as_deref().unwrap_or_default()), "{length}, {constants}: {}", run.stdout);
    }
}

#[test]
fn a_check_for_an_unknown_device_lists_the_known_ones() {
    let project = Project::shipped();
    let check = |name: &str, graph: &str| -> Run {
        output(&mut command(project.root(), &["check", graph, "--device", name])).into()
    };
    let none = check("Voodoo 2", "graphs/primary.toml").exits(2).stderr;
    for device in DEVICES {
        assert!(none.contains(&format!("\n  {}", device.name)), "{none}");
    }
    let several = check("uhd", "graphs/primary.toml").exits(2).stderr;
    assert!(several.contains("several devices:\n  Intel UHD 620 (Mesa)\n  Intel UHD 620 (Windows)\n"), "{several}");
    let good = check("raspberry pi 5", "graphs/primary.toml").exits(0).stderr;
    assert!(good.contains("graphs/primary.toml: ok on Raspberry Pi 5 (V3DV)"), "{good}");
}

/// Whether a graph runs on the device: `raxel doctor --graph` and the start of the graph come to the same answer.
fn is_answered_alike(shipped: &(Project, PathBuf), lesser: &KnownDevice, graph: &str) -> bool {
    let doctor = run(shipped, &["doctor", "--graph", graph, "--world", world_of(graph), "--format", "json"]);
    let told = doctor.json().iter().find(|line| line["what"] == "graph").map(|line| line["state"] == "ok");
    let starts = fits(shipped, graph);
    assert_eq!(told, Some(starts), "{graph}, {lesser:?}\n{}\n{}", doctor.stdout, doctor.stderr);
    assert_eq!(doctor.code, if starts { 0 } else { 3 }, "{graph}, {lesser:?}: {}", doctor.stderr);
    // At once: a long run may be cut off.
    println!("{graph} {} on {}", if starts { "runs" } else { "is refused" }, lesser.name);
    starts
}

/// Graphs that ask for little, and one that asks for a random amount of nearly everything.
const SMALL_GRAPHS: [&str; 5] = [
    "graphs/large.toml",
    "graphs/primary.toml",
    "graphs/inspect.toml",
    "graphs/examples/queue.toml",
    "graphs/examples/world_size.toml",
];

/// Errors of a check without Vulkan, and those of the start on the device: the same, each with the pass or target, and with what to do. A graph that
/// starts draws the same picture on every device. `RAXEL_DEVICES=30` tries as many devices, from `RAXEL_DEVICE_SEED` on, with more graphs.
#[test]
fn on_devices_of_random_limits_a_check_says_what_the_start_says() {
    let number = |name: &str| std::env::var(name).ok().map(|number| number.parse::<u64>().expect("a number"));
    let first = number("RAXEL_DEVICE_SEED").unwrap_or(0);
    let (devices, graphs) = number("RAXEL_DEVICES").map_or((3, 2), |devices| (devices, SMALL_GRAPHS.len()));
    let mut pictures: BTreeMap<&str, Vec<u8>> = BTreeMap::new();
    for seed in first..first + devices {
        let lesser = random_device(seed);
        let shipped = behind(&lesser);
        plant(&shipped.0, &mut Random::new(seed));
        for graph in &SMALL_GRAPHS[..graphs] {
            let found = errors_of_check(&shipped.0, graph, &lesser);
            let scene = [graph, "--world", "worlds/menger.toml", "--size", "32x18", "--validate", "--format", "json"];
            let start = run(&shipped, &[&["render"], &scene[..], &["-o", "out.png"]].concat());
            assert_ne!(start.code, EXCEEDED, "{graph}, {lesser:?}: {}", start.stderr);
            let lines = start.stderr.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
            let said = lines.filter(|line| line["severity"] == "error");
            let said: Vec<_> = said.map(|line| ["code", "message", "help"].map(|key| line[key].clone())).collect();
            assert_eq!(said, found, "{graph}, {lesser:?}: {}", start.stderr);
            println!("seed {seed}: {graph} {}", if said.is_empty() { "runs" } else { "is refused" });
            assert_eq!(start.code, if said.is_empty() { 0 } else { 3 }, "{graph}, {lesser:?}: {}", start.stderr);
            for [code, message, help] in &said {
                let message = message.as_str().unwrap();
                assert!(REFUSED.iter().any(|known| code == known), "{code}: {message}");
                assert!(message.contains("pass `") || message.contains("target `"), "{message}");
                assert!(!help.as_array().unwrap().is_empty(), "{message}");
            }
            if said.is_empty() && *graph != SMALL_GRAPHS[0] {
                let picture = std::fs::read(shipped.0.path("out.png")).unwrap();
                assert!(*pictures.entry(graph).or_insert_with(|| picture.clone()) == picture, "{graph}, {lesser:?}");
            }
        }
    }
}

/// The first of `SMALL_GRAPHS`, with random sizes.
fn plant(project: &Project, random: &mut Random) {
    let (threads, length) = (random.pick(&[64, 128, 256, 512, 1024]), 64 << random.below(8_u32));
    let constants = format!("THREADS = {threads}, LENGTH = {length}, WIDE = {}", random.percent(50));
    let graph = LARGE_GRAPH.replace("THREADS = 512, LENGTH = 6000", &constants);
    let graph = graph.replace("\"r16\"", random.pick(&["\"r16\"", "\"rgba8\"", "\"rg16f\"", "\"rgba16f\""]));
    let format = graph.split('"').nth(5).unwrap();
    let mut shader = PLANTED_SHADER.replace("rgba8)", &format!("{format})"));
    if random.percent(50) {
        shader = shader.replace("[LENGTH]", "[WIDE ? LENGTH * 2u : LENGTH + gl_WorkGroupSize.x]");
    } else {
        shader = shader.replace("[LENGTH]", "[uint(WIDE) + LENGTH]");
    }
    let shader = shader.replace(
        "shared uint",
        "layout(constant_id = 2) const bool WIDE = false;\nuniform sampler2D fine;\nshared uint",
    );
    let shader = shader.replace("vec4(all[0])", "vec4(all[0]) + textureLod(fine, vec2(0.5), 0.0)");
    project.write("graphs/large.toml", &graph).write("shaders/plant.comp", &shader).write("shaders/make.comp", MAKE);
}

/// Code, message and help of what `raxel check --device` would say, if it knew the device by a name.
fn errors_of_check(project: &Project, graph: &str, device: &KnownDevice) -> Vec<[serde_json::Value; 3]> {
    let offline = OfflineProject::around(project.root()).unwrap().for_checks().for_device(Some(device));
    let world = offline.built("worlds/menger.toml").result.unwrap();
    let found = offline.check(graph, Some(&world)).found.into_iter().filter(Diagnostic::is_error);
    found.map(|error| [json!(error.code.as_str()), json!(error.message), json!(error.help)]).collect()
}

#[test]
fn on_devices_of_random_limits_a_graph_runs_or_is_refused() {
    for seed in 0..4 {
        println!("seed {seed}");
        let (lesser, mut random) = (random_device(seed), Random::new(seed));
        let shipped = behind(&lesser);
        let all = graphs_of(&shipped.0);
        for _ in 0..3 {
            is_answered_alike(&shipped, &lesser, &all[random.below(all.len())]);
        }
    }
}

#[test]
#[ignore = "minutes: every shipped graph"]
fn on_a_device_of_random_limits_every_graph_runs_or_is_refused() {
    let seed = std::env::var("RAXEL_DEVICE_SEED").map_or(0, |seed| seed.parse().expect("a number"));
    refused(&random_device(seed), |_| true);
}

/// Paths of the shipped graphs, in order.
fn graphs_of(project: &Project) -> Vec<String> {
    let is_graph = |path: &String| {
        path.starts_with("graphs/")
            && !path.contains("/base/")
            && Path::new(path).extension().is_some_and(|extension| extension == "toml")
    };
    let mut graphs: Vec<String> = project.files().into_iter().filter(is_graph).collect();
    graphs.sort();
    graphs
}

/// Which of the graphs that ship and are tried the device refuses.
fn refused(lesser: &KnownDevice, is_tried: impl Fn(&str) -> bool) -> Vec<String> {
    let shipped = behind(lesser);
    let tried = graphs_of(&shipped.0).into_iter().filter(|graph| is_tried(graph));
    let refused: Vec<String> = tried.filter(|graph| !is_answered_alike(&shipped, lesser, graph)).collect();
    println!("{} refuses {}: {}", lesser.name, refused.len(), refused.join(" "));
    refused
}

/// `docs/devices.md` has the graphs that some device refuses, by `raxel check --device`. `RAXEL_WRITE_DOCS=1` writes the table; without, it is compared.
#[test]
fn the_table_of_devices_is_what_checks_for_them_say() {
    let project = Project::shipped();
    project.copy_folder("textures");
    let graphs = graphs_of(&project);
    let mut refusing: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for device in DEVICES {
        for world in ["worlds/valley.toml", "worlds/meadow.toml"] {
            let over = ["check", "--device", device.name, "--world", world, "--format", "json"].into_iter();
            let tried = graphs.iter().map(String::as_str).filter(|graph| world_of(graph) == world);
            let checked = project.raxel(&over.chain(tried).collect::<Vec<_>>()).json();
            for line in checked.iter().filter(|line| line["reason"] == "checked" && line["errors"] != 0) {
                refusing.entry(line["file"].as_str().unwrap().to_owned()).or_default().push(device.name);
            }
        }
    }
    let mut table = String::from("| graph | refused by |\n|---|---|\n");
    for (graph, devices) in refusing {
        table += &format!("| `{graph}` | {} |\n", devices.join(", "));
    }
    let path = repository().join("docs/devices.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once(TABLE[0]).unwrap();
    let (_, after) = rest.split_once(TABLE[1]).unwrap();
    let written = [before, TABLE[0], "\n\n", &table, "\n", TABLE[1], after].concat();
    if std::env::var_os("RAXEL_WRITE_DOCS").is_some() {
        std::fs::write(&path, &written).unwrap();
    }
    assert_eq!(page, written, "docs/devices.md is of older graphs: RAXEL_WRITE_DOCS=1 writes it anew");
}

/// The table of `docs/devices.md` is right: each graph runs, or is refused, on each device as it says. `RAXEL_LESSER=Mali` tries only the devices whose names
/// contain that word, `RAXEL_GRAPHS=sph` only the graphs whose paths contain it. Several words stand between commas.
#[test]
#[ignore = "hours: every shipped graph on every device"]
fn every_graph_runs_or_is_refused_on_every_device() {
    let [devices, graphs] = ["RAXEL_LESSER", "RAXEL_GRAPHS"].map(|name| std::env::var(name).unwrap_or_default());
    let is_named = |words: &str, name: &str| words.split(',').any(|word| name.contains(word));
    let page = std::fs::read_to_string(repository().join("docs/devices.md")).unwrap();
    for device in DEVICES.iter().filter(|device| is_named(&devices, device.name)) {
        let found = refused(device, |graph| is_named(&graphs, graph));
        let told = refused_by(&page, device.name).filter(|graph| is_named(&graphs, graph));
        assert_eq!(found, told.collect::<Vec<_>>(), "{}", device.name);
    }
}

/// The graphs that a device refuses by the table of a page.
fn refused_by<'p>(page: &'p str, device: &'p str) -> impl Iterator<Item = &'p str> {
    let (_, table) = page.split_once(TABLE[0]).unwrap();
    let (table, _) = table.split_once(TABLE[1]).unwrap();
    let rows = table.lines().filter_map(|row| row.strip_prefix("| `")?.strip_suffix(" |")?.split_once("` | "));
    rows.filter(move |(_, devices)| devices.split(", ").any(|name| name == device)).map(|(graph, _)| graph)
}

/// The place of the table in the page.
const TABLE: [&str; 2] = ["<!-- table by tests/devices.rs -->", "<!-- end of the table -->"];

#[test]
#[ignore = "minutes: every shipped graph"]
fn every_graph_runs_or_is_refused_by_the_least_device() {
    assert!(refused(&LEAST, |_| true).len() <= 27);
}

#[test]
#[ignore = "minutes: every shipped graph"]
fn every_graph_runs_or_is_refused_by_a_small_device() {
    // Rivals of raxel, and graphs that measure one tracer, may need more.
    let own = |graph: &String| !graph.starts_with("graphs/rivals/") && !graph.starts_with("graphs/bench/");
    assert_eq!(refused(&SMALL, |_| true).into_iter().filter(own).collect::<Vec<_>>(), [""; 0]);
}

#[test]
#[ignore = "minutes: every shipped graph"]
fn every_graph_runs_or_is_refused_over_metal() {
    assert!(refused(&METAL, |_| true).len() <= 8);
}
