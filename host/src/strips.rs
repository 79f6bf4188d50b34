//! An image larger than memory: strips of whole rows, worked on one after the other, with the labels and the catalogue of
//! one piece.
//!
//! Each strip lays a halo of its neighbours' rows around its own, and what depends on all of the image all strips answer
//! together ([`crate::mosaic`]). Pixels and labels lie in files. A source belongs to the strip that has its first pixel. One
//! that goes on beyond what a strip sees is joined across the border, measured on its largest piece, and told of.

use crate::background::SkyMaps;
use crate::catalogue::{Catalogue, Request};
use crate::extraction;
use crate::input::{Input, Observed};
use crate::measure::Measured;
use crate::mosaic::{Answers, Asking, Seen, answer, is_beyond};
use crate::pipeline::{Drive, Segmentation, Values, segment};
use crate::read::Image;
use crate::write::{Scratch, WriteError};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::image::normalize::Extremes;
use skyfront_core::plane::part::{Part, Whole};
use skyfront_core::run::stage::Stage;
use skyfront_core::sky::cells_along;
use skyfront_core::sources::flags;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::time::{Duration, Instant};

/// The most pixels: places are told apart by 32 bits.
pub const MOST_PIXELS: u64 = (1 << 32) - 1;
/// The least rows around a strip: sources up to this size come out as in one piece.
const HALO: usize = 128;
/// Of the memory a strip leaves one part in so many to the rows of the catalogue.
const LEFT: u64 = 8;

/// How an image is divided: strips of as many rows, the last of what is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strips {
    /// Columns and rows of the image.
    pub size: (usize, usize),
    /// Rows of a strip.
    pub rows: usize,
    /// Rows around them: sources up to this size come out as in one piece.
    pub halo: usize,
}

impl Strips {
    /// Strips of so many rows; the halo holds half a cell of the sky's mesh, at least.
    pub fn new(config: &Config, size: (usize, usize), rows: usize) -> Strips {
        let cell = size.1.div_ceil(cells_along(size.1, config.sky.cell()).get());
        Strips { size, rows: rows.clamp(1, size.1.max(1)), halo: HALO.max(cell / 2 + 2) }
    }

    /// The highest strips that take at most so many bytes.
    ///
    /// # Errors
    /// The bytes of strips as low as their halo, where these are more: lower ones would mostly see again what others see.
    pub fn within(config: &Config, size: (usize, usize), bytes: u64) -> Result<Strips, u64> {
        let need = |rows: usize| Strips::new(config, size, rows).bytes(config);
        // One has no neighbours to remember the rows of.
        if need(size.1) <= bytes {
            return Ok(Strips::new(config, size, size.1));
        }
        let least = Strips::new(config, size, 1).halo.min(size.1);
        if need(least) > bytes {
            return Err(need(least));
        }
        let (mut fits, mut beyond) = (least, size.1 + 1);
        while beyond - fits > 1 {
            let middle = fits.midpoint(beyond);
            if need(middle) > bytes { beyond = middle } else { fits = middle }
        }
        // As high, but none much lower than the others.
        let count = size.1.div_ceil(fits);
        Ok(Strips::new(config, size, size.1.div_ceil(count)))
    }

    /// The bytes that a run takes at most, beside those of the program and but for images full of specks.
    pub fn bytes(&self, config: &Config) -> u64 {
        let (width, height) = self.size;
        let seen = height.min(self.rows + 2 * self.halo);
        let run = extraction::usual_memory(config, width, seen);
        let lines = self.count() * 2 * width * size_of::<u32>();
        (run + lines) as u64 / (LEFT - 1) * LEFT
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.size.1.div_ceil(self.rows)
    }

    /// A strip's own rows, and those that it sees.
    fn strip(&self, number: usize) -> (Range<usize>, Range<usize>) {
        let (first, end) = (number * self.rows, ((number + 1) * self.rows).min(self.size.1));
        (first..end, first.saturating_sub(self.halo)..(end + self.halo).min(self.size.1))
    }
}

/// Why a run over strips ended.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// What the core found wrong with the configuration or the image.
    #[error(transparent)]
    Core(#[from] Error),
    /// A file for pixels or labels could not be written or read.
    #[error(transparent)]
    Files(#[from] WriteError),
}

/// What a run over strips works on.
pub struct Task<'a> {
    /// The settings.
    pub config: &'a Config,
    /// The image, without its pixels.
    pub input: &'a Input,
    /// What is to be measured.
    pub request: &'a Request,
    /// How the image is divided.
    pub strips: Strips,
    /// The bits of all pixels, row-major.
    pub pixels: Scratch,
    /// Where labels go.
    pub labels: Scratch,
    /// Hears the round and the strip, both from 0.
    pub watch: &'a mut dyn FnMut(usize, usize),
}

/// What strips found together.
pub struct Found {
    /// As of the run over the whole image, without planes; of the sky a sample.
    pub run: Segmentation,
    /// The sources.
    pub catalogue: Catalogue,
    /// The labels of those that go on beyond what a strip sees, or are measured in what does.
    pub beyond: Vec<u32>,
    /// Time of the rounds before the last.
    pub asking: Duration,
    /// How the image was divided.
    pub strips: Strips,
    labels: Scratch,
    row: Vec<u32>,
    /// Of every strip's labels the final ones.
    numbers: Vec<Vec<u32>>,
}

impl Found {
    /// Gives a row of labels.
    ///
    /// # Errors
    /// What the system reports.
    pub fn row(&mut self, y: usize, each: impl FnOnce(&[u32])) -> Result<(), WriteError> {
        let (width, numbers) = (self.strips.size.0, &self.numbers[y / self.strips.rows]);
        self.row.clear();
        self.labels.get(y * width, width, |label| self.row.push(numbers[label as usize]))?;
        each(&self.row);
        Ok(())
    }
}

/// A source in a strip's view.
struct Row {
    /// The place of its first pixel there, from 1.
    id: u64,
    /// Whether that is one of the strip's own.
    owned: bool,
    /// Whether it, or something measured around it, goes on beyond what the strip sees.
    beyond: bool,
    measured: Measured,
}

/// What remains of a strip when its planes are gone.
struct Piece {
    /// Of every label the place of its first pixel, from 1; 0 for none.
    ids: Vec<u64>,
    rows: Vec<Row>,
    /// Labels in the rows below and above its own; empty at the edges of the image.
    beyond: [Vec<u32>; 2],
    /// The run and the catalogue, without what is here or in files.
    run: Segmentation,
    catalogue: Catalogue,
}

/// Segments an image strip by strip, and measures its sources.
///
/// Every strip goes as far as the answers reach, again and again, about a dozen times; most of these are short.
///
/// # Errors
/// What the core finds wrong with the image, or the system with the files.
pub fn run(mut task: Task<'_>) -> Result<Found, Failure> {
    let count = task.strips.count();
    let (mut answers, mut pieces) = (Answers::default(), (0..count).map(|_| None).collect::<Vec<Option<Piece>>>());
    let began = Instant::now();
    let mut asking = Duration::ZERO;
    for round in 0.. {
        let mut asked: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
        for (number, piece) in pieces.iter_mut().enumerate().filter(|(_, piece)| piece.is_none()) {
            (task.watch)(round, number);
            match task.strip(number, &answers)? {
                Ok(done) => *piece = Some(done),
                Err(own) => own.into_iter().for_each(|(name, own)| asked.entry(name).or_default().push(own)),
            }
        }
        if asked.is_empty() {
            break;
        }
        asked.iter().for_each(|(name, own)| answers.take(name, &answer(name, own)));
        asking = began.elapsed();
    }
    task.joined(pieces.into_iter().flatten().collect(), asking)
}

/// What a strip contributes to questions, by their names.
type Asked = Vec<(String, Vec<u8>)>;

impl Task<'_> {
    /// A strip as far as the answers go.
    fn strip(&mut self, number: usize, answers: &Answers) -> Result<Result<Piece, Asked>, Failure> {
        let (own, seen) = self.strips.strip(number);
        let (width, _) = self.strips.size;
        let mut pixels = Vec::with_capacity(seen.len() * width);
        self.pixels.get(seen.start * width, seen.len() * width, |bits| pixels.push(f32::from_bits(bits)))?;
        let rows = own.start - seen.start..own.end - seen.start;
        let part = Part { image: self.strips.size, origin: (0, seen.start), columns: 0..width, rows };
        let asking = Asking::new(part.clone(), answers);
        let mut nowhere = |_: &Values<'_>| {};
        let mut drive = Drive {
            whole: Some(&asking as &dyn Whole),
            keep_sums: false,
            threads: self.request.extras.threads,
            take_front: Some(&mut nowhere),
            ..Drive::default()
        };
        match segment(self.config, &pixels, width, seen.len(), &mut drive) {
            Err(Error::Waiting) => Ok(Err(asking.contributions())),
            run => Ok(Ok(self.piece(&part, pixels, run?)?)),
        }
    }

    /// What remains of a strip that was segmented.
    fn piece(&mut self, part: &Part, pixels: Vec<f32>, mut run: Segmentation) -> Result<Piece, Failure> {
        let Segmentation { width, height, .. } = run;
        let first_row = part.origin.1;
        run.sources.iter_mut().for_each(|source| {
            let row = first_row as u32;
            (source.y0, source.rows) = (source.y0 + row, (source.rows.0 + row, source.rows.1 + row));
        });
        let observed = &self.input.detected;
        let image = Image { pixels, height, ..observed.image.clone() };
        let input = Input { detected: Observed { image, ..observed.clone() }, ..self.input.clone() };
        let mut request = self.request.clone();
        request.extras.first_row = first_row;
        let mut catalogue = Catalogue::of(&input, &run, &request);
        let seen = Seen::of(&run, part);
        let own = part.rows.start * width..part.rows.end * width;
        self.labels.put((first_row + part.rows.start) * width, run.labels[own.clone()].iter().copied())?;
        let mut visible = vec![false; seen.firsts.len()];
        run.labels[own].iter().for_each(|&label| visible[label as usize] = true);
        let radius = request.extras.apertures.iter().copied().fold(0.0, f64::max);
        let owns = |first: u64| part.rows.contains(&((first / width as u64) as usize - first_row));
        let rows = std::mem::take(&mut catalogue.rows).into_iter().zip(1..).filter_map(|(mut measured, label)| {
            let (first, clipped) = (seen.firsts[label]?, seen.clipped[label]);
            let owned = owns(first);
            if clipped {
                measured.flags |= flags::TRUNCATED;
            }
            let beyond = clipped || is_beyond(&measured, radius, part, (width, height));
            (owned || clipped && visible[label]).then_some(Row { id: first + 1, owned, beyond, measured })
        });
        let rows = rows.collect();
        let line = |y: Option<usize>| y.and_then(|y| run.labels.chunks(width).nth(y)).unwrap_or(&[]).to_vec();
        let beyond = [line(part.rows.start.checked_sub(1)), line(Some(part.rows.end))];
        // As many values as the summary would look at.
        let sample: Vec<usize> = part.sample(width, part.stride()).collect();
        let sampled = |map: &[f32]| sample.iter().map(|&at| map[at]).collect();
        run.sky = run.sky.map(|SkyMaps { level, noise }| SkyMaps { level: sampled(&level), noise: sampled(&noise) });
        run.labels = Vec::new();
        run.sources = Vec::new();
        let ids = seen.firsts.iter().map(|first| first.map_or(0, |first| first + 1)).collect();
        Ok(Piece { ids, rows, beyond, run, catalogue })
    }

    /// The strips as one: sources that are cut off put together, labels in the order of first pixels, and one table.
    fn joined(mut self, mut pieces: Vec<Piece>, asking: Duration) -> Result<Found, Failure> {
        let (strips, mut same) = (self.strips, Same::default());
        for number in 1..pieces.len() {
            let border = number * strips.rows;
            let [before, after] = [&pieces[number - 1], &pieces[number]];
            same.agree((&before.ids, &self.row(border - 1)?), (&after.ids, &after.beyond[0]));
            same.agree((&before.ids, &before.beyond[1]), (&after.ids, &self.row(border)?));
        }
        let disputed: BTreeSet<u64> = same.disputed.iter().map(|&id| same.root(id)).collect();
        let mut chosen: BTreeMap<u64, Row> = BTreeMap::new();
        for mut row in pieces.iter_mut().flat_map(|piece| std::mem::take(&mut piece.rows)) {
            row.id = same.root(row.id);
            if disputed.contains(&row.id) {
                row.beyond = true;
                row.measured.flags |= flags::TRUNCATED;
            }
            let rank = |row: &Row| (row.owned && !row.beyond, row.measured.source.area, row.owned);
            if chosen.get(&row.id).is_none_or(|before| rank(&row) > rank(before)) {
                chosen.insert(row.id, row);
            }
        }
        let label: BTreeMap<u64, u32> = chosen.keys().copied().zip(1..).collect();
        let final_label = |&id: &u64| label.get(&same.root(id)).copied().unwrap_or(0);
        let numbers = pieces.iter().map(|piece| piece.ids.iter().map(final_label).collect()).collect();
        let beyond = chosen.values().zip(1..).filter(|(row, _)| row.beyond).map(|(_, label)| label).collect();
        let rows = chosen.into_values().zip(1..).map(|(row, label)| {
            let mut measured = row.measured;
            measured.source.label = label;
            measured
        });
        let rows: Vec<Measured> = rows.collect();
        let mut pieces = pieces.into_iter();
        let Some(Piece { mut run, mut catalogue, .. }) = pieces.next() else {
            return Err(Error::NothingDefined { pixels: 0 }.into());
        };
        pieces.for_each(|piece| add(&mut run, piece.run));
        (run.width, run.height) = strips.size;
        run.outcome.sources = rows.len() as u32;
        run.outcome.catalogued = run.outcome.sources;
        catalogue.lost = rows.iter().filter(|row| row.shape.x.is_nan()).count();
        catalogue.rows = rows;
        Ok(Found { run, catalogue, beyond, asking, strips, labels: self.labels, row: Vec::new(), numbers })
    }

    fn row(&mut self, y: usize) -> Result<Vec<u32>, WriteError> {
        let mut row = Vec::new();
        self.labels.get(y * self.strips.size.0, self.strips.size.0, |label| row.push(label))?;
        Ok(row)
    }
}

/// Adds what a further strip found.
fn add(run: &mut Segmentation, more: Segmentation) {
    let (of, own) = (&mut run.outcome, more.outcome);
    of.extremes = Extremes {
        least: of.extremes.least.min(own.extremes.least),
        greatest: of.extremes.greatest.max(own.extremes.greatest),
        defined: of.extremes.defined + own.extremes.defined,
    };
    of.unlabelled += own.unlabelled;
    of.unreached += own.unreached;
    if let (Some(sky), Some(own)) = (&mut run.sky, more.sky) {
        sky.level.extend(own.level);
        sky.noise.extend(own.noise);
    }
    let sum: &mut Vec<(Stage, Duration)> = &mut run.seconds;
    sum.extend(more.seconds);
    run.remarks.extend(more.remarks);
    let mut told = BTreeSet::new();
    run.remarks.retain(|remark| told.insert(remark.clone()));
}

/// Which sources are one, as they are cut off by what strips see.
#[derive(Default)]
struct Same {
    roots: BTreeMap<u64, u64>,
    disputed: BTreeSet<u64>,
}

impl Same {
    fn root(&self, mut id: u64) -> u64 {
        while let Some(&root) = self.roots.get(&id) {
            id = root;
        }
        id
    }

    /// Two strips on the same row: where they name different sources, these are one that is cut off.
    fn agree(&mut self, (ids, ours): (&[u64], &[u32]), (their_ids, theirs): (&[u64], &[u32])) {
        for (&our, &their) in ours.iter().zip(theirs) {
            let (one, other) = (ids[our as usize], their_ids[their as usize]);
            if one > 0 && other > 0 && one != other {
                let (one, other) = (self.root(one), self.root(other));
                self.disputed.insert(one);
                if one != other {
                    self.roots.insert(one.max(other), one.min(other));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outputs::{DATA, names, write, write_strips};
    use crate::truth::simulated;
    use crate::write::Products;
    use skyfront_core::simulate::Kind as Sky;
    use std::path::{Path, PathBuf};

    const WIDTH: usize = 210;
    const HEIGHT: usize = 640;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("skyfront-strips-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        folder
    }

    /// A sky on a slope, with a hole and an edge of filling.
    fn image(kind: Sky, seed: u32) -> Image {
        let mut image = simulated(kind, seed, WIDTH, HEIGHT).0;
        image.pixels.iter_mut().enumerate().for_each(|(at, pixel)| *pixel += (at / WIDTH) as f32 * 1e-4);
        (180..220).for_each(|y| image.pixels[y * WIDTH + 40..][..60].fill(f32::NAN));
        image.pixels.chunks_mut(WIDTH).for_each(|row| row[WIDTH - 7..].fill(0.0));
        image
    }

    fn request(columns: &str, radius: f64) -> Request {
        let names = [columns.to_owned()];
        let mut request = Request { columns: crate::catalogue::Choice::new(&names).unwrap(), ..Request::default() };
        (request.extras.apertures, request.extras.zero_point, request.map_only) = (vec![radius], Some(25.0), true);
        request.extras.threads = 2;
        request
    }

    fn in_one_piece(image: &Image, request: &Request, folder: &Path) -> Segmentation {
        let (config, input) = (&Config::NOISE_AWARE, Input::alone("sky", image.clone()));
        let run = segment(config, &image.pixels, WIDTH, HEIGHT, &mut Drive::default()).unwrap();
        let mut products = Products::plan(folder, &[], true).unwrap();
        write(&mut products, config, &input, &run, request).unwrap();
        products.publish().unwrap();
        run
    }

    fn in_strips(image: &Image, rows: usize, request: &Request, folder: &Path) -> Vec<u32> {
        let config = &Config::NOISE_AWARE;
        let mut products = Products::plan(folder, &[], true).unwrap();
        let (mut pixels, labels) = (products.scratch().unwrap(), products.scratch().unwrap());
        pixels.put(0, image.pixels.iter().map(|value| value.to_bits())).unwrap();
        let input = Input::alone("sky", Image { pixels: Vec::new(), ..image.clone() });
        let strips = Strips::new(config, (WIDTH, HEIGHT), rows);
        let mut rounds = 0;
        let mut watch = |round: usize, _: usize| rounds = round;
        let task = Task { config, input: &input, request, strips, pixels, labels, watch: &mut watch };
        let mut found = run(task).unwrap();
        write_strips(&mut products, config, &input, &mut found, request).unwrap();
        products.publish().unwrap();
        assert!(strips.count() == 1 || rounds > 3);
        found.beyond
    }

    fn file(folder: &Path, name: &str) -> Vec<u8> {
        std::fs::read(folder.join(name)).unwrap()
    }

    #[test]
    fn strips_have_the_bytes_of_one_piece() {
        let (folder, request) = (folder("bytes"), request("all", 3.0));
        for (kind, seed) in [(Sky::Noisy, 1), (Sky::Stars, 2), (Sky::Bright, 3)] {
            let image = image(kind, seed);
            let (one, parts) = (folder.join("one"), folder.join("strips"));
            assert!(in_one_piece(&image, &request, &one).sources.len() > 10);
            for rows in [200, 333, HEIGHT] {
                let beyond = in_strips(&image, rows, &request, &parts);
                assert!(beyond.is_empty(), "{beyond:?}");
                for name in [DATA[0]].into_iter().chain(names(&request)) {
                    assert!(file(&parts, name) == file(&one, name), "{name} of {kind:?} in strips of {rows}");
                }
                let summary =
                    |folder: &Path| -> serde_json::Value { serde_json::from_slice(&file(folder, DATA[1])).unwrap() };
                let (whole, mut ours) = (summary(&one), summary(&parts));
                assert_eq!(ours["strips"], HEIGHT.div_ceil(rows));
                ours.as_object_mut().unwrap().retain(|key, _| key != "strips" && key != "beyond_strips");
                ours["seconds"] = whole["seconds"].clone();
                assert_eq!(ours, whole);
            }
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// The rows of a catalogue without their labels.
    fn rows(folder: &Path) -> Vec<String> {
        let text = String::from_utf8(file(folder, "catalog.csv")).unwrap();
        text.lines().skip(1).map(|line| line.split_once(',').unwrap().1.to_owned()).collect()
    }

    #[test]
    fn what_is_longer_than_a_strip_sees_is_one_source_that_is_told_of_and_the_others_are_as_in_one_piece() {
        let (folder, request, (x, y)) = (folder("long"), request("default", 3.0), (100, 330));
        let mut image = image(Sky::Noisy, 5);
        image.pixels.iter_mut().enumerate().for_each(|(at, pixel)| {
            let off = ((at % WIDTH) as f32 - x as f32, (at / WIDTH) as f32 - y as f32);
            *pixel += 3.0 * (-(off.0 / 4.0).powi(2) - (off.1 / 110.0).powi(2)).exp();
        });
        let (one, parts) = (folder.join("one"), folder.join("strips"));
        // What is taken beside sources on request knows the outlines of their neighbours.
        let whole = in_one_piece(&image, &request, &one);
        let long = whole.sources[whole.labels[y * WIDTH + x] as usize - 1];
        assert!(long.rows.1 - long.rows.0 > 400, "{:?}", long.rows);
        let beyond = in_strips(&image, 100, &request, &parts);
        let labels = crate::read::image(&parts.join(DATA[0]), None).unwrap().pixels;
        let on_axis = (0..HEIGHT).map(|y| y * WIDTH + x).filter(|&at| whole.labels[at] == long.label);
        let found: BTreeSet<u32> = on_axis.map(|at| labels[at] as u32).collect();
        let Some(label) = found.first().filter(|_| found.len() == 1) else { panic!("{found:?}") };
        assert!(beyond.contains(label), "{label} {beyond:?}");
        let (expected, found) = (rows(&one), rows(&parts));
        assert_eq!(labels.iter().fold(0.0f32, |most, &label| most.max(label)), found.len() as f32);
        let differing: Vec<usize> =
            (1..).zip(&found).filter(|(_, row)| !expected.contains(row)).map(|(n, _)| n).collect();
        assert!(differing.iter().all(|&label| beyond.contains(&(label as u32))), "{differing:?} {beyond:?}");
        assert!(beyond.len() < found.len() / 4, "{} of {}", beyond.len(), found.len());
        let flags: Vec<u32> = csv(&parts, "flags");
        assert!(flags[*label as usize - 1] & flags::TRUNCATED > 0);
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn apertures_wider_than_what_a_strip_sees_are_told_of() {
        let (folder, image) = (folder("wide"), image(Sky::Noisy, 6));
        let beyond = in_strips(&image, 320, &request("default", 160.0), &folder);
        let rows: Vec<f64> = csv(&folder, "y");
        // Of 640 rows each strip sees 448; a circle goes one pixel farther than its radius.
        let is_near = |y: f64| if y < 319.5 { y + 161.0 > 447.0 } else { y - 161.0 < 192.0 };
        let near: Vec<u32> = (1..).zip(&rows).filter(|(_, y)| is_near(**y - 1.0)).map(|(label, _)| label).collect();
        assert!(near.len() > 3 && near.len() < rows.len(), "{near:?}");
        assert_eq!(beyond, near);
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// A column of a catalogue.
    fn csv<T: std::str::FromStr<Err: std::fmt::Debug>>(folder: &Path, name: &str) -> Vec<T> {
        let text = String::from_utf8(file(folder, "catalog.csv")).unwrap();
        let at = text.lines().next().unwrap().split(',').position(|column| column == name).unwrap();
        text.lines().skip(1).map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
    }

    #[test]
    fn strips_are_as_high_as_memory_allows_and_no_lower_than_their_halo() {
        let config = &Config::NOISE_AWARE;
        let size = (40_000, 40_000);
        // What the program takes beside them is left out.
        let strips = Strips::within(config, size, 1_976_000_000).unwrap();
        assert!(strips.bytes(config) <= 1_976_000_000, "{strips:?}");
        assert_eq!((strips.count(), strips.halo), (56, 314), "as images.md says");
        let higher = Strips::new(config, size, strips.rows + strips.rows / strips.count() + 1);
        assert!(higher.bytes(config) > 1_976_000_000, "{higher:?}");
        let whole = Strips::within(config, (500, 500), 2_000_000_000).unwrap();
        assert_eq!((whole.count(), whole.rows), (1, 500));
        let exact = Strips::new(config, (300, 300), 300);
        assert_eq!(Strips::within(config, (300, 300), exact.bytes(config)), Ok(exact));
        let need = Strips::within(config, size, 1_000_000).unwrap_err();
        assert_eq!(need, Strips::new(config, size, strips.halo).bytes(config));
        assert!(Strips::within(config, size, need).is_ok_and(|strips| strips.bytes(config) <= need));
    }
}
