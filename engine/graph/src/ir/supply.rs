//! Supply: the resources that can come into a graph from outside, as far as the compiler must know them.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use raxel_diagnostics::{Code, codes};
use raxel_shader::format::Format;
use raxel_shader::interface::{Access, Block};

/// A source: `source = "world.tree64"`.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceLayout {
    /// Its name, e.g. `world.tree64`.
    pub name: String,
    /// How the bytes of its buffer are laid out; a shader's block must agree member by member.
    pub block: Block,
    /// The texels of its 3-D image, if it has one besides: the format of a target with this source.
    pub image: Option<Format>,
    /// The accesses that passes may have.
    pub access: Access,
    /// Bytes of a buffer that works the other way round: passes fill it, and after the frame the runtime takes its contents. The memory is
    /// the graph's own, and zero when a frame begins.
    pub collected: Option<u64>,
}

/// Everything that can come from outside.
pub trait Catalog {
    /// The sources that are known by their names alone.
    fn sources(&self) -> &[SourceLayout];

    /// The source of that name, one that is not listed included: that of a model, whose name only its world knows.
    fn source(&self, name: &str) -> Option<SourceLayout> {
        self.sources().iter().find(|source| source.name == name).cloned()
    }

    /// Reads a file of the project, for the source `file.<path>` of a buffer or, with a request, of a target.
    fn file(&self, path: &str, image: Option<&ImageRequest>) -> Result<Arc<FileContents>, Refusal>;

    /// The texels that a microphone brings, for the source [`MICROPHONE`] of a target.
    fn microphone(&self, _: &ImageRequest) -> Result<Arc<FileContents>, Refusal> {
        let message = "there is no microphone here".to_owned();
        Err(Refusal { code: codes::graph::FILE_SOURCE, key: "source", message, help: None })
    }
}

/// A graph's declaration about a file with texels besides its path, or about the microphone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageRequest {
    /// `format`; the file's own when `None`.
    pub format: Option<Format>,
    /// `mips`; 0 is the full chain.
    pub mips: u32,
    /// `slices`: the file is a strip of that many pictures, one below the other, that are the slices of a 3-D image.
    pub slices: Option<u32>,
    /// `encoding = "srgb"`: colours are brought into linear light.
    pub srgb: bool,
}

/// Why a file is no source.
#[derive(Clone, Debug)]
pub struct Refusal {
    /// The diagnostic's code.
    pub code: Code,
    /// The key that is to blame: `source`, `format`, `mips`, `slices` or `encoding`.
    pub key: &'static str,
    /// The message, with the name of the file.
    pub message: String,
    /// Advice.
    pub help: Option<String>,
}

/// Contents of a file, ready for the device.
#[derive(Clone, PartialEq)]
pub enum FileContents {
    /// Of a buffer; a multiple of 4 bytes.
    Bytes(Vec<u8>),
    /// Of a target.
    Image(FileImage),
}

/// Texels of a file.
#[derive(Clone, PartialEq)]
pub struct FileImage {
    /// Texel format.
    pub format: Format,
    /// Texels of mip 0; the third is 1 unless `volume`.
    pub extent: [u32; 3],
    /// 3-D, else 2-D.
    pub volume: bool,
    /// Each mip: x first, then y, then z, without padding. Of a video, those of its first frame; of a sound, those of silence.
    pub mips: Vec<Vec<u8>>,
    /// The playing source: a video, a sound or the microphone.
    pub plays: Option<Plays>,
}

/// Sources whose texels change with time.
#[derive(Clone, Debug, PartialEq)]
pub enum Plays {
    /// Frames.
    Video(Video),
    /// Spectrum and waveform.
    Sound(Sound),
}

/// Samples of a second of every sound.
pub const SAMPLE_RATE: u32 = 48_000;

/// A sound file, decoded, or the microphone.
#[derive(Clone, PartialEq)]
pub struct Sound {
    /// The project path of the file, or [`MICROPHONE`].
    pub path: String,
    /// All of the file, as one channel; at least one sample. None: the microphone's, as each frame hears it.
    pub samples: Option<Arc<[i16]>>,
    /// The graph's declaration about its texels.
    pub request: ImageRequest,
}

/// A video file, whose frames become texels as time goes by.
#[derive(Clone, Debug, PartialEq)]
pub struct Video {
    /// Its project path.
    pub path: String,
    /// Where it lies.
    pub disk: PathBuf,
    /// Pixels of a frame.
    pub extent: [u32; 2],
    /// Frames a second.
    pub rate: f64,
    /// How many frames; at least one.
    pub frames: u64,
    /// The graph's declaration about its texels.
    pub request: ImageRequest,
}

impl FileContents {
    /// Bytes of all of it, mips included.
    pub fn bytes(&self) -> u64 {
        match self {
            FileContents::Bytes(bytes) => bytes.len() as u64,
            FileContents::Image(image) => image.mips.iter().map(|mip| mip.len() as u64).sum(),
        }
    }
}

impl fmt::Debug for FileContents {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FileContents::Bytes(bytes) => write!(f, "{} bytes", bytes.len()),
            FileContents::Image(image) => image.fmt(f),
        }
    }
}

impl fmt::Debug for Sound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.samples {
            Some(samples) => write!(f, "{} samples of {}", samples.len(), self.path),
            None => f.write_str(&self.path),
        }
    }
}

impl fmt::Debug for FileImage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {:?}, {} mips", self.format.name(), self.extent, self.mips.len())
    }
}

/// The prefix of the path of a file in a source's name.
pub const FILE: &str = "file.";

/// The source of a target with the spectrum and the waveform of a microphone's sound.
pub const MICROPHONE: &str = "input.microphone";

/// Whether the texels of a source have a shape that is known before anything runs, and may be brought into another: those of a file, and the
/// microphone's.
pub fn has_shape(source: &str) -> bool {
    source.starts_with(FILE) || source == MICROPHONE
}

/// The layout that a source such as `world.tree64` or `model.pine.tree64` has.
pub fn layout_of(source: &str) -> Option<&str> {
    match source.split_once('.')? {
        ("world", layout) => Some(layout),
        ("model", rest) => rest.rsplit_once('.').map(|(_, layout)| layout),
        _ => None,
    }
}

impl Catalog for Vec<SourceLayout> {
    fn sources(&self) -> &[SourceLayout] {
        self
    }

    /// There are none.
    fn file(&self, path: &str, _: Option<&ImageRequest>) -> Result<Arc<FileContents>, Refusal> {
        let message = format!("`{path}` cannot be read: there are no files here");
        Err(Refusal { code: codes::graph::FILE_SOURCE, key: "source", message, help: None })
    }
}
