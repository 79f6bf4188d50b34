//! `PLIO_1`: run lengths of masks (FITS standard 4.0, section 10.4.3; IRAF's pixel lists).
//!
//! A line list is a header and 16-bit instructions: four bits say what to do, twelve bits how often or by how much.
//! The decoder keeps one "high value" that instructions change and runs repeat.

use super::bits::Exhausted;

/// Decodes a line list into `out`; pixels after its end are zero.
pub(super) fn decode(stream: &[u8], out: &mut [i64]) -> Result<(), Exhausted> {
    let words: Vec<u16> = stream.as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect();
    out.fill(0);
    let mut instructions = instructions(&words).ok_or(Exhausted)?.iter();
    let mut high = 1i64;
    let mut at = 0usize;
    while let Some(&word) = instructions.next() {
        let amount = word & 0xfff;
        let run = usize::from(amount);
        match word >> 12 {
            0 => at += run,
            1 => high = i64::from(*instructions.next().ok_or(Exhausted)?) << 12 | i64::from(amount),
            2 => high += i64::from(amount),
            3 => high -= i64::from(amount),
            4 => {
                paint(out, at, run, high);
                at += run;
            }
            5 => {
                at += run;
                paint(out, at.saturating_sub(1), run.min(1), high);
            }
            code @ (6 | 7) => {
                high += if code == 6 { i64::from(amount) } else { -i64::from(amount) };
                paint(out, at, 1, high);
                at += 1;
            }
            _ => {}
        }
        if at >= out.len() {
            break;
        }
    }
    Ok(())
}

/// The instructions of a line list: what its header, of which there are two forms, says they are.
fn instructions(words: &[u16]) -> Option<&[u16]> {
    let word = |n: usize| words.get(n).map(|&word| usize::from(word));
    let short_length = word(2)?;
    let (first, end) =
        if (1..0x8000).contains(&short_length) { (3, short_length) } else { (word(1)?, (word(4)? << 15) + word(3)?) };
    words.get(first..end.max(first))
}

/// Gives `count` pixels from `at` on, as far as they exist, one value.
fn paint(out: &mut [i64], at: usize, count: usize, value: i64) {
    let end = out.len().min(at + count);
    if let Some(run) = out.get_mut(at..end) {
        run.fill(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(instructions: &[u16]) -> Vec<u8> {
        let length = 7 + instructions.len() as u16;
        let header = [0, 7, (-100i16) as u16, length, 0, 0, 0];
        header.iter().chain(instructions).flat_map(|word| word.to_be_bytes()).collect()
    }

    #[test]
    fn every_instruction_does_its_part() {
        let stream = list(&[2, 0x4000 + 2, 0x2000 + 4, 0x5000 + 2, 0x6000 + 1, 0x7000 + 3, 0x1000 + 5, 1, 0x4000 + 1]);
        let mut out = [9; 11];
        decode(&stream, &mut out).unwrap();
        assert_eq!(out, [0, 0, 1, 1, 0, 5, 6, 3, 4101, 0, 0]);
    }

    #[test]
    fn runs_end_at_the_last_pixel_and_lists_at_their_last_word() {
        let mut out = [9; 3];
        decode(&list(&[0x4fff]), &mut out).unwrap();
        assert_eq!(out, [1, 1, 1]);
        assert_eq!(decode(&list(&[0x1000])[..14], &mut out), Err(Exhausted));
        assert_eq!(decode(&list(&[0x1000]), &mut out), Err(Exhausted));
        assert_eq!(decode(&[], &mut out), Err(Exhausted));
    }
}
