//! Broken tracers are caught.

use crate::common::{Project, Run, RunRaxel, raxel, repository};
use crate::{broken, rows};

#[test]
fn a_broken_tracer_is_caught_and_its_rays_can_be_traced_alone() {
    let project = broken();
    let scope = ["stress", "--scenes", "gravel,menger", "--layouts", "tree64,octree,tree64:cpu", "--rays", "1e5"];
    let run = project.raxel(&scope).exits(1);
    assert!(run.stderr.contains("error: tree64 is wrong about "), "{}", run.stderr);
    assert!(run.stderr.contains("octree is wrong about ") && run.stderr.contains("differ in "), "{}", run.stderr);
    assert!(run.stdout.contains("wrong ppm"), "the table is printed all the same: {}", run.stdout);

    // The first command that is offered traces that ray, and shows the error again.
    let offered = run.stderr.lines().find_map(|line| line.trim().strip_prefix("raxel ")).expect("a command");
    let (words, ray) = offered.split_once('"').unwrap();
    let mut arguments: Vec<&str> = words.split_whitespace().collect();
    arguments.push(ray.trim_end_matches('"'));
    let alone = project.raxel(&arguments).exits(1);
    assert!(alone.stdout.contains("exact ") && alone.stdout.contains("WRONG: "), "{offered}\n{}", alone.stdout);
    assert!(!raxel(&arguments).exits(0).stdout.contains("WRONG"), "the tracer as it is gets it right");

    project.write("shaders/include/raxel/internal/walk.glsl", "this is not a shader");
    let run = project.raxel(&scope).exits(3);
    assert!(run.stderr.contains("shaders/include/raxel/internal/walk.glsl"), "{}", run.stderr);
}

/// Hits are spoilt in one way at a time; each is found and called by its name.
#[test]
fn every_way_to_be_wrong_is_told_from_the_others() {
    let inexact = ["wrong_t", "wrong_uv", "wrong_steps"];
    let run = |spoil: &str| {
        let project = Project::empty();
        let march = format!(
            "bool rx_march(RxRay ray, out RxHit hit) {{\n    bool found = rx_trace(ray, hit);\n    {spoil}\n    return found;\n}}\n"
        );
        project.write("shaders/include/raxel/rivals/march.glsl", march);
        let scope = ["stress", "--scenes", "hills@near", "--layouts", "tree64", "--rays", "2e4", "--format", "json"];
        let run = project.raxel(&scope).exits(1);
        let total = rows(&run)["tree64"]["total"].clone();
        let symmetry = run.json().into_iter().find(|value| value["reason"] == "stress").unwrap()["symmetry"].clone();
        (total, symmetry["tree64"].clone())
    };
    for (spoil, column) in [
        ("if (found) { hit.steps = 0xffffffffu; return false; }", "hangs"),
        ("hit.t = uintBitsToFloat(0x7fc00000u);", "not_finite"),
        ("hit.face ^= 1u;", "face"),
        ("hit.material = 3u;", "material"),
        ("if (found && hit.face != RX_FACE_INSIDE) { hit.voxel += rx_face_step(hit.face); hit.t *= 0.99; }", "early"),
        ("if (found && hit.face != RX_FACE_INSIDE) { hit.voxel -= rx_face_step(hit.face); hit.t *= 1.01; }", "late"),
        ("found = found && ray.dir.x > 0.0;", "missed"),
        ("found = true;", "false"),
        ("ray.t_max = RX_FAR; found = rx_trace(ray, hit);", "beyond_t_max"),
        ("hit.t = 0.0;", "wrong_t"),
        ("hit.t *= 2.0;", "wrong_t"),
        ("hit.t = uintBitsToFloat(floatBitsToUint(hit.t) + 8u);", "wrong_t"),
        ("hit.uv = vec2(0.25, 0.75);", "wrong_uv"),
        ("hit.uv = hit.uv.yx;", "wrong_uv"),
        ("hit.uv = uintBitsToFloat(floatBitsToUint(hit.uv) + 8u);", "wrong_uv"),
        ("hit.steps = 0u;", "wrong_steps"),
        ("hit.steps = hit.steps * 16u + 100u;", "wrong_steps"),
    ] {
        let (total, _) = run(spoil);
        let count = |name: &str| total[name].as_u64().unwrap();
        let all = count("wrong") + inexact.map(count).iter().sum::<u64>();
        assert!(count(column) > 50, "{spoil}: {total}");
        assert!(count(column) * 10 > all * 9, "{spoil}: {total}");
    }
    // Half a unit in the last place of t is right by the oracle, but not the same for all directions, or everywhere.
    let one_up = "hit.t = uintBitsToFloat(floatBitsToUint(hit.t) + 1u);";
    for (condition, part) in [("ray.dir.x > 0.0", "turned_wrong"), ("ray.cell.x > 900000", "moved_wrong")] {
        let (total, symmetry) = run(&format!("if ({condition} && hit.t > 0.0) {one_up}"));
        assert!(total["wrong"] == 0 && inexact.iter().all(|column| total[column] == 0), "{total}");
        assert!(symmetry[part].as_u64().unwrap() > 50, "{condition}: {symmetry}");
    }
}

/// Rays that begin half a step too late behind the time up to which they count as free.
#[test]
fn a_start_too_far_ahead_is_caught() {
    let project = Project::empty();
    let walk = std::fs::read_to_string(repository().join("shaders/include/raxel/internal/walk.glsl")).unwrap();
    let (right, wrong) = ("* 0.999998 - 0.25;", "* 0.999998 + (t_free > 0.0 ? 0.5 : -0.25);");
    assert!(walk.contains(right));
    project.write("shaders/include/raxel/internal/walk.glsl", walk.replace(right, wrong));
    let scope = ["stress", "--scenes", "hills,gravel", "--layouts", "tree64,tree64:ahead", "--rays", "4e4"];
    let run = project.raxel(&[&scope[..], &["--format", "json"]].concat()).exits(1);
    let found = rows(&run);
    let wrong = |row: &str| found[row]["total"]["wrong"].as_u64().unwrap();
    assert!(wrong("tree64") == 0 && wrong("tree64:ahead") > 1000, "{} {}", wrong("tree64"), wrong("tree64:ahead"));
    assert!(run.stderr.contains("tree64:ahead is wrong about "), "{}", run.stderr);
}

/// A beam that continues past the border of its last look; the rays themselves are traced as they are.
#[test]
fn a_beam_that_goes_too_far_is_caught() {
    let project = Project::empty();
    let beam = std::fs::read_to_string(repository().join("shaders/include/raxel/beam.glsl")).unwrap();
    let (right, wrong) = ("pixel, size) * 0.99999 - 0.01;", "pixel, size) + 0.75;");
    assert!(beam.contains(right));
    project.write("shaders/include/raxel/beam.glsl", beam.replace(right, wrong));
    let scope = ["stress", "--scenes", "hills,menger,gravel", "--sets", "tiles,pinhole", "--rays", "6e4"];
    let layouts = ["--layouts", "tree64,tree64:beam,svo:beam", "--format", "json"];
    let run = project.raxel(&[&scope[..], &layouts].concat()).exits(1);
    let found = rows(&run);
    let count = |row: &str, name: &str| found[row]["total"][name].as_u64().unwrap();
    assert_eq!(count("tree64", "wrong") + count("tree64", "wrong_t"), 0);
    for row in ["tree64:beam", "svo:beam"] {
        assert!(count(row, "hits") > 1000 && count(row, "wrong") > 100, "{}", found[row]);
    }
    raxel(&[&scope[..], &layouts].concat()).exits(0);
}

/// Rays of one direction that stop at voxels that they only touch.
#[test]
fn a_tile_that_stops_rays_beside_voxels_is_caught() {
    let project = Project::empty();
    let tile = std::fs::read_to_string(repository().join("shaders/include/raxel/parallel.glsl")).unwrap();
    let (right, wrong) = ("certain = inside > bound;", "certain = true;");
    assert!(tile.contains(right));
    project.write("shaders/include/raxel/parallel.glsl", tile.replace(right, wrong));
    let scope = ["stress", "--scenes", "checkerboard,menger,gravel", "--sets", "parallel-ties", "--rays", "4e4"];
    let layouts = ["--layouts", "tree64,tree64:parallel", "--format", "json"];
    let run = project.raxel(&[&scope[..], &layouts].concat()).exits(1);
    let found = rows(&run);
    let count = |row: &str, name: &str| found[row]["total"][name].as_u64().unwrap();
    assert_eq!(count("tree64", "wrong") + count("tree64", "wrong_t"), 0);
    assert!(count("tree64:parallel", "wrong") > 100, "{}", found["tree64:parallel"]);
    raxel(&[&scope[..], &layouts].concat()).exits(0);
}

/// Rays that begin where the pixel of another ray is, and are traced with the voxels of their own.
#[test]
fn a_tile_that_takes_rays_of_other_pixels_is_caught() {
    let project = Project::empty();
    let tile = std::fs::read_to_string(repository().join("shaders/include/raxel/parallel.glsl")).unwrap();
    let (right, wrong) = ("abs(16.0 * x - float(pixel.x) * w) <= near", "abs(16.0 * x + float(pixel.x) * w) <= near");
    assert!(tile.contains(right));
    project.write("shaders/include/raxel/parallel.glsl", tile.replace(right, wrong));
    let scope = ["stress", "--scenes", "gravel,corners", "--sets", "parallel-moved", "--rays", "2e4"];
    let layouts = ["--layouts", "tree64:parallel", "--format", "json"];
    let run = project.raxel(&[&scope[..], &layouts].concat()).exits(1);
    let total = &rows(&run)["tree64:parallel"]["total"];
    assert!(total["wrong"].as_u64().unwrap() > 40, "{total}");
    raxel(&[&scope[..], &layouts].concat()).exits(0);
}

/// Further answers of tracers are judged, too: whether they find anything, and the voxels around a hit.
#[test]
fn a_tracer_that_is_wrong_beside_its_hits_is_caught() {
    let faults = [
        // This row reports only that something is hit, not the face.
        ("parallel", "uint axis = 3u;", "uint axis = 0u;", "tree64:parallel_any"),
        // Neither the outside of the world nor an empty cell counts as air.
        ("internal/layouts/tree64", "? rx_look(cell, log2_free) : 0u;", "? rx_look(cell, log2_free) : 1u;", "tree64"),
        (
            "internal/layouts/tree64",
            "log2_free = rx_free_octet(leaf, voxel) ? 1u : 0u;\n            return 0u;",
            "log2_free = 0u;\n            return 1u;",
            "tree64",
        ),
    ];
    for (file, right, wrong, row) in faults {
        let project = Project::empty();
        let path = format!("shaders/include/raxel/{file}.glsl");
        let text = std::fs::read_to_string(repository().join(&path)).unwrap();
        assert!(text.contains(right), "{path} has no `{right}`");
        project.write(&path, text.replace(right, wrong));
        let scope =
            ["stress", "--scenes", "gravel", "--sets", "parallel,parallel-edges", "--rays", "2e4", "--layouts", row];
        let run = project.raxel(&[&scope[..], &["--format", "json"]].concat()).exits(1);
        let found = rows(&run);
        assert!(found[row]["total"]["wrong"].as_u64().unwrap() > 50, "{wrong}: {}", found[row]);
    }
}

/// Packets that lose rays that they should hand on.
#[test]
fn a_packet_that_loses_rays_is_caught() {
    let project = Project::empty();
    let packet = std::fs::read_to_string(repository().join("shaders/include/raxel/packet.glsl")).unwrap();
    let (right, wrong) = ("rx_tile_rest(pixel, free * (0.999 * length(dir) / far_away));", "rx_tile_miss(pixel);");
    assert!(packet.contains(right));
    project.write("shaders/include/raxel/packet.glsl", packet.replace(right, wrong));
    let scope = ["stress", "--scenes", "hills,menger,gravel", "--sets", "tiles", "--rays", "4e4"];
    let layouts = ["--layouts", "tree64,tree64:packet", "--format", "json"];
    let run = project.raxel(&[&scope[..], &layouts].concat()).exits(1);
    let found = rows(&run);
    let count = |row: &str, name: &str| found[row]["total"][name].as_u64().unwrap();
    assert_eq!(count("tree64", "wrong") + count("tree64", "wrong_t"), 0);
    assert!(
        count("tree64:packet", "hits") > 1000 && count("tree64:packet", "wrong") > 100,
        "{}",
        found["tree64:packet"]
    );
    raxel(&[&scope[..], &layouts].concat()).exits(0);
}

/// No scene is wide enough for a table of sectors in place of a grid.
#[test]
fn a_table_of_sectors_is_traced_exactly_and_a_fault_in_it_is_caught() {
    let project = Project::empty();
    let places = [0, 700, 1400].map(|x| [0, 700, 1400].map(|y| [0, 700, 1400].map(|z| [x, y, z])));
    let boxes = places.as_flattened().as_flattened().iter().map(|[x, y, z]| {
        format!("[[build]]\nop = \"box\"\nmin = [{x}, {y}, {z}]\nsize = [60, 50, 40]\nmaterial = \"stone\"\n")
    });
    let world = format!("name = \"apart\"\n[materials.stone]\nalbedo = [0.5, 0.5, 0.5]\n{}", boxes.collect::<String>());
    project.write("worlds/apart.toml", world);
    let scope =
        ["stress", "--world", "worlds/apart.toml", "--layouts", "brickmap", "--rays", "2e4", "--format", "json"];
    let count = |run: Run, name: &str| rows(&run)["brickmap"]["total"][name].as_u64().unwrap();
    assert!(count(project.raxel(&scope).exits(0), "hits") > 1000);

    let path = "shaders/include/raxel/rivals/internal/layouts/brickmap.glsl";
    let brickmap = std::fs::read_to_string(repository().join(path)).unwrap();
    let (right, wrong) = ("RX_TOP_BIT | rx_table_free", "RX_TOP_BIT & rx_table_free");
    assert_eq!(brickmap.matches(right).count(), 1);
    project.write(path, brickmap.replace(right, wrong));
    assert!(count(project.raxel(&scope).exits(1), "wrong") > 100);
}
