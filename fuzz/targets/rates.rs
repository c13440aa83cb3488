//! Any bytes as the rates that `catamaran tune` measured, behind the line that names this machine:
//! rates or an error.
#![no_main]

use catamaran::kernel::packed::{FloatIsa, Rates};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let own = Rates::of(FloatIsa::Portable).to_text(FloatIsa::Portable);
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let text = format!("{}\n{text}", own.lines().next().unwrap_or_default());
    if let Ok(rates) = Rates::parse(&text, FloatIsa::Portable) {
        let again = Rates::parse(&rates.to_text(FloatIsa::Portable), FloatIsa::Portable);
        assert_eq!(again.expect("rates as they are written"), rates);
    }
});
