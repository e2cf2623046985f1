//! The window's own changes, step by step, for undo and redo.

use raxel_graph::checked::Value;
use raxel_panels::view::Map;
use raxel_runtime::camera::Camera;

use super::write_back::Written;

/// Steps that are kept.
const MOST: usize = 256;

/// A change that the window has made.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Step {
    /// An edit of the world. The session keeps it.
    World,
    /// Files were written.
    Files(Files),
    /// Params had other values.
    Params(Vec<Change>),
    /// The camera was elsewhere.
    Camera {
        /// Where it was.
        before: Pose,
        /// Where it went.
        after: Pose,
    },
    /// Texels became colours in another way.
    Display {
        /// `None` for the way of the graph.
        before: Option<Map>,
        /// `None` for the way of the graph.
        after: Option<Map>,
    },
}

/// Who says where the camera is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Pose {
    /// The demo that drives.
    Demo,
    /// The user, who has put it there.
    At(Camera),
}

/// Files that were written.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Files {
    /// Their values before.
    pub written: Vec<Written>,
    /// Params that had these values in the window only, and have them in the files now. Undo gives the window its values back.
    pub params: Vec<(String, Value)>,
}

/// A param, and its values before and after.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Change {
    /// Its name.
    pub name: String,
    /// `None` for the value of the file.
    pub before: Option<Value>,
    /// `None` for the value of the file.
    pub after: Option<Value>,
}

/// The steps that were made, and the undone ones, oldest first.
#[derive(Debug, Default)]
pub(crate) struct History {
    done: Vec<Step>,
    undone: Vec<Step>,
    /// The last step is a motion of a widget that goes on.
    moving: bool,
    /// Where the camera was before the flight that goes on.
    flight: Option<Pose>,
}

impl Step {
    /// Whether it changes only what is seen of world and graph.
    fn is_of_view(&self) -> bool {
        matches!(self, Step::Camera { .. } | Step::Display { .. })
    }
}

impl History {
    /// Notes a step. Undone steps can no longer be redone, unless the step is a look at what was undone.
    pub(crate) fn note(&mut self, step: Step) {
        if !step.is_of_view() {
            self.undone.clear();
        }
        self.moving = false;
        self.done.push(step);
        if self.done.len() > MOST {
            // Many flights must not push edits out.
            let oldest = self.done.iter().position(Step::is_of_view).unwrap_or(0);
            self.done.remove(oldest);
        }
    }

    /// Notes another value of a param. All values of one motion, until [`Self::let_go`], are one step.
    pub(crate) fn note_param(&mut self, change: Change) {
        if let Some(Step::Params(last)) = self.motion()
            && let [last] = last.as_mut_slice()
            && last.name == change.name
        {
            last.after = change.after;
            return;
        }
        self.note(Step::Params(vec![change]));
        self.moving = true;
    }

    /// Notes another way of showing. All ways of one motion, until [`Self::let_go`], are one step.
    pub(crate) fn note_display(&mut self, before: Option<Map>, after: Option<Map>) {
        if let Some(Step::Display { after: last, .. }) = self.motion() {
            *last = after;
            return;
        }
        self.note(Step::Display { before, after });
        self.moving = true;
    }

    /// The step of a motion that goes on.
    fn motion(&mut self) -> Option<&mut Step> {
        if self.moving { self.done.last_mut() } else { None }
    }

    /// The camera flies, and was there before. All motions until [`Self::land`] are one step.
    pub(crate) fn fly(&mut self, before: Pose) {
        self.flight.get_or_insert(before);
    }

    /// Whether a flight goes on.
    pub(crate) fn flies(&self) -> bool {
        self.flight.is_some()
    }

    /// The flight has ended, if one went on.
    pub(crate) fn land(&mut self, after: Pose) {
        if let Some(before) = self.flight.take().filter(|before| *before != after) {
            self.note(Step::Camera { before, after });
        }
    }

    /// Nothing of a panel is held any more: the next value of a widget is another step.
    pub(crate) fn let_go(&mut self) {
        self.moving = false;
    }

    /// Takes the newest step out, to be undone.
    pub(crate) fn take_done(&mut self) -> Option<Step> {
        self.moving = false;
        self.done.pop()
    }

    /// Takes the step out that was undone last, to be made again.
    pub(crate) fn take_undone(&mut self) -> Option<Step> {
        self.moving = false;
        self.undone.pop()
    }

    /// A step was undone: this makes it again.
    pub(crate) fn was_undone(&mut self, step: Step) {
        self.undone.push(step);
    }

    /// A step was made again: this undoes it.
    pub(crate) fn was_redone(&mut self, step: Step) {
        self.done.push(step);
    }

    /// Takes the newest of the steps out that a test holds for.
    pub(crate) fn take_last(&mut self, is_it: impl Fn(&Step) -> bool) -> Option<Step> {
        self.moving = false;
        let at = self.done.iter().rposition(is_it)?;
        Some(self.done.remove(at))
    }

    /// The same of the steps that were taken back.
    pub(crate) fn take_last_undone(&mut self, is_it: impl Fn(&Step) -> bool) -> Option<Step> {
        self.moving = false;
        let at = self.undone.iter().rposition(is_it)?;
        Some(self.undone.remove(at))
    }

    /// The files that were written last.
    pub(crate) fn last_write(&self) -> Option<&Files> {
        self.done.iter().rev().find_map(|step| match step {
            Step::Files(files) => Some(files),
            Step::World | Step::Params(_) | Step::Camera { .. } | Step::Display { .. } => None,
        })
    }

    /// Project paths of the files that were written last.
    pub(crate) fn last_files(&self) -> Vec<String> {
        let written = self.last_write().map(|files| files.written.as_slice()).unwrap_or_default();
        written.iter().map(|written| written.file.clone()).collect()
    }

    /// Other files run: values of params before say nothing of them, nor edits of another world.
    pub(crate) fn forget_session(&mut self) {
        self.flight = None;
        self.done.retain(|step| matches!(step, Step::Files(_)));
        self.undone.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(name: &str, before: f32, after: f32) -> Change {
        Change { name: name.to_owned(), before: Some(Value::F32(before)), after: Some(Value::F32(after)) }
    }

    #[test]
    fn a_gesture_is_one_step_and_a_new_step_ends_what_can_be_made_again() {
        let mut history = History::default();
        history.note_param(change("fog", 0.0, 1.0));
        history.note_param(change("fog", 1.0, 2.0));
        assert_eq!(history.take_done(), Some(Step::Params(vec![change("fog", 0.0, 2.0)])));
        history.was_undone(Step::Params(vec![change("fog", 0.0, 2.0)]));
        history.note_param(change("fog", 0.0, 3.0));
        assert_eq!(history.take_undone(), None);
        history.let_go();
        history.note_param(change("fog", 3.0, 4.0));
        history.note_param(change("sun", 0.0, 4.0));
        assert_eq!([(); 4].map(|()| history.take_done().is_some()), [true, true, true, false]);
    }

    #[test]
    fn a_flight_is_one_step_and_a_drag_of_a_range_is_one() {
        let mut history = History::default();
        let at = |x: f64| Pose::At(Camera::at([x, 0.0, 0.0]));
        (0..3).for_each(|x| history.fly(at(f64::from(x))));
        history.note(Step::World);
        history.land(at(3.0));
        history.land(at(4.0));
        assert_eq!(history.take_done(), Some(Step::Camera { before: at(0.0), after: at(3.0) }));
        assert_eq!((history.take_done(), history.take_done()), (Some(Step::World), None));
        history.fly(at(5.0));
        history.land(at(5.0));
        assert_eq!(history.take_done(), None, "it did not move");

        // Who flies to look at what was undone can still redo it, and a thousand flights push no edit out.
        history.note(Step::World);
        history.was_undone(Step::World);
        for x in 0..1000 {
            history.fly(at(f64::from(x)));
            history.land(at(f64::from(x + 1)));
        }
        assert_eq!((history.done.len(), &history.done[0]), (MOST, &Step::World));
        assert_eq!(history.take_undone(), Some(Step::World));

        let map = |high| Some(Map { map: 0, range: Some([0.0, high]), channel: 0 });
        history.note_display(None, map(1.0));
        history.note_display(map(1.0), map(2.0));
        history.let_go();
        history.note_display(map(2.0), None);
        assert_eq!(history.take_done(), Some(Step::Display { before: map(2.0), after: None }));
        assert_eq!(history.take_done(), Some(Step::Display { before: None, after: map(2.0) }));
    }

    #[test]
    fn the_newest_of_a_kind_is_taken_out_and_only_so_many_are_kept() {
        let mut history = History::default();
        for _ in 0..2 * MOST {
            history.note(Step::World);
        }
        history.note_param(change("fog", 0.0, 1.0));
        assert_eq!(history.take_last(|step| *step == Step::World), Some(Step::World));
        assert_eq!(history.done.len(), MOST - 1);
        assert!(history.last_files().is_empty() && matches!(history.done.last(), Some(Step::Params(_))));
        history.forget_session();
        assert!(history.done.is_empty());
    }
}
