//! Decimation with a density of vertices that varies: the ratios of areas that are asked for, the
//! promises of every decimation, and errors that name the culprit.

use catamaran::Par;
use catamaran_geometry::decimate::{
    DecimateOptions, Decimator, Difference, Method, Quality, curvature_density, decimate,
    decimate_within,
};
use catamaran_geometry::mesh::{TriMesh, families};

use super::decimate::check;

fn options() -> DecimateOptions<'static> {
    DecimateOptions::new().par(Par::Seq)
}

/// The middle of the mesh along x, and its width.
fn middle_and_width(mesh: &TriMesh) -> [f64; 2] {
    let [low, high] = mesh.bounding_box().unwrap();
    [0.5 * (low[0] + high[0]), high[0] - low[0]]
}

/// The density that is `ratio` on the right half, and 1 on the left.
fn halves(mesh: &TriMesh, ratio: f64) -> Vec<f64> {
    let [middle, _] = middle_and_width(mesh);
    mesh.vertices().iter().map(|p| if p[0] > middle { ratio } else { 1.0 }).collect()
}

/// The ratio of the mean area of faces of the left half to that of the right half, away from the
/// middle.
fn ratio_of_areas(mesh: &TriMesh) -> f64 {
    let [middle, width] = middle_and_width(mesh);
    let mut sums = [(0.0, 0.0); 2];
    for (area, face) in mesh.face_areas().into_iter().zip(mesh.faces()) {
        let x = face.iter().map(|&v| mesh.vertices()[v as usize][0]).sum::<f64>() / 3.0 - middle;
        if x.abs() > 0.05 * width {
            let sum = &mut sums[usize::from(x > 0.0)];
            *sum = (sum.0 + area, sum.1 + 1.0);
        }
    }
    let [left, right] = sums.map(|(area, count)| area / count);
    left / right
}

/// A ball with small bumps on one side.
fn bumpy(subdivisions: u32) -> TriMesh {
    let (mut vertices, faces) = families::icosphere(subdivisions).unwrap().into_parts();
    for p in &mut vertices {
        let on_side = ((p[0] - 0.5) / 0.2).clamp(0.0, 1.0);
        let bump = 1.0 + 0.05 * on_side * (12.0 * p[1]).sin() * (12.0 * p[2]).sin();
        *p = p.map(|x| x * bump);
    }
    TriMesh::new(vertices, faces).unwrap()
}

#[test]
fn areas_have_the_ratio_that_the_density_asks_for() {
    let cases = [
        ("grid", families::grid(80, 80).unwrap()),
        ("sphere", families::icosphere(5).unwrap()),
        // Its edges are longer than those of the result.
        ("coarse grid", families::grid(40, 12).unwrap()),
    ];
    for (name, mesh) in cases {
        let density = halves(&mesh, 9.0);
        let options = options().density(&density);
        for options in [options, options.lloyd(2), options.uniform(true)] {
            let found = decimate(&mesh, 1500, &options).unwrap();
            check(name, &mesh, 1500, &found);
            let ratio = ratio_of_areas(&found.mesh);
            assert!((ratio / 9.0 - 1.0).abs() < 0.15, "{name}: {ratio}");
            let quality = Quality::of(&found.mesh);
            assert!(quality.mean_quality >= 0.85, "{name}: {quality}");
            assert!(found.mesh.intersecting_faces(Par::Seq).is_empty(), "{name}");
        }
    }
}

#[test]
fn a_density_that_is_the_same_everywhere_changes_nothing() {
    let torus = families::torus(61, 29, 2.0, 0.7).unwrap();
    let same = vec![7.5; torus.vertices().len()];
    for n in [100, 3000] {
        let without = decimate(&torus, n, &options()).unwrap();
        assert_eq!(without, decimate(&torus, n, &options().density(&[])).unwrap());
        assert_eq!(without, decimate(&torus, n, &options().density(&same)).unwrap());
        assert_eq!(without, decimate(&torus, n, &options().curvature(1.0)).unwrap());
    }
    // A plane does not bend; lengths are measured by the density, which is constant.
    let plane = families::grid(50, 40).unwrap();
    for n in [200, 4000] {
        let without = decimate(&plane, n, &options()).unwrap();
        assert_eq!(without, decimate(&plane, n, &options().curvature(16.0)).unwrap());
    }
}

#[test]
fn only_ratios_of_densities_count_and_threads_do_not() {
    let (vertices, faces) = bumpy(4).into_parts();
    // Neighbours are far from each other in memory.
    let half = vertices.len().div_ceil(2) as u32;
    let number = |v: u32| v / 2 + half * (v % 2);
    let mut moved = vertices.clone();
    vertices.iter().zip(0..).for_each(|(&p, v)| moved[number(v) as usize] = p);
    let mesh = TriMesh::new(moved, faces.iter().map(|face| face.map(number)).collect()).unwrap();
    let density: Vec<f64> = mesh.vertices().iter().map(|p| (2.0 * p[2]).exp()).collect();
    let larger: Vec<f64> = density.iter().map(|d| 1024.0 * d).collect();
    let options = options().density(&density).curvature(8.0).lloyd(1).uniform(true);
    for n in [300, 4000] {
        let found = decimate(&mesh, n, &options).unwrap();
        check("bumpy", &mesh, n, &found);
        for other in [options.par(Par::Threads(3)), options.density(&larger)] {
            assert!(found == decimate(&mesh, n, &other).unwrap(), "{n}");
        }
    }
}

#[test]
fn every_family_keeps_its_topology_with_extreme_densities() {
    for (name, mesh, sizes) in [
        ("torus", families::torus(61, 29, 2.0, 0.7), [90, 2500]),
        ("genus 3", families::genus(3, 6), [200, 3000]),
        ("figure", families::figure(5, 0.5), [200, 900]),
        ("spheres", families::spheres(3, 3), [80, 1200]),
        ("cylinder", families::cylinder(60, 20, 1.0, 1.0), [100, 1500]),
        ("Moebius", families::moebius(100, 12), [100, 1500]),
        ("terrain", families::terrain(60, 50, 3), [101, 600]),
    ] {
        let mesh = mesh.unwrap();
        let alternating = (0..mesh.vertices().len()).map(|v| if v % 7 == 0 { 1e6 } else { 1e-6 });
        for density in [halves(&mesh, 1e12), halves(&mesh, 100.0), alternating.collect()] {
            let options = options().density(&density).cut_narrow_handles(name == "spheres");
            for n in sizes {
                let name = format!("{name} to {n}");
                let found = decimate(&mesh, n, &options).unwrap_or_else(|e| panic!("{name}: {e}"));
                check(&name, &mesh, n, &found);
            }
        }
    }
}

#[test]
fn locked_vertices_stay_and_levels_come_from_one_decimator() {
    let mesh = families::cylinder(24, 6, 1.0, 1.0).unwrap();
    let density = halves(&mesh, 16.0);
    let locked = [70, 3, 111];
    let options = options().density(&density).curvature(4.0).locked(&locked);
    let mut decimator = Decimator::new(&mesh, &options).unwrap();
    for n in [60, 900, 300, 2000] {
        let found = decimator.decimate(n).unwrap();
        check("cylinder", &mesh, n, &found);
        for (&v, p) in locked.iter().zip(found.mesh.vertices()) {
            assert_eq!(*p, mesh.vertices()[v as usize]);
        }
    }
    // Distances of cells are lengths on the mesh.
    let found = decimator.decimate(3).unwrap_err().to_string();
    assert!(found.starts_with("n: 3"), "{found}");
    let found = decimator.decimate(60).unwrap();
    let far = found.cells.distances().iter().fold(0f32, |most, &d| most.max(d));
    assert!(far < 1.2, "{far}");
}

#[test]
fn curvature_brings_the_result_nearer_to_a_shape_with_fine_detail() {
    let mesh = bumpy(6);
    let away = |options: &DecimateOptions<'_>| {
        let found = decimate(&mesh, 1000, options).unwrap();
        check("bumpy", &mesh, 1000, &found);
        let quality = Quality::of(&found.mesh);
        assert!(quality.mean_quality >= 0.85, "{quality}");
        Difference::between(&mesh, &found.mesh, Par::Seq).unwrap()
    };
    let [even, adapted] = [options(), options().curvature(16.0)].map(|options| away(&options));
    assert!(adapted.hausdorff < 0.7 * even.hausdorff, "{adapted:?} {even:?}");
    assert!(adapted.chamfer < 0.8 * even.chamfer, "{adapted:?} {even:?}");
    // So fewer vertices suffice for the same error.
    let mesh = bumpy(5);
    let within = |options: &DecimateOptions<'_>| {
        let found = decimate_within(&mesh, 0.03, options).unwrap();
        let bound = Difference::between(&mesh, &found.mesh, Par::Seq).unwrap().hausdorff_bound;
        assert!(bound <= 0.03, "{bound}");
        found.mesh.vertices().len()
    };
    let [even, adapted] = [options(), options().curvature(16.0)].map(|options| within(&options));
    assert!(adapted < even, "{adapted} {even}");
}

#[test]
fn densities_by_curvature_are_large_where_a_surface_bends_and_grow_gently() {
    let sphere = families::icosphere(5).unwrap();
    let ends = curvature_density(&sphere, 500, 16.0).unwrap();
    let most = ends.iter().copied().fold(0.0, f64::max);
    assert!(ends.iter().all(|&d| d > 0.8 * most), "a sphere is even");
    let mesh = bumpy(5);
    let density = curvature_density(&mesh, 800, 16.0).unwrap();
    assert_eq!(density.len(), mesh.vertices().len());
    let extremes = density.iter().fold((f64::MAX, 0f64), |(a, b), &d| (a.min(d), b.max(d)));
    assert!(extremes.0 > 0.0 && extremes.1 <= 16.0 * (1.0 + 1e-12) * extremes.0, "{extremes:?}");
    let mean = |wanted: &dyn Fn(f64) -> bool| {
        let some = mesh.vertices().iter().zip(&density).filter(|(p, _)| wanted(p[0]));
        let (sum, count) = some.fold((0.0, 0.0), |(sum, count), (_, d)| (sum + d, count + 1.0));
        sum / count
    };
    let (bumps, rest) = (mean(&|x| x > 0.8), mean(&|x| x < 0.0));
    assert!(bumps > 2.0 * rest, "{bumps} {rest}");
    // Neighbours differ by what a fifth of an edge allows.
    let size = |v: u32| 1.0 / density[v as usize].sqrt();
    let length = catamaran_geometry::decimate::edge_length_for(mesh.area(), 800).unwrap();
    for &[a, b] in catamaran_geometry::mesh::Edges::new(&mesh).ends() {
        let [p, q] = [a, b].map(|v| mesh.vertices()[v as usize]);
        let away = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
        assert!((size(a) - size(b)).abs() <= 0.2 * away / length + 1e-12);
    }
    // Units do not matter.
    let (mut vertices, faces) = mesh.into_parts();
    vertices.iter_mut().for_each(|p| *p = p.map(|x| 1024.0 * x));
    let large = TriMesh::new(vertices, faces).unwrap();
    for (a, b) in density.iter().zip(curvature_density(&large, 800, 16.0).unwrap()) {
        assert!((a / b - 1.0).abs() < 1e-9);
    }
}

#[test]
fn impossible_densities_are_refused_with_the_culprit() {
    let mesh = families::icosphere(2).unwrap();
    let mut density = vec![1.0; 162];
    let mut with = |changes: &[(usize, f64)]| {
        density.fill(1.0);
        changes.iter().for_each(|&(v, d)| density[v] = d);
        decimate(&mesh, 50, &options().density(&density)).unwrap_err().to_string()
    };
    for (value, text) in [(0.0, "0e0"), (-2.0, "-2e0"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
        let why = format!("density: must be positive and finite, is {text} at vertex 7");
        assert_eq!(with(&[(7, value), (9, -1.0)]), why);
    }
    assert_eq!(
        with(&[(5, 1e-7), (3, 1e6)]),
        "density: must not vary by more than 1e12, is 1e-7 at vertex 5 and 1e6 at vertex 3"
    );
    let few = decimate(&mesh, 50, &options().density(&[1.0, 2.0])).unwrap_err().to_string();
    assert_eq!(few, "density: must be one for each of 162 vertices, has 2");
    for (value, text) in [(0.5, "0.5"), (f64::NAN, "NaN"), (2e6, "2000000")] {
        let refused = decimate(&mesh, 50, &options().curvature(value)).unwrap_err().to_string();
        assert_eq!(refused, format!("curvature: must be from 1 to 1000000, is {text}"));
    }
    let thesis = options().method(Method::Thesis);
    let one = vec![1.0; 162];
    for (options, what) in [(thesis.density(&one), "density"), (thesis.curvature(2.0), "curvature")]
    {
        let refused = decimate(&mesh, 50, &options).unwrap_err().to_string();
        let why = "the method of the thesis has the same density everywhere";
        assert_eq!(refused, format!("{what}: {why}"));
    }
    let refused = curvature_density(&mesh, 0, 16.0).unwrap_err().to_string();
    assert!(refused.starts_with("n: "), "{refused}");
}
