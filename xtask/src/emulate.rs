//! The firmware on an emulated STM32F405.

use std::process::Command;

use miette::{IntoDiagnostic, bail};

use crate::check::set_up_tests;
use crate::firmware;
use crate::golden::Golden;
use crate::packages;

const QEMU: &str = "qemu-system-arm";
/// Emulators that run at the same time.
pub const AT_ONCE: u32 = 2;

/// Sets up, builds and runs everything that the firmware promises, with a steady stream of so many seconds.
pub fn run(steady_s: u32, update: bool) -> miette::Result<()> {
    install()?;
    measure(update)?;
    check(steady_s)
}

/// Builds the firmware and holds its sizes and counts of instructions to the golden file, or with `update` writes that anew.
pub fn measure(update: bool) -> miette::Result<()> {
    let mut golden = Golden::open("firmware.txt", update)?;
    firmware::check(&mut golden)?;
    cost(&mut golden)?;
    golden.close()
}

/// Runs what was built, with a steady stream of so many seconds.
pub fn check(steady_s: u32) -> miette::Result<()> {
    set_up_tests("emulated device", "emulated", AT_ONCE, steady_s, &[])
}

/// Installs the emulator where it is missing.
pub fn install() -> miette::Result<()> {
    packages::set_up(QEMU, &[QEMU], "to run the firmware")
}

/// Sets up what the tests need: the emulator and the firmware.
pub fn set_up() -> miette::Result<()> {
    install()?;
    firmware::release().map(drop)
}

/// Instructions of a sample, printed beside those of rivals and held to the golden file.
pub fn cost(golden: &mut Golden) -> miette::Result<()> {
    firmware::cargo("count of instructions", &["build", "--release", "-p", "palpate-cost"])?;
    let output = Command::new(QEMU)
        .args(["-machine", "netduinoplus2", "-nographic", "-icount", "shift=0"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(firmware::executable("palpate-cost"))
        .output()
        .into_diagnostic()?;
    let text = String::from_utf8_lossy(&output.stdout);
    println!("instructions per gauge and sample on the emulated Cortex-M4:");
    let mut figures = 0;
    for line in text.lines() {
        let Some((name, figure)) = line.rsplit_once(' ') else { continue };
        let Ok(figure) = figure.parse::<f64>() else { continue };
        println!("  {name:<40} {figure:>7}");
        golden.hold(name, figure)?;
        figures += 1;
    }
    if figures < 7 {
        bail!("the count ended early: {text}{}", String::from_utf8_lossy(&output.stderr));
    }
    Ok(())
}
