//! The table of formats, from which detection, help, the guide and errors are made.

use super::attributes::MeshFile;
use super::detect::{self, Head};
use super::format::MeshFormat;
use super::gltf::GltfEncoding;
use super::ply::PlyEncoding;
use super::stl::StlEncoding;
use super::{gltf, obj, off, ply, stl};
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
}

impl Stored {
    /// Returns the words of the guide; `None` for what the words of another one imply.
    fn words(self) -> Option<&'static str> {
        Some(match self {
            Self::LoneVertices => "vertices without a face",
            Self::Uv => "texture coordinates",
            Self::Normals => "normals of vertices",
            Self::NormalsBesideColors => return None,
            Self::CornerNormals => "normals of corners",
            Self::Colors => "colours",
            Self::Materials => "names of materials",
            Self::MaterialFiles => "files of materials",
            Self::Groups => "groups and objects",
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
    /// Whether [`write()`](super::write()) knows the format.
    pub is_written: bool,
    /// The encoding that has every digit as text.
    pub text: Option<MeshFormat>,
    /// What a file keeps of the coordinates, for the guide.
    pub coordinates: &'static str,
    pub stores: &'static [Stored],
}

const EVERY_DIGIT: &str = "every digit";

/// The formats. A file has the last one that it fits: those whose content may be taken for another
/// format come first.
pub(super) static FORMATS: [Description; 5] = [
    Description {
        title: "OBJ",
        endings: &[("obj", MeshFormat::Obj)],
        fits: detect::is_obj,
        read: obj::read,
        is_written: true,
        text: Some(MeshFormat::Obj),
        coordinates: EVERY_DIGIT,
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
        coordinates: EVERY_DIGIT,
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
        coordinates: EVERY_DIGIT,
        stores: &[Stored::LoneVertices, Stored::Normals, Stored::Colors],
    },
    Description {
        title: "STL",
        endings: &[("stl", MeshFormat::Stl(StlEncoding::Binary))],
        fits: detect::is_stl,
        read: stl::read,
        is_written: true,
        text: Some(MeshFormat::Stl(StlEncoding::Ascii)),
        coordinates: "single precision; every digit with `mesh --text`",
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
        coordinates: "single precision, from the middle of the mesh",
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

/// Returns the rows of the table of the guide, in Markdown.
pub(super) fn rows() -> String {
    let row = |format: &Description| {
        let endings = format.endings.iter().map(|(ending, _)| format!("`.{ending}`"));
        let endings = endings.collect::<Vec<_>>().join(", ");
        let stored = format.stores.iter().filter_map(|stored| stored.words());
        let stored = stored.collect::<Vec<_>>().join(", ");
        let stored = if stored.is_empty() { "nothing" } else { &stored };
        let has = |what| format.stores.contains(&what);
        let alone =
            has(Stored::Normals) && has(Stored::Colors) && !has(Stored::NormalsBesideColors);
        let instead = if alone { ", the normals only without colours" } else { "" };
        let written = if format.is_written { format.coordinates } else { "read only" };
        format!("| {} | {endings} | {written} | {stored}{instead} |\n", format.title)
    };
    FORMATS.iter().map(row).collect()
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
        assert_eq!(titles(), "OBJ, PLY, OFF, STL or glTF");
        assert_eq!(endings(true), ".obj, .ply, .off, .stl, .glb or .gltf");
    }
}
