//! `DATASUM` and `CHECKSUM` of an HDU (FITS standard 4.0, section 4.4.2.7 and appendix J).

use crate::machine::Native;
use skyfront_core::arithmetic::machine::{Machine, Task};

/// The sum of 32-bit words in ones' complement: what is carried out at the top comes in at the bottom.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum(u32);

impl Sum {
    /// Adds the big-endian words of `bytes`; words that the end cuts short are filled with zeros, so that only the
    /// last piece may be none of four bytes.
    pub(super) fn add(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<4>();
        let mut last = [0; 4];
        last.iter_mut().zip(rest).for_each(|(to, &from)| *to = from);
        for words in [words, &[last]] {
            self.0 = carried(u64::from(self.0) + u64::from(carried(Native::wide(Words(words)))));
        }
    }

    /// The sum, as `DATASUM` tells it.
    pub(super) fn value(self) -> u32 {
        self.0
    }

    /// The text which, as the value of `CHECKSUM` in place of sixteen zeros, makes the whole sum -0.
    pub(super) fn text(self) -> String {
        let mut columns = (!self.0).to_be_bytes().map(letters);
        // Letters and digits only: what one character gains, the other of its pair loses.
        for column in &mut columns {
            while let Some(pair) =
                (0..2).find(|&pair| !column[2 * pair..2 * pair + 2].iter().all(u8::is_ascii_alphanumeric))
            {
                column[2 * pair] += 1;
                column[2 * pair + 1] -= 1;
            }
        }
        let mut text: Vec<char> = (0..16).map(|at| char::from(columns[at % 4][at / 4])).collect();
        // The value begins at the last byte of a word of its card.
        text.rotate_right(1);
        text.into_iter().collect()
    }
}

/// Four characters whose distances from `0` add up to the byte.
fn letters(byte: u8) -> [u8; 4] {
    let quarter = b'0' + byte / 4;
    [quarter + byte % 4, quarter, quarter, quarter]
}

/// Big-endian words that are summed up. No image has 2^32 of them a piece: the sum stays within 64 bits.
struct Words<'a>(&'a [[u8; 4]]);

impl Task for Words<'_> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        self.0.iter().map(|&word| u64::from(u32::from_be_bytes(word))).sum()
    }
}

fn carried(sum: u64) -> u32 {
    let folded = (sum & 0xffff_ffff) + (sum >> 32);
    ((folded & 0xffff_ffff) + (folded >> 32)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_sums_have_the_texts_that_astropy_gives_them() {
        for (complement, text) in [(868_229_149u32, "7Bf889Z87Af877Z8"), (0xdead_beef, "kiafngVZkgadkgUZ")] {
            let mut sum = Sum::default();
            sum.add(&(!complement).to_be_bytes());
            assert_eq!(sum.text(), text);
        }
        assert_eq!(Sum(u32::MAX).text(), "0000000000000000");
    }

    #[test]
    fn carries_come_in_at_the_bottom_and_pieces_add_up() {
        let mut whole = Sum::default();
        whole.add(&[0xff, 0xff, 0xff, 0xff, 0, 0, 0, 2, 0, 0, 1]);
        assert_eq!(whole.value(), 0x102);
        let mut pieces = Sum::default();
        pieces.add(&[0xff, 0xff, 0xff, 0xff]);
        pieces.add(&[0, 0, 0, 2, 0, 0, 1]);
        assert_eq!(pieces.value(), whole.value());
    }

    #[test]
    fn every_text_is_letters_and_digits_and_stands_for_its_sum() {
        for seed in 0..20_000u32 {
            let sum = Sum(seed.wrapping_mul(2_654_435_761));
            let text = sum.text();
            assert!(text.bytes().all(|b| b.is_ascii_alphanumeric()), "{text}");
            let mut back = Sum::default();
            let mut bytes: Vec<u8> = text.bytes().map(|b| b - b'0').collect();
            bytes.rotate_left(1);
            bytes.chunks(4).for_each(|word| back.add(word));
            assert_eq!(back.value() % u32::MAX, !sum.value() % u32::MAX, "{text}");
        }
    }
}
