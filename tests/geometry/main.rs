//! Sparse and orthonormal bases, meshes, spectra, decimation, plants and slime moulds.

#[path = "../common/mod.rs"]
mod common;
mod decimate;
mod decimate_families;
mod gltf_scenes;
mod laplacian;
mod materials;
mod mesh;
mod mesh_files;
mod mesh_files_written;
mod ortho;
mod plant;
mod repair;
#[cfg(feature = "hdf5")]
mod rows_hdf5;
mod slime;
mod sparse;
mod spectral;
#[path = "../common/surface.rs"]
mod surface;
#[path = "../common/triangles.rs"]
mod triangles;
