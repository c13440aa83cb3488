//! Textures that grow on surfaces (thesis, chapters 3 and 7): the reference implementations, on the
//! CPU. The module `opencl` (feature `opencl`) provides the same as kernels. This module also
//! provides normal maps and materials of these textures.

mod margin;
mod material;
pub mod newton;
mod relief;
pub mod slime;

pub use margin::margin;
pub use material::{Finish, Look, MaterialMaps, Preset};
pub use relief::{HeightField, flat_normal_map, normal_colors, normal_map};
