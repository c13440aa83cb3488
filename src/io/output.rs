use std::fs::{File, Metadata, OpenOptions};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use super::source::error;
use crate::base::{Error, Result};

/// What happens to a file that exists already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Overwrite {
    /// It stays, and writing is an error.
    Never,
    /// It is replaced, in one step.
    Replace,
}

/// A file that appears whole or not at all. It is written under another name in the same folder,
/// flushed to the disk, and renamed by [`Output::commit`]. If it is dropped before that, no file is
/// left behind.
///
/// A new file gets the default permissions, less what the umask forbids. A file that replaces
/// another file gets the permissions of that file, and its owner and group where the system allows
/// it. A symbolic link stays a link: the file that it leads to is replaced or created.
///
/// ```
/// use std::io::Write;
/// use catamaran::io::{Output, Overwrite};
///
/// let path = std::env::temp_dir().join(format!("catamaran-output-{}.txt", std::process::id()));
/// let mut output = Output::create(&path, Overwrite::Never)?;
/// output.write_all(b"whole").map_err(|e| output.error(e))?;
/// assert!(!path.exists());
/// output.commit()?;
/// assert!(path.exists() && Output::create(&path, Overwrite::Never).is_err());
/// # std::fs::remove_file(path).unwrap();
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    /// Where the file appears, absolute: the target of the path, if the path is a symbolic link.
    target: PathBuf,
    file: BufWriter<Temporary>,
    overwrite: Overwrite,
    // Dropped after the file, which removes itself from the disk.
    _listed: Listed,
}

/// The temporary files of all outputs.
struct Unfinished {
    paths: Vec<PathBuf>,
    /// Set when the files were discarded: from then on, no output is created or committed.
    is_closed: bool,
}

static UNFINISHED: Mutex<Unfinished> =
    Mutex::new(Unfinished { paths: Vec::new(), is_closed: false });

fn unfinished() -> MutexGuard<'static, Unfinished> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the list while outputs may be created and committed.
fn open_list() -> io::Result<MutexGuard<'static, Unfinished>> {
    let unfinished = unfinished();
    if unfinished.is_closed {
        return Err(io::Error::other(
            "the program discarded its unfinished files, in order to end",
        ));
    }
    Ok(unfinished)
}

/// An entry of [`UNFINISHED`].
#[derive(Debug)]
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().paths.retain(|path| *path != self.0);
    }
}

/// Most names that are tried for a temporary file.
const MOST_NAMES: usize = 1000;

/// An open file that is removed when it is dropped, unless it was renamed.
#[derive(Debug)]
struct Temporary {
    path: PathBuf,
    file: File,
    is_renamed: bool,
}

impl Temporary {
    /// Creates and lists a file with a random name.
    fn create(folder: &Path, options: &OpenOptions) -> io::Result<(Self, Listed)> {
        for _ in 0..MOST_NAMES {
            // Every `RandomState` has keys of its own.
            let random = RandomState::new().build_hasher().finish();
            let path = folder.join(format!(".catamaran-{random:016x}.tmp"));
            // Allocates before the lock: an abort for lack of memory needs the list.
            let (line, listed) = (path.clone(), Listed(path.clone()));
            let mut unfinished = open_list()?;
            unfinished.paths.try_reserve(1)?;
            let opened = options.open(&path);
            if opened.is_ok() {
                unfinished.paths.push(line);
            }
            // `Listed` takes the lock when it is dropped.
            drop(unfinished);
            match opened {
                Ok(file) => return Ok((Self { path, file, is_renamed: false }, listed)),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
        Err(io::Error::other("no name is free for a temporary file"))
    }

    /// Renames the file to `target`, and replaces a file of that name.
    fn replace(mut self, target: &Path) -> io::Result<()> {
        std::fs::rename(&self.path, target)?;
        self.is_renamed = true;
        Ok(())
    }

    /// Renames the file to `target`, which does not exist.
    fn appear(mut self, target: &Path) -> io::Result<()> {
        let is_there = |e: &io::Error| e.kind() == io::ErrorKind::AlreadyExists;
        match std::fs::hard_link(&self.path, target) {
            // The first name goes with `self`.
            Ok(()) => return Ok(()),
            Err(e) if is_there(&e) => return Err(e),
            // Some file systems have no links, such as those of memory cards.
            Err(_) => {}
        }
        match rename_new(&self.path, target) {
            Ok(()) => {
                self.is_renamed = true;
                Ok(())
            }
            Err(e) if is_there(&e) => Err(e),
            // Where the system has no such call, an empty file holds the name meanwhile, and stays
            // if the process is killed then.
            Err(_) => {
                File::create_new(target)?;
                let renamed = self.replace(target);
                if renamed.is_err() {
                    let _ = std::fs::remove_file(target);
                }
                renamed
            }
        }
    }
}

/// Renames a file to `to`, which does not exist, in one step.
#[cfg(target_os = "linux")]
fn rename_new(from: &Path, to: &Path) -> io::Result<()> {
    use std::ffi::CString;
    use std::os::unix::ffi::OsStrExt as _;
    let name = |path: &Path| Ok::<_, io::Error>(CString::new(path.as_os_str().as_bytes())?);
    let (from, to, here) = (name(from)?, name(to)?, libc::AT_FDCWD);
    let (from, to, flags) = (from.as_ptr(), to.as_ptr(), libc::RENAME_NOREPLACE);
    // SAFETY: both names end in a zero and live until the end of this function.
    match unsafe { libc::renameat2(here, from, here, to, flags) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// There is no such call.
#[cfg(not(target_os = "linux"))]
fn rename_new(_from: &Path, _to: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.is_renamed {
            // It is gone already, or can't be removed.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

impl Write for Temporary {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Temporary {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Removes the temporary file of every [`Output`] that is not committed. Afterwards, creating and
/// committing an [`Output`] are errors for the rest of the process. Call it only immediately before
/// the program exits without destructors, for example after a signal: no file stays behind, and
/// none is committed in part.
///
/// ```
/// use catamaran::io::{Output, Overwrite, discard_unfinished};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let folder = folder.path();
/// let output = Output::create(&folder.join("a.txt"), Overwrite::Never)?;
/// discard_unfinished();
/// assert_eq!(std::fs::read_dir(folder).unwrap().count(), 0);
/// assert!(output.commit().is_err());
/// assert!(Output::create(&folder.join("b.txt"), Overwrite::Never).is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn discard_unfinished() {
    discard(unfinished());
}

/// Works as [`discard_unfinished`], for a program that aborts: the calling thread may be creating
/// or committing an [`Output`] itself, and the function waits for other threads no longer than
/// `patience`. Returns whether the files were removed.
///
/// ```
/// use std::time::Duration;
/// use catamaran::io::{Output, Overwrite, try_discard_unfinished};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let folder = folder.path();
/// let output = Output::create(&folder.join("a.txt"), Overwrite::Never)?;
/// assert!(try_discard_unfinished(Duration::from_secs(1)));
/// assert_eq!(std::fs::read_dir(folder).unwrap().count(), 0);
/// assert!(output.commit().is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn try_discard_unfinished(patience: Duration) -> bool {
    let start = Instant::now();
    loop {
        match UNFINISHED.try_lock() {
            Ok(unfinished) => return discard(unfinished),
            Err(TryLockError::Poisoned(unfinished)) => return discard(unfinished.into_inner()),
            Err(TryLockError::WouldBlock) if start.elapsed() > patience => return false,
            Err(TryLockError::WouldBlock) => std::thread::sleep(patience / 100),
        }
    }
}

/// Removes the files, and closes the list.
fn discard(mut unfinished: MutexGuard<'_, Unfinished>) -> bool {
    unfinished.is_closed = true;
    for path in &unfinished.paths {
        // The file is gone already, or can't be removed.
        let _ = std::fs::remove_file(path);
    }
    true
}

impl Output {
    /// Starts a file that will be called `path`.
    ///
    /// # Errors
    /// [`Error::Io`] when it exists and may not be replaced, its folder can't be written, or
    /// unfinished outputs were discarded ([`discard_unfinished`]).
    pub fn create(path: &Path, overwrite: Overwrite) -> Result<Self> {
        if overwrite == Overwrite::Never && path.symlink_metadata().is_ok() {
            return Err(exists(path));
        }
        if path.is_dir() {
            return Err(error(path, None, "is a directory"));
        }
        // Absolute, so that a change of the current folder neither moves the file nor leaves its
        // temporary one behind.
        let target =
            target_of(path).and_then(std::path::absolute).map_err(|e| write_error(path, e))?;
        let replaced = target.metadata().ok();
        if replaced.as_ref().is_some_and(|about| !about.is_file()) {
            return Err(error(path, None, "is not a regular file"));
        }
        let mut options = File::options();
        options.read(true).write(true).create_new(true);
        #[cfg(unix)]
        {
            // Private until the permissions of the replaced file are known.
            let mode = if replaced.is_some() { 0o600 } else { 0o666 };
            std::os::unix::fs::OpenOptionsExt::mode(&mut options, mode);
        }
        let (file, listed) =
            Temporary::create(folder_of(&target), &options).map_err(|e| write_error(path, e))?;
        if let Some(replaced) = replaced {
            take_over(&file.file, &replaced).map_err(|e| write_error(path, e))?;
        }
        let file = BufWriter::with_capacity(1 << 20, file);
        Ok(Self { path: path.into(), target, file, overwrite, _listed: listed })
    }

    /// Returns the path of the file once it is committed.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the path of the file until then.
    #[cfg(feature = "hdf5")]
    pub(super) fn temporary_path(&self) -> &Path {
        &self.file.get_ref().path
    }

    /// Lets the file appear under its name.
    ///
    /// # Errors
    /// [`Error::Io`]; no file is left behind then, unless the error is that of flushing the folder
    /// to the disk.
    pub fn commit(mut self) -> Result<()> {
        let flushed = self.file.flush().and_then(|()| self.file.get_ref().file.sync_all());
        flushed.map_err(|e| self.error(e))?;
        let Self { path, target, file, overwrite, _listed } = self;
        let file = file.into_inner().map_err(|e| write_error(&path, e.into_error()))?;
        // Locked, so that no file is committed while the files are discarded, or afterwards.
        let unfinished = open_list().map_err(|e| write_error(&path, e))?;
        let renamed = match overwrite {
            Overwrite::Replace => file.replace(&target),
            Overwrite::Never => file.appear(&target),
        };
        drop(unfinished);
        match renamed {
            Ok(()) => sync_folder(&target).map_err(|e| write_error(&path, e)),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Err(exists(&path)),
            Err(e) => Err(write_error(&path, e)),
        }
    }

    /// Sets the length of the file; bytes that were not written are zeros.
    pub(super) fn set_len(&mut self, bytes: u64) -> io::Result<()> {
        self.file.flush()?;
        self.file.get_ref().file.set_len(bytes)
    }

    /// Returns the error of a failed write, with the path of the file.
    pub fn error(&self, e: io::Error) -> Error {
        write_error(&self.path, e)
    }
}

/// Returns the error of a failed write to the file that will have this path.
pub(super) fn write_error(path: &Path, e: io::Error) -> Error {
    let what = format!("can't be written: {e}");
    Error::Io { path: path.into(), line: None, what, cause: Some(e.into()) }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Output {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Most symbolic links that are followed, as in the kernel of Linux.
const MOST_LINKS: usize = 40;

/// Returns the file that `path` leads to through symbolic links; it need not exist.
fn target_of(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        if !target.symlink_metadata().is_ok_and(|about| about.is_symlink()) {
            return Ok(target);
        }
        // Relative to the folder of the link, unless the target is absolute.
        target = folder_of(&target).join(std::fs::read_link(&target)?);
    }
    Err(io::Error::other("too many symbolic links"))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Gives `file` the permissions of the file it will replace, and its owner and group if that is
/// allowed.
fn take_over(file: &File, replaced: &Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
        // Only root may do this, unless owner and group are the user's own. It comes before the
        // permissions, which a change of owner may cut.
        let _ = fchown(file, None, Some(replaced.gid()));
        let _ = fchown(file, Some(replaced.uid()), None);
        // Without the bits that make a program run as its owner.
        file.set_permissions(PermissionsExt::from_mode(replaced.mode() & 0o777))
    }
    #[cfg(not(unix))]
    file.set_permissions(replaced.permissions())
}

/// Makes a rename in the folder of `path` survive a power cut, where the system lets the user do
/// that: some folders can be written but not opened, and some file systems have no such call.
fn sync_folder(path: &Path) -> io::Result<()> {
    use io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    if !cfg!(unix) {
        return Ok(());
    }
    match File::open(folder_of(path)).and_then(|folder| folder.sync_all()) {
        Err(e) if matches!(e.kind(), InvalidInput | PermissionDenied | Unsupported) => Ok(()),
        synced => synced,
    }
}

fn exists(path: &Path) -> Error {
    error(path, None, "exists already and is not replaced")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_is_renamed_in_one_step_unless_the_name_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("new"), "new").unwrap();
        std::fs::write(path("old"), "old").unwrap();
        let refused = rename_new(&path("new"), &path("old")).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(std::fs::read(path("old")).unwrap(), b"old");
        rename_new(&path("new"), &path("other")).unwrap();
        assert!(!path("new").exists());
        assert_eq!(std::fs::read(path("other")).unwrap(), b"new");
    }

    #[test]
    fn a_relative_path_is_that_of_the_folder_in_which_the_output_was_created() {
        let path = Path::new("an-output-that-is-dropped.csv");
        let here = std::env::current_dir().unwrap();
        let output = Output::create(path, Overwrite::Never).unwrap();
        assert_eq!((output.path(), &output.target), (path, &here.join(path)));
        let temporary = output.file.get_ref().path.clone();
        assert!(temporary.starts_with(&here) && temporary.exists());
        drop(output);
        assert!(!temporary.exists() && !path.exists());
    }
}
