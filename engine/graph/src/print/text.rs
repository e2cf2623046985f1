//! A plan as text: the frame step by step, the uses of each resource, the memory, and the culled passes.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::words;
use crate::ir::checked::ResourceId;
use crate::ir::plan::{Barrier, Lifetime, PassPlan, Plan, ResourceDesc, ResourcePlan, Step};

/// The plan for people.
pub fn text(plan: &Plan) -> String {
    let mut out = String::new();
    head(plan, &mut out);
    steps(plan, &mut out);
    updates(plan, &mut out);
    uses(plan, &mut out);
    memory(plan, &mut out);
    culled(plan, &mut out);
    clocks(plan, &mut out);
    warnings(plan, &mut out);
    out
}

fn warnings(plan: &Plan, out: &mut String) {
    let of = |planned: &ResourcePlan| plan.graph.resource(planned.resource);
    let mut title = "\nwarnings, while a word that is counted is not 0\n";
    for resource in plan.resources.iter().map(of) {
        for warning in &resource.warnings {
            let at = if warning.offset == 0 { String::new() } else { format!(" + {}", warning.offset) };
            let _ = writeln!(out, "{title}  {}{at}: {}", resource.name, warning.says);
            title = "";
        }
    }
}

fn clocks(plan: &Plan, out: &mut String) {
    if plan.graph.clocks.is_empty() {
        return;
    }
    let _ = writeln!(out, "\nclocks");
    for (clock, planned) in plan.graph.clocks.iter().zip(&plan.clocks) {
        let of_clock =
            if planned.first == planned.end { "no steps".to_owned() } else { span(planned.first, planned.end - 1) };
        let _ = writeln!(out, "  {}: {of_clock}", words::clock(clock));
    }
}

fn head(plan: &Plan, out: &mut String) {
    let graph = &plan.graph;
    let [w, h] = plan.output;
    // The number of passes as the author counts them. It leaves out passes that raxel adds, and counts each pass once for all its cases
    // and ticks.
    let all = graph.pass_names().count();
    let live = plan.passes.iter().map(|planned| graph.pass(planned.pass)).filter(|pass| !pass.made);
    let live = live.map(|pass| pass.name.as_str()).collect::<BTreeSet<_>>().len();
    let _ = writeln!(out, "{} at {w}×{h}, shows {}", graph.name, words::present(graph, plan.present));
    if !graph.about.is_empty() {
        let _ = writeln!(out, "{}", graph.about);
    }
    let _ = writeln!(
        out,
        "{live} of {}, {} in {}",
        words::counted(all, "pass", "passes"),
        words::counted(words::barriers(plan), "barrier", "barriers"),
        words::counted(plan.steps.len(), "step", "steps"),
    );
}

fn steps(plan: &Plan, out: &mut String) {
    let _ = writeln!(out, "\nframe");
    let graph = &plan.graph;
    for (number, step) in plan.steps.iter().enumerate() {
        match step {
            Step::Barrier(barrier) => self::barrier(plan, number, barrier, out),
            Step::Clear { resource, tick } => {
                let _ =
                    writeln!(out, "{number:>4}  clear {}{}", words::resource_name(plan, *resource), words::tick(*tick));
            }
            Step::Copy { resource } => {
                let source = plan.resources[*resource as usize].copy.as_deref().unwrap_or_default();
                let name = words::resource_name(plan, *resource);
                let _ = writeln!(out, "{number:>4}  copy {source} to {name}, when it has changed");
            }
            Step::Present => {
                let _ = writeln!(out, "{number:>4}  present {}", words::present(graph, plan.present));
            }
            Step::Dispatch { pass } => {
                let PassPlan { pass: id, tick, .. } = plan.passes[*pass as usize];
                let (name, tick) = (&graph.pass(id).name, words::tick(tick));
                let _ = write!(out, "{number:>4}  {name}{tick}  {}", words::work(plan, *pass));
                if let Some(every) = graph.pass(id).every {
                    let _ = write!(out, ", {}", words::every(graph, every));
                }
                if let Some(size) = graph.pass(id).subgroup_size {
                    let _ = write!(out, ", subgroups of {size}");
                }
                if graph.pass(id).made {
                    out.push_str(", made by raxel");
                }
                out.push('\n');
                let (loads, stores) = words::loads_and_stores(graph, id);
                for (verb, names) in [("reads", loads), ("writes", stores)] {
                    if !names.is_empty() {
                        let _ = writeln!(out, "        {verb} {}", names.join(", "));
                    }
                }
            }
        }
    }
}

fn updates(plan: &Plan, out: &mut String) {
    let updates = &plan.updates;
    if !updates.after.dst.stages.is_empty() {
        let _ = writeln!(out, "\nupdates of sources, in front of the frame where there are any");
        let _ = writeln!(out, "  before  {}", words::dependency(&updates.before));
        let _ = writeln!(out, "  after   {}", words::dependency(&updates.after));
    }
}

fn barrier(plan: &Plan, number: usize, barrier: &Barrier, out: &mut String) {
    let mut mark = format!("{number:>4}  ──");
    let mut line = |out: &mut String, text: String| {
        let _ = writeln!(out, "{mark} {text}");
        mark = " ".repeat(8);
    };
    if let Some(memory) = &barrier.memory {
        line(out, words::dependency(memory));
    }
    for activation in &barrier.activate {
        let name = words::resource_name(plan, activation.resource);
        let image = matches!(plan.resources[activation.resource as usize].desc, ResourceDesc::Image(_));
        if image {
            line(out, format!("activate {name}: {}", words::dependency(&activation.dependency)));
        } else {
            line(out, format!("activate {name}"));
        }
    }
    for hazard in &barrier.hazards {
        let _ = writeln!(out, "           {}", words::hazard(plan, number, hazard));
    }
}

/// One row for each resource, one column for each step.
fn uses(plan: &Plan, out: &mut String) {
    let _ = writeln!(out, "\nuses (c clear, r read, w write, x both, p present; │ barrier)");
    let width = name_width(plan);
    let rulers: &[usize] = if plan.steps.len() > 100 { &[100, 10, 1] } else { &[10, 1] };
    for &unit in rulers {
        let digits: String = (0..plan.steps.len())
            .map(|step| if unit > 1 && step % unit != 0 { ' ' } else { digit(step / unit) })
            .collect();
        let _ = writeln!(out, "  {:width$}  {}", "", digits.trim_end());
    }
    for (index, resource) in plan.resources.iter().enumerate() {
        let marks: Vec<char> = plan.steps.iter().map(|step| mark(plan, index, resource.resource, step)).collect();
        let touched = |c: &char| *c != '·' && *c != '│';
        let (first, last) = (marks.iter().position(touched), marks.iter().rposition(touched));
        let persistent = resource.lifetime == Lifetime::Persistent;
        let row: String = marks
            .iter()
            .enumerate()
            .map(|(step, &mark)| {
                let alive = persistent || Some(step) >= first && Some(step) <= last;
                match mark {
                    '·' if alive => '─',
                    '│' if alive => '┼',
                    other => other,
                }
            })
            .collect();
        let _ = writeln!(out, "  {:width$}  {row}", words::name_of(&plan.graph, resource.resource));
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a digit is below 10")]
fn digit(number: usize) -> char {
    char::from(b'0' + (number % 10) as u8)
}

fn mark(plan: &Plan, index: usize, id: ResourceId, step: &Step) -> char {
    match step {
        Step::Barrier(_) => '│',
        Step::Clear { resource, .. } | Step::Copy { resource } if *resource as usize == index => 'c',
        Step::Present if plan.present.resource == id => 'p',
        Step::Dispatch { pass } => {
            let accesses = &plan.graph.pass(plan.passes[*pass as usize].pass).accesses;
            let of = || accesses.iter().filter(|access| access.resource == id);
            match (of().any(|a| a.access.reads()), of().any(|a| a.access.writes())) {
                (true, true) => 'x',
                (true, false) => 'r',
                (false, true) => 'w',
                (false, false) => '·',
            }
        }
        _ => '·',
    }
}

fn name_width(plan: &Plan) -> usize {
    let names = plan.resources.iter().map(|r| words::name_of(&plan.graph, r.resource).chars().count());
    names.max().unwrap_or(0)
}

fn memory(plan: &Plan, out: &mut String) {
    let _ = writeln!(out, "\nmemory");
    let width = name_width(plan);
    let kinds: Vec<String> = plan.resources.iter().map(|resource| words::describe(&resource.desc)).collect();
    let kind_width = kinds.iter().map(|kind| kind.chars().count()).max().unwrap_or(0);
    for (resource, kind) in plan.resources.iter().zip(&kinds) {
        let supplied = matches!(resource.desc, ResourceDesc::Source(_) | ResourceDesc::SourceImage(..));
        let unknown = supplied && resource.memory.size == 0;
        let size = if unknown { "—".to_owned() } else { words::bytes(resource.memory.size) };
        let copies = if resource.copies > 1 { format!("{} × {size}", resource.copies) } else { size };
        let where_ = match (words::block_of(resource), resource.lifetime) {
            (Some((block, offset)), Lifetime::Transient { first, last, .. }) => {
                format!("{}, block {block} + {offset}", span(first, last))
            }
            (None, Lifetime::Transient { first, last, .. }) if resource.varies => span(first, last),
            (None, Lifetime::Transient { first, last, .. }) => {
                format!("{}, apart: made without camera, cursor and time", span(first, last))
            }
            _ if supplied => "supplied".to_owned(),
            _ => "persistent".to_owned(),
        };
        let name = words::name_of(&plan.graph, resource.resource);
        let _ = writeln!(out, "  {name:width$}  {kind:kind_width$}  {copies:>13}  {where_}");
    }
    for (number, block) in plan.blocks.iter().enumerate() {
        let of_block = plan.resources.iter().filter(|r| words::block_of(r).is_some_and(|(b, _)| b as usize == number));
        let (count, apart) =
            of_block.fold((0, 0_u64), |(count, sum), r| (count + 1, sum.saturating_add(r.memory.size)));
        let _ = writeln!(
            out,
            "  block {number}: {} for {count} resources of {}",
            words::bytes(block.size),
            words::bytes(apart)
        );
    }
    let memory = words::memory(plan);
    let _ = write!(out, "  {} in all", words::bytes(memory.allocated));
    if memory.saved > 0 {
        let _ = write!(out, ", {} saved by sharing", words::bytes(memory.saved));
    }
    out.push('\n');
}

fn span(first: u32, last: u32) -> String {
    if first == last { format!("step {first}") } else { format!("steps {first}–{last}") }
}

fn culled(plan: &Plan, out: &mut String) {
    if plan.culled.is_empty() {
        return;
    }
    let _ = writeln!(out, "\nleft out");
    let name = |culled: &crate::ir::plan::Culled| plan.graph.pass(culled.pass).name.clone();
    let width = plan.culled.iter().map(|culled| name(culled).chars().count()).max().unwrap_or(0);
    for culled in &plan.culled {
        let _ = writeln!(out, "  {:width$}  {}", name(culled), words::culled(&plan.graph, culled));
    }
}
