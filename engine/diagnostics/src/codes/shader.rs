use crate::code::declare;

declare! {}
