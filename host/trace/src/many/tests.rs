use std::path::PathBuf;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};

use super::*;
use crate::TIME;

/// One row: trace, finger, day since 1970, time, force.
type Sample = (&'static str, i64, i32, f64, f64);

/// A file of rows in groups of rows, columns optional as other programs write them.
fn file(folder: &Path, rows: &[Sample], group: usize) -> PathBuf {
    let column = |name: &str, kind, logical| {
        let column = Type::primitive_type_builder(name, kind);
        let column = column.with_repetition(Repetition::OPTIONAL).with_logical_type(logical);
        Arc::new(column.build().unwrap())
    };
    let fields: Vec<TypePtr> = vec![
        column("trace_id", Physical::BYTE_ARRAY, Some(LogicalType::String)),
        column("finger", Physical::INT64, None),
        column("day", Physical::INT32, Some(LogicalType::Date)),
        column(TIME, Physical::DOUBLE, None),
        column("force_N", Physical::DOUBLE, None),
    ];
    let schema = Type::group_type_builder("long").with_fields(fields).build().unwrap();
    let path = folder.join("long.parquet");
    // Small pages, so that some are skipped.
    let properties = WriterProperties::builder()
        .set_data_page_row_count_limit(3)
        .set_write_batch_size(1)
        .build();
    let out = File::create(&path).unwrap();
    let mut writer =
        SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties)).unwrap();
    for rows in rows.chunks(group) {
        let there = vec![1_i16; rows.len()];
        let mut group = writer.next_row_group().unwrap();
        for place in 0..5 {
            let mut column = group.next_column().unwrap().unwrap();
            let there = Some(&there[..]);
            match place {
                0 => {
                    let ids: Vec<_> = rows.iter().map(|row| ByteArray::from(row.0)).collect();
                    column.typed::<ByteArrayType>().write_batch(&ids, there, None)
                }
                1 => {
                    let fingers: Vec<_> = rows.iter().map(|row| row.1).collect();
                    column.typed::<Int64Type>().write_batch(&fingers, there, None)
                }
                2 => {
                    let days: Vec<_> = rows.iter().map(|row| row.2).collect();
                    column.typed::<Int32Type>().write_batch(&days, there, None)
                }
                3 => {
                    let times: Vec<_> = rows.iter().map(|row| row.3).collect();
                    column.typed::<DoubleType>().write_batch(&times, there, None)
                }
                _ => {
                    let forces: Vec<_> = rows.iter().map(|row| row.4).collect();
                    column.typed::<DoubleType>().write_batch(&forces, there, None)
                }
            }
            .unwrap();
            column.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
    path
}

/// Traces of 4, 7, 2, … samples.
fn samples() -> Vec<Sample> {
    let traces = [("a", 3, 4), ("b", 3, 7), ("c", 4, 2), ("d", 4, 9), ("e", 4, 5)];
    let rows = traces.iter().flat_map(|&(id, finger, rows)| {
        (0..rows)
            .map(move |k| (id, finger, 20_760, f64::from(k), f64::from(k) + 100.0 * finger as f64))
    });
    rows.collect()
}

#[test]
fn the_traces_of_a_file_are_found_by_their_names_across_groups_of_rows() {
    let folder = tempfile::tempdir().unwrap();
    for group in [100, 5, 1] {
        let path = file(folder.path(), &samples(), group);
        let found = runs(&path, "trace_id", &["finger", "day"]).unwrap();
        let shown: Vec<String> = found
            .iter()
            .map(|run| {
                format!("{} {} {} {}+{}", run.id, run.keys[0], run.keys[1], run.first, run.rows)
            })
            .collect();
        let day = "2026-11-03";
        assert_eq!(
            shown,
            [
                format!("a 3 {day} 0+4"),
                format!("b 3 {day} 4+7"),
                format!("c 4 {day} 11+2"),
                format!("d 4 {day} 13+9"),
                format!("e 4 {day} 22+5"),
            ]
        );
    }
}

#[test]
fn traces_are_read_forward_or_back_as_they_lie() {
    let folder = tempfile::tempdir().unwrap();
    for group in [100, 5] {
        let path = file(folder.path(), &samples(), group);
        let found = runs(&path, "trace_id", &[]).unwrap();
        let mut rows = Rows::open(
            &path,
            &Names { beside: vec!["trace_id".into(), "finger".into()], called: Vec::new() },
        )
        .unwrap();
        for index in [0, 1, 3, 4, 2, 2, 0] {
            let run = &found[index];
            let trace = rows.trace(&run.id, run.first, run.rows).unwrap();
            assert_eq!(trace.label(), *run.id);
            let own: Vec<Sample> = samples().into_iter().filter(|row| *row.0 == *run.id).collect();
            assert_eq!(trace.time, own.iter().map(|row| row.3).collect::<Vec<_>>());
            assert_eq!(trace.force().unwrap(), own.iter().map(|row| row.4).collect::<Vec<_>>());
            // A date is no number of a trace, and a key is none either.
            assert_eq!(trace.columns.len(), 1);
        }
    }
}

#[test]
fn traces_whose_rows_lie_apart_and_columns_that_are_not_there_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut apart = samples();
    apart.swap(1, 20);
    let path = file(folder.path(), &apart, 100);
    let error = runs(&path, "trace_id", &[]).unwrap_err().to_string();
    assert!(error.contains("do not lie together"), "{error}");
    let error = runs(&path, "trace_id", &["operator"]).unwrap_err().to_string();
    assert!(error.contains("no column `operator`"), "{error}");
    let error = runs(&path, "force_N", &[]).unwrap_err().to_string();
    assert!(error.contains("neither text"), "{error}");
    std::fs::write(&path, "PAR1 and nothing").unwrap();
    assert!(runs(&path, "trace_id", &[]).is_err());
}

/// A file as LeRobot writes its data sets: the episode, its clock, and a list of two numbers a frame.
fn episodes(folder: &Path) -> PathBuf {
    let leaf = |name: &str, kind| {
        let leaf = Type::primitive_type_builder(name, kind);
        Arc::new(leaf.with_repetition(Repetition::OPTIONAL).build().unwrap())
    };
    let group = |name: &str, inside, repetition, logical| {
        let group = Type::group_type_builder(name).with_fields(vec![inside]);
        Arc::new(group.with_repetition(repetition).with_logical_type(logical).build().unwrap())
    };
    let each = group("list", leaf("element", Physical::FLOAT), Repetition::REPEATED, None);
    let state = group("observation.state", each, Repetition::OPTIONAL, Some(LogicalType::List));
    let fields: Vec<TypePtr> =
        vec![leaf("episode_index", Physical::INT64), leaf("timestamp", Physical::FLOAT), state];
    let schema = Type::group_type_builder("grasps").with_fields(fields).build().unwrap();
    let path = folder.join("file-000.parquet");
    let out = File::create(&path).unwrap();
    let mut writer = SerializedFileWriter::new(out, Arc::new(schema), Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    let there = [1; 5];
    column.typed::<Int64Type>().write_batch(&[0, 0, 0, 1, 1], Some(&there), None).unwrap();
    column.close().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    let times = [0.0, 0.5, 1.0, 0.0, 0.5];
    column.typed::<FloatType>().write_batch(&times, Some(&there), None).unwrap();
    column.close().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    let values: Vec<f32> = (0..10_u8).map(f32::from).collect();
    let goes_on = [0, 1].repeat(5);
    column.typed::<FloatType>().write_batch(&values, Some(&[3; 10]), Some(&goes_on)).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    path
}

#[test]
fn a_place_of_a_list_is_a_column_by_the_name_that_a_trace_has_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = episodes(folder.path());
    let names = |called: &[(&str, &str)]| Names {
        beside: vec!["episode_index".into()],
        called: called.iter().map(|&(from, to)| (from.into(), to.into())).collect(),
    };
    let called = [("timestamp", TIME), ("observation.state.1", "force_N")];
    let mut rows = Rows::open(&path, &names(&called)).unwrap();
    assert_eq!(rows.bytes_of(5), 5 * 2 * 8);
    let trace = rows.trace("1", 3, 2).unwrap();
    assert_eq!((&trace.time[..], trace.columns.len()), (&[0.0, 0.5][..], 1));
    assert_eq!(trace.column("force_N").unwrap(), [7.0, 9.0]);
    assert_eq!(rows.trace("0", 0, 3).unwrap().column("force_N").unwrap(), [1.0, 3.0, 5.0]);
    let error = |called: &[(&str, &str)]| {
        let rows = Rows::open(&path, &names(called)).and_then(|mut rows| rows.trace("0", 0, 3));
        rows.unwrap_err().to_string()
    };
    let too_far = error(&[("timestamp", TIME), ("observation.state.2", "force_N")]);
    assert!(too_far.contains("column `force_N`: a list is too short"), "{too_far}");
    let unknown = error(&[("timestamp", TIME), ("observation.force", "force_N")]);
    assert!(unknown.contains("there is no column `observation.force` of numbers"), "{unknown}");
    let without = error(&[]);
    assert!(without.contains("there is no column `time_s`"), "{without}");
}
