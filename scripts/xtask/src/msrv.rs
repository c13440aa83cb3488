//! The minimum Rust version, as far as one toolchain can check it: no dependency of the library, of
//! the command line or of the Python package asks for more. Clippy's `incompatible_msrv` watches
//! our own code, and the hosted workflow builds with that very version.

use std::path::Path;

use serde_json::Value;

use crate::packages::{Graph, text};

/// Fails and names every dependency that needs a newer Rust than `package.rust-version`.
pub fn check(root: &Path) -> Result<(), String> {
    let newer = newer_dependencies(&Graph::read(root, None)?)?;
    if newer.is_empty() { Ok(()) } else { Err(newer.join("\n")) }
}

/// Returns the dependencies, direct or not, that ask for a newer Rust than we do.
fn newer_dependencies(graph: &Graph) -> Result<Vec<String>, String> {
    let minimum = graph.ours().into_iter().find_map(version).ok_or("no rust-version")?;
    // Dependencies of tests do not reach our users.
    let reached = graph.reached(|_, kind| kind != Some("dev")).into_iter();
    let mut newer: Vec<String> = reached
        .filter(|package| version(package).is_some_and(|v| v > minimum))
        .map(|package| (text(package, "name"), text(package, "rust_version")))
        .map(|(name, needs)| format!("{name} needs Rust {needs}, newer than our minimum"))
        .collect();
    newer.sort();
    Ok(newer)
}

/// Returns `rust_version` as numbers.
fn version(package: &Value) -> Option<Vec<u32>> {
    let text = package["rust_version"].as_str()?;
    text.split('.').map(|part| part.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::{Graph, newer_dependencies};
    use serde_json::json;

    #[test]
    fn a_dependency_that_needs_a_newer_rust_is_named() {
        let package = |name: &str, rust: &str| json!({"id": name, "name": name, "rust_version": rust, "source": null});
        let dependency =
            |name: &str, kind: Option<&str>| json!({"pkg": name, "dep_kinds": [{"kind": kind}]});
        let metadata = json!({
            "packages": [package("catamaran", "1.89"), package("old", "1.60.0"),
                package("new", "1.90"), package("test-only", "1.99")],
            "resolve": {"nodes": [
                {"id": "catamaran",
                 "deps": [dependency("old", None), dependency("test-only", Some("dev"))]},
                {"id": "old", "deps": [dependency("new", Some("build"))]},
                {"id": "new", "deps": []},
                {"id": "test-only", "deps": []},
            ]},
        });
        let newer = newer_dependencies(&Graph::of(&metadata)).unwrap();
        assert_eq!(newer, ["new needs Rust 1.90, newer than our minimum"]);
    }
}
