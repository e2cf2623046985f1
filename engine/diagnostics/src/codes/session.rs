use crate::code::declare;

// 00–39: projects, sessions and demos; 40 and up: the command line.
declare! {
    /// A path that is in no project.
    NO_PROJECT = "RX0401";
    /// A project with no graph, world or demo to choose, or several.
    NO_CHOICE = "RX0402";
    /// A demo animates a param that the graph does not have.
    UNKNOWN_PARAM = "RX0403";
    /// A demo's key does not fit its param: wrong type, or outside its range.
    WRONG_PARAM_VALUE = "RX0404";
    /// A debug target that the graph does not have.
    UNKNOWN_TARGET = "RX0405";
    /// Keys that are not in order of time, or lie outside the demo.
    KEY_TIME = "RX0406";
    /// A world's layout is larger than the device can bind.
    LAYOUT_TOO_LARGE = "RX0407";
    /// A buffer source that nothing supplies.
    UNKNOWN_SOURCE = "RX0408";
    /// A pass is switched off since the device was lost while it ran.
    PASS_SWITCHED_OFF = "RX0409";
    /// A demo checks a pass that the graph does not have.
    UNKNOWN_PASS = "RX0420";
    /// The reference of a check is missing or no picture.
    NO_REFERENCE = "RX0421";
    /// A picture is too far from its reference.
    PICTURE_DIFFERS = "RX0422";
    /// A pass takes longer than it may.
    PASS_TOO_SLOW = "RX0423";
    /// A default of the project's manifest that is not there, or is a file of another kind.
    WRONG_DEFAULT = "RX0460";
    /// A damaged file of the cache.
    BAD_CACHE = "RX0485";
    /// A plan that the device refuses: a format, a feature or a size.
    DEVICE_REFUSES = "RX0410";
    /// Passes count something that the graph warns of.
    COUNTED = "RX0411";
    /// An `rx_assert` of a shader failed.
    ASSERTION_FAILED = "RX0412";
    /// A shader has accessed an array or an image out of bounds.
    OUT_OF_BOUNDS = "RX0413";
}
