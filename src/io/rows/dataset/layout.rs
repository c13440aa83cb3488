//! Where the entries of a dataset lie: in which files, packed by what, and in which chunks.

use std::ffi::{CString, c_char};
use std::fs;
use std::path::{Path, PathBuf};
use std::ptr;

use ::hdf5::dataset::Layout;
use ::hdf5::filters::Filter;
use ::hdf5::plist::{DatasetAccess, DatasetCreate};
use ::hdf5::{Dataset, File};
use ::hdf5_sys::h5d::H5Dopen2;
use ::hdf5_sys::h5i::hid_t;
use ::hdf5_sys::h5p::{H5Pget_virtual_count, H5Pget_virtual_dsetname, H5Pget_virtual_filename};

use super::access;
use crate::base::{available_memory, byte_size};
use crate::io::rows::file::Stamp;

/// Least bytes of unpacked chunks that are kept, and slots of the table that finds them: a prime,
/// as the documentation of HDF5 recommends.
const CACHE: (usize, usize) = (32 << 20, 12_421);

/// The part of the available memory that unpacked chunks may take.
const PART: u64 = 16;

/// Bytes of a chunk in an advice: large enough to be packed well, small enough to be kept.
const CHUNK: usize = 1 << 20;

/// The other files that hold entries of a virtual dataset, and their size and time of modification.
pub(super) type Sources = Vec<(PathBuf, Stamp)>;

/// Finds the files that hold the entries of a virtual dataset in the file `holder`; none for
/// another dataset.
///
/// # Errors
/// The end of a sentence about a dataset that can't be read: HDF5 itself would read missing parts
/// as zeros.
pub(super) fn sources(dataset: &Dataset, holder: &Path) -> Result<Sources, String> {
    let creation = dataset.dcpl().map_err(|e| format!("can't be read: HDF5 says: {e}"))?;
    if !creation.external().is_empty() {
        return Err("has its entries in other files that are not HDF5 (external storage), which \
                    are not read: h5repack copies them into one file"
            .into());
    }
    if creation.layout() != Layout::Virtual {
        return Ok(Vec::new());
    }
    let parts = parts(&creation).map_err(|e| format!("is virtual, and HDF5 says: {e}"))?;
    let (mut all, mut seen) = (Sources::new(), Vec::new());
    for (file, name) in &parts {
        if file.contains("%b") || name.contains("%b") {
            return Err(format!(
                "is virtual, of files named by a pattern ({file}:{name}), which is not read: \
                 name the files when the dataset is made"
            ));
        }
        let refused = |why: &str| format!("is virtual, and its part {file}:{name} {why}");
        if file == "." {
            let own = dataset.file().and_then(|file| file.dataset(name));
            own.map_err(|_| refused("is missing"))?;
            continue;
        }
        let beside = holder.parent().unwrap_or(Path::new("")).join(file);
        let part = (if beside.exists() { beside } else { file.into() }, name.clone());
        if seen.contains(&part) {
            continue;
        }
        let path = &part.0;
        let about = fs::metadata(path).map_err(|_| refused("is missing"))?;
        let (opened, _) =
            access::open(path).map_err(|e| refused(&format!("can't be read: {e}")))?;
        opened.dataset(name).map_err(|_| refused("is missing"))?;
        if all.iter().all(|(other, _)| other != path) {
            all.push((path.clone(), Stamp::of(&about)));
        }
        seen.push(part);
    }
    Ok(all)
}

/// Returns the files and names of the datasets that a virtual dataset consists of. The crate reads
/// them only together with their places, and knows no places of blocks.
fn parts(creation: &DatasetCreate) -> ::hdf5::Result<Vec<(String, String)>> {
    type Getter = unsafe extern "C" fn(hid_t, usize, *mut c_char, usize) -> isize;
    let id = creation.id();
    let fail = || ::hdf5::Error::query().unwrap_or_else(|e| e);
    let text = |getter: Getter, at: usize| {
        // SAFETY: the list is alive; without a buffer, only the length is returned.
        let length = unsafe { getter(id, at, ptr::null_mut(), 0) };
        let length = usize::try_from(length).map_err(|_| fail())?;
        let mut text = vec![0_u8; length + 1];
        // SAFETY: the buffer has room for the text and the zero behind it.
        if unsafe { getter(id, at, text.as_mut_ptr().cast(), text.len()) } < 0 {
            return Err(fail());
        }
        text.truncate(length);
        Ok(String::from_utf8_lossy(&text).into_owned())
    };
    ::hdf5::sync::sync(|| {
        let mut count = 0;
        // SAFETY: `id` is a live property list, `count` a number to write, and `sync` holds the
        // lock of the HDF5 library.
        if unsafe { H5Pget_virtual_count(id, &mut count) } < 0 {
            return Err(fail());
        }
        let part =
            |at| Ok((text(H5Pget_virtual_filename, at)?, text(H5Pget_virtual_dsetname, at)?));
        (0..count).map(part).collect()
    })
}

/// Checks that the library can unpack the entries.
///
/// # Errors
/// The end of a sentence about a dataset that it can't unpack.
pub(super) fn check_filters(dataset: &Dataset) -> Result<(), String> {
    let Some(lacking) = dataset.filters().into_iter().find(|filter| !filter.is_available()) else {
        return Ok(());
    };
    let (number, plugin) = match &lacking {
        Filter::User(number, _) => (*number, known(*number)),
        other => (other.id(), None),
    };
    let name = plugin.map_or_else(|| format!("{lacking:?}"), str::to_owned);
    Err(format!(
        "is packed by {name} (filter {number}), which this HDF5 library lacks: the environment \
         variable HDF5_PLUGIN_PATH names the folder of its plugins, such as \
         `python -c \"import hdf5plugin; print(hdf5plugin.PLUGIN_PATH)\"` prints, and \
         `h5repack -f GZIP=4` packs a file for every HDF5"
    ))
}

/// Returns the name of a filter in the registry of The HDF Group.
fn known(number: i32) -> Option<&'static str> {
    Some(match number {
        307 => "bzip2",
        32_000 => "LZF",
        32_001 => "Blosc",
        32_004 => "LZ4",
        32_008 => "Bitshuffle",
        32_013 => "ZFP",
        32_015 => "Zstandard",
        32_017 => "SZ",
        32_026 => "Blosc2",
        _ => return None,
    })
}

/// The chunks of a dataset that are unpacked as a whole.
#[derive(Debug, Clone)]
pub(super) struct Chunks {
    /// Rows of the matrix in a chunk; 1 for entries that are not packed.
    pub rows: usize,
    /// Bytes of a block of rows that is a chunk high.
    band: usize,
    /// Chunks in such a block.
    count: usize,
    /// An advice, if chunks are unpacked several times.
    pub note: Option<String>,
}

impl Chunks {
    /// Returns the chunks of a dataset whose matrix has this shape and entries of `bytes` bytes;
    /// `transposed` if the rows of the matrix are columns of the dataset.
    pub fn of(dataset: &Dataset, shape: (usize, usize), bytes: usize, transposed: bool) -> Self {
        let none = Self { rows: 1, band: 0, count: 0, note: None };
        let chunk = dataset.chunk().filter(|_| !dataset.filters().is_empty());
        let (height, width) = match chunk.as_deref() {
            Some(&[height]) => (height, 1),
            Some(&[height, width]) if transposed => (width, height),
            Some(&[height, width]) => (height, width),
            _ => return none,
        };
        let count = shape.1.div_ceil(width.max(1));
        let sides = [height, width, count, bytes];
        let band = sides.iter().try_fold(1_usize, |all, &side| all.checked_mul(side));
        let band = band.unwrap_or(usize::MAX);
        let mut chunks = Self { rows: height.max(1), band, count, ..none };
        let most = chunks.most();
        if band > most {
            let rows = (CHUNK / (shape.1.max(1) * bytes)).clamp(1, shape.0.max(1));
            chunks.note = Some(format!(
                "its chunks of {height} x {width} entries are unpacked once for each block of \
                 rows, because a row of chunks takes {}: `h5repack -l {}:CHUNK={rows}x{}` writes \
                 them for reading by rows",
                byte_size(band as f64),
                dataset.name(),
                shape.1
            ));
        }
        chunks
    }

    /// Returns the most bytes of chunks that are kept.
    fn most(&self) -> usize {
        usize::try_from(available_memory() / PART).unwrap_or(usize::MAX).max(CACHE.0)
    }

    /// Opens the dataset of this name such that a row of chunks is kept, where memory allows it:
    /// each chunk is then unpacked once, however many blocks of rows it spans.
    pub fn open(&self, file: &File, name: &str) -> ::hdf5::Result<Dataset> {
        let (bytes, slots) = match self.band <= self.most() {
            true => (self.band.max(CACHE.0), CACHE.1.max(10 * self.count + 1)),
            false => CACHE,
        };
        let access = DatasetAccess::build().chunk_cache(slots, bytes, 1.0).finish()?;
        let name = CString::new(name).map_err(|e| ::hdf5::Error::Internal(e.to_string()))?;
        ::hdf5::sync::sync(|| {
            // SAFETY: `file` and `access` keep their handles alive, `name` ends with a NUL, and
            // `sync` holds the lock of the HDF5 library.
            let id = unsafe { H5Dopen2(file.id(), name.as_ptr(), access.id()) };
            if id < 0 {
                return Err(::hdf5::Error::query().unwrap_or_else(|e| e));
            }
            // SAFETY: a new identifier, which the handle then owns.
            unsafe { ::hdf5::from_id(id) }
        })
    }
}
