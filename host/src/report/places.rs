//! Where the pixels of the page are on the sky: directions on a grid, between which it interpolates.

use crate::sky::Sky;
use serde_json::{Value, json};

/// Grid points along the longer side. Between two of them, h radians apart, a direction is off by
/// less than h^3: 1e-4 arcsec in a field of one degree, less than a pixel in one of thirty.
const POINTS: usize = 65;

/// Unit vectors towards a grid of positions from the upper left to the lower right corner of an
/// image, row by row; null where the projection does not reach.
pub fn places(sky: &Sky, width: usize, height: usize) -> Value {
    let (columns, rows) = (points(width, height), points(height, width));
    let along = |index: usize, points: usize, length: usize| index as f64 / (points - 1) as f64 * length as f64 - 0.5;
    let direction = |row: usize, column: usize| {
        let y = height as f64 - 1.0 - along(row, rows, height);
        sky.position(along(column, columns, width), y).map(unit_vector)
    };
    let directions: Vec<Value> = (0..rows)
        .flat_map(|row| (0..columns).map(move |column| (row, column)))
        .map(|(row, column)| json!(direction(row, column)))
        .collect();
    json!({ "frame": sky.frame().name(), "columns": columns, "rows": rows, "directions": directions })
}

/// Grid points along a side, by its share of the longer one.
fn points(side: usize, other: usize) -> usize {
    ((POINTS - 1) * side).div_ceil(side.max(other)).max(1) + 1
}

fn unit_vector((ra, dec): (f64, f64)) -> [f64; 3] {
    let ((sin_ra, cos_ra), (sin_dec, cos_dec)) = (ra.to_radians().sin_cos(), dec.to_radians().sin_cos());
    [cos_dec * cos_ra, cos_dec * sin_ra, sin_dec]
}
