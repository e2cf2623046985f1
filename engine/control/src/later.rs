//! Results that take longer than a frame may: copies from the device, pictures that are coded, files that are read or written. Another thread makes
//! them while the frames of a window go on. Without a window, they are made at once.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread;

use raxel_execute::ReadTicket;
use raxel_runtime::{ReadError, Session};
use serde_json::Value;

use super::answer;
use super::refusal::Refusal;

/// A result that comes later.
pub(super) struct Later<T> {
    /// Before its thread has begun.
    work: Option<Box<dyn Work<T>>>,
    send: Sender<Result<T, Refusal>>,
    made: Receiver<Result<T, Refusal>>,
}

/// Something that is done once.
trait Work<T>: Send {
    /// Whether all copies that it needs are there.
    fn is_ready(&self) -> bool;

    /// Does it. With a session, it waits for the copies.
    fn run(self: Box<Self>, session: Option<&Session>) -> Result<T, Refusal>;
}

/// Work on copies, which come in the order of their tickets.
struct OnCopies<C, F> {
    tickets: Vec<ReadTicket<C>>,
    make: F,
}

impl<C, T, F> Work<T> for OnCopies<C, F>
where
    F: FnOnce(Vec<C>) -> Result<T, Refusal> + Send,
{
    fn is_ready(&self) -> bool {
        // [`Self::run`] reports a copy that was lost with its device.
        self.tickets.iter().all(|ticket| ticket.has_arrived().unwrap_or(true))
    }

    fn run(self: Box<Self>, session: Option<&Session>) -> Result<T, Refusal> {
        let Self { tickets, make } = *self;
        let copy = |ticket: ReadTicket<C>| match session {
            Some(session) => Ok(session.redeem(&ticket)?),
            None => ticket.poll().map_err(ReadError::from)?.ok_or_else(|| Refusal::new("the device has not copied it")),
        };
        make(tickets.into_iter().map(copy).collect::<Result<_, Refusal>>()?)
    }
}

/// Work whose result becomes the line of an answer: the text of a large one takes as long as the work.
struct Lined<T> {
    work: Box<dyn Work<T>>,
    id: Value,
}

impl Work<String> for Lined<Value> {
    fn is_ready(&self) -> bool {
        self.work.is_ready()
    }

    fn run(self: Box<Self>, session: Option<&Session>) -> Result<String, Refusal> {
        let Self { work, id } = *self;
        Ok(answer::line(&id, work.run(session)).to_string())
    }
}

impl<T: Send + 'static> Later<T> {
    /// Made of copies, which are in the order of their tickets.
    pub(crate) fn of<C: 'static>(
        tickets: Vec<ReadTicket<C>>,
        make: impl FnOnce(Vec<C>) -> Result<T, Refusal> + Send + 'static,
    ) -> Self {
        Self::doing(Box::new(OnCopies { tickets, make }))
    }

    /// Made of one copy.
    pub(crate) fn of_one<C: 'static>(
        ticket: ReadTicket<C>,
        make: impl FnOnce(C) -> Result<T, Refusal> + Send + 'static,
    ) -> Self {
        let first = |copies: Vec<C>| copies.into_iter().next().ok_or_else(|| Refusal::new("nothing was copied"));
        Self::of(vec![ticket], move |copies| make(first(copies)?))
    }

    /// Made without a copy.
    pub(crate) fn beside(make: impl FnOnce() -> Result<T, Refusal> + Send + 'static) -> Self {
        Self::of(Vec::<ReadTicket<()>>::new(), move |_| make())
    }

    fn doing(work: Box<dyn Work<T>>) -> Self {
        let (send, made) = channel();
        Self { work: Some(work), send, made }
    }

    /// The result, once it is there. Never waits.
    pub(crate) fn poll(&mut self) -> Option<Result<T, Refusal>> {
        if let Some(work) = self.work.take_if(|work| work.is_ready()) {
            // The thread alone has the sender from here on, so that its panic is noticed.
            let send = std::mem::replace(&mut self.send, channel().0);
            thread::spawn(move || {
                // A program that has gone does not wait for it.
                let _ = send.send(work.run(None));
            });
        }
        match self.made.try_recv() {
            Ok(made) => Some(made),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(Refusal::new("the work on it has ended without a result"))),
        }
    }

    /// The result, which is made at once: where no frame waits for it.
    pub(crate) fn finish(&mut self, session: &Session) -> Result<T, Refusal> {
        match self.work.take() {
            Some(work) => work.run(Some(session)),
            None => self.made.recv().unwrap_or_else(|_| Err(Refusal::new("the work on it has ended without a result"))),
        }
    }
}

impl Later<Value> {
    /// The line of the answer, if the work has not begun.
    pub(crate) fn into_line(self, id: Value) -> Later<String> {
        match self.work {
            Some(work) => Later::doing(Box::new(Lined { work, id })),
            None => Later::beside(move || {
                let made = self.made.recv();
                let lost = |_| Err(Refusal::new("the work on it has ended without a result"));
                Ok(answer::line(&id, made.unwrap_or_else(lost)).to_string())
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_result_comes_from_another_thread_and_polling_does_not_wait() {
        let (go, gate) = channel::<()>();
        let mut later = Later::beside(move || {
            let _ = gate.recv();
            Ok(json!({ "here": thread::current().name() }))
        })
        .into_line(json!(7));
        assert!(later.poll().is_none() && later.poll().is_none());
        go.send(()).unwrap();
        let line = std::iter::repeat_with(|| later.poll()).flatten().next().unwrap().unwrap();
        assert_eq!(serde_json::from_str::<Value>(&line).unwrap(), json!({ "id": 7, "ok": true, "here": null }));
    }

    #[test]
    fn a_refusal_is_an_answer_and_a_panic_is_noticed() {
        let mut refused = Later::<Value>::beside(|| Err(Refusal::new("no"))).into_line(json!(null));
        let line = std::iter::repeat_with(|| refused.poll()).flatten().next().unwrap().unwrap();
        assert!(line.contains(r#""error":"no""#) && line.contains(r#""ok":false"#), "{line}");
        let mut lost = Later::<()>::beside(|| panic!("a test"));
        let why = std::iter::repeat_with(|| lost.poll()).flatten().next().unwrap().unwrap_err();
        assert!(why.error.contains("without a result"), "{why:?}");
    }
}
