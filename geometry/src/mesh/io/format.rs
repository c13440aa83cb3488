use std::path::Path;

use super::super::TriMesh;
use super::attributes::MeshFile;
use super::colors::{byte, nearest_byte};
use super::gltf::GltfEncoding;
use super::ply::PlyEncoding;
use super::stl::StlEncoding;
use catamaran::base::{Error, Result};
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
    /// use catamaran_geometry::mesh::io::MeshFormat;
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
                    .gltf, and may have .gz or (for reading) .xz, .zst or .zip after it";
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
    /// use catamaran_geometry::mesh::{families, io::{MeshFile, MeshFormat}};
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
        let (is_obj, is_off) = (self == Self::Obj, self == Self::Off);
        let is_stl = matches!(self, Self::Stl(_));
        let is_gltf = matches!(self, Self::Gltf(_));
        let whole = is_obj || is_gltf;
        let all = [
            (is_stl && has_lone_vertices(&file.mesh), "vertices without a face"),
            ((is_stl || is_off) && uv.is_some(), "texture coordinates"),
            (is_stl && normals.is_some(), "normals"),
            (is_off && normals.is_some() && file.colors.is_some(), "normals beside colours"),
            (is_off && of_corners(normals) && file.colors.is_none(), "normals of corners"),
            (!is_stl && !is_off && !whole && of_corners(normals), "normals of corners"),
            (is_stl && file.colors.is_some(), "colours"),
            (!whole && (materials || !file.material_files.is_empty()), "materials"),
            (is_gltf && !file.material_files.is_empty(), "files of materials"),
            (!is_obj && groups, "groups"),
        ];
        all.into_iter().filter(|(lost, _)| *lost).map(|(_, what)| what).collect()
    }

    /// Returns the format that has every digit as text, instead of single precision or binary
    /// numbers; `None` for glTF, whose coordinates have single precision as text, too.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::{MeshFormat, PlyEncoding, StlEncoding};
    ///
    /// let format = MeshFormat::of("a.stl".as_ref())?;
    /// assert_eq!(format, MeshFormat::Stl(StlEncoding::Binary));
    /// assert_eq!(format.as_text(), Some(MeshFormat::Stl(StlEncoding::Ascii)));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn as_text(self) -> Option<Self> {
        match self {
            Self::Obj | Self::Off => Some(self),
            Self::Ply(_) => Some(Self::Ply(PlyEncoding::Ascii)),
            Self::Stl(_) => Some(Self::Stl(StlEncoding::Ascii)),
            Self::Gltf(_) => None,
        }
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

/// Returns whether some vertex is in no face.
fn has_lone_vertices(mesh: &TriMesh) -> bool {
    let mut lone = vec![true; mesh.vertices().len()];
    mesh.faces().as_flattened().iter().for_each(|&v| lone[v as usize] = false);
    lone.contains(&true)
}
