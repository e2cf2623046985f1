//! The graph as a picture: passes and resources as nodes, from left to right. A drag moves it, the wheel zooms.

use std::collections::HashMap;

use egui::epaint::CubicBezierShape;
use egui::{
    Align2, Color32, ColorImage, Context, FontId, Painter, Pos2, Rect, Response, Sense, Stroke, StrokeKind,
    TextureHandle, TextureOptions, Ui, Vec2, pos2, vec2,
};

use crate::action::Action;
use crate::frame::milliseconds;
use crate::graph_layout::{Drawing, Node, Of, lay_out};
use crate::passes;
use crate::samples::Samples;
use crate::view::{PassState, Shown, Thumbnail, View};

/// Points between the middles of columns and of rows, at a zoom of 1; and between rows where targets have thumbnails.
const STEP: Vec2 = vec2(150.0, 44.0);
const ROW: f32 = 100.0;

/// Points of a node of a pass, and of one of a resource.
const PASS: Vec2 = vec2(124.0, 34.0);
const RESOURCE: Vec2 = vec2(116.0, 22.0);

/// Points around a thumbnail.
const MARGIN: f32 = 4.0;

/// Smallest and largest zoom.
const ZOOMS: [f32; 2] = [0.15, 2.0];

const RAN: Color32 = Color32::from_rgb(46, 82, 58);
const IDLE: Color32 = Color32::from_rgb(58, 60, 66);
const OFF: Color32 = Color32::from_rgb(110, 44, 40);
const HELD: Color32 = Color32::from_rgb(40, 58, 88);
const LINE: Color32 = Color32::from_rgb(110, 120, 140);

/// Which part of the picture is seen.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Camera {
    /// The place in the middle of the panel and the zoom; `None` shows all of the graph.
    at: Option<(Pos2, f32)>,
}

/// Thumbnails as textures, by the indices of pass and resource, with the number of the thumbnail.
#[derive(Default)]
pub(crate) struct Textures(HashMap<[usize; 2], (u64, TextureHandle)>, Option<Context>);

impl std::fmt::Debug for Textures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Textures").field("count", &self.0.len()).finish_non_exhaustive()
    }
}

impl Textures {
    /// Takes what is new, and lets go of what is no longer there.
    fn update(&mut self, context: &Context, thumbnails: &[Thumbnail]) {
        // A window that is opened anew has a context of its own, without the textures of the old one.
        if self.1.replace(context.clone()).is_some_and(|before| before != *context) {
            self.0.clear();
        }
        self.0.retain(|of, _| thumbnails.iter().any(|thumbnail| [thumbnail.pass, thumbnail.resource] == *of));
        for thumbnail in thumbnails {
            let of = [thumbnail.pass, thumbnail.resource];
            if self.0.get(&of).is_some_and(|(number, _)| *number == thumbnail.number) {
                continue;
            }
            let image = ColorImage::from_rgba_unmultiplied(thumbnail.size, &thumbnail.rgba);
            if let Some((number, texture)) = self.0.get_mut(&of) {
                *number = thumbnail.number;
                texture.set(image, TextureOptions::LINEAR);
            } else {
                let texture = context.load_texture("thumbnail", image, TextureOptions::LINEAR);
                self.0.insert(of, (thumbnail.number, texture));
            }
        }
    }

    /// The panel is closed.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    fn of(&self, node: &Node) -> Option<&TextureHandle> {
        match node.of {
            Of::Resource { resource, after: Some(pass) } => self.0.get(&[pass, resource]).map(|(_, texture)| texture),
            Of::Resource { after: None, .. } | Of::Pass(_) => None,
        }
    }
}

/// Draws the panel.
pub(crate) fn show(
    ui: &mut Ui,
    view: &View<'_>,
    camera: &mut Camera,
    textures: &mut Textures,
    actions: &mut Vec<Action>,
) {
    textures.update(ui.ctx(), &view.thumbnails);
    let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
    let area = response.rect;
    let drawing = lay_out(&view.passes, view.resources);
    if drawing.nodes.is_empty() {
        ui.put(area, egui::Label::new("The graph has no passes."));
        return;
    }
    let size = |node: &Node| size(node, textures);
    let row = if view.thumbnails.is_empty() { STEP.y } else { ROW };
    let center = |node: &Node| pos2(node.column as f32 * STEP.x, node.row * row);
    let place = |node: &Node| Rect::from_center_size(center(node), size(node));
    let fit = fitting(drawing.nodes.iter().map(place), area);
    follow(ui, &response, camera, fit);
    let (middle, zoom) = camera.at.unwrap_or(fit);
    let screen = |at: Pos2| area.center() + (at - middle) * zoom;
    let rects: Vec<Rect> =
        (drawing.nodes.iter()).map(|node| Rect::from_center_size(screen(center(node)), size(node) * zoom)).collect();
    let hovered = hovered(ui, &response, &rects);
    for [from, to] in &drawing.edges {
        let near = hovered.is_some_and(|node| node == *from || node == *to);
        edge(&painter, [rects[*from].right_center(), rects[*to].left_center()], near);
    }
    for (index, node) in drawing.nodes.iter().enumerate().filter(|(index, _)| rects[*index].intersects(area)) {
        let seen = is_shown(view, &drawing, index);
        let thumbnail = textures.of(node);
        let picture = NodePicture { rect: rects[index], zoom, hovered: hovered == Some(index), seen, thumbnail };
        draw(ui, &painter, view, node, &picture);
        interact(ui, view, (index, node), rects[index].intersect(area), actions);
    }
}

fn size(node: &Node, textures: &Textures) -> Vec2 {
    match (node.of, textures.of(node)) {
        (Of::Pass(_), _) => PASS,
        (Of::Resource { .. }, None) => RESOURCE,
        (Of::Resource { .. }, Some(texture)) => RESOURCE + vec2(0.0, texture.size_vec2().y + MARGIN),
    }
}

/// The middle and the zoom that show all nodes.
fn fitting(nodes: impl Iterator<Item = Rect>, area: Rect) -> (Pos2, f32) {
    let all = nodes.fold(Rect::NOTHING, Rect::union);
    let room = (area.size() - vec2(16.0, 16.0)).max(vec2(1.0, 1.0)) / all.size();
    (all.center(), room.min_elem().clamp(ZOOMS[0], 1.0))
}

/// Moves and zooms as the pointer asks; a double click shows all again.
fn follow(ui: &Ui, response: &Response, camera: &mut Camera, fit: (Pos2, f32)) {
    if response.double_clicked() {
        camera.at = None;
    }
    let (middle, zoom) = camera.at.unwrap_or(fit);
    if response.dragged() {
        camera.at = Some((middle - response.drag_delta() / zoom, zoom));
    }
    let scroll = ui.input(|input| input.smooth_scroll_delta.y);
    if let Some(pointer) = response.hover_pos().filter(|_| scroll != 0.0) {
        let larger = (zoom * (scroll / 200.0).exp()).clamp(ZOOMS[0], ZOOMS[1]);
        // What is under the pointer stays there.
        let from_middle = pointer - response.rect.center();
        camera.at = Some((middle + from_middle / zoom - from_middle / larger, larger));
    }
}

fn hovered(ui: &Ui, response: &Response, rects: &[Rect]) -> Option<usize> {
    let at = ui.input(|input| input.pointer.hover_pos()).filter(|at| response.rect.contains(*at))?;
    rects.iter().position(|rect| rect.contains(at))
}

fn edge(painter: &Painter, [from, to]: [Pos2; 2], near: bool) {
    let bend = vec2((to.x - from.x).max(20.0) * 0.4, 0.0);
    let stroke = if near { Stroke::new(2.0, Color32::WHITE) } else { Stroke::new(1.0, LINE) };
    let points = [from, from + bend, to - bend, to];
    painter.add(CubicBezierShape::from_points_stroke(points, false, Color32::TRANSPARENT, stroke));
}

/// How a node is drawn.
struct NodePicture<'t> {
    rect: Rect,
    zoom: f32,
    hovered: bool,
    /// It is what the window shows.
    seen: bool,
    /// What a target holds.
    thumbnail: Option<&'t TextureHandle>,
}

fn draw(ui: &Ui, painter: &Painter, view: &View<'_>, node: &Node, picture: &NodePicture<'_>) {
    let NodePicture { rect, zoom, hovered, seen, thumbnail } = *picture;
    let (name, below, fill, lit) = match node.of {
        Of::Pass(index) => {
            let pass = &view.passes[index];
            let time = pass.times.and_then(Samples::median).map(|time| format!("{} ms", milliseconds(Some(time))));
            let (below, fill) = match pass.state {
                PassState::Ran => (time.unwrap_or_default(), RAN),
                PassState::Off => (pass.state.word().to_owned(), OFF),
                state => (state.word().to_owned(), IDLE),
            };
            (pass.name, below, fill, pass.state.is_planned())
        }
        Of::Resource { resource, after } => {
            let lit = after.is_none_or(|pass| view.passes[pass].state.is_planned());
            (view.resources[resource].name.as_str(), String::new(), HELD, lit)
        }
    };
    let fill = if lit { fill } else { fill.gamma_multiply(0.5) };
    let corner = if matches!(node.of, Of::Pass(_)) { 3.0 } else { RESOURCE.y * zoom / 2.0 };
    painter.rect_filled(rect, corner, fill);
    if seen || hovered {
        let stroke = Stroke::new(if seen { 2.0 } else { 1.0 }, Color32::WHITE);
        painter.rect_stroke(rect, corner, stroke, StrokeKind::Outside);
    }
    let mut words = rect;
    if let Some(texture) = thumbnail {
        let size = texture.size_vec2() * zoom;
        let corner = pos2(rect.center().x - size.x / 2.0, rect.top() + MARGIN * zoom);
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        let tint = if lit { Color32::WHITE } else { Color32::GRAY };
        painter.image(texture.id(), Rect::from_min_size(corner, size), whole, tint);
        *words.top_mut() += size.y + MARGIN * zoom;
    }
    // Letters that nobody can read are left out.
    if zoom < 0.4 {
        return;
    }
    let font = FontId::proportional((11.0 * zoom).round().max(5.0));
    let visuals = ui.visuals();
    let color = if lit { visuals.text_color() } else { visuals.weak_text_color() };
    let inside = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    let line = if below.is_empty() { Vec2::ZERO } else { vec2(0.0, 7.0 * zoom) };
    inside.text(words.center() - line, Align2::CENTER_CENTER, name, font.clone(), color);
    inside.text(words.center() + line, Align2::CENTER_CENTER, below, font, visuals.weak_text_color());
}

/// Whether the window shows what a node stands for. At the end of the frame, that is a resource as the last pass leaves it.
fn is_shown(view: &View<'_>, drawing: &Drawing, index: usize) -> bool {
    let shown = &view.status.shown;
    let resource = |node: &Node| match node.of {
        Of::Resource { resource, .. } => Some(resource),
        Of::Pass(_) => None,
    };
    let node = &drawing.nodes[index];
    let Some(of) = resource(node) else { return false };
    if shown.after.is_none() {
        let last = !drawing.nodes[index + 1..].iter().any(|later| resource(later) == Some(of));
        return last && shown.resource == view.resources[of].name;
    }
    target(view, node).is_some_and(|target| shown.is_at(&target))
}

/// What a click on a node shows.
fn target(view: &View<'_>, node: &Node) -> Option<Shown> {
    match node.of {
        Of::Pass(index) => passes::target(view, index),
        Of::Resource { resource, .. } if view.resources[resource].opaque => None,
        Of::Resource { resource, after } => {
            let found = &view.resources[resource];
            let pass = after.map(|pass| view.passes[pass].after.to_owned());
            let used = after.and_then(|pass| found.uses.get(pass)).copied().unwrap_or_default();
            Some(Shown::after(found.name.clone(), pass).part(used))
        }
    }
}

fn interact(ui: &Ui, view: &View<'_>, (index, node): (usize, &Node), rect: Rect, actions: &mut Vec<Action>) {
    let name = match node.of {
        Of::Pass(index) => format!("pass {}", view.passes[index].name),
        Of::Resource { resource, after: Some(pass) } => {
            format!("{} as {} leaves it", view.resources[resource].name, view.passes[pass].name)
        }
        Of::Resource { resource, after: None } => format!("{} from before", view.resources[resource].name),
    };
    let response = ui.interact(rect, ui.id().with(("node", index)), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &name));
    if response.clicked()
        && let Some(target) = target(view, node)
    {
        actions.push(Action::Show(target));
    }
    response.on_hover_ui(|ui| match node.of {
        Of::Pass(index) => passes::about(ui, view, index),
        Of::Resource { resource, .. } => {
            ui.label(&name);
            ui.label(&view.resources[resource].about);
            ui.weak(&view.resources[resource].memory);
        }
    });
}
