//! The rows of a part of a survey as two Parquet files: what was found, which is the same in every run, and what it cost.

use std::fs::File;
use std::path::Path;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row as Record, RowAccessor};
use parquet::schema::types::{Type, TypePtr};

use super::columns::{Cells, Column, list, number, primitive, text, to_bytes, whole};
use super::row::{Estimate, Row, Said, Status, Worked};

/// Key of the version in the metadata of the files.
const ABOUT: &str = "palpate-survey";
/// Version of the tables.
pub const VERSION: &str = "1";
/// Columns that no key may be called by.
pub const RESERVED: [&str; 18] = [
    "group",
    "status",
    "reason",
    "traces",
    "samples",
    "unit",
    "residual_rms",
    "noise_rms",
    "heldout_rms",
    "r_squared",
    "verdict",
    "effects",
    "credible_set",
    "in_words",
    "next_experiment",
    "warnings",
    "estimates",
    "correlations",
];

/// One number of what an answer says.
type Number = fn(&Said) -> Option<f64>;

/// What was found, as Parquet.
pub(super) fn found_bytes(by: &[String], rows: &[Row]) -> Result<Vec<u8>, ParquetError> {
    let mut fields = vec![whole("group")?];
    let mut columns = vec![Column::Whole(rows.iter().map(|row| row.group as i64).collect())];
    for (k, key) in by.iter().enumerate() {
        fields.push(text(key)?);
        columns.push(texts(rows, |row| row.key[k].as_deref()));
    }
    fields.extend([text("status")?, text("reason")?, whole("traces")?, whole("samples")?]);
    columns.push(texts(rows, |row| Some(row.status.word())));
    columns.push(texts(rows, |row| row.reason.as_deref()));
    columns.push(Column::Whole(rows.iter().map(|row| row.traces as i64).collect()));
    columns.push(Column::Whole(rows.iter().map(|row| row.samples as i64).collect()));
    fields.push(text("unit")?);
    columns.push(texts(rows, |row| row.said.unit.as_deref()));
    let errors: [(&str, Number); 4] = [
        ("residual_rms", |said| said.residual_rms),
        ("noise_rms", |said| said.noise_rms),
        ("heldout_rms", |said| said.heldout_rms),
        ("r_squared", |said| said.r_squared),
    ];
    for (name, of) in errors {
        fields.push(number(name)?);
        columns.push(Column::Number(Cells::of(rows.iter().map(|row| of(&row.said)))));
    }
    fields.push(text("verdict")?);
    columns.push(texts(rows, |row| row.said.verdict.as_deref()));
    fields.extend([words("effects")?, words("credible_set")?]);
    columns.push(lists(rows, |said| &said.effects));
    columns.push(lists(rows, |said| &said.credible_set));
    fields.extend([text("in_words")?, text("next_experiment")?, words("warnings")?]);
    columns.push(texts(rows, |row| row.said.in_words.as_deref()));
    columns.push(texts(rows, |row| row.said.next_experiment.as_deref()));
    columns.push(lists(rows, |said| &said.warnings));
    fields.push(estimates_field()?);
    columns.extend(estimates(rows));
    fields
        .push(list("correlations", primitive("element", Physical::DOUBLE, Repetition::REQUIRED)?)?);
    let correlations = |row: &'_ Row| {
        row.said.correlations.iter().copied().map(Some).collect::<Vec<_>>().into_iter()
    };
    columns.push(Column::Number(Cells::lists(rows.iter().map(correlations), false)));
    to_bytes("survey", fields, columns, (ABOUT, VERSION.into()))
}

/// What it cost, as Parquet.
pub(super) fn worked_bytes(rows: &[(u64, Worked)]) -> Result<Vec<u8>, ParquetError> {
    let fields = vec![whole("group")?, number("cpu_seconds")?, whole("attempts")?];
    let columns = vec![
        Column::Whole(rows.iter().map(|(group, _)| *group as i64).collect()),
        Column::Number(Cells::of(rows.iter().map(|(_, worked)| Some(worked.seconds)))),
        Column::Whole(rows.iter().map(|(_, worked)| worked.attempts as i64).collect()),
    ];
    to_bytes("work", fields, columns, (ABOUT, VERSION.into()))
}

fn texts<'a>(rows: &'a [Row], of: impl Fn(&'a Row) -> Option<&'a str>) -> Column {
    Column::Text(Cells::of(rows.iter().map(|row| of(row).map(ByteArray::from))))
}

fn words(name: &str) -> Result<TypePtr, ParquetError> {
    list(name, primitive("element", Physical::BYTE_ARRAY, Repetition::REQUIRED)?)
}

fn lists<'a>(rows: &'a [Row], of: impl Fn(&'a Said) -> &'a Vec<String>) -> Column {
    let list = |row: &'a Row| of(&row.said).iter().map(|word| Some(ByteArray::from(word.as_str())));
    Column::Text(Cells::lists(rows.iter().map(list), false))
}

fn estimates_field() -> Result<TypePtr, ParquetError> {
    let part = |name, kind, repetition| primitive(name, kind, repetition);
    let element = Type::group_type_builder("element")
        .with_repetition(Repetition::REQUIRED)
        .with_fields(vec![
            part("of", Physical::BYTE_ARRAY, Repetition::REQUIRED)?,
            part("name", Physical::BYTE_ARRAY, Repetition::REQUIRED)?,
            part("value", Physical::DOUBLE, Repetition::REQUIRED)?,
            part("standard_error", Physical::DOUBLE, Repetition::OPTIONAL)?,
            part("unit", Physical::BYTE_ARRAY, Repetition::REQUIRED)?,
        ])
        .build()?;
    list("estimates", element.into())
}

fn estimates(rows: &[Row]) -> [Column; 5] {
    let text = |of: fn(&Estimate) -> &str| {
        let list = move |row: &'_ Row| {
            let cells = row.said.estimates.iter().map(|it| Some(ByteArray::from(of(it))));
            cells.collect::<Vec<_>>().into_iter()
        };
        Column::Text(Cells::lists(rows.iter().map(list), false))
    };
    let number = |of: fn(&Estimate) -> Option<f64>, optional| {
        let list =
            move |row: &'_ Row| row.said.estimates.iter().map(of).collect::<Vec<_>>().into_iter();
        Column::Number(Cells::lists(rows.iter().map(list), optional))
    };
    [
        text(|it| &it.of),
        text(|it| &it.name),
        number(|it| Some(it.value), false),
        number(|it| it.standard_error, true),
        text(|it| &it.unit),
    ]
}

/// Reads what was found, row by row.
///
/// # Errors
/// In words, when the file is no such table.
pub(super) fn read(path: &Path, by: &[String], mut each: impl FnMut(Row)) -> Result<(), String> {
    for record in records(path)? {
        each(row_of(&record?, by)?);
    }
    Ok(())
}

/// Reads what it cost.
///
/// # Errors
/// In words, when the file is no such table.
pub(super) fn read_work(path: &Path, mut each: impl FnMut(u64, Worked)) -> Result<(), String> {
    let words = |error: ParquetError| error.to_string();
    for record in records(path)? {
        let record = record?;
        let worked = Worked {
            seconds: record.get_double(1).map_err(words)?,
            attempts: record.get_long(2).map_err(words)? as u64,
        };
        each(record.get_long(0).map_err(words)? as u64, worked);
    }
    Ok(())
}

fn records(path: &Path) -> Result<impl Iterator<Item = Result<Record, String>>, String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let reader = SerializedFileReader::new(file).map_err(|error| error.to_string())?;
    let pairs = reader.metadata().file_metadata().key_value_metadata();
    let version = pairs.into_iter().flatten().find(|pair| pair.key == ABOUT);
    match version.and_then(|pair| pair.value.as_deref()) {
        Some(VERSION) => {}
        Some(other) => {
            return Err(format!("version {other}, this program reads version {VERSION}"));
        }
        None => return Err("is no table of a survey".into()),
    }
    let records = reader.into_iter();
    Ok(records.map(|record| record.map_err(|error| error.to_string())))
}

fn row_of(record: &Record, by: &[String]) -> Result<Row, String> {
    let columns: Vec<(&String, &Field)> = record.get_column_iter().collect();
    let field = |name: &str| {
        let found = columns.iter().find(|(column, _)| *column == name);
        found.map(|(_, field)| *field).ok_or_else(|| format!("there is no column `{name}`"))
    };
    let whole = |name: &str| match field(name)? {
        Field::Long(value) => Ok(*value as u64),
        other => Err(format!("column `{name}` holds {other}")),
    };
    let status = text_of(field("status")?).unwrap_or_default();
    let status = Status::ALL.into_iter().find(|known| known.word() == status);
    let mut estimates = Vec::new();
    for element in elements(field("estimates")?) {
        if let Field::Group(element) = element {
            estimates.push(estimate_of(element)?);
        }
    }
    // Surveys of before this column was there are read without.
    let correlations = field("correlations").map(elements).unwrap_or_default();
    let words = |name: &str| {
        Ok::<_, String>(elements(field(name)?).iter().filter_map(text_of).collect::<Vec<_>>())
    };
    Ok(Row {
        group: whole("group")?,
        key: by.iter().map(|key| field(key).map(text_of)).collect::<Result<_, _>>()?,
        status: status.ok_or("a status is not known")?,
        reason: text_of(field("reason")?),
        traces: whole("traces")?,
        samples: whole("samples")?,
        said: Said {
            unit: text_of(field("unit")?),
            residual_rms: number_of(field("residual_rms")?),
            noise_rms: number_of(field("noise_rms")?),
            heldout_rms: number_of(field("heldout_rms")?),
            r_squared: number_of(field("r_squared")?),
            verdict: text_of(field("verdict")?),
            effects: words("effects")?,
            credible_set: words("credible_set")?,
            in_words: text_of(field("in_words")?),
            next_experiment: text_of(field("next_experiment")?),
            warnings: words("warnings")?,
            estimates,
            correlations: correlations.iter().filter_map(number_of).collect(),
        },
    })
}

fn estimate_of(element: &Record) -> Result<Estimate, String> {
    let fields: Vec<&Field> = element.get_column_iter().map(|(_, field)| field).collect();
    let [of, name, value, standard_error, unit] = &fields[..] else {
        return Err("an estimate has other columns".into());
    };
    Ok(Estimate {
        of: text_of(of).unwrap_or_default(),
        name: text_of(name).unwrap_or_default(),
        value: number_of(value).ok_or("an estimate has no value")?,
        standard_error: number_of(standard_error),
        unit: text_of(unit).unwrap_or_default(),
    })
}

fn text_of(field: &Field) -> Option<String> {
    match field {
        Field::Str(text) => Some(text.clone()),
        _ => None,
    }
}

fn number_of(field: &Field) -> Option<f64> {
    match field {
        Field::Double(value) => Some(*value),
        _ => None,
    }
}

fn elements(field: &Field) -> &[Field] {
    match field {
        Field::ListInternal(list) => list.elements(),
        _ => &[],
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    fn estimate(of: &str, value: f64, standard_error: Option<f64>) -> Estimate {
        let (name, unit) = ("c1".to_owned(), "N".to_owned());
        Estimate { of: of.into(), name, value, standard_error, unit }
    }

    /// Three rows: nothing said, everything said, lists of one.
    pub(crate) fn rows() -> Vec<Row> {
        let row = |group, status, said| Row {
            group,
            key: vec![Some(format!("finger {group}")), None],
            status,
            reason: (status != Status::Done).then(|| "no contact".into()),
            traces: group,
            samples: 1000 * group,
            said,
        };
        let full = Said {
            unit: Some("N".into()),
            residual_rms: Some(0.1 + 0.2),
            noise_rms: Some(f64::MIN_POSITIVE),
            heldout_rms: Some(1e300),
            r_squared: Some(-0.5),
            verdict: Some("named".into()),
            effects: vec!["mullins".into(), "drift".into()],
            credible_set: vec!["drift".into()],
            in_words: Some("ä \"quoted\"".into()),
            next_experiment: Some("hold longer".into()),
            warnings: vec!["one".into(), String::new(), "three".into()],
            estimates: vec![
                estimate("", 1.0 / 3.0, None),
                estimate("mullins", 5e-324, Some(0.1)),
                estimate("drift", -0.0, None),
            ],
            correlations: vec![0.5, -1.0 / 3.0, -0.0],
        };
        let few = Said { estimates: vec![estimate("", 2.0, Some(3.0))], ..Said::default() };
        vec![
            row(0, Status::Refused, Said::default()),
            row(1, Status::Done, full),
            row(2, Status::Failed, few),
            row(3, Status::Failed, Said::default()),
        ]
    }

    #[test]
    fn rows_come_back_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let by = ["finger".to_owned(), "specimen.batch".to_owned()];
        let path = folder.path().join("part.parquet");
        std::fs::write(&path, found_bytes(&by, &rows()).unwrap()).unwrap();
        let mut back = Vec::new();
        read(&path, &by, |row| back.push(row)).unwrap();
        assert_eq!(back, rows());
        assert!(back[1].said.estimates[2].value.is_sign_negative());
    }

    #[test]
    fn what_it_cost_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.parquet");
        let worked = [
            (4, Worked { seconds: 0.25, attempts: 1 }),
            (5, Worked { seconds: 1e-9, attempts: 2 }),
        ];
        std::fs::write(&path, worked_bytes(&worked).unwrap()).unwrap();
        let mut back = Vec::new();
        read_work(&path, |group, worked| back.push((group, worked))).unwrap();
        assert_eq!(back, worked);
    }
}
