//! Textures that grow on surfaces, chapters 3 and 7 of the thesis: what a device computes, computed here. The modules of
//! `opencl` (feature of that name) have the same as kernels.

pub mod newton;
