//! Every command from outside: what it writes, says and refuses.

#[path = "../common/mod.rs"]
mod common;

mod ata;
mod curve;
mod decimate;
mod demo;
mod files;
mod gram;
mod guide;
mod mesh;
mod newton;
mod picture;
mod ranks;
mod shapedna;
mod slime;
mod spectral;
mod spectrum;
mod stream;
mod tune;
mod unions;
mod wilt;
