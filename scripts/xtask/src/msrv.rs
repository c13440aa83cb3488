//! The minimum Rust version, as far as one toolchain can check it: no dependency of the library or
//! of the command line asks for more. Clippy's `incompatible_msrv` watches our own code, and the
//! hosted workflow builds with that very version.

use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Fails and names every dependency that needs a newer Rust than `package.rust-version`.
pub fn check(root: &Path) -> Result<(), String> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--all-features"])
        .current_dir(root)
        .output()
        .map_err(|e| format!("cargo metadata: {e}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    let metadata: Value =
        serde_json::from_slice(&output.stdout).map_err(|e| format!("cargo metadata: {e}"))?;
    let newer = newer_dependencies(&metadata, &["catamaran", "catamaran-cli"])?;
    if newer.is_empty() { Ok(()) } else { Err(newer.join("\n")) }
}

/// The dependencies, direct or not, of `ours` that ask for a newer Rust than the first of them.
fn newer_dependencies(metadata: &Value, ours: &[&str]) -> Result<Vec<String>, String> {
    let text = |v: &Value, key: &str| v[key].as_str().unwrap_or_default().to_owned();
    let list = |v: &Value| v.as_array().cloned().unwrap_or_default();
    let packages: HashMap<String, Value> =
        list(&metadata["packages"]).into_iter().map(|p| (text(&p, "id"), p)).collect();
    let nodes: HashMap<String, Value> =
        list(&metadata["resolve"]["nodes"]).into_iter().map(|n| (text(&n, "id"), n)).collect();
    let mut waiting: Vec<String> = packages
        .values()
        .filter(|p| ours.contains(&text(p, "name").as_str()) && p["source"].is_null())
        .map(|p| text(p, "id"))
        .collect();
    let minimum = waiting.iter().find_map(|id| version(&packages[id])).ok_or("no rust-version")?;
    let mut seen = std::collections::HashSet::new();
    let mut newer = Vec::new();
    while let Some(id) = waiting.pop() {
        if !seen.insert(id.clone()) {
            continue;
        }
        let package = &packages[&id];
        if version(package).is_some_and(|v| v > minimum) {
            let (name, needs) = (text(package, "name"), text(package, "rust_version"));
            newer.push(format!("{name} needs Rust {needs}, newer than our minimum"));
        }
        for dependency in list(&nodes[&id]["deps"]) {
            // Dependencies of tests do not reach our users.
            let kinds = list(&dependency["dep_kinds"]);
            if kinds.iter().any(|k| k["kind"].as_str() != Some("dev")) {
                waiting.push(text(&dependency, "pkg"));
            }
        }
    }
    newer.sort();
    Ok(newer)
}

/// `rust_version` as numbers.
fn version(package: &Value) -> Option<Vec<u32>> {
    let text = package["rust_version"].as_str()?;
    text.split('.').map(|part| part.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::newer_dependencies;
    use serde_json::json;

    #[test]
    fn a_dependency_that_needs_a_newer_rust_is_named() {
        let package = |name: &str, rust: &str| json!({"id": name, "name": name, "rust_version": rust, "source": null});
        let dependency =
            |name: &str, kind: Option<&str>| json!({"pkg": name, "dep_kinds": [{"kind": kind}]});
        let metadata = json!({
            "packages": [package("us", "1.89"), package("old", "1.60.0"), package("new", "1.90"),
                package("test-only", "1.99")],
            "resolve": {"nodes": [
                {"id": "us", "deps": [dependency("old", None), dependency("test-only", Some("dev"))]},
                {"id": "old", "deps": [dependency("new", Some("build"))]},
                {"id": "new", "deps": []},
                {"id": "test-only", "deps": []},
            ]},
        });
        let newer = newer_dependencies(&metadata, &["us"]).unwrap();
        assert_eq!(newer, ["new needs Rust 1.90, newer than our minimum"]);
    }
}
