//! Dispatches over lists: each element gets one thread, however many there are.

use raxel_execute::Builtins;
use raxel_graph::checked::Value;

use crate::lab::{Lab, Planned};

/// Five million threads of 64 are 78,125 workgroups: more than a device need take along x.
const LONG: u32 = 5_000_000;

const GRAPH: &str = include_str!("../fixtures/lists/lists.toml");

/// A workgroup with all three axes: its threads are neighbours all the same.
const LONG_SHADER: &str = include_str!("../fixtures/lists/long.comp");

/// A workgroup as wide as another list is long.
const PAIRS_SHADER: &str = include_str!("../fixtures/lists/pairs.comp");

const FILES: [(&str, &str); 3] =
    [("graphs/test.toml", GRAPH), ("shaders/long.comp", LONG_SHADER), ("shaders/pairs.comp", PAIRS_SHADER)];

#[test]
fn each_element_gets_one_thread() {
    let mut lab = Lab::new();
    let plan = lab.load(&FILES, &Planned { pinned: &["list", "pairs"], ..Planned::default() });
    assert!(plan.passes[0].groups.is_some_and(|[x, y, z]| x > 1 && y == 2 && z == 1), "{:?}", plan.passes[0].groups);
    assert_eq!(plan.passes[1].groups, Some([3, 1, 1]));
    lab.frame();
    let list = lab.words("list");
    assert_eq!(list.len(), LONG as usize);
    let wrong = (0_u32..).zip(&list).find(|(i, word)| **word != i + 1);
    assert_eq!(wrong, None, "element and what its threads added up to");
    let pairs = lab.words("pairs");
    assert_eq!(pairs.len(), 2 * 210);
    assert!(pairs.chunks(2).all(|pair| pair == [70, 210]), "{pairs:?}");
    assert_eq!(lab.floats("color", 0, 0, 0)[1][0], 6.0);
}

const WORLD_GRAPH: &str = include_str!("../fixtures/lists/world.toml");

const FILL: &str = include_str!("../fixtures/lists/fill.comp");

/// A target over the world has its extent; a world of another extent resizes it, and nothing is left of the old one.
#[test]
fn targets_follow_the_world() {
    let mut lab = Lab::new();
    for (world, extent) in [([16, 9, 5], [4_u32, 3, 2]), ([0; 3], [1; 3]), ([17, 1, 40], [5, 1, 10])] {
        let how = Planned { world, present: "probes", pinned: &["faces"], ..Planned::default() };
        lab.load(&[("graphs/test.toml", WORLD_GRAPH), ("shaders/fill.comp", FILL)], &how);
        lab.frame();
        let count: u32 = extent.iter().product();
        let slice = count / extent[2];
        for z in 0..extent[2] {
            let texels: Vec<u32> = lab.integers("probes", 0, z).iter().map(|texel| texel[0]).collect();
            assert_eq!(texels, (z * slice..(z + 1) * slice).map(|i| i + 6 * count).collect::<Vec<_>>(), "{world:?}");
        }
        let faces: Vec<u32> = (0..count).flat_map(|i| [i; 6]).collect();
        assert_eq!(lab.words("faces"), faces);
    }
}

/// A pass counts the queue; the pass behind it runs with as many threads, for any shape of its workgroup.
const QUEUE_GRAPH: &str = include_str!("../fixtures/lists/queue.toml");

const ENQUEUE: &str = r"#version 460
layout(local_size_x = 1) in;
layout(std430) writeonly buffer Queue { uint queue[]; };
layout(push_constant) uniform Push { uint count; };
void main() {
    for (int i = 0; i < 4; i++) queue[i] = i == 2 ? count : 1000000000u;
}";

/// The constant that sizes the workgroup has no name of its own.
const RUN: &str = include_str!("../fixtures/lists/run.comp");

#[test]
fn a_queue_gets_a_thread_for_each_element() {
    for wide in [1_u32, 32] {
        let graph = QUEUE_GRAPH.replace("\"WIDE\"", &wide.to_string());
        let files = [("graphs/test.toml", &graph[..]), ("shaders/enqueue.comp", ENQUEUE), ("shaders/run.comp", RUN)];
        let mut lab = Lab::new();
        let plan = lab.load(&files, &Planned { present: "hits", ..Planned::default() });
        let names: Vec<_> = plan.passes.iter().map(|live| plan.graph.pass(live.pass).name.as_str()).collect();
        assert_eq!(names, ["enqueue", "run.arguments", "run"]);
        for count in [0_u32, 1, 64, 65, 5_000_000] {
            lab.frame_with(&Builtins::default(), &[Value::U32(count)]);
            let hits = lab.words("hits");
            let wrong = (0_u32..5_000_001).zip(&hits).find(|(i, hit)| **hit != u32::from(i < &count));
            assert_eq!(wrong, None, "thread and how often it ran, of {count} in groups of {wide}×2");
            // Less than a workgroup is to spare in each row.
            let group = wide * 2;
            let spare: u32 = hits[5_000_001..].iter().sum();
            let rows = count.div_ceil(group).div_ceil(65_535);
            assert!(spare < (rows * group).max(1), "{spare} threads too many for {count}");
        }
        let report = lab.frame_with(&Builtins::default(), &[Value::U32(5_000_000)]);
        assert_eq!((report.dispatched, report.skipped), (0, 3), "a queue that did not change is not run again");
    }
}

const VALUES_GRAPH: &str = include_str!("../fixtures/lists/values.toml");

const SHOW: &str = include_str!("../fixtures/lists/show.comp");

/// The file's values are in the buffer, in the shader's layout; readers see an edit of them.
#[test]
fn values_are_in_their_buffer() {
    let mut lab = Lab::new();
    let mut shown = |graph: &str| {
        lab.load(&[("graphs/test.toml", graph), ("shaders/show.comp", SHOW)], &Planned::default());
        lab.frame();
        lab.floats("color", 0, 0, 0)[..4].to_vec()
    };
    let first = shown(VALUES_GRAPH);
    assert_eq!(
        first,
        [[0.0625, 1.0, 3.0, 2.0], [0.25, -4.0, -6.0, 2.0], [0.375, 1.0, 3.0, 2.0], [1.0, -4.0, -6.0, 2.0]]
    );
    let edited = shown(&VALUES_GRAPH.replace("0.25", "0.5"));
    assert_eq!(edited[1], [0.5, -4.0, -6.0, 2.0]);
    assert_eq!([edited[0], edited[2], edited[3]], [first[0], first[2], first[3]]);
    // On reset they are written again.
    lab.executor.reset_history();
    lab.frame();
    assert_eq!(lab.floats("color", 0, 0, 0)[1][0], 0.5);
}
