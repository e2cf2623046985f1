//! Names of sources, as graphs write them.

use std::fmt;

use raxel_world::layout::Layout;

/// The name of a source.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SourceName {
    /// `world.<layout>`: the session's world in a layout.
    World(Layout),
}

impl SourceName {
    /// The source that a word of a graph names.
    pub fn parse(text: &str) -> Option<Self> {
        let (kind, rest) = text.split_once('.')?;
        match kind {
            "world" => Layout::from_name(rest).map(Self::World),
            _ => None,
        }
    }

    /// The layout of the session's world, if that is what it names.
    pub fn world_layout(text: &str) -> Option<Layout> {
        Self::parse(text).map(|Self::World(layout)| layout)
    }
}

impl fmt::Display for SourceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::World(layout) => write!(f, "world.{}", layout.name()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for layout in Layout::ALL {
            let name = SourceName::World(*layout);
            assert_eq!(SourceName::parse(&name.to_string()), Some(name));
        }
        for wrong in ["", "world", "world.", "world.tree", "tree64", "worlds.tree64"] {
            assert_eq!(SourceName::parse(wrong), None, "{wrong}");
        }
    }
}
