//! Resolves supplies from outside: sources, copies of them, and files.

use raxel_diagnostics::files::join;
use raxel_diagnostics::names::list;
use raxel_diagnostics::{Diagnostic, Span, Spanned, codes};
use raxel_graph::checked::{self, Extent, Origin, Resource, ResourceKind};
use raxel_graph::index32;
use raxel_graph::supply::{FILE, FileContents, ImageRequest, MICROPHONE, Refusal};
use raxel_shader::format::Format;

use super::displays::show;
use super::resources::Scope;
use super::{Declared, unknown};
use crate::model::{Buffer, Encoding, Target};

impl Scope<'_> {
    /// A target that is a source, or a copy of one: all of it but how it is shown comes from there.
    pub(super) fn supplied(
        &self,
        target: &Target,
        source: &Spanned<String>,
        found: &mut Vec<Diagnostic>,
    ) -> Declared<Resource> {
        let before = found.len();
        let name = &target.name;
        let known = self.catalog.source(&source.value);
        let format = known.as_ref().and_then(|known| known.image);
        if format.is_none() {
            let images = self.catalog.sources().iter().filter(|known| known.image.is_some());
            let microphone = target.copy.is_none().then_some(MICROPHONE);
            let images = images.map(|known| known.name.as_str()).chain(microphone);
            found.push(if known.is_some() {
                let message = format!("`{}` supplies a buffer and no image", source.value);
                Diagnostic::error(codes::graph::WRONG_KIND, message)
                    .label(source.span.clone(), "an image is needed here")
                    .help(format!("declare it in `[buffers.{}]`; images come from {}", name.value, list(images)))
            } else {
                unknown(codes::graph::UNKNOWN_SOURCE, "source of images", &source.value, &source.span, images)
            });
        }
        takes_none(target, source, &["format", "mips", "slices", "encoding"], found);
        let shape = format.unwrap_or(Format::R16ui);
        let display = target.display.as_ref().filter(|_| format.is_some());
        let display = display.and_then(|display| show(&name.value, display, shape, found));
        let sound = !target.flawed && found.len() == before;
        let origin = match known {
            _ if target.copy.is_some() => Origin::Copy,
            Some(known) => Origin::Source(known.access),
            None => Origin::default(),
        };
        let image = supplied_image(name.value.clone(), source, shape, display, origin);
        let item = Resource { place: name.span.clone(), ..image.item };
        Declared { item, sound, ..image }
    }

    /// A target whose texels are those of a file, or the microphone's.
    pub(super) fn shaped_target(
        &self,
        target: &Target,
        source: &Spanned<String>,
        format: Option<Format>,
        found: &mut Vec<Diagnostic>,
    ) -> Declared<Resource> {
        let before = found.len();
        let name = &target.name;
        takes_none(target, source, &[], found);
        let request = ImageRequest {
            format,
            mips: target.mips.as_ref().map_or(1, |mips| mips.value),
            slices: target.slices.as_ref().map(|slices| slices.value),
            srgb: target.encoding.as_ref().is_some_and(|encoding| encoding.value == Encoding::Srgb),
        };
        let read = if source.value == MICROPHONE {
            Some(self.catalog.microphone(&request))
        } else {
            project_path(source, found).map(|path| self.catalog.file(&path, Some(&request)))
        };
        let contents =
            read.and_then(|read| read.map_err(|refusal| found.push(refused(&refusal, source, Some(target)))).ok());
        let (image, origin) = match contents {
            Some(contents) => match &*contents {
                FileContents::Image(image) => (Some(shape(image, source)), Origin::File(contents.clone())),
                FileContents::Bytes(_) => (None, Origin::default()),
            },
            None => (None, Origin::default()),
        };
        let known = image.is_some();
        let mut image = image.unwrap_or_else(|| blank(format.unwrap_or(Format::Rgba32f), source));
        let display = target.display.as_ref().filter(|_| known);
        image.display = display.and_then(|display| show(&name.value, display, image.format, found));
        let sound = known && !target.flawed && found.len() == before;
        let image = Resource::new(&name.value, ResourceKind::Target(image), name.span.clone());
        let item = Resource { origin, ..image };
        Declared { item, sound, detail: source.span.clone() }
    }

    /// The bytes of a buffer that is a source, a copy of one or a file, and where they come from.
    pub(super) fn supplied_bytes(
        &self,
        buffer: &Buffer,
        found: &mut Vec<Diagnostic>,
    ) -> Option<(checked::BufferSize, Origin)> {
        let source = buffer.source.as_ref().or(buffer.copy.as_ref())?;
        let size = || checked::BufferSize::Source(source.value.clone());
        if buffer.source.is_some() && source.value.starts_with(FILE) {
            let path = project_path(source, found)?;
            let read = self.catalog.file(&path, None);
            let contents = read.map_err(|refusal| found.push(refused(&refusal, source, None))).ok()?;
            return Some((size(), Origin::File(contents)));
        }
        if source.value == MICROPHONE {
            let message = format!("`{MICROPHONE}` supplies an image and no buffer");
            found.push(
                Diagnostic::error(codes::graph::WRONG_KIND, message)
                    .label(source.span.clone(), "a buffer is needed here")
                    .help(format!("declare it in `[targets.{}]`", buffer.name.value)),
            );
            return None;
        }
        let Some(known) = self.catalog.source(&source.value) else {
            let names = self.catalog.sources().iter().map(|source| source.name.as_str());
            found.push(unknown(codes::graph::UNKNOWN_SOURCE, "source", &source.value, &source.span, names));
            return None;
        };
        match (known.collected, &buffer.copy) {
            (Some(bytes), None) => Some((checked::BufferSize::Bytes(bytes), Origin::Collected(known.name))),
            (Some(_), Some(copy)) => {
                let message = format!("`{}` is written by passes, so there is nothing to copy", copy.value);
                found.push(
                    Diagnostic::error(codes::graph::WRONG_KIND, message)
                        .label(copy.span.clone(), "a source that passes read is needed here")
                        .help(format!("write `source = \"{}\"`", copy.value)),
                );
                None
            }
            (None, Some(_)) => Some((size(), Origin::Copy)),
            (None, None) => Some((size(), Origin::Source(known.access))),
        }
    }
}

/// The image of a source, or a copy of it, as a target.
pub(crate) fn supplied_image(
    name: String,
    source: &Spanned<String>,
    format: Format,
    display: Option<checked::Display>,
    origin: Origin,
) -> Declared<Resource> {
    let target = checked::Target { display, ..blank(format, source) };
    let item = Resource { origin, ..Resource::new(name, ResourceKind::Target(target), source.span.clone()) };
    Declared { item, sound: true, detail: source.span.clone() }
}

/// Nothing can be as large as the supply of a world: its extent is not known until it is there.
pub(super) fn extent_from_outside(name: &Spanned<String>, source: &Span) -> Diagnostic {
    let message = format!("`{}` comes from outside, and its extent cannot be used here", name.value);
    Diagnostic::error(codes::graph::WRONG_KIND, message)
        .label(name.span.clone(), "a target of this graph is needed")
        .label(source.clone(), "supplied by this source")
        .help("ask for its extent in the shader, with `textureSize` or `imageSize`")
}

/// Keys that only the texels of a file have.
pub(super) fn only_of_files(target: &Target, found: &mut Vec<Diagnostic>) {
    let slices = target.slices.as_ref().map(|slices| ("slices", &slices.span));
    let encoding = target.encoding.as_ref().map(|encoding| ("encoding", &encoding.span));
    for (key, place) in slices.into_iter().chain(encoding).filter(|_| !target.flawed) {
        let message = format!("target `{}` is from no file and takes no `{key}`", target.name.value);
        found.push(
            Diagnostic::error(codes::files::CONFLICTING_KEYS, message)
                .label(place.clone(), "of a file only")
                .help("name a file: `source = \"file.textures/NAME.png\"`"),
        );
    }
}

fn blank(format: Format, source: &Spanned<String>) -> checked::Target {
    checked::Target {
        format,
        extent: Extent::Source,
        source: Some(source.value.clone()),
        mips: 0,
        layers: 1,
        clear: None,
        init: None,
        display: None,
    }
}

fn shape(image: &raxel_graph::supply::FileImage, source: &Spanned<String>) -> checked::Target {
    let [width, height, _] = image.extent;
    let extent = if image.volume { Extent::Fixed3(image.extent) } else { Extent::Fixed2([width, height]) };
    checked::Target { extent, mips: index32(image.mips.len()), ..blank(image.format, source) }
}

/// Keys that repeat the source's own properties. Those of a file that this one extends are met here; those beside it in the same table are
/// reported already.
fn takes_none(target: &Target, source: &Spanned<String>, more: &[&str], found: &mut Vec<Diagnostic>) {
    if target.flawed {
        return;
    }
    let written = [
        ("size", target.size.as_ref().map(|value| &value.span)),
        ("layers", target.layers.as_ref().map(|value| &value.span)),
        ("history", target.history.as_ref().map(|value| &value.span)),
        ("clear", target.clear.as_ref().map(|value| &value.span)),
        ("init", target.init.as_ref().map(|value| &value.span)),
        ("keep", target.keep.as_ref().map(|value| &value.span)),
        ("clock", target.clock.as_ref().map(|value| &value.span)),
        ("format", target.format.as_ref().map(|value| &value.span)),
        ("mips", target.mips.as_ref().map(|value| &value.span)),
        ("slices", target.slices.as_ref().map(|value| &value.span)),
        ("encoding", target.encoding.as_ref().map(|value| &value.span)),
    ];
    let always = 7;
    for (index, (key, place)) in written.into_iter().enumerate() {
        if let Some(place) = place.filter(|_| index < always || more.contains(&key)) {
            let message = format!("target `{}` comes from outside and takes no `{key}`", target.name.value);
            let error = Diagnostic::error(codes::files::CONFLICTING_KEYS, message);
            found.push(error.label(place.clone(), "this one").label(source.span.clone(), "and this one"));
        }
    }
}

/// The path of a file in the project.
fn project_path(source: &Spanned<String>, found: &mut Vec<Diagnostic>) -> Option<String> {
    let text = source.value.strip_prefix(FILE).unwrap_or_default();
    let path = join("", text);
    if path.is_none() {
        found.push(
            Diagnostic::error(codes::files::OUTSIDE_ROOT, format!("`{text}` is not a path inside the project"))
                .label(source.span.clone(), "relative to the project's folder, with `/` between names"),
        );
    }
    path
}

fn refused(refusal: &Refusal, source: &Spanned<String>, target: Option<&Target>) -> Diagnostic {
    let key = target.and_then(|target| match refusal.key {
        "format" => target.format.as_ref().map(|value| &value.span),
        "mips" => target.mips.as_ref().map(|value| &value.span),
        "slices" => target.slices.as_ref().map(|value| &value.span),
        "encoding" => target.encoding.as_ref().map(|value| &value.span),
        _ => None,
    });
    let diagnostic = Diagnostic::error(refusal.code, refusal.message.clone());
    let diagnostic = match key {
        Some(key) => {
            let whose = if source.value == MICROPHONE { "of the microphone" } else { "of this file" };
            diagnostic.label(key.clone(), "wanted here").label(source.span.clone(), whose)
        }
        None => diagnostic.label(source.span.clone(), "named here"),
    };
    match &refusal.help {
        Some(help) => diagnostic.help(help.clone()),
        None => diagnostic,
    }
}
