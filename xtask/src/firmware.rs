//! The firmware: built, measured against its limits, and left where it is found to be flashed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use miette::{IntoDiagnostic, WrapErr, bail, miette};
use object::elf::{PT_LOAD, SHF_ALLOC};
use object::read::elf::{ElfFile32, ProgramHeader, SectionHeader};

use crate::check::{LINTED_BY, STRICT, rust, rustup, workspace};
use crate::golden::Golden;
use crate::uf2::{self, Family};

/// The processor's target.
const TARGET: &str = "thumbv7em-none-eabihf";
/// That of the port to the Raspberry Pi Pico 2, and where its flash begins.
const PICO2_TARGET: &str = "thumbv8m.main-none-eabihf";
const PICO2_FLASH: u32 = 0x1000_0000;
/// Where the flash begins and where the RAM does.
const FLASH: u32 = 0x0800_0000;
const RAM: u32 = 0x2000_0000;
/// Where the flash begins behind the loader TinyUF2.
const BEHIND_LOADER: u32 = 0x0801_0000;
/// Most bytes of flash and of RAM, the stack included.
const MOST: [(&str, u64); 2] = [("flash", 128 * 1024), ("RAM", 32 * 1024)];

/// Bytes of flash and of RAM.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    flash: u64,
    ram: u64,
}

/// The folder of the firmware.
pub fn folder() -> PathBuf {
    workspace().join("firmware")
}

/// An executable of the firmware's workspace.
pub fn executable(name: &str) -> PathBuf {
    target().join(TARGET).join("release").join(name)
}

/// Where its workspace is built, whatever the environment says of other workspaces.
pub fn target() -> PathBuf {
    folder().join("target")
}

/// Runs cargo in the workspace of the firmware.
pub fn cargo(name: &str, arguments: &[&str]) -> miette::Result<()> {
    cargo_with(name, arguments, &[])
}

fn cargo_with(name: &str, arguments: &[&str], more: &[(&str, &str)]) -> miette::Result<()> {
    let target = target();
    let target = target.to_string_lossy();
    let environment = [&[("CARGO_TARGET_DIR", &*target)], more].concat();
    rust(name, &folder(), arguments, &environment)
}

/// Installs the target where it is missing.
pub fn set_up() -> miette::Result<()> {
    set_up_for(TARGET)
}

fn set_up_for(target: &str) -> miette::Result<()> {
    let installed = Command::new("rustup").args(["target", "list", "--installed"]).output();
    let present = installed.is_ok_and(|output| {
        String::from_utf8_lossy(&output.stdout).lines().any(|line| line == target)
    });
    if present { Ok(()) } else { rustup("target", target, "to build the firmware") }
}

/// Runs cargo in the workspace of the port to the Pico 2.
fn pico2(name: &str, arguments: &[&str]) -> miette::Result<()> {
    let target = target().join("pico2");
    let environment = [("CARGO_TARGET_DIR", &*target.to_string_lossy()), STRICT];
    rust(name, &folder().join("pico2"), arguments, &environment)
}

/// Checks format and lints of the port to the Pico 2.
pub fn check_pico2() -> miette::Result<()> {
    set_up_for(PICO2_TARGET)?;
    pico2("format of the firmware of the Pico 2", &["fmt", "--all", "--check"])?;
    for converter in [&[][..], &["--features", "nau7802"]] {
        // Builds, so that what others wrote is compiled once for lints and firmware.
        let lints = [&LINTED_BY[..], &["build", "--release"], converter].concat();
        pico2("lints of the firmware of the Pico 2", &lints)?;
    }
    build_pico2()
}

/// Builds the port to the Pico 2 with each converter and leaves it as files that are drawn onto its disk.
fn build_pico2() -> miette::Result<()> {
    set_up_for(PICO2_TARGET)?;
    let out = workspace().join("target/firmware");
    fs::create_dir_all(&out).into_diagnostic()?;
    for (name, converter) in
        [("palpate-pico2-nau7802.uf2", &["--features", "nau7802"][..]), ("palpate-pico2.uf2", &[])]
    {
        pico2("firmware of the Pico 2", &[&["build", "--release"], converter].concat())?;
        let elf = target().join("pico2").join(PICO2_TARGET).join("release/palpate-pico2");
        let elf = fs::read(&elf).into_diagnostic().wrap_err_with(|| elf.display().to_string())?;
        let file = uf2::file(&image(&elf, PICO2_FLASH)?, PICO2_FLASH, Family::Rp2350);
        write(&out.join(name), &file)?;
    }
    Ok(())
}

/// Builds the firmware and leaves it in `target/firmware/`, with its sizes.
fn build() -> miette::Result<Sizes> {
    set_up()?;
    cargo("firmware", &["build", "--release", "--bin", "palpate"])?;
    let elf = executable("palpate");
    let elf = fs::read(&elf).into_diagnostic().wrap_err_with(|| elf.display().to_string())?;
    let out = workspace().join("target/firmware");
    fs::create_dir_all(&out).into_diagnostic()?;
    let sizes = sizes(&elf)?;
    let text = format!("flash {} B\nRAM {} B, the stack included\n", sizes.flash, sizes.ram);
    write(&out.join("palpate.elf"), &elf)?;
    write(&out.join("palpate.bin"), &image(&elf, FLASH)?)?;
    write(&out.join("sizes.txt"), text.as_bytes())?;
    print!("{text}");
    println!("palpate.elf, palpate.bin, palpate.uf2 and sizes.txt in {}", out.display());
    Ok(sizes)
}

/// Builds everything that is given to users, for every board.
pub fn everything() -> miette::Result<()> {
    build_pico2()?;
    release().map(drop)
}

/// Builds what is given to users of boards with an STM32F405: what [`build`] leaves, and a file for loaders that show a disk.
pub fn release() -> miette::Result<Sizes> {
    set_up()?;
    let origin = format!("{BEHIND_LOADER:#010x}");
    let build_it = ["build", "--release", "--bin", "palpate"];
    cargo_with("firmware behind a loader", &build_it, &[("PALPATE_ORIGIN", &origin)])?;
    let elf = executable("palpate");
    let elf = fs::read(&elf).into_diagnostic().wrap_err_with(|| elf.display().to_string())?;
    let file = uf2::file(&image(&elf, BEHIND_LOADER)?, BEHIND_LOADER, Family::Stm32F4);
    let out = workspace().join("target/firmware");
    fs::create_dir_all(&out).into_diagnostic()?;
    write(&out.join("palpate.uf2"), &file)?;
    // Last, so that the executables that stay are those of the image at the beginning of the flash.
    build()
}

/// Builds the firmware and holds its sizes to their limits and to the golden file.
pub fn check(golden: &mut Golden) -> miette::Result<()> {
    let Sizes { flash, ram } = release()?;
    for ((name, most), bytes) in MOST.iter().zip([flash, ram]) {
        if bytes > *most {
            bail!("the firmware takes {bytes} B of {name}; there are {most} B");
        }
        golden.hold(&format!("{name}, B"), bytes as f64)?;
    }
    Ok(())
}

/// Everything of the file that lies in flash, and all of the RAM that is taken, the stack too.
fn sizes(elf: &[u8]) -> miette::Result<Sizes> {
    let file = ElfFile32::<object::Endianness>::parse(elf).into_diagnostic()?;
    let endian = file.endian();
    let mut sizes = Sizes { flash: 0, ram: 0 };
    for section in file.elf_section_table().iter() {
        let (address, size) = (section.sh_addr(endian), u64::from(section.sh_size(endian)));
        if section.sh_flags(endian).contains(SHF_ALLOC) && address >= RAM {
            sizes.ram += size;
        }
    }
    for header in file.elf_program_headers() {
        if header.p_type(endian) == PT_LOAD && header.p_paddr(endian) < RAM {
            sizes.flash += u64::from(header.p_filesz(endian));
        }
    }
    sizes.ram += u64::from(stack(&file)?);
    Ok(sizes)
}

/// Bytes between the two symbols that `memory.x` gives the stack.
fn stack(file: &ElfFile32<'_>) -> miette::Result<u32> {
    use object::{Object, ObjectSymbol};
    let symbol = |name: &str| {
        let found = file.symbols().find(|symbol| symbol.name() == Ok(name));
        found
            .map(|symbol| symbol.address())
            .ok_or_else(|| miette!("no symbol {name} in the firmware"))
    };
    Ok((symbol("_stack_start")? - symbol("_stack_end")?) as u32)
}

/// The bytes to be written to the flash from this address on.
fn image(elf: &[u8], from: u32) -> miette::Result<Vec<u8>> {
    let file = ElfFile32::<object::Endianness>::parse(elf).into_diagnostic()?;
    let endian = file.endian();
    let mut image = Vec::new();
    for header in file.elf_program_headers() {
        let at = header.p_paddr(endian);
        if header.p_type(endian) != PT_LOAD || !(from..RAM).contains(&at) {
            continue;
        }
        let bytes = header.data(endian, elf).map_err(|()| miette!("a segment is cut off"))?;
        let at = (at - from) as usize;
        if image.len() < at + bytes.len() {
            image.resize(at + bytes.len(), 0xff);
        }
        image[at..at + bytes.len()].copy_from_slice(bytes);
    }
    Ok(image)
}

fn write(path: &Path, bytes: &[u8]) -> miette::Result<()> {
    fs::write(path, bytes).into_diagnostic().wrap_err_with(|| path.display().to_string())
}
