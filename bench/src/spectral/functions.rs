//! The functions that tables 1.1 to 1.4 of the thesis approximate and transfer; one row for each
//! vertex, one column for each function. The descriptors among them are those of the library.

use catamaran::base::{Error, Result, Rng};
use catamaran::faer::{Mat, MatRef};
use catamaran_geometry::mesh::{Dijkstra, Graph, SearchLimits, TriMesh, vertex_areas};
use catamaran_geometry::spectral::descriptors::heat_kernel;

/// Computes heat kernels between random vertices and all others (HK). The arguments are those of
/// [`heat_kernel`]; the thesis uses t = 1e-3 on shapes of area 1. The same seed gives the same
/// vertices for any number of eigenfunctions.
///
/// # Errors
/// As [`heat_kernel`]; [`Error::Argument`] when there are no vertices.
pub fn heat_kernels(
    values: &[f64],
    vectors: MatRef<'_, f64>,
    time: f64,
    count: usize,
    seed: u64,
) -> Result<Mat<f64>> {
    let (n, mut rng) = (vectors.nrows(), Rng::new(seed));
    let mut kernels = Mat::zeros(n, count);
    for j in 0..count {
        let source = random_vertex(n, &mut rng)?;
        for (i, heat) in heat_kernel(values, vectors, source, time)?.into_iter().enumerate() {
            kernels[(i, j)] = heat;
        }
    }
    Ok(kernels)
}

/// Returns `count` columns of a signature at equal distances, the first and the last included (the
/// middle one, if `count` is 1). The thesis takes 10 channels of 100 scales for HKS and WKS.
///
/// # Errors
/// [`Error::Argument`] for more columns than the signature has.
pub fn channels(signature: MatRef<'_, f64>, count: usize) -> Result<Mat<f64>> {
    let all = signature.ncols();
    if count > all {
        let why = format!("must be at most {all}, the columns of the signature, is {count}");
        return Err(Error::Argument { what: "channels", why });
    }
    let column = |j: usize| if count == 1 { all / 2 } else { j * (all - 1) / (count - 1) };
    Ok(Mat::from_fn(signature.nrows(), count, |i, j| signature[(i, column(j))]))
}

/// Returns columns of independent random numbers, uniform in [0, 1) (Rand).
pub fn random(n: usize, count: usize, seed: u64) -> Mat<f64> {
    let mut rng = Rng::new(seed);
    let mut functions = Mat::zeros(n, count);
    for j in 0..count {
        for i in 0..n {
            functions[(i, j)] = rng.uniform();
        }
    }
    functions
}

/// Returns indicators of random regions (Ind): 1 at the vertices nearest to a random vertex along
/// edges, and 0 elsewhere. A region has at least this share of the area (in (0, 1]), or all
/// vertices connected to the random one.
///
/// # Errors
/// [`Error::Argument`] for a share out of range, or no vertices.
pub fn geodesic_cells(mesh: &TriMesh, share: f64, count: usize, seed: u64) -> Result<Mat<f64>> {
    if !(share > 0.0 && share <= 1.0) {
        let why = format!("must be in (0, 1], is {share}");
        return Err(Error::Argument { what: "share", why });
    }
    let (n, mut rng) = (mesh.vertices().len(), Rng::new(seed));
    let areas = vertex_areas(mesh);
    let wanted = share * areas.iter().sum::<f64>();
    let graph = Graph::of_mesh(mesh);
    let mut search = Dijkstra::new(&graph);
    let mut cells = Mat::zeros(n, count);
    for j in 0..count {
        let source = random_vertex(n, &mut rng)?;
        search.search(&[(source as u32, 0.0)], &SearchLimits::default())?;
        let mut area = 0.0;
        for &v in search.reached() {
            if area >= wanted {
                break;
            }
            area += areas[v as usize];
            cells[(v as usize, j)] = 1.0;
        }
    }
    Ok(cells)
}

fn random_vertex(n: usize, rng: &mut Rng) -> Result<usize> {
    if n == 0 {
        return Err(Error::Argument { what: "mesh", why: "has no vertices".into() });
    }
    Ok(((rng.uniform() * n as f64) as usize).min(n - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran_geometry::mesh::families;

    #[test]
    fn cells_have_their_share_of_the_area_and_are_connected() {
        let mesh = families::icosphere(3).unwrap();
        let areas = vertex_areas(&mesh);
        let total: f64 = areas.iter().sum();
        let cells = geodesic_cells(&mesh, 0.1, 5, 1).unwrap();
        let graph = Graph::of_mesh(&mesh);
        for j in 0..5 {
            let inside: Vec<usize> = (0..areas.len()).filter(|&i| cells[(i, j)] == 1.0).collect();
            let area: f64 = inside.iter().map(|&i| areas[i]).sum();
            assert!(area >= 0.1 * total && area < 0.12 * total, "{area} of {total}");
            for &i in &inside {
                let mut near = graph.neighbours(i as u32);
                assert!(near.any(|(v, _)| cells[(v as usize, j)] == 1.0));
            }
        }
        assert!(geodesic_cells(&mesh, 1.0, 1, 1).unwrap().sum() == areas.len() as f64);
        for share in [0.0, 1.5, f64::NAN] {
            let refused = geodesic_cells(&mesh, share, 1, 1);
            assert!(matches!(refused, Err(Error::Argument { what: "share", .. })), "{share}");
        }
        assert!(geodesic_cells(&TriMesh::new(vec![], vec![]).unwrap(), 0.5, 1, 1).is_err());
    }

    #[test]
    fn the_seed_decides_and_channels_are_spread() {
        assert_eq!(random(5, 2, 3), random(5, 2, 3));
        assert!(random(5, 2, 3) != random(5, 2, 4));
        let signature = Mat::from_fn(2, 100, |_, j| j as f64);
        let ten = channels(signature.as_ref(), 10).unwrap();
        let expected = Mat::from_fn(2, 10, |_, j| 11.0 * j as f64);
        assert_eq!(ten, expected);
        assert_eq!(channels(signature.as_ref(), 1).unwrap()[(0, 0)], 50.0);
        assert_eq!(channels(signature.as_ref(), 0).unwrap().ncols(), 0);
        assert!(channels(signature.as_ref(), 101).is_err());
        let vectors = Mat::from_fn(6, 1, |_, _| 2.0);
        let heat = heat_kernels(&[0.0], vectors.as_ref(), 1e-3, 3, 1).unwrap();
        assert_eq!(heat, Mat::from_fn(6, 3, |_, _| 4.0));
    }
}
