//! Prints the reports of `mesh`.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use catamaran::Par;
use catamaran_geometry::mesh::io::MeshFile;
use catamaran_geometry::mesh::vector::distance;
use catamaran_geometry::mesh::{
    Comparison, Edges, Genus, OneSided, Problem, RepairStep, TriMesh, Validation,
};
use serde_json::{Value, json};

use crate::input;
use crate::report::{report, row, status};

/// Reports the topology of a mesh, its problems, and the options that help.
pub fn validation(mesh: &TriMesh, found: &Validation) -> Result<()> {
    let options = options(mesh, found);
    let mut text = found.to_string();
    for (option, what) in &options {
        text += &format!("\noption      {option} {what}");
    }
    let options: Vec<&str> = options.iter().map(|(option, _)| &**option).collect();
    row!(
        "validation",
        vertices = found.vertices,
        edges = found.edges,
        boundary_edges = found.boundary_edges,
        faces = found.faces,
        components = found.components,
        loops = found.boundary_loops,
        euler_characteristic = found.euler_characteristic,
        genus = found.genus.map(genus),
        orientable = found.genus.map(|genus| matches!(genus, Genus::Orientable(_))),
        problems = found.problems.iter().map(problem).collect::<Vec<_>>(),
        options = options;
        "{text}"
    )
}

/// What `--weld` with a tolerance does.
const JOINS: &str = "joins vertices at most that far apart";

/// Returns the length of the shortest edge that is not 0; infinite without one.
fn shortest_edge(mesh: &TriMesh) -> f64 {
    let length = |&[a, b]: &[u32; 2]| between(mesh, a, b);
    let edges = Edges::new(mesh);
    let lengths = edges.ends().iter().map(length).filter(|length| *length > 0.0);
    lengths.fold(f64::INFINITY, f64::min)
}

/// Returns the distance between two vertices.
fn between(mesh: &TriMesh, a: u32, b: u32) -> f64 {
    distance(mesh.vertices()[a as usize], mesh.vertices()[b as usize])
}

/// Returns the options that help against the problems of a mesh, with what they do.
fn options(mesh: &TriMesh, found: &Validation) -> Vec<(String, &'static str)> {
    let mut options = Vec::new();
    let has = |kind: fn(&Problem) -> bool| found.problems.iter().any(kind);
    let apart = found.problems.iter().filter_map(|problem| match problem {
        Problem::CoincidentVertex { vertex, first } => Some(between(mesh, *vertex, *first)),
        _ => None,
    });
    match apart.reduce(f64::max) {
        Some(0.0) => options.push(("--weld".into(), "joins vertices in the same place")),
        // A round number above the distance, below the edges, which are to stay.
        Some(apart) if 2.0 * apart < shortest_edge(mesh) => {
            options.push((format!("--weld={:.0e}", 1.5 * apart), JOINS));
        }
        Some(_) => options.push(("--weld=TOLERANCE".into(), JOINS)),
        None if has(|p| matches!(p, Problem::LooseFace(_))) => {
            options.push(("--weld=TOLERANCE".into(), JOINS));
        }
        None => {}
    }
    let mut add = |kind: fn(&Problem) -> bool, option: &str, what| {
        if has(kind) {
            options.push((option.into(), what));
        }
    };
    add(|p| matches!(p, Problem::RepeatedFace { .. }), "--drop-duplicates", "drops repeated faces");
    add(|p| matches!(p, Problem::ZeroArea(_)), "--drop-degenerate", "removes faces without area");
    add(
        |p| matches!(p, Problem::UnreferencedVertex(_)),
        "--compact",
        "drops vertices without a face",
    );
    let is_cut = |p: &Problem| {
        matches!(p, Problem::NonManifoldEdge { .. } | Problem::NonManifoldVertex { .. })
    };
    add(is_cut, "--repair", "cuts the mesh into manifolds");
    // A surface like a Moebius strip stays inconsistent.
    if !has(|p| matches!(p, Problem::NotOrientable { .. })) {
        let disagree = |p: &Problem| matches!(p, Problem::Inconsistent { .. });
        if has(disagree) {
            add(disagree, "--orient", "flips faces until they agree");
        } else {
            let is_turned = |p: &Problem| matches!(p, Problem::InsideOut(_));
            add(is_turned, "--orient", "flips the faces of components that are inside out");
        }
    }
    options
}

/// Returns a problem as JSON: its kind, and the elements that have it.
fn problem(problem: &Problem) -> Value {
    match problem {
        Problem::NoFace { vertices } => json!({"kind": "no_face", "vertices": vertices}),
        Problem::CollapsedFaces { count, first } => {
            json!({"kind": "collapsed_faces", "faces": count, "first": first})
        }
        Problem::UnreferencedVertex(vertex) => {
            json!({"kind": "unreferenced_vertex", "vertex": vertex})
        }
        Problem::NonManifoldEdge { ends, faces } => {
            json!({"kind": "non_manifold_edge", "ends": ends, "faces": faces})
        }
        Problem::NonManifoldVertex { vertex, fans } => {
            json!({"kind": "non_manifold_vertex", "vertex": vertex, "fans": fans})
        }
        Problem::RepeatedFace { face, first } => {
            json!({"kind": "repeated_face", "face": face, "first": first})
        }
        Problem::ZeroArea(face) => json!({"kind": "zero_area", "face": face}),
        Problem::Inconsistent { ends, faces } => {
            json!({"kind": "inconsistent", "ends": ends, "faces": faces})
        }
        Problem::InsideOut(face) => json!({"kind": "inside_out", "face": face}),
        Problem::CoincidentVertex { vertex, first } => {
            json!({"kind": "coincident_vertex", "vertex": vertex, "first": first})
        }
        Problem::LooseFace(face) => json!({"kind": "loose_face", "face": face}),
        Problem::NotOrientable { why } => json!({"kind": "not_orientable", "reason": why}),
        other => json!({"kind": "other", "reason": other.to_string()}),
    }
}

/// Returns the number of handles, or of cross-caps.
pub fn genus(genus: Genus) -> usize {
    match genus {
        Genus::Orientable(number) | Genus::NonOrientable(number) => number,
    }
}

/// Reports what a step of a repair did.
pub fn repair(step: &RepairStep) -> Result<()> {
    let counts: Vec<(&str, usize)> = match *step {
        RepairStep::Welded { vertices, faces, colors, .. } => {
            vec![("joined_vertices", vertices), ("collapsed_faces", faces), ("lost_colors", colors)]
        }
        RepairStep::ClosedSeams { vertices, colors, ambiguous } => vec![
            ("joined_vertices", vertices),
            ("lost_colors", colors),
            ("ambiguous_edges", ambiguous),
        ],
        RepairStep::DroppedDuplicates { faces, .. } => vec![("dropped_faces", faces)],
        RepairStep::DroppedDegenerate { joined, flipped, faces, .. } => {
            vec![("joined_vertices", joined), ("flipped_edges", flipped), ("dropped_faces", faces)]
        }
        RepairStep::Compacted { vertices } => vec![("dropped_vertices", vertices)],
        RepairStep::Cut { edges, vertices } => {
            vec![("cut_edges", edges), ("split_vertices", vertices)]
        }
        RepairStep::KeptLargest { components, faces }
        | RepairStep::DroppedSpecks { components, faces, .. } => {
            vec![("dropped_components", components), ("dropped_faces", faces)]
        }
        RepairStep::FilledHoles { holes, faces, left } => {
            vec![("filled_holes", holes), ("new_faces", faces), ("left_loops", left)]
        }
        RepairStep::Oriented { faces, not_orientable, .. } => {
            vec![("flipped_faces", faces), ("not_orientable_parts", not_orientable)]
        }
        _ => vec![],
    };
    // The name of the step has a separate column, as labels have.
    let line = step.to_string();
    let (name, what) = line.split_once(' ').unwrap_or((&line, ""));
    report!(
        "repair": name,
        step = name,
        changed = step.changed(),
        counts = counts.iter().copied().collect::<BTreeMap<_, _>>();
        "{}",
        what.trim_start()
    )
}

/// Reports on the differences between the mesh and another one.
pub fn compare(mesh: &TriMesh, found: &Validation, path: &Path) -> Result<()> {
    let other = input::mesh(path)?.mesh;
    let there = other.validate();
    let between = Comparison::between(mesh, &other, Par::all())?;
    let longest = |mesh: &TriMesh| {
        let [low, high] = mesh.bounding_box().unwrap_or_default();
        (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max)
    };
    let path = path.display().to_string();
    status!("compared", path = path; "{path}")?;
    let side = longest(mesh);
    let line = |label: &str, direction: &str, far: &OneSided| {
        let OneSided { largest, mean, angle, .. } = far;
        report!(
            "distance": label,
            direction = direction,
            largest = largest,
            largest_share = largest / side,
            mean = mean,
            mean_share = mean / side,
            normals_degrees = angle;
            "largest distance {largest:.4e} ({:.4e} of the longest side), mean \
             {mean:.4e} ({:.4e}), normals {angle:.2} degrees",
            largest / side,
            mean / side
        )
    };
    line("to other", "to_other", &between.out)?;
    line("from other", "from_other", &between.back)?;
    let far = between.out.largest.max(between.back.largest);
    let share = far / side;
    report!(
        "hausdorff": "Hausdorff",
        distance = far,
        share = share;
        "{far:.4e} ({share:.4e} of the longest side)"
    )?;
    let areas = [mesh.area(), other.area()];
    let both = [found, &there];
    let columns = |label: &str, [own, other]: [Option<String>; 2]| {
        let known = |text: Option<String>| text.unwrap_or_else(|| "unknown".into());
        format!("{label:<12}{:<24}{}", known(own), known(other))
    };
    let counts = |label, count: fn(&Validation) -> usize| {
        columns(label, both.map(|v| Some(count(v).to_string())))
    };
    row!(
        "comparison",
        vertices = both.map(|v| v.vertices),
        faces = both.map(|v| v.faces),
        area = areas,
        components = both.map(|v| v.components),
        loops = both.map(|v| v.boundary_loops),
        genus = both.map(|v| v.genus.map(genus)),
        problems = both.map(|v| v.problems.len());
        "{}",
        [
            counts("vertices", |v| v.vertices),
            counts("faces", |v| v.faces),
            columns("area", areas.map(|area| Some(area.to_string()))),
            counts("components", |v| v.components),
            columns("loops", both.map(|v| v.boundary_loops.map(|loops| loops.to_string()))),
            columns("genus", both.map(|v| v.genus.map(|genus| genus.to_string()))),
            counts("problems", |v| v.problems.len()),
        ]
        .join("\n")
    )
}

/// Reports sizes and qualities.
pub fn measures(file: &MeshFile) -> Result<()> {
    let mesh = &file.mesh;
    let area = mesh.area();
    report!("area", area = area; "{area}")?;
    if let Some(volume) = mesh.volume() {
        let note = if volume < 0.0 { ", faces are clockwise as seen from outside" } else { "" };
        report!("volume", volume = volume; "{volume}{note}")?;
    }
    if let Some([low, high]) = mesh.bounding_box() {
        report!("box", low = low, high = high; "{low:?} to {high:?}")?;
    }
    let intersecting = mesh.intersecting_faces(Par::all()).len();
    report!("intersect", faces = intersecting; "{intersecting} faces with others")?;
    let qualities = mesh.qualities();
    if !qualities.is_empty() {
        let count = qualities.len() as f64;
        let mean = qualities.iter().sum::<f64>() / count;
        let least = qualities.iter().copied().fold(1.0, f64::min);
        let slivers = 100.0 * qualities.iter().filter(|&&q| q < 0.1).count() as f64 / count;
        report!(
            "quality",
            mean = mean,
            least = least,
            below_a_tenth_percent = slivers;
            "{mean:.3} mean, {least:.3} least, {slivers:.2} % below 0.1 (1: equilateral)"
        )?;
    }
    let extras = [
        (file.uv.is_some(), "texture coordinates"),
        (file.normals.is_some(), "normals"),
        (file.colors.is_some(), "colours"),
        (!file.scalars.is_empty(), "scalars"),
    ];
    let extras: Vec<_> =
        extras.into_iter().filter(|(there, _)| *there).map(|(_, what)| what).collect();
    if !extras.is_empty() {
        report!("attributes", names = extras; "{}", extras.join(", "))?;
    }
    Ok(())
}
