//! The packages that the libraries, the command line and the Python package are built from, as
//! `cargo metadata` lists them.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// What others are made of: the libraries, the command line and the Python package.
const OURS: [&str; 4] = ["catamaran", "catamaran-cli", "catamaran-blas", "catamaran-python"];

/// The whole graph, with every feature, of one platform or of all.
pub struct Graph {
    /// By their ids.
    packages: HashMap<String, Value>,
    nodes: HashMap<String, Value>,
}

impl Graph {
    /// Reads it from the lock file at `root`, which has to be up to date.
    pub fn read(root: &Path, platform: Option<&str>) -> Result<Self, String> {
        let mut command = Command::new(env!("CARGO"));
        command.args(["metadata", "--format-version", "1", "--locked", "--all-features"]);
        if let Some(platform) = platform {
            command.args(["--filter-platform", platform]);
        }
        let output =
            command.current_dir(root).output().map_err(|e| format!("cargo metadata: {e}"))?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned());
        }
        let metadata =
            serde_json::from_slice(&output.stdout).map_err(|e| format!("cargo metadata: {e}"))?;
        Ok(Self::of(&metadata))
    }

    /// Returns the packages that `metadata` lists.
    pub fn of(metadata: &Value) -> Self {
        let by_id = |all: &Value| list(all).iter().map(|v| (text(v, "id"), v.clone())).collect();
        Self { packages: by_id(&metadata["packages"]), nodes: by_id(&metadata["resolve"]["nodes"]) }
    }

    /// Returns the packages of this workspace.
    pub fn ours(&self) -> Vec<&Value> {
        let ours = |p: &&Value| OURS.contains(&text(p, "name").as_str()) && p["source"].is_null();
        self.packages.values().filter(ours).collect()
    }

    /// Returns ours and all packages that they depend on, by dependencies of the kinds that
    /// `follow` allows: `None` for normal ones, `build`, `dev`.
    pub fn reached(&self, follow: impl Fn(&Value, Option<&str>) -> bool) -> Vec<&Value> {
        let mut waiting: Vec<String> = self.ours().iter().map(|p| text(p, "id")).collect();
        let mut seen = HashSet::new();
        let mut reached = Vec::new();
        while let Some(id) = waiting.pop() {
            if !seen.insert(id.clone()) {
                continue;
            }
            reached.push(&self.packages[&id]);
            for dependency in list(&self.nodes[&id]["deps"]) {
                let target = text(dependency, "pkg");
                let kinds = list(&dependency["dep_kinds"]);
                if kinds.iter().any(|k| follow(&self.packages[&target], k["kind"].as_str())) {
                    waiting.push(target);
                }
            }
        }
        reached
    }
}

/// Returns a text of a value, empty when it has none.
pub fn text(value: &Value, key: &str) -> String {
    value[key].as_str().unwrap_or_default().to_owned()
}

/// Returns a list of a value, empty when it is none.
pub fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}
