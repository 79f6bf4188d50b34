//! A bit for every pixel of a plane.

use crate::arithmetic::Level;

/// Bits of a word.
pub const WORD: usize = 32;

/// Words of the mask of a plane of so many pixels.
pub const fn mask_words(pixels: usize) -> usize {
    pixels.div_ceil(WORD)
}

/// Which pixels are marked; those beyond its end are not.
#[derive(Clone, Copy, Debug)]
pub struct Mask<'a>(pub &'a [u32]);

impl Mask<'_> {
    /// Whether a pixel is marked.
    #[inline]
    pub fn has(&self, at: usize) -> bool {
        self.0.get(at / WORD).is_some_and(|word| word >> (at % WORD) & 1 == 1)
    }

    /// [`WORD`] pixels from the first one on, a bit for each, the lowest for the first.
    #[inline]
    pub fn word(&self, first: usize) -> u32 {
        let word = |at: usize| self.0.get(at).map_or(0, |&word| u64::from(word));
        let both = word(first / WORD) | word(first / WORD + 1) << WORD;
        (both >> (first % WORD)) as u32
    }

    /// Of the pixels of a word, those that are marked or beside a marked one along the plane.
    #[inline]
    pub(crate) fn beside(&self, at: usize) -> u32 {
        let word = |at: usize| self.0.get(at).copied().unwrap_or(0);
        let (own, ends) = (word(at), WORD - 1);
        own | own << 1 | own >> 1 | word(at.wrapping_sub(1)) >> ends | word(at + 1) << ends
    }
}

/// Of the bits of a word that are open, some of them and those that follow them without a gap: upwards, or backwards.
#[inline]
pub(crate) fn flooded(open: u32, some: u32, backwards: bool) -> u32 {
    // The sum carries from the lowest of a run to its end.
    let upwards = |open: u32, some: u32| open & !open.wrapping_add(some) | some;
    if backwards { upwards(open.reverse_bits(), some.reverse_bits()).reverse_bits() } else { upwards(open, some) }
}

/// A bit for each of at most [`WORD`] values, the lowest for the first: is it above a level.
#[inline(always)]
pub(crate) fn bits_of<L: Level>(values: &[L], level: L) -> u32 {
    let bits = |values: &[L]| (0..).zip(values).fold(0, |bits, (bit, &value)| bits | u32::from(value > level) << bit);
    // Of whole words the compiler knows how many there are.
    values.first_chunk::<WORD>().map_or_else(|| bits(values), |values| bits(values))
}

/// A mask that is written.
#[derive(Debug)]
pub struct MaskMut<'a>(pub &'a mut [u32]);

impl MaskMut<'_> {
    /// Marks a pixel.
    #[inline]
    pub fn set(&mut self, at: usize) {
        if let Some(word) = self.0.get_mut(at / WORD) {
            *word |= 1 << (at % WORD);
        }
    }

    /// Marks those of the pixels from the first one on that have their bit.
    #[inline]
    pub(crate) fn set_all(&mut self, first: usize, bits: u32) {
        let both = u64::from(bits) << (first % WORD);
        for (at, bits) in [(first / WORD, both as u32), (first / WORD + 1, (both >> WORD) as u32)] {
            if let Some(word) = self.0.get_mut(at) {
                *word |= bits;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_open_is_flooded_bit_by_bit() {
        let mut state = 1u32;
        for _ in 0..10_000 {
            let mut draw = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                state ^ state >> 16
            };
            let open = draw() | draw();
            let some = draw() & draw() & draw() & open;
            let one = |flood: u32, bit: u32| {
                let before = flood >> bit.wrapping_sub(1).min(WORD as u32 - 1) & 1;
                flood | (before << bit & if bit == 0 { 0 } else { open })
            };
            let expected = (0..32).fold(some, one);
            assert_eq!(flooded(open, some, false), expected, "{open:x} {some:x}");
            let back = flooded(open.reverse_bits(), some.reverse_bits(), true);
            assert_eq!(back.reverse_bits(), expected, "{open:x} {some:x}");
        }
    }

    #[test]
    fn beside_a_mark_are_those_along_the_plane() {
        for marked in 0..96 {
            let mut words = [0; 3];
            MaskMut(&mut words).set(marked);
            for at in 0..96 {
                let is_beside = Mask(&words).beside(at / WORD) >> (at % WORD) & 1 == 1;
                assert_eq!(is_beside, at.abs_diff(marked) <= 1, "{at} {marked}");
            }
        }
    }

    #[test]
    fn a_pixel_is_marked_and_no_other() {
        for marked in [0, 1, 31, 32, 63, 69] {
            let mut words = [0; mask_words(70)];
            MaskMut(&mut words).set(marked);
            assert!((0..200).all(|at| Mask(&words).has(at) == (at == marked)), "{marked}");
            let bit = |first: usize| 1u32.checked_shl(marked.wrapping_sub(first) as u32).unwrap_or(0);
            assert!((0..200).all(|first| Mask(&words).word(first) == bit(first)), "{marked}");
        }
        MaskMut(&mut []).set(0);
        assert_eq!(mask_words(64), 2);
    }
}
