//! Saves and loads rates in the user's cache directory.

use std::env;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use super::Rates;
use crate::base::{Error, Result};
use crate::kernel::packed::isa::FloatIsa;

impl Rates {
    /// Returns the rates that [`Rates::save`] stored for this isa on this machine; `None` when
    /// there are none, or when [`Rates::load`] refuses the file.
    pub fn cached(isa: FloatIsa) -> Option<Self> {
        Self::load(&Self::path(isa)?, isa).ok()
    }

    /// Returns the path of the cache file: `catamaran/rates-<isa>.txt` in `$XDG_CACHE_HOME` or
    /// `~/.cache` (macOS: `~/Library/Caches`, Windows: `%LOCALAPPDATA%`); `None` when the
    /// environment names no such directory. The file need not exist.
    pub fn path(isa: FloatIsa) -> Option<PathBuf> {
        Some(file_in(&directory()?, isa))
    }

    /// Reads rates from a file.
    ///
    /// ```
    /// use catamaran::kernel::packed::{FloatIsa, Rates};
    ///
    /// # let folder = tempfile::tempdir().unwrap();
    /// # let path = &folder.path().join("rates.txt");
    /// let rates = Rates::of(FloatIsa::Portable);
    /// std::fs::write(path, rates.to_text(FloatIsa::Portable)).unwrap();
    /// assert_eq!(Rates::load(path, FloatIsa::Portable)?, rates);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Io`] with the path, and the line if one is at fault, when the file can't be read,
    /// is malformed, or is of another CPU, isa or kind of build ([`Rates::parse`]).
    pub fn load(path: &Path, isa: FloatIsa) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
        Self::parse(&text, isa).map_err(|(line, what)| Error::Io {
            path: path.into(),
            line,
            what,
            cause: None,
        })
    }

    /// Writes the rates to [`Rates::path`] atomically, and returns the path.
    ///
    /// ```no_run
    /// use catamaran::kernel::packed::{FloatIsa, Rates};
    ///
    /// let rates = Rates::measure(FloatIsa::best())?;
    /// let path = rates.save(FloatIsa::best())?;
    /// assert_eq!(Rates::load(&path, FloatIsa::best())?, rates);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when the environment names no directory, [`Error::Io`] when the file
    /// can't be written.
    pub fn save(&self, isa: FloatIsa) -> Result<PathBuf> {
        let why = "the environment names none: set XDG_CACHE_HOME or HOME (Windows: LOCALAPPDATA)";
        let none = || Error::Argument { what: "cache directory", why: why.into() };
        self.save_in(&directory().ok_or_else(none)?, isa)
    }

    fn save_in(&self, directory: &Path, isa: FloatIsa) -> Result<PathBuf> {
        // A temporary file for this call only: other threads and processes may save too.
        static CALLS: AtomicUsize = AtomicUsize::new(0);
        let call = CALLS.fetch_add(1, Ordering::Relaxed);
        let path = file_in(directory, isa);
        let temporary = path.with_extension(format!("{}-{call}.tmp", std::process::id()));
        let write = || -> io::Result<()> {
            std::fs::create_dir_all(directory)?;
            std::fs::write(&temporary, self.to_text(isa))?;
            std::fs::rename(&temporary, &path)
        };
        match write() {
            Ok(()) => Ok(path),
            Err(e) => {
                let _ = std::fs::remove_file(&temporary);
                let what = format!("can't be written: {e}");
                Err(Error::Io { path, line: None, what, cause: Some(e.into()) })
            }
        }
    }
}

fn file_in(directory: &Path, isa: FloatIsa) -> PathBuf {
    directory.join(format!("rates-{}.txt", isa.name()))
}

/// Returns the directory of the cache files, which need not exist.
fn directory() -> Option<PathBuf> {
    // A relative path would name another directory in every working directory.
    let named = |variable| env::var_os(variable).map(PathBuf::from).filter(|p| p.is_absolute());
    let home = || env::home_dir().filter(|p| p.is_absolute());
    let caches = if cfg!(windows) {
        named("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        home().map(|home| home.join("Library/Caches"))
    } else {
        named("XDG_CACHE_HOME").or_else(|| home().map(|home| home.join(".cache")))
    };
    Some(caches?.join("catamaran"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATES: Rates =
        Rates { flops: 3e10, read_bytes: 2e9, pack_bytes: 1.25e9, update_bytes: 4e9 };

    #[test]
    fn what_is_saved_is_loaded_for_the_same_instance_only() {
        let folder = tempfile::tempdir().unwrap();
        let directory = folder.path().join("not there yet");
        for rates in [Rates::of(FloatIsa::Avx2), RATES] {
            let path = rates.save_in(&directory, FloatIsa::Avx2).unwrap();
            assert_eq!(path, directory.join("rates-avx2.txt"));
            assert_eq!(Rates::load(&path, FloatIsa::Avx2), Ok(rates));
            // Nothing else stays behind.
            assert_eq!(std::fs::read_dir(&directory).unwrap().count(), 1);
            let Err(Error::Io { line, .. }) = Rates::load(&path, FloatIsa::Portable) else {
                panic!("rates of avx2 for portable");
            };
            assert_eq!(line, Some(1));
        }
    }

    #[test]
    fn a_file_that_is_broken_or_absent_is_refused_by_path_and_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = RATES.save_in(folder.path(), FloatIsa::Portable).unwrap();
        let text = RATES.to_text(FloatIsa::Portable).replace("1250000000", "fast");
        std::fs::write(&path, text).unwrap();
        let message = Rates::load(&path, FloatIsa::Portable).unwrap_err().to_string();
        assert!(message.contains("rates-portable.txt:4: pack_bytes: \"fast\""), "{message}");
        std::fs::remove_file(&path).unwrap();
        let message = Rates::load(&path, FloatIsa::Portable).unwrap_err().to_string();
        assert!(message.contains("rates-portable.txt: "), "{message}");
    }

    #[test]
    fn a_directory_that_can_not_be_made_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        let message = RATES.save_in(&file, FloatIsa::Portable).unwrap_err().to_string();
        assert!(message.contains("file") && message.contains("can't be written"), "{message}");
    }
}
