//! The vector units of x86-64 processors with AVX2: two registers hold a row of a tile.
//!
//! No fused multiply-add, and the order of operands that decides between a number and its like:
//! `min` and `max` return the second operand where neither is smaller, as comparisons do in the core.

use core::arch::x86_64::{
    __m128i, __m256, __m256i, _CMP_LE_OQ, _mm_add_epi32, _mm_cvtsi128_si32, _mm_shuffle_epi32, _mm256_add_epi32,
    _mm256_add_ps, _mm256_and_si256, _mm256_andnot_ps, _mm256_castps_si256, _mm256_castsi256_ps,
    _mm256_castsi256_si128, _mm256_cmp_ps, _mm256_cmpeq_epi32, _mm256_extracti128_si256, _mm256_loadu_ps,
    _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_or_ps, _mm256_set1_ps, _mm256_sqrt_ps,
    _mm256_storeu_ps, _mm256_sub_epi32, _mm256_sub_ps,
};
use skyfront_core::arithmetic::LARGEST_CHANGE;
use skyfront_core::arithmetic::vectors::COLUMNS;
use skyfront_core::arithmetic::vectors::Vectors;

/// The proof that this processor has AVX2.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    /// The units, where the processor has them.
    #[inline(always)]
    pub fn detect() -> Option<Avx2> {
        std::arch::is_x86_feature_detected!("avx2").then_some(Avx2(()))
    }
}

/// The numbers of a row of a tile.
type Row = [__m256; 2];

/// An operation on both registers of its operands.
macro_rules! on_both {
    ($operation:ident($($row:expr),+)) => {
        // SAFETY: there is an `Avx2`, so the processor has AVX2; registers only.
        unsafe { [$operation($($row[0]),+), $operation($($row[1]),+)] }
    };
}

impl Vectors for Avx2 {
    type Cell = f32;
    type Real = f32;
    type Row = Row;

    #[inline(always)]
    fn load(self, cells: &[f32; COLUMNS]) -> Row {
        let first = cells.as_ptr();
        // SAFETY: AVX2 as above; sixteen numbers are there to be read, at any alignment.
        unsafe { [_mm256_loadu_ps(first), _mm256_loadu_ps(first.add(8))] }
    }

    #[inline(always)]
    fn store(self, row: Row, cells: &mut [f32; COLUMNS]) {
        let first = cells.as_mut_ptr();
        // SAFETY: AVX2 as above; sixteen numbers are there to be written, at any alignment.
        unsafe {
            _mm256_storeu_ps(first, row[0]);
            _mm256_storeu_ps(first.add(8), row[1]);
        }
    }

    #[inline(always)]
    fn splat(self, x: f32) -> Row {
        // SAFETY: AVX2 as above.
        unsafe { [_mm256_set1_ps(x); 2] }
    }

    #[inline(always)]
    fn plus(self, a: Row, b: Row) -> Row {
        on_both!(_mm256_add_ps(a, b))
    }

    #[inline(always)]
    fn minus(self, a: Row, b: Row) -> Row {
        on_both!(_mm256_sub_ps(a, b))
    }

    #[inline(always)]
    fn times(self, a: Row, b: Row) -> Row {
        on_both!(_mm256_mul_ps(a, b))
    }

    #[inline(always)]
    fn root(self, row: Row) -> Row {
        on_both!(_mm256_sqrt_ps(row))
    }

    #[inline(always)]
    fn positive(self, row: Row) -> Row {
        let zero = self.splat(0.0);
        on_both!(_mm256_max_ps(row, zero))
    }

    #[inline(always)]
    fn least(self, row: Row, other: Row) -> Row {
        on_both!(_mm256_min_ps(other, row))
    }

    #[inline(always)]
    fn greatest(self, row: Row, other: Row) -> Row {
        on_both!(_mm256_max_ps(other, row))
    }

    #[inline(always)]
    fn change(self, old: Row, new: Row, limit: f32) -> u64 {
        // SAFETY: AVX2 as above; registers only.
        unsafe {
            let limit = _mm256_set1_ps(limit);
            let near = [within(old[0], limit), within(old[1], limit)];
            if _mm256_movemask_ps(_mm256_or_ps(near[0], near[1])) == 0 {
                return 0;
            }
            let units = _mm256_add_epi32(units(old[0], new[0], near[0]), units(old[1], new[1], near[1]));
            let four = _mm_add_epi32(_mm256_castsi256_si128(units), _mm256_extracti128_si256::<1>(units));
            u64::from(sum_of(four))
        }
    }

    #[inline(always)]
    fn differing(self, a: Row, b: Row) -> u32 {
        // SAFETY: AVX2 as above; registers only.
        let equal = unsafe { [equal(a[0], b[0]), equal(a[1], b[1])] };
        !(equal[0] | equal[1] << 8) & 0xFFFF
    }
}

/// All bits set where `|v| <= limit`. Safe to call where there is AVX2, as all that follow.
#[inline(always)]
unsafe fn within(v: __m256, limit: __m256) -> __m256 {
    // SAFETY: the caller's.
    unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(_mm256_andnot_ps(_mm256_set1_ps(-0.0), v), limit) }
}

/// `|new - old|` in units of 2^-24, 1/2 at most, where `near` has its bits set.
#[inline(always)]
unsafe fn units(old: __m256, new: __m256, near: __m256) -> __m256i {
    // SAFETY: the caller's.
    unsafe {
        let change = _mm256_andnot_ps(_mm256_set1_ps(-0.0), _mm256_sub_ps(new, old));
        let change = _mm256_min_ps(change, _mm256_set1_ps(LARGEST_CHANGE));
        let half = _mm256_set1_ps(0.5);
        let units = _mm256_sub_epi32(_mm256_castps_si256(_mm256_add_ps(half, change)), _mm256_castps_si256(half));
        _mm256_and_si256(units, _mm256_castps_si256(near))
    }
}

/// The sum of four whole numbers.
#[inline(always)]
unsafe fn sum_of(four: __m128i) -> u32 {
    // SAFETY: the caller's.
    unsafe {
        let two = _mm_add_epi32(four, _mm_shuffle_epi32::<0b1110>(four));
        _mm_cvtsi128_si32(_mm_add_epi32(two, _mm_shuffle_epi32::<0b01>(two))) as u32
    }
}

/// A bit for every number that has the same bits in both.
#[inline(always)]
unsafe fn equal(a: __m256, b: __m256) -> u32 {
    // SAFETY: the caller's.
    unsafe {
        let same = _mm256_cmpeq_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b));
        _mm256_movemask_ps(_mm256_castsi256_ps(same)) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use skyfront_core::arithmetic::{Arithmetic, F32, Real};

    const ODD: [f32; 13] = [0.0, -0.0, 1e-45, -1e-45, 1e-38, -0.1, 0.1, 0.25, -0.5, 0.499_999_97, 8.0, -1.5, f32::MAX];

    /// Every pair of the odd numbers, in rows.
    fn pairs() -> impl Iterator<Item = [[f32; COLUMNS]; 2]> {
        (0..ODD.len() * ODD.len()).map(|start| {
            let pair = |i: usize| ((start + i) % ODD.len(), (start + i) / ODD.len() % ODD.len());
            [core::array::from_fn(|i| ODD[pair(i).0]), core::array::from_fn(|i| ODD[pair(i).1])]
        })
    }

    fn same(units: Avx2, row: Row, cells: [f32; COLUMNS]) {
        let mut stored = [0.0; COLUMNS];
        units.store(row, &mut stored);
        assert_eq!(stored.map(f32::to_bits), cells.map(f32::to_bits));
    }

    #[test]
    fn every_operation_gives_the_bits_of_the_same_one_on_single_numbers() {
        let Some(units) = Avx2::detect() else {
            println!("this processor has no AVX2");
            return;
        };
        for [a, b] in pairs() {
            let each = |f: fn(f32, f32) -> f32| core::array::from_fn(|i| f(a[i], b[i]));
            let (x, y) = (units.load(&a), units.load(&b));
            same(units, units.plus(x, y), each(|a, b| a + b));
            same(units, units.minus(x, y), each(|a, b| a - b));
            same(units, units.times(x, y), each(|a, b| a * b));
            same(units, units.least(x, y), each(Real::least));
            same(units, units.greatest(x, y), each(Real::greatest));
            same(units, units.positive(x), each(|a, _| a.positive()));
            same(units, units.root(units.positive(x)), each(|a, _| a.positive().sqrt()));
            for limit in [0.0, 0.1, 7.0] {
                assert_eq!(units.change(x, y, limit), F32::<crate::machine::Native>::change(&a, &b, limit));
            }
            let bits = (0..COLUMNS).fold(0, |bits, i| bits | u32::from(a[i].to_bits() != b[i].to_bits()) << i);
            assert_eq!(units.differing(x, y), bits);
        }
    }
}
