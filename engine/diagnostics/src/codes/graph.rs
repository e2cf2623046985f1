use crate::code::declare;

declare! {
    /// A target or buffer that the graph does not declare.
    UNKNOWN_RESOURCE = "RX0100";
    /// A param that the graph does not declare.
    UNKNOWN_PARAM = "RX0101";
    /// A pass that the base does not have.
    UNKNOWN_PASS = "RX0102";
    /// An image format that GLSL does not have.
    UNKNOWN_FORMAT = "RX0103";
    /// A `from` that names nothing.
    UNKNOWN_BUILTIN = "RX0104";
    /// A buffer source that the runtime does not have.
    UNKNOWN_SOURCE = "RX0105";
    /// A condition that nothing answers.
    UNKNOWN_FACT = "RX0106";
    /// Two things with one name.
    DUPLICATE_NAME = "RX0107";
    /// A name with characters that names cannot have.
    BAD_NAME = "RX0108";
    /// Graphs that extend each other in a circle, or in too long a row.
    EXTENDS_CYCLE = "RX0109";
    /// A member of the shader's block without a value.
    MEMBER_MISSING = "RX0110";
    /// A value for a member that the shader's block does not have.
    MEMBER_EXTRA = "RX0111";
    /// A declared offset that is not the shader's.
    MEMBER_OFFSET = "RX0112";
    /// A declared type that is not the shader's.
    MEMBER_TYPE = "RX0113";
    /// A value whose type is not the member's.
    VALUE_TYPE = "RX0114";
    /// Push constants of more than 128 bytes.
    PUSH_SIZE = "RX0115";
    /// A member of a type that a graph cannot fill.
    UNFILLABLE = "RX0116";
    /// A written value of another type or shape than is needed.
    LITERAL = "RX0117";
    /// Values for a block that the shader does not use.
    NO_BLOCK = "RX0118";
    /// A word that is not a type.
    UNKNOWN_TYPE = "RX0119";
    /// A binding of the shader without a resource.
    UNBOUND = "RX0120";
    /// An entry of `bind` that the shader has no use for.
    BIND_UNUSED = "RX0121";
    /// A target where a buffer is needed, or the other way round.
    WRONG_KIND = "RX0122";
    /// A target whose format is not the shader's layout qualifier.
    FORMAT_MISMATCH = "RX0123";
    /// A target of floats read as integers, or the like.
    TEXEL_KIND = "RX0124";
    /// An image of another dimension than the target.
    DIMENSION = "RX0125";
    /// A write to an earlier frame or to a source.
    READ_ONLY = "RX0126";
    /// An earlier frame that is not kept.
    HISTORY = "RX0127";
    /// A mip or layer that the target does not have.
    MIP_OR_LAYER = "RX0128";
    /// A resource written through one name and seen through another in one pass.
    OVERLAP = "RX0129";
    /// A kind of binding that a graph cannot make.
    UNSUPPORTED_BINDING = "RX0130";
    /// An array of bindings.
    DESCRIPTOR_ARRAY = "RX0131";
    /// A block that is not laid out as its source.
    SOURCE_LAYOUT = "RX0132";
    /// An invalid filter or wrap.
    SAMPLER = "RX0133";
    /// A buffer with fewer bytes than the shader's block.
    BUFFER_SIZE = "RX0134";
    /// Elements of another size than the shader's.
    BUFFER_STRIDE = "RX0135";
    /// `partial` on a binding that stores nothing.
    PARTIAL = "RX0136";
    /// A dispatch that runs nothing.
    DISPATCH_SIZE = "RX0140";
    /// Indirect arguments that are not in their buffer.
    INDIRECT = "RX0142";
    /// A workgroup without threads.
    WORKGROUP = "RX0143";
    /// A specialization constant that the shader does not have.
    UNKNOWN_CONSTANT = "RX0144";
    /// A specialization constant of another type.
    CONSTANT_TYPE = "RX0145";
    /// A define that the preprocessor cannot take.
    DEFINE = "RX0146";
    /// A condition on a param that is not a bool.
    CONDITION_TYPE = "RX0147";
    /// A `clear` or `init` that the resource cannot hold.
    FILL_VALUE = "RX0150";
    /// Targets whose sizes depend on each other in a circle.
    SIZE_CYCLE = "RX0151";
    /// A display map that cannot show the format.
    DISPLAY = "RX0152";
    /// A range that is empty or leaves the default outside.
    PARAM_RANGE = "RX0153";
    /// `remove`, `before` or `after` without something in a base.
    NOTHING_TO_OVERLAY = "RX0154";
    /// More things than a graph may have.
    TOO_MANY = "RX0155";
    /// A file that does not fit its target or buffer.
    FILE_SOURCE = "RX0156";
    /// Names of a param's values that do not fit it.
    PARAM_CHOICES = "RX0157";
    /// A param that cannot be a colour.
    PARAM_COLOR = "RX0158";
    /// Something is read that nothing writes.
    NEVER_WRITTEN = "RX0160";
    /// Something is declared that nothing uses.
    UNUSED = "RX0161";
    /// The presented resource is never written.
    PRESENT_UNWRITTEN = "RX0162";
    /// Something that not every device can do.
    NOT_PORTABLE = "RX0163";
    /// A capability that raxel does not switch on.
    CAPABILITY = "RX0164";
    /// A clock that the graph does not declare.
    UNKNOWN_CLOCK = "RX0165";
    /// Passes of a clock with another pass between them, or in one loop with it.
    CLOCK_GROUP = "RX0166";
    /// A resource that turns with a clock is written, or changes places, at another rhythm.
    CLOCK_WRITER = "RX0167";
    /// History or a clear that turns with the frames, of something that not every frame writes.
    CLOCK_MISSING = "RX0168";
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
    /// The shared variables of a workgroup exceed the device's.
    SHARED_TOO_LARGE = "RX0180";
    /// A value names a material that the world has not.
    UNKNOWN_MATERIAL = "RX0181";
    /// A warning of a buffer counts beyond its end.
    WARNING_OUT_OF_RANGE = "RX0182";
    /// A pass binds more resources than the device allows.
    TOO_MANY_BINDINGS = "RX0183";
    /// A loop that the graph does not declare.
    UNKNOWN_LOOP = "RX0190";
    /// Passes of a loop with another pass between them.
    LOOP_GROUP = "RX0191";
    /// Two resources that cannot change places.
    SWAP = "RX0192";
    /// A number of rounds that a loop cannot have.
    LOOP_COUNT = "RX0193";
    /// `loop.index` or `loop.next` where there is no loop.
    NO_LOOP = "RX0194";
    /// An odd number of swaps of a carried resource, or in a loop that not every frame runs.
    SWAP_CARRIED = "RX0195";
    /// A loop over the mips of a target that has one.
    NO_ROUND = "RX0491";
}
