//! What answers on the serial ports, without touching the one that is open.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde_json::{Value, json};

use crate::live::lock;
use crate::live::store::Store;
use palpate_link::device::answers::{PortAnswer, ReleaseAnswer};
use palpate_link::device::discover::{ask, ports};
use palpate_link::device::release::verdict;
use palpate_link::device::session::LinkError;
use palpate_present::answers;

/// Ours first, then all others but those of the fingers `beside` it.
pub(super) fn list(ours: &Path, beside: &[PathBuf], store: &Mutex<Store>) -> Value {
    let taken = beside.iter().map(PathBuf::as_path).chain([ours]);
    let others = taken.fold(ports(), others);
    let mine = {
        let store = lock(store);
        let linked = store.health.linked;
        json!({
            "port": ours,
            "device": linked.then(|| store.health.device()),
            "error": if linked { None } else { store.health.trouble.clone() },
            "release": store.bench.release.as_ref().map(ReleaseAnswer::from),
            "ours": true,
        })
    };
    let found = ask(&others);
    let rest = found.iter().map(|found| {
        let release = match &found.answer {
            Ok(identity) => Some(verdict(&identity.version, true)),
            Err(LinkError::Schema { theirs, .. }) => Some(verdict(theirs, false)),
            Err(_) => None,
        };
        let mut json = answers::json(&PortAnswer::from(found));
        json["release"] = answers::json(&release.as_ref().map(ReleaseAnswer::from));
        json["ours"] = false.into();
        json
    });
    let all: Vec<Value> = std::iter::once(mine).chain(rest).collect();
    json!({ "ports": all, "command": "palpate device list" })
}

/// All ports but one that is open, by whatever name.
fn others(ports: Vec<PathBuf>, ours: &Path) -> Vec<PathBuf> {
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let ours = real(ours);
    ports.into_iter().filter(|port| real(port) != ours).collect()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn our_port_is_not_asked_under_another_name_either() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("tty"), "").unwrap();
        std::fs::write(at("other"), "").unwrap();
        std::os::unix::fs::symlink(at("tty"), at("fingertip")).unwrap();
        let all = vec![at("other"), at("tty"), at("fingertip")];
        assert_eq!(others(all.clone(), &at("fingertip")), [at("other")]);
        assert_eq!(others(all, &at("gone")).len(), 3);
    }
}
