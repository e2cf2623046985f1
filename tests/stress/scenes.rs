//! Faults in what is traced beside a fixed world: instances, rays from hits, stored voxels, publications, period rays.

use crate::common::{Project, RunRaxel, raxel, repository};
use crate::rows;

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
