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
/// Wide digits of a key.
const DIGITS: usize = 3;
/// Room for the counts of wide digits, behind that for the items.
pub(crate) const WIDE_ROOM: usize = DIGITS * WIDES;
/// So many items are worth the counts of wide digits.
const MANY: usize = 1 << 10;

/// Sorts `items`, fewer than 2^32, by `key`, the least first; `spare` needs as many elements, and where it has 6144
/// more many items are sorted by fewer digits, wider than bytes.
/// Cost: two looks at each item and its key, and one for each digit of the distance from the least key to the greatest.
pub fn by_key(items: &mut [u32], spare: &mut [u32], key: impl Fn(u32) -> u32) {
    let wider = |(least, greatest): (u32, u32), &item: &u32| (key(item).min(least), key(item).max(greatest));
    let (least, greatest) = items.iter().fold((u32::MAX, 0), wider);
    let range = greatest.saturating_sub(least);
    let key = |item: u32| key(item).wrapping_sub(least);
    let (spare, rest) = spare.split_at_mut_checked(items.len()).unwrap_or_default();
    match rest.as_chunks_mut::<WIDES>().0.first_chunk_mut::<DIGITS>() {
        Some(places) if items.len() >= MANY => by_wide_digits(items, spare, places, range, key),
        _ => by_bytes(items, spare, range, key),
    }
}

/// Sorts by the bytes of keys up to `range`, the lowest first.
fn by_bytes(items: &mut [u32], spare: &mut [u32], range: u32, key: impl Fn(u32) -> u32) {
    let (mut from, mut to, mut is_elsewhere) = (items, spare, false);
    let mut places = [0; BYTES];
    for shift in (0..u32::BITS).step_by(8).take_while(|shift| range >> shift > 0) {
        let byte = |item: u32| usize::from((key(item) >> shift) as u8);
        places.fill(0);
        count_digits(from, &mut places, byte);
        begin_at(&mut places);
        lay(from, to, &mut places, byte);
        core::mem::swap(&mut from, &mut to);
        is_elsewhere = !is_elsewhere;
    }
    if is_elsewhere {
        to.iter_mut().zip(from.iter()).for_each(|(to, from)| *to = *from);
    }
}

/// Sorts by the wide digits of keys up to `range`. Where two do not reach, the two highest leave nearly every item at its
/// place, unless many keys lie together and one is far from them.
fn by_wide_digits(
    items: &mut [u32],
    spare: &mut [u32],
    places: &mut [[u32; WIDES]; DIGITS],
    range: u32,
    key: impl Fn(u32) -> u32,
) {
    let rest = (u32::BITS - range.leading_zeros()).saturating_sub(2 * WIDE);
    if range >> WIDE == 0 {
        by_digits::<1>(items, spare, places, (range, 0), &key);
    } else {
        by_digits::<2>(items, spare, places, (range, rest), &key);
    }
    if rest > 0 && !settle_near(items, &key) {
        by_digits::<DIGITS>(items, spare, places, (range, 0), &key);
    }
}

/// Sorts by so many wide digits of keys up to `range`, which are counted together; the lowest begins at bit `first`.
fn by_digits<const COUNT: usize>(
    items: &mut [u32],
    spare: &mut [u32],
    places: &mut [[u32; WIDES]; DIGITS],
    (range, first): (u32, u32),
    key: &impl Fn(u32) -> u32,
) {
    let shifts = (first..).step_by(WIDE as usize).take(COUNT);
    for (shift, places) in shifts.clone().zip(places.iter_mut()) {
        values_of(places, range, shift).fill(0);
    }
    count_each::<COUNT>(items, places, first, key);
    let (mut from, mut to) = (items, spare);
    for (shift, places) in shifts.zip(places) {
        begin_at(values_of(places, range, shift));
        lay(from, to, places, |item| wide_digit(key(item), shift));
        core::mem::swap(&mut from, &mut to);
    }
    if COUNT % 2 == 1 {
        to.iter_mut().zip(from.iter()).for_each(|(to, from)| *to = *from);
    }
}

/// Moves each item that precedes one before it to its place, if that is near; whether all are sorted then. Items of one
/// key keep their order.
fn settle_near(items: &mut [u32], key: impl Fn(u32) -> u32) -> bool {
    const NEAR: usize = 8;
    let mut next = 1;
    while let Some(end) = next_fall(items, next, &key) {
        let first = end.saturating_sub(NEAR);
        settle(items.get_mut(first..=end).unwrap_or(&mut []), |a, b| key(a) < key(b));
        if let Some(&[before, settled]) = items.get(first.wrapping_sub(1)..).and_then(<[u32]>::first_chunk)
            && key(settled) < key(before)
        {
            return false;
        }
        next = end + 1;
    }
    true
}

/// The first item from `from`, at least 1, on that precedes the one before it. Cost: a look at each up to there, some at a
/// time.
fn next_fall(items: &[u32], from: usize, key: impl Fn(u32) -> u32) -> Option<usize> {
    const PIECE: usize = 16;
    let (before, behind) = (items.get(from.wrapping_sub(1)..)?, items.get(from..)?);
    let falls = |(&before, &behind): (&u32, &u32)| key(behind) < key(before);
    let sorted = |(before, behind): &(&[u32], &[u32])| {
        before.iter().zip(*behind).fold(true, |sorted, pair| sorted & !falls(pair))
    };
    let sorted = PIECE * before.chunks(PIECE).zip(behind.chunks(PIECE)).take_while(sorted).count();
    let mut pairs = before.iter().zip(behind).skip(sorted);
    pairs.position(falls).map(|at| from + sorted + at)
}

#[inline(always)]
fn wide_digit(key: u32, shift: u32) -> usize {
    (key >> shift) as usize & (WIDES - 1)
}

/// The values that a digit of keys up to `range` can have.
fn values_of(places: &mut [u32; WIDES], range: u32, shift: u32) -> &mut [u32] {
    let last = (range >> shift) as usize;
    places.get_mut(..=last.min(WIDES - 1)).unwrap_or(&mut [])
}

/// Counts the items that have each value of so many digits from bit `first` on.
// A function of its own: what it is lent cannot be the same memory.
#[inline(never)]
fn count_each<const COUNT: usize>(
    items: &[u32],
    places: &mut [[u32; WIDES]; DIGITS],
    first: u32,
    key: impl Fn(u32) -> u32,
) {
    let [low, middle, high] = places;
    let count = |places: &mut [u32; WIDES], digit: usize| {
        if let Some(count) = places.get_mut(digit) {
            *count = count.wrapping_add(1);
        }
    };
    for &item in items {
        let key = key(item) >> first;
        count(low, wide_digit(key, 0));
        if COUNT > 1 {
            count(middle, wide_digit(key, WIDE));
        }
        if COUNT > 2 {
            count(high, wide_digit(key, 2 * WIDE));
        }
    }
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
    for end in 2..=items.len() {
        settle(items.get_mut(..end).unwrap_or(&mut []), &precedes);
    }
}

/// Moves the last of items, of which the others are sorted, to its place.
pub fn settle<T: Copy>(items: &mut [T], precedes: impl Fn(T, T) -> bool) {
    for at in (1..items.len()).rev() {
        match items.get_mut(at - 1..=at) {
            Some([left, right]) if precedes(*right, *left) => core::mem::swap(left, right),
            _ => break,
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
        let mut spare = [7; MANY + WIDE_ROOM];
        for shared in [0, 0xFF, 0xFF00, 0xFF_0000, 0xFF00_FF00, 0x00FF_FFFF, 0x003F_F800, 0xFFFF_FC00, u32::MAX] {
            let key = |item: u32| item.wrapping_mul(0x9E37_79B1) & !shared;
            // By bytes, with too little room for wide digits, and by these.
            for (count, room) in [(300, 300), (MANY, MANY + WIDE_ROOM - 1), (MANY, MANY + WIDE_ROOM)] {
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

    /// Keys around 0 of which two digits tell nearly all, and the same with one that is far away, beside which the others
    /// are one.
    #[test]
    fn keys_that_lie_together_are_sorted_however_far_one_is() {
        const COUNT: usize = 2 * MANY;
        let mut state = 1u32;
        let mut draw = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((state >> 8) as f32 / (1 << 23) as f32 - 1.0) as f64
        };
        let around_zero: [f32; COUNT] = core::array::from_fn(|_| (draw() * draw()) as f32);
        let mut far: [f32; COUNT] = core::array::from_fn(|at| 1e4 + (at * 7919 % COUNT) as f32 / 64.0);
        far[700] = 0.0;
        for (values, is_near) in [(around_zero, true), (far, false)] {
            let key = |at: u32| values[at as usize].key();
            let mut items = core::array::from_fn::<u32, COUNT, _>(|at| at as u32 % (COUNT as u32 - 9));
            let (mut expected, mut by_two) = (items, items);
            expected.sort_by_key(|&at| key(at));
            by_key(&mut items, &mut [0; COUNT + WIDE_ROOM], key);
            assert!(items == expected, "{is_near}");
            by_two.sort_by_key(|&at| key(at) >> 10);
            assert!(by_two != expected);
            assert_eq!(settle_near(&mut by_two, key), is_near);
            assert!(by_two == expected || !is_near);
        }
    }

    #[test]
    fn what_is_not_near_its_place_is_told() {
        for (from, is_near) in [(8, true), (9, false)] {
            let mut items = core::array::from_fn::<u32, 20, _>(|at| 1 + at as u32);
            items[from] = 0;
            let mut settled = items;
            assert_eq!(settle_near(&mut settled, |item| item), is_near, "from {from}");
            items.sort_unstable();
            assert!(settled == items || !is_near);
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
