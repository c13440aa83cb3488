//! Repairs the places where the new mesh is farthest from the surface, one after the other.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::closest::{on_boundary, on_surface};
use super::collapse::reduce;
use super::gaps::{Gap, Gaps, Site};
use super::guard::{allows_flip, allows_move};
use super::patch::{Move, Patch, Sides};
use super::quadric::Quadrics;
use crate::mesh::quality;
use crate::mesh::vector::{Vector, distance, dot, sub};
use catamaran::base::{Par, Progress, Result};

/// Number of vertices that one thread processes at a time.
const BLOCK: usize = 128;

/// Size of gaps, stretched and relative to the mean stretched edge, below which they stay.
const FINE: f64 = 0.3;

/// Largest number of vertices at which gaps of sizes within a factor of two are repaired: a share
/// of all vertices, plus a constant.
const TRIES: (f64, usize) = (0.05, 20);

/// Largest number of splits at gaps, whose vertices come from collapses elsewhere: a share of all
/// vertices, plus a constant.
const SPLITS: (f64, usize) = (0.03, 4);

/// Largest gap around a change relative to the gap that it repairs.
const GAIN: f64 = 0.9;

/// Least regularity of faces (see [`quality`]) after a change at the narrowest gap, and half of it
/// at a gap twice as wide. Faces that were less regular before are exempt.
const REGULAR: f64 = 0.4;

/// Number of changes that are tried at a gap: vertices that move, edges that are split.
const MOVES: usize = 4;
const EDGES: usize = 3;

/// Moves vertices and flips edges where the gaps are widest, as long as that narrows them; splits
/// edges where it does not, and collapses short edges elsewhere in exchange.
///
/// # Errors
/// [`Error::Cancelled`](catamaran::base::Error::Cancelled).
pub(super) fn mend(
    gaps: &Gaps<'_, '_>,
    quadrics: &Quadrics<'_, '_>,
    patch: &mut Patch,
    par: Par,
    progress: Progress<'_>,
) -> Result<()> {
    let n = patch.count;
    let least = FINE * patch.mean_length();
    let splits = part(SPLITS, n);
    mend_with(gaps, quadrics, patch, least, splits, par, progress.part(0.0..0.5))?;
    if patch.count > n {
        reduce(patch, n)?;
        mend_with(gaps, quadrics, patch, least, 0, par, progress.part(0.5..1.0))?;
    }
    Ok(())
}

fn part((part, more): (f64, usize), n: usize) -> usize {
    (part * n as f64) as usize + more
}

/// Repairs gaps of stretched size `least`, with at most `splits` splits.
fn mend_with(
    gaps: &Gaps<'_, '_>,
    quadrics: &Quadrics<'_, '_>,
    patch: &mut Patch,
    least: f64,
    mut splits: usize,
    par: Par,
    progress: Progress<'_>,
) -> Result<()> {
    let size_at = |patch: &Patch, v| {
        let stretch = patch.stretch_at(v);
        widest_at(gaps, patch, v, least / stretch).map_or(0.0, |gap| gap.size * stretch)
    };
    let blocks = par.map_blocks(patch.positions().len(), BLOCK, |range| {
        range.map(|v| size_at(patch, v as u32)).collect::<Vec<_>>()
    });
    let mut sizes = blocks.concat();
    // Sizes are not negative, so that their bits have the order of the numbers.
    let key = |size: f64, v: u32| (size.to_bits(), Reverse(v));
    let wide = sizes.iter().zip(0..).filter(|(size, _)| **size > 0.0);
    let mut waiting: BinaryHeap<_> = wide.map(|(&size, v)| key(size, v)).collect();
    let mut tries = part(TRIES, patch.count);
    while let Some((size, Reverse(v))) = waiting.pop() {
        // The number of further gaps is unknown, so the progress serves to cancel only.
        progress.report(0.0)?;
        if sizes[v as usize].to_bits() != size {
            continue; // the gap was repaired or measured again
        }
        if f64::from_bits(size) < 2.0 * least {
            if tries == 0 {
                break;
            }
            tries -= 1;
        }
        sizes[v as usize] = 0.0;
        let stretch = patch.stretch_at(v);
        let Some(gap) = widest_at(gaps, patch, v, least / stretch) else { continue };
        let regular = REGULAR * least / (gap.size * stretch);
        let count = patch.count;
        let mending = Mending { gaps, quadrics, patch, gap, regular }.run(splits > 0);
        let Some(changed) = mending else { continue };
        splits -= patch.count - count;
        sizes.resize(patch.positions().len(), 0.0);
        let mut near: Vec<u32> = changed.iter().flat_map(|&v| patch.neighbours(v)).collect();
        near.extend(changed);
        near.sort_unstable();
        near.dedup();
        for v in near {
            let size = size_at(patch, v);
            sizes[v as usize] = size;
            if size > 0.0 {
                waiting.push(key(size, v));
            }
        }
    }
    Ok(())
}

/// Returns the widest gap above `least` of the cell of v, or of a face whose first corner is v.
fn widest_at(gaps: &Gaps<'_, '_>, patch: &Patch, v: u32, least: f64) -> Option<Gap> {
    if patch.around(v).is_empty() {
        return None;
    }
    let first = patch.around(v).iter().copied().filter(|&f| patch.faces[f as usize][0] == v);
    let of_faces = first.filter_map(|f| gaps.of_face(patch, f, least));
    let all = gaps.of_cell(patch, v, least).into_iter().chain(of_faces);
    all.max_by(|a, b| a.size.total_cmp(&b.size))
}

/// A gap, and the changes that may repair it.
struct Mending<'a, 's> {
    gaps: &'a Gaps<'a, 's>,
    quadrics: &'a Quadrics<'a, 's>,
    patch: &'a mut Patch,
    gap: Gap,
    /// No face becomes less regular than this, unless it was.
    regular: f64,
}

impl Mending<'_, '_> {
    /// Repairs the gap. Returns the vertices that the change concerns; `None` when no change helps.
    fn run(&mut self, may_split: bool) -> Option<Vec<u32>> {
        for v in self.vertices() {
            let here = self.patch.position(v);
            let step = sub(self.gap.on_surface, self.gap.on_patch);
            let along = |part: f64| std::array::from_fn(|k| here[k] + part * step[k]);
            let reach = self.longest_edge(v);
            let sharp = self.quadrics.sharpest(self.patch, v, here, reach);
            let targets = [self.gap.on_surface, along(1.0), sharp, along(1.5)];
            let changed = targets.into_iter().find_map(|target| self.try_move(v, target));
            if changed.is_some() {
                return changed;
            }
        }
        let edges = self.edges();
        let changed = edges.iter().find_map(|&edge| self.try_flip(edge));
        if changed.is_some() || !may_split {
            return changed;
        }
        edges.iter().take(EDGES).find_map(|&edge| self.try_split(edge))
    }

    fn longest_edge(&self, v: u32) -> f64 {
        let lengths = self.patch.neighbours(v).into_iter().map(|w| self.patch.length(v, w));
        lengths.fold(0.0, f64::max)
    }

    /// Returns the vertices that may move, the nearest to the gap first.
    fn vertices(&self) -> Vec<u32> {
        let mut vertices = match self.gap.site {
            Site::Cell(v) => [vec![v], self.patch.neighbours(v)].concat(),
            Site::Face(f) => self.patch.faces[f as usize].to_vec(),
        };
        let away = |v: u32| distance(self.patch.position(v), self.gap.on_patch);
        vertices.sort_by(|&a, &b| away(a).total_cmp(&away(b)));
        vertices.truncate(MOVES);
        vertices
    }

    /// Returns the edges that may flip or split, the nearest to the gap first.
    fn edges(&self) -> Vec<[u32; 2]> {
        let own;
        let faces = match self.gap.site {
            Site::Cell(v) => self.patch.around(v),
            Site::Face(f) => {
                own = [f];
                &own
            }
        };
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for &f in faces {
            let [a, b, c] = self.patch.faces[f as usize];
            edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
        }
        edges.sort_unstable();
        edges.dedup();
        let away = |[a, b]: [u32; 2]| distance(self.patch.middle(a, b), self.gap.on_patch);
        edges.sort_by(|&a, &b| away(a).total_cmp(&away(b)));
        edges
    }

    /// Returns whether the gaps of these faces, and of the cells of these vertices, are now
    /// narrower than the repaired one.
    fn helps(&self, vertices: &[u32], faces: &[u32]) -> bool {
        let limit = GAIN * self.gap.size;
        faces.iter().all(|&f| self.gaps.of_face(self.patch, f, limit).is_none())
            && vertices.iter().all(|&v| self.gaps.of_cell(self.patch, v, limit).is_none())
    }

    fn try_move(&mut self, v: u32, target: Vector) -> Option<Vec<u32>> {
        if self.patch.locked[v as usize] {
            return None;
        }
        let faces = self.patch.around(v).to_vec();
        let least = self.least_quality(&faces);
        let (p, anchor) = self.landing(v, target)?;
        if !self.may_move(v, p, &faces, least) {
            return None;
        }
        let before = (self.patch.position(v), self.patch.anchors[v as usize]);
        self.patch.move_to(v, (p, anchor));
        let mut vertices = self.patch.neighbours(v);
        vertices.push(v);
        if self.helps(&vertices, &faces) {
            return Some(vertices);
        }
        self.patch.move_to(v, before);
        None
    }

    fn try_flip(&mut self, [a, b]: [u32; 2]) -> Option<Vec<u32>> {
        let flip = self.patch.flipped(a, b)?;
        let [c, d, _] = flip.new[0];
        let least = self.least_quality(&flip.old);
        let mut normals = [0.0; 3];
        for f in flip.old {
            let normal = self.patch.normal(self.patch.faces[f as usize]);
            (0..3).for_each(|k| normals[k] += normal[k]);
        }
        let fits = |&face: &[u32; 3]| {
            dot(self.patch.normal(face), normals) > 0.0
                && quality(self.patch.corners_at(face)) >= least
        };
        if !flip.new.iter().all(fits) || !allows_flip(self.patch, &flip) {
            return None;
        }
        self.patch.flip(&flip);
        let vertices = vec![a, b, c, d];
        if self.helps(&vertices, &flip.old) {
            return Some(vertices);
        }
        let back = self.patch.flipped(c, d)?;
        self.patch.flip(&back);
        None
    }

    fn try_split(&mut self, [a, b]: [u32; 2]) -> Option<Vec<u32>> {
        let Sides { first, second } = self.patch.sides(a, b)?;
        let old: Vec<u32> = [Some(first), second].into_iter().flatten().collect();
        let least = self.least_quality(&old);
        let mut vertices = vec![a, b];
        vertices.extend(old.iter().map(|&f| self.patch.opposite(f, a, b)));
        let new = self.patch.split(a, b)?;
        vertices.push(new);
        let faces = self.patch.around(new).to_vec();
        let before = (self.patch.position(new), self.patch.anchors[new as usize]);
        let step = sub(self.gap.on_surface, self.gap.on_patch);
        let beside = std::array::from_fn(|k| before.0[k] + step[k]);
        for target in [self.gap.on_surface, beside] {
            let Some((p, anchor)) = self.landing(new, target) else { continue };
            if !self.may_move(new, p, &faces, least) {
                continue;
            }
            self.patch.move_to(new, (p, anchor));
            if self.helps(&vertices, &faces) {
                return Some(vertices);
            }
            self.patch.move_to(new, before);
        }
        // Collapsed into the end that restores the original faces.
        let end = self.patch.position(b);
        self.patch.collapse(new, b, end);
        None
    }

    /// Returns the position to which v may move near `target`, and its anchor there.
    fn landing(&self, v: u32, target: Vector) -> Option<Move> {
        if self.patch.on_boundary[v as usize] {
            let anchor = self.patch.anchors[v as usize];
            let found = on_boundary(self.gaps.surface, anchor, target)?;
            return Some((found.point, found.vertex));
        }
        let found = on_surface(self.gaps.surface, self.gap.near, target)?;
        (found.square.sqrt() < GAIN * self.gap.size).then_some((target, found.vertex))
    }

    /// Returns whether v, which has these faces, may move to p: the faces stay upright and as
    /// regular as `least`, and create no new intersections.
    fn may_move(&self, v: u32, p: Vector, faces: &[u32], least: f64) -> bool {
        let moved = |f: u32| self.patch.corners_with(self.patch.faces[f as usize], [v, v], p);
        self.patch.stays_upright(v, None, p)
            && faces.iter().all(|&f| quality(moved(f)) >= least)
            && allows_move(self.patch, v, p)
    }

    /// Returns the least regularity of faces that replace these.
    fn least_quality(&self, faces: &[u32]) -> f64 {
        faces.iter().map(|&f| quality(self.patch.corners_of(f))).fold(self.regular, f64::min)
    }
}
