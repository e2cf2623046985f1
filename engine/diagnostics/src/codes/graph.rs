use crate::code::declare;

declare! {
    /// A target's extent exceeds the device's.
    TARGET_TOO_LARGE = "RX0170";
    /// More array layers than the device allows.
    TOO_MANY_LAYERS = "RX0171";
    /// A mip that the target does not have at this size.
    TOO_MANY_MIPS = "RX0172";
    /// A buffer exceeds what a shader can see.
    BUFFER_TOO_LARGE = "RX0173";
    /// More workgroups than the device allows.
    TOO_MANY_WORKGROUPS = "RX0174";
    /// A workgroup has more threads than the device allows.
    WORKGROUP_TOO_LARGE = "RX0175";
    /// The push-constant block exceeds the device's.
    PUSH_TOO_LARGE = "RX0176";
    /// A uniform block exceeds the device's.
    UNIFORM_TOO_LARGE = "RX0177";
    /// Indirect arguments beyond the end of their buffer.
    ARGUMENTS_OUT_OF_RANGE = "RX0178";
    /// The debug target names a frame, mip or layer that is not there.
    PRESENT_OUT_OF_RANGE = "RX0179";
}
