//! A file under way to its place: hidden, beside it, removed if the work ends early.

use std::fs::{self, File, Permissions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use tempfile::{Builder, NamedTempFile};

use super::folder_of;

/// How the name of such a file ends; it begins with a dot.
const SUFFIX: &str = ".palpate-tmp";

/// Those of this process, so that a signal can remove them.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes the temporary files of this process, and lets no other begin: the process is about to end.
pub fn remove_unfinished() {
    let Ok(unfinished) = UNFINISHED.lock() else { return };
    for path in unfinished.iter() {
        let _ = fs::remove_file(path);
    }
    // Whoever wants to begin another one waits until the end.
    std::mem::forget(unfinished);
}

/// A temporary file. It is locked while it is written: one that is not was left behind by a kill.
pub(super) struct Temporary(NamedTempFile);

impl Temporary {
    /// Begins a file that will lie at `path`, and removes what earlier calls left in that folder.
    pub(super) fn beside(path: &Path) -> io::Result<Self> {
        let folder = folder_of(path);
        remove_left_behind(folder);
        let mut unfinished = UNFINISHED.lock().map_err(|_| io::Error::other("a writer failed"))?;
        loop {
            let file =
                like_new_file(Builder::new().prefix(".").suffix(SUFFIX)).tempfile_in(folder)?;
            // Between its creation and its lock another process may have taken it for one left behind.
            let taken = matches!(file.as_file().try_lock(), Err(TryLockError::WouldBlock));
            if !taken && file.path().exists() {
                unfinished.push(file.path().to_path_buf());
                return Ok(Self(file));
            }
        }
    }

    /// Puts it in its place once all of it is on the disk.
    pub(super) fn persist(
        mut self,
        path: &Path,
        permissions: Option<Permissions>,
    ) -> io::Result<()> {
        if let Some(permissions) = permissions {
            self.0.as_file().set_permissions(permissions)?;
        }
        self.0.as_file().sync_all()?;
        fs::rename(self.0.path(), path)?;
        self.0.disable_cleanup(true);
        Ok(())
    }
}

impl Write for Temporary {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.as_file_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.as_file_mut().flush()
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Ok(mut unfinished) = UNFINISHED.lock() {
            unfinished.retain(|path| path != self.0.path());
        }
    }
}

/// Removes the temporary files of a folder that nobody is writing. What cannot be removed is left: it harms nothing.
fn remove_left_behind(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let ours =
            name.to_str().is_some_and(|name| name.starts_with('.') && name.ends_with(SUFFIX));
        if !ours || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        if let Ok(file) = File::options().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// A temporary file is private by default; a result is as readable as any file the user makes.
#[cfg(unix)]
fn like_new_file<'a, 'b, 'c>(builder: &'c mut Builder<'a, 'b>) -> &'c mut Builder<'a, 'b> {
    use std::os::unix::fs::PermissionsExt;
    // The process's umask still applies.
    builder.permissions(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn like_new_file<'a, 'b, 'c>(builder: &'c mut Builder<'a, 'b>) -> &'c mut Builder<'a, 'b> {
    builder
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::write_whole;

    #[test]
    fn what_a_kill_left_is_removed_and_what_another_writes_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at(".a1b2c3.palpate-tmp"), "half of a mod").unwrap();
        fs::write(at("mine.palpate-tmp"), "a file of the user").unwrap();
        let other = Temporary::beside(&at("other.toml")).unwrap();
        write_whole(&at("model.toml"), |file| file.write_all(b"whole")).unwrap();
        assert!(!at(".a1b2c3.palpate-tmp").exists());
        assert!(at("mine.palpate-tmp").exists());
        other.persist(&at("other.toml"), None).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
    }
}
