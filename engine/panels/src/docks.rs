//! The bar at the top and the docks below it, and which panel each of them holds.

use egui::scroll_area::ScrollBarVisibility;
use egui::{
    Align2, CentralPanel, Color32, Context, FontId, Frame, Id, Margin, Order, Pos2, Rect, RichText, ScrollArea, Stroke,
    TextStyle, TopBottomPanel, Ui, WidgetText,
};
use egui_dock::{DockArea, DockState, Node, NodeIndex, Style, TabViewer};

use crate::action::Action;
use crate::layout::{Layout, Panel, Side};
use crate::layout_file::Tab;
use crate::passes::Timed;
use crate::problems::problem_list;
use crate::rows::Rows;
use crate::shape_cache::ShapeCache;
use crate::switcher::{Switcher, Switching};
use crate::view::{Problem, Shown, View};
use crate::{
    bar, brush, compare, frame, graph, inspect, magnified, params, passes, problems, resources, timeline, world,
};

/// Below this number of points, the window has room for one dock only, with a tab for each open panel: the picture comes first.
const NARROW: f32 = 1000.0;

/// The share of a narrow window that its one dock takes.
const NARROW_SHARE: f32 = 0.45;

/// A press within this number of points beside the picture takes hold of an edge of a dock: egui gives it to the nearest widget within a radius.
const GRIP: f32 = 8.0;

/// Points of the smallest place beside the panels that shows the picture.
const SMALLEST: f32 = 32.0;

/// The opacity of panels over the picture, of 255.
const OPACITY: u8 = 236;

/// The panels with their state from frame to frame.
#[derive(Debug, Default)]
pub struct Panels {
    /// Which are open; kept beside the project.
    pub layout: Layout,
    /// Every widget is made in every frame, for what reads the tree of widgets. Else a panel that nobody touches has none.
    pub whole: bool,
    /// The shapes of each panel's last draw, in the order of [`Panel::ALL`].
    kept: [ShapeCache; Panel::ALL.len()],
    /// The panel that was opened last: in a narrow window it is in front of the others.
    recent: Option<Panel>,
    /// The item under a resting pointer, since when, and whether it is shown.
    pub(crate) peek: Option<Peek>,
    /// Texts of the fields of the panel of the world.
    fields: world::Fields,
    /// The picture of the graph.
    graph: graph::Memory,
    /// The rows of the panels with long lists.
    passes: Rows<4>,
    resources: Rows<2>,
    params: Rows<1>,
    /// The name of a new preset.
    preset: String,
    /// The file that a picture is loaded from.
    picture: String,
    /// The list of the project's files, while it is open.
    switcher: Option<Switcher>,
    /// The demo.
    timeline: timeline::Memory,
    /// The failed generation for which the problems were opened by themselves.
    told: Option<u64>,
    /// They were, and were not open before.
    problems_opened: bool,
    /// The part of the window without docks, in points; `None` if nothing is docked.
    free: Option<Rect>,
    /// The share of a narrow window that is left to the picture, once it was dragged.
    narrow: Option<f32>,
    /// The lower edge of the bar.
    bar: f32,
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

    /// Whether the picture must ignore a pointer at this point, in points from the top left: it is over a panel, or takes hold of a panel's
    /// edge.
    pub fn has_pointer(&self, ctx: &Context, at: Pos2) -> bool {
        if ctx.is_using_pointer() || self.is_switching() {
            return true;
        }
        let covered = ctx.layer_id_at(at).is_some_and(|layer| layer.order != Order::Background);
        self.are_drawn() && (covered || !self.grasp(ctx).contains(at))
    }

    /// The place of the picture: the whole window, or the part without docks.
    pub fn picture(&self, ctx: &Context) -> Rect {
        let window = ctx.content_rect();
        if !self.layout.visible || !self.layout.beside {
            return window;
        }
        let free = self.free.unwrap_or(Rect::from_min_max(self.below_bar(ctx), window.max)).intersect(window);
        if free.width() < SMALLEST || free.height() < SMALLEST { window } else { free }
    }

    /// The part in which presses belong to the picture.
    fn grasp(&self, ctx: &Context) -> Rect {
        let window = ctx.content_rect();
        let Some(mut free) = self.free else { return Rect::from_min_max(self.below_bar(ctx), window.max) };
        // The edges of the window are no docks'.
        free.min.x += if free.min.x > window.min.x { GRIP } else { 0.0 };
        free.max.x -= if free.max.x < window.max.x { GRIP } else { 0.0 };
        free.max.y -= if free.max.y < window.max.y { GRIP } else { 0.0 };
        free
    }

    fn below_bar(&self, ctx: &Context) -> Pos2 {
        Pos2::new(ctx.content_rect().left(), self.bar)
    }

    /// Draws the open panels, and returns the user's actions in order. While nothing is visible, it only ends an open question.
    pub fn show(&mut self, ctx: &Context, view: &View<'_>) -> Vec<Action> {
        let mut actions = Vec::new();
        self.style(ctx);
        self.follow_problems(view);
        self.follow_timeline(view);
        let mut hovered = None;
        if self.layout.visible {
            let area = self.picture(ctx);
            brush::outline(ctx, area, &view.world.editing.outline);
            magnified::show(ctx, area, &view.magnified);
            if let Some(found) = view.inspected.filter(|_| self.layout.is_open(Panel::Inspect)) {
                inspect::mark(ctx, area, found, &view.magnified);
            }
            compare::edge(ctx, area, &view.compare);
            self.bar(ctx, view, &mut actions);
            self.docks(ctx, view, (&mut actions, &mut hovered));
        }
        if !self.layout.visible || !self.layout.is_open(Panel::Graph) {
            self.graph.close();
        }
        if let Some(switcher) = &mut self.switcher
            && switcher.show(ctx, view.files, &mut actions) == Switching::Ends
        {
            self.switcher = None;
        }
        self.follow(ctx, hovered, &mut actions);
        actions
    }

    /// Draws a window that has only problems to show yet. Returns the user's actions.
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

    /// The panel of problems opens by itself, once for each edit, until they are mended.
    fn follow_problems(&mut self, view: &View<'_>) {
        if view.status.failed == self.told {
            return;
        }
        self.told = view.status.failed;
        if self.told.is_some() {
            self.problems_opened |= !self.layout.has(Panel::Problems);
            self.open(Panel::Problems);
        } else if view.problems.is_empty() && std::mem::take(&mut self.problems_opened) {
            self.layout.close(Panel::Problems);
        }
    }

    /// Only a demo has a timeline.
    fn follow_timeline(&mut self, view: &View<'_>) {
        let has = self.layout.has(Panel::Timeline);
        if view.timeline.is_none() && has {
            self.layout.close(Panel::Timeline);
        } else if view.timeline.is_some() && !has && self.layout.timeline {
            self.layout.open(Panel::Timeline);
        }
    }

    /// The panel in front of all others, in a narrow window.
    fn only(&self, ctx: &Context) -> Option<Panel> {
        if ctx.content_rect().width() >= NARROW {
            return None;
        }
        let open = |panel: &Panel| self.layout.has(*panel);
        let preferred = |side| Panel::ALL.into_iter().find(|panel| panel.side() == side && open(panel));
        let first = || [Side::Right, Side::Left, Side::Bottom].into_iter().find_map(preferred);
        self.recent.filter(open).or_else(first)
    }

    /// Opens a panel and brings it to the front.
    pub(crate) fn open(&mut self, panel: Panel) {
        self.layout.open(panel);
        self.recent = Some(panel);
    }

    fn style(&mut self, ctx: &Context) {
        // A window that opens again, for example after the loss of a device, has a new context.
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
        let bar = TopBottomPanel::top("bar").frame(frame(ctx)).show(ctx, |ui| {
            // A scroll bar would lie over the lower half of the buttons, and take their clicks.
            let hidden = ScrollBarVisibility::AlwaysHidden;
            ScrollArea::horizontal()
                .scroll_bar_visibility(hidden)
                .auto_shrink([false, true])
                .show(ui, |ui| {
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
                            let seen = self.layout.is_open(panel) && self.only(ctx).is_none_or(|only| only == panel);
                            if ui.selectable_label(seen, title).clicked() {
                                if seen {
                                    self.layout.toggle(panel);
                                } else {
                                    self.open(panel);
                                }
                            }
                        }
                        let hint = "The picture beside the panels, rather than under them; F3";
                        if ui.selectable_label(self.layout.beside, "Beside").on_hover_text(hint).clicked() {
                            self.layout.beside = !self.layout.beside;
                        }
                        if ui.button("Reset layout").on_hover_text("Docks and closes all panels as at first").clicked()
                        {
                            self.layout = Layout { zoom: self.layout.zoom, ..Layout::default() };
                            self.recent = None;
                        }
                        ui.separator();
                        bar::clock(ui, &view.status, actions);
                        bar::status(ui, view, actions)
                    })
                    .inner
                })
                .inner
        });
        self.bar = bar.response.rect.bottom();
        if let Some(notice) = bar.inner {
            bar::notice(ctx, self.bar, notice);
        }
    }

    /// Draws the docks, and notes the free part of the window.
    fn docks(&mut self, ctx: &Context, view: &View<'_>, (actions, hovered): (&mut Vec<Action>, &mut Option<Shown>)) {
        let only = self.only(ctx);
        let narrow = only.map(|panel| {
            let mut docks = DockState::new(vec![Tab::Picture]);
            let share = self.narrow.unwrap_or(1.0 - NARROW_SHARE);
            let open = Panel::ALL.into_iter().filter(|panel| self.layout.has(*panel)).map(Tab::Panel);
            docks.main_surface_mut().split_right(NodeIndex::root(), share, open.collect());
            if let Some(front) = docks.find_tab(&Tab::Panel(panel)) {
                docks.set_active_tab(front);
            }
            docks
        });
        if !self.layout.is_docked() && only.is_none() && self.layout.docks.surfaces_count() == 1 {
            self.free = None;
            return;
        }
        let ground = frame(ctx).fill;
        let mut style = Style::from_egui(&ctx.style());
        (style.tab_bar.height, style.tab_bar.bg_fill) = (20.0, ground);
        // No line lies over the picture.
        (style.main_surface_border_stroke, style.tab.tab_body.stroke) = (Stroke::NONE, Stroke::NONE);
        // No part of the window is smaller, in points.
        style.separator.extra = 40.0;
        (style.tab.tab_body.bg_fill, style.tab.tab_body.inner_margin) = (ground, Margin::same(4));
        // The panels are lent to what draws the tabs, and the docks are not.
        let empty = DockState::new(Vec::new());
        let own = std::mem::replace(&mut self.layout.docks, empty);
        let (mut docks, kept) = match narrow {
            Some(narrow) => (narrow, Some(own)),
            None => (own, None),
        };
        let mut tabs = Tabs { panels: self, view, actions, hovered, free: None, opened: None, closed: None };
        CentralPanel::default().frame(Frame::NONE).show(ctx, |ui| {
            DockArea::new(&mut docks)
                .id(Id::new(if kept.is_some() { "narrow" } else { "docks" }))
                .style(style)
                .draggable_tabs(kept.is_none())
                .tab_context_menus(kept.is_none())
                .show_leaf_close_all_buttons(false)
                .show_leaf_collapse_buttons(false)
                .show_inside(ui, &mut tabs);
        });
        let Tabs { free, opened, closed, .. } = tabs;
        self.layout.docks = match kept {
            Some(own) => {
                if let Node::Horizontal(split) = &docks.main_surface()[NodeIndex::root()] {
                    self.narrow = Some(split.fraction);
                }
                let leaves = docks.main_surface().iter().filter_map(Node::get_leaf);
                let fronts = leaves.filter_map(|leaf| leaf.tabs.get(leaf.active.0));
                self.recent = fronts.fold(self.recent, |recent, tab| match tab {
                    Tab::Panel(panel) => Some(*panel),
                    Tab::Picture => recent,
                });
                own
            }
            None => docks,
        };
        self.free = if self.layout.is_docked() || only.is_some() { free.or(self.free) } else { None };
        self.layout.timeline &= closed != Some(Panel::Timeline);
        if let Some(panel) = closed {
            self.layout.close(panel);
        }
        if let Some(panel) = opened {
            self.open(panel);
        }
    }

    fn content(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        panel: Panel,
        (actions, hovered): (&mut Vec<Action>, &mut Option<Shown>),
    ) -> Option<Panel> {
        let before = actions.len();
        if panel == Panel::Graph {
            self.graph.update(ui.ctx(), &view.thumbnails);
        }
        let place = Panel::ALL.iter().position(|other| *other == panel).unwrap_or(0);
        let mut kept = std::mem::take(&mut self.kept[place]);
        // A key that was dropped returns after a while.
        let moves = panel == Panel::Timeline && self.timeline.moves();
        if self.whole || moves {
            self.draw(ui, view, panel, (&mut *actions, hovered));
        } else {
            keep(&mut kept, ui, view, panel, |ui| self.draw(ui, view, panel, (&mut *actions, hovered)));
        }
        self.kept[place] = kept;
        // A click there opens *Inspect*.
        let shows = actions[before..].iter().any(|action| matches!(action, Action::Show(_)));
        (shows && matches!(panel, Panel::Resources | Panel::Graph)).then_some(Panel::Inspect)
    }

    fn draw(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        panel: Panel,
        (actions, hovered): (&mut Vec<Action>, &mut Option<Shown>),
    ) {
        match panel {
            // It scrolls by itself.
            Panel::Graph => graph::show(ui, view, &mut self.graph, self.whole, actions),
            _ => {
                ScrollArea::both()
                    .id_salt(panel.title())
                    .auto_shrink(false)
                    .show(ui, |ui| self.scrolled(ui, view, panel, (&mut *actions, hovered)));
            }
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
            Panel::Passes => passes::show(ui, view, &mut self.passes, (actions, hovered)),
            Panel::Resources => resources::show(ui, view, &mut self.resources, self.whole, actions),
            Panel::Params => params::show(ui, view, (&mut self.params, &mut self.preset), actions),
            Panel::Inspect => inspect::show(ui, view, actions),
            Panel::Compare => compare::show(ui, &view.compare, &mut self.picture, actions),
            Panel::World => world::show(ui, &view.world, &mut self.fields, actions),
            Panel::Frame => frame::show(ui, &view.frame, actions),
            Panel::Timeline => {
                if let Some(timeline) = &view.timeline {
                    let memory = (&mut self.timeline, self.whole);
                    timeline::show(ui, timeline, view.status.paused, memory, actions);
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

/// Draws the tabs of the docks.
struct Tabs<'a, 'v> {
    panels: &'a mut Panels,
    view: &'a View<'v>,
    actions: &'a mut Vec<Action>,
    hovered: &'a mut Option<Shown>,
    /// The part of the window without docks.
    free: Option<Rect>,
    /// A panel to be opened, and one that was closed.
    opened: Option<Panel>,
    closed: Option<Panel>,
}

impl TabViewer for Tabs<'_, '_> {
    type Tab = Tab;

    fn title(&mut self, tab: &mut Tab) -> WidgetText {
        match tab {
            Tab::Picture => "Picture".into(),
            Tab::Panel(panel) => panel.title().into(),
        }
    }

    fn ui(&mut self, ui: &mut Ui, tab: &mut Tab) {
        match *tab {
            Tab::Picture => self.free = Some(ui.clip_rect()),
            Tab::Panel(panel) => {
                let opened = self.panels.content(ui, self.view, panel, (&mut *self.actions, &mut *self.hovered));
                self.opened = opened.or(self.opened);
            }
        }
    }

    fn on_close(&mut self, tab: &mut Tab) -> egui_dock::tab_viewer::OnCloseResponse {
        if let Tab::Panel(panel) = *tab {
            self.closed = Some(panel);
        }
        egui_dock::tab_viewer::OnCloseResponse::Close
    }

    fn is_closeable(&self, tab: &Tab) -> bool {
        *tab != Tab::Picture
    }

    fn allowed_in_windows(&self, tab: &mut Tab) -> bool {
        *tab != Tab::Picture
    }

    fn clear_background(&self, tab: &Tab) -> bool {
        *tab != Tab::Picture
    }

    fn scroll_bars(&self, _: &Tab) -> [bool; 2] {
        // Panels scroll by themselves.
        [false, false]
    }
}

/// Draws a panel, or repeats its last shapes if it shows the same.
fn keep(kept: &mut ShapeCache, ui: &mut Ui, view: &View<'_>, panel: Panel, draw: impl FnOnce(&mut Ui)) {
    let status = &view.status;
    let passes = |timed| Timed { passes: &view.passes, timed };
    match panel {
        Panel::Passes => {
            let span = view.frame.gpu.map(|span| [span.median(), span.p95()]);
            kept.show(ui, &(passes(true), view.resources, &status.locked, &span), draw);
        }
        Panel::Resources => kept.show(ui, &(passes(false), view.resources, &status.shown), draw),
        Panel::Graph => {
            let thumbnails = view.thumbnails.iter().map(|found| (found.pass, found.resource, found.number, found.size));
            let thumbnails: Vec<_> = thumbnails.collect();
            kept.show(ui, &(passes(true), view.resources, &status.shown, &*thumbnails), draw);
        }
        Panel::Frame => kept.show(ui, &frame::content(&view.frame), draw),
        Panel::Timeline => kept.show(ui, &(view.timeline.as_slice(), &status.paused), draw),
        Panel::Problems => {
            let generations = (status.generation, status.failed);
            kept.show(ui, &(&generations, &view.checks_bounds, view.problems), draw);
        }
        Panel::Params => {
            let (file, has_demo) = (status.graph_file.as_str(), view.timeline.is_some());
            kept.show(ui, &(&*view.params, &*view.presets, &view.records, file, &has_demo), draw);
        }
        Panel::Inspect => {
            let inspected = view.inspected.map_or(&[][..], std::slice::from_ref);
            kept.show(ui, &(&status.shown, inspected), draw);
        }
        Panel::Compare => kept.show(ui, &&view.compare, draw),
        Panel::World => kept.show(ui, &world::content(&view.world), draw),
    }
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
