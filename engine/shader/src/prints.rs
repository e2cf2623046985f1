//! What a shader prints: the buffer that it needs, and the texts that its records stand for.

use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, Span, codes};
use raxel_spirv::{PrintCall, PrintError, PrintedScalar, PrintedType, Printing, RECORD_HEAD, RECORDS};
use serde::Serialize;

use crate::lexer;
use crate::messages;
use crate::print_format::{self, Piece};
use crate::sources::Sources;

/// The text by which `rx_assert` of `raxel/print.glsl` is known.
const ASSERTION: &str = "rx_assert";

/// What a shader prints with `debugPrintfEXT` and `rx_assert`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Prints {
    /// The binding, in set 0, of the storage buffer that it prints to.
    pub binding: u32,
    /// Bytes of that buffer. It holds zeros when a frame begins.
    pub bytes: u64,
    /// The calls that print.
    pub calls: Vec<Call>,
}

/// One call that prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Call {
    /// Where it is, when the source is known.
    pub place: Option<Span>,
    /// File and line of that place, counted from 1.
    pub line: Option<(Arc<str>, u32)>,
    /// Whether it is an assertion: then it prints when that fails.
    pub assertion: bool,
    /// The text, or the assertion, as the source has it.
    pub text: Arc<str>,
    #[serde(skip)]
    pieces: Vec<Piece>,
    #[serde(skip)]
    values: Vec<PrintedType>,
    #[serde(skip)]
    first_word: u32,
}

/// What a call has left in the buffer.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// How often it was reached.
    pub reached: u32,
    /// The first records, in no order.
    pub records: Vec<Record>,
}

/// What one invocation printed by one call.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Numbers the records of a pass as they were written.
    pub order: u32,
    /// `gl_GlobalInvocationID`.
    pub invocation: [u32; 3],
    /// The text with the values.
    pub text: String,
}

impl Prints {
    /// From the calls of a module. What is wrong with them goes to `wrong`.
    pub(crate) fn of(printing: &Printing, binding: u32, sources: &Sources<'_>, wrong: &mut Vec<Diagnostic>) -> Self {
        let calls = printing.calls.iter().filter_map(|call| match Call::of(call, sources) {
            Ok(call) => Some(call),
            Err(reason) => {
                let error = PrintError { reason, line: call.line.clone() };
                wrong.push(unprintable(&error, sources));
                None
            }
        });
        Self { binding, bytes: printing.bytes, calls: calls.collect() }
    }
}

impl Call {
    fn of(call: &PrintCall, sources: &Sources<'_>) -> Result<Self, String> {
        let assertion = call.format == ASSERTION;
        let pieces = print_format::pieces(&call.format)?;
        let conversions = pieces.iter().filter(|piece| matches!(piece, Piece::Value(_))).count();
        let given = call.values.len();
        if conversions != given {
            return Err(format!(
                "its text has {conversions} conversion{}, and it has {given} value{}",
                s(conversions),
                s(given)
            ));
        }
        let word = if assertion { ASSERTION } else { "debugPrintfEXT" };
        let place = call.line.as_ref().and_then(|(file, line)| {
            let range = messages::place(sources.text(file)?, *line as usize, Some(word));
            Some(Span::new(file.as_str(), range))
        });
        let source = place.as_ref().filter(|_| assertion).and_then(|place| {
            let text = sources.text(&place.file)?.get(place.range.start..)?;
            Some(argument(text).unwrap_or(ASSERTION))
        });
        Ok(Self {
            line: place.as_ref().zip(call.line.as_ref()).map(|(place, (_, line))| (place.file.clone(), *line)),
            place,
            assertion,
            text: source.unwrap_or(&call.format).into(),
            pieces,
            values: call.values.clone(),
            first_word: call.first_word,
        })
    }

    /// What it has left in the words of the buffer. Words beyond their end count as zeros.
    pub fn recorded(&self, words: &[u32]) -> Recorded {
        let at = self.first_word as usize;
        let reached = words.get(at).copied().unwrap_or(0);
        let head = RECORD_HEAD as usize;
        let stride = head + self.values.iter().map(|value| value.components as usize).sum::<usize>();
        let part = words.get(at + 1..).unwrap_or(&[]);
        let records = part.chunks_exact(stride).take(reached.min(RECORDS) as usize).map(|record| Record {
            order: record[0],
            invocation: [record[1], record[2], record[3]],
            text: self.shown(&record[head..]),
        });
        Recorded { reached, records: records.collect() }
    }

    fn shown(&self, mut words: &[u32]) -> String {
        if self.assertion {
            return self.text.to_string();
        }
        let mut shown = String::new();
        let mut types = self.values.iter();
        for piece in &self.pieces {
            match piece {
                Piece::Text(text) => shown.push_str(text),
                Piece::Value(conversion) => {
                    let ty =
                        types.next().copied().unwrap_or(PrintedType { scalar: PrintedScalar::Uint, components: 0 });
                    let (value, rest) = words.split_at((ty.components as usize).min(words.len()));
                    shown.push_str(&conversion.value(ty, value));
                    words = rest;
                }
            }
        }
        shown
    }
}

/// `rx_assert(…)` with its argument, at the beginning of a text.
fn argument(text: &str) -> Option<&str> {
    let mut depth = 0usize;
    for token in lexer::tokens(text) {
        match token.text {
            "(" => depth += 1,
            ")" if depth <= 1 => return Some(&text[..token.range().end]),
            ")" => depth -= 1,
            ";" if depth == 0 => return None,
            _ => {}
        }
    }
    None
}

fn s(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// What is said of a call that cannot print.
pub(crate) fn unprintable(error: &PrintError, sources: &Sources<'_>) -> Diagnostic {
    let message = format!("`debugPrintfEXT` cannot print this: {}", error.reason);
    let diagnostic = Diagnostic::error(codes::shader::UNPRINTABLE, message);
    let Some((file, line)) = &error.line else { return diagnostic };
    let Some(text) = sources.text(file) else { return diagnostic.note(format!("at {file}:{line}")) };
    let range = messages::place(text, *line as usize, Some("debugPrintfEXT"));
    sources.with_chain(diagnostic.label(Span::new(file.as_str(), range), "printed here"), file)
}
