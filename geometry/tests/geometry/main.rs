//! Meshes, spectra and decimation.

#[path = "../../../tests/common/inputs.rs"]
mod common;
mod decimate;
mod decimate_density;
mod decimate_families;
mod gltf_scenes;
mod laplacian;
mod lenient;
mod mesh;
mod mesh_files;
mod mesh_files_written;
mod mesh_formats;
mod repair;
mod spectral;
mod surface;
mod triangles;
