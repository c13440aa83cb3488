//! Arrays of numbers in a MATLAB 5 file, by name; those of a structure as `structure.field`.

use std::io::Read;

use crate::Result;

/// Length of the text and version at the start of a file.
const HEADER: usize = 128;

/// Kinds of elements: a compressed one, and an array.
const COMPRESSED: u32 = 15;
const MATRIX: u32 = 14;

/// Class of an array that is a structure, and the classes of numbers.
const STRUCTURE: u8 = 2;
const NUMBERS: std::ops::RangeInclusive<u8> = 6..=15;

/// Returns all arrays of numbers, columns one after the other.
///
/// # Errors
/// When the file ends early or is of another version.
pub fn arrays(file: &[u8]) -> Result<Vec<(String, Vec<f64>)>> {
    // The two last bytes tell the order of bytes.
    if file.get(HEADER - 2..HEADER) != Some(b"IM") {
        return Err("is no MATLAB 5 file of little-endian numbers".into());
    }
    let mut found = Vec::new();
    let mut rest = &file[HEADER..];
    while !rest.is_empty() {
        let element = Element::take(&mut rest)?;
        if element.kind == COMPRESSED {
            let mut whole = Vec::new();
            flate2::read::ZlibDecoder::new(element.data).read_to_end(&mut whole)?;
            add(&Element::take(&mut &whole[..])?, "", &mut found)?;
        } else {
            add(&element, "", &mut found)?;
        }
    }
    Ok(found)
}

struct Element<'a> {
    kind: u32,
    data: &'a [u8],
}

impl<'a> Element<'a> {
    /// Takes the next element and what fills its last 8 bytes.
    fn take(rest: &mut &'a [u8]) -> Result<Self> {
        let word = |at: usize| -> Result<u32> {
            let bytes = rest.get(at..at + 4).ok_or("ends early")?;
            Ok(u32::from_le_bytes(bytes.try_into()?))
        };
        let first = word(0)?;
        // A short element has its length in the upper half of the first word.
        let (kind, start, len) = match first >> 16 {
            0 => (first, 8, word(4)? as usize),
            len => (first & 0xffff, 4, len as usize),
        };
        let data = rest.get(start..start + len).ok_or("ends early")?;
        let end = match (start, kind) {
            (4, _) => 8,
            // Nothing fills up what is compressed.
            (_, COMPRESSED) => start + len,
            _ => start + len.next_multiple_of(8),
        };
        *rest = rest.get(end..).unwrap_or_default();
        Ok(Self { kind, data })
    }

    fn numbers(&self) -> Result<Vec<f64>> {
        fn all<const N: usize>(data: &[u8], number: fn([u8; N]) -> f64) -> Vec<f64> {
            data.as_chunks().0.iter().map(|&bytes| number(bytes)).collect()
        }
        let data = self.data;
        Ok(match self.kind {
            1 => all(data, |b| f64::from(i8::from_le_bytes(b))),
            2 => all(data, |b| f64::from(u8::from_le_bytes(b))),
            3 => all(data, |b| f64::from(i16::from_le_bytes(b))),
            4 => all(data, |b| f64::from(u16::from_le_bytes(b))),
            5 => all(data, |b| f64::from(i32::from_le_bytes(b))),
            6 => all(data, |b| f64::from(u32::from_le_bytes(b))),
            7 => all(data, |b| f64::from(f32::from_le_bytes(b))),
            9 => all(data, f64::from_le_bytes),
            kind => return Err(format!("has numbers of the unknown type {kind}").into()),
        })
    }
}

/// Adds the array of an element, or those of a structure.
fn add(element: &Element<'_>, prefix: &str, found: &mut Vec<(String, Vec<f64>)>) -> Result<()> {
    // A field without a value has no content at all.
    if element.kind != MATRIX || element.data.is_empty() {
        return Ok(());
    }
    let mut rest = element.data;
    let mut next = || Element::take(&mut rest);
    let (flags, _sizes, name) = (next()?, next()?, next()?);
    let class = flags.data.first().copied().unwrap_or_default();
    let name = format!("{prefix}{}", String::from_utf8_lossy(name.data));
    if NUMBERS.contains(&class) {
        found.push((name, next()?.numbers()?));
    } else if class == STRUCTURE {
        let len = next()?.numbers()?.first().copied().unwrap_or_default() as usize;
        let names = next()?;
        for field in names.data.chunks(len.max(1)) {
            let field: Vec<u8> = field.iter().copied().take_while(|&byte| byte != 0).collect();
            let prefix = format!("{name}.{}", String::from_utf8_lossy(&field));
            add(&next()?, &prefix, found)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn element(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }

    fn array(class: u8, name: &str, content: &[u8]) -> Vec<u8> {
        let flags = element(6, &[class, 0, 0, 0, 0, 0, 0, 0]);
        let sizes = element(5, &[1, 0, 0, 0, 1, 0, 0, 0]);
        element(MATRIX, &[&flags[..], &sizes, &element(1, name.as_bytes()), content].concat())
    }

    fn file(elements: &[&[u8]]) -> Vec<u8> {
        let mut bytes = vec![b' '; HEADER - 4];
        bytes.extend([0, 1, b'I', b'M']);
        bytes.extend(elements.concat());
        bytes
    }

    #[test]
    fn numbers_are_read_whole_short_compressed_and_in_structures() {
        // A short element: two numbers of 16 bits in the second word.
        let short = array(11, "few", &[4, 0, 4, 0, 3, 0, 9, 0]);
        let doubles = element(9, &[1.5_f64.to_le_bytes(), (-2.0_f64).to_le_bytes()].concat());
        let plain = array(6, "x", &doubles);
        let fields = [
            element(5, &4_i32.to_le_bytes()),
            element(1, b"a\0\0\0cor\0"),
            array(9, "", &element(2, &[7, 8])),
            array(9, "", &element(2, &[1])),
        ];
        let structure = array(STRUCTURE, "shape", &fields.concat());
        let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(&structure).unwrap();
        let packed = packed.finish().unwrap();
        let mut compressed =
            [COMPRESSED.to_le_bytes(), (packed.len() as u32).to_le_bytes()].concat();
        compressed.extend(packed);
        let found = arrays(&file(&[&short, &compressed, &plain])).unwrap();
        let expected = [
            ("few", vec![3.0, 9.0]),
            ("shape.a", vec![7.0, 8.0]),
            ("shape.cor", vec![1.0]),
            ("x", vec![1.5, -2.0]),
        ];
        assert_eq!(found, expected.map(|(name, numbers)| (name.to_string(), numbers)));
        assert!(arrays(&file(&[&plain[..20]])).is_err());
        assert!(arrays(b"MATLAB 7.3").is_err());
    }
}
