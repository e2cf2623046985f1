//! The panels of the window: an egui interface as a function of plain data. [`Panels::show`] draws a [`View`] and gives the [`Action`]s that
//! the user asks for. Knows nothing of sessions, devices and windows, so that it is built and tested by itself.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod action;
mod bar;
mod brush;
mod compare;
mod docks;
mod frame;
mod graph;
mod graph_layout;
mod hint;
mod inspect;
mod layout;
mod layout_file;
mod magnified;
mod params;
mod passes;
mod presets;
mod problems;
mod resources;
mod rows;
mod samples;
mod shape_cache;
mod split_input;
mod switcher;
mod timeline;
pub mod view;
mod world;

pub use action::{Action, WriteTo};
pub use docks::Panels;
pub use layout::{Layout, Panel, Side};
pub use samples::Samples;
pub use split_input::split_input;
pub use view::View;
