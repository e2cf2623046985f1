//! Each kind of output holds the texels.

use std::path::Path;

use crate::common::{command, output};
use crate::{MENGER, common, decoded, menger};

#[test]
fn an_exr_holds_the_texels_of_the_target() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.exr");
    menger(&["--target", "depth", "--set", "sky_depth=99999", "-o", path.to_str().unwrap()]).exits(0);
    let image = exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
    let size = image.layer_data.size;
    assert_eq!((size.0, size.1), (96, 54));
    let channels = &image.layer_data.channel_data.list;
    assert_eq!(channels.len(), 1, "depth has one channel");
    let depth: Vec<f32> = channels[0].sample_data.values_as_f32().collect();
    assert!(depth.contains(&99999.0), "the sky has the value that was set");
    assert!(depth.iter().any(|&d| d < 1000.0), "the sponge is some voxels away");
    assert!(depth.iter().all(|&d| d > 0.0));
}

#[test]
fn several_targets_are_the_layers_of_one_exr() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.exr");
    let twice = menger(&["--layers", "depth,normal,depth", "-o", path.to_str().unwrap()]).exits(2).stderr;
    assert!(twice.contains("`--layers` names `depth` twice") && !path.exists(), "{twice}");
    menger(&["--layers", "depth,normal", "-o", path.to_str().unwrap()]).exits(0);
    let image = exr::prelude::read_all_flat_layers_from_file(&path).unwrap();
    let layers: Vec<_> = image
        .layer_data
        .iter()
        .map(|layer| (layer.attributes.layer_name.as_ref().unwrap().to_string(), layer.channel_data.list.len()))
        .collect();
    assert_eq!(layers[0], ("depth".to_owned(), 1));
    assert_eq!(layers[1].0, "normal");
    let run = menger(&["--layers", "depth,nromal", "-o", path.to_str().unwrap()]).exits(2);
    assert!(run.stderr.contains("did you mean `normal`?"), "{}", run.stderr);
    menger(&["--layers", "depth", "-o", "a.png"]).exits(2);
}

#[test]
fn frames_go_through_a_pipe() {
    let arguments = [&MENGER[..], &["--frames", "3", "--as", "raw", "-o", "-"]].concat();
    let piped = output(&mut command(common::repository(), &arguments));
    assert!(piped.status.success(), "{}", String::from_utf8_lossy(&piped.stderr));
    assert_eq!(piped.stdout.len(), 3 * 96 * 54 * 4);
    let picture = output(&mut command(common::repository(), &[&MENGER[..], &["-o", "-"]].concat())).stdout;
    let picture = image::load_from_memory_with_format(&picture, image::ImageFormat::Png).unwrap().into_rgba8();
    assert!(picture.as_raw()[..] == piped.stdout[..96 * 54 * 4], "the same pixels in either form");
    menger(&["-o", "-", "--time"]).exits(2);
}

#[test]
fn jpg_and_hdr_are_what_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    menger(&["-o", &inside("a.jpg"), "--quality", "95"]).exits(0);
    menger(&["-o", &inside("a.png"), "--compression", "high"]).exits(0);
    let (lossy, exact) = (decoded(Path::new(&inside("a.jpg"))), decoded(Path::new(&inside("a.png"))));
    let apart: u64 = lossy.iter().zip(exact.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    assert!(apart > 0 && apart < 4 * exact.len() as u64, "{apart}");
    menger(&["--target", "depth", "-o", &inside("d.hdr")]).exits(0);
    let depth = image::open(inside("d.hdr")).unwrap().into_rgb32f();
    assert!(depth.iter().any(|&d| d > 1.0 && d < 1000.0), "the sponge is some voxels away");
}

#[test]
fn what_was_rendered_is_told_as_json() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let told = menger(&["-o", path.to_str().unwrap(), "--format", "json", "--time", "--validate"]).exits(0).json();
    assert_eq!(told[0]["reason"], "rendered");
    assert_eq!(told[0]["size"], serde_json::json!([96, 54]));
    assert_eq!(told[0]["passes"][0]["pass"], "inspect");
    assert!(told[0]["passes"][0]["milliseconds"].as_f64().unwrap() > 0.0);

    // For a picture the frame before it is enough, for times all are run; and the picture is the same.
    let eighth = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        let frames = ["-o", path.to_str().unwrap(), "--format", "json", "--frames", "8"];
        let told = menger(&[&frames[..], more].concat()).exits(0).json();
        (told[0]["run"].clone(), std::fs::read(path).unwrap())
    };
    let (alone, timed) = (eighth("alone.png", &[]), eighth("timed.png", &["--time"]));
    assert_eq!((alone.0, timed.0), (serde_json::json!([6, 8]), serde_json::json!([0, 8])));
    assert!(alone.1 == timed.1);
}
