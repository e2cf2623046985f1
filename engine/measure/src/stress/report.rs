//! The results of a run, row by row.

use raxel_oracle::metrics::Errors;

use super::judge::{Differences, Sample, Tally, WRONG_KEPT};
use super::plan::{Plan, Row};

/// The result of one row.
#[derive(Clone, Debug)]
pub struct RowReport {
    /// Who.
    pub row: Row,
    /// By site and set; rays are 0 where the site does not fit.
    pub errors: Vec<Vec<Errors>>,
    /// Sites that it could not trace.
    pub refused: Vec<Refused>,
    /// Why it traces nothing at all.
    pub unusable: Option<String>,
    /// Seconds that the device (or for the port, the CPU) took to trace.
    pub seconds: f64,
    /// Rays in that time.
    pub timed: u64,
    /// The first wrong rays.
    pub wrong: Vec<Sample>,
    /// Of the port: how it differs from the device.
    pub differs: Option<Differences>,
}

/// Why a row did not trace a site.
#[derive(Clone, Debug)]
pub struct Refused {
    /// The site's number.
    pub site: usize,
    /// The reason.
    pub why: String,
    /// The device had no memory left: its limits would have allowed it.
    pub out_of_memory: bool,
}

impl RowReport {
    pub(super) fn new(row: &Row, plan: &Plan) -> Self {
        Self {
            row: row.clone(),
            errors: vec![vec![Errors::default(); plan.sets.len()]; plan.sites.len()],
            refused: Vec::new(),
            unusable: None,
            seconds: 0.0,
            timed: 0,
            wrong: Vec::new(),
            differs: None,
        }
    }

    /// One set over all sites.
    pub fn set(&self, set: usize) -> Errors {
        self.errors.iter().map(|sets| sets[set]).fold(Errors::default(), Errors::and)
    }

    /// One site over all sets.
    pub fn site(&self, site: usize) -> Errors {
        self.errors[site].iter().copied().fold(Errors::default(), Errors::and)
    }

    /// All sites and sets.
    pub fn total(&self) -> Errors {
        (0..self.errors.len()).map(|site| self.site(site)).fold(Errors::default(), Errors::and)
    }

    /// Millions of rays a second.
    pub fn mrays(&self) -> Option<f64> {
        (self.seconds > 0.0).then(|| self.timed as f64 / self.seconds / 1e6)
    }

    pub(super) fn refuse(&mut self, site: usize, why: String) {
        self.refused.push(Refused { site, why, out_of_memory: false });
    }

    pub(super) fn add(&mut self, site: usize, tally: Tally) {
        for (all, one) in self.errors[site].iter_mut().zip(&tally.sets) {
            *all = all.and(*one);
        }
        let room = WRONG_KEPT.saturating_sub(self.wrong.len());
        self.wrong.extend(tally.wrong.into_iter().take(room));
    }
}

/// The results of a run.
#[derive(Clone, Debug)]
pub struct Report {
    /// Row by row.
    pub rows: Vec<RowReport>,
    /// Rays that the exact tracer answered: each once, however many rows trace it.
    pub answered: u64,
    /// Seconds that took, on all cores.
    pub answer_seconds: f64,
    /// Seconds of the whole run.
    pub seconds: f64,
}
