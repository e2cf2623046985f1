//! The figures of a system over random scenes: its worst and its geometric mean.

use raxel_terminal::console::{self, Console, Format};
use serde_json::{Value, json};

use super::super::labels::three;
use super::Judgement;

/// Over a number of scenes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Figure {
    /// The worst value, and the scene that has it.
    pub worst: (f64, String),
    /// The geometric mean.
    pub mean: f64,
    /// Scenes that count.
    pub scenes: usize,
}

impl Figure {
    /// Of the values of scenes; `None` without any. `larger` values are worse, or smaller ones.
    fn of(values: &[(f64, &str)], larger: bool) -> Option<Self> {
        let sign = if larger { 1.0 } else { -1.0 };
        let worst = values.iter().max_by(|a, b| (sign * a.0).total_cmp(&(sign * b.0)))?;
        let logs: f64 = values.iter().map(|(value, _)| value.ln()).sum();
        Some(Self {
            worst: (worst.0, worst.1.to_owned()),
            mean: (logs / values.len() as f64).exp(),
            scenes: values.len(),
        })
    }

    fn json(&self) -> Value {
        json!({ "worst": self.worst.0, "scene": self.worst.1, "mean": self.mean, "scenes": self.scenes })
    }
}

/// A system over all random scenes.
#[derive(Clone, Debug)]
pub(super) struct Summary {
    pub system: String,
    /// relMSE of the last still picture, and of the moving one.
    pub errors: [Option<Figure>; 2],
    /// E·t, still and moving.
    pub gains: [Option<Figure>; 2],
    /// Random scenes in which it could not be judged.
    pub failed: usize,
}

/// A row for each system. Nothing where there are no random scenes.
pub(super) fn summaries(all: &[Judgement], is_random: impl Fn(&Judgement) -> bool) -> Vec<Summary> {
    let random: Vec<&Judgement> = all.iter().filter(|judgement| is_random(judgement)).collect();
    let Some(first) = random.first() else { return Vec::new() };
    let of = |index: usize, system: &String| {
        let (mut errors, mut gains, mut failed) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()], 0);
        for judgement in &random {
            let Some(row) = judgement.rows.get(index) else { continue };
            let Ok(outcome) = &row.outcome else {
                failed += 1;
                continue;
            };
            let scene = judgement.scene.name.as_str();
            let still = outcome.still.last().map(|last| (last.judged, last.ms, judgement.brute_force()));
            let moving = outcome.pan.as_ref().map(|pan| (pan.judged, pan.frame_ms, judgement.brute_force_moving()));
            for (which, found) in [still, moving].into_iter().enumerate() {
                let Some((judged, ms, brute)) = found else { continue };
                // An estimate below its own standard error is no better than that.
                let error = judged.error.max(judged.error_se);
                if error > 0.0 {
                    errors[which].push((error, scene));
                    gains[which].extend(brute.map(|brute| (brute / (error * ms), scene)));
                }
            }
        }
        Summary {
            system: system.clone(),
            errors: errors.each_ref().map(|values| Figure::of(values, true)),
            gains: gains.each_ref().map(|values| Figure::of(values, false)),
            failed,
        }
    };
    first.rows.iter().enumerate().map(|(index, row)| of(index, &row.system)).collect()
}

/// As JSON.
pub(super) fn summary_json(summary: &Summary) -> Value {
    let of = |figure: &Option<Figure>| figure.as_ref().map(Figure::json);
    json!({
        "reason": "over-random-scenes",
        "system": summary.system,
        "error": of(&summary.errors[0]),
        "error_moving": of(&summary.errors[1]),
        "gain": of(&summary.gains[0]),
        "gain_moving": of(&summary.gains[1]),
        "refused": summary.failed,
    })
}

/// A line for each system.
pub(super) fn print(all: &[Summary], console: &Console) {
    if console.format() == Format::Json {
        return all.iter().for_each(|summary| console::json(&summary_json(summary)));
    }
    let Some(scenes) = all.iter().flat_map(|summary| &summary.errors).flatten().map(|figure| figure.scenes).max()
    else {
        return;
    };
    let mut text = format!("\nover {scenes} random scenes: geometric mean, worst\n{:<18}", "");
    for head in ["relMSE", "E·t", "moving: relMSE", "E·t"] {
        text += &format!(" {head:>38}");
    }
    text += "\n";
    for summary in all {
        text += &format!("{:<18}", summary.system);
        let error = |value: f64| format!("{value:.2e}");
        let gain = |value: f64| format!("{}×", three(value));
        for which in 0..2 {
            text += &format!(" {:>38}", cell(summary.errors[which].as_ref(), error));
            text += &format!(" {:>38}", cell(summary.gains[which].as_ref(), gain));
        }
        if summary.failed > 0 {
            text += &format!("  not judged in {}", summary.failed);
        }
        text += "\n";
    }
    console::data(&text);
}

fn cell(figure: Option<&Figure>, number: impl Fn(f64) -> String) -> String {
    figure.map_or_else(
        || "-".to_owned(),
        |figure| format!("{}, {} {}", number(figure.mean), number(figure.worst.0), figure.worst.1),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_is_the_worst_and_the_geometric_mean() {
        let values = [(4.0, "a"), (1.0, "b"), (16.0, "c")];
        let errors = Figure::of(&values, true).unwrap();
        assert_eq!((errors.worst, errors.scenes), ((16.0, "c".to_owned()), 3));
        assert!((errors.mean - 4.0).abs() < 1e-12);
        assert_eq!(Figure::of(&values, false).unwrap().worst, (1.0, "b".to_owned()));
        assert_eq!(Figure::of(&[], true), None);
    }
}
