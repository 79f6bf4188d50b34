//! Sorting in bounded time, without a panic: what the standard library's sorts cannot promise.
//!
//! Many items are sorted by the digits of a key above the least one, from the lowest (H. H. Seward 1954; Knuth, The
//! Art of Computer Programming, 5.2.5): items of one key keep their order. A [`Level`] has a key of
//! 32 bits; of single precision -0 and +0 are neighbours.

use crate::arithmetic::Level;
use crate::plane::walk::{BYTES, Walk};
use core::ops::Range;

/// Bits of a wide digit: three hold every key.
const WIDE: u32 = 11;
/// Values of a wide digit.
const WIDES: usize = 1 << WIDE;
/// So many items are worth the counts of wide digits.
const MANY: usize = 1 << 10;

/// Sorts `items`, fewer than 2^32, by `key`, the least first; `spare` needs as many elements, and where it has 2048
/// more many items are sorted by wider digits than bytes.
/// Cost: a look at each item and its key, and two for each digit of the distance from the least key to the greatest.
pub fn by_key(items: &mut [u32], spare: &mut [u32], key: impl Fn(u32) -> u32) {
    let wider = |(least, greatest): (u32, u32), &item: &u32| (key(item).min(least), key(item).max(greatest));
    let (least, greatest) = items.iter().fold((u32::MAX, 0), wider);
    let range = greatest.saturating_sub(least);
    let key = |item: u32| key(item).wrapping_sub(least);
    let (spare, rest) = spare.split_at_mut_checked(items.len()).unwrap_or_default();
    match rest.first_chunk_mut::<WIDES>() {
        Some(places) if items.len() >= MANY => by_digits(items, spare, places, range, key),
        _ => by_digits(items, spare, &mut [0; BYTES], range, key),
    }
}

/// Sorts by the digits of keys up to `range`, the lowest first; each has as many values as there are `places`.
fn by_digits<const VALUES: usize>(
    items: &mut [u32],
    spare: &mut [u32],
    places: &mut [u32; VALUES],
    range: u32,
    key: impl Fn(u32) -> u32,
) {
    let (mut from, mut to, mut is_elsewhere) = (items, spare, false);
    let shifts = (0..u32::BITS).step_by((VALUES.trailing_zeros() as usize).max(1));
    for shift in shifts.take_while(|shift| range >> shift > 0) {
        by_digit(from, to, places, |item| (key(item) >> shift) as usize & (VALUES - 1));
        core::mem::swap(&mut from, &mut to);
        is_elsewhere = !is_elsewhere;
    }
    if is_elsewhere {
        to.iter_mut().zip(from.iter()).for_each(|(to, from)| *to = *from);
    }
}

/// Sorts by a digit.
#[inline(always)]
fn by_digit<const VALUES: usize>(
    from: &[u32],
    to: &mut [u32],
    places: &mut [u32; VALUES],
    digit: impl Fn(u32) -> usize + Copy,
) {
    places.fill(0);
    count_digits(from, places, digit);
    begin_at(places);
    lay(from, to, places, digit);
}

/// The same in parts, by bytes; at once where all may be done now.
pub(crate) fn by_key_in(walk: &mut Walk, items: &mut [u32], spare: &mut [u32], key: impl Fn(u32) -> u32) -> Option<()> {
    if walk.is_open() {
        return walk.once(items.len(), || by_key(items, spare, key));
    }
    let (count, spare) = (items.len(), spare.get_mut(..items.len()).unwrap_or(&mut []));
    walk.tally(count, 1, |tally, range| {
        let wider = |(least, greatest): (u32, u32), &item: &u32| (key(item).min(least), key(item).max(greatest));
        let known = if range.start == 0 { (u32::MAX, 0) } else { tally.keys };
        tally.keys = part_of(items, range).iter().fold(known, wider);
    })?;
    let (least, greatest) = walk.tally.keys;
    let distance = greatest.saturating_sub(least);
    let (mut from, mut to) = (items, spare);
    for shift in [0, 8, 16, 24] {
        let (is_needed, last) = (distance >> shift > 0, count.saturating_sub(1));
        let byte = |item: u32| usize::from((key(item).wrapping_sub(least) >> shift) as u8);
        let count = if is_needed { count } else { 0 };
        walk.tally(count, 1, |tally, range| {
            if range.start == 0 {
                tally.places.fill(0);
            }
            let is_last = range.end > last;
            count_digits(part_of(from, range), &mut tally.places, byte);
            if is_last {
                begin_at(&mut tally.places);
            }
        })?;
        walk.tally(count, 1, |tally, range| lay(part_of(from, range), to, &mut tally.places, byte))?;
        if is_needed {
            core::mem::swap(&mut from, &mut to);
        }
    }
    // Sorted by one byte or three, they lie in the spare room.
    let is_elsewhere = (distance > 0 && distance >> 8 == 0) || (distance >> 16 > 0 && distance >> 24 == 0);
    walk.pass(if is_elsewhere { count } else { 0 }, 1, |range| {
        let places = to.iter_mut().zip(from.iter()).take(range.end).skip(range.start);
        places.for_each(|(to, from)| *to = *from);
    })
}

/// Counts the items that have each digit.
// A function of its own: what it is lent cannot be the same memory.
#[inline(never)]
fn count_digits<const VALUES: usize>(items: &[u32], places: &mut [u32; VALUES], digit: impl Fn(u32) -> usize) {
    for &item in items {
        if let Some(count) = places.get_mut(digit(item)) {
            *count = count.wrapping_add(1);
        }
    }
}

/// Makes of counts the place of the first item of each digit.
fn begin_at(places: &mut [u32]) {
    let mut before = 0u32;
    for place in places {
        (*place, before) = (before, before.wrapping_add(*place));
    }
}

/// Lays every item at the place of its digit.
#[inline(never)]
fn lay<const VALUES: usize>(items: &[u32], to: &mut [u32], places: &mut [u32; VALUES], digit: impl Fn(u32) -> usize) {
    for &item in items {
        if let Some(place) = places.get_mut(digit(item)) {
            if let Some(out) = to.get_mut(*place as usize) {
                *out = item;
            }
            *place = place.wrapping_add(1);
        }
    }
}

fn part_of(items: &[u32], range: Range<usize>) -> &[u32] {
    items.get(range).unwrap_or(&[])
}

/// Sorts a few items by insertion; `precedes` says whether one comes before another.
pub fn few<T: Copy>(items: &mut [T], precedes: impl Fn(T, T) -> bool) {
    for end in 1..items.len() {
        for at in (0..end).rev() {
            match items.get_mut(at..at + 2) {
                Some([left, right]) if precedes(*right, *left) => core::mem::swap(left, right),
                _ => break,
            }
        }
    }
}

/// The most values from which the noise of a plane is taken: its error is then half a percent.
pub const SAMPLES: usize = 1 << 16;

/// Room for keys, and as much again to sort them.
#[derive(Debug)]
pub struct Keys<'m>(pub &'m mut [u32], pub &'m mut [u32]);

impl Keys<'_> {
    /// How many keys there is room for.
    pub fn room(&self) -> usize {
        self.0.len().min(self.1.len())
    }

    /// The stride at which a sample of `count` values, evenly spread, finds room and has at most
    /// [`SAMPLES`]. It is odd, not to fall on the same columns in every row of an even width.
    pub fn stride(&self, count: usize) -> usize {
        match self.room().min(SAMPLES) {
            0 => 1,
            room => count.div_ceil(room) | 1,
        }
    }

    /// The same room, for another to use and give back.
    pub fn again(&mut self) -> Keys<'_> {
        Keys(self.0, self.1)
    }

    /// The keys of the values, the least first: as many as there is room for.
    pub fn sorted<L: Level>(&mut self, values: impl Iterator<Item = L>) -> &[u32] {
        let count = lay_keys(values, self.0);
        self.sort(count)
    }

    /// The same in parts, of the values of so many items, each with the work of `cost` cells.
    pub(crate) fn gather<L: Level, V: Iterator<Item = L>>(
        &mut self,
        walk: &mut Walk,
        (items, cost): (usize, usize),
        values: impl FnOnce(Range<usize>) -> V,
    ) -> Option<&[u32]> {
        walk.tally(items, cost, |tally, range| {
            if range.start == 0 {
                tally.count = 0;
            }
            let room = self.0.get_mut(tally.count..).unwrap_or(&mut []);
            tally.count = tally.count.saturating_add(lay_keys(values(range), room));
        })?;
        let count = walk.tally.count.min(self.0.len());
        let keys = self.0.get_mut(..count).unwrap_or(&mut []);
        by_key_in(walk, keys, self.1, |key| key)?;
        Some(keys)
    }

    /// Sorts the first keys that were laid there, the least first.
    pub fn sort(&mut self, count: usize) -> &[u32] {
        let room = self.0.len();
        let keys = self.0.get_mut(..count.min(room)).unwrap_or(&mut []);
        by_key(keys, self.1, |key| key);
        keys
    }
}

/// Lays the keys of values where there is room for them; gives their number.
fn lay_keys<L: Level>(values: impl Iterator<Item = L>, room: &mut [u32]) -> usize {
    let (mut count, mut free) = (0, room.iter_mut());
    // From within, which of nested iterators makes nested loops.
    values.for_each(|value| {
        if let Some(out) = free.next() {
            *out = value.key();
            count += 1;
        }
    });
    count
}

/// The value of a rank among sorted keys; 0 beyond them.
pub fn ranked<L: Level>(sorted: &[u32], rank: usize) -> L {
    sorted.get(rank).map_or(L::ZERO, |&key| L::of_key(key))
}

/// The median of sorted keys, the upper one of an even number; 0 for none.
pub fn median<L: Level>(sorted: &[u32]) -> L {
    ranked(sorted, sorted.len() / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sorted_as_the_standard_library_does() {
        let mut values = core::array::from_fn::<f32, 1000, _>(|i| {
            let bits = (i as u32).wrapping_mul(0x9E37_79B1);
            if i % 7 == 0 { 0.0 } else { (bits as i32 >> (i % 30)) as f32 }
        });
        values[5] = -0.0;
        let (mut keys, mut spare) = ([0; 1000], [0; 1000]);
        let mut room = Keys(&mut keys, &mut spare);
        let sorted = room.sorted(values.into_iter()).iter().map(|&key| f32::of_key(key).to_bits());
        let mut order = core::array::from_fn::<u32, 1000, _>(|i| i as u32);
        by_key(&mut order, &mut [0; 1000], |at| !values[at as usize].key());
        let mut brightest = core::array::from_fn::<u32, 1000, _>(|i| i as u32);
        brightest.sort_by(|&a, &b| values[b as usize].total_cmp(&values[a as usize]));
        assert_eq!(order, brightest, "items of one key keep their order");
        let mut some = values;
        some.sort_unstable_by(f32::total_cmp);
        assert!(sorted.eq(some.iter().map(|value| value.to_bits())));
        few(&mut values, |a, b| a.total_cmp(&b).is_lt());
        assert_eq!(values.map(f32::to_bits), some.map(f32::to_bits));
    }

    #[test]
    fn digits_that_all_keys_share_change_no_order() {
        let mut spare = [7; MANY + WIDES];
        for shared in [0, 0xFF, 0xFF00, 0xFF_0000, 0xFF00_FF00, 0x00FF_FFFF, 0x003F_F800, u32::MAX] {
            let key = |item: u32| item.wrapping_mul(0x9E37_79B1) & !shared;
            // By bytes, with too little room for wide digits, and by these.
            for (count, room) in [(300, 300), (MANY, MANY + WIDES - 1), (MANY, MANY + WIDES)] {
                let mut items = core::array::from_fn::<u32, MANY, _>(|i| i as u32);
                let mut expected = items;
                by_key(&mut items[..count], &mut spare[..room], key);
                expected[..count].sort_by_key(|&item| key(item));
                assert_eq!(items, expected, "{shared:x}, {count} items, room for {room}");
                let (mut items, mut walk) = (core::array::from_fn::<u32, MANY, _>(|i| i as u32), Walk::whole());
                let mut sort = |cells: usize| {
                    walk.resume(cells);
                    by_key_in(&mut walk, &mut items[..count], &mut spare[..room], key)
                };
                while sort(100).is_none() {}
                assert_eq!(items, expected, "{shared:x}, {count} items in parts");
            }
        }
    }

    #[test]
    fn keys_beyond_the_room_are_left_out() {
        let (mut keys, mut spare) = ([0; 3], [0; 4]);
        let mut room = Keys(&mut keys, &mut spare);
        assert_eq!(room.room(), 3);
        assert_eq!(median::<f32>(room.sorted([5.0f32, 9.0, -1.0, 2.0].into_iter())), 5.0);
        assert_eq!(median::<f32>(room.sorted::<f32>([].into_iter())), 0.0);
    }
}
