//! The graph as a picture: passes and resources as nodes, from left to right. A drag moves it, the wheel zooms.

use std::collections::HashMap;
use std::sync::Arc;

use egui::epaint::{ClippedShape, CubicBezierShape, Primitive};
use egui::{
    Align2, Color32, ColorImage, Context, FontId, Mesh, Painter, Pos2, Rect, Response, Sense, Shape, Stroke,
    StrokeKind, TextureHandle, TextureOptions, Ui, Vec2, pos2, vec2,
};

use crate::action::Action;
use crate::frame::milliseconds;
use crate::graph_layout::{Drawing, Node, Of, lay_out};
use crate::passes;
use crate::samples::Samples;
use crate::view::{Pass, PassState, Resource, Shown, Thumbnail, Use, View};

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

/// The zoom at which names are read well: a graph that is shown whole only at a smaller one opens at this zoom, around the shown target.
const READ: f32 = 0.7;

const RAN: Color32 = Color32::from_rgb(46, 82, 58);
const IDLE: Color32 = Color32::from_rgb(58, 60, 66);
const OFF: Color32 = Color32::from_rgb(110, 44, 40);
const HELD: Color32 = Color32::from_rgb(40, 58, 88);
const LINE: Color32 = Color32::from_rgb(110, 120, 140);

/// Which part of the picture is seen.
#[derive(Clone, Copy, Debug, Default)]
struct Camera {
    /// The place in the middle of the panel and the zoom; `None` is the first view.
    at: Option<(Pos2, f32)>,
    /// Shows all of the graph, however small.
    whole: bool,
}

/// Where the nodes stand, for the plan that they were placed for last.
#[derive(Debug, Default)]
struct Placed {
    /// How many passes it has, and how they use each resource.
    passes: usize,
    uses: Vec<Vec<Use>>,
    drawing: Drawing,
}

impl Placed {
    /// The nodes of this plan. They are placed again only if a new plan has other passes or resources, or uses them in another way.
    fn of(&mut self, passes: &[Pass<'_>], resources: &[Resource]) -> &Drawing {
        let same = |uses: &[Vec<Use>]| uses.iter().eq(resources.iter().map(|resource| &resource.uses));
        if self.passes != passes.len() || !same(&self.uses) {
            let uses = resources.iter().map(|resource| resource.uses.clone()).collect();
            *self = Self { passes: passes.len(), uses, drawing: lay_out(passes, resources) };
        }
        &self.drawing
    }
}

/// Thumbnails as textures, by the indices of pass and resource, with the number of the thumbnail.
#[derive(Default)]
struct Textures(HashMap<[usize; 2], (u64, TextureHandle)>, Option<Context>);

impl std::fmt::Debug for Textures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Textures").field("count", &self.0.len()).finish_non_exhaustive()
    }
}

impl Textures {
    /// Takes new thumbnails, and drops those that are gone.
    fn update(&mut self, context: &Context, thumbnails: &[Thumbnail]) {
        // A window that opens again has a new context, without the textures of the old one.
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

    fn of(&self, node: &Node) -> Option<&TextureHandle> {
        match node.of {
            Of::Resource { resource, after: Some(pass) } => self.0.get(&[pass, resource]).map(|(_, texture)| texture),
            Of::Resource { after: None, .. } | Of::Pass(_) => None,
        }
    }
}

/// The state of the panel from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    camera: Camera,
    textures: Textures,
    placed: Placed,
    ground: Ground,
}

impl Memory {
    /// Takes thumbnails that are new.
    pub(crate) fn update(&mut self, context: &Context, thumbnails: &[Thumbnail]) {
        self.textures.update(context, thumbnails);
    }

    /// The panel is closed.
    pub(crate) fn close(&mut self) {
        self.textures.0.clear();
    }
}

/// Draws the panel. `whole`: each node is a widget, rather than only the one under the pointer.
pub(crate) fn show(ui: &mut Ui, view: &View<'_>, memory: &mut Memory, whole: bool, actions: &mut Vec<Action>) {
    let Memory { camera, textures, placed, ground } = memory;
    let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
    let area = response.rect;
    let drawing = placed.of(&view.passes, view.resources);
    if drawing.nodes.is_empty() {
        ui.put(area, egui::Label::new("The graph has no passes."));
        return;
    }
    let size = |node: &Node| size(node, textures);
    let row = if view.thumbnails.is_empty() { STEP.y } else { ROW };
    let center = |node: &Node| pos2(node.column as f32 * STEP.x, node.row * row);
    let place = |node: &Node| Rect::from_center_size(center(node), size(node));
    let seen = seen(view, drawing);
    let all = drawing.nodes.iter().map(place).fold(Rect::NOTHING, Rect::union);
    let shown = drawing.nodes.iter().enumerate().find(|(index, _)| seen(*index)).map(|(_, node)| center(node));
    let fit = fitting(all, area);
    let first = if camera.whole { fit } else { readable(fit, all, shown, area) };
    follow(ui, &response, camera, first);
    let (middle, zoom) = camera.at.unwrap_or(if camera.whole { fit } else { first });
    let screen = |at: Pos2| area.center() + (at - middle) * zoom;
    let rects: Vec<Rect> =
        (drawing.nodes.iter()).map(|node| Rect::from_center_size(screen(center(node)), size(node) * zoom)).collect();
    let hovered = hovered(ui, &response, &rects);
    let boxes = drawing.nodes.iter().zip(&rects).enumerate().filter(|(_, (_, rect))| rect.intersects(area));
    let boxes = boxes.map(|(index, (node, rect))| {
        let lit = if seen(index) { Some(2.0) } else { (hovered == Some(index)).then_some(1.0) };
        NodeBox { index, rect: *rect, round: round(node, zoom), fill: fill(view, node), lit }
    });
    let boxes: Vec<NodeBox> = boxes.collect();
    let edges = edges(drawing, &rects, hovered).filter(|edge| edge.is_in(area));
    painter.add(ground.of(ui.ctx(), edges.collect(), boxes));
    for NodeBox { index, rect, .. } in &ground.boxes {
        let node = &drawing.nodes[*index];
        write(ui, &painter, view, node, (*rect, zoom, textures.of(node)));
        if whole || hovered == Some(*index) {
            interact(ui, view, (*index, node), rect.intersect(area), actions);
        }
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
fn fitting(all: Rect, area: Rect) -> (Pos2, f32) {
    let room = (area.size() - vec2(16.0, 16.0)).max(vec2(1.0, 1.0)) / all.size();
    (all.center(), room.min_elem().clamp(ZOOMS[0], 1.0))
}

/// The same, but no smaller than names can be read: then around the shown target, with as little empty ground as possible.
fn readable(fit: (Pos2, f32), all: Rect, shown: Option<Pos2>, area: Rect) -> (Pos2, f32) {
    if fit.1 >= READ {
        return fit;
    }
    let half = area.size() / READ / 2.0;
    let within = |at: f32, from: f32, to: f32| if from < to { at.clamp(from, to) } else { f32::midpoint(from, to) };
    let Pos2 { x, y } = shown.unwrap_or(fit.0);
    let (min, max) = (all.min + half - vec2(8.0, 8.0), all.max - half + vec2(8.0, 8.0));
    (pos2(within(x, min.x, max.x), within(y, min.y, max.y)), READ)
}

/// Moves and zooms as the pointer asks; a double click shows all.
fn follow(ui: &Ui, response: &Response, camera: &mut Camera, first: (Pos2, f32)) {
    if response.double_clicked() {
        *camera = Camera { at: None, whole: true };
    }
    let (middle, zoom) = camera.at.unwrap_or(first);
    if response.dragged() {
        camera.at = Some((middle - response.drag_delta() / zoom, zoom));
    }
    let scroll = ui.input(|input| input.smooth_scroll_delta.y);
    if let Some(pointer) = response.hover_pos().filter(|_| scroll != 0.0) {
        let larger = (zoom * (scroll / 200.0).exp()).clamp(ZOOMS[0], ZOOMS[1]);
        // The point under the pointer stays in place.
        let from_middle = pointer - response.rect.center();
        camera.at = Some((middle + from_middle / zoom - from_middle / larger, larger));
    }
}

fn hovered(ui: &Ui, response: &Response, rects: &[Rect]) -> Option<usize> {
    let at = ui.input(|input| input.pointer.hover_pos()).filter(|at| response.rect.contains(*at))?;
    rects.iter().position(|rect| rect.contains(at))
}

/// A line from node to node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    from: Pos2,
    to: Pos2,
    /// The pointer is over one of the nodes.
    near: bool,
}

impl Edge {
    /// The distance of its control points from its ends.
    fn bend(&self) -> Vec2 {
        vec2((self.to.x - self.from.x).max(20.0) * 0.4, 0.0)
    }

    fn line(&self) -> Shape {
        let Edge { from, to, near } = *self;
        let points = [from, from + self.bend(), to - self.bend(), to];
        let stroke = if near { Stroke::new(2.0, Color32::WHITE) } else { Stroke::new(1.0, LINE) };
        Shape::from(CubicBezierShape::from_points_stroke(points, false, Color32::TRANSPARENT, stroke))
    }

    /// Whether it may be seen in this area: it stays within its ends and the points that bend it.
    fn is_in(&self, area: Rect) -> bool {
        Rect::from_two_pos(self.from, self.to).expand2(self.bend() + Vec2::splat(2.0)).intersects(area)
    }
}

fn edges(drawing: &Drawing, rects: &[Rect], hovered: Option<usize>) -> impl Iterator<Item = Edge> {
    drawing.edges.iter().map(move |[from, to]| Edge {
        from: rects[*from].right_center(),
        to: rects[*to].left_center(),
        near: hovered.is_some_and(|node| node == *from || node == *to),
    })
}

/// The ground of a node that is in sight.
#[derive(Clone, Copy, Debug, PartialEq)]
struct NodeBox {
    index: usize,
    rect: Rect,
    round: f32,
    fill: Color32,
    /// The width of a line around it.
    lit: Option<f32>,
}

/// The triangles of edges and nodes. They are made again only if one of them changes.
#[derive(Debug, Default)]
struct Ground {
    edges: Vec<Edge>,
    boxes: Vec<NodeBox>,
    pixels_per_point: f32,
    mesh: Arc<Mesh>,
}

impl Ground {
    fn of(&mut self, ctx: &Context, edges: Vec<Edge>, boxes: Vec<NodeBox>) -> Arc<Mesh> {
        let pixels_per_point = ctx.pixels_per_point();
        let same = self.pixels_per_point.to_bits() == pixels_per_point.to_bits();
        if !same || self.edges != edges || self.boxes != boxes {
            let lines = edges.iter().map(Edge::line);
            let grounds = boxes.iter().flat_map(|NodeBox { rect, round, fill, lit, .. }| {
                let line = lit.map(|width| Stroke::new(width, Color32::WHITE));
                let line = line.map(|line| Shape::rect_stroke(*rect, *round, line, StrokeKind::Outside));
                [Some(Shape::rect_filled(*rect, *round, *fill)), line].into_iter().flatten()
            });
            let shapes = lines.chain(grounds).map(|shape| ClippedShape { clip_rect: Rect::EVERYTHING, shape });
            let mut mesh = Mesh::default();
            for primitive in ctx.tessellate(shapes.collect(), pixels_per_point) {
                if let Primitive::Mesh(part) = primitive.primitive {
                    mesh.append(part);
                }
            }
            *self = Self { edges, boxes, pixels_per_point, mesh: Arc::new(mesh) };
        }
        self.mesh.clone()
    }
}

/// The radius of the corners of a node.
fn round(node: &Node, zoom: f32) -> f32 {
    if matches!(node.of, Of::Pass(_)) { 3.0 } else { RESOURCE.y * zoom / 2.0 }
}

/// Whether a node has a part in the frame.
fn is_lit(view: &View<'_>, node: &Node) -> bool {
    match node.of {
        Of::Pass(pass) => view.passes[pass].state.is_planned(),
        Of::Resource { after, .. } => after.is_none_or(|pass| view.passes[pass].state.is_planned()),
    }
}

fn fill(view: &View<'_>, node: &Node) -> Color32 {
    let fill = match node.of {
        Of::Pass(pass) => match view.passes[pass].state {
            PassState::Ran => RAN,
            PassState::Off => OFF,
            _ => IDLE,
        },
        Of::Resource { .. } => HELD,
    };
    if is_lit(view, node) { fill } else { fill.gamma_multiply(0.5) }
}

/// Draws what stands in a node: its thumbnail, its name, and of a pass its time or why it has none.
fn write(
    ui: &Ui,
    painter: &Painter,
    view: &View<'_>,
    node: &Node,
    (rect, zoom, thumbnail): (Rect, f32, Option<&TextureHandle>),
) {
    let lit = is_lit(view, node);
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
    let (name, below) = match node.of {
        Of::Pass(index) => {
            let pass = &view.passes[index];
            let time = pass.times.filter(|_| pass.state == PassState::Ran).and_then(Samples::median);
            let time = time.map(|time| format!("{} ms", milliseconds(Some(time))));
            (pass.name, time.unwrap_or_else(|| pass.state.word().to_owned()))
        }
        Of::Resource { resource, .. } => (view.resources[resource].name.as_str(), String::new()),
    };
    let font = FontId::proportional((11.0 * zoom).round().max(5.0));
    let visuals = ui.visuals();
    let color = if lit { visuals.text_color() } else { visuals.weak_text_color() };
    let inside = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    let line = if below.is_empty() { Vec2::ZERO } else { vec2(0.0, 7.0 * zoom) };
    inside.text(words.center() - line, Align2::CENTER_CENTER, name, font.clone(), color);
    inside.text(words.center() + line, Align2::CENTER_CENTER, below, font, visuals.weak_text_color());
}

/// The nodes for the shown target of the window. At the end of the frame, that is a resource as the last pass leaves it.
fn seen(view: &View<'_>, drawing: &Drawing) -> impl Fn(usize) -> bool + use<> {
    let shown = &view.status.shown;
    let resource = |node: &Node| match node.of {
        Of::Resource { resource, .. } => Some(resource),
        Of::Pass(_) => None,
    };
    let of = view.resources.iter().position(|resource| resource.name == shown.resource);
    let nodes = &drawing.nodes;
    let of_it = nodes.iter().enumerate().filter(|(_, node)| of.is_some() && resource(node) == of);
    let seen: Vec<usize> = match &shown.after {
        None => of_it.map(|(index, _)| index).next_back().into_iter().collect(),
        Some(_) => of_it
            .filter(|(_, node)| target(view, node).is_some_and(|target| shown.is_at(&target)))
            .map(|(index, _)| index)
            .collect(),
    };
    move |index| seen.contains(&index)
}

/// The view that a click on a node opens.
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
    let name = || match node.of {
        Of::Pass(index) => format!("pass {}", view.passes[index].name),
        Of::Resource { resource, after: Some(pass) } => {
            format!("{} as {} leaves it", view.resources[resource].name, view.passes[pass].name)
        }
        Of::Resource { resource, after: None } => format!("{} from before", view.resources[resource].name),
    };
    let response = ui.interact(rect, ui.id().with(("node", index)), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, name()));
    if response.clicked()
        && let Some(target) = target(view, node)
    {
        actions.push(Action::Show(target));
    }
    response.on_hover_ui(|ui| match node.of {
        Of::Pass(index) => passes::about(ui, view, index),
        Of::Resource { resource, .. } => {
            ui.label(name());
            ui.label(&view.resources[resource].about);
            ui.weak(&view.resources[resource].memory);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(name: &str) -> Pass<'_> {
        Pass { name, after: name, times: None, state: PassState::Ran, groups: "", place: "", output: None }
    }

    fn resource(writes: [bool; 2]) -> Resource {
        let uses = writes.map(|writes| Use { reads: !writes, writes, ..Use::default() }).to_vec();
        Resource { uses, ..Resource::default() }
    }

    #[test]
    fn nodes_are_placed_anew_for_another_plan_only() {
        let mut placed = Placed::default();
        let passes = [pass("a"), pass("b")];
        let mut resources = vec![resource([true, false])];
        let nodes = |placed: &mut Placed, passes: &[Pass<'_>], resources: &[Resource]| {
            let drawing = placed.of(passes, resources);
            assert_eq!(*drawing, lay_out(passes, resources));
            drawing.nodes.as_ptr()
        };
        let first = nodes(&mut placed, &passes, &resources);
        // Another name and another state stand in the same place.
        let renamed = [pass("c"), Pass { state: PassState::Skipped, ..pass("b") }];
        assert_eq!(nodes(&mut placed, &renamed, &resources), first);
        resources[0].uses[1].writes = true;
        nodes(&mut placed, &passes, &resources);
        resources.push(resource([false, true]));
        nodes(&mut placed, &passes, &resources);
        nodes(&mut placed, &passes[..1], &resources);
        nodes(&mut placed, &passes, &[]);
    }
}
