//! Slime moulds on surfaces: MoMaS (thesis, chapter 3; docs/algorithms/slime.md).
//!
//! A step consists of three kernels over flat buffers. Each is a pure function here, and a kernel
//! of the same name on devices:
//!
//! 1. [`agent_step`], for each agent: senses the texture at three positions ahead, turns, moves.
//!    Reads [`Surface`], texture and ground; writes the agent, and returns its texel.
//! 2. deposit, for each agent: sets the bit of its texel ([`mark`]). An integer "or", so that the
//!    order of agents does not matter.
//! 3. [`diffuse_row`] and [`diffuse_border`], for each texel: reads the texture, with 1 where a bit
//!    is set, blurs, evaporates, and writes the next texture.
//!
//! All arithmetic is that of IEEE `f32` (no contraction to fused operations, divisions and roots
//! correctly rounded) and of `u32` that wraps. No kernel computes a sine or a cosine: headings are
//! unit vectors, and the rotations are in [`Parameters`].
//!
//! # Layout
//! - A triangle has a frame in its plane: origin at its corner 0, the x axis towards corner 1,
//!   corner 2 at positive y, the unit of length the square root of the area of the surface. Records
//!   of triangles: [`Surface::records`], [`Surface::across`], [`Surface::frames`].
//! - An agent is a triangle, a position and a unit heading in its frame: [`State::triangles`],
//!   [`State::positions`], [`State::headings`]. An agent has a number, [`State::ids`], which does
//!   not depend on its position in the arrays; the number seeds the random numbers of the agent,
//!   and modulo the number of species it is the species.
//! - A texture of R x R texels and n species is n planes of R rows of R values in `[0, 1]`; texel
//!   (i, j), i along u and j along v, is number `R j + i`, species s begins at `s R R`. Row 0 is
//!   v = 0. R is a multiple of 32.
//! - Marks: bit b of word w is entry `32 w + b` of the texture.

mod agents;
mod atlas;
mod coverage;
mod diffuse;
mod kinds;
mod links;
mod locate;
mod options;
mod order;
mod pattern;
mod random;
mod raster;
mod saved;
mod simulation;
mod start;
mod state;
mod surface;
mod texels;
mod walk;

pub use agents::{Field, agent_step, mark};
pub use atlas::{atlas, smallest_size};
pub use coverage::Coverage;
#[cfg(feature = "opencl")]
pub(crate) use coverage::{AREA_UNIT, PHEROMONE_UNIT, sum_of};
pub use diffuse::{diffuse_border, diffuse_row};
pub use kinds::{BORDER, FREE, GOAL, INSIDE, OBSTACLE, OUTSIDE};
pub use options::{Blur, Options, Parameters, TURNS, TangentStep};
#[cfg(feature = "opencl")]
pub(crate) use order::{EVERY, TILE};
pub use pattern::Pattern;
pub use random::{Purpose, draw};
pub use simulation::{Mask, Simulation};
pub use state::State;
pub use surface::{ACROSS_FLIP, HOPS, NO_TRIANGLE, RECORD, Surface, UV, fitted};
pub use texels::Texels;
pub use walk::{MOST_HOPS, Walker, project, unfold};
