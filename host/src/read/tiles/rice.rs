//! `RICE_1`: differences of neighbours in Rice code (FITS standard 4.0, section 10.4.1; Rice, Yeh and Miller 1993).
//!
//! The first value stands alone. Then, for every block of pixels, a code says how the differences are written: not at
//! all (all zero), in full, or as a unary high part and `split` low bits. Signs are folded into the lowest bit.

use super::bits::{Bits, Exhausted};

/// Decodes `out.len()` integers of `bytes` bytes each (1: unsigned; 2 and 4: signed) in blocks of `block` pixels.
pub(super) fn decode(stream: &[u8], bytes: u32, block: usize, out: &mut [i64]) -> Result<(), Exhausted> {
    let (code_bits, in_full) = match bytes {
        1 => (3, 6),
        2 => (4, 14),
        _ => (5, 25),
    };
    let width = bytes * 8;
    let mut bits = Bits::new(stream);
    let mut last = bits.take(width)?;
    for block in out.chunks_mut(block) {
        let code = bits.take(code_bits)?;
        for pixel in block {
            let folded = match code.checked_sub(1) {
                None => 0,
                Some(split) if split == in_full => bits.take(width)?,
                Some(split) => (bits.unary()?.wrapping_shl(split)) | bits.take(split)?,
            };
            last = last.wrapping_add(unfold(folded));
            *pixel = widen(last, bytes);
        }
    }
    Ok(())
}

/// 0, 1, 2, 3, 4 ... stand for 0, -1, 1, -2, 2 ...
fn unfold(folded: u32) -> u32 {
    (folded >> 1) ^ (folded & 1).wrapping_neg()
}

/// The low bytes of a running sum as the integer they stand for.
fn widen(sum: u32, bytes: u32) -> i64 {
    match bytes {
        1 => (sum as u8).into(),
        2 => (sum as i16).into(),
        _ => (sum as i32).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_kinds_of_block_are_decoded() {
        // First value 7; a block without differences; one of +1, -1 with split 0; one written in full.
        let mut stream = String::from("00000000000001110000");
        stream += "0001" /* split 0 */;
        stream += "001" /* folded 2: +1 */;
        stream += "01" /* folded 1: -1 */;
        stream += "1111" /* in full */;
        stream += "0000000000001010" /* folded 10: +5 */;
        stream += "0000000000001001" /* folded 9: -5 */;
        let bytes: Vec<u8> = stream
            .as_bytes()
            .chunks(8)
            .map(|byte| byte.iter().enumerate().map(|(n, &b)| (b - b'0') << (7 - n)).sum())
            .collect();
        let mut out = [0; 6];
        decode(&bytes, 2, 2, &mut out).unwrap();
        assert_eq!(out, [7, 7, 8, 7, 12, 7]);
        assert_eq!(decode(&bytes[..3], 2, 2, &mut out), Err(Exhausted));
    }
}
