//! Light at places that are known, as the light itself is, to within roundings: between which numbers it lies.

use super::Plane;
use super::light::{Place, ROUND, Shape, opposite, turned};

/// Between which numbers another lies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Between {
    /// The least.
    pub low: f64,
    /// The most.
    pub high: f64,
}

impl Between {
    /// So far beyond both.
    pub fn widened(self, off: f64) -> Between {
        Between { low: self.low - off, high: self.high + off }
    }

    /// The upper one in the middle; `None` of nothing.
    fn median(all: &[Between]) -> Option<Between> {
        let middle = |of: fn(&Between) -> f64| {
            let mut values: Vec<f64> = all.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied()
        };
        Some(Between { low: middle(|one| one.low)?, high: middle(|one| one.high)? })
    }
}

/// What is rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roundings {
    /// The distance of two neighbouring numbers in fixed point; 0 in single precision.
    pub grain: f64,
    /// The share of a number by which it may be off in single precision.
    pub unit: f64,
}

impl Roundings {
    /// Nothing.
    pub const NONE: Roundings = Roundings { grain: 0.0, unit: 0.0 };

    /// How far light between pixels up to a size may be off: in fixed point four products that half of it goes on by, each
    /// rounded to half a grain, in rows and across them; else as many, their factors and their sums.
    fn of_light(&self, size: f64) -> f64 {
        if self.grain > 0.0 { 2.0 * self.grain } else { 8.0 * self.unit * size }
    }

    /// How far along each axis a place on an ellipse may be off, at a distance from its centre told as the sum of both
    /// axes, in a frame with a side. What is left of 1 is off by four roundings, the moments by half of that as a part of
    /// it and three of their own, and in fixed point half a grain; a quarter of a turn is two products with them and half
    /// of that one more, which is added to the centre.
    fn of_place(&self, shape: Shape, distance: f64, side: usize) -> f64 {
        let left = left(shape);
        let most = (1.0 + shape.0.abs()).max(shape.1.abs()) / left.sqrt();
        let moments = most * (2.0 / left + 4.0) * self.unit + 0.5 * self.grain;
        let turned = moments * distance + 4.0 * self.unit * (1.0 + most) * distance + self.grain;
        turned + 0.5 * self.grain + self.unit * side as f64
    }

    /// The shape that the parts of moments make, by all that is open: none where one axis is longer than ten of the other.
    fn shapes(&self, parts: Shape) -> impl Iterator<Item = Option<Shape>> {
        let (left, off) = (left(parts) - 0.039, 4.0 * self.unit);
        let open = [(left > -off, Some(parts)), (left <= off, None)];
        open.into_iter().filter_map(|(may_be, shape)| may_be.then_some(shape))
    }
}

/// What the axes of a shape leave of 1: the square of twice the product of both as a part of the sum of their squares.
fn left((along, across): Shape) -> f64 {
    1.0 - along * along - across * across
}

/// What is seen at a place.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The light there.
    pub light: Between,
    /// The pixels that may be the nearest.
    pub pixels: Vec<usize>,
    /// Whether the place may lie beyond the frame.
    pub may_be_beyond: bool,
}

/// An image that is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Seeing<'a> {
    /// The image.
    pub image: &'a Plane,
    /// What is rounded.
    pub roundings: Roundings,
}

/// A part of an axis within the frame: its ends, and whether it went beyond.
fn part(at: f64, off: f64, length: usize) -> Option<(f64, f64, bool)> {
    let last = length.checked_sub(1).filter(|&last| last > 0)? as f64;
    let (low, high) = (at - off, at + off);
    (high >= 0.0 && low <= last).then(|| (low.max(0.0), high.min(last), low < 0.0 || high > last))
}

/// Both ends and the pixels between: light is straight from one to the next.
fn corners(low: f64, high: f64) -> impl Iterator<Item = f64> + Clone {
    let pixels = (low.ceil() as usize..=high.floor() as usize).map(|at| at as f64);
    [low, high].into_iter().chain(pixels)
}

impl Seeing<'_> {
    /// The light at a place that may be off along each axis by so much; `None` beyond the frame.
    pub fn look(&self, (x, y): Place, off: f64) -> Option<Seen> {
        let (width, image) = (self.image.width(), self.image);
        let (left, right, beside) = part(x, off, width)?;
        let (bottom, top, above) = part(y, off, image.height())?;
        let places = || corners(bottom, top).flat_map(|y| corners(left, right).map(move |x| (x, y)));
        let lights = places().map(|(x, y)| image.interpolate(x, y));
        let (low, high) = lights.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        let pixels = |low: f64, high: f64| low as usize..=high as usize;
        let all = pixels(bottom.floor(), top.ceil())
            .flat_map(|y| pixels(left.floor(), right.ceil()).map(move |x| y * width + x));
        let size = all.map(|at| image.values()[at].abs()).fold(0.0, f64::max);
        let round = |at: f64| (at - 0.5).ceil();
        let nearest = pixels(round(bottom), round(top))
            .flat_map(|y| pixels(round(left), round(right)).map(move |x| y * width + x));
        let Between { low, high } = Between { low, high }.widened(self.roundings.of_light(size));
        let light = Between { low: low.max(0.0), high: high.max(0.0) };
        Some(Seen { light, pixels: nearest.collect(), may_be_beyond: beside || above })
    }

    /// What is seen at the seven other places on the ellipse through a place.
    fn turned(&self, centre: Place, shape: Shape, from: Place) -> impl Iterator<Item = Option<Seen>> {
        let distance = (from.0 - centre.0).abs() + (from.1 - centre.1).abs();
        let off = self.roundings.of_place(shape, distance, self.image.width().max(self.image.height()));
        turned(centre, shape, from).map(|place| self.look(place, off)).into_iter()
    }

    /// The median of the light at the seven other places as far from a centre; 0 counts for what is beyond the frame.
    fn around(&self, centre: Place, from: Place) -> Between {
        let light = |seen: Option<Seen>| match seen {
            Some(Seen { light, may_be_beyond: true, .. }) => Between { low: 0.0, ..light },
            seen => seen.map_or(Between::default(), |seen| seen.light),
        };
        let lights: Vec<Between> = self.turned(centre, ROUND, from).map(light).collect();
        Between::median(&lights).unwrap_or_default()
    }

    /// What `other` alone has at a place; 0 where that is not known.
    pub fn alone(&self, [host, other]: [Place; 2], at: Place) -> Between {
        let across = opposite(other, at);
        let Some(Seen { light, .. }) = self.look(across, 0.0) else { return Between::default() };
        let mirrored = self.look(opposite(host, across), 0.0).map_or(Between::default(), |seen| seen.light);
        let around = self.around(host, across);
        let off = self.roundings.unit * light.high;
        let low = light.low - mirrored.high.min(around.high) - off;
        let high = light.high - mirrored.low.min(around.low) + off;
        Between { low: low.max(0.0), high: high.max(0.0) }
    }

    /// The median of the light at the seven other places on an ellipse, of those in the frame whose pixel `counts`, by all
    /// that is open; `None` where there may be none, or no ellipse.
    pub fn on_ellipse(
        &self,
        (centre, parts): (Place, Shape),
        from: Place,
        counts: impl Fn(usize) -> bool,
    ) -> Vec<Option<Between>> {
        let mut found = Vec::new();
        for shape in self.roundings.shapes(parts) {
            let Some(shape) = shape else {
                found.push(None);
                continue;
            };
            let (mut certain, mut open) = (Vec::new(), Vec::new());
            for Seen { light, pixels, may_be_beyond } in self.turned(centre, shape, from).flatten() {
                let counting = pixels.iter().filter(|&&at| counts(at)).count();
                if counting == pixels.len() && !may_be_beyond {
                    certain.push(light);
                } else if counting > 0 {
                    open.push(light);
                }
            }
            for choice in 0..1u32 << open.len() {
                let chosen = open.iter().enumerate().filter(|(n, _)| choice >> n & 1 == 1).map(|(_, &light)| light);
                let lights: Vec<Between> = certain.iter().copied().chain(chosen).collect();
                found.push(Between::median(&lights));
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of 3 along x and 5 along y, with a step of 40 in one pixel.
    fn image() -> Plane {
        Plane::from_fn(16, 12, |i, j| 3.0 * i as f64 + 5.0 * j as f64 + if (i, j) == (7, 6) { 40.0 } else { 0.0 })
    }

    const FIXED: Roundings = Roundings { grain: 0.01, unit: 0.0 };

    #[test]
    fn light_lies_between_that_of_all_places_near() {
        let (image, off) = (image(), 0.3);
        let seeing = Seeing { image: &image, roundings: Roundings::NONE };
        for (x, y) in [(3.1, 4.2), (6.9, 6.1), (7.0, 5.5), (0.1, 11.0), (15.2, 3.0)] {
            let seen = seeing.look((x, y), off).expect("it may lie in the frame");
            let (mut low, mut high, mut pixels) = (f64::MAX, f64::MIN, Vec::new());
            for step in 0..=60 * 60 {
                let place = (x + off * ((step % 61) as f64 / 30.0 - 1.0), y + off * ((step / 61) as f64 / 30.0 - 1.0));
                let Some(exact) = seeing.look(place, 0.0) else { continue };
                assert_eq!(exact.light.low, exact.light.high);
                (low, high) = (low.min(exact.light.low), high.max(exact.light.high));
                pixels.extend(exact.pixels);
            }
            pixels.sort_unstable();
            pixels.dedup();
            assert_eq!(seen.pixels, pixels);
            assert!((0.0..1.0).contains(&(low - seen.light.low + 1e-9)), "{:?}, not {low}", seen.light);
            assert!((0.0..1.0).contains(&(seen.light.high - high + 1e-9)), "{:?}, not {high}", seen.light);
            assert_eq!(seen.may_be_beyond, y > 10.0 || x > 15.0);
        }
        assert!(seeing.look((15.4, 3.0), off).is_none());
        let rounded = Seeing { image: &image, roundings: FIXED }.look((3.0, 4.0), 0.0).expect("in the frame");
        assert_eq!(rounded.light, Between { low: 29.0, high: 29.0 }.widened(0.02));
    }

    #[test]
    fn what_may_or_may_not_count_is_tried_both_ways() {
        let image = Plane::from_fn(16, 12, |i, _| 10.0 * i as f64);
        let counts = |at: usize| at % 16 >= 7;
        let light = |roundings: Roundings, x: f64| {
            let seeing = Seeing { image: &image, roundings };
            seeing.on_ellipse(((7.0, 6.0), ROUND), (7.0 + x, 6.0), counts)
        };
        // Of seven places on a circle of two pixels two on the right count, and those above and below.
        let exact = light(Roundings::NONE, 2.0);
        assert!(exact.len() == 1 && exact[0].is_some_and(|light| (light.low - 84.14).abs() < 0.01), "{exact:?}");
        // On one of 0.7 pixels the places on the slanted left may count.
        let open = light(FIXED, 0.7072);
        assert!(open.len() > 1, "{open:?}");
        assert!(open.iter().flatten().any(|light| light.high - light.low > 0.05), "{open:?}");
        assert_eq!(light(Roundings::NONE, 0.7072).len(), 1);
        let nothing = Seeing { image: &image, roundings: FIXED }.on_ellipse(((7.0, 6.0), ROUND), (9.0, 6.0), |_| false);
        assert_eq!(nothing, [None]);
    }

    #[test]
    fn an_axis_of_ten_others_may_have_no_ellipse() {
        let needle = (0.961f64.sqrt(), 0.0);
        let unit = 1e-6;
        let shapes = |along: f64| Roundings { unit, grain: 0.0 }.shapes((along, 0.0)).collect::<Vec<_>>();
        assert_eq!(shapes(needle.0), [Some(needle), None]);
        assert_eq!(shapes(needle.0 + 1e-4), [None]);
        assert_eq!(shapes(needle.0 - 1e-4), [Some((needle.0 - 1e-4, 0.0))]);
        assert_eq!(Roundings::NONE.shapes((0.0, 1.0)).collect::<Vec<_>>(), [None]);
    }
}
