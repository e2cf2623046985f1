use crate::code::declare;

declare! {
    /// A file that is needed does not exist.
    NOT_FOUND = "RX0001";
    /// A file exists and cannot be read.
    UNREADABLE = "RX0002";
    /// A text file is not UTF-8.
    NOT_UTF8 = "RX0003";
    /// A file is larger than raxel reads.
    TOO_LARGE = "RX0004";
    /// A path is absolute or leaves the project root.
    OUTSIDE_ROOT = "RX0005";
    /// A TOML syntax error.
    TOML_SYNTAX = "RX0010";
    /// A key that the table does not have.
    UNKNOWN_KEY = "RX0011";
    /// A value of the wrong type.
    WRONG_TYPE = "RX0012";
    /// A key that is required is missing.
    MISSING_KEY = "RX0013";
    /// A value outside its range, or a word that is none of the allowed ones.
    BAD_VALUE = "RX0014";
    /// Two keys that exclude each other.
    CONFLICTING_KEYS = "RX0015";
}
