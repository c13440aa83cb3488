//! The symbols that the library exports.

use std::collections::BTreeSet;

use super::library;

/// Returns all spellings of all routines.
fn expected() -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let real = ["syrk", "gemm", "gemmt", "gemmtr"].as_slice();
    let complex = ["herk", "gemm"].as_slice();
    for (scalar, routines) in [("s", real), ("d", real), ("c", complex), ("z", complex)] {
        for routine in routines {
            let name = format!("{scalar}{routine}");
            for prefix in ["", "scipy_"] {
                names.insert(format!("{prefix}{name}_"));
                names.insert(format!("{prefix}{name}_64_"));
                names.insert(format!("{prefix}cblas_{name}"));
                names.insert(format!("{prefix}cblas_{name}64_"));
            }
            names.insert(format!("{name}_64"));
            names.insert(format!("cblas_{name}_64"));
        }
    }
    names
}

/// Returns the little-endian number of `N` bytes at `at`.
fn number<const N: usize>(file: &[u8], at: usize) -> usize {
    let mut bytes = [0; 8];
    bytes[..N].copy_from_slice(&file[at..at + N]);
    u64::from_le_bytes(bytes) as usize
}

/// Returns the names of the dynamic symbols that a 64-bit ELF file defines (System V ABI,
/// "Sections" and "Symbol Table").
fn defined(file: &[u8]) -> BTreeSet<String> {
    const DYNSYM: usize = 11;
    assert_eq!(&file[..6], b"\x7fELF\x02\x01", "a 64-bit little-endian ELF file");
    let (sections, size) = (number::<8>(file, 0x28), number::<2>(file, 0x3a));
    let section = |index: usize| sections + index * size;
    let count = number::<2>(file, 0x3c);
    let table = (0..count).map(section).find(|&s| number::<4>(file, s + 4) == DYNSYM).unwrap();
    let strings = number::<8>(file, section(number::<4>(file, table + 0x28)) + 0x18);
    let (start, length) = (number::<8>(file, table + 0x18), number::<8>(file, table + 0x20));
    (start..start + length)
        .step_by(24)
        .filter(|&symbol| number::<2>(file, symbol + 6) != 0)
        .map(|symbol| {
            let name = &file[strings + number::<4>(file, symbol)..];
            let end = name.iter().position(|&b| b == 0).unwrap();
            String::from_utf8(name[..end].to_vec()).unwrap()
        })
        .collect()
}

#[test]
fn each_routine_is_exported_in_each_spelling_and_nothing_else_is() {
    let defined = defined(&std::fs::read(library::path()).unwrap());
    assert_eq!(defined, expected());
}
