//! The text export of JPK's force curves: the header says units, spring constant and segments.
//!
//! Nothing is guessed: units are read from the line `# units:`, only metres, newtons and seconds are taken, and what was
//! used is said in the notes of the curve.

use super::AfmError;
use super::curve::{COMES_AGAIN, ForceCurve, Segments, Stretch};

/// How a text export begins.
const FIRST_LINE: &str = "# TEXT EXPORT";
/// Columns of height, the best first: measured ones before the one that was commanded. All fall towards the specimen.
const HEIGHTS: [&str; 6] = [
    "smoothedCapacitiveSensorHeight",
    "smoothedStrainGaugeHeight",
    "capacitiveSensorHeight",
    "strainGaugeHeight",
    "measuredHeight",
    "height",
];

/// The kinds of segments that are read.
const SEGMENTS: [(&str, Stretch); 3] =
    [("extend", Stretch::Approach), ("pause", Stretch::Pause), ("retract", Stretch::Retract)];

/// Whether a text is such an export.
#[must_use]
pub fn is_export(text: &str) -> bool {
    text.lines().next().is_some_and(|line| line.trim_end() == FIRST_LINE)
}

/// One segment: what its header says, and its numbers.
#[derive(Default)]
struct Block {
    kind: String,
    columns: Vec<String>,
    units: Vec<String>,
    spring: Option<f64>,
    /// Line of the columns, from 1.
    line: usize,
    rows: Vec<Vec<f64>>,
}

/// Reads an export; `name` is what to call it.
///
/// # Errors
/// [`AfmError::Jpk`] names the line and what is wrong with it.
pub fn parse(name: &str, text: &str) -> Result<ForceCurve, AfmError> {
    let fault = |line: usize, problem: String| AfmError::Jpk { curve: name.into(), line, problem };
    let mut blocks: Vec<Block> = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let Some(header) = line.strip_prefix('#') else {
            if !line.trim().is_empty() {
                let block = blocks
                    .last_mut()
                    .ok_or_else(|| fault(number, "numbers before any `# segmentIndex:`".into()))?;
                block
                    .rows
                    .push(row(line, block.columns.len()).map_err(|what| fault(number, what))?);
            }
            continue;
        };
        let Some((key, value)) = header.split_once(':') else { continue };
        let (key, value) = (key.trim(), value.trim());
        if key == "segmentIndex" {
            blocks.push(Block::default());
        }
        let Some(block) = blocks.last_mut() else { continue };
        let words = || value.split_whitespace().map(String::from).collect();
        match key {
            "segment" => block.kind = value.into(),
            "columns" if !block.rows.is_empty() => {
                let problem = "`# columns:` again without a `# segmentIndex:` before it";
                return Err(fault(number, problem.into()));
            }
            "columns" => (block.columns, block.line) = (words(), number),
            "units" => block.units = words(),
            "springConstant" => block.spring = value.parse().ok().filter(|k: &f64| k.is_finite()),
            _ => {}
        }
    }
    blocks.retain(|block| !block.rows.is_empty());
    join(name, &blocks)
}

fn row(line: &str, count: usize) -> Result<Vec<f64>, String> {
    let number = |cell: &str| {
        cell.parse().ok().filter(|x: &f64| x.is_finite()).ok_or(format!("`{cell}` is no number"))
    };
    let row = line.split_whitespace().map(number).collect::<Result<Vec<f64>, _>>()?;
    if row.len() == count {
        Ok(row)
    } else {
        Err(format!("{} numbers where `# columns:` names {count}", row.len()))
    }
}

/// The segments one after the other.
fn join(name: &str, blocks: &[Block]) -> Result<ForceCurve, AfmError> {
    let first = blocks.first().ok_or_else(|| AfmError::Jpk {
        curve: name.into(),
        line: 1,
        problem: "no segment with numbers".into(),
    })?;
    let missing = |column: &str| AfmError::Jpk {
        curve: name.into(),
        line: first.line,
        problem: format!("no column `{column}`"),
    };
    let has = |column: &&str| blocks.iter().all(|block| block.columns.iter().any(|c| c == column));
    let height = HEIGHTS.into_iter().find(has).ok_or_else(|| missing("height"))?;
    let (mut time_s, mut piezo_m, mut force_n) = (Vec::new(), Vec::new(), Vec::new());
    let mut stretches = Vec::new();
    for block in blocks {
        let begin = time_s.len();
        time_s.extend(column(name, block, "seriesTime", "s")?);
        piezo_m.extend(column(name, block, height, "m")?.iter().map(|height| -height));
        force_n.extend(column(name, block, "vDeflection", "N")?);
        let known = SEGMENTS.iter().find(|(kind, _)| *kind == block.kind);
        let (_, stretch) = known.ok_or_else(|| {
            let all = SEGMENTS.map(|(kind, _)| kind).join(", ");
            let problem = format!("segment `{}` is none of {all}", block.kind);
            AfmError::Jpk { curve: name.into(), line: block.line, problem }
        })?;
        stretches.push((*stretch, begin..time_s.len()));
    }
    let (segments, comes_again) = Segments::joined(stretches);
    let mut notes = vec![format!("height: column `{height}`; force: `vDeflection`")];
    notes.push(match first.spring {
        Some(k) => format!("spring constant of the header: {k} N/m"),
        None => "the header states no spring constant".into(),
    });
    if comes_again {
        notes.push(COMES_AGAIN.into());
    }
    Ok(ForceCurve {
        label: name.into(),
        time_s,
        piezo_m,
        force_n,
        spring_n_per_m: first.spring,
        segments,
        notes,
    })
}

/// A column in its unit.
fn column(name: &str, block: &Block, column: &str, unit: &str) -> Result<Vec<f64>, AfmError> {
    let fault = |problem| AfmError::Jpk { curve: name.into(), line: block.line, problem };
    let place = block.columns.iter().position(|c| c == column);
    let place = place.ok_or_else(|| fault(format!("no column `{column}`")))?;
    match block.units.get(place) {
        Some(found) if found == unit => Ok(block.rows.iter().map(|row| row[place]).collect()),
        Some(found) => {
            Err(fault(format!("`{column}` is in {found}, not in {unit}: export calibrated values")))
        }
        None => Err(fault(format!("`# units:` gives no unit for `{column}`"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPORT: &str = "# TEXT EXPORT\n# springConstant: 9\n#\n# segmentIndex: 0\n# segment: extend\n\
        # columns: height vDeflection seriesTime\n# springConstant: 0.05\n# units: m N s\n\
        3e-6 0 0.0\n2e-6 0 0.1\n1e-6 1e-9 0.2\n#\n# segmentIndex: 1\n# segment: retract\n\
        # columns: height vDeflection seriesTime\n# units: m N s\n2e-6 0 0.3\n3e-6 0 0.4\n";

    #[test]
    fn segments_units_and_spring_constant_come_from_the_header() {
        assert!(is_export(EXPORT));
        let curve = parse("c.txt", EXPORT).unwrap();
        assert_eq!(curve.piezo_m, [-3e-6, -2e-6, -1e-6, -2e-6, -3e-6]);
        assert_eq!((curve.segments.approach, curve.segments.retract), (0..3, Some(3..5)));
        assert_eq!(curve.spring_n_per_m, Some(0.05));
        assert!(curve.notes[0].contains("`height`"));
    }

    #[test]
    fn an_approach_in_steps_is_one_with_its_pauses() {
        let columns = "# columns: height vDeflection seriesTime\n# units: m N s\n";
        let mut export = String::from("# TEXT EXPORT\n");
        for (index, kind) in
            ["extend", "pause", "extend", "pause", "retract", "pause", "extend"].iter().enumerate()
        {
            export += &format!("# segmentIndex: {index}\n# segment: {kind}\n{columns}");
            export += &format!("3e-6 0 {index}.0\n2e-6 0 {index}.5\n");
        }
        let curve = parse("c.txt", &export).unwrap();
        assert_eq!(curve.segments.approach, 0..8);
        assert_eq!(curve.segments.pauses, [2..4, 6..8]);
        assert_eq!(curve.segments.retract, Some(8..12));
        assert!(curve.notes.last().unwrap().contains("comes in again"));
    }

    #[test]
    fn what_is_not_calibrated_or_damaged_is_refused_with_its_line() {
        let refused = |from: &str, to: &str| {
            parse("c.txt", &EXPORT.replacen(from, to, 1)).unwrap_err().to_string()
        };
        assert!(refused("units: m N s", "units: m V s").contains("in V, not in N"));
        assert!(refused("2e-6 0 0.1", "2e-6 0").contains("line 10"));
        assert!(refused("2e-6 0 0.1", "2e-6 x 0.1").contains("`x` is no number"));
        assert!(refused("vDeflection", "deflection").contains("no column `vDeflection`"));
        assert!(refused("extend", "modulation").contains("none of extend"));
        // Numbers of two segments would stand under the names of one.
        assert!(refused("# segmentIndex: 1\n", "").contains("line 14"));
        assert!(parse("c.txt", "# TEXT EXPORT\n").is_err());
    }
}
