//! `libcatamaran_blas.so`: a BLAS to put in front of another one, by `LD_PRELOAD` or by linking.
//!
//! It exports `?gemm` for real and complex matrices, `?syrk` and `?gemmt` (`?gemmtr`) for real and
//! `?herk` for complex ones, in every spelling that programs use. It computes the products for
//! which Catamaran is expected to be faster; all other calls go to the next library in line.
//! docs/guide/blas.md is the user's guide.
//!
//! A call passes the modules in this order:
//!
//! | Module | Content |
//! |---|---|
//! | `symbols` | the exported functions; small products leave from here |
//! | `arguments` | the arguments of Fortran and CBLAS as a request |
//! | `dispatch` | computes a request, or forwards the call |
//! | `policy` | what is computed here, and by which plan |
//! | `product`, `element` | the computation, of real or complex elements |
//! | `threads` | the threads of this library |
//! | `entry`, `host` | counts of a symbol; where the next library has it |
//! | `report` | what is printed at exit |
//! | `settings` | environment variables |

#![cfg(target_os = "linux")]

mod arguments;
mod dispatch;
mod element;
mod entry;
mod host;
mod overlap;
mod policy;
mod product;
mod report;
mod request;
mod settings;
mod symbols;
mod threads;
