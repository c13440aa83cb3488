//! Imports inside a crate run one way, between its rooms (folders of `src`, or files beside
//! `lib.rs`) and between the files of a room (`circles.rs`); cargo keeps the crates apart.

mod circles;
mod modules;
mod source;
