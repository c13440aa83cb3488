//! Any bytes as an accumulator: the file itself, or, behind a zero, its head and its body, between
//! the checksums that hold.
#![no_main]

use catamaran::Uplo;
use catamaran::io::read_accumulator;
use catamaran::rows::Accumulator;
use catamaran_fuzz::file;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let made;
    let bytes = match bytes {
        [0, scalar, length, content @ ..] => {
            made = accumulator(*scalar, content.split_at(content.len().min((*length).into())));
            &made
        }
        _ => bytes,
    };
    let path = file("a.acc", bytes);
    if let Ok(sum) = read_accumulator::<f64>(&path) {
        let mut written = Vec::new();
        sum.write(&mut written).expect("memory for an accumulator");
        let read = Accumulator::<f64>::read(&mut &written[..]).expect("what was written");
        let mut again = Vec::new();
        read.write(&mut again).expect("memory for an accumulator");
        assert!(again == written, "an accumulator is written as it was read");
        std::hint::black_box(sum.finish(1.0, Uplo::Lower).ok());
    }
    std::hint::black_box(read_accumulator::<f32>(&path).ok());
});

fn accumulator(scalar: u8, (head, body): (&[u8], &[u8])) -> Vec<u8> {
    let mut bytes = b"CATAACC\0".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend([4u32, 8][usize::from(scalar % 2)].to_le_bytes());
    bytes.extend((head.len() as u32).to_le_bytes());
    bytes.extend(head);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes.extend(body);
    bytes.extend(crc32fast::hash(body).to_le_bytes());
    bytes
}
