//! The layers of the house: a file imports only modules of layers below its own, or of its own
//! module, or the siblings listed here.

use std::fs;

use super::{rust_files, src};

/// Module, layer, and the modules of the same layer that it may import.
const LAYERS: [(&str, u8, &[&str]); 22] = [
    ("base", 0, &[]),
    ("kernel", 1, &[]),
    ("blas", 1, &["kernel"]),
    ("ata", 2, &[]),
    ("dense", 2, &[]),
    ("gram", 2, &["ata", "dense"]),
    ("sparse", 2, &["dense"]),
    ("ortho", 2, &["ata", "dense", "sparse"]),
    // Mesh files are opened, unpacked and written like those of matrices.
    ("mesh", 3, &["io"]),
    ("io", 3, &[]),
    ("spectral", 4, &[]),
    ("unions", 4, &[]),
    ("texture", 4, &[]),
    ("plant", 4, &[]),
    ("decimate", 4, &[]),
    ("curve", 4, &[]),
    ("mpi", 5, &[]),
    ("opencl", 5, &[]),
    ("capi", 6, &[]),
    ("prelude", 6, &[]),
    // Tests of calls of all layers.
    ("interruption", 7, &[]),
    ("lib", 8, &[]),
];

/// The C ABI stands on everything.
const TOP: u8 = 6;

fn layer(module: &str) -> Option<&'static (&'static str, u8, &'static [&'static str])> {
    LAYERS.iter().find(|l| l.0 == module)
}

/// The modules named right after each `crate::` in `text`, groups (`crate::{a, b}`) included.
fn imported(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for rest in text.split("crate::").skip(1) {
        let word = |s: &str| {
            s.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>()
        };
        if let Some(group) = rest.strip_prefix('{') {
            let mut depth = 0;
            let mut item = String::new();
            for c in group.chars() {
                match c {
                    '{' => depth += 1,
                    '}' if depth == 0 => break,
                    '}' => depth -= 1,
                    ',' if depth == 0 => found.push(word(&std::mem::take(&mut item))),
                    _ => item.push(c),
                }
            }
            found.push(word(&item));
        } else {
            found.push(word(rest));
        }
    }
    found.retain(|f| !f.is_empty());
    found
}

/// The breaches of a file of `module` with this text.
fn breaches(module: &str, text: &str) -> Vec<String> {
    let &(_, own, siblings) = layer(module).unwrap_or_else(|| panic!("{module}: not in the list"));
    let code: String = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .collect::<Vec<_>>()
        .join("\n");
    imported(&code)
        .into_iter()
        .filter(|target| match layer(target) {
            Some(&(name, other, _)) => other >= own && name != module && !siblings.contains(&name),
            // An item re-exported at the root, which hides where it comes from; the top may.
            None => own < TOP,
        })
        .collect()
}

#[test]
fn every_module_imports_only_from_below() {
    let src = src();
    let mut wrong = Vec::new();
    for file in rust_files(&src) {
        let relative = file.strip_prefix(&src).unwrap();
        let first = relative.components().next().unwrap().as_os_str().to_str().unwrap();
        let module = first.trim_end_matches(".rs");
        for target in breaches(module, &fs::read_to_string(&file).unwrap()) {
            wrong.push(format!("{}: crate::{target}", relative.display()));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_breach_is_found() {
    assert_eq!(breaches("blas", "use crate::base::Real;\nuse crate::ata::Plan;"), ["ata"]);
    assert_eq!(breaches("base", "use crate::{base::x, io::{npy, csv}, blas};"), ["io", "blas"]);
    assert_eq!(breaches("io", "let x = crate::mesh::read();"), ["mesh"]);
    assert_eq!(breaches("ata", "use crate::Error;"), ["Error"]);
    assert!(breaches("ortho", "use crate::ata; // crate::capi").is_empty());
}
