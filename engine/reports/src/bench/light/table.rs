//! The printed table: a line for each reference, and a line for each system under the head of its scene.

use raxel_measure::light::Point;
use raxel_measure::light::reference::About;
use raxel_terminal::console::{self, Console, Format};
use serde_json::json;

use super::super::labels::three;
use super::{Judgement, Row, files};

/// A reference, and how good it is.
pub(super) fn print_reference(about: &About, console: &Console) {
    if console.format() == Format::Json {
        let mut value = json!(about);
        value["reason"] = json!("reference");
        return console::json(&value);
    }
    let [width, height] = about.size;
    console::data(&format!(
        "\n{}, {width}×{height}: two halves of {} paths a pixel, each with an error of {:.2e} (forecast {:.2e}), {} ms a path; mean {}, e {:.2e}; {} {}{}\n",
        about.scene,
        about.paths,
        about.noise,
        about.forecast,
        three(about.path_ms),
        three(about.mean),
        about.epsilon,
        &about.hashes[0][..16],
        &about.hashes[1][..16],
        if about.kept { ", made before" } else { "" },
    ));
}

/// The last row of a scene.
pub(super) fn print_last(judgement: &Judgement, console: &Console) {
    let Some(row) = judgement.rows.last() else { return };
    if console.format() == Format::Json {
        return console::json(&files::row_json(judgement, row));
    }
    if judgement.rows.len() == 1 {
        console::data(&format!(
            "{:<18} {:>8} {:>8} {:>9} {:>9} {:>9} {:>19} {:>9} {:>7} {:>7} {:>9} {:>9} {:>7} {:>17} {:>9} {:>12}\n",
            "",
            "ms/frame",
            "MiB",
            "1 frame",
            "1 ms",
            "last",
            "bias²",
            "noise",
            "light",
            "FLIP",
            "p99",
            "flicker",
            "E·t",
            "moving: ms, error",
            "E·t",
            "lamp 5%, 1%"
        ));
    }
    console::data(&line(judgement, row));
}

fn line(judgement: &Judgement, row: &Row) -> String {
    let outcome = match &row.outcome {
        Ok(outcome) => outcome,
        Err(reason) => return format!("{:<18} {reason}\n", row.system),
    };
    let Some((first, last)) = outcome.still.first().zip(outcome.still.last()) else { return String::new() };
    let times = |part: Option<f64>| part.map_or_else(|| "-".to_owned(), |part| format!("{}×", three(part)));
    let gain = judgement.brute_force().map(|brute| brute / (last.judged.error * last.ms));
    let (moving, moving_gain) = match &outcome.pan {
        Some(pan) => (
            format!("{} {:.2e}", three(pan.frame_ms), pan.judged.error),
            judgement.brute_force_moving().map(|brute| brute / (pan.judged.error * pan.frame_ms)),
        ),
        None => ("-".to_owned(), None),
    };
    let lag = outcome.lag.as_ref().map_or_else(
        || "-".to_owned(),
        |lag| {
            let frames = |frames: Option<u32>| frames.map_or_else(|| format!(">{}", lag.frames), |n| n.to_string());
            format!("{}, {}", frames(lag.to_5_percent), frames(lag.to_1_percent))
        },
    );
    let flip = outcome.flip.map_or_else(|| "-".to_owned(), |flip| format!("{flip:.4}"));
    let after = at(&outcome.still, 1.0).map_or_else(|| "-".to_owned(), |error| format!("{error:.2e}"));
    let not_finite = match last.judged.not_finite {
        0 => String::new(),
        count => format!("  {count} texels are not numbers"),
    };
    format!(
        "{:<18} {:>8} {:>8} {:>9.2e} {:>9} {:>9.2e} {:>9.2e} ± {:>7.1e} {:>9.2e} {:>+6.1}% {:>7} {:>9.2e} {:>9.2e} {:>7} {:>17} {:>9} {:>12}{}\n",
        row.system,
        three(outcome.frame_ms),
        three(outcome.bytes as f64 / f64::from(1 << 20)),
        first.judged.error,
        after,
        last.judged.error,
        last.judged.bias2,
        last.judged.bias2_se,
        last.judged.noise,
        100.0 * last.judged.gain,
        flip,
        last.judged.p99,
        outcome.flicker,
        times(gain),
        moving,
        times(moving_gain),
        lag,
        not_finite,
    )
}

/// The error after `ms` milliseconds, between the points on either side as a straight line in logarithms; `None` outside.
pub(super) fn at(points: &[Point], ms: f64) -> Option<f64> {
    let pair = points.windows(2).find(|pair| (pair[0].ms..=pair[1].ms).contains(&ms))?;
    let [(x0, y0), (x1, y1)] = [&pair[0], &pair[1]].map(|point| (point.ms.ln(), point.judged.error.max(1e-12).ln()));
    let part = if x1 > x0 { (ms.ln() - x0) / (x1 - x0) } else { 0.0 };
    Some((y0 + part * (y1 - y0)).exp())
}

#[cfg(test)]
mod tests {
    use raxel_measure::light::Judged;

    use super::*;

    #[test]
    fn errors_between_points_lie_on_straight_lines_in_logarithms() {
        let point = |ms, error| Point { frame: 1, ms, judged: Judged { error, ..Judged::default() } };
        let points = [point(1.0, 0.1), point(4.0, 0.025), point(16.0, 0.025)];
        assert!((at(&points, 2.0).unwrap() - 0.05).abs() < 1e-12);
        assert!((at(&points, 10.0).unwrap() - 0.025).abs() < 1e-12);
        assert_eq!((at(&points, 0.5), at(&points, 17.0)), (None, None));
    }
}
