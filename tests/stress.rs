//! `raxel stress`: every tracer is held to the exact one, a broken one is caught, and the same command counts the same.

mod common;

use std::collections::BTreeMap;

use common::{Project, Run, RunRaxel, command, raxel, repository};
use serde_json::Value;

/// The rows of a run, by name.
fn rows(run: &Run) -> BTreeMap<String, Value> {
    let named = |value: Value| Some((value["row"].as_str()?.to_owned(), value));
    run.json().into_iter().filter(|value| value["reason"] == "stressed").filter_map(named).collect()
}

#[test]
fn every_tracer_that_claims_to_be_exact_is() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().display().to_string();
    let run = raxel(&["stress", "--rays", "5.5e5", "--validate", "--format", "json", "-o", &folder]).exits(0);
    let rows = rows(&run);
    let count = |row: &Value, name: &str| row["total"][name].as_u64().unwrap();
    let exact: Vec<_> = rows.values().filter(|row| row["exact"] == true).collect();
    assert!(exact.len() >= 23 && rows.contains_key("brickmap:ahead"), "{:?}", rows.keys());
    let of_tiles = ["tree64:beam", "tree64:packet"];
    for row in exact.iter().filter(|row| of_tiles.iter().all(|name| row["row"] != *name)) {
        let of_periods = ["flat64:period", "flat64:refill"].iter().any(|name| row["row"] == *name);
        // Instances stand near alone, and rays go on from hits alone.
        match row["row"].as_str().unwrap() {
            "tree64:instances" => assert!(count(row, "rays") > 5000 && count(row, "hits") > 1500, "{row}"),
            "tree64:onward" => assert!(count(row, "rays") > 3000 && count(row, "hits") > 2000, "{row}"),
            "tree64:instances_onward" => assert!(count(row, "rays") > 1500 && count(row, "hits") > 1000, "{row}"),
            _ => {}
        }
        if ["tree64:instances", "tree64:onward", "tree64:instances_onward"].iter().any(|name| row["row"] == *name) {
            continue;
        }
        let ties = if of_periods { 100 } else { 1000 };
        assert!(count(row, "rays") > 10_000 && count(row, "hits") > 2000 && count(row, "ties") > ties, "{row}");
    }
    // Period rays are near the rays of every set.
    for row in ["flat64:period", "flat64:refill"].map(|name| &rows[name]) {
        assert!(row["exact"] == true && row["sets"]["far-pinhole"]["rays"].as_u64().unwrap() > 100, "{row}");
    }
    // Beams and packets are for the tiles of pixels alone.
    for row in of_tiles.map(|name| &rows[name]) {
        let of_sets = [
            "tiles",
            "octant-tiles",
            "grazing-tiles",
            "lattice-tiles",
            "skimming-tiles",
            "hidden-tiles",
            "wrapped-tiles",
            "range-end-tiles",
            "far-tiles",
        ]
        .map(|set| row["sets"][set]["rays"].as_u64().unwrap());
        assert!(row["exact"] == true && of_sets.iter().all(|rays| *rays > 300), "{row}");
        assert_eq!(count(row, "rays"), of_sets.iter().sum::<u64>(), "{row}");
    }
    for row in ["tree64:parallel", "tree64:parallel_any"].map(|name| &rows[name]) {
        let mut grids = ["parallel", "parallel-edges", "parallel-beside", "parallel-ties", "parallel-depths"].iter();
        assert!(row["exact"] == true && grids.all(|set| row["sets"][set]["rays"].as_u64().unwrap() > 300), "{row}");
    }
    // Publications are for all sets, near and far.
    let streamed = &rows["tree64:streamed"];
    assert!(streamed["exact"] == true && streamed["refused"].as_array().unwrap().is_empty(), "{streamed}");
    assert_eq!(count(streamed, "rays"), count(&rows["tree64"], "rays"), "{streamed}");
    for row in exact {
        for column in ["wrong", "hangs", "wrong_t", "wrong_uv", "wrong_steps", "beyond_t_max"] {
            assert_eq!(count(row, column), 0, "{column}: {row}");
        }
        // Instances do not stand at the ends of the coordinates.
        let refused = row["refused"].as_array().unwrap();
        let posed = row["row"].as_str().unwrap().starts_with("tree64:instances");
        let far = |site: &Value| posed && site["site"].as_str().unwrap().ends_with("@far");
        assert!(refused.iter().all(far), "{row}");
    }
    // The judge notices errors: marchers in plain f32 miss voxels by their edges.
    let dda = &rows["tree64:dda"];
    assert!(count(dda, "wrong") > 100 && count(dda, "missed") > 10 && count(dda, "early") > 10, "{dda}");
    assert!(dda["sets"]["silhouettes"]["wrong_ppm"].as_f64().unwrap() > 1000.0);
    assert!(dda["total"]["missed_chord_voxels"].as_f64().unwrap() > 0.0);

    let port = &rows["tree64:cpu"]["differs_from_device"];
    assert_eq!((&port["hits"], &port["steps"]), (&Value::from(0), &Value::from(0)), "{port}");

    let summary = run.json().into_iter().find(|value| value["reason"] == "stress").unwrap();
    assert!(summary["rays"].as_u64().unwrap() >= 280_000);
    assert!(summary["symmetry"]["tree64"]["turned"].as_u64().unwrap() > 5000);
    assert_eq!(summary["symmetry"]["tree64"]["moved_wrong"], 0);

    let csv = std::fs::read_to_string(out.path().join("stress.csv")).unwrap();
    assert!(csv.starts_with("row,site,set,rays,hits,") && csv.contains("\ntree64,hills@far,edges,"), "{csv}");
    let json: Value = serde_json::from_slice(&std::fs::read(out.path().join("stress.json")).unwrap()).unwrap();
    assert_eq!(json["rows"].as_array().unwrap().len(), rows.len());
}

/// A project whose tracer never asks integers when floating point cannot decide.
fn broken() -> Project {
    let project = Project::empty();
    let walk = std::fs::read_to_string(repository().join("shaders/include/raxel/internal/walk.glsl")).unwrap();
    let (before, rest) = walk.split_once("const float RX_WALK_ERROR = ").expect("the bound of the tracer's error");
    let (_, after) = rest.split_once(';').unwrap();
    project
        .write("shaders/include/raxel/internal/walk.glsl", format!("{before}const float RX_WALK_ERROR = 0.0;{after}"));
    project
}

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

/// Faults in the tracer of instances: of turned models, of those on the lattice, of the order of hits.
#[test]
fn faults_in_instances_are_caught() {
    let library = |name: &str| format!("shaders/include/raxel/{name}.glsl");
    let text = |name: &str| std::fs::read_to_string(repository().join(library(name))).unwrap();
    let scope = ["stress", "--scenes", "gravel@near,hills@near", "--rays", "4e4", "--format", "json"];
    let scope = [&scope[..], &["--layouts", "tree64,tree64:instances"]].concat();
    for (file, right, wrong) in [
        ("instance_frame", "uvec2(0u, 0x4000u)", "uvec2(0u, 0x3fffu)"),
        ("instance_voxels", "? last - c : c", "? last - 1u - c : c"),
        ("instances", "uint shift = exponent + 1u - top;", "uint shift = exponent - top;"),
        ("instances", "return p.z != q.z ? p.z < q.z", "return p.z != q.z ? p.z > q.z"),
        (
            "instances",
            "rx_instance_turns_around(instance, axis) ? 1u : 0u",
            "rx_instance_turns_around(instance, axis) ? 0u : 1u",
        ),
        // Packed materials: the halfword of the palette, where it ends, and voxels without one.
        ("instance_voxels", "own & 1u", "0u"),
        ("instance_voxels", "kind == 4u ? 0u : (1u << bits) >> 1", "kind == 4u ? 0u : (1u << bits) >> 2"),
        ("instance_voxels", "code == 3u ? 4u : code", "code"),
    ] {
        let whole = text(file);
        assert_eq!(whole.matches(right).count(), 1, "{right}");
        let project = Project::empty();
        project.write(&library(file), whole.replace(right, wrong));
        let run = project.raxel(&scope).exits(1);
        let found = rows(&run);
        let count = |row: &str| found[row]["total"]["wrong"].as_u64().unwrap();
        assert_eq!(count("tree64"), 0);
        assert!(count("tree64:instances") > 0, "{wrong}: {}", found["tree64:instances"]);
    }
    raxel(&scope).exits(0);
}

/// Faults in rays that continue from hits, and in shaders that store voxels. Each fault is planted in one file, and the row that runs it must notice.
#[test]
fn faults_in_what_goes_on_from_hits_and_in_stored_voxels_are_caught() {
    let chunk_table = "rivals/internal/layouts/chunk_table";
    for (file, row, right, wrong) in [
        ("ray", "tree64:onward", "float plane = (face & 1u) != 0u ? 0.0 : 1.0;", "float plane = 0.0;"),
        ("ray", "tree64:onward", "v = axis == 2u ? ivec3(0, 1, 0)", "v = axis == 1u ? ivec3(0, 1, 0)"),
        (
            "box",
            "tree64:onward",
            "min(end - 1, ivec3(2147483647 - margin)) + margin",
            "min(end - 1, ivec3(2147483647 - margin)) - margin",
        ),
        ("instance_frame", "tree64:instances_onward", "+ ivec3(sum >> 24) - 1", "+ ivec3(sum >> 24)"),
        (
            "instances",
            "tree64:instances_onward",
            "turned = scene_ray.start;",
            "rx_ray_in_instance(instance, ray, direction, turned);",
        ),
        (
            "internal/layouts/octree",
            "octree:stored",
            "atomicOr(world.words[at], 1u << number)",
            "atomicOr(world.words[at], 2u << number)",
        ),
        (
            chunk_table,
            "chunk_table:stored",
            "if (!rx_in_world(cell)) return false;",
            "if (!rx_in_world(cell)) return true;",
        ),
        ("rivals/internal/layouts/chunks", "chunks:stored", "index & 1u, material", "0u, material"),
    ] {
        let source = std::fs::read_to_string(repository().join(format!("shaders/include/raxel/{file}.glsl"))).unwrap();
        assert!(source.contains(right), "{right}");
        let project = Project::empty();
        project.write(&format!("shaders/include/raxel/{file}.glsl"), source.replace(right, wrong));
        let scope = ["stress", "--scenes", "hills", "--rays", "2e4", "--format", "json", "--layouts", row];
        let found = rows(&project.raxel(&scope).exits(1));
        assert!(found[row]["total"]["wrong"].as_u64().unwrap() > 0, "{file} {wrong}: {}", found[row]);
        raxel(&scope).exits(0);
    }
}

/// Tracers that know where an encoded world has its nodes and its materials: a streamer puts them elsewhere.
#[test]
fn faults_in_publications_are_caught() {
    let tree64 =
        std::fs::read_to_string(repository().join("shaders/include/raxel/internal/layouts/tree64.glsl")).unwrap();
    let scope = ["stress", "--scenes", "gravel,hills", "--rays", "4e4", "--format", "json"];
    let scope = [&scope[..], &["--layouts", "tree64,tree64:streamed"]].concat();
    for (right, wrong) in [
        // The nodes below the root come behind it in an encoded world.
        (
            "uint at = node.z + rx_child_rank(node.xy, child);",
            "uint at = (height == top && top > 3u ? world.root + 1u : node.z) + rx_child_rank(node.xy, child);",
        ),
        // The header of an encoded world counts leaves, that of a publication does not.
        (
            "return ((c.x | c.y | c.z) >> world.log2_size) == 0u ? rx_look(cell, log2_free) : 0u;",
            "return world.leaf_count > 0u && ((c.x | c.y | c.z) >> world.log2_size) == 0u ? rx_look(cell, log2_free) : 0u;",
        ),
    ] {
        assert_eq!(tree64.matches(right).count(), 1, "{right}");
        let project = Project::empty();
        project.write("shaders/include/raxel/internal/layouts/tree64.glsl", tree64.replace(right, wrong));
        let run = project.raxel(&scope).exits(1);
        let found = rows(&run);
        let count = |row: &str| found[row]["total"]["wrong"].as_u64().unwrap();
        assert_eq!(count("tree64"), 0);
        assert!(count("tree64:streamed") > 100, "{wrong}: {}", found["tree64:streamed"]);
        assert!(run.stderr.contains("tree64:streamed is wrong about "), "{}", run.stderr);

        // The offered command shows the error again, beside the right hit in that publication.
        let offered = run.json().into_iter().find(|value| value["reason"] == "wrong-ray").expect("a wrong ray");
        let offered = offered["command"].as_str().unwrap().trim_start_matches("raxel ").to_owned();
        let (words, ray) = offered.split_once('"').unwrap();
        let mut arguments: Vec<&str> = words.split_whitespace().collect();
        arguments.push(ray.trim_end_matches('"'));
        let alone = project.raxel(&arguments).exits(1).stdout;
        assert!(alone.contains("WRONG: ") && alone.contains(", exactly "), "{offered}\n{alone}");
        assert!(!raxel(&arguments).exits(0).stdout.contains("WRONG"), "the tracer as it is gets it right");
    }
    raxel(&scope).exits(0);
}

/// Faults in the tracer of period rays, each found by both rows that use it.
#[test]
fn faults_in_period_rays_are_caught() {
    let period = std::fs::read_to_string(repository().join("shaders/include/raxel/period.glsl")).unwrap();
    // Without a step in the end a ray takes all rounds that the device lets it. A driver that ends no loop is given up.
    for (right, wrong, rays) in [
        ("cell + vec3(lessThanEqual(crossed", "cell + vec3(lessThan(crossed", "200"),
        ("0x00330033u) == 0u ? 7u : 3u;", "0x00330033u) == 0u ? 15u : 3u;", "4e4"),
    ] {
        let scope = ["stress", "--scenes", "gravel,hills", "--sets", "pinhole,bounce,lattice", "--rays", rays];
        let scope = [&scope[..], &["--layouts", "flat64,flat64:period,flat64:refill", "--format", "json"]].concat();
        let project = Project::empty();
        assert_eq!(period.matches(right).count(), 1);
        project.write("shaders/include/raxel/period.glsl", period.replace(right, wrong));
        let run = project.raxel(&scope);
        if run.code == 5 && wrong.contains("lessThan(crossed") {
            continue;
        }
        let run = run.exits(1);
        let found = rows(&run);
        let count = |row: &str| found[row]["total"]["wrong"].as_u64().unwrap();
        assert_eq!(count("flat64"), 0);
        for row in ["flat64:period", "flat64:refill"] {
            assert!(count(row) > 5, "{wrong}: {}", found[row]);
            assert!(run.stderr.contains(&format!("{row} is wrong about ")), "{}", run.stderr);
        }
        raxel(&scope).exits(0);
    }
}

#[test]
fn the_same_seed_counts_the_same_on_any_number_of_threads() {
    let count = |threads: &str, seed: &str| {
        let scope =
            ["stress", "--scenes", "hills,dust", "--layouts", "tree64,tree64:dda", "--rays", "1e5", "--seed", seed];
        let out = tempfile::tempdir().unwrap();
        let file = out.path().join("a.csv");
        let mut command = command(repository(), &scope);
        command.arg("-o").arg(&file).env("RAYON_NUM_THREADS", threads);
        assert!(common::output(&mut command).status.success());
        std::fs::read_to_string(file).unwrap()
    };
    let one = count("1", "7");
    assert_eq!(one, count("3", "7"));
    assert_ne!(one, count("3", "8"));
}

#[test]
fn what_is_named_twice_is_traced_once() {
    let scope = ["stress", "--scenes", "menger@far,menger@far", "--sets", "zeros,zeros", "--layouts", "svo,svo"];
    let run = raxel(&[&scope[..], &["--rays", "1024", "--format", "json"]].concat()).exits(0);
    assert_eq!(run.json().iter().filter(|value| value["reason"] == "stressed").count(), 1);
    assert_eq!(rows(&run)["svo"]["total"]["rays"], 1024);
}

#[test]
fn wrong_words_are_answered_with_the_right_ones() {
    for (arguments, help) in [
        (["--sets", "pinhle"], "did you mean `pinhole`?"),
        (["--scenes", "mengr"], "did you mean `menger`?"),
        (["--scenes", "menger@fra"], "did you mean `far`?"),
        (["--layouts", "tree46"], "did you mean `tree64`?"),
        (["--layouts", "tree64:dad"], "did you mean `dda`?"),
        (["--layouts", "octree:cpu"], "tree64:cpu"),
        (["--layouts", "svo:streamed"], "tree64:streamed"),
        (["--layouts", "svo:stored"], "chunk_table:stored"),
        (["--rays", "lots"], "e.g. 1e9"),
        (["--rays", "0"], "1 to 1e13"),
        (["--ray", "1 2 3"], "nine numbers"),
        (["--ray", "0 20 0  1.5 0.5 -3  1 0 0"], "from 0 to 1"),
        (["-o", "/nonexistent/folder/a.csv"], "does not exist"),
        (["-o", "s.txt"], "FILE.csv, FILE.json, or a folder"),
    ] {
        let run = raxel(&[&["stress"], &arguments[..]].concat()).exits(2);
        assert!(run.stderr.contains(help), "{arguments:?}: {}", run.stderr);
        assert!(run.stdout.is_empty());
    }
    assert!(!repository().join("s.txt").exists());
    raxel(&["stress", "--world", "worlds/none.toml"]).exits(3);
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

#[test]
fn worlds_of_files_are_traced_and_too_wide_ones_refused() {
    let scope =
        ["stress", "--world", "worlds/menger.toml", "--layouts", "tree64,svo", "--rays", "4e4", "--format", "json"];
    let found = rows(&raxel(&scope).exits(0));
    assert!(found["svo"]["total"]["hits"].as_u64().unwrap() > 1000);

    let project = Project::empty();
    let far = |x: i64| format!("[[build]]\nop = \"box\"\nmin = [{x}, 0, 0]\nsize = [4, 4, 4]\nmaterial = \"stone\"\n");
    let materials = "name = \"wide\"\n[materials.stone]\nalbedo = [0.5, 0.5, 0.5]\n";
    project.write("worlds/wide.toml", format!("{materials}{}{}", far(-2_000_000_000), far(2_000_000_000)));
    let run =
        project.raxel(&["stress", "--world", "worlds/wide.toml", "--layouts", "tree64", "--rays", "1000"]).exits(3);
    assert!(run.stdout.contains("voxels wide, and the layout `tree64` holds at most"), "{}", run.stdout);
}
