//! Where the pixels of the page are on the sky: directions on a grid, between which it interpolates.

use crate::sky::Sky;
use serde_json::{Value, json};

/// Grid points along the longer side. Between two of them, h radians apart, a direction is off by
/// h^3 or so: less than 1e-3 arcsec in a field of one degree, less than a pixel in one of thirty.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::Header;
    use crate::read::header::Card;

    /// A tangential projection with square pixels of so many degrees.
    fn sky(scale: f64, side: usize) -> Sky {
        let centre = side as f64 / 2.0;
        let text = format!(
            "CTYPE1  = 'RA---TAN'\nCTYPE2  = 'DEC--TAN'\nCRVAL1  = 40.0\nCRVAL2  = 60.0\nCRPIX1  = {centre}\n\
             CRPIX2  = {centre}\nCDELT1  = -{scale}\nCDELT2  = {scale}"
        );
        let header = Header::new(text.lines().map(Card::new).collect());
        Sky::of(&header).expect("it is supported").expect("it has coordinates")
    }

    /// As the page does it: how far off between the grid's points, in arcsec.
    fn greatest_error(scale: f64, side: usize) -> f64 {
        let sky = sky(scale, side);
        let grid = places(&sky, side, side);
        let columns = grid["columns"].as_u64().expect("a number") as usize;
        let at = |row: usize, column: usize, axis: usize| {
            grid["directions"][row * columns + column][axis].as_f64().expect("on the sky")
        };
        let mut greatest = 0.0f64;
        for (i, j) in [(0, 0), (31, 31), (columns - 2, 5), (columns - 2, columns - 2)] {
            let middle: Vec<f64> = (0..3)
                .map(|axis| (at(j, i, axis) + at(j, i + 1, axis) + at(j + 1, i, axis) + at(j + 1, i + 1, axis)) / 4.0)
                .collect();
            let along = |index: usize| (index as f64 + 0.5) / (columns - 1) as f64 * side as f64 - 0.5;
            let (ra, dec) = sky.position(along(i), side as f64 - 1.0 - along(j)).expect("on the sky");
            let known = unit_vector((ra, dec));
            let length = middle.iter().map(|x| x * x).sum::<f64>().sqrt();
            let off = middle.iter().zip(known).map(|(x, y)| (x / length - y).powi(2)).sum::<f64>().sqrt();
            greatest = greatest.max(off.to_degrees() * 3600.0);
        }
        greatest
    }

    #[test]
    fn between_the_points_directions_are_as_good_as_a_reader_needs() {
        let degree = greatest_error(1.0 / 3600.0, 3600);
        assert!(degree < 1e-3, "{degree} arcsec in a field of one degree");
        let wide = greatest_error(30.0 / 3600.0, 3600);
        assert!(wide < 30.0, "{wide} arcsec in a field of thirty degrees, less than a pixel");
        println!("{degree} {wide}");
    }

    #[test]
    fn a_long_image_has_fewer_points_across() {
        assert_eq!((points(1000, 100), points(100, 1000), points(1, 1)), (65, 8, 65));
    }
}
