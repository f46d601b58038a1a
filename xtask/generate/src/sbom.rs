//! The bill of materials of the program: every crate that is in it, with version, licence and checksum, as CycloneDX.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use miette::{IntoDiagnostic, bail};
use palpate::files::write_whole;
use serde_json::{Value, json};

use crate::workspace;

/// Where it is written.
const FILE: &str = "target/palpate.cdx.json";

/// Writes the bill of materials of `palpate` on this platform, without what only builds or tests it.
pub fn write() -> miette::Result<()> {
    let tree =
        ["tree", "--locked", "--package", "palpate", "--edges", "normal", "--prefix", "none"];
    let output = Command::new(env!("CARGO"))
        .args(tree)
        .args(["--format", "{p}|{l}"])
        .current_dir(workspace())
        .output()
        .into_diagnostic()?;
    if !output.status.success() {
        bail!("cargo tree failed: {}", String::from_utf8_lossy(&output.stderr));
    }
    // A crate that was shown before is marked so.
    let once = |line: &str| line.trim_end_matches(" (*)").to_owned();
    let lines: BTreeSet<String> =
        String::from_utf8_lossy(&output.stdout).lines().map(once).collect();
    let checksums = checksums()?;
    let all: Vec<Value> = lines.iter().filter_map(|line| component(line, &checksums)).collect();
    let (program, parts): (Vec<Value>, Vec<Value>) =
        all.into_iter().partition(|part| part["name"] == "palpate");
    let text = format!("{:#}\n", bill(program.first(), &parts));
    write_whole(&workspace().join(FILE), |file| file.write_all(text.as_bytes()))
        .into_diagnostic()?;
    println!("{FILE}: {} crates", parts.len());
    Ok(())
}

fn bill(program: Option<&Value>, parts: &[Value]) -> Value {
    json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": program},
        "components": parts,
    })
}

/// A crate of a line such as `serde v1.0.0 (proc-macro)|MIT OR Apache-2.0`.
fn component(line: &str, checksums: &BTreeMap<(String, String), String>) -> Option<Value> {
    let (package, licence) = line.split_once('|')?;
    let mut words = package.split_whitespace();
    let (name, version) = (words.next()?, words.next()?.strip_prefix('v')?);
    let mut component = json!({
        "type": if name == "palpate" { "application" } else { "library" },
        "bom-ref": format!("pkg:cargo/{name}@{version}"),
        "purl": format!("pkg:cargo/{name}@{version}"),
        "name": name,
        "version": version,
        // Older manifests have a slash between alternatives.
        "licenses": [{"expression": licence.replace('/', " OR ")}],
    });
    if let Some(checksum) = checksums.get(&(name.into(), version.into())) {
        component["hashes"] = json!([{"alg": "SHA-256", "content": checksum}]);
    }
    Some(component)
}

/// Checksums of the packages of Cargo.lock, by name and version.
fn checksums() -> miette::Result<BTreeMap<(String, String), String>> {
    let text = std::fs::read_to_string(workspace().join("Cargo.lock")).into_diagnostic()?;
    let lock: toml::Table = text.parse().into_diagnostic()?;
    let packages = lock.get("package").and_then(toml::Value::as_array).into_iter().flatten();
    let known = |package: &toml::Value| {
        let word = |key: &str| Some(package.get(key)?.as_str()?.to_owned());
        Some(((word("name")?, word("version")?), word("checksum")?))
    };
    Ok(packages.filter_map(known).collect())
}
