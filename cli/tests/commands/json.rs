//! `--json` and `--quiet`: what commands print for programs.

use std::collections::BTreeMap;

use catamaran_geometry::mesh::families;
use catamaran_geometry::mesh::vector::dot;
use serde_json::{Map, Value};

use crate::common::{Folder, table};
use crate::lines::{LINES, folder_for, inputs};

/// Further lines, whose records those of [`LINES`] lack.
const MORE: &[&str] = &[
    "ata a.npy --explain --verify",
    "ata a.mtx --explain",
    "ata a.npy -o c.npy --explain --scheme exact --covariance",
    "ata a.npy -o c.npy --checkpoint sums --resume",
    "lstsq a.npy w.npy",
    "lstsq a.csv --by-column 7 --confidence 0.9 --missing drop",
    "predict fit.json a.csv --interval observation",
    "mesh sphere.ply --repair --orient --compare torus.obj --drop-specks 0.1 --fill-holes 3",
    "decimate sphere.ply -n 40 -o out.ply --report",
    "spectrum sphere.ply -k 4 --via-decimation 60",
    "filter sphere.ply --low-pass 9 --order 2 -k 5 -o out.ply",
    "wilt --grow 20 --hours 3 --frames 1 -o out --motion 0.1 --soil 10 --mesh none",
    "wilt plant.txt --fit weights.csv -o out",
    "curve sphere.ply --samples ring.txt --region r.csv --cut pieces/",
    "newton --volume --size 9 --basins 4 -o basin.ply",
    "slime square.obj --config c.toml --steps 3 -o out --state s.state --resume",
    "unions predict left.off right.off --localize template.ply",
];

/// The vertices of the sphere of the inputs two edges from its first one, a line each.
fn ring() -> String {
    let sphere = families::icosphere(2).unwrap();
    let angle = |p: &[f64; 3]| dot(*p, sphere.vertices()[0]).acos();
    let is_near = |&i: &usize| (0.5..0.7).contains(&angle(&sphere.vertices()[i]));
    (0..sphere.vertices().len()).filter(is_near).map(|i| format!("{i}\n")).collect()
}

/// Records of a text, each a JSON object with a name and keys in `snake_case`.
fn records(line: &str, text: &str) -> Vec<Map<String, Value>> {
    let is_key = |key: &str| {
        key.starts_with(|c: char| c.is_ascii_lowercase())
            && key.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
    };
    let record = |text: &str| -> Map<String, Value> {
        let record: Map<String, Value> = serde_json::from_str(text)
            .unwrap_or_else(|e| panic!("{line}: {e} where one JSON object is expected: {text}"));
        assert!(text.starts_with("{\"record\":"), "{line}: {text}");
        assert!(record["record"].as_str().is_some_and(is_key), "{line}: {text}");
        assert!(record.keys().all(|key| is_key(key)), "{line}: {text}");
        record
    };
    text.lines().map(record).collect()
}

/// The records that a line prints in this folder.
fn run(folder: &Folder, line: &str) -> Vec<Map<String, Value>> {
    records(line, &folder.succeed(&format!("--json {line}")))
}

/// The records of a name.
fn named<'a>(records: &'a [Map<String, Value>], name: &str) -> Vec<&'a Map<String, Value>> {
    records.iter().filter(|record| record["record"] == name).collect()
}

/// `lines::every_command_has_a_line` asks for a line for each command; that of `demo` is in
/// `demo.rs`.
#[test]
fn every_command_prints_json_lines() {
    inputs().write("ring.txt", ring());
    inputs().succeed("unions template -o template.ply");
    inputs().write("weights.csv", "time_h,weight_g\n0,30\n1,29\n2,28.2\n3,27.5\n");
    let is_told =
        |line: &&&str| !["demo", "--picture", "--render"].iter().any(|word| line.contains(*word));
    for line in LINES.iter().filter(is_told).chain(MORE) {
        let found = run(&folder_for(line), line);
        assert!(!found.is_empty(), "{line}: no record");
    }
}

#[test]
fn tables_are_records_with_all_rows() {
    let folder = Folder::new();
    let (m, n) = (90, 60);
    folder.write_npy("a.npy", &[m as u64, n as u64], &table(m, n));
    let found = run(&folder, "svd a.npy");
    let values = named(&found, "singular_value");
    assert_eq!(values.len(), n);
    let value = |i: usize| values[i]["value"].as_f64().unwrap();
    assert!((1..n).all(|i| value(i) <= value(i - 1)));
    assert!((0..n).all(|i| values[i]["number"] == i));
    // The text has as many as a screen.
    assert!(folder.succeed("svd a.npy").contains("... and 10 more"));

    let rank = named(&found, "rank");
    assert_eq!((&rank[0]["columns"], rank.len()), (&Value::from(n), 1));
    assert!(named(&found, "time")[0]["seconds"].as_f64().unwrap() > 0.0);
}

#[test]
fn shares_of_components_are_also_cumulative() {
    let folder = Folder::new();
    folder.write("a.csv", "1,1\n3,0\n5,1\n");
    let found = run(&folder, "pca a.csv");
    let components = named(&found, "component");
    assert_eq!(components.len(), 2);
    let share = |i: usize| components[i]["share"].as_f64().unwrap();
    assert_eq!(components[1]["cumulative"].as_f64(), Some(share(0) + share(1)));
}

#[test]
fn directions_of_a_comparison_are_to_and_from_the_other_mesh() {
    let found = run(inputs(), "mesh sphere.ply --compare torus.obj");
    let directions: Vec<_> =
        named(&found, "distance").iter().map(|record| record["direction"].clone()).collect();
    assert_eq!(directions, ["to_other", "from_other"]);
}

#[test]
fn problems_of_a_mesh_are_told_by_kind_and_element() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\nf 3 1 2\n");
    let found = run(&folder, "mesh a.obj");
    let validation = named(&found, "validation")[0];
    assert_eq!(validation["vertices"], 4);
    let kinds: BTreeMap<&str, &Value> = validation["problems"]
        .as_array()
        .unwrap()
        .iter()
        .map(|problem| (problem["kind"].as_str().unwrap(), problem))
        .collect();
    assert_eq!(kinds["unreferenced_vertex"]["vertex"], 3);
    assert_eq!(kinds["repeated_face"]["first"], 0);
}

#[test]
fn what_is_not_finite_is_null() {
    let folder = Folder::new();
    folder.write("a.csv", "1\n1\n");
    folder.write("b.csv", "2\n2\n");
    let found = run(&folder, "lstsq a.csv b.csv");
    let coefficient = named(&found, "coefficient")[0];
    assert_eq!((&coefficient["value"], &coefficient["t"]), (&Value::from(2.0), &Value::Null));
}

#[test]
fn quiet_leaves_results_only() {
    let folder = Folder::new();
    folder.write("a.csv", "1,2\n3,4\n");
    assert_eq!(folder.succeed("ata a.csv -o c.csv --quiet"), "");
    let check = folder.succeed("ata a.csv -o c.csv --verify --force --quiet");
    assert!(check.starts_with("check       passed") && check.lines().count() == 1, "{check}");
    let all = folder.succeed("svd a.csv");
    let results = folder.succeed("--quiet svd a.csv");
    let all = all.split_once("hint").map_or(&*all, |parts| parts.0);
    assert!(all.ends_with(&results) && results.starts_with("rank "), "{results}");
    let found = records("svd", &folder.succeed("svd a.csv --quiet --json"));
    assert!(named(&found, "time").is_empty() && named(&found, "singular_value").len() == 2);
    // Notes stay.
    folder.write("b.csv", "1,1\n2,2\n3,3\n");
    let run = folder.run("lstsq b.csv --by-column 1 --columns 0..2 --quiet");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    folder.write("b.csv", "1,1,5\n2,2,6\n3,3,8\n");
    let run = folder.run("lstsq b.csv --by-column 2 --quiet");
    assert!(run.stderr.contains("note: b.csv: column"), "{}", run.stderr);
}
