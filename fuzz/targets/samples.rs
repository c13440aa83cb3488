//! Any bytes as the samples of a curve: sites or an error.
#![no_main]

#[path = "../../cli/src/curve/samples.rs"]
mod samples;

use catamaran_fuzz::file;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    std::hint::black_box(samples::read(&file("a.txt", bytes)).ok());
});
