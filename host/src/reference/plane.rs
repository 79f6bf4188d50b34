//! A whole image of f64 in memory.

/// W x H values, row-major, row 0 first. Outside, the nearest edge pixel answers: the homogeneous Neumann condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    values: Vec<f64>,
    width: usize,
    height: usize,
}

impl Plane {
    /// The plane whose pixel in column i and row j is `value(i, j)`.
    pub fn from_fn(width: usize, height: usize, mut value: impl FnMut(isize, isize) -> f64) -> Plane {
        let mut values = Vec::with_capacity(width * height);
        for j in 0..height {
            for i in 0..width {
                values.push(value(i as isize, j as isize));
            }
        }
        Plane { values, width, height }
    }

    /// The plane with `f` of every value.
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Plane {
        Plane::from_fn(self.width, self.height, |i, j| f(self.at(i, j)))
    }

    /// Gives the node in column i and row j, which is in the plane, another value.
    pub(super) fn set(&mut self, i: isize, j: isize, value: f64) {
        let at = self.row(j) + self.column(i);
        self.values[at] = value;
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All values, row-major.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The value in column i and row j, or that of the nearest pixel.
    #[inline]
    pub fn at(&self, i: isize, j: isize) -> f64 {
        self.values[self.row(j) + self.column(i)]
    }

    /// The value in column i and row j and those of its eight neighbours.
    #[inline]
    pub fn around(&self, i: isize, j: isize) -> Around {
        let (west, centre, east) = (self.column(i - 1), self.column(i), self.column(i + 1));
        let three = |row: usize| {
            let row = &self.values[row..row + self.width];
            (row[west], row[centre], row[east])
        };
        let (nw, n, ne) = three(self.row(j + 1));
        let (w, c, e) = three(self.row(j));
        let (sw, s, se) = three(self.row(j - 1));
        Around { nw, n, ne, w, c, e, sw, s, se }
    }

    /// The bilinear interpolant I\[V\] at column x and row y, in pixels.
    #[inline]
    pub fn interpolate(&self, x: f64, y: f64) -> f64 {
        let (i, j) = (floor(x), floor(y));
        let (s, t) = (x - i as f64, y - j as f64);
        let (west, east) = (self.column(i), self.column(i + 1));
        let (south, north) = (self.row(j), self.row(j + 1));
        (1.0 - t) * ((1.0 - s) * self.values[south + west] + s * self.values[south + east])
            + t * ((1.0 - s) * self.values[north + west] + s * self.values[north + east])
    }

    /// The nearest column of the image.
    fn column(&self, i: isize) -> usize {
        i.clamp(0, self.width as isize - 1) as usize
    }

    /// Where the nearest row of the image starts.
    fn row(&self, j: isize) -> usize {
        j.clamp(0, self.height as isize - 1) as usize * self.width
    }
}

/// The largest whole number up to x; `f64::floor` is a function call on many processors.
#[inline]
fn floor(x: f64) -> isize {
    let towards_zero = x as isize;
    towards_zero - isize::from(towards_zero as f64 > x)
}

/// A value and its neighbours: east is the next column, north the next row.
#[derive(Clone, Copy, Debug)]
pub struct Around {
    /// North-west.
    pub nw: f64,
    /// North.
    pub n: f64,
    /// North-east.
    pub ne: f64,
    /// West.
    pub w: f64,
    /// The centre.
    pub c: f64,
    /// East.
    pub e: f64,
    /// South-west.
    pub sw: f64,
    /// South.
    pub s: f64,
    /// South-east.
    pub se: f64,
}
