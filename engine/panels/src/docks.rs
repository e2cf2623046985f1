//! The bar at the top and the docks at three sides, and which panel each of them holds.

use egui::containers::panel::PanelState;
use egui::scroll_area::ScrollBarVisibility;
use egui::{
    Align2, CentralPanel, Color32, Context, FontId, Frame, Id, Pos2, Rect, RichText, ScrollArea, SidePanel, TextStyle,
    TopBottomPanel, Ui, Vec2,
};

use crate::action::Action;
use crate::layout::{Layout, Panel, Side};
use crate::problems::problem_list;
use crate::switcher::{Switcher, Switching};
use crate::view::{Problem, Shown, View};
use crate::{
    bar, brush, compare, frame, graph, inspect, magnified, params, passes, problems, resources, timeline, world,
};

/// Below so many points the window has room for the panels of one side only: the picture is what one looks at.
const NARROW: f32 = 1000.0;

/// What lies over the picture: how opaque it is, of 255.
const OPACITY: u8 = 236;

/// The panels with what they remember from frame to frame.
#[derive(Debug, Default)]
pub struct Panels {
    /// Which are open; kept beside the project.
    pub layout: Layout,
    /// The side that was touched last: in a narrow window only that one is drawn.
    recent: Option<Side>,
    /// What the pointer rests on, since when, and whether it is shown.
    pub(crate) peek: Option<Peek>,
    /// Texts of the fields of the panel of the world.
    fields: world::Fields,
    /// Which part of the picture of the graph is seen.
    graph: graph::Camera,
    /// The name of a new preset.
    preset: String,
    /// The file that a picture is loaded from.
    picture: String,
    /// The list of the project's files, while it is open.
    switcher: Option<Switcher>,
    /// A key of the timeline on its way to another time.
    moving: Option<timeline::Moving>,
    /// The failed generation for which the problems were opened by themselves.
    told: Option<u64>,
    /// The panel in whose place they were.
    displaced: Option<Panel>,
    /// Points of the window when it was drawn last.
    room: Vec2,
    /// Where a press takes hold of the edge of a dock. Half of it lies over the picture.
    edges: Vec<Rect>,
}

/// A pass whose output is looked at while the pointer rests on it.
#[derive(Clone, Debug)]
pub(crate) struct Peek {
    pub(crate) shown: Shown,
    pub(crate) since: f64,
    pub(crate) told: bool,
}

impl Panels {
    /// Panels as a layout says.
    pub fn new(layout: Layout) -> Self {
        Self { layout, ..Self::default() }
    }

    /// Shows or hides everything.
    pub fn toggle(&mut self) {
        self.layout.visible = !self.layout.visible;
    }

    /// Opens the list of the project's files, also while the panels are hidden.
    pub fn switch(&mut self) {
        self.switcher = Some(Switcher::default());
    }

    /// Whether the list of the project's files is open.
    pub fn is_switching(&self) -> bool {
        self.switcher.is_some()
    }

    /// Whether anything is drawn over the picture.
    pub fn are_drawn(&self) -> bool {
        self.layout.visible || self.is_switching()
    }

    /// Whether a press at this point, in points from the top left, resizes a dock. It must not drag the camera as well.
    pub fn is_edge(&self, at: Pos2) -> bool {
        self.layout.visible && self.edges.iter().any(|edge| edge.contains(at))
    }

    /// Draws what is open, and gives what the user asks for, in order. While nothing is visible only an open question is ended.
    pub fn show(&mut self, ctx: &Context, view: &View<'_>) -> Vec<Action> {
        let mut actions = Vec::new();
        self.style(ctx);
        // What goes wrong is shown by itself, once for each edit.
        if view.status.failed != self.told {
            self.told = view.status.failed;
            if self.told.is_some() {
                self.displaced = self.layout.bottom.open.filter(|panel| *panel != Panel::Problems).or(self.displaced);
                self.open(Panel::Problems);
            } else if self.layout.bottom.open == Some(Panel::Problems) && view.problems.is_empty() {
                self.layout.bottom.open = self.displaced.take();
            }
        }
        let mut hovered = None;
        self.follow_window(ctx);
        if self.layout.visible {
            brush::outline(ctx, &view.world.editing.outline);
            magnified::show(ctx, &view.magnified);
            if let Some(found) = view.inspected.filter(|_| self.layout.is_open(Panel::Inspect)) {
                inspect::mark(ctx, found, &view.magnified);
            }
            compare::edge(ctx, &view.compare);
            self.bar(ctx, view, &mut actions);
            self.edges.clear();
            for side in self.sides(ctx) {
                self.dock(ctx, view, side, (&mut actions, &mut hovered));
            }
        }
        if let Some(switcher) = &mut self.switcher
            && switcher.show(ctx, view.files, &mut actions) == Switching::Ends
        {
            self.switcher = None;
        }
        self.follow(ctx, hovered, &mut actions);
        actions
    }

    /// Draws a window that has nothing to show yet but what is wrong. Gives what the user asks for.
    pub fn waiting(&mut self, ctx: &Context, title: &str, found: &[Problem]) -> Vec<Action> {
        let mut actions = Vec::new();
        self.style(ctx);
        let fill = Color32::from_gray(20);
        CentralPanel::default().frame(Frame::central_panel(&ctx.style()).fill(fill)).show(ctx, |ui| {
            ui.heading(title);
            ui.label("The window goes on by itself when the files are mended.");
            ui.separator();
            ScrollArea::both().auto_shrink(false).show(ui, |ui| problem_list(ui, found, &mut actions));
        });
        actions
    }

    /// In a window of another size each dock has the size that the user has chosen for it again, as far as there is room: a window that was
    /// small for a moment must not leave it narrow.
    fn follow_window(&mut self, ctx: &Context) {
        let room = ctx.content_rect().size();
        if self.room != room {
            self.room = room;
            ctx.data_mut(|data| {
                for panel in Panel::ALL {
                    data.remove::<PanelState>(dock_id(panel));
                }
            });
        }
    }

    /// The sides that there is room for, in the order in which they take theirs.
    fn sides(&self, ctx: &Context) -> Vec<Side> {
        if ctx.content_rect().width() < NARROW {
            let open = |side: &Side| self.layout.dock(*side).open.is_some();
            let first = || [Side::Right, Side::Left, Side::Bottom].into_iter().find(open);
            return vec![self.recent.or_else(first).unwrap_or(Side::Right)];
        }
        vec![Side::Bottom, Side::Left, Side::Right]
    }

    /// Opens a panel and brings its side to the front.
    pub(crate) fn open(&mut self, panel: Panel) {
        self.layout.open(panel);
        self.recent = Some(panel.side());
    }

    fn style(&mut self, ctx: &Context) {
        // A window that is opened anew, as after the loss of a device, has a context of its own.
        let styled = Id::new("styled");
        if ctx.data(|data| data.get_temp::<bool>(styled)).is_none() {
            ctx.data_mut(|data| data.insert_temp(styled, true));
            ctx.set_theme(egui::Theme::Dark);
            ctx.set_zoom_factor(self.layout.zoom);
            ctx.style_mut(|style| {
                style.interaction.tooltip_delay = 0.3;
                style.visuals.override_text_color = Some(Color32::from_gray(210));
                style.visuals.weak_text_alpha = 0.75;
                style.spacing.item_spacing = egui::vec2(6.0, 3.0);
                // Names in the matrix of resources and on the timeline.
                style.text_styles.insert(TextStyle::Small, FontId::proportional(10.0));
            });
        }
        self.layout.zoom = ctx.zoom_factor();
    }

    fn bar(&mut self, ctx: &Context, view: &View<'_>, actions: &mut Vec<Action>) {
        TopBottomPanel::top("bar").frame(frame(ctx)).show(ctx, |ui| {
            // A scroll bar would lie over the lower half of the buttons, and take their clicks.
            let hidden = ScrollBarVisibility::AlwaysHidden;
            ScrollArea::horizontal().scroll_bar_visibility(hidden).auto_shrink([false, true]).show(ui, |ui| {
                ui.horizontal(|ui| {
                    if ui.button("Open").on_hover_text("Another graph, world or demo of the project; O").clicked() {
                        actions.push(Action::ListFiles);
                    }
                    ui.separator();
                    for panel in Panel::ALL {
                        if panel == Panel::Timeline && view.timeline.is_none() {
                            continue;
                        }
                        let title = match (panel, view.problems.len()) {
                            (Panel::Problems, count @ 1..) => {
                                RichText::new(format!("Problems {count}")).color(bar::color_of(view.problems))
                            }
                            _ => RichText::new(panel.title()),
                        };
                        let seen = self.layout.is_open(panel) && self.sides(ctx).contains(&panel.side());
                        if ui.selectable_label(seen, title).clicked() {
                            if seen {
                                self.layout.toggle(panel);
                            } else {
                                self.layout.open(panel);
                            }
                            self.recent = Some(panel.side());
                        }
                    }
                    ui.separator();
                    bar::clock(ui, &view.status, actions);
                    bar::status(ui, view, actions);
                });
            });
        });
    }

    fn dock(
        &mut self,
        ctx: &Context,
        view: &View<'_>,
        side: Side,
        (actions, hovered): (&mut Vec<Action>, &mut Option<Shown>),
    ) {
        let Some(panel) = self.layout.dock(side).open else { return };
        let below = self.layout.dock(side).below;
        if panel == Panel::Timeline && view.timeline.is_none() {
            return;
        }
        let (size, room) = (self.layout.dock(side).size, ctx.content_rect().size());
        let id = dock_id(panel);
        let content = |ui: &mut Ui| {
            if let Some(below) = below {
                let (id, most) = (Id::new(("below", below.title())), (ui.available_height() - 60.0).max(20.0));
                let lower = TopBottomPanel::bottom(id).resizable(true).frame(Frame::NONE);
                let lower = lower.default_height(ui.available_height() / 2.0).height_range(20.0..=most);
                lower.show_inside(ui, |ui| self.content(ui, view, below, (&mut *actions, &mut *hovered)));
            }
            self.content(ui, view, panel, (actions, hovered));
        };
        let rect = match side {
            Side::Left | Side::Right => {
                let dock = if side == Side::Left { SidePanel::left(id) } else { SidePanel::right(id) };
                // Some of the picture stays in sight, whatever the window's size.
                let most = (room.x * 0.7).max(60.0);
                let dock = dock.frame(frame(ctx)).default_width(size.min(most)).width_range(60.0_f32.min(most)..=most);
                dock.show(ctx, content).response.rect
            }
            Side::Bottom => {
                let most = (room.y * 0.6).max(40.0);
                let dock = TopBottomPanel::bottom(id).resizable(true).frame(frame(ctx));
                let dock = dock.default_height(size.min(most)).height_range(40.0_f32.min(most)..=most);
                dock.show(ctx, content).response.rect
            }
        };
        let (edge, shown) = match side {
            Side::Left => (Rect::from_min_max(rect.right_top(), rect.right_bottom()), rect.width()),
            Side::Right => (Rect::from_min_max(rect.left_top(), rect.left_bottom()), rect.width()),
            Side::Bottom => (Rect::from_min_max(rect.left_top(), rect.right_top()), rect.height()),
        };
        let interaction = ctx.style().interaction.clone();
        // egui gives a press beside a widget to the nearest one within a radius.
        self.edges.push(edge.expand(interaction.resize_grab_radius_side + interaction.interact_radius));
        // A size that the window forced is not what the user chose.
        if ctx.input(|input| input.pointer.any_down()) {
            self.layout.dock_mut(side).size = shown;
        }
    }

    fn content(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        panel: Panel,
        (actions, hovered): (&mut Vec<Action>, &mut Option<Shown>),
    ) {
        let before = actions.len();
        match panel {
            // It scrolls by itself.
            Panel::Graph => graph::show(ui, view, &mut self.graph, actions),
            _ => {
                ScrollArea::both()
                    .id_salt(panel.title())
                    .auto_shrink(false)
                    .show(ui, |ui| self.scrolled(ui, view, panel, (&mut *actions, hovered)));
            }
        }
        // What is clicked there is looked into.
        let shows = actions[before..].iter().any(|action| matches!(action, Action::Show(_)));
        if shows && matches!(panel, Panel::Resources | Panel::Graph) {
            self.open(Panel::Inspect);
        }
    }

    /// The panels that may be larger than their dock.
    fn scrolled(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        panel: Panel,
        (actions, hovered): (&mut Vec<Action>, &mut Option<Shown>),
    ) {
        match panel {
            Panel::Graph => {}
            Panel::Passes => passes::show(ui, view, (actions, hovered)),
            Panel::Resources => resources::show(ui, view, actions),
            Panel::Params => params::show(ui, view, &mut self.preset, actions),
            Panel::Inspect => inspect::show(ui, view, actions),
            Panel::Compare => compare::show(ui, &view.compare, &mut self.picture, actions),
            Panel::World => world::show(ui, &view.world, &mut self.fields, actions),
            Panel::Frame => frame::show(ui, &view.frame, actions),
            Panel::Timeline => {
                if let Some(timeline) = &view.timeline {
                    timeline::show(ui, timeline, view.status.paused, &mut self.moving, actions);
                }
            }
            Panel::Problems => problems::show(ui, view, actions),
        }
    }

    /// Begins and ends looking at what the pointer rests on.
    fn follow(&mut self, ctx: &Context, hovered: Option<Shown>, actions: &mut Vec<Action>) {
        /// Seconds that the pointer rests before the picture changes: on its way across a list it changes nothing.
        const REST: f64 = 0.15;
        let now = ctx.input(|input| input.time);
        let told = self.peek.as_ref().is_some_and(|peek| peek.told);
        match hovered {
            None => {
                if told {
                    actions.push(Action::Peek(None));
                }
                self.peek = None;
            }
            Some(shown) => {
                if self.peek.as_ref().is_none_or(|peek| peek.shown != shown) {
                    self.peek = Some(Peek { shown, since: now, told: false });
                    if told {
                        actions.push(Action::Peek(None));
                    }
                }
                if let Some(peek) = self.peek.as_mut().filter(|peek| !peek.told) {
                    if now - peek.since >= REST {
                        peek.told = true;
                        actions.push(Action::Peek(Some(peek.shown.clone())));
                    } else {
                        ctx.request_repaint();
                    }
                }
            }
        }
    }
}

/// Under which egui keeps the size of a dock.
fn dock_id(panel: Panel) -> Id {
    Id::new(("dock", panel.title()))
}

/// The ground of bar and docks.
fn frame(ctx: &Context) -> Frame {
    let fill = Color32::from_rgba_unmultiplied(24, 26, 30, OPACITY);
    Frame::side_top_panel(&ctx.style()).fill(fill)
}

/// Text at a place of a painting.
pub(crate) fn caption(ui: &Ui, at: egui::Pos2, anchor: Align2, text: &str) {
    let font = egui::TextStyle::Small.resolve(ui.style());
    ui.painter().text(at, anchor, text, font, ui.visuals().weak_text_color());
}
