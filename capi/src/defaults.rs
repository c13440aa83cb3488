//! Tests that parameter structs of zeros mean the defaults of the library.

use std::fmt::Debug;
use std::mem::MaybeUninit;

use super::params::{Versioned, init};
use super::status::Failure;
use super::{
    ata_params, cholesky, curve, decimation, distance, eigs, newton, ortho, repair, shape, slime,
};
use catamaran::AtaOptions;
use catamaran::ortho::GramSchmidtOptions;
use catamaran::sparse::{CholeskyOptions, EigenOptions};
use catamaran_geometry::curve::CurveOptions;
use catamaran_geometry::decimate::DecimateOptions;
use catamaran_geometry::mesh::{HeatOptions, LaplacianOptions, RepairOptions};
use catamaran_geometry::spectral::ShapeOptions;
use catamaran_simulation::texture::newton::NewtonOptions;

/// Returns a struct as its `cata_*_params_init` leaves it.
fn zeros<T: Versioned>() -> T {
    let mut params = MaybeUninit::<T>::zeroed();
    // SAFETY: `params` has as many writable bytes as the size says.
    let status = unsafe { init(params.as_mut_ptr(), size_of::<T>()) };
    assert_eq!(status, super::status::CATA_OK);
    // SAFETY: all fields of a parameter struct may be 0, and `init` has written the size.
    unsafe { params.assume_init() }
}

fn printed(options: &impl Debug) -> String {
    format!("{options:?}")
}

fn done<X>(result: Result<X, Failure>) -> X {
    result.unwrap_or_else(|_| panic!("parameters of zeros are refused"))
}

#[test]
fn parameters_of_zeros_are_the_defaults_of_the_library() {
    let default = AtaOptions::default();
    let compare = |options: &AtaOptions<'_>| {
        assert_eq!(printed(options), printed(&default));
        Ok(())
    };
    // SAFETY: the struct is a live one of this version.
    done(unsafe {
        ata_params::with_options(&zeros::<ata_params::cata_ata_params>(), default.uplo, compare)
    });

    // SAFETY: the struct is a live one of this version.
    let found = unsafe {
        eigs::with_eigen_options(100, &zeros::<eigs::cata_eigs_params>(), |eigen, laplacian| {
            Ok((printed(eigen), printed(laplacian)))
        })
    };
    let default = LaplacianOptions::default();
    assert_eq!(done(found), (printed(&EigenOptions::default()), printed(&default)));

    // SAFETY: the struct is a live one of this version.
    let found = unsafe {
        ortho::with_ortho_options(&zeros::<ortho::cata_ortho_params>(), |options, _| {
            Ok(printed(options))
        })
    };
    assert_eq!(done(found), printed(&GramSchmidtOptions::default()));

    // SAFETY: the struct is a live one of this version.
    let found = unsafe {
        decimation::with_options(&zeros::<decimation::cata_decimation_params>(), |options| {
            Ok(printed(options))
        })
    };
    assert_eq!(done(found), printed(&DecimateOptions::default()));

    let found = done(cholesky::options(&zeros()));
    assert_eq!(printed(&found), printed(&CholeskyOptions::default()));

    assert_eq!(printed(&shape::options(&zeros())), printed(&ShapeOptions::default()));

    let options = done(distance::heat_options(&zeros()));
    assert_eq!(options, HeatOptions::default());

    let options = done(repair::options(&zeros()));
    assert_eq!(options, RepairOptions::default());

    let options = done(curve::options(&zeros()));
    assert_eq!(printed(&options), printed(&CurveOptions::default()));

    let options = done(newton::options(&zeros(), &[]));
    assert_eq!(printed(&options), printed(&NewtonOptions::default()));

    assert_eq!(
        done(slime::options(&zeros())),
        catamaran_simulation::texture::slime::Options::default()
    );
}
