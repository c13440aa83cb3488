//! `NOTICE`: whose work the library, the command line and the Python package contain.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

use crate::generated::Generated;
use crate::packages::{Graph, list, text};

/// `NOTICE` of this repository.
pub const NOTICE: Generated =
    Generated { name: "NOTICE", source: "Cargo.lock", command: "cargo xtask notice", generate };

/// The platform whose packages are listed; those of others differ in what they call the system by.
const PLATFORM: &str = "x86_64-unknown-linux-gnu";

const INTRODUCTION: &str = "\
Catamaran is licensed under MIT or Apache-2.0. Programs that contain it also contain packages of
others, with all features on Linux those below: name, version, license (SPDX; texts at
https://spdx.org/licenses), where they come from, and whose they are as their license files say. System
libraries that features link (OpenBLAS, HDF5, MPI, OpenCL) are not part of it.

Fonts and data:
Noto Sans Mono, in pictures with text: SIL Open Font License 1.1
    https://fonts.google.com/noto/specimen/Noto+Sans+Mono
Statistical Reference Datasets of NIST, in tests: public domain (17 U.S.C. 105)
    https://www.itl.nist.gov/div898/strd
Nefertiti, and Spot by Keenan Crane, in pictures of docs/guide: public domain
    https://github.com/odedstein/meshes
Weights of the network of `unions`: trained on generated shapes; license of Catamaran

Written by `cargo xtask notice`.
";

fn generate(root: &Path) -> Result<String, String> {
    let graph = Graph::read(root, Some(PLATFORM))?;
    // What only runs while others are compiled is in no program.
    let contained = |package: &Value, kind: Option<&str>| kind.is_none() && !is_macro(package);
    let mut packages = graph.reached(contained);
    packages.retain(|package| !package["source"].is_null());
    packages.sort_by_key(|package| (text(package, "name"), text(package, "version")));
    let mut notice = String::from(INTRODUCTION);
    for package in packages {
        let (name, version) = (text(package, "name"), text(package, "version"));
        let license = text(package, "license");
        if license.is_empty() {
            return Err(format!("{name} {version} does not say its license"));
        }
        let _ =
            writeln!(notice, "\n{name} {version}: {license}\n    {}", text(package, "repository"));
        let manifest = text(package, "manifest_path");
        let folder = Path::new(&manifest).parent().ok_or("a package without a folder")?;
        for line in copyrights(folder)? {
            let _ = writeln!(notice, "    {line}");
        }
    }
    Ok(notice)
}

fn is_macro(package: &Value) -> bool {
    let kinds = list(&package["targets"]).iter().flat_map(|target| list(&target["kind"]));
    kinds.into_iter().any(|kind| kind == "proc-macro")
}

/// Returns the lines of its license files that name whose a package is.
fn copyrights(folder: &Path) -> Result<BTreeSet<String>, String> {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut lines = BTreeSet::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_uppercase();
        let names = ["LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE"];
        if path.is_file() && names.iter().any(|start| name.starts_with(start)) {
            let bytes = std::fs::read(&path).map_err(failed)?;
            lines.extend(String::from_utf8_lossy(&bytes).lines().filter_map(copyright));
        }
    }
    Ok(lines)
}

/// Returns a line that says `Copyright` and whose, without what license texts say of copyright.
fn copyright(line: &str) -> Option<String> {
    let line =
        line.trim_start_matches(|c: char| c.is_whitespace() || "*#/-".contains(c)).trim_end();
    let rest = line.strip_prefix("Copyright ")?.trim_start();
    let placeholder = rest.contains(['[', '{', '<']) && !rest.contains('@');
    let named = ["(c)", "(C)", "\u{a9}"].iter().any(|sign| rest.starts_with(sign))
        || rest.starts_with(|c: char| c.is_ascii_digit())
        || (rest.starts_with(|c: char| c.is_uppercase()) && !rest.starts_with("License"));
    (named && !placeholder).then(|| line.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::copyright;

    #[test]
    fn lines_that_name_somebody_are_told_from_those_of_license_texts() {
        for line in ["Copyright (c) 2015 A. Person", "  Copyright 2020-2024 The Project Developers"]
        {
            assert_eq!(copyright(line).as_deref(), Some(line.trim()));
        }
        let mailed = "Copyright (c) 2014 A. Person <a@b.c>";
        assert_eq!(copyright(mailed).as_deref(), Some(mailed));
        for line in [
            "Copyright [yyyy] [name of copyright owner]",
            "Copyright (c) <year> <owner>",
            "Copyright License. Subject to the terms",
            "copyright notice that is included",
            "the above copyright notice",
        ] {
            assert_eq!(copyright(line), None, "{line}");
        }
    }
}
