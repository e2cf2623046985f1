//! One file a verb.

pub(crate) mod check;
pub(crate) mod clean;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod control;
pub(crate) mod demo;
pub(crate) mod doctor;
pub(crate) mod explain;
pub(crate) mod film;
pub(crate) mod graph;
pub(crate) mod list;
pub(crate) mod man;
pub(crate) mod new;
pub(crate) mod render;
pub(crate) mod run;
pub(crate) mod schema;
pub(crate) mod shaders;
pub(crate) mod test;
pub(crate) mod world;
