//! A slow interpreter of random graphs ([`crate::random`]): every pass in the order of the file, over memory of its own for every copy of
//! every resource. It has no plans and no culling, and computes the same bits as the shaders: all factors are powers of two.

use std::collections::VecDeque;

use raxel_graph::checked::{
    BoundAccess, BufferSize, Builtin, Clear, Dispatch, Every, Extent, Graph, Pass, Resource, ResourceId, ResourceKind,
    ValueOrigin,
};

use crate::random::FLOATS;
use crate::random_shaders::Kind;

/// The inputs of a frame.
#[derive(Clone, Copy)]
pub(crate) struct Given {
    pub frame: u32,
    pub time: f32,
    pub params: [f32; 2],
    /// Ticks that are due.
    pub ticks: u32,
}

/// The words of every mip of one copy.
pub(crate) type Contents = Vec<Vec<u32>>;

/// Every copy of a resource, the current one first.
type Copies = VecDeque<Contents>;

pub(crate) struct Interpreter<'a> {
    graph: &'a Graph,
    copies: Vec<Copies>,
    /// By pass: it has run.
    ran: Vec<bool>,
    /// An indirect dispatch found no workgroups. It stores nothing, though its `writeonly` bindings promise to.
    pub starved: bool,
}

impl<'a> Interpreter<'a> {
    /// Before the first frame. `supplied` gives the contents of sources and their copies.
    pub(crate) fn new(graph: &'a Graph, supplied: impl Fn(&str) -> Vec<u32>) -> Self {
        let copies = graph.resources.iter().map(|resource| {
            let contents = match resource.kind.supplied_by() {
                Some(source) => vec![supplied(source)],
                None => initial(resource),
            };
            (0..=resource.history).map(|_| contents.clone()).collect()
        });
        Self { graph, copies: copies.collect(), ran: vec![false; graph.passes.len()], starved: false }
    }

    /// A resource as it was this number of frames (or ticks) ago.
    pub(crate) fn contents(&self, resource: usize, age: usize) -> &Contents {
        &self.copies[resource][age]
    }

    /// Replaces words of everything that comes from a source.
    pub(crate) fn supply(&mut self, wanted: impl Fn(&Resource) -> bool, words: impl Fn(&mut [u32])) {
        for (resource, copies) in self.graph.resources.iter().zip(&mut self.copies) {
            if wanted(resource) {
                words(&mut copies[0][0]);
            }
        }
    }

    /// Runs a frame.
    pub(crate) fn frame(&mut self, given: &Given) {
        self.begin(|resource| resource.clock.is_none(), true);
        let of_clock = |pass: &Pass| matches!(pass.every, Some(Every::Clock(_)));
        let passes: Vec<usize> = (0..self.graph.passes.len()).collect();
        let clocked = self.graph.passes.iter().any(of_clock);
        for group in passes.chunk_by(|a, b| of_clock(&self.graph.passes[*a]) && of_clock(&self.graph.passes[*b])) {
            let ticks = of_clock(&self.graph.passes[group[0]]);
            for _ in 0..if ticks { given.ticks } else { 1 } {
                if ticks {
                    self.begin(|resource| resource.clock.is_some(), true);
                }
                group.iter().for_each(|pass| self.pass(*pass, given));
            }
        }
        if !clocked {
            (0..given.ticks).for_each(|_| self.begin(|resource| resource.clock.is_some(), false));
        }
    }

    /// The oldest copy becomes the current one, and is cleared if the file has a clear.
    fn begin(&mut self, of: impl Fn(&Resource) -> bool, clears: bool) {
        for (resource, copies) in self.graph.resources.iter().zip(&mut self.copies).filter(|(resource, _)| of(resource))
        {
            copies.rotate_right(1);
            if let Some(word) = cleared(resource).filter(|_| clears) {
                copies[0].iter_mut().for_each(|mip| mip.fill(word));
            }
        }
    }

    fn pass(&mut self, index: usize, given: &Given) {
        let graph = self.graph;
        let pass = &graph.passes[index];
        let due = match pass.every {
            Some(Every::Frames(frames)) => !self.ran[index] || given.frame.is_multiple_of(frames),
            _ => true,
        };
        if !due {
            return;
        }
        self.ran[index] = true;
        if let Dispatch::Indirect { buffer, offset } = pass.dispatch {
            let first = offset as usize / 4;
            if self.copies[buffer.0 as usize][0][0][first..first + 3].contains(&0) {
                self.starved = true;
                return;
            }
        }
        let add = match pass.push[0].from {
            ValueOrigin::Builtin(Builtin::FrameTime) => given.time,
            ValueOrigin::Param(id) => given.params[id.0 as usize],
            ref other => panic!("{other:?}"),
        };
        let kinds = Kind::of_shader(&pass.shader.request.path);
        let bound: Vec<(Kind, &BoundAccess)> =
            kinds.into_iter().enumerate().map(|(at, kind)| (kind, bound(pass, &format!("b{at}")))).collect();
        for thread in 0..64 {
            let value = bound.iter().fold(add, |value, (kind, access)| value + self.load(*kind, access, thread));
            for (kind, access) in &bound {
                self.store(*kind, access, thread, value);
            }
        }
    }

    /// The addend of a binding to the value of a thread.
    fn load(&self, kind: Kind, access: &BoundAccess, thread: usize) -> f32 {
        let words = &self.copies[access.resource.0 as usize][access.age as usize][access.mips.first as usize];
        let texel =
            || f32::from_bits(words[thread / 4 % 4 * self.width(access.resource, access.mips.first) + thread % 4]);
        match kind {
            Kind::Sampled => texel() * 0.5,
            Kind::ReadImage => texel() * 0.25,
            Kind::ReadBuffer => f32::from_bits(words[thread % words.len()]) * 0.5,
            Kind::WriteImage | Kind::ReadWriteImage | Kind::WriteBuffer | Kind::WriteArguments => 0.0,
        }
    }

    /// The value that a thread stores in a binding.
    fn store(&mut self, kind: Kind, access: &BoundAccess, thread: usize, value: f32) {
        let fract = |value: f32| value - value.floor();
        let step = |index: usize| index as f32 * 0.125;
        let words = &mut self.copies[access.resource.0 as usize][0][access.mips.first as usize];
        for (index, word) in words.iter_mut().enumerate().skip(thread).step_by(64) {
            *word = match kind {
                Kind::Sampled | Kind::ReadImage | Kind::ReadBuffer => return,
                Kind::WriteImage => fract(value + step(index)).to_bits(),
                Kind::ReadWriteImage => fract(value + f32::from_bits(*word) * 0.5 + step(index)).to_bits(),
                Kind::WriteBuffer => fract(value).to_bits(),
                Kind::WriteArguments => 1,
            };
        }
    }

    fn width(&self, resource: ResourceId, mip: u32) -> usize {
        extent(self.graph.resource(resource)).map_or(1, |[width, _]| (width >> mip).max(1) as usize)
    }
}

fn bound<'p>(pass: &'p Pass, name: &str) -> &'p BoundAccess {
    let at = pass.shader.interface.bindings.iter().position(|binding| binding.name == name);
    let found = pass.accesses.iter().find(|access| access.binding.map(|binding| binding as usize) == at);
    found.unwrap_or_else(|| panic!("`{}` binds `{name}`", pass.name))
}

fn extent(resource: &Resource) -> Option<[u32; 2]> {
    match &resource.kind {
        ResourceKind::Target(target) => match target.extent {
            Extent::Fixed2(extent) => Some(extent),
            other => panic!("{other:?}"),
        },
        ResourceKind::Buffer(_) => None,
    }
}

/// The words of a resource at its creation.
fn initial(resource: &Resource) -> Contents {
    match &resource.kind {
        ResourceKind::Target(target) => {
            let word = target.init.map_or(0, word);
            let [width, height] = extent(resource).unwrap_or([1; 2]);
            let texels = |mip: u32| (width >> mip).max(1) * (height >> mip).max(1);
            (0..target.mips).map(|mip| vec![word; texels(mip) as usize]).collect()
        }
        ResourceKind::Buffer(buffer) => vec![match &buffer.size {
            BufferSize::Bytes(bytes) => vec![buffer.init.unwrap_or(0); *bytes as usize / 4],
            BufferSize::Values(values) => bytemuck::pod_collect_to_vec(&values.bytes),
            _ => vec![0; FLOATS],
        }],
    }
}

fn cleared(resource: &Resource) -> Option<u32> {
    match &resource.kind {
        ResourceKind::Target(target) => target.clear.map(word),
        ResourceKind::Buffer(buffer) => buffer.clear,
    }
}

fn word(clear: Clear) -> u32 {
    match clear {
        Clear::Float(channels) => channels[0].to_bits(),
        Clear::Int(channels) => channels[0].cast_unsigned(),
        Clear::Uint(channels) => channels[0],
    }
}

/// Whether a pass binds a resource.
pub(crate) fn is_touched(graph: &Graph, resource: usize) -> bool {
    graph.passes.iter().flat_map(|pass| &pass.accesses).any(|access| access.resource.0 as usize == resource)
}

/// Whether a pass stores to a resource.
pub(crate) fn is_written(graph: &Graph, resource: usize) -> bool {
    let writes = |access: &BoundAccess| access.resource.0 as usize == resource && access.access.writes();
    graph.passes.iter().flat_map(|pass| &pass.accesses).any(writes)
}
