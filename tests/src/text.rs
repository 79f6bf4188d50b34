//! Small pictures as text, so that a test can be read: the top line is the last row.

use skyfront_core::arithmetic::F32;
use skyfront_core::config::Connectivity;
use skyfront_core::sources::label::Table;

/// A mask from lines of `#` (inside) and anything else (outside): row-major values of +1 and -1.
pub fn mask(lines: &[&str]) -> (Vec<f32>, usize) {
    let width = lines.first().map_or(0, |line| line.len());
    let value = |byte: u8| if byte == b'#' { 1.0 } else { -1.0 };
    (lines.iter().rev().flat_map(|line| line.bytes().map(value)).collect(), width)
}

/// Labels as text: digits and letters, `.` for background.
pub fn picture(labels: &[u32], width: usize) -> Vec<String> {
    let sign = |&label: &u32| char::from_digit(label % 36, 36).filter(|_| label != 0).unwrap_or('.');
    labels.chunks(width).rev().map(|row| row.iter().map(sign).collect()).collect()
}

/// Labels of the connected components of a front's positive pixels, by the core's five passes.
pub fn label(front: &[f32], width: usize, connectivity: Connectivity, min_area: u32) -> Vec<u32> {
    let mut plane = front.to_vec();
    let mut cells = vec![0.0f32; plane.len()];
    let mut table = Table::new(&mut cells);
    let defined = vec![0.0f32; width];
    let (mut labels, mut numbered) = (0, 0);
    for y in 0..plane.len() / width {
        let (before, row) = plane.split_at_mut(y * width);
        let before = before.get(y.wrapping_sub(1).wrapping_mul(width)..).unwrap_or(&[]);
        let row = &mut row[..width];
        let unlabelled = table.provisional_row::<F32>(row, before, &defined, connectivity, &mut labels);
        assert_eq!(unlabelled, Ok(0));
    }
    (1..=labels).for_each(|label| table.resolve(label).expect("an intact table"));
    plane.chunks_exact_mut(width).for_each(|row| table.count_row(row).expect("an intact table"));
    (1..=labels).for_each(|label| table.number(label, min_area, &mut numbered).expect("an intact table"));
    plane.chunks_exact_mut(width).for_each(|row| table.final_row(row).expect("an intact table"));
    plane.iter().map(|&label| label as u32).collect()
}
