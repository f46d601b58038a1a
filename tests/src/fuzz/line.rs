//! Frames whose check fits, whatever is in them.

use crc::{CRC_32_ISO_HDLC, Crc};
use shared::wire::MAX_CONTENT;

const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A frame around head and payload, its zero byte included.
#[must_use]
pub fn frame(content: &[u8]) -> Vec<u8> {
    let mut content = content[..content.len().min(MAX_CONTENT - 4)].to_vec();
    content.extend(CHECK.checksum(&content).to_le_bytes());
    let mut bytes = cobs::encode_vec(&content);
    bytes.push(0);
    bytes
}

/// The same bytes with the check of every frame put right, so that what is within is looked at.
#[must_use]
pub fn resealed(bytes: &[u8]) -> Vec<u8> {
    let mut all = Vec::with_capacity(bytes.len() + 8);
    for piece in bytes.split_inclusive(|byte| *byte == 0) {
        match cobs::decode_vec(piece.strip_suffix(&[0]).unwrap_or(piece)) {
            Ok(content) if content.len() > 4 => all.extend(frame(&content[..content.len() - 4])),
            _ => all.extend(piece),
        }
    }
    all
}
