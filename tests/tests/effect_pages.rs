//! The pages of the library are what its declarations say; `cargo xtask effects` writes them anew.

use std::collections::BTreeSet;
use std::fs;

use palpate::summary::effect_pages;
use palpate_tests::workspace;

/// Largest picture, bytes.
const LARGEST: usize = 60_000;
/// Difference of a coordinate, user units, that another machine's mathematics may make.
const NEAR: f64 = 0.3;

#[test]
fn the_pages_of_the_effects_are_what_the_library_declares() {
    let folder = workspace().join("docs/effects");
    let pages = effect_pages().unwrap();
    for (name, content) in &pages {
        let written = fs::read_to_string(folder.join(name)).unwrap_or_default();
        let same =
            if name.ends_with(".svg") { alike(&written, content) } else { written == *content };
        assert!(same, "docs/effects/{name} is out of date: run `cargo xtask effects`");
        assert!(content.len() < LARGEST, "{name} has {} bytes", content.len());
    }
    let made: BTreeSet<String> = pages.into_iter().map(|(name, _)| name).collect();
    let there: BTreeSet<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(there, made, "docs/effects has a page too many");
}

/// The same text, but for the last digits of coordinates.
fn alike(a: &str, b: &str) -> bool {
    let parts = |text: &str| -> Vec<(bool, String)> {
        let mut parts: Vec<(bool, String)> = Vec::new();
        for c in text.chars() {
            let number = c.is_ascii_digit() || c == '.' || c == '-';
            match parts.last_mut() {
                Some((kind, part)) if *kind == number && c != '-' => part.push(c),
                _ => parts.push((number, c.to_string())),
            }
        }
        parts
    };
    let (a, b) = (parts(a), parts(b));
    let near = |a: &str, b: &str| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= NEAR,
        _ => a == b,
    };
    a.len() == b.len() && a.iter().zip(&b).all(|((_, a), (_, b))| a == b || near(a, b))
}
