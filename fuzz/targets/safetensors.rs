//! Any bytes as weights of the network of unions: the file itself, or, behind a zero, changes of
//! the weights that the library comes with, of five bytes each: where and what.
#![no_main]

use std::sync::OnceLock;

use catamaran_geometry::unions::SpectralUnion;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let changed;
    let bytes = match bytes {
        [0, changes @ ..] => {
            changed = weights(changes);
            &changed
        }
        _ => bytes,
    };
    std::hint::black_box(SpectralUnion::from_bytes(bytes).ok());
});

fn weights(changes: &[u8]) -> Vec<u8> {
    static OWN: OnceLock<Vec<u8>> = OnceLock::new();
    let own = OWN.get_or_init(|| {
        let network = SpectralUnion::pretrained().expect("the weights of the library");
        network.to_bytes().expect("a file of them")
    });
    let mut bytes = own.clone();
    for change in changes.chunks_exact(5) {
        let at = u32::from_le_bytes([change[0], change[1], change[2], change[3]]) as usize;
        let len = bytes.len();
        bytes[at % len] = change[4];
    }
    bytes
}
