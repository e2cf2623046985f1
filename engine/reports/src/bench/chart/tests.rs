//! The contents of the chart, read back from its SVG.

use raxel_measure::bench::{Case, Measured, Refusal, Spread};
use raxel_measure::light::DeviceName;
use raxel_oracle::metrics::Errors;

use super::*;

fn row(graph: &str, layout: &'static str, milliseconds: f64, wrong: u64) -> Row {
    let case = Case {
        graph: format!("graphs/bench/{graph}.toml"),
        layout: Some(layout),
        world: "worlds/a&b.toml".to_owned(),
        camera: "ground".to_owned(),
        size: [1000, 1000],
    };
    let measured = Measured {
        rays: 1_000_000,
        bounced: graph == "bounce",
        frames: 3,
        time: Spread { median: milliseconds, p95: milliseconds },
        passes: Vec::new(),
        once: Vec::new(),
        steps: None,
        cost: None,
        voxels: 1,
        depths: false,
        judgement: Ok(Errors { rays: 1_000_000, late: wrong, ..Errors::default() }),
        claims_exact: false,
    };
    Row { case, outcome: Ok(measured) }
}

fn about() -> About {
    About {
        device: DeviceName { name: "a <device>".to_owned(), driver: "a driver".to_owned() },
        command: "raxel bench".to_owned(),
        date: "2026-11-20".to_owned(),
    }
}

/// Names of the dots that are drawn as on the front.
fn front(svg: &str) -> Vec<&str> {
    let dots = svg.lines().filter(|line| line.starts_with("<circle") && line.contains("<title>"));
    let on_front = dots.filter(|line| line.contains(FRONT));
    on_front.filter_map(|line| line.split_once("<title>")?.1.split(':').next()).collect()
}

#[test]
fn the_front_is_what_nothing_beats_in_both() {
    let rows = [
        row("exact", "tree64", 1.0, 0),
        row("exact", "svo", 2.0, 0),
        row("march", "tree64", 0.2, 9000),
        row("march", "svo", 0.3, 9000),
        row("dda", "svo", 0.5, 20),
        row("dda", "chunks", 5.0, 20),
        row("bounce", "tree64", 0.1, 0),
    ];
    let svg = draw(&rows, &about()).unwrap();
    let mut found = front(&svg);
    found.sort_unstable();
    assert_eq!(found, ["bounce · tree64", "dda · svo", "exact · tree64", "march · tree64"]);
    // A stair of three, and the rest of the page.
    let stair = svg.lines().find(|line| line.contains("fill=\"none\" stroke=\"#c8452f\"")).unwrap();
    assert_eq!((stair.matches('H').count(), stair.matches('V').count()), (2, 2), "{stair}");
    assert!(svg.contains("exact: none of 1\u{202f}000\u{202f}000 rays is wrong") && svg.contains("a &lt;device&gt;"));
    assert!(svg.contains("a&amp;b, ground, 1000 × 1000"));
}

#[test]
fn the_foot_is_two_lines() {
    let words = "word ".repeat(100);
    let lines = foot_lines(&words);
    assert_eq!(lines.len(), 2);
    assert!(lines.iter().all(|line| line.chars().count() <= FOOT) && lines[1].ends_with("word …"), "{lines:?}");
    assert_eq!(foot_lines("raxel bench"), ["raxel bench"]);
}

#[test]
fn names_keep_apart_and_inside() {
    let layouts = ["tree64", "hashed_chunks", "texture3d", "svo"];
    let crowd = |graph, slowest: f64, wrong| {
        let rows = layouts.iter().enumerate();
        rows.map(|(i, layout)| row(graph, layout, slowest - 1e-3 * i as f64, wrong)).collect::<Vec<_>>()
    };
    for wrong in [0, 50] {
        let mut rows = crowd("dda", 3.0, wrong);
        rows.push(row("other", "tree64", 0.1, 9000));
        let svg = draw(&rows, &about()).unwrap();
        let names = svg.lines().filter_map(|line| line.strip_prefix("<text transform=\"translate(")?.split_once(' '));
        let names: Vec<f64> = names
            .filter(|(_, rest)| rest.contains("rotate(45)") || rest.contains("rotate(-45)"))
            .map(|(x, _)| x.parse().unwrap())
            .collect();
        assert_eq!(names.len(), layouts.len(), "{svg}");
        assert!(names.windows(2).all(|pair| pair[1] - pair[0] > 16.0), "{names:?}");
        assert!(names.iter().all(|x| (LEFT..EDGE - 20.0).contains(x)), "{names:?}");
    }
    // Threads on top of each other: those whose dots have no names hang on their fastest, each in a place of its own.
    let rows: Vec<Row> = ["a", "b", "c", "d"].into_iter().flat_map(|graph| crowd(graph, 3.0, 50)).collect();
    let svg = draw(&rows, &about()).unwrap();
    let mut labels: Vec<&str> = svg.lines().filter(|line| line.contains("svo fastest</text>")).collect();
    assert_eq!(labels.len(), 2, "{svg}");
    labels.dedup_by_key(|line| line.split(" font-size").next());
    assert_eq!(labels.len(), 2, "{svg}");
    let fastest = svg.lines().find_map(|line| line.strip_prefix("<polyline points=\"")?.split(',').next()).unwrap();
    let mut leaders = svg.lines().filter(|line| line.contains("stroke-opacity=\"0.6\""));
    assert!(leaders.all(|line| line.starts_with(&format!("<path d=\"M{fastest} "))), "{svg}");
}

#[test]
fn there_is_no_chart_of_nothing() {
    let refused = Row {
        outcome: Err(Refusal { reason: "no".to_owned(), ..Refusal::default() }),
        ..row("exact", "tree64", 1.0, 0)
    };
    assert!(draw(&[refused], &about()).is_none());
    // One dot alone has an axis, too.
    let svg = draw(&[row("exact", "tree64", 1.0, 0)], &about()).unwrap();
    assert!(svg.contains("1 ns") && !svg.contains("NaN"));
}

#[test]
fn times_and_shares_have_units() {
    assert_eq!([0.05, 0.5, 1.0, 200.0, 5000.0].map(duration), ["50 ps", "500 ps", "1 ns", "200 ns", "5 µs"]);
    assert_eq!([0.05, 1.0, 200.0, 1e5].map(rate), ["20 G/s", "1 G/s", "5 M/s", "10 k/s"]);
    assert_eq!([-1, 0, 3, 6].map(parts), ["100 ppb", "1 ppm", "0.1 %", "100 %"]);
}
