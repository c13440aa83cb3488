use std::mem::discriminant;
use std::path::Path;

use super::super::TriMesh;
use super::attributes::MeshFile;
use super::colors::{byte, nearest_byte};
use super::formats::{Description, FORMATS, Stored, endings};
use super::gltf::GltfEncoding;
use super::ply::PlyEncoding;
use super::stl::StlEncoding;
use super::vtk::VtkEncoding;
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
    /// Legacy VTK. The encoding matters for writing only; a reader takes it from the header.
    Vtk(VtkEncoding),
    /// XML files of VTK: PolyData and UnstructuredGrid; only read.
    VtkXml,
    /// GIFTI; written in single precision.
    Gifti,
    /// Surfaces of FreeSurfer; only read.
    FreeSurfer,
    /// Gmsh's MSH, versions 2 and 4.1; only read.
    Gmsh,
    /// 3MF; written in millimetres.
    ThreeMf,
}

impl MeshFormat {
    /// Returns the format and the packing that the name of a file implies.
    pub(super) fn named(path: &Path) -> (Option<Self>, Packing) {
        let ending = Self::ending(path);
        let mut all = FORMATS.iter().flat_map(|format| format.endings);
        let format = all.find(|(known, _)| *known == ending).map(|(_, format)| *format);
        (format, Packing::of(&name(path)).1)
    }

    /// Returns the ending of the name of a file, in lower case and without that of a packing.
    pub(super) fn ending(path: &Path) -> String {
        let name = name(path);
        let (stem, _) = Packing::of(&name);
        stem.rsplit_once('.').map_or("", |(_, ending)| ending).to_owned()
    }

    /// Returns the row of this format in the table of formats.
    pub(super) fn description(self) -> &'static Description {
        let is_own = |(_, format): &(&str, Self)| discriminant(format) == discriminant(&self);
        let found = FORMATS.iter().find(|format| format.endings.iter().any(is_own));
        found.unwrap_or(&FORMATS[0])
    }

    /// Returns the endings of the names of the files that can be read, such as ".obj, .ply or
    /// .glb"; `.gz` or `.xz` may follow.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::MeshFormat;
    ///
    /// assert!(MeshFormat::readable().starts_with(".obj, .ply, "));
    /// ```
    pub fn readable() -> String {
        endings(false)
    }

    /// Returns the endings of the names of the files that can be written; `.gz` may follow.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::MeshFormat;
    ///
    /// assert!(MeshFormat::writable().starts_with(".obj, .ply, "));
    /// ```
    pub fn writable() -> String {
        endings(true)
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
        let what = match Self::named(path).0 {
            Some(format) if format.description().written.is_some() => return Ok(format),
            Some(format) => format!("{} files can only be read", format.title()),
            None => "unknown kind of mesh".into(),
        };
        let known = endings(true);
        let what = format!(
            "{what}: the name must end in {known}, and may have .gz or (for reading) .xz, .zst or \
             .zip after it"
        );
        Err(Error::file(path, what))
    }

    pub(super) fn title(self) -> &'static str {
        self.description().title
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
        let stores = |what| self.description().stores.contains(&what);
        let (colors, normals) = (file.colors.is_some(), file.normals.as_ref());
        let beside = colors && !stores(Stored::NormalsBesideColors);
        let of_corners = normals.is_some_and(|normals| normals.corners.is_some());
        let of_corners = of_corners && !beside && !stores(Stored::CornerNormals);
        let material_files = !file.material_files.is_empty() && !stores(Stored::MaterialFiles);
        let materials = (file.materials.is_some() || material_files) && !stores(Stored::Materials);
        let groups = file.groups.is_some() || file.objects.is_some();
        let normals = normals.map(|_| stores(Stored::Normals));
        let lone = !stores(Stored::LoneVertices) && has_lone_vertices(&file.mesh);
        let all = [
            (lone, "vertices without a face"),
            (file.uv.is_some() && !stores(Stored::Uv), "texture coordinates"),
            (normals == Some(false), "normals"),
            (normals == Some(true) && beside, "normals beside colours"),
            (normals == Some(true) && of_corners, "normals of corners"),
            (colors && !stores(Stored::Colors), "colours"),
            (materials, "materials"),
            (material_files && !materials, "files of materials"),
            (groups && !stores(Stored::Groups), "groups"),
            (!file.scalars.is_empty() && !stores(Stored::Scalars), "scalars"),
        ];
        all.into_iter().filter(|(lost, _)| *lost).map(|(_, what)| what).collect()
    }

    /// Returns the format that has every digit as text, instead of single precision or binary
    /// numbers; `None` for those that have single precision as text, too, or are only read.
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
        self.description().text
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
fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// Returns whether some vertex is in no face.
fn has_lone_vertices(mesh: &TriMesh) -> bool {
    let mut lone = vec![true; mesh.vertices().len()];
    mesh.faces().as_flattened().iter().for_each(|&v| lone[v as usize] = false);
    lone.contains(&true)
}
