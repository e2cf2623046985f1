//! A plan as a Mermaid flow chart, which code hosts draw in Markdown. Hexagons are barriers: thick
//! arrows lead to each from the passes before it, and from it to the passes after it.

use std::fmt::Write as _;

use super::words;
use crate::ir::checked::ResourceKind;
use crate::ir::plan::Plan;

/// The plan as a Mermaid flow chart.
pub fn mermaid(plan: &Plan) -> String {
    let graph = &plan.graph;
    let mut out = String::from("flowchart LR\n");
    for resource in &plan.resources {
        let id = resource.resource;
        let (open, close) = match graph.resource(id).kind {
            ResourceKind::Target(_) if id == plan.present.resource => ("(((", ")))"),
            ResourceKind::Target(_) => ("([", "])"),
            ResourceKind::Buffer(_) => ("[(", ")]"),
        };
        let label = format!("{}\n{}", words::name_of(graph, id), words::describe(&resource.desc));
        let _ = writeln!(out, "  r{}{open}{}{close}", id.0, quoted(&label));
    }
    for (_, pass) in words::each_pass(plan) {
        let _ = writeln!(out, "  p{}[{}]", pass.pass.0, quoted(&graph.pass(pass.pass).name));
    }
    for culled in &plan.culled {
        let label = format!("{}\n{}", graph.pass(culled.pass).name, words::culled(graph, culled));
        let _ = writeln!(out, "  p{}[{}]:::culled", culled.pass.0, quoted(&label));
    }
    for (_, pass) in words::each_pass(plan) {
        let mut seen = Vec::new();
        for access in &graph.pass(pass.pass).accesses {
            let (p, r) = (format!("p{}", pass.pass.0), format!("r{}", access.resource.0));
            let load = access.access.reads().then(|| match access.age {
                0 => format!("  {r} --> {p}"),
                age => format!("  {r} -.->|@{age}| {p}"),
            });
            let store = access.access.writes().then(|| format!("  {p} --> {r}"));
            for edge in [load, store].into_iter().flatten() {
                if !seen.contains(&edge) {
                    let _ = writeln!(out, "{edge}");
                    seen.push(edge);
                }
            }
        }
    }
    let drawn_barriers = words::drawn_barriers(plan);
    for (number, drawn) in drawn_barriers.iter().enumerate() {
        let _ = writeln!(out, "  b{number}{{{{{}}}}}:::barrier", quoted(&drawn.label));
        for (from, to) in &drawn.arrows {
            let _ = writeln!(out, "  {from} ==> {to}");
        }
    }
    if !drawn_barriers.is_empty() {
        out.push_str("  classDef barrier fill: #f8dcd8,stroke: #c0392b\n");
    }
    if !plan.culled.is_empty() {
        out.push_str("  classDef culled stroke-dasharray: 4,color: gray\n");
    }
    out
}

/// A Mermaid string: quotes and markup become entities, line breaks `<br>`.
fn quoted(text: &str) -> String {
    let text = text.replace('&', "#amp;").replace('"', "#quot;").replace('<', "#lt;").replace('>', "#gt;");
    format!("\"{}\"", text.replace('\n', "<br>"))
}
