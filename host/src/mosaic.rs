//! An image in parts, each segmented on its own with what all of them know together.
//!
//! A run over a part ends when it comes to a question that has no answer yet, and tells what the part contributes. The
//! contributions of all parts become the answer, in any order of parts; then every run begins anew, until none is left.

use crate::measure::Measured;
use crate::segmentation::Segmentation;
use skyfront_core::plane::part::{CELL_WORDS, Part, Question, Whole};
use skyfront_core::plane::rows::used;
use skyfront_core::sources::typical::{MOST, RECORD};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The answers so far, by the name of the question; little-endian words or sums.
#[derive(Clone, Debug, Default)]
pub struct Answers(BTreeMap<String, Answer>);

#[derive(Clone, Debug)]
enum Answer {
    Words(Vec<u32>),
    Sums([f64; 4]),
}

/// How the contributions to a question become its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Added.
    Sums,
    /// All keys, the least first.
    Sorted,
    /// All records of so many words, by the first word and then the second; the first ones only.
    Records { words: usize, most: usize },
}

impl Kind {
    /// Of the question with this name.
    fn of(name: &str) -> Kind {
        let word = name.split('(').next().unwrap_or(name);
        match word {
            "Filling" | "Defined" => Kind::Sums,
            _ if word.ends_with("Powers") => Kind::Sums,
            "Cells" => Kind::Records { words: CELL_WORDS, most: usize::MAX },
            "Typical" => Kind::Records { words: RECORD, most: MOST },
            _ => Kind::Sorted,
        }
    }
}

/// The answer to the question with this name, of the contributions of all parts.
pub fn answer(name: &str, contributions: &[Vec<u8>]) -> Vec<u8> {
    let words = || contributions.iter().flat_map(|bytes| words(bytes)).collect::<Vec<u32>>();
    match Kind::of(name) {
        Kind::Sums => {
            let add = |sum: [f64; 4], own: [f64; 4]| std::array::from_fn(|index| sum[index] + own[index]);
            let sum = contributions.iter().map(|bytes| sums(bytes)).fold([0.0; 4], add);
            sum.iter().flat_map(|value| value.to_le_bytes()).collect()
        }
        Kind::Sorted => {
            let mut keys = words();
            keys.sort_unstable();
            bytes(keys)
        }
        Kind::Records { words: length, most } => {
            let all = words();
            let mut records: Vec<&[u32]> = all.chunks_exact(length).collect();
            records.sort_by_key(|record| (record[0], record[1]));
            bytes(records.into_iter().take(most).flatten().copied())
        }
    }
}

fn bytes(words: impl IntoIterator<Item = u32>) -> Vec<u8> {
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

fn words(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word))
}

fn sums(bytes: &[u8]) -> [f64; 4] {
    let mut sums = [0.0; 4];
    sums.iter_mut().zip(bytes.as_chunks::<8>().0).for_each(|(sum, bytes)| *sum = f64::from_le_bytes(*bytes));
    sums
}

impl Answers {
    /// Takes the answer to a question.
    pub fn take(&mut self, name: &str, bytes: &[u8]) {
        let answer = match Kind::of(name) {
            Kind::Sums => Answer::Sums(sums(bytes)),
            _ => Answer::Words(words(bytes).collect()),
        };
        self.0.insert(name.to_owned(), answer);
    }
}

/// A part that asks.
///
/// ```
/// use skyfront::mosaic::{Answers, Asking, answer};
/// use skyfront::pipeline::{Drive, segment};
/// use skyfront::truth::simulated;
/// use skyfront_core::config::Config;
/// use skyfront_core::error::Error;
/// use skyfront_core::plane::part::{Part, Whole};
/// use skyfront_core::simulate::Kind;
/// use std::collections::BTreeMap;
///
/// const SIDE: usize = 128;
/// let (image, _) = simulated(Kind::Bright, 5, SIDE, SIDE);
/// // Two halves, without a halo; both are asked until all questions have answers.
/// let halves = [0, SIDE / 2].map(|row| &image.pixels[row * SIDE..][..SIDE * SIDE / 2]);
/// let mut answers = Answers::default();
/// let labels = loop {
///     let (mut labels, mut contributions) = (Vec::new(), Vec::new());
///     for (half, row) in halves.into_iter().zip([0, SIDE / 2]) {
///         let (columns, rows) = (0..SIDE, row..row + SIDE / 2);
///         let part = Part { image: (SIDE, SIDE), origin: (0, row), columns, rows };
///         let asking = Asking::new(part, &answers);
///         let mut drive = Drive { whole: Some(&asking as &dyn Whole), ..Drive::default() };
///         match segment(&Config::NOISE_AWARE, half, SIDE, SIDE / 2, &mut drive) {
///             Ok(run) => labels.extend(run.labels),
///             Err(Error::Waiting) => contributions.extend(asking.contributions()),
///             Err(error) => return Err(error),
///         }
///     }
///     if contributions.is_empty() {
///         break labels;
///     }
///     let mut questions: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
///     for (name, own) in contributions {
///         questions.entry(name).or_default().push(own);
///     }
///     questions.iter().for_each(|(name, own)| answers.take(name, &answer(name, own)));
/// };
/// assert_eq!(labels.len(), SIDE * SIDE);
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug)]
pub struct Asking<'a> {
    part: Part,
    answers: &'a Answers,
    own: Mutex<Vec<(String, Vec<u8>)>>,
}

impl<'a> Asking<'a> {
    /// With the answers so far.
    pub fn new(part: Part, answers: &'a Answers) -> Asking<'a> {
        Asking { part, answers, own: Mutex::default() }
    }

    /// What the part contributes to the questions that had no answer.
    pub fn contributions(self) -> Vec<(String, Vec<u8>)> {
        self.own.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    fn own(&self) -> MutexGuard<'_, Vec<(String, Vec<u8>)>> {
        self.own.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn get(&self, question: Question) -> Option<&Answer> {
        self.answers.0.get(&name(question))
    }

    fn contribute(&self, question: Question, own: Vec<u8>) {
        self.own().push((name(question), own));
    }
}

fn name(question: Question) -> String {
    format!("{question:?}")
}

impl Whole for Asking<'_> {
    fn part(&self) -> Part {
        self.part.clone()
    }

    fn words(&self, question: Question, own: &mut dyn Iterator<Item = u32>) -> Option<&[u32]> {
        match self.get(question) {
            Some(Answer::Words(words)) => Some(words),
            _ => {
                self.contribute(question, bytes(own));
                None
            }
        }
    }

    fn sums(&self, question: Question, own: &mut dyn FnMut() -> [f64; 4]) -> Option<[f64; 4]> {
        match self.get(question) {
            Some(Answer::Sums(sums)) => Some(*sums),
            _ => {
                self.contribute(question, own().iter().flat_map(|value| value.to_le_bytes()).collect());
                None
            }
        }
    }

    fn knows(&self, question: Question) -> bool {
        self.get(question).is_some()
    }

    fn is_waiting(&self) -> bool {
        !self.own().is_empty()
    }
}

/// Of every label of a part, by its number: where it begins, and whether it may go on beyond the part.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The index of its first pixel in the image; none for labels without pixels.
    pub firsts: Vec<Option<u64>>,
    /// Whether it touches a border of the part beyond which the image goes on.
    pub clipped: Vec<bool>,
}

impl Seen {
    /// What is seen of the labels of a run over a part.
    pub fn of(run: &Segmentation, part: &Part) -> Seen {
        let (width, height, labels) = (run.width, run.height, run.sources.len() + 1);
        let mut seen = Seen { firsts: vec![None; labels], clipped: vec![false; labels] };
        for (y, row) in run.labels.chunks(width.max(1)).enumerate() {
            for (x, label) in used(row) {
                let (column, row) = part.place((x, y));
                seen.firsts[label as usize].get_or_insert(row as u64 * part.image.0 as u64 + column as u64);
                let ends = [(x, column, part.image.0, width), (y, row, part.image.1, height)];
                seen.clipped[label as usize] |= ends.iter().any(|&(at, place, image, length)| {
                    (at == 0 && place > 0) || (at + 1 == length && place + 1 < image)
                });
            }
        }
        seen
    }
}

/// Pixels within which the background beside a source is looked for, from its bounding box.
const BESIDE: f64 = 24.0;
/// Kron's first moment is taken within so many times the ellipse of the second moments.
const MOMENTS: f64 = 6.0;

/// Whether something that is measured around a source, in circles of at most this radius among others, lies beyond a part
/// of `size` where the image goes on. Places of the source are those in the image.
pub fn is_beyond(row: &Measured, radius: f64, part: &Part, size: (usize, usize)) -> bool {
    let kron = if row.kron_radius.is_finite() { row.kron_radius } else { 0.0 };
    let reach = (MOMENTS * row.shape.wide_axes().0).max(kron).max(radius) + 1.0;
    let beyond = |centre: f64, (first, last): (u32, u32), origin: usize, length: usize, image: usize| {
        let (low, high) =
            ((centre - reach).min(f64::from(first) - BESIDE), (centre + reach).max(f64::from(last) + BESIDE));
        (low < origin as f64 && origin > 0) || (high > (origin + length) as f64 - 1.0 && origin + length < image)
    };
    beyond(row.shape.x, row.source.columns, part.origin.0, size.0, part.image.0)
        || beyond(row.shape.y, row.source.rows, part.origin.1, size.1, part.image.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{Drive, segment};
    use skyfront_core::config::Config;
    use skyfront_core::error::Error;
    use skyfront_core::simulate::Kind as Sky;

    const WIDTH: usize = 420;
    const HEIGHT: usize = 390;
    const DEPTH: usize = 64;

    /// The parts of an image that is divided at a column and a row.
    fn parts(at: (usize, usize)) -> Vec<Part> {
        let sides = |at: usize, length: usize| [(0, at), (at, length)];
        let one = |(left, right): (usize, usize), (bottom, top): (usize, usize)| {
            let origin = (left.saturating_sub(DEPTH), bottom.saturating_sub(DEPTH));
            Part {
                image: (WIDTH, HEIGHT),
                origin,
                columns: left - origin.0..right - origin.0,
                rows: bottom - origin.1..top - origin.1,
            }
        };
        sides(at.1, HEIGHT).into_iter().flat_map(|rows| sides(at.0, WIDTH).map(|columns| one(columns, rows))).collect()
    }

    /// The pixels of a part with those around it, and its width.
    fn cut(image: &[f32], part: &Part) -> (Vec<f32>, usize) {
        let right = (part.origin.0 + part.columns.end + DEPTH).min(WIDTH);
        let top = (part.origin.1 + part.rows.end + DEPTH).min(HEIGHT);
        let rows = (part.origin.1..top).flat_map(|y| &image[y * WIDTH + part.origin.0..y * WIDTH + right]);
        (rows.copied().collect(), right - part.origin.0)
    }

    /// What parts find together.
    #[derive(Default)]
    struct Found {
        /// The first pixel of the source of every pixel, 0 for none.
        firsts: Vec<usize>,
        noise: Vec<f32>,
        /// How often they asked.
        rounds: usize,
    }

    fn in_parts(config: &Config, image: &[f32], at: (usize, usize)) -> Found {
        let (parts, mut answers, mut found) = (parts(at), Answers::default(), Found::default());
        loop {
            let mut asked: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
            (found.firsts, found.noise) = (vec![0; WIDTH * HEIGHT], vec![0.0; WIDTH * HEIGHT]);
            for part in &parts {
                let (pixels, width) = cut(image, part);
                let whole = Asking::new(part.clone(), &answers);
                let mut drive = Drive { whole: Some(&whole), ..Drive::default() };
                match segment(config, &pixels, width, pixels.len() / width, &mut drive) {
                    Err(Error::Waiting) => {}
                    Err(error) => panic!("{error}"),
                    Ok(run) => paste(&run, part, &mut found),
                }
                whole.contributions().into_iter().for_each(|(name, own)| asked.entry(name).or_default().push(own));
            }
            if asked.is_empty() {
                return found;
            }
            found.rounds += 1;
            asked.iter().for_each(|(name, own)| answers.take(name, &answer(name, own)));
        }
    }

    fn paste(run: &Segmentation, part: &Part, found: &mut Found) {
        let first = firsts_of(&run.labels, run.width, |place| part.place(place));
        for at in part.own(run.width) {
            let (x, y) = part.place((at % run.width, at / run.width));
            found.firsts[y * WIDTH + x] = first[run.labels[at] as usize];
            found.noise[y * WIDTH + x] = run.sky.as_ref().expect("it is measured").noise[at];
        }
    }

    /// Of every label the index of its first pixel in the image, from 1.
    fn firsts_of(labels: &[u32], width: usize, place: impl Fn((usize, usize)) -> (usize, usize)) -> Vec<usize> {
        let mut firsts = vec![0; labels.iter().max().map_or(1, |&most| most as usize + 1)];
        for (at, &label) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
            let (x, y) = place((at % width, at / width));
            if firsts[label as usize] == 0 {
                firsts[label as usize] = y * WIDTH + x + 1;
            }
        }
        firsts
    }

    #[test]
    fn parts_find_together_what_one_piece_has() {
        for (kind, seed) in [(Sky::Noisy, 1), (Sky::Stars, 2), (Sky::Bright, 3)] {
            let mut image = crate::truth::simulated(kind, seed, WIDTH, HEIGHT).0.pixels;
            // A slope, a hole, and a frame of filling.
            image.iter_mut().enumerate().for_each(|(at, pixel)| *pixel += (at % WIDTH) as f32 * 0.01);
            image[150 * WIDTH + 200] = f32::NAN;
            image.chunks_exact_mut(WIDTH).for_each(|row| row[..9].fill(0.0));
            let config = Config::NOISE_AWARE;
            let whole = segment(&config, &image, WIDTH, HEIGHT, &mut Drive::default()).expect("an image");
            let expected = firsts_of(&whole.labels, WIDTH, |place| place);
            let expected: Vec<usize> = whole.labels.iter().map(|&label| expected[label as usize]).collect();
            for at in [(200, 190), (133, 301)] {
                let Found { firsts, rounds, .. } = in_parts(&config, &image, at);
                let other = firsts.iter().zip(&expected).filter(|(found, expected)| found != expected).count();
                assert_eq!(other, 0, "{other} pixels differ, {kind:?} at {at:?}");
                assert!(rounds < 16, "{rounds}");
            }
            assert!(whole.outcome.sources > 3);
        }
    }

    /// Of values that are cut off at the black level, or as coarse as their noise, the skewness of the noise counts.
    #[test]
    fn parts_of_what_is_cut_off_or_coarse_find_what_one_piece_has() {
        for (kind, seed) in [(Sky::Noisy, 6), (Sky::Stars, 7)] {
            let image = crate::truth::simulated(kind, seed, WIDTH, HEIGHT).0.pixels;
            let mut sorted = image.clone();
            sorted.sort_by(f32::total_cmp);
            let (middle, low) = (sorted[sorted.len() / 2], sorted[sorted.len() / 6]);
            let noises = |pixel: f32| (pixel - middle) / (middle - low);
            let cut_off: Vec<f32> = image.iter().map(|&pixel| (8.0 * noises(pixel)).round().max(0.0)).collect();
            let coarse: Vec<f32> = image.iter().map(|&pixel| (noises(pixel) + 20.0).round()).collect();
            for image in [cut_off, coarse] {
                let config = Config::NOISE_AWARE;
                let whole = segment(&config, &image, WIDTH, HEIGHT, &mut Drive::default()).expect("an image");
                let first = firsts_of(&whole.labels, WIDTH, |place| place);
                let found = in_parts(&config, &image, (200, 190));
                assert!(found.noise == whole.sky.expect("it is measured").noise, "{kind:?}");
                assert!(
                    found.firsts.into_iter().eq(whole.labels.iter().map(|&label| first[label as usize])),
                    "{kind:?}"
                );
                assert!(whole.outcome.sources > 50);
            }
        }
    }

    /// Most cells are crowded, and have the noise of their darkest pixels.
    #[test]
    fn parts_of_a_crowd_have_the_noise_of_one_piece() {
        let mut image = crate::truth::simulated(Sky::Noisy, 4, WIDTH, HEIGHT).0.pixels;
        let mut state = 1u32;
        let mut draw = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as usize
        };
        for _ in 0..9000 {
            let (x, y, peak) = (2 + draw() % (WIDTH - 4), 2 + draw() % (HEIGHT - 4), 900.0 / (1 + draw() % 60) as f32);
            for (row, column) in (0..5).flat_map(|row| (0..5).map(move |column| (row, column))) {
                let off = (row as f32 - 2.0).powi(2) + (column as f32 - 2.0).powi(2);
                image[(y + row - 2) * WIDTH + x + column - 2] += peak * (-off / 2.0).exp();
            }
        }
        let config = Config::NOISE_AWARE;
        let whole = segment(&config, &image, WIDTH, HEIGHT, &mut Drive::default()).expect("an image");
        assert!(whole.outcome.sources > 500 && whole.remarks.iter().any(|remark| remark.contains("cells of the sky")));
        // Sources hang together farther than parts see.
        let sky = whole.sky.expect("it is measured");
        assert_eq!(in_parts(&config, &image, (200, 190)).noise, sky.noise);
    }

    #[test]
    fn answers_do_not_depend_on_the_order_of_parts() {
        let parts = [bytes([5, 1]), bytes([3]), Vec::new()];
        let back: Vec<Vec<u8>> = parts.iter().rev().cloned().collect();
        assert_eq!(answer("Fine(2)", &parts), bytes([1, 3, 5]));
        assert_eq!(answer("Fine(2)", &back), answer("Fine(2)", &parts));
        let cells = [bytes([1, 9, 9, 9, 9, 9, 9]), bytes([0, 7, 7, 7, 7, 7, 7])];
        assert_eq!(answer("Cells(0)", &cells), bytes([0, 7, 7, 7, 7, 7, 7, 1, 9, 9, 9, 9, 9, 9]));
        let one = [1.0f64, 2.0, 0.0, 0.0].iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
        assert_eq!(sums(&answer("FinePowers(0)", &[one.clone(), one])), [2.0, 4.0, 0.0, 0.0]);
    }
}
