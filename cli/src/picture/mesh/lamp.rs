//! Where light comes from.

use catamaran::mesh::vector::Vector;

/// Where the two lamps are as the viewer sees it (right, up, near; unit vectors), and how bright.
pub const LAMPS: [(Vector, f64); 2] = [([-0.43, 0.62, 0.656], 0.68), ([0.77, 0.12, 0.627], 0.28)];
