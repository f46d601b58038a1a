//! Files of other programs, written by their own libraries.

use std::path::Path;
use std::process::Command;

use miette::{IntoDiagnostic, bail};

use crate::check::{linted, workspace};

/// Libraries that write the files, or read those of microscopes beside palpate, at the versions that were tried.
const LIBRARIES: &[&str] = &[
    "NSFopen==2.2.4",
    "afmformats==0.18.7",
    "h5py==3.16.0",
    "mcap==1.6.0",
    "mcap-ros2-support==0.6.0",
    "npTDMS==1.13.0",
    "numpy==2.4.6",
    "odfpy==1.4.1",
    "openpyxl==3.1.5",
    "pyarrow==26.0.1",
    "pyfmreader==0.1.3",
    "rosbags==0.11.9",
    "scipy==1.17.1",
    "websockets==17.4",
    "zstandard==0.25.0",
];

/// Sets up Python with those libraries, lets them write one file of each format, and runs the tests that read them.
pub fn run() -> miette::Result<()> {
    let folder = workspace().join("target/formats");
    let python = folder.join("python/bin/python");
    let listed = LIBRARIES.join("\n");
    let mark = folder.join("python/libraries");
    if std::fs::read_to_string(&mark).ok().as_deref() != Some(&listed) {
        println!("==> installing Python's writers of files into target/formats");
        call(Path::new("python3"), &["-m", "venv", &folder.join("python").to_string_lossy()])?;
        let quiet = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
        call(&python, &[&quiet[..], LIBRARIES].concat())?;
        std::fs::write(&mark, &listed).into_diagnostic()?;
    }
    let files = folder.join("files");
    if files.exists() {
        std::fs::remove_dir_all(&files).into_diagnostic()?;
    }
    call(&python, &["tests/formats/write.py", &files.to_string_lossy()])?;
    let files = ["--test", "formats", "--test", "robots"];
    linted("files of other programs", &[&files[..], &["--", "--include-ignored"]].concat())
}

fn call(program: &Path, arguments: &[&str]) -> miette::Result<()> {
    let status = Command::new(program).args(arguments).current_dir(workspace()).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        _ => bail!(
            "{} {} failed; Python 3.11 or later is needed",
            program.display(),
            arguments.join(" ")
        ),
    }
}
