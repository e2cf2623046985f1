//! Faults of a .vox file, and of a world that is to become one.

use raxel_diagnostics::{Diagnostic, Span, codes};

/// Why a .vox file was not imported.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}{}", offset.map(|byte| format!(" (at byte {byte})")).unwrap_or_default())]
pub struct VoxError {
    /// Which sort of mistake.
    pub kind: VoxErrorKind,
    /// Where in the file, in bytes from its start; `None` if the mistake has no single place.
    pub offset: Option<usize>,
    /// One line, lower case.
    pub message: String,
}

/// Sorts of mistakes in a .vox file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VoxErrorKind {
    /// Not a .vox file, cut off, or with chunks that do not fit into each other.
    Structure,
    /// A field that cannot be: an unknown id, a rotation that is none, a voxel outside its model.
    Value,
    /// A scene graph that contains itself.
    Cycle,
    /// More than raxel imports.
    TooLarge,
    /// A frame that the file does not have.
    Frame,
}

impl VoxError {
    pub(super) fn new(kind: VoxErrorKind, offset: usize, message: impl Into<String>) -> Self {
        Self { kind, offset: Some(offset), message: message.into() }
    }

    pub(super) fn no_frame(message: impl Into<String>) -> Self {
        Self { kind: VoxErrorKind::Frame, offset: None, message: message.into() }
    }

    /// The diagnostic for the file at a project path. `named_at` is the place that names it, if a file does.
    pub fn diagnostic(&self, path: &str, named_at: Option<(Span, &str)>) -> Diagnostic {
        let code = match self.kind {
            VoxErrorKind::Structure => codes::world::VOX_STRUCTURE,
            VoxErrorKind::Value => codes::world::VOX_VALUE,
            VoxErrorKind::Cycle => codes::world::VOX_CYCLE,
            VoxErrorKind::TooLarge => codes::world::VOX_TOO_LARGE,
            VoxErrorKind::Frame => codes::world::VOX_FRAME,
        };
        let diagnostic = Diagnostic::error(code, format!("`{path}`: {self}"));
        match named_at {
            Some((span, text)) => diagnostic.label(span, text),
            None => diagnostic,
        }
    }
}

/// Why a world cannot become a .vox file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExportError {
    /// The palette of a .vox file is a byte wide.
    #[error("the world uses {used} materials; a .vox file has at most 255")]
    TooManyMaterials {
        /// Materials that voxels are made of.
        used: usize,
    },
    /// Its chunk sizes are 32 bits wide.
    #[error("the world has {voxels} voxels; a .vox file has at most {limit}")]
    TooManyVoxels {
        /// Solid voxels.
        voxels: u64,
        /// How many fit.
        limit: u64,
    },
    /// So is the size of the file: voxels that are scattered need a model each.
    #[error("the world takes {bytes} bytes; a .vox file has at most {limit}")]
    TooLarge {
        /// Bytes of all models and materials.
        bytes: u64,
        /// How many fit.
        limit: u32,
    },
}

impl ExportError {
    /// The diagnostic for the world of that name.
    pub fn diagnostic(&self, world: &str) -> Diagnostic {
        let code = match self {
            ExportError::TooManyMaterials { .. } => codes::world::EXPORT_MATERIALS,
            ExportError::TooManyVoxels { .. } | ExportError::TooLarge { .. } => codes::world::EXPORT_VOXELS,
        };
        Diagnostic::error(code, format!("`{world}` cannot be written as .vox: {self}"))
    }
}
