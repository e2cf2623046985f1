//! The comparison of the picture.

/// How the shown target and the kept picture are shown together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CompareMode {
    /// The shown target alone.
    #[default]
    Off,
    /// Both, side by side at an edge.
    Wipe,
    /// The shown target minus the kept picture.
    Difference,
}

impl CompareMode {
    /// All, in the order of the key that goes through them.
    pub const ALL: [CompareMode; 3] = [CompareMode::Off, CompareMode::Wipe, CompareMode::Difference];

    /// A word for it.
    pub fn word(self) -> &'static str {
        match self {
            CompareMode::Off => "off",
            CompareMode::Wipe => "wipe",
            CompareMode::Difference => "difference",
        }
    }
}

/// The figures of a comparison.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Figures {
    /// There is no request.
    #[default]
    None,
    /// They are being found.
    Awaited,
    /// They cannot be found, and why.
    Refused(String),
    /// As `raxel compare` has them.
    Found {
        /// The name of the picture that was compared with the kept one.
        of: String,
        /// Mean FLIP error.
        flip: f64,
        /// Root of the mean square of the differences.
        rmse: f64,
        /// Largest difference.
        max: f64,
        /// Pixels that differ, and all of them.
        differing: [u64; 2],
    },
}

/// The comparison of the shown target.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compare {
    /// The kept picture in words; `None` before anything is kept.
    pub kept: Option<String>,
    /// It is a target of the running graph, as it is in each frame.
    pub live: bool,
    /// How both are shown.
    pub mode: CompareMode,
    /// The kept picture is shown alone.
    pub flipped: bool,
    /// Place of the edge, as a share of the window's width.
    pub edge: f64,
    /// The factor of differences.
    pub gain: f32,
    /// Why the two cannot be compared.
    pub refused: Option<String>,
    /// How far they are apart.
    pub figures: Figures,
}

impl Compare {
    /// Whether the edge of a wipe is in the picture.
    pub fn has_edge(&self) -> bool {
        self.kept.is_some() && self.refused.is_none() && !self.flipped && self.mode == CompareMode::Wipe
    }
}
