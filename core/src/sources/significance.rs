//! What noise alone would do: the height of a peak that it reaches as often as is allowed.
//!
//! In a smooth Gaussian field of unit variance, on `area` pixels, the number of regions above a
//! height u is expected to be `area lambda / (2 pi)^(3/2) u exp(-u^2 / 2)`, lambda the variance of
//! its slope along an axis (Adler 1981, The Geometry of Random Fields; Bardeen et al. 1986,
//! doi:10.1086/164143). Measured on the image, lambda knows the filter and the correlation of
//! the pixels' noise. Of sources that are found, a share may be false (Benjamini and Hochberg
//! 1995; for images Hopkins et al. 2002, doi:10.1086/338316).

/// `(2 pi)^(3/2)`.
const DENSITY: f32 = 15.749_61;

/// Peaks of noise above `height`, at least 1, for `elements = area lambda`.
pub fn expected(elements: f32, height: f32) -> f32 {
    elements / DENSITY * height * libm::expf(-0.5 * height * height)
}

/// The height, 1 to 14 standard deviations, above which noise has `allowed` peaks.
pub fn height(elements: f32, allowed: f32) -> f32 {
    let (mut low, mut high) = (1.0, 14.0);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if expected(elements, middle) > allowed {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_height_has_the_expected_number_of_peaks() {
        for (elements, allowed) in [(1e4, 0.5), (1.35e5, 0.5), (5e5, 0.1), (2e6, 20.0)] {
            let found = expected(elements, height(elements, allowed));
            assert!((found - allowed).abs() < 1e-3 * allowed, "{found} for {allowed}");
        }
        assert_eq!(height(1.0, 0.5), 1.0 + 13.0 / (1 << 24) as f32);
    }
}
