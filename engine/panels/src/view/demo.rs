//! A demo: its tracks, and their keys over time.

/// A demo.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timeline {
    /// Its name.
    pub name: String,
    /// Seconds.
    pub duration: f64,
    /// Seconds into it.
    pub time: f64,
    /// It starts over at its end.
    pub looped: bool,
    /// It drives; else the user has taken over.
    pub drives: bool,
    /// The values that it drives over time.
    pub tracks: Vec<Track>,
}

/// The target of a demo's track.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Lane {
    /// The camera.
    Camera,
    /// The param of that name.
    Param(String),
    /// The graph.
    Graphs,
    /// The debug target.
    Show,
    /// The world.
    Edits,
    /// Lines of text over the picture.
    Captions,
    /// The checks of pictures.
    Checks,
    /// The input of that name.
    Input(String),
}

impl Lane {
    /// Whether its keys can be moved and taken out here. The target of a check belongs to its reference, and a press without its release is
    /// another input.
    pub fn movable(&self) -> bool {
        !matches!(self, Lane::Checks | Lane::Input(_))
    }
}

/// A track of a demo.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Its target.
    pub lane: Lane,
    /// Its name.
    pub name: String,
    /// Seconds of its keys, in order.
    pub keys: Vec<f64>,
    /// For how many seconds each of them lasts; empty where they are moments.
    pub lasting: Vec<f64>,
}

impl Track {
    /// A track whose keys are moments.
    pub fn new(lane: Lane, name: &str, keys: Vec<f64>) -> Self {
        Self { lane, name: name.to_owned(), keys, lasting: Vec::new() }
    }

    /// For how many seconds a key lasts.
    pub fn lasts(&self, key: usize) -> f64 {
        self.lasting.get(key).copied().unwrap_or(0.0)
    }
}
