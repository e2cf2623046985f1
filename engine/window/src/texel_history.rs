//! The pinned texel over the passes of a frame, and over frames; and who wrote it.

use std::collections::VecDeque;

use raxel_execute::{InvocationWrite, PassWrites, ReadTicket, TexelTrace, TracedTexel};
use raxel_panels::view;
use raxel_runtime::Session;

use super::inspector::texel;

/// Frames whose values are kept: four seconds at sixty frames a second.
const KEPT: usize = 240;

/// A texel that is followed, and what is known of it.
#[derive(Default)]
pub(crate) struct TexelHistory {
    of: Option<TracedTexel>,
    on_their_way: VecDeque<ReadTicket<TexelTrace>>,
    newest: Option<TexelTrace>,
    /// After each frame that wrote it, oldest first: the channels, as floats.
    frames: VecDeque<[f32; 4]>,
    /// The known writes of each pass, while the user asks for them.
    writers: Option<Vec<PassWrites>>,
}

impl TexelHistory {
    /// Before a frame: follows a texel, or none. What was known of another one is forgotten.
    pub(crate) fn follow(&mut self, session: &mut Session, texel: Option<TracedTexel>) {
        if self.of != texel {
            let writers = self.writers.as_ref().map(|_| Vec::new());
            *self = Self { of: texel.clone(), writers, ..Self::default() };
        }
        if self.writers.is_some() {
            session.find_writers(texel.clone());
        }
        session.trace_texel(texel);
    }

    /// Asks for the writers of the followed texel from the next frame on, or no more.
    pub(crate) fn find_writers(&mut self, session: &mut Session, on: bool) {
        self.writers = on.then(Vec::new);
        if !on {
            session.find_writers(None);
        }
    }

    /// The panel's view of the writers.
    pub(crate) fn view_writers(&self) -> Option<Vec<view::PassWriters>> {
        Some(self.writers.as_ref()?.iter().map(writers_of).collect())
    }

    /// After a frame: takes what has come.
    pub(crate) fn take(&mut self, session: &mut Session) {
        if let Some(writers) = &mut self.writers {
            *writers = session.writers();
        }
        self.on_their_way.extend(session.texel_trace());
        while let Some(ticket) = self.on_their_way.front() {
            match ticket.poll() {
                Ok(Some(trace)) => self.note(trace),
                Ok(None) => return,
                // The next frame opens the device again, and has a trace of its own.
                Err(_) => {}
            }
            self.on_their_way.pop_front();
        }
    }

    fn note(&mut self, trace: TexelTrace) {
        let left = trace.writes.last().and_then(|write| write.texel.floats().first().copied());
        self.frames.extend(left);
        while self.frames.len() > KEPT {
            self.frames.pop_front();
        }
        self.newest = Some(trace);
    }

    /// The panel's view, with one channel over frames; `None` before anything is known.
    pub(crate) fn view(&self, channel: u32) -> Option<view::TexelHistory> {
        let writes = self.newest.as_ref()?.writes.iter().map(|write| view::PassTexel {
            pass: write.pass.clone(),
            values: texel(&write.texel, [0, 0])
                .map(|texel| texel.values.into_iter().map(|[value, _]| value).collect())
                .unwrap_or_default(),
        });
        let channel = channel.min(3) as usize;
        let frames = self.frames.iter().map(|values| Some(values[channel]).filter(|value| value.is_finite()));
        Some(view::TexelHistory { writes: writes.collect(), frames: frames.collect() })
    }
}

fn writers_of(written: &PassWrites) -> view::PassWriters {
    let write = |write: &InvocationWrite| view::TexelWriter {
        place: write.place.as_ref().map(|(file, line)| format!("{file}:{line}")),
        invocation: write.invocation,
        workgroup: write.workgroup,
        values: write.value.texts(4),
    };
    view::PassWriters {
        pass: written.pass.clone(),
        frame: written.frame,
        count: written.count,
        race: written.races(),
        writes: written.writes.iter().map(write).collect(),
    }
}

#[cfg(test)]
mod tests {
    use raxel_execute::{TexelWrite, Texels};
    use raxel_shader::format::Format;

    use super::*;

    #[test]
    fn the_newest_frame_has_its_passes_and_each_frame_its_last_value() {
        let mut history = TexelHistory::default();
        assert_eq!(history.view(0), None);
        let write = |pass: &str, value: f32| TexelWrite {
            pass: pass.to_owned(),
            texel: Texels { format: Format::R32f, width: 1, height: 1, bytes: value.to_le_bytes().to_vec() },
        };
        for frame in 0..KEPT as u64 + 2 {
            let writes = vec![write("clear", 0.0), write("add", frame as f32)];
            history.note(TexelTrace { frame, writes });
        }
        let seen = history.view(0).unwrap();
        let writes: Vec<(&str, &str)> =
            seen.writes.iter().map(|write| (write.pass.as_str(), write.values[0].as_str())).collect();
        assert_eq!(writes, [("clear", "0"), ("add", "241")]);
        assert_eq!((seen.frames.len(), seen.frames[0], seen.frames[KEPT - 1]), (KEPT, Some(2.0), Some(241.0)));
    }
}
