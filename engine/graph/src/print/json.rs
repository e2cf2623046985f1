//! A plan as JSON: the same facts as the text, with names instead of indices.

use serde_json::{Value, json};

use super::words;
use crate::ir::plan::{Barrier, Dependency, Lifetime, PassPlan, Plan, ResourceDesc, ResourcePlan, Scope, Step};

/// The plan for programs, indented. Keys are sorted; names refer to `resources` and `passes`.
pub fn json(plan: &Plan) -> String {
    let graph = &plan.graph;
    let memory = words::memory(plan);
    let value = json!({
        "graph": graph.name,
        "about": graph.about,
        "output": plan.output,
        "present": {
            "resource": words::name_of(graph, plan.present.resource),
            "age": plan.present.age,
            "mip": plan.present.mip,
            "layer": plan.present.layer,
            "after": plan.present.after.map(|pass| &graph.pass(pass).name),
        },
        "resources": plan.resources.iter().map(|r| resource(plan, r)).collect::<Vec<_>>(),
        "blocks": plan.blocks,
        "memory": { "allocated": memory.allocated, "saved": memory.saved },
        "clocks": plan.graph.clocks.iter().zip(&plan.clocks).map(|(clock, planned)| json!({
            "name": clock.name, "hz": clock.hz, "most": clock.most, "first": planned.first, "end": planned.end,
        })).collect::<Vec<_>>(),
        "passes": plan.passes.iter().map(|p| pass(plan, p)).collect::<Vec<_>>(),
        "culled": plan.culled.iter().map(|culled| json!({
            "pass": graph.pass(culled.pass).name,
            "reason": culled.reason,
            "about": words::culled(graph, culled),
        })).collect::<Vec<_>>(),
        "updates": {
            "before": dependency(&plan.updates.before),
            "after": dependency(&plan.updates.after),
        },
        "steps": plan.steps.iter().map(|s| step(plan, s)).collect::<Vec<_>>(),
    });
    format!("{value:#}\n")
}

fn resource(plan: &Plan, resource: &ResourcePlan) -> Value {
    let (kind, desc) = match &resource.desc {
        ResourceDesc::Image(image) => ("image", json!(image)),
        ResourceDesc::Buffer(buffer) => ("buffer", json!(buffer)),
        ResourceDesc::Source(name) => ("source", json!(name)),
        ResourceDesc::SourceImage(name, image) => ("source", json!({ "name": name, "image": image })),
    };
    let lifetime = match resource.lifetime {
        Lifetime::Persistent => json!("persistent"),
        Lifetime::Transient { first, last, place } => json!({ "first": first, "last": last, "place": place }),
    };
    let mut value = json!({
        "name": words::name_of(&plan.graph, resource.resource),
        "kind": kind,
        "made": plan.graph.resource(resource.resource).made,
        "desc": desc,
        "copies": resource.copies,
        "bytes": words::all_copies(resource),
        "clear": resource.clear,
        "init": resource.init,
        "varies": resource.varies,
        "lifetime": lifetime,
    });
    let warnings = &plan.graph.resource(resource.resource).warnings;
    if !warnings.is_empty() {
        value["warnings"] = json!(warnings);
    }
    value
}

fn pass(plan: &Plan, planned: &PassPlan) -> Value {
    let graph = &plan.graph;
    let pass = graph.pass(planned.pass);
    let (reads, writes) = words::loads_and_stores(graph, planned.pass);
    json!({
        "name": pass.name,
        "round": pass.round.and_then(|round| round.index),
        "shader": pass.shader.request.path,
        "groups": planned.groups,
        "tick": planned.tick,
        "every": pass.every.map(|every| words::every(graph, every)),
        "subgroup": pass.subgroup_size,
        "made": pass.made,
        "when": words::conditions(graph, &pass.when),
        "reads": reads,
        "writes": writes,
    })
}

fn step(plan: &Plan, step: &Step) -> Value {
    match step {
        Step::Barrier(barrier) => self::barrier(plan, barrier),
        Step::Copy { resource } => json!({
            "step": "copy",
            "resource": words::resource_name(plan, *resource),
            "source": plan.resources[*resource as usize].copy,
        }),
        Step::Clear { resource, tick } => {
            json!({ "step": "clear", "resource": words::resource_name(plan, *resource), "tick": tick })
        }
        Step::Dispatch { pass } => {
            let PassPlan { pass, tick, .. } = plan.passes[*pass as usize];
            json!({ "step": "dispatch", "pass": plan.graph.pass(pass).name, "tick": tick })
        }
        Step::Present => json!({ "step": "present" }),
    }
}

fn barrier(plan: &Plan, barrier: &Barrier) -> Value {
    let graph = &plan.graph;
    let hazard = |hazard: &crate::ir::plan::Hazard| {
        json!({
            "resource": words::name_of(graph, hazard.resource),
            "kind": words::kind(hazard.kind),
            "from": hazard.from.map(|pass| &graph.pass(pass).name),
            "to": hazard.to.map(|pass| &graph.pass(pass).name),
            "wraps": hazard.wraps,
        })
    };
    json!({
        "step": "barrier",
        "memory": barrier.memory.as_ref().map(dependency),
        "activate": barrier.activate.iter().map(|activation| json!({
            "resource": words::resource_name(plan, activation.resource),
            "dependency": dependency(&activation.dependency),
        })).collect::<Vec<_>>(),
        "hazards": barrier.hazards.iter().map(hazard).collect::<Vec<_>>(),
    })
}

fn dependency(dependency: &Dependency) -> Value {
    json!({ "src": scope(dependency.src), "dst": scope(dependency.dst) })
}

fn scope(scope: Scope) -> Value {
    let stages = scope.stages.iter_names().map(|(name, _)| name);
    let access = scope.access.iter_names().map(|(name, _)| name);
    json!({ "stages": stages.collect::<Vec<_>>(), "access": access.collect::<Vec<_>>() })
}
