//! Resolves `[targets.*]` and `[buffers.*]`: formats, extents, sources, values.

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Diagnostic, Span, Spanned, codes};
use raxel_graph::ValueType;
use raxel_graph::checked::{self, ClockId, Extent, Origin, Resource, ResourceId, ResourceKind};
use raxel_graph::supply::{Catalog, has_shape};
use raxel_shader::format::Format;

use super::clears::{colour, pattern};
use super::displays::show;
use super::params::unknown_type;
use super::supplied::{extent_from_outside, only_of_files};
use super::{Declared, Names, clock_id, missing, resource};
use crate::literal::{describe, typed};
use crate::model::{Buffer, BufferSize, Data, Dispatch, File, Literal, Pass, Size, Target, WORLD, Warning};
use crate::queues;

/// Resolves targets, then buffers.
pub(crate) fn resources(
    model: &File,
    names: &Names,
    clocks: &Names,
    catalog: &dyn Catalog,
    found: &mut Vec<Diagnostic>,
) -> Vec<Declared<Resource>> {
    let scope = Scope { names, clocks, targets: &model.targets, buffers: &model.buffers, catalog };
    world_is_the_world(model, found);
    let mut resources = Vec::with_capacity(model.targets.len() + model.buffers.len());
    for target in &model.targets {
        resources.push(scope.target(target, found));
    }
    for buffer in &model.buffers {
        resources.push(scope.buffer(buffer, found));
    }
    // A resource as large as a wrong one has a stand-in extent; a chain of these is as long as there are resources.
    for _ in 0..resources.len() {
        let stands_in = |resource: &Declared<Resource>| match &resource.item.kind {
            ResourceKind::Target(checked::Target { extent: Extent::Of { target, .. }, .. }) => {
                resource.sound && !resources[target.0 as usize].sound
            }
            _ => false,
        };
        let Some(index) = resources.iter().position(stands_in) else { break };
        resources[index].sound = false;
    }
    resources
}

pub(super) struct Scope<'a> {
    names: &'a Names,
    clocks: &'a Names,
    targets: &'a [Target],
    buffers: &'a [Buffer],
    pub(super) catalog: &'a dyn Catalog,
}

impl Scope<'_> {
    fn target(&self, target: &Target, found: &mut Vec<Diagnostic>) -> Declared<Resource> {
        match (&target.source, &target.copy) {
            (Some(source), _) if has_shape(&source.value) => {
                // A format that does not exist is reported, and then it is as if none were wanted.
                let format = target.format.as_ref().and_then(|_| format(target, found));
                return self.shaped_target(target, source, format, found);
            }
            (Some(source), _) | (None, Some(source)) => return self.supplied(target, source, found),
            (None, None) => {}
        }
        let before = found.len();
        let name = &target.name;
        only_of_files(target, found);
        let format = format(target, found);
        let extent = match target.size.as_ref().map(|size| &size.value) {
            None => Extent::Output { scale: [1.0; 2] },
            Some(Size::Output(scale)) => Extent::Output { scale: *scale },
            Some(Size::Fixed2(extent)) => Extent::Fixed2(*extent),
            Some(Size::Fixed3(extent)) => Extent::Fixed3(*extent),
            Some(Size::Of { target, scale }) if target.value == WORLD => Extent::World { scale: *scale },
            Some(Size::Of { target, scale }) => match self.target_id(target, found) {
                Some(target) => Extent::Of { target, scale: *scale },
                None => Extent::Output { scale: [1.0; 2] },
            },
        };
        // Without a format, users of the target cannot be checked; the rest of the target still is.
        let shape = format.unwrap_or(Format::Rgba32f);
        let mut fill = |literal: &Option<Literal>, key| {
            let literal = literal.as_ref().filter(|_| format.is_some())?;
            colour(&name.value, key, literal, shape, found)
        };
        let (clear, init) = (fill(&target.clear, "clear"), fill(&target.init, "init"));
        let display = target.display.as_ref().filter(|_| format.is_some());
        let display = display.and_then(|display| show(&name.value, display, shape, found));
        let kind = ResourceKind::Target(checked::Target {
            format: shape,
            extent,
            source: None,
            mips: target.mips.as_ref().map_or(1, |mips| mips.value),
            layers: target.layers.as_ref().map_or(1, |layers| layers.value),
            clear,
            init,
            display,
        });
        volume_has_no_layers(target, found);
        let clock = self.clock(target.clock.as_ref(), found);
        let sound = format.is_some() && !target.flawed && found.len() == before;
        let detail = target.format.as_ref().map_or(&name.span, |format| &format.span).clone();
        declared(name, kind, kept(target.history.as_ref(), target.keep.as_ref(), clock), sound, detail)
    }

    fn buffer(&self, buffer: &Buffer, found: &mut Vec<Diagnostic>) -> Declared<Resource> {
        let before = found.len();
        let name = &buffer.name;
        let supplied = buffer.source.as_ref().or(buffer.copy.as_ref());
        let (size, origin) = match (supplied, &buffer.size) {
            (Some(_), _) => self.supplied_bytes(buffer, found).unzip(),
            (None, _) if buffer.values.is_some() => (values(buffer, found).map(checked::BufferSize::Values), None),
            (None, Some(size)) => (self.buffer_size(&size.value, found), None),
            (None, None) => {
                if !buffer.flawed {
                    let whose = format!("`buffers.{}`", name.value);
                    found.push(missing(&whose, "size", &name.span).help("or `source`, or `values`"));
                }
                (None, None)
            }
        };
        if let (Some(ty), None, false) = (&buffer.ty, &buffer.values, buffer.flawed) {
            let message = format!("buffer `{}` has a `type` and no `values`", name.value);
            found.push(
                Diagnostic::error(codes::files::CONFLICTING_KEYS, message)
                    .label(ty.span.clone(), "nothing has this type")
                    .help("`type` is for `values = […]`; the shader declares the type of any other buffer"),
            );
        }
        let mut fill = |literal: &Option<Literal>, key| pattern(&name.value, key, literal.as_ref()?, found);
        let (clear, init) = (fill(&buffer.clear, "clear"), fill(&buffer.init, "init"));
        let clear = if matches!(origin, Some(Origin::Collected(_))) { Some(0) } else { clear };
        let clock = self.clock(buffer.clock.as_ref(), found);
        let sound = size.is_some() && !buffer.flawed && found.len() == before;
        let size = size.unwrap_or(checked::BufferSize::Bytes(4));
        let kind = ResourceKind::Buffer(checked::Buffer { size, clear, init });
        let places = supplied.map(|source| &source.span);
        let places = places.or(buffer.values.as_ref().map(|values| &values.span));
        let detail = places.or(buffer.size.as_ref().map(|size| &size.span)).unwrap_or(&name.span).clone();
        let mut kept = kept(buffer.history.as_ref(), buffer.keep.as_ref(), clock);
        let warnings: Vec<checked::Warning> = buffer.warnings.iter().flatten().map(warning).collect();
        // A counted word must still be there when the frame is over.
        kept.keep |= !warnings.is_empty();
        let declared = declared(name, kind, kept, sound, detail);
        let item = Resource { origin: origin.unwrap_or_default(), warnings, ..declared.item };
        Declared { item, ..declared }
    }

    fn clock(&self, name: Option<&Spanned<String>>, found: &mut Vec<Diagnostic>) -> Option<ClockId> {
        let name = name?;
        clock_id(self.clocks, &name.value, &name.span, found)
    }

    fn buffer_size(&self, size: &BufferSize, found: &mut Vec<Diagnostic>) -> Option<checked::BufferSize> {
        Some(match size {
            BufferSize::Bytes(bytes) => checked::BufferSize::Bytes(*bytes),
            BufferSize::Elements { count, stride } => checked::BufferSize::Elements { count: *count, stride: *stride },
            BufferSize::Of { of, scale, per, stride } if of.value == WORLD => {
                let scale = scale.as_ref().map_or(1.0, |scale| scale.value);
                checked::BufferSize::World { scale, per: *per, stride: *stride }
            }
            BufferSize::Of { of, scale, per, stride } => {
                if let Some(scale) = scale {
                    found.push(
                        Diagnostic::error(
                            codes::files::CONFLICTING_KEYS,
                            format!("a buffer with elements for each of `{}` has no `scale`", of.value),
                        )
                        .label(scale.span.clone(), "only a part of the world can be meant here")
                        .label(of.span.clone(), "not the world")
                        .help("declare a target of the scaled size and name it in `of`"),
                    );
                    return None;
                }
                checked::BufferSize::Of { of: self.counted_id(of, found)?, per: *per, stride: *stride }
            }
        })
    }

    /// The target of that name.
    fn target_id(&self, name: &Spanned<String>, found: &mut Vec<Diagnostic>) -> Option<ResourceId> {
        let id = resource(self.names, &name.value, &name.span, found)?;
        match self.targets.get(id.0 as usize) {
            Some(Target { source: Some(source), .. } | Target { copy: Some(source), .. })
                if !has_shape(&source.value) =>
            {
                found.push(extent_from_outside(name, &source.span));
                return None;
            }
            Some(_) => return Some(id),
            None => {}
        }
        found.push(
            Diagnostic::error(
                codes::graph::WRONG_KIND,
                format!("`{}` is a buffer; only a target has an extent", name.value),
            )
            .label(name.span.clone(), "a target is needed here"),
        );
        None
    }

    /// The target or buffer of that name, whose texels or elements can be counted.
    fn counted_id(&self, name: &Spanned<String>, found: &mut Vec<Diagnostic>) -> Option<ResourceId> {
        let id = resource(self.names, &name.value, &name.span, found)?;
        let Some(buffer) = (id.0 as usize).checked_sub(self.targets.len()).and_then(|index| self.buffers.get(index))
        else {
            return self.target_id(name, found);
        };
        if buffer.values.is_some() {
            return Some(id);
        }
        match (buffer.source.as_ref().or(buffer.copy.as_ref()), &buffer.size) {
            (None, Some(Spanned { value: BufferSize::Elements { .. } | BufferSize::Of { .. }, .. })) => {
                return Some(id);
            }
            // A size that is missing or wrong is reported where it is.
            (None, None) => {}
            (Some(source), _) => found.push(no_elements(name, &source.span)),
            (None, Some(size)) => found.push(no_elements(name, &size.span)),
        }
        None
    }
}

/// The elements that a file writes, laid out as `std430` does.
fn values(buffer: &Buffer, found: &mut Vec<Diagnostic>) -> Option<checked::Values> {
    let literal = buffer.values.as_ref()?;
    let Data::Array(elements) = &literal.data else { return None };
    let word = buffer.ty.as_ref().map_or("f32", |ty| ty.value.as_str());
    let Some(ty) = ValueType::from_word(word) else {
        let place = buffer.ty.as_ref().map_or(&literal.span, |ty| &ty.span);
        found.push(unknown_type(word, place, ValueType::words()));
        return None;
    };
    let mut bytes = Vec::with_capacity(elements.len() * ty.stride() as usize);
    let mut wrong = elements.iter().filter(|element| {
        let value = typed(element, ty);
        if let Some(value) = value {
            value.lay_out(&mut bytes);
        }
        value.is_none()
    });
    if let Some(element) = wrong.next() {
        let more = wrong.count();
        let message =
            format!("a value of buffer `{}` is {}, which is no `{}`", buffer.name.value, describe(element), ty.word());
        let mut diagnostic = Diagnostic::error(codes::graph::LITERAL, message).label(element.span.clone(), "");
        diagnostic = match &buffer.ty {
            Some(ty) => diagnostic.label(ty.span.clone(), "the type"),
            None => diagnostic.help("give their type, e.g. `type = \"vec4\"`; without `type` each value is a float"),
        };
        if more > 0 {
            diagnostic = diagnostic.note(format!("{more} more of its values are none"));
        }
        found.push(diagnostic);
        return None;
    }
    Some(checked::Values { ty, stride: ty.stride(), bytes: bytes.into() })
}

fn warning(warning: &Warning) -> checked::Warning {
    let Warning { offset, says, help } = warning;
    checked::Warning { offset: *offset, says: says.value.clone(), help: help.clone(), place: says.span.clone() }
}

/// The buffer for the indirect arguments of a pass that dispatches a queue.
pub(crate) fn arguments(pass: &Pass) -> Option<Declared<Resource>> {
    let dispatch = pass.dispatch.as_ref().filter(|dispatch| matches!(dispatch.value, Dispatch::Queue { .. }))?;
    let item = queues::arguments(&pass.name.value, pass.name.span.clone());
    Some(Declared { item, sound: true, detail: dispatch.span.clone() })
}

/// In sizes `world` is the world. A resource of that name that is something else would be mistaken for it.
fn world_is_the_world(model: &File, found: &mut Vec<Diagnostic>) {
    let of_target = model.targets.iter().map(|target| (&target.name, target.source.as_ref().or(target.copy.as_ref())));
    let of_buffer = model.buffers.iter().map(|buffer| (&buffer.name, buffer.source.as_ref().or(buffer.copy.as_ref())));
    for (name, source) in of_target.chain(of_buffer).filter(|(name, _)| name.value == WORLD) {
        if source.is_none_or(|source| !source.value.starts_with("world.")) {
            found.push(
                Diagnostic::error(codes::graph::BAD_NAME, "`world` is the name of a resource that is not the world".to_owned())
                    .label(name.span.clone(), "in sizes, this name means the world")
                    .help("give it another name, or `source = \"world.tree64\"`: in sizes, `of = \"world\"` means the bounds of the world"),
            );
        }
    }
}

/// The number of elements of the buffer of that name is unknown.
pub(super) fn no_elements(name: &Spanned<String>, size: &Span) -> Diagnostic {
    let message = format!("the number of elements of buffer `{}` is not known", name.value);
    Diagnostic::error(codes::graph::WRONG_KIND, message)
        .label(name.span.clone(), "a number of elements is needed here")
        .label(size.clone(), "this says bytes alone")
        .help("give its size as `{ count = …, stride = … }` or `{ of = \"…\", stride = … }`")
}

/// The parts of a resource that outlive a frame.
#[derive(Clone, Copy)]
struct Kept {
    history: u32,
    keep: bool,
    clock: Option<ClockId>,
}

fn kept(history: Option<&Spanned<u32>>, keep: Option<&Spanned<bool>>, clock: Option<ClockId>) -> Kept {
    Kept { history: history.map_or(0, |history| history.value), keep: keep.is_some_and(|keep| keep.value), clock }
}

fn declared(name: &Spanned<String>, kind: ResourceKind, kept: Kept, sound: bool, detail: Span) -> Declared<Resource> {
    let Kept { history, keep, clock } = kept;
    let (name, place) = (name.value.clone(), name.span.clone());
    let (warnings, origin) = (Vec::new(), Origin::Graph);
    let item = Resource { name, kind, history, keep, clock, made: false, warnings, origin, place };
    Declared { item, sound, detail }
}

fn format(target: &Target, found: &mut Vec<Diagnostic>) -> Option<Format> {
    let Some(word) = &target.format else {
        if !target.flawed {
            found.push(missing(&format!("`targets.{}`", target.name.value), "format", &target.name.span));
        }
        return None;
    };
    let format = Format::from_name(&word.value);
    if format.is_none() {
        let names = || Format::ALL.iter().map(|format| format.name());
        let diagnostic =
            Diagnostic::error(codes::graph::UNKNOWN_FORMAT, format!("there is no format `{}`", word.value))
                .label(word.span.clone(), "no such format");
        found.push(match closest(&word.value, names()) {
            Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
            None => diagnostic.help(format!("one of: {}", list(names()))),
        });
    }
    format
}

fn volume_has_no_layers(target: &Target, found: &mut Vec<Diagnostic>) {
    let (Some(size), Some(layers)) = (&target.size, &target.layers) else { return };
    let volume = match &size.value {
        Size::Fixed3(_) => true,
        Size::Of { target, .. } => target.value == WORLD,
        Size::Output(_) | Size::Fixed2(_) => false,
    };
    if volume && layers.value > 1 {
        found.push(
            Diagnostic::error(
                codes::files::CONFLICTING_KEYS,
                format!("target `{}` has three dimensions and {} layers", target.name.value, layers.value),
            )
            .label(layers.span.clone(), "a 3-D image has no layers")
            .label(size.span.clone(), "three dimensions"),
        );
    }
}
