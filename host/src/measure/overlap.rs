//! The area that a circle and a polygon share, exactly.

/// A point, or a vector.
type Point = (f64, f64);

/// Area of the unit circle around the origin within a convex quadrilateral whose corners go round
/// counter-clockwise.
///
/// Every edge contributes its triangle with the origin, where outside the circle cut down to a
/// sector. Seen from outside, the sectors together span less than half a turn: as directions they
/// are multiplied, and one arc tangent gives their angle.
pub fn circle_polygon(corners: &[Point; 4]) -> f64 {
    let &[a, b, c, d] = corners;
    let edges = [(a, b), (b, c), (c, d), (d, a)];
    if edges.iter().all(|&(from, to)| cross(from, to) >= 0.0) {
        let one = |edge: Edge| edge.triangle + edge.turns.map(angle).iter().sum::<f64>();
        return 0.5 * edges.iter().map(|&(from, to)| one(Edge::of(from, to))).sum::<f64>();
    }
    let (mut triangles, mut turn) = (0.0, AHEAD);
    for (from, to) in edges {
        let edge = Edge::of(from, to);
        triangles += edge.triangle;
        for part in edge.turns {
            turn = if part == AHEAD { turn } else { product(turn, part) };
        }
    }
    0.5 * (triangles + if turn == AHEAD { 0.0 } else { angle(turn) })
}

/// No turn at all.
const AHEAD: Point = (1.0, 0.0);

/// What an edge contributes, doubled: an area, and the sectors before and behind it by their turn.
struct Edge {
    triangle: f64,
    turns: [Point; 2],
}

impl Edge {
    #[inline(always)]
    fn of(from: Point, to: Point) -> Edge {
        if dot(from, from) <= 1.0 && dot(to, to) <= 1.0 {
            return Edge { triangle: cross(from, to), turns: [AHEAD; 2] };
        }
        let outside = Edge { triangle: 0.0, turns: [turn(from, to), AHEAD] };
        let along = (to.0 - from.0, to.1 - from.1);
        // |from + t along|^2 = 1 has its two solutions around the point nearest to the origin.
        let (square, nearest) = (dot(along, along), -dot(from, along));
        let within = nearest * nearest - square * (dot(from, from) - 1.0);
        if within <= 0.0 || square == 0.0 {
            return outside;
        }
        let half = within.sqrt();
        let (enter, leave) = ((nearest - half) / square, (nearest + half) / square);
        if enter.max(0.0) >= leave.min(1.0) {
            return outside;
        }
        let at = |t: f64| (from.0 + t * along.0, from.1 + t * along.1);
        let (first, before) = if enter > 0.0 { (at(enter), turn(from, at(enter))) } else { (from, AHEAD) };
        let (last, behind) = if leave < 1.0 { (at(leave), turn(at(leave), to)) } else { (to, AHEAD) };
        Edge { triangle: cross(first, last), turns: [before, behind] }
    }
}

/// The turn from one direction to another, as a complex number of any length.
fn turn(from: Point, to: Point) -> Point {
    (dot(from, to), cross(from, to))
}

fn angle(turn: Point) -> f64 {
    if turn == AHEAD { 0.0 } else { libm::atan2(turn.1, turn.0) }
}

fn product(a: Point, b: Point) -> Point {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
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
