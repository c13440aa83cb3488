//! Decimation: farthest points against brute force, invariants of cells, duals, weights and
//! resampling, and the promise of exactly n vertices on a manifold of the same topology, or a
//! refusal that says why.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::base::Progress;
use catamaran::{Error, Par};
use catamaran_geometry::decimate::{
    Cells, DecimateOptions, Decimation, Decimator, Difference, FarthestPoints, Method, Quality,
    decimate, decimate_within, edge_length_for, resample, vertices_for_edge_length,
    vertices_for_faces,
};
use catamaran_geometry::mesh::io::{self, Attribute, MeshFile};
use catamaran_geometry::mesh::{
    Comparison, Dijkstra, Edges, Genus, Graph, SearchLimits, TriMesh, families,
};

fn options() -> DecimateOptions<'static> {
    DecimateOptions::new().par(Par::Seq)
}

/// Everything that a decimation promises.
pub fn check(name: &str, input: &TriMesh, n: usize, found: &Decimation) {
    let mesh = &found.mesh;
    assert_eq!(mesh.vertices().len(), n, "{name}");
    assert!(mesh.unreferenced_vertices().is_empty(), "{name}");
    mesh.require_manifold().unwrap_or_else(|e| panic!("{name}: {e}"));
    let after = found.after.unwrap_or_else(|| panic!("{name}: no topology"));
    assert_eq!(found.before, after, "{name}");
    let validation = mesh.validate();
    assert_eq!(validation.genus, Some(after.genus), "{name}");
    assert_eq!(validation.components, after.components, "{name}");
    assert_eq!(validation.boundary_loops, Some(after.boundary_loops), "{name}");
    let vertices = input.vertices();
    assert_eq!(found.cells.of_vertices().len(), vertices.len(), "{name}");
    let unreferenced = input.unreferenced_vertices();
    for (v, &cell) in found.cells.of_vertices().iter().enumerate() {
        let lonely = unreferenced.contains(&(v as u32));
        assert_eq!(cell == Cells::NONE, lonely, "{name}: vertex {v}");
        assert!(lonely || (cell as usize) < n, "{name}: vertex {v}");
    }
    let longest = longest_edge(mesh);
    for (v, place) in found.places.iter().enumerate() {
        assert!(place.weights.iter().all(|w| (0.0..=1.0).contains(w)), "{name}: {place:?}");
        assert!((place.weights.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{name}: {place:?}");
        // A vertex is raised by half of the height of the surface above the faces around it, and
        // the middle of a collapsed edge is as far from its ends as half of the edge.
        let off = distance(place.position(input), mesh.vertices()[v]);
        assert!(off <= longest, "{name}: vertex {v} is {off} off, edges are {longest} at most");
    }
}

fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
}

fn longest_edge(mesh: &TriMesh) -> f64 {
    let edges = Edges::new(mesh);
    let lengths = edges.ends().iter().map(|ends| {
        let [p, q] = ends.map(|v| mesh.vertices()[v as usize]);
        distance(p, q)
    });
    lengths.fold(0.0, f64::max)
}

/// Farthest points by the definition.
fn naive_farthest(mesh: &TriMesh, n: usize) -> Vec<u32> {
    let graph = Graph::of_mesh(mesh);
    let mut search = Dijkstra::new(&graph);
    let mut samples = vec![0];
    while samples.len() < n {
        let sources: Vec<_> = samples.iter().map(|&v| (v, 0.0)).collect();
        search.search(&sources, &SearchLimits::default()).unwrap();
        let farthest = (0..mesh.vertices().len() as u32)
            .max_by(|&a, &b| search.distance(a).total_cmp(&search.distance(b)).then(b.cmp(&a)));
        samples.push(farthest.unwrap());
    }
    samples
}

/// A surface on which no two distances are equal, but for rounding.
fn generic(subdivisions: u32) -> TriMesh {
    let (mut vertices, faces) = families::icosphere(subdivisions).unwrap().into_parts();
    let mut rng = catamaran::base::Rng::new(5);
    for p in &mut vertices {
        *p = p.map(|x| x * (1.0 + 0.05 * rng.uniform()));
    }
    TriMesh::new(vertices, faces).unwrap()
}

#[test]
fn farthest_points_are_those_of_brute_force() {
    for mesh in [generic(2), generic(3)] {
        let mut points = FarthestPoints::new(&mesh, None).unwrap();
        points.extend_to(40, Progress::none()).unwrap();
        assert_eq!(points.samples(), naive_farthest(&mesh, 40));
    }
}

#[test]
fn farthest_points_are_nested_and_cells_are_those_of_the_nearest_sample() {
    let mesh = generic(3);
    let mut points = FarthestPoints::new(&mesh, Some(17)).unwrap();
    points.extend_to(10, Progress::none()).unwrap();
    let ten = points.samples().to_vec();
    points.extend_to(30, Progress::none()).unwrap();
    assert_eq!(points.samples()[..10], ten);
    assert_eq!(ten[0], 17);
    let graph = Graph::of_mesh(&mesh);
    let mut search = Dijkstra::new(&graph);
    let sources: Vec<_> = points.samples().iter().map(|&v| (v, 0.0)).collect();
    search.search(&sources, &SearchLimits::default()).unwrap();
    let cells = points.cells();
    for v in 0..mesh.vertices().len() {
        let distance = search.distance(v as u32);
        assert!((f64::from(cells.distances()[v]) - distance).abs() < 1e-5);
        let sample = points.samples()[cells.of_vertices()[v] as usize];
        assert_eq!(search.origin(v as u32), Some(sample), "vertex {v}");
    }
    let farthest = search.distances().into_iter().fold(0.0, f64::max);
    assert!((cells.radius() - farthest).abs() < 1e-5, "{farthest}");
}

#[test]
fn distances_of_cells_have_the_same_digits_at_any_scale() {
    let mesh = families::torus(40, 20, 2.0, 0.8).unwrap();
    let ten = |mesh: &TriMesh| {
        let mut points = FarthestPoints::new(mesh, Some(3)).unwrap();
        points.extend_to(10, Progress::none()).unwrap();
        (points.samples().to_vec(), points.cells())
    };
    let (samples, cells) = ten(&mesh);
    let single: Vec<f64> = cells.distances().iter().map(|&d| f64::from(d)).collect();
    assert_eq!(cells.lengths(), single);
    for exponent in [-170, -146, -64, -40, 40, 64, 127, 200] {
        let factor = 2f64.powi(exponent);
        let vertices = mesh.vertices().iter().map(|p| p.map(|x| factor * x)).collect();
        let scaled = TriMesh::new(vertices, mesh.faces().to_vec()).unwrap();
        let (found, of_scaled) = ten(&scaled);
        assert_eq!(found, samples, "{exponent}");
        let expected: Vec<f64> = single.iter().map(|x| factor * x).collect();
        assert_eq!(of_scaled.lengths(), expected, "{exponent}");
        assert_eq!(of_scaled.radius(), factor * cells.radius(), "{exponent}");
        let radius = decimate(&scaled, 60, &options()).unwrap().cells.radius();
        assert!((0.1..2.0).contains(&(radius / factor)), "{exponent}: {radius:e}");
    }
}

#[test]
fn farthest_points_go_to_every_component_first_and_to_every_vertex_at_last() {
    let mesh = families::spheres(5, 1).unwrap();
    let mut points = FarthestPoints::new(&mesh, None).unwrap();
    points.extend_to(5, Progress::none()).unwrap();
    let mut spheres: Vec<u32> = points.samples().iter().map(|v| v / 42).collect();
    spheres.sort_unstable();
    assert_eq!(spheres, [0, 1, 2, 3, 4]);
    points.extend_to(210, Progress::none()).unwrap();
    let mut all = points.samples().to_vec();
    all.sort_unstable();
    assert_eq!(all, (0..210).collect::<Vec<_>>());
    let refused = points.extend_to(211, Progress::none()).unwrap_err();
    assert!(refused.to_string().contains("only 210 vertices"), "{refused}");
}

#[test]
fn every_family_is_decimated_with_its_topology() {
    let cases = [
        ("icosphere", families::icosphere(4), vec![4, 5, 17, 100, 500, 2562]),
        ("spheres", families::spheres(3, 3), vec![12, 31, 200]),
        ("torus", families::torus(61, 29, 2.0, 0.7), vec![13, 50, 300]),
        ("trefoil", families::knot(2, 3, 301, 9, 0.2), vec![200, 701]),
        ("genus 3", families::genus(3, 6), vec![60, 200, 997]),
        ("figure", families::figure(5, 0.5), vec![60, 400]),
        ("grid", families::grid(40, 30), vec![4, 10, 97, 500, 1271]),
        ("terrain", families::terrain(60, 50, 3), vec![3, 101, 600]),
        ("disk", families::disk(20, 60), vec![7, 100, 400]),
        ("cylinder", families::cylinder(60, 20, 1.0, 1.0), vec![20, 100, 500]),
        ("Moebius", families::moebius(100, 12), vec![20, 100, 500]),
        ("slivers", families::slivers(40, 40, 0.01), vec![10, 100]),
    ];
    for (name, mesh, sizes) in cases {
        let mesh = mesh.unwrap();
        for n in sizes {
            let name = format!("{name} to {n}");
            for options in [options(), options().uniform(true)] {
                let found = decimate(&mesh, n, &options).unwrap_or_else(|e| panic!("{name}: {e}"));
                check(&name, &mesh, n, &found);
            }
        }
    }
}

#[test]
fn narrow_handles_are_cut_and_told_unless_they_are_to_be_kept() {
    // A slab whose holes are one tenth of the whole, and a triangle of the result as large as a
    // hole.
    let mesh = families::genus(5, 4).unwrap();
    let keep = decimate(&mesh, 70, &options()).unwrap();
    check("slab", &mesh, 70, &keep);
    let cut = options().cut_narrow_handles(true);
    // A tube around a torus that is as thin as a hair: its loops are all narrow.
    let ring = families::torus(400, 5, 1.0, 0.002).unwrap();
    let found = decimate(&ring, 60, &cut).unwrap();
    assert_eq!(found.mesh.vertices().len(), 60);
    found.mesh.require_manifold().unwrap();
    assert_eq!(found.before.genus, Genus::Orientable(1));
    assert_eq!(found.after.unwrap().genus, found.mesh.genus(&Edges::new(&found.mesh)).unwrap());
}

#[test]
fn results_are_uniform() {
    for (mesh, n) in [
        (families::terrain(200, 200, 1).unwrap(), 800),
        (families::icosphere(5).unwrap(), 600),
        (families::figure(12, 0.3).unwrap(), 1500),
    ] {
        let found = decimate(&mesh, n, &options()).unwrap();
        let quality = Quality::of(&found.mesh);
        assert!(quality.mean_quality > 0.85, "{quality}");
        assert!(quality.area_variation < 0.25, "{quality}");
        let literal = options().method(Method::Thesis);
        let thesis = Quality::of(&decimate(&mesh, n, &literal).unwrap().mesh);
        assert!(thesis.mean_quality < quality.mean_quality, "{thesis}");
    }
}

#[test]
fn areas_are_even_where_that_is_asked_for_and_nothing_else_is_lost() {
    for (name, mesh, n) in [
        ("torus", families::torus(200, 100, 2.0, 0.8).unwrap(), 1000),
        ("terrain", families::terrain(200, 200, 1).unwrap(), 1500),
    ] {
        let found = decimate(&mesh, n, &options().uniform(true)).unwrap();
        check(name, &mesh, n, &found);
        let quality = Quality::of(&found.mesh);
        assert!(quality.area_variation <= 0.08, "{name}: {quality}");
        assert!(quality.mean_quality > 0.85, "{name}: {quality}");
        assert!(found.mesh.intersecting_faces(Par::Seq).is_empty(), "{name}");
    }
}

/// A ball with thin parts: a needle along each axis, and a blade around it.
fn thin_parts() -> [(&'static str, TriMesh); 2] {
    let ball = families::icosphere(5).unwrap();
    let stretched = |by: fn([f64; 3]) -> f64| {
        let vertices = ball.vertices().iter().map(|&p| p.map(|x| x * by(p))).collect();
        TriMesh::new(vertices, ball.faces().to_vec()).unwrap()
    };
    let needles = stretched(|p| {
        let nearest = p.iter().fold(0.0, |most: f64, x| most.max(x.abs())).min(1.0);
        1.0 + 0.8 * (-(nearest.acos() / 0.15).powi(2)).exp()
    });
    let blade = stretched(|p| 1.0 + 0.6 * (-(p[0] / 0.05).powi(2)).exp());
    [("needles", needles), ("blade", blade)]
}

#[test]
fn even_areas_make_no_slivers_of_the_faces_of_thin_parts() {
    for (name, mesh) in thin_parts() {
        for n in [300, 600] {
            let [without, with] = [false, true].map(|uniform| {
                let found = decimate(&mesh, n, &options().uniform(uniform)).unwrap();
                Quality::of(&found.mesh)
            });
            // The last step, which raises vertices, may take a bit.
            let least = 0.8 * without.least_quality.min(0.4);
            assert!(with.least_quality >= least, "{name} to {n}: {with}, not {without}");
            assert!(with.area_variation < without.area_variation, "{name} to {n}: {with}");
        }
    }
}

#[test]
fn thin_parts_are_not_cut_short() {
    for (name, mesh) in thin_parts() {
        for n in [300, 600] {
            let found = decimate(&mesh, n, &options()).unwrap();
            check(name, &mesh, n, &found);
            // Without care for them, relaxation takes two edges of the blade.
            let edge = edge_length_for(mesh.area(), n).unwrap();
            let difference = Difference::between(&mesh, &found.mesh, Par::Seq).unwrap();
            assert!(difference.hausdorff < edge, "{name} to {n}: {difference:?}, edges {edge}");
            assert!(found.mesh.area() > 0.92 * mesh.area(), "{name} to {n}");
        }
    }
}

#[test]
fn vertices_are_beside_the_surface_so_that_faces_are_on_both_sides_of_it() {
    let ball = families::icosphere(5).unwrap();
    let made = decimate(&ball, 200, &options()).unwrap().mesh;
    let radius = |p: [f64; 3]| p.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!(made.vertices().iter().all(|&p| radius(p) > 1.0));
    // On the sphere itself, the volume would be less by three times the mean depth of faces, some
    // 0.045.
    let [volume, whole] = [&made, &ball].map(|m| m.volume().unwrap());
    assert!((volume / whole - 1.0).abs() < 0.03, "{volume}");
}

#[test]
fn results_do_not_depend_on_threads() {
    let [_, (_, blade)] = thin_parts();
    for mesh in [families::genus(2, 14).unwrap(), blade] {
        same_for_all_threads(&mesh);
    }
}

fn same_for_all_threads(mesh: &TriMesh) {
    let of = |threads| {
        let options = options().threads(threads).lloyd(2);
        let found = decimate(mesh, 333, &options).unwrap();
        let weights = found.weights(mesh, Par::Threads(threads)).unwrap();
        (found, weights)
    };
    let one = of(1);
    for threads in [2, 3, 5] {
        assert!(one == of(threads), "{threads} threads");
    }
}

/// A sphere whose vertices are numbered at random.
fn shuffled_sphere() -> TriMesh {
    let (vertices, faces) = families::icosphere(5).unwrap().into_parts();
    let mut rng = catamaran::base::Rng::new(11);
    let mut numbers: Vec<u32> = (0..vertices.len() as u32).collect();
    for i in (1..numbers.len()).rev() {
        numbers.swap(i, (rng.uniform() * (i + 1) as f64) as usize);
    }
    let mut moved = vec![[0.0; 3]; vertices.len()];
    numbers.iter().zip(vertices).for_each(|(&new, p)| moved[new as usize] = p);
    let faces = faces.iter().map(|face| face.map(|v| numbers[v as usize])).collect();
    TriMesh::new(moved, faces).unwrap()
}

#[test]
fn vertices_and_faces_are_those_of_the_input_in_whatever_order_they_are_numbered() {
    let mesh = shuffled_sphere();
    let found = decimate(&mesh, 300, &options()).unwrap();
    check("shuffled sphere", &mesh, 300, &found);
    // The place of each new vertex is below it, and the vertices of its cell are around it.
    for (place, p) in found.places.iter().zip(found.mesh.vertices()) {
        assert!(distance(place.position(&mesh), *p) < 0.02);
    }
    let edge = edge_length_for(mesh.area(), 300).unwrap();
    for (p, &cell) in mesh.vertices().iter().zip(found.cells.of_vertices()) {
        assert!(distance(*p, found.mesh.vertices()[cell as usize]) < edge);
    }
    same_for_all_threads(&mesh);
    let nowhere = options().first(mesh.vertices().len() as u32);
    let refused = decimate(&mesh, 300, &nowhere).err().unwrap();
    let why = "first: must be a vertex with a face, is 10242 of 10242";
    assert_eq!(refused.to_string(), why);
}

#[test]
fn weights_take_linear_functions_over() {
    let mesh = families::grid(50, 40).unwrap();
    let found = decimate(&mesh, 200, &options()).unwrap();
    let weights = found.weights(&mesh, Par::Seq).unwrap();
    assert_eq!(weights.shape(), (51 * 41, 200));
    let mut exact = 0;
    for (row, p) in weights.outer_iterator().zip(mesh.vertices()) {
        assert!(row.nnz() <= 3 && row.iter().all(|(_, &w)| w > 0.0));
        assert!((row.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
        let at = |k: usize| row.iter().map(|(j, w)| w * found.mesh.vertices()[j][k]).sum::<f64>();
        exact += usize::from((at(0) - p[0]).abs() + (at(1) - p[1]).abs() < 1e-9);
    }
    // All but what was cut off at the corners.
    assert!(exact > 9 * mesh.vertices().len() / 10, "{exact}");
}

#[test]
fn resampled_edges_are_short_and_the_surface_is_the_same() {
    for (mesh, longest) in [
        (families::slivers(5, 5, 0.05).unwrap(), 0.02),
        (families::genus(1, 1).unwrap(), 0.2),
        (families::moebius(5, 1).unwrap(), 0.17),
        (families::pages(3).unwrap(), 0.3),
    ] {
        let found = resample(&mesh, longest).unwrap();
        assert_eq!(found.mesh.vertices()[..mesh.vertices().len()], *mesh.vertices());
        assert_eq!(found.parents.len(), found.mesh.faces().len());
        assert!(longest_edge(&found.mesh) <= longest);
        assert!((found.mesh.area() / mesh.area() - 1.0).abs() < 1e-9);
        let areas = mesh.face_areas();
        let mut sums = vec![0.0; areas.len()];
        for (area, &parent) in found.mesh.face_areas().iter().zip(&found.parents) {
            sums[parent as usize] += area;
        }
        for (sum, area) in sums.iter().zip(&areas) {
            assert!((sum / area - 1.0).abs() < 1e-9);
        }
        let (before, after) = (mesh.validate(), found.mesh.validate());
        assert_eq!(before.euler_characteristic, after.euler_characteristic);
        assert_eq!(before.boundary_loops, after.boundary_loops);
        assert_eq!(before.genus, after.genus);
    }
    // At once: an hour of work would not find vertices for them.
    for longest in [1e-9, 1e-200] {
        let refused = resample(&families::grid(1, 1).unwrap(), longest).unwrap_err();
        assert!(refused.to_string().contains("more than a mesh can have"), "{refused}");
    }
    let refused = resample(&families::grid(1, 1).unwrap(), 0.0).unwrap_err();
    assert_eq!(refused.to_string(), "longest: must be positive, is 0");
}

#[test]
fn slender_faces_are_resampled_by_faces_in_proportion_to_their_length() {
    // A polygon of so many edges has two triangles less. The long sides of the needle have 64 and
    // 64 parts (2^6), and its short side one; the cap has 64, 32 and 32. Three or four faces for
    // each in six rounds were 729 and 4096.
    for (name, tip, parts) in [("needle", 1000.0, 129), ("cap", 500.0, 128)] {
        for times in [1, 2, 4, 32] {
            let length = 1000.0 * f64::from(times);
            let tip = [tip * f64::from(times), 1.0, 0.0];
            let corners = vec![[0.0; 3], [length, 0.0, 0.0], tip];
            let mesh = TriMesh::new(corners, vec![[0, 1, 2]]).unwrap();
            let found = resample(&mesh, 20.0).unwrap().mesh;
            let edges = match name {
                "needle" => (parts - 1) * times + 1,
                _ => parts * times,
            };
            assert_eq!(found.faces().len(), edges as usize - 2, "{name}, {times} times");
            assert!((found.area() - mesh.area()).abs() < 1e-9 * mesh.area());
            assert!(longest_edge(&found) <= 20.0);
        }
    }
}

#[test]
fn a_pipe_is_resampled_without_gaps_by_faces_in_proportion_to_its_length() {
    for times in [1, 4] {
        let length = 100.0 * f64::from(times);
        let mesh = families::cylinder(64, 1, 1.0, length).unwrap();
        let found = resample(&mesh, 3.3).unwrap().mesh;
        // 32 parts of each long side, which both of its faces share.
        let parts = 32 * times as usize;
        assert_eq!(found.faces().len(), 128 * (2 * parts - 1));
        assert_eq!(found.vertices().len(), 128 * parts);
        assert!(longest_edge(&found) <= 3.3);
        assert_eq!(found.validate().boundary_loops, Some(2));
        found.require_manifold().unwrap();
    }
    // Faces that are split round by round beside those that are split at once.
    let beside = cad_cylinder(64);
    for longest in [0.11, 0.3, 0.9] {
        let found = resample(&beside, longest).unwrap().mesh;
        found.require_closed().unwrap();
        assert!(longest_edge(&found) <= longest);
        assert!((found.area() / beside.area() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn lengths_that_ask_for_too_many_parts_of_an_edge_are_refused_at_once() {
    // Nearly without area, which alone would allow it.
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1e-12, 0.0]];
    let mesh = TriMesh::new(corners, vec![[0, 1, 2]]).unwrap();
    let refused = resample(&mesh, 1e-10).unwrap_err();
    assert!(refused.to_string().contains("more than a mesh can have"), "{refused}");
    // Between these ends there is no number.
    let far = 2f64.powi(60);
    let corners = vec![[far, far, 0.0], [far + 256.0, far, 0.0], [far, far + 256.0, 0.0]];
    let mesh = TriMesh::new(corners, vec![[0, 1, 2]]).unwrap();
    let found = resample(&mesh, 60.0).unwrap().mesh;
    assert!(found.faces().len() < 20, "{}", found.faces().len());
}

#[test]
fn pipes_are_decimated_with_their_topology() {
    for (sides, length, n) in [(64, 400.0, 128), (200, 300.0, 60)] {
        let mesh = families::cylinder(sides, 1, 1.0, length).unwrap();
        let found = decimate(&mesh, n, &options()).unwrap();
        check("pipe", &mesh, n, &found);
        assert!(found.mesh.intersecting_faces(Par::Seq).is_empty());
    }
}

#[test]
fn resampling_makes_vertices_where_there_are_none() {
    let mesh = families::grid(2, 2).unwrap();
    let without = decimate(&mesh, 50, &options().resample(false)).unwrap_err();
    assert!(without.to_string().contains("has 9 vertices, and is not resampled"), "{without}");
    let found = decimate(&mesh, 50, &options()).unwrap();
    check("resampled grid", &mesh, 50, &found);
    let length = edge_length_for(1.0, 50).unwrap();
    // 100 equilateral triangles of that side cover the area.
    assert!((100.0 * 3f64.sqrt() / 4.0 * length * length - 1.0).abs() < 1e-12);
    assert!(matches!(edge_length_for(1.0, 0), Err(Error::Argument { what: "n", .. })));
    assert!(matches!(edge_length_for(f64::NAN, 1), Err(Error::Argument { what: "area", .. })));
}

/// A cylinder as CAD programs write it: sides of two long triangles, ends that are fans.
pub fn cad_cylinder(sides: u32) -> TriMesh {
    let mut vertices = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 10.0]];
    for i in 0..sides {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(sides);
        vertices.extend([0.0, 10.0].map(|z| [angle.cos(), angle.sin(), z]));
    }
    let faces = (0..sides).flat_map(|i| {
        let [a, c] = [i, (i + 1) % sides].map(|i| 2 + 2 * i);
        let [b, d] = [a + 1, c + 1];
        [[a, c, b], [c, d, b], [0, c, a], [1, b, d]]
    });
    TriMesh::new(vertices, faces.collect()).unwrap()
}

/// A sphere so flat, and bent, that its sheets are nearer to each other than vertices of the
/// result.
pub fn blade() -> TriMesh {
    bent_sphere(0.06)
}

/// A bent sphere of this thickness.
fn bent_sphere(thickness: f64) -> TriMesh {
    let (mut vertices, faces) = families::icosphere(5).unwrap().into_parts();
    for p in &mut vertices {
        let [x, y, z] = *p;
        *p = [x, 3.0 * y, thickness * z + 0.3 * x * x];
    }
    TriMesh::new(vertices, faces).unwrap()
}

#[test]
fn no_faces_intersect_after_decimation_that_did_not_before() {
    let [ears, fingers] = thin_parts();
    let meshes = [
        ("cylinder of CAD", cad_cylinder(64)),
        ("blade", blade()),
        ("thinner blade", bent_sphere(0.02)),
        ("figure", families::figure(5, 0.5).unwrap()),
        ears,
        fingers,
    ];
    for (name, mesh) in meshes {
        assert!(mesh.intersecting_faces(Par::all()).is_empty(), "{name}");
        for n in [150, 600] {
            let found = decimate(&mesh, n, &options()).unwrap();
            assert!(found.mesh.intersecting_faces(Par::all()).is_empty(), "{name}, {n}");
            check(name, &mesh, n, &found);
        }
    }
}

/// A cube of twelve faces.
fn cube() -> TriMesh {
    let vertices = (0..8).map(|i| [i >> 2, i >> 1 & 1, i & 1].map(f64::from)).collect();
    let sides =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let faces = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    TriMesh::new(vertices, faces.collect()).unwrap()
}

/// A cone of 64 sides.
fn cone() -> TriMesh {
    let (mut vertices, faces) = cad_cylinder(64).into_parts();
    for p in &mut vertices {
        let part = 0.01 + 0.99 * (1.0 - p[2] / 10.0);
        *p = [part * p[0], part * p[1], 0.3 * p[2]];
    }
    TriMesh::new(vertices, faces).unwrap()
}

#[test]
fn creases_corners_and_tips_are_met() {
    for (name, mesh) in [("cube", cube()), ("cylinder", cad_cylinder(64)), ("cone", cone())] {
        // In lengths of edges of the result. How near a sample is to the tip is a matter of luck.
        let numbers = [150, 250, 500];
        let farthest = numbers.map(|n| {
            let found = decimate(&mesh, n, &options()).unwrap();
            check(name, &mesh, n, &found);
            let edge = edge_length_for(mesh.area(), n).unwrap();
            let Comparison { out, back, .. } =
                Comparison::between(&mesh, &found.mesh, Par::all()).unwrap();
            out.largest.max(back.largest) / edge
        });
        let mean = farthest.iter().sum::<f64>() / numbers.len() as f64;
        assert!(mean < 0.27 && farthest.iter().all(|&d| d < 0.4), "{name}: {farthest:?}");
    }
}

#[test]
fn numbers_of_faces_and_lengths_of_edges_are_met() {
    for mesh in [families::icosphere(3).unwrap(), families::torus(30, 20, 1.0, 0.4).unwrap()] {
        for faces in [200, 700] {
            let n = vertices_for_faces(&mesh, faces).unwrap();
            assert_eq!(decimate(&mesh, n, &options()).unwrap().mesh.faces().len(), faces);
        }
        let n = vertices_for_edge_length(mesh.area(), 0.2).unwrap();
        assert!((edge_length_for(mesh.area(), n).unwrap() - 0.2).abs() < 1e-3);
    }
    // With a boundary, about.
    let sheet = families::grid(20, 20).unwrap();
    let n = vertices_for_faces(&sheet, 400).unwrap();
    let faces = decimate(&sheet, n, &options()).unwrap().mesh.faces().len();
    assert!((380..420).contains(&faces), "{faces}");
    assert!(matches!(vertices_for_faces(&sheet, 0), Err(Error::Argument { what: "faces", .. })));
    for length in [0.0, -1.0, f64::NAN, 1e-9] {
        let refused = vertices_for_edge_length(1.0, length);
        assert!(matches!(refused, Err(Error::Argument { what: "length", .. })), "{refused:?}");
    }
}

#[test]
fn large_faces_of_the_input_do_not_harm_the_result() {
    let cylinder = cad_cylinder(64);
    let found = decimate(&cylinder, 500, &options()).unwrap();
    assert!(Quality::of(&found.mesh).mean_quality > 0.85);
    // An edge of the result is about .53 long.
    let difference = Difference::between(&cylinder, &found.mesh, Par::Seq).unwrap();
    assert!(difference.hausdorff < 0.3, "{difference:?}");
    assert!(found.cells.of_vertices().iter().all(|&cell| (cell as usize) < 500));
}

#[test]
fn levels_of_detail_come_from_one_decimator() {
    let mesh = families::figure(6, 0.2).unwrap();
    let mut decimator = Decimator::new(&mesh, &options()).unwrap();
    for n in [50, 500, 100, 200] {
        check("figure", &mesh, n, &decimator.decimate(n).unwrap());
    }
    let literal = options().method(Method::Thesis).relaxation(0);
    let mut decimator = Decimator::new(&mesh, &literal).unwrap();
    let few = decimator.decimate(50).unwrap().mesh;
    let many = decimator.decimate(90).unwrap().mesh;
    assert_eq!(few.vertices(), &many.vertices()[..50]);
    assert_eq!(decimator.decimate(50).unwrap().mesh, few);
}

#[test]
fn the_thesis_literally_takes_vertices_of_the_input_and_all_three_cycles() {
    // Cells of single vertices: the graph of cells is that of the mesh, and its three-cycles are
    // the faces and more.
    let mesh = families::icosphere(0).unwrap();
    let literal = options().method(Method::Thesis);
    let found = decimate(&mesh, 12, &literal).unwrap();
    assert_eq!(found.mesh.faces().len(), 20);
    let back: Vec<u32> = found
        .mesh
        .vertices()
        .iter()
        .map(|p| mesh.vertices().iter().position(|q| p == q).unwrap() as u32)
        .collect();
    let sorted = |mut face: [u32; 3]| {
        face.sort_unstable();
        face
    };
    let mut new: Vec<_> =
        found.mesh.faces().iter().map(|f| sorted(f.map(|v| back[v as usize]))).collect();
    let mut old: Vec<_> = mesh.faces().iter().copied().map(sorted).collect();
    new.sort_unstable();
    old.sort_unstable();
    assert_eq!(new, old);
    assert!(found.mesh.volume().unwrap() > 0.0);
}

#[test]
fn refusals_say_why() {
    let refused = |mesh: &TriMesh, n| decimate(mesh, n, &options()).unwrap_err().to_string();
    let empty = TriMesh::new(vec![], vec![]).unwrap();
    assert_eq!(refused(&empty, 0), "mesh: has no face");
    let lonely = TriMesh::new(vec![[1.0; 3]], vec![]).unwrap();
    assert_eq!(refused(&lonely, 1), "mesh: has no face");
    let spheres = families::spheres(3, 2).unwrap();
    assert!(refused(&spheres, 0).contains("3 components need 12 vertices"));
    assert!(refused(&spheres, 11).contains("3 components need 12 vertices"));
    let given = decimate(&spheres, 10_000, &options().resample(false)).unwrap_err().to_string();
    assert!(given.contains("has 486 vertices, and is not resampled"), "{given}");
    let torus = families::torus(20, 20, 2.0, 1.0).unwrap();
    // A torus needs seven. The number where collapses end depends on that of the samples.
    let why = refused(&torus, 6);
    assert!(why.contains("genus 1) could not be kept: collapses of edges ended at "), "{why}");
    assert!(why.ends_with(" vertices, which is about how many are needed"), "{why}");
    let first = options().first(Some(400));
    assert!(matches!(decimate(&torus, 20, &first), Err(Error::Argument { what: "first", .. })));
    let huge = TriMesh::new(
        vec![[1e308, 0.0, 0.0], [-1e308, 0.0, 0.0], [0.0, 1e308, 0.0]],
        vec![[0, 1, 2]],
    );
    assert!(refused(&huge.unwrap(), 3).contains("out of range"));
}

#[test]
fn what_is_no_manifold_is_cut_and_told() {
    let pages = resample(&families::pages(3).unwrap(), 0.05).unwrap().mesh;
    let found = decimate(&pages, 60, &options()).unwrap();
    check("pages", &pages, 60, &found);
    assert!(found.repairs.cut_edges > 0 && found.before.components == 3, "{}", found.repairs);
    let tie = resample(&families::bow_tie().unwrap(), 0.1).unwrap().mesh;
    let found = decimate(&tie, 60, &options()).unwrap();
    check("bow tie", &tie, 60, &found);
    assert_eq!((found.repairs.split_vertices, found.before.components), (1, 2));

    // Twice the same face, a face the wrong way round, and a vertex of no face.
    let (mut vertices, mut faces) = families::icosphere(3).unwrap().into_parts();
    vertices.push([5.0; 3]);
    faces.push(faces[7]);
    faces[30].swap(0, 1);
    let broken = TriMesh::new(vertices, faces).unwrap();
    let found = decimate(&broken, 100, &options()).unwrap();
    check("broken sphere", &broken, 100, &found);
    let repairs = found.repairs;
    assert_eq!((repairs.repeated_faces, repairs.unreferenced_vertices), (1, 1));
    assert!(repairs.oriented && repairs.to_string().contains("1 repeated faces"), "{repairs}");
}

#[test]
fn scale_and_coinciding_vertices_do_no_harm() {
    for (scale, is_possible) in [(1e-200, false), (1e-30, true), (1e30, true), (1e150, false)] {
        let (vertices, faces) = families::icosphere(3).unwrap().into_parts();
        let vertices = vertices.into_iter().map(|p| p.map(|x| x * scale)).collect();
        let mesh = TriMesh::new(vertices, faces).unwrap();
        match (decimate(&mesh, 60, &options()), is_possible) {
            (Ok(found), true) => check("scaled sphere", &mesh, 60, &found),
            (Err(refused), false) => {
                assert!(refused.to_string().contains("out of range"), "{refused}");
            }
            (found, _) => panic!("{scale:e}: {:?}", found.map(drop)),
        }
    }
    // All in one point: faces without area, edges without length.
    let (vertices, faces) = families::icosphere(2).unwrap().into_parts();
    let point = TriMesh::new(vec![[1.0; 3]; vertices.len()], faces).unwrap();
    let found = decimate(&point, 20, &options()).unwrap();
    assert_eq!(found.mesh.vertices().len(), 20);
    found.mesh.require_manifold().unwrap();
}

#[test]
fn progress_rises_to_one_and_can_cancel() {
    let mesh = families::icosphere(4).unwrap();
    let last = AtomicUsize::new(0);
    let calls = AtomicUsize::new(0);
    let watch = |fraction: f64| {
        let now = (fraction * 1e6) as usize;
        assert!(now >= last.swap(now, Ordering::Relaxed), "{fraction}");
        calls.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    decimate(&mesh, 300, &options().progress(&watch)).unwrap();
    assert_eq!(last.load(Ordering::Relaxed), 1_000_000);
    for stop in 0..calls.load(Ordering::Relaxed) {
        let left = AtomicUsize::new(stop);
        let cancel = |_: f64| match left
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1))
        {
            Ok(_) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        };
        let options = options().progress(&cancel);
        assert_eq!(decimate(&mesh, 300, &options).unwrap_err(), Error::Cancelled);
    }
    let mut points = FarthestPoints::new(&mesh, None).unwrap();
    let cancel = |_: f64| ControlFlow::Break(());
    assert_eq!(points.extend_to(9, (&cancel).into()), Err(Error::Cancelled));
    points.extend_to(9, Progress::none()).unwrap();
    assert_eq!(points.samples().len(), 9);
}

#[test]
fn quality_of_equal_triangles_is_one_and_their_variation_zero() {
    let quality = Quality::of(&families::icosphere(0).unwrap());
    assert!((quality.mean_quality - 1.0).abs() < 1e-12 && quality.area_variation < 1e-12);
    assert_eq!((quality.mean_valence, quality.regular_vertices), (5.0, 0.0));
    let nothing = Quality::of(&TriMesh::new(vec![], vec![]).unwrap());
    assert_eq!((nothing.mean_area, nothing.mean_quality, nothing.mean_valence), (0.0, 0.0, 0.0));
    assert_eq!(Quality::of(&families::pages(4).unwrap()).non_manifold_edges, 1);
}

#[test]
fn differences_have_exact_values() {
    let square = families::grid(1, 1).unwrap();
    let (vertices, faces) = families::grid(2, 2).unwrap().into_parts();
    let raised: Vec<_> = vertices.iter().map(|p| [p[0], p[1], 0.25]).collect();
    let raised = TriMesh::new(raised, faces).unwrap();
    let found = Difference::between(&square, &raised, Par::Seq).unwrap();
    assert!((found.hausdorff - 0.25).abs() < 1e-15);
    assert!((found.chamfer - 2.0 * 0.0625).abs() < 1e-15);
    assert!((found.printed_hausdorff - 0.25).abs() < 1e-15);
    // Four corners at 1/16, four middles of sides at 1/4 more, the centre at 1/2 more.
    assert!((found.printed_chamfer - (9.0 / 16.0 + 1.0 + 0.5) / 9.0).abs() < 1e-15);
    let empty = TriMesh::new(vec![], vec![]).unwrap();
    let refused = Difference::between(&square, &empty, Par::Seq).unwrap_err();
    assert_eq!(refused.to_string(), "mesh: has no face");
    let found = Difference::between(&square, &square, Par::Threads(2)).unwrap();
    assert_eq!((found.hausdorff, found.printed_chamfer), (0.0, 0.0));
}

/// Triangles of this side at the corners of an equilateral one of side 1.
fn corners_of_a_triangle(side: f64) -> [TriMesh; 2] {
    let high = 3f64.sqrt() / 2.0;
    let whole = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, high, 0.0]];
    let parts = (0..3).flat_map(|k| {
        let towards = |p: [f64; 3]| {
            let at = |i: usize| whole[k][i] + side * (p[i] - whole[k][i]);
            std::array::from_fn(at)
        };
        whole.map(towards)
    });
    let faces = vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]];
    [
        TriMesh::new(whole.to_vec(), vec![[0, 1, 2]]).unwrap(),
        TriMesh::new(parts.collect(), faces).unwrap(),
    ]
}

#[test]
fn the_bound_of_the_distance_is_of_all_points_not_of_vertices_alone() {
    for side in [0.1, 0.01, 0.3] {
        let [whole, parts] = corners_of_a_triangle(side);
        // The middle is farthest from the corners that are left.
        let exact = 1.0 / 3f64.sqrt() - side * 3f64.sqrt() / 2.0;
        for [a, b] in [[&whole, &parts], [&parts, &whole]] {
            let found = Difference::between(a, b, Par::Seq).unwrap();
            assert!(found.hausdorff < 1e-15, "{found:?}");
            let bound = found.hausdorff_bound;
            assert!(bound >= exact * (1.0 - 1e-12) && bound <= 1.01 * exact, "{bound}, {exact}");
        }
    }
}

#[test]
fn the_bound_of_the_distance_is_as_tight_for_a_small_mesh_far_from_the_origin() {
    const FAR: f64 = 4.5e6;
    let (vertices, faces) = families::torus(40, 20, 2e-3, 8e-4).unwrap().into_parts();
    let moved = |mesh: &TriMesh, by: f64| {
        let vertices = mesh.vertices().iter().map(|p| p.map(|x| x + by)).collect();
        TriMesh::new(vertices, mesh.faces().to_vec()).unwrap()
    };
    let far = moved(&TriMesh::new(vertices, faces).unwrap(), FAR);
    let small = decimate(&far, 300, &options()).unwrap().mesh;
    // The same positions: this subtraction rounds nothing.
    let [near, small_near] = [&far, &small].map(|mesh| moved(mesh, -FAR));
    let [expected, found] = [(&near, &small_near), (&far, &small)]
        .map(|(a, b)| Difference::between(a, b, Par::Seq).unwrap().hausdorff_bound);
    assert!((found / expected - 1.0).abs() < 0.02, "{found:e}, {expected:e}");
    let vertices = [near, far].map(|mesh| {
        let found = decimate_within(&mesh, 1e-4, &options()).unwrap();
        found.mesh.vertices().len()
    });
    assert!(3 * vertices[1] < 4 * vertices[0], "{vertices:?}");
}

#[test]
fn the_bound_of_the_distance_is_tight_for_surfaces_of_different_faces() {
    // Two triangulations of one plane, and of a parallel one.
    let coarse = families::grid(3, 2).unwrap();
    let (vertices, faces) = families::grid(17, 23).unwrap().into_parts();
    for height in [0.0, 0.125] {
        let raised = vertices.iter().map(|p| [p[0], p[1], height]).collect();
        let fine = TriMesh::new(raised, faces.clone()).unwrap();
        let bound = Difference::between(&coarse, &fine, Par::Seq).unwrap().hausdorff_bound;
        assert!(bound >= height && bound <= 1.01 * height + 1e-9, "{bound}, {height}");
    }
    // Spheres: a face of the coarse one is as deep as its middle, far from all its vertices.
    let [ball, finest] = [2, 6].map(|level| families::icosphere(level).unwrap());
    let norm = |p: [f64; 3]| distance(p, [0.0; 3]);
    let depths = ball.faces().iter().map(|face| {
        let corners = face.map(|v| ball.vertices()[v as usize]);
        1.0 - norm(std::array::from_fn(|k| corners.iter().map(|p| p[k] / 3.0).sum()))
    });
    let deepest = depths.fold(0.0, f64::max);
    for par in [Par::Seq, Par::Threads(3)] {
        let bound = Difference::between(&ball, &finest, par).unwrap().hausdorff_bound;
        // The middle of a face is nearly its deepest point; the finest ball is .0002 inside.
        assert!(bound >= deepest - 3e-4 && bound <= 1.02 * deepest, "{bound}, {deepest}");
        assert_eq!(bound, Difference::between(&ball, &finest, Par::Seq).unwrap().hausdorff_bound);
    }
}

#[test]
fn the_bound_of_the_distance_is_between_that_of_samples_and_that_with_their_spacing() {
    let [(_, needles), (_, blade)] = thin_parts();
    let meshes =
        [("needles", needles), ("blade", blade), ("cylinder", cad_cylinder(64)), ("cube", cube())];
    for (name, mesh) in meshes {
        let spacing = 0.01 * mesh.area().sqrt();
        for n in [40, 150] {
            let made = decimate(&mesh, n, &options()).unwrap().mesh;
            let bound = Difference::between(&mesh, &made, Par::Seq).unwrap().hausdorff_bound;
            let sampled = [(&mesh, &made), (&made, &mesh)].map(|(of, from)| {
                let samples = resample(of, spacing).unwrap().mesh;
                Comparison::between(&samples, from, Par::Seq).unwrap().out.largest
            });
            let sampled = sampled[0].max(sampled[1]);
            assert!(sampled <= bound * (1.0 + 1e-12), "{name} to {n}: {sampled}, {bound}");
            // No point is farther from a corner of its face than the edges by the root of 3.
            let most = 1.01 * (sampled + spacing / 3f64.sqrt());
            assert!(bound <= most, "{name} to {n}: {bound}, {most}");
        }
    }
}

/// Checks that the first vertices of a result are these of the input, to the last bit, and that
/// edges between them are there.
fn check_locks(name: &str, mesh: &TriMesh, locked: &[u32], found: &Decimation) {
    let bits = |p: [f64; 3]| p.map(f64::to_bits);
    for (at, &v) in locked.iter().enumerate() {
        let [was, is] = [mesh.vertices()[v as usize], found.mesh.vertices()[at]];
        assert_eq!(bits(was), bits(is), "{name}: vertex {v}");
    }
    let pairs = |mesh: &TriMesh| Edges::new(mesh).ends().to_vec();
    let there = pairs(&found.mesh);
    let at = |v: u32| locked.iter().position(|&w| w == v).map(|at| at as u32);
    let mut count = 0;
    for [a, b] in pairs(mesh) {
        if let (Some(a), Some(b)) = (at(a), at(b)) {
            count += 1;
            let is_there = there.contains(&[a.min(b), a.max(b)]);
            assert!(is_there || found.lost_edges > 0, "{name}: edge {a} {b}");
        }
    }
    assert_eq!(found.locked_edges, count, "{name}");
}

#[test]
fn locked_vertices_and_the_edges_between_them_stay_on_every_family() {
    let cases = [
        ("icosphere", families::icosphere(4), vec![60, 500, 2562]),
        ("spheres", families::spheres(3, 3), vec![80, 200]),
        ("torus", families::torus(61, 29, 2.0, 0.7), vec![90, 300]),
        ("genus 3", families::genus(3, 6), vec![200, 500]),
        ("figure", families::figure(5, 0.5), vec![200, 400]),
        ("grid", families::grid(40, 30), vec![97, 500]),
        ("terrain", families::terrain(60, 50, 3), vec![101, 600]),
        ("disk", families::disk(20, 60), vec![100, 400]),
        ("cylinder", families::cylinder(60, 20, 1.0, 1.0), vec![100, 500]),
        ("Moebius", families::moebius(100, 12), vec![100, 500]),
    ];
    let mut rng = catamaran::base::Rng::new(8);
    for (name, mesh, sizes) in cases {
        let mesh = mesh.unwrap();
        let vertices = mesh.vertices().len();
        // A path over edges, which may run along the boundary or beside it, and vertices anywhere.
        let edges = Edges::new(&mesh);
        let mut path = vec![0u32];
        while path.len() < 20 {
            let end = path[path.len() - 1];
            let ends = edges.ends().iter().filter(|ends| ends.contains(&end));
            let mut others = ends.map(|&[a, b]| if a == end { b } else { a });
            let Some(next) = others.rfind(|v| !path.contains(v)) else { break };
            path.push(next);
        }
        while path.len() < 35 {
            let v = (rng.uniform() * vertices as f64) as u32;
            if !path.contains(&v) {
                path.push(v);
            }
        }
        for n in sizes {
            for options in [
                options().locked(&path).uniform(true),
                options().locked(&path).lloyd(1).relaxation(0),
            ] {
                let name = format!("{name} to {n}");
                let found = decimate(&mesh, n, &options).unwrap_or_else(|e| panic!("{name}: {e}"));
                check(&name, &mesh, n, &found);
                check_locks(&name, &mesh, &path, &found);
                // Triangles that are smaller than those of the result have no long edges.
                assert!(found.lost_edges == 0 || 6 * n > vertices, "{name}");
            }
        }
    }
}

#[test]
fn locks_that_are_none_change_nothing_and_impossible_ones_are_refused() {
    let mesh = families::torus(61, 29, 2.0, 0.7).unwrap();
    let without = decimate(&mesh, 100, &options()).unwrap();
    assert_eq!((without.locked_edges, without.lost_edges), (0, 0));
    assert_eq!(without, decimate(&mesh, 100, &options().locked(&[])).unwrap());
    let many: Vec<u32> = (0..100).collect();
    let stray = {
        let (mut vertices, faces) = mesh.clone().into_parts();
        vertices.push([0.0; 3]);
        TriMesh::new(vertices, faces).unwrap()
    };
    let last = mesh.vertices().len() as u32;
    for (locked, n, why) in [
        (&many[..], 99, "n: 99, but 100 vertices are locked"),
        (&[3, 5, 3], 50, "locked: has vertex 3 twice"),
        (&[7, last], 50, "locked: must be a vertex with a face, is 1769 of 1770"),
        (&[u32::MAX], 50, "locked: must be a vertex with a face, is 4294967295 of 1770"),
    ] {
        let refused = decimate(&stray, n, &options().locked(locked)).unwrap_err().to_string();
        assert_eq!(refused, why);
    }
    let literal = options().locked(&[1]).method(Method::Thesis);
    let refused = decimate(&mesh, 50, &literal).unwrap_err().to_string();
    assert!(refused.starts_with("locked: "), "{refused}");
    // All vertices of the result may be locked.
    let ring: Vec<u32> = without
        .places
        .iter()
        .map(|p| mesh.faces()[p.face as usize][0])
        .collect::<std::collections::BTreeSet<_>>()
        .into_iter()
        .collect();
    let found = decimate(&mesh, ring.len(), &options().locked(&ring)).unwrap();
    check("all", &mesh, ring.len(), &found);
    check_locks("all", &mesh, &ring, &found);
}

#[test]
fn locks_survive_repairs_another_order_and_longer_edges() {
    // A mesh whose neighbours are far from each other in memory, and which has a fan too many.
    let (mut vertices, faces) = families::icosphere(5).unwrap().into_parts();
    let half = vertices.len().div_ceil(2) as u32;
    let number = |v: u32| v / 2 + half * (v % 2);
    let old = vertices.clone();
    old.iter().zip(0..).for_each(|(&p, v)| vertices[number(v) as usize] = p);
    let faces: Vec<_> = faces.iter().map(|face| face.map(number)).collect();
    let scattered = TriMesh::new(vertices.clone(), faces.clone()).unwrap();
    let locked = [5, 4000, 17, 3, 9000];
    let found = decimate(&scattered, 500, &options().locked(&locked)).unwrap();
    check_locks("scattered", &scattered, &locked, &found);
    let twice: Vec<_> = faces.iter().chain([&faces[7]]).copied().collect();
    let repeated = TriMesh::new(vertices, twice).unwrap();
    let found = decimate(&repeated, 500, &options().locked(&locked)).unwrap();
    assert_eq!(found.repairs.repeated_faces, 1);
    check_locks("repeated", &repeated, &locked, &found);
    // Edges that are longer than those of the result are split, and counted; vertices stay.
    let solid = families::icosphere(0).unwrap();
    let all: Vec<u32> = (0..12).rev().collect();
    let found = decimate(&solid, 400, &options().locked(&all)).unwrap();
    check("solid", &solid, 400, &found);
    check_locks("solid", &solid, &all, &found);
    assert_eq!((found.locked_edges, found.lost_edges), (30, 30));
    let whole = options().locked(&all).resample(false);
    let found = decimate(&solid, 12, &whole).unwrap();
    assert_eq!((found.locked_edges, found.lost_edges), (30, 0));
    check_locks("whole", &solid, &all, &found);
}

#[test]
fn all_parts_of_a_locked_vertex_that_is_split_stay_behind_the_named_ones() {
    let pages = families::pages(3).unwrap();
    let mesh = resample(&pages, 0.05).unwrap().mesh;
    let found = decimate(&mesh, 90, &options().locked(&[1, 0])).unwrap();
    check("pages", &mesh, 90, &found);
    // The ends of the common edge, one of each of the three pages.
    assert_eq!(found.locked, 6);
    let mut ends = found.mesh.vertices()[..6].to_vec();
    assert_eq!(ends[..2], [1, 0].map(|v| mesh.vertices()[v]));
    ends.sort_by(|p, q| p.partial_cmp(q).unwrap());
    assert!(ends[0] == ends[2] && ends[3] == ends[5] && ends[2] != ends[3], "{ends:?}");
    // So they stay in the next level, too.
    let all: Vec<u32> = (0..6).collect();
    let next = decimate(&found.mesh, 30, &options().locked(&all)).unwrap();
    assert_eq!(next.mesh.vertices()[..6], found.mesh.vertices()[..6]);
    let refused = decimate(&mesh, 5, &options().locked(&[1, 0])).unwrap_err().to_string();
    assert_eq!(refused, "n: 5, but 6 vertices are locked, with all parts of split ones");
}

#[test]
fn vertices_without_a_face_have_no_distance() {
    let square = families::grid(1, 1).unwrap();
    let mut vertices = square.vertices().to_vec();
    vertices.push([0.0, 0.0, 7.0]);
    let stray = TriMesh::new(vertices, square.faces().to_vec()).unwrap();
    for [a, b] in [[&square, &stray], [&stray, &square]] {
        let found = Difference::between(a, b, Par::Seq).unwrap();
        assert_eq!([found.hausdorff, found.chamfer, found.printed_hausdorff], [0.0; 3]);
    }
}

#[test]
fn as_few_vertices_as_an_error_allows_are_found_and_less_would_not_do() {
    let cases = [
        ("icosphere", families::icosphere(4), 0.02),
        ("torus", families::torus(61, 29, 2.0, 0.7), 0.05),
        ("terrain", families::terrain(60, 50, 3), 0.01),
        ("genus 3", families::genus(3, 6), 0.08),
        ("spheres", families::spheres(3, 3), 0.1),
        ("Moebius", families::moebius(100, 12), 0.02),
    ];
    for (name, mesh, error) in cases {
        let mesh = mesh.unwrap();
        let found = decimate_within(&mesh, error, &options()).unwrap();
        let n = found.mesh.vertices().len();
        check(name, &mesh, n, &found);
        let bound = Difference::between(&mesh, &found.mesh, Par::Seq).unwrap().hausdorff_bound;
        assert!(bound <= error, "{name}: {bound} with {n}");
        assert_eq!(found, decimate(&mesh, n, &options()).unwrap(), "{name}");
        // An oracle that knows vertices alone.
        let compared = Comparison::between(&mesh, &found.mesh, Par::Seq).unwrap();
        assert!(compared.out.largest.max(compared.back.largest) <= bound, "{name}: {compared:?}");
        // Clearly fewer vertices are not enough.
        let fewer = decimate(&mesh, 4 * n / 5, &options());
        let enough = fewer.is_ok_and(|fewer| {
            Difference::between(&mesh, &fewer.mesh, Par::Seq).unwrap().hausdorff_bound <= error
        });
        assert!(!enough, "{name}: {n} are more than needed");
    }
}

#[test]
fn an_error_that_cannot_be_reached_is_refused_with_what_was_reached() {
    let mesh = families::icosphere(2).unwrap();
    let small = options().relaxation(2);
    let refused = decimate_within(&mesh, 1e-9, &small.resample(false)).unwrap_err().to_string();
    assert!(refused.starts_with("error: 1e-9 can't be reached: with "), "{refused}");
    for error in [0.0, -1.0, f64::NAN] {
        let refused = decimate_within(&mesh, error, &small).unwrap_err().to_string();
        assert!(refused.starts_with("error: "), "{refused}");
    }
    // Fewer vertices than the search begins with, and edges that are not split.
    for whole in [small.resample(false), small.method(Method::Thesis)] {
        let found = decimate_within(&mesh, 0.2, &whole).unwrap().mesh;
        assert!(found.vertices().len() < mesh.vertices().len());
        let bound = Difference::between(&mesh, &found, Par::Seq).unwrap().hausdorff_bound;
        assert!(bound <= 0.2, "{bound}");
    }
    let empty = TriMesh::new(vec![], vec![]).unwrap();
    let refused = decimate_within(&empty, f64::NAN, &small).unwrap_err().to_string();
    assert_eq!(refused, "mesh: has no face");
    // A large face needs more vertices than the input has.
    let solid = families::icosphere(0).unwrap();
    let found = decimate_within(&solid, 0.1, &options()).unwrap();
    assert!(found.mesh.vertices().len() > solid.vertices().len());
}

#[test]
fn vertices_without_a_face_are_no_part_of_a_comparison() {
    let square = families::grid(1, 1).unwrap();
    let mut vertices = square.vertices().to_vec();
    vertices.push([0.0, 0.0, 7.0]);
    let stray = TriMesh::new(vertices, square.faces().to_vec()).unwrap();
    for [a, b] in [[&square, &stray], [&stray, &square]] {
        let found = Comparison::between(a, b, Par::Seq).unwrap();
        assert!(found.out.largest.max(found.back.largest) < 1e-15, "{found:?}");
    }
}

#[test]
fn meshes_beyond_the_range_of_areas_are_not_compared() {
    let square = families::grid(1, 1).unwrap();
    let far = square.vertices().iter().map(|p| p.map(|x| 1e80 * x)).collect();
    let far = TriMesh::new(far, square.faces().to_vec()).unwrap();
    for [a, b] in [[&square, &far], [&far, &square]] {
        let refused = [
            Difference::between(a, b, Par::Seq).unwrap_err(),
            Comparison::between(a, b, Par::Seq).unwrap_err(),
        ];
        for error in refused {
            assert!(error.to_string().contains("is out of range"), "{error}");
        }
    }
}

#[test]
fn colours_and_texture_coordinates_are_carried() {
    let mesh = families::terrain(40, 40, 2).unwrap();
    let mut file = MeshFile::from(mesh.clone());
    file.colors = Some(mesh.vertices().iter().map(|p| [p[0], p[1], p[2] + 0.5, 1.0]).collect());
    let plane = |p: &[f64; 3]| [2.0 * p[0], p[1] - 1.0];
    file.uv =
        Some(Attribute { values: mesh.vertices().iter().map(plane).collect(), corners: None });
    let found = decimate(&mesh, 200, &options()).unwrap();
    let carried = found.carry(&file).unwrap();
    let (colors, uv) = (carried.colors.unwrap(), carried.uv.unwrap());
    for (v, place) in found.places.iter().enumerate() {
        // Where the vertex is on the input; itself it is beside that.
        let p = &place.position(&mesh);
        for (is, should_be) in colors[v].iter().zip([p[0], p[1], p[2] + 0.5, 1.0]) {
            assert!((is - should_be).abs() < 1e-9);
        }
        for (is, should_be) in uv.values[v].iter().zip(plane(p)) {
            assert!((is - should_be).abs() < 1e-9);
        }
    }

    // The square in two charts, cut where x is 1/2: the right half is moved by 10.
    let chart = |f: usize| {
        let x: f64 = mesh.faces()[f].iter().map(|&v| mesh.vertices()[v as usize][0]).sum();
        x > 1.5
    };
    let n = mesh.vertices().len() as u32;
    let mut values: Vec<_> = mesh.vertices().iter().map(plane).collect();
    values.extend(mesh.vertices().iter().map(plane).map(|[u, v]| [u + 10.0, v]));
    let corners = (0..mesh.faces().len())
        .map(|f| mesh.faces()[f].map(|v| if chart(f) { v + n } else { v }))
        .collect();
    file.uv = Some(Attribute { values, corners: Some(corners) });
    let uv = found.carry(&file).unwrap().uv.unwrap();
    for (f, face) in found.mesh.faces().iter().enumerate() {
        let corners = uv.of_face(&found.mesh, f).unwrap();
        let right = corners[0][0] > 5.0;
        for k in 0..3 {
            let [u, _] = plane(&found.mesh.vertices()[face[k] as usize]);
            let expected = if right { u + 10.0 } else { u };
            // The terrain is not flat: beyond a cut, the plane of one of its faces is followed.
            assert!((corners[k][0] - expected).abs() < 0.3, "{corners:?} {expected}");
        }
    }
    let other = MeshFile::from(families::grid(3, 3).unwrap());
    assert!(matches!(found.carry(&other), Err(Error::Shape { what: "input", .. })));
    let refused = found.weights(&other.mesh, Par::Seq);
    assert!(matches!(refused, Err(Error::Shape { what: "input", .. })), "{refused:?}");
}

/// Meshes of ../shared that have no mesh of so many vertices, and why.
const REFUSED: [(&str, usize, &str); 6] = [
    ("cheese_genus133.off.gz", 100, "genus 133) could not be kept: collapses"),
    ("counter42k.stl.gz", 100, "genus 25) could not be kept: collapses"),
    ("cycloidal_nonmanifold.ply.gz", 100, "119 components need 464 vertices"),
    ("office_chair_degenerate.obj.gz", 100, "93 components need 291 vertices"),
    ("suzanne_499components.ply.gz", 100, "499 components need 1497 vertices"),
    ("suzanne_499components.ply.gz", 1000, "499 components need 1497 vertices"),
];

/// All meshes of ../shared that are quick to read: exact, or refused for the reason that is known.
#[test]
fn shared_meshes_are_decimated_or_refused_for_known_reasons() {
    let Some(folder) = crate::common::data("meshes") else { return };
    let mut entries: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap()).collect();
    entries.sort_by_key(|entry| entry.file_name());
    for entry in entries {
        let name = entry.file_name().into_string().unwrap();
        if name.ends_with(".tsv") || entry.metadata().unwrap().len() > 2_000_000 {
            continue;
        }
        let mesh = io::read(&entry.path()).unwrap_or_else(|refused| panic!("{refused}")).mesh;
        for n in [100, 1000] {
            let known = REFUSED.iter().find(|(file, count, _)| (*file, *count) == (&name, n));
            match (decimate(&mesh, n, &options()), known) {
                (Ok(found), None) => {
                    assert_eq!(found.mesh.vertices().len(), n, "{name}");
                    found.mesh.require_manifold().unwrap_or_else(|e| panic!("{name}: {e}"));
                    assert_eq!(Some(found.before), found.after, "{name}");
                }
                (Err(refused), Some((_, _, why))) => {
                    assert!(refused.to_string().contains(why), "{name} to {n}: {refused}");
                }
                (Err(refused), None) => panic!("{name} to {n}: {refused}"),
                (Ok(_), Some(_)) => panic!("{name} to {n} was not refused"),
            }
        }
    }
}
