//! The corner of a histogram with one peak, of Rosin (doi:10.1016/S0031-3203(00)00136-9): for
//! frames of much sky and few objects, where the objects make no peak of their own.

use crate::sky::otsu::{BINS, Histogram};

impl Histogram {
    /// The upper edge of the bin (the first of equals) that lies farthest below the straight line from the highest bin
    /// (the first of equals) down to the first empty one behind the last bin in use; 0 where all
    /// values share a bin. The last bin, where clipped values gather, is no peak. Exact: the
    /// distances are compared as integers.
    pub fn rosin(&self) -> f32 {
        let (mut peak, mut height) = (0, 0);
        for (bin, &n) in self.0.iter().enumerate().take(BINS - 1) {
            if n > height {
                (peak, height) = (bin, n);
            }
        }
        let end = self.0.iter().rposition(|&n| n > 0).map_or(0, |last| last + 1);
        let first = self.0.iter().position(|&n| n > 0).unwrap_or(0);
        if first + 1 >= end {
            return 0.0;
        }
        let run = end.saturating_sub(peak) as u64;
        let (mut best, mut corner) = (0i64, peak);
        for (bin, &n) in self.0.iter().enumerate().take(end).skip(peak) {
            let line = u64::from(height).saturating_mul(end.saturating_sub(bin) as u64);
            // The distance times the length of the line.
            let depth = line as i64 - u64::from(n).saturating_mul(run) as i64;
            if depth > best {
                (best, corner) = (depth, bin);
            }
        }
        (corner + 1) as f32 / BINS as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corner_is_farthest_below_the_line() {
        let corner = |bins: &[(usize, u32)]| {
            let mut histogram = Histogram::EMPTY;
            bins.iter().for_each(|&(bin, count)| histogram.0[bin] = count);
            histogram.rosin() * BINS as f32
        };
        // Times the length of the line: 1000 - 440, 900 - 110, 800 - 11, and from then on less.
        assert_eq!(corner(&[(10, 100), (11, 40), (12, 10), (13, 1), (20, 1)]), 13.0);
        // 12 - 4 and 8 - 0.
        assert_eq!(corner(&[(10, 4), (11, 1), (13, 1)]), 12.0);
        // The last bin is no peak, and of equal ones the first is.
        assert_eq!(corner(&[(10, 100), (255, 1000)]), 12.0);
        assert_eq!(corner(&[(10, 50), (12, 50), (30, 1)]), 12.0);
        assert_eq!((corner(&[(10, 5), (11, 1)]), corner(&[(10, 5)]), corner(&[])), (12.0, 0.0, 0.0));
    }
}
