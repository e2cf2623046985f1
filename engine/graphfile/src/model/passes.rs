//! What passes say in tables of their own: bindings and rhythms.

use raxel_diagnostics::{Spanned, codes};
use raxel_graph::checked::{MOST_STILL, RoundIndex};
use raxel_language::Keys;

use crate::parse::{RATES, needs_target, rate};
use crate::schema::reference;

/// A resource with its view.
#[derive(Clone, Debug, Keys)]
#[keys(layer("binding", unknown = codes::graph::NOTHING_TO_OVERLAY, whole), check = needs_target(remove, target))]
pub struct Bind {
    /// The key: the GLSL name.
    #[keys(entry)]
    pub name: Spanned<String>,
    /// Takes it out of the pass of the graph that `extends` names.
    #[keys(remove, shape = reference("remove"))]
    pub remove: bool,
    /// The resource: needed.
    ///
    /// With its age, e.g. `color@1`. `None` with `remove`.
    pub target: Option<Spanned<String>>,
    /// The mip, from 0. A storage image is one (0 when left out), a sampled image all of them.
    pub mip: Option<Spanned<Mip>>,
    /// One layer of many, from 0, as a plain 2-D image; all of them when left out.
    #[keys(range = 0..=65_535)]
    pub layer: Option<Spanned<u32>>,
    /// Filter of a sampled image.
    #[keys(told = Filter::Nearest)]
    pub filter: Option<Spanned<Filter>>,
    /// What lies beyond the edge of a sampled image.
    #[keys(told = Wrap::Clamp)]
    pub wrap: Option<Spanned<Wrap>>,
    /// The shader stores only some of the texels (or bytes) that are read later: what was there before shows through. Without it, a
    /// `writeonly` binding is taken to store all of them.
    #[keys(told = false)]
    pub partial: Option<Spanned<bool>>,
}

/// A mip as the file names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mip {
    /// A number.
    Level(u32),
    /// Another one in each round of a loop: `"loop.index"`, `"loop.next"`.
    Round(RoundIndex),
}

/// `filter` of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub enum Filter {
    /// The closest texel.
    Nearest,
    /// A mix of the texels around.
    Linear,
}

/// `wrap` of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Keys)]
pub enum Wrap {
    /// The texel at the edge.
    Clamp,
    /// The image again.
    Repeat,
}

/// `every` as a table, which has one of these keys.
#[derive(Keys)]
pub struct Rhythm {
    /// Times a second: needed in this form.
    #[keys(read = rate, range = RATES, excludes("frames", "still", why = "a pass has one rhythm"))]
    pub hz: Option<f64>,
    /// Runs in frames whose index this divides: needed in this form.
    #[keys(range = 1..=u32::MAX, excludes("still", why = "a pass has one rhythm"))]
    pub frames: Option<u32>,
    /// Runs while `frame.still`, a number of frames, is less than this: needed in this form.
    #[keys(range = 1..=MOST_STILL)]
    pub still: Option<u32>,
}
