//! Which panels are open and how large they are. Kept beside the project, never in its files.

use serde::{Deserialize, Serialize};

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
    /// What the shown resource holds.
    Inspect,
    /// A kept picture beside what is shown.
    Compare,
    /// Camera and world.
    World,
    /// Times of frames, memory, scale.
    Frame,
    /// The demo.
    Timeline,
    /// What is wrong.
    Problems,
}

/// The side of the window that a panel is docked to.
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

    /// Where it is docked.
    pub fn side(self) -> Side {
        match self {
            Panel::Passes | Panel::Resources => Side::Left,
            Panel::Params | Panel::Inspect | Panel::Compare | Panel::World => Side::Right,
            Panel::Graph | Panel::Frame | Panel::Timeline | Panel::Problems => Side::Bottom,
        }
    }
}

/// One side of the window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Dock {
    /// The panel that is open there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub open: Option<Panel>,
    /// A second one, below it; never at the bottom of the window.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub below: Option<Panel>,
    /// Points: its width at the sides, its height at the bottom.
    pub size: f32,
}

impl Default for Dock {
    fn default() -> Self {
        Self { open: None, below: None, size: 280.0 }
    }
}

/// The panels of a window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Layout {
    /// Whether anything is drawn over the picture.
    pub visible: bool,
    /// Times the size that the screen asks for.
    pub zoom: f32,
    /// At the left.
    pub left: Dock,
    /// At the right.
    pub right: Dock,
    /// At the bottom.
    pub bottom: Dock,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            visible: true,
            zoom: 1.0,
            left: Dock { open: Some(Panel::Passes), size: 350.0, ..Dock::default() },
            right: Dock { open: Some(Panel::Params), size: 340.0, ..Dock::default() },
            // Only a demo has one.
            bottom: Dock { open: Some(Panel::Timeline), size: 200.0, ..Dock::default() },
        }
    }
}

impl Layout {
    /// Reads what [`Layout::write`] has written. What is missing has its default.
    ///
    /// # Errors
    /// What is wrong with the text, in one line.
    pub fn read(text: &str) -> Result<Layout, String> {
        let mut layout: Layout = toml::from_str(text).map_err(|error| error.message().to_owned())?;
        layout.zoom = if layout.zoom.is_finite() { layout.zoom.clamp(0.5, 4.0) } else { 1.0 };
        for (side, dock) in
            [(Side::Left, &mut layout.left), (Side::Right, &mut layout.right), (Side::Bottom, &mut layout.bottom)]
        {
            dock.open = dock.open.filter(|panel| panel.side() == side);
            let fits = |panel: &Panel| {
                panel.side() == side && side != Side::Bottom && dock.open.is_some_and(|open| open != *panel)
            };
            dock.below = dock.below.filter(fits);
            dock.size = if dock.size.is_finite() { dock.size.clamp(80.0, 4000.0) } else { Dock::default().size };
        }
        Ok(layout)
    }

    /// The text of a file.
    pub fn write(&self) -> String {
        let text = toml::to_string(self).unwrap_or_default();
        format!(
            "# The panels of the window. raxel writes this file when the window closes; remove it to get the default.\n{text}"
        )
    }

    /// One side.
    pub fn dock(&self, side: Side) -> &Dock {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
            Side::Bottom => &self.bottom,
        }
    }

    /// One side, to be changed.
    pub fn dock_mut(&mut self, side: Side) -> &mut Dock {
        match side {
            Side::Left => &mut self.left,
            Side::Right => &mut self.right,
            Side::Bottom => &mut self.bottom,
        }
    }

    /// Whether a panel is open.
    pub fn is_open(&self, panel: Panel) -> bool {
        let dock = self.dock(panel.side());
        self.visible && (dock.open == Some(panel) || dock.below == Some(panel))
    }

    /// Opens a panel: at the bottom in the place of the one that is there, at a side below it. A third one takes the place of the lower.
    pub fn open(&mut self, panel: Panel) {
        let dock = self.dock_mut(panel.side());
        if panel.side() == Side::Bottom || dock.open.is_none() {
            dock.open = Some(panel);
        } else if dock.open != Some(panel) {
            dock.below = Some(panel);
        }
    }

    /// Opens a panel, or closes it.
    pub fn toggle(&mut self, panel: Panel) {
        let dock = self.dock_mut(panel.side());
        if dock.open == Some(panel) {
            dock.open = dock.below.take();
        } else if dock.below == Some(panel) {
            dock.below = None;
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
        let mut layout = Layout { zoom: 1.5, ..Layout::default() };
        layout.toggle(Panel::Passes);
        layout.open(Panel::Problems);
        assert_eq!(Layout::read(&layout.write()), Ok(layout));
        assert_eq!(Layout::read(""), Ok(Layout::default()));
    }

    #[test]
    fn a_side_has_room_for_two_and_the_bottom_for_one() {
        let mut layout = Layout::default();
        layout.open(Panel::Inspect);
        assert!(layout.is_open(Panel::Params) && layout.is_open(Panel::Inspect));
        layout.open(Panel::Inspect);
        layout.open(Panel::World);
        assert_eq!((layout.right.open, layout.right.below), (Some(Panel::Params), Some(Panel::World)));
        assert_eq!(Layout::read(&layout.write()), Ok(layout.clone()));
        layout.toggle(Panel::Params);
        assert_eq!((layout.right.open, layout.right.below), (Some(Panel::World), None));
        layout.open(Panel::Problems);
        assert_eq!((layout.bottom.open, layout.bottom.below), (Some(Panel::Problems), None));
        for text in ["right = { below = \"world\" }", "left = { open = \"passes\", below = \"passes\" }"] {
            let layout = Layout::read(text).unwrap();
            assert_eq!((layout.left.below, layout.right.below), (None, None), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_is_mended_and_what_is_no_layout_is_said() {
        let layout = Layout::read("zoom = 99.0\nleft = { open = \"problems\", size = -5.0 }").unwrap();
        assert_eq!((layout.zoom, layout.left.open, layout.left.size), (4.0, None, 80.0));
        assert_eq!(Layout::read("zoom = nan").unwrap().zoom.to_bits(), 1.0_f32.to_bits());
        assert!(Layout::read("left = 3").is_err());
        assert!(Layout::read("left = { open = \"kitchen\" }").is_err());
    }
}
