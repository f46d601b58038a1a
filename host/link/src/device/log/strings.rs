//! The strings of a firmware's log, which are the names of symbols in its ELF file.
//!
//! The linker puts them in a section `.defmt` that is not loaded; a message on the line begins with the address of its string.

use std::collections::BTreeMap;

use serde::Deserialize;

/// Formats of the line that are read: those of defmt 0.3 and 1.
const VERSIONS: [&str; 2] = ["3", "4"];
/// How frames must be coded.
const ENCODING: &str = "rzcobs";

/// A section of an ELF file is a table of symbols.
const SYMBOL_TABLE: u32 = 2;
/// Bytes of one symbol.
const SYMBOL: usize = 16;

/// Every string by its address.
#[derive(Debug)]
pub(super) struct Strings {
    by_address: BTreeMap<u16, Text>,
    /// What every message begins with.
    pub(super) timestamp: Option<String>,
}

/// A string, and how urgent a message with it is; no level where it is a part of others.
#[derive(Debug)]
pub(super) struct Text {
    pub(super) level: Option<&'static str>,
    pub(super) format: String,
}

/// The name of a symbol.
#[derive(Deserialize)]
struct Name {
    tag: String,
    data: String,
}

impl Strings {
    /// Reads them from the bytes of an ELF file for a 32-bit processor.
    ///
    /// # Errors
    /// Why there is no log in the file.
    pub(super) fn read(elf: &[u8]) -> Result<Self, String> {
        let file = Elf::new(elf).ok_or("it is no ELF file")?;
        let section = file.section(b".defmt").ok_or("it has no section .defmt")?;
        let mut strings = Self { by_address: BTreeMap::new(), timestamp: None };
        let (mut version, mut encoding) = (None, None);
        for symbol in file.symbols().ok_or("its symbols are cut off")? {
            let name = String::from_utf8_lossy(symbol.name);
            let plain = name.trim_matches('"');
            version = version.or(plain.strip_prefix("_defmt_version_ = ").map(str::to_owned));
            encoding = encoding.or(plain.strip_prefix("_defmt_encoding_ = ").map(str::to_owned));
            if symbol.section == section && name.starts_with('{') {
                let Name { tag, data } = serde_json::from_str(&name)
                    .map_err(|error| format!("a symbol of its log is damaged: {error}"))?;
                strings.take(symbol.address, &tag, data);
            }
        }
        let version = version.unwrap_or_default();
        if !VERSIONS.contains(&&*version) {
            let known = VERSIONS.join(" and ");
            return Err(format!("its log is of version `{version}` of defmt; read are {known}"));
        }
        match encoding.as_deref() {
            Some(ENCODING) => Ok(strings),
            other => Err(format!("its log is coded as `{}`, not {ENCODING}", other.unwrap_or(""))),
        }
    }

    fn take(&mut self, address: u32, tag: &str, format: String) {
        let level = match tag {
            "defmt_timestamp" => {
                self.timestamp = Some(format);
                return;
            }
            "defmt_trace" => Some("TRACE"),
            "defmt_debug" => Some("DEBUG"),
            "defmt_info" => Some("INFO"),
            "defmt_warn" => Some("WARN"),
            "defmt_error" => Some("ERROR"),
            _ if tag.starts_with("defmt_") => None,
            _ => return,
        };
        if let Ok(address) = u16::try_from(address) {
            self.by_address.insert(address, Text { level, format });
        }
    }

    /// The string at an address.
    pub(super) fn at(&self, address: u16) -> Option<&Text> {
        self.by_address.get(&address)
    }

    /// A string that is a part of others, at an address.
    pub(super) fn part(&self, address: u16) -> Option<&str> {
        self.at(address).filter(|text| text.level.is_none()).map(|text| &*text.format)
    }
}

/// An ELF file for a 32-bit processor, least byte first.
struct Elf<'b> {
    bytes: &'b [u8],
    sections: Vec<Section>,
    /// The section with the names of sections.
    names: usize,
}

struct Section {
    name: usize,
    kind: u32,
    offset: usize,
    size: usize,
    /// Of a table of symbols the section with their names.
    link: usize,
}

struct Symbol<'b> {
    name: &'b [u8],
    address: u32,
    section: usize,
}

impl<'b> Elf<'b> {
    /// Reads the sections; none where it is no such file. One for another processor has no sections.
    fn new(bytes: &'b [u8]) -> Option<Self> {
        let mut file = Self { bytes, sections: Vec::new(), names: 0 };
        if !bytes.starts_with(b"\x7fELF") {
            return None;
        }
        if bytes.get(4..6)? != [1, 1] {
            return Some(file);
        }
        let (table, size) = (file.word(0x20)?, file.half(0x2e)?);
        file.names = file.half(0x32)?;
        for k in 0..file.half(0x30)? {
            let at = table.checked_add(k.checked_mul(size)?)?;
            let field = |place: usize| file.word(at.checked_add(place)?);
            let section = Section {
                name: field(0)?,
                kind: u32::try_from(field(4)?).ok()?,
                offset: field(16)?,
                size: field(20)?,
                link: field(24)?,
            };
            file.sections.push(section);
        }
        Some(file)
    }

    fn half(&self, at: usize) -> Option<usize> {
        let bytes = self.bytes.get(at..at.checked_add(2)?)?;
        Some(u16::from_le_bytes(bytes.try_into().ok()?).into())
    }

    fn word(&self, at: usize) -> Option<usize> {
        let bytes = self.bytes.get(at..at.checked_add(4)?)?;
        usize::try_from(u32::from_le_bytes(bytes.try_into().ok()?)).ok()
    }

    /// The name at a place of a section of names.
    fn name(&self, section: usize, at: usize) -> Option<&'b [u8]> {
        let section = self.sections.get(section)?;
        let names = self.bytes.get(section.offset..section.offset.checked_add(section.size)?)?;
        names.get(at..)?.split(|byte| *byte == 0).next()
    }

    /// The number of the section with a name.
    fn section(&self, name: &[u8]) -> Option<usize> {
        self.sections.iter().position(|it| self.name(self.names, it.name) == Some(name))
    }

    /// Every symbol; none where the file is cut off.
    fn symbols(&self) -> Option<Vec<Symbol<'b>>> {
        let Some(table) = self.sections.iter().find(|it| it.kind == SYMBOL_TABLE) else {
            return Some(Vec::new());
        };
        let starts = (0..table.size / SYMBOL).map(|k| table.offset.checked_add(k * SYMBOL));
        let symbol = |start: Option<usize>| {
            let start = start?;
            Some(Symbol {
                name: self.name(table.link, self.word(start)?)?,
                address: u32::try_from(self.word(start.checked_add(4)?)?).ok()?,
                section: self.half(start.checked_add(14)?)?,
            })
        };
        starts.map(symbol).collect()
    }
}
