//! Textures that grow on surfaces (thesis, chapters 3 and 7): the reference implementations, on the CPU.

pub mod slime;
