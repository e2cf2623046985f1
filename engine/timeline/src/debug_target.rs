//! Which resource is shown, as text: `depth`, `color@1`, `pyramid,mip=2`, `cascades,layer=3`, `color,after=sky`.
//!
//! A colon may stand for a comma. `--target`, demos and `Session::set_debug_target_text` use this text.

use std::fmt;

use raxel_graph::checked::{Graph, PassId, ResourceKind};
use raxel_graph::plan::Present;

use crate::params::SetError;

/// A debug target by name. It stays valid over reloads.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct DebugTarget {
    /// Name of a target or a buffer. Empty: the target that the graph presents.
    pub resource: String,
    /// How many frames ago: 0 is this frame.
    pub age: u32,
    /// Mip, from 0.
    pub mip: u32,
    /// Layer, or slice of a 3-D target, from 0.
    pub layer: u32,
    /// The pass after which the resource is shown; `None` is the end of the frame. For a pass in a loop, `blur` means its last round, and
    /// `blur[2]` the round with `loop.index` 2.
    pub after: Option<String>,
}

/// Why a debug target cannot be shown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DebugTargetError {
    /// It does not read as one.
    #[error(
        "`{text}` is not a debug target: {why}; write NAME, NAME@AGE, and after it any of `,mip=N` `,layer=N` `,after=PASS`"
    )]
    Syntax {
        /// The text.
        text: String,
        /// The mistake in the text.
        why: String,
    },
    /// A name that the graph does not have.
    #[error(transparent)]
    Unknown(#[from] SetError),
    /// The resource has fewer mips, layers or frames of history.
    #[error("`{resource}` has {has} {what}; there is no {what_one} {asked}")]
    OutOfRange {
        /// The resource.
        resource: String,
        /// `mips`, `layers`, `frames of history`.
        what: &'static str,
        /// `mip`, `layer`, `frame`.
        what_one: &'static str,
        /// How many the resource has.
        has: u32,
        /// The number that was asked for.
        asked: u32,
    },
}

impl DebugTarget {
    /// A resource at the end of the frame.
    pub fn resource(name: impl Into<String>) -> Self {
        Self { resource: name.into(), ..Self::default() }
    }

    /// Reads a debug target from its text.
    pub fn parse(text: &str) -> Result<Self, DebugTargetError> {
        let wrong = |why: String| DebugTargetError::Syntax { text: text.to_owned(), why };
        let mut parts = text.split([',', ':']).map(str::trim);
        let head = parts.next().unwrap_or_default();
        let (name, age) = match head.split_once('@') {
            None => (head, 0),
            Some((name, age)) => (name, age.parse().map_err(|_| wrong(format!("`{age}` is not a number of frames")))?),
        };
        if name.is_empty() {
            return Err(wrong("it names no resource".to_owned()));
        }
        let mut target = Self { age, ..Self::resource(name) };
        for part in parts {
            let (key, value) = part.split_once('=').ok_or_else(|| wrong(format!("`{part}` has no `=`")))?;
            let (key, value) = (key.trim(), value.trim());
            let number = || value.parse().map_err(|_| wrong(format!("`{value}` is not a number")));
            match key {
                "mip" => target.mip = number()?,
                "layer" => target.layer = number()?,
                "after" if !value.is_empty() => target.after = Some(value.to_owned()),
                _ => return Err(wrong(format!("`{part}` is none of `mip=N`, `layer=N`, `after=PASS`"))),
            }
        }
        Ok(target)
    }

    /// Finds the debug target in a graph.
    pub fn resolve(&self, graph: &Graph) -> Result<Present, DebugTargetError> {
        let resource = if self.resource.is_empty() {
            graph.present
        } else {
            graph.find_resource(&self.resource).ok_or_else(|| {
                SetError::unknown(
                    "target",
                    &self.resource,
                    graph.resources.iter().filter(|r| !r.made).map(|r| r.name.as_str()),
                )
            })?
        };
        let (after, round) = match &self.after {
            None => (None, None),
            Some(name) => {
                let found = graph.find_pass(name).map(|pass| (pass, None)).or_else(|| find_round(graph, name));
                let (pass, round) = found.ok_or_else(|| SetError::unknown("pass", name, graph.pass_names()))?;
                (Some(pass), round)
            }
        };
        let found = graph.resource(resource);
        let outside = |what, what_one, has, asked| {
            Err(DebugTargetError::OutOfRange { resource: found.name.clone(), what, what_one, has, asked })
        };
        if self.age > found.history {
            return outside("frames of history", "frame", found.history, self.age);
        }
        let (mips, layers) = match &found.kind {
            // A full chain and the slices of a volume depend on the extent; the plan knows.
            ResourceKind::Target(target) => {
                (if target.mips == 0 { u32::MAX } else { target.mips }, slices(target).unwrap_or(u32::MAX))
            }
            ResourceKind::Buffer(_) => (1, 1),
        };
        if self.mip >= mips {
            return outside("mips", "mip", mips, self.mip);
        }
        if self.layer >= layers {
            return outside("layers", "layer", layers, self.layer);
        }
        Ok(Present { resource, age: self.age, mip: self.mip, layer: self.layer, after, round })
    }
}

/// Layers of a target, when they are known without the extents of others.
fn slices(target: &raxel_graph::checked::Target) -> Option<u32> {
    use raxel_graph::checked::Extent;
    match target.extent {
        Extent::Output { .. } | Extent::Fixed2(_) => Some(target.layers.max(1)),
        Extent::Fixed3([_, _, depth]) => Some(depth),
        Extent::Of { .. } | Extent::World { .. } | Extent::Source => None,
    }
}

impl fmt::Display for DebugTarget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.resource)?;
        if self.age > 0 {
            write!(f, "@{}", self.age)?;
        }
        if self.mip > 0 {
            write!(f, ",mip={}", self.mip)?;
        }
        if self.layer > 0 {
            write!(f, ",layer={}", self.layer)?;
        }
        match &self.after {
            Some(pass) => write!(f, ",after={pass}"),
            None => Ok(()),
        }
    }
}

/// The pass of a loop and its round in `blur[2]`.
fn find_round(graph: &Graph, name: &str) -> Option<(PassId, Option<u32>)> {
    let (pass, index) = name.strip_suffix(']')?.split_once('[')?;
    let pass = graph.find_pass(pass).filter(|&pass| graph.pass(pass).in_loop.is_some())?;
    Some((pass, Some(index.parse().ok()?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colon_does_for_a_comma() {
        assert_eq!(DebugTarget::parse("pyramid:mip=2:after=sky"), DebugTarget::parse("pyramid,mip=2,after=sky"));
    }

    #[test]
    fn reads_what_it_writes() {
        for text in ["depth", "color@1", "pyramid,mip=2", "cascades@2,mip=1,layer=3,after=sky"] {
            assert_eq!(DebugTarget::parse(text).unwrap().to_string(), text);
        }
        assert_eq!(DebugTarget::parse("a , after = b").unwrap().after.as_deref(), Some("b"));
    }

    #[test]
    fn says_what_is_wrong() {
        for text in ["", "@1", "a@b", "a,mip", "a,mip=x", "a,size=1", "a,after="] {
            assert!(matches!(DebugTarget::parse(text), Err(DebugTargetError::Syntax { .. })), "{text}");
        }
    }
}
