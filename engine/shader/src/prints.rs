//! A shader's prints, its accesses out of bounds, and its writes of a texel: the buffer that it needs, and the meaning of its records.

use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, Span, codes};
use raxel_spirv::{AccessKind, PrintCall, PrintError, PrintedScalar, PrintedType, RECORD_HEAD, RECORDS, Recording};
use serde::Serialize;

use crate::lexer;
use crate::messages;
use crate::print_format::{self, Piece};
use crate::sources::Sources;
use crate::writes::Writes;

/// The text that marks a print as that of `rx_assert` in `raxel/print.glsl`.
const ASSERTION: &str = "rx_assert";

/// A shader's prints with `debugPrintfEXT` and `rx_assert`, its accesses that are checked, and its writes that are recorded.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Prints {
    /// The binding, in set 0, of the storage buffer that it prints to.
    pub binding: u32,
    /// Bytes of that buffer. It holds zeros when a frame begins.
    pub bytes: u64,
    /// The calls that print.
    pub calls: Vec<Call>,
    /// The accesses that are checked.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub accesses: Vec<Access>,
    /// The writes of texels that are recorded, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub writes: Option<Writes>,
}

/// An access to an array, a vector, a matrix or an image that is compared with its bounds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Access {
    /// Where it is, when the source is known.
    pub place: Option<Span>,
    /// The accessed array or image, by its name in the source.
    pub name: Arc<str>,
    /// Whether it writes.
    pub writes: bool,
    #[serde(skip)]
    kind: AccessKind,
    #[serde(skip)]
    first_word: u32,
}

/// An access that was out of bounds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutOfBounds {
    /// How often.
    pub count: u32,
    /// The invocation that was the first: `gl_GlobalInvocationID`.
    pub invocation: [u32; 3],
    /// The index, and the size: `index 70 of 64 elements`.
    pub beyond: String,
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

/// The records of a call in the buffer.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// How often it was reached.
    pub reached: u32,
    /// The first records, in no order.
    pub records: Vec<Record>,
}

/// The print of one invocation by one call.
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
    /// From the calls of a module. Mistakes in them go to `wrong`.
    pub(crate) fn of(recording: &Recording, binding: u32, sources: &Sources<'_>, wrong: &mut Vec<Diagnostic>) -> Self {
        let accesses = recording.accesses.iter().map(|access| Access::of(access, sources)).collect();
        let calls = recording.calls.iter().filter_map(|call| match Call::of(call, sources) {
            Ok(call) => Some(call),
            Err(reason) => {
                let error = PrintError { reason, line: call.line.clone() };
                wrong.push(unprintable(&error, sources));
                None
            }
        });
        let writes = recording.writes.as_ref().map(|writes| Writes::of(writes, sources));
        Self { binding, bytes: recording.bytes, calls: calls.collect(), accesses, writes }
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

    /// Its records in the words of the buffer. Words beyond their end count as zeros.
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

impl Access {
    fn of(access: &raxel_spirv::Access, sources: &Sources<'_>) -> Self {
        let word =
            access.name.rsplit('.').next().map(|name| name.trim_end_matches("[]")).filter(|name| !name.is_empty());
        let place = access.line.as_ref().and_then(|(file, line)| {
            let range = messages::place(sources.text(file)?, *line as usize, word);
            Some(Span::new(file.as_str(), range))
        });
        Self {
            place,
            name: access.name.as_str().into(),
            writes: access.writes,
            kind: access.kind,
            first_word: access.first_word,
        }
    }

    /// Its record in the words of the buffer, if it was out of bounds.
    pub fn recorded(&self, words: &[u32]) -> Option<OutOfBounds> {
        let (count, record) = words.get(self.first_word as usize..)?.split_first()?;
        let coordinates = self.kind.coordinates() as usize;
        let values = record.get(RECORD_HEAD as usize..)?.get(..2 * coordinates)?;
        let (at, sizes) = values.split_at(coordinates);
        let list = |words: &[u32], between: &str| {
            words.iter().map(|word| word.cast_signed().to_string()).collect::<Vec<_>>().join(between)
        };
        let beyond = match self.kind {
            AccessKind::Element => format!("index {} of {}", list(at, ""), elements(sizes[0])),
            AccessKind::Texel(_) => format!("texel ({}) of {}", list(at, ", "), list(sizes, "×")),
        };
        let invocation = [record[1], record[2], record[3]];
        (*count > 0).then_some(OutOfBounds { count: *count, invocation, beyond })
    }
}

fn elements(count: u32) -> String {
    format!("{count} element{}", s(count as usize))
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

/// The message about a call that cannot print.
pub(crate) fn unprintable(error: &PrintError, sources: &Sources<'_>) -> Diagnostic {
    let message = format!("`debugPrintfEXT` cannot print this: {}", error.reason);
    let diagnostic = Diagnostic::error(codes::shader::UNPRINTABLE, message);
    let Some((file, line)) = &error.line else { return diagnostic };
    let Some(text) = sources.text(file) else { return diagnostic.note(format!("at {file}:{line}")) };
    let range = messages::place(text, *line as usize, Some("debugPrintfEXT"));
    sources.with_chain(diagnostic.label(Span::new(file.as_str(), range), "printed here"), file)
}
