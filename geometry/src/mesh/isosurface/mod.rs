//! Extracts surfaces of regions in space from values on a lattice, by marching tetrahedra.
//!
//! Each cell of the lattice is cut into six tetrahedra along its diagonal from the lowest to the
//! highest corner (Kuhn's triangulation, whose tetrahedra fit together across cells). A tetrahedron
//! with corners on both sides holds one or two triangles of the surface, whose corners are on its
//! edges. There are no ambiguous cases: the surface is a manifold for any values, closed except
//! where it ends at the border of an open lattice (A. Doi and A. Koide, "An efficient method of
//! triangulating equi-valued surfaces by using tetrahedral cells", IEICE Transactions E74, 1991).

mod lattice;
mod march;
#[cfg(test)]
mod tests;

pub use lattice::{Lattice, Rim};
use march::{Crossing, March};

use super::TriMesh;
use catamaran::base::{Error, Par, Progress, Result, reserved};

/// Returns the surface of the region where `values`, interpolated linearly between the points of
/// `lattice`, exceed `level`; faces are counter-clockwise as seen from outside.
///
/// A vertex is at least 1/1024 of its lattice edge away from the ends of the edge, so that no face
/// vanishes where values equal `level`. The result is the same for any number of threads.
///
/// ```
/// use catamaran_geometry::mesh::{Edges, Lattice, Rim, isosurface};
/// use catamaran::{Par, base::Progress};
///
/// // A ball of radius 1 in a box of side 3.
/// let lattice = Lattice { counts: [31; 3], origin: [-1.5; 3], step: [0.1; 3] };
/// let square = |i: usize| (0.1 * i as f32 - 1.5).powi(2);
/// let at = |n: usize| 1.0 - square(n % 31) - square(n / 31 % 31) - square(n / 961);
/// let values: Vec<f32> = (0..31 * 31 * 31).map(at).collect();
/// let ball = isosurface(&lattice, &values, 0.0, Rim::Closed, Par::all(), Progress::none())?;
/// ball.require_closed()?;
/// assert_eq!(ball.euler_characteristic(&Edges::new(&ball)), 2);
/// assert!((ball.volume().unwrap() - 4.19).abs() < 0.05);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when there are not as many values as points; [`Error::NonFinite`] names a value
/// (row 0, its number) that is not a number; [`Error::Argument`] for such a level, and for a
/// lattice with no points along an axis, or with only one (with [`Rim::Open`]), with steps that are
/// not positive, or of more points or vertices than 2^32 - 1; [`Error::OutOfMemory`];
/// [`Error::Cancelled`].
pub fn isosurface(
    lattice: &Lattice,
    values: &[f32],
    level: f32,
    rim: Rim,
    par: Par,
    progress: Progress<'_>,
) -> Result<TriMesh> {
    lattice.check(values.len(), "values")?;
    if level.is_nan() {
        return Err(Error::Argument { what: "level", why: "must not be NaN".into() });
    }
    if let Some(i) = values.iter().position(|x| x.is_nan()) {
        return Err(Error::NonFinite { what: "values", index: (0, i) });
    }
    let inside = |i: usize| values[i] > level;
    let march = March::new(lattice, rim, &inside, par, progress.part(0.0..0.9))?;
    let share = |crossing: &Crossing| {
        let [from, to] = crossing.points.map(|i| f64::from(values[i]));
        // An infinite value has its border halfway.
        let share = (f64::from(level) - from) / (to - from);
        if share.is_finite() { share.clamp(1.0 / 1024.0, 1023.0 / 1024.0) } else { 0.5 }
    };
    let shares: Vec<f64> =
        march.crossings().map(|c| if c.capped { 0.5 } else { share(&c) }).collect();
    march.mesh(&shares, progress.part(0.9..1.0))
}

/// Returns the surface of the region of the points whose label is `label`; vertices are halfway
/// between points with the label and points without it. [`label_surface_by`] locates the border
/// between points more precisely.
///
/// ```
/// use catamaran_geometry::mesh::{Lattice, Rim, label_surface};
/// use catamaran::{Par, base::Progress};
///
/// let lattice = Lattice { counts: [2, 1, 1], origin: [0.5; 3], step: [1.0; 3] };
/// let half = label_surface(&lattice, &[4, 7], 7, Rim::Closed, Par::Seq, Progress::none())?;
/// half.require_closed()?;
/// let [low, high] = half.bounding_box().unwrap();
/// assert_eq!((low, high), ([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`isosurface`], except that labels have no invalid values.
pub fn label_surface(
    lattice: &Lattice,
    labels: &[u16],
    label: u16,
    rim: Rim,
    par: Par,
    progress: Progress<'_>,
) -> Result<TriMesh> {
    lattice.check(labels.len(), "labels")?;
    let inside = |i: usize| labels[i] == label;
    let march = March::new(lattice, rim, &inside, par, progress.part(0.0..0.9))?;
    let shares = vec![0.5; march.crossings().len()];
    march.mesh(&shares, progress.part(0.9..1.0))
}

/// Number of bisections of an edge: its crossing is known to 1/512 of its length.
const HALVINGS: u32 = 8;

/// Returns the same surface as [`label_surface`], with vertices on the border itself, to 1/512 of
/// the distance of points. The function calls `label_at` for the labels of many points in space at
/// a time, and bisects edges of the lattice eight times.
///
/// ```
/// use catamaran_geometry::mesh::{Lattice, Rim, label_surface_by};
/// use catamaran::{Par, base::Progress};
///
/// let label = |p: &[f64; 3]| u16::from(p.iter().map(|x| x * x).sum::<f64>() < 1.0);
/// let label_at = |points: &[[f64; 3]]| Ok(points.iter().map(label).collect());
/// let lattice = Lattice { counts: [9; 3], origin: [-1.2; 3], step: [0.3; 3] };
/// let points = lattice.points();
/// let labels: Vec<u16> = points.iter().map(label).collect();
/// let (par, none) = (Par::all(), Progress::none());
/// let ball = label_surface_by(&lattice, &labels, 1, Rim::Closed, label_at, par, none)?;
/// let radius = |p: &[f64; 3]| p.iter().map(|x| x * x).sum::<f64>().sqrt();
/// assert!(ball.vertices().iter().all(|p| (radius(p) - 1.0).abs() < 0.3 * 1.74 / 512.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`label_surface`], those of `label_at`, and [`Error::Shape`] when it returns a wrong number
/// of labels.
pub fn label_surface_by(
    lattice: &Lattice,
    labels: &[u16],
    label: u16,
    rim: Rim,
    label_at: impl FnMut(&[[f64; 3]]) -> Result<Vec<u16>>,
    par: Par,
    progress: Progress<'_>,
) -> Result<TriMesh> {
    lattice.check(labels.len(), "labels")?;
    let inside = |i: usize| labels[i] == label;
    let march = March::new(lattice, rim, &inside, par, progress.part(0.0..0.4))?;
    let is_label = |i: usize| labels[i] == label;
    let shares = halved(&march, is_label, label, label_at, progress.part(0.4..0.9))?;
    march.mesh(&shares, progress.part(0.9..1.0))
}

/// Returns the position of each crossing along its edge.
fn halved(
    march: &March<'_>,
    inside: impl Fn(usize) -> bool,
    label: u16,
    mut label_at: impl FnMut(&[[f64; 3]]) -> Result<Vec<u16>>,
    progress: Progress<'_>,
) -> Result<Vec<f64>> {
    let count = march.crossings().len();
    let (mut shares, mut points) = (reserved(count)?, reserved(count)?);
    shares.resize(count, 0.5);
    let free = || march.crossings().enumerate().filter(|(_, crossing)| !crossing.capped);
    let mut width = 0.25;
    for halving in 0..HALVINGS {
        points.clear();
        points.extend(free().map(|(i, crossing)| march.between(&crossing, shares[i])));
        let found = label_at(&points)?;
        Error::check_shape("labels of points", (points.len(), 1), (found.len(), 1))?;
        for ((i, crossing), found) in free().zip(found) {
            // A point with the label of the start of the edge lies before the border.
            let same = (found == label) == inside(crossing.points[0]);
            shares[i] += if same { width } else { -width };
        }
        width /= 2.0;
        progress.report(f64::from(halving + 1) / f64::from(HALVINGS))?;
    }
    Ok(shares)
}
