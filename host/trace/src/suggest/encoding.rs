//! The encoding that the first bytes of a text speak for.

use chardetng::{EncodingDetector, Iso2022JpDetection, Utf8Detection};
use encoding_rs::Encoding;

/// The encoding of a text that begins with `start`.
pub(super) fn encoding(start: &[u8]) -> &'static Encoding {
    let in_utf8 = match std::str::from_utf8(start) {
        Ok(_) => true,
        // A character cut by the end of what was read.
        Err(error) => error.error_len().is_none(),
    };
    match Encoding::for_bom(start) {
        Some((encoding, _)) => encoding,
        None if in_utf8 => encoding_rs::UTF_8,
        None if only_marks(start) => encoding_rs::WINDOWS_1252,
        None => {
            let mut detector = EncodingDetector::new(Iso2022JpDetection::Deny);
            detector.feed(start, false);
            detector.guess(None, Utf8Detection::Deny)
        }
    }
}

/// Whether no two bytes beyond ASCII stand together: `µ`, `°`, `²` and letters with accents among others. Words of languages
/// that need two bytes for a letter have runs of them.
fn only_marks(start: &[u8]) -> bool {
    start.windows(2).all(|pair| pair.iter().any(u8::is_ascii))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_encodings_of_instruments_are_told_apart() {
        let cases = [
            ("时间;位移;载荷\ns;mm;N\n", encoding_rs::GBK),
            ("時間;変位;荷重\ns;mm;N\n", encoding_rs::SHIFT_JIS),
            ("Zeit;Weg;Temperatur\ns;µm;°C\nDrücken;größer;²\n", encoding_rs::WINDOWS_1252),
            ("时间;位移\n", encoding_rs::UTF_8),
            ("t;x\n", encoding_rs::UTF_8),
        ];
        for (text, expected) in cases {
            let rows = text.to_owned() + &"0,5;1,5;2\n".repeat(50);
            let (bytes, ..) = expected.encode(&rows);
            assert_eq!(encoding(&bytes), expected, "{text}");
        }
    }
}
