//! Fluxes within ellipses and circles, by the exact area that each pixel shares with them.

use super::overlap::circle_polygon;
use super::scene::{Light, Spot};
use super::{Flux, Scene};
use skyfront_core::sources::flags;
use std::ops::Range;

/// No point of a pixel is farther from its centre.
pub(super) const CORNER: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The area of the largest aperture of a source: so many times its own pixels, and so many pixels more.
/// Kron's ellipses around even discs have 9 times their pixels, those around faint stars a few times
/// more; those around thin rings and arcs, which do not tell how their light lies, have no bound else.
const LARGEST: (f64, f64) = (64.0, 1024.0);
/// That of Kron's ellipse of a source of more than 5600 pixels, which noise does not make wide: rings in rings
/// overlap. Up to there it holds a ring a hundred times as wide as thick.
const LARGEST_KRON: (f64, f64) = (16.0, 269_824.0);

/// The area of the largest aperture of a source of so many pixels.
pub(super) fn largest(pixels: u32) -> f64 {
    LARGEST.0 * f64::from(pixels) + LARGEST.1
}

/// The area of its largest Kron aperture.
pub(super) fn largest_kron(pixels: u32) -> f64 {
    largest(pixels).min(LARGEST_KRON.0 * f64::from(pixels) + LARGEST_KRON.1)
}

/// The length of a vector; its parts are pixels, far from any overflow.
pub(super) fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// An ellipse, in pixels that count from 0.
///
/// ```
/// use skyfront::measure::{Aperture, Extras, Level, Scene};
///
/// let (pixels, labels) = (vec![2.0; 400], vec![0; 400]);
/// let [background, noise] = [0.0, 0.5].map(|level| Some(Level::Constant(level)));
/// let extras = Extras { background, noise, ..Extras::default() };
/// let scene = Scene::new(&pixels, &labels, 20, 20, &extras);
/// let (flux, flags) = Aperture::circle(9.3, 10.1, 4.0).flux(&scene, 0);
/// // The exact area of the circle counts, and nothing was in the way.
/// assert!((flux.value - 2.0 * 50.265).abs() < 0.01 && flags == 0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aperture {
    /// Column of its centre.
    pub x: f64,
    /// Row of its centre.
    pub y: f64,
    /// The first semi-axis.
    pub a: f64,
    /// The other semi-axis.
    pub b: f64,
    /// A place in units of the semi-axes: rows of the matrix that is applied to (dx, dy).
    to_unit: [(f64, f64); 2],
    /// Half of its width and of its height.
    half: (f64, f64),
    /// The row, from the centre, of its point farthest along x.
    tip: f64,
    /// The greatest distance of a pixel's corner from its centre, in units of the semi-axes.
    reach: f64,
}

impl Aperture {
    /// A circle.
    pub fn circle(x: f64, y: f64, radius: f64) -> Aperture {
        Aperture::ellipse((x, y), (radius, radius), 0.0)
    }

    /// An ellipse around (x, y) with the semi-axes (a, b), the first in the direction `theta` from
    /// the x axis towards y, radians.
    pub fn ellipse((x, y): (f64, f64), (a, b): (f64, f64), theta: f64) -> Aperture {
        let (sin, cos) = if theta == 0.0 { (0.0, 1.0) } else { libm::sincos(theta) };
        let half = (length(a * cos, b * sin), length(a * sin, b * cos));
        Aperture {
            x,
            y,
            a,
            b,
            to_unit: [(cos / a, sin / a), (-sin / b, cos / b)],
            half,
            tip: (a * a - b * b) * sin * cos / half.0,
            reach: CORNER / a.min(b),
        }
    }

    /// Calls `each` with every pixel of the image that may lie inside; whether the bounding box
    /// lies within the image. Cost: the pixels inside and along the border, and the rows.
    #[inline(always)]
    pub(super) fn visit(&self, width: usize, rows: &Range<usize>, each: impl FnMut(Spot)) -> bool {
        self.visit_near((width, rows), f64::INFINITY, each)
    }

    /// The same of the pixels nearer to the centre than `reach`, and of some others.
    #[inline(always)]
    fn visit_near(&self, (width, rows): (usize, &Range<usize>), reach: f64, mut each: impl FnMut(Spot)) -> bool {
        let near = |(low, high): (f64, f64)| (low.max(-reach), high.min(reach));
        let range = |centre: f64, (low, high): (f64, f64), most: &Range<usize>| {
            let (low, high) = ((centre + low + 0.5).floor(), (centre + high + 0.5).ceil());
            let (first, end) = (most.start as f64, most.end as f64);
            (low.max(first) as usize..(high.max(0.0) as usize).min(most.end), low >= first && high <= end)
        };
        let columns = 0..width;
        let (_, inside_x) = range(self.x, (-self.half.0, self.half.0), &columns);
        let (_, inside_y) = range(self.y, (-self.half.1, self.half.1), rows);
        for y in range(self.y, near((-self.half.1, self.half.1)), rows).0 {
            // What has a sign is converted at once.
            let dy = y as i64 as f64 - self.y;
            for x in range(self.x, near(self.span(dy)), &columns).0 {
                each(Spot { x, y, dx: x as i64 as f64 - self.x, dy });
            }
        }
        inside_x && inside_y
    }

    /// The least and the greatest dx of the ellipse within the row of pixels around `dy`.
    fn span(&self, dy: f64) -> (f64, f64) {
        let [(p, q), (r, s)] = self.to_unit;
        // A dx^2 + 2 B dx dy + C dy^2 = 1.
        let (square, mixed, other) = (p * p + r * r, p * q + r * s, q * q + s * s);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for edge in [dy - 0.5, dy + 0.5] {
            let (middle, rest) = (mixed * edge, square * (1.0 - other * edge * edge));
            let discriminant = middle * middle + rest;
            if discriminant >= 0.0 {
                let root = discriminant.sqrt();
                low = low.min((-middle - root) / square);
                high = high.max((-middle + root) / square);
            }
        }
        let within = |place: f64| (place - dy).abs() <= 0.5;
        (if within(-self.tip) { -self.half.0 } else { low }, if within(self.tip) { self.half.0 } else { high })
    }

    /// A place (dx, dy) from the centre in units of the semi-axes.
    #[inline(always)]
    fn unit(&self, dx: f64, dy: f64) -> (f64, f64) {
        let [(p, q), (r, s)] = self.to_unit;
        (p * dx + q * dy, r * dx + s * dy)
    }

    /// The share of a pixel at (dx, dy) from the centre that lies inside.
    #[inline]
    pub(super) fn share(&self, dx: f64, dy: f64) -> f64 {
        let (u, v) = self.unit(dx, dy);
        let square = u * u + v * v;
        let (whole, none) = (1.0 - self.reach, 1.0 + self.reach);
        if whole >= 0.0 && square <= whole * whole {
            1.0
        } else if square >= none * none {
            0.0
        } else {
            let corner = |x: f64, y: f64| self.unit(dx + x, dy + y);
            let corners = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
            circle_polygon(&corners) * self.a * self.b
        }
    }

    /// Calls `each` with what every pixel counts for source `label` and with its share inside; the
    /// flags that the pixels earn.
    pub(super) fn lights(&self, scene: &Scene<'_>, label: u32, mut each: impl FnMut(Spot, Light, f64)) -> u32 {
        let mut flags = 0;
        let complete = self.visit(scene.width, &scene.rows, |spot| {
            let share = self.share(spot.dx, spot.dy);
            if share <= 0.0 {
                return;
            }
            match scene.light(spot, label) {
                Ok(light) => {
                    flags |= light.flags;
                    each(spot, light, share);
                }
                Err(why) => flags |= why,
            }
        });
        flags | if complete { 0 } else { flags::APERTURE }
    }

    /// Calls `each` with the place, from the centre, and the share of the light of every pixel at such
    /// a distance from it.
    pub(super) fn lights_between(
        &self,
        scene: &Scene<'_>,
        label: u32,
        distances: Range<f64>,
        each: &mut dyn FnMut(f64, f64, f64),
    ) {
        self.visit_near((scene.width, &scene.rows), distances.end, |spot| {
            if !distances.contains(&length(spot.dx, spot.dy)) {
                return;
            }
            let share = self.share(spot.dx, spot.dy);
            if let (true, Ok(light)) = (share > 0.0, scene.light(spot, label)) {
                each(spot.dx, spot.dy, share * light.value);
            }
        });
    }

    /// Flux above the background within the aperture, and the flags it earns; NaN where no pixel of
    /// it can be measured. What pixels of other sources and undefined ones count is said by
    /// [`super::Neighbours`].
    pub fn flux(&self, scene: &Scene<'_>, label: u32) -> (Flux, u32) {
        let mut sum = Sum::default();
        let flags = self.lights(scene, label, |_, light, share| sum.add(light, share));
        (sum.flux(scene), flags)
    }

    /// Kron's first moment: the mean distance of the light from the centre, in units of the
    /// semi-axes, over the pixels whose centres lie inside (Kron 1980, doi:10.1086/190669); none
    /// where there is no light.
    pub fn first_moment(&self, scene: &Scene<'_>, label: u32) -> Option<f64> {
        let (mut light, mut moment) = (0.0, 0.0);
        self.visit(scene.width, &scene.rows, |spot| {
            let (u, v) = self.unit(spot.dx, spot.dy);
            let square = u * u + v * v;
            if square > 1.0 {
                return;
            }
            if let Ok(Light { value, .. }) = scene.light(spot, label) {
                light += value;
                moment += value * square.sqrt();
            }
        });
        (light > 0.0 && moment > 0.0).then(|| moment / light)
    }
}

/// The light of an aperture as it is summed up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    area: f64,
    value: f64,
    variance: f64,
}

impl Sum {
    /// Takes in the share of a pixel.
    pub(super) fn add(&mut self, light: Light, share: f64) {
        self.area += share;
        self.value += share * light.value;
        self.variance += share * light.variance;
    }

    /// The flux; NaN where there was no pixel.
    pub(super) fn flux(&self, scene: &Scene<'_>) -> Flux {
        if self.area > 0.0 { scene.flux(self.value, self.variance) } else { Flux::NONE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// The pixels that are visited, and the sum of their shares.
    fn visited(aperture: &Aperture, side: usize) -> (usize, f64) {
        let (mut count, mut area) = (0, 0.0);
        let complete = aperture.visit(side, &(0..side), |spot| {
            count += 1;
            area += aperture.share(spot.dx, spot.dy);
        });
        assert!(complete);
        (count, area)
    }

    #[test]
    fn the_pixels_that_are_visited_hold_the_whole_ellipse() {
        for (a, b, theta) in [(20.0, 20.0, 0.0), (60.0, 3.0, 0.7), (40.0, 0.4, -1.1), (5.0, 30.0, 2.0), (0.3, 0.2, 0.5)]
        {
            for (x, y) in [(100.0, 100.0), (99.5, 100.5), (100.3, 99.9)] {
                let (_, area) = visited(&Aperture::ellipse((x, y), (a, b), theta), 200);
                assert!((area / (PI * a * b) - 1.0).abs() < 1e-12, "{a} {b} {theta}: {area}");
            }
        }
    }

    #[test]
    fn all_pixels_near_the_centre_are_visited_and_few_others() {
        let ellipse = Aperture::ellipse((100.3, 99.6), (80.0, 50.0), 0.7);
        for reach in [0.4, 7.0, 30.5, 61.0, 200.0] {
            let near = |spot: &Spot| length(spot.dx, spot.dy) < reach;
            let (mut all, mut some, mut count) = (Vec::new(), Vec::new(), 0);
            ellipse.visit(200, &(0..200), |spot| all.extend(Some(spot).filter(near).map(|spot| (spot.x, spot.y))));
            ellipse.visit_near((200, &(0..200)), reach, |spot| {
                count += 1;
                some.extend(Some(spot).filter(near).map(|spot| (spot.x, spot.y)));
            });
            assert_eq!(some, all);
            assert!(f64::from(count) <= (2.0 * reach + 3.0) * (2.0 * reach + 3.0), "{count} pixels within {reach}");
        }
    }

    #[test]
    fn even_light_has_two_thirds_of_the_radius_as_its_first_moment() {
        let (pixels, labels) = (vec![3.0; 40_000], vec![0; 40_000]);
        let [background, noise] = [1.0, 1.0].map(|level| Some(crate::measure::Level::Constant(level)));
        let extras = crate::measure::Extras { background, noise, ..Default::default() };
        let scene = Scene::new(&pixels, &labels, 200, 200, &extras);
        for (a, b) in [(60.0, 60.0), (80.0, 30.0)] {
            let moment = Aperture::ellipse((99.6, 100.3), (a, b), 0.4).first_moment(&scene, 1).expect("light");
            assert!((moment - 2.0 / 3.0).abs() < 2e-3, "{moment}");
        }
    }

    #[test]
    fn a_small_source_may_have_a_wider_kron_aperture_for_its_size_than_a_large_one() {
        assert_eq!((largest(100), largest_kron(100)), (7424.0, 7424.0));
        assert_eq!((largest(10_000), largest_kron(10_000)), (641_024.0, 429_824.0));
    }

    /// The bounding box of a slanting line is most of the image.
    #[test]
    fn a_thin_ellipse_visits_a_thin_strip() {
        let (count, area) = visited(&Aperture::ellipse((1000.0, 1000.0), (1200.0, 3.0), 0.78), 2000);
        assert!((count as f64) < 2.0 * area, "{count} pixels for {area}");
    }

    #[test]
    fn an_aperture_beyond_any_border_is_not_complete() {
        let complete = |x: f64, y: f64| Aperture::circle(x, y, 5.0).visit(40, &(10..50), |_| ());
        assert!(complete(20.0, 30.0) && complete(4.6, 14.6) && complete(34.4, 44.4));
        for (x, y) in [(4.4, 30.0), (34.6, 30.0), (20.0, 14.4), (20.0, 44.6)] {
            assert!(!complete(x, y), "around {x}, {y}");
        }
    }

    #[test]
    fn light_on_the_ellipse_is_inside() {
        let mut pixels = vec![0.0; 400];
        pixels[10 * 20 + 13] = 1.0;
        let [background, noise] = [0.0, 1.0].map(|level| Some(crate::measure::Level::Constant(level)));
        let extras = crate::measure::Extras { background, noise, ..Default::default() };
        let scene = Scene::new(&pixels, &[0; 400], 20, 20, &extras);
        let moment = |radius: f64| Aperture::circle(10.0, 10.0, radius).first_moment(&scene, 1);
        assert_eq!((moment(3.0), moment(2.9)), (Some(1.0), None));
    }
}
