use catamaran::{Error, Par, Result};
use catamaran_geometry::mesh::{LaplacianOptions, TriMesh, vertex_areas};
use catamaran_geometry::unions::PartSpectra;

use crate::cuts::{Mask, Surface, no_pair, union};
use crate::dataset::{EIGENVALUES, Spectrum};
use crate::train::Pair;

/// The axes of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// The coordinate axis of the height, 0 to 2.
    pub up: usize,
    /// The coordinate axis of the stretched arms.
    pub side: usize,
}

/// A part: the vertices within ranges of the height and of the span of the arms, as shares.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Window {
    height: [f64; 2],
    span: [f64; 2],
}

/// A way to cut a shape into two overlapping parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyCut {
    /// Names of the parts.
    pub name: &'static str,
    /// Whether the two spectra determine the union among those of a human. They do not if one part
    /// can be mirrored and the union then differs; data sets contain no such pairs.
    pub clear: bool,
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Windows([Window; 2]),
    /// A geodesic ball around the highest vertex with the first share of the area, and the
    /// complement of the ball with the second share.
    Ball([f64; 2]),
}

const ALL: [f64; 2] = [0.0, 1.0];

const fn windows(name: &'static str, clear: bool, parts: [[[f64; 2]; 2]; 2]) -> BodyCut {
    let [[first_height, first_span], [second_height, second_span]] = parts;
    let first = Window { height: first_height, span: first_span };
    let second = Window { height: second_height, span: second_span };
    BodyCut { name, clear, kind: Kind::Windows([first, second]) }
}

/// Cuts of people with stretched arms. Unless a cut is ambiguous, one part is its own mirror image.
pub const BODY_CUTS: [BodyCut; 7] = [
    windows("lower and upper half", true, [[[0.0, 0.58], ALL], [[0.42, 1.0], ALL]]),
    windows("upper half; middle of the span", true, [[[0.5, 1.0], ALL], [ALL, [0.2, 0.65]]]),
    windows("legs; torso", true, [[[0.0, 0.55], ALL], [[0.42, 0.86], [0.38, 0.62]]]),
    windows(
        "head, torso and one arm; legs and torso",
        true,
        [[[0.45, 1.0], [0.38, 1.0]], [[0.0, 0.7], [0.38, 0.62]]],
    ),
    windows("one side; legs", true, [[ALL, [0.47, 1.0]], [[0.0, 0.5], ALL]]),
    BodyCut { name: "ball about the head; the rest", clear: true, kind: Kind::Ball([0.2, 0.06]) },
    windows("left and right half", false, [[ALL, [0.44, 1.0]], [ALL, [0.0, 0.56]]]),
];

impl BodyCut {
    pub(super) fn parts(&self, surface: &Surface<'_>, frame: Frame) -> Result<[Mask; 2]> {
        let vertices = surface.mesh.vertices();
        let bounds = surface.mesh.bounding_box().unwrap_or_default();
        let share = |v: usize, axis: usize| {
            (vertices[v][axis] - bounds[0][axis]) / (bounds[1][axis] - bounds[0][axis])
        };
        let every = 0..vertices.len();
        let raw: [Mask; 2] = match self.kind {
            Kind::Windows(parts) => parts.map(|Window { height, span }| {
                let within = |[low, high]: [f64; 2], x: f64| (low..=high).contains(&x);
                let inside =
                    |v| within(height, share(v, frame.up)) && within(span, share(v, frame.side));
                every.clone().map(inside).collect()
            }),
            Kind::Ball(shares) => {
                let height = |v: usize| vertices[v][frame.up];
                let top = every.clone().max_by(|&v, &w| height(v).total_cmp(&height(w)));
                let distances = surface.distances(top.unwrap_or(0) as u32)?;
                let radii = shares.map(|share| radius(&distances, &surface.areas, share));
                let ball = distances.iter().map(|&d| d <= radii[0]).collect();
                [ball, distances.iter().map(|&d| d >= radii[1]).collect()]
            }
        };
        Ok(raw.map(|mask| surface.largest_piece(&mask)))
    }
}

/// Computes the spectra of two parts of a shape and of their union.
///
/// # Errors
/// [`Error::Argument`] when the parts are not a pair as in data sets: they have too few common
/// vertices, too few interior vertices, or one adds too little; those of [`PartSpectra`].
fn pair(surface: &Surface<'_>, spectra: &PartSpectra<'_>, [a, b]: &[Mask; 2]) -> Result<Pair> {
    let all = union(a, b);
    if let Some(why) = no_pair(surface, [a, b], &all) {
        return Err(Error::Argument { what: "parts", why: why.into() });
    }
    let spectrum = |mask: &Mask| -> Result<Spectrum> {
        let values = spectra.dirichlet(mask, EIGENVALUES)?;
        Ok(std::array::from_fn(|i| values[i]))
    };
    let (first, second, union) = (spectrum(a)?, spectrum(b)?, spectrum(&all)?);
    Ok(Pair { first, second, union, regions: None })
}

/// Returns the distance within which the given share of the area lies.
fn radius(distances: &[f64], areas: &[f64], share: f64) -> f64 {
    let mut order: Vec<usize> = (0..distances.len()).collect();
    order.sort_by(|&v, &w| distances[v].total_cmp(&distances[w]));
    let goal = share * areas.iter().sum::<f64>();
    let mut area = 0.0;
    let reached = order.into_iter().find(|&v| {
        area += areas[v];
        area >= goal
    });
    reached.map_or(0.0, |v| distances[v])
}

/// Cuts a shape in each way of [`BODY_CUTS`]; returns the spectra of each pair, or why it has none.
///
/// # Errors
/// Those of [`HeatMethod`](catamaran_geometry::mesh::HeatMethod) and [`PartSpectra::new`].
pub fn body_pairs(
    mesh: &TriMesh,
    frame: Frame,
    par: Par,
) -> Result<Vec<(&'static BodyCut, Result<Pair>)>> {
    let parts = body_parts(mesh, frame, par)?;
    Ok(BODY_CUTS.iter().zip(part_pairs(mesh, &parts, par)?).collect())
}

/// Cuts a shape in each way of [`BODY_CUTS`]; returns the parts of each.
///
/// # Errors
/// Those of [`HeatMethod`](catamaran_geometry::mesh::HeatMethod).
pub fn body_parts(mesh: &TriMesh, frame: Frame, par: Par) -> Result<Vec<[Mask; 2]>> {
    let mirror = itself(mesh);
    let surface = Surface::new(mesh, &mirror, par)?;
    BODY_CUTS.iter().map(|cut| cut.parts(&surface, frame)).collect()
}

/// Computes the spectra of pairs of parts, of each part those of its largest piece; returns why
/// parts are no pair otherwise.
///
/// # Errors
/// As [`body_pairs`].
pub fn part_pairs(mesh: &TriMesh, parts: &[[Mask; 2]], par: Par) -> Result<Vec<Result<Pair>>> {
    let mirror = itself(mesh);
    let surface = Surface::new(mesh, &mirror, par)?;
    let spectra = PartSpectra::new(mesh, &LaplacianOptions::new().par(par))?;
    let of = |parts: &[Mask; 2]| {
        pair(&surface, &spectra, &parts.each_ref().map(|part| surface.largest_piece(part)))
    };
    Ok(parts.iter().map(of).collect())
}

/// Returns the mirror image of each vertex where none is known: the cuts of real shapes are not
/// mirrored.
fn itself(mesh: &TriMesh) -> Vec<u32> {
    (0..mesh.vertices().len() as u32).collect()
}

/// Returns how far the union of two parts changes if the second part is mirrored, which spectra do
/// not tell: the area that belongs to only one of both unions, as a share of the area of the shape.
/// The smaller share of the union and its mirror image counts. `mirror` has the mirror image of
/// each vertex.
pub fn mirrored_union(mesh: &TriMesh, mirror: &[u32], [a, b]: &[Mask; 2]) -> f64 {
    let areas = vertex_areas(mesh);
    let mirrored = |mask: &Mask| -> Mask { mirror.iter().map(|&v| mask[v as usize]).collect() };
    let (all, other) = (union(a, b), union(a, &mirrored(b)));
    let apart = |all: &Mask| -> f64 {
        (0..areas.len()).filter(|&v| all[v] != other[v]).map(|v| areas[v]).sum()
    };
    apart(&all).min(apart(&mirrored(&all))) / areas.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cuts::canonical;
    use crate::families::{Family, Model};

    const FRAME: Frame = Frame { up: 2, side: 0 };

    #[test]
    fn cuts_that_are_clear_have_the_union_that_data_sets_keep() {
        let model = Model::new(Family::Humanoid, 2500).unwrap();
        let surface = Surface::new(model.template(), model.mirror(), Par::all()).unwrap();
        for cut in &BODY_CUTS {
            let [a, b] = cut.parts(&surface, FRAME).unwrap();
            let all = union(&a, &b);
            let kept = canonical(&surface, &a, &b).map(|[a, b]| union(&a, &b));
            let same = kept.is_some_and(|kept| kept == all || kept == surface.mirrored(&all));
            assert_eq!(same, cut.clear, "{}", cut.name);
        }
    }

    #[test]
    fn unions_have_smaller_eigenvalues_and_what_cannot_be_cut_is_refused() {
        let model = Model::new(Family::Humanoid, 2500).unwrap();
        let pairs = body_pairs(model.template(), FRAME, Par::all()).unwrap();
        assert_eq!(pairs.len(), BODY_CUTS.len());
        for (cut, pair) in pairs {
            let Pair { first, second, union, .. } = pair.unwrap();
            for i in 0..EIGENVALUES {
                assert!(union[i] <= first[i].min(second[i]) * (1.0 + 1e-6), "{}", cut.name);
            }
        }
        let small = catamaran_geometry::mesh::families::icosphere(1).unwrap();
        let pairs = body_pairs(&small, FRAME, Par::all()).unwrap();
        assert!(pairs.iter().all(|(_, pair)| matches!(pair, Err(Error::Argument { .. }))));
    }

    #[test]
    fn cuts_that_are_clear_have_the_same_union_if_a_part_is_mirrored() {
        let model = Model::new(Family::Humanoid, 2500).unwrap();
        let mesh = model.template();
        for (cut, parts) in BODY_CUTS.iter().zip(body_parts(mesh, FRAME, Par::all()).unwrap()) {
            let change = mirrored_union(mesh, model.mirror(), &parts);
            assert_eq!(change < 0.01, cut.clear, "{}: {change}", cut.name);
        }
    }

    #[test]
    fn only_the_largest_piece_of_a_part_counts() {
        let model = Model::new(Family::Humanoid, 2500).unwrap();
        let mesh = model.template();
        let mut parts = body_parts(mesh, FRAME, Par::all()).unwrap();
        let lowest = (0..mesh.vertices().len())
            .min_by(|&v, &w| mesh.vertices()[v][2].total_cmp(&mesh.vertices()[w][2]))
            .unwrap();
        // The upper half, and a vertex of a foot.
        assert!(!std::mem::replace(&mut parts[0][1][lowest], true));
        let pairs = part_pairs(mesh, &parts[..1], Par::all()).unwrap();
        let (_, expected) = body_pairs(mesh, FRAME, Par::all()).unwrap().remove(0);
        assert_eq!(pairs[0].as_ref().unwrap(), &expected.unwrap());
    }

    #[test]
    fn a_ball_has_its_share_of_the_area() {
        let distances = [3.0, 1.0, 0.0, 2.0];
        let areas = [1.0, 2.0, 1.0, 4.0];
        let found = [0.1, 0.2, 0.5, 1.0].map(|share| radius(&distances, &areas, share));
        assert_eq!(found, [0.0, 1.0, 2.0, 3.0]);
    }
}
