//! The director's knowledge of the room in the pool: whether something was refused, whether blocks were freed since, and whether it still
//! asks for tiles.
//!
//! | from | event | to |
//! |---|---|---|
//! | `Asking`, `Starved` | a block is freed | `Freed`; a starved director asks again |
//! | `Freed` | the director asks for tiles | `Asking` |
//! | `Freed` | it reacts to a refused tile | `Asking`: it asks again |
//! | `Asking`, and `Freed` without a directory | it reacts to a refusal | `Starved`: it makes room |
//! | `Starved` | less is wanted, and nothing waits to be freed | `Asking`: it asks again |
//!
//! A refusal waits in the state until [`Room::react`] takes it, once in each turn of the director.

/// The room in the pool, as far as the director knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Room {
    /// The director asks for tiles, and no block was freed since it last did.
    Asking(Refusal),
    /// Blocks were freed since the director last asked for tiles, so that a refused tile may fit now.
    Freed(Refusal),
    /// Something was refused and no block was freed since: the director asks for nothing until one is.
    Starved(Refusal),
}

/// A refusal of the pool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// Nothing: the last directory found a block, and so did every tile since the last reaction.
    None,
    /// A tile found no block, or a directory found none but the next one did. The director has not reacted yet.
    Unanswered,
    /// The last directory found no block; the director has not reacted to the last refusal yet.
    UnansweredDirectory,
    /// The last directory found no block, and the director has reacted.
    Directory,
}

/// The director's reaction to a refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reaction {
    /// It asks again: blocks were freed while the refused tile was made.
    AskAgain,
    /// It stops asking and makes room.
    MakeRoom,
}

impl Default for Room {
    fn default() -> Self {
        Self::Asking(Refusal::None)
    }
}

impl Room {
    /// The director asks for the tiles that are missing.
    pub(super) fn asked(&mut self) {
        if let Self::Freed(refusal) = *self {
            *self = Self::Asking(refusal);
        }
    }

    /// A block was freed. Returns whether the director was starved, and has to ask again.
    pub(super) fn block_freed(&mut self) -> bool {
        let was_starved = matches!(self, Self::Starved(_));
        *self = Self::Freed(self.refusal());
        was_starved
    }

    /// A tile found no block.
    pub(super) fn refuse_tile(&mut self) {
        self.set_refusal(match self.refusal() {
            Refusal::None | Refusal::Unanswered => Refusal::Unanswered,
            Refusal::Directory | Refusal::UnansweredDirectory => Refusal::UnansweredDirectory,
        });
    }

    /// A directory found no block.
    pub(super) fn refuse_directory(&mut self) {
        self.set_refusal(Refusal::UnansweredDirectory);
    }

    /// A directory found a block.
    pub(super) fn place_directory(&mut self) {
        self.set_refusal(match self.refusal() {
            Refusal::None | Refusal::Directory => Refusal::None,
            // The reaction still follows: it may be for a tile.
            Refusal::Unanswered | Refusal::UnansweredDirectory => Refusal::Unanswered,
        });
    }

    /// The reaction to the refusals since the last call; `None` if there were none.
    pub(super) fn react(&mut self) -> Option<Reaction> {
        if !self.is_unanswered() {
            return None;
        }
        // Blocks that were given up are freed only after the next directory: it comes before any tile.
        let lacks_directory = self.lacks_directory();
        let refusal = if lacks_directory { Refusal::Directory } else { Refusal::None };
        let may_fit_now = matches!(self, Self::Freed(_)) && !lacks_directory;
        *self = if may_fit_now { Self::Asking(refusal) } else { Self::Starved(refusal) };
        Some(if may_fit_now { Reaction::AskAgain } else { Reaction::MakeRoom })
    }

    /// The wanted set has shrunk, and no block has to be freed first: the director asks again.
    pub(super) fn want_less(&mut self) {
        if let Self::Starved(refusal) = *self {
            *self = Self::Asking(refusal);
        }
    }

    /// Whether the director has not reacted to a refusal yet.
    pub(super) fn is_unanswered(self) -> bool {
        matches!(self.refusal(), Refusal::Unanswered | Refusal::UnansweredDirectory)
    }

    /// Whether the last directory found no block. The blocks that it would have released stay in use until one does.
    pub(super) fn lacks_directory(self) -> bool {
        matches!(self.refusal(), Refusal::Directory | Refusal::UnansweredDirectory)
    }

    fn refusal(self) -> Refusal {
        match self {
            Self::Asking(refusal) | Self::Freed(refusal) | Self::Starved(refusal) => refusal,
        }
    }

    fn set_refusal(&mut self, to: Refusal) {
        match self {
            Self::Asking(refusal) | Self::Freed(refusal) | Self::Starved(refusal) => *refusal = to,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_refused_tile_starves_the_director_until_a_block_is_freed() {
        let mut room = Room::default();
        assert_eq!(room.react(), None);
        room.refuse_tile();
        assert!(room.is_unanswered() && !room.lacks_directory());
        assert_eq!((room.react(), room), (Some(Reaction::MakeRoom), Room::Starved(Refusal::None)));
        assert_eq!(room.react(), None, "a refusal is answered once");
        room.asked();
        assert_eq!(room, Room::Starved(Refusal::None));
        assert!(room.block_freed(), "the director has to ask again");
        assert!(!room.block_freed(), "it knows already");
        room.asked();
        assert_eq!(room, Room::default());
    }

    #[test]
    fn a_tile_that_was_refused_before_a_block_was_freed_is_asked_for_again() {
        let mut room = Room::default();
        room.refuse_tile();
        room.block_freed();
        assert_eq!((room.react(), room), (Some(Reaction::AskAgain), Room::Asking(Refusal::None)));
        // Freed before the director asked: the tile was made with that room in the pool, and was refused all the same.
        room.block_freed();
        room.asked();
        room.refuse_tile();
        assert_eq!(room.react(), Some(Reaction::MakeRoom));
    }

    #[test]
    fn a_refused_directory_is_not_helped_by_asking_again() {
        let mut room = Room::default();
        room.block_freed();
        room.refuse_directory();
        assert_eq!((room.react(), room), (Some(Reaction::MakeRoom), Room::Starved(Refusal::Directory)));
        assert!(room.lacks_directory() && !room.is_unanswered());
        // While the directory has no block, a tile is refused for good, too.
        room.block_freed();
        room.refuse_tile();
        assert_eq!(room.react(), Some(Reaction::MakeRoom));
        room.place_directory();
        assert_eq!(room, Room::Starved(Refusal::None));
        room.want_less();
        assert_eq!(room, Room::default());
    }

    #[test]
    fn a_directory_that_finds_a_block_leaves_the_refused_tile_unanswered() {
        let mut room = Room::default();
        room.refuse_directory();
        room.refuse_tile();
        room.place_directory();
        assert!(room.is_unanswered() && !room.lacks_directory());
        room.block_freed();
        assert_eq!(room.react(), Some(Reaction::AskAgain));
    }

    /// The test reaches every state, so each state is needed.
    #[test]
    fn every_state_can_occur() {
        let steps: [fn(&mut Room); 7] = [
            Room::asked,
            |room| {
                room.block_freed();
            },
            Room::refuse_tile,
            Room::refuse_directory,
            Room::place_directory,
            |room| {
                room.react();
            },
            Room::want_less,
        ];
        let mut reached = BTreeSet::new();
        let mut open = vec![Room::default()];
        while let Some(room) = open.pop() {
            if reached.insert(format!("{room:?}")) {
                open.extend(steps.map(|step| {
                    let mut next = room;
                    step(&mut next);
                    next
                }));
            }
        }
        assert_eq!(reached.len(), 12, "{reached:?}");
    }
}
