//! The events of a slow frame, so that each press and release of a button meets what lies under it.

use egui::{Event, RawInput};

/// Splits the input of one frame if the pointer moves on after a press or a release. egui looks once for the widget under the pointer for each
/// input, at the pointer's last place. So in a long frame, a drag would begin at its end.
///
/// It also splits before a press or a release at a new place of the pointer. An untouched panel has widgets only from the part on in which
/// the pointer comes to it.
pub fn split_input(mut input: RawInput) -> Vec<RawInput> {
    let events = std::mem::take(&mut input.events);
    let mut parts = vec![Vec::new()];
    // What the pointer did last: nothing, a move, or a press or release.
    let mut pressed = None;
    for event in events {
        let presses = match event {
            Event::PointerMoved(_) => Some(false),
            Event::PointerButton { .. } => Some(true),
            _ => None,
        };
        if presses.is_some() && pressed.is_some() && presses != pressed {
            parts.push(Vec::new());
        }
        pressed = presses.or(pressed);
        if let Some(part) = parts.last_mut() {
            part.push(event);
        }
    }
    let whole = |(index, events)| RawInput {
        events,
        // Files that are dropped on the window are dropped once.
        dropped_files: if index == 0 { input.dropped_files.clone() } else { Vec::new() },
        ..input.clone()
    };
    parts.into_iter().enumerate().map(whole).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{CentralPanel, Context, Modifiers, PointerButton, Pos2, Rect, Sense, pos2, vec2};

    fn button(pos: Pos2, pressed: bool) -> Event {
        Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
    }

    /// Which of two fields, one over the other, are dragged or clicked by these events of one frame.
    fn touched(context: &Context, split: impl Fn(RawInput) -> Vec<RawInput>, events: Vec<Event>) -> Vec<&'static str> {
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(200.0, 100.0)));
        let mut touched = Vec::new();
        for input in split(RawInput { screen_rect, events, ..RawInput::default() }) {
            let _ = context.run(input, |context| {
                CentralPanel::default().show(context, |ui| {
                    for (name, left) in [("key", 10.0), ("beside", 110.0)] {
                        let rect = Rect::from_min_size(pos2(left, 10.0), vec2(80.0, 80.0));
                        let response = ui.interact(rect, ui.id().with(name), Sense::click_and_drag());
                        touched.extend((response.dragged() || response.clicked()).then_some(name));
                    }
                });
            });
        }
        touched.dedup();
        touched
    }

    #[test]
    fn a_drag_belongs_to_what_was_pressed_although_the_frame_took_long() {
        let [from, to] = [pos2(50.0, 50.0), pos2(150.0, 50.0)];
        let events = || vec![Event::PointerMoved(from), button(from, true), Event::PointerMoved(to)];
        for (split, expected) in [(split_input as fn(_) -> _, &["key"][..]), (|input| vec![input], &[])] {
            let context = Context::default();
            touched(&context, split, Vec::new());
            assert_eq!(touched(&context, split, events()), expected);
        }
    }

    #[test]
    fn a_click_belongs_to_what_was_clicked_although_the_pointer_went_on() {
        let [at, on] = [pos2(50.0, 50.0), pos2(150.0, 50.0)];
        let context = Context::default();
        touched(&context, split_input, Vec::new());
        let events = vec![Event::PointerMoved(at), button(at, true), button(at, false), Event::PointerMoved(on)];
        assert_eq!(touched(&context, split_input, events), ["key"]);
    }

    #[test]
    fn input_without_buttons_stays_whole() {
        let events = vec![Event::PointerMoved(pos2(1.0, 1.0)), Event::PointerMoved(pos2(2.0, 1.0)), Event::Copy];
        let parts = split_input(RawInput { events: events.clone(), ..RawInput::default() });
        assert_eq!(parts.into_iter().map(|part| part.events).collect::<Vec<_>>(), [events]);
    }
}
