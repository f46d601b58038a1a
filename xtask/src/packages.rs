//! Programs from the system's packages that the checks need.

use std::process::Command;

use miette::bail;

/// Installs packages with apt-get where a program is missing.
pub fn set_up(program: &str, packages: &[&str], why: &str) -> miette::Result<()> {
    let present =
        Command::new(program).arg("--version").output().is_ok_and(|out| out.status.success());
    if present {
        return Ok(());
    }
    let names = packages.join(" ");
    println!("==> installing {names} from the system's packages, {why}");
    let root =
        Command::new("id").arg("-u").output().is_ok_and(|out| out.stdout.starts_with(b"0\n"));
    let install = [&["install", "-y", "-q", "--no-install-recommends"][..], packages].concat();
    for arguments in [&["update", "-q"][..], &install] {
        let mut command = Command::new(if root { "apt-get" } else { "sudo" });
        if !root {
            command.arg("apt-get");
        }
        match command.args(arguments).status() {
            Ok(status) if status.success() => {}
            _ => bail!(
                "{program} is missing and {names} could not be installed with apt-get; install it {why}"
            ),
        }
    }
    Ok(())
}
