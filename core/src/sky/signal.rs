//! The signal-to-noise of a frame, smoothed, and the mask of its sources.

use crate::arithmetic::machine::Task;
use crate::arithmetic::{Level, Real};
use crate::plane::crew::{Crew, MOST_BANDS};
use crate::plane::grid::Grid;
use crate::plane::mask::{Mask, MaskMut};
use crate::plane::part::{self, Question, Whole};
use crate::plane::rows::row_of;
use crate::plane::smooth::Weights;
use crate::plane::sort::{Keys, median};
use crate::sky::spike::clean;
use crate::sky::tail::Tail;
use crate::sky::view::{Known, View};
use crate::sky::{Mesh, Seen, Sky, Survey, Words};

/// Smoothing goes on where the change is below this, in its noise.
const LEPSKI: f32 = 1.7;
/// Scale of the light smoothing, pixels.
const FINE: f32 = 0.8;
/// Scale of the growth of the mask of sources, pixels.
const GROWTH: f32 = 2.0;
/// What is above this of the marks so smoothed is near a source.
const NEAR: f32 = 0.2;

/// The planes of these steps.
#[derive(Debug)]
pub struct Planes<'m, L: Level> {
    /// W x H: signal-to-noise.
    pub signal: &'m mut [L],
    /// W x H: lightly smoothed.
    pub fine: &'m mut [L],
    /// W x H: smoothed by need.
    pub smooth: &'m mut [L],
    /// The pixels near sources.
    pub masked: MaskMut<'m>,
    /// Room for rows.
    pub rows: &'m mut [L],
    /// Scratch for sorting.
    pub keys: Keys<'m>,
    /// The mesh.
    pub mesh: &'m mut [Sky],
}

/// Signal-to-noise of every pixel from a mesh of cells `cell` pixels wide, spikes replaced; an undefined
/// pixel has the mean of the two between which it lies, or none. Tells how the sky was measured; `None`
/// where there is no noise to divide by. `round` counts how often it has been measured.
pub fn measure<L: Level>(
    view: &View<'_>,
    cell: usize,
    round: u32,
    work: &mut Planes<'_, L>,
    crew: &impl Crew,
) -> Option<Survey> {
    let &View { pixels, grid, known, values } = view;
    let width = grid.width.get();
    let mut keys = work.keys.again();
    let masked = Mask(work.masked.0);
    let all_defined = view.is_whole();
    let seen = |at: usize| match (all_defined || view.is_defined(at), !masked.has(at)) {
        (false, _) => Seen::Undefined,
        (true, false) => Seen::Source,
        (true, true) => Seen::Sky,
    };
    let mut mesh = Mesh::over(work.mesh, view.image(), cell);
    let survey = match known.whole {
        None if all_defined => {
            let words = |first: usize| Words { defined: u32::MAX, sky: !masked.word(first) };
            mesh.measure_by(crew, pixels, words, &values, keys.again())
        }
        None => mesh.measure_by(crew, pixels, |first| Words::of(|bit| seen(first + bit)), &values, keys.again()),
        // Nothing can be done before it is known.
        Some(whole) => match mesh.asked((whole, round), (pixels, width), seen, &values, keys.again()) {
            Some(survey) => survey,
            None => return Some(Survey::default()),
        },
    };
    let (left, bottom) = known.whole.map_or((0, 0), |whole| whole.part().origin);
    let sky_at = |at: usize| mesh.at(left + at % grid.width, bottom + at / grid.width);
    let mut factor = 1.0;
    if known.relative {
        let ratio = |at: usize| sky_at(at).noise / Known::value(known.noise, at).unwrap_or(1.0);
        factor = typical(known.whole.map(|whole| (whole, Question::Relative(round))), ratio, pixels.len(), width, keys);
    }
    // A part may have no pixel, where the image has.
    let noise_seen = known.whole.is_some() && !sky_at(0).level.is_nan();
    let (rows, mut seen_in) = (crew.rows(grid).max(1), [noise_seen; MOST_BANDS]);
    let band = (width * rows).max(1);
    let bands = (0..).step_by(rows).zip(work.fine.chunks_mut(band)).zip(&mut seen_in);
    crew.each(bands, |((first, band), noise_seen)| {
        for (y, out) in (first..).zip(band.chunks_exact_mut(width)) {
            *noise_seen |= crew.wide(SignalRow { view, y, mesh: &mesh, origin: (left, bottom), factor, out });
        }
    });
    bridge(view, work.fine);
    let signal = &*work.fine;
    let row = |y: Option<usize>| y.map_or(&[][..], |y| row_of(signal, width, y));
    crew.each((0..).step_by(rows).zip(work.signal.chunks_mut(band)), |(first, band): (usize, _)| {
        for (y, out) in (first..).zip(band.chunks_exact_mut(width)) {
            clean([row(y.checked_sub(1)), row(Some(y)), row(Some(y + 1))], out);
        }
    });
    seen_in.contains(&true).then_some(survey)
}

/// Keeps of a round that all parts of an image have answered what the next one may need: the mesh.
pub fn remember<L: Level>(view: &View<'_>, cell: usize, round: u32, whole: &dyn Whole, work: &mut Planes<'_, L>) {
    let pixels = (view.pixels, view.grid.width.get());
    let mut mesh = Mesh::over(work.mesh, view.image(), cell);
    mesh.asked((whole, round), pixels, |_| Seen::Undefined, &view.values, work.keys.again());
}

/// Pixels of a row whose sky is looked up together.
const PIECE: usize = 256;

/// Signal-to-noise of row `y`, 0 where a pixel is undefined or has no noise; whether any has. The mesh is read from a
/// column and row of its frame on; noise that is given counts `factor` times.
struct SignalRow<'a, L> {
    view: &'a View<'a>,
    y: usize,
    mesh: &'a Mesh<'a>,
    origin: (usize, usize),
    factor: f32,
    out: &'a mut [L],
}

impl<L: Level> Task for SignalRow<'_, L> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let SignalRow { view, y, mesh, origin: (left, bottom), factor, out } = self;
        let &View { pixels, grid, values, .. } = view;
        let (width, mut noise_seen) = (grid.width.get(), false);
        let pieces = row_of(pixels, width, y).chunks(PIECE).zip(out.chunks_mut(PIECE));
        for (x, (pixels, out)) in (0..).step_by(PIECE).zip(pieces) {
            let (mut level, mut noise) = ([0.0; PIECE], [0.0; PIECE]);
            let level = level.get_mut(..pixels.len()).unwrap_or(&mut []);
            let noise = noise.get_mut(..pixels.len()).unwrap_or(&mut []);
            mesh.along(left + x, bottom + y, level, noise);
            if let Some(map) = view.known.background {
                level.iter_mut().zip(from(map, width, x, y)).for_each(|(level, known)| *level = *known);
            }
            if let Some(map) = view.known.noise {
                let noise = noise.iter_mut().zip(from(map, width, x, y));
                noise.for_each(|(noise, known)| *noise = if known.is_finite() { factor * known } else { f32::NAN });
            }
            for (((out, &pixel), &level), &noise) in out.iter_mut().zip(pixels).zip(&*level).zip(&*noise) {
                let signal = (pixel - level) / noise;
                let usable = values.holds(pixel) & (noise > 0.0) & signal.is_finite();
                noise_seen |= usable;
                *out = L::of(if usable { signal } else { 0.0 });
            }
        }
        noise_seen
    }
}

/// Row `y` of a map from column `x` on.
fn from(map: &[f32], width: usize, x: usize, y: usize) -> &[f32] {
    row_of(map, width, y).get(x..).unwrap_or(&[])
}

/// Gives undefined pixels between two defined ones their mean.
fn bridge<L: Level>(view: &View<'_>, signal: &mut [L]) {
    if view.is_whole() {
        return;
    }
    let half = L::Weight::of(0.5);
    for at in (0..signal.len()).filter(|&at| !view.is_defined(at)) {
        let Some(pair) = view.between(at) else { continue };
        let [before, after] = pair.map(|at| signal.get(at).map_or(L::ZERO, |signal| signal.scaled(half)));
        if let Some(signal) = signal.get_mut(at) {
            *signal = before + after;
        }
    }
}

/// The median of the positive values of a sample; 1 where there are none.
fn typical(
    whole: Option<(&dyn Whole, Question)>,
    value: impl Fn(usize) -> f32,
    count: usize,
    width: usize,
    mut keys: Keys<'_>,
) -> f32 {
    let positive = |at: usize| Some(value(at)).filter(|value| value.is_finite() && *value > 0.0);
    match part::sorted(whole, (count, width, true), &mut keys, positive) {
        Some(sorted) if !sorted.is_empty() => median(sorted),
        _ => 1.0,
    }
}

/// Fills the fine and the smooth plane; gives the noise of the fine one.
pub fn smooth<L: Level>(view: &View<'_>, round: u32, work: &mut Planes<'_, L>, crew: &impl Crew) -> Tail<L> {
    let grid = view.grid;
    Weights::gauss(FINE).apply(work.signal, work.rows, work.fine, grid, crew);
    let (fine, masked) = (&*work.fine, Mask(work.masked.0));
    let value = |plane: &[L], at: usize| plane.get(at).copied().unwrap_or(L::ZERO);
    let questions = [Question::Fine(round), Question::FinePowers(round)];
    let tail = view.tail(questions, |at| value(fine, at), masked, work.keys.again());
    Weights::SPLINE.apply(fine, work.rows, work.smooth, grid, crew);
    let detail = |at: usize| value(fine, at) - value(work.smooth, at);
    let questions = [Question::Details(round), Question::DetailPowers(round)];
    let details = view.tail(questions, detail, masked, work.keys.again());
    let least = details.noise.scaled(L::Weight::of(LEPSKI));
    let band = (grid.width.get() * crew.rows(grid)).max(1);
    crew.each(work.smooth.chunks_mut(band).zip(fine.chunks(band)), |(smooth, fine)| {
        for (smooth, &fine) in smooth.iter_mut().zip(fine) {
            *smooth = if (fine - *smooth).magnitude() >= least { fine } else { *smooth };
        }
    });
    tail
}

/// Masks the sources that have a pixel above `peak` in the fine plane, what is within about
/// two pixels of them, and what has no signal.
pub fn mask_sources<L: Level>(view: &View<'_>, outline: L, peak: L, work: &mut Planes<'_, L>, crew: &impl Crew) {
    let grid = view.grid;
    let (source, perhaps) = (L::ONE, perhaps());
    let band = (grid.width.get() * crew.rows(grid)).max(1);
    crew.each(work.fine.chunks_mut(band).zip(work.smooth.chunks(band)), |(fine, smooth)| {
        for (fine, &smooth) in fine.iter_mut().zip(smooth) {
            *fine = match (smooth > outline, *fine > peak) {
                (true, true) => source,
                (true, false) => perhaps,
                _ => L::ZERO,
            };
        }
    });
    // From the peaks outwards, along the rows and back; what winds more than that stays unmasked.
    let (marks, width) = (&mut *work.fine, grid.width.get());
    for backwards in [false, true, false] {
        let pieces = marks.len().div_ceil(MARKS);
        for piece in 0..pieces {
            let first = MARKS * if backwards { pieces - 1 - piece } else { piece };
            let end = marks.len().min(first + MARKS);
            let has = |piece: &[L], wanted: L| piece.iter().fold(false, |any, &mark| any | (mark == wanted));
            let is_open = marks.get(first..end).is_some_and(|piece| has(piece, perhaps));
            // With a pixel on every side; where the plane ends there may be a source.
            let beside = |start: Option<usize>| marks.get(start?..)?.get(..MARKS + 2);
            let rows = || [first.checked_sub(width + 1), first.checked_sub(1), (first + width).checked_sub(1)];
            if is_open && rows().into_iter().any(|start| beside(start).is_none_or(|piece| has(piece, source))) {
                for index in first..end {
                    let index = if backwards { end - 1 - (index - first) } else { index };
                    mark_beside(marks, index, grid);
                }
            }
        }
    }
    for mark in marks.iter_mut() {
        *mark = if *mark < source { L::ZERO } else { *mark };
    }
    Weights::gauss(GROWTH).mark(work.fine, L::of(NEAR), work.rows, MaskMut(work.masked.0), grid, crew);
    mask_undefined(view, &mut work.masked);
}

/// Marks that are looked at together.
const MARKS: usize = 16;

/// The mark of a pixel that is a source's if it touches one.
fn perhaps<L: Level>() -> L {
    L::of(0.5)
}

/// Marks a pixel that may be a source's where it touches one.
fn mark_beside<L: Level>(marks: &mut [L], index: usize, grid: Grid) {
    let is = |at: usize, wanted: L| marks.get(at).is_some_and(|&mark| mark == wanted);
    if is(index, perhaps())
        && grid.neighbours(index).any(|at| is(at, L::ONE))
        && let Some(mark) = marks.get_mut(index)
    {
        *mark = L::ONE;
    }
}

/// Masks the pixels without a signal: they would count as quiet sky.
pub fn mask_undefined(view: &View<'_>, masked: &mut MaskMut<'_>) {
    if view.is_whole() {
        return;
    }
    (0..view.pixels.len()).filter(|&at| !view.has_signal(at)).for_each(|at| masked.set(at));
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;

    const X: f32 = f32::NAN;
    #[rustfmt::skip]
    const PIXELS: [f32; 20] = [
        1.0, X, 3.0, X, X,
        4.0, 5.0, X, 7.0, 8.0,
        X, X, 9.0, X, X,
        2.0, X, X, X, 6.0,
    ];

    #[test]
    fn undefined_pixels_between_defined_ones_have_their_mean() {
        let grid = Grid::of(20, 5).unwrap();
        let (mut keys, mut spare) = ([0; 20], [0; 20]);
        let view = View::of(&PIXELS, grid, Known::default(), Keys(&mut keys, &mut spare));
        let mut signal = PIXELS.map(|pixel| if pixel.is_nan() { 0.0 } else { pixel });
        bridge(&view, &mut signal);
        #[rustfmt::skip]
        let expected = [
            1.0, 2.0, 3.0, 0.0, 0.0,
            4.0, 5.0, 6.0, 7.0, 8.0,
            3.0, 0.0, 9.0, 0.0, 7.0,
            2.0, 0.0, 0.0, 0.0, 6.0,
        ];
        assert_eq!(signal, expected);
        let mut masked = [0];
        mask_undefined(&view, &mut MaskMut(&mut masked));
        for (at, signal) in expected.into_iter().enumerate() {
            assert_eq!(Mask(&masked).has(at), signal == 0.0, "pixel {at}");
            assert_eq!(view.has_signal(at), signal != 0.0);
        }
    }
}
