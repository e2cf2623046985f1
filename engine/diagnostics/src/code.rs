//! Stable codes. Each is declared once, in the table of its range, with a page in `docs/errors/` that `raxel explain` prints.

use std::fmt;

use serde::Serialize;

/// A stable diagnostic code such as `RX0113`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(transparent)]
pub struct Code(&'static str);

impl Code {
    /// The code as text, e.g. `RX0113`.
    pub const fn as_str(self) -> &'static str {
        self.0
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// Declares the codes of one range: `pub const NAME: Code = "RX…"`, and `ALL`: (code, Markdown page compiled in).
macro_rules! declare {
    ($($(#[$doc:meta])* $name:ident = $code:literal;)*) => {
        $($(#[$doc])* pub const $name: $crate::Code = $crate::code::make($code);)*

        /// Every code of this range with its page.
        pub const ALL: &[($crate::Code, &str)] =
            &[$(($name, include_str!(concat!(env!("RAXEL_ERROR_PAGES"), "/", $code, ".md")))),*];
    };
}
pub(crate) use declare;

pub(crate) const fn make(code: &'static str) -> Code {
    Code(code)
}
