//! The table of formats, from which detection, help, the guide and errors are made.

use super::attributes::MeshFile;
use super::detect::{self, Head};
use super::format::MeshFormat;
use super::gltf::GltfEncoding;
use super::ply::PlyEncoding;
use super::stl::StlEncoding;
use super::vtk::{self, VtkEncoding};
use super::{freesurfer, gifti, gltf, gmsh, obj, off, ply, stl, threemf};
use catamaran::base::Result;
use catamaran::io::Source;

/// What a format can store besides a mesh without lone vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stored {
    LoneVertices,
    Uv,
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
    /// Whether [`write()`](super::write()) knows the format.
    pub is_written: bool,
    /// The encoding that has every digit as text.
    pub text: Option<MeshFormat>,
    pub stores: &'static [Stored],
}

/// The formats. A file has the last one that it fits: those whose content may be taken for another
/// format come first.
pub(super) static FORMATS: [Description; 11] = [
    Description {
        title: "OBJ",
        endings: &[("obj", MeshFormat::Obj)],
        fits: detect::is_obj,
        read: obj::read,
        is_written: true,
        text: Some(MeshFormat::Obj),
        stores: &[
            Stored::LoneVertices,
            Stored::Uv,
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
        is_written: true,
        text: Some(MeshFormat::Ply(PlyEncoding::Ascii)),
        stores: &[
            Stored::LoneVertices,
            Stored::Uv,
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
        is_written: true,
        text: Some(MeshFormat::Off),
        stores: &[Stored::LoneVertices, Stored::Normals, Stored::Colors],
    },
    Description {
        title: "STL",
        endings: &[("stl", MeshFormat::Stl(StlEncoding::Binary))],
        fits: detect::is_stl,
        read: stl::read,
        is_written: true,
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
        is_written: true,
        text: None,
        stores: &[
            Stored::LoneVertices,
            Stored::Uv,
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
        is_written: true,
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
        is_written: false,
        text: None,
        stores: &[],
    },
    Description {
        title: "GIFTI",
        endings: &[("gii", MeshFormat::Gifti)],
        fits: detect::is_gifti,
        read: gifti::read,
        is_written: true,
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
        is_written: false,
        text: None,
        stores: &[],
    },
    Description {
        title: "Gmsh",
        endings: &[("msh", MeshFormat::Gmsh)],
        fits: detect::is_gmsh,
        read: gmsh::read,
        is_written: false,
        text: None,
        stores: &[],
    },
    Description {
        title: "3MF",
        endings: &[("3mf", MeshFormat::ThreeMf)],
        fits: detect::is_threemf,
        read: threemf::read,
        is_written: true,
        text: Some(MeshFormat::ThreeMf),
        stores: &[Stored::LoneVertices],
    },
];

/// Returns the names of all formats, such as "OBJ, PLY or glTF".
pub(super) fn titles() -> String {
    in_words(FORMATS.iter().map(|format| format.title.to_owned()))
}

/// Returns the endings of the files that are read or, with `written`, those that are written, such
/// as ".obj, .ply or .glb".
pub(super) fn endings(written: bool) -> String {
    let formats = FORMATS.iter().filter(|format| format.is_written || !written);
    in_words(formats.flat_map(|format| format.endings).map(|(ending, _)| format!(".{ending}")))
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
    }
}
