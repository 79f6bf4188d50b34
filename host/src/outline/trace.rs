//! Marching squares on the front, label by label.
//!
//! A walk along the border of a label passes the sides of its pixels one by one, the label on the
//! left hand. Each side lies between a pixel of the label and one outside, and the outline crosses
//! the line between their centres where the front, taken linear there, is zero. Where both sides
//! are positive (two labels that touch, undefined pixels) or the frame ends, it crosses halfway.

use skyfront_core::config::Connectivity;

/// A closed outline. Positions are in pixels, the first pixel's centre at (0, 0).
///
/// ```
/// use skyfront::outline::rings;
/// use skyfront_core::config::Connectivity;
///
/// // The front is above 0 in the middle of 3 x 3 pixels, by as much as the others are below.
/// let labels = [0, 0, 0, 0, 7, 0, 0, 0, 0];
/// let front = labels.map(|label| if label > 0 { 1.0 } else { -1.0 });
/// let rings = rings(&labels, &front, 3, 3, Connectivity::Eight);
/// assert_eq!((rings.len(), rings[0].label, rings[0].hole), (1, 7, false));
/// assert!(rings[0].points.contains(&(1.5, 1.0)));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// The source.
    pub label: u32,
    /// Whether it bounds a hole in the source.
    pub hole: bool,
    /// Its corners: counter-clockwise around a source, clockwise around a hole.
    pub points: Vec<(f64, f64)>,
}

/// A step to a neighbouring pixel.
type Step = (isize, isize);
/// Directions in the order of left turns.
const STEPS: [Step; 4] = [(0, -1), (1, 0), (0, 1), (-1, 0)];

/// A side of a pixel of a label: the pixel, and the direction in which the label ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Side {
    pixel: (isize, isize),
    direction: usize,
}

struct Tracer<'a> {
    labels: &'a [u32],
    front: &'a [f32],
    width: usize,
    height: usize,
    /// Whether pixels that touch at a corner belong together.
    corners: bool,
    /// For every pixel, a bit for each side already passed.
    passed: Vec<u8>,
}

/// The outlines of all labels, by label, those of one label in raster order of their first side.
pub fn rings(labels: &[u32], front: &[f32], width: usize, height: usize, connectivity: Connectivity) -> Vec<Ring> {
    let corners = connectivity == Connectivity::Eight;
    let mut tracer = Tracer { labels, front, width, height, corners, passed: vec![0; width * height] };
    let mut rings = Vec::new();
    for (index, &label) in labels.iter().enumerate() {
        let pixel = ((index % width) as isize, (index / width) as isize);
        // Every ring has a side that faces down.
        let side = Side { pixel, direction: 0 };
        if label != 0 && tracer.passed[index] & 1 == 0 && tracer.label(add(pixel, STEPS[0])) != label {
            rings.push(tracer.ring(label, side));
        }
    }
    rings.sort_by_key(|ring| ring.label);
    rings
}

impl Tracer<'_> {
    fn index(&self, (x, y): (isize, isize)) -> Option<usize> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        (x < self.width && y < self.height).then_some(y * self.width + x)
    }

    fn label(&self, pixel: (isize, isize)) -> u32 {
        self.index(pixel).map_or(0, |index| self.labels[index])
    }

    /// Walks once around from a side.
    fn ring(&mut self, label: u32, start: Side) -> Ring {
        let (mut points, mut turns, mut side) = (Vec::new(), 0, start);
        loop {
            if let Some(index) = self.index(side.pixel) {
                self.passed[index] |= 1 << side.direction;
            }
            points.push(self.crossing(side));
            let (next, turn) = self.next(label, side);
            turns += turn;
            side = next;
            if side == start {
                // Four left turns more than right ones go round a source, four less round a hole.
                return Ring { label, hole: turns < 0, points };
            }
        }
    }

    /// The next side, and the turn that leads to it: 1 left, -1 right.
    fn next(&self, label: u32, Side { pixel, direction }: Side) -> (Side, i32) {
        let (left, right) = ((direction + 1) % 4, (direction + 3) % 4);
        let ahead = add(pixel, STEPS[left]);
        let beyond = add(ahead, STEPS[direction]);
        let (is_ahead, is_beyond) = (self.label(ahead) == label, self.label(beyond) == label);
        if is_beyond && (is_ahead || self.corners) {
            (Side { pixel: beyond, direction: right }, -1)
        } else if is_ahead {
            (Side { pixel: ahead, direction }, 0)
        } else {
            (Side { pixel, direction: left }, 1)
        }
    }

    /// Where the outline crosses the line between the centres on both sides.
    fn crossing(&self, Side { pixel, direction }: Side) -> (f64, f64) {
        let level = |at| self.index(at).map_or(f64::NAN, |index| f64::from(self.front[index]));
        let (inside, outside) = (level(pixel), level(add(pixel, STEPS[direction])));
        let share = if inside > 0.0 && outside <= 0.0 { inside / (inside - outside) } else { 0.5 };
        let (dx, dy) = STEPS[direction];
        (pixel.0 as f64 + share * dx as f64, pixel.1 as f64 + share * dy as f64)
    }
}

fn add((x, y): (isize, isize), (dx, dy): Step) -> (isize, isize) {
    (x + dx, y + dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Labels from a picture, its top line being the last row.
    fn picture(lines: &[&str]) -> (Vec<u32>, usize, usize) {
        let labels = lines.iter().rev().flat_map(|line| line.chars().map(|c| c.to_digit(10).unwrap_or(0)));
        (labels.collect(), lines[0].len(), lines.len())
    }

    fn traced(lines: &[&str], connectivity: Connectivity) -> Vec<Ring> {
        let (labels, width, height) = picture(lines);
        let front: Vec<f32> = labels.iter().map(|&label| if label > 0 { 1.0 } else { -1.0 }).collect();
        rings(&labels, &front, width, height, connectivity)
    }

    fn area(ring: &Ring) -> f64 {
        let next = ring.points.iter().cycle().skip(1);
        0.5 * ring.points.iter().zip(next).map(|(a, b)| a.0 * b.1 - a.1 * b.0).sum::<f64>()
    }

    #[test]
    fn one_pixel_is_a_diamond() {
        let rings = traced(&["...", ".1.", "..."], Connectivity::Eight);
        assert_eq!(rings[0].points, [(1.0, 0.5), (1.5, 1.0), (1.0, 1.5), (0.5, 1.0)]);
        assert_eq!((rings.len(), rings[0].hole), (1, false));
    }

    #[test]
    fn a_hole_is_a_ring_of_its_own() {
        let rings = traced(&[".....", ".111.", ".1.1.", ".111.", "....."], Connectivity::Eight);
        assert_eq!(rings.iter().map(|ring| ring.hole).collect::<Vec<_>>(), [false, true]);
        assert_eq!((area(&rings[0]), area(&rings[1])), (8.5, -0.5));
    }

    #[test]
    fn corners_join_or_part() {
        let lines = ["....", "..1.", ".1..", "...."];
        assert_eq!(traced(&lines, Connectivity::Eight).len(), 1);
        assert_eq!(traced(&lines, Connectivity::Four).len(), 2);
    }

    #[test]
    fn touching_labels_share_their_border() {
        let rings = traced(&["....", ".12.", "...."], Connectivity::Eight);
        assert_eq!(rings.iter().map(|ring| ring.label).collect::<Vec<_>>(), [1, 2]);
        assert!(rings.iter().all(|ring| ring.points.contains(&(1.5, 1.0))));
    }

    #[test]
    fn the_frame_ends_half_a_pixel_outside() {
        let rings = traced(&["1"], Connectivity::Eight);
        assert_eq!(area(&rings[0]), 0.5);
    }

    #[test]
    fn the_zero_level_of_a_cone_is_a_circle() {
        let (side, radius, centre) = (41, 14.3, (20.2, 19.7));
        let distance = |x: f64, y: f64| (x - centre.0).hypot(y - centre.1);
        let front: Vec<f32> =
            (0..side * side).map(|i| (radius - distance((i % side) as f64, (i / side) as f64)) as f32).collect();
        let labels: Vec<u32> = front.iter().map(|&u| u32::from(u > 0.0)).collect();
        let rings = rings(&labels, &front, side, side, Connectivity::Eight);
        assert_eq!(rings.len(), 1);
        // Linear interpolation over one pixel of a circle: an error below 1/(8 r) = 0.009 pixels.
        for &(x, y) in &rings[0].points {
            assert!((distance(x, y) - radius).abs() < 0.009, "{x} {y}");
        }
    }
}
