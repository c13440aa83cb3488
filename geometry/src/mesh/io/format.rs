use std::path::Path;

use super::attributes::MeshFile;
use super::colors::{byte, nearest_byte};
use super::gltf::GltfEncoding;
use super::ply::PlyEncoding;
use super::stl::StlEncoding;
use super::vtk::VtkEncoding;
use catamaran::io::Packing;

/// Rounding of texture coordinates up to this is not noted: a sixtieth of a texel of a picture of
/// 16,384 texels.
const UV_ROUNDING: f64 = 1e-6;

/// The format of a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ: `v`, `vt`, `vn`, `f`; text.
    Obj,
    /// Stanford PLY. The encoding matters for writing only; a reader takes it from the header.
    Ply(PlyEncoding),
    /// Geomview OFF: text.
    Off,
    /// Stereolithography STL. The encoding matters for writing only; a reader detects it.
    Stl(StlEncoding),
    /// Khronos glTF 2.0. The encoding matters for writing only; a reader detects it.
    Gltf(GltfEncoding),
    /// Legacy VTK. The encoding matters for writing only; a reader takes it from the header.
    Vtk(VtkEncoding),
    /// XML files of VTK: PolyData and UnstructuredGrid; only read.
    VtkXml,
    /// GIFTI; written in single precision.
    Gifti,
    /// Surfaces of FreeSurfer; only read.
    FreeSurfer,
    /// Gmsh's MSH; only read.
    Gmsh,
    /// 3MF; written in millimetres.
    ThreeMf,
}

impl MeshFormat {
    /// Returns the ending of the name of a file, in lower case and without that of a packing.
    pub(super) fn ending(path: &Path) -> String {
        let name = name(path);
        let (stem, _) = Packing::of(&name);
        stem.rsplit_once('.').map_or("", |(_, ending)| ending).to_owned()
    }

    /// Adds notes about attributes that this format rounds or fills in.
    pub(super) fn note_rounded(self, file: &MeshFile, notes: &mut Vec<String>) {
        let is_ply = matches!(self, Self::Ply(_));
        if let (true, Some(uv)) = (is_ply, &file.uv) {
            let faces = 0..file.mesh.faces().len();
            let without = faces.filter(|&f| uv.of_face(&file.mesh, f).is_none()).count();
            if without > 0 {
                notes.push(format!("wrote texture coordinates 0 for {without} faces without any"));
            }
        }
        if let (true, Some(colors)) = (is_ply, &file.colors) {
            let numbers = colors.as_flattened();
            if numbers.iter().any(|&x| nearest_byte(x).is_none()) {
                let what = "wrote colours below 0 or above 1 as double numbers, which few programs \
                            read";
                notes.push(what.into());
            } else if numbers.iter().any(|&x| byte(x).is_none()) {
                notes.push("rounded colours to 256 levels".into());
            }
        }
        let levels = |x: &f64| byte(*x).is_none();
        let mut colors = file.colors.iter().flat_map(|colors| colors.as_flattened());
        if self == Self::Vtk(VtkEncoding::Binary) && colors.any(levels) {
            notes.push("rounded colours to 256 levels from 0 to 1".into());
        }
        let is_rounded = |x: &f64| f64::from(*x as f32) != *x && !x.is_nan();
        let mut scalars = file.scalars.iter().flat_map(|scalars| &scalars.values);
        if self == Self::Gifti && scalars.any(is_rounded) {
            notes.push("rounded scalars to single precision".into());
        }
        let binary_ply = is_ply && self != Self::Ply(PlyEncoding::Ascii);
        if binary_ply || matches!(self, Self::Gltf(_)) {
            let numbers = file.uv.iter().flat_map(|uv| uv.values.as_flattened());
            let moved = numbers.fold(0.0, |most, &x| (f64::from(x as f32) - x).abs().max(most));
            // PLY has doubles for what is beyond single precision.
            if moved > UV_ROUNDING && moved.is_finite() {
                let what = "rounded texture coordinates to single precision, by up to";
                notes.push(format!("{what} {moved:.1e}"));
            }
        }
    }
}

/// Returns the name of a file in lower case.
pub(super) fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
