//! A plan as a picture for Graphviz: passes are boxes, images ellipses, buffers cylinders; history is dashed, skipped passes grey. Red
//! boxes are barriers: arrows lead to each from the passes before it, and from it to the passes after it.

use std::fmt::Write as _;

use super::words;
use crate::ir::checked::ResourceKind;
use crate::ir::index::index32;
use crate::ir::plan::Plan;

/// The plan as DOT: `raxel graph FILE --format dot | dot -Tsvg`.
pub fn dot(plan: &Plan) -> String {
    let graph = &plan.graph;
    let mut out = String::new();
    let _ = writeln!(out, "digraph {} {{", quoted(&graph.name));
    out.push_str("  rankdir=LR;\n  node [fontname=\"sans-serif\", fontsize=11];\n  edge [fontname=\"sans-serif\", fontsize=9];\n");
    for resource in &plan.resources {
        let id = resource.resource;
        let shape = match graph.resource(id).kind {
            ResourceKind::Target(_) => "ellipse",
            ResourceKind::Buffer(_) => "cylinder",
        };
        let label = format!("{}\n{}", words::name_of(graph, id), words::describe(&resource.desc));
        let shown = if id == plan.present.resource { ", peripheries=2" } else { "" };
        let _ = writeln!(out, "  r{} [shape={shape}, label={}{shown}];", id.0, quoted(&label));
    }
    for (number, pass) in words::each_pass(plan) {
        let label = format!("{}\n{}", graph.pass(pass.pass).name, words::work(plan, index32(number)));
        let _ = writeln!(
            out,
            "  p{} [shape=box, style=\"rounded,filled\", fillcolor=\"#dde8f5\", label={}];",
            pass.pass.0,
            quoted(&label)
        );
    }
    for culled in &plan.culled {
        let label = format!("{}\n{}", graph.pass(culled.pass).name, words::culled(graph, culled));
        let _ = writeln!(
            out,
            "  p{} [shape=box, style=\"rounded,dashed\", color=gray, fontcolor=gray, label={}];",
            culled.pass.0,
            quoted(&label)
        );
    }
    for (_, pass) in words::each_pass(plan) {
        let mut seen = Vec::new();
        for access in &graph.pass(pass.pass).accesses {
            let age = if access.age > 0 {
                format!(" [style=dashed, label={}]", quoted(&format!("@{}", access.age)))
            } else {
                String::new()
            };
            let (p, r) = (format!("p{}", pass.pass.0), format!("r{}", access.resource.0));
            let load = access.access.reads().then(|| format!("  {r} -> {p}{age};"));
            let store = access.access.writes().then(|| format!("  {p} -> {r};"));
            for edge in [load, store].into_iter().flatten() {
                if !seen.contains(&edge) {
                    let _ = writeln!(out, "{edge}");
                    seen.push(edge);
                }
            }
        }
    }
    for (number, drawn) in words::drawn_barriers(plan).iter().enumerate() {
        let label = quoted(&drawn.label);
        let _ = writeln!(
            out,
            "  b{number} [shape=box, style=filled, fillcolor=\"#f8dcd8\", color=\"#c0392b\", fontsize=9, label={label}];"
        );
        for (from, to) in &drawn.arrows {
            let _ = writeln!(out, "  {from} -> {to} [color=\"#c0392b\", style=bold];");
        }
    }
    out.push_str("}\n");
    out
}

/// A DOT string: line breaks become `\n`, quotes and backslashes are escaped.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n"))
}
