//! The data set: spectra of parts and of their unions.
