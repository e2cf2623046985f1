//! What the title bar says.

/// The state that the title shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Title {
    /// Name of the graph.
    pub graph: String,
    /// Debug target.
    pub target: String,
    /// Milliseconds a frame takes.
    pub milliseconds: Option<f64>,
    /// The clock stands still.
    pub paused: bool,
    /// Generation shown.
    pub generation: u64,
    /// A newer generation that could not be built.
    pub failed: Option<u64>,
}

impl Title {
    /// The text.
    pub fn text(&self) -> String {
        let mut parts = vec![self.graph.clone(), self.target.clone()];
        parts.extend(self.milliseconds.map(|ms| format!("{ms:.1} ms")));
        if self.paused {
            parts.push("paused".to_owned());
        }
        parts.extend(self.failed.map(|failed| format!("gen {failed} failed: showing gen {}", self.generation)));
        format!("{} — raxel", parts.join(" · "))
    }
}

#[cfg(test)]
mod tests {
    use super::Title;

    #[test]
    fn says_what_is_shown_and_what_is_wrong() {
        let title = Title {
            graph: "primary".into(),
            target: "depth".into(),
            milliseconds: Some(4.26),
            generation: 16,
            ..Title::default()
        };
        assert_eq!(title.text(), "primary · depth · 4.3 ms — raxel");
        let title = Title { paused: true, failed: Some(17), ..title };
        assert_eq!(title.text(), "primary · depth · 4.3 ms · paused · gen 17 failed: showing gen 16 — raxel");
    }
}
