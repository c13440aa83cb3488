//! The JSON and the buffers of a glTF file: in one binary file, in the JSON as base64, or in
//! separate files.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::super::beside::beside;
use super::super::draft::{Checked, Fault};
use super::super::stored::from_base64;
use super::super::text::without_mark;
use super::document::{Buffer, Document, Draco, Packed, Primitive, View};
use super::extensions::{self, check_required, unsupported};
use super::{draco, meshopt};
use catamaran::base::push;
use catamaran::io::Source;

/// The first bytes of a binary file, and the types of its chunks.
const MAGIC: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";

/// A document and its buffers.
pub(super) struct Content<'b> {
    pub document: Document,
    pub buffers: Vec<Cow<'b, [u8]>>,
    /// The bytes of views that are packed, or what is wrong with them, by the number of the view.
    pub unpacked: BTreeMap<usize, Result<Vec<u8>, String>>,
    /// The numbers of accessors that Draco packs, or what is wrong with them, by the number of the
    /// accessor.
    pub decoded: BTreeMap<usize, Result<Vec<f64>, String>>,
}

impl<'b> Content<'b> {
    /// Reads the container and its document, which are all bytes of a file.
    pub fn read(bytes: &'b [u8], source: &Source<'_>) -> Checked<Self> {
        let (json, binary, is_text) = if bytes.starts_with(MAGIC) {
            let (json, binary) = chunks(bytes)?;
            (json, binary, false)
        } else {
            (bytes, None, true)
        };
        let json = without_mark(json);
        let document: Document = serde_json::from_slice(json).map_err(|e| {
            // Documents of version 1 have the same names with other contents.
            let found: Option<Value> = serde_json::from_slice(json).ok();
            let version = found.and_then(|found| match &found["asset"]["version"] {
                Value::String(version) => Some(version.clone()),
                Value::Number(version) => Some(version.to_string()),
                _ => None,
            });
            if let Some(other) = version.and_then(|version| other_version(&version)) {
                return other;
            }
            let line = is_text.then_some(e.line());
            source.fail_at(line, format!("not the JSON of a glTF file: {e}")).into()
        })?;
        if let Some(other) = other_version(&document.asset.version) {
            return Err(other);
        }
        let least = document.asset.min_version.as_deref().unwrap_or("2.0");
        if least != "2.0" {
            return Err(format!("needs version {least:?} of glTF, and 2.0 is supported").into());
        }
        check_required(&document)?;
        let mut buffers = Vec::new();
        let mut total = 0usize;
        for (i, buffer) in document.buffers.iter().enumerate() {
            let binary = binary.filter(|_| i == 0);
            if is_placeholder(buffer, binary, &document) {
                buffers.push(Cow::default());
                continue;
            }
            total = total.saturating_add(buffer.byte_length);
            source.check_memory::<u8>("the buffers", total)?;
            let content = load(buffer, binary, source.path(), &document);
            buffers.push(content.map_err(|fault| fault.of(|| format!("buffer {i}")))?);
        }
        let mut unpacked = BTreeMap::new();
        for (i, view) in document.buffer_views.iter().enumerate() {
            let Some(packed) = &view.extensions.packed else { continue };
            total = total.saturating_add(packed.count.saturating_mul(packed.byte_stride));
            source.check_memory::<u8>("the buffers", total)?;
            // A view that no mesh has may be broken.
            let content = match unpack(view, packed, &buffers) {
                Err(Fault::Error(error)) => return Err(error.into()),
                Err(Fault::What(what)) => Err(what),
                Ok(content) => Ok(content),
            };
            unpacked.insert(i, content);
        }
        let mut content = Self { document, buffers, unpacked, decoded: BTreeMap::new() };
        content.decoded = content.unpacked_primitives(source)?;
        Ok(content)
    }

    /// Returns the numbers of the accessors of primitives that Draco packs, unless the file has
    /// them unpacked, too.
    fn unpacked_primitives(
        &self,
        source: &Source<'_>,
    ) -> Checked<BTreeMap<usize, Result<Vec<f64>, String>>> {
        let mut decoded = BTreeMap::new();
        // The view that has the numbers of an accessor: primitives with other materials may share
        // a stream.
        let mut views = BTreeMap::new();
        let mut total = 0usize;
        for primitive in self.document.meshes.iter().flat_map(|mesh| &mesh.primitives) {
            let Some(packed) = &primitive.extensions.draco else { continue };
            let view = packed.buffer_view;
            let own = || {
                let named = primitive.attributes.named().map(|(_, accessor)| accessor);
                named.chain(primitive.indices)
            };
            let is_stored = |accessor: usize| self.is_stored(accessor).unwrap_or(true);
            let is_known = |accessor: usize| views.get(&accessor) == Some(&view);
            if primitive.indices.is_none() || own().all(is_stored) || own().all(is_known) {
                continue;
            }
            let numbers: Vec<_> = match self.unpack_primitive(primitive, packed, source.memory()) {
                Err(Fault::Error(error)) => return Err(error.into()),
                // A primitive of no node may be broken.
                Err(Fault::What(what)) => {
                    let what = format!("{}: {what}", draco::NAME);
                    own().map(|accessor| (accessor, Err(what.clone()))).collect()
                }
                Ok(numbers) => numbers.into_iter().map(|(i, values)| (i, Ok(values))).collect(),
            };
            for (accessor, values) in numbers {
                if views.insert(accessor, view).is_some_and(|other| other != view) {
                    let what = format!("accessor {accessor} is packed in two views");
                    return Err(format!("{}: {what}", draco::NAME).into());
                }
                total = total.saturating_add(values.as_ref().map_or(0, Vec::len));
                source.check_memory::<f64>("what Draco unpacks to", total)?;
                decoded.insert(accessor, values);
            }
        }
        Ok(decoded)
    }

    /// Returns the numbers of each accessor of a primitive that Draco packs.
    fn unpack_primitive(
        &self,
        primitive: &Primitive,
        packed: &Draco,
        memory: u64,
    ) -> Checked<Vec<(usize, Vec<f64>)>> {
        let number = packed.buffer_view;
        let views = &self.document.buffer_views;
        let view = views.get(number);
        let view = view.ok_or_else(|| format!("view {number} is out of range"))?;
        let unpacked = draco::Unpacked::new(self.bytes(number, view)?, memory)?;
        let mut numbers = Vec::new();
        if let Some(indices) = primitive.indices {
            push(&mut numbers, (indices, unpacked.corners()?))?;
        }
        for (name, accessor) in primitive.attributes.named() {
            // The file has the values of other attributes, of the same vertices.
            let Some(&id) = packed.attributes.get(name) else { continue };
            let values = unpacked.values(id, self.accessor(accessor)?)?;
            push(&mut numbers, (accessor, values))?;
        }
        Ok(numbers)
    }
}

/// Returns whether a buffer stands for the bytes that packed views unpack to.
fn is_placeholder(buffer: &Buffer, binary: Option<&[u8]>, document: &Document) -> bool {
    let own = buffer.extensions.unpacked.as_ref();
    let is_absent = buffer.uri.is_none() && binary.is_none();
    let is_used = || document.extensions_used.iter().any(|name| name == meshopt::NAME);
    own.is_some_and(|own| own.fallback) || (is_absent && (own.is_some() || is_used()))
}

/// Returns the bytes of a view that is packed.
fn unpack(view: &View, packed: &Packed, buffers: &[Cow<'_, [u8]>]) -> Checked<Vec<u8>> {
    let stride = packed.byte_stride;
    if view.byte_stride.is_some_and(|own| own != stride)
        || packed.count.checked_mul(stride) != Some(view.byte_length)
    {
        let Packed { count, .. } = packed;
        return Err(format!("does not have the size of {count} packed elements").into());
    }
    let buffer = buffers.get(packed.buffer);
    let data = buffer.and_then(|all| all.get(packed.byte_offset..)?.get(..packed.byte_length));
    meshopt::unpacked(packed, data.ok_or("the packed bytes are beyond their buffer")?)
}

/// Returns the error about a version that is not supported.
fn other_version(version: &str) -> Option<Fault> {
    if version.is_empty() {
        return Some("JSON, but not of glTF: it has no asset with a version".into());
    }
    let what = format!("version {version:?} of glTF is not supported, must be 2.0: export it anew");
    (!version.starts_with("2.")).then_some(what.into())
}

/// Returns the JSON and the buffer of a binary file.
fn chunks(bytes: &[u8]) -> Checked<(&[u8], Option<&[u8]>)> {
    let truncated = || Fault::from("truncated: the file ends too early");
    let word = |bytes: &[u8]| -> Checked<usize> {
        let bytes = bytes.first_chunk::<4>().ok_or_else(truncated)?;
        Ok(u32::from_le_bytes(*bytes) as usize)
    };
    let (head, _) = bytes.split_at_checked(12).ok_or_else(truncated)?;
    let (version, length) = (word(&head[4..])?, word(&head[8..])?);
    if version != 2 {
        let what =
            format!("version {version} of binary glTF is not supported, must be 2: export it anew");
        return Err(what.into());
    }
    let mut rest = bytes.get(12..length).ok_or_else(truncated)?;
    let mut json = None;
    let mut binary = None;
    while !rest.is_empty() {
        let (head, after) = rest.split_at_checked(8).ok_or_else(truncated)?;
        let (content, after) = after.split_at_checked(word(head)?).ok_or_else(truncated)?;
        match &head[4..] {
            JSON if json.is_none() => json = Some(content),
            BIN if binary.is_none() => binary = Some(content),
            _ => {}
        }
        rest = after;
    }
    Ok((json.ok_or("a binary glTF file without a chunk of JSON")?, binary))
}

/// Returns the bytes of a buffer: `binary` where the buffer has no URI, otherwise those of the URI
/// or of the file beside `path` that it names.
fn load<'b>(
    buffer: &Buffer,
    binary: Option<&'b [u8]>,
    path: &Path,
    document: &Document,
) -> Checked<Cow<'b, [u8]>> {
    let length = buffer.byte_length;
    let bytes: Cow<'b, [u8]> = match buffer.uri.as_deref() {
        None => match (binary, extensions::source(&buffer.extensions.others, document)) {
            (Some(binary), _) => binary.into(),
            (None, Some(name)) => return Err(unsupported(name)),
            (None, None) => return Err("has no URI, and is not in the file".into()),
        },
        Some(uri) => match uri.strip_prefix("data:") {
            Some(data) => embedded(data)?.into(),
            None => {
                let name = unescaped(uri).ok_or_else(|| format!("broken URI {uri:?}"))?;
                beside(&name, path, 0, length)?.into()
            }
        },
    };
    if bytes.len() < length {
        return Err(format!("has {} of {length} bytes", bytes.len()).into());
    }
    Ok(match bytes {
        Cow::Borrowed(bytes) => bytes[..length].into(),
        Cow::Owned(mut bytes) => {
            bytes.truncate(length);
            bytes.into()
        }
    })
}

/// Returns the bytes of a data URI; `data` is what follows `data:`.
fn embedded(data: &str) -> Checked<Vec<u8>> {
    let (_, text) = data.split_once(";base64,").ok_or("a data URI that is not in base64")?;
    from_base64(text.as_bytes())
}

/// Returns a URI with its escapes, such as %20, replaced.
fn unescaped(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        rest = after;
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let (digits, after) = rest.split_at_checked(2)?;
        let digits = std::str::from_utf8(digits).ok()?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        rest = after;
    }
    String::from_utf8(bytes).ok()
}
