//! The files' declaration of one pass, to find out whether an edit has changed it.

use std::fmt::Write as _;

use super::{Dispatch, Graph, PassId, ValueOrigin};

impl Graph {
    /// Everything that decides the time of a pass: its shader, dispatch, bindings and values, the resources that it touches, and the rounds of
    /// its loop. Equal texts, equal work. Places in the file are left out, so that an edit elsewhere gives the same text. Resources and params
    /// are numbered: one that is added before them counts as an edit.
    ///
    /// To be called on graphs of the same kind: both of files, or both of plans.
    pub fn declaration(&self, id: PassId) -> String {
        let pass = self.pass(id);
        let mut text = format!(
            "{:?} {:?} {:?} {:?} {:?} {:?}",
            pass.shader.key, pass.dispatch, pass.accesses, pass.subgroup_size, pass.when, pass.every
        );
        let touched = pass.accesses.iter().map(|access| access.resource);
        let covered = match pass.dispatch {
            Dispatch::ThreadsOf { target, .. } | Dispatch::GroupsOf { target, .. } => Some(target),
            Dispatch::ElementsOf { buffer } | Dispatch::Indirect { buffer, .. } => Some(buffer),
            Dispatch::ThreadsOfWorld | Dispatch::Threads(_) | Dispatch::Groups(_) => None,
        };
        for resource in touched.chain(covered).map(|id| self.resource(id)) {
            let _ = write!(text, " {:?}", resource.kind);
        }
        let blocks = pass.uniforms.iter().flat_map(|block| &block.fills);
        let values = pass.push.iter().chain(blocks).map(|fill| (fill.member.as_str(), &fill.from));
        for (member, from) in values.chain(pass.specialization.iter().map(|(_, from)| ("", from))) {
            let _ = match from {
                ValueOrigin::Param(id) => write!(text, " {member} {:?}", self.params[id.0 as usize].default),
                from => write!(text, " {member} {from:?}"),
            };
        }
        let declared = self.declared(id);
        let rounds = (0..self.passes.len())
            .filter(|other| self.passes[*other].round.is_some_and(|round| round.pass == declared));
        let _ = write!(text, " {}", rounds.count());
        text
    }
}
