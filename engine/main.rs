//! raxel
fn main() {}
