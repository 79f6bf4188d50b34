//! Otsu's threshold (N. Otsu 1979, DOI 10.1109/TSMC.1979.4310076).

/// Bins over \[0, 1\].
const BINS: usize = 256;

/// The histogram of levels in \[0, 1\].
pub(super) fn histogram(levels: impl Iterator<Item = f64>) -> [u64; BINS] {
    let mut histogram = [0u64; BINS];
    for x in levels {
        histogram[((x * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
    histogram
}

/// The upper edge of the last background bin: the split of the 256-bin histogram with the largest variance between
/// the two classes, the first of equals. 0 when all levels share a bin.
pub fn otsu(levels: impl Iterator<Item = f64>) -> f64 {
    let histogram = histogram(levels);
    let sum = |range: &[u64]| range.iter().sum::<u64>() as f64;
    let moment = |range: &[u64], first: usize| -> f64 {
        let bins = range.iter().zip(first..);
        bins.map(|(&n, bin)| n as f64 * bin as f64).sum()
    };
    let (mut best, mut tau) = (0.0, 0.0);
    for last in 0..BINS - 1 {
        let (background, objects) = histogram.split_at(last + 1);
        let (w0, w1) = (sum(background), sum(objects));
        if w0 == 0.0 || w1 == 0.0 {
            continue;
        }
        let distance = moment(objects, last + 1) / w1 - moment(background, 0) / w0;
        let between = w0 * w1 * distance * distance;
        if between > best {
            (best, tau) = (between, (last + 1) as f64 / BINS as f64);
        }
    }
    tau
}
