use crate::code::declare;

declare! {
    /// An operation names a material that is not declared.
    UNKNOWN_MATERIAL = "RX0301";
    /// An operation names a model that is not declared.
    UNKNOWN_MODEL = "RX0302";
    /// A colour that is none.
    COLOR = "RX0303";
    /// A box or area that is not given clearly, or is empty.
    EXTENT = "RX0304";
    /// An operation reaches beyond the range of voxel coordinates.
    OUT_OF_RANGE = "RX0305";
    /// An operation reaches over more than a world can hold.
    TOO_LARGE = "RX0306";
    /// The voxels of a world take too much memory.
    TOO_MANY_BYTES = "RX0307";
    /// More materials than palette indices.
    TOO_MANY_MATERIALS = "RX0308";
    /// Noise too fine for its distance from the origin.
    NOISE_TOO_FINE = "RX0309";
    /// A scatter found fewer places than it was asked for.
    SCATTER_SHORT = "RX0310";
    /// A world without voxels.
    EMPTY = "RX0311";
    /// A .vox file that is cut off, or is none.
    VOX_STRUCTURE = "RX0320";
    /// A field of a .vox file that cannot be.
    VOX_VALUE = "RX0321";
    /// A scene graph that contains itself.
    VOX_CYCLE = "RX0322";
    /// A .vox file larger than the limit of an import.
    VOX_TOO_LARGE = "RX0323";
    /// A frame that a .vox file does not have.
    VOX_FRAME = "RX0324";
    /// A world with more materials than a .vox file has.
    EXPORT_MATERIALS = "RX0330";
    /// A world with more voxels than a .vox file holds.
    EXPORT_VOXELS = "RX0331";
    /// A streamed world with an operation that has to see it whole.
    NEEDS_WHOLE = "RX0340";
    /// A budget that cannot hold the wanted tiles of a streamed world.
    STREAM_BUDGET = "RX0341";
    /// A layout that a streamed world does not have.
    STREAM_LAYOUT = "RX0342";
    /// A streamed world where all voxels are needed.
    STREAM_ENDLESS = "RX0343";
    /// A thread that loads a streamed world and cannot start, or has ended.
    STREAM_THREAD = "RX0344";
    /// More lamps around the camera than the list of a streamed world has room for.
    STREAM_LAMPS = "RX0490";
    /// An edit that cannot be made.
    EDIT = "RX0350";
    /// A save of a newer raxel.
    SAVE_NEWER = "RX0351";
    /// A save that can only be read.
    SAVE_READ_ONLY = "RX0352";
    /// A save of another world.
    SAVE_GENERATOR = "RX0353";
    /// A save with materials that the world no longer has.
    SAVE_MATERIALS = "RX0354";
    /// A save that has a broken part.
    SAVE_DAMAGED = "RX0355";
    /// A save that cannot be written for the time being.
    SAVE_FAILING = "RX0356";
    /// A save that cannot be read.
    SAVE_UNREADABLE = "RX0357";
    /// Edits that a change of the world's file has undone.
    EDITS_DROPPED = "RX0358";
    /// A save where none can be.
    SAVE_PLACE = "RX0359";
    /// Passes have written edits that are wrong.
    RECORD_WRONG = "RX0440";
    /// Passes have written more edits than there is room for.
    RECORDS_LOST = "RX0441";
    /// Passes have written poses of instances that are wrong.
    POSE_WRONG = "RX0475";
    /// Passes have written more poses than there is room for.
    POSES_LOST = "RX0476";
    /// More instances than a world may have.
    TOO_MANY_INSTANCES = "RX0445";
    /// An instance that reaches too far.
    INSTANCE_RANGE = "RX0446";
    /// A param that moves an instance and that the graph lacks.
    INSTANCE_PARAM = "RX0447";
    /// Two instances of one name.
    INSTANCE_NAME = "RX0448";
    /// A graph that shows a world without its instances.
    INSTANCES_UNSEEN = "RX0449";
    /// An address at which no store of baked worlds can be opened.
    STORE_ADDRESS = "RX0450";
    /// A store that fails.
    STORE_FAILING = "RX0451";
    /// A store with another world in it.
    STORE_OTHER = "RX0452";
    /// A region that cannot be baked.
    BAKE_REGION = "RX0453";
    /// A store that holds no world that can be read.
    STORE_UNREADABLE = "RX0454";
    /// A view that is farther than the levels of detail that were baked.
    SOURCE_LEVELS = "RX0455";
    /// A world from a store that would build, too.
    SOURCE_BUILD = "RX0456";
    /// A budget on the host that cannot hold the wanted tiles of a streamed world.
    STREAM_HOST_BUDGET = "RX0470";
}
