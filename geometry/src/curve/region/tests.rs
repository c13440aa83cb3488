use crate::curve::dataset::{Generator, Sampling, samples, scaled};
use crate::curve::{
    Count, Curve, CurveOptions, Drawing, Drawn, Mode, Outcome, Region, Side, cut, same_order,
};
use crate::mesh::{Components, Edges, Graph, TriMesh, families, shapes};
use catamaran::base::Rng;

fn walls(curves: &[Curve]) -> Vec<[u32; 2]> {
    curves.iter().flat_map(Curve::edges).collect()
}

/// Returns curves through each list of samples, drawn into the mesh.
fn drawn(mesh: &TriMesh, layers: &[&[u32]], smooth: bool) -> Drawn {
    let mut drawing = Drawing::new(mesh.clone()).unwrap();
    for layer in layers {
        let found = drawing.add(layer, &CurveOptions::new()).unwrap();
        assert_eq!(found.outcome, Outcome::Closed);
    }
    if smooth {
        assert!(drawing.smooth().unwrap());
    }
    drawing.inscribe().unwrap()
}

fn regions(drawn: &Drawn, side: &Side) -> Vec<Region> {
    let mesh = &drawn.refined.mesh;
    drawn.layers.iter().map(|l| Region::enclosed(mesh, &walls(l), side).unwrap()).collect()
}

/// Returns the numbers of components, the Euler characteristic, and the number of boundary loops.
fn topology(mesh: &TriMesh) -> (usize, i64, usize) {
    let edges = Edges::new(mesh);
    let loops = mesh.boundary_loops(&edges).unwrap().len();
    (Components::new(mesh).len(), mesh.euler_characteristic(&edges), loops)
}

#[test]
fn a_closed_curve_on_a_sphere_cuts_it_in_two_disks() {
    let mesh = families::icosphere(4).unwrap();
    for smooth in [false, true] {
        let drawn = drawn(&mesh, &[&[3, 700, 1200, 2000, 150, 999]], smooth);
        let whole = &drawn.refined.mesh;
        let along = walls(&drawn.layers[0]);
        let open = cut(whole, &along).unwrap();
        assert_eq!(topology(whole), (1, 2, 0));
        assert_eq!(topology(&open.mesh), (2, 2, 2));
        assert_eq!(open.mesh.vertices().len(), whole.vertices().len() + along.len());
        assert!(open.mesh.require_manifold().is_ok());
        // The same triangles at the same positions.
        assert_eq!(open.mesh.area(), whole.area());
        for (face, old) in open.mesh.faces().iter().zip(whole.faces()) {
            assert_eq!(face.map(|v| open.vertices[v as usize]), *old);
        }
        // The pieces are the two sides.
        let small = Region::enclosed(whole, &along, &Side::Small).unwrap();
        let large = Region::enclosed(whole, &along, &Side::Large).unwrap();
        assert_eq!(small.complement(), large);
        let [a, b] = [&small, &large].map(|side| side.area(whole).unwrap());
        assert!(a < b && (a + b - mesh.area()).abs() < 1e-12);
        let mut edges = along.clone();
        edges.sort_unstable();
        assert_eq!(small.boundary(whole).unwrap(), edges);
        let part = small.part(whole).unwrap();
        assert_eq!(topology(&part.mesh), (1, 1, 1));
        // Shares of the faces of the mesh give the same area.
        let shares = drawn.refined.shares(small.mask()).unwrap();
        let sum: f64 = shares.iter().zip(mesh.face_areas()).map(|(s, a)| s * a).sum();
        assert!((sum - a).abs() < 1e-12);
        assert_eq!(shares.iter().all(|&s| s == 0.0 || s == 1.0), !smooth);
    }
}

#[test]
fn seeds_choose_pieces() {
    let mesh = families::cylinder(24, 60, 1.0, 20.0).unwrap();
    let ring = |row: u32| (0..24).step_by(3).map(move |i| 61 * i + row);
    let both: Vec<u32> = ring(10).chain(ring(50)).collect();
    let drawn = drawn(&mesh, &[&both], false);
    assert_eq!(drawn.layers[0].len(), 2);
    let along = walls(&drawn.layers[0]);
    let mesh = &drawn.refined.mesh;
    let region = |side: Side| Region::enclosed(mesh, &along, &side);
    // By area: the two ends together, or the middle between them.
    let ends = region(Side::Small).unwrap();
    assert_eq!(Components::new(&ends.part(mesh).unwrap().mesh).len(), 2);
    assert_eq!(ends.faces().len(), 24 * 2 * 20);
    let [first, last] = [5, 55].map(|v| region(Side::Seeds(vec![v])).unwrap());
    assert_eq!(first.union(&last).unwrap(), ends);
    assert_eq!(region(Side::Seeds(vec![5, 55])).unwrap(), ends);
    assert_eq!(region(Side::Seeds(vec![30])).unwrap(), region(Side::Large).unwrap());
    assert!(region(Side::Seeds(vec![10])).unwrap_err().to_string().contains("on the curve"));
    assert!(region(Side::Seeds(vec![])).unwrap_err().to_string().contains("must not be empty"));
    assert!(region(Side::Seeds(vec![99999])).unwrap_err().to_string().contains("in no face"));
}

#[test]
fn a_loop_around_a_handle_can_be_cut_but_encloses_nothing() {
    let mesh = families::torus(40, 20, 2.0, 0.8).unwrap();
    // Two curves around the tube; each has the vertices 20 i to 20 i + 19.
    let ring = |i: u32| [20 * i, 20 * i + 5, 20 * i + 10, 20 * i + 15];
    let one = drawn(&mesh, &[&ring(3)], false);
    let along = walls(&one.layers[0]);
    assert_eq!(along.len(), 20);
    let open = cut(&mesh, &along).unwrap();
    assert_eq!(topology(&open.mesh), (1, 0, 2));
    for side in [Side::Small, Side::Large, Side::Seeds(vec![200])] {
        let refused = Region::enclosed(&mesh, &along, &side).unwrap_err().to_string();
        assert!(refused.contains("go around a handle"), "{refused}");
    }
    // Two such curves separate it.
    let two = drawn(&mesh, &[&ring(3), &ring(13)], false);
    let along = two.layers.concat();
    let along = walls(&along);
    assert_eq!(topology(&cut(&mesh, &along).unwrap().mesh), (2, 0, 4));
    let small = Region::enclosed(&mesh, &along, &Side::Small).unwrap();
    assert_eq!(small.faces().len(), 2 * 20 * 10);
}

#[test]
fn an_open_curve_is_a_slit_and_parts_what_it_reaches_across() {
    let mesh = shapes::grid(8, 8);
    let row = |from: u32, to: u32| (from..to).map(|x| [36 + x, 37 + x]).collect::<Vec<_>>();
    let inside = cut(&mesh, &row(2, 6)).unwrap();
    // Four edges, whose three inner vertices are doubled.
    assert_eq!(inside.mesh.vertices().len(), 81 + 3);
    assert_eq!(topology(&mesh), (1, 1, 1));
    assert_eq!(topology(&inside.mesh), (1, 0, 2));
    let across = cut(&mesh, &row(0, 8)).unwrap();
    assert_eq!(topology(&across.mesh), (2, 2, 2));
    assert!(Region::enclosed(&mesh, &row(2, 6), &Side::Small).is_err());
    let half = Region::enclosed(&mesh, &row(0, 8), &Side::Small).unwrap();
    // Of two equal halves, the one with the face of the lowest number is chosen.
    assert_eq!(half.faces(), (0..64).collect::<Vec<u32>>());
    // Edges of the boundary separate nothing.
    let side: Vec<[u32; 2]> = (0..8).map(|x| [x, x + 1]).collect();
    assert_eq!(topology(&cut(&mesh, &side).unwrap().mesh), (1, 1, 1));
    assert!(
        Region::enclosed(&mesh, &side, &Side::Small).unwrap_err().to_string().contains("boundary")
    );
    assert!(
        cut(&mesh, &[[0, 40]]).unwrap_err().to_string().contains("no edge joins vertices 0 and 40")
    );
    assert_eq!(cut(&mesh, &[]).unwrap().mesh, mesh);
}

#[test]
fn regions_of_curves_that_cross_satisfy_the_laws_of_sets() {
    let mesh = families::icosphere(4).unwrap();
    let mut rng = Rng::new(5);
    let mut pick = |count: usize| -> Vec<u32> {
        let mut all: Vec<u32> =
            (0..count).map(|_| (rng.bits() % mesh.vertices().len() as u64) as u32).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let layers: Vec<Vec<u32>> = (0..4).map(|_| pick(6)).collect();
    let layers: Vec<&[u32]> = layers.iter().map(|layer| &layer[..]).collect();
    for smooth in [false, true] {
        let drawn = drawn(&mesh, &layers, smooth);
        let whole = &drawn.refined.mesh;
        assert_eq!(topology(whole), (1, 2, 0));
        assert!((whole.area() - mesh.area()).abs() < 1e-12);
        assert!(whole.inconsistent_edges(&Edges::new(whole)).is_empty());
        let all = regions(&drawn, &Side::Small);
        for (a, b) in all.iter().zip(all.iter().skip(1)) {
            let (union, both) = (a.union(b).unwrap(), a.intersection(b).unwrap());
            assert!(!both.is_empty() || !smooth, "they do not cross");
            let others = a.complement().intersection(&b.complement()).unwrap();
            assert_eq!(union.complement(), others);
            assert_eq!(a.difference(b).unwrap(), a.intersection(&b.complement()).unwrap());
            let one = a.difference(b).unwrap().union(&b.difference(a).unwrap()).unwrap();
            assert_eq!(a.symmetric_difference(b).unwrap(), one);
            let area = |r: &Region| r.area(whole).unwrap();
            assert!((area(&union) + area(&both) - area(a) - area(b)).abs() < 1e-12);
            assert!(a.union(&a.complement()).unwrap().faces().len() == whole.faces().len());
        }
        // A cut along all curves at once gives disks, as many as the arrangement has faces.
        let along: Vec<[u32; 2]> = walls(&drawn.layers.concat());
        let open = cut(whole, &along).unwrap();
        let parts = Components::new(&open.mesh);
        assert!(parts.len() > 4);
        let sum: f64 = (0..parts.len())
            .map(|part| open.mesh.component(&parts, part).unwrap().mesh.area())
            .sum();
        assert!((sum - mesh.area()).abs() < 1e-12);
    }
    let other = Region::new(vec![true]);
    assert!(other.union(&Region::new(vec![])).is_err());
    assert!(other.area(&mesh).is_err() && other.boundary(&mesh).is_err());
}

#[test]
fn generated_curves_cut_surfaces_of_every_genus_and_with_boundary() {
    let surfaces = [
        families::genus(2, 10).unwrap(),
        families::icosphere(5).unwrap(),
        families::torus(120, 50, 2.0, 0.8).unwrap(),
        families::disk(60, 96).unwrap(),
    ];
    for mesh in surfaces {
        let mesh = scaled(&mesh).unwrap();
        let graph = Graph::of_mesh(&mesh);
        let mut generator = Generator::new(&graph, 3).unwrap();
        let mut rng = Rng::new(4);
        let (parts, euler, loops) = topology(&mesh);
        for smooth in [false, true] {
            let Some(curve) = generator.curve().unwrap() else { continue };
            let given = samples(&curve, 25, Sampling::Even, &mut rng);
            let mut drawing = Drawing::new(mesh.clone()).unwrap();
            let options = CurveOptions::new().count(Count::One);
            drawing.add(&given.vertices, &options).unwrap();
            if smooth {
                drawing.smooth().unwrap();
            }
            let drawn = drawing.inscribe().unwrap();
            let whole = &drawn.refined.mesh;
            assert!((whole.area() / mesh.area() - 1.0).abs() < 1e-12);
            assert_eq!(topology(whole), (parts, euler, loops));
            let along = walls(&drawn.layers[0]);
            let open = topology(&cut(whole, &along).unwrap().mesh);
            // A closed curve away from the boundary has two sides.
            let region = Region::enclosed(whole, &along, &Side::Small);
            if loops == 0 {
                let more = usize::from(region.is_ok());
                assert_eq!(open, (parts + more, euler, 2));
            }
            if let Ok(region) = region {
                assert!(region.area(whole).unwrap() <= mesh.area() / 2.0);
            }
        }
    }
}

#[test]
fn samples_in_their_order_are_joined_in_it() {
    let mesh = families::disk(40, 96).unwrap();
    let star: Vec<u32> = (0..5).map(|i| 1 + 20 * 96 + (38 * i) % 96).collect();
    let mut drawing = Drawing::new(mesh).unwrap();
    let found = drawing.add(&star, &CurveOptions::new()).unwrap();
    assert!(!same_order(&found.curves[0].order, &[0, 1, 2, 3, 4]));
    let options = CurveOptions::new().mode(Mode::Ordered);
    let found = drawing.add(&star, &options).unwrap();
    assert_eq!(found.curves[0].order, [0, 1, 2, 3, 4]);
    let found = drawing.add(&star[..2], &options);
    assert!(found.is_err(), "two samples");
    let mut spheres = Drawing::new(families::spheres(2, 1).unwrap()).unwrap();
    let found = spheres.add(&[0, 1, 50], &options).unwrap();
    assert_eq!(found.outcome, Outcome::Disconnected { components: 2 });
}

#[test]
fn layers_stay_where_they_are_when_a_later_one_needs_steiner_points() {
    // All vertices of an icosahedron, in an order in which paths must cross without new points.
    let mesh = families::icosphere(0).unwrap();
    let mut drawing = Drawing::new(mesh.clone()).unwrap();
    drawing.add(&[0, 1, 2], &CurveOptions::new()).unwrap();
    let before = drawing.found().next().unwrap().curves[0].clone();
    let all = [0, 3, 1, 2, 5, 4, 6, 7, 8, 9, 10, 11];
    drawing.add(&all, &CurveOptions::new().mode(Mode::Ordered)).unwrap();
    let after = drawing.found().next().unwrap().curves[0].clone();
    assert!(drawing.mesh().vertices().len() > 12, "no Steiner points were needed");
    assert!((after.length - before.length).abs() < 1e-12);
    let drawn = drawing.inscribe().unwrap();
    let edges = Edges::new(&drawn.refined.mesh);
    for ends in walls(&drawn.layers.concat()) {
        assert!(edges.ends().binary_search(&ends).is_ok(), "{ends:?}");
    }
    assert!((drawn.refined.mesh.area() - mesh.area()).abs() < 1e-12);
    drawing.smooth().unwrap();
    assert!(drawing.add(&[0, 1, 2], &CurveOptions::new()).is_err());
}
