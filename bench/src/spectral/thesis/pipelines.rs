//! The ways from two meshes to transferred functions.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran::faer::{Mat, MatRef};
use catamaran_geometry::spectral::functional_map::{
    FoundMap, MapFit, commutativity, map_from_points, pull_back, search_map, zoomout,
};
use catamaran_geometry::spectral::{Eigenbasis, Transfer};

use crate::Result;
use crate::spectral::shapes::Pair;
use crate::spectral::transfer::{Bases, fitted, landmarks};

/// Eigenfunctions at the end of ZoomOut, the constant included: the default of `transfer --zoom`.
const ZOOM: usize = 100;

/// The columns without landmarks: all along the points that `transfer A B` finds.
pub const SEARCHED: [&str; 6] = ["K", "prods", "ours", "ours*", "NK", "pull-back"];

/// The columns with landmarks: by the thesis' map (multiplications, then ICP), and along ZoomOut's
/// points of `transfer --landmarks`.
pub const LANDMARKED: [&str; 8] =
    ["K", "prods", "ours", "ours*", "NK", "ours, ZoomOut", "ours*, ZoomOut", "pull-back"];

/// Returns the error of transferred functions, from the functions on the source.
pub type Measure<'a> = &'a dyn Fn(MatRef<'_, f64>, &Mat<f64>) -> Result<f64>;

/// The map that a search found.
#[derive(Debug, Clone)]
pub struct Found {
    /// Its distance from commuting with the Laplacians, that of the next best map, and its
    /// orientation.
    pub commutativity: f64,
    /// As [`FoundMap::next`].
    pub next: Option<f64>,
    /// As [`FoundMap::orientation`].
    pub orientation: f64,
    /// Whether `transfer A B` warns.
    pub is_ambiguous: bool,
    /// A vertex of the source for each of the target.
    pub points: Vec<u32>,
}

/// Finds points as `transfer A B` does.
///
/// # Errors
/// The errors of the library.
pub fn searched(pair: &Pair) -> Result<Found> {
    let (source, target) = both(pair, ZOOM - 1)?;
    let meshes = (&pair.source.mesh, &pair.target.mesh);
    let (par, progress) = (Par::all(), Progress::none());
    let found = search_map((meshes.0, &source), (meshes.1, &target), par, progress)?;
    let c = found.map.as_ref();
    let refined = zoomout(c, source.basis(), target.basis(), FoundMap::STEP, par, progress)?;
    Ok(Found {
        commutativity: found.commutativity,
        next: found.next,
        orientation: found.orientation,
        is_ambiguous: found.is_ambiguous(),
        points: refined.points,
    })
}

/// Finds points as `transfer A B --landmarks FILE` does with these numbers of eigenfunctions.
///
/// # Errors
/// The errors of the library.
pub fn landmarked(pair: &Pair, [k, l]: [usize; 2]) -> Result<Vec<u32>> {
    let (source, target) = both(pair, ZOOM - 1)?;
    let low = (source.truncated(k + 1)?, target.truncated(l + 1)?);
    let par = Par::all();
    let mut fit = MapFit::new(&low.0, &low.1, par);
    fit.landmarks(&landmarks(pair))?;
    fit.signatures(&source, &target)?;
    let c = fit.solve(MapFit::COMMUTATIVITY)?;
    let bases = (source.basis(), target.basis());
    Ok(zoomout(c.as_ref(), bases.0, bases.1, 1, par, Progress::none())?.points)
}

/// Returns the first `k` eigenfunctions of both meshes, and the constant.
fn both(pair: &Pair, k: usize) -> Result<(Eigenbasis, Eigenbasis)> {
    Ok((pair.source.first(k)?, pair.target.first(k)?))
}

/// Computes the errors of [`SEARCHED`] along these points, a row for each of the functions.
///
/// # Errors
/// The errors of the library.
pub fn along(
    pair: &Pair,
    bases: &Bases,
    (order, [k, l]): (usize, [usize; 2]),
    points: &[u32],
    (functions, error): (&[Mat<f64>], Measure<'_>),
) -> Result<Vec<Vec<f64>>> {
    let par = Par::all();
    let mut ways = bases.along(points)?;
    let (more, more_target) = (pair.source.first(order * k)?, pair.target.first(order * l)?);
    let c = map_from_points(points, more.basis(), more_target.basis(), par)?;
    let more = Transfer::new(more.basis(), more_target.basis(), c)?;
    let row = |f: &Mat<f64>| -> Result<Vec<f64>> {
        let f = f.as_ref();
        let [eigen, prods, ours, star] = ways.all(f)?;
        let all = [eigen, prods, ours, star, more.apply(f, par)?, pull_back(points, f)?];
        all.iter().map(|g| error(f, g)).collect()
    };
    functions.iter().map(row).collect()
}

/// Computes the errors of [`LANDMARKED`], along these points of ZoomOut, a row for each of the
/// functions.
///
/// # Errors
/// The errors of the library.
pub fn from_landmarks(
    pair: &Pair,
    bases: &Bases,
    (order, [k, l]): (usize, [usize; 2]),
    points: &[u32],
    (functions, error): (&[Mat<f64>], Measure<'_>),
) -> Result<Vec<Vec<f64>>> {
    let par = Par::all();
    let (source, target) = bases.eigenbases();
    let mut ways = bases.by(fitted(pair, source, target)?.as_ref())?;
    let (more, more_target) = (pair.source.first(order * k)?, pair.target.first(order * l)?);
    let c = fitted(pair, &more, &more_target)?;
    let more = Transfer::new(more.basis(), more_target.basis(), c)?;
    let zoomed = bases.along(points)?;
    let row = |f: &Mat<f64>| -> Result<Vec<f64>> {
        let f = f.as_ref();
        let [eigen, prods, ours, star] = ways.all(f)?;
        let again = [zoomed.ours.apply(f, par)?, zoomed.ours_star.apply(f, par)?];
        let by_map = [eigen, prods, ours, star, more.apply(f, par)?];
        let pulled = [pull_back(points, f)?];
        by_map.iter().chain(&again).chain(&pulled).map(|g| error(f, g)).collect()
    };
    functions.iter().map(row).collect()
}

/// Returns the mean distance of these points from the true ones, where these are known, in space,
/// on surfaces of area 1.
pub fn distance(pair: &Pair, points: &[u32]) -> f64 {
    let position = |v: u32| pair.source.mesh.vertices()[v as usize];
    let apart = |&y: &u32| {
        let (p, q) = (position(points[y as usize]), position(pair.truth[y as usize]));
        (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
    };
    pair.known.iter().map(apart).sum::<f64>() / pair.known.len().max(1) as f64
}

/// Returns how far the map along the true points is from commuting with the Laplacians, between as
/// many functions as a search compares in the end; `None` where not all points are known.
///
/// # Errors
/// The errors of the library.
pub fn true_commutativity(pair: &Pair) -> Result<Option<f64>> {
    if pair.known.len() < pair.truth.len() {
        return Ok(None);
    }
    let (source, target) = both(pair, 39)?;
    let c = map_from_points(&pair.truth, source.basis(), target.basis(), Par::all())?;
    Ok(Some(commutativity(c.as_ref(), source.values(), target.values())?))
}
