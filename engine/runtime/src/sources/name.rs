//! Names of sources, as graphs write them.

use std::fmt;

use raxel_layouts::Layout;

/// The name of a source that a session supplies.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SourceName {
    /// `world.<layout>`: the session's world.
    World(Layout),
    /// `model.<name>.<layout>`: a model of the world's file.
    Model(String, Layout),
    /// `world.lights`: the faces of the session's world that give off light.
    Lights,
    /// `world.instances`: the models that stand in the session's world.
    Instances,
    /// `input.keys`: the keys that are held.
    Keys,
}

impl SourceName {
    /// The source that a word of a graph names.
    pub fn parse(text: &str) -> Option<Self> {
        match text.split_once('.')? {
            ("world", "lights") => Some(Self::Lights),
            ("world", "instances") => Some(Self::Instances),
            ("world", layout) => raxel_rivals::layout(layout).map(Self::World),
            ("input", "keys") => Some(Self::Keys),
            ("model", rest) => {
                let (name, layout) = rest.rsplit_once('.')?;
                raxel_rivals::layout(layout)
                    .filter(|_| !name.is_empty())
                    .map(|layout| Self::Model(name.to_owned(), layout))
            }
            _ => None,
        }
    }

    /// The layout of the session's world, if it names one.
    pub fn world_layout(text: &str) -> Option<Layout> {
        match Self::parse(text)? {
            Self::World(layout) => Some(layout),
            Self::Model(..) | Self::Lights | Self::Instances | Self::Keys => None,
        }
    }

    /// Whether it needs a world.
    pub(crate) fn is_of_world(&self) -> bool {
        *self != Self::Keys
    }

    /// The layout of the voxels, if it has some.
    pub fn layout(&self) -> Option<Layout> {
        match self {
            Self::World(layout) | Self::Model(_, layout) => Some(*layout),
            Self::Lights | Self::Instances | Self::Keys => None,
        }
    }
}

impl fmt::Display for SourceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::World(layout) => write!(f, "world.{}", layout.name()),
            Self::Model(name, layout) => write!(f, "model.{name}.{}", layout.name()),
            Self::Lights => f.write_str("world.lights"),
            Self::Instances => f.write_str("world.instances"),
            Self::Keys => f.write_str("input.keys"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for layout in raxel_rivals::LAYOUTS {
            for name in [SourceName::World(*layout), SourceName::Model("old.pine".to_owned(), *layout)] {
                assert_eq!(SourceName::parse(&name.to_string()), Some(name.clone()));
                assert_eq!(name.layout(), Some(*layout));
            }
        }
        assert_eq!(SourceName::parse("world.lights"), Some(SourceName::Lights));
        assert_eq!((SourceName::Lights.to_string().as_str(), SourceName::Lights.layout()), ("world.lights", None));
        assert_eq!(SourceName::parse("world.instances"), Some(SourceName::Instances));
        assert_eq!(
            (SourceName::parse("input.keys"), SourceName::Keys.to_string().as_str()),
            (Some(SourceName::Keys), "input.keys")
        );
        for wrong in ["", "world", "world.", "world.tree", "tree64", "worlds.tree64", "model.tree64", "model..tree64"] {
            assert_eq!(SourceName::parse(wrong), None, "{wrong}");
        }
    }
}
