//! Arrays of any number as planes of single precision, and planes as arrays.

use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use skyfront::planes::room_for;

/// A number of an array.
trait Sample: Element + Copy {
    /// The number with its bytes in the other order.
    fn swapped(self) -> Self;
    /// In single precision, as a FITS file with this number gives it: rounded once, 0 without a sign.
    fn single(self) -> f32;
}

macro_rules! integers {
    ($($type:ty),+) => {$(
        impl Sample for $type {
            fn swapped(self) -> Self {
                self.swap_bytes()
            }
            fn single(self) -> f32 {
                self as f32
            }
        }
    )+};
}
integers!(u8, i8, u16, i16, u32, i32, u64, i64);

impl Sample for f32 {
    fn swapped(self) -> Self {
        f32::from_bits(self.to_bits().swap_bytes())
    }
    fn single(self) -> f32 {
        0.0 + self
    }
}

impl Sample for f64 {
    fn swapped(self) -> Self {
        f64::from_bits(self.to_bits().swap_bytes())
    }
    fn single(self) -> f32 {
        (0.0 + self) as f32
    }
}

/// A plane of numbers, row-major.
pub struct Plane {
    /// The numbers.
    pub values: Vec<f32>,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Plane {
    /// Columns and rows.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }
}

/// An array of two axes, aligned, of one of the types of [`Sample`], in one copy; `swapped` where its
/// bytes are in the other order than this machine's.
///
/// # Errors
/// An array of another type.
pub fn plane(array: &Bound<'_, PyAny>, swapped: bool) -> PyResult<Plane> {
    macro_rules! of {
        ($($type:ty),+) => {$(
            if let Ok(array) = array.cast::<PyArray2<$type>>() {
                return Ok(copied(&array.try_readonly()?.as_array(), swapped));
            }
        )+};
    }
    of!(f32, f64, u8, i8, u16, i16, u32, i32, u64, i64);
    Err(PyTypeError::new_err(format!("{array} is no array of two axes of numbers")))
}

fn copied<T: Sample>(array: &ArrayView2<'_, T>, swapped: bool) -> Plane {
    let (height, width) = array.dim();
    let mut values = room_for(width * height);
    for row in array.rows() {
        match (row.as_slice(), swapped) {
            (Some(row), false) => values.extend(row.iter().map(|&value| value.single())),
            (_, false) => values.extend(row.iter().map(|&value| value.single())),
            (_, true) => values.extend(row.iter().map(|&value| value.swapped().single())),
        }
    }
    Plane { values, width, height }
}

/// What is true in a mask.
pub struct Marked {
    /// Indices, row-major.
    pub places: Vec<usize>,
    /// Columns and rows of the mask.
    pub size: (usize, usize),
}

impl Marked {
    /// The places of a mask.
    ///
    /// # Errors
    /// A mask that is being written to.
    pub fn of(mask: &Bound<'_, PyArray2<bool>>) -> PyResult<Marked> {
        let size = size(mask);
        let mask = mask.try_readonly()?;
        let places = mask.as_array().iter().enumerate().filter_map(|(at, &bad)| bad.then_some(at)).collect();
        Ok(Marked { places, size })
    }
}

/// Numbers as an array of rows of `width`, which takes over their memory.
pub fn rows<T: Element>(py: Python<'_>, values: Vec<T>, width: usize) -> PyResult<Bound<'_, PyArray2<T>>> {
    let height = values.len() / width.max(1);
    PyArray1::from_vec(py, values).reshape([height, width])
}

/// The length of an array's axes, columns first.
pub fn size<T: Element>(array: &Bound<'_, PyArray2<T>>) -> (usize, usize) {
    let [height, width] = *array.shape() else { return (0, 0) };
    (width, height)
}
