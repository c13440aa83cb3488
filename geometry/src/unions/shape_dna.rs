//! ShapeDNA: the first eigenvalues of a surface as its signature.
//!
//! Source: Reuter, Wolter and Peinecke, Laplace-Beltrami spectra as "Shape-DNA" of surfaces and
//! solids (2006).

use crate::mesh::{LaplacianOptions, TriMesh, free_components, laplacian};
use catamaran::base::{Error, Par, Progress, Result, options};
use catamaran::sparse::{EigenOptions, eigs};

options! {
    /// Options of [`shape_dna`].
    #[derive(Debug, Clone)]
    pub struct ShapeDnaOptions<'a> {
        /// Number of eigenvalues; [`free_components`] returns the number of zeros among them.
        k: usize = 20, range "more than the number of zeros";
        /// Whether the eigenvalues are multiplied by the area, so that they do not depend on the
        /// size of the shape.
        normalized: bool = true;
        /// Options of the Laplacian, including the boundary condition and threads.
        laplacian: LaplacianOptions = LaplacianOptions::new();
        /// Callback for progress, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

/// Computes the k smallest eigenvalues of a surface, ascending: in units of 1 / length^2, or
/// without unit if they are normalized by the area. As many of them are 0 as the surface has
/// components without a vertex that is held at zero ([`free_components`]): one of a connected
/// surface under Neumann conditions.
///
/// ```
/// use catamaran_geometry::{mesh::families, unions::{ShapeDnaOptions, shape_dna}};
///
/// let signature = shape_dna(&families::icosphere(2)?, &ShapeDnaOptions::new().k(5))?;
/// assert_eq!(signature.len(), 5);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`laplacian()`] and [`eigs`]; [`Error::Argument`] when fewer than k vertices are not held at
/// zero, and when all k eigenvalues would be 0, which all such surfaces have in common.
pub fn shape_dna(mesh: &TriMesh, options: &ShapeDnaOptions<'_>) -> Result<Vec<f64>> {
    let free = free_components(mesh, &options.laplacian.boundary)?;
    if options.k <= free {
        let why = match free {
            0 => "must be at least 1, is 0".into(),
            _ => format!(
                "must be more than {free}, is {}: {free} eigenvalues are zero, one for each \
                 component without a vertex held at zero",
                options.k
            ),
        };
        return Err(Error::Argument { what: "k", why });
    }
    options.progress.watch(|| signature(mesh, options))
}

fn signature(mesh: &TriMesh, options: &ShapeDnaOptions<'_>) -> Result<Vec<f64>> {
    let operator = laplacian(mesh, &options.laplacian)?;
    // The relative error of eigenvalues is about the square of the tolerance.
    let wanted = EigenOptions::new()
        .k(options.k)
        .par(options.laplacian.par)
        .tolerance(1e-6)
        .progress(options.progress);
    let mut values = eigs(operator.stiffness.view(), &operator.mass, &wanted)?.values;
    if options.normalized {
        let area = mesh.area();
        values.iter_mut().for_each(|value| *value *= area);
    }
    Ok(values)
}

/// A signature that [`retrieve`] found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Index of the signature.
    pub index: usize,
    /// Euclidean distance to the signature, in the unit of the signatures.
    pub distance: f64,
}

/// Returns the signatures nearest to `query`, the nearest first (for equal distances, in order of
/// index), at most `count` of them.
///
/// ```
/// use catamaran::Par;
/// use catamaran_geometry::unions::retrieve;
///
/// let found = retrieve(&[1.0, 2.0], &[[5.0, 5.0], [1.0, 2.5]], 1, Par::Seq)?;
/// assert_eq!(found[0].index, 1);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when a signature is not as long as the query; [`Error::NonFinite`] for numbers
/// that are not finite.
pub fn retrieve<S: AsRef<[f64]> + Sync>(
    query: &[f64],
    signatures: &[S],
    count: usize,
    par: Par,
) -> Result<Vec<Match>> {
    let finite = |what, row: usize, values: &[f64]| match values.iter().position(|x| !x.is_finite())
    {
        Some(column) => Err(Error::NonFinite { what, index: (row, column) }),
        None => Ok(()),
    };
    finite("query", 0, query)?;
    for (i, signature) in signatures.iter().enumerate() {
        let signature = signature.as_ref();
        Error::check_shape("signature", (query.len(), 1), (signature.len(), 1))?;
        finite("signature", i, signature)?;
    }
    let distance = |index: usize| {
        let pairs = query.iter().zip(signatures[index].as_ref());
        pairs.map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
    };
    let blocks = par.map_blocks(signatures.len(), BLOCK, |block| {
        block.map(|index| Match { index, distance: distance(index) }).collect::<Vec<_>>()
    });
    let mut found: Vec<Match> = blocks.into_iter().flatten().collect();
    let order =
        |a: &Match, b: &Match| a.distance.total_cmp(&b.distance).then(a.index.cmp(&b.index));
    if count < found.len() {
        found.select_nth_unstable_by(count, order);
        found.truncate(count);
    }
    found.sort_unstable_by(order);
    Ok(found)
}

/// Number of signatures that a thread compares at a time.
const BLOCK: usize = 4096;
