//! Any bytes as the rates that `catamaran tune` measured, behind the line that names this machine:
//! rates or an error.
#![no_main]

use catamaran::kernel::packed::{Isa, Rates};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let own = Rates::of(Isa::Portable).to_text(Isa::Portable);
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let text = format!("{}\n{text}", own.lines().next().unwrap_or_default());
    if let Ok(rates) = Rates::parse(&text, Isa::Portable) {
        let again = Rates::parse(&rates.to_text(Isa::Portable), Isa::Portable);
        assert_eq!(again.expect("rates as they are written"), rates);
    }
});
