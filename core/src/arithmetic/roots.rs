//! Integer square roots: exact, bounded, and cheap on processors without a square root.
//!
//! The operand is shifted left by an even number of bits until one of its two top bits is set; a
//! table of a byte per entry then knows the root to 7 bits, one step of Newton's iteration gives
//! 16 bits, and a comparison removes the last unit. 64 bits take one more division of 32 bits
//! (Zimmermann's "Karatsuba square root", INRIA RR-3805). No loop, no 64-bit division.

/// Roots of the middles of 256 intervals of width 2^24, in units of 2^8 below 2^16; the first 64
/// entries are never looked up.
#[allow(clippy::indexing_slicing, reason = "evaluated by the compiler")]
const GUESS: [u8; 256] = {
    let mut table = [0; 256];
    let mut i = 64;
    while i < 256 {
        // (guess + 1/2)^2 * 2^16 is nearest to (i + 1/2) * 2^24.
        let mut guess = 255u64;
        while (2 * guess) * (2 * guess) > (2 * i + 1) * 512 {
            guess -= 1;
        }
        table[i as usize] = guess as u8;
        i += 1;
    }
    table
};

/// The square root of `n > 0` as `root / 2^shift`, the root from 2^15 to 2^16: within 1 of the exact one.
#[inline]
#[allow(clippy::indexing_slicing, reason = "a byte is below the length of the table")]
pub fn scaled32(n: u32) -> (u32, u32) {
    let (m, shift) = (n, 0u32);
    let (m, shift) = if m < 1 << 16 { (m << 16, 8) } else { (m, shift) };
    let (m, shift) = if m < 1 << 24 { (m << 8, shift | 4) } else { (m, shift) };
    let (m, shift) = if m < 1 << 28 { (m << 4, shift | 2) } else { (m, shift) };
    let (m, shift) = if m < 1 << 30 { (m << 2, shift | 1) } else { (m, shift) };
    let guess = u32::from(GUESS[(m >> 24) as u8 as usize]) << 8 | 0x80;
    // The mean of guess and quotient is never below the root, and above it by less than 1.
    ((guess + m / guess) >> 1, shift)
}

/// The square root, rounded down.
#[inline]
pub fn floor32(n: u32) -> u32 {
    if n == 0 {
        return 0;
    }
    let (above, shift) = scaled32(n);
    let root = (above >> shift).min(0xFFFF);
    root.wrapping_sub(u32::from(root.wrapping_mul(root) > n))
}

/// The square root, rounded to nearest.
#[inline]
pub fn nearest32(n: u32) -> u32 {
    let root = floor32(n);
    root.wrapping_add(u32::from(n.wrapping_sub(root.wrapping_mul(root)) > root))
}

/// The square root, rounded down.
#[inline]
pub fn floor64(n: u64) -> u32 {
    if n >> 32 == 0 {
        return floor32(n as u32);
    }
    let shift = n.leading_zeros() & !1;
    let m = n << shift;
    let (high, low) = ((m >> 32) as u32, m as u32);
    let first = floor32(high).max(1);
    // The rest is at most twice the first half of the root, so the numerator has 32 bits.
    let rest = high.wrapping_sub(first.wrapping_mul(first));
    let second = ((rest << 15 | low >> 17) / first).min(0xFFFF);
    let above = first << 16 | second;
    let root = above.wrapping_sub(u32::from(square(above) > m));
    root >> (shift >> 1)
}

/// The square root, rounded to nearest; saturated.
#[inline]
pub fn nearest64(n: u64) -> u32 {
    let root = floor64(n);
    root.saturating_add(u32::from(n.wrapping_sub(square(root)) > u64::from(root)))
}

#[inline]
fn square(n: u32) -> u64 {
    u64::from(n).wrapping_mul(u64::from(n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_32_bit_root_at_both_ends_of_its_interval() {
        for root in 0..=0xFFFFu32 {
            let first = root * root;
            let last = first + 2 * root;
            assert_eq!((floor32(first), floor32(last)), (root, root), "root {root}");
            let (scaled, shift) = scaled32(last.max(1));
            let exact = libm::sqrt(f64::from(last.max(1))) * f64::from(1u32 << shift);
            assert!((32768..=65536).contains(&scaled) && (f64::from(scaled) - exact).abs() < 1.0, "{last}");
            assert_eq!((nearest32(first + root), nearest32(last)), (root, root + u32::from(root > 0)), "root {root}");
        }
    }

    #[test]
    fn many_64_bit_roots_at_both_ends_of_their_intervals() {
        let near_powers =
            (0..32).flat_map(|bit| (0..4096u32).map(move |i| (1u32 << bit).wrapping_add(i).wrapping_sub(2048)));
        let spread = (0..1_000_000u32).map(|i| i.wrapping_mul(0x9E37_79B1));
        for root in near_powers.chain(spread) {
            let first = square(root);
            let last = first + 2 * u64::from(root);
            assert_eq!((floor64(first), floor64(last)), (root, root), "root {root}");
            assert_eq!(nearest64(first + u64::from(root)), root);
            if root > 0 {
                assert_eq!(nearest64(last), root.saturating_add(1));
            }
        }
    }
}
