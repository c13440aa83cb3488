//! Elements of a PLY file and their properties.

use super::super::draft::Checked;
use super::super::notes::Notes;
use super::super::text::quoted;

pub(super) use super::super::stored::Kind as Type;

impl Type {
    /// Parses the name of a type, also of those that programs take over from NumPy.
    pub fn parse(word: &[u8]) -> Checked<Self> {
        let lower = word.to_ascii_lowercase();
        let name = match &lower[..] {
            [b'<' | b'>' | b'=' | b'|', name @ ..] => name,
            name => name,
        };
        Ok(match name {
            b"char" | b"int8" | b"i1" => Self::I8,
            b"uchar" | b"uint8" | b"u1" | b"bool" | b"b1" => Self::U8,
            b"short" | b"int16" | b"i2" => Self::I16,
            b"ushort" | b"uint16" | b"u2" => Self::U16,
            b"int" | b"int32" | b"i4" => Self::I32,
            b"uint" | b"uint32" | b"u4" => Self::U32,
            b"int64" | b"longlong" | b"i8" => Self::I64,
            b"uint64" | b"ulonglong" | b"u8" => Self::U64,
            b"float16" | b"half" | b"f2" => Self::F16,
            b"float" | b"float32" | b"single" | b"f4" => Self::F32,
            b"double" | b"float64" | b"f8" => Self::F64,
            _ => return Err(format!("unknown type {}", quoted(word)).into()),
        })
    }

    /// Returns the integer that represents 1 in a colour; 1 for floating-point types.
    fn full_scale(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::I64 => i64::MAX as f64,
            Self::U64 => u64::MAX as f64,
            Self::F16 | Self::F32 | Self::F64 => 1.0,
        }
    }
}

/// The properties that the reader uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Name {
    X,
    Y,
    Z,
    NormalX,
    NormalY,
    NormalZ,
    U,
    V,
    Red,
    Green,
    Blue,
    Alpha,
    Corners,
    CornerUv,
}

/// The parts of a colour.
pub(super) const COLOR: [Name; 4] = [Name::Red, Name::Green, Name::Blue, Name::Alpha];

/// The parts of a normal.
pub(super) const NORMAL: [Name; 3] = [Name::NormalX, Name::NormalY, Name::NormalZ];

/// The texture coordinates of a vertex.
pub(super) const UV: [Name; 2] = [Name::U, Name::V];

impl Name {
    /// Parses the name of a property.
    pub fn parse(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"x" => Self::X,
            b"y" => Self::Y,
            b"z" => Self::Z,
            b"nx" => Self::NormalX,
            b"ny" => Self::NormalY,
            b"nz" => Self::NormalZ,
            b"s" | b"u" | b"texture_u" => Self::U,
            b"t" | b"v" | b"texture_v" => Self::V,
            b"red" | b"diffuse_red" | b"r" => Self::Red,
            b"green" | b"diffuse_green" | b"g" => Self::Green,
            b"blue" | b"diffuse_blue" | b"b" => Self::Blue,
            b"alpha" | b"a" => Self::Alpha,
            b"vertex_indices" | b"vertex_index" => Self::Corners,
            b"texcoord" => Self::CornerUv,
            _ => return None,
        })
    }
}

/// A property of an element: a scalar or a list.
#[derive(Debug)]
pub(super) struct Property {
    pub name: Option<Name>,
    /// The name in the file, in quotes.
    pub word: String,
    pub item: Type,
    /// The type of the length of a list; `None` for a scalar.
    pub counted_by: Option<Type>,
}

/// An element: rows with the same properties.
#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    /// Returns the index of a scalar among the scalars.
    pub fn scalar(&self, name: Name) -> Option<usize> {
        self.properties.iter().filter(|p| p.counted_by.is_none()).position(|p| p.name == Some(name))
    }

    /// Returns the indices of scalars; `None` unless all exist.
    pub fn scalars<const N: usize>(&self, names: [Name; N]) -> Option<[usize; N]> {
        let places = names.map(|name| self.scalar(name));
        places.iter().all(Option::is_some).then(|| places.map(Option::unwrap_or_default))
    }

    /// Returns the index of a list among the lists.
    pub fn list(&self, name: Name) -> Option<usize> {
        self.properties.iter().filter(|p| p.counted_by.is_some()).position(|p| p.name == Some(name))
    }

    /// Returns whether there is a scalar for each of red, green and blue.
    pub fn has_colors(&self) -> bool {
        self.scalars([Name::Red, Name::Green, Name::Blue]).is_some()
    }

    /// Notes the properties that are not among those that a reader uses.
    pub fn note_unused(&self, used: &[Name], what: &'static str, notes: &mut Notes) {
        let is_unused = |p: &&Property| !p.name.is_some_and(|name| used.contains(&name));
        for property in self.properties.iter().filter(is_unused) {
            notes.add(what, || property.word.clone());
        }
    }

    /// Returns the value of scalar number i that represents 1 in a colour.
    pub fn full_scale(&self, i: usize) -> f64 {
        let mut scalars = self.properties.iter().filter(|p| p.counted_by.is_none());
        scalars.nth(i).map_or(1.0, |p| p.item.full_scale())
    }
}
