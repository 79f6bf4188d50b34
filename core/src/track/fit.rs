//! The centre of the brightest star of a window.

use super::solve::{Basis, Equations, Solution};
use super::window::{Border, Rectangle, View};
use super::{BLENDED, Camera, HOT, LEAST_SNR, SATURATED, Star};
use crate::arithmetic::{Arithmetic, Real};
use crate::plane::raster::Pixel;

/// The most steps that a centre takes; a star of S/N 20 and more has settled to 0.01 pixels by then.
pub const STEPS: usize = 4;
/// A centre has settled when a step is shorter, pixels.
const SETTLED: f32 = 1.0 / 512.0;
/// It is lost when the last of all steps is longer, pixels.
const ASTRAY: f32 = 0.1;
/// The window ends at so many standard deviations of the PSF.
const REACH: f32 = 3.0;
/// Pixels of the window along an axis, at most: twice three widths of 3 pixels and the middle.
const MOST: usize = 19;
/// The unit of the sky, so that sums over a window stay small enough for fixed point.
const SKY: f32 = 0.125;
/// What a pixel of the median is worth beside one of the mean: 2 / pi.
const MEDIAN: f32 = core::f32::consts::FRAC_2_PI;
/// A pixel is hot from so many deviations above the sky on, if its neighbours are dark.
const SPIKE: f32 = 8.0;
/// A pixel is another source's from so many deviations above star and sky on.
const SIGNIFICANT: f32 = 5.0;
/// And from this part of the star's peak, which a PSF that is no Gaussian may have beside it.
const BESIDE: f32 = 0.2;

/// A star's light along an axis: its integral over each pixel, in units of the peak, and how that grows as
/// the centre moves up.
struct Profile<R> {
    /// The first pixel.
    first: usize,
    /// How many there are.
    pixels: usize,
    light: [R; MOST],
    growth: [R; MOST],
}

/// The PSF, ready for use.
struct Psf<A: Arithmetic> {
    /// 1 / (sqrt(2) sigma).
    steepness: A::Real,
    /// 1 / (60 sigma^2).
    bend: A::Real,
    /// Pixels from the middle of the window to its end.
    reach: usize,
}

impl<A: Arithmetic> Psf<A> {
    fn of(sigma: f32) -> Self {
        let steepness = A::Real::of(core::f32::consts::FRAC_1_SQRT_2 / sigma);
        Psf { steepness, bend: A::Real::of(1.0 / (60.0 * sigma * sigma)), reach: libm::ceilf(REACH * sigma) as usize }
    }

    fn at(&self, distance: A::Real) -> A::Real {
        let scaled = distance * self.steepness;
        A::exp_neg(scaled * scaled)
    }

    /// Pixels from `first` to `last` of a star at `centre`. The integral over a pixel is Simpson's rule
    /// corrected by the slopes at both ends, within 2e-4 of the peak from 0.7 pixels of width on.
    fn profile(&self, centre: A::Real, (first, last): (usize, usize)) -> Profile<A::Real> {
        let half = A::Real::of(0.5);
        let (ends, middle) = (A::Real::of(7.0 / 30.0), A::Real::of(16.0 / 30.0));
        let pixels = last.saturating_add(1).saturating_sub(first).min(MOST);
        let mut profile = Profile { first, pixels, light: [A::Real::ZERO; MOST], growth: [A::Real::ZERO; MOST] };
        let mut below = (A::Real::of(first as f32) - half) - centre;
        let mut at_below = self.at(below);
        for (light, growth) in profile.light.iter_mut().zip(&mut profile.growth).take(pixels) {
            let above = below + A::Real::ONE;
            let at_above = self.at(above);
            let slopes = (above * at_above - below * at_below) * self.bend;
            *light = ((at_below + at_above) * ends + self.at(below + half) * middle) + slopes;
            *growth = at_below - at_above;
            (below, at_below) = (above, at_above);
        }
        profile
    }
}

/// The pixels of a window along an axis of the view.
fn span(centre: f32, reach: usize, length: usize) -> (usize, usize) {
    let middle = libm::floorf(centre + 0.5) as usize;
    let last = length.saturating_sub(1);
    (middle.saturating_sub(reach).min(last), middle.saturating_add(reach).min(last))
}

/// A window on its way to the star's centre.
pub struct Fit<'a, A: Arithmetic, P> {
    view: &'a View<'a, P>,
    camera: &'a Camera,
    psf: Psf<A>,
    /// Counts are taken from here.
    base: u16,
    /// The number of one count.
    unit: f32,
    /// Column and row of the centre in the view.
    centre: (A::Real, A::Real),
    /// Sky above the base and amplitude of the star.
    sky: A::Real,
    star: A::Real,
    /// Length of the last step, pixels.
    moved: f32,
    /// The border outside the star's rectangle, and that rectangle.
    border: (Rectangle, Option<Border>),
}

/// How pixels are weighted: `level / (level + (1 - level) m)` for a star's light m in units of its peak.
struct Weights<R> {
    level: R,
    rest: R,
    /// Variance of a pixel of the sky, counts squared.
    variance: f32,
}

/// What a step found, and the variance of the sky that its weights are relative to.
struct Step<R> {
    solution: Solution<R>,
    variance: f32,
}

impl<'a, A: Arithmetic, P: Pixel> Fit<'a, A, P> {
    /// Ready for the first step; nothing where no pixel can be used.
    pub fn of(view: &'a mut View<'_, P>, camera: &'a Camera) -> Option<Self> {
        let whole = view.sky(&Rectangle::NONE)?;
        let Border { base, rest, .. } = whole;
        let psf = Psf::<A>::of(camera.psf_sigma);
        let noise = A::root(camera.variance(f32::from(base) + rest));
        let level = libm::ceilf(f32::from(base) + SPIKE * noise);
        let centred = psf.profile(A::Real::ZERO, (0, 1));
        let [middle, beside, ..] = centred.light;
        view.leave_out_spikes(base, level as u16, 0.5 * beside.ratio(middle).to_f32());
        let (x, y) = view.brightest(base);
        let height = view.peak((x, y), base).saturating_sub(base);
        if height == 0 {
            return None;
        }
        // The peak lies between 1/2 and 1: a power of two, so that no count is rounded.
        let unit = 1.0 / u32::from(height).saturating_add(1).next_power_of_two() as f32;
        let centre = (A::Real::of(x as f32), A::Real::of(y as f32));
        let sky = A::Real::of(rest * unit);
        let star = A::Real::of(f32::from(height) * unit).ratio(middle * middle);
        let mut fit = Fit {
            view,
            camera,
            psf,
            base,
            unit,
            centre,
            sky,
            star,
            moved: 0.0,
            border: (Rectangle::NONE, Some(whole)),
        };
        fit.look_at_border();
        Some(fit)
    }

    fn weights(&self) -> Weights<A::Real> {
        let counts = |value: A::Real| value.to_f32() / self.unit;
        let variance = self.camera.variance(f32::from(self.base) + counts(self.sky));
        let level = variance / (variance + counts(self.star) / self.camera.gain);
        Weights { level: A::Real::of(level), rest: A::Real::of(1.0 - level), variance }
    }

    /// The star's light along both axes.
    fn profiles(&self) -> [Profile<A::Real>; 2] {
        let Rectangle { columns, rows } = self.rectangle(self.psf.reach);
        [self.psf.profile(self.centre.0, columns), self.psf.profile(self.centre.1, rows)]
    }

    fn value(&self, count: u16) -> A::Real {
        A::Real::of(i32::from(count).saturating_sub(i32::from(self.base)) as f32 * self.unit)
    }

    /// The equations at the centre, where the noise is that of the last sky and star.
    fn equations(&self, [columns, rows]: &[Profile<A::Real>; 2], weights: &Weights<A::Real>) -> Equations<A::Real> {
        let sky = A::Real::of(SKY);
        let mut equations = self.known();
        for (y, (light_y, growth_y)) in (rows.first..).zip(rows.light.iter().zip(&rows.growth)).take(rows.pixels) {
            let pixels = self.view.row(y).get(columns.first..).unwrap_or(&[]);
            let mut out = self.view.out_of(y).wrapping_shr(columns.first as u32);
            let across = columns.light.iter().zip(&columns.growth).take(columns.pixels);
            for (pixel, (light_x, growth_x)) in pixels.iter().zip(across) {
                if out & 1 == 0 {
                    let star = *light_x * *light_y;
                    let basis = Basis { sky, star, column: *growth_x * *light_y, row: *light_x * *growth_y };
                    let weight = weights.level.ratio(weights.level + weights.rest * star);
                    equations.add(basis, weight, self.value(pixel.count()));
                }
                out >>= 1;
            }
        }
        equations
    }

    /// The columns and rows up to `reach` pixels from the star.
    fn rectangle(&self, reach: usize) -> Rectangle {
        let (x, y) = (self.centre.0.to_f32(), self.centre.1.to_f32());
        let (columns, rows) = self.view.size;
        Rectangle { columns: span(x, reach, columns), rows: span(y, reach, rows) }
    }

    /// Takes the median of the border where the star does not reach, when that is elsewhere than before.
    fn look_at_border(&mut self) {
        // A pixel more: a bright star would raise the sky beside the window yet.
        let inside = self.rectangle(self.psf.reach.saturating_add(1));
        let inside = if self.view.at_border(&inside) { inside } else { Rectangle::NONE };
        if self.border.0 != inside {
            self.border = (inside, self.view.sky(&inside));
        }
    }

    /// What the border tells of the sky.
    fn known(&self) -> Equations<A::Real> {
        let Some(Border { base, rest, pixels }) = self.border.1 else {
            return Equations::with_sky(A::Real::ZERO, A::Real::ZERO);
        };
        let level = (i32::from(base).saturating_sub(i32::from(self.base)) as f32 + rest) * self.unit;
        let information = MEDIAN * pixels as f32 * (SKY * SKY);
        Equations::with_sky(A::Real::of(information), A::Real::of(level / SKY))
    }

    /// Moves the centre; nothing where the equations have no solution or the centre leaves the view.
    fn step(&mut self) -> Option<Step<A::Real>> {
        let weights = self.weights();
        let solution = self.equations(&self.profiles(), &weights).solve()?;
        if solution.star <= A::Real::ZERO {
            return None;
        }
        let shift = |by: A::Real| by.ratio(solution.star).least(A::Real::ONE).greatest(-A::Real::ONE);
        let (x, y) = (shift(solution.shift.0), shift(solution.shift.1));
        self.centre = (self.centre.0 + x, self.centre.1 + y);
        (self.sky, self.star) = (solution.sky * A::Real::of(SKY), solution.star);
        self.moved = x.magnitude().greatest(y.magnitude()).to_f32();
        let inside = |place: A::Real, length: usize| {
            place > A::Real::of(-0.5) && place < A::Real::of(length as f32) - A::Real::of(0.5)
        };
        let within = inside(self.centre.0, self.view.size.0) && inside(self.centre.1, self.view.size.1);
        self.look_at_border();
        within.then_some(Step { solution, variance: weights.variance })
    }

    /// The star at its centre; nothing where there is none.
    pub fn star(mut self) -> Option<Star> {
        // The first step takes light and noise from one pixel: it is never the last.
        self.step()?;
        let mut last = self.step()?;
        for _ in 2..STEPS {
            if self.moved <= SETTLED {
                break;
            }
            last = self.step()?;
        }
        let star = self.record(&last);
        (star.snr >= LEAST_SNR && self.moved <= ASTRAY).then_some(star)
    }

    fn record(&self, Step { solution, variance }: &Step<A::Real>) -> Star {
        let amplitude = solution.star.to_f32() / self.unit;
        let sigma = self.camera.psf_sigma;
        let snr = amplitude * A::root(solution.of_star.to_f32() / variance);
        let (xx, xy, yy) = solution.of_shift;
        let [xx, xy, yy] = [xx, xy, yy].map(|information| information.to_f32());
        // Of the inverse, with each pivot divided out first: no product of two small numbers.
        let scale = variance / (amplitude * amplitude);
        let (of_x, of_y) = (xx - xy * (xy / yy), yy - xy * (xy / xx));
        let place = |within: A::Real, first: usize| first as f32 + within.to_f32();
        Star {
            x: place(self.centre.0, self.view.origin.0),
            y: place(self.centre.1, self.view.origin.1),
            flux: amplitude * core::f32::consts::TAU * sigma * sigma,
            snr,
            errx2: scale / of_x,
            erry2: scale / of_y,
            errxy: -(xy / yy) * (scale / of_x),
            flags: self.flags(),
        }
    }

    /// What is wrong with the pixels of the star.
    fn flags(&self) -> u32 {
        let weights = self.weights();
        let photons = self.star.to_f32() / (self.unit * self.camera.gain);
        let most = A::Real::of(SIGNIFICANT * A::root(weights.variance + photons) * self.unit)
            + self.star * A::Real::of(BESIDE);
        let [columns, rows] = self.profiles();
        let full = self.camera.full();
        let mut flags = 0;
        for (y, light_y) in (rows.first..).zip(&rows.light).take(rows.pixels) {
            let pixels = self.view.row(y).get(columns.first..).unwrap_or(&[]);
            let mut out = self.view.out_of(y).wrapping_shr(columns.first as u32);
            for (pixel, light_x) in pixels.iter().zip(&columns.light).take(columns.pixels) {
                let star = *light_x * *light_y;
                if u32::from(pixel.count()) >= full {
                    flags |= SATURATED;
                } else if out & 1 != 0 {
                    flags |= HOT;
                } else {
                    let rest = (self.value(pixel.count()) - self.sky) - self.star * star;
                    if rest > most {
                        flags |= BLENDED;
                    }
                }
                out >>= 1;
            }
        }
        flags
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;
    use crate::plane::raster::Raster;
    use crate::track::Window;

    const SIDE: usize = 21;

    #[test]
    fn a_profile_is_the_integral_over_each_pixel() {
        for sigma in [0.7, 1.2, 3.0f32] {
            let width = f64::from(sigma);
            let profile = Psf::<F32>::of(sigma).profile(3.3, (1, 7));
            assert_eq!((profile.first, profile.pixels), (1, 7));
            let scale = width * (core::f64::consts::PI / 2.0).sqrt();
            let normal = |x: f64| libm::erf(x / (width * core::f64::consts::SQRT_2));
            let bell = |x: f64| libm::exp(-0.5 * x * x / (width * width));
            for (at, (light, growth)) in profile.light.iter().zip(profile.growth).take(7).enumerate() {
                let (low, high) = (at as f64 + 0.5 - 3.3, at as f64 + 1.5 - 3.3);
                let exact = scale * (normal(high) - normal(low));
                assert!((f64::from(*light) - exact).abs() < 2e-4, "{sigma}, pixel {at}: {light}, not {exact}");
                assert!((f64::from(growth) - (bell(low) - bell(high))).abs() < 1e-6, "{sigma}, pixel {at}: {growth}");
            }
        }
    }

    #[test]
    fn spans_reach_as_far_on_both_sides_and_not_beyond_the_view() {
        assert_eq!([span(8.4, 3, 20), span(8.6, 3, 20)], [(5, 11), (6, 12)]);
        assert_eq!([span(1.0, 3, 20), span(18.0, 3, 20), span(-0.4, 3, 20)], [(0, 4), (15, 19), (0, 3)]);
    }

    fn camera(gain: f32) -> Camera {
        Camera { black: 0.0, gain, read_noise: 0.0, saturation: 65_000.0, psf_sigma: 2.0 }
    }

    /// A star without noise on a sky of 10000 counts.
    fn star(camera: &Camera, amplitude: f32, (x, y): (f32, f32)) -> Star {
        let bell = |d: f32| libm::expf(-0.5 * d * d / 4.0);
        let pixels: [u16; SIDE * SIDE] = core::array::from_fn(|at| {
            let light = amplitude * bell((at % SIDE) as f32 - x) * bell((at / SIDE) as f32 - y);
            libm::roundf(10_000.0 + light) as u16
        });
        let frame = Raster::new(&pixels, SIDE, SIDE, SIDE).expect("a frame");
        let window = Window { x: 10.0, y: 10.0, width: SIDE as u16, height: SIDE as u16 };
        let mut view = View::new(&frame, &window, camera, &[]).expect("a view");
        Fit::<F32, u16>::of(&mut view, camera).and_then(Fit::star).expect("a star")
    }

    /// Pixels that sample a wide star tell what integrals over it do: information of `pi sigma^2` on the amplitude and
    /// of `pi / 2` on the shift, over the variance of a pixel.
    #[test]
    fn a_star_is_found_with_the_errors_that_its_light_allows() {
        for (gain, amplitude) in [(1.0, 1000.0), (4.0, 500.0)] {
            let camera = camera(gain);
            let found = star(&camera, amplitude, (10.3, 9.6));
            assert!((found.x - 10.3).abs() < 5e-3 && (found.y - 9.6).abs() < 5e-3 && found.flags == 0, "{found:?}");
            let flux = core::f32::consts::TAU * 4.0 * amplitude;
            assert!((found.flux / flux - 1.0).abs() < 0.02, "{found:?}: {flux}");
            let deviation = libm::sqrtf(10_000.0 / gain);
            // The sky, which is not known, takes an eighth of it.
            let snr = 0.875 * amplitude / deviation * libm::sqrtf(core::f32::consts::PI * 4.0);
            assert!((found.snr / snr - 1.0).abs() < 0.1, "{found:?}: {snr}");
            let error = deviation * deviation * core::f32::consts::FRAC_2_PI / (amplitude * amplitude);
            assert!(
                (found.errx2 / error - 1.0).abs() < 0.15 && (found.erry2 / error - 1.0).abs() < 0.15,
                "{error}: {found:?}"
            );
            assert!(found.errxy.abs() < 0.02 * error, "{found:?}");
        }
    }
}
