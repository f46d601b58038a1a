//! Tells the linker where the memory of the firmware is.

fn main() {
    println!("cargo:rerun-if-changed=../memory/memory.x");
    println!(
        "cargo:rustc-link-search={}/../memory",
        std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default()
    );
}
