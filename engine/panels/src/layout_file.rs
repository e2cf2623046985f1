//! The layout of the panels as its file has it.

use egui::{Pos2, Rect, Vec2};
use egui_dock::{DockState, Node, NodeIndex, Surface, Tree};
use serde::{Deserialize, Serialize};

use crate::layout::{Layout, Panel};

/// The contents of a tab.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Tab {
    /// The picture: there is always one.
    Picture,
    #[serde(untagged)]
    Panel(Panel),
}

/// The file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct File {
    visible: bool,
    zoom: f32,
    timeline: bool,
    beside: bool,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    floating: Vec<Floating>,
    docks: Area,
}

/// A part of the window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", untagged)]
enum Area {
    /// Tabs. One is in front.
    Tabs {
        tabs: Vec<Tab>,
        #[serde(default)]
        front: usize,
    },
    /// Two parts, one beside the other.
    Across { across: Across },
    /// Two parts, one above the other.
    Down { down: Down },
}

/// The share of the left part, and both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Across {
    share: f32,
    left: Box<Area>,
    right: Box<Area>,
}

/// The share of the upper part, and both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Down {
    share: f32,
    top: Box<Area>,
    bottom: Box<Area>,
}

/// A window over the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Floating {
    /// Points from the top left of the window.
    at: [f32; 2],
    /// Points.
    size: [f32; 2],
    docks: Area,
}

impl Default for File {
    fn default() -> Self {
        Self::of(&Layout::default())
    }
}

impl File {
    /// The stored form of a layout.
    pub(crate) fn of(layout: &Layout) -> Self {
        let docks = area(layout.docks.main_surface(), NodeIndex::root()).unwrap_or_else(Area::picture);
        let floating = layout.docks.iter_surfaces().enumerate().filter_map(|(index, surface)| match surface {
            Surface::Window(tree, state) => {
                // One that was not drawn yet is where it is to be.
                let wanted = layout.windows.iter().find(|(surface, _)| surface.0 == index).map(|(_, rect)| *rect);
                let rect = if state.rect().is_finite() { state.rect() } else { wanted.unwrap_or(Rect::ZERO) };
                let [at, size] = [rect.min.to_vec2(), rect.size()].map(|vec| [vec.x.round(), vec.y.round()]);
                Some(Floating { at, size, docks: area(tree, NodeIndex::root())? })
            }
            Surface::Empty | Surface::Main(_) => None,
        });
        let Layout { visible, zoom, timeline, beside, .. } = *layout;
        Self { visible, zoom, timeline, beside, floating: floating.collect(), docks }
    }

    /// The layout. An impossible part is left out: a panel that is there twice, a size that is no number.
    pub(crate) fn layout(mut self) -> Layout {
        let mut seen = Vec::new();
        self.docks.keep_once(&mut seen);
        self.floating.iter_mut().for_each(|window| {
            window.docks.keep_once(&mut seen);
            window.docks.drop_picture();
        });
        if !self.docks.has_picture() {
            let (left, right) =
                (Box::new(std::mem::replace(&mut self.docks, Area::picture())), Box::new(Area::picture()));
            self.docks = if left.is_empty() {
                Area::picture()
            } else {
                Area::Across { across: Across { share: 0.3, left, right } }
            };
        }
        let zoom = if self.zoom.is_finite() { self.zoom.clamp(0.5, 4.0) } else { 1.0 };
        let File { visible, timeline, beside, .. } = self;
        let mut layout = Layout { visible, zoom, timeline, beside, ..Layout::empty() };
        self.docks.build(&mut layout.docks, None);
        for Floating { at, size, docks } in self.floating.iter().filter(|window| !window.docks.is_empty()) {
            let number = |number: f32, low, high| if number.is_finite() { number.clamp(low, high) } else { low };
            let (at, size) = (at.map(|at| number(at, 0.0, 1e4)), size.map(|size| number(size, 80.0, 4000.0)));
            let window = docks.build(&mut layout.docks, Some(docks.first()));
            let rect = Rect::from_min_size(Pos2::from(at), Vec2::from(size));
            if let Some(state) = layout.docks.get_window_state_mut(window) {
                state.set_position(rect.min).set_size(rect.size());
            }
            layout.windows.push((window, rect));
        }
        layout
    }
}

/// The stored form of a node of a tree.
fn area(tree: &Tree<Tab>, node: NodeIndex) -> Option<Area> {
    if node.0 >= tree.len() {
        return None;
    }
    let share = |fraction: f32| (fraction * 1000.0).round() / 1000.0;
    match &tree[node] {
        Node::Empty => None,
        Node::Leaf(leaf) => Some(Area::Tabs { tabs: leaf.tabs.clone(), front: leaf.active.0 }),
        Node::Horizontal(split) => {
            let (left, right) = (Box::new(area(tree, node.left())?), Box::new(area(tree, node.right())?));
            Some(Area::Across { across: Across { share: share(split.fraction), left, right } })
        }
        Node::Vertical(split) => {
            let (top, bottom) = (Box::new(area(tree, node.left())?), Box::new(area(tree, node.right())?));
            Some(Area::Down { down: Down { share: share(split.fraction), top, bottom } })
        }
    }
}

impl Area {
    fn picture() -> Self {
        Self::Tabs { tabs: vec![Tab::Picture], front: 0 }
    }

    /// Both parts of an area that has parts.
    fn parts(&self) -> Option<(&Area, &Area)> {
        match self {
            Area::Tabs { .. } => None,
            Area::Across { across: Across { left, right, .. } } => Some((left, right)),
            Area::Down { down: Down { top, bottom, .. } } => Some((top, bottom)),
        }
    }

    /// All tabs, in order.
    fn tabs(&self) -> Vec<Tab> {
        match (self, self.parts()) {
            (Area::Tabs { tabs, .. }, _) => tabs.clone(),
            (_, Some((first, second))) => [first.tabs(), second.tabs()].concat(),
            (_, None) => Vec::new(),
        }
    }

    fn has_picture(&self) -> bool {
        self.tabs().contains(&Tab::Picture)
    }

    fn is_empty(&self) -> bool {
        self.tabs().is_empty()
    }

    fn drop_picture(&mut self) {
        self.retain(&mut |tab| *tab != Tab::Picture);
    }

    /// Leaves out what was seen before, and parts without a tab.
    fn keep_once(&mut self, seen: &mut Vec<Tab>) {
        self.retain(&mut |tab| {
            let new = !seen.contains(tab);
            seen.push(*tab);
            new
        });
    }

    /// Leaves tabs out, and then parts without a tab.
    fn retain(&mut self, keep: &mut dyn FnMut(&Tab) -> bool) {
        let parts = match self {
            Area::Tabs { tabs, front } => {
                tabs.retain(keep);
                *front = (*front).min(tabs.len().saturating_sub(1));
                return;
            }
            Area::Across { across: Across { left, right, .. } } => [left, right],
            Area::Down { down: Down { top, bottom, .. } } => [top, bottom],
        };
        let mut left = Vec::new();
        for part in parts {
            part.retain(keep);
            if !part.is_empty() {
                left.push(part.clone());
            }
        }
        if left.len() < 2 {
            *self = left.pop().map_or(Area::Tabs { tabs: Vec::new(), front: 0 }, |part| *part);
        }
    }

    /// The tabs of its first leaf.
    fn first(&self) -> Vec<Tab> {
        match (self, self.parts()) {
            (_, Some((first, _))) => first.first(),
            (Area::Tabs { tabs, .. }, None) => tabs.clone(),
            (_, None) => Vec::new(),
        }
    }

    /// Builds it in place of the main surface, or in a new window.
    fn build(&self, docks: &mut DockState<Tab>, window: Option<Vec<Tab>>) -> egui_dock::SurfaceIndex {
        let surface = if let Some(tabs) = window {
            docks.add_window(tabs)
        } else {
            *docks.main_surface_mut() = Tree::new(self.first());
            egui_dock::SurfaceIndex::main()
        };
        self.fill(&mut docks[surface], NodeIndex::root());
        surface
    }

    /// Splits a leaf, which has the tabs of the first leaf.
    fn fill(&self, tree: &mut Tree<Tab>, node: NodeIndex) {
        let share = |share: f32| if share.is_finite() { share.clamp(0.05, 0.95) } else { 0.5 };
        let (first, second, nodes) = match self {
            Area::Tabs { front, .. } => {
                if let Some(leaf) = tree[node].get_leaf_mut() {
                    leaf.active = (*front).into();
                }
                return;
            }
            Area::Across { across: Across { share: wanted, left, right } } => {
                (left, right, tree.split_right(node, share(*wanted), right.first()))
            }
            Area::Down { down: Down { share: wanted, top, bottom } } => {
                (top, bottom, tree.split_below(node, share(*wanted), bottom.first()))
            }
        };
        first.fill(tree, nodes[0]);
        second.fill(tree, nodes[1]);
    }
}
