//! Any text as the samples of a curve: sites or an error.
#![no_main]

// The command line uses more of it.
#[allow(dead_code)]
#[path = "../../cli/src/curve/samples.rs"]
mod samples;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    std::hint::black_box(samples::parse(text, "a.txt").ok());
});
