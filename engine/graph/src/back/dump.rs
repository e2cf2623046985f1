//! The results of each phase of the back end, as text.

use std::fmt::Write as _;

use crate::back::alias::Alias;
use crate::back::cull::Cull;
use crate::back::lifetimes::Life;
use crate::back::order::{Action, Instance, Order};
use crate::ir::checked::{Graph, Pass};
use crate::ir::plan::Barrier;
use crate::ir::size::Size;
use crate::print::words;

/// A phase of the back end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Extents, mips and bytes.
    Sizes,
    /// Loops written out.
    Unroll,
    /// Passes that run.
    Cull,
    /// Actions and their accesses.
    Order,
    /// Resources that matter only inside a frame.
    Lifetimes,
    /// Resources that depend on camera, cursor, frame or clock.
    Varies,
    /// Places in shared memory.
    Alias,
    /// Barriers.
    Barriers,
}

impl Phase {
    /// Every phase in order.
    pub const ALL: &[Phase] = &[
        Phase::Sizes,
        Phase::Unroll,
        Phase::Cull,
        Phase::Order,
        Phase::Lifetimes,
        Phase::Varies,
        Phase::Alias,
        Phase::Barriers,
    ];

    /// Its word on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Phase::Sizes => "sizes",
            Phase::Unroll => "unroll",
            Phase::Cull => "cull",
            Phase::Order => "order",
            Phase::Lifetimes => "lifetimes",
            Phase::Varies => "varies",
            Phase::Alias => "alias",
            Phase::Barriers => "barriers",
        }
    }

    /// The phase of that word.
    pub fn from_name(name: &str) -> Option<Phase> {
        Phase::ALL.iter().copied().find(|phase| phase.name() == name)
    }
}

/// The result of a phase.
pub(crate) enum After<'a> {
    Sizes(&'a [Size]),
    /// The graph as it was declared.
    Unroll(&'a Graph),
    Cull(&'a Cull),
    Order(&'a Order, &'a Cull),
    Lifetimes(&'a [Life], &'a Cull),
    Varies(&'a [bool], &'a Cull),
    Alias(&'a Alias, &'a Cull),
    Barriers(&'a [Option<Barrier>], &'a Order, &'a Cull),
}

impl After<'_> {
    /// The phase.
    pub(crate) fn phase(&self) -> Phase {
        match self {
            After::Sizes(_) => Phase::Sizes,
            After::Unroll(_) => Phase::Unroll,
            After::Cull(_) => Phase::Cull,
            After::Order(..) => Phase::Order,
            After::Lifetimes(..) => Phase::Lifetimes,
            After::Varies(..) => Phase::Varies,
            After::Alias(..) => Phase::Alias,
            After::Barriers(..) => Phase::Barriers,
        }
    }

    /// One line for each fact.
    pub(crate) fn text(&self, graph: &Graph) -> String {
        let mut out = String::new();
        let name = |cull: &Cull, index: usize| words::name_of(graph, cull.used[index]).to_owned();
        match self {
            After::Sizes(sizes) => {
                for (resource, size) in graph.resources.iter().zip(*sizes) {
                    let _ = writeln!(out, "{}: {}", resource.name, size_text(size));
                }
            }
            After::Unroll(declared) => {
                for pass in &graph.passes {
                    let _ = writeln!(out, "{}{}", pass.name, renamed(graph, declared, pass));
                }
            }
            After::Cull(cull) => {
                for pass in &cull.live {
                    let _ = writeln!(out, "{} runs", graph.pass(*pass).name);
                }
                for culled in &cull.culled {
                    let _ =
                        writeln!(out, "{} does not: {}", graph.pass(culled.pass).name, words::culled(graph, culled));
                }
            }
            After::Order(order, cull) => {
                for (number, action) in (0..).zip(&order.actions) {
                    let _ = writeln!(out, "{number} {}", action_text(graph, cull, order, *action));
                    for access in order.accesses.iter().filter(|access| access.action == number) {
                        let (mips, layers) = (access.range.mips, access.range.layers);
                        let _ = writeln!(
                            out,
                            "    {} of {}, mips {}..{}, layers {}..{}",
                            access.mask,
                            words::aged(graph, cull.used[access.resource as usize], access.age),
                            mips.0,
                            mips.1,
                            layers.0,
                            layers.1
                        );
                    }
                }
            }
            After::Lifetimes(lives, cull) => {
                for (index, life) in lives.iter().enumerate() {
                    let name = name(cull, index);
                    let _ = match life {
                        Life::Persistent => writeln!(out, "{name}: persistent"),
                        Life::Transient { first, last } => writeln!(out, "{name}: actions {first}..={last}"),
                    };
                }
            }
            After::Varies(varies, cull) => {
                for (index, varies) in varies.iter().enumerate() {
                    let says =
                        if *varies { "may change with every frame" } else { "made without camera, cursor and time" };
                    let _ = writeln!(out, "{}: {says}", name(cull, index));
                }
            }
            After::Alias(alias, cull) => {
                for (number, block) in alias.blocks.iter().enumerate() {
                    let _ = writeln!(
                        out,
                        "block {number}: {} bytes, alignment {}, memory types {:#b}",
                        block.size, block.alignment, block.type_bits
                    );
                }
                for (index, place) in alias.places.iter().enumerate() {
                    if let Some(place) = place {
                        let others: Vec<_> = alias.neighbours[index].iter().map(|&i| name(cull, i as usize)).collect();
                        let _ = writeln!(
                            out,
                            "{}: block {} + {}, shared with {}",
                            name(cull, index),
                            place.block,
                            place.offset,
                            others.join(", ")
                        );
                    }
                }
            }
            After::Barriers(barriers, order, cull) => {
                for (barrier, action) in barriers.iter().zip(&order.actions) {
                    let Some(barrier) = barrier else { continue };
                    let _ = writeln!(out, "before {}", action_text(graph, cull, order, *action));
                    if let Some(memory) = &barrier.memory {
                        let _ = writeln!(out, "    {}", words::dependency(memory));
                    }
                    for activation in &barrier.activate {
                        let name = name(cull, activation.resource as usize);
                        let _ = writeln!(out, "    activate {name}: {}", words::dependency(&activation.dependency));
                    }
                }
            }
        }
        out
    }
}

/// The names of a pass that stand for another resource in its round.
fn renamed(graph: &Graph, declared: &Graph, pass: &Pass) -> String {
    let Some(round) = pass.round else { return String::new() };
    let mut pairs = Vec::new();
    for (named, meant) in declared.pass(round.pass).accesses.iter().zip(&pass.accesses) {
        let pair = format!("{} is {}", words::name_of(graph, named.resource), words::name_of(graph, meant.resource));
        if named.resource != meant.resource && !pairs.contains(&pair) {
            pairs.push(pair);
        }
    }
    if pairs.is_empty() { String::new() } else { format!(": {}", pairs.join(", ")) }
}

fn action_text(graph: &Graph, cull: &Cull, order: &Order, action: Action) -> String {
    match action {
        Action::Copy(resource) => format!("fill {}", words::name_of(graph, cull.used[resource as usize])),
        Action::Clear(resource, tick) => {
            format!("clear {}{}", words::name_of(graph, cull.used[resource as usize]), words::tick(tick))
        }
        Action::Dispatch(pass) => {
            let Instance { pass, tick } = order.passes[pass as usize];
            format!("dispatch {}{}", graph.pass(pass).name, words::tick(tick))
        }
        Action::Present => "present".to_owned(),
    }
}

fn size_text(size: &Size) -> String {
    match size {
        Size::Image { extent: [w, h, d], mips, layers, .. } => {
            format!("{w}×{h}×{d} texels, {mips} mips, {layers} layers")
        }
        Size::Buffer { bytes: Some(bytes), .. } => format!("{bytes} bytes"),
        Size::Buffer { bytes: None, .. } => "not supplied".to_owned(),
    }
}
