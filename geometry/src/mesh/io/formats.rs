//! The table of formats, from which detection, help, the guide and errors are made.

use std::mem::discriminant;
use std::path::Path;

use super::super::TriMesh;
use super::attributes::MeshFile;
use super::detect::{self, Head};
use super::format::{MeshFormat, name};
use super::gltf::GltfEncoding;
use super::ply::PlyEncoding;
use super::stl::StlEncoding;
use super::text::of_utf16;
use super::vtk::{self, VtkEncoding};
use super::{freesurfer, gifti, gltf, gmsh, obj, off, ply, stl, threemf};
use catamaran::base::{Error, Result};
use catamaran::io::{Packing, Source};

/// What a format can store besides a mesh without lone vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stored {
    LoneVertices,
    /// Texture coordinates of vertices.
    Uv,
    CornerUv,
    /// Normals of vertices.
    Normals,
    /// Normals of vertices and colours in one file.
    NormalsBesideColors,
    CornerNormals,
    Colors,
    Materials,
    MaterialFiles,
    Groups,
    Scalars,
}

impl Stored {
    /// Returns the words of the guide; `None` for what the words of another one imply.
    fn words(self) -> Option<&'static str> {
        Some(match self {
            Self::LoneVertices => "vertices without a face",
            Self::Uv => "texture coordinates of vertices",
            Self::CornerUv => "texture coordinates of corners",
            Self::Normals => "normals of vertices",
            Self::NormalsBesideColors => return None,
            Self::CornerNormals => "normals of corners",
            Self::Colors => "colours",
            Self::Materials => "names of materials",
            Self::MaterialFiles => "files of materials",
            Self::Groups => "groups and objects",
            Self::Scalars => "functions on vertices",
        })
    }
}

/// A format of mesh files.
pub(super) struct Description {
    /// Its name in messages.
    pub title: &'static str,
    /// The endings of its files (in lower case), with the format or encoding that each implies for
    /// writing.
    pub endings: &'static [(&'static str, MeshFormat)],
    /// Returns whether a file that begins so has this format.
    pub fits: fn(&Head<'_>) -> bool,
    pub read: fn(&mut Source<'_>) -> Result<MeshFile>,
    /// What a file keeps of the coordinates; `None` for a format that is only read.
    pub written: Option<&'static str>,
    /// The encoding that has every digit as text.
    pub text: Option<MeshFormat>,
    /// What is written, or read from a format that is only read.
    pub stores: &'static [Stored],
}

const EVERY_DIGIT: &str = "every digit";

/// The formats. A file has the last one that it fits: those whose content may be taken for another
/// format come first.
pub(super) static FORMATS: [Description; 11] = [
    Description {
        title: "OBJ",
        endings: &[("obj", MeshFormat::Obj)],
        fits: detect::is_obj,
        read: obj::read,
        written: Some(EVERY_DIGIT),
        text: Some(MeshFormat::Obj),
        stores: &[
            Stored::LoneVertices,
            Stored::Uv,
            Stored::CornerUv,
            Stored::Normals,
            Stored::NormalsBesideColors,
            Stored::CornerNormals,
            Stored::Colors,
            Stored::Materials,
            Stored::MaterialFiles,
            Stored::Groups,
        ],
    },
    Description {
        title: "PLY",
        endings: &[("ply", MeshFormat::Ply(PlyEncoding::LittleEndian))],
        fits: detect::is_ply,
        read: ply::read,
        written: Some(EVERY_DIGIT),
        text: Some(MeshFormat::Ply(PlyEncoding::Ascii)),
        stores: &[
            Stored::LoneVertices,
            Stored::Uv,
            Stored::CornerUv,
            Stored::Normals,
            Stored::NormalsBesideColors,
            Stored::Colors,
        ],
    },
    Description {
        title: "OFF",
        endings: &[("off", MeshFormat::Off)],
        fits: detect::is_off,
        read: off::read,
        written: Some(EVERY_DIGIT),
        text: Some(MeshFormat::Off),
        stores: &[Stored::LoneVertices, Stored::Normals, Stored::Colors],
    },
    Description {
        title: "STL",
        endings: &[("stl", MeshFormat::Stl(StlEncoding::Binary))],
        fits: detect::is_stl,
        read: stl::read,
        written: Some("single precision; every digit with `mesh --text`"),
        text: Some(MeshFormat::Stl(StlEncoding::Ascii)),
        stores: &[],
    },
    Description {
        title: "glTF",
        endings: &[
            ("glb", MeshFormat::Gltf(GltfEncoding::Binary)),
            ("gltf", MeshFormat::Gltf(GltfEncoding::Text)),
        ],
        fits: detect::is_gltf,
        read: gltf::read,
        written: Some("single precision, from the middle of the mesh"),
        text: None,
        stores: &[
            Stored::LoneVertices,
            Stored::Uv,
            Stored::CornerUv,
            Stored::Normals,
            Stored::NormalsBesideColors,
            Stored::CornerNormals,
            Stored::Colors,
            Stored::Materials,
        ],
    },
    Description {
        title: "VTK",
        endings: &[("vtk", MeshFormat::Vtk(VtkEncoding::Binary))],
        fits: detect::is_vtk,
        read: vtk::read_legacy,
        written: Some(EVERY_DIGIT),
        text: Some(MeshFormat::Vtk(VtkEncoding::Ascii)),
        stores: &[
            Stored::LoneVertices,
            Stored::Uv,
            Stored::Normals,
            Stored::NormalsBesideColors,
            Stored::Colors,
            Stored::Scalars,
        ],
    },
    Description {
        title: "VTK XML",
        endings: &[("vtp", MeshFormat::VtkXml), ("vtu", MeshFormat::VtkXml)],
        fits: detect::is_vtk_xml,
        read: vtk::read_xml,
        written: None,
        text: None,
        stores: &[
            Stored::LoneVertices,
            Stored::Uv,
            Stored::Normals,
            Stored::NormalsBesideColors,
            Stored::Colors,
            Stored::Scalars,
        ],
    },
    Description {
        title: "GIFTI",
        endings: &[("gii", MeshFormat::Gifti)],
        fits: detect::is_gifti,
        read: gifti::read,
        written: Some("single precision"),
        text: None,
        stores: &[
            Stored::LoneVertices,
            Stored::Normals,
            Stored::NormalsBesideColors,
            Stored::Scalars,
        ],
    },
    Description {
        title: "FreeSurfer",
        endings: &[
            ("white", MeshFormat::FreeSurfer),
            ("pial", MeshFormat::FreeSurfer),
            ("inflated", MeshFormat::FreeSurfer),
            ("sphere", MeshFormat::FreeSurfer),
            ("orig", MeshFormat::FreeSurfer),
        ],
        fits: detect::is_freesurfer,
        read: freesurfer::read,
        written: None,
        text: None,
        stores: &[Stored::LoneVertices],
    },
    Description {
        title: "Gmsh",
        endings: &[("msh", MeshFormat::Gmsh)],
        fits: detect::is_gmsh,
        read: gmsh::read,
        written: None,
        text: None,
        stores: &[Stored::Scalars],
    },
    Description {
        title: "3MF",
        endings: &[("3mf", MeshFormat::ThreeMf)],
        fits: detect::is_threemf,
        read: threemf::read,
        written: Some(EVERY_DIGIT),
        text: Some(MeshFormat::ThreeMf),
        stores: &[Stored::LoneVertices],
    },
];

impl MeshFormat {
    /// Returns the format and the packing that the name of a file implies.
    pub(super) fn named(path: &Path) -> (Option<Self>, Packing) {
        let ending = Self::ending(path);
        let mut all = FORMATS.iter().flat_map(|format| format.endings);
        let format = all.find(|(known, _)| *known == ending).map(|(_, format)| *format);
        (format, Packing::of(&name(path)).1)
    }

    /// Returns the row of this format in the table of formats.
    pub(super) fn description(self) -> &'static Description {
        let is_own = |(_, format): &(&str, Self)| discriminant(format) == discriminant(&self);
        let found = FORMATS.iter().find(|format| format.endings.iter().any(is_own));
        found.unwrap_or(&FORMATS[0])
    }

    /// Returns the endings of the names of the files that can be read, such as ".obj, .ply or
    /// .glb"; the ending of a packing, such as `.gz` or `.xz`, may follow.
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
            "{what}: the name must end in {known}, and may have .gz or (for reading) .xz, .bz2, \
             .zst or .zip after it"
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
        let uv = file.uv.as_ref();
        let corner_uv = uv.is_some_and(|uv| uv.corners.is_some()) && !stores(Stored::CornerUv);
        let uv = uv.map(|_| stores(Stored::Uv));
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
            (uv == Some(false), "texture coordinates"),
            (uv == Some(true) && corner_uv, "texture coordinates of corners"),
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
}

/// Returns the packing of a file that begins with `head`; the name of the file says `named`.
pub(super) fn packing(head: &[u8], named: (Option<MeshFormat>, Packing)) -> Packing {
    let named_threemf = named == (Some(MeshFormat::ThreeMf), Packing::None);
    match Packing::of_content(head) {
        // 3MF is an archive itself.
        Packing::Zip if named_threemf || detect::is_threemf(&Head::new(head, None)) => {
            Packing::None
        }
        Packing::None if format(head, None).is_none() => named.1,
        found => found,
    }
}

/// Returns the format of a file that begins with `bytes`, and has `size` bytes if that is known;
/// `None` if it fits no format.
pub(super) fn format(bytes: &[u8], size: Option<u64>) -> Option<MeshFormat> {
    let decoded = of_utf16(bytes);
    let head = Head::new(decoded.as_deref().unwrap_or(bytes), size);
    let found = FORMATS.iter().rev().find(|format| (format.fits)(&head))?;
    found.endings.first().map(|(_, format)| *format)
}

/// Returns the names of all formats, such as "OBJ, PLY or glTF".
pub(super) fn titles() -> String {
    in_words(FORMATS.iter().map(|format| format.title.to_owned()))
}

/// Returns the endings of the files that are read or, with `written`, those that are written, such
/// as ".obj, .ply or .glb".
pub(super) fn endings(written: bool) -> String {
    let formats = FORMATS.iter().filter(|format| format.written.is_some() || !written);
    in_words(formats.flat_map(|format| format.endings).map(|(ending, _)| format!(".{ending}")))
}

/// Returns whether files whose names end so may have functions on vertices beside a mesh.
pub(super) fn has_functions(ending: &str) -> bool {
    let mut formats = FORMATS.iter().filter(|format| format.stores.contains(&Stored::Scalars));
    formats.any(|format| format.endings.iter().any(|(known, _)| *known == ending))
}

/// Returns the rows of the table of the guide, in Markdown.
pub(super) fn rows() -> String {
    let row = |format: &Description| {
        let endings = format.endings.iter().map(|(ending, _)| format!("`.{ending}`"));
        let endings = endings.collect::<Vec<_>>().join(", ");
        let stored = format.stores.iter().filter_map(|stored| stored.words());
        let stored = stored.collect::<Vec<_>>().join(", ");
        let stored = match format.written {
            Some(_) if stored.is_empty() => "nothing",
            _ => &stored,
        };
        let has = |what| format.stores.contains(&what);
        let alone =
            has(Stored::Normals) && has(Stored::Colors) && !has(Stored::NormalsBesideColors);
        let instead = if alone { ", the normals only without colours" } else { "" };
        let written = format.written.unwrap_or("read only");
        format!("| {} | {endings} | {written} | {stored}{instead} |\n", format.title)
    };
    FORMATS.iter().map(row).collect()
}

/// Returns whether some vertex is in no face.
fn has_lone_vertices(mesh: &TriMesh) -> bool {
    let mut lone = vec![true; mesh.vertices().len()];
    mesh.faces().as_flattened().iter().for_each(|&v| lone[v as usize] = false);
    lone.contains(&true)
}

/// Returns a list with "or" before the last item.
fn in_words(items: impl Iterator<Item = String>) -> String {
    let items: Vec<String> = items.collect();
    match items.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_ending_belongs_to_one_format_which_finds_its_row() {
        let all: Vec<_> = FORMATS.iter().flat_map(|format| format.endings).collect();
        for (i, (ending, format)) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|(other, _)| other != ending), "{ending}");
            assert!(format.description().endings.contains(&(*ending, *format)), "{ending}");
        }
        let known = "OBJ, PLY, OFF, STL, glTF, VTK, VTK XML, GIFTI, FreeSurfer, Gmsh or 3MF";
        assert_eq!(titles(), known);
        let written = ".obj, .ply, .off, .stl, .glb, .gltf, .vtk, .gii or .3mf";
        assert_eq!(endings(true), written);
        let functions =
            all.iter().map(|(ending, _)| *ending).filter(|ending| has_functions(ending));
        assert_eq!(functions.collect::<Vec<_>>(), ["vtk", "vtp", "vtu", "gii", "msh"]);
    }
}
