//! The kinds of texels, and of ground.

/// The kind of a texel that is not on the surface.
pub const OUTSIDE: u8 = 0;
/// The kind of a texel on the surface, with all texels around it in the same chart.
pub const INSIDE: u8 = 1;
/// The kind of a texel on the surface, at a seam or the boundary.
pub const BORDER: u8 = 2;

/// Ground without obstacle or attractor.
pub const FREE: u8 = 0;
/// An obstacle: agents do not enter it.
pub const OBSTACLE: u8 = 1;
/// An attractor: agents do not leave it.
pub const GOAL: u8 = 2;
