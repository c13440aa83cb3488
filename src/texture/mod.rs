//! Textures that grow on surfaces (thesis, chapters 3 and 7): the reference implementations, on the CPU. The modules of `opencl`
//! (feature of that name) have the same as kernels.

pub mod newton;
pub mod slime;
