//! The rows of a plane.

/// Row `y` of a row-major plane; empty beyond its end.
#[inline]
pub fn row_of<T>(plane: &[T], width: usize, y: usize) -> &[T] {
    let start = y.saturating_mul(width);
    plane.get(start..start.saturating_add(width)).unwrap_or(&[])
}

/// Row `y` of a row-major plane, to write to; empty beyond its end.
#[inline]
pub fn row_of_mut<T>(plane: &mut [T], width: usize, y: usize) -> &mut [T] {
    let start = y.saturating_mul(width);
    plane.get_mut(start..start.saturating_add(width)).unwrap_or(&mut [])
}
