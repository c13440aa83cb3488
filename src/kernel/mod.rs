//! Kernels: the arithmetic that everything above is made of, per instruction set.

pub mod int8;
pub mod packed;
