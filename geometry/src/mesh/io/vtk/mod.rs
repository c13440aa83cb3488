//! VTK: legacy files (`.vtk`) and XML files (`.vtp`, `.vtu`) of polygons and of unstructured grids.
//!
//! Formats: "VTK legacy file formats" and "VTK XML file formats" (docs.vtk.org).

mod encoding;
mod legacy;
mod write;
mod xml;

pub use self::encoding::VtkEncoding;
pub(super) use self::legacy::read as read_legacy;
pub(super) use self::write::write;
pub(super) use self::xml::read as read_xml;
