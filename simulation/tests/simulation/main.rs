//! Plants and slime moulds.

#[path = "../../../tests/common/inputs.rs"]
mod common;
mod materials;
mod plant;
mod slime;
