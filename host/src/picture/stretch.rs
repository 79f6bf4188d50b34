//! From pixel values to shades of grey in which faint and bright objects can both be seen.

/// An asinh stretch between a dark and a bright value (Lupton et al. 2004, doi:10.1086/382245).
///
/// ```
/// use skyfront::picture::Stretch;
///
/// let stretch = Stretch::linear(100.0, 200.0);
/// assert_eq!((stretch.shade(100.0), stretch.shade(1e6)), (0, 255));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    black: f64,
    scale: f64,
    top: f64,
}

/// How many times the spread of the sky counts as faint.
const SOFTENING: f64 = 3.0;

impl Stretch {
    /// A stretch for an image: the sky becomes dark grey, the brightest thousandth white.
    ///
    /// Sky and spread are the median and the distance to the 16th percentile of a sample of at
    /// most 100 000 pixels; undefined pixels do not count.
    pub fn of(pixels: &[f32]) -> Stretch {
        let step = (pixels.len() / 100_000).max(1);
        let mut sample: Vec<f32> = pixels.iter().step_by(step).copied().filter(|pixel| pixel.is_finite()).collect();
        sample.sort_unstable_by(f32::total_cmp);
        let at = |fraction: f64| {
            let index = (fraction * sample.len().saturating_sub(1) as f64) as usize;
            sample.get(index).map_or(0.0, |&value| f64::from(value))
        };
        let (median, low, high) = (at(0.5), at(0.16), at(0.999));
        let spread = if median > low { median - low } else { (high - median).abs().max(f64::MIN_POSITIVE) };
        let scale = SOFTENING * spread;
        let black = median - 1.5 * spread;
        Stretch { black, scale, top: ((high - black) / scale).max(1e-3).asinh() }
    }

    /// A linear stretch from `black` to `white`.
    pub fn linear(black: f64, white: f64) -> Stretch {
        // An asinh so wide that its argument stays in the linear part.
        let scale = (white - black).max(f64::MIN_POSITIVE) * 1e3;
        Stretch { black, scale, top: 1e-3f64.asinh() }
    }

    /// The value that becomes black.
    pub fn black(&self) -> f64 {
        self.black
    }

    /// How far above black values begin to be pressed together.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The value that becomes white.
    pub fn white(&self) -> f64 {
        self.black + self.scale * self.top.sinh()
    }

    /// The shade of a pixel, 0 to 255; undefined pixels are black.
    pub fn shade(&self, pixel: f32) -> u8 {
        let value = ((f64::from(pixel) - self.black) / self.scale).asinh() / self.top;
        if value.is_finite() { (value.clamp(0.0, 1.0) * 255.0).round() as u8 } else { 0 }
    }
}
