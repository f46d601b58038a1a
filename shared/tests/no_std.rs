//! The device has neither `std` nor an allocator, and a host build would not notice a slip.

use std::fs;
use std::path::Path;

fn sources(folder: &Path, found: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else {
            found.push((path.display().to_string(), fs::read_to_string(&path).unwrap()));
        }
    }
}

#[test]
fn no_source_brings_in_std_or_alloc_and_the_crate_root_forbids_unsafe_code() {
    let mut found = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
    assert!(found.len() > 5);
    for (path, text) in &found {
        for word in ["extern crate", "std::", "alloc::"] {
            assert!(!text.contains(word), "{path} contains `{word}`");
        }
    }
    let (_, root) = found.iter().find(|(path, _)| path.ends_with("lib.rs")).unwrap();
    assert!(
        root.contains("\n#![cfg_attr(not(test), no_std)]\n")
            && root.contains("\n#![forbid(unsafe_code)]\n")
    );
}
