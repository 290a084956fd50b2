//! The command line of Reflet.
fn main() {}
