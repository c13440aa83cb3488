//! Plants: the water in them against closed forms and a double-double reference, and the rods against beam theory.

#[path = "../common/mod.rs"]
mod common;
mod reference;

mod accuracy;
mod damage;
mod files;
mod models;
mod rods;
