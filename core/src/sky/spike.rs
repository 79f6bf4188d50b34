//! Hot pixels and cosmic rays: values that stand alone.

use crate::arithmetic::{Level, Real};
use crate::plane::sort;

/// A pixel whose neighbours' median reaches this part of it is a star. So is one whose four neighbours across an edge
/// have this part of it together, ...
const SHARE: f32 = 0.25;
/// ... or what noise leaves of this part: a star so sharp that it lights hardly two by two pixels has so much there,
/// wherever in a pixel its centre lies.
const SHARPEST: f32 = 1.0 / 3.0;
/// Noise may take this of the four, one and a quarter of their standard deviation, ...
const TAKEN: f32 = 2.5;
/// ... and seldom gives them this, one and three quarters: with less there is no star.
const GIVEN: f32 = 3.5;

/// Copies the middle of three rows of signal-to-noise to `out`, each pixel that stands alone by more than `height` noise
/// units replaced by the median of its neighbours, and counts these; with 0 none does. Rows beyond the frame are empty.
pub fn clean<L: Level>(rows: [&[L]; 3], height: f32, out: &mut [L]) -> u32 {
    let ([_, row, _], mut spikes) = (rows, 0);
    let height = if height > 0.0 { L::of(height) } else { L::of(f32::MAX) };
    let pieces = out.chunks_mut(PIECE).zip(row.chunks(PIECE));
    for (first, (out, row)) in (0..).step_by(PIECE).zip(pieces) {
        out.iter_mut().zip(row).for_each(|(out, value)| *out = *value);
        if row.iter().fold(false, |any, value| any | (*value > height)) {
            let bright = out.iter_mut().zip(first..).filter(|(value, _)| **value > height);
            for (value, x) in bright {
                if let Some(median) = in_place_of(rows, height, x) {
                    *value = median;
                    spikes += 1;
                }
            }
        }
    }
    spikes
}

/// Pixels of a row that are looked at together.
const PIECE: usize = 64;

/// The median of the neighbours of the pixel at `x` of the middle of three rows, if the pixel is a spike.
fn in_place_of<L: Level>(rows: [&[L]; 3], height: L, x: usize) -> Option<L> {
    let [_, row, _] = rows;
    let own = row.get(x).copied().unwrap_or(L::ZERO);
    let share = |part: f32| own.scaled(L::Weight::of(part));
    let around = across_edges(rows, x);
    let is_sharp = around >= share(SHARE) || around >= share(SHARPEST) - L::of(TAKEN);
    if is_sharp && around >= L::of(GIVEN) {
        return None;
    }
    let median = median_around(rows, x);
    let alone = median.positive() + L::ONE < share(SHARE);
    (own - median > height && alone).then_some(median)
}

/// The median of the up to eight neighbours of a pixel.
fn median_around<L: Level>(rows: [&[L]; 3], x: usize) -> L {
    let (mut near, mut count) = ([L::ZERO; 8], 0);
    for (index, row) in rows.into_iter().enumerate() {
        for column in x.saturating_sub(1)..x + 2 {
            if let (Some(&value), Some(out), false) = (row.get(column), near.get_mut(count), index == 1 && column == x)
            {
                *out = value;
                count += 1;
            }
        }
    }
    let near = near.get_mut(..count).unwrap_or(&mut []);
    sort::few(near, |a, b| a.key() < b.key());
    let at = |index: usize| near.get(index).copied().unwrap_or(L::ZERO);
    (at(count / 2) + at(count.saturating_sub(1) / 2)).scaled(L::Weight::of(0.5))
}

/// The sum of the four neighbours across an edge; those beyond the frame have nothing.
fn across_edges<L: Level>([below, row, above]: [&[L]; 3], x: usize) -> L {
    let at = |row: &[L], x: usize| row.get(x).copied().unwrap_or(L::ZERO);
    (at(row, x.wrapping_sub(1)) + at(row, x + 1)) + (at(below, x) + at(above, x))
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;

    /// The light of a Gaussian star of standard deviation `sigma` in the pixels around the brightest,
    /// in units of what is there; `x` and `y` are where in that pixel its centre lies.
    fn star(sigma: f32, x: f32, y: f32) -> [[f32; 3]; 3] {
        let until = |edge: f32, centre: f32| libm::erff((edge - centre) / (core::f32::consts::SQRT_2 * sigma));
        let part = |pixel: usize, centre: f32| {
            let from = pixel as f32 - 1.5;
            0.5 * (until(from + 1.0, centre) - until(from, centre))
        };
        let brightest = part(1, x) * part(1, y);
        core::array::from_fn(|row| core::array::from_fn(|column| part(row, y) * part(column, x) / brightest))
    }

    /// What is at `x` of the middle of three rows when spikes of five noise units are taken out.
    fn cleaned(rows: [&[f32]; 3], x: usize) -> f32 {
        let mut out = std::vec![0.0; rows[1].len()];
        let spikes = clean(rows, 5.0, &mut out);
        let replaced = out.iter().zip(rows[1]).filter(|(out, own)| out != own).count();
        assert_eq!(spikes as usize, replaced);
        out[x]
    }

    fn middle(image: [[f32; 3]; 3], peak: f32) -> f32 {
        let rows = image.map(|row| row.map(|value| value * peak));
        cleaned([&rows[0], &rows[1], &rows[2]], 1)
    }

    #[test]
    fn the_sharpest_star_stays_wherever_in_a_pixel_it_lies() {
        for step in 0..36 {
            let place = |step: i32| 0.1 * step as f32 - 0.25;
            let image = star(0.34, place(step % 6), place(step / 6));
            assert_eq!(middle(image, 60.0), 60.0, "{image:?}");
        }
    }

    #[test]
    fn a_pixel_with_less_than_a_quarter_of_its_light_around_it_is_a_spike() {
        let cross = |arm: f32| [[0.0, arm, 0.0], [arm, 1.0, arm], [0.0, arm, 0.0]];
        assert_eq!(middle(cross(0.06), 100.0), 3.0, "the median of four at 0 and four at 6");
        assert_eq!(middle(cross(0.07), 100.0), 100.0);
        assert_eq!(middle(cross(0.0), 5.0), 5.0, "noise is no spike");
    }

    #[test]
    fn spikes_stand_alone_by_more_than_is_asked_and_may_be_kept() {
        let row = [0.0f32, 30.0, 0.0];
        let cleaned = |height: f32| {
            let mut out = [1.0; 3];
            (clean([&[0.0; 3], &row, &[0.0; 3]], height, &mut out), out)
        };
        assert_eq!([cleaned(29.9), cleaned(30.0), cleaned(0.0)], [(1, [0.0; 3]), (0, row), (0, row)]);
    }

    /// A pixel of so many noise units whose four neighbours have so many together: what is in its place.
    fn lit(own: f32, around: f32) -> f32 {
        middle([[0.0, around / own, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]], own)
    }

    #[test]
    fn a_faint_sharp_star_stays_where_noise_has_taken_of_its_light() {
        assert_eq!([lit(20.0, 4.2), lit(20.0, 4.1)], [20.0, 0.0], "a third less 2.5 is 4.17");
        assert_eq!([lit(40.0, 10.1), lit(40.0, 9.9)], [40.0, 0.0], "a quarter is 10, a third less 2.5 is 10.83");
        assert_eq!([lit(12.0, 3.6), lit(12.0, 3.4)], [12.0, 0.0], "noise alone may bring 3.4");
    }

    #[test]
    fn at_the_edge_of_a_frame_the_neighbours_that_there_are_decide() {
        let row = [100.0f32, 1.0, 0.0];
        assert_eq!(cleaned([&[], &row, &[]], 0), 1.0);
        assert_eq!(cleaned([&[], &[100.0f32, 40.0], &[40.0, 30.0]], 0), 100.0);
    }
}
