use super::*;
use crate::mesh::vector::{distance, dot};
use crate::mesh::{LaplacianKind, Site, TriMesh, families, shapes};
use catamaran::base::{Error, Par, Rng};

/// Returns the distances from several sources by the Bellman-Ford algorithm.
fn oracle(n: usize, edges: &[(u32, u32, f64)], sources: &[(u32, f64)]) -> Vec<f64> {
    let mut distances = vec![f64::INFINITY; n];
    for &(v, d) in sources {
        distances[v as usize] = d.min(distances[v as usize]);
    }
    for _ in 0..n {
        for &(a, b, length) in edges {
            let (x, y) = (distances[a as usize], distances[b as usize]);
            distances[a as usize] = x.min(y + length);
            distances[b as usize] = y.min(x + length);
        }
    }
    distances
}

fn random_graph(n: u32, m: usize, seed: u64) -> Vec<(u32, u32, f64)> {
    let mut rng = Rng::new(seed);
    let mut vertex = || (rng.bits() % u64::from(n)) as u32;
    let ends: Vec<_> = (0..m).map(|_| (vertex(), vertex())).collect();
    // The lengths have few digits, so that sums are exact and paths tie.
    ends.into_iter().map(|(a, b)| (a, b, (rng.bits() % 16) as f64 / 8.0)).collect()
}

fn close(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() < 1e-12
}

#[test]
fn the_distance_on_a_grid_graph_is_the_sum_of_steps() {
    let (x, y) = (7, 5);
    let mut edges = Vec::new();
    for j in 0..y {
        for i in 0..x {
            if i + 1 < x {
                edges.push((j * x + i, j * x + i + 1, 1.0));
            }
            if j + 1 < y {
                edges.push((j * x + i, (j + 1) * x + i, 2.0));
            }
        }
    }
    let graph = Graph::new((x * y) as usize, &edges).unwrap();
    let mut search = Dijkstra::new(&graph);
    search.search(&[(0, 0.0)], &SearchLimits::default()).unwrap();
    for v in 0..x * y {
        assert_eq!(search.distance(v), f64::from(v % x + 2 * (v / x)));
    }
    assert_eq!(search.reached().len(), 35);
    assert_eq!(search.path(34).len(), 11);
}

#[test]
fn distances_paths_and_origins_agree_with_bellman_and_ford() {
    for seed in 0..30 {
        let n = [1, 2, 13, 40][seed as usize % 4];
        let edges = random_graph(n, (seed as usize % 5) * n as usize / 2, seed);
        let graph = Graph::new(n as usize, &edges).unwrap();
        let mut search = Dijkstra::new(&graph);
        let sources = [(0, 0.5), (n / 2, 0.0), (n - 1, 0.25), (0, 0.75)];
        let expected = oracle(n as usize, &edges, &sources);
        search.search(&sources, &SearchLimits::default()).unwrap();
        assert_eq!(search.distances(), expected);
        for v in 0..n {
            let path = search.path(v);
            assert_eq!(path.last().copied(), expected[v as usize].is_finite().then_some(v));
            assert_eq!(path.first().copied(), search.origin(v));
            for pair in path.windows(2) {
                let step = search.distance(pair[1]) - search.distance(pair[0]);
                assert!(graph.neighbours(pair[0]).any(|(w, l)| w == pair[1] && l == step));
            }
        }
        let order: Vec<f64> = search.reached().iter().map(|&v| search.distance(v)).collect();
        assert!(order.is_sorted());
    }
}

#[test]
fn one_solver_serves_many_limited_searches() {
    let edges = random_graph(60, 100, 7);
    let graph = Graph::new(60, &edges).unwrap();
    let mut search = Dijkstra::new(&graph);
    for source in 0..60 {
        let expected = oracle(60, &edges, &[(source, 0.0)]);
        let cutoff = f64::from(source % 7) / 2.0;
        search.search(&[(source, 0.0)], &SearchLimits { cutoff, targets: &[] }).unwrap();
        for v in 0..60 {
            let d = expected[v as usize];
            assert_eq!(search.distance(v), if d <= cutoff { d } else { f64::INFINITY });
            assert_eq!(search.origin(v).is_some(), d <= cutoff);
        }
        let targets = [(source + 5) % 60, (source + 30) % 60, (source + 5) % 60];
        let limits = SearchLimits { targets: &targets, ..Default::default() };
        search.search(&[(source, 0.0)], &limits).unwrap();
        for v in targets {
            assert_eq!(search.distance(v), expected[v as usize]);
        }
        for v in 0..60 {
            let reached = search.reached().contains(&v);
            let expected = if reached { expected[v as usize] } else { f64::INFINITY };
            assert_eq!(search.distance(v), expected, "what is not final is not told");
        }
    }
}

#[test]
fn inserted_sources_change_only_what_they_are_nearer_to() {
    let edges = random_graph(50, 90, 8);
    let graph = Graph::new(50, &edges).unwrap();
    let mut search = Dijkstra::new(&graph);
    let mut sources = Vec::new();
    let mut before = vec![f64::INFINITY; 50];
    for source in [3, 17, 40, 3, 22] {
        sources.push((source, 0.0));
        search.insert(&[(source, 0.0)]).unwrap();
        let now = oracle(50, &edges, &sources);
        assert_eq!(search.distances(), now);
        let changed = (0..50).filter(|&v| now[v as usize] < before[v as usize]);
        let mut reached = search.reached().to_vec();
        reached.sort_unstable();
        assert_eq!(reached, changed.collect::<Vec<u32>>());
        before = now;
    }
    search.search(&[(1, 0.0)], &SearchLimits::default()).unwrap();
    assert_eq!(search.distances(), oracle(50, &edges, &[(1, 0.0)]), "all is forgotten");
}

#[test]
fn a_path_whose_length_overflows_reaches_nothing() {
    let graph = Graph::new(3, &[(0, 1, f64::MAX), (1, 2, f64::MAX)]).unwrap();
    let mut search = Dijkstra::new(&graph);
    search.search(&[(0, 0.0)], &SearchLimits::default()).unwrap();
    assert_eq!(search.distances(), [0.0, f64::MAX, f64::INFINITY]);
    assert_eq!((search.origin(2), search.path(2), search.reached()), (None, vec![], &[0, 1][..]));
}

#[test]
fn a_mesh_is_the_graph_of_its_edges() {
    let mesh = families::pages(3).unwrap();
    let graph = Graph::of_mesh(&mesh);
    assert_eq!(graph.len(), 5);
    let near: Vec<_> = graph.neighbours(2).collect();
    assert_eq!(near.iter().map(|e| e.0).collect::<Vec<_>>(), [0, 1]);
    assert!(near.iter().all(|e| close(e.1, 1.25_f64.sqrt())));
    assert_eq!(graph.neighbours(0).count(), 4, "the edge of three faces is one edge");
}

#[test]
fn wrong_arguments_of_graphs_and_searches_are_named() {
    for (edge, part) in [((0, 3, 1.0), "edge 0, from 0 to 3"), ((0, 1, -1.0), "length -1")] {
        let error = Graph::new(3, &[edge]).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    let graph = Graph::new(3, &[(0, 1, 1.0)]).unwrap();
    let mut search = Dijkstra::new(&graph);
    let all = SearchLimits::default();
    let refused = [
        (search.search(&[(3, 0.0)], &all), "sources"),
        (search.search(&[(0, f64::NAN)], &all), "sources"),
        (search.search(&[(0, 0.0)], &SearchLimits { targets: &[9], ..all }), "targets"),
        (search.search(&[(0, 0.0)], &SearchLimits { cutoff: -1.0, ..all }), "cutoff"),
        (search.insert(&[(3, 0.0)]), "sources"),
    ];
    for (found, name) in refused {
        assert!(matches!(found, Err(Error::Argument { what, .. }) if what == name), "{name}");
    }
    search.search(&[(0, -0.0)], &all).unwrap();
    assert_eq!(search.distances(), [0.0, 1.0, f64::INFINITY]);
    let empty = Graph::new(0, &[]).unwrap();
    assert!(empty.is_empty());
    Dijkstra::new(&empty).search(&[], &all).unwrap();
}

fn heat(mesh: &TriMesh, kind: LaplacianKind) -> HeatMethod {
    HeatMethod::new(mesh, &HeatOptions { kind, par: Par::Seq, ..Default::default() }).unwrap()
}

/// Returns the mean and the largest difference, relative to the largest distance.
fn errors(found: &[f64], exact: impl Fn(usize) -> f64) -> (f64, f64) {
    let largest = (0..found.len()).map(&exact).fold(0.0, f64::max);
    let all = || found.iter().enumerate().map(|(v, d)| (d - exact(v)).abs() / largest);
    (all().sum::<f64>() / found.len() as f64, all().fold(0.0, f64::max))
}

const KINDS: [LaplacianKind; 3] =
    [LaplacianKind::Cotangent, LaplacianKind::IntrinsicDelaunay, LaplacianKind::Tufted];

#[test]
fn heat_distances_on_a_plane_are_euclidean() {
    let mesh = shapes::shaken(&shapes::grid(30, 30), 0.0, 1);
    let centre = 15 * 31 + 15;
    for kind in KINDS {
        let found = heat(&mesh, kind).distances(&[centre]).unwrap();
        let p = mesh.vertices();
        let (mean, largest) = errors(&found, |v| distance(p[v], p[centre as usize]));
        assert!(mean < 0.015 && largest < 0.06, "{kind:?}: {mean} {largest}");
        assert_eq!(found[centre as usize], 0.0);
    }
}

#[test]
fn heat_distances_on_a_sphere_are_arcs() {
    let mesh = shapes::sphere(4);
    let p = mesh.vertices();
    for kind in KINDS {
        let solver = heat(&mesh, kind);
        for source in [0, 77] {
            let found = solver.distances(&[source]).unwrap();
            let arc = |v: usize| dot(p[v], p[source as usize]).clamp(-1.0, 1.0).acos();
            let (mean, largest) = errors(&found, arc);
            assert!(mean < 0.01 && largest < 0.04, "{kind:?}: {mean} {largest}");
        }
        let found = solver.distances(&[0, 1]).unwrap();
        let arc = |v: usize| {
            let nearer = dot(p[v], p[0]).max(dot(p[v], p[1]));
            nearer.clamp(-1.0, 1.0).acos()
        };
        let (mean, largest) = errors(&found, arc);
        assert!(mean < 0.02 && largest < 0.07, "{kind:?}, two sources: {mean} {largest}");
    }
}

#[test]
fn heat_distances_from_several_sources_are_as_exact_as_their_documentation_says() {
    let several: Vec<u32> = (0..20).map(|i| 37 * i % 800).collect();
    for (around, tube, bounds) in [(40, 20, [0.05, 0.11, 0.23]), (80, 40, [0.05, 0.07, 0.15])] {
        let mesh = families::torus(around, tube, 2.0, 0.8).unwrap();
        let solver = heat(&mesh, LaplacianKind::Tufted);
        let exact = Geodesics::new(&mesh).unwrap();
        for (sources, most) in [&[0][..], &[0, 5][..], &several[..]].into_iter().zip(bounds) {
            let sites: Vec<Site> = sources.iter().map(|&v| v.into()).collect();
            let distances = exact.distances(&sites).unwrap();
            let found = solver.distances(sources).unwrap();
            let (_, largest) = errors(&found, |v| distances[v]);
            assert!(largest < most, "{around}, from {}: {largest}", sources.len());
        }
    }
}

#[test]
fn heat_distances_are_infinite_where_no_source_is() {
    let (mut vertices, faces) =
        shapes::both(&shapes::sphere(2), &shapes::sphere(2), 5.0).into_parts();
    vertices.push([0.0, 9.0, 0.0]);
    let n = vertices.len();
    let mesh = TriMesh::new(vertices, faces).unwrap();
    let solver = heat(&mesh, LaplacianKind::Cotangent);
    let found = solver.distances(&[3]).unwrap();
    assert!(found[..n / 2].iter().all(|d| d.is_finite()));
    assert!(found[n / 2..].iter().all(|&d| d == f64::INFINITY));
    let both = solver.distances(&[3, 3 + n as u32 / 2, n as u32 - 1]).unwrap();
    for v in 0..n / 2 {
        assert!((both[v] - found[v]).abs() < 1e-9 && (both[v + n / 2] - found[v]).abs() < 1e-9);
    }
    assert_eq!(both[n - 1], 0.0);
    assert!(solver.distances(&[]).unwrap().iter().all(|&d| d == f64::INFINITY));
    let refused = solver.distances(&[n as u32]);
    assert!(matches!(refused, Err(Error::Argument { what: "sources", .. })));
}

#[test]
fn heat_that_does_not_arrive_is_an_error_and_more_time_helps() {
    let mesh = shapes::grid(1200, 1);
    let solver = heat(&mesh, LaplacianKind::Cotangent);
    let error = solver.distances(&[0]).unwrap_err();
    assert!(matches!(error, Error::Mesh { .. }) && error.to_string().contains("longer time"));
    let options = HeatOptions { time: 100.0, par: Par::Seq, ..Default::default() };
    let found = HeatMethod::new(&mesh, &options).unwrap().distances(&[0]).unwrap();
    assert!((found[1200] / 1200.0 - 1.0).abs() < 0.02, "{}", found[1200]);
    for time in [0.0, -1.0, f64::NAN] {
        assert!(HeatMethod::new(&mesh, &HeatOptions { time, ..options }).is_err());
    }
}

#[test]
fn heat_distances_survive_faces_without_area() {
    let mut vertices = shapes::grid(20, 20).into_parts().0;
    vertices[100] = vertices[101];
    let mesh = TriMesh::new(vertices, shapes::grid(20, 20).into_parts().1).unwrap();
    let plain = HeatOptions::new().kind(LaplacianKind::Cotangent);
    assert!(HeatMethod::new(&mesh, &plain).is_err());
    for kind in &KINDS[1..] {
        let found = heat(&mesh, *kind).distances(&[0]).unwrap();
        let p = mesh.vertices();
        let (mean, largest) = errors(&found, |v| distance(p[v], p[0]));
        assert!(mean < 0.03 && largest < 0.08, "{kind:?}: {mean} {largest}");
    }
}

#[test]
fn heat_distances_without_faces_are_zero_or_infinite() {
    let empty = TriMesh::new(vec![], vec![]).unwrap();
    assert_eq!(heat(&empty, LaplacianKind::Cotangent).distances(&[]).unwrap(), [0.0; 0]);
    let points = TriMesh::new(vec![[0.0; 3]; 2], vec![]).unwrap();
    let found = heat(&points, LaplacianKind::Tufted).distances(&[1]).unwrap();
    assert_eq!(found, [f64::INFINITY, 0.0]);
}

/// Checks distances of the default method, whose mean and largest errors, relative to the largest
/// distance, must be below these.
fn check(
    name: &str,
    mesh: &TriMesh,
    source: u32,
    (most, largest): (f64, f64),
    exact: impl Fn(usize) -> f64,
) {
    let options = HeatOptions::new().par(Par::Seq);
    let found = HeatMethod::new(mesh, &options).unwrap().distances(&[source]).unwrap();
    let errors = errors(&found, exact);
    println!("{name} from {source}: mean {:.4}, largest {:.4}", errors.0, errors.1);
    assert!(errors.0 < most && errors.1 < largest, "{name} from {source}: {errors:?}");
}

/// Returns a mesh with every vertex moved.
fn moved(mesh: &TriMesh, to: impl Fn([f64; 3]) -> [f64; 3]) -> TriMesh {
    let vertices = mesh.vertices().iter().map(|&p| to(p)).collect();
    TriMesh::new(vertices, mesh.faces().to_vec()).unwrap()
}

#[test]
fn heat_distances_do_not_depend_on_how_a_plane_is_cut_into_triangles() {
    for n in [4, 20] {
        let square = shapes::grid(n, n);
        for by in [1.0, 3.0, 6.0, -2.0, 10.0] {
            let mesh = moved(&square, |p| [p[0] + by * p[1], p[1], 0.0]);
            let p = mesh.vertices();
            for source in [0, n, (n / 2) * (n + 2), (n + 1) * (n + 1) - 1] {
                let exact = |v: usize| distance(p[v], p[source as usize]);
                check(&format!("{n} x {n}, sheared by {by}"), &mesh, source, (0.01, 0.03), exact);
            }
        }
        for by in [0.05, 30.0] {
            let mesh = moved(&square, |p| [by * p[0], p[1], 0.0]);
            let p = mesh.vertices();
            for source in [0, n, (n / 2) * (n + 2)] {
                let exact = |v: usize| distance(p[v], p[source as usize]);
                check(&format!("{n} x {n}, stretched by {by}"), &mesh, source, (0.01, 0.03), exact);
            }
        }
    }
    // Needles.
    let mesh = families::slivers(12, 6, 1e-3).unwrap();
    let p = mesh.vertices();
    for source in [0, p.len() as u32 / 2] {
        let exact = |v: usize| distance(p[v], p[source as usize]);
        check("slivers", &mesh, source, (0.01, 0.03), exact);
    }
}

#[test]
fn heat_distances_on_a_long_ellipsoid_are_lengths_of_its_meridian() {
    for long in [1.0, 4.0, 8.0, 20.0] {
        let mesh = moved(&shapes::sphere(4), |p| [long * p[0], p[1], p[2]]);
        // The tip is a vertex: the middle of an edge of the icosahedron.
        let tip = (0..).zip(mesh.vertices()).max_by(|a, b| a.1[0].total_cmp(&b.1[0])).unwrap().0;
        let meridian = |v: usize| {
            let angle = (mesh.vertices()[v][0] / long).clamp(-1.0, 1.0).acos();
            // The midpoint rule.
            let steps = 2000;
            let length = |i: i32| {
                let at = angle * (f64::from(i) + 0.5) / f64::from(steps);
                (long * at.sin()).hypot(at.cos()) * angle / f64::from(steps)
            };
            (0..steps).map(length).sum()
        };
        check(&format!("ellipsoid {long}:1"), &mesh, tip, (0.01, 0.03), meridian);
    }
}

#[test]
fn heat_distances_on_a_few_faces_are_those_of_the_surface() {
    // The distance is the straight one, which is an edge or lies in the plane.
    let rhombus = [[0.0, 0.0, 0.0], [1.0, -3.0, 0.0], [2.0, 0.0, 0.0], [1.0, 3.0, 0.0]];
    let rhombus = TriMesh::new(rhombus.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let found = HeatMethod::new(&rhombus, &HeatOptions::default()).unwrap().distances(&[2]);
    for (found, exact) in found.unwrap().iter().zip([2.0, 10f64.sqrt(), 0.0, 10f64.sqrt()]) {
        assert!((found - exact).abs() < 1e-12, "{found} and not {exact}");
    }
    // A cube: to the opposite corner over two unfolded sides.
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let cube = TriMesh::new((0..8).map(corner).collect(), faces).unwrap();
    for source in 0..8 {
        let exact =
            |v: usize| [0.0, 1.0, 2f64.sqrt(), 5f64.sqrt()][(v ^ source).count_ones() as usize];
        check("cube", &cube, source as u32, (0.01, 0.03), exact);
    }
    // Pages that share an edge of length 1, unfolded in pairs: tips are 1 away from it.
    let book = families::pages(5).unwrap();
    for source in 2..7 {
        let exact = |v: usize| match v {
            0 | 1 => 1.25f64.sqrt(),
            _ => {
                if v == source {
                    0.0
                } else {
                    2.0
                }
            }
        };
        check("pages", &book, source as u32, (0.01, 0.03), exact);
    }
}

#[test]
fn heat_distances_are_between_straight_lines_and_paths_along_edges() {
    for seed in 0..20 {
        let mesh = shapes::soup(4 + seed as u32 % 13, 3 + seed as usize % 17, seed);
        let p = mesh.vertices();
        let sources = [mesh.faces()[0][0], mesh.faces()[2][1]];
        let solver = HeatMethod::new(&mesh, &HeatOptions::new().par(Par::Seq)).unwrap();
        let found = solver.distances(&sources).unwrap();
        let graph = Graph::of_mesh(&mesh);
        let mut search = Dijkstra::new(&graph);
        search.search(&sources.map(|v| (v, 0.0)), &SearchLimits::default()).unwrap();
        for (v, found) in found.iter().enumerate() {
            let straight = |s: u32| distance(p[v], p[s as usize]);
            let below = straight(sources[0]).min(straight(sources[1]));
            let above = search.distance(v as u32);
            assert_eq!(found.is_finite(), above.is_finite(), "seed {seed}, vertex {v}");
            let between = (below - 1e-12..=above + 1e-12).contains(found);
            assert!(between || above == f64::INFINITY, "seed {seed}, vertex {v}: {found}");
        }
    }
}
