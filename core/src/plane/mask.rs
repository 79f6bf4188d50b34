//! A bit for every pixel of a plane.

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
}

#[cfg(test)]
mod tests {
    use super::*;

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
