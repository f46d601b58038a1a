//! The wiring as files: what is joined is what the firmware expects, and every part is in the bill of materials.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::read_to_string;
use std::path::Path;

/// A file of the firmware.
fn file(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware").join(path);
    read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Pins by net: part and pin.
fn nets() -> BTreeMap<String, BTreeSet<(String, String)>> {
    let mut nets: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
    for line in file("hardware/netlist.csv").lines().skip(1) {
        let [net, part, pin] = line.split(',').collect::<Vec<_>>()[..] else { panic!("{line}") };
        nets.entry(net.to_owned()).or_default().insert((part.to_owned(), pin.to_owned()));
    }
    nets
}

#[test]
fn every_pin_is_in_one_net_and_every_net_joins_pins() {
    let nets = nets();
    let all: Vec<_> = nets.values().flatten().collect();
    assert_eq!(all.len(), all.iter().collect::<BTreeSet<_>>().len(), "a pin in two nets");
    for (net, pins) in &nets {
        assert!(pins.len() >= 2, "{net} joins nothing");
    }
}

#[test]
fn the_bill_of_materials_has_every_part_of_the_netlist_and_no_other() {
    let nets = nets();
    let joined: BTreeSet<&str> = nets.values().flatten().map(|(part, _)| part.as_str()).collect();
    let bill = file("hardware/bill-of-materials.csv");
    let mut listed = BTreeSet::new();
    for line in bill.lines().skip(1) {
        let (quantity, rest) = line.split_once(',').unwrap();
        let parts: Vec<&str> = rest.split(',').next().unwrap().split(' ').collect();
        assert_eq!(parts.len(), quantity.parse::<usize>().unwrap(), "{line}");
        listed.extend(parts);
    }
    assert_eq!(listed, joined);
}

#[test]
fn what_the_firmware_has_pins_for_is_wired_to_them() {
    let nets = nets();
    let pin_of = |part: &str, signal: &str| {
        let net = nets.values().find(|net| net.contains(&(part.to_owned(), signal.to_owned())));
        let (_, pin) = net.unwrap().iter().find(|(part, _)| part == "U1").unwrap();
        pin.clone()
    };
    // Rows of the table in the firmware: signals, pins of the chip, pins of the Feather.
    let table = file("src/board/mod.rs");
    for (named, part, signals) in [
        ("converter SCK, MISO, MOSI", "U2", &["SCLK", "DOUT", "DIN"][..]),
        ("converter CS", "U2", &["CS"]),
        ("converter SYNC/RESET", "U2", &["SYNC/RESET"]),
        ("converter DRDY", "U2", &["DRDY"]),
        ("converter CLKIN", "U2", &["CLKIN"]),
        ("line that fingers share, what this one hears", "J5", &["2"]),
        ("the same, what this one says", "J5", &["3"]),
    ] {
        let row = table.lines().find(|line| line.contains(named)).unwrap();
        let feather: Vec<&str> = row.split('|').nth(3).unwrap().split(',').map(str::trim).collect();
        for (signal, feather) in signals.iter().zip(feather) {
            // A number alone is a digital pin.
            let feather =
                if feather.parse::<u8>().is_ok() { format!("D{feather}") } else { feather.into() };
            assert_eq!(pin_of(part, signal), feather, "{signal}");
        }
    }
}

#[test]
fn the_rules_for_linux_name_the_device_as_it_names_itself() {
    use shared::wire::{USB_NAME, USB_PRODUCT, USB_VENDOR};
    let rule = format!(
        r#"ATTRS{{idVendor}}=="{USB_VENDOR:04x}", ATTRS{{idProduct}}=="{USB_PRODUCT:04x}", ATTRS{{product}}=="{USB_NAME}""#
    );
    assert!(file("udev/70-palpate.rules").contains(&rule), "{rule}");
    let readme = file("README.md");
    assert!(readme.contains(&format!("vendor {USB_VENDOR:04x}, product {USB_PRODUCT:04x}")));
}
