use std::sync::atomic::{AtomicU32, Ordering};

use super::kinds::{GOAL, OBSTACLE};
use super::locate::texel;
use super::options::{Parameters, TURNS};
use super::random::{Purpose, draw};
use super::surface::Surface;
use super::walk::{Walker, project, unfold};

/// The texture and the ground that agents sense.
#[derive(Debug, Clone, Copy)]
pub struct Field<'a> {
    /// The texture of all species, one after the other.
    pub texture: &'a [f32],
    /// [`FREE`](super::FREE), [`OBSTACLE`] or [`GOAL`] for each texel; empty when all are free.
    pub ground: &'a [u8],
}

/// Computes a step of agent number `agent` (algorithm 3.2, lines 11 to 20), and returns the agent
/// and its texel.
///
/// Differences from the thesis: an agent goes straight on unless a side is better than the centre;
/// it turns by one of [`Parameters::turns`]; it turns back instead of entering an obstacle, or
/// leaving an attractor.
///
/// ```
/// use catamaran_simulation::texture::slime::{Field, Options, Surface, Walker, agent_step};
///
/// let surface = Surface::tile()?;
/// let parameters = Options::new().agents(1).size(32).parameters()?;
/// let field = Field { texture: &vec![0.0; 32 * 32], ground: &[] };
/// let [a, b, c] = surface.corners()[0];
/// let position = [0, 1].map(|k| ((a[k] + b[k] + c[k]) / 3.0) as f32);
/// let walker = Walker { triangle: 0, position, heading: [1.0, 0.0] };
/// // Without pheromone, agents go straight on.
/// let (walker, texel) = agent_step(&surface, field, &parameters, walker, 0, 0);
/// assert!(texel < 32 * 32 && (walker.heading[0] - 1.0).abs() < 1e-6);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn agent_step(
    surface: &Surface,
    field: Field<'_>,
    parameters: &Parameters,
    walker: Walker,
    agent: u32,
    step: u32,
) -> (Walker, u32) {
    let species = agent % parameters.species;
    let place = |heading| {
        let end = walk(surface, parameters, Walker { heading, ..walker }, parameters.sense);
        texel(surface, parameters.size, &end)
    };
    let [cos, sin] = parameters.vision;
    let ahead = place(walker.heading);
    let left = place(rotated(walker.heading, cos, sin));
    let right = place(rotated(walker.heading, cos, -sin));
    // All three at once, so that their memory accesses overlap.
    let [ahead, left, right] =
        [ahead, left, right].map(|texel| smell(field, parameters, species, texel));
    let [choice, coin, ..] = draw(parameters.seed, agent, step, Purpose::Turn as u32);
    let [cos, sin] = parameters.turns[choice as usize % TURNS];
    let mut next = walker;
    if ahead < left || ahead < right {
        let to_left = if left == right { coin & 1 == 0 } else { left > right };
        next.heading = rotated(walker.heading, cos, if to_left { sin } else { -sin });
    }
    next = walk(surface, parameters, next, parameters.advance);
    let mut reached = texel(surface, parameters.size, &next);
    if !field.ground.is_empty() {
        let before = texel(surface, parameters.size, &walker);
        let [from, to] = [before, reached].map(|t| field.ground[t as usize]);
        if (to == OBSTACLE && from != OBSTACLE) || (from == GOAL && to != GOAL) {
            let back = walker.heading.map(|x| -x);
            let sin = if coin & 2 == 0 { sin } else { -sin };
            next = Walker { heading: rotated(back, cos, sin), ..walker };
            reached = before;
        }
    }
    next.heading = normalized(next.heading);
    (next, reached)
}

/// Moves along the heading by `length`, or by the sub-steps if there are any.
fn walk(surface: &Surface, parameters: &Parameters, walker: Walker, length: f32) -> Walker {
    let rescale = parameters.rescale != 0;
    match parameters.substeps {
        0 => unfold(surface, walker, length, rescale),
        count => project(surface, walker, length, count, rescale),
    }
}

/// Returns the pheromone of the agent's own species minus that of the others; an attractor adds to
/// it, and an obstacle has the least value.
#[inline]
fn smell(field: Field<'_>, parameters: &Parameters, species: u32, texel: u32) -> f32 {
    let plane = parameters.size as usize * parameters.size as usize;
    let at = |s: u32| field.texture[s as usize * plane + texel as usize];
    let mut sum = at(species);
    for other in (0..parameters.species).filter(|&s| s != species) {
        sum -= at(other);
    }
    match field.ground.get(texel as usize) {
        Some(&OBSTACLE) => f32::NEG_INFINITY,
        Some(&GOAL) => sum + parameters.attraction,
        _ => sum,
    }
}

fn rotated([x, y]: [f32; 2], cos: f32, sin: f32) -> [f32; 2] {
    [cos * x - sin * y, sin * x + cos * y]
}

/// Normalizes a heading by one step of Newton's method, which suffices because rounding has changed
/// its length little.
fn normalized(heading: [f32; 2]) -> [f32; 2] {
    let [x, y] = heading;
    let factor = 1.5 - 0.5 * (x * x + y * y);
    heading.map(|c| c * factor)
}

/// Sets the mark of an entry of the texture.
pub fn mark(marks: &[AtomicU32], entry: u32) {
    let bit = 1 << (entry % 32);
    let word = &marks[entry as usize / 32];
    // Most texels are marked already, and reading is cheaper than an atomic write.
    if word.load(Ordering::Relaxed) & bit == 0 {
        word.fetch_or(bit, Ordering::Relaxed);
    }
}
