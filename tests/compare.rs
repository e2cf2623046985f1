//! `raxel compare`: figures, thresholds, exit codes, heat maps, folders.

mod common;

use common::{Project, RunRaxel, raxel};
use image::{Rgb, RgbImage};

/// A picture with a grey square, whose grey is given.
fn picture(grey: u8) -> RgbImage {
    RgbImage::from_fn(64, 48, |x, y| if x > 20 && y > 20 { Rgb([grey; 3]) } else { Rgb([200, 90, 30]) })
}

#[test]
fn figures_and_thresholds_make_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let save = |name: &str, grey: u8| picture(grey).save(inside(name)).unwrap();
    save("a.png", 100);
    save("same.png", 100);
    save("b.png", 110);
    RgbImage::new(8, 8).save(inside("small.png")).unwrap();
    std::fs::write(inside("c.png"), "no picture").unwrap();
    raxel(&["compare", &inside("a.png"), &inside("same.png")]).exits(0);
    let run = raxel(&["compare", &inside("a.png"), &inside("b.png"), "--format", "json"]).exits(1);
    let found = &run.json()[0];
    // 43 × 27 of 64 × 48 pixels differ by 10 of 255.
    assert_eq!(found["differing"], serde_json::json!(43 * 27));
    assert!((found["max"].as_f64().unwrap() - 10.0 / 255.0).abs() < 1e-6, "{found}");
    let rmse = (10.0 / 255.0) * (f64::from(43 * 27) / f64::from(64 * 48)).sqrt();
    assert!((found["rmse"].as_f64().unwrap() - rmse).abs() < 1e-6, "{found}");
    let flip = found["flip"].as_f64().unwrap();
    assert!(flip > 0.0 && flip < 0.1, "{found}");
    for (threshold, code) in [(flip * 1.01, 0), (flip * 0.99, 1)] {
        raxel(&["compare", &inside("a.png"), &inside("b.png"), "--flip", &threshold.to_string()]).exits(code);
    }
    raxel(&["compare", &inside("a.png"), &inside("b.png"), "--flip", "1", "--max", "0.001"]).exits(1);
    let run = raxel(&["compare", &inside("a.png"), &inside("small.png")]).exits(1);
    assert!(run.stdout.contains("one is 64×48 pixels, the other 8×8"), "{}", run.stdout);
    for wrong in ["c.png", "none.png"] {
        let run = raxel(&["compare", &inside("a.png"), &inside(wrong)]).exits(2);
        assert!(run.stderr.contains(wrong), "{}", run.stderr);
    }
    raxel(&["compare", &inside("a.png"), &inside("b.png"), "--heat", &inside("heat.png")]).exits(1);
    let heat = image::open(inside("heat.png")).unwrap().into_rgb8();
    let light = |x, y| heat.get_pixel(x, y).0.iter().map(|v| u32::from(*v)).sum::<u32>();
    assert!(light(40, 40) > light(2, 2), "what differs is lighter");
}

#[test]
fn folders_and_layers_are_compared_by_name() {
    let project = Project::empty();
    for (folder, names) in [("one", &["0.png", "1.png"][..]), ("two", &["0.png", "1.png", "2.png"])] {
        std::fs::create_dir(project.path(folder)).unwrap();
        names.iter().for_each(|name| picture(50).save(project.path(folder).join(name)).unwrap());
    }
    let run = project.raxel(&["compare", "one", "two"]).exits(1);
    assert!(run.stdout.contains("2.png: is in `two` and not in `one`"), "{}", run.stdout);
    assert!(run.stderr.contains("1 of 3 pictures differ"), "{}", run.stderr);
    std::fs::remove_file(project.path("two/2.png")).unwrap();
    project.raxel(&["compare", "one", "two"]).exits(0);
    project.raxel(&["compare", "one", "two/0.png"]).exits(2);

    let scene = ["render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "96x54"];
    for (name, depth) in [("a.exr", "500"), ("b.exr", "700")] {
        let path = project.path(name);
        let sky = format!("sky_depth={depth}");
        raxel(&[&scene[..], &["--set", &sky, "--layers", "normal,depth", "-o", path.to_str().unwrap()]].concat())
            .exits(0);
    }
    project.raxel(&["compare", "a.exr", "b.exr", "--layer", "normal"]).exits(0);
    let run = project.raxel(&["compare", "a.exr", "b.exr", "--layer", "depth", "--format", "json"]).exits(1);
    assert_eq!(run.json()[0]["max"], serde_json::json!(200.0));
    let run = project.raxel(&["compare", "a.exr", "b.exr", "--layer", "dpeth"]).exits(2);
    assert!(run.stderr.contains("it has `normal`, `depth`"), "{}", run.stderr);
}
