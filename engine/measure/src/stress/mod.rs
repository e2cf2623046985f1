//! Tracers held to the exact one over sets of rays × scenes × methods, in any number of rays: `raxel stress`. Each ray is made and judged
//! once and traced by every method. Memory is bounded for any number of rays, and the same plan makes the same rays on every machine, with
//! any number of cores.

mod edited;
mod invariants;
mod judge;
mod onward;
mod plan;
mod posed;
mod report;
mod run;
mod single;
mod stored;
mod streamed;
mod truth;

pub use invariants::{Invariants, invariants};
pub use judge::{Differences, Sample, Tally};
pub use plan::{Plan, Row, Site, Sites};
pub use report::{Refused, Report, RowReport};
pub use run::{Progress, run};
pub use single::{Said, Single, single};
pub use truth::Truth;
