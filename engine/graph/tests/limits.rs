//! Graphs that are right in themselves and do not fit an output size or a device.
#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]
#![allow(missing_docs, reason = "a test")]

mod hand;

use std::fmt::Write as _;
use std::sync::Arc;

use hand::Hand;
use raxel_diagnostics::Span;
use raxel_graph::checked::{
    Buffer, BufferSize, Condition, Dispatch, Extent, Fact, Material, Pass, ResourceId, ResourceKind, UniformBlock,
    Value, ValueOrigin, Warning,
};
use raxel_graph::plan::DeviceLimits;
use raxel_shader::format::Format;
use raxel_shader::interface::Block;

/// All messages, in a line each.
fn said(hand: &Hand, shown: &str) -> String {
    let found = hand.plan(shown).expect_err("this graph does not fit");
    let mut text = String::new();
    for d in found {
        assert!(d.is_error());
        let _ = writeln!(text, "{}: {}", d.code, d.message);
        for label in &d.labels {
            let _ = writeln!(text, "  {}: {}", label.span.file, label.text);
        }
        for note in d.notes.iter().chain(&d.help) {
            let _ = writeln!(text, "  {note}");
        }
    }
    text
}

#[test]
fn everything_is_said_at_once() {
    let mut hand = Hand::new("large");
    hand.target("wide", Format::R32f, |target, _| target.extent = Extent::Output { scale: [20.0, 0.5] })
        .target("of_wide", Format::R32f, |target, _| {
            let target_ = raxel_graph::checked::ResourceId(0);
            target.extent = Extent::Of { target: target_, scale: 2.0 };
        })
        .target("deep", Format::R32f, |target, _| target.extent = Extent::Fixed3([8, 8, 1000]))
        .target("layered", Format::R32f, |target, _| target.layers = 300)
        .target("pyramid", Format::R32f, |target, _| target.mips = 12)
        .buffer("large", BufferSize::Of { of: raxel_graph::checked::ResourceId(0), per: 1, stride: 4096 }, None)
        .buffer("huge", BufferSize::Bytes(1 << 40), None)
        .buffer("short", BufferSize::Bytes(8), None);
    let all = ["w of_wide", "w deep", "w layered", "w pyramid", "w large", "x huge", "i short", "w wide"];
    hand.pass("everything", &all);
    insta::assert_snapshot!(said(&hand, "wide"));
}

#[test]
fn passes_have_limits_too() {
    let mut hand = Hand::new("passes");
    hand.limits = DeviceLimits { workgroup_count: [20, 100, 1], ..DeviceLimits::PORTABLE };
    hand.target("color", Format::R32f, |_, _| {});
    hand.pass("wide", &["w color"]);
    hand.pass("layers", &["x color"]).dispatch = Dispatch::Groups([1, 1, 2]);
    let pass = hand.pass("fat", &["x color"]);
    let mut shader = (*pass.shader).clone();
    shader.interface.local_size[0].spec_id = Some(3);
    shader.interface.push = Some(Block { name: "Push".into(), size: 192, members: Vec::new() });
    pass.shader = Arc::new(shader);
    pass.specialization = vec![(3, ValueOrigin::Value(Value::U32(32)))];
    pass.uniforms = vec![UniformBlock { binding: 0, size: 1 << 20, fills: Vec::new() }];
    insta::assert_snapshot!(said(&hand, "color"));
}

/// Needs of a shader beyond many devices: 512 threads by a constant, 20,000 shared bytes, 192 pushed bytes, two capabilities.
fn is_demanding(pass: &mut Pass) {
    let mut shader = (*pass.shader).clone();
    shader.interface.local_size[0].spec_id = Some(3);
    shader.interface.shared_bytes = 20_000;
    shader.interface.push = Some(Block { name: "Push".into(), size: 192, members: Vec::new() });
    shader.interface.capabilities = ["Shader", "Int64", "GroupNonUniformShuffle"].map(str::to_owned).to_vec();
    pass.shader = Arc::new(shader);
    pass.specialization = vec![(3, ValueOrigin::Value(Value::U32(64)))];
}

#[test]
fn what_many_devices_lack_is_a_warning_unless_the_pass_asks_for_it() {
    let mut hand = Hand::new("demanding");
    hand.limits = DeviceLimits {
        workgroup_invocations: 1024,
        workgroup_size: [1024; 3],
        shared_memory: 1 << 16,
        push_constants: 256,
        ..hand.limits
    };
    hand.target("color", Format::R32f, |_, _| {});
    is_demanding(hand.pass("heavy", &["w color"]));
    hand.pass("light", &["x color"]);
    let said = |hand: &Hand| {
        let found = raxel_graph::rarely_met(&hand.plan("color").unwrap());
        assert!(found.iter().all(|warning| !warning.is_error() && warning.code.as_str() == "RX0163"));
        found.iter().fold(String::new(), |text, d| {
            format!(
                "{text}{}; {}\n",
                d.message,
                [&d.labels[0].text].into_iter().chain(&d.notes).cloned().collect::<Vec<_>>().join("; ")
            )
        })
    };
    insta::assert_snapshot!(said(&hand), @r"
    pass `heavy` needs 512 workgroup threads, and many devices have 256; this pass; the limit is `maxComputeWorkGroupInvocations`
    pass `heavy` needs 20000 shared bytes, and many devices have 16384; this pass; the limit is `maxComputeSharedMemorySize`
    pass `heavy` needs 192 pushed bytes, and many devices have 128; this pass; the limit is `maxPushConstantsSize`
    pass `heavy` needs `Int64`, which not every device has; declared by the compiled shader
    pass `heavy` needs `GroupNonUniformShuffle`, which not every device has; declared by the compiled shader
    ");
    // Packets need 64-bit integers, and nothing else of these.
    hand.graph.passes[0].when = vec![Condition { fact: Fact::DevicePackets, negated: false }];
    hand.facts = true;
    let asked = said(&hand);
    assert!(!asked.contains("Int64") && asked.contains("GroupNonUniformShuffle"), "{asked}");
    hand.graph.passes[0].when[0].negated = true;
    hand.facts = false;
    assert!(said(&hand).contains("Int64"));
}

/// Vulkan guarantees images of some formats, and stores to fewer ("Required Format Support").
#[test]
fn a_format_that_not_every_device_has_is_a_warning() {
    let mut hand = Hand::new("formats");
    for (name, format) in [("a", Format::R8ui), ("c", Format::Rgba16f), ("d", Format::R16)] {
        hand.target(name, format, |_, _| {});
    }
    hand.target("color", Format::R32f, |_, _| {});
    hand.pass("store", &["w a", "w c", "w d"]);
    hand.pass("sum", &["s a", "s c", "s d", "w color"]);
    let found = raxel_graph::rarely_met(&hand.plan("color").unwrap());
    let said: Vec<&str> = found.iter().map(|warning| warning.message.as_str()).collect();
    assert_eq!(
        said,
        [
            "target `a` has the format `r8ui`, and not every device stores to images of it",
            "target `d` has the format `r16`, and not every device has images of it"
        ]
    );
}

#[test]
fn specialization_sizes_the_dispatch() {
    let mut hand = Hand::new("specialized");
    hand.target("color", Format::R32f, |_, _| {});
    let pass = hand.pass("fill", &["w color"]);
    let mut shader = (*pass.shader).clone();
    shader.interface.local_size[0].spec_id = Some(7);
    pass.shader = Arc::new(shader);
    assert_eq!(hand.plan("color").unwrap().passes[0].groups, Some([40, 23, 1]));
    hand.graph.passes[0].specialization = vec![(7, ValueOrigin::Value(Value::U32(16)))];
    assert_eq!(hand.plan("color").unwrap().passes[0].groups, Some([20, 23, 1]));
}

#[test]
fn what_is_culled_need_not_fit() {
    let mut hand = Hand::new("culled");
    hand.target("color", Format::R32f, |_, _| {}).buffer("huge", BufferSize::Bytes(1 << 40), None);
    hand.pass("fill", &["w color"]);
    hand.pass("unused", &["w huge"]);
    assert!(hand.plan("color").is_ok());
}

#[test]
fn only_what_is_there_can_be_shown() {
    let mut hand = Hand::new("shown");
    hand.target("color", Format::R32f, |target, history| {
        target.layers = 2;
        *history = 1;
    });
    hand.pass("fill", &["w color"]);
    assert!(hand.plan("color@1").is_ok());
    insta::assert_snapshot!(said(&hand, "color@2"), @r"
    RX0179: `color` has no earlier frame 2 to show: it has 0 to 1
      graphs/hand.toml: declared here
    ");
}

#[test]
fn a_warning_counts_in_its_buffer() {
    let mut hand = Hand::new("warned");
    hand.target("color", Format::R32f, |_, _| {}).buffer("queue", BufferSize::Bytes(8), Some(0));
    hand.pass("fill", &["w color", "x queue"]);
    let at = |offset| Warning { offset, says: "lost".into(), help: None, place: Span::new("graphs/hand.toml", 0..0) };
    hand.graph.resources[1].warnings = vec![at(4), at(0)];
    let text = raxel_graph::print::text(&hand.plan("color").unwrap());
    assert!(text.ends_with("not 0\n  queue + 4: lost\n  queue: lost\n"), "{text}");
    hand.graph.resources[1].warnings.push(at(8));
    insta::assert_snapshot!(said(&hand, "color"), @r"
    RX0182: a warning of `queue` counts at offset 8, but `queue` has 8 bytes
      graphs/hand.toml: this offset
      graphs/hand.toml: declared here
      offsets are in bytes; that of the last `uint` is 4
    ");
}

#[test]
fn sizes_follow_the_output() {
    let mut hand = Hand::new("sizes");
    hand.output = [333, 7];
    hand.target("full", Format::R32f, |target, _| target.mips = 0)
        .target("half", Format::R32f, |target, _| target.extent = Extent::Output { scale: [0.5, 0.01] })
        .target("quarter", Format::R32f, |target, _| {
            target.extent = Extent::Of { target: raxel_graph::checked::ResourceId(1), scale: 0.5 };
            target.layers = 3;
        })
        .buffer("texels", BufferSize::Of { of: raxel_graph::checked::ResourceId(2), per: 1, stride: 8 }, None);
    hand.pass("fill", &["w full", "w half", "w quarter", "w texels"]);
    let text = hand.with_input("full", |graph, input| raxel_graph::dump(graph, input, raxel_graph::Phase::Sizes));
    let plan = hand.plan("full").unwrap();
    let told = [0, 1, 2].map(|id| plan.constant(&ValueOrigin::ExtentOf(ResourceId(id))));
    let expected = [[333, 7, 1, 1], [167, 1, 1, 1], [84, 1, 3, 1]];
    assert_eq!(told, expected.map(|extent| Some(Value::IVec4(extent))));
    insta::assert_snapshot!(text.unwrap(), @r"
    full: 333×7×1 texels, 9 mips, 1 layers
    half: 167×1×1 texels, 1 mips, 1 layers
    quarter: 84×1×1 texels, 1 mips, 3 layers
    texels: 2016 bytes
    ");
}

/// The world in its graph: three dimensions, rounded up, at least one texel; any size may follow it.
#[test]
fn sizes_follow_the_world() {
    let mut hand = Hand::new("world");
    hand.target("probes", Format::R32f, |target, _| {
        target.extent = Extent::World { scale: 0.0625 };
        target.mips = 0;
    })
    .target("half", Format::R32f, |target, _| {
        target.extent = Extent::Of { target: ResourceId(0), scale: 0.5 };
    })
    .buffer("faces", BufferSize::World { scale: 0.25, per: 6, stride: 4 }, None)
    .buffer("pairs", BufferSize::Of { of: ResourceId(2), per: 2, stride: 8 }, None);
    hand.pass("fill", &["w probes", "w half", "w faces", "w pairs"]).dispatch =
        Dispatch::ElementsOf { buffer: ResourceId(3) };
    let told = |hand: &Hand| {
        hand.with_input("probes", |graph, input| raxel_graph::dump(graph, input, raxel_graph::Phase::Sizes).unwrap())
    };
    let mut text = told(&hand);
    let plan = hand.plan("probes").unwrap();
    assert_eq!(plan.constant(&ValueOrigin::ExtentOf(ResourceId(0))), Some(Value::IVec4([7, 4, 3, 1])));
    assert_eq!(plan.constant(&ValueOrigin::CountOf(ResourceId(3))), Some(Value::U32(25 * 15 * 10 * 6 * 2)));
    // 45,000 threads in groups of 64.
    assert_eq!(plan.passes[0].groups, Some([704, 1, 1]));
    hand.world = [0; 3];
    let _ = writeln!(text, "\nwithout a voxel\n{}", told(&hand));
    assert!(hand.plan("probes").is_ok());
    hand.world = [1 << 20, 1, u32::MAX];
    hand.limits.image_3d = 2048;
    let _ = writeln!(text, "without end\n{}", said(&hand, "probes"));
    insta::assert_snapshot!(text);
}

/// Workgroups that do not fit in one row continue in the next, and the rows are of one length.
#[test]
fn long_lists_take_rows() {
    let mut hand = Hand::new("rows");
    hand.target("color", Format::R32f, |_, _| {}).buffer(
        "list",
        BufferSize::Elements { count: 64 * 65_535, stride: 4 },
        None,
    );
    hand.pass("walk", &["x list", "w color"]).dispatch = Dispatch::ElementsOf { buffer: ResourceId(1) };
    assert_eq!(hand.plan("color").unwrap().passes[0].groups, Some([65_535, 1, 1]));
    let mut with = |count: u64| {
        hand.graph.resources[1].kind =
            ResourceKind::Buffer(Buffer { size: BufferSize::Elements { count, stride: 4 }, clear: None, init: None });
        hand.plan("color").unwrap().passes[0].groups
    };
    assert_eq!(with(64 * 65_535 + 1), Some([32_768, 2, 1]));
    assert_eq!(with(1), Some([1, 1, 1]));
    assert_eq!(with(5_000_000), Some([39_063, 2, 1]));
    // A constant can follow the size of a list, and then the dispatch follows the constant.
    hand.buffer("groups", BufferSize::Elements { count: 16, stride: 4 }, None);
    let pass = &mut hand.graph.passes[0];
    let mut shader = (*pass.shader).clone();
    shader.interface.local_size[0].spec_id = Some(3);
    pass.shader = Arc::new(shader);
    pass.specialization = vec![(3, ValueOrigin::CountOf(ResourceId(2)))];
    let planned = hand.plan("color").unwrap();
    assert_eq!(
        (&planned.passes[0].specialization[..], planned.passes[0].groups),
        (&[(3, Value::U32(16))][..], Some([39_063, 1, 1]))
    );
}

/// Only the world knows the index of a material. A missing material is an error at its name, for passes that run.
#[test]
fn materials_are_those_of_the_world() {
    let mut hand = Hand::new("materials");
    hand.target("color", Format::R32f, |_, _| {}).target("other", Format::R32f, |_, _| {});
    for (number, (pass, name)) in [("w color", "lamp"), ("w other", "pine 3")].into_iter().enumerate() {
        let made = hand.pass(name, &[pass]);
        made.specialization = vec![(0, ValueOrigin::Material(number as u32))];
        let place = made.place.clone();
        hand.graph.materials.push(Material { name: name.to_owned(), place });
    }
    assert_eq!(hand.plan("color").unwrap().passes[0].specialization, [(0, Value::U32(0))], "nobody knows the world");
    hand.materials = Some(["air", "stone", "lamp"].map(str::to_owned).to_vec());
    assert_eq!(hand.plan("color").unwrap().passes[0].specialization, [(0, Value::U32(2))]);
    hand.materials = Some(["air", "lamps"].map(str::to_owned).to_vec());
    let text = said(&hand, "color") + &said(&hand, "other");
    insta::assert_snapshot!(text);
}
