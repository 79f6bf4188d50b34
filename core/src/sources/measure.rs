//! What the pixels of a source tell above the background: flux, centroid and moments with their errors, and flags.
//!
//! The catalogue on board and that on the ground come from these sums. They are in double precision, in the order of
//! the frame, so that processors without a unit for it need some fifty instructions per operation, and have the same
//! bits. Cost: about 40 operations per pixel of a source.

use crate::sources::flags;

/// A pixel of a source that is defined.
#[derive(Clone, Copy, Debug)]
pub struct Pixel {
    /// Its value, in units of the image.
    pub value: f32,
    /// The background there.
    pub background: f64,
    /// Standard deviation of the background there.
    pub noise: f64,
    /// Whether it reaches the saturation level.
    pub is_saturated: bool,
}

/// What lies around a pixel of a source.
#[derive(Clone, Copy, Debug, Default)]
pub struct Around {
    /// [`flags::TRUNCATED`], [`flags::MASKED`], [`flags::BLENDED`].
    pub flags: u32,
    /// Whether one of the four pixels beside it is not of the source.
    pub is_outline: bool,
}

/// Sums over the pixels of one source, relative to its first pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sums {
    /// Number of pixels.
    pub area: u32,
    /// Columns of its bounding box, both included.
    pub columns: (u32, u32),
    /// Rows of its bounding box, both included.
    pub rows: (u32, u32),
    /// The greatest value of a defined pixel, and column and row of the first that has it.
    pub peak: Option<(f32, (u32, u32))>,
    /// Bits of [`flags`] that pixels and neighbours earned.
    flags: u32,
    first_pixel: (u32, u32),
    defined: f64,
    flux: f64,
    variance: f64,
    background: f64,
    noise: f64,
    edge: f64,
    edge_pixels: f64,
    light: Weighted,
    /// The variance of the pixels at their places.
    noisy: Weighted,
}

/// A weight with its moments.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Weighted {
    sum: f64,
    first: (f64, f64),
    second: (f64, f64, f64),
}

/// A flux with its error, in units of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flux {
    /// Above the background.
    pub value: f64,
    /// One standard deviation: `sqrt(sum sigma^2 + flux / gain)`.
    pub error: f64,
}

/// Where a source is: pixels from 0, and pixels squared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centroid {
    /// Column.
    pub x: f64,
    /// Row.
    pub y: f64,
    /// Second moments xx, yy, xy.
    pub moments: (f64, f64, f64),
    /// Variances xx, yy, xy of the place; NaN where nothing stands above the background.
    pub errors: (f64, f64, f64),
}

/// Means over the pixels of a source; NaN where there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// The background.
    pub background: f64,
    /// The noise of the background.
    pub noise: f64,
    /// The value above the background along the outline.
    pub threshold: f64,
}

/// The variance of a pixel: that of the background, and of the light in it where the gain is known.
#[inline]
pub fn variance_with(gain: Option<f64>, variance: f64, light: f64) -> f64 {
    variance + gain.map_or(0.0, |gain| not_negative(light) / gain)
}

/// The value, or 0 where it is below.
#[inline]
fn not_negative(value: f64) -> f64 {
    if value > 0.0 { value } else { 0.0 }
}

impl Sums {
    /// No pixel yet: for static memory.
    pub const EMPTY: Sums = {
        const NOTHING: Weighted = Weighted { sum: 0.0, first: (0.0, 0.0), second: (0.0, 0.0, 0.0) };
        Sums {
            area: 0,
            columns: (0, 0),
            rows: (0, 0),
            peak: None,
            flags: 0,
            first_pixel: (0, 0),
            defined: 0.0,
            flux: 0.0,
            variance: 0.0,
            background: 0.0,
            noise: 0.0,
            edge: 0.0,
            edge_pixels: 0.0,
            light: NOTHING,
            noisy: NOTHING,
        }
    };

    /// Takes in a pixel at a column and row; `None` where it is undefined. Pixels come in the order of the frame.
    #[inline]
    pub fn add(&mut self, place: (u32, u32), around: Around, pixel: Option<Pixel>, gain: Option<f64>) {
        let (x, y) = place;
        if self.area == 0 {
            (self.first_pixel, self.columns, self.rows) = (place, (x, x), (y, y));
        }
        self.area = self.area.saturating_add(1);
        self.columns = (self.columns.0.min(x), self.columns.1.max(x));
        self.rows.1 = y;
        self.flags |= around.flags;
        let Some(Pixel { value: pixel, background, noise, is_saturated }) = pixel else {
            self.flags |= flags::MASKED;
            return;
        };
        if is_saturated {
            self.flags |= flags::SATURATED;
        }
        self.defined += 1.0;
        if self.peak.is_none_or(|(peak, _)| pixel > peak) {
            self.peak = Some((pixel, place));
        }
        let (value, of_sky) = (f64::from(pixel) - background, noise * noise);
        self.flux += value;
        self.variance += of_sky;
        self.background += background;
        self.noise += noise;
        if around.is_outline {
            self.edge += value;
            self.edge_pixels += 1.0;
        }
        let from = |at: u32, first: u32| f64::from(at) - f64::from(first);
        let at = (from(x, self.first_pixel.0), from(y, self.first_pixel.1));
        self.light.add(not_negative(value), at);
        self.noisy.add(variance_with(gain, of_sky, value), at);
    }

    /// Adds flags that pixels do not tell.
    pub fn mark(&mut self, flags: u32) {
        self.flags |= flags;
    }

    /// The flags of the source.
    pub fn flags(&self) -> u32 {
        self.flags | if self.light.sum > 0.0 { 0 } else { flags::NO_FLUX }
    }

    /// Number of defined pixels.
    pub fn defined(&self) -> f64 {
        self.defined
    }

    /// The sum of the pixels' values, background included; NaN where none is defined.
    pub fn total(&self) -> f64 {
        if self.defined > 0.0 { self.flux + self.background } else { f64::NAN }
    }

    /// The flux above the background.
    pub fn flux(&self, gain: Option<f64>) -> Flux {
        let variance = variance_with(gain, self.variance, self.flux);
        Flux { value: self.flux, error: libm::sqrt(variance) }
    }

    /// Mean levels.
    pub fn levels(&self) -> Levels {
        let mean = |sum: f64, count: f64| if count > 0.0 { sum / count } else { f64::NAN };
        Levels {
            background: mean(self.background, self.defined),
            noise: mean(self.noise, self.defined),
            threshold: mean(self.edge, self.edge_pixels),
        }
    }

    /// Centroid and moments, weighted by the values above the background. Without any such value the middle of the
    /// bounding box, and no extent.
    pub fn centroid(&self) -> Centroid {
        let Weighted { sum, first, second: (xx, yy, xy) } = self.light;
        if sum <= 0.0 {
            let middle = |(from, to): (u32, u32)| 0.5 * (f64::from(from) + f64::from(to));
            let errors = (f64::NAN, f64::NAN, f64::NAN);
            return Centroid { x: middle(self.columns), y: middle(self.rows), moments: (0.0, 0.0, 0.0), errors };
        }
        let (dx, dy) = (first.0 / sum, first.1 / sum);
        let xx = not_negative(xx / sum - dx * dx);
        let yy = not_negative(yy / sum - dy * dy);
        let xy = xy / sum - dx * dy;
        Centroid {
            x: f64::from(self.first_pixel.0) + dx,
            y: f64::from(self.first_pixel.1) + dy,
            moments: (xx, yy, xy),
            errors: self.errors((dx, dy), xx * yy - xy * xy),
        }
    }

    /// Variances of the centroid at `(dx, dy)`: those of its pixels, by their distance from it. Where
    /// the moments are those of less than a pixel, each is uncertain by a pixel's own width too, as
    /// SExtractor has it (`ERRX2_IMAGE`).
    fn errors(&self, (dx, dy): (f64, f64), determinant: f64) -> (f64, f64, f64) {
        let square = self.light.sum * self.light.sum;
        let Weighted { sum: n, first: (nx, ny), second: (nxx, nyy, nxy) } = self.noisy;
        let xx = not_negative((nxx - 2.0 * dx * nx + dx * dx * n) / square);
        let yy = not_negative((nyy - 2.0 * dy * ny + dy * dy * n) / square);
        let xy = (nxy - dx * ny - dy * nx + dx * dy * n) / square;
        let least = n / square / 12.0;
        if determinant < 1.0 / 144.0 && xx * yy - xy * xy < least * least {
            (xx + least, yy + least, xy)
        } else {
            (xx, yy, xy)
        }
    }
}

impl Default for Sums {
    fn default() -> Self {
        Sums::EMPTY
    }
}

impl Weighted {
    #[inline]
    fn add(&mut self, weight: f64, (x, y): (f64, f64)) {
        let Weighted { sum, first, second } = self;
        *sum += weight;
        *first = (first.0 + weight * x, first.1 + weight * y);
        *second = (second.0 + weight * x * x, second.1 + weight * y * y, second.2 + weight * x * y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bar of three pixels above a background of 2 with a noise of 0.5.
    fn bar(gain: Option<f64>) -> Sums {
        let mut sums = Sums::default();
        for (x, value) in [(10, 3.0), (11, 5.0), (12, 3.0)] {
            let pixel = Pixel { value, background: 2.0, noise: 0.5, is_saturated: value > 4.0 };
            sums.add((x, 7), Around { flags: 0, is_outline: x != 11 }, Some(pixel), gain);
        }
        sums
    }

    #[test]
    fn a_bar_of_three_pixels() {
        let sums = bar(None);
        assert_eq!((sums.area, sums.columns, sums.rows, sums.peak), (3, (10, 12), (7, 7), Some((5.0, (11, 7)))));
        assert_eq!((sums.flags(), sums.total(), sums.defined()), (flags::SATURATED, 11.0, 3.0));
        assert_eq!(sums.levels(), Levels { background: 2.0, noise: 0.5, threshold: 1.0 });
        let Centroid { x, y, moments, errors } = sums.centroid();
        assert!((x, y, moments.1, moments.2) == (11.0, 7.0, 0.0, 0.0) && (moments.0 - 0.4).abs() < 1e-12);
        // Two pixels a column away with a variance of 0.25, and a twelfth of that of three, over the square of the light.
        assert!((errors.0 - (0.5 + 0.0625) / 25.0).abs() < 1e-12 && (errors.1 - 0.0625 / 25.0).abs() < 1e-12);
        assert_eq!(sums.flux(None), Flux { value: 5.0, error: libm::sqrt(0.75) });
    }

    /// Light of 4, 2 and 2 with variances of 2.25, 1.25 and 1.25, none of it on the others' rows and columns alike.
    #[test]
    fn both_axes_count_and_how_they_go_together() {
        let mut sums = Sums::default();
        for (place, value) in [((10, 7), 6.0), ((11, 7), 4.0), ((12, 8), 4.0)] {
            let pixel = Pixel { value, background: 2.0, noise: 0.5, is_saturated: false };
            sums.add(place, Around::default(), Some(pixel), Some(2.0));
        }
        assert_eq!((sums.rows, sums.flags()), ((7, 8), 0));
        let errors = (3.296_875 / 64.0, 0.921_875 / 64.0, 1.515_625 / 64.0);
        assert_eq!(sums.centroid(), Centroid { x: 10.75, y: 7.25, moments: (0.6875, 0.1875, 0.3125), errors });
    }

    #[test]
    fn light_adds_its_own_noise_where_the_gain_is_known() {
        let (dark, bright) = (bar(None), bar(Some(2.0)));
        assert_eq!(bright.flux(Some(2.0)).error, libm::sqrt(0.75 + 2.5));
        assert!(bright.centroid().errors.0 > dark.centroid().errors.0);
    }

    #[test]
    fn without_light_or_pixels_there_is_a_place_and_a_flag() {
        let mut sums = Sums::default();
        for x in [4, 5, 7] {
            sums.add((x, 1), Around::default(), None, None);
        }
        assert_eq!(sums.flags(), flags::MASKED | flags::NO_FLUX);
        let Centroid { x, y, errors, .. } = sums.centroid();
        assert!((x, y) == (5.5, 1.0) && errors.0.is_nan() && sums.total().is_nan() && sums.levels().noise.is_nan());
    }

    #[test]
    fn the_first_of_equal_peaks_is_the_peak_and_marks_are_flags() {
        let mut sums = Sums::default();
        for (x, value) in [(3, 4.0), (4, 6.0), (5, 6.0)] {
            let pixel = Pixel { value, background: 2.0, noise: 0.5, is_saturated: false };
            sums.add((x, 1), Around { flags: flags::TRUNCATED, is_outline: true }, Some(pixel), None);
        }
        assert_eq!(sums.peak, Some((6.0, (4, 1))));
        sums.mark(flags::BLENDED | flags::TRUNCATED);
        assert_eq!(sums.flags(), flags::BLENDED | flags::TRUNCATED);
    }

    /// A pixel's own width is a variance of a twelfth of the noise, 1 here.
    #[test]
    fn sources_within_a_pixel_are_uncertain_by_its_width() {
        let errors = |determinant: f64, n: f64, second: (f64, f64, f64)| {
            let light = Weighted { sum: 1.0, ..Sums::EMPTY.light };
            let noisy = Weighted { sum: n, first: (0.0, 0.0), second };
            Sums { light, noisy, ..Sums::EMPTY }.errors((0.0, 0.0), determinant)
        };
        let within = 0.001;
        assert_eq!(errors(within, 12.0, (0.5, 0.5, 0.0)), (1.5, 1.5, 0.0));
        assert_eq!(errors(within, 12.0, (1.5, 1.0, 0.75)), (2.5, 2.0, 0.75));
        for (determinant, n, second) in [
            // The light reaches beyond a pixel.
            (1.0 / 144.0, 12.0, (0.5, 0.5, 0.0)),
            (0.01, 12.0, (0.5, 0.5, 0.0)),
            // The errors do.
            (within, 12.0, (2.0, 0.5, 0.0)),
            (within, 12.0, (1.25, 0.85, 0.1)),
            (within, 6.0, (1.0, 0.5, 0.0)),
        ] {
            assert_eq!(errors(determinant, n, second), second, "{determinant}, {n}");
        }
    }

    #[test]
    fn light_along_a_diagonal_is_within_a_pixel_and_beside_it_is_not() {
        let errors = |pixels: &[((u32, u32), f32)]| {
            let mut sums = Sums::default();
            for (at, &(place, value)) in pixels.iter().enumerate() {
                let noise = if at == 0 { 0.5 } else { 0.0 };
                let pixel = Pixel { value, background: 0.0, noise, is_saturated: false };
                sums.add(place, Around::default(), Some(pixel), None);
            }
            sums.centroid().errors
        };
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        near(errors(&[((0, 0), 4.0), ((1, 1), 4.0)]).0, 0.25 * (0.25 + 1.0 / 12.0) / 64.0);
        // The centre is (5/9, 4/9).
        near(errors(&[((0, 0), 4.0), ((1, 0), 1.0), ((1, 1), 4.0)]).0, 0.25 * 25.0 / 81.0 / 81.0);
    }
}
