//! Random regions.

use catamaran::Result;
use catamaran::base::Rng;
use catamaran_geometry::mesh::Edges;

use super::regions::{Mask, Surface};

/// Range of a region's share of the area.
const SHARES: [f64; 2] = [0.08, 0.6];

/// Number of attempts per region.
const ATTEMPTS: usize = 20;

/// Draws up to `count` regions, in turn a ball, a union of segments, if there are any, and a half
/// space. No two are equal or mirror images of each other.
pub(super) fn regions(
    surface: &Surface<'_>,
    segments: &[u32],
    count: usize,
    rng: &mut Rng,
) -> Result<Vec<Mask>> {
    let touching = touching(surface, segments);
    let mut found: Vec<Mask> = Vec::new();
    for attempt in 0..ATTEMPTS * count {
        if found.len() == count {
            break;
        }
        let raw = match attempt % 3 {
            0 => ball(surface, rng)?,
            1 if !segments.is_empty() => segment_union(segments, &touching, rng),
            _ => half_space(surface, rng),
        };
        let mask = surface.smoothed(&surface.largest_piece(&raw));
        let share = surface.share(&mask);
        let other = surface.mirrored(&mask);
        if (SHARES[0]..=SHARES[1]).contains(&share)
            && !found.iter().any(|old| *old == mask || *old == other)
        {
            found.push(mask);
        }
    }
    Ok(found)
}

/// Returns a geodesic ball with a random share of the area.
fn ball(surface: &Surface<'_>, rng: &mut Rng) -> Result<Mask> {
    let centre = below(surface.len(), rng) as u32;
    let share = SHARES[0] + (SHARES[1] - SHARES[0]) * rng.uniform();
    let distances = surface.distances(centre)?;
    let mut order: Vec<usize> = (0..surface.len()).collect();
    order.sort_by(|&a, &b| distances[a].total_cmp(&distances[b]));
    let goal = share * surface.areas.iter().sum::<f64>();
    let mut mask = vec![false; surface.len()];
    let mut area = 0.0;
    for v in order {
        if area >= goal {
            break;
        }
        area += surface.areas[v];
        mask[v] = true;
    }
    Ok(mask)
}

/// Returns a connected union of segments.
fn segment_union(segments: &[u32], touching: &[Vec<u32>], rng: &mut Rng) -> Mask {
    let mut inside = vec![false; touching.len()];
    let mut edge = vec![below(touching.len(), rng) as u32];
    let wanted = 1 + below(touching.len().div_ceil(2), rng);
    for _ in 0..wanted {
        if edge.is_empty() {
            break;
        }
        let next = edge.swap_remove(below(edge.len(), rng));
        inside[next as usize] = true;
        let more = touching[next as usize].iter();
        edge.extend(more.filter(|&&s| !inside[s as usize]));
        edge.retain(|&s| !inside[s as usize]);
    }
    segments.iter().map(|&s| inside[s as usize]).collect()
}

/// Returns one side of a plane through a vertex.
fn half_space(surface: &Surface<'_>, rng: &mut Rng) -> Mask {
    let normal = std::array::from_fn(|_| 2.0 * rng.uniform() - 1.0);
    let p = surface.mesh.vertices()[below(surface.len(), rng)];
    let offset = (0..3).map(|k| normal[k] * p[k]).sum();
    surface.mesh.half_space(normal, offset)
}

/// Returns, for each segment, the segments that touch it.
fn touching(surface: &Surface<'_>, segments: &[u32]) -> Vec<Vec<u32>> {
    let count = segments.iter().max().map_or(0, |&s| s as usize + 1);
    let mut touching = vec![vec![]; count];
    if segments.is_empty() {
        return touching;
    }
    for &[a, b] in Edges::new(surface.mesh).ends() {
        let [a, b] = [a, b].map(|v| segments[v as usize]);
        if a != b && !touching[a as usize].contains(&b) {
            touching[a as usize].push(b);
            touching[b as usize].push(a);
        }
    }
    touching
}

/// Returns a random number from 0 to n - 1.
pub(crate) fn below(n: usize, rng: &mut Rng) -> usize {
    ((rng.uniform() * n as f64) as usize).min(n.saturating_sub(1))
}
