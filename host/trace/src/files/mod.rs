//! Files: what may be written ([`plan`]), so that a reader sees all of one or nothing ([`write_whole`]) or as its contents come
//! ([`begin`]), and how a shell takes a name ([`quoted`]).

pub mod plan;
mod temporary;

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use temporary::Temporary;
pub use temporary::remove_unfinished;

/// Most links that lead from a name to its file.
const MAX_LINKS: usize = 40;

/// Writes `path` through a temporary file in the same folder, renamed into place at the end: on any error, or a kill at any
/// moment, an earlier file of that name is still there, whole. A link stays, and its target is written. What is no regular
/// file (a device, a pipe) is written into, and stays what it is.
///
/// # Errors
/// Whatever the file system answers, or the error that `fill` returned.
pub fn write_whole(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(about) if about.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(about) if about.is_file() && about.permissions().readonly() => {
            Err(io::ErrorKind::PermissionDenied.into())
        }
        Ok(about) if about.is_file() => replace(&followed(path)?, Some(about.permissions()), fill),
        Ok(_) => {
            let mut out = BufWriter::new(File::options().write(true).open(path)?);
            fill(&mut out)?;
            out.flush()
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            replace(&followed(path)?, None, fill)
        }
        Err(error) => Err(error),
    }
}

fn replace(
    path: &Path,
    permissions: Option<fs::Permissions>,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut writer = BufWriter::new(Temporary::beside(path)?);
    fill(&mut writer)?;
    let temporary = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
    temporary.persist(path, permissions)
}

/// Begins a file that is written as its contents come; one that is there is replaced only if `overwrite` says so. Nobody else who
/// begins it so writes to it meanwhile. What is no regular file (a device, a pipe) is written into.
///
/// # Errors
/// [`io::ErrorKind::AlreadyExists`], [`io::ErrorKind::ResourceBusy`] while another writes to it, or whatever else the file
/// system answers.
pub fn begin(path: &Path, overwrite: bool) -> io::Result<File> {
    let regular = !fs::metadata(path).is_ok_and(|about| !about.is_file());
    if !regular {
        return File::options().write(true).open(path);
    }
    let mut options = File::options();
    options.write(true).create(true).truncate(false);
    let file = if overwrite { options.open(path) } else { File::create_new(path) }?;
    // A file system without locks cannot tell; there one writer could lose what another writes.
    if let Err(TryLockError::WouldBlock) = file.try_lock() {
        return Err(io::ErrorKind::ResourceBusy.into());
    }
    file.set_len(0)?;
    Ok(file)
}

/// Tells the disk to keep what was written; a device such as `/dev/null` has nothing to keep.
///
/// # Errors
/// Whatever the file system answers.
pub fn keep(file: &mut File) -> io::Result<()> {
    match file.sync_data() {
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
        kept => kept,
    }
}

/// Where a name leads, link by link; the last one may lead to nothing yet.
///
/// # Errors
/// When links lead in a circle, or one cannot be read.
pub fn followed(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        match fs::symlink_metadata(&path) {
            Ok(about) if about.is_symlink() => path = folder_of(&path).join(fs::read_link(&path)?),
            _ => return Ok(path),
        }
    }
    Err(io::Error::other("its links lead in a circle"))
}

/// The folder that a file lies in.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// An argument as a shell takes it: in quotes where it needs them.
#[must_use]
pub fn quoted(argument: &str) -> String {
    let safe = |c: char| c.is_alphanumeric() || "-_./=+:,".contains(c);
    let plain = argument.chars().all(safe);
    if plain { argument.into() } else { format!("'{}'", argument.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_earlier_file_and_no_litter() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        write_whole(&path, |file| file.write_all(b"first")).unwrap();
        let failed = write_whole(&path, |file| {
            file.write_all(b"half of the seco")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_that_may_not_be_written_is_not_replaced_either() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        fs::write(&path, "protected").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        let error = write_whole(&path, |file| file.write_all(b"x")).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::PermissionDenied);
        assert_eq!(fs::read(&path).unwrap(), b"protected");
    }

    #[test]
    fn a_folder_is_not_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_whole(folder.path(), |file| file.write_all(b"x")).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::IsADirectory);
    }

    #[cfg(unix)]
    mod unix {
        use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
        use std::path::Path;

        use super::*;

        #[test]
        fn a_link_stays_and_its_target_is_written_also_where_there_is_none_yet() {
            let folder = tempfile::tempdir().unwrap();
            let at = |name: &str| folder.path().join(name);
            fs::create_dir(at("models")).unwrap();
            fs::write(at("models/one.toml"), "earlier").unwrap();
            symlink("models/one.toml", at("old.toml")).unwrap();
            symlink("old.toml", at("twice.toml")).unwrap();
            symlink("models/two.toml", at("new.toml")).unwrap();
            for (link, target) in
                [("twice.toml", "models/one.toml"), ("new.toml", "models/two.toml")]
            {
                write_whole(&at(link), |file| file.write_all(link.as_bytes())).unwrap();
                assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink(), "{link}");
                assert_eq!(fs::read_to_string(at(target)).unwrap(), link);
            }
            assert_eq!(fs::read_dir(at("models")).unwrap().count(), 2);
        }

        #[test]
        fn links_that_lead_in_a_circle_are_an_error() {
            let folder = tempfile::tempdir().unwrap();
            symlink("b", folder.path().join("a")).unwrap();
            symlink("a", folder.path().join("b")).unwrap();
            assert!(write_whole(&folder.path().join("a"), |file| file.write_all(b"x")).is_err());
        }

        #[test]
        fn a_pipe_is_written_into_and_stays_a_pipe() {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("pipe");
            let made = std::process::Command::new("mkfifo").arg(&path).status().unwrap();
            assert!(made.success());
            let reader = std::thread::spawn({
                let path = path.clone();
                move || fs::read_to_string(path)
            });
            write_whole(&path, |file| file.write_all(b"through")).unwrap();
            assert_eq!(reader.join().unwrap().unwrap(), "through");
            assert!(fs::metadata(&path).unwrap().file_type().is_fifo());
        }

        #[test]
        fn a_device_is_written_into() {
            write_whole(Path::new("/dev/null"), |file| file.write_all(b"x")).unwrap();
            assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        }

        #[test]
        fn a_file_keeps_its_permissions_and_a_new_one_has_those_of_any_new_file() {
            let folder = tempfile::tempdir().unwrap();
            let at = |name: &str| folder.path().join(name);
            let mode = |name: &str| fs::metadata(at(name)).unwrap().permissions().mode() & 0o777;
            fs::write(at("usual"), "").unwrap();
            fs::write(at("private"), "").unwrap();
            fs::set_permissions(at("private"), fs::Permissions::from_mode(0o600)).unwrap();
            for name in ["private", "new"] {
                write_whole(&at(name), |file| file.write_all(b"x")).unwrap();
            }
            assert_eq!((mode("private"), mode("new")), (0o600, mode("usual")));
        }
    }
}
