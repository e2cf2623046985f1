//! results.csv, results.json and the charts.

use std::collections::BTreeSet;
use std::path::Path;

use raxel_measure::bench::{Effort, Measured, Row};
use raxel_oracle::metrics::Errors;
use raxel_output::{Pending, Table, shown};
use raxel_terminal::failure::Result;
use serde_json::{Value, json};

use super::about::About;
use super::chart;
use super::labels::stem;
use super::matrix::same_view;
use super::table::{Mean, means};

/// Charts that an earlier run has left in a folder, by the views of its results.json.
pub(super) fn old_charts(folder: &Path) -> BTreeSet<String> {
    let results = std::fs::read(folder.join("results.json")).unwrap_or_default();
    let results: Value = serde_json::from_slice(&results).unwrap_or_default();
    let rows = results["rows"].as_array().filter(|_| results["reason"] == "bench");
    let view = |row: &Value| {
        let case = &row["case"];
        let side = |i: usize| case["size"][i].as_u64()?.try_into().ok();
        Some(chart_name(case["world"].as_str()?, case["camera"].as_str()?, [side(0)?, side(1)?]))
    };
    // A name that leads elsewhere was not made here.
    rows.into_iter().flatten().filter_map(view).filter(|name| !name.contains(['/', '\\'])).collect()
}

fn chart_name(world: &str, camera: &str, [width, height]: [u32; 2]) -> String {
    format!("{}-{camera}-{width}x{height}.svg", stem(world))
}

/// Writes everything into a folder, and removes those of `old` charts that there is no new one of.
pub(super) fn write(
    folder: &Path,
    about: &About,
    effort: &Effort,
    rows: &[Row],
    old: &BTreeSet<String>,
) -> Result<Vec<String>> {
    let mut written = Vec::new();
    let mut charts = BTreeSet::new();
    let mut put = |name: String, bytes: &[u8]| -> Result {
        let path = folder.join(name);
        Pending::new(&path)?.finish(bytes)?;
        written.push(shown(&path));
        Ok(())
    };
    put("results.csv".to_owned(), &csv(rows)?)?;
    let mut all = head_json(about, effort);
    all["rows"] = rows.iter().map(row_json).collect();
    all["means"] = means(rows).iter().map(mean_json).collect();
    put("results.json".to_owned(), format!("{all:#}\n").as_bytes())?;
    for view in rows.chunk_by(same_view) {
        let case = &view[0].case;
        let name = chart_name(&case.world, &case.camera, case.size);
        if let Some(svg) = chart::draw(view, about) {
            charts.insert(name.clone());
            put(name, svg.as_bytes())?;
        }
    }
    for name in old.difference(&charts) {
        // A file that is gone already is no error.
        let _ = std::fs::remove_file(folder.join(name));
    }
    Ok(written)
}

/// Counts of a judgement with their names, in the order of the columns; some need depths.
fn errors(errors: &Errors, depths: bool) -> Vec<(&'static str, Option<f64>)> {
    let counts = [
        ("wrong", errors.wrong()),
        ("missed", errors.missed),
        ("invented", errors.invented),
        ("early", errors.early),
        ("late", errors.late),
        ("face", errors.face),
        ("material", errors.material),
        ("not_finite", errors.not_finite),
        ("ties", errors.ties),
        ("wrong_without_tie", errors.wrong_without_tie),
        ("wrong_but_tied", errors.tied),
    ];
    let mut all: Vec<_> = counts.into_iter().map(|(name, count)| (name, Some(count as f64))).collect();
    all.push(("wrong_ppm", Some(errors.ppm())));
    all.push(("missed_chord_voxels", Some(errors.missed_chord)));
    all.push(("false_gap_voxels", Some(errors.false_gap)));
    all.push(("t_error_voxels", Some(errors.t_voxels).filter(|_| depths)));
    all.push(("t_error_ulp", Some(errors.t_ulp).filter(|_| depths)));
    all.push(("wrong_t", Some(errors.time as f64).filter(|_| depths)));
    all
}

/// The numbers of a row with their names, in the order of the columns; `None` where there is none.
fn numbers(measured: &Measured) -> Vec<(&'static str, Option<f64>)> {
    let cost = measured.cost;
    let bytes = measured.bytes_a_voxel();
    let mut all = vec![
        ("rays", Some(measured.rays as f64)),
        ("frames", Some(f64::from(measured.frames))),
        ("median_ms", Some(measured.time.median)),
        ("p95_ms", Some(measured.time.p95)),
        ("mrays_per_s", Some(measured.mrays())),
        ("ns_per_ray", Some(measured.nanoseconds_a_ray())),
        ("once_ms", Some(measured.once.iter().map(|pass| pass.time.median).sum())),
        ("steps_per_ray", measured.steps),
        ("voxels", Some(measured.voxels as f64)),
        ("geometry_bytes", cost.map(|cost| cost.geometry_bytes as f64)),
        ("attribute_bytes", cost.map(|cost| cost.attribute_bytes as f64)),
        ("geometry_bytes_per_voxel", bytes.map(|bytes| bytes.geometry)),
        ("bytes_per_voxel", bytes.map(|bytes| bytes.all)),
        ("encode_s", cost.map(|cost| cost.encode_seconds)),
        ("encode_mvoxels_per_s", measured.encoded_mvoxels()),
    ];
    match &measured.judgement {
        Ok(judged) => all.extend(errors(judged, measured.depths)),
        Err(_) => all.extend(errors(&Errors::default(), false).into_iter().map(|(name, _)| (name, None))),
    }
    all
}

/// The measurement itself as JSON.
pub(super) fn head_json(about: &About, effort: &Effort) -> Value {
    let mut value = about.json("bench");
    value["effort"] = json!(effort);
    value
}

/// One row as JSON.
#[expect(clippy::cast_possible_truncation, reason = "every whole number below 9·10¹⁵ fits")]
pub(super) fn row_json(row: &Row) -> Value {
    let mut value = json!({ "reason": "measured", "case": row.case });
    match &row.outcome {
        Err(refusal) => value["refused"] = json!(refusal.reason),
        Ok(measured) => {
            for (name, number) in numbers(measured) {
                // Counts stay whole.
                value[name] = match number {
                    Some(number) if number.fract() == 0.0 && number.abs() < 9e15 => json!(number as i64),
                    number => json!(number),
                };
            }
            value["bounced"] = json!(measured.bounced);
            value["claims_exact"] = json!(measured.claims_exact);
            value["passes"] = json!(measured.passes);
            value["once"] = json!(measured.once);
            if let Err(reason) = &measured.judgement {
                value["not_judged"] = json!(reason);
            }
        }
    }
    value
}

/// A mean over views as JSON.
pub(super) fn mean_json(mean: &Mean<'_>) -> Value {
    json!({
        "reason": "mean",
        "graph": mean.graph,
        "layout": mean.layout,
        "views": mean.views,
        "mrays_per_s": mean.mrays,
        "wrong_ppm": mean.wrong_ppm,
    })
}

/// All rows, a line each, under their names.
fn csv(rows: &[Row]) -> Result<Vec<u8>> {
    let names: Vec<&str> = numbers(&EMPTY).into_iter().map(|(name, _)| name).collect();
    let mut table =
        Table::new(["world", "camera", "width", "height", "graph", "layout"].iter().chain(&names).chain(&["reason"]))?;
    for row in rows {
        let case = &row.case;
        let (values, reason) = match &row.outcome {
            Ok(measured) => (numbers(measured), measured.judgement.as_ref().err()),
            Err(refusal) => (names.iter().map(|name| (*name, None)).collect(), Some(&refusal.reason)),
        };
        let [width, height] = case.size.map(|side| side.to_string());
        let place = [&case.world, &case.camera, &width, &height, &case.graph].map(String::as_str);
        let values = values.into_iter().map(|(_, value)| value.map_or_else(String::new, |value| value.to_string()));
        let place = place.into_iter().chain([case.layout.unwrap_or_default()]).map(str::to_owned);
        table.row(place.chain(values).chain([reason.cloned().unwrap_or_default()]))?;
    }
    Ok(table.finish()?)
}

/// For the names of the columns.
const EMPTY: Measured = Measured {
    rays: 0,
    bounced: false,
    frames: 0,
    time: raxel_measure::bench::Spread { median: 0.0, p95: 0.0 },
    passes: Vec::new(),
    once: Vec::new(),
    steps: None,
    cost: None,
    voxels: 0,
    depths: false,
    judgement: Err(String::new()),
    claims_exact: false,
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_field_has_a_name() {
        let head = String::from_utf8(csv(&[]).unwrap()).unwrap();
        assert_eq!(head.trim_end().split(',').count(), numbers(&EMPTY).len() + 7, "{head}");
    }
}
