//! Generated plants of any size.

use std::collections::VecDeque;
use std::f64::consts::PI;

use super::{Plant, Segment};
use catamaran::base::{Result, Rng, check_request, options, reserved};
use catamaran_geometry::mesh::vector::{add, cross, dot, scale, unit};

/// Number of segments of an internode.
const SEGMENTS: usize = 3;

/// Number of generations for which a lateral bud is dormant: the apex is dominant.
const DORMANCY: u32 = 4;

/// Number of generations after which an axis ends as the vein of a leaf.
const LIFE: u32 = 24;

/// The divergence of successive laterals, 137.5 degrees.
const GOLDEN_ANGLE: f64 = PI * 0.763_932_022_500_210_3;

options! {
    /// Options of [`grow`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct GrowthOptions {
        /// Number of nodes.
        nodes: usize = 500, check(at least 1);
        /// Seed of the variation of angles.
        seed: u64 = 0;
        /// The radius of the stem at the ground.
        radius: f64 = 2e-3, unit "m", check(positive);
        /// The length of the first internode.
        internode: f64 = 0.025, unit "m", check(positive);
        /// The angle between a branch and its axis.
        branching: f64 = 0.9, unit "rad", check(finite);
    }
}

/// A bud: the state of the turtle, and the parameters of the module.
struct Bud {
    parent: Option<u32>,
    tail: [f64; 3],
    direction: [f64; 3],
    /// A unit vector orthogonal to the direction, from which the next lateral is rotated.
    side: [f64; 3],
    radius: f64,
    length: f64,
    asleep: u32,
    age: u32,
    /// The order of branching: 0 for the stem, 1 for its branches, and so on.
    order: u32,
}

impl Bud {
    /// Returns the bud from which the whole plant grows.
    fn first(options: &GrowthOptions) -> Self {
        Self {
            parent: None,
            tail: [0.0; 3],
            direction: [0.0, 0.0, 1.0],
            side: [1.0, 0.0, 0.0],
            radius: options.radius,
            length: options.internode,
            asleep: 0,
            age: 0,
            order: 0,
        }
    }

    /// Returns the bud of a branch, which is tilted from the axis towards `side`.
    fn lateral(&self, side: [f64; 3], tilt: f64) -> Self {
        let (along, across) = (tilt.cos(), tilt.sin());
        let branch = unit([0, 1, 2].map(|i| along * self.direction[i] + across * side[i]));
        Self {
            direction: branch,
            side: unit(cross(branch, self.direction)),
            radius: (0.5 * self.radius).max(3e-5),
            length: (0.6 * self.length).max(2e-3),
            asleep: DORMANCY,
            age: 0,
            order: self.order + 1,
            ..*self
        }
    }

    /// Returns the next bud of the axis, which turns about `side` by an angle.
    fn apex(&self, side: [f64; 3], angle: f64) -> Self {
        let sway = rotated(self.direction, side, angle);
        Self {
            direction: unit(sway),
            side: unit(cross(cross(sway, side), sway)),
            radius: (0.95 * self.radius).max(3e-5),
            length: (0.95 * self.length).max(2e-3),
            age: self.age + 1,
            ..*self
        }
    }
}

/// Generates a plant of exactly `options.nodes` nodes from a parametric L-system (Prusinkiewicz and
/// Lindenmayer 1990, section 1.10):
/// `A(r, l) -> F(l, r) [+(branching) B(r / 2, 0.6 l, 4)] /(137.5) A(0.95 r, 0.95 l)` and
/// `B(r, l, s) -> B(r, l, s - 1)`, `B(r, l, 0) -> A(r, l)`, with F cut into three segments. Axes of
/// order 2 and more, old axes and all tips are veins of leaves. Nodes are numbered as they grow.
///
/// ```
/// use catamaran_simulation::plant::families::{GrowthOptions, grow};
///
/// assert_eq!(grow(&GrowthOptions::new().nodes(100))?.len(), 100);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) names an option out of its range;
/// [`Error::OutOfMemory`](catamaran::Error::OutOfMemory).
pub fn grow(options: &GrowthOptions) -> Result<Plant> {
    options.check_ranges()?;
    /// Bytes of a node while the plant grows: its segment, its place in the tree, and its bud.
    const NODE: f64 = 200.0;
    let request = format_args!("a plant of {} nodes", options.nodes);
    check_request("nodes", request, options.nodes as f64 * NODE)?;
    let mut rng = Rng::new(options.seed);
    let mut segments: Vec<Segment> = reserved(options.nodes)?;
    let mut parents: Vec<Option<u32>> = reserved(options.nodes)?;
    let mut buds = VecDeque::from([Bud::first(options)]);
    while segments.len() < options.nodes {
        // The apex of the stem never ends, so there is always a bud.
        let Some(mut bud) = buds.pop_front() else { break };
        if bud.asleep > 0 {
            bud.asleep -= 1;
            buds.push_back(bud);
            continue;
        }
        for _ in 0..SEGMENTS.min(options.nodes - segments.len()) {
            let step = bud.length / SEGMENTS as f64;
            bud.tail = add(bud.tail, scale(bud.direction, step));
            let mut segment = Segment::stem(bud.tail, bud.radius);
            segment.leaf = bud.order >= 2 || (bud.order > 0 && bud.age >= LIFE);
            parents.push(bud.parent);
            bud.parent = Some(segments.len() as u32);
            segments.push(segment);
        }
        let turned = rotated(bud.side, bud.direction, GOLDEN_ANGLE + 0.2 * (rng.uniform() - 0.5));
        buds.push_back(bud.lateral(turned, options.branching * (0.8 + 0.4 * rng.uniform())));
        let next = bud.apex(turned, 0.15 * (rng.uniform() - 0.5));
        if next.order == 0 || next.age < 2 * LIFE {
            buds.push_back(next);
        }
    }
    let mut is_tip = vec![true; segments.len()];
    for parent in parents.iter().flatten() {
        is_tip[*parent as usize] = false;
    }
    for (segment, is_tip) in segments.iter_mut().zip(is_tip) {
        segment.leaf |= is_tip;
    }
    Plant::new(segments, &parents, Some([0.0; 3]))
}

/// Generates a straight, vertical stem of `nodes` equal segments (at least 1), of which the last
/// one is on a leaf.
///
/// ```
/// use catamaran_simulation::plant::families::chain;
///
/// let plant = chain(10, 0.3, 1e-3)?;
/// assert_eq!(plant.len(), 10);
/// assert!((plant.lengths().iter().sum::<f64>() - 0.3).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`Plant::new`].
pub fn chain(nodes: usize, length: f64, radius: f64) -> Result<Plant> {
    let step = length / nodes as f64;
    let mut segments: Vec<Segment> = reserved(nodes)?;
    segments.extend((1..=nodes).map(|i| Segment::stem([0.0, 0.0, step * i as f64], radius)));
    if let Some(last) = segments.last_mut() {
        last.leaf = true;
    }
    let parents: Vec<_> = (0..nodes as u32).map(|v| v.checked_sub(1)).collect();
    Plant::new(segments, &parents, Some([0.0; 3]))
}

/// Returns `a` rotated about the unit vector `axis` (Rodrigues).
fn rotated(a: [f64; 3], axis: [f64; 3], angle: f64) -> [f64; 3] {
    let (s, c) = angle.sin_cos();
    let across = cross(axis, a);
    let along = dot(axis, a);
    [0, 1, 2].map(|i| c * a[i] + s * across[i] + (1.0 - c) * along * axis[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plants_have_the_nodes_that_are_asked_for_and_only_the_seed_changes_them() {
        for nodes in [1, 2, 3, 7, 127, 3001] {
            let options = GrowthOptions { nodes, seed: 5, ..GrowthOptions::default() };
            let plant = grow(&options).unwrap();
            assert_eq!(plant.len(), nodes);
            assert!(plant.segments().iter().any(|s| s.leaf));
            assert_eq!(plant, grow(&options).unwrap());
            assert!(nodes < 7 || plant != grow(&GrowthOptions { seed: 6, ..options }).unwrap());
        }
        assert_eq!(chain(3, 0.3, 1e-3).unwrap().len(), 3);
    }

    #[test]
    fn options_out_of_range_are_named() {
        let says = |options: GrowthOptions, why: &str| {
            assert_eq!(grow(&options).unwrap_err().to_string(), why);
        };
        let options = GrowthOptions::new();
        says(options.nodes(0), "nodes: must be at least 1, is 0");
        says(options.radius(0.0), "radius: must be positive and finite, is 0");
        says(options.internode(-1.0), "internode: must be positive and finite, is -1");
        says(options.branching(f64::NAN), "branching: must be finite, is NaN");
    }
}
