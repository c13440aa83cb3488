//! Tables of FlatBuffers, the encoding of Arrow's metadata. Every access is checked.
//! Source: "FlatBuffers internals", <https://flatbuffers.dev/internals/>.

use crate::io::columnar::fault::Fault;

/// A table in bytes.
#[derive(Debug, Clone, Copy)]
pub struct Table<'a> {
    bytes: &'a [u8],
    /// Where the table begins.
    at: usize,
    /// The places of its fields, from its beginning; 0 for one that is not there.
    fields: &'a [u8],
}

fn broken<T>() -> Result<T, Fault> {
    Err("broken metadata".into())
}

/// Returns the N bytes at a place.
fn array<const N: usize>(bytes: &[u8], at: usize) -> Result<[u8; N], Fault> {
    let found = bytes.get(at..).and_then(|rest| rest.first_chunk::<N>());
    found.copied().map_or_else(broken, Ok)
}

/// Returns the place that the offset at a place leads to.
fn target(bytes: &[u8], at: usize) -> Result<usize, Fault> {
    Ok(at + u32::from_le_bytes(array(bytes, at)?) as usize)
}

impl<'a> Table<'a> {
    /// Returns the table that a message begins with.
    pub fn root(bytes: &'a [u8]) -> Result<Self, Fault> {
        Self::at(bytes, target(bytes, 0)?)
    }

    fn at(bytes: &'a [u8], at: usize) -> Result<Self, Fault> {
        let back = i64::from(i32::from_le_bytes(array(bytes, at)?));
        let Ok(start) = usize::try_from(at as i64 - back) else { return broken() };
        let len = usize::from(u16::from_le_bytes(array(bytes, start)?));
        match bytes.get(start..).and_then(|rest| rest.get(4..len)) {
            Some(fields) => Ok(Self { bytes, at, fields }),
            None => broken(),
        }
    }

    /// Returns the place of a field.
    fn place(&self, field: usize) -> Option<usize> {
        let offset = u16::from_le_bytes(array(self.fields, 2 * field).ok()?);
        (offset != 0).then(|| self.at + usize::from(offset))
    }

    /// Returns the bytes of a number; zeros if it is not there.
    pub fn number<const N: usize>(&self, field: usize) -> Result<[u8; N], Fault> {
        self.place(field).map_or(Ok([0; N]), |at| array(self.bytes, at))
    }

    pub fn u8(&self, field: usize) -> Result<u8, Fault> {
        self.number(field).map(u8::from_le_bytes)
    }

    pub fn i16(&self, field: usize) -> Result<i16, Fault> {
        self.number(field).map(i16::from_le_bytes)
    }

    pub fn i32(&self, field: usize) -> Result<i32, Fault> {
        self.number(field).map(i32::from_le_bytes)
    }

    pub fn i64(&self, field: usize) -> Result<i64, Fault> {
        self.number(field).map(i64::from_le_bytes)
    }

    /// Returns whether a field is there.
    pub fn has(&self, field: usize) -> bool {
        self.place(field).is_some()
    }

    pub fn table(&self, field: usize) -> Result<Option<Self>, Fault> {
        let Some(at) = self.place(field) else { return Ok(None) };
        Self::at(self.bytes, target(self.bytes, at)?).map(Some)
    }

    /// Returns the entries, each of N bytes, of a vector; none if it is not there.
    pub fn vector<const N: usize>(&self, field: usize) -> Result<&'a [[u8; N]], Fault> {
        Ok(self.elements(field)?.1)
    }

    /// Returns where a vector begins, and its entries.
    fn elements<const N: usize>(&self, field: usize) -> Result<(usize, &'a [[u8; N]]), Fault> {
        let Some(at) = self.place(field) else { return Ok((0, &[])) };
        let start = target(self.bytes, at)?;
        let len = u32::from_le_bytes(array(self.bytes, start)?) as usize;
        let bytes = self.bytes.get(start + 4..).and_then(|rest| rest.get(..len.checked_mul(N)?));
        bytes.map_or_else(broken, |bytes| Ok((start + 4, bytes.as_chunks::<N>().0)))
    }

    pub fn tables(&self, field: usize) -> Result<Vec<Self>, Fault> {
        let (start, offsets) = self.elements::<4>(field)?;
        (0..offsets.len())
            .map(|i| Self::at(self.bytes, target(self.bytes, start + 4 * i)?))
            .collect()
    }

    pub fn text(&self, field: usize) -> Result<String, Fault> {
        let bytes: Vec<u8> = self.vector::<1>(field)?.iter().map(|&[byte]| byte).collect();
        String::from_utf8(bytes).or_else(|_| broken())
    }
}
