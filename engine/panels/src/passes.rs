//! The passes in their order, with their times, and what became of them.

use egui::{Grid, RichText, Ui, Vec2};

use crate::action::Action;
use crate::bar::text_of;
use crate::frame::milliseconds;
use crate::hint::Hint as _;
use crate::rows::Rows;
use crate::samples::Samples;
use crate::shape_cache::Content;
use crate::view::{Pass, PassState, Shown, View};

/// Passes as panels show them: by the words of their rows, and where that counts by what is usual among their times.
pub(crate) struct Timed<'v> {
    pub(crate) passes: &'v [Pass<'v>],
    pub(crate) timed: bool,
}

/// A pass, owned.
pub(crate) struct Known {
    words: [String; 4],
    state: PassState,
    output: Option<usize>,
    times: [Option<f32>; 2],
}

impl Timed<'_> {
    fn times(&self, pass: &Pass<'_>) -> [Option<f32>; 2] {
        pass.times.filter(|_| self.timed).map_or([None; 2], |times| [times.median(), times.p95()])
    }
}

impl Content for Timed<'_> {
    type Kept = Vec<Known>;

    fn is(&self, kept: &Vec<Known>) -> bool {
        let same = |(pass, row): (&Pass<'_>, &Known)| {
            words(pass) == row.words.each_ref().map(String::as_str)
                && (pass.state, pass.output, self.times(pass)) == (row.state, row.output, row.times)
        };
        self.passes.len() == kept.len() && self.passes.iter().zip(kept).all(same)
    }

    fn keep(&self) -> Vec<Known> {
        let row = |pass: &Pass<'_>| Known {
            words: words(pass).map(str::to_owned),
            state: pass.state,
            output: pass.output,
            times: self.times(pass),
        };
        self.passes.iter().map(row).collect()
    }
}

fn words<'p>(pass: &Pass<'p>) -> [&'p str; 4] {
    [pass.name, pass.after, pass.groups, pass.place]
}

/// Draws the panel. The pass under the pointer is given, as what it shows.
pub(crate) fn show(
    ui: &mut Ui,
    view: &View<'_>,
    rows: &mut Rows<4>,
    (actions, hovered): (&mut Vec<Action>, &mut Option<Shown>),
) {
    ui.horizontal_wrapped(|ui| {
        let span = view.frame.gpu;
        let (median, p95) = (span.and_then(Samples::median), span.and_then(Samples::p95));
        ui.label(format!("span {} ms, p95 {}", milliseconds(median), milliseconds(p95)))
            .hint(|| "From the start of the first pass to the end of the last, with gaps and overlaps.");
    });
    let longest = view.passes.iter().filter_map(median).fold(0.0_f32, f32::max);
    Grid::new("passes").num_columns(3).striped(true).min_col_width(30.0).show(ui, |ui| {
        ui.weak("pass");
        ui.weak("ms");
        ui.weak("p95");
        ui.end_row();
        for (index, pass) in view.passes.iter().enumerate() {
            let times = is_timed(pass).then(|| [median(pass), pass.times.and_then(Samples::p95)].map(milliseconds));
            // Digits are as wide as each other.
            let digits = times.as_ref().map(|times| times.each_ref().map(|time| time.chars().count()));
            let words = (pass.name, pass.state.word(), digits);
            rows.add(ui, index, words, |ui| row(ui, view, (index, pass), (times, longest), (actions, hovered)));
            ui.end_row();
        }
    });
    if view.passes.is_empty() {
        ui.weak("The graph has no passes.");
    }
}

/// Whether the times of a pass are shown, rather than only why it did not run.
fn is_timed(pass: &Pass<'_>) -> bool {
    pass.state == PassState::Ran || (pass.state.is_planned() && median(pass).is_some())
}

/// Draws a pass with its times in words. Gives the sizes of its cells.
fn row(
    ui: &mut Ui,
    view: &View<'_>,
    (index, pass): (usize, &Pass<'_>),
    (times, longest): (Option<[String; 2]>, f32),
    (actions, hovered): (&mut Vec<Action>, &mut Option<Shown>),
) -> [Vec2; 4] {
    let target = target(view, index);
    let locked = target.as_ref().is_some_and(|target| view.status.locked.is_at(target));
    let name = match pass.state {
        PassState::Ran => RichText::new(pass.name),
        _ => RichText::new(pass.name).weak(),
    };
    let response = ui.selectable_label(locked, name);
    if response.hovered() {
        response.clone().on_hover_ui(|ui| about(ui, view, index));
    }
    if let Some(target) = target {
        if response.hovered() && pass.state.is_planned() {
            *hovered = Some(target.clone());
        }
        if response.clicked() {
            actions.push(if locked { Action::ShowDefault } else { Action::Show(target) });
        }
    }
    let name = response.rect.size();
    let state = |ui: &mut Ui| ui.weak(pass.state.word()).hint(|| pass.state.reason()).rect.size();
    let Some([median_text, p95]) = times else {
        return [name, state(ui), ui.label("").rect.size(), Vec2::ZERO];
    };
    let text = ui.monospace(median_text);
    bar(ui, &text, median(pass).unwrap_or(0.0) / longest.max(1e-9));
    let p95 = ui.monospace(p95);
    let state = if pass.state == PassState::Ran { Vec2::ZERO } else { state(ui) };
    [name, text.rect.size(), p95.rect.size(), state]
}

/// The target of a pass: the part that it writes of the resource that it is best known by.
pub(crate) fn target(view: &View<'_>, index: usize) -> Option<Shown> {
    let pass = &view.passes[index];
    let resource = pass.output.and_then(|index| view.resources.get(index))?;
    // A skipped pass has no place in the frame after which something could be shown.
    let after = pass.state.is_planned().then(|| pass.after.to_owned());
    // A pass of a loop writes another mip in each round.
    let used = resource.uses.get(index).copied().unwrap_or_default();
    Some(Shown::after(resource.name.clone(), after).part(used))
}

/// The tooltip of a pass.
pub(crate) fn about(ui: &mut Ui, view: &View<'_>, index: usize) {
    let pass = &view.passes[index];
    ui.label(RichText::new(pass.name).strong());
    ui.label(pass.state.reason());
    if !pass.groups.is_empty() {
        ui.label(format!("workgroups {}", pass.groups));
    }
    if let Some(output) = pass.output.and_then(|index| view.resources.get(index)) {
        let shown = target(view, index).as_ref().map(text_of).unwrap_or_default();
        ui.label(format!("shows {shown} ({}); a click locks it", output.about));
    }
    ui.weak(pass.place);
}

fn median(pass: &Pass<'_>) -> Option<f32> {
    pass.times.and_then(Samples::median)
}

/// A line under a number, as long as its share of the longest.
fn bar(ui: &Ui, text: &egui::Response, share: f32) {
    let rect = text.rect;
    let line = egui::Rect::from_min_size(
        egui::pos2(rect.left(), rect.bottom() - 1.0),
        egui::vec2(rect.width() * share.clamp(0.0, 1.0), 2.0),
    );
    ui.painter().rect_filled(line, 0.0, egui::Color32::from_rgb(120, 200, 120));
}
