use std::path::Path;

use super::attributes::MeshFile;
use super::gltf::GltfEncoding;
use super::ply::PlyEncoding;
use super::stl::StlEncoding;
use crate::base::{Error, Result};
use crate::io::Packing;

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
}

impl MeshFormat {
    /// Returns the format and the packing that the name of a file implies: `.obj`, `.ply` (binary,
    /// little endian), `.off`, `.stl` (binary), `.glb`, `.gltf`.
    pub(super) fn named(path: &Path) -> (Option<Self>, Packing) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let (stem, packing) = Packing::of(&name);
        let format = match stem.rsplit_once('.').map(|(_, extension)| extension) {
            Some("obj") => Some(Self::Obj),
            Some("ply") => Some(Self::Ply(PlyEncoding::LittleEndian)),
            Some("off") => Some(Self::Off),
            Some("stl") => Some(Self::Stl(StlEncoding::Binary)),
            Some("glb") => Some(Self::Gltf(GltfEncoding::Binary)),
            Some("gltf") => Some(Self::Gltf(GltfEncoding::Text)),
            _ => None,
        };
        (format, packing)
    }

    /// Returns the format that the name of a file to be written implies; the name may end in a
    /// packing (`.gz`).
    ///
    /// ```
    /// use catamaran::mesh::io::MeshFormat;
    ///
    /// assert_eq!(MeshFormat::of("a.off.gz".as_ref())?, MeshFormat::Off);
    /// assert!(MeshFormat::of("a.doc".as_ref()).is_err());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Io`] for a name that implies no format.
    pub fn of(path: &Path) -> Result<Self> {
        let what = "unknown kind of mesh: the name must end in .obj, .ply, .off, .stl, .glb or \
                    .gltf, and may have .gz or (for reading) .xz after it";
        Self::named(path).0.ok_or_else(|| Error::file(path, what))
    }

    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Obj => "OBJ",
            Self::Ply(_) => "PLY",
            Self::Off => "OFF",
            Self::Stl(_) => "STL",
            Self::Gltf(_) => "glTF",
        }
    }

    /// Returns the attributes of a file that this format can't store and that
    /// [`write()`](super::write()) leaves out, in plain words; empty when all are stored.
    ///
    /// ```
    /// use catamaran::mesh::{families, io::{MeshFile, MeshFormat}};
    ///
    /// let mut sphere = MeshFile::from(families::icosphere(1)?);
    /// assert!(MeshFormat::Off.left_out(&sphere).is_empty());
    /// sphere.material_files = vec!["spot.mtl".into()];
    /// assert_eq!(MeshFormat::Off.left_out(&sphere), ["materials"]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn left_out(self, file: &MeshFile) -> Vec<&'static str> {
        let of_corners = |corners: Option<bool>| corners == Some(true);
        let uv = file.uv.as_ref().map(|uv| uv.corners.is_some());
        let normals = file.normals.as_ref().map(|normals| normals.corners.is_some());
        let materials = file.materials.is_some();
        let groups = file.groups.is_some() || file.objects.is_some();
        let (is_obj, is_stl) = (self == Self::Obj, matches!(self, Self::Stl(_)));
        let is_gltf = matches!(self, Self::Gltf(_));
        let whole = is_obj || is_gltf;
        let all = [
            (is_stl && uv.is_some(), "texture coordinates"),
            (self == Self::Off && of_corners(uv), "texture coordinates along seams"),
            (is_stl && normals.is_some(), "normals"),
            (!is_stl && !whole && of_corners(normals), "normals of corners"),
            (is_stl && file.colors.is_some(), "colours"),
            (!whole && (materials || !file.material_files.is_empty()), "materials"),
            (is_gltf && !file.material_files.is_empty(), "files of materials"),
            (!is_obj && groups, "groups"),
        ];
        all.into_iter().filter(|(lost, _)| *lost).map(|(_, what)| what).collect()
    }
}
