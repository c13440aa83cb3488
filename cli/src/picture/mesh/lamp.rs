//! The lamps.

use catamaran_geometry::mesh::vector::Vector;

/// The directions of the two lamps as the viewer sees them (right, up, near; unit vectors), and
/// their brightness.
pub const LAMPS: [(Vector, f64); 2] = [([-0.43, 0.62, 0.656], 0.68), ([0.77, 0.12, 0.627], 0.28)];
