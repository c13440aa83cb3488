use super::surface::Surface;
use super::walk::Walker;
use catamaran::base::{Error, Result, reserved};

/// The state of a simulation: everything that a step changes.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Number of steps done.
    pub step: u32,
    /// The number of each agent: a permutation of all numbers below the number of agents, in an
    /// order that changes.
    pub ids: Vec<u32>,
    /// The triangle of each agent.
    pub triangles: Vec<u32>,
    /// Positions of agents in the frames of their triangles.
    pub positions: Vec<[f32; 2]>,
    /// Unit headings of agents in the same frames.
    pub headings: Vec<[f32; 2]>,
    /// The texture of each species, one after the other.
    pub texture: Vec<f32>,
}

/// Agents may lie this far beyond the edges of their triangle, in the unit of the surface, because
/// of rounding.
const SLACK: f32 = 1e-4;

impl State {
    /// Creates the state of agents and a texture.
    pub(super) fn new(walkers: &[Walker], texture: Vec<f32>) -> Result<Self> {
        let mut state = Self { texture, ..Self::filled(walkers.len(), 0)? };
        for (i, walker) in walkers.iter().enumerate() {
            state.put(i, i as u32, *walker);
        }
        Ok(state)
    }

    /// Allocates a state with that many agents and entries of the texture, all zero.
    pub(crate) fn filled(agents: usize, entries: usize) -> Result<Self> {
        Ok(Self {
            step: 0,
            ids: filled(agents, 0)?,
            triangles: filled(agents, 0)?,
            positions: filled(agents, [0.0; 2])?,
            headings: filled(agents, [0.0; 2])?,
            texture: filled(entries, 0.0)?,
        })
    }

    /// Stores an agent at index i.
    pub(crate) fn put(&mut self, i: usize, id: u32, walker: Walker) {
        self.ids[i] = id;
        self.triangles[i] = walker.triangle;
        self.positions[i] = walker.position;
        self.headings[i] = walker.heading;
    }

    /// Returns the agent at index i.
    pub fn agent(&self, i: usize) -> Walker {
        Walker {
            triangle: self.triangles[i],
            position: self.positions[i],
            heading: self.headings[i],
        }
    }

    /// Returns an error unless all agents are on their triangles, with a heading of length 1, and
    /// all pheromone is from 0 to 1.
    ///
    /// # Errors
    /// [`Error::Argument`] names the first agent or entry of the texture that is invalid,
    /// [`Error::Shape`] arrays of different lengths.
    pub fn check(&self, surface: &Surface) -> Result<()> {
        let agents = self.triangles.len();
        Error::check_shape("ids", (agents, 1), (self.ids.len(), 1))?;
        Error::check_shape("positions", (agents, 2), (self.positions.len(), 2))?;
        Error::check_shape("headings", (agents, 2), (self.headings.len(), 2))?;
        let mut seen = filled(agents, false)?;
        for &id in &self.ids {
            match seen.get_mut(id as usize) {
                Some(seen) if !*seen => *seen = true,
                _ => {
                    let why = format!("number {id} of {agents} is repeated or too large");
                    return Err(Error::Argument { what: "ids", why });
                }
            }
        }
        if let Some(i) = (0..agents).find(|&i| !is_on(surface, self.agent(i))) {
            let triangle = self.triangles[i];
            let why = format!(
                "agent {i}, of triangle {triangle}, is not on the surface, or its heading is no \
                 unit vector"
            );
            return Err(Error::Argument { what: "agents", why });
        }
        match self.texture.iter().position(|p| !(0.0..=1.0).contains(p)) {
            None => Ok(()),
            Some(at) => Err(Error::Argument {
                what: "texture",
                why: format!("must be from 0 to 1, is {} at {at}", self.texture[at]),
            }),
        }
    }
}

fn is_on(surface: &Surface, walker: Walker) -> bool {
    let Some(record) = surface.records().get(walker.triangle as usize) else { return false };
    let [x, y] = walker.position;
    let [dx, dy] = walker.heading;
    let inside = |k: usize| record[3 * k] * x + record[3 * k + 1] * y + record[3 * k + 2] >= -SLACK;
    (0..3).all(inside) && (dx * dx + dy * dy - 1.0).abs() < 1e-3
}

fn filled<T: Clone>(len: usize, value: T) -> Result<Vec<T>> {
    let mut all = reserved(len)?;
    all.resize(len, value);
    Ok(all)
}
