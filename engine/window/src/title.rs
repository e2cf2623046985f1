//! The text of the title bar.

use raxel_panels::view::Busy;

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
    /// Seconds of the take that is being recorded.
    pub recording: Option<f64>,
    /// Generation shown.
    pub generation: u64,
    /// A newer generation that could not be built.
    pub failed: Option<u64>,
    /// There is no plan for the wanted size or debug target.
    pub refused: bool,
    /// There was no picture yet.
    pub starting: bool,
    /// The device has worked for long.
    pub busy: Option<Busy>,
    /// A pass that is switched off, since the device was lost while it ran.
    pub off: Option<String>,
    /// A demo's line of text.
    pub caption: Option<String>,
}

impl Title {
    /// The text.
    pub(crate) fn text(&self) -> String {
        let mut parts = vec![self.graph.clone(), self.target.clone()];
        parts.extend(self.milliseconds.map(|ms| format!("{ms:.1} ms")));
        if self.paused {
            parts.push("paused".to_owned());
        }
        parts.extend(self.recording.map(|seconds| format!("recording {seconds:.0} s")));
        parts.extend(self.failed.map(|failed| format!("gen {failed} failed: showing gen {}", self.generation)));
        if self.refused {
            parts.push("refused: showing the last plan".to_owned());
        }
        if self.starting && self.busy.is_none() {
            parts.push("making the first picture".to_owned());
        }
        parts.extend(self.off.as_ref().map(|pass| format!("`{pass}` is off")));
        parts.extend(self.busy.as_ref().map(|Busy { pass, seconds }| {
            let pass = pass.as_ref().map_or_else(String::new, |pass| format!(" on `{pass}`"));
            format!("working{pass} for {seconds} s")
        }));
        parts.extend(self.caption.as_ref().map(|line| format!("“{line}”")));
        format!("{} — raxel", parts.join(" · "))
    }
}

#[cfg(test)]
mod tests {
    use super::{Busy, Title};

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
        let busy = Title {
            refused: true,
            busy: Some(Busy { pass: Some("spin".into()), seconds: 3 }),
            milliseconds: None,
            ..title.clone()
        };
        assert_eq!(busy.text(), "primary · depth · refused: showing the last plan · working on `spin` for 3 s — raxel");
        let starting = Title { starting: true, milliseconds: None, ..title.clone() };
        assert_eq!(starting.text(), "primary · depth · making the first picture — raxel");
        assert!(!Title { starting: true, ..busy }.text().contains("first picture"));
        let off = Title { off: Some("spin".into()), ..title.clone() };
        assert_eq!(off.text(), "primary · depth · 4.3 ms · `spin` is off — raxel");
        let said = Title { caption: Some("a flight".into()), ..title.clone() };
        assert_eq!(said.text(), "primary · depth · 4.3 ms · “a flight” — raxel");
        let take = Title { recording: Some(12.4), ..title.clone() };
        assert_eq!(take.text(), "primary · depth · 4.3 ms · recording 12 s — raxel");
        let title = Title { paused: true, failed: Some(17), ..title };
        assert_eq!(title.text(), "primary · depth · 4.3 ms · paused · gen 17 failed: showing gen 16 — raxel");
    }
}
