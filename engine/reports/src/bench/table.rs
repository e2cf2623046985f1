//! The table of one view on stdout.

use std::fmt::Write;

use raxel_measure::bench::{Measured, Refusal, Row};
use raxel_oracle::metrics::Errors;
use raxel_terminal::console::{self, Console, Format};

use super::files;
use super::labels::{stem, three, view, wrong_ppm};
use super::matrix::same_view;

const HEAD: [&str; 10] =
    ["graph", "layout", "ms", "p95", "Mrays/s", "wrong ppm", "steps", "B/voxel", "all", "Mvoxels/s"];

/// Prints the rows of one view: the fastest first, those that could not run last.
pub(super) fn print(rows: &[Row], console: &Console) {
    let Some(first) = rows.first() else { return };
    match console.format() {
        Format::Json => rows.iter().for_each(|row| console::json(&files::row_json(row))),
        Format::Short => console::data(&short(rows)),
        Format::Human => console::data(&format!("{}\n{}\n", view(&first.case), human(rows))),
    }
}

/// Fastest first, refused last.
fn sorted(rows: &[Row]) -> Vec<&Row> {
    let time = |row: &Row| row.outcome.as_ref().map_or(f64::INFINITY, Measured::nanoseconds_a_ray);
    let mut all: Vec<&Row> = rows.iter().collect();
    all.sort_by(|a, b| time(a).total_cmp(&time(b)));
    all
}

/// A tracer over all views that it could be measured in.
pub(super) struct Mean<'r> {
    pub graph: &'r str,
    pub layout: Option<&'static str>,
    /// How many views.
    pub views: usize,
    /// Geometric mean of millions of rays a second.
    pub mrays: f64,
    /// Wrong rays in a million over all views; `None` when one was not judged.
    pub wrong_ppm: Option<f64>,
}

/// Means over the views, for tracers that were measured in all of them; the fastest first. None when there is only one view.
pub(super) fn means(rows: &[Row]) -> Vec<Mean<'_>> {
    let views = rows.chunk_by(same_view).count();
    let mut tracers: Vec<Vec<&Row>> = Vec::new();
    for row in rows.iter().filter(|row| row.outcome.is_ok() && views > 1) {
        let same = |other: &Row| (&other.case.graph, other.case.layout) == (&row.case.graph, row.case.layout);
        match tracers.iter_mut().find(|rows| same(rows[0])) {
            Some(rows) => rows.push(row),
            None => tracers.push(vec![row]),
        }
    }
    let mean = |rows: Vec<&'_ Row>| {
        let measured: Vec<&Measured> = rows.iter().filter_map(|row| row.outcome.as_ref().ok()).collect();
        let logarithms = measured.iter().map(|measured| measured.mrays().ln()).sum::<f64>();
        let errors: Option<Vec<&Errors>> = measured.iter().map(|measured| measured.judgement.as_ref().ok()).collect();
        let errors = errors.map(|all| all.into_iter().fold(Errors::default(), |sum, errors| sum.and(*errors)));
        (logarithms / measured.len() as f64, errors.map(|errors| errors.ppm()))
    };
    let mut all: Vec<Mean<'_>> = tracers
        .into_iter()
        .filter(|rows| rows.len() == views)
        .map(|rows| {
            let case = &rows[0].case;
            let (logarithm, wrong_ppm) = mean(rows);
            Mean { graph: &case.graph, layout: case.layout, views, mrays: logarithm.exp(), wrong_ppm }
        })
        .collect();
    all.sort_by(|a, b| b.mrays.total_cmp(&a.mrays));
    all
}

/// Prints the means over all views.
pub(super) fn print_means(rows: &[Row], console: &Console) {
    let means = means(rows);
    let Some(first) = means.first() else { return };
    let mut text = format!("means over {} views: geometric of the rates, arithmetic of the wrong rays\n", first.views);
    let width = means.iter().map(|mean| stem(mean.graph).len()).max().unwrap_or(0);
    for mean in &means {
        let (graph, layout) = (stem(mean.graph), mean.layout.unwrap_or("-"));
        let wrong = mean.wrong_ppm.map_or_else(|| "-".to_owned(), three);
        let _ = match console.format() {
            Format::Short => writeln!(text, "{graph}\t{layout}\t{}\t{wrong}", three(mean.mrays)),
            _ => writeln!(
                text,
                "  {graph:<width$}  {layout:<11}  {:>9} Mrays/s  {wrong:>9} ppm wrong",
                three(mean.mrays)
            ),
        };
    }
    match console.format() {
        Format::Json => means.iter().for_each(|mean| console::json(&files::mean_json(mean))),
        Format::Short => console::data(text.split_once('\n').map_or("", |(_, rows)| rows)),
        Format::Human => console::data(&text),
    }
}

fn cells(row: &Row, measured: &Measured) -> [String; 10] {
    let or_dash = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), three);
    let bytes = measured.bytes_a_voxel();
    [
        stem(&row.case.graph).to_owned(),
        row.case.layout.unwrap_or("-").to_owned(),
        three(measured.time.median),
        three(measured.time.p95),
        three(measured.mrays()),
        or_dash(wrong_ppm(row)),
        or_dash(measured.steps),
        or_dash(bytes.map(|bytes| bytes.geometry)),
        or_dash(bytes.map(|bytes| bytes.all)),
        or_dash(measured.encoded_mvoxels()),
    ]
}

/// Columns under a head, and why rows are missing.
fn human(rows: &[Row]) -> String {
    let sorted = sorted(rows);
    let mut lines = vec![HEAD.map(str::to_owned)];
    lines.extend(sorted.iter().filter_map(|row| Some(cells(row, row.outcome.as_ref().ok()?))));
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for line in &lines {
        let columns = line.iter().enumerate().map(|(i, cell)| {
            let width = width(i);
            if i < 2 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
        });
        let _ = writeln!(text, "  {}", columns.collect::<Vec<_>>().join("  ").trim_end());
    }
    // Of one graph many layouts often say the same, and of one layout many graphs.
    let mut reasons: Vec<(&str, Vec<(&str, &str)>)> = Vec::new();
    for row in sorted {
        let pair = (stem(&row.case.graph), row.case.layout.unwrap_or("its world"));
        let reason = match &row.outcome {
            Err(Refusal { reason, .. }) | Ok(Measured { judgement: Err(reason), .. }) => reason.as_str(),
            Ok(_) => continue,
        };
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, pairs)) => pairs.push(pair),
            None => reasons.push((reason, vec![pair])),
        }
    }
    for (reason, pairs) in reasons {
        let (graphs, layouts) = (distinct(pairs.iter().map(|pair| pair.0)), distinct(pairs.iter().map(|pair| pair.1)));
        let whom = if graphs.len() * layouts.len() == pairs.len() {
            format!("{} over {}", graphs.join(", "), layouts.join(", "))
        } else {
            pairs.iter().map(|(graph, layout)| format!("{graph} over {layout}")).collect::<Vec<_>>().join(", ")
        };
        let _ = writeln!(text, "  {whom}: {reason}");
    }
    text
}

/// Each once, in the order of the first.
fn distinct<'t>(names: impl Iterator<Item = &'t str>) -> Vec<&'t str> {
    let mut all = Vec::new();
    for name in names {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}

/// A line a row, separated by tabs.
fn short(rows: &[Row]) -> String {
    let mut text = String::new();
    for row in sorted(rows) {
        let [width, height] = row.case.size;
        let place = format!("{}\t{}\t{width}x{height}", stem(&row.case.world), row.case.camera);
        let _ = match &row.outcome {
            Ok(measured) => writeln!(text, "{place}\t{}", cells(row, measured).join("\t")),
            Err(Refusal { reason, .. }) => {
                let layout = row.case.layout.unwrap_or("-");
                writeln!(text, "{place}\t{}\t{layout}\t{reason}", stem(&row.case.graph))
            }
        };
    }
    text
}
