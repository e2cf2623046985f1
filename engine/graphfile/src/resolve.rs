//! Phase 3, resolve: names become indices, words become types, literals become values. Mistakes that show without a shader are reported
//! here. A wrong part gets a stand-in and `sound: false`, so that later phases can continue and report further mistakes. A graph with an
//! error is never handed on.

mod clears;
mod conditions;
mod displays;
mod loops;
mod params;
mod passes;
mod resources;
mod supplied;
mod values;

pub(crate) use conditions::{FACTS, KnownFact};
pub(crate) use supplied::supplied_image;

use std::cell::RefCell;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Code, Diagnostic, Span, Spanned, codes};
use raxel_graph::ValueType;
use raxel_graph::checked::{self, ClockId, Condition, Every, LoopId, ParamId, ResourceId, RoundIndex};
use raxel_graph::index32;
use raxel_graph::supply::Catalog;
use raxel_shader::Request;

use crate::extends::Loaded;
use crate::model::{self, File, Fills, Literal, Mip};
use crate::queues::Queue;

/// A graph whose names are resolved.
#[derive(Clone, Debug)]
pub(crate) struct Resolved {
    /// `name`.
    pub name: String,
    /// `about`.
    pub about: String,
    /// `present` and its place; `None` when it is missing or unknown.
    pub present: Option<Spanned<ResourceId>>,
    /// In the order of the model.
    pub params: Vec<Declared<checked::Param>>,
    /// In the order of the model.
    pub clocks: Vec<Declared<checked::Clock>>,
    /// Targets, then buffers, each in the order of the model.
    pub resources: Vec<Declared<checked::Resource>>,
    /// The values of `[blocks.*]`.
    pub blocks: Vec<Fills<Member>>,
    /// In the order of the model.
    pub loops: Vec<Loop>,
    /// In program order.
    pub passes: Vec<Pass>,
    /// Every mention of a material of the world.
    pub materials: Vec<checked::Material>,
    /// The graph's files.
    pub files: Vec<String>,
}

/// Something declared in the file. When it is not `sound`, parts of it are stand-ins for parts with reported mistakes.
#[derive(Clone, Debug)]
pub(crate) struct Declared<T> {
    /// The thing.
    pub item: T,
    /// Whether all of it is meant.
    pub sound: bool,
    /// Where its main property is written (a target's format, a buffer's size or source, a param's type), else where its name is.
    pub detail: Span,
}

/// A loop whose names are resolved.
#[derive(Clone, Debug)]
pub(crate) struct Loop {
    /// The loop; a single round where its count is missing or wrong.
    pub item: checked::Loop,
    /// Where its count is written, else where its name is.
    pub count: Span,
    /// Whether all of it is meant.
    pub sound: bool,
}

/// A pass whose names are resolved.
#[derive(Clone, Debug)]
pub(crate) struct Pass {
    /// Its name.
    pub name: Spanned<String>,
    /// The compiler's request, at the place of `shader`; `None` when that is missing or wrong.
    pub request: Option<Spanned<Request>>,
    /// `None` when it is missing or wrong. That of a queue is indirect, from a buffer that is made for it.
    pub dispatch: Option<Spanned<checked::Dispatch>>,
    /// The queue that is dispatched.
    pub queue: Option<Queue>,
    /// The mip that the dispatch covers, where the round decides it.
    pub dispatch_mip: Option<Spanned<RoundIndex>>,
    /// `loop`; `None` when it is missing or unknown.
    pub in_loop: Option<Spanned<LoopId>>,
    /// Whether it has a `loop`, known or unknown.
    pub(crate) names_loop: bool,
    /// The entries of `bind`.
    pub bind: Vec<Bind>,
    /// The push-constant values.
    pub push: Option<Fills<Member>>,
    /// The uniform blocks.
    pub uniforms: Vec<Fills<Member>>,
    /// Constants by name; `None` where the value is unknown.
    pub specialization: Vec<(Spanned<String>, Option<Spanned<Feed>>)>,
    /// `subgroup`.
    pub subgroup_size: Option<u32>,
    /// `when`, and the conditions of the buffers that it binds or leaves out.
    pub when: Vec<Condition>,
    /// `every`.
    pub every: Option<Every>,
    /// Whether the file's entries are all known, so that an absent one is meant to be absent.
    pub sound: bool,
}

/// A GLSL name bound to a resource.
#[derive(Clone, Debug)]
pub(crate) struct Bind {
    /// The GLSL name.
    pub name: Spanned<String>,
    /// The resource and its age, `None` when there is no such resource or age.
    pub target: Option<Spanned<(ResourceId, u32)>>,
    /// `mip`.
    pub mip: Option<Spanned<Mip>>,
    /// `layer`.
    pub layer: Option<Spanned<u32>>,
    /// `filter`: linear, else nearest.
    pub linear: Option<Spanned<bool>>,
    /// `wrap`: repeat, else clamp.
    pub repeat: Option<Spanned<bool>>,
    /// `partial = true`: stores only some of the texels that are read later.
    pub partial: Option<Spanned<()>>,
}

/// The value of a member.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    /// Path in the block.
    pub path: Spanned<String>,
    /// The type that the file declares; with a number of elements for an array.
    pub ty: Option<Spanned<(ValueType, Option<u32>)>>,
    /// `None` when it is missing or unknown.
    pub feed: Option<Spanned<Feed>>,
    /// The offset that the file declares, in bytes.
    pub offset: Option<Spanned<u32>>,
}

/// Where the value of a member comes from.
#[derive(Clone, Debug)]
pub(crate) enum Feed {
    /// A param, a builtin or an extent, with its type.
    From(checked::ValueOrigin, ValueType),
    /// Written in the file; its type is the member's.
    Literal(Literal),
}

/// Names with their indices.
type Names = HashMap<String, u32>;

/// Resolves every name of a model. `sources` are the buffer sources that the runtime can supply.
pub(crate) fn resolve(loaded: Loaded, sources: &dyn Catalog, found: &mut Vec<Diagnostic>) -> Resolved {
    let Loaded { model, files } = loaded;
    let start = Span::new(model.path.clone(), 0..0);
    // Names first: a resource may be mentioned before it is declared.
    let param_names = declare("param", model.params.iter().map(|param| &param.name), found);
    let clock_names = declare("clock", model.clocks.iter().map(|clock| &clock.name), found);
    let targets = model.targets.iter().map(|target| &target.name);
    let resource_names =
        declare("target or buffer", targets.chain(model.buffers.iter().map(|buffer| &buffer.name)), found);
    let nameless = |pass: &&model::Pass| pass.flawed && pass.name.value.is_empty();
    check_names("pass", model.passes.iter().filter(|pass| !nameless(pass)).map(|pass| &pass.name), found);

    let name = name(&model, &start, found);
    let about = model.about.as_ref().map(|about| about.value.clone()).unwrap_or_default();
    let params = model.params.iter().map(|param| params::param(param, found)).collect::<Vec<_>>();
    let clocks = model.clocks.iter().map(|declared| clock(declared, found)).collect::<Vec<_>>();
    let mut resources = resources::resources(&model, &resource_names, &clock_names, sources, found);
    // The cases of a pass share its arguments: a plan has one of them.
    let mut arguments = HashMap::new();
    for pass in &model.passes {
        if let (Some(buffer), Entry::Vacant(vacant)) =
            (resources::arguments(pass), arguments.entry(pass.name.value.as_str()))
        {
            vacant.insert(ResourceId(index32(resources.len())));
            resources.push(buffer);
        }
    }
    let loop_names = declare("loop", model.loops.iter().map(|repeated| &repeated.name), found);
    let scope = Scope {
        params: &params,
        param_names: &param_names,
        clock_names: &clock_names,
        resources: &resources,
        names: &resource_names,
        loop_names: &loop_names,
        materials: RefCell::default(),
    };
    let loops = model.loops.iter().map(|repeated| loops::loop_(repeated, &scope, found)).collect();
    check_names("block", model.blocks.iter().map(|block| &block.fills.name), found);
    let blocks = model.blocks.iter().map(|block| values::fills(&block.fills, &scope, found)).collect();
    let of = |pass: &model::Pass| arguments.get(pass.name.value.as_str()).copied();
    let passes = model.passes.iter().map(|pass| passes::pass(pass, &scope, of(pass), found)).collect();
    let present = present(&model, &scope, &start, found);
    let materials = scope.materials.into_inner();
    Resolved { name, about, present, params, clocks, resources, blocks, loops, passes, materials, files }
}

/// The names that a pass can use.
struct Scope<'a> {
    params: &'a [Declared<checked::Param>],
    param_names: &'a Names,
    clock_names: &'a Names,
    resources: &'a [Declared<checked::Resource>],
    names: &'a Names,
    loop_names: &'a Names,
    /// Mentions of materials, collected.
    materials: RefCell<Vec<checked::Material>>,
}

impl Scope<'_> {
    fn param(&self, name: &str, place: &Span, found: &mut Vec<Diagnostic>) -> Option<ParamId> {
        if let Some(id) = self.param_names.get(name) {
            return Some(ParamId(*id));
        }
        let known = self.param_names.keys().map(String::as_str);
        found.push(unknown(codes::graph::UNKNOWN_PARAM, "param", name, place, known));
        None
    }

    fn clock(&self, name: &str, place: &Span, found: &mut Vec<Diagnostic>) -> Option<ClockId> {
        clock_id(self.clock_names, name, place, found)
    }

    fn resource(&self, name: &str, place: &Span, found: &mut Vec<Diagnostic>) -> Option<ResourceId> {
        resource(self.names, name, place, found)
    }
}

fn clock_id(names: &Names, name: &str, place: &Span, found: &mut Vec<Diagnostic>) -> Option<ClockId> {
    if let Some(id) = names.get(name) {
        return Some(ClockId(*id));
    }
    let known = names.keys().map(String::as_str);
    found.push(unknown(codes::graph::UNKNOWN_CLOCK, "clock", name, place, known));
    None
}

/// `[clocks.NAME]`; a clock without `most` catches up four ticks.
fn clock(clock: &model::Clock, found: &mut Vec<Diagnostic>) -> Declared<checked::Clock> {
    let name = &clock.name;
    if clock.hz.is_none() && !clock.flawed {
        let whose = format!("`clocks.{}`", name.value);
        found.push(missing(&whose, "hz", &name.span).help("the number of ticks a second, e.g. `hz = 60`"));
    }
    let item = checked::Clock {
        name: name.value.clone(),
        hz: clock.hz.as_ref().map_or(1.0, |hz| hz.value),
        most: clock.most.as_ref().map_or(4, |most| most.value),
        place: name.span.clone(),
    };
    let detail = clock.hz.as_ref().map_or(&name.span, |hz| &hz.span).clone();
    Declared { item, sound: clock.hz.is_some() && !clock.flawed, detail }
}

fn resource(names: &Names, name: &str, place: &Span, found: &mut Vec<Diagnostic>) -> Option<ResourceId> {
    if let Some(id) = names.get(name) {
        return Some(ResourceId(*id));
    }
    let known = names.keys().map(String::as_str);
    found.push(unknown(codes::graph::UNKNOWN_RESOURCE, "target or buffer", name, place, known));
    None
}

/// A name that nothing has, with the closest that something has, or all of them if they are few.
fn unknown<'n>(code: Code, what: &str, name: &str, place: &Span, known: impl Iterator<Item = &'n str>) -> Diagnostic {
    let mut known: Vec<&str> = known.collect();
    known.sort_unstable();
    let diagnostic =
        Diagnostic::error(code, format!("there is no {what} `{name}`")).label(place.clone(), format!("no such {what}"));
    match closest(name, known.iter().copied()) {
        Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
        None if known.is_empty() => diagnostic.help(format!("the graph declares no {what}")),
        None if known.len() <= 16 => diagnostic.help(format!("there is {}", list(known.into_iter()))),
        None => diagnostic,
    }
}

/// Numbers names in their order; reports those that are given twice or are malformed.
fn declare<'m>(
    what: &str,
    names: impl Iterator<Item = &'m Spanned<String>> + Clone,
    found: &mut Vec<Diagnostic>,
) -> Names {
    check_names(what, names.clone(), found);
    let mut first: HashMap<String, (u32, &Span)> = HashMap::new();
    for (index, name) in names.enumerate() {
        if let Some((_, earlier)) = first.get(&name.value) {
            found.push(
                Diagnostic::error(codes::graph::DUPLICATE_NAME, format!("two things are called `{}`", name.value))
                    .label(name.span.clone(), format!("this {what} has the name of another"))
                    .label((*earlier).clone(), "the first one"),
            );
            continue;
        }
        first.insert(name.value.clone(), (index32(index), &name.span));
    }
    first.into_iter().map(|(name, (index, _))| (name, index)).collect()
}

fn check_names<'m>(what: &str, names: impl Iterator<Item = &'m Spanned<String>>, found: &mut Vec<Diagnostic>) {
    for name in names {
        if !is_name(&name.value) {
            found.push(
                Diagnostic::error(codes::graph::BAD_NAME, format!("`{}` cannot be the name of a {what}", name.value))
                    .label(name.span.clone(), "")
                    .help("a name has 1 to 64 letters, digits, `_` and `-`"),
            );
        }
    }
}

fn is_name(name: &str) -> bool {
    (1..=64).contains(&name.len()) && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-')
}

fn name(model: &File, start: &Span, found: &mut Vec<Diagnostic>) -> String {
    if let Some(name) = &model.name {
        return name.value.clone();
    }
    if !is_misspelt(model, "name") {
        found.push(missing("the file", "name", start));
    }
    String::new()
}

/// Whether a key of the file is there under a wrong name.
fn is_misspelt(model: &File, key: &str) -> bool {
    model.misspelt.iter().any(|meant| meant == key)
}

/// The diagnostic for a key that must be there.
fn missing(whose: &str, key: &str, place: &Span) -> Diagnostic {
    Diagnostic::error(codes::files::MISSING_KEY, format!("{whose} needs the key `{key}`"))
        .label(place.clone(), "missing here")
}

fn present(model: &File, scope: &Scope<'_>, start: &Span, found: &mut Vec<Diagnostic>) -> Option<Spanned<ResourceId>> {
    let Some(present) = &model.present else {
        if !is_misspelt(model, "present") {
            found.push(missing("the file", "present", start).help("name the target that is shown by default"));
        }
        return None;
    };
    let (name, age) = age(&present.value);
    let id = scope.resource(name, &present.span, found)?;
    if age != Some(0) {
        found.push(
            Diagnostic::error(codes::graph::HISTORY, format!("`present` is `{}`, an earlier frame", present.value))
                .label(present.span.clone(), "")
                .help(format!("present `{name}`; earlier frames of it can be chosen while it runs")),
        );
        return None;
    }
    Some(Spanned::new(id, present.span.clone()))
}

/// Splits `color@1` into name and age. The age is `None` when it is no number of at least 1.
fn age(reference: &str) -> (&str, Option<u32>) {
    match reference.split_once('@') {
        None => (reference, Some(0)),
        Some((name, age)) => (name, age.parse().ok().filter(|age| *age >= 1)),
    }
}
