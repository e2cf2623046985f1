//! Sources that are written in part while plans read them.

use raxel_execute::{ExternalResource, Texture, WriteError};
use raxel_gpu::Device;
use raxel_shader::format::Format;
use raxel_shader::interface::Access;

use crate::lab::{Lab, Planned, at, graph, graph_with};

const TOML: &str = include_str!("../fixtures/sources/sources.toml");

const TEXTURE: Texture = Texture { format: Format::R16ui, extent: [8, 1, 1], volume: true };

/// The first rows show words, the last one texels.
const SHOW: &str = include_str!("../fixtures/sources/show.comp");

/// A lab that shows 24 words (all 1) and 8 texels (all 2) of a source.
fn lab() -> (Lab, std::sync::Arc<ExternalResource>) {
    let mut lab = Lab::new();
    let builder = lab.executor.builder();
    let words = vec![1_u32; 1 << 16];
    let buffer = builder.upload_buffer(bytemuck::cast_slice(&words), "words").expect("it fits");
    let mips: Vec<Vec<u16>> = (0..4).map(|mip| vec![2; 8 >> mip]).collect();
    let mips: Vec<&[u8]> = mips.iter().map(|mip| bytemuck::cast_slice(mip)).collect();
    let image = builder.upload_image("voxels", TEXTURE, &mips).expect("it fits");
    let source = builder.source("test.words", Some(buffer), Some((image, Format::R16ui)));
    lab.sources.insert("words", source.clone());
    lab.sources.insert("voxels", source.clone());
    let plan = lab.plan(&graph(&[("graphs/test.toml", TOML), ("shaders/show.comp", SHOW)]), &Planned::default());
    let prepared = lab.prepare(&plan).expect("it suits the device");
    lab.executor.swap(prepared);
    (lab, source)
}

fn shown(lab: &mut Lab) -> Vec<u32> {
    lab.integers("color", 0, 0).iter().map(|texel| texel[0]).collect()
}

/// How often a frame waits for the device.
fn waits(device: &Device, frame: impl FnOnce()) -> u64 {
    let before = device.waits();
    frame();
    device.waits() - before
}

#[test]
fn a_part_that_is_written_shows_in_the_next_frame_and_nothing_runs_without() {
    let (mut lab, source) = lab();
    assert_eq!(lab.frame().dispatched, 1);
    let version = source.version();
    assert_eq!((lab.frame().dispatched, lab.frame().skipped), (0, 1));
    assert_eq!(source.version(), version);

    let device = lab.device.clone();
    let without = waits(&device, || assert_eq!(lab.frame().dispatched, 0));
    source.write(4 * 10, bytemuck::bytes_of(&[7_u32, 8])).unwrap();
    source.write_texels(0, [3, 0, 0], [2, 1, 1], bytemuck::bytes_of(&[5_u16, 6])).unwrap();
    let with = waits(&device, || assert_eq!(lab.frame().dispatched, 1));
    // The one wait of each frame is for the frame in flight before the last one.
    assert_eq!((with, without), (1, 1));
    assert_ne!(source.version(), version);
    let mut expected = vec![1; 24];
    expected.extend([2; 8]);
    expected.splice(10..12, [7, 8]);
    expected.splice(27..29, [5, 6]);
    assert_eq!(shown(&mut lab), expected);
    assert_eq!((lab.frame().dispatched, lab.frame().skipped), (0, 1));

    // Of writes that overlap the last one wins, whether they wait for the same frame or not.
    for value in 20..30_u32 {
        source.write(4 * 2, bytemuck::bytes_of(&[value; 3])).unwrap();
        source.write(4 * 4, bytemuck::bytes_of(&[value + 100])).unwrap();
        source.write_texels(0, [0, 0, 0], [1, 1, 1], bytemuck::bytes_of(&(value as u16))).unwrap();
        if value % 3 == 0 {
            lab.frame();
        }
    }
    lab.frame();
    expected.splice(2..5, [29, 29, 129]);
    expected[24] = 29;
    assert_eq!(shown(&mut lab), expected);
}

#[test]
fn a_plan_that_is_swapped_in_sees_what_was_written_before() {
    let (mut lab, source) = lab();
    lab.frame();
    source.write(0, &9_u32.to_le_bytes()).unwrap();
    let plan = lab.executor.plan().expect("it runs").clone();
    let prepared = lab.prepare(&plan).expect("it suits the device");
    lab.executor.swap(prepared);
    lab.frame();
    assert_eq!(shown(&mut lab)[..2], [9, 1]);
    lab.executor.reset_history();
    lab.frame();
    assert_eq!(shown(&mut lab)[..2], [9, 1]);
}

#[test]
fn more_than_a_frame_takes_follows_in_order() {
    let (mut lab, source) = lab();
    lab.frame();
    // 48 MiB; a frame takes 32.
    let words = vec![3_u32; 1 << 16];
    for _ in 0..192 {
        source.write(0, bytemuck::cast_slice(&words)).unwrap();
    }
    source.write(0, &4_u32.to_le_bytes()).unwrap();
    lab.frame();
    assert_eq!(shown(&mut lab)[..2], [3, 3]);
    lab.frame();
    assert_eq!(shown(&mut lab)[..2], [4, 3]);
}

#[test]
fn parts_that_are_not_there_are_refused() {
    let (mut lab, source) = lab();
    let refused = |result| matches!(result, Err(WriteError::OutOfRange { .. }));
    assert!(refused(source.write(1 << 18, &[0; 4])));
    assert!(refused(source.write(u64::MAX, &[0; 4])));
    assert!(refused(source.write_texels(4, [0; 3], [1; 3], &[0; 2])));
    assert!(refused(source.write_texels(0, [8, 0, 0], [1; 3], &[0; 2])));
    assert!(refused(source.write_texels(0, [u32::MAX, 0, 0], [1; 3], &[0; 2])));
    assert!(refused(source.write_texels(0, [0; 3], [1; 3], &[0; 4])));
    assert!(refused(source.write_texels(0, [0; 3], [0; 3], &[])));
    let words = vec![0_u8; 1 << 18];
    let error = (0..2000).find_map(|_| source.write(0, &words).err());
    assert_eq!(error, Some(WriteError::TooMany { waiting: 256 << 20 }));
    source.write(0, &[]).unwrap();
    lab.frame();
    source.write(0, &words).unwrap();
}

/// Adds one to each word of a writable source, then shows them; every dispatch sees what the last one stored.
const COUNTING: &str = include_str!("../fixtures/sources/counting.toml");

const COUNT: &str = "#version 460
layout(local_size_x = 8) in;
buffer Words { uint words[]; } words;
void main() { words.words[gl_GlobalInvocationID.x] += 1u; }";

const SHOW_WORDS: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 4) in;
readonly buffer Words { uint words[]; } words;
layout(r32ui) writeonly uniform uimage2D outColor;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    imageStore(outColor, p, uvec4(words.words[p.y * 8 + p.x]));
}";

/// A lab in which passes count in a source itself, or in a copy of it. The passes run in even frames.
fn counting(origin: &str, access: Access) -> (Lab, std::sync::Arc<ExternalResource>) {
    let mut lab = Lab::new();
    let source = lab.supply("words", bytemuck::cast_slice(&[10_u32; 32]));
    let toml = COUNTING.replace("# ORIGIN", origin);
    let files = [("graphs/test.toml", toml.as_str()), ("shaders/count.comp", COUNT), ("shaders/show.comp", SHOW_WORDS)];
    let plan = lab.plan(&graph_with(&files, access), &Planned::default());
    let prepared = lab.prepare(&plan).expect("it suits the device");
    lab.executor.swap(prepared);
    (lab, source)
}

fn shown_at(lab: &mut Lab, frame: u32) -> u32 {
    lab.frame_with(&at(frame), &[]);
    let shown = shown(lab);
    assert!(shown.iter().all(|word| *word == shown[0]), "{shown:?}");
    shown[0]
}

#[test]
fn a_source_that_passes_may_write_has_its_hazards_in_the_plan() {
    let (mut lab, source) = counting("source = \"test.words\"", Access::ReadWrite);
    // Of two rounds a frame the picture shows the first.
    assert_eq!([0, 1, 2, 3, 4].map(|frame| shown_at(&mut lab, frame)), [11, 12, 13, 14, 15]);
    assert_eq!(lab.frame_with(&at(5), &[]).dispatched, 1);
    assert_eq!(lab.frame_with(&at(7), &[]).dispatched, 0);
    // The runtime's words lie over the passes' own, and the rest of these stays.
    source.write(0, bytemuck::cast_slice(&[100_u32; 32])).unwrap();
    assert_eq!(shown_at(&mut lab, 9), 100);
    // A swap keeps it.
    let plan = lab.executor.plan().expect("it runs").clone();
    let prepared = lab.prepare(&plan).expect("it suits the device");
    lab.executor.swap(prepared);
    assert_eq!([10, 11].map(|frame| shown_at(&mut lab, frame)), [101, 102]);
    assert!(plan.steps.iter().filter(|step| matches!(step, raxel_graph::plan::Step::Barrier(_))).count() >= 2);
}

#[test]
fn a_copy_is_filled_when_its_source_changes_and_on_reset() {
    let (mut lab, source) = counting("copy = \"test.words\"", Access::Read);
    assert_eq!([0, 1, 2].map(|frame| shown_at(&mut lab, frame)), [11, 12, 13]);
    // The source changes in part: the copy is filled whole, and what passes did is gone.
    source.write(0, bytemuck::cast_slice(&[50_u32; 32])).unwrap();
    assert_eq!([3, 4, 5].map(|frame| shown_at(&mut lab, frame)), [50, 51, 52]);
    assert_eq!(lab.frame_with(&at(7), &[]).dispatched, 0);
    lab.executor.reset_history();
    // After a reset passes with `every` run at once.
    assert_eq!([9, 11].map(|frame| shown_at(&mut lab, frame)), [51, 52]);
    // A swap keeps what passes did.
    let plan = lab.executor.plan().expect("it runs").clone();
    let prepared = lab.prepare(&plan).expect("it suits the device");
    assert!(lab.executor.swap(prepared).kept.contains(&"words".to_owned()));
    assert_eq!([13, 14].map(|frame| shown_at(&mut lab, frame)), [52, 53]);
    // Another source in its place.
    lab.supply("words", bytemuck::cast_slice(&[7_u32; 32]));
    let prepared = lab.prepare(&plan).expect("it suits the device");
    lab.executor.swap(prepared);
    assert_eq!(shown_at(&mut lab, 15), 7);
}

/// In even frames, the copy is shown before a pass writes all of it over.
const WRITTEN_OVER: &str = include_str!("../fixtures/sources/written_over.toml");

const SET: &str = "#version 460
layout(local_size_x = 8) in;
writeonly buffer Words { uint words[]; } words;
void main() { words.words[gl_GlobalInvocationID.x] = 5u; }";

#[test]
fn a_copy_that_is_written_over_in_the_frame_that_fills_it_is_not_filled_again() {
    let mut lab = Lab::new();
    let source = lab.supply("words", bytemuck::cast_slice(&[10_u32; 32]));
    let files = [("graphs/test.toml", WRITTEN_OVER), ("shaders/set.comp", SET), ("shaders/show.comp", SHOW_WORDS)];
    lab.load(&files, &Planned::default());
    assert_eq!([0, 1, 2].map(|frame| shown_at(&mut lab, frame)), [10, 10, 5]);
    source.write(0, bytemuck::cast_slice(&[50_u32; 32])).unwrap();
    assert_eq!([3, 4, 5, 6].map(|frame| shown_at(&mut lab, frame)), [5; 4]);
}
