//! The `catamaran` command line.
fn main() {}
