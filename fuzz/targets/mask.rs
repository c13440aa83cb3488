//! Any bytes as a picture in PNG: a mask or an error.
#![no_main]

#[path = "../../cli/src/slime/mask.rs"]
mod mask;

use catamaran_fuzz::{file, source_options};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(mask) = mask::read(&file("a.png", bytes), 32, &source_options()) else { return };
    assert_eq!(mask.ground.len(), 32 * 32);
    assert!(mask.start.is_empty() || mask.start.len() == 32 * 32);
});
