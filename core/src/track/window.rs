//! A window on the frame: which of its pixels can be used, its sky, and where its star begins.

use super::{Camera, EDGE, SIDES};
use crate::error::Error;
use crate::plane::raster::{BadPixel, Pixel, Raster};

/// Where a star is expected, and how far around to look.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Predicted column of the star, pixels.
    pub x: f32,
    /// Predicted row of the star, pixels.
    pub y: f32,
    /// Columns, 8 to 64.
    pub width: u16,
    /// Rows, 8 to 64.
    pub height: u16,
}

impl Window {
    /// Checks size and place.
    pub(crate) fn validate(&self) -> Result<(), Error> {
        for (name, side) in [("window width", self.width), ("window height", self.height)] {
            let (value, (least, most)) = (f32::from(side), SIDES);
            if side < least {
                return Err(Error::Parameter { name, value, bound: "at least", limit: f32::from(least) });
            }
            if side > most {
                return Err(Error::Parameter { name, value, bound: "at most", limit: f32::from(most) });
            }
        }
        for (name, value) in [("predicted column", self.x), ("predicted row", self.y)] {
            // Also false for what is no number.
            if !(-1e6..=1e6).contains(&value) {
                return Err(Error::Parameter { name, value, bound: "within 10^6 of", limit: 0.0 });
            }
        }
        Ok(())
    }

    /// Its part in a frame: the first column and how many there are, and the same of rows.
    pub(crate) fn within<P>(&self, frame: &Raster<'_, P>) -> ((usize, usize), (usize, usize)) {
        (clip(self.x, self.width, frame.width), clip(self.y, self.height, frame.height))
    }
}

/// Pixels of the border of the greatest window.
const BORDER: usize = 4 * (SIDES.1 as usize - 1);

/// A level with the number of pixels that told it.
#[derive(Clone, Copy, Debug)]
pub struct Border {
    /// The whole part of the median, counts.
    pub base: u16,
    /// What the median is above that, -0.5 to 0.5.
    pub rest: f32,
    /// Pixels.
    pub pixels: u32,
}

/// The part of a window that lies in the frame.
#[derive(Debug)]
pub struct View<'a, P> {
    frame: Raster<'a, P>,
    /// First column and row in the frame.
    pub origin: (usize, usize),
    /// Columns and rows, 3 to 64 each.
    pub size: (usize, usize),
    whole: bool,
    /// One bit for each pixel that is not to be used, a word for each row.
    left_out: [u64; SIDES.1 as usize],
}

/// The columns or rows of a window along an axis of the frame.
fn clip(place: f32, side: u16, length: usize) -> (usize, usize) {
    let first = libm::floorf(place - f32::from(side.saturating_sub(1)) * 0.5 + 0.5) as i32;
    let end = first.saturating_add(i32::from(side)).clamp(0, i32::try_from(length).unwrap_or(i32::MAX));
    let first = first.clamp(0, end);
    (first as usize, end.saturating_sub(first) as usize)
}

/// The bit of a column.
fn bit(x: usize) -> u64 {
    1u64.wrapping_shl(x as u32)
}

/// The light of the brightest 3 x 3 pixels of three rows and their middle column; `value` takes a pixel, its
/// column, and which of the rows it is in.
#[inline(always)]
fn brightest_of<P: Pixel>([below, row, above]: [&[P]; 3], value: impl Fn(&P, usize, usize) -> u32) -> (u32, usize) {
    let (mut most, mut place, mut last) = (0, 1, (0u32, 0u32));
    for (x, ((below, pixel), above)) in below.iter().zip(row).zip(above).enumerate() {
        let column = value(below, x, 0).wrapping_add(value(pixel, x, 1)).wrapping_add(value(above, x, 2));
        let light = last.0.wrapping_add(last.1).wrapping_add(column);
        if light > most && x >= 2 {
            (most, place) = (light, x.wrapping_sub(1));
        }
        last = (last.1, column);
    }
    (most, place)
}

/// Columns and rows of a view, the last ones included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rectangle {
    /// First and last column.
    pub columns: (usize, usize),
    /// First and last row.
    pub rows: (usize, usize),
}

impl Rectangle {
    /// No pixel.
    pub const NONE: Rectangle = Rectangle { columns: (1, 0), rows: (1, 0) };

    fn has(&self, x: usize, y: usize) -> bool {
        x >= self.columns.0 && x <= self.columns.1 && y >= self.rows.0 && y <= self.rows.1
    }
}

impl<'a, P: Pixel> View<'a, P> {
    /// The window; nothing where fewer than three columns or rows of it are in the frame.
    pub fn new(frame: &Raster<'a, P>, window: &Window, camera: &Camera, bad: &[BadPixel]) -> Option<View<'a, P>> {
        let ((x, columns), (y, rows)) = window.within(frame);
        if columns < 3 || rows < 3 {
            return None;
        }
        let none = [0; SIDES.1 as usize];
        let whole = columns == usize::from(window.width) && rows == usize::from(window.height);
        let mut view = View { frame: *frame, origin: (x, y), size: (columns, rows), whole, left_out: none };
        view.leave_out(bad);
        view.leave_out_from(camera.full());
        Some(view)
    }

    /// [`EDGE`], if the window is cut off.
    pub fn cut(&self) -> u32 {
        if self.whole { 0 } else { EDGE }
    }

    fn leave_out(&mut self, bad: &[BadPixel]) {
        for pixel in bad {
            let x = usize::from(pixel.x).wrapping_sub(self.origin.0);
            let y = usize::from(pixel.y).wrapping_sub(self.origin.1);
            if x < self.size.0 {
                self.mark(x, y);
            }
        }
    }

    /// Leaves out what has this value or more.
    fn leave_out_from(&mut self, full: u32) {
        for y in 0..self.size.1 {
            for (x, pixel) in self.row(y).iter().enumerate() {
                if u32::from(pixel.count()) >= full {
                    self.mark(x, y);
                }
            }
        }
    }

    /// Leaves a pixel out.
    fn mark(&mut self, x: usize, y: usize) {
        if let Some(word) = self.left_out.get_mut(y) {
            *word |= bit(x);
        }
    }

    /// The pixels of a row.
    #[inline(always)]
    pub fn row(&self, y: usize) -> &'a [P] {
        let x = self.origin.0;
        self.frame.part(self.origin.1.saturating_add(y), x..x.saturating_add(self.size.0))
    }

    /// Which pixels of a row are left out.
    #[inline(always)]
    pub fn out_of(&self, y: usize) -> u64 {
        self.left_out.get(y).copied().unwrap_or(u64::MAX)
    }

    /// The value of a pixel that is to be used.
    fn at(&self, x: usize, y: usize) -> Option<u16> {
        if self.out_of(y) & bit(x) == 0 { self.row(y).get(x).map(|pixel| pixel.count()) } else { None }
    }

    /// The pixels of the border that are to be used and lie outside the rectangle, and how many they are.
    fn border(&self, inside: &Rectangle) -> ([u16; BORDER], usize) {
        let (columns, rows) = self.size;
        let (last_x, last_y) = (columns.saturating_sub(1), rows.saturating_sub(1));
        let (mut values, mut count) = ([0; BORDER], 0usize);
        for y in 0..rows {
            let step = if y == 0 || y == last_y { 1 } else { last_x.max(1) };
            for x in (0..columns).step_by(step) {
                if !inside.has(x, y)
                    && let (Some(value), Some(to)) = (self.at(x, y), values.get_mut(count))
                {
                    *to = value;
                    count = count.saturating_add(1);
                }
            }
        }
        (values, count)
    }

    /// Whether a rectangle has pixels of the border.
    pub fn at_border(&self, inside: &Rectangle) -> bool {
        let last = |length: usize| length.saturating_sub(1);
        let along = |(first, end): (usize, usize), length| first == 0 || end >= last(length);
        along(inside.columns, self.size.0) || along(inside.rows, self.size.1)
    }

    /// The median of the border outside a rectangle, as if equal counts were spread evenly over the width of a count.
    pub fn sky(&self, inside: &Rectangle) -> Option<Border> {
        let (values, count) = self.border(inside);
        let values = values.get(..count)?;
        let pixels = count as u32;
        let below = |value: u16| values.iter().fold(0u32, |sum, &pixel| sum.wrapping_add(u32::from(pixel < value)));
        // The greatest value with at most half of the pixels below it, bit by bit.
        let highest = values.iter().fold(0, |all, value| all | value);
        let mut base = 0u16;
        for place in (0..16u32.saturating_sub(highest.leading_zeros())).rev() {
            let higher = base | 1u16.wrapping_shl(place);
            if below(higher).saturating_mul(2) <= pixels {
                base = higher;
            }
        }
        if pixels == 0 {
            return None;
        }
        let equal = values.iter().filter(|&&pixel| pixel == base).count();
        let part = (pixels as f32 * 0.5 - below(base) as f32) / equal.max(1) as f32;
        // Between two counts that share the middle: at the upper end of the lower one.
        let rest = if part < 1.0 { part - 0.5 } else { 0.5 };
        Some(Border { base, rest, pixels })
    }

    /// Leaves out pixels that stand above `level` alone: no star's neighbours on both axes are so dark.
    /// `slope` is the least mean of the four neighbours in units of the pixel, both above the base.
    pub fn leave_out_spikes(&mut self, base: u16, level: u16, slope: f32) {
        for y in 0..self.size.1 {
            for (x, pixel) in self.row(y).iter().enumerate() {
                if pixel.count() > level && self.is_spike(x, y, base, level, slope) {
                    self.mark(x, y);
                }
            }
        }
    }

    fn is_spike(&self, x: usize, y: usize, base: u16, level: u16, slope: f32) -> bool {
        let around =
            [(x.wrapping_sub(1), y), (x.saturating_add(1), y), (x, y.wrapping_sub(1)), (x, y.saturating_add(1))];
        let (mut sum, mut count) = (0i32, 0i32);
        for value in around.into_iter().filter_map(|(x, y)| if x < self.size.0 { self.at(x, y) } else { None }) {
            sum = sum.saturating_add(i32::from(value).saturating_sub(i32::from(base)));
            count = count.saturating_add(1);
        }
        let Some(own) = self.at(x, y) else { return false };
        let height = i32::from(own).saturating_sub(i32::from(base));
        // Four neighbours and the pixel may be off by three and a half deviations together: eight of a pixel, as the
        // level is.
        let noise = f32::from(level.saturating_sub(base));
        count >= 3 && sum as f32 + noise < slope * height as f32 * count as f32
    }

    /// The column and row in whose 3 x 3 pixels most light is, the first of several; pixels left out count
    /// as `base`. Not on the border.
    pub fn brightest(&self, base: u16) -> (usize, usize) {
        let (mut most, mut place) = (0, (1, 1));
        for y in 1..self.size.1.saturating_sub(1) {
            let rows = [y.wrapping_sub(1), y, y.saturating_add(1)];
            let out = rows.map(|y| self.out_of(y));
            let of_row = rows.map(|y| self.row(y));
            let (light, x) = match out {
                [0, 0, 0] => brightest_of(of_row, |pixel, _, _| u32::from(pixel.count())),
                _ => brightest_of(of_row, |pixel, x, row| {
                    let left_out = out.get(row).is_some_and(|out| out & bit(x) != 0);
                    u32::from(if left_out { base } else { pixel.count() })
                }),
            };
            if light > most {
                (most, place) = (light, (x, y));
            }
        }
        place
    }

    /// The greatest value of 3 x 3 pixels, `base` where all are left out.
    pub fn peak(&self, (x, y): (usize, usize), base: u16) -> u16 {
        let across = |x: usize| x.saturating_sub(1)..x.saturating_add(2);
        across(y).flat_map(|y| across(x).map(move |x| (x, y))).filter_map(|(x, y)| self.at(x, y)).fold(base, u16::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: Camera = Camera { black: 0.0, gain: 1.0, read_noise: 1.0, saturation: 1000.0, psf_sigma: 1.0 };

    #[test]
    fn windows_are_centred_and_end_with_the_frame() {
        assert_eq!(
            [clip(10.2, 8, 20), clip(10.6, 8, 20), clip(10.0, 9, 20), clip(10.4, 9, 20)],
            [(7, 8), (7, 8), (6, 9), (6, 9)]
        );
        assert_eq!(
            [clip(1.0, 8, 20), clip(18.0, 9, 20), clip(-99.0, 8, 20), clip(99.0, 8, 20)],
            [(0, 6), (14, 6), (0, 0), (20, 0)]
        );
    }

    /// Looks at a window of 8 x 8 pixels that is all of its frame.
    fn look<T>(pixels: [u16; 64], bad: &[BadPixel], look: impl FnOnce(&mut View<'_, u16>) -> T) -> T {
        let frame = Raster::new(&pixels, 8, 8, 8).expect("a frame");
        let window = Window { x: 3.5, y: 3.5, width: 8, height: 8 };
        look(&mut View::new(&frame, &window, &CAMERA, bad).expect("a view"))
    }

    /// A border of so many 9s, 10s and then 12s around light.
    fn border(nines: usize, tens: usize) -> [u16; 64] {
        let mut counts =
            core::iter::repeat_n(9, nines).chain(core::iter::repeat_n(10, tens)).chain(core::iter::repeat(12));
        core::array::from_fn(|at| {
            let at_border = [0, 7].contains(&(at % 8)) || [0, 7].contains(&(at / 8));
            if at_border { counts.next().unwrap_or(0) } else { 500 }
        })
    }

    #[test]
    fn the_sky_is_the_median_of_the_border_within_a_count() {
        // Of 28 pixels the middle is behind 14: behind 7 or 11 of 14 equal ones.
        for (nines, rest) in [(7, 0.0), (3, 11.0 / 14.0 - 0.5), (14, -0.5)] {
            let sky = look(border(nines, 14), &[], |view| view.sky(&Rectangle::NONE)).expect("a border");
            assert!((sky.base, sky.pixels) == (10, 28) && (sky.rest - rest).abs() < 1e-6, "{sky:?}");
        }
        // Below the third row, and without a pixel that is bad, a 10 and fourteen 12s are left.
        let (inside, bad) = (Rectangle { columns: (0, 7), rows: (0, 2) }, [BadPixel { x: 0, y: 3 }]);
        let sky = look(border(8, 6), &bad, |view| view.sky(&inside)).expect("a border");
        assert_eq!((sky.base, sky.pixels), (12, 15));
    }

    #[test]
    fn rectangles_at_the_border_are_told() {
        let at_border = |columns, rows| look([0; 64], &[], |view| view.at_border(&Rectangle { columns, rows }));
        assert!(!at_border((1, 6), (1, 6)));
        assert!(
            at_border((0, 6), (1, 6))
                && at_border((1, 7), (1, 6))
                && at_border((1, 6), (0, 6))
                && at_border((1, 6), (1, 7))
        );
    }

    #[test]
    fn the_brightest_nine_pixels_are_found_without_those_left_out() {
        let mut pixels = [10; 64];
        for (at, value) in [(2 * 8 + 5, 60), (3 * 8 + 5, 90), (3 * 8 + 4, 50), (5 * 8 + 2, 1000)] {
            pixels[at] = value;
        }
        // The last one is saturated.
        assert_eq!(look(pixels, &[], |view| (view.brightest(10), view.peak((2, 5), 10))), ((4, 2), 10));
        let bad = [BadPixel { x: 5, y: 3 }];
        assert_eq!(look(pixels, &bad, |view| (view.brightest(10), view.peak((4, 2), 10))), ((4, 2), 60));
        assert_eq!(look([0; 64], &[], |view| view.brightest(10)), (1, 1));
    }

    #[test]
    fn spikes_stand_alone_above_their_level() {
        let mut pixels = [10; 64];
        for (at, value) in [(3 * 8 + 3, 210), (0, 210), (6 * 8 + 5, 60), (5 * 8 + 5, 60), (6 * 8 + 6, 60), (2, 20)] {
            pixels[at] = value;
        }
        look(pixels, &[], |view| {
            view.leave_out_spikes(10, 25, 0.3);
            // In a corner two neighbours are too few to tell.
            let left_out = |x: usize, y: usize| view.at(x, y).is_none();
            assert!(left_out(3, 3) && !left_out(0, 0) && !left_out(5, 6) && !left_out(5, 5) && !left_out(2, 0));
            assert_eq!((0..8).map(|y| view.out_of(y).count_ones()).sum::<u32>(), 1);
        });
        // Four neighbours with 0.3 of the light in the mean are enough, 15 in all for the noise.
        for (beside, spike) in [(66, true), (67, false)] {
            let mut pixels = [10; 64];
            for at in [3 * 8 + 2, 3 * 8 + 4, 2 * 8 + 3, 4 * 8 + 3] {
                pixels[at] = beside;
            }
            pixels[3 * 8 + 3] = 210;
            assert_eq!(look(pixels, &[], |view| view.is_spike(3, 3, 10, 25, 0.3)), spike, "{beside}");
        }
    }

    #[test]
    fn windows_and_places_have_bounds() {
        let valid = |x: f32, side: u16| Window { x, y: 0.0, width: side, height: 8 }.validate().is_ok();
        assert!(
            valid(-1e6, 8)
                && valid(1e6, 64)
                && !valid(1.1e6, 8)
                && !valid(f32::NAN, 8)
                && !valid(0.0, 7)
                && !valid(0.0, 65)
        );
        assert!(Window { x: 0.0, y: 2e6, width: 8, height: 8 }.validate().is_err());
        assert!(Window { x: 0.0, y: 0.0, width: 8, height: 7 }.validate().is_err());
    }
}
