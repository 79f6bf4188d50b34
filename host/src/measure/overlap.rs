//! The area that a circle and a polygon share, exactly.

/// A point, or a vector.
type Point = (f64, f64);

/// Area of the unit circle around the origin within a polygon whose corners go round
/// counter-clockwise.
///
/// Every edge contributes its triangle with the origin, where outside the circle cut down to a
/// sector; the signs of the angles take care of corners on any side.
pub fn circle_polygon(corners: &[Point]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&from, &to)| edge(from, to)).sum()
}

/// The signed area between the origin and an edge, within the unit circle.
fn edge(from: Point, to: Point) -> f64 {
    let along = (to.0 - from.0, to.1 - from.1);
    // |from + t along|^2 = 1 has its two solutions around the point nearest to the origin.
    let (square, nearest) = (dot(along, along), -dot(from, along));
    let within = nearest * nearest - square * (dot(from, from) - 1.0);
    if within <= 0.0 || square == 0.0 {
        return sector(from, to);
    }
    let half = within.sqrt();
    let (enter, leave) = (((nearest - half) / square).max(0.0), ((nearest + half) / square).min(1.0));
    if enter >= leave {
        return sector(from, to);
    }
    let at = |t: f64| (from.0 + t * along.0, from.1 + t * along.1);
    let (first, last) = (at(enter), at(leave));
    sector(from, first) + 0.5 * cross(first, last) + sector(last, to)
}

/// Signed area of the unit circle between two directions.
fn sector(from: Point, to: Point) -> f64 {
    0.5 * libm::atan2(cross(from, to), dot(from, to))
}

fn dot(a: Point, b: Point) -> f64 {
    a.0 * b.0 + a.1 * b.1
}

fn cross(a: Point, b: Point) -> f64 {
    a.0 * b.1 - a.1 * b.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn square(x: f64, y: f64, side: f64) -> [Point; 4] {
        [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]
    }

    #[test]
    fn known_areas() {
        let near = |area: f64, known: f64| assert!((area - known).abs() < 1e-14, "{area} {known}");
        near(circle_polygon(&square(-5.0, -5.0, 10.0)), PI);
        near(circle_polygon(&square(0.0, 0.0, 5.0)), PI / 4.0);
        near(circle_polygon(&square(-0.1, 0.2, 0.3)), 0.09);
        near(circle_polygon(&square(1.0, 1.0, 2.0)), 0.0);
        // The cap beyond x = 1/2: a third of the circle less a triangle.
        near(circle_polygon(&square(0.5, -2.0, 4.0)), PI / 3.0 - 0.75f64.sqrt() / 2.0);
    }

    #[test]
    fn a_grid_of_squares_makes_up_the_circle() {
        let cell = |i: i32| f64::from(i) * 0.37 - 2.0 + 0.013;
        let total: f64 =
            (0..12).flat_map(|i| (0..12).map(move |j| circle_polygon(&square(cell(i), cell(j), 0.37)))).sum();
        assert!((total - PI).abs() < 1e-12, "{total}");
    }
}
