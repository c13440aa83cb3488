//! `include/catamaran.h`, generated from src/capi.

use std::path::Path;

use crate::generated::Generated;

/// `include/catamaran.h`.
pub const HEADER: Generated = Generated {
    name: "include/catamaran.h",
    source: "src/capi",
    command: "cargo xtask header",
    generate,
};

/// The files of the C ABI, in the order of the header.
const FILES: &[&str] = &[
    "version",
    "status",
    "backend",
    "pointer",
    "params",
    "ata",
    "ata_sparse",
    "rows",
    "atb",
    "aha",
    "verify",
    "spectrum",
    "mesh_spectrum",
    "parts",
    "ortho",
    "gram",
    "transfer",
    "decimate",
    "plant",
    "curve",
    "slime",
    "device",
    "newton",
    "unions",
    "world",
    "mpi",
    "memory",
];

/// Exported for tests; last in the header.
const INTERNAL: &str = "internal";

fn generate(root: &Path) -> Result<String, String> {
    let capi = root.join("src/capi");
    every_file_is_known(&capi)?;
    let mut config = cbindgen::Config::from_file(root.join("cbindgen.toml"))?;
    config.header = Some(preamble());
    config.after_includes = Some(version_macros());
    let mut builder = cbindgen::Builder::new().with_config(config);
    for name in FILES.iter().chain(&[INTERNAL]) {
        builder = builder.with_src(capi.join(name).with_extension("rs"));
    }
    let bindings = builder.generate().map_err(|e| format!("cbindgen: {e}"))?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    Ok(tidied(&String::from_utf8(text).map_err(|e| format!("cbindgen: {e}"))?))
}

/// A new file of src/capi must be entered above, or its exports would be missing silently.
fn every_file_is_known(capi: &Path) -> Result<(), String> {
    let without_exports = ["mod", "boundary", "entries", "message", "ranks", INTERNAL];
    let entries = std::fs::read_dir(capi).map_err(|e| format!("{}: {e}", capi.display()))?;
    for entry in entries {
        let path = entry.map_err(|e| e.to_string())?.path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if !FILES.contains(&name.as_str()) && !without_exports.contains(&name.as_str()) {
            return Err(format!("{}: add it to FILES in scripts/xtask", path.display()));
        }
    }
    Ok(())
}

/// Comments as in C: one line where one is enough, and without the sections that say the same to
/// readers of Rust.
fn tidied(header: &str) -> String {
    let mut lines: Vec<&str> = Vec::new();
    let mut in_safety = false;
    for line in header.lines() {
        in_safety = (in_safety || line == " * # Safety") && line != " */";
        if in_safety {
            continue;
        }
        if line == " */" && lines.last() == Some(&" *") {
            lines.pop();
        }
        lines.push(line);
    }
    let text = lines.join("\n") + "\n";
    let mut tidy = String::new();
    let mut rest = text.as_str();
    while let Some(start) = rest.find("/**\n") {
        let (before, comment) = rest.split_at(start);
        tidy += before;
        let end = comment.find("*/").map_or(comment.len(), |end| end + 2);
        let (comment, after) = comment.split_at(end);
        let inner: Vec<&str> = comment.lines().collect();
        match inner[..] {
            ["/**", only, _] => {
                tidy += &format!("/** {} */", only.trim_start().trim_start_matches("* "));
            }
            _ => tidy += comment,
        }
        rest = after;
    }
    tidy + rest
}

fn preamble() -> String {
    "\
/* Catamaran: A^T A and what stands on it, at scale. The C interface.
 *
 * Generated from src/capi by `cargo xtask header`: do not edit.
 *
 * Every function that can fail returns a cata_status: CATA_OK (0), or why not; the message of
 * cata_last_error_message says more. Element counts and ranges are given in numbers of elements,
 * never bytes. Unless said otherwise a pointer may not be NULL, is not kept after the call, and
 * points to memory that no other thread writes during the call.
 *
 * MIT OR Apache-2.0
 */"
    .to_owned()
}

fn version_macros() -> String {
    // xtask shares the version of the workspace.
    let parts = [
        ("MAJOR", env!("CARGO_PKG_VERSION_MAJOR")),
        ("MINOR", env!("CARGO_PKG_VERSION_MINOR")),
        ("PATCH", env!("CARGO_PKG_VERSION_PATCH")),
    ];
    let mut text =
        String::from("\n/* The version of this header; cata_version tells the library's. */\n");
    for (part, number) in parts {
        text += &format!("#define CATA_VERSION_{part} {number}\n");
    }
    text + &format!("#define CATA_VERSION_STRING \"{}\"", env!("CARGO_PKG_VERSION"))
}

#[cfg(test)]
mod tests {
    use super::tidied;

    #[test]
    fn comments_are_tidied() {
        let raw = "/**\n * One.\n */\n#define A 1\n\n/**\n * Two\n * lines.\n *\n * # Safety\n \
                   * Rust.\n */\nint f(void);\n";
        let tidy = "/** One. */\n#define A 1\n\n/**\n * Two\n * lines.\n */\nint f(void);\n";
        assert_eq!(tidied(raw), tidy);
    }
}
