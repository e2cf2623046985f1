//! The counts of a run as CSV and JSON.

use std::path::Path;

use raxel_layouts::Layout;
use raxel_measure::stress::{Invariants, Plan, Report, RowReport};
use raxel_oracle::metrics::Errors;
use raxel_output::{Folders, Pending, Table, shown};
use raxel_terminal::console::{Console, Format};
use raxel_terminal::failure::{Failure, Result};
use serde_json::{Value, json};

use super::About;

/// The files that are asked for; whether they can be written is found out before anything is traced.
#[derive(Default)]
pub(super) struct Outputs {
    csv: Option<(Pending, String)>,
    json: Option<(Pending, String)>,
    _folder: Option<Folders>,
}

impl Outputs {
    pub(crate) fn prepare(path: &Path) -> Result<Self> {
        let file = |path: &Path| Ok::<_, Failure>(Some((Pending::new(path)?, shown(path))));
        let named_folder = path.is_dir() || path.as_os_str().to_string_lossy().ends_with(['/', '\\']);
        match path.extension().map(|extension| extension.to_string_lossy().into_owned()).as_deref() {
            Some("csv") if !named_folder => Ok(Self { csv: file(path)?, ..Self::default() }),
            Some("json") if !named_folder => Ok(Self { json: file(path)?, ..Self::default() }),
            Some(_) if !named_folder => Err(Failure::usage(format!("`{}` does not say what to write", path.display()))
                .help("FILE.csv, FILE.json, or a folder for both: a name without ending, or with a / behind it")),
            _ => {
                let folder = Folders::make(path)?;
                Ok(Self {
                    csv: file(&path.join("stress.csv"))?,
                    json: file(&path.join("stress.json"))?,
                    _folder: Some(folder),
                })
            }
        }
    }

    pub(crate) fn write(
        &mut self,
        plan: &Plan,
        report: &Report,
        symmetry: &[(Layout, Invariants)],
        about: &About,
        console: &Console,
    ) -> Result {
        let mut written = Vec::new();
        if let Some((pending, name)) = self.csv.take() {
            pending.finish(&csv(plan, report)?)?;
            written.push(name);
        }
        if let Some((pending, name)) = self.json.take() {
            pending.finish(format!("{:#}\n", json_of(plan, report, symmetry, about)).as_bytes())?;
            written.push(name);
        }
        if !written.is_empty() && console.format() != Format::Json {
            console.message(&format!("wrote {}", written.join(", ")));
        }
        Ok(())
    }
}

/// Counts with their names, in the order of the columns.
fn numbers(errors: &Errors) -> Vec<(&'static str, f64)> {
    let counts = [
        ("rays", errors.rays),
        ("hits", errors.hits),
        ("ties", errors.ties),
        ("wrong", errors.wrong()),
        ("missed", errors.missed),
        ("false", errors.invented),
        ("early", errors.early),
        ("late", errors.late),
        ("hangs", errors.hangs),
        ("not_finite", errors.not_finite),
        ("unwritten", errors.unwritten),
        ("face", errors.face),
        ("material", errors.material),
        ("beyond_t_max", errors.beyond),
        ("wrong_t", errors.time),
        ("wrong_uv", errors.place),
        ("wrong_steps", errors.steps),
        ("wrong_without_tie", errors.wrong_without_tie),
        ("wrong_but_tied", errors.tied),
    ];
    let measures = [
        ("wrong_ppm", errors.ppm()),
        ("missed_chord_voxels", errors.missed_chord),
        ("false_gap_voxels", errors.false_gap),
        ("t_error_voxels", errors.t_voxels),
        ("t_error_ulp", errors.t_ulp),
    ];
    counts.into_iter().map(|(name, count)| (name, count as f64)).chain(measures).collect()
}

fn csv(plan: &Plan, report: &Report) -> Result<Vec<u8>> {
    let names: Vec<&str> = numbers(&Errors::default()).into_iter().map(|(name, _)| name).collect();
    let mut table = Table::new(["row", "site", "set"].iter().chain(&names))?;
    for row in &report.rows {
        for (site, sets) in plan.sites.iter().zip(&row.errors) {
            for (set, errors) in plan.sets.iter().zip(sets).filter(|(_, errors)| errors.rays > 0) {
                let place = [row.row.to_string(), site.name.clone(), set.name.to_owned()];
                table.row(place.into_iter().chain(numbers(errors).iter().map(|(_, number)| number.to_string())))?;
            }
        }
    }
    Ok(table.finish()?)
}

#[expect(clippy::cast_possible_truncation, reason = "every whole number below 9·10¹⁵ fits")]
fn errors_json(errors: &Errors) -> Value {
    // Counts stay whole; one that is larger than a float can count to stays a float.
    let number =
        |number: f64| if number.fract() == 0.0 && number.abs() < 9e15 { json!(number as i64) } else { json!(number) };
    numbers(errors)
        .into_iter()
        .map(|(name, value)| (name.to_owned(), number(value)))
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// One row over all sites: its totals and the counts of each set.
pub(super) fn row_json(plan: &Plan, row: &RowReport) -> Value {
    let sets: serde_json::Map<_, _> =
        plan.sets.iter().enumerate().map(|(i, set)| (set.name.to_owned(), errors_json(&row.set(i)))).collect();
    let refused = row.refused.iter().map(|refused| {
        let site = &plan.sites[refused.site].name;
        json!({ "site": site, "why": refused.why, "out_of_memory": refused.out_of_memory })
    });
    let refused: Vec<_> = refused.collect();
    json!({
        "reason": "stressed",
        "row": row.row.to_string(),
        "exact": row.row.exact(),
        "total": errors_json(&row.total()),
        "mrays_per_s": row.mrays(),
        "differs_from_device": row.differs.map(|d| json!({ "hits": d.hits, "bits": d.bits, "steps": d.steps })),
        "unusable": row.unusable,
        "refused": refused,
        "sets": sets,
    })
}

/// The subject and the result of a run.
pub(super) fn summary(plan: &Plan, report: &Report, symmetry: &[(Layout, Invariants)], about: &About) -> Value {
    let symmetry: serde_json::Map<_, _> =
        symmetry.iter().map(|(layout, found)| (layout.name().to_owned(), json!(found))).collect();
    json!({
        "reason": "stress",
        "device": about.device,
        "driver": about.driver,
        "raxel": env!("CARGO_PKG_VERSION"),
        "command": about.command,
        "seed": plan.seed,
        "rays": report.rows.iter().map(|row| row.total().rays).sum::<u64>(),
        "rays_each": plan.rays_each(),
        "answered": report.answered,
        "answer_seconds": report.answer_seconds,
        "seconds": report.seconds,
        "symmetry": symmetry,
    })
}

fn json_of(plan: &Plan, report: &Report, symmetry: &[(Layout, Invariants)], about: &About) -> Value {
    let mut all = summary(plan, report, symmetry, about);
    all["rows"] = report
        .rows
        .iter()
        .map(|row| {
            let mut value = row_json(plan, row);
            value["sites"] = plan
                .sites
                .iter()
                .enumerate()
                .map(|(i, site)| (site.name.clone(), errors_json(&row.site(i))))
                .collect::<serde_json::Map<_, _>>()
                .into();
            value
        })
        .collect();
    all
}
