//! Several bands of a frame for one contour: the active contours without edges of Chan, Sandberg and
//! Vese for vector-valued images (doi:10.1006/jvci.1999.0442).
//!
//! The energy is that of [`crate::front::scheme::ChanVese`] with the mean over N bands in the place of
//! the one image:
//!
//! `mu/dx * sum of |grad v|  +  1/N sum over bands of lambda1 (I_i - c1_i)^2 (1 + v) + lambda2 (I_i - c2_i)^2 (1 - v)`
//!
//! where c1_i and c2_i are the means of band I_i. Each band is normalised, rescaled and filtered by
//! itself, so that bands weigh alike in what they are normalised by: in units of their noise with
//! [`Normalize::Noise`](crate::config::Normalize::Noise), which is the authors' weighting by noise.
//!
//! For fixed means the bands act through one number per pixel, the mean of their forces. It is
//! written into the image plane row by row ahead of the step, and the step reads it there.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::{Arithmetic, Cell, Real};
use crate::config::{Config, Scheme};
use crate::error::Error;
use crate::front::region::{Moments, Regions};
use crate::plane::rows::{row_of, row_of_mut};
use core::ops::Range;

/// The most bands of a frame.
pub const MOST_BANDS: usize = 8;

/// What a run knows of a band between two polls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Whether its plane holds the image that the front sees.
    ready: bool,
    /// The level above which its pixels count as objects, where the front starts near them.
    pub(crate) tau: f32,
    /// The sums of the step under way, and the means before it.
    regions: Regions,
}

impl Band {
    /// Before the first row.
    pub const NEW: Band = Band { ready: false, tau: 0.0, regions: Regions::NONE };

    /// The list of fields, out or in.
    fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.flag(&mut self.ready)?;
        codec.real(&mut self.tau)?;
        self.regions.code(codec)
    }
}

/// The caller's memory for bands, beside that of any run.
#[derive(Debug)]
pub struct Bands<'m, A: Arithmetic> {
    /// W x H cells for each band, one band after another.
    pub planes: &'m mut [A::Cell],
    /// One for each band, at most [`MOST_BANDS`]; overwritten.
    pub each: &'m mut [Band],
}

impl<A: Arithmetic> Bands<'_, A> {
    /// None: the image has one band, in the image plane.
    pub fn none() -> Self {
        Bands { planes: &mut [], each: &mut [] }
    }

    /// Whether the front of a configuration can be moved by them in frames of so many pixels.
    pub(crate) fn check(&self, config: &Config, pixels: usize) -> Result<(), Error> {
        let count = self.each.len();
        serve::<A>(config, count)?;
        let planes = ("the planes of the bands", self.planes.len(), count.saturating_mul(pixels));
        match [("the bands", count, 1), planes].into_iter().find(|&(_, given, needed)| given < needed) {
            Some((name, given, needed)) => Err(Error::Length { name, given, needed }),
            None => Ok(()),
        }
    }

    /// The band that is made ready: the last first, so that in the end what is known of the frame is
    /// known of the first. That, too, when all are ready.
    pub(crate) fn under_way(&self) -> usize {
        self.each.iter().rposition(|band| !band.ready).unwrap_or(0)
    }

    /// Notes that the band under way is ready; whether there is another that is not.
    pub(crate) fn go_on(&mut self, tau: f32) -> bool {
        let at = self.under_way();
        if let Some(band) = self.each.get_mut(at) {
            (band.ready, band.tau) = (true, tau);
        }
        self.each.iter().any(|band| !band.ready)
    }

    /// The plane of a band.
    pub(crate) fn plane(&self, at: usize, pixels: usize) -> &[A::Cell] {
        self.planes.get(cells_of(at, pixels)).unwrap_or(&[])
    }

    /// The same, to be written to.
    pub(crate) fn plane_mut(&mut self, at: usize, pixels: usize) -> &mut [A::Cell] {
        self.planes.get_mut(cells_of(at, pixels)).unwrap_or(&mut [])
    }

    /// Every band with its plane.
    pub(crate) fn iter(&self, pixels: usize) -> impl Iterator<Item = (&Band, &[A::Cell])> {
        self.each.iter().enumerate().map(move |(at, band)| (band, self.plane(at, pixels)))
    }

    /// Takes in rows of the front for the means of the next step.
    pub(crate) fn add_rows(&mut self, front: &[A::Cell], width: usize, rows: Range<usize>) {
        let Bands { planes, each } = self;
        for (at, band) in each.iter_mut().enumerate() {
            let plane = planes.get(cells_of(at, front.len())).unwrap_or(&[]);
            for y in rows.clone() {
                band.regions.add_row::<A>(row_of(front, width, y), row_of(plane, width, y));
            }
        }
    }

    /// All rows are taken in: the means of the next step, and no rows yet for those after it. Whether
    /// one of the means is another than before.
    pub(crate) fn turn(&mut self) -> bool {
        let mut turned = false;
        for band in self.each.iter_mut() {
            turned |= band.regions.turn(&Moments::default());
            band.regions = band.regions.anew();
        }
        turned
    }

    /// Writes the mean force of the bands on rows of the front into `force`, of the same size.
    pub(crate) fn force_rows(&self, pull: &Pull<A>, force: &mut [A::Cell], width: usize, rows: Range<usize>) {
        let pixels = force.len();
        for y in rows {
            let force = row_of_mut(force, width, y);
            force.fill(A::to_level(A::Real::ZERO));
            for (band, plane) in self.iter(pixels) {
                let [c2, c1, ..] = band.regions.means.values::<A>();
                for (force, &cell) in force.iter_mut().zip(row_of(plane, width, y)) {
                    let pixel = A::pixel(cell);
                    *force = A::to_level(A::level(*force) + pull.of(pixel - c1, pixel - c2));
                }
            }
        }
    }

    /// Whether a run could have come to this.
    pub(crate) fn is_sound(&self) -> bool {
        self.each.iter().all(|band| (0.0..=1.0).contains(&band.tau))
    }

    /// The planes and what is known of them, out or in.
    pub(crate) fn code<C: Codec>(&mut self, pixels: usize, codec: &mut C) -> Result<(), C::Error> {
        let cells = self.each.len().saturating_mul(pixels);
        codec.cells(self.planes.get_mut(..cells).unwrap_or(&mut []))?;
        self.each.iter_mut().try_for_each(|band| band.code(codec))
    }
}

/// Whether so many bands can move the front of a configuration.
///
/// # Errors
/// [`Error::Together`] with a scheme that goes by one image, or by signal-to-noise, [`Error::Arithmetic`] with narrow
/// cells, [`Error::Parameter`] for more than [`MOST_BANDS`].
pub fn serve<A: Arithmetic>(config: &Config, count: usize) -> Result<(), Error> {
    let apart = |other, wanted| Err(Error::Together { choice: "an image of", value: "several bands", other, wanted });
    match (config.scheme, config.sky.is_known()) {
        (Scheme::ChanVese, false) if A::Cell::BYTES < 4 => {
            Err(Error::Arithmetic { name: A::NAME, reason: "the force of several bands needs cells of 32 bits" })
        }
        (Scheme::ChanVese, false) if count > MOST_BANDS => {
            let (value, limit) = (count as f32, MOST_BANDS as f32);
            Err(Error::Parameter { name: "bands", value, bound: "at most", limit })
        }
        (Scheme::ChanVese, false) => Ok(()),
        (Scheme::ChanVese, true) => apart("sky", "none"),
        _ => apart("scheme", Scheme::ChanVese.name()),
    }
}

/// The cells of a band among those of all.
fn cells_of(at: usize, pixels: usize) -> Range<usize> {
    let start = at.saturating_mul(pixels);
    start..start.saturating_add(pixels)
}

/// What the distances of a pixel from both means pull a front by in a step.
#[derive(Clone, Copy, Debug)]
pub struct Pull<A: Arithmetic> {
    /// `dt lambda1` and `dt lambda2`, over the number of bands.
    inside: A::Real,
    outside: A::Real,
}

impl<A: Arithmetic> Pull<A> {
    /// That of one of so many bands.
    pub fn new(config: &Config, bands: usize) -> Self {
        let dt = config.dt / bands.clamp(1, MOST_BANDS) as f32;
        let weights = config.chan_vese;
        Pull { inside: A::Real::of(dt * weights.lambda1), outside: A::Real::of(dt * weights.lambda2) }
    }

    /// The force of a pixel that differs so much from the means inside and outside.
    #[inline(always)]
    pub fn of(&self, from_inside: A::Real, from_outside: A::Real) -> A::Real {
        self.outside * (from_outside * from_outside) - self.inside * (from_inside * from_inside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    const SIDE: usize = 2;

    /// Two bands of four pixels; the second has what the first lacks.
    fn filled<T>(look: impl FnOnce(Bands<'_, F32>) -> T) -> T {
        let mut planes = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        look(Bands { planes: &mut planes, each: &mut [Band::NEW; 2] })
    }

    #[test]
    fn the_last_band_is_made_ready_first() {
        filled(|mut bands| {
            assert_eq!(bands.under_way(), 1);
            assert!(bands.go_on(0.5));
            assert_eq!(bands.under_way(), 0);
            assert!(!bands.go_on(0.25));
            assert_eq!((bands.under_way(), bands.each[0].tau, bands.each[1].tau), (0, 0.25, 0.5));
        });
    }

    #[test]
    fn levels_beyond_the_image_are_not_sound() {
        filled(|bands| {
            assert!(bands.is_sound());
            bands.each[1].tau = 1.5;
            assert!(!bands.is_sound());
        });
    }

    /// A front around both objects has means of 1/2 in each band; then each object is pulled inside
    /// by its own band more than it is pushed outside by the other.
    #[test]
    fn what_one_band_shows_pulls_though_the_other_does_not() {
        let front = [1.0, 1.0, -1.0, -1.0f32];
        filled(|mut bands| {
            bands.add_rows(&front, SIDE, 0..SIDE);
            assert!(bands.turn(), "the means were 1 and 0");
            let mut force = [9.0f32; SIDE * SIDE];
            let pull = Pull::new(&Config { dt: 1.0, ..Config::CHAN_VESE }, 2);
            bands.force_rows(&pull, &mut force, SIDE, 0..SIDE);
            // Objects: (1 - 1/4 + 0 - 1/4) / 2; elsewhere: (0 - 1/4 + 0 - 1/4) / 2.
            assert_eq!(force, [0.25, 0.25, -0.25, -0.25]);
            bands.add_rows(&front, SIDE, 0..SIDE);
            assert!(!bands.turn(), "the same means again");
        });
    }

    #[test]
    fn each_side_has_its_own_weight() {
        let chan_vese = crate::config::ChanVese { mu: 0.0, lambda1: 3.0, lambda2: 0.5 };
        let pull = |bands| Pull::<F32>::new(&Config { dt: 0.5, chan_vese, ..Config::CHAN_VESE }, bands);
        // 0.25 * (0.5 * 0.4^2 - 3 * 0.2^2), and of two bands half of twice that.
        assert!((pull(2).of(0.2, -0.4) + 0.01).abs() < 1e-7 && (pull(1).of(0.2, -0.4) + 0.02).abs() < 1e-7);
    }

    #[test]
    fn eight_bands_move_one_front_of_regions_in_wide_cells() {
        use crate::arithmetic::Q11;
        assert!(serve::<F32>(&Config::CHAN_VESE, MOST_BANDS).is_ok());
        assert!(matches!(
            serve::<F32>(&Config::CHAN_VESE, MOST_BANDS + 1),
            Err(Error::Parameter { name: "bands", .. })
        ));
        assert!(matches!(serve::<Q11>(&Config::CHAN_VESE, 2), Err(Error::Arithmetic { .. })));
        assert!(matches!(serve::<F32>(&Config::PAPER_F160, 2), Err(Error::Together { other: "scheme", .. })));
        let sky = Config { sky: Config::NOISE_AWARE.sky, ..Config::CHAN_VESE };
        assert!(matches!(serve::<F32>(&sky, 2), Err(Error::Together { other: "sky", .. })));
    }
}
