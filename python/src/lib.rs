//! The extension module of the Python package `catamaran`: arguments in, the call of the library,
//! arrays out. No algorithm is here.
//!
//! `array` holds views of numpy arrays, `task` runs the work with the interpreter released,
//! `error` turns errors into exceptions, `options` reads words into options; then a module for
//! each chapter. Names, defaults and documentation are in the Python files beside it.

mod accumulator;
mod array;
mod ata;
mod cholesky;
mod curve;
mod decimate;
mod descriptor;
mod distance;
mod environment;
mod error;
mod exclusive;
mod frame;
mod gram;
mod isosurface;
mod measure;
mod mesh;
mod mesh_file;
mod operators;
mod options;
mod ortho;
mod plant;
mod product_plan;
mod region;
mod repair;
mod scalar;
mod sparse;
mod spectral;
mod spectrum;
mod surface;
mod tables;
mod task;
mod texture;
mod unions;
mod verify;

/// The functions and classes that the Python files call.
#[pyo3::pymodule(gil_used = true)]
mod _catamaran {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::accumulator::Accumulator;
    #[pymodule_export]
    use crate::ata::{ata, ata_sparse};
    #[pymodule_export]
    use crate::cholesky::CholeskyHandle;
    #[pymodule_export]
    use crate::curve::{curve, draw, place};
    #[pymodule_export]
    use crate::decimate::{decimate, farthest_points};
    #[pymodule_export]
    use crate::descriptor::{geodesic_rings, shot};
    #[pymodule_export]
    use crate::distance::{distances, geodesic_path, shortest_path, trace_geodesic};
    #[pymodule_export]
    use crate::environment::Nearest;
    #[pymodule_export]
    use crate::gram::{corrcoef, lstsq, lstsq_table, orthogonality, pca, scores, svd, t_quantile};
    #[pymodule_export]
    use crate::isosurface::{isosurface, label_surface};
    #[pymodule_export]
    use crate::measure::{compare, component, difference, measure, quality, submesh, validate};
    #[pymodule_export]
    use crate::mesh::{laplacian, shape};
    #[pymodule_export]
    use crate::mesh_file::{mesh_from_bytes, mesh_to_bytes, read_mesh, read_scalars, write_mesh};
    #[pymodule_export]
    use crate::operators::{cloud_laplacian, dirichlet_energies, gradient};
    #[pymodule_export]
    use crate::options::{get_num_threads, set_num_threads};
    #[pymodule_export]
    use crate::ortho::{orthogonalize, qr};
    #[pymodule_export]
    use crate::plant::{PlantHandle, grow, read_plant, tubes, wilt};
    #[pymodule_export]
    use crate::product_plan::{Plan, plan};
    #[pymodule_export]
    use crate::region::{cut, enclosed_faces, region_boundary};
    #[pymodule_export]
    use crate::repair::repair;
    #[pymodule_export]
    use crate::spectral::{
        Eigenbasis, eigenbasis, eigenproducts, functional_map, product_map, shape_from_spectrum,
        transfer, transfer_details,
    };
    #[pymodule_export]
    use crate::spectrum::{
        count_below_mesh, count_below_sparse, eigsh, eigsh_ranks, eigsh_sparse,
        free_components_mesh, free_components_sparse,
    };
    #[pymodule_export]
    use crate::tables::read;
    #[pymodule_export]
    use crate::texture::{newton, slime};
    #[pymodule_export]
    use crate::unions::{
        MetricHandle, interpolate_spectra, locate_union, shape_dna, union_spectrum,
    };
    #[pymodule_export]
    use crate::verify::verify;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        catamaran::base::obey_omp_num_threads();
        catamaran::base::use_own_threads_only();
        // Nobody would see the library's own line on standard error.
        catamaran::base::isa_limit().map_err(crate::error::exception)?;
        module.add("__version__", catamaran::base::VERSION)
    }
}
