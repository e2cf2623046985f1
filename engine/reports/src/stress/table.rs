//! The tables on stdout: wrong rays in a million, by row and set; and the kinds of errors.

use std::fmt::Write;

use raxel_diagnostics::names::grouped;
use raxel_layouts::Layout;
use raxel_measure::stress::{Invariants, Plan, Report, RowReport};
use raxel_oracle::metrics::Errors;
use raxel_terminal::console::{self, Console, Format};

use super::{About, files};

/// Columns of text that a table takes at most; wider ones go on below.
const WIDTH: usize = 118;

pub(super) fn print(plan: &Plan, report: &Report, symmetry: &[(Layout, Invariants)], about: &About, console: &Console) {
    match console.format() {
        Format::Json => {
            report.rows.iter().for_each(|row| console::json(&files::row_json(plan, row)));
            console::json(&files::summary(plan, report, symmetry, about));
        }
        Format::Short => console::data(&short(report)),
        Format::Human => console::data(&human(plan, report, symmetry, about)),
    }
}

/// One line a row.
fn short(report: &Report) -> String {
    let line = |row: &RowReport| {
        let total = row.total();
        let mrays = row.mrays().map_or_else(|| "-".to_owned(), three);
        format!(
            "{}: {} rays, {} wrong ({} ppm), {} hangs, {mrays} Mrays/s\n",
            row.row,
            total.rays,
            total.wrong(),
            ppm(&total),
            total.hangs
        )
    };
    report.rows.iter().map(line).collect()
}

fn human(plan: &Plan, report: &Report, symmetry: &[(Layout, Invariants)], about: &About) -> String {
    let mut text = format!(
        "{}, {}\n{} rays of each row, scene and set; seed {}\n\nwrong rays in a million\n",
        about.device,
        about.driver,
        grouped(plan.rays_each()),
        plan.seed
    );
    let mut head: Vec<String> = vec![String::new()];
    head.extend(plan.sets.iter().map(|set| set.name.to_owned()));
    let mut lines = vec![head];
    for row in &report.rows {
        let mut line = vec![row.row.to_string()];
        line.extend((0..plan.sets.len()).map(|set| ppm(&row.set(set))));
        lines.push(line);
    }
    columns(&mut text, &lines);
    text.push_str("\nof all\n");
    let head = [
        "",
        "rays",
        "wrong ppm",
        "miss",
        "false",
        "early",
        "late",
        "hang",
        "NaN",
        "face",
        "material",
        "t max",
        "t",
        "uv",
        "steps",
        "tied",
        "missed chord",
        "false gap",
        "t ulp",
        "Mrays/s",
    ];
    let mut lines = vec![head.map(str::to_owned).to_vec()];
    lines.extend(report.rows.iter().map(totals));
    columns(&mut text, &lines);
    text.push('\n');
    notes(&mut text, plan, report, symmetry);
    text
}

fn totals(row: &RowReport) -> Vec<String> {
    let all = row.total();
    let longest = |length: f64| if length > 0.0 { format!("{length:.1e}") } else { "0".to_owned() };
    vec![
        row.row.to_string(),
        grouped(all.rays),
        ppm(&all),
        grouped(all.missed),
        grouped(all.invented),
        grouped(all.early),
        grouped(all.late),
        grouped(all.hangs + all.unwritten),
        grouped(all.not_finite),
        grouped(all.face),
        grouped(all.material),
        grouped(all.beyond),
        grouped(all.time),
        grouped(all.place),
        grouped(all.steps),
        grouped(all.tied),
        longest(all.missed_chord),
        longest(all.false_gap),
        three(all.t_ulp),
        row.mrays().map_or_else(|| "-".to_owned(), three),
    ]
}

fn notes(text: &mut String, plan: &Plan, report: &Report, symmetry: &[(Layout, Invariants)]) {
    // A plane of voxels has no hole: a ray that misses it has slipped through an edge.
    let planes: Vec<usize> = (0..plan.sites.len())
        .filter(|i| ["diagonal@", "slope@"].iter().any(|plane| plan.sites[*i].name.starts_with(plane)))
        .collect();
    for row in &report.rows {
        let leaks: u64 = planes.iter().map(|&site| row.site(site)).map(|errors| errors.missed + errors.late).sum();
        if leaks > 0 {
            let _ = writeln!(text, "{} slips {} times through planes one voxel thick", row.row, grouped(leaks));
        }
        if let Some(differs) = row.differs {
            let all = grouped(row.total().rays);
            let _ = writeln!(
                text,
                "{}: {} of {all} hits differ from the device's in voxel, face or material; of the others {} in a bit of t or uv, {} in steps",
                row.row,
                grouped(differs.hits),
                grouped(differs.bits),
                grouped(differs.steps)
            );
        }
        if let Some(why) = &row.unusable {
            let _ = writeln!(text, "{}: {why}", row.row);
        }
        for refused in &row.refused {
            let _ = writeln!(text, "{} over {}: {}", row.row, plan.sites[refused.site].name, refused.why);
        }
    }
    for (layout, found) in symmetry {
        let wrong = found.moved_wrong + found.turned_wrong;
        let all = found.moved + found.turned;
        if wrong > 0 {
            let _ = writeln!(
                text,
                "{}: {wrong} of {all} rays are hit differently when moved, turned or mirrored",
                layout.name()
            );
        }
    }
    let rays: u64 = symmetry.iter().map(|(_, found)| found.moved + found.turned).sum();
    if symmetry.iter().all(|(_, found)| found.moved_wrong + found.turned_wrong == 0) && rays > 0 {
        let _ = writeln!(text, "moved, turned and mirrored: {} rays, all hit alike", grouped(rays));
    }
    let traced: u64 = report.rows.iter().map(|row| row.total().rays).sum();
    let judged = report.answered as f64 / report.answer_seconds.max(1e-9) / 1e6;
    let _ = writeln!(
        text,
        "{} rays traced in {:.1} s; {} answered exactly, {} Mrays/s on {} threads",
        grouped(traced),
        report.seconds,
        grouped(report.answered),
        three(judged),
        rayon::current_num_threads()
    );
}

/// Lines of cells as columns, the first to the left and the others to the right, in as many blocks as the width needs.
fn columns(text: &mut String, lines: &[Vec<String>]) {
    let widths: Vec<usize> = (0..lines[0].len())
        .map(|column| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0))
        .collect();
    let mut next = 1;
    while next < widths.len() {
        let mut used = widths[0] + 2;
        let begin = next;
        while next < widths.len() && (next == begin || used + widths[next] + 2 <= WIDTH) {
            used += widths[next] + 2;
            next += 1;
        }
        for line in lines {
            let _ = write!(text, "  {:<width$}", line[0], width = widths[0]);
            for column in begin..next {
                let _ = write!(text, "  {:>width$}", line[column], width = widths[column]);
            }
            text.push('\n');
        }
    }
}

fn ppm(errors: &Errors) -> String {
    if errors.rays == 0 { "-".to_owned() } else { three(errors.ppm()) }
}

/// About three digits.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "casts of floats saturate, and errors are not negative"
)]
fn three(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        v if v >= 100.0 => grouped(v.round() as u64),
        v if v >= 10.0 => format!("{v:.1}"),
        v if v >= 1.0 => format!("{v:.2}"),
        v if v >= 0.001 => format!("{v:.3}"),
        v => format!("{v:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [0.0, 0.0123, 5.678, 34.56, 1234.5, 2.5e-7].map(three),
            ["0", "0.012", "5.68", "34.6", "1,235", "2.5e-7"]
        );
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
    }

    #[test]
    fn wide_tables_go_on_below() {
        let line = |first: &str| [vec![first.to_owned()], vec!["x".repeat(30); 6]].concat();
        let mut text = String::new();
        columns(&mut text, &[line(""), line("row")]);
        assert_eq!(text.lines().count(), 4);
        assert!(text.lines().all(|line| line.len() <= WIDTH + 2), "{text}");
        assert_eq!(text.matches('x').count(), 2 * 6 * 30);
    }
}
