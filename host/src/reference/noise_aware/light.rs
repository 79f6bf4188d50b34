//! Light between pixels, and on the other side of a centre (`default.md`, 5).

use super::{Judge, Plane};

/// A place, column and row.
pub type Place = (f64, f64);

/// The place of a pixel.
pub fn place(at: usize, width: usize) -> Place {
    ((at % width) as f64, (at / width) as f64)
}

/// The place on the other side of a centre.
pub fn opposite(centre: Place, place: Place) -> Place {
    (2.0 * centre.0 - place.0, 2.0 * centre.1 - place.1)
}

/// The light at a place, not below 0; `None` beyond the frame.
pub fn light(image: &Plane, place: Place) -> Option<f64> {
    let inside = |at: f64, length: usize| length >= 2 && at >= 0.0 && at <= (length - 1) as f64;
    let is_seen = inside(place.0, image.width()) && inside(place.1, image.height());
    is_seen.then(|| image.interpolate(place.0, place.1).max(0.0))
}

/// The light on the other side of a centre from a place.
pub fn mirrored(image: &Plane, centre: Place, from: Place) -> Option<f64> {
    light(image, opposite(centre, from))
}

/// The shape of isophotes: of their second moments `(xx - yy, 2 xy)` as parts of `xx + yy`.
pub type Shape = (f64, f64);

/// A circle.
pub const ROUND: Shape = (0.0, 0.0);

/// The seven other places on the ellipse through a place, 45 degrees apart in the circle that it is when stretched.
pub fn turned(centre: Place, (along, across): Shape, from: Place) -> [Place; 7] {
    let (xx, xy, yy) = (1.0 + along, across, 1.0 - along);
    let root = (xx * yy - xy * xy).sqrt();
    // Half of the ellipse's matrix, as a lower triangle: a circle stretched by it is the ellipse.
    let (a, b, c) = ((xx / root).sqrt(), xy / (xx * root).sqrt(), (root / xx).sqrt());
    let (x, y) = (from.0 - centre.0, from.1 - centre.1);
    let (u, v) = (x / a, (y - b * x / a) / c);
    std::array::from_fn(|eighth| {
        let (sin, cos) = ((eighth + 1) as f64 * std::f64::consts::FRAC_PI_4).sin_cos();
        let (u, v) = (u * cos - v * sin, u * sin + v * cos);
        (centre.0 + a * u, centre.1 + b * u + c * v)
    })
}

/// The median of the light at the seven other places as far from a centre, 45 degrees apart.
pub fn around(image: &Plane, centre: Place, from: Place) -> f64 {
    let mut turned = turned(centre, ROUND, from).map(|place| light(image, place).unwrap_or(0.0));
    turned.sort_by(f64::total_cmp);
    turned[3]
}

/// The pixel nearest to a place in the frame.
pub fn nearest(image: &Plane, place: Place) -> Option<usize> {
    light(image, place)?;
    let round = |at: f64| (at - 0.5).ceil() as usize;
    Some(round(place.1) * image.width() + round(place.0))
}

/// The nearest whole part of 256 of a pixel, halves away from 0. The offset is a quotient by `divisor`.
pub fn to_part(offset: f64, divisor: f64, judge: &Judge) -> f64 {
    let below = (256.0 * offset.abs()).floor();
    let border = (below + 0.5) / 256.0;
    let is_below = judge.exceeds_of(0.25 + 0.25 / divisor, border, offset.abs());
    (if is_below { below } else { below + 1.0 } / 256.0).copysign(offset)
}

/// The vertex of the parabolas through a pixel and its neighbours along each axis.
pub fn vertex(image: &Plane, at: usize, judge: &Judge) -> Place {
    let (width, height) = (image.width(), image.height());
    let (x, y) = (at % width, at / width);
    let v = image.around(x as isize, y as isize);
    let off = |before: f64, after: f64, at: usize, length: usize| {
        let bend = 2.0 * v.c - before - after;
        let inner = at > 0 && at + 1 < length && bend > 0.0;
        let off = if inner { to_part((0.5 * (after - before) / bend).clamp(-0.5, 0.5), bend, judge) } else { 0.0 };
        at as f64 + off
    };
    (off(v.w, v.e, x, width), off(v.s, v.n, y, height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::noise_aware::{Slack, nearest};

    #[test]
    fn halves_go_outwards_and_either_way_where_roundings_may_have_moved_them() {
        let exact = |offset: f64| 256.0 * to_part(offset / 256.0, 1.0, &Judge::exact());
        assert_eq!([2.5, -2.5, 2.49, -2.51, 0.0, -0.2].map(exact), [3.0, -3.0, 2.0, -3.0, 0.0, 0.0]);
        let slack = Slack { relative: 0.0, absolute: 1e-6 };
        for offset in [2.5, -2.5, 2.500_01, -2.499_99] {
            for wanted in [2.0, 3.0] {
                let run = |judge: &Judge| 256.0 * to_part(offset / 256.0, 1.0, judge).abs();
                assert_eq!(nearest(slack, run, |part| usize::from(*part != wanted)), wanted, "{offset}");
            }
        }
    }
}
