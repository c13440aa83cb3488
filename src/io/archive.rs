//! A matrix in an `.npz` file: one of its arrays, or a sparse matrix as `scipy.sparse.save_npz`
//! writes it.

use std::fmt::Display;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use sprs::TriMat;
use zip::ZipArchive;

use super::columns::{Columns, listed};
use super::limits::{SourceOptions, check_memory, memory_limit};
use super::matrix::Matrix;
use super::rounding::RoundedIntegers;
use super::source::{Source, error, error_at};
use super::{npy, npy_header};
use crate::base::{Error, Result};

/// Reads the array of this name; without one, the only array, or the sparse matrix. Returns all of
/// its columns, and which integers in those that are kept were rounded; of a sparse matrix, in any.
pub(super) fn read(
    path: &Path,
    array: Option<&str>,
    options: &SourceOptions<'_>,
    columns: &Columns,
) -> Result<(Matrix, Option<RoundedIntegers>)> {
    let mut archive = Archive::open(path, options)?;
    let names = archive.names()?;
    let has = |name: &&str| names.iter().any(|other| other == name);
    match (array, &names[..]) {
        (Some(name), _) => archive.matrix(name, columns),
        (None, [name]) => archive.matrix(name, columns),
        (None, _) if ["format", "shape", "data"].iter().all(has) => archive.sparse(),
        (None, names) => {
            let names = listed(names);
            Err(archive.fail(format!("FILE.npz:NAME chooses one of its arrays: {names}")))
        }
    }
}

/// Returns the name of the array in a file of an archive: that of the file without one `.npy`.
pub(super) fn array_name(file: &str) -> &str {
    file.strip_suffix(".npy").unwrap_or(file)
}

/// An open file.
struct Archive {
    path: PathBuf,
    zip: ZipArchive<BufReader<File>>,
    /// Bytes of memory that an array may take.
    memory: u64,
}

impl Archive {
    fn open(path: &Path, options: &SourceOptions<'_>) -> Result<Self> {
        let file = File::open(path).map_err(|e| error_at(path, None, e))?;
        let about = file.metadata().map_err(|e| error_at(path, None, e))?;
        let memory = memory_limit(about.len(), options.max_memory);
        let zip = ZipArchive::new(BufReader::new(file));
        let zip = zip.map_err(|e| error(path, None, e.to_string()))?;
        options.progress.report(0.0)?;
        Ok(Self { path: path.into(), zip, memory })
    }

    fn fail(&self, what: impl Display) -> Error {
        error(&self.path, None, what.to_string())
    }

    /// Returns the names of the arrays.
    fn names(&self) -> Result<Vec<String>> {
        let names = self.zip.file_names().map(|name| match name {
            Ok(name) => Ok(array_name(&name).to_owned()),
            Err(e) => Err(self.fail(e)),
        });
        names.collect()
    }

    /// Returns the bytes of an array with its header, unpacked.
    fn bytes(&mut self, name: &str) -> Result<Vec<u8>> {
        let (path, memory) = (&self.path, self.memory);
        let fail = |e: &dyn Display| error(path, None, format!("`{name}`: {e}"));
        let at = self.zip.index_for_name(&format!("{name}.npy"));
        let Some(at) = at.or_else(|| self.zip.index_for_name(name)) else {
            return Err(error(path, None, format!("has no array `{name}`")));
        };
        let entry = self.zip.by_index(at).map_err(|e| fail(&e))?;
        check_memory(memory, format_args!("`{name}`"), entry.size())
            .map_err(|what| error(path, None, what))?;
        let mut bytes = Vec::new();
        // What is announced may be less than what is there.
        entry.take(memory).read_to_end(&mut bytes).map_err(|e| fail(&e))?;
        Ok(bytes)
    }

    fn matrix(
        &mut self,
        name: &str,
        columns: &Columns,
    ) -> Result<(Matrix, Option<RoundedIntegers>)> {
        let bytes = self.bytes(name)?;
        npy::read_counting(&mut Source::of_bytes(&self.path, &bytes), &Columns::ALL, columns)
    }

    /// Returns the entries of a vector, and which integers were rounded.
    fn vector(&mut self, name: &str) -> Result<(Vec<f64>, Option<RoundedIntegers>)> {
        let (matrix, rounded) = self.matrix(name, &Columns::ALL)?;
        if matrix.ncols() != 1 {
            return Err(self.fail(format!("`{name}` is not a vector")));
        }
        let rows = 0..matrix.nrows();
        let values = match &matrix {
            Matrix::F32(dense) => rows.map(|i| f64::from(dense.as_ref()[(i, 0)])).collect(),
            Matrix::F64(dense) => rows.map(|i| dense.as_ref()[(i, 0)]).collect(),
            Matrix::Complex(_) => return Err(self.fail(format!("`{name}` is complex"))),
            Matrix::Sparse(_) => Vec::new(),
        };
        Ok((values, rounded))
    }

    /// Returns a vector of whole numbers of at least 0.
    fn numbers(&mut self, name: &str) -> Result<Vec<usize>> {
        let (values, _) = self.vector(name)?;
        let whole = |&value: &f64| (value >= 0.0 && value.fract() == 0.0).then_some(value as usize);
        let found: Option<Vec<usize>> = values.iter().map(whole).collect();
        found.ok_or_else(|| self.fail(format!("`{name}` has an entry that is no index")))
    }

    /// Returns the sparse matrix of the arrays `format`, `shape`, `data` and the indices.
    fn sparse(&mut self) -> Result<(Matrix, Option<RoundedIntegers>)> {
        let bytes = self.bytes("format")?;
        let header = npy_header::read(&mut &bytes[..]).map_err(|e| self.fail(e))?;
        // One byte or four a character, of which the others are zeros.
        let letters = bytes[header.offset as usize..].iter().filter(|&&byte| byte != 0);
        let format: String = letters.map(|&byte| char::from(byte)).collect();
        if !matches!(&format[..], "coo" | "csr" | "csc") {
            let what = format!("a sparse matrix of format {format:?}: save it as csr, csc or coo");
            return Err(self.fail(what));
        }
        let &[nrows, ncols] = &self.numbers("shape")?[..] else {
            return Err(self.fail("`shape` has not two entries"));
        };
        let (data, mut rounded) = self.vector("data")?;
        if let Some(rounded) = &mut rounded {
            rounded.place = format!("`data`, {}", rounded.place);
        }
        let (rows, columns) = match format.as_str() {
            "coo" => (self.numbers("row")?, self.numbers("col")?),
            _ => {
                let (inner, starts) = (self.numbers("indices")?, self.numbers("indptr")?);
                let is_sorted = starts.first() == Some(&0) && starts.is_sorted();
                let outer = if format == "csr" { nrows } else { ncols };
                let is_whole = starts.last() == Some(&inner.len());
                if !is_sorted || !is_whole || starts.len().checked_sub(1) != Some(outer) {
                    return Err(self.fail("`indptr` does not fit `indices` and `shape`"));
                }
                let count = |i: usize| starts[i + 1] - starts[i];
                let outer = (0..outer).flat_map(|i| std::iter::repeat_n(i, count(i))).collect();
                if format == "csr" { (outer, inner) } else { (inner, outer) }
            }
        };
        let is_inside = rows.iter().all(|&i| i < nrows) && columns.iter().all(|&j| j < ncols);
        if rows.len() != data.len() || columns.len() != data.len() || !is_inside {
            return Err(self.fail("the indices of the sparse matrix do not fit `data` and `shape`"));
        }
        // Rows without entries take memory, too.
        let bytes = (nrows as u64).saturating_mul(size_of::<usize>() as u64);
        check_memory(self.memory, format_args!("a sparse matrix of {nrows} rows"), bytes)
            .map_err(|what| self.fail(what))?;
        let entries = TriMat::from_triplets((nrows, ncols), rows, columns, data);
        Ok((Matrix::Sparse(entries.to_csr()), rounded))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use zip::write::SimpleFileOptions;

    use super::*;
    use crate::io::tests::{Folder, doubles, npy};
    use crate::io::{ReadOptions, read as read_matrix};

    fn ints(values: &[i32]) -> Vec<u8> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        npy("<i4", "False", &format!("({},)", values.len()), &bytes)
    }

    fn archive(folder: &Folder, name: &str, arrays: &[(&str, Vec<u8>)]) -> PathBuf {
        let path = folder.path(name);
        let mut zip = zip::ZipWriter::new(File::create(&path).unwrap());
        for (name, bytes) in arrays {
            zip.start_file(format!("{name}.npy"), SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap();
        path
    }

    fn named(path: &Path, end: &str) -> Result<Matrix> {
        read_matrix(&PathBuf::from(format!("{}{end}", path.display())), &ReadOptions::new())
    }

    #[test]
    fn arrays_of_any_type_are_chosen_by_name() {
        let folder = Folder::new();
        let arrays = [("a", ints(&[1, 2])), ("b", npy("|b1", "False", "(1, 2)", &[1, 0]))];
        let path = archive(&folder, "a.npz", &arrays);
        assert_eq!(doubles(&named(&path, ":a").unwrap()), faer::mat![[1.0], [2.0]]);
        assert_eq!(doubles(&named(&path, ":b").unwrap()), faer::mat![[1.0, 0.0]]);
        for (end, why) in
            [("", "FILE.npz:NAME chooses one of its arrays: a, b"), (":c", "has no array `c`")]
        {
            let said = named(&path, end).unwrap_err().to_string();
            assert!(said.contains("a.npz: ") && said.contains(why), "{said}");
        }
        let one = archive(&folder, "one.npz", &arrays[..1]);
        assert_eq!(named(&one, "").unwrap().nrows(), 2);
    }

    #[test]
    fn names_of_arrays_may_end_as_those_of_files_do() {
        let folder = Folder::new();
        let path = archive(&folder, "a.npz", &[("x", ints(&[1])), ("x.npy", ints(&[2]))]);
        assert_eq!(doubles(&named(&path, ":x").unwrap()), faer::mat![[1.0]]);
        assert_eq!(doubles(&named(&path, ":x.npy").unwrap()), faer::mat![[2.0]]);
        let said = named(&path, "").unwrap_err().to_string();
        assert!(said.contains("FILE.npz:NAME chooses one of its arrays: x, x.npy"), "{said}");
        // The only array needs no name.
        let one = archive(&folder, "one.npz", &[("x.npy", ints(&[3]))]);
        assert_eq!(doubles(&named(&one, "").unwrap()), faer::mat![[3.0]]);
    }

    #[test]
    fn sparse_matrices_of_scipy_are_read() {
        let folder = Folder::new();
        let format = |name: &str| ("format", npy("|S3", "False", "()", name.as_bytes()));
        let parts = || {
            [("shape", ints(&[2, 3])), ("data", ints(&[5, 6, 7])), ("indices", ints(&[2, 0, 2]))]
        };
        let expected = faer::mat![[0.0, 0.0, 5.0], [6.0, 0.0, 7.0]];
        let with = |name: &str, more: &[(&'static str, Vec<u8>)]| {
            let all = [&parts()[..], &[format(name)], more].concat();
            named(&archive(&folder, "s.npz", &all), "")
        };
        let csr = with("csr", &[("indptr", ints(&[0, 1, 3]))]).unwrap();
        assert!(matches!(csr, Matrix::Sparse(_)));
        assert_eq!(doubles(&csr), expected);
        let wrong = with("csr", &[("indptr", ints(&[0, 1, 9]))]).unwrap_err().to_string();
        assert!(wrong.contains("`indptr` does not fit"), "{wrong}");
        let other = with("dia", &[]).unwrap_err().to_string();
        assert!(other.contains("format \"dia\""), "{other}");
        let coo = [format("coo"), ("row", ints(&[0, 1, 1])), ("col", ints(&[2, 0, 2]))];
        let coo = [&parts()[..2], &coo].concat();
        assert_eq!(doubles(&named(&archive(&folder, "c.npz", &coo), "").unwrap()), expected);
        let outside = [format("coo"), ("row", ints(&[0, 1, 2])), ("col", ints(&[2, 0, 2]))];
        let outside = [&parts()[..2], &outside].concat();
        assert!(named(&archive(&folder, "o.npz", &outside), "").is_err());
    }
}
