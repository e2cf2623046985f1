//! If a panel shows the same as before, and nobody touches it, its last shapes are drawn again.
//!
//! egui makes every widget again in each frame, which takes a few microseconds a widget. A frame of a renderer has no time for hundreds of
//! them, and most panels show the same for seconds.

use std::any::Any;
use std::sync::Arc;

use egui::epaint::{ClippedPrimitive, ClippedShape, Primitive};
use egui::text_selection::LabelSelectionState;
use egui::{Color32, Context, FontId, Galley, Id, LayerId, Popup, Rect, Shape, Style, Ui};

/// Seconds after a change until nothing of a panel moves any more: a header that opens, a bar that fades.
const SETTLES: f64 = 0.3;

/// A pointer within this number of points beside a panel may take hold of something in it.
const REACH: f32 = 12.0;

/// The contents of a panel, borrowed, to compare with its last contents.
pub(crate) trait Content {
    /// The same, owned.
    type Kept: 'static;

    /// Whether it is as it was.
    fn is(&self, kept: &Self::Kept) -> bool;

    /// Makes a copy of it.
    fn keep(&self) -> Self::Kept;
}

impl<T: PartialEq + ToOwned<Owned: 'static> + ?Sized> Content for &T {
    type Kept = T::Owned;

    fn is(&self, kept: &T::Owned) -> bool {
        **self == *std::borrow::Borrow::<T>::borrow(kept)
    }

    fn keep(&self) -> T::Owned {
        (*self).to_owned()
    }
}

/// A tuple is as it was if each part of it is.
macro_rules! tuple {
    ($($part:ident $kept:ident),+) => {
        impl<$($part: Content),+> Content for ($($part,)+) {
            type Kept = ($($part::Kept,)+);

            #[expect(non_snake_case, reason = "variables have the names of their types")]
            fn is(&self, ($($kept,)+): &Self::Kept) -> bool {
                let ($($part,)+) = self;
                $($part.is($kept))&&+
            }

            #[expect(non_snake_case, reason = "variables have the names of their types")]
            fn keep(&self) -> Self::Kept {
                let ($($part,)+) = self;
                ($($part.keep(),)+)
            }
        }
    };
}

tuple!(A KeptA, B KeptB);
tuple!(A KeptA, B KeptB, C KeptC);
tuple!(A KeptA, B KeptB, C KeptC, D KeptD);
tuple!(A KeptA, B KeptB, C KeptC, D KeptD, E KeptE);

/// The place and the style of a part of a panel.
struct Place {
    id: Id,
    layer: LayerId,
    room: Rect,
    clip: Rect,
    opacity: f32,
    pixels_per_point: f32,
    style: Arc<Style>,
    /// A text in the layout of the fonts. New fonts give a new layout, with other glyphs in place of the old ones.
    probe: Arc<Galley>,
}

impl Place {
    fn of(ui: &Ui) -> Self {
        let probe = ui.fonts_mut(|fonts| fonts.layout_no_wrap("0".to_owned(), FontId::default(), Color32::WHITE));
        Self {
            id: ui.id(),
            layer: ui.layer_id(),
            room: ui.available_rect_before_wrap(),
            clip: ui.clip_rect(),
            opacity: ui.opacity(),
            pixels_per_point: ui.ctx().pixels_per_point(),
            style: ui.ctx().style(),
            probe,
        }
    }

    fn is(&self, other: &Self) -> bool {
        let place =
            |of: &Self| (of.id, of.layer, of.room, of.clip, of.opacity.to_bits(), of.pixels_per_point.to_bits());
        place(self) == place(other) && Arc::ptr_eq(&self.style, &other.style) && Arc::ptr_eq(&self.probe, &other.probe)
    }
}

/// The last shapes of a part of a panel.
#[derive(Default)]
pub(crate) struct ShapeCache(Option<Drawn>);

struct Drawn {
    content: Box<dyn Any>,
    place: Place,
    /// The pass of egui in which it was drawn last.
    pass: u64,
    /// Seconds of egui's clock until which it is drawn with all of its widgets.
    settled: f64,
    /// Its shapes and its extent, once it has settled.
    shapes: Option<(Vec<ClippedShape>, Rect)>,
}

impl std::fmt::Debug for ShapeCache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let shapes = self.0.as_ref().and_then(|drawn| drawn.shapes.as_ref()).map(|(shapes, _)| shapes.len());
        f.debug_struct("ShapeCache").field("shapes", &shapes).finish_non_exhaustive()
    }
}

impl ShapeCache {
    /// Draws a part of a panel. The output of `draw` must depend only on `content`, and on the user's actions in it.
    pub(crate) fn show<C: Content>(&mut self, ui: &mut Ui, content: &C, draw: impl FnOnce(&mut Ui)) {
        let (ctx, place) = (ui.ctx().clone(), Place::of(ui));
        let (now, pass) = (ctx.input(|input| input.time), ctx.cumulative_pass_nr());
        let touched = is_touched(&ctx, place.room.intersect(place.clip));
        // A part that was not drawn for a while may have lost textures or state.
        let drawn = self.0.as_mut().filter(|drawn| drawn.pass + 1 == pass && drawn.place.is(&place));
        let drawn = drawn.filter(|drawn| drawn.content.downcast_ref().is_some_and(|kept| content.is(kept)));
        let settled = now + SETTLES;
        let Some(drawn) = drawn else {
            self.0 = Some(Drawn { content: Box::new(content.keep()), place, pass, settled, shapes: None });
            ui.scope(draw);
            return;
        };
        drawn.pass = pass;
        if touched {
            (drawn.settled, drawn.shapes) = (settled, None);
        }
        if let Some((shapes, extent)) = &drawn.shapes {
            ctx.graphics_mut(|graphics| {
                let list = graphics.entry(place.layer);
                for ClippedShape { clip_rect, shape } in shapes {
                    list.add(*clip_rect, shape.clone());
                }
            });
            ui.advance_cursor_after_rect(*extent);
            return;
        }
        let first = ctx.graphics_mut(|graphics| graphics.entry(place.layer).next_idx().0);
        let extent = ui.scope(draw).response.rect;
        if now >= drawn.settled {
            let all = ctx.graphics(|graphics| {
                let list = graphics.get(place.layer);
                list.map_or_else(Vec::new, |list| list.all_entries().skip(first).cloned().collect())
            });
            drawn.shapes = Some((triangles(&ctx, all), extent));
        }
    }
}

/// The same shapes, as triangles where these never change: letters and discs lie in a texture that may grow.
fn triangles(ctx: &Context, shapes: Vec<ClippedShape>) -> Vec<ClippedShape> {
    let (mut all, mut run) = (Vec::new(), Vec::new());
    for shape in shapes {
        match shape.shape {
            Shape::Noop => {}
            Shape::Rect(_) | Shape::Path(_) | Shape::LineSegment { .. } => run.push(shape),
            _ => {
                tessellate(ctx, std::mem::take(&mut run), &mut all);
                all.push(shape);
            }
        }
    }
    tessellate(ctx, run, &mut all);
    all
}

fn tessellate(ctx: &Context, shapes: Vec<ClippedShape>, all: &mut Vec<ClippedShape>) {
    if shapes.is_empty() {
        return;
    }
    for ClippedPrimitive { clip_rect, primitive } in ctx.tessellate(shapes, ctx.pixels_per_point()) {
        if let Primitive::Mesh(mesh) = primitive {
            all.push(ClippedShape { clip_rect, shape: Shape::mesh(mesh) });
        }
    }
}

/// Whether a panel in this area has to answer the user: the pointer is in it, or something is dragged, written, open or selected.
fn is_touched(ctx: &Context, area: Rect) -> bool {
    let near = ctx.input(|input| input.pointer.latest_pos()).is_some_and(|at| area.expand(REACH).contains(at));
    let selects = || ctx.with_plugin(|labels: &mut LabelSelectionState| labels.has_selection()) == Some(true);
    let writes = || ctx.memory(|memory| memory.focused().is_some());
    near || ctx.is_using_pointer() || writes() || Popup::is_any_open(ctx) || selects()
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{CentralPanel, Event, Pos2, RawInput, pos2, vec2};

    /// Draws a text in a frame at this time; whether its widget was made, and what was painted.
    fn made(context: &Context, kept: &mut ShapeCache, text: &str, (time, events): (f64, Vec<Event>)) -> (bool, usize) {
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(200.0, 100.0)));
        let mut made = false;
        let input = RawInput { screen_rect, time: Some(time), events, ..RawInput::default() };
        let output = context.run(input, |context| {
            CentralPanel::default().show(context, |ui| {
                kept.show(ui, &text, |ui| {
                    made = true;
                    ui.label(text);
                });
            });
        });
        (made, output.shapes.len())
    }

    #[test]
    fn widgets_are_made_when_something_changes_and_while_somebody_is_near() {
        let (context, mut kept) = (Context::default(), ShapeCache::default());
        let mut at = |text: &str, time: f64, events: Vec<Event>| made(&context, &mut kept, text, (time, events));
        let (first, shapes) = at("a", 0.0, Vec::new());
        assert!(first && at("a", 0.1, Vec::new()).0, "until it has settled");
        assert!(at("a", 0.5, Vec::new()).0, "once more, to be kept");
        assert_eq!(at("a", 0.6, Vec::new()), (false, shapes), "the same is painted");
        assert!(at("b", 0.7, Vec::new()).0, "another text");
        at("b", 1.1, Vec::new());
        assert!(!at("b", 1.2, Vec::new()).0);
        assert!(at("b", 1.3, vec![Event::PointerMoved(pos2(20.0, 20.0))]).0, "the pointer comes");
        assert!(at("b", 9.0, Vec::new()).0, "and rests");
        assert!(at("b", 9.1, vec![Event::PointerGone]).0, "what it lit fades");
        at("b", 9.5, Vec::new());
        assert!(!at("b", 9.6, Vec::new()).0);
        context.set_zoom_factor(2.0);
        at("b", 9.7, Vec::new());
        assert!(at("b", 9.8, Vec::new()).0, "all is larger");
    }

    #[test]
    fn what_was_hidden_for_a_frame_is_made_anew() {
        let (context, mut kept) = (Context::default(), ShapeCache::default());
        for time in [0.0, 0.1, 0.5] {
            made(&context, &mut kept, "a", (time, Vec::new()));
        }
        assert!(!made(&context, &mut kept, "a", (0.6, Vec::new())).0);
        let _ = context.run(RawInput { time: Some(0.7), ..RawInput::default() }, |_| {});
        assert!(made(&context, &mut kept, "a", (0.8, Vec::new())).0);
        // A window that opens again has other fonts.
        for time in [0.9, 1.0, 1.5] {
            made(&context, &mut kept, "a", (time, Vec::new()));
        }
        assert!(made(&Context::default(), &mut kept, "a", (1.6, Vec::new())).0);
    }
}
