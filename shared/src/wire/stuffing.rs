//! Bytes on their way into a frame: copied, summed and stuffed in one pass.

use core::mem::take;

use postcard::ser_flavors::Flavor;

use super::check::Check;
use super::frame::{FRAME_MAX, HEAD, Head};

/// Longest piece that waits for others, and how many bytes may wait.
const SHORT: usize = 10;
const WAITING: usize = 32;

/// A frame that is being written. Postcard writes the message straight into it; its first byte, the type, stands where the
/// head ends, and goes into the head.
///
/// COBS: the first byte, and every zero after it, becomes the distance to the next. A frame is too short to need a further
/// code byte.
pub(super) struct Stuffed<'f> {
    head: Option<Head>,
    /// Bytes that wait, so that a message of many short pieces costs no more than it must.
    waiting: [u8; WAITING],
    waiting_bytes: usize,
    written: Written<'f>,
}

/// What was written already, and the room behind it.
struct Written<'f> {
    check: Check,
    links: Links<'f>,
    room: &'f mut [u8],
}

/// The chain of zeros.
struct Links<'f> {
    /// The byte that says how far the next zero is.
    code: Option<&'f mut u8>,
    distance: u8,
}

impl<'f> Links<'f> {
    #[inline(always)]
    fn pass(&mut self, bytes: u8) {
        self.distance = self.distance.wrapping_add(bytes);
    }

    /// Passes bytes of which some may be zero.
    #[inline]
    fn look_at(&mut self, bytes: &'f mut [u8]) {
        for byte in bytes {
            if *byte == 0 {
                self.end();
                (self.code, self.distance) = (Some(byte), 0);
            }
            self.pass(1);
        }
    }

    #[inline]
    fn end(&mut self) {
        if let Some(code) = &mut self.code {
            **code = self.distance;
        }
    }
}

impl<'f> Stuffed<'f> {
    /// An empty frame.
    pub(super) fn new(head: Head, frame: &'f mut [u8; FRAME_MAX]) -> Self {
        let [code, room @ ..] = frame;
        let links = Links { code: Some(code), distance: 1 };
        Self {
            head: Some(head),
            waiting: [0; WAITING],
            waiting_bytes: HEAD.saturating_sub(1),
            written: Written { check: Check::new(), links, room },
        }
    }

    /// Lets a short piece wait.
    #[inline(always)]
    fn wait(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        if self.waiting_bytes > const { WAITING - SHORT } {
            self.flush()?;
        }
        let places = self.waiting.iter_mut().skip(self.waiting_bytes);
        for (place, byte) in places.zip(bytes) {
            *place = *byte;
        }
        self.waiting_bytes = self.waiting_bytes.wrapping_add(bytes.len());
        Ok(())
    }

    /// Puts what waits.
    fn flush(&mut self) -> postcard::Result<()> {
        if let Some(head) = self.head.take()
            && let Some(place) = self.waiting.first_chunk_mut::<HEAD>()
        {
            let [.., kind] = *place;
            *place = head.bytes(kind);
        }
        let bytes = take(&mut self.waiting_bytes);
        self.written.put(self.waiting.get(..bytes).unwrap_or_default())
    }
}

impl<'f> Written<'f> {
    /// Room for so many bytes.
    #[inline]
    fn place(&mut self, bytes: usize) -> postcard::Result<&'f mut [u8]> {
        let full = postcard::Error::SerializeBufferFull;
        let (place, room) = take(&mut self.room).split_at_mut_checked(bytes).ok_or(full)?;
        self.room = room;
        Ok(place)
    }

    fn put(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        let (to_words, to_tail) = self.place(bytes.len())?.as_chunks_mut::<4>();
        let (words, tail) = bytes.as_chunks::<4>();
        // Copies, for the loop to have them in registers.
        let mut check = self.check;
        let mut links = Links { code: self.links.code.take(), ..self.links };
        for (to, from) in to_words.iter_mut().zip(words) {
            let word = u32::from_le_bytes(*from);
            check = check.word(word);
            *to = *from;
            if has_zero(word) {
                links.look_at(to);
            } else {
                links.pass(4);
            }
        }
        for (to, from) in to_tail.iter_mut().zip(tail) {
            check = check.byte(*from);
            *to = *from;
            links.look_at(core::slice::from_mut(to));
        }
        (self.check, self.links) = (check, links);
        Ok(())
    }
}

impl Flavor for &mut Stuffed<'_> {
    /// How many bytes the frame has.
    type Output = usize;

    #[inline(never)]
    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.wait(&[byte])
    }

    #[inline(never)]
    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        if bytes.len() <= SHORT {
            return self.wait(bytes);
        }
        self.flush()?;
        self.written.put(bytes)
    }

    /// Adds the sum and ends the frame.
    fn finalize(self) -> postcard::Result<usize> {
        self.flush()?;
        let sum = self.written.check.sum().to_le_bytes();
        self.written.put(&sum)?;
        if let [end] = self.written.place(1)? {
            *end = 0;
        }
        self.written.links.end();
        Ok(FRAME_MAX.saturating_sub(self.written.room.len()))
    }
}

/// Whether any of four bytes is zero: only there a borrow reaches the upper bit that was not set.
const fn has_zero(word: u32) -> bool {
    word.wrapping_sub(0x0101_0101) & !word & 0x8080_8080 != 0
}
