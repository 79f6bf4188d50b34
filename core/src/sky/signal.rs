//! The signal-to-noise of a frame, smoothed, and the mask of its sources.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::machine::Task;
use crate::arithmetic::{Level, Real};
use crate::config::Config;
use crate::plane::crew::{Crew, MOST_BANDS};
use crate::plane::mask::{Mask, MaskMut, WORD, bits_of, flooded};
use crate::plane::part::{self, Question, Whole};
use crate::plane::raster::{Sample, mixed};
use crate::plane::rows::row_of;
use crate::plane::smooth::Weights;
use crate::plane::sort::{Keys, median};
use crate::plane::walk::Walk;
use crate::sky::spike::clean;
use crate::sky::tail::Tail;
use crate::sky::view::{Known, View};
use crate::sky::{Mesh, Seen, Sky, Survey, Words};
use core::ops::Range;

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

/// What was seen of a frame when its sky was measured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measured {
    /// How the sky was measured.
    pub survey: Survey,
    /// By how much noise that is given counts.
    pub factor: f32,
    pub read: Read,
    /// Pixels in whose place is the median of their neighbours.
    pub spikes: u32,
}

impl Measured {
    /// Before the first look.
    pub const NOTHING: Measured = Measured {
        survey: Survey { cells: 0, measured: 0 },
        factor: 1.0,
        read: Read { has_noise: false, checksum: 0 },
        spikes: 0,
    };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.word(&mut self.survey.cells)?;
        codec.word(&mut self.survey.measured)?;
        codec.real(&mut self.factor)?;
        codec.flag(&mut self.read.has_noise)?;
        codec.word(&mut self.read.checksum)?;
        codec.word(&mut self.spikes)
    }
}

/// Signal-to-noise of every pixel from a mesh of cells as wide as the configuration says, spikes replaced; an undefined
/// pixel has the mean of the two between which it lies, or none. `round` counts how often it has been measured.
pub(crate) fn measure<L: Level, P: Sample>(
    (walk, crew): (&mut Walk, &impl Crew),
    measured: &mut Measured,
    view: &View<'_, P>,
    config: &Config,
    round: u32,
    work: &mut Planes<'_, L>,
) -> Option<()> {
    let (&View { frame, grid, known, values }, cell) = (view, config.sky.cell());
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
    let words = |first: usize| match all_defined {
        true => Words { defined: u32::MAX, sky: !masked.word(first) },
        false => Words::of(|bit| seen(first + bit)),
    };
    match known.whole {
        None => mesh.step((walk, crew), &mut measured.survey, &frame, words, &values, keys.again())?,
        // Nothing can be done before it is known.
        Some(whole) => match mesh.asked((whole, round), &frame, seen, &values, keys.again()) {
            Some(survey) => measured.survey = survey,
            None => {
                *measured = Measured { read: Read { has_noise: true, checksum: 0 }, ..Measured::NOTHING };
                return Some(());
            }
        },
    }
    let (left, bottom) = view.origin();
    let sky_at = |at: usize| mesh.at(left + at % grid.width, bottom + at / grid.width);
    if known.relative {
        let ratio = |at: usize| sky_at(at).noise / Known::value(known.noise, at).unwrap_or(1.0);
        let asked = known.whole.map(|whole| (whole, Question::Relative(round)));
        typical(walk, asked, &mut measured.factor, ratio, (frame.count(), width), keys)?;
    }
    // A part may have no pixel, where the image has.
    let has_noise = known.whole.is_some() && !sky_at(0).level.is_nan();
    let rows = crew.rows(grid).max(1);
    let band = (width * rows).max(1);
    let factor = measured.factor;
    walk.pass(grid.height, 2 * width, |part| {
        let read = if part.start == 0 { Read { has_noise, checksum: 0 } } else { measured.read };
        let mut seen_in = [read; MOST_BANDS];
        let bands = bands_of(&part, band, width, work.fine).zip(&mut seen_in);
        crew.each(bands, |((first, band), read)| {
            for (y, out) in (first..).zip(band.chunks_exact_mut(width)) {
                crew.wide(SignalRow { view, y, mesh: &mesh, origin: (left, bottom), factor, out, read });
            }
        });
        let sum = |sum: u32, other: &Read| sum.wrapping_add(other.checksum.wrapping_sub(read.checksum));
        let has_noise = seen_in.iter().any(|read| read.has_noise);
        measured.read = Read { has_noise, checksum: seen_in.iter().fold(read.checksum, sum) };
    })?;
    walk.pass(if view.is_whole() { 0 } else { grid.height }, width, |rows| bridge(view, rows, work.fine))?;
    let signal = &*work.fine;
    let row = |y: Option<usize>| y.map_or(&[][..], |y| row_of(signal, width, y));
    walk.pass(grid.height, width, |part| {
        let before = if part.start == 0 { 0 } else { measured.spikes };
        let mut spikes_in = [0; MOST_BANDS];
        let bands = bands_of(&part, band, width, work.signal).zip(&mut spikes_in);
        crew.each(bands, |((first, band), spikes): (_, &mut u32)| {
            for (y, out) in (first..).zip(band.chunks_exact_mut(width)) {
                *spikes += clean([row(y.checked_sub(1)), row(Some(y)), row(Some(y + 1))], config.spike_height, out);
            }
        });
        measured.spikes = before.saturating_add(spikes_in.iter().sum());
    })
}

/// The first rows and the pixels of bands in some rows of a plane.
fn bands_of<'p, L>(
    rows: &Range<usize>,
    band: usize,
    width: usize,
    plane: &'p mut [L],
) -> impl Iterator<Item = (usize, &'p mut [L])> + use<'p, L> {
    let part = plane.get_mut(rows.start * width..rows.end * width).unwrap_or(&mut []);
    (rows.start..).step_by((band / width.max(1)).max(1)).zip(part.chunks_mut(band.max(1)))
}

/// What was seen of some rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Read {
    /// Whether there is noise to divide by.
    pub has_noise: bool,
    /// As in [`Values`](crate::sky::Values).
    pub checksum: u32,
}

/// Keeps of a round that all parts of an image have answered what the next one may need: the mesh.
pub fn remember<L: Level, P: Sample>(
    view: &View<'_, P>,
    cell: usize,
    round: u32,
    whole: &dyn Whole,
    work: &mut Planes<'_, L>,
) {
    let mut mesh = Mesh::over(work.mesh, view.image(), cell);
    mesh.asked((whole, round), &view.frame, |_| Seen::Undefined, &view.values, work.keys.again());
}

/// Pixels of a row whose sky is looked up together.
const PIECE: usize = 256;

/// Signal-to-noise of row `y`, 0 where a pixel is undefined or has no noise. The mesh is read from a
/// column and row of its frame on; noise that is given counts `factor` times.
struct SignalRow<'a, L, P> {
    view: &'a View<'a, P>,
    y: usize,
    mesh: &'a Mesh<'a>,
    origin: (usize, usize),
    factor: f32,
    out: &'a mut [L],
    read: &'a mut Read,
}

impl<L: Level, P: Sample> Task for SignalRow<'_, L, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let SignalRow { view, y, mesh, origin: (left, bottom), factor, out, read } = self;
        let &View { frame, grid, values, .. } = view;
        let (width, mut noise_seen) = (grid.width.get(), false);
        let pieces = frame.row(y).chunks(PIECE).zip(out.chunks_mut(PIECE));
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
            for ((((out, pixel), &level), &noise), x) in out.iter_mut().zip(pixels).zip(&*level).zip(&*noise).zip(x..) {
                let pixel = pixel.value();
                if P::CHANGES {
                    read.checksum = read.checksum.wrapping_add(mixed((y * width + x) as u32, pixel));
                }
                let signal = (pixel - level) / noise;
                let usable = values.holds(pixel) & (noise > 0.0) & signal.is_finite();
                noise_seen |= usable;
                *out = L::signal(if usable { signal } else { 0.0 });
            }
        }
        read.has_noise |= noise_seen;
    }
}

/// Row `y` of a map from column `x` on.
fn from(map: &[f32], width: usize, x: usize, y: usize) -> &[f32] {
    row_of(map, width, y).get(x..).unwrap_or(&[])
}

/// Gives undefined pixels of some rows between two defined ones their mean.
fn bridge<L: Level, P: Sample>(view: &View<'_, P>, rows: Range<usize>, signal: &mut [L]) {
    let (half, width) = (L::Weight::of(0.5), view.grid.width.get());
    for at in (rows.start * width..rows.end * width).filter(|&at| !view.is_defined(at)) {
        let Some(pair) = view.between(at) else { continue };
        let [before, after] = pair.map(|at| signal.get(at).map_or(L::ZERO, |signal| signal.scaled(half)));
        if let Some(signal) = signal.get_mut(at) {
            *signal = before + after;
        }
    }
}

/// Finds the median of the positive values of a sample; 1 where there are none.
fn typical(
    walk: &mut Walk,
    whole: Option<(&dyn Whole, Question)>,
    found: &mut f32,
    value: impl Fn(usize) -> f32,
    (count, width): (usize, usize),
    mut keys: Keys<'_>,
) -> Option<()> {
    let positive = |at: usize| Some(value(at)).filter(|value| value.is_finite() && *value > 0.0);
    let sorted = part::sorted(walk, whole, (count, width, true), &mut keys, positive)?;
    walk.once(1, || *found = sorted.filter(|sorted| !sorted.is_empty()).map_or(1.0, median))
}

/// The noise of what is smoothed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Smoothing<L> {
    /// Of the fine plane.
    pub fine: Tail<L>,
    /// Of what is smoothed away from it.
    pub details: Tail<L>,
}

impl<L: Level> Smoothing<L> {
    /// Nothing is known.
    pub const NOTHING: Smoothing<L> = Smoothing { fine: Tail::UNKNOWN, details: Tail::UNKNOWN };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        self.fine.code(codec)?;
        self.details.code(codec)
    }
}

/// Fills the fine and the smooth plane, and finds their noise.
pub(crate) fn smooth<L: Level, P: Sample>(
    (walk, crew): (&mut Walk, &impl Crew),
    noise: &mut Smoothing<L>,
    view: &View<'_, P>,
    round: u32,
    work: &mut Planes<'_, L>,
) -> Option<()> {
    let (grid, width) = (view.grid, view.grid.width.get());
    walk.pass(grid.height, 2 * width, |rows| {
        Weights::gauss(FINE).apply_rows(rows, work.signal, work.rows, work.fine, grid, crew);
    })?;
    let (fine, masked) = (&*work.fine, Mask(work.masked.0));
    let value = |plane: &[L], at: usize| plane.get(at).copied().unwrap_or(L::ZERO);
    let questions = [Question::Fine(round), Question::FinePowers(round)];
    view.tail(walk, (&mut noise.fine, questions), |at| value(fine, at), masked, work.keys.again())?;
    walk.pass(grid.height, 2 * width, |rows| {
        Weights::SPLINE.apply_rows(rows, fine, work.rows, work.smooth, grid, crew);
    })?;
    let detail = |at: usize| value(fine, at) - value(work.smooth, at);
    let questions = [Question::Details(round), Question::DetailPowers(round)];
    view.tail(walk, (&mut noise.details, questions), detail, masked, work.keys.again())?;
    let least = noise.details.noise.scaled(L::Weight::of(LEPSKI));
    walk.pass(grid.height, width, |rows| {
        let bands = bands_of(&rows, width * crew.rows(grid), width, work.smooth);
        crew.each(bands, |(first, smooth)| {
            for (smooth, &fine) in smooth.iter_mut().zip(fine.get(first * width..).unwrap_or(&[])) {
                *smooth = if (fine - *smooth).magnitude() >= least { fine } else { *smooth };
            }
        });
    })
}

/// Masks the sources that have a pixel above `peak` in the fine plane, what is within about
/// two pixels of them, and what has no signal.
pub(crate) fn mask_sources<L: Level, P: Sample>(
    (walk, crew): (&mut Walk, &impl Crew),
    view: &View<'_, P>,
    outline: L,
    peak: L,
    work: &mut Planes<'_, L>,
) -> Option<()> {
    let (grid, width) = (view.grid, view.grid.width.get());
    // A bit for each pixel, in rows of whole words: is it a source's, and is it if it touches one.
    let words = width.div_ceil(WORD);
    let [sources, perhaps] = { [&mut *work.keys.0, &mut *work.keys.1] }
        .map(|room| room.get_mut(..words.saturating_mul(grid.height)).unwrap_or(&mut []));
    walk.pass(grid.height, width, |rows| {
        let (smooth, fine, band) = (&*work.smooth, &*work.fine, words * crew.rows(grid));
        let bands = bands_of(&rows, band, words, sources).zip(bands_of(&rows, band, words, perhaps));
        crew.each(bands, |((first, sources), (_, perhaps))| {
            let rows = sources.chunks_exact_mut(words.max(1)).zip(perhaps.chunks_exact_mut(words.max(1)));
            for (y, (sources, perhaps)) in (first..).zip(rows) {
                let (smooth, fine) = (row_of(smooth, width, y), row_of(fine, width, y));
                crew.wide(Marks { smooth, fine, outline, peak, sources, perhaps });
            }
        });
    })?;
    // From the peaks outwards, along the rows and back; what winds more than that stays unmasked.
    for backwards in [false, true, false] {
        walk.pass(grid.height, words, |rows| {
            for row in rows {
                let y = if backwards { grid.height - 1 - row } else { row };
                mark_beside((sources, row_of(perhaps, words, y)), y, words, backwards);
            }
        })?;
    }
    let sources = &*sources;
    walk.pass(grid.height, width, |rows| {
        crew.each(bands_of(&rows, width * crew.rows(grid), width, work.fine), |(first, marks)| {
            for (y, marks) in (first..).zip(marks.chunks_exact_mut(width)) {
                for (word, marks) in row_of(sources, words, y).iter().zip(marks.chunks_mut(WORD)) {
                    let mark = |bit: u32| if word >> bit & 1 == 1 { L::ONE } else { L::ZERO };
                    marks.iter_mut().zip(0..).for_each(|(out, bit)| *out = mark(bit));
                }
            }
        });
    })?;
    walk.pass(grid.height, 2 * width, |rows| {
        let masked = MaskMut(work.masked.0);
        Weights::gauss(GROWTH).mark_rows(rows, (work.fine, L::of(NEAR)), work.rows, masked, grid, crew);
    })?;
    mask_undefined(walk, view, &mut work.masked)
}

/// Of a row of pixels, which are a source's and which are if they touch one: a bit for each.
struct Marks<'a, L> {
    smooth: &'a [L],
    fine: &'a [L],
    outline: L,
    peak: L,
    sources: &'a mut [u32],
    perhaps: &'a mut [u32],
}

impl<L: Level> Task for Marks<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Marks { smooth, fine, outline, peak, sources, perhaps } = self;
        let pieces = smooth.chunks(WORD).zip(fine.chunks(WORD));
        for ((sources, perhaps), (smooth, fine)) in sources.iter_mut().zip(perhaps).zip(pieces) {
            let inside = bits_of(smooth, outline);
            let peaks = if inside == 0 { 0 } else { bits_of(fine, peak) };
            (*sources, *perhaps) = (inside & peaks, inside & !peaks);
        }
    }
}

/// Marks the pixels of row `y` that may be a source's where they touch one, one after another.
fn mark_beside((sources, perhaps): (&mut [u32], &[u32]), y: usize, words: usize, backwards: bool) {
    for place in 0..words {
        let at = if backwards { words - 1 - place } else { place };
        let open = perhaps.get(at).copied().unwrap_or(0);
        if open == 0 {
            continue;
        }
        let rows = [y.checked_sub(1), Some(y), Some(y + 1)];
        let near = rows.into_iter().flatten().fold(0, |near, y| near | Mask(row_of(sources, words, y)).beside(at));
        let marked = flooded(open, near & open, backwards);
        if let Some(word) = sources.get_mut(y * words + at) {
            *word |= marked;
        }
    }
}

/// Masks the pixels without a signal: they would count as quiet sky.
pub(crate) fn mask_undefined<P: Sample>(walk: &mut Walk, view: &View<'_, P>, masked: &mut MaskMut<'_>) -> Option<()> {
    let (rows, width) = (if view.is_whole() { 0 } else { view.grid.height }, view.grid.width.get());
    walk.pass(rows, width, |rows| {
        let pixels = rows.start * width..rows.end * width;
        pixels.filter(|&at| !view.has_signal(at)).for_each(|at| masked.set(at));
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::grid::Grid;
    use crate::plane::raster::Raster;

    extern crate std;

    /// Pixel by pixel along the rows, and back.
    #[test]
    fn what_may_be_a_sources_is_one_where_it_touches_one() {
        const HEIGHT: usize = 19;
        let mut state = 1u32;
        for width in [1usize, 2, 31, 32, 33, 64, 70] {
            let (words, grid) = (width.div_ceil(WORD), Grid::of(width * HEIGHT, width).expect("there are columns"));
            let mut draw = |percent: u32| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 8) % 100 < percent
            };
            let perhaps: std::vec::Vec<bool> = (0..grid.cells()).map(|_| draw(45)).collect();
            let mut sources: std::vec::Vec<bool> = perhaps.iter().map(|&perhaps| draw(4) && !perhaps).collect();
            let plane = |of: &[bool]| -> std::vec::Vec<u32> {
                let word = |row: &[bool]| row.iter().rev().fold(0, |word, &bit| word << 1 | u32::from(bit));
                of.chunks(width).flat_map(|row| row.chunks(WORD).map(word)).collect()
            };
            let (mut marked, perhaps_of_rows) = (plane(&sources), plane(&perhaps));
            for backwards in [false, true, false] {
                for row in 0..HEIGHT {
                    let y = if backwards { HEIGHT - 1 - row } else { row };
                    mark_beside((&mut marked, row_of(&perhaps_of_rows, words, y)), y, words, backwards);
                }
                for place in 0..grid.cells() {
                    let at = if backwards { grid.cells() - 1 - place } else { place };
                    sources[at] |= perhaps[at] && grid.neighbours(at).any(|near| sources[near]);
                }
                assert_eq!(marked, plane(&sources), "{width} columns, backwards {backwards}");
            }
        }
    }

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
        let view = View::of(Raster::of(&PIXELS, 5), grid, Known::default(), Keys(&mut keys, &mut spare));
        let mut signal = PIXELS.map(|pixel| if pixel.is_nan() { 0.0 } else { pixel });
        bridge(&view, 0..4, &mut signal);
        #[rustfmt::skip]
        let expected = [
            1.0, 2.0, 3.0, 0.0, 0.0,
            4.0, 5.0, 6.0, 7.0, 8.0,
            3.0, 0.0, 9.0, 0.0, 7.0,
            2.0, 0.0, 0.0, 0.0, 6.0,
        ];
        assert_eq!(signal, expected);
        let mut masked = [0];
        let _ = mask_undefined(&mut Walk::whole(), &view, &mut MaskMut(&mut masked));
        for (at, signal) in expected.into_iter().enumerate() {
            assert_eq!(Mask(&masked).has(at), signal == 0.0, "pixel {at}");
            assert_eq!(view.has_signal(at), signal != 0.0);
        }
    }
}
