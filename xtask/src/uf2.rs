//! UF2: an image as a file that is drawn onto the disk which a loader shows. Blocks of 512 bytes, each with its address, so that
//! they may come in any order (github.com/microsoft/uf2).

/// What a block begins with, and what it ends with.
const BEGIN: [u32; 2] = [0x0a32_4655, 0x9e5d_5157];
const END: u32 = 0x0ab1_6f30;
/// The word behind the numbers of the block names the family of chips.
const HAS_FAMILY: u32 = 0x2000;
/// Bytes of a block, and of the image in it.
const BLOCK: usize = 512;
const PAYLOAD: usize = 256;

/// A family of chips, by the number that its loaders know it by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Family {
    /// STM32F4, with the loader TinyUF2.
    Stm32F4 = 0x5775_5a57,
    /// RP2350, its Arm cores, with the loader in ROM.
    Rp2350 = 0xe48b_ff59,
}

/// The file for an image that begins at an address.
pub fn file(image: &[u8], address: u32, family: Family) -> Vec<u8> {
    let pieces = image.chunks(PAYLOAD);
    let blocks = pieces.len() as u32;
    let block = |(number, piece): (u32, &[u8])| {
        let at = address + number * PAYLOAD as u32;
        let head = [HAS_FAMILY, at, PAYLOAD as u32, number, blocks, family as u32];
        let words = BEGIN.into_iter().chain(head).flat_map(u32::to_le_bytes);
        let mut block: Vec<u8> = words.chain(piece.iter().copied()).collect();
        block.resize(BLOCK - 4, 0);
        block.extend(END.to_le_bytes());
        block
    };
    (0..).zip(pieces).flat_map(block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_of_the_image_is_at_its_address_in_some_block() {
        let image: Vec<u8> = (0..1_000_u32).map(|at| (at * 7) as u8).collect();
        let file = file(&image, 0x0801_0000, Family::Stm32F4);
        let mut flash = vec![0; 1_024];
        let word = |block: &[u8], at: usize| {
            u32::from_le_bytes(block[4 * at..4 * at + 4].try_into().unwrap())
        };
        for (number, block) in (0..).zip(file.chunks(BLOCK)) {
            assert_eq!(
                [word(block, 0), word(block, 1), word(block, 127)],
                [BEGIN[0], BEGIN[1], END]
            );
            assert_eq!([word(block, 5), word(block, 6)], [number, 4]);
            assert_eq!(word(block, 7), 0x5775_5a57);
            let at = (word(block, 3) - 0x0801_0000) as usize;
            flash[at..at + PAYLOAD].copy_from_slice(&block[32..32 + PAYLOAD]);
        }
        assert_eq!(flash[..1_000], image);
    }
}
