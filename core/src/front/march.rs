//! Arrival times in one pass: `g |grad T| = 1`, the stationary form of the first-order equation.
//!
//! Where g does not change with time, the front is at a pixel at most once, and the time T of its
//! arrival is smaller at the neighbours it came from: pixels can be settled in the order of T
//! (fast marching, doi:10.1073/pnas.93.4.1591), here through a ring of buckets in place of a heap
//! (doi:10.1016/j.jcp.2005.08.005). Times are in pixels of free motion: T `dx` is the paper's t.
//!
//! No memory beside the front plane is needed. A cell holds a time, or the next pixel of its
//! bucket's list, or nothing yet. A pixel lies in one list at a time, under a time at which it can
//! arrive at the earliest, given that all pixels without a time arrive later than now. When that
//! bucket's turn comes, the pixel's time is computed: it is settled if it falls into the bucket,
//! else it moves to a later one. So a time is never changed, only found.
//!
//! The first list is chosen with care, for a look costs more than the choice: a neighbour that has
//! no time comes 1 / sqrt 2 after all that is settled around it, not just later than now. A front
//! along an axis so looks at each pixel once.
//!
//! Within a bucket of [`WIDTH`] pixels of time the order is that of the lists, fixed but not
//! sorted, and a pixel is settled when its time is known to `WIDTH^2`: next to its neighbours'
//! times it comes out too late by at most `2 WIDTH^2`, 1/32 of a pixel.
//!
//! How often a pixel is looked at before it is settled has a bound, [`looks`]. `end` is the end of
//! the bucket at work, d the pixel's delay, at least 1, h the least time around it.
//!
//! - h >= end: the pixel moves on by at least d / sqrt 2. Settled times are less than `AHEAD`
//!   beyond `end`, so that h is reached after 3 looks; later the least time only falls.
//! - h < end and the other axis is open: the pixel waits until it could come with the other axis at
//!   `end`. If `x d` is left until `h + d` was certain, then `x^2 d / 2` is left at the next look:
//!   d, 0.3 d, 0.05 d, 1e-3 d, 5e-7 d, nothing. That is 6 looks, and again for each of the other 3
//!   neighbours that makes h smaller.
//! - h < end and both axes are known, or one counts for nothing: the time is exact, and the pixel
//!   is settled at the next look, unless one of the other 3 neighbours makes it smaller.
//! - A pixel that is to wait longer than the ring is long is looked at once a round.
//!
//! 3 + 4 * 6 + 4 looks, and one for a rounding that puts a pixel one bucket too early.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::{Arithmetic, Bits, Real};
use crate::front::settle::FLOOR;

/// Time that a bucket spans, in pixels of free motion.
pub const WIDTH: f32 = 0.125;
/// A time is settled when no neighbour can make it earlier by more than this.
const SLACK: f32 = WIDTH * WIDTH;
/// Buckets of the ring: pixels that arrive later than all of them wait in the last one.
const BUCKETS: u32 = 64;
/// Added to all times, which may be negative at the start: their sign tells them from links.
const OFFSET: f32 = 2.0;
/// The sign bit: the cell holds a link to the next pixel of a list.
const LINK: u32 = 1 << 31;
/// The link of the last pixel of a list.
const END: u32 = 0x7F00_0000;
/// The time of a pixel that is in no list yet.
const FAR: f32 = f32::MAX;

/// No pixel comes earlier than this after all of its neighbours, for none is crossed in less than a
/// pixel of time: 1 / sqrt 2, less what roundings take.
const CORNER: f32 = 0.707;
/// A pixel is settled at most so long before its time, in pixels of free motion.
const AHEAD: f32 = 2.0;
/// Looks at a pixel, without those of whole rounds of the ring.
const LOOKS: u32 = 32;

/// The most often that a march to `t_max` looks at a pixel, whatever the image: 95 times for the
/// paper's 500 pixels of free motion.
pub fn looks(t_max: f32) -> u32 {
    LOOKS + March::new(t_max).last_bucket / (BUCKETS - 1)
}

/// A front that takes longer over a pixel counts as resting there.
const AT_REST: f32 = 10.0;
/// Longer than any run, which takes at most 100 000 steps of a pixel.
const NEVER: f32 = 1e6;

/// The lists, and how far the time is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct March {
    heads: [u32; BUCKETS as usize],
    /// The next pixel of the bucket at work.
    next: u32,
    bucket: u32,
    last_bucket: u32,
    /// The greatest time that was settled.
    latest: f32,
    /// The front was still on its way to a pixel when time was up.
    cut: bool,
}

/// The two planes of a march.
struct Planes<'a, A: Arithmetic> {
    front: &'a mut [A::Cell],
    speed: &'a [A::Cell],
    width: u32,
}

/// The pixels to the left and right, below and above. Beyond the frame's edge stands the one on the
/// other side, which changes nothing: of two neighbours on an axis the earlier one counts.
type Neighbours = [[u32; 2]; 2];
/// The bits of their cells.
type Around = [[u32; 2]; 2];

/// What is known along an axis: the least settled time, and whether a pixel that is not settled yet
/// lies on it.
#[derive(Clone, Copy)]
struct Axis {
    known: f32,
    open: bool,
}

impl Axis {
    /// From the bits of the two cells: settled times are positive, and as whole numbers smaller
    /// than those of all other cells.
    #[inline(always)]
    fn of([one, other]: [u32; 2]) -> Axis {
        let (least, most) = if one < other { (one, other) } else { (other, one) };
        let open = most >= FAR.to_bits();
        Axis { known: f32::from_bits(least.min(FAR.to_bits())), open }
    }

    /// The least time that may come of it, where what is not settled comes at `end` or later.
    #[inline(always)]
    fn soonest(self, end: f32) -> f32 {
        if self.open && end < self.known { end } else { self.known }
    }
}

impl<A: Arithmetic> Planes<'_, A> {
    #[inline(always)]
    fn bits(&self, pixel: u32) -> u32 {
        self.front.get(pixel as usize).map_or(0, |cell| cell.bits())
    }

    /// A time before which a pixel does not come, `now` at the earliest where it has none yet.
    /// `step` before it lies a pixel in no list; on its other axis the neighbours lie at `across`.
    #[inline(always)]
    fn soonest(&self, pixel: u32, step: u32, across: u32, now: f32) -> f32 {
        let own = self.bits_or_far(pixel);
        if own < FAR.to_bits() {
            return f32::from_bits(own);
        }
        // In no list: it has no settled neighbour.
        if own == FAR.to_bits() {
            return now + CORNER;
        }
        // What lies beyond the frame's edge, or at its other side, makes it no later.
        let around = [step, across, across.wrapping_neg()].map(|step| self.bits_or_far(pixel.wrapping_add(step)));
        let soonest = f32::from_bits(around.into_iter().fold(now.to_bits(), u32::min)) + CORNER;
        if soonest > now { soonest } else { now }
    }

    #[inline(always)]
    fn bits_or_far(&self, pixel: u32) -> u32 {
        self.front.get(pixel as usize).map_or(FAR.to_bits(), |cell| cell.bits())
    }

    #[inline(always)]
    fn around(&self, neighbours: &Neighbours) -> Around {
        neighbours.map(|pair| pair.map(|neighbour| self.bits(neighbour)))
    }

    /// Reads around a pixel that will soon be looked at, so that its memory is at hand by then.
    #[inline(always)]
    fn fetch(&self, pixel: u32) {
        let [here, below, above] =
            [pixel, pixel.wrapping_sub(self.width), pixel.wrapping_add(self.width)].map(|cell| self.bits(cell));
        let speed = self.speed.get(pixel as usize).map_or(0, |cell| cell.bits());
        core::hint::black_box(here ^ below ^ above ^ speed);
    }

    #[inline(always)]
    fn set(&mut self, pixel: u32, bits: u32) {
        if let Some(cell) = self.front.get_mut(pixel as usize) {
            *cell = A::Cell::from_bits(bits);
        }
    }

    /// Pixels of time that it takes to cross the pixel, [`NEVER`] at most.
    #[inline(always)]
    fn delay(&self, pixel: u32) -> f32 {
        let g = self.speed.get(pixel as usize).map_or(0.0, |&cell| A::pixel(cell).to_f32());
        if g * NEVER > 1.0 { 1.0 / g } else { NEVER }
    }

    #[inline(always)]
    fn neighbours(&self, pixel: u32) -> Neighbours {
        let (width, cells) = (self.width, self.front.len() as u32);
        let column = pixel % width.max(1);
        let (left, right) = (pixel.wrapping_sub(1), pixel.wrapping_add(1));
        let (below, above) = (pixel.wrapping_sub(width), pixel.wrapping_add(width));
        [
            [if column == 0 { right } else { left }, if column + 1 == width { left } else { right }],
            [if pixel < width { above } else { below }, if above >= cells { below } else { above }],
        ]
    }
}

/// The time at a pixel from the times `h` and `v` along the two axes: the larger root of
/// `(T-h)^2 + (T-v)^2 = delay^2`, or from one axis alone where the other is too late to matter.
#[inline(always)]
fn arrival<A: Arithmetic>(h: f32, v: f32, delay: f32) -> f32 {
    let (first, second) = if h < v { (h, v) } else { (v, h) };
    let lag = second - first;
    if lag < delay { 0.5 * ((first + second) + A::root(2.0 * delay * delay - lag * lag)) } else { first + delay }
}

impl March {
    /// The list of fields, out or in; the last bucket is the configuration's.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        self.heads.iter_mut().try_for_each(|head| codec.word(head))?;
        codec.word(&mut self.next)?;
        codec.word(&mut self.bucket)?;
        codec.real(&mut self.latest)?;
        let mut cut = u32::from(self.cut);
        codec.word(&mut cut)?;
        self.cut = cut != 0;
        Ok(())
    }

    /// Whether a march to `t_max` over so many pixels can be in this state.
    pub(crate) fn is_sound(&self, t_max: f32, pixels: usize) -> bool {
        let known = |&link: &u32| link == END || (link as usize) < pixels;
        self.heads.iter().all(known)
            && known(&self.next)
            && self.bucket <= self.last_bucket
            && self.latest.is_finite()
            && self.last_bucket == March::new(t_max).last_bucket
    }

    /// A march up to the time `t_max`, in pixels of free motion.
    pub fn new(t_max: f32) -> March {
        let last_bucket = ((t_max + OFFSET) / WIDTH) as u32;
        March { heads: [END; BUCKETS as usize], next: END, bucket: 0, last_bucket, latest: 0.0, cut: false }
    }

    /// Turns a row of `u0`, in pixels, into times: pixels outside the front have theirs.
    pub fn seed_row<A: Arithmetic>(row: &mut [A::Cell]) {
        for cell in row {
            let u = A::level(*cell).to_f32();
            let time = if u > 0.0 { FAR } else { (if u < -FLOOR { -FLOOR } else { u }) + OFFSET };
            *cell = A::Cell::from_bits(time.to_bits());
        }
    }

    /// Puts the pixels beside the settled ones of row `y` into the lists.
    pub fn sow_row<A: Arithmetic>(&mut self, front: &mut [A::Cell], speed: &[A::Cell], width: usize, y: usize) {
        let mut planes = Planes::<A> { front, speed, width: width as u32 };
        let first = (y * width) as u32;
        for pixel in first..first + width as u32 {
            let bits = planes.bits(pixel);
            if bits & LINK == 0 && bits != FAR.to_bits() {
                let neighbours = planes.neighbours(pixel);
                let around = planes.around(&neighbours);
                self.reach(&mut planes, pixel, &neighbours, &around, f32::from_bits(bits));
            }
        }
    }

    /// Looks at `pixels` pixels; whether there is more to do.
    pub fn advance<A: Arithmetic>(
        &mut self,
        front: &mut [A::Cell],
        speed: &[A::Cell],
        width: usize,
        pixels: usize,
    ) -> bool {
        let mut planes = Planes::<A> { front, speed, width: width as u32 };
        for _ in 0..pixels {
            if self.next == END && !self.next_bucket() {
                return false;
            }
            self.look(&mut planes);
        }
        true
    }

    /// Goes on to the next bucket with a pixel in it; `false` where there is none.
    fn next_bucket(&mut self) -> bool {
        let last = self.last_bucket.min(self.bucket.saturating_add(BUCKETS - 1));
        for bucket in self.bucket.saturating_add(1)..=last {
            if let Some(head) = self.heads.get_mut((bucket % BUCKETS) as usize)
                && *head != END
            {
                self.bucket = bucket;
                (self.next, *head) = (*head, END);
                return true;
            }
        }
        false
    }

    /// Takes the next pixel of the bucket: settles it, or moves it to a later bucket.
    #[inline(always)]
    fn look<A: Arithmetic>(&mut self, planes: &mut Planes<'_, A>) {
        let pixel = self.next;
        self.next = planes.bits(pixel) & !LINK;
        planes.fetch(self.next);
        let (delay, neighbours) = (planes.delay(pixel), planes.neighbours(pixel));
        let around = planes.around(&neighbours);
        let [h, v] = around.map(Axis::of);
        let end = (self.bucket + 1) as f32 * WIDTH;
        let time = arrival::<A>(h.known, v.known, delay);
        let soonest = if time < end { time } else { arrival::<A>(h.soonest(end), v.soonest(end), delay) };
        if time < end + AHEAD && time - soonest <= SLACK {
            planes.set(pixel, time.to_bits());
            self.latest = if time > self.latest { time } else { self.latest };
            self.reach(planes, pixel, &neighbours, &around, time);
        } else {
            self.wait(planes, pixel, soonest, self.bucket + 1);
        }
    }

    /// The pixels around one that is settled at `time` can be next: those in no list go into one.
    #[inline(always)]
    fn reach<A: Arithmetic>(
        &mut self,
        planes: &mut Planes<'_, A>,
        pixel: u32,
        neighbours: &Neighbours,
        around: &Around,
        time: f32,
    ) {
        for ((pair, bits), across) in neighbours.iter().zip(around).zip([planes.width, 1]) {
            for (&neighbour, &bits) in pair.iter().zip(bits) {
                if bits == FAR.to_bits() {
                    self.enlist(planes, neighbour, neighbour.wrapping_sub(pixel), across, time);
                }
            }
        }
    }

    /// Puts a pixel into its first list; `step` before it one was settled at `time`, and on its other
    /// axis its neighbours lie at `across`.
    #[inline(never)]
    fn enlist<A: Arithmetic>(&mut self, planes: &mut Planes<'_, A>, pixel: u32, step: u32, across: u32, time: f32) {
        // At the frame's edge both neighbours are the same pixel.
        if planes.bits(pixel) != FAR.to_bits() {
            return;
        }
        let now = self.bucket as f32 * WIDTH;
        let soonest = |step: u32, across: u32| planes.soonest(pixel.wrapping_add(step), step, across, now);
        let (one, other, ahead) = (soonest(across, step), soonest(across.wrapping_neg(), step), soonest(step, across));
        let along = if time < ahead { time } else { ahead };
        let aside = if one < other { one } else { other };
        let soonest = arrival::<A>(along, aside, planes.delay(pixel));
        self.wait(planes, pixel, soonest, self.bucket);
    }

    /// Puts a pixel into the list of the bucket of `time`, `first` at the earliest. Beyond the
    /// last bucket it is in no list.
    #[inline(always)]
    fn wait<A: Arithmetic>(&mut self, planes: &mut Planes<'_, A>, pixel: u32, time: f32, first: u32) {
        let bucket = (time / WIDTH) as u32;
        if bucket > self.last_bucket {
            self.cut |= planes.delay(pixel) < AT_REST;
            planes.set(pixel, FAR.to_bits());
            return;
        }
        let bucket = bucket.max(first).min(self.bucket + (BUCKETS - 1));
        let head = match self.heads.get_mut((bucket % BUCKETS) as usize) {
            Some(head) if bucket != self.bucket => head,
            _ => &mut self.next,
        };
        planes.set(pixel, LINK | *head);
        *head = pixel;
    }

    /// Turns a row of times into a front at `t_max` pixels of free motion: `T - t_max` where it
    /// has been, 1 where it has not.
    pub fn level_row<A: Arithmetic>(row: &mut [A::Cell], t_max: f32) {
        for cell in row {
            let bits = cell.bits();
            let reached = bits & LINK == 0 && bits != FAR.to_bits();
            let level = if reached { (f32::from_bits(bits) - OFFSET) - t_max } else { 1.0 };
            *cell = A::to_level(A::Real::of(if level > 0.0 && reached { 1.0 } else { level }));
        }
    }

    /// Whether time was up while the front still moved at more than a tenth of its free speed.
    pub fn is_cut(&self) -> bool {
        self.cut
    }

    /// The latest arrival, in pixels of free motion.
    pub fn latest(&self) -> f32 {
        self.latest - OFFSET
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    const SIDE: usize = 41;

    /// Arrival times from the middle pixel.
    fn times(speed: &[f32], slice: usize) -> [f32; SIDE * SIDE] {
        let mut front = [1.0f32; SIDE * SIDE];
        front[SIDE * SIDE / 2] = 0.0;
        let t_max = 200.0;
        let mut march = March::new(t_max);
        front.chunks_exact_mut(SIDE).for_each(March::seed_row::<F32>);
        (0..SIDE).for_each(|y| march.sow_row::<F32>(&mut front, speed, SIDE, y));
        while march.advance::<F32>(&mut front, speed, SIDE, slice) {}
        March::level_row::<F32>(&mut front, t_max);
        front.map(|level| if level > 0.0 { f32::INFINITY } else { level + t_max })
    }

    #[test]
    fn free_motion_arrives_after_the_distance() {
        let times = times(&[1.0; SIDE * SIDE], 7);
        for (index, &time) in times.iter().enumerate() {
            let (x, y) = ((index % SIDE) as f32 - 20.0, (index / SIDE) as f32 - 20.0);
            let distance = (x * x + y * y).sqrt();
            // First order: a point source is smeared by a logarithm of the distance.
            assert!(time >= distance - 1e-3 && time < distance + 0.5 + 0.6 * (1.0 + distance).ln(), "{x} {y} {time}");
        }
        assert_eq!(times[20 * SIDE], 20.0);
    }

    #[test]
    fn walls_are_walked_around_and_slow_pixels_take_their_time() {
        let mut speed = [1.0; SIDE * SIDE];
        for (y, row) in speed.chunks_exact_mut(SIDE).enumerate() {
            row[25] = if y < 39 { 0.0 } else { 0.25 };
        }
        let times = times(&speed, usize::MAX);
        assert_eq!(times[20 * SIDE + 25], f32::INFINITY);
        assert!(times[20 * SIDE + 26] > 38.0 && times[20 * SIDE + 26] < 60.0, "{}", times[20 * SIDE + 26]);
        assert!(times[39 * SIDE + 25] - times[39 * SIDE + 24] > 2.5);
    }

    /// How often each pixel is looked at until the march from a frame of settled pixels, and from
    /// one in the middle, ends.
    fn looks_at(speed: &[f32], t_max: f32) -> [u32; SIDE * SIDE] {
        let mut front = [0.0f32; SIDE * SIDE];
        for (index, cell) in front.iter_mut().enumerate() {
            let (x, y) = (index % SIDE, index / SIDE);
            let depth = x.min(y).min(SIDE - 1 - x).min(SIDE - 1 - y) as f32;
            *cell = if index == SIDE * SIDE / 2 { -0.3 } else { depth - 1.5 };
        }
        let mut march = March::new(t_max);
        front.chunks_exact_mut(SIDE).for_each(March::seed_row::<F32>);
        (0..SIDE).for_each(|y| march.sow_row::<F32>(&mut front, speed, SIDE, y));
        let mut looks = [0; SIDE * SIDE];
        while march.next != END || march.next_bucket() {
            looks[march.next as usize] += 1;
            march.advance::<F32>(&mut front, speed, SIDE, 1);
        }
        looks
    }

    #[test]
    fn a_front_along_an_axis_looks_at_each_pixel_once() {
        let looks = looks_at(&[0.95; SIDE * SIDE], 200.0);
        let along = |&index: &usize| {
            let (x, y) = (index % SIDE, index / SIDE);
            let (depth, aside) = (y.min(SIDE - 1 - y), x.min(SIDE - 1 - x));
            // Behind the first ones, out of the corners, and not where the front from the middle is met.
            (3..8).contains(&depth) && aside > depth + 1
        };
        for index in (0..SIDE * SIDE).filter(along) {
            assert_eq!(looks[index], 1, "pixel {index}");
        }
    }

    #[test]
    fn no_pixel_is_looked_at_more_often_than_was_said() {
        assert_eq!(looks(500.0), 95);
        let mut seed = 7u32;
        let mut draw = |below: usize| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 16) as usize % below
        };
        for t_max in [20.0, 200.0, 5000.0] {
            for round in 0..40 {
                // Ever slower pixels among fast ones, and plains of slow ones.
                let slow = [0.5, 0.2, 0.05, 0.02, 1e-2, 1e-3, 3e-4, 0.0];
                let patch = 1 + round % 9;
                let patches = [0.0; SIDE * SIDE].map(|_| if draw(2) == 0 { 1.0 } else { slow[draw(1 + round % 8)] });
                let mut speed = [0.0; SIDE * SIDE];
                for (index, speed) in speed.iter_mut().enumerate() {
                    *speed = patches[index / SIDE / patch * SIDE + index % SIDE / patch];
                }
                let most = looks_at(&speed, t_max).into_iter().fold(0, u32::max);
                assert!(most <= looks(t_max), "{most} looks in round {round} to {t_max}");
            }
        }
    }

    #[test]
    fn slices_change_nothing_and_every_time_solves_the_equation() {
        let mut seed = 1u32;
        let speed = [0.0f32; SIDE * SIDE].map(|_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            0.05 + 0.95 * (seed >> 8) as f32 / (1 << 24) as f32
        });
        let found = times(&speed, 1);
        assert_eq!(found.map(f32::to_bits), times(&speed, 1000).map(f32::to_bits));
        let at = |x: usize, y: usize| if x < SIDE && y < SIDE { found[y * SIDE + x] } else { FAR };
        for (index, &time) in found.iter().enumerate().filter(|&(index, _)| index != SIDE * SIDE / 2) {
            let (x, y) = (index % SIDE, index / SIDE);
            let h = at(x.wrapping_sub(1), y).min(at(x + 1, y));
            let v = at(x, y.wrapping_sub(1)).min(at(x, y + 1));
            let exact = arrival::<F32>(h, v, 1.0 / speed[index]);
            assert!(time >= exact - 1e-3 && time <= exact + 2.0 * SLACK, "{x} {y}: {time}, {exact}");
        }
    }

    #[test]
    fn a_time_comes_from_both_axes_where_they_are_near() {
        let cases = [
            (3.0, 3.0, 1.0, 3.0 + core::f32::consts::FRAC_1_SQRT_2),
            (0.6, 0.0, 1.0, 0.940_312_4),
            (0.0, 1.0, 1.0, 1.0),
            (2.0, 0.0, 1.5, 1.5),
        ];
        for (h, v, delay, time) in cases {
            assert!((arrival::<F32>(h, v, delay) - time).abs() < 1e-6, "{h} {v} {delay}: {time}");
        }
    }

    #[test]
    fn time_is_up_for_a_front_that_moves_and_not_for_one_that_creeps() {
        let marched = |speed: f32, t_max: f32| {
            let (mut front, speed) = ([1.0f32; SIDE * SIDE], [speed; SIDE * SIDE]);
            front[SIDE * SIDE / 2] = 0.0;
            let mut march = March::new(t_max);
            front.chunks_exact_mut(SIDE).for_each(March::seed_row::<F32>);
            (0..SIDE).for_each(|y| march.sow_row::<F32>(&mut front, &speed, SIDE, y));
            while march.advance::<F32>(&mut front, &speed, SIDE, SIDE) {}
            march
        };
        let cut = |speed, t_max| marched(speed, t_max).is_cut();
        assert!(cut(1.0, 5.0) && cut(0.125, 5.0) && !cut(0.05, 5.0) && !cut(1.0, 50.0));
        // To the corners, and what a first order adds.
        assert!((28.28..29.5).contains(&marched(1.0, 50.0).latest()), "{}", marched(1.0, 50.0).latest());
    }

    #[test]
    fn what_points_beyond_the_frame_is_not_sound() {
        let march = March::new(30.0);
        let sound = [march, March { next: 8, ..march }, March { bucket: march.last_bucket, ..march }];
        assert!(sound.iter().all(|march| march.is_sound(30.0, 9)) && !march.is_sound(60.0, 9));
        let mut heads = march.heads;
        heads[3] = 9;
        let (bucket, latest) = (march.last_bucket + 1, f32::INFINITY);
        let broken = [
            March { heads, ..march },
            March { next: 9, ..march },
            March { bucket, ..march },
            March { latest, ..march },
        ];
        assert!(broken.iter().all(|march| !march.is_sound(30.0, 9)));
    }
}
