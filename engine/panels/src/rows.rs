//! Long lists. A row out of sight is not made: it keeps its place by the size of its last draw.

use std::hash::Hash;

use egui::{Id, Ui, Vec2};

/// Sizes of the rows of a list. Each row has this number of cells.
#[derive(Clone, Debug)]
pub(crate) struct Rows<const CELLS: usize>(Vec<Option<(Id, [Vec2; CELLS])>>);

impl<const CELLS: usize> Default for Rows<CELLS> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<const CELLS: usize> Rows<CELLS> {
    /// Draws a row of a list or a grid, or leaves it out. `words` are all that its size depends on, and `draw` gives the sizes of its cells;
    /// a cell of no size is none.
    pub(crate) fn add(
        &mut self,
        ui: &mut Ui,
        index: usize,
        words: impl Hash,
        draw: impl FnOnce(&mut Ui) -> [Vec2; CELLS],
    ) {
        let id = Id::new((words, ui.ctx().pixels_per_point().to_bits()));
        if self.0.len() <= index {
            self.0.resize(index + 1, None);
        }
        let known = self.0[index].filter(|(known, _)| *known == id).map(|(_, cells)| cells);
        let top = ui.cursor().top();
        let below = |cells: [Vec2; CELLS]| top + cells.iter().map(|cell| cell.y).fold(0.0, f32::max);
        let sight = ui.clip_rect();
        match known.filter(|cells| top > sight.bottom() || below(*cells) < sight.top()) {
            Some(cells) => cells.into_iter().filter(|cell| *cell != Vec2::ZERO).for_each(|cell| {
                ui.allocate_space(cell);
            }),
            None => self.0[index] = Some((id, draw(ui))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{CentralPanel, Context, Grid, Pos2, RawInput, Rect, ScrollArea, vec2};

    /// Draws a hundred numbers in a grid, this one long. Returns the numbers that were made, and the size of all.
    fn drawn(context: &Context, rows: &mut Rows<1>, long: usize) -> (Vec<usize>, Vec2) {
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(200.0, 100.0)));
        let (mut made, mut size) = (Vec::new(), Vec2::ZERO);
        let _ = context.run(RawInput { screen_rect, ..RawInput::default() }, |context| {
            made.clear();
            CentralPanel::default().show(context, |ui| {
                let list = ScrollArea::both().show(ui, |ui| {
                    Grid::new("list").show(ui, |ui| {
                        for index in 0..100 {
                            let text = index.to_string().repeat(if index == long { 40 } else { 1 });
                            rows.add(ui, index, &text, |ui| {
                                made.push(index);
                                [ui.label(&text).rect.size()]
                            });
                            ui.end_row();
                        }
                    });
                });
                size = list.content_size;
            });
        });
        (made, size)
    }

    #[test]
    fn rows_out_of_sight_keep_their_place_and_are_made_when_they_change() {
        let (context, mut rows) = (Context::default(), Rows::default());
        drawn(&context, &mut rows, 99);
        let (_, whole) = drawn(&context, &mut Rows::default(), 99);
        let (made, size) = drawn(&context, &mut rows, 99);
        assert!(made.len() < 10 && made[0] == 0, "{made:?}");
        assert_eq!(size, whole);
        let (made, _) = drawn(&context, &mut rows, 50);
        assert!(made.ends_with(&[50, 99]), "{made:?}");
        // None is long: the column is as wide as the others need.
        drawn(&context, &mut rows, 100);
        assert!(drawn(&context, &mut rows, 100).1.x < whole.x);
    }
}
