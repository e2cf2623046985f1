//! results.csv, results.json and a chart for each scene.

use std::path::Path;

use raxel_measure::light::error::FORMULA;
use raxel_measure::light::{Bench, Judged};
use raxel_output::{Pending, Table, shown};
use raxel_terminal::failure::Result;
use serde_json::{Value, json};

use super::super::about::About;
use super::summary::{Summary, summary_json};
use super::table::at;
use super::{Judgement, Row, chart};

/// Milliseconds at which errors are compared: up to a frame at 60 Hz and one step beyond.
const TIMES: [f64; 6] = [0.5, 1.0, 4.0, 16.0, 16.6, 20.0];

/// Writes everything into a folder.
pub(super) fn write(folder: &Path, bench: &Bench, all: &[Judgement], summaries: &[Summary]) -> Result<Vec<String>> {
    let about = About::of(bench.device().cloned().unwrap_or_default());
    let effort = bench.effort();
    let mut written = Vec::new();
    let mut put = |name: String, bytes: &[u8]| -> Result {
        let path = folder.join(name);
        Pending::new(&path)?.finish(bytes)?;
        written.push(shown(&path));
        Ok(())
    };
    let mut value = about.json("bench-light");
    value["formula"] = json!(FORMULA);
    value["size"] = json!(effort.size);
    value["frames"] = json!(effort.frames);
    value["pan"] = json!(effort.pan);
    value["references"] = all.iter().map(|judgement| json!(judgement.references.about)).collect();
    value["rows"] =
        all.iter().flat_map(|judgement| judgement.rows.iter().map(|row| row_json(judgement, row))).collect();
    value["over_random_scenes"] = summaries.iter().map(summary_json).collect();
    put("results.json".to_owned(), format!("{value:#}\n").as_bytes())?;
    put("results.csv".to_owned(), &csv(all)?)?;
    for judgement in all {
        if let Some(svg) = chart::draw(judgement, &about) {
            put(format!("light-{}.svg", judgement.scene.name), svg.as_bytes())?;
        }
    }
    Ok(written)
}

/// One row as JSON.
pub(super) fn row_json(judgement: &Judgement, row: &Row) -> Value {
    let mut value = match &row.outcome {
        Ok(outcome) => json!(outcome),
        Err(reason) => json!({ "refused": reason }),
    };
    if let Ok(outcome) = &row.outcome {
        let errors = TIMES.iter().map(|ms| json!({ "ms": ms, "error": at(&outcome.still, *ms) }));
        value["error_at"] = errors.collect();
        let gain = |brute: Option<f64>, product: f64| brute.map(|brute| brute / product);
        value["gain"] =
            json!(outcome.still.last().and_then(|last| gain(judgement.brute_force(), last.judged.error * last.ms)));
        value["gain_moving"] = json!(
            outcome.pan.as_ref().and_then(|pan| gain(judgement.brute_force_moving(), pan.judged.error * pan.frame_ms))
        );
    }
    value["reason"] = json!("judged");
    value["scene"] = json!(judgement.scene.name);
    value["system"] = json!(row.system);
    value
}

/// A line for each picture that was judged.
fn csv(all: &[Judgement]) -> Result<Vec<u8>> {
    let names = [
        "scene",
        "system",
        "camera",
        "frame",
        "ms",
        "relmse",
        "relmse_se",
        "bias2",
        "bias2_se",
        "noise",
        "gain",
        "gain_se",
        "p99",
        "not_finite",
        "epsilon",
        "reason",
    ];
    let mut table = Table::new(names.iter())?;
    for judgement in all {
        for row in &judgement.rows {
            let mut line = |camera: &str, frame: u32, ms: f64, judged: &Judged| {
                let head = [judgement.scene.name.clone(), row.system.clone(), camera.to_owned(), frame.to_string()];
                let numbers = [
                    ms,
                    judged.error,
                    judged.error_se,
                    judged.bias2,
                    judged.bias2_se,
                    judged.noise,
                    judged.gain,
                    judged.gain_se,
                    judged.p99,
                ];
                let numbers = numbers.map(|number| number.to_string());
                table.row(head.into_iter().chain(numbers).chain([
                    judged.not_finite.to_string(),
                    judgement.references.about.epsilon.to_string(),
                    String::new(),
                ]))
            };
            match &row.outcome {
                Ok(outcome) => {
                    for point in &outcome.still {
                        line("still", point.frame, point.ms, &point.judged)?;
                    }
                    if let Some(pan) = &outcome.pan {
                        line("moving", outcome.still.last().map_or(0, |point| point.frame), pan.frame_ms, &pan.judged)?;
                    }
                }
                Err(reason) => {
                    let empty = std::iter::repeat_n(String::new(), names.len() - 3);
                    let head = [judgement.scene.name.clone(), row.system.clone()];
                    table.row(head.into_iter().chain(empty).chain([reason.clone()]))?;
                }
            }
        }
    }
    Ok(table.finish()?)
}
