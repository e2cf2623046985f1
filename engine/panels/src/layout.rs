//! Which panels are open, where they are docked, and how large they are. Kept beside the project, never in its files.

use egui::Rect;
use egui_dock::{DockState, NodeIndex, SurfaceIndex, TabIndex};
use serde::{Deserialize, Serialize};

use crate::layout_file::{File, Tab};

/// A panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Panel {
    /// Order and times of the passes.
    Passes,
    /// Which pass touches which resource.
    Resources,
    /// Passes and resources as nodes.
    Graph,
    /// Live values.
    Params,
    /// The contents of the shown resource.
    Inspect,
    /// A kept picture beside what is shown.
    Compare,
    /// Camera and world.
    World,
    /// Times of frames, memory, scale.
    Frame,
    /// The demo.
    Timeline,
    /// The problems.
    Problems,
}

/// The side of the window that a panel opens at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "each is the side of its name")]
pub enum Side {
    Left,
    Right,
    Bottom,
}

impl Panel {
    /// Every panel, in the order of the bar.
    pub const ALL: [Panel; 10] = [
        Panel::Passes,
        Panel::Resources,
        Panel::Graph,
        Panel::Frame,
        Panel::Timeline,
        Panel::Problems,
        Panel::Params,
        Panel::Inspect,
        Panel::Compare,
        Panel::World,
    ];

    /// Its title.
    pub fn title(self) -> &'static str {
        match self {
            Panel::Passes => "Passes",
            Panel::Resources => "Resources",
            Panel::Graph => "Graph",
            Panel::Params => "Params",
            Panel::Inspect => "Inspect",
            Panel::Compare => "Compare",
            Panel::World => "World",
            Panel::Frame => "Frame",
            Panel::Timeline => "Timeline",
            Panel::Problems => "Problems",
        }
    }

    /// Where it opens.
    pub fn side(self) -> Side {
        match self {
            Panel::Passes | Panel::Resources => Side::Left,
            Panel::Params | Panel::Inspect | Panel::Compare | Panel::World => Side::Right,
            Panel::Graph | Panel::Frame | Panel::Timeline | Panel::Problems => Side::Bottom,
        }
    }
}

/// The panels of a window.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Whether anything is drawn over the picture.
    pub visible: bool,
    /// Times the size that the screen asks for.
    pub zoom: f32,
    /// The timeline opens when a demo runs.
    pub timeline: bool,
    /// The picture fills what the docks leave of the window, rather than all of it.
    pub beside: bool,
    /// The picture and the open panels: docked as tabs, or floating.
    pub(crate) docks: DockState<Tab>,
    /// The wanted places of floating panels, until they are drawn.
    pub(crate) windows: Vec<(SurfaceIndex, Rect)>,
}

impl Default for Layout {
    fn default() -> Self {
        let mut layout = Self::empty();
        layout.open_within(Panel::Passes, FIRST);
        layout.open_within(Panel::Params, FIRST);
        layout
    }
}

impl PartialEq for Layout {
    fn eq(&self, other: &Self) -> bool {
        File::of(self) == File::of(other)
    }
}

/// The share of the window that a side takes when its first panel opens.
const SIDE: f32 = 0.27;

/// The share of each side in the first layout: a new user looks at the picture.
const FIRST: f32 = 0.2;

/// The share of the bottom.
const BOTTOM: f32 = 0.28;

impl Layout {
    /// No panel is open.
    pub fn empty() -> Self {
        let mut docks = DockState::new(vec![Tab::Picture]);
        "Float".clone_into(&mut docks.translations.tab_context_menu.eject_button);
        Self { visible: true, zoom: 1.0, timeline: true, beside: false, docks, windows: Vec::new() }
    }

    /// Reads what [`Layout::write`] has written. A missing value has its default.
    ///
    /// # Errors
    /// Returns the mistake in the text, in one line.
    pub fn read(text: &str) -> Result<Layout, String> {
        let file: File = toml::from_str(text).map_err(|error| error.message().to_owned())?;
        Ok(file.layout())
    }

    /// The text of a file.
    pub fn write(&self) -> String {
        let text = toml::to_string(&File::of(self)).unwrap_or_default();
        format!(
            "# The panels of the window. raxel writes this file when the window closes; remove it to get the default.\n{text}"
        )
    }

    /// Whether a panel is open and no other tab hides it.
    pub fn is_open(&self, panel: Panel) -> bool {
        let front = |(surface, node, tab): (SurfaceIndex, NodeIndex, TabIndex)| {
            self.docks[surface][node].get_leaf().is_some_and(|leaf| leaf.active == tab)
        };
        self.visible && self.docks.find_tab(&Tab::Panel(panel)).is_some_and(front)
    }

    /// Whether a panel is open, perhaps behind another tab.
    pub fn has(&self, panel: Panel) -> bool {
        self.docks.find_tab(&Tab::Panel(panel)).is_some()
    }

    /// Whether a panel takes room from the picture.
    pub(crate) fn is_docked(&self) -> bool {
        self.docks.main_surface().num_tabs() > 1
    }

    /// Opens a panel: beside the others of its side, or in front of what hides it. A side has room for two, one above the other, and the bottom
    /// for one; a further one is a tab of the last.
    pub fn open(&mut self, panel: Panel) {
        self.open_within(panel, SIDE);
    }

    /// Opens a panel. A side without one takes this share of the window.
    fn open_within(&mut self, panel: Panel, share: f32) {
        if panel == Panel::Timeline {
            self.timeline = true;
        }
        if let Some(at) = self.docks.find_tab(&Tab::Panel(panel)) {
            self.docks.set_active_tab(at);
            return;
        }
        let side = panel.side();
        let (tree, new) = (self.docks.main_surface_mut(), vec![Tab::Panel(panel)]);
        let of_side = |tab: &Tab| matches!(tab, Tab::Panel(other) if other.side() == side);
        let leaves: Vec<usize> = (tree.iter().enumerate())
            .filter(|(_, node)| node.get_leaf().is_some_and(|leaf| leaf.tabs.iter().any(of_side)))
            .map(|(index, _)| index)
            .collect();
        match (leaves.as_slice(), side) {
            ([only], Side::Left | Side::Right) => drop(tree.split_below(NodeIndex(*only), 0.5, new)),
            ([.., last], _) => {
                if let Some(leaf) = tree.iter_mut().nth(*last).and_then(egui_dock::Node::get_leaf_mut) {
                    leaf.append_tab(Tab::Panel(panel));
                }
            }
            ([], Side::Bottom) => drop(tree.split_below(NodeIndex::root(), 1.0 - BOTTOM, new)),
            ([], Side::Left | Side::Right) => {
                let picture = tree.find_tab(&Tab::Picture).map_or(NodeIndex::root(), |(node, _)| node);
                let beside =
                    |tab: &Tab| matches!(tab, Tab::Panel(other) if ![side, Side::Bottom].contains(&other.side()));
                // Where the other side is taken, this one is a part of what is left.
                let share = if tree.tabs().any(beside) { share / (1.0 - share) } else { share };
                if side == Side::Left {
                    tree.split_left(picture, share, new);
                } else {
                    tree.split_right(picture, 1.0 - share, new);
                }
            }
        }
    }

    /// Closes a panel.
    pub fn close(&mut self, panel: Panel) {
        if let Some(at) = self.docks.find_tab(&Tab::Panel(panel)) {
            self.docks.remove_tab(at);
        }
    }

    /// Opens a panel, or closes it where it is seen.
    pub fn toggle(&mut self, panel: Panel) {
        if self.is_open(panel) {
            self.close(panel);
            self.timeline &= panel != Panel::Timeline;
        } else {
            self.open(panel);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_it_writes() {
        let mut layout = Layout { zoom: 1.5, beside: true, ..Layout::default() };
        layout.toggle(Panel::Passes);
        for panel in [Panel::Problems, Panel::Inspect, Panel::World, Panel::Graph] {
            layout.open(panel);
        }
        let window = layout.docks.add_window(vec![Tab::Panel(Panel::Compare)]);
        let rect = Rect::from_min_size(egui::pos2(40.0, 60.0), egui::vec2(300.0, 200.0));
        layout.windows.push((window, rect));
        let again = Layout::read(&layout.write()).unwrap();
        assert_eq!(again, layout, "{}", layout.write());
        assert_eq!((again.write(), &again.windows), (layout.write(), &layout.windows));
        assert!(
            again.has(Panel::Compare) && again.docks.main_surface().find_tab(&Tab::Panel(Panel::Compare)).is_none()
        );
        assert_eq!(Layout::read(""), Ok(Layout::default()));
    }

    #[test]
    fn a_side_has_room_for_two_and_the_bottom_for_one_then_there_are_tabs() {
        let mut layout = Layout::default();
        layout.open(Panel::Inspect);
        assert!(layout.is_open(Panel::Params) && layout.is_open(Panel::Inspect));
        layout.open(Panel::World);
        assert!(layout.is_open(Panel::Params) && layout.is_open(Panel::World));
        assert!(layout.has(Panel::Inspect) && !layout.is_open(Panel::Inspect), "behind the world");
        layout.toggle(Panel::Inspect);
        assert!(layout.is_open(Panel::Inspect) && layout.has(Panel::World), "in front again");
        layout.toggle(Panel::Inspect);
        assert!(!layout.has(Panel::Inspect) && layout.is_open(Panel::World));
        layout.open(Panel::Problems);
        layout.open(Panel::Frame);
        assert!(layout.has(Panel::Problems) && layout.is_open(Panel::Frame));
        for panel in Panel::ALL {
            layout.close(panel);
        }
        assert!(!layout.is_docked() && layout.docks.find_tab(&Tab::Picture).is_some());
        assert_eq!(layout, Layout::empty());
    }

    #[test]
    fn what_cannot_be_is_mended_and_what_is_no_layout_is_said() {
        let tabs = |tabs: &str| format!("docks = {{ tabs = [{tabs}], front = 7 }}");
        // A panel is there once, and the picture always.
        let layout = Layout::read(&format!("zoom = 99.0\n{}", tabs("\"passes\", \"passes\""))).unwrap();
        assert_eq!((layout.zoom, layout.docks.iter_all_tabs().count()), (4.0, 2));
        assert!(layout.has(Panel::Passes) && layout.docks.find_tab(&Tab::Picture).is_some());
        let layout = Layout::read(
            "docks = { across = { share = -3.0, left = { tabs = [] }, right = { tabs = [\"params\"] } } }",
        );
        assert!(layout.unwrap().has(Panel::Params));
        let window = "floating = [{ at = [inf, 0.0], size = [-5.0, 1e9], docks = { tabs = [\"frame\"] } }]";
        assert!(Layout::read(window).unwrap().has(Panel::Frame));
        assert_eq!(Layout::read("zoom = nan").unwrap().zoom.to_bits(), 1.0_f32.to_bits());
        // The layout of an older raxel.
        assert_eq!(Layout::read("left = { open = \"inspect\", size = 100.0 }"), Ok(Layout::default()));
        assert!(Layout::read("docks = 3").is_err());
        assert!(Layout::read(&tabs("\"kitchen\"")).is_err());
    }
}
