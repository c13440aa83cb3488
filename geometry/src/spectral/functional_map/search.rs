//! Finds a functional map between two meshes of which no correspondence is known.
//!
//! Nearly isometric surfaces have nearly diagonal functional maps: the first eigenfunctions go to
//! those of the target in about the same order, with unknown signs. The search tries signs and
//! orders, refines each map between few samples, and keeps the map that commutes best with the
//! Laplacians among those that keep the orientation (after Ren, Melzi, Ovsjanikov and Wonka,
//! MapTree, 2020; the orientation after Ren, Poulenard, Wonka and Ovsjanikov 2018).

use faer::{Mat, MatRef, Scale};

use super::embedding::{Embedding, far_vertices, of_unit_areas};
use super::fit::MapFit;
use super::orientation::{Rings, correlation};
use super::points::{map_from_points, points_from_map};
use crate::mesh::TriMesh;
use crate::spectral::basis::Basis;
use crate::spectral::eigenbasis::Eigenbasis;
use catamaran::base::{Error, Par, Progress, Result, Tracker};

/// Numbers of samples of each mesh between which maps are refined, and with which they are compared
/// in the end: 200 tell the true map of two bodies from others less well.
const SAMPLES: usize = 200;
const COMPARING: usize = 2000;

/// Number of functions besides the constant whose signs and orders are tried: 256 starts.
const SIGNS: usize = 5;

/// Numbers of functions with which candidates are compared, and with which the search ends; and
/// their increments.
const COMPARED: usize = 20;
const LAST: usize = 40;
const STEPS: [usize; 2] = [2, 3];

/// Samples for each function, at least: fewer do not determine the map.
const SAMPLES_EACH: usize = 4;

/// Number of candidates that are kept after each stage, that are varied, and that are composed.
const KEPT: usize = 16;
const VARIED: usize = 8;
const COMPOSED: usize = 8;

/// Functions (constant: 0) of which one changes its sign in a variation. Among them are the first
/// that tell the front of a body from its back, which signs of earlier functions do not decide.
const FLIPPED: std::ops::Range<usize> = 5..14;

/// Share of the points above which two candidates count as the same map.
const SAME: f64 = 0.5;

/// Correlation of turns above which a map keeps the orientation.
const ORIENTED: f64 = 0.2;

/// Factor of the commutativity below which another map fits almost as well, and above which one
/// fits better.
const CLOSE: f64 = 1.1;

/// Commutativity below which maps fit exactly, up to rounding and sampling: where two do, the
/// surfaces are symmetric. The least of the 55 pairs of the record spectral-thesis is 0.0079.
const EXACT: f64 = 0.002;

/// Commutativity above which the surfaces are no poses of one shape. Of the 55 pairs of the record
/// spectral-thesis, 41 have points that are less than 5 % off: 40 of these pairs are below 0.058,
/// and one pair of dogs is at 0.106. Of the 14 other pairs, 13 are above 0.073.
const FAR: f64 = 0.065;

/// A functional map that was found without known correspondences.
#[derive(Debug, Clone)]
pub struct FoundMap {
    /// The map, k x k, between the first k functions of both bases: at most 40.
    pub map: Mat<f64>,
    /// How far the map is from commuting with the Laplacians ([`commutativity()`]).
    pub commutativity: f64,
    /// Whether the map keeps the orientation: the correlation, from -1 to 1, of `n . (grad f x grad
    /// g)` for pairs of functions on the target and their images.
    pub orientation: f64,
    /// The commutativity of the next best map that keeps the orientation; `None` if there is none.
    pub next: Option<f64>,
    /// The commutativity of the best map that reverses the orientation; `None` if there is none.
    pub mirrored: Option<f64>,
}

impl FoundMap {
    /// Number of functions that [`zoomout`](super::zoomout) may add at a time to this map. A map
    /// that was fitted to fewer functions needs smaller steps.
    pub const STEP: usize = 5;

    /// Computes the map along the points of this one between the functions `low` (source and
    /// target) instead of the first ones of the bases of the search, `all`.
    ///
    /// # Errors
    /// As [`points_from_map`] and [`map_from_points`].
    pub fn between(
        &self,
        low: (&Basis, &Basis),
        all: (&Eigenbasis, &Eigenbasis),
        par: Par,
        progress: Progress<'_>,
    ) -> Result<Mat<f64>> {
        let from = all.0.truncated(self.map.ncols())?;
        let to = all.1.truncated(self.map.nrows())?;
        let points = points_from_map(self.map.as_ref(), from.basis(), to.basis(), par, progress)?;
        map_from_points(&points, low.0, low.1, par)
    }

    /// Returns why another map may be the true one, so that only known correspondences could
    /// decide; `None` where nothing speaks against this one.
    pub fn doubt(&self) -> Option<&'static str> {
        if self.orientation < ORIENTED {
            Some("no map that keeps left and right was found")
        } else if self.next.is_some_and(|next| next < (CLOSE * self.commutativity).max(EXACT)) {
            Some("another map fits almost as well")
        } else if self.mirrored.is_some_and(|mirrored| CLOSE * mirrored < self.commutativity) {
            // On a shape with a left and a right, its mirror image was missed.
            Some("a map that exchanges left and right fits better")
        } else if self.commutativity > FAR {
            Some("the surfaces are far from isometric")
        } else {
            None
        }
    }

    /// Returns whether there is a [`doubt`](Self::doubt).
    pub fn is_ambiguous(&self) -> bool {
        self.doubt().is_some()
    }
}

/// Searches for the functional map of two nearly isometric surfaces, each a mesh and its
/// eigenbasis, without known correspondences. The map keeps the orientation: left stays left.
///
/// The map starts refinements ([`zoomout`](super::zoomout)). Bases of 40 functions or more are
/// best. Meshes with symmetries that keep the orientation have several such maps.
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, functional_map::search_map};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::mesh::families;
///
/// # let mesh = families::figure(2, 0.5)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(20))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// // A mesh to itself.
/// let found = search_map((&mesh, &basis), (&mesh, &basis), Par::Seq, Progress::none())?;
/// assert!(found.commutativity < 1e-3 && found.orientation > 0.9);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when a basis has fewer than 3 functions or does not start with the constant,
/// or a mesh is too small; [`Error::Shape`] when mesh and basis differ in the number of vertices;
/// [`Error::OutOfMemory`]; [`Error::Cancelled`].
pub fn search_map(
    (source_mesh, source): (&TriMesh, &Eigenbasis),
    (target_mesh, target): (&TriMesh, &Eigenbasis),
    par: Par,
    progress: Progress<'_>,
) -> Result<FoundMap> {
    for (what, mesh, basis) in [("source", source_mesh, source), ("target", target_mesh, target)] {
        let (n, rows) = (mesh.vertices().len(), basis.basis().vertices());
        Error::check_shape(what, (n, basis.len()), (rows, basis.len()))?;
        basis.need_constant(what)?;
    }
    let [from, to] = [source_mesh, target_mesh].map(|mesh| far_vertices(mesh, SAMPLES));
    let fewest = from.len().min(to.len()) / SAMPLES_EACH;
    let last = LAST.min(source.len()).min(target.len()).min(fewest);
    if last < 3 {
        let why = format!("needs 3 functions and {} vertices or more", 3 * SAMPLES_EACH);
        return Err(Error::Argument { what: "eigenbasis", why });
    }
    let ratio = target.basis().area()? / source.basis().area()?;
    let search = Search {
        embedding: Embedding::new((source, &from), (target, &to), last)?,
        values: [source.unit_values()?, target.unit_values()?],
        par,
    };
    let compared = COMPARED.min(last);

    let mut starts = signed_orders(SIGNS.min(compared - 1));
    starts.push(by_signatures((source, target), compared, ratio, par)?);
    let mut kept = search.run(starts, compared, STEPS[0], progress.part(0.0..0.4))?;
    let variations = kept.iter().take(VARIED).flat_map(|c| flipped(c.map.as_ref())).collect();
    kept.extend(search.run(variations, compared, STEPS[0], progress.part(0.4..0.8))?);
    kept = distinct(kept);
    let compositions = composed(&kept[..COMPOSED.min(kept.len())]);
    kept.extend(search.run(compositions, compared, STEPS[0], progress.part(0.8..0.85))?);
    let maps = |candidates: Vec<Candidate>| candidates.into_iter().map(|c| c.map).collect();
    let found = search.run(maps(distinct(kept)), last, STEPS[1], progress.part(0.85..0.95))?;

    let [from, to] = [source_mesh, target_mesh].map(|mesh| far_vertices(mesh, COMPARING));
    let embedding = Embedding::new((source, &from), (target, &to), last)?;
    let search = Search { embedding, ..search };
    let found = search.run(maps(found), last, STEPS[1], progress.part(0.95..1.0))?;

    let turning = |i: usize| if i + 1 < last { i + 1 } else { 0 };
    let rings = [Rings::new(source_mesh, &from), Rings::new(target_mesh, &to)];
    let (phi, psi) = (source.functions(), target.functions());
    let own = rings[0].turns(|v| std::array::from_fn(|i| phi[(v as usize, turning(i))]));
    let orientation = |c: &Candidate| {
        let image = |v: u32, i: usize| -> f64 {
            (0..last).map(|l| psi[(v as usize, l)] * c.map[(l, turning(i))]).sum()
        };
        let turns = rings[1].turns(|v| std::array::from_fn(|i| image(v, i)));
        correlation(&turns, &own, &c.points)
    };
    let orientations: Vec<f64> = found.iter().map(orientation).collect();
    let mut oriented = (0..found.len()).filter(|&i| orientations[i] >= ORIENTED);
    let mirrored = (0..found.len()).find(|&i| orientations[i] <= -ORIENTED);
    // Candidates are in ascending order. Where none keeps the orientation, the best of all.
    let best = oriented.next().unwrap_or(0);
    Ok(FoundMap {
        map: Scale(ratio.sqrt()) * &found[best].map,
        commutativity: found[best].defect,
        orientation: orientations[best],
        next: oriented.next().map(|i| found[i].defect),
        mirrored: mirrored.map(|i| found[i].defect),
    })
}

/// A refined map.
struct Candidate {
    map: Mat<f64>,
    /// A sample of the source for each sample of the target.
    points: Vec<u32>,
    defect: f64,
}

struct Search {
    embedding: Embedding,
    /// The eigenvalues of source and target, as if of area 1.
    values: [Vec<f64>; 2],
    par: Par,
}

impl Search {
    /// Refines these maps to `len` functions, and returns the best different ones, ascending.
    fn run(
        &self,
        starts: Vec<Mat<f64>>,
        len: usize,
        step: usize,
        progress: Progress<'_>,
    ) -> Result<Vec<Candidate>> {
        let tracker = Tracker::new(progress, starts.len() as f64);
        let found = self.par.map_blocks(starts.len(), 1, |block| {
            if tracker.state().is_break() {
                return Err(Error::Cancelled);
            }
            let (map, points) = self.embedding.zoom(starts[block.start].clone(), len, step)?;
            let defect = commutativity(map.as_ref(), &self.values[0], &self.values[1])?;
            // The remaining blocks check the state of the tracker.
            let _ = tracker.add(1.0);
            Ok(Candidate { map, points, defect })
        });
        tracker.finish()?;
        Ok(distinct(found.into_iter().collect::<Result<_>>()?))
    }
}

/// Computes how far a functional map c (k' x k) is from commuting with the Laplacians:
/// `|C L - L' C|^2 / |L|^2`, L and L' the first k and k' eigenvalues of source and target, each
/// times the area of its mesh.
///
/// ```
/// use catamaran_geometry::spectral::functional_map::commutativity;
/// use faer::Mat;
///
/// let c = Mat::<f64>::identity(2, 2);
/// assert_eq!(commutativity(c.as_ref(), &[0.0, 2.0], &[0.0, 3.0])?, 0.25);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] unless the source has k eigenvalues, of which one is not 0, and the target
/// has k'.
pub fn commutativity(c: MatRef<'_, f64>, source: &[f64], target: &[f64]) -> Result<f64> {
    let refused = |what, why: String| Err(Error::Argument { what, why });
    for (what, values, needed) in [("source", source, c.ncols()), ("target", target, c.nrows())] {
        if values.len() < needed {
            return refused(
                what,
                format!("{} eigenvalues, where {needed} are needed", values.len()),
            );
        }
    }
    if source[..c.ncols()].iter().all(|&value| value == 0.0) {
        return refused("source", "all eigenvalues are 0".into());
    }
    let (mut sum, mut size) = (0.0, 0.0);
    for j in 0..c.ncols() {
        size += source[j] * source[j];
        for i in 0..c.nrows() {
            sum += (c[(i, j)] * (source[j] - target[i])).powi(2);
        }
    }
    Ok(sum / size)
}

/// Returns the best candidates in ascending order, without those whose points are those of a
/// better one.
fn distinct(mut candidates: Vec<Candidate>) -> Vec<Candidate> {
    candidates.sort_by(|a, b| a.defect.total_cmp(&b.defect));
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in candidates {
        let same = |other: &Candidate| {
            let equal = other.points.iter().zip(&candidate.points).filter(|(x, y)| x == y).count();
            equal as f64 > SAME * candidate.points.len() as f64
        };
        if kept.len() < KEPT && !kept.iter().any(same) {
            kept.push(candidate);
        }
    }
    kept
}

/// Returns the maps that take the first `count` functions after the constant to those of the
/// target, with any signs, in the same order up to exchanges of neighbours.
fn signed_orders(count: usize) -> Vec<Mat<f64>> {
    // The number of exchanges is that of the Fibonacci numbers: bits that have no neighbours.
    let exchanges = (0_u32..1 << count.saturating_sub(1)).filter(|bits| bits & (bits << 1) == 0);
    let order = |bits: u32| {
        let mut order: Vec<usize> = (0..count).collect();
        (1..count).filter(|i| (bits >> (i - 1)) & 1 == 1).for_each(|i| order.swap(i - 1, i));
        order
    };
    let signed = |order: Vec<usize>| {
        (0_u32..1 << count).map(move |signs| {
            let mut c = Mat::zeros(count + 1, count + 1);
            c[(0, 0)] = 1.0;
            for (i, &j) in order.iter().enumerate() {
                c[(i + 1, j + 1)] = if (signs >> i) & 1 == 1 { -1.0 } else { 1.0 };
            }
            c
        })
    };
    exchanges.map(order).flat_map(signed).collect()
}

/// Returns leading blocks of a map, each with the sign of its last row changed.
fn flipped(c: MatRef<'_, f64>) -> Vec<Mat<f64>> {
    let flipped = |j: usize| {
        let mut part = c.submatrix(0, 0, j + 1, j + 1).to_owned();
        (0..=j).for_each(|k| part[(j, k)] = -part[(j, k)]);
        part
    };
    FLIPPED.filter(|&j| j < c.nrows()).map(flipped).collect()
}

/// Returns `A B^T C` of any three of these maps: where A, B and C are the true map after three
/// symmetries of a surface, which map it nearly to itself, the true map is often among them.
fn composed(best: &[Candidate]) -> Vec<Mat<f64>> {
    let mut all = Vec::new();
    for b in 0..best.len() {
        let others: Vec<usize> = (0..best.len()).filter(|&i| i != b).collect();
        for (place, &a) in others.iter().enumerate() {
            for &c in &others[place + 1..] {
                let half = &best[a].map * best[b].map.transpose();
                all.push(&half * &best[c].map);
            }
        }
    }
    all
}

/// Returns the map that fits signatures, which is all that tells points of surfaces apart that are
/// far from isometric.
fn by_signatures(
    (source, target): (&Eigenbasis, &Eigenbasis),
    len: usize,
    ratio: f64,
    par: Par,
) -> Result<Mat<f64>> {
    let few = (source.truncated(len)?, target.truncated(len)?);
    let mut fit = MapFit::new(&few.0, &few.1, par);
    fit.signatures(source, target)?;
    Ok(of_unit_areas(&fit.solve(MapFit::COMMUTATIVITY)?, ratio))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_exchange_neighbours_only_and_all_signs_are_tried() {
        let all = signed_orders(4);
        assert_eq!(all.len(), 5 * 16);
        for c in &all {
            assert!((0..5).all(|j| (0..5).map(|i| c[(i, j)].abs()).sum::<f64>() == 1.0));
            assert!((0..5).all(|i| (0..5).all(|j| c[(i, j)] == 0.0 || i.abs_diff(j) <= 1)));
        }
        assert!((0..all.len()).all(|a| (0..a).all(|b| all[a] != all[b])));
        assert_eq!(signed_orders(1).len(), 2);
    }

    #[test]
    fn four_symmetries_are_compositions_of_three_of_them() {
        let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let map =
            |[x, y]: [f64; 2]| Mat::from_fn(2, 2, |i, j| if i == j { [x, y][i] } else { 0.0 });
        let candidate = |signs| Candidate { map: map(signs), points: vec![], defect: 0.0 };
        let found = composed(&signs[1..].iter().copied().map(candidate).collect::<Vec<_>>());
        assert_eq!(found, vec![map(signs[0]); 3]);
        assert_eq!(composed(&signs.map(candidate)).len(), 12);
        assert!(composed(&[]).is_empty());
    }

    #[test]
    fn eigenvalues_that_are_missing_or_all_zero_are_refused() {
        let c = Mat::<f64>::identity(2, 2);
        let said = |source: &[f64], target: &[f64]| {
            commutativity(c.as_ref(), source, target).unwrap_err().to_string()
        };
        assert_eq!(said(&[0.0], &[0.0, 1.0]), "source: 1 eigenvalues, where 2 are needed");
        assert_eq!(said(&[0.0, 1.0], &[]), "target: 0 eigenvalues, where 2 are needed");
        assert_eq!(said(&[0.0, 0.0], &[0.0, 1.0]), "source: all eigenvalues are 0");
    }

    #[test]
    fn a_variation_is_a_leading_block_with_its_last_row_turned() {
        let c = Mat::from_fn(8, 8, |i, j| (8 * i + j) as f64);
        let found = flipped(c.as_ref());
        assert_eq!(found.len(), 3);
        let expected = Mat::from_fn(6, 6, |i, j| if i == 5 { -c[(i, j)] } else { c[(i, j)] });
        assert_eq!(found[0], expected);
    }
}
