//! Tables of comma-separated values (RFC 4180).

use crate::error::{OutputError, Result};

/// A table in the making: a head, and rows of as many fields.
pub struct Table(csv::Writer<Vec<u8>>);

impl Table {
    /// A table with this head.
    pub fn new<'n>(head: impl Iterator<Item = &'n &'n str>) -> Result<Self> {
        let mut table = Self(csv::Writer::from_writer(Vec::new()));
        table.row(head.map(|name| (*name).to_owned()))?;
        Ok(table)
    }

    /// Adds a row.
    pub fn row(&mut self, fields: impl Iterator<Item = String>) -> Result {
        self.0.write_record(fields).map_err(|error| failed(&error))
    }

    /// The text.
    pub fn finish(self) -> Result<Vec<u8>> {
        self.0.into_inner().map_err(|error| failed(error.error()))
    }
}

fn failed(error: &dyn std::error::Error) -> OutputError {
    OutputError::new(format!("the CSV could not be made: {error}"))
}
