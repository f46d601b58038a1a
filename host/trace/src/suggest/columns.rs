//! What each column is, by its name, its unit and its numbers.

use super::super::names;
use super::super::units::{self, Quantity, Unit};
use super::super::{DISPLACEMENT, FORCE, TEMPERATURE, TIME};
use super::guess::Kind;

/// A column of numbers as it was found.
pub(super) struct Seen {
    /// Place in the row, from 0.
    pub(super) index: usize,
    /// Its name in the file.
    pub(super) name: String,
    /// What stands between its name and its numbers.
    pub(super) below: Vec<String>,
    /// Whether it holds numbers or written times.
    pub(super) kind: Kind,
    /// Its first numbers.
    pub(super) values: Vec<f64>,
}

/// What a column becomes.
pub(super) struct Proposal {
    /// Its name in the trace.
    pub(super) name: String,
    /// Its unit in the file, where it is known and the name ends in one.
    pub(super) unit: Option<&'static Unit>,
    /// Whether the unit was told by nothing in the file.
    pub(super) guessed: bool,
}

/// Words for what a column measures, the plainest first; those of one or two letters must stand alone.
const TIMES: &[&str] =
    &["time", "zeit", "temps", "tiempo", "stamp", "elapsed", "时间", "時間", "t"];
const FORCES: &[&str] = &[
    "force_n",
    "normal force",
    "force.z",
    "axial force",
    "fz",
    "fn",
    "force",
    "kraft",
    "load",
    "fuerza",
    "carga",
    "last",
    "载荷",
    "力",
    "荷重",
    "試験力",
    "f",
];
const DISPLACEMENTS: &[&str] = &[
    "displacement",
    "verschiebung",
    "indentation",
    "crosshead",
    "position",
    "extension",
    "travel",
    "distance",
    "stroke",
    "deflection",
    "depth",
    "weg",
    "gap",
    "位移",
    "变形",
    "変位",
    "ストローク",
];
const TEMPERATURES: &[&str] = &["temperature", "temperatur", "température", "temp", "温度"];
/// Names of counters, which rise as steadily as time.
const COUNTERS: &[&str] = &[
    "no", "nr", "index", "frame", "row", "point", "sample", "id", "番号", "序号", "#", "number",
    "step",
];
/// Other ways to write units.
const ALIASES: &[(&str, &str)] = &[
    ("sec", "s"),
    ("secs", "s"),
    ("second", "s"),
    ("seconds", "s"),
    ("sekunden", "s"),
    ("msec", "ms"),
    ("millis", "ms"),
    ("milliseconds", "ms"),
    ("micros", "us"),
    ("microseconds", "us"),
    ("minutes", "min"),
    ("newton", "N"),
    ("newtons", "N"),
    ("millimeter", "mm"),
    ("mm", "mm"),
    ("micron", "um"),
    ("microns", "um"),
    ("℃", "C"),
    ("degc", "C"),
    ("deg c", "C"),
];
/// What instruments write for the weight of so much mass, where the column is a force.
const WEIGHTS: &[(&str, &str)] = &[("g", "gf"), ("kg", "kgf"), ("lb", "lbf"), ("lbs", "lbf")];

/// The unit of that name, however it is written.
pub(super) fn unit_named(text: &str) -> Option<&'static Unit> {
    let plain = text.trim().replace('μ', "µ");
    let lower = plain.to_lowercase();
    let alias = || ALIASES.iter().find(|(alias, _)| *alias == lower);
    units::named(&plain).or_else(|| units::named(alias()?.1))
}

/// The weight of what a mass of that name says.
fn weight_named(text: &str) -> Option<&'static Unit> {
    let mass = text.trim().to_lowercase();
    units::named(WEIGHTS.iter().find(|(other, _)| *other == mass)?.1)
}

/// Whether a cell is a unit, in brackets or not, as in a row below the names.
pub(super) fn is_unit(cell: &str) -> bool {
    let inner = cell.trim_matches(|c: char| "()[]{}<>".contains(c));
    cell.starts_with(['(', '[', '{', '<'])
        || matches!(inner, "-" | "—")
        || weight_named(inner).is_some()
        || unit_named(inner).is_some()
}

impl Seen {
    /// The unit that is written below the name, else in it: in brackets, behind a stroke or an underscore, or as its last word.
    pub(super) fn unit(&self) -> Option<&'static Unit> {
        let inner = |text: &String| self.named(text.trim_matches(|c: char| "()[]{}<>".contains(c)));
        self.below.iter().find_map(inner).or_else(|| self.unit_in_name().map(|(_, unit)| unit))
    }

    /// What a message calls it.
    pub(super) fn shown(&self) -> String {
        match self.name.as_str() {
            "" => format!("column {}", self.index + 1),
            name => format!("`{name}`"),
        }
    }

    /// The unit of that name; a mass is the weight of it where the column is called a force, and a capital S a second where it is called
    /// a time.
    fn named(&self, text: &str) -> Option<&'static Unit> {
        let name = self.name.to_lowercase();
        let called = |list: &[&str]| list.iter().any(|word| word.len() > 2 && name.contains(word));
        let weight = || weight_named(text).filter(|_| called(FORCES));
        let second = || units::named("s").filter(|_| text.trim() == "S" && called(TIMES));
        unit_named(text).or_else(weight).or_else(second)
    }

    /// The name without its unit, and the unit.
    fn unit_in_name(&self) -> Option<(&str, &'static Unit)> {
        let name = self.name.trim();
        if let Some((rest, unit)) = name
            .strip_suffix([')', ']', '}', '>'])
            .and_then(|open| open.rsplit_once(['(', '[', '{', '<']))
            .and_then(|(rest, unit)| Some((rest, self.named(unit)?)))
        {
            return Some((rest, unit));
        }
        if let Some(unit) = units::of_column(name) {
            return Some((name.strip_suffix(unit.name)?, unit));
        }
        // What `rostopic echo -p` calls its clock.
        if let Some(rest) = name.strip_prefix('%').filter(|rest| *rest == "time") {
            return Some((rest, units::named("ns")?));
        }
        // A clock that is called by its unit: `millis`.
        if let Some(unit) = unit_named(name).filter(|unit| unit.quantity == Quantity::Time) {
            return Some((name, unit));
        }
        let (rest, unit) = name.rsplit_once(['/', ' ', ',', '_'])?;
        // A single letter behind a blank is more often a name (`Channel C`) than a unit.
        let letter = unit.len() == 1 && !matches!(unit, "s" | "S" | "N");
        let behind_blank = name[..name.len() - unit.len()].ends_with([' ', '_']);
        (!(letter && behind_blank)).then_some(())?;
        Some((rest, self.named(unit)?))
    }

    /// The name without its unit, in small letters.
    fn words(&self) -> String {
        let name = self.unit_in_name().map_or(self.name.as_str(), |(rest, _)| rest);
        name.to_lowercase().replace('_', " ").trim().to_owned()
    }

    /// The place in a list of words of the first that the name has.
    fn rank(&self, list: &[&str]) -> Option<usize> {
        let (words, whole) = (self.words(), self.name.to_lowercase());
        let alone = |word: &str| {
            words.split(|c: char| !c.is_alphanumeric() && c != '#').any(|part| part == word)
        };
        let has = |&word: &&str| match word.len() {
            1 | 2 => alone(word),
            _ => words.contains(word) || whole == word,
        };
        list.iter().position(has)
    }

    fn rises(&self) -> bool {
        self.values.len() > 2 && self.values.windows(2).all(|pair| pair[0] < pair[1])
    }

    fn measures(&self, quantity: Quantity) -> bool {
        self.unit().is_some_and(|unit| unit.quantity == quantity)
    }
}

/// Which column is time: one that rises steadily, and is a written time, is called so, has a unit of time, or at least is no
/// counter; else the first that is called so.
pub(super) fn time_of(columns: &[Seen]) -> usize {
    let is_time = |column: &Seen| column.rank(TIMES).is_some();
    let unit = |column: &Seen| column.measures(Quantity::Time);
    let nothing = |column: &Seen| {
        column.unit().is_none()
            && column.rank(COUNTERS).is_none()
            && [FORCES, DISPLACEMENTS, TEMPERATURES].iter().all(|list| column.rank(list).is_none())
    };
    let rules: [&dyn Fn(&Seen) -> bool; 7] = [
        &|column| column.name == TIME,
        &|column| column.rises() && matches!(column.kind, Kind::Time(_)),
        &|column| column.rises() && is_time(column),
        &|column| column.rises() && unit(column),
        &|column| column.rises() && nothing(column),
        &is_time,
        &|_| true,
    ];
    rules.iter().find_map(|rule| columns.iter().position(rule)).unwrap_or(0)
}

/// What the columns other than time become, in their order. A name that a trace knows goes to the one column that has its unit,
/// or, of several, the one that is called so most plainly.
pub(super) fn proposals(columns: &[&Seen]) -> Vec<Proposal> {
    let force = chosen(columns, Quantity::Force, FORCES);
    let displacement = chosen(columns, Quantity::Length, DISPLACEMENTS);
    let temperature = chosen(columns, Quantity::Temperature, TEMPERATURES)
        .filter(|&index| columns[index].unit().is_some());
    let known = [(force, FORCE), (displacement, DISPLACEMENT), (temperature, TEMPERATURE)];
    let mut taken = vec![TIME.to_owned()];
    taken.extend(known.iter().filter(|(index, _)| index.is_some()).map(|(_, name)| (*name).into()));
    let mut found = Vec::new();
    for (at, column) in columns.iter().enumerate() {
        let unit = column.unit();
        let role = known.iter().find(|(index, _)| *index == Some(at)).map(|(_, name)| *name);
        let name = match role {
            Some(name) => name.to_owned(),
            None => own_name(column, &taken),
        };
        taken.push(name.clone());
        let unit = unit.filter(|_| units::of_column(&name).is_some());
        found.push(Proposal { guessed: role.is_some() && unit.is_none(), name, unit });
    }
    found
}

fn chosen(columns: &[&Seen], quantity: Quantity, words: &[&str]) -> Option<usize> {
    let only = |mut found: Box<dyn Iterator<Item = usize> + '_>| {
        found.next().filter(|_| found.next().is_none())
    };
    let all = || columns.iter().enumerate();
    let with_unit = || all().filter(|(_, column)| column.measures(quantity));
    let best = |found: Vec<(usize, usize)>| {
        let rank = found.iter().map(|&(_, rank)| rank).min()?;
        only(Box::new(found.into_iter().filter(move |&(_, other)| other == rank).map(|(at, _)| at)))
    };
    let ranked = |found: &mut dyn Iterator<Item = (usize, &&Seen)>| {
        best(found.filter_map(|(at, column)| Some((at, column.rank(words)?))).collect())
    };
    match with_unit().count() {
        0 => ranked(&mut all().filter(|(_, column)| column.unit().is_none())),
        1 => with_unit().next().map(|(at, _)| at),
        _ => ranked(&mut with_unit()),
    }
}

/// A name of letters, digits and underscores that no other column has, with its unit behind it.
fn own_name(column: &Seen, taken: &[String]) -> String {
    let free = |name: &String| !taken.contains(name) && names::check(&[name]).is_ok();
    if units::of_column(&column.name).is_some() && !column.name.contains(' ') && free(&column.name)
    {
        return column.name.clone();
    }
    let unit = column.unit().map(|unit| match unit.name {
        "°C" => "C",
        "%" => "percent",
        "1/Pa" => "per_Pa",
        "1/kPa" => "per_kPa",
        "1/MPa" => "per_MPa",
        name => name,
    });
    let unit = unit.filter(|unit| *unit != "1").map(|unit| format!("_{}", unit.replace('µ', "u")));
    let word = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let plain: String = column.words().chars().map(word).collect();
    let words: Vec<&str> = plain.split('_').filter(|word| !word.is_empty()).collect();
    let base = match &words[..] {
        [] => format!("column_{}", column.index + 1),
        words => words.join("_"),
    };
    let unit = unit.unwrap_or_default();
    (1..)
        .map(
            |count| {
                if count == 1 { format!("{base}{unit}") } else { format!("{base}_{count}{unit}") }
            },
        )
        .find(free)
        .unwrap_or(base)
}

/// Whether a column is a gap, which falls while it is pressed.
pub(super) fn is_gap(column: &Seen) -> bool {
    column.rank(&["gap", "abstand"]).is_some()
}

/// Whether a column is a strain.
pub(super) fn is_strain(column: &Seen) -> bool {
    column.rank(&["strain", "dehnung", "stauchung", "应变", "ひずみ"]).is_some()
}
