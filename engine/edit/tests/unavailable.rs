//! Edits of a world whose chunks cannot be had for a while: what is not there is not changed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use raxel_edit::{EditError, EditedSource, Edits, Operation, Scene};
use raxel_world::{ChunkPos, ChunkSource, Content, Material, Unavailable};

/// All of one material, when it is there.
struct Failing {
    materials: Vec<Material>,
    there: AtomicBool,
}

impl ChunkSource for Failing {
    fn materials(&self) -> &[Material] {
        &self.materials
    }

    fn chunk(&self, level: u32, pos: ChunkPos) -> Content {
        self.try_chunk(level, pos).unwrap_or(Content::Empty)
    }

    fn try_chunk(&self, _level: u32, _pos: ChunkPos) -> Result<Content, Unavailable> {
        if self.there.load(Ordering::Relaxed) {
            Ok(Content::Full(1))
        } else {
            Err(Unavailable::new("the store is busy"))
        }
    }
}

#[test]
fn what_is_not_there_is_not_changed() {
    let materials = vec![Material::air(), Material::matt("stone", [0.5; 3])];
    let failing = Arc::new(Failing { materials: materials.clone(), there: AtomicBool::new(false) });
    let source = EditedSource::new(failing.clone(), materials.clone());
    let scene = Scene::new(&materials, &[]);
    let mut edits = Edits::default();
    let hole = [Operation::Set { cell: [3, 70, -5], material: 0 }];
    let refused = edits.apply(&hole, &scene, source.unedited()).unwrap_err();
    assert_eq!(refused, EditError::Unavailable(Unavailable::new("the store is busy")));
    assert!(edits.is_empty() && edits.steps() == [0, 0]);

    failing.there.store(true, Ordering::Relaxed);
    let change = edits.apply(&hole, &scene, source.unedited()).unwrap();
    source.change(&change);
    let pos = ChunkPos::new(0, 1, -1);
    let solids = |content: Content| content.to_chunk().map_or(0, |chunk| chunk.solids());
    assert_eq!(solids(source.chunk(0, pos)), 64 * 64 * 64 - 1);

    // What was edited needs the store no more; what lies around it does.
    failing.there.store(false, Ordering::Relaxed);
    assert_eq!(source.try_chunk(0, pos).map(solids), Ok(64 * 64 * 64 - 1));
    let deeper = [Operation::Set { cell: [3, 69, -5], material: 0 }];
    assert_eq!(edits.apply(&deeper, &scene, source.unedited()).unwrap().chunks.len(), 1);
    assert!(
        source.try_chunk(1, ChunkPos::new(0, 0, -1)).is_err() && source.try_chunk(0, ChunkPos::new(1, 1, -1)).is_err()
    );
}
