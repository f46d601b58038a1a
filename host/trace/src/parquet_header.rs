//! What the headers of a Parquet file hold: the structs of the format (parquet.thrift of parquet-format 2.12), each as the kinds of its
//! fields 1, 2, … in turn.

use super::thrift::Kind::{self, Bool, Byte, Double, List, Number, Struct, Text};

/// The header of the whole file, `FileMetaData`.
pub(super) const FILE: &[Kind] = &[
    Number,
    List(&Struct(SCHEMA_ELEMENT)),
    Number,
    List(&Struct(ROW_GROUP)),
    List(&Struct(KEY_VALUE)),
    Text,
    // A column order has one case, without fields.
    List(&Struct(&[Struct(EMPTY), Struct(EMPTY)])),
];

/// The header of a page, `PageHeader`.
pub(super) const PAGE: &[Kind] = &[
    Number,
    Number,
    Number,
    Number,
    // Data, index, dictionary, and data of the second version.
    Struct(&[Number, Number, Number, Number, Struct(STATISTICS)]),
    Struct(EMPTY),
    Struct(&[Number, Number, Bool]),
    Struct(&[Number, Number, Number, Number, Number, Number, Bool, Struct(STATISTICS)]),
];

const EMPTY: &[Kind] = &[];

const KEY_VALUE: &[Kind] = &[Text, Text];

const SCHEMA_ELEMENT: &[Kind] =
    &[Number, Number, Number, Text, Number, Number, Number, Number, Number, Struct(LOGICAL_TYPE)];

/// The cases of `LogicalType`.
const LOGICAL_TYPE: &[Kind] = &[
    Struct(EMPTY),
    Struct(EMPTY),
    Struct(EMPTY),
    Struct(EMPTY),
    // Decimal.
    Struct(&[Number, Number]),
    Struct(EMPTY),
    // Time and timestamp.
    Struct(&[Bool, Struct(TIME_UNIT)]),
    Struct(&[Bool, Struct(TIME_UNIT)]),
    Struct(EMPTY),
    // Integer.
    Struct(&[Byte, Bool]),
    Struct(EMPTY),
    Struct(EMPTY),
    Struct(EMPTY),
    Struct(EMPTY),
    Struct(EMPTY),
    // Variant, geometry, geography.
    Struct(&[Byte]),
    Struct(&[Text]),
    Struct(&[Text, Number]),
];

const TIME_UNIT: &[Kind] = &[Struct(EMPTY), Struct(EMPTY), Struct(EMPTY)];

const ROW_GROUP: &[Kind] = &[
    List(&Struct(COLUMN_CHUNK)),
    Number,
    Number,
    // Sorting columns.
    List(&Struct(&[Number, Bool, Bool])),
    Number,
    Number,
    Number,
];

const COLUMN_CHUNK: &[Kind] = &[Text, Number, Struct(COLUMN), Number, Number, Number, Number];

/// `ColumnMetaData`.
const COLUMN: &[Kind] = &[
    Number,
    List(&Number),
    List(&Text),
    Number,
    Number,
    Number,
    Number,
    List(&Struct(KEY_VALUE)),
    Number,
    Number,
    Number,
    Struct(STATISTICS),
    // Encodings of pages.
    List(&Struct(&[Number, Number, Number])),
    Number,
    Number,
    // Sizes, and places on the globe.
    Struct(&[Number, List(&Number), List(&Number)]),
    Struct(&[Struct(BOUNDING_BOX), List(&Number)]),
];

const BOUNDING_BOX: &[Kind] = &[Double, Double, Double, Double, Double, Double, Double, Double];

const STATISTICS: &[Kind] = &[Text, Text, Number, Number, Text, Text, Bool, Bool, Number];
