//! Skeletons of creatures: every creature has its own random bones.

use std::f64::consts::TAU;

use catamaran::base::Rng;
use catamaran_geometry::mesh::vector::{Vector, add, distance, scale};

use super::skeleton::Spec;
use crate::cuts::below;

/// Width of the rounding of creases between limbs, in metres.
pub(super) const SMOOTHNESS: f64 = 0.015;

/// Range of the number of entries of a skeleton; entries at the side give two bones.
const ENTRIES: [usize; 2] = [2, 9];
/// Range of the lengths of bones, in metres.
const LENGTHS: [f64; 2] = [0.1, 0.7];
/// Range of the radii, relative to the length.
const RADII: [f64; 2] = [0.12, 0.7];
/// Range of the ratio of the thickness at the tail to that at the head.
const TAPER: [f64; 2] = [0.6, 1.15];
/// Share of the bones that are on both sides.
const PAIRED: f64 = 0.6;
/// Share of the bones that begin at the ends of others; the rest begin anywhere on them.
const CHAINED: f64 = 0.5;
/// Largest rotation about each axis, in radians.
const TURN: f64 = 0.35;
/// Smallest radius, relative to the mean distance of vertices.
const RESOLVED: f64 = 1.5;

/// Draws the bones of a creature whose surface has about `vertices` vertices.
pub(super) fn specs(vertices: usize, rng: &mut Rng) -> Vec<Spec> {
    let count = ENTRIES[0] + below(ENTRIES[1] - ENTRIES[0] + 1, rng);
    let mut specs: Vec<Spec> = Vec::with_capacity(count);
    for number in 0..count {
        let length = between_evenly(LENGTHS, rng);
        let parent = below(number, rng);
        let along = if rng.uniform() < CHAINED { 1.0 } else { rng.uniform() };
        let (head, beside, thickest) = match specs.get(parent) {
            None => ([0.0; 3], false, f64::INFINITY),
            Some(Spec { head, tail, radii, .. }) => {
                let p = add(scale(*head, 1.0 - along), scale(*tail, along));
                (p, p[0] > 0.0, radii[0].max(radii[1]))
            }
        };
        let paired = beside || number > 0 && rng.uniform() < PAIRED;
        let direction = if paired { to_the_right(rng) } else { in_the_plane(rng) };
        // Limbs are no thicker than the bones to which they are attached.
        let radius = (length * between_evenly(RADII, rng)).min(thickest);
        let mut head = head;
        if paired && !beside {
            head[0] = 0.3 * thickest;
        }
        specs.push(Spec {
            parent,
            head,
            tail: add(head, scale(direction, length)),
            radii: [radius, radius * between_evenly(TAPER, rng)],
            turns: if number == 0 { [[0.0; 2]; 3] } else { [[-TURN, TURN]; 3] },
            body_b: [1.0; 2],
        });
    }
    thickened(specs, vertices)
}

/// Increases radii that are too small for the resolution of the mesh.
fn thickened(mut specs: Vec<Spec>, vertices: usize) -> Vec<Spec> {
    let flesh = |spec: &Spec| {
        let sides = if spec.tail[0] > 0.0 { 2.0 } else { 1.0 };
        let radius = 0.5 * (spec.radii[0] + spec.radii[1]);
        sides * TAU * radius * (distance(spec.head, spec.tail) + radius)
    };
    let area: f64 = specs.iter().map(flesh).sum();
    let least = RESOLVED * (area / vertices.max(1) as f64).sqrt();
    for spec in &mut specs {
        spec.radii = spec.radii.map(|radius| radius.max(least));
    }
    specs
}

/// Draws a number whose logarithm is uniformly distributed.
fn between_evenly([low, high]: [f64; 2], rng: &mut Rng) -> f64 {
    low * (high / low).powf(rng.uniform())
}

/// Draws a direction away from the plane x = 0.
fn to_the_right(rng: &mut Rng) -> Vector {
    let x = rng.uniform();
    let across = (1.0 - x * x).sqrt();
    let [_, y, z] = in_the_plane(rng);
    [x, across * y, across * z]
}

/// Draws a direction in the plane x = 0.
fn in_the_plane(rng: &mut Rng) -> Vector {
    let (sin, cos) = (TAU * rng.uniform()).sin_cos();
    [0.0, cos, sin]
}
