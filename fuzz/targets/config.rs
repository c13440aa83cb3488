//! Any bytes as the options of slime moulds, as TOML and as .ini of the reference implementation.
#![no_main]

// The command line uses more of them.
#[allow(dead_code)]
#[path = "../../cli/src/slime/config.rs"]
mod config;
#[allow(dead_code)]
#[path = "../../cli/src/slime/look.rs"]
mod look;

use catamaran_fuzz::file;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    for name in ["a.toml", "a.ini"] {
        if let Ok(loaded) = config::load(&file(name, bytes)) {
            loaded.options.check().expect("options that were checked");
        }
    }
});
