//! Varies: finds the resources whose contents may change in every frame. A resource that depends only on params, the world and the output is the
//! same for many frames, so it keeps its memory to itself: the memo then finds it in place. (A table of a sky that shares memory would be
//! made again in every frame.)

use crate::back::cull::Cull;
use crate::back::lifetimes::{Life, read_before_written};
use crate::back::order::{Action, Order, ResourceAccess};
use crate::ir::checked::{Builtin, Fill, Graph, ResourceId, ValueOrigin};
use crate::ir::plan::AccessMask;

/// By used resource: whether its contents depend on the camera, the cursor, the frame or a clock. They do so directly, through the
/// inputs of a pass, or through their own contents of the frame before.
pub(crate) fn varies(graph: &Graph, cull: &Cull, order: &Order, lives: &[Life]) -> Vec<bool> {
    let mut varies: Vec<bool> =
        (0..cull.used.len()).map(|index| feeds_back(graph, cull, order, lives, index)).collect();
    let index = |id: ResourceId| cull.used.binary_search(&id).ok();
    loop {
        let before = varies.clone();
        for &id in &cull.live {
            let pass = graph.pass(id);
            let mut fills = pass.push.iter().chain(pass.uniforms.iter().flat_map(|block| &block.fills));
            let moves = fills.any(moves)
                || pass.accesses.iter().any(|a| a.access.reads() && index(a.resource).is_some_and(|at| varies[at]));
            for stored in pass.accesses.iter().filter(|access| moves && access.access.writes()) {
                if let Some(at) = index(stored.resource) {
                    varies[at] = true;
                }
            }
        }
        if varies == before {
            return varies;
        }
    }
}

/// Whether passes store to it, and load the store of an earlier frame.
fn feeds_back(graph: &Graph, cull: &Cull, order: &Order, lives: &[Life], index: usize) -> bool {
    // A copy of a source is not filled in every frame: stores of passes stay.
    let fills = |access: &&ResourceAccess| matches!(order.actions[access.action as usize], Action::Copy(_));
    let of_it = order.accesses.iter().filter(|access| access.resource as usize == index && !fills(access));
    let accesses: Vec<ResourceAccess> = of_it.copied().collect();
    let resource = graph.resource(cull.used[index]);
    let stored = accesses.iter().any(|access| access.mask == AccessMask::SHADER_STORAGE_WRITE);
    let older = accesses.iter().any(|access| access.age > 0);
    stored && (older || resource.clock.is_some() || lives[index] == Life::Persistent && read_before_written(&accesses))
}

/// Whether a frame depends on more of the frames before it than the camera of the last one: whether something grows from frame to frame, a
/// pass runs only now and then, or a shader gets the number of frames for which the picture has been still. A frame of a graph that does
/// not look back can be made without those before it.
pub(crate) fn uses_history(graph: &Graph, cull: &Cull, order: &Order, lives: &[Life]) -> bool {
    let carried = (0..cull.used.len()).any(|index| {
        let resource = graph.resource(cull.used[index]);
        // Passes may store to a part of it only: the rest stays, once it was filled.
        let stays = resource.kind.is_initialised() || resource.keep;
        let stored = || order.accesses.iter().any(|access| access.resource as usize == index && access.writes());
        stays && stored() || feeds_back(graph, cull, order, lives, index)
    });
    carried
        || cull.live.iter().map(|id| graph.pass(*id)).any(|pass| {
            let mut fills = pass.push.iter().chain(pass.uniforms.iter().flat_map(|block| &block.fills));
            pass.every.is_some()
                || fills.any(|fill| {
                    matches!(
                        fill.from,
                        ValueOrigin::Clock(..) | ValueOrigin::Builtin(Builtin::FrameStill | Builtin::HistoryValid)
                    )
                })
        })
}

/// Whether a value may be another in every frame.
fn moves(fill: &Fill) -> bool {
    match fill.from {
        ValueOrigin::Value(_)
        | ValueOrigin::Param(_)
        | ValueOrigin::ExtentOf(_)
        | ValueOrigin::CountOf(_)
        | ValueOrigin::Material(_)
        | ValueOrigin::Round(_) => false,
        ValueOrigin::Clock(..) => true,
        ValueOrigin::Builtin(builtin) => match builtin {
            Builtin::OutputSize
            | Builtin::OutputAspect
            | Builtin::WorldMin
            | Builtin::WorldMax
            | Builtin::WorldVoxels
            | Builtin::WorldSerial
            | Builtin::WorldEdited
            | Builtin::WorldChangedMin
            | Builtin::WorldChangedMax => false,
            Builtin::CameraCell
            | Builtin::CameraFrac
            | Builtin::CameraViewToWorld
            | Builtin::CameraWorldToView
            | Builtin::CameraFov
            | Builtin::CameraTanHalfFov
            | Builtin::CameraPreviousCell
            | Builtin::CameraPreviousFrac
            | Builtin::CameraPreviousViewToWorld
            | Builtin::CameraPreviousWorldToView
            | Builtin::FrameIndex
            | Builtin::FrameTime
            | Builtin::FrameDelta
            | Builtin::FrameStill
            | Builtin::HistoryValid
            | Builtin::CursorPosition
            | Builtin::InputButtons
            | Builtin::InputPressed
            | Builtin::InputDrag
            | Builtin::InputWheel
            | Builtin::InputGamepadSticks
            | Builtin::InputGamepadTriggers
            | Builtin::InputGamepadButtons
            | Builtin::InputGamepadPressed
            | Builtin::InputTimeOfDay => true,
        },
    }
}
