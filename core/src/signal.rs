//! The signal-to-noise of a frame, smoothed, and the mask of its sources.

use crate::arithmetic::{Level, Real};
use crate::detect::{Known, SCALES, Workspace};
use crate::grid::Grid;
use crate::sky::Mesh;
use crate::smooth::{Weights, noise};
use crate::sort::{Keys, median};
use crate::spike::cleaned;

/// Smoothing goes on where the change is below this, in its noise.
const LEPSKI: f32 = 1.7;
/// Signal-to-noise of every pixel, spikes replaced; undefined pixels have none. Says whether there
/// is any noise.
pub fn measure<L: Level>(pixels: &[f32], grid: Grid, known: &Known<'_>, work: &mut Workspace<'_, L>) -> bool {
    let (width, height) = (grid.width.get(), grid.height);
    let mut keys = Keys(work.parents, work.order);
    let masked = &*work.masked;
    let sky = |at: usize| masked.get(at).is_none_or(|&mask| mask <= L::ZERO);
    let mesh = Mesh::measure(pixels, sky, (width, height), work.mesh, keys.again());
    let sky_at = |at: usize| mesh.at(at % grid.width, at / grid.width);
    let mut factor = 1.0;
    if known.relative {
        let ratio = |at: usize| sky_at(at).noise / Known::value(known.noise, at).unwrap_or(1.0);
        factor = typical(ratio, pixels.len(), keys);
    }
    let mut noise_seen = false;
    for (at, (out, &pixel)) in work.scratch.iter_mut().zip(pixels).enumerate() {
        let sky = sky_at(at);
        let level = Known::value(known.background, at).unwrap_or(sky.level);
        let noise = Known::value(known.noise, at).map_or(sky.noise, |noise| factor * noise);
        let signal = (pixel - level) / noise;
        let usable = known.allows(at) && noise > 0.0 && signal.is_finite();
        noise_seen |= usable;
        *out = if usable { L::of(signal) } else { L::ZERO };
    }
    let row = |y: Option<usize>| y.and_then(|y| work.scratch.get(y * width..(y + 1) * width)).unwrap_or(&[]);
    for (y, out) in work.signal.chunks_exact_mut(width).enumerate() {
        let rows = [row(y.checked_sub(1)), row(Some(y)), row(Some(y + 1))];
        for (x, out) in out.iter_mut().enumerate() {
            *out = cleaned(rows, x);
        }
    }
    noise_seen
}

/// The median of the positive values of a sample; 1 where there are none.
fn typical(value: impl Fn(usize) -> f32, count: usize, mut keys: Keys<'_>) -> f32 {
    let positive = |value: &f32| value.is_finite() && *value > 0.0;
    let sorted = keys.sorted((0..count).step_by(keys.stride(count)).map(value).filter(positive));
    if sorted.is_empty() { 1.0 } else { median(sorted) }
}

/// Fills the fine and the smooth plane; gives the noise of the fine one.
pub fn smooth<L: Level>(grid: Grid, work: &mut Workspace<'_, L>) -> L {
    let [scale, ..] = SCALES;
    Weights::gauss(scale).apply(work.signal, work.scratch, work.fine, grid);
    let fine = &*work.fine;
    let value = |plane: &[L], at: usize| plane.get(at).copied().unwrap_or(L::ZERO);
    let fine_noise = noise(|at| value(fine, at), work.masked, Keys(work.parents, work.order));
    Weights::SPLINE.apply(fine, work.scratch, work.smooth, grid);
    let detail = |at: usize| value(fine, at) - value(work.smooth, at);
    let least = noise(detail, work.masked, Keys(work.parents, work.order)).scaled(L::Weight::of(LEPSKI));
    for (smooth, &fine) in work.smooth.iter_mut().zip(fine) {
        if (fine - *smooth).magnitude() >= least {
            *smooth = fine;
        }
    }
    fine_noise
}

/// Masks the sources that have a pixel above `peak` in the fine plane, and what is within about
/// three pixels of them.
pub fn mask_sources<L: Level>(grid: Grid, outline: L, peak: L, work: &mut Workspace<'_, L>) {
    let (source, perhaps) = (L::ONE, L::of(0.5));
    for (fine, &smooth) in work.fine.iter_mut().zip(work.smooth.iter()) {
        *fine = match (smooth > outline, *fine > peak) {
            (true, true) => source,
            (true, false) => perhaps,
            _ => L::ZERO,
        };
    }
    // From the peaks outwards, along the rows and back; what winds more than that stays unmasked.
    let marks = &mut *work.fine;
    for index in (0..marks.len()).chain((0..marks.len()).rev()).chain(0..marks.len()) {
        let marked = |at: usize| marks.get(at).is_some_and(|&mark| mark == source);
        if marks.get(index).is_some_and(|&mark| mark == perhaps)
            && grid.neighbours(index).any(marked)
            && let Some(mark) = marks.get_mut(index)
        {
            *mark = source;
        }
    }
    for mark in marks.iter_mut().filter(|mark| **mark < source) {
        *mark = L::ZERO;
    }
    let [_, growth, ..] = SCALES;
    Weights::gauss(growth).apply(work.fine, work.scratch, work.masked, grid);
    let near = L::of(0.08);
    for cell in work.masked.iter_mut() {
        *cell = if *cell > near { L::ONE } else { L::ZERO };
    }
}
