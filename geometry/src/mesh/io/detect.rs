//! Detects the packing and the format of a file from its content.

use super::format::MeshFormat;
use super::gltf::GltfEncoding;
use super::off;
use super::ply::PlyEncoding;
use super::stl::StlEncoding;
use super::text::{number, words};
use catamaran::io::Packing;

/// Number of bytes of a file that are read to detect its format.
pub(super) const LOOK: usize = 1 << 16;

/// Least ratio of lines that are statements of OBJ to lines that are not: programs add statements
/// of their own.
const LEAST_KNOWN: usize = 8;

/// Returns the packing of a file that begins with `head`; the name of the file says `named`.
pub(super) fn packing(head: &[u8], named: Packing) -> Packing {
    match Packing::of_content(head) {
        Packing::None if format(head, None).is_none() => named,
        found => found,
    }
}

/// Returns the format of a file that begins with `head`, and has `size` bytes if that is known;
/// `None` if it fits no format or several.
pub(super) fn format(head: &[u8], size: Option<u64>) -> Option<MeshFormat> {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let head = &head[..head.len().min(LOOK)];
    // The header of binary STL is arbitrary text, so the size decides, not the header.
    if is_binary_stl(head, size) {
        return Some(MeshFormat::Stl(StlEncoding::Binary));
    }
    if head.starts_with(b"glTF") {
        return Some(MeshFormat::Gltf(GltfEncoding::Binary));
    }
    if head.starts_with(b"ply\n") || head.starts_with(b"ply\r") {
        return Some(MeshFormat::Ply(PlyEncoding::Ascii));
    }
    let text = head.trim_ascii_start();
    if text.starts_with(b"{") {
        return Some(MeshFormat::Gltf(GltfEncoding::Text));
    }
    let mut lines = text.split(|&byte| byte == b'\n');
    if text.starts_with(b"solid") {
        let facet = |line: &[u8]| matches!(words(line).next(), Some(b"facet" | b"endsolid"));
        return lines.any(facet).then_some(MeshFormat::Stl(StlEncoding::Ascii));
    }
    // The last line may be incomplete.
    let complete = text.len() - lines.next_back().map_or(0, <[u8]>::len);
    let lines = text[..complete].split(|&byte| byte == b'\n');
    let mut content = lines.filter_map(|line| {
        let mut words = words(line.split(|&byte| byte == b'#').next()?);
        Some((words.next()?, words.next()))
    });
    let (first, second) = content.next()?;
    if off::kind_of(first).is_some() {
        return Some(MeshFormat::Off);
    }
    let is_obj = |(keyword, operand): (&[u8], Option<&[u8]>)| match keyword {
        b"v" | b"vt" | b"vn" => operand.is_some_and(|word| number(word).is_ok()),
        b"f" | b"g" | b"o" | b"s" | b"l" | b"p" | b"mtllib" | b"usemtl" => true,
        _ => false,
    };
    let (mut known, mut unknown) = (0, 0);
    let mut vertices = false;
    for line in std::iter::once((first, second)).chain(content) {
        if is_obj(line) {
            known += 1
        } else {
            unknown += 1
        }
        vertices |= line.0 == b"v";
    }
    (vertices && known >= LEAST_KNOWN * unknown).then_some(MeshFormat::Obj)
}

/// Returns whether the size is that of a header of 80 bytes, a count and that many facets of 50
/// bytes.
fn is_binary_stl(head: &[u8], size: Option<u64>) -> bool {
    let count = head.get(80..84).and_then(|bytes| bytes.first_chunk::<4>());
    let expected = count.map(|&bytes| 84 + 50 * u64::from(u32::from_le_bytes(bytes)));
    expected.is_some() && expected == size
}
