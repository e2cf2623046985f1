//! `raxel bench` on a real device: the numbers that it gives, the files that it writes, and its errors.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::{Project, RunRaxel};
use raxel::{Options, Session};
use raxel_layouts::Layout;
use raxel_rivals as rivals;
use serde_json::Value;

/// A ball, a sponge and a thin wall, seen from the outside and from within.
const SMALL: &str = include_str!("fixtures/bench/small.toml");

fn project() -> Project {
    let project = Project::shipped();
    project.write("worlds/small.toml", SMALL);
    project
}

const QUICK: [&str; 10] =
    ["bench", "--worlds", "small", "--size", "64x36", "--frames", "3", "--warmup", "1", "--seconds=1"];

fn bench(project: &Project, more: &[&str], code: i32) -> common::Run {
    project.raxel(&[&QUICK[..], more].concat()).exits(code)
}

/// The rows of `--format json`, without what comes before them.
fn rows(run: &common::Run) -> Vec<Value> {
    let mut all = run.json();
    assert_eq!(all.remove(0)["reason"], "bench");
    all
}

#[test]
fn exact_tracers_are_exact_and_others_are_told_apart() {
    let project = project();
    let out = project.path("out");
    // Without its `every`, only the skipping of unchanged passes keeps the table from being baked in every frame.
    project.edit("graphs/rivals/march/raymask.toml", "\nevery ", "\n# every ");
    let layouts = "tree64,svo,brickmap";
    let graphs = ["first_hit", "fixed", "bounce", "raymask"];
    let run = bench(
        &project,
        &[&graphs[..], &["--layouts", layouts, "--format=json", "-o", "out", "--validate"]].concat(),
        0,
    );
    let mut rows = rows(&run);
    // Two cameras, four graphs, three layouts; then the means over both cameras.
    let means = rows.split_off(24);
    assert_eq!(means.len(), 10);
    for mean in &means {
        assert_eq!((&mean["reason"], &mean["views"]), (&Value::from("mean"), &Value::from(2)));
        let of = |row: &&Value| row["case"]["graph"] == mean["graph"] && row["case"]["layout"] == mean["layout"];
        let product: f64 = rows.iter().filter(of).map(|row| row["mrays_per_s"].as_f64().unwrap()).product();
        assert!((mean["mrays_per_s"].as_f64().unwrap() / product.sqrt() - 1.0).abs() < 1e-9, "{mean}");
    }
    let measured: Vec<&Value> = rows.iter().filter(|row| row["refused"].is_null()).collect();
    for row in &measured {
        let graph = row["case"]["graph"].as_str().unwrap();
        let (pixels, wrong) = (64 * 36, row["wrong"].as_u64().unwrap());
        let number = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name} of {row}"));
        assert!(number("median_ms") > 0.0 && number("p95_ms") >= number("median_ms"), "{row}");
        assert!(number("geometry_bytes_per_voxel") > 0.0 && number("encode_mvoxels_per_s") > 0.0, "{row}");
        assert_eq!(row["frames"], 3);
        match graph {
            "graphs/rivals/march/fixed.toml" => {
                assert!(wrong > 10 && number("missed_chord_voxels") > 0.0 && number("wrong_ppm") > 4000.0, "{row}");
            }
            "graphs/bench/bounce.toml" => {
                assert_eq!((wrong, row["rays"].as_u64().unwrap() < pixels), (0, true), "{row}");
                assert!(row["passes"].as_array().unwrap().len() == 2 && row["t_error_ulp"].is_null(), "{row}");
            }
            _ => {
                assert_eq!((wrong, row["rays"].as_u64()), (0, Some(pixels)), "{row}");
                assert!(number("steps_per_ray") >= 1.0 && number("t_error_ulp") < 16.0, "{row}");
            }
        }
        // The time of a frame leaves out passes that do not depend on the camera.
        let names = |list: &str| -> Vec<String> {
            row[list].as_array().unwrap().iter().map(|pass| pass["pass"].as_str().unwrap().to_owned()).collect()
        };
        let bakes = graph == "graphs/rivals/march/raymask.toml";
        assert_eq!((names("once").len(), names("passes").contains(&"bake".to_owned())), (usize::from(bakes), false));
    }
    // The table of masks is for one of the layouts only; the others say why.
    let refused: Vec<&Value> = rows.iter().filter(|row| !row["refused"].is_null()).collect();
    assert_eq!(refused.len(), 4, "{refused:?}");
    assert!(refused.iter().all(|row| row["refused"].as_str().unwrap().starts_with("RX")), "{refused:?}");

    // The files say the same.
    let csv = std::fs::read_to_string(out.join("results.csv")).unwrap();
    let columns: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let at = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    assert_eq!(csv.lines().count(), 25);
    for (line, row) in csv.lines().skip(1).zip(&rows) {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields[at("camera")], row["case"]["camera"].as_str().unwrap());
        if row["refused"].is_null() {
            assert_eq!(fields[at("wrong")].parse::<u64>().ok(), row["wrong"].as_u64(), "{line}");
            assert_eq!(fields[at("median_ms")].parse::<f64>().ok(), row["median_ms"].as_f64(), "{line}");
        }
    }
    let json: Value = serde_json::from_slice(&std::fs::read(out.join("results.json")).unwrap()).unwrap();
    assert_eq!([&json["rows"], &json["means"]].map(|list| list.as_array().unwrap().len()), [24, 10]);
    for name in ["device", "driver", "raxel", "command", "date", "effort"] {
        assert!(!json[name].is_null(), "{name}");
    }
    for camera in ["outside", "within"] {
        let svg = std::fs::read_to_string(out.join(format!("small-{camera}-64x36.svg"))).unwrap();
        for part in ["<svg ", "</svg>", "exact: none of 2\u{202f}304 rays is wrong", ">fixed</text>", "brickmap", "ppm"]
        {
            assert!(svg.contains(part), "{part} is not in\n{svg}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}

#[test]
fn a_tracer_that_is_off_by_one_is_found_out() {
    let project = project();
    project.edit("shaders/bench/first_hit.comp", "ivec4(hit.voxel,", "ivec4(hit.voxel + ivec3(hit.voxel.y & 1, 0, 0),");
    let run = bench(&project, &["first_hit", "--layouts=own", "--cameras=camera", "--format=json"], 1);
    let rows = rows(&run);
    assert_eq!((rows.len(), &rows[0]["case"]["layout"]), (1, &Value::from("tree64")));
    let count = |name: &str| rows[0][name].as_u64().unwrap();
    assert!(count("wrong") > 100 && count("early") + count("late") == count("wrong"), "{}", rows[0]);
    let said = format!("first_hit.toml over tree64 is wrong about {} of 2304 rays", count("wrong"));
    assert!(run.stderr.contains(&said), "{}", run.stderr);

    // Who does not claim to be exact may be wrong; who does may not be by its depth alone.
    let about = "\nabout   = \"First hit, nearly\"\n";
    let graph = std::fs::read_to_string(project.path("graphs/bench/first_hit.toml")).unwrap();
    let (before, rest) = graph.split_once("\nabout").unwrap();
    let modest = format!("{before}{about}{}", rest.split_once('\n').unwrap().1);
    project.write("graphs/bench/first_hit.toml", modest);
    bench(&project, &["first_hit", "--layouts=own", "--cameras=camera"], 0);
    let project = self::project();
    project.edit("shaders/bench/first_hit.comp", "vec4(found ? hit.t : 0.0)", "vec4(found ? hit.t * 1.000001 : 0.0)");
    let run = bench(&project, &["first_hit", "--layouts=own", "--cameras=camera", "--format=json"], 1);
    assert!(run.stderr.contains("is wrong about "), "{}", run.stderr);
    let row = &self::rows(&run)[0];
    assert!(row["wrong"] == 0 && row["wrong_t"].as_u64().unwrap() > 100, "{row}");
}

#[test]
fn any_graph_can_be_timed_and_says_why_it_is_not_judged() {
    let run = bench(&project(), &["graphs/rivals/naive.toml", "--layouts=own", "--cameras=camera"], 0);
    assert!(run.stdout.contains("small, camera, 64 × 36\n"), "{}", run.stdout);
    assert!(run.stdout.contains("naive over chunks: it has no target `hit` of format rgba32i"), "{}", run.stdout);
    let short = bench(&project(), &["first_hit", "--layouts=svo", "--cameras=camera", "--format=short"], 0);
    let fields: Vec<&str> = short.stdout.trim_end().split('\t').collect();
    assert_eq!(
        (fields.len(), &fields[..5], fields[8]),
        (13, &["small", "camera", "64x36", "first_hit", "svo"][..], "0")
    );
}

#[test]
fn what_is_not_there_is_said_before_anything_is_measured() {
    let project = project();
    project.write("graphs/bench/broken.toml", "present = 3");
    std::fs::create_dir_all(project.path("taken/results.csv")).unwrap();
    project.write("worlds/wide.toml", include_str!("fixtures/bench/wide.toml"));
    for (arguments, code, said) in [
        (&["first_hut"][..], 3, "did you mean `first_hit`?"),
        (&["--layouts", "tree46"], 2, "did you mean `tree64`?"),
        (&["--layouts", "own,svo"], 2, "stands alone"),
        (&["--cameras", "wthin"], 2, "did you mean `within`?"),
        (&["--worlds", "smal"], 3, "did you mean `small`?"),
        (&["--worlds", "small,menger", "--cameras", "within"], 2, "`worlds/menger.toml` has none of the cameras"),
        (&["--size", "0x1"], 2, "640x360"),
        (&["--size", "16384x16384"], 2, "33177600 that can be judged"),
        (&["--frames", "1"], 2, "3.."),
        (&["--export", "out", "-o", "out"], 2, "cannot be used with"),
        (&["--seconds=-1"], 2, "above 0"),
        (&["--export", "out", "--worlds", "wide"], 3, "70001 voxels wide"),
        (&["-o", "/proc/out"], 2, "cannot be made"),
        (&["-o", "taken"], 2, "taken/results.csv` cannot be written: it is a folder"),
        (&["broken"], 3, "nothing could be measured"),
    ] {
        // Worlds that are named twice are added up.
        let world: &[&str] = if arguments.contains(&"--worlds") { &[] } else { &["--worlds=small"] };
        let run = project.raxel(&[&["bench"], world, arguments].concat()).exits(code);
        assert!(run.stderr.contains(said), "{arguments:?}: {}", run.stderr);
        assert_eq!(run.stdout.contains("broken"), arguments == ["broken"], "{}", run.stdout);
    }
}

#[test]
fn what_is_wrong_with_a_graph_is_said_with_its_place_and_the_others_are_measured() {
    let project = project();
    let named = ["first_hit", "dda", "--cameras=camera", "--layouts"];
    let dda = std::fs::read_to_string(project.path("graphs/rivals/march/dda.toml")).unwrap();
    project.write("graphs/rivals/march/dda.toml", format!("{dda}[[[\n"));
    for layouts in ["own", "tree64,svo"] {
        let run = bench(&project, &[&named[..], &[layouts, "-o", "out"]].concat(), 3);
        let place = format!("graphs/rivals/march/dda.toml:{}:", dda.lines().count() + 1);
        assert_eq!(run.stderr.matches(&place).count(), 1, "{}", run.stderr);
        assert!(run.stderr.contains("not compile: `graphs/rivals/march/dda.toml`;"), "{}", run.stderr);
        assert!(run.stdout.contains("first_hit") && run.stdout.contains("RX00"), "{}", run.stdout);
        assert!(project.path("out/results.csv").is_file());
    }

    // An error in an included file is printed with its line; over another layout the graph can still be measured.
    project.write("graphs/rivals/march/dda.toml", dda);
    let tree = project.path("shaders/include/raxel/internal/layouts/tree64.glsl");
    let text = std::fs::read_to_string(&tree).unwrap();
    std::fs::write(&tree, format!("{text}\nint rx_wrong = ;\n")).unwrap();
    let place = format!("shaders/include/raxel/internal/layouts/tree64.glsl:{}", text.lines().count() + 2);
    for (layouts, measured) in [("own", false), ("tree64,svo", true)] {
        let named = ["first_hit", "--cameras=camera", "--format=short", "--layouts", layouts];
        let run = bench(&project, &named, 3);
        assert_eq!(run.stderr.matches(&place).count(), 1, "{}", run.stderr);
        let said = if measured { "that do not compile" } else { "nothing could be measured" };
        assert!(run.stderr.contains(said), "{}", run.stderr);
        assert!(run.stdout.contains("RX0210"), "{}", run.stdout);
    }
}

/// A graph that compiles and cannot be planned: the place in its file is printed, once for all views.
#[test]
fn what_the_planner_refuses_is_said_with_its_place() {
    let project = project();
    let wide = r#"
[targets.wide]
format = "r32f"
size = [40000, 1]
[[passes]]
name = "wide"
shader = "wide.comp"
dispatch = { threads = "wide" }
bind = { wide = "wide" }
"#;
    let shader = r"#version 460
layout(local_size_x = 64) in;
layout(r32f) writeonly uniform image2D wide;
void main() { imageStore(wide, ivec2(gl_GlobalInvocationID.xy), vec4(1.0)); }
";
    let graph = format!("name = \"wide\"\npresent = \"wide\"\n{wide}");
    project.write("graphs/bench/wide.toml", graph).write("shaders/wide.comp", shader);
    let run = bench(&project, &["wide", "first_hit", "--layouts=own"], 0);
    assert_eq!(run.stderr.matches("--> graphs/bench/wide.toml:").count(), 1, "{}", run.stderr);
    assert!(run.stdout.contains("wide over its world: RX"), "{}", run.stdout);
}

#[test]
fn what_is_named_twice_is_measured_once() {
    let project = project();
    let twice = ["first_hit", "graphs/bench/first_hit.toml", "--layouts=svo,svo", "--cameras=camera,camera"];
    let run = project.raxel(
        &[&["bench", "--worlds=small,worlds/small.toml", "--size=8x8,8x8", "--frames=3", "--warmup=1"][..], &twice]
            .concat(),
    );
    let run = run.exits(0);
    assert_eq!(run.stdout.matches("first_hit").count(), 1, "{}", run.stdout);
    let check = project.raxel(&["check", "graphs/primary.toml", "graphs/primary.toml", "--format=json"]).exits(0);
    assert_eq!(check.json().len(), 1);
}

/// A chart of another run is not shown beside the numbers of this one; files of others stay.
#[test]
fn old_charts_do_not_stay() {
    let project = project();
    let of = |camera: &str| {
        bench(&project, &["first_hit", "--layouts=svo", &format!("--cameras={camera}"), "-o", "out"], 0);
    };
    of("outside");
    project.write("out/mine.svg", "<svg/>");
    of("within");
    let names: Vec<String> = project.files().into_iter().filter(|file| file.starts_with("out/")).collect();
    assert_eq!(names, ["out/mine.svg", "out/results.csv", "out/results.json", "out/small-within-64x36.svg"]);
}

/// One camera that is too far away is left out; the others are exported, and no graph is needed for it.
#[test]
fn a_camera_that_is_too_far_away_does_not_end_an_export() {
    let project = project();
    for folder in ["graphs/bench", "graphs/rivals"] {
        std::fs::remove_dir_all(project.path(folder)).unwrap();
    }
    let far = "\n[cameras.far]\nposition = [30, 30, 2147483600.5]\nlook_at = [0, 0, 0]\n\n[materials]";
    project.edit("worlds/small.toml", "\n[materials]", far);
    let run = bench(&project, &["--export", "out"], 0);
    assert!(run.stderr.contains("left out: camera `far` of `worlds/small.toml` is too far away"), "{}", run.stderr);
    let index: Value = serde_json::from_slice(&std::fs::read(project.path("out/export.json")).unwrap()).unwrap();
    let cameras = |list: &str| -> Vec<String> {
        index[list].as_array().unwrap().iter().map(|entry| entry["camera"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(
        (cameras("exports"), cameras("refused")),
        (vec!["outside".into(), "within".into()], vec!["far".to_owned()])
    );
    bench(&project, &["--export", "out", "--cameras=far"], 3);
}

#[test]
fn a_session_takes_another_layout_for_its_world() {
    let project = project();
    let options = Options {
        project: Some(project.root().to_owned()),
        graph: Some("graphs/bench/first_hit.toml".into()),
        world: Some("worlds/small.toml".into()),
        size: [16, 9],
        layout: Some(rivals::SVO),
        pinned: vec!["hit".to_owned()],
        ..Options::default()
    };
    let read = |layout: Option<Layout>| {
        let mut session = Session::open(Options { layout, ..options.clone() }).unwrap();
        session.frame().unwrap();
        let hits = session.read_target("hit").unwrap().bytes;
        let costs: Vec<bool> =
            [rivals::SVO, Layout::TREE64].map(|layout| session.world().cost(layout).is_some()).into();
        (hits, costs)
    };
    let (of_svo, costs) = read(Some(rivals::SVO));
    assert_eq!(costs, [true, false]);
    let (own, costs) = read(None);
    assert_eq!(costs, [false, true]);
    assert!(of_svo == own && own.iter().any(|byte| *byte != own[0]));
}

/// Reads the files of `--export` by docs/bench-export.md alone, and traces the rays again by an unrelated method: every voxel's box
/// in `f64`.
#[test]
fn what_is_exported_is_what_another_tracer_finds() {
    let project = project();
    bench(&project, &["--export", "out"], 0);
    let read = |name: &str| std::fs::read(project.path("out").join(name)).unwrap();
    let bytes = read("small.voxels");
    let u16_at = |at: usize| u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap());
    let u32_at = |bytes: &[u8], at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let f32_at = |bytes: &[u8], at: usize| f32::from_bits(u32_at(bytes, at));
    assert_eq!((&bytes[..4], u32_at(&bytes, 4)), (&b"RXVX"[..], 1));
    let count = u64::from_le_bytes(bytes[8..16].try_into().unwrap()) as usize;
    assert_eq!(bytes.len(), 28 + 8 * count);
    let corner: Vec<i32> = (0..3).map(|axis| u32_at(&bytes, 16 + 4 * axis) as i32).collect();
    assert_eq!(corner, [-3, -4, 0]);
    let voxels: Vec<[f64; 3]> = (0..count).map(|i| [0, 2, 4].map(|at| f64::from(u16_at(28 + 8 * i + at)))).collect();
    assert!((0..count).all(|i| (1..=2).contains(&u16_at(28 + 8 * i + 6))));

    for camera in ["outside", "within"] {
        let [rays, hits, ties] = ["rays", "hits", "ties"].map(|ending| read(&format!("small-{camera}-64x36.{ending}")));
        assert_eq!([rays.len(), hits.len(), ties.len()], [32 * 64 * 36, 20 * 64 * 36, 64 * 36]);
        let mut hit_some = 0;
        for i in (0..64 * 36).step_by(7) {
            let ray: [f64; 8] = std::array::from_fn(|n| f64::from(f32_at(&rays, 32 * i + 4 * n)));
            let ([ox, oy, oz, t_min], [dx, dy, dz, _]) = (ray[..4].try_into().unwrap(), ray[4..].try_into().unwrap());
            assert_eq!(t_min.to_bits(), 0.0f64.to_bits());
            let found = nearest(&voxels, [ox, oy, oz], [dx, dy, dz]);
            let hit = &hits[20 * i..20 * i + 20];
            let voxel: [f64; 3] = std::array::from_fn(|axis| f64::from(u32_at(hit, 4 * axis) as i32));
            let (face, t) = (u32_at(hit, 12), f64::from(f32_at(hit, 16)));
            match found {
                None => assert_eq!((voxel, face, t), ([-1.0; 3], u32::MAX, -1.0), "ray {i}"),
                Some((nearest, its_face, at, sure)) => {
                    hit_some += 1;
                    // In f64, the boxes on both sides of a shared face cannot be distinguished.
                    assert!(
                        !sure || (voxel, face) == (nearest, its_face),
                        "ray {i}: {voxel:?} {face}, {nearest:?} {its_face}"
                    );
                    assert!((t - at).abs() <= 1e-6 * at.max(1.0), "ray {i}: {t} {at}");
                }
            }
        }
        assert!(hit_some > 100, "{hit_some}");
    }
}

/// First box along a ray: its voxel, the face, the time, and whether no other box is nearly as near.
fn nearest(voxels: &[[f64; 3]], origin: [f64; 3], dir: [f64; 3]) -> Option<([f64; 3], u32, f64, bool)> {
    let mut met: Vec<([f64; 3], u32, f64)> = Vec::new();
    for voxel in voxels {
        let (mut enter, mut leave, mut face) = (0.0f64, f64::INFINITY, 6);
        for axis in 0..3 {
            let (a, b) = ((voxel[axis] - origin[axis]) / dir[axis], (voxel[axis] + 1.0 - origin[axis]) / dir[axis]);
            if a.min(b) > enter {
                (enter, face) = (a.min(b), 2 * axis as u32 + u32::from(dir[axis] < 0.0));
            }
            leave = leave.min(a.max(b));
        }
        if enter < leave {
            met.push((*voxel, face, enter));
        }
    }
    met.sort_by(|a, b| a.2.total_cmp(&b.2));
    let (voxel, face, t) = *met.first()?;
    Some((voxel, face, t, met.get(1).is_none_or(|second| second.2 - t > 1e-9)))
}

/// Period rays are judged in whole numbers, a target of them by itself.
#[test]
fn period_rays_are_exact_and_wrong_ones_are_told() {
    let project = project();
    let run = bench(&project, &["period", "--layouts", "own", "--format=json", "--validate"], 0);
    let measured: Vec<Value> = rows(&run).into_iter().filter(|row| row["reason"] != "mean").collect();
    assert_eq!(measured.len(), 2);
    for row in &measured {
        assert_eq!((row["wrong"].as_u64(), row["bounced"].as_bool()), (Some(0), Some(true)), "{row}");
        assert!(row["rays"].as_u64().unwrap() > 200 && row["once"].as_array().unwrap().len() == 1, "{row}");
    }
    // Rays from the table's other end are other rays.
    project.edit("shaders/bench/period.comp", "directions[draw % 4096u]", "directions[4095u - draw % 4096u]");
    let run = bench(&project, &["period", "--layouts", "own", "--format=json"], 1);
    assert!(run.stderr.contains("graphs/bench/period.toml over flat64 is wrong about "), "{}", run.stderr);
    assert!(rows(&run).iter().all(|row| row["wrong"].as_u64().is_none_or(|wrong| wrong > 20)), "{}", run.stdout);
}
