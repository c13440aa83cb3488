//! What a texel is on the surface, and what stands there.

/// Not on the surface.
pub const OUTSIDE: u8 = 0;
/// On the surface, with all texels around it in the same chart.
pub const INSIDE: u8 = 1;
/// On the surface, at a seam or the boundary.
pub const BORDER: u8 = 2;

/// Nothing is there.
pub const FREE: u8 = 0;
/// Agents do not go there.
pub const OBSTACLE: u8 = 1;
/// An attractor: agents do not leave it.
pub const GOAL: u8 = 2;
