//! Moves vertices off the surface, so that the faces do not all lie on one side of it.

use super::closest::on_surface;
use super::guard::move_all;
use super::patch::Patch;
use super::surface::Surface;
use crate::mesh::vector::{Vector, dot, scale, sub, unit};
use catamaran::base::{Par, Result};

/// Number of vertices or faces that one thread processes at a time.
const BLOCK: usize = 512;

/// Share of the height of the surface above the surrounding faces by which a vertex is raised. For
/// a sphere, the mean square distance in both directions is least at 3/8 of the height above the
/// middles of faces; in measurements, it is least at 1/2.
const PART: f64 = 0.5;

/// Operations that finding the height of a face is equal to.
const MEASURED: f64 = 5000.0;

/// Raises all vertices except those on the boundary and locked ones by a share of the mean height
/// of the surface above the surrounding faces.
pub(super) fn fit(surface: &Surface<'_>, patch: &mut Patch, par: Par) -> Result<()> {
    let operations = MEASURED * BLOCK as f64;
    let heights = par.map_blocks_asking(patch.faces.len(), BLOCK, operations, |range| {
        range.map(|f| height(surface, patch, f)).collect::<Vec<_>>()
    })?;
    let heights = heights.concat();
    let raised = par.map_blocks(patch.positions().len(), BLOCK, |range| {
        let to = range.map(|v| Some((raised(patch, v as u32, &heights)?, patch.anchors[v])));
        to.collect::<Vec<_>>()
    });
    move_all(patch, &raised.concat(), par);
    Ok(())
}

/// Returns the height of the surface above the middle of a face, along its normal.
fn height(surface: &Surface<'_>, patch: &Patch, face: usize) -> f64 {
    let Some(corners) = patch.face(face) else { return 0.0 };
    let [a, b, c] = corners.map(|v| patch.position(v));
    let middle: Vector = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0);
    let found = on_surface(surface, patch.anchors[corners[0] as usize], middle);
    found.map_or(0.0, |found| dot(sub(found.point, middle), unit(patch.normal(corners))))
}

fn raised(patch: &Patch, v: u32, heights: &[f64]) -> Option<Vector> {
    let here = patch.position(v);
    let faces = patch.around(v);
    if patch.on_boundary[v as usize] || patch.locked[v as usize] || faces.is_empty() {
        return None;
    }
    let mut normal = [0.0; 3];
    let mut sum = 0.0;
    for &f in faces {
        let doubled = patch.normal(patch.faces[f as usize]);
        (0..3).for_each(|k| normal[k] += doubled[k]);
        sum += heights[f as usize];
    }
    let step = scale(unit(normal), PART * sum / faces.len() as f64);
    Some(std::array::from_fn(|k| here[k] + step[k]))
}
