//! Every command from outside: what it writes, says and refuses.

#[path = "../common/mod.rs"]
mod common;
#[path = "../../../tests/common/inputs.rs"]
mod inputs;

mod ata;
mod curve;
mod decimate;
mod defaults;
mod demo;
mod documents;
mod files;
mod gram;
mod guide;
mod json;
mod launchers;
#[allow(dead_code, reason = "the tests of faults use all of it")]
#[path = "../faults/commands.rs"]
mod lines;
mod mesh;
mod newton;
mod picture;
mod pieces;
mod predict;
mod ranks;
mod shapedna;
mod shell;
mod slime;
mod spectral;
mod spectrum;
mod stream;
mod tables;
mod tune;
mod unions;
mod wilt;
