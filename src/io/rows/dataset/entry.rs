//! The types of entries that are read as real numbers.

use ::hdf5::types::{FloatSize, IntSize, TypeDescriptor};
use ::hdf5::{Dataset, Datatype};
use ::hdf5_sys::h5t::{H5T_class_t, H5Tget_class};

/// Names of an enumeration in a note.
const LISTED: usize = 4;

/// The type of the entries of a dataset, all of which HDF5 converts to f64.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    /// The name of the type.
    pub text: String,
    /// Whether f32 holds every entry, and no other type of the file is smaller.
    pub is_single: bool,
    /// The bits of a signed integer.
    pub signed_bits: Option<u32>,
    /// Integers of 8 bytes, some of which are no f64.
    pub long: Option<Long>,
    /// What a user may not expect.
    pub note: Option<String>,
}

/// A type of integers of 8 bytes.
#[derive(Debug, Clone, Copy)]
pub(super) enum Long {
    Signed,
    Unsigned,
}

impl Entry {
    /// Returns the type of the entries.
    ///
    /// # Errors
    /// The end of a sentence about a dataset whose entries are not real numbers.
    pub fn of(dataset: &Dataset) -> Result<Self, String> {
        let kind = dataset.dtype().map_err(|e| format!("has no type: HDF5 says: {e}"))?;
        let known = match kind.to_descriptor() {
            Ok(known) => known,
            Err(e) => return unusual(&kind, &e),
        };
        let mut entry = Self {
            text: known.to_string(),
            is_single: false,
            signed_bits: None,
            long: None,
            note: None,
        };
        match known {
            TypeDescriptor::Float(size) => entry.is_single = size == FloatSize::U4,
            TypeDescriptor::Integer(size) => {
                entry.signed_bits = Some(bits(size));
                entry.long = (size == IntSize::U8).then_some(Long::Signed);
            }
            TypeDescriptor::Unsigned(size) => {
                entry.long = (size == IntSize::U8).then_some(Long::Unsigned);
            }
            TypeDescriptor::Boolean => {}
            TypeDescriptor::Enum(names) => {
                let count = names.members.len();
                let mut first: Vec<_> = names.members.iter().collect();
                first.sort_by_key(|member| member.value);
                first.truncate(LISTED);
                let name = |member: &&::hdf5::types::EnumMember| {
                    format!("{} = {}", member.name, member.value)
                };
                let first: Vec<_> = first.iter().map(name).collect();
                let more = if count > LISTED { ", ..." } else { "" };
                entry.note =
                    Some(format!("its names are read as numbers: {}{more}", first.join(", ")));
                entry.text = "enum".into();
            }
            other => return Err(format!("has entries of type {other}, not real numbers")),
        }
        Ok(entry)
    }
}

/// Returns a type of numbers that the library has no name for: floating point of other sizes.
fn unusual(kind: &Datatype, e: &::hdf5::Error) -> Result<Entry, String> {
    // SAFETY: `kind` keeps its handle alive, and `sync` holds the lock of the HDF5 library.
    let class = ::hdf5::sync::sync(|| unsafe { H5Tget_class(kind.id()) });
    if class != H5T_class_t::H5T_FLOAT {
        return Err(format!("has entries of a type that is not read: {e}"));
    }
    let bytes = kind.size();
    let note = format!("its numbers of {bytes} bytes are rounded to double precision");
    Ok(Entry {
        text: format!("float of {bytes} bytes"),
        is_single: false,
        signed_bits: None,
        long: None,
        note: (bytes > size_of::<f64>()).then_some(note),
    })
}

fn bits(size: IntSize) -> u32 {
    match size {
        IntSize::U1 => 8,
        IntSize::U2 => 16,
        IntSize::U4 => 32,
        IntSize::U8 => 64,
    }
}
