//! How a session shows a target as a picture.

use raxel_execute::display_of;
use raxel_graph::checked::{Display, DisplayMap, ResourceKind};
use raxel_runtime::Session;

/// The maps by the names of the graph language.
pub const MAPS: [(&str, DisplayMap); 8] = [
    ("color", DisplayMap::Color),
    ("raw", DisplayMap::Raw),
    ("gray", DisplayMap::Gray),
    ("turbo", DisplayMap::Turbo),
    ("viridis", DisplayMap::Viridis),
    ("normal", DisplayMap::Normal),
    ("id", DisplayMap::Id),
    ("integer", DisplayMap::Integer),
];

/// The map of that name.
pub fn map_named(name: &str) -> Option<DisplayMap> {
    MAPS.iter().find(|(known, _)| *known == name).map(|(_, map)| *map)
}

/// The name of a map.
pub fn name_of(map: DisplayMap) -> &'static str {
    MAPS.iter().find(|(_, known)| *known == map).map_or("", |(name, _)| name)
}

/// The name of the resource that a session shows.
pub fn shown_resource(session: &Session) -> &str {
    let (graph, target) = (session.graph(), session.debug_target());
    if target.resource.is_empty() { &graph.resource(graph.present).name } else { &target.resource }
}

/// How the graph shows the shown target; `None` of a buffer.
pub fn of_graph(session: &Session) -> Option<Display> {
    let graph = session.graph();
    match &graph.resource(graph.find_resource(shown_resource(session))?).kind {
        ResourceKind::Target(target) => Some(display_of(target)),
        ResourceKind::Buffer(_) => None,
    }
}
