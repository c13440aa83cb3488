//! MGH and MGZ: values of vertices, in frames (`.mgh`, and `.mgz`, which is packed by gzip).
//!
//! Format: "MGH file format" (FreeSurfer wiki, FsTutorial/MghFormat); all numbers are big endian.

use super::attributes::Scalars;
use super::cursor::Cursor;
use super::draft::Checked;
use super::stored::{Budget, Kind, whole};
use catamaran::base::{Result, push, reserved};
use catamaran::io::Source;

/// Bytes before the first value.
const HEADER: usize = 284;

/// Most frames that are read, each of which becomes a function with a name.
const MOST_FRAMES: usize = 1 << 12;

/// Returns whether a file that begins so is MGH: version 1, sizes that are not 0, a type of values,
/// and whether it has a place in space, which is 0 or 1.
pub(super) fn begins(head: &[u8]) -> bool {
    let (words, _) = head.as_chunks::<4>();
    let Some(&[version, sizes @ .., kind, _]) = words.first_chunk::<7>() else { return false };
    let is_size = |size: &[u8; 4]| i32::from_be_bytes(*size) > 0;
    u32::from_be_bytes(version) == 1
        && sizes.iter().all(is_size)
        && kind_of(f64::from(u32::from_be_bytes(kind))).is_some()
        && matches!(head.get(28..30), Some([0, 0 | 1]))
}

/// Returns the type of values with this number.
fn kind_of(number: f64) -> Option<Kind> {
    Some(match number {
        0.0 => Kind::U8,
        1.0 => Kind::I32,
        3.0 => Kind::F32,
        4.0 => Kind::I16,
        10.0 => Kind::U16,
        _ => return None,
    })
}

/// Reads the values of vertices: a function for each frame, named `name`, and with the number of
/// the frame after it where there are several.
pub(super) fn scalars(source: &mut Source<'_>, name: &str) -> Result<Vec<Scalars>> {
    let bytes = source.read_all()?;
    let mut cursor = Cursor::new(&bytes);
    match frames(&mut cursor, name, &mut Budget::new(source)) {
        Ok(scalars) => Ok(scalars),
        Err(fault) => Err(cursor.fail(fault, source)),
    }
}

fn frames(
    cursor: &mut Cursor<'_>,
    name: &str,
    budget: &mut Budget<'_, '_>,
) -> Checked<Vec<Scalars>> {
    let mut number = || cursor.stored(Kind::I32, true, "the header");
    let version = number()?;
    if version != 1.0 {
        return Err(format!("version {version} of MGH, must be 1").into());
    }
    // Values of vertices may fill any of the three dimensions.
    let sizes = [whole(number()?)?, whole(number()?)?, whole(number()?)?];
    let vertices = sizes.iter().fold(1, |product: usize, &size| product.saturating_mul(size));
    let frames = whole(number()?)?;
    let kind = number()?;
    let kind = kind_of(kind).ok_or_else(|| format!("unknown type {kind} of values"))?;
    if frames > MOST_FRAMES {
        return Err(format!("{frames} frames, where {MOST_FRAMES} are supported").into());
    }
    cursor.bytes(HEADER - 24, "the header")?;
    budget.take_numbers(vertices.saturating_mul(frames))?;
    let mut scalars = reserved(frames)?;
    for k in 0..frames {
        let values = cursor.numbers(vertices, Some((kind, true)), "the values")?;
        let name = if frames == 1 { name.to_owned() } else { format!("{name}.{k}") };
        push(&mut scalars, Scalars { name, values })?;
    }
    Ok(scalars)
}
