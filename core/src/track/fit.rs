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

/// Whether a centre lies on a pixel along an axis; where pixels end it is on none.
fn is_within<R: Real>(centre: R, length: usize) -> bool {
    let half = R::of(0.5);
    centre > -half && centre < R::of(length as f32) - half
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
        let within = is_within(self.centre.0, self.view.size.0) && is_within(self.centre.1, self.view.size.1);
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
    use crate::plane::raster::{BadPixel, Raster};
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

    #[test]
    fn a_view_ends_where_its_pixels_do() {
        assert_eq!([-0.5, -0.49, 9.49, 9.5].map(|centre: f32| is_within(centre, 10)), [false, true, true, false]);
    }

    fn camera(gain: f32) -> Camera {
        Camera { black: 0.0, gain, read_noise: 0.0, saturation: 65_000.0, psf_sigma: 2.0 }
    }

    type Pixels = [u16; SIDE * SIDE];

    /// A star without noise on a level sky.
    fn pixels(sky: f32, amplitude: f32, (x, y): (f32, f32)) -> Pixels {
        let bell = |d: f32| libm::expf(-0.5 * d * d / 4.0);
        core::array::from_fn(|at| {
            libm::roundf(sky + amplitude * bell((at % SIDE) as f32 - x) * bell((at / SIDE) as f32 - y)) as u16
        })
    }

    /// A window that is all of its frame, ready for the first step.
    fn fitted<T>(pixels: &Pixels, camera: &Camera, bad: &[BadPixel], look: impl FnOnce(Fit<'_, F32, u16>) -> T) -> T {
        let frame = Raster::new(pixels, SIDE, SIDE, SIDE).expect("a frame");
        let window = Window { x: 10.0, y: 10.0, width: SIDE as u16, height: SIDE as u16 };
        let mut view = View::new(&frame, &window, camera, bad).expect("a view");
        look(Fit::of(&mut view, camera).expect("light"))
    }

    fn star(camera: &Camera, amplitude: f32, place: (f32, f32)) -> Star {
        fitted(&pixels(10_000.0, amplitude, place), camera, &[], |fit| fit.star()).expect("a star")
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

    #[test]
    fn the_window_ends_at_three_widths() {
        assert_eq!([0.7, 1.2, 2.0].map(|sigma| Psf::<F32>::of(sigma).reach), [3, 4, 6]);
    }

    /// A median of half a count below 5: a spike is what stands above 5 and 8 deviations of 2.14.
    #[test]
    fn spikes_are_told_by_the_noise_of_the_sky_and_the_slopes_of_the_psf() {
        let left_out = |peak: u16, beside: u16| {
            let star = pixels(4.0, 100.0, (13.0, 13.0));
            let mut pixels: Pixels = core::array::from_fn(|at| star[at] + (at % 2) as u16);
            let at = 5 * SIDE + 7;
            [at - SIDE, at, at + SIDE].into_iter().for_each(|at| pixels[at - 1..=at + 1].fill(beside));
            pixels[at] = peak;
            fitted(&pixels, &camera(1.0), &[], |fit| fit.view.out_of(5) >> 7 & 1)
        };
        assert_eq!([left_out(23, 4), left_out(24, 4)], [0, 1]);
        // Half of what the PSF has beside its middle is 0.44.
        assert_eq!([left_out(1004, 404), left_out(1004, 504)], [1, 0]);
    }

    #[test]
    fn it_starts_with_the_brightest_pixel_as_a_star_and_the_border_as_sky() {
        let mut pixels: Pixels = core::array::from_fn(|at| 100 + (at % 2) as u16);
        for (at, light) in [(9 * SIDE + 10, 600), (10 * SIDE + 10, 1000), (11 * SIDE + 10, 600)] {
            [(at - 1, light - 200), (at, light), (at + 1, light - 200)].into_iter().for_each(|(at, v)| pixels[at] = v);
        }
        fitted(&pixels, &camera(1.0), &[], |fit| {
            let [middle, ..] = fit.psf.profile(0.0, (0, 1)).light;
            assert_eq!((fit.centre, fit.base, fit.unit), ((10.0, 10.0), 101, 1.0 / 1024.0));
            let rest = fit.border.1.expect("a border").rest;
            assert!(rest == -0.5 && fit.sky == rest / 1024.0, "{rest}");
            assert!((fit.star - 899.0 / 1024.0 / (middle * middle)).abs() < 1e-6, "{}", fit.star);
        });
    }

    #[test]
    fn the_border_is_the_sky_where_the_star_does_not_reach() {
        let camera = camera(1.0);
        fitted(&pixels(1000.0, 500.0, (10.0, 10.0)), &camera, &[], |fit| assert_eq!(fit.border.0, Rectangle::NONE));
        fitted(&pixels(1000.0, 500.0, (3.0, 10.0)), &camera, &[], |fit| {
            assert_eq!(fit.border.0, Rectangle { columns: (0, 10), rows: (3, 17) });
            // 80 pixels without the 15 of the first column.
            assert_eq!(fit.border.1.map(|border| (border.base, border.rest, border.pixels)), Some((1000, 0.0, 65)));
        });
    }

    #[test]
    fn pixels_weigh_by_the_noise_of_sky_and_star() {
        fitted(&pixels(1000.0, 500.0, (10.0, 10.0)), &camera(4.0), &[], |mut fit| {
            (fit.base, fit.unit, fit.sky, fit.star) = (900, 1.0 / 512.0, 0.125, 0.5);
            let weights = fit.weights();
            // 900 + 64 counts of sky and 256 of the star, four electrons each, and a twelfth for whole counts.
            let variance = 241.0 + 1.0 / 12.0;
            let level = variance / (variance + 64.0);
            assert!((weights.variance - variance).abs() < 1e-3, "{}", weights.variance);
            assert!((weights.level - level).abs() < 1e-6 && (weights.rest - (1.0 - level)).abs() < 1e-6);
        });
    }

    #[test]
    fn the_border_tells_the_sky_as_a_median_does() {
        fitted(&pixels(1000.0, 500.0, (10.0, 10.0)), &camera(1.0), &[], |mut fit| {
            (fit.base, fit.unit) = (990, 1.0 / 512.0);
            fit.border.1 = Some(Border { base: 1000, rest: 0.25, pixels: 64 });
            let zero = Basis { sky: 0.0, star: 0.0, column: 0.0, row: 0.0 };
            let mut equations = fit.known();
            for basis in
                [Basis { sky: 1.0, star: 1.0, ..zero }, Basis { column: 1.0, ..zero }, Basis { row: 1.0, ..zero }]
            {
                equations.add(basis, 1.0, 0.0);
            }
            let found = equations.solve().expect("a solution");
            // 64 pixels of which each is worth 2 / pi, in units of an eighth; and what is left of one of the star.
            let information = core::f32::consts::FRAC_2_PI;
            assert!((found.of_star - information / (information + 1.0)).abs() < 1e-6, "{found:?}");
            assert!((found.sky - 10.25 / 512.0 * 8.0).abs() < 1e-6, "{found:?}");
        });
    }

    #[test]
    fn errors_are_the_inverse_of_the_information() {
        fitted(&pixels(1000.0, 500.0, (10.0, 10.0)), &camera(1.0), &[], |mut fit| {
            fit.unit = 1.0 / 512.0;
            let solution = Solution { sky: 0.0, star: 0.5, shift: (0.0, 0.0), of_star: 4.0, of_shift: (2.0, 1.0, 4.0) };
            let star = fit.record(&Step { solution, variance: 100.0 });
            // Of 256 counts; the determinant is 7.
            let scale = 100.0 / 65_536.0 / 7.0;
            for (found, expected) in [
                (star.snr, 256.0 * 0.2),
                (star.errx2, 4.0 * scale),
                (star.erry2, 2.0 * scale),
                (star.errxy, -scale),
                (star.flux, 256.0 * core::f32::consts::TAU * 4.0),
            ] {
                assert!((found / expected - 1.0).abs() < 1e-5, "{found}, not {expected}: {star:?}");
            }
        });
    }

    /// Light of photons: `sum (A m)^2 / (sky + A m)`, of which a sky that is all but dark takes nothing.
    #[test]
    fn a_bright_star_has_the_noise_of_its_own_light() {
        let found = fitted(&pixels(20.0, 20_000.0, (10.3, 9.6)), &camera(1.0), &[], |fit| fit.star()).expect("a star");
        let mut square = 0.0;
        for light in pixels(0.0, 20_000.0, (10.3, 9.6)).map(f32::from) {
            square += light * light / (light + 20.0);
        }
        assert!((found.snr / libm::sqrtf(square) - 1.0).abs() < 0.05, "{found:?}: {}", libm::sqrtf(square));
        assert!((found.x - 10.3).abs() < 5e-3 && (found.y - 9.6).abs() < 5e-3, "{found:?}");
    }

    #[test]
    fn pixels_left_out_do_not_count() {
        let (camera, bad) = (camera(1.0), [BadPixel { x: 12, y: 11 }, BadPixel { x: 8, y: 8 }]);
        let mut frame = pixels(10_000.0, 3000.0, (10.3, 9.6));
        bad.iter().for_each(|bad| frame[usize::from(bad.y) * SIDE + usize::from(bad.x)] = 0);
        let found = fitted(&frame, &camera, &bad, |fit| fit.star()).expect("a star");
        assert!((found.x - 10.3).abs() < 5e-3 && (found.y - 9.6).abs() < 5e-3 && found.flags == HOT, "{found:?}");
    }

    #[test]
    fn centres_lie_within_the_window_and_stars_above_the_noise() {
        let found =
            |amplitude: f32, place| fitted(&pixels(10_000.0, amplitude, place), &camera(1.0), &[], |fit| fit.star());
        for (out, within) in [
            ((-0.8, 10.0), (-0.3, 10.0)),
            ((20.8, 10.0), (20.3, 10.0)),
            ((10.0, -0.8), (10.0, -0.3)),
            ((10.0, 20.8), (10.0, 20.3)),
        ] {
            assert_eq!(found(5000.0, out), None, "{out:?}");
            let star = found(5000.0, within).expect("a star");
            assert!((star.x - within.0).abs() < 0.05 && (star.y - within.1).abs() < 0.05, "{star:?}");
        }
        assert_eq!(found(10.0, (10.3, 9.6)), None);
    }

    /// At least two steps, and then as long as the last one was longer than 1/512 of a pixel.
    #[test]
    fn steps_end_when_the_centre_has_settled() {
        let mut taken = [0; STEPS + 1];
        for (amplitude, place) in
            [(1000.0, (10.0, 10.0)), (1000.0, (10.3, 9.6)), (20_000.0, (10.4, 9.5)), (3000.0, (0.2, 9.5))]
        {
            let (frame, camera) = (pixels(1000.0, amplitude, place), camera(1.0));
            let (centre, steps) = fitted(&frame, &camera, &[], |mut fit| {
                let mut steps = 0;
                while steps < 2 || steps < STEPS && fit.moved > 1.0 / 512.0 {
                    fit.step().expect("a step");
                    steps += 1;
                }
                (fit.centre, steps)
            });
            let star = fitted(&frame, &camera, &[], |fit| fit.star()).expect("a star");
            assert_eq!((star.x, star.y), centre, "{place:?}");
            taken[steps] += 1;
        }
        assert!(taken[2] > 0 && taken[3] + taken[4] > 0, "{taken:?}");
    }

    /// Five deviations of sky and peak and a fifth of the peak.
    #[test]
    fn what_stands_above_star_and_noise_is_another_source() {
        let (mut frame, at) = (pixels(1000.0, 400.0, (10.0, 10.0)), 6 * SIDE + 5);
        [at - 1, at + 1, at - SIDE, at + SIDE].into_iter().for_each(|at| frame[at] = 1150);
        let flags = |beside: u16, gain: f32| {
            let mut frame = frame;
            frame[at] = beside;
            fitted(&frame, &camera(gain), &[], |mut fit| {
                fit.centre = (10.0, 10.0);
                (fit.base, fit.unit, fit.sky, fit.star) = (990, 1.0 / 512.0, 10.0 / 512.0, 400.0 / 512.0);
                fit.flags() & BLENDED
            })
        };
        // 80 + 5 sqrt((1000 + 400) / gain), and 2.4 of the star there.
        for (gain, least) in [(1.0, 1270), (2.0, 1215)] {
            assert_eq!((1150..1400).find(|beside| flags(*beside, gain) != 0), Some(least));
        }
    }

    /// Of photons without number, so that the noise is that of whole counts, on a pixel without star.
    #[test]
    fn what_stands_as_high_as_star_and_noise_is_no_other_source() {
        let flags = |part: f32| {
            fitted(&pixels(1000.0, 400.0, (10.0, 10.0)), &camera(1e30), &[], |mut fit| {
                let most = SIGNIFICANT * libm::sqrtf(1.0 / 12.0) * fit.unit;
                (fit.base, fit.sky, fit.star) = (1400, -most * part, 0.0);
                fit.flags() & BLENDED
            })
        };
        assert_eq!([flags(1.0), flags(1.0 + 1e-6)], [0, BLENDED]);
    }
}
