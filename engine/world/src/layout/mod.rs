//! GPU encodings of a world: one file a layout.
