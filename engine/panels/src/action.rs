//! The user's requests.

use raxel_picture::Sought;

use crate::view::{Brush, CompareMode, FileKind, Lane, Map, Shown};

/// The file that values of params are written into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteTo {
    /// The graph's own file: it overrides inherited values.
    Own,
    /// The one that each default stands in, which other graphs may extend as well.
    Declared,
}

/// One thing that a panel asks the window to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Show this from now on.
    Show(Shown),
    /// Show what the graph presents.
    ShowDefault,
    /// Show this while the pointer rests on its pass; `None` ends it.
    Peek(Option<Shown>),
    /// Map texels to colours in another way than the graph says; `None` goes back to the graph's own.
    Display(Option<Map>),
    /// Show this part of the inspected buffer, from an element on.
    Rows(u64),
    /// Write the inspected buffer to a file of comma-separated values.
    WriteTable,
    /// Set a param: its components, in the order of its type.
    SetParam(String, Vec<f64>),
    /// Bring a param back to the value in its file.
    ResetParam(String),
    /// Write the values of these params into a file.
    WriteParams(Vec<String>, WriteTo),
    /// Make keys of the demo of params that are moved, or not any more.
    Record(bool),
    /// Keep the values of all params under a name.
    SavePreset(String),
    /// Set the params to the values of this name.
    ApplyPreset(String),
    /// Forget the values of this name.
    DeletePreset(String),
    /// Put the files that were written last back as they were.
    UndoWrite,
    /// Pin another texel of the shown target.
    Pin([u32; 2]),
    /// Put the pin of this number on another texel.
    MovePin(u32, [u32; 2]),
    /// Make the pin of this number the active one, whose history is shown.
    ChoosePin(u32),
    /// Let go of the pin of this number.
    Unpin(u32),
    /// Pin the next texel whose channel has what is looked for, or the one before, in any slice of the shown target.
    Find {
        /// The wanted values.
        sought: Sought,
        /// The channel.
        channel: u32,
        /// The next one in order of slices and rows, else the one before.
        forward: bool,
    },
    /// End the search.
    StopFind,
    /// Keep the shown picture, to compare with it.
    Keep,
    /// Compare with the target that is shown now, as it goes on.
    KeepLive,
    /// Compare with the picture in this file.
    KeepFile(String),
    /// Let go of the kept picture.
    ForgetKept,
    /// The comparison of the kept picture with the shown target.
    CompareMode(CompareMode),
    /// Show the kept picture alone, or not any more.
    Flip,
    /// The factor of differences.
    Gain(f32),
    /// Measure the difference between the shown target and the kept picture.
    Measure,
    /// List the files of the project, for [`View::files`](crate::View::files).
    ListFiles,
    /// Open a file of the project, by its project path, in place of what runs.
    Open(FileKind, String),
    /// Stop or start the clock.
    Pause,
    /// Let one frame pass.
    Step,
    /// Start over.
    Reset,
    /// Pixels of the output for each pixel of the window, along each axis.
    Scale(f64),
    /// Most frames a second; `None` for as many as there can be.
    FpsCap(Option<u32>),
    /// Put a text on the clipboard.
    Copy(String),
    /// Open a place, `path:line:column`, in the user's editor.
    Edit(String),
    /// Give up the pass that the device works on, and switch it off until its shader or its part of the graph changes.
    Cancel,
    /// Compile the shaders with checks of the bounds of their accesses, or without them.
    CheckBounds(bool),
    /// Compile the shaders so that they tell who writes the pinned texel, or without that.
    FindWriters(bool),
    /// Put the demo at this number of seconds.
    Seek(f64),
    /// Start the demo over at its end, or stay there.
    Loop(bool),
    /// Let the demo drive again.
    HandBack,
    /// Write another time of a key into the demo's file.
    MoveKey {
        /// Its track.
        lane: Lane,
        /// Its index in the track.
        key: usize,
        /// Seconds.
        to: f64,
    },
    /// Take a key out of the demo's file.
    DeleteKey {
        /// Its track.
        lane: Lane,
        /// Its index in the track.
        key: usize,
    },
    /// Write the camera into the demo's file, as a key at this time.
    RecordKey,
    /// Put the camera where a camera of the world is.
    Camera(String),
    /// Put the camera where it began.
    Home,
    /// Put the camera on the clipboard, as the lines of a world's file.
    CopyCamera,
    /// Write the camera into the world's file under a name.
    WriteCamera(String),
    /// Voxels that the camera flies in a second.
    Speed(f64),
    /// The effect of the right mouse button on voxels from now on.
    Brush(Brush),
    /// Take the newest edit back.
    Undo,
    /// Make the edit again that was taken back last.
    Redo,
}
