//! The catalogue of a run that is done: what the sources measure on the frame, in parts like the run itself.

use super::{Extractor, Progress};
use crate::arithmetic::Level;
use crate::error::Error;
use crate::plane::raster::Sample;
use crate::plane::rows::{row_of, used};
use crate::sky::Mesh;
use crate::sky::view::{Known, View};
use crate::sources::flags;
use crate::sources::measure::{Around, Pixel, Sums};
use crate::sources::tree::Region;

/// How far the sources of a run are measured: so many parts of one row, first those of the frame, then of the table of
/// regions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measuring(usize);

impl<L: Level, P: Sample> Extractor<'_, '_, L, P> {
    /// Measures the sources of a run that is done, at most `rows` rows (at least one) of the frame, or as many regions
    /// as these have pixels; tells whether all is measured. `sums` has the source of label 1 first, and starts with
    /// [`Sums::EMPTY`]. These are the numbers that the command line prints, to the bit.
    ///
    /// Reads each pixel of a source once more. A run that was restored in between measures again from the start.
    ///
    /// # Errors
    /// [`Error::Length`] for fewer `sums` than sources, [`Error::Together`] for a run that is not done.
    pub fn measure(&mut self, so_far: &mut Measuring, rows: usize, sums: &mut [Sums]) -> Result<bool, Error> {
        let Progress::Done(found) = self.progress() else {
            let (choice, value) = ("the catalogue", "of sources");
            return Err(Error::Together { choice, value, other: "a run", wanted: "that is done" });
        };
        let needed = found.sources as usize;
        if sums.len() < needed {
            return Err(Error::Length { name: "sums", given: sums.len(), needed });
        }
        let Extractor { config, grid, view, work, state, .. } = self;
        let regions = work.regions.get(..found.regions).unwrap_or(&[]);
        let (width, height) = (grid.width.get(), grid.height);
        let all = height.saturating_add(regions.len().div_ceil(width));
        let part = so_far.0..so_far.0.saturating_add(rows.max(1)).min(all);
        so_far.0 = part.end.max(so_far.0);
        let mesh = &Mesh::over(work.mesh, view.image(), config.sky.cell());
        let scene = Scene { view, labels: work.labels, mesh, factor: state.measured.factor };
        part.clone().take_while(|&y| y < height).for_each(|y| scene.measure(y, sums));
        let of_row = |row: usize| row.saturating_sub(height).saturating_mul(width).min(regions.len());
        mark(regions.get(of_row(part.start)..of_row(part.end)).unwrap_or(&[]), work.labels, sums);
        Ok(so_far.0 >= all)
    }
}

/// The frame with its labels and its sky.
struct Scene<'s, 'a, P> {
    view: &'s View<'a, P>,
    labels: &'s [u32],
    mesh: &'s Mesh<'s>,
    /// Noise that was given counts so many times.
    factor: f32,
}

impl<P: Sample> Scene<'_, '_, P> {
    /// Adds the pixels of a row to the sums of their sources.
    fn measure(&self, y: usize, sums: &mut [Sums]) {
        let gain = self.view.known.camera.map(|camera| f64::from(camera.gain));
        let width = self.view.grid.width.get();
        for (x, label) in used(row_of(self.labels, width, y)) {
            if let Some(sums) = of_label(sums, label) {
                let at = y.saturating_mul(width).saturating_add(x);
                sums.add((x as u32, y as u32), self.around(at, label), self.pixel((x, y), at), gain);
            }
        }
    }

    /// A pixel with its sky; `None` where it is undefined.
    fn pixel(&self, (x, y): (usize, usize), at: usize) -> Option<Pixel> {
        let (view, (left, bottom)) = (self.view, self.view.origin());
        let Known { background, noise, camera, .. } = view.known;
        let value = view.frame.value(at).filter(|_| view.is_defined(at))?;
        let sky = self.mesh.at(left.saturating_add(x), bottom.saturating_add(y));
        let background = f64::from(Known::value(background, at).unwrap_or(sky.level));
        let noise = f64::from(Known::value(noise, at).map_or(sky.noise, |noise| self.factor * noise));
        let is_saturated = camera.is_some_and(|camera| value >= camera.saturation);
        let is_defined = (f64::from(value) - background).is_finite() && noise.is_finite();
        is_defined.then_some(Pixel { value, background, noise, is_saturated })
    }

    /// What lies beside a pixel of a source. Sources that touch are not blended by that: the tree knows better.
    fn around(&self, at: usize, label: u32) -> Around {
        let (mut flags, mut same, mut beside) = (0, 0, 0);
        for near in self.view.grid.touching(at, 4) {
            let other = self.labels.get(near).copied().unwrap_or(0);
            flags |= if other == 0 && !self.view.is_defined(near) { flags::MASKED } else { 0 };
            same += u32::from(other == label);
            beside += 1;
        }
        Around { flags: flags | if beside < 4 { flags::TRUNCATED } else { 0 }, is_outline: same < 4 }
    }
}

/// Marks sources that were divided from each other, and those that end in a plateau.
fn mark<L: Level>(regions: &[Region<L>], labels: &[u32], sums: &mut [Sums]) {
    let mut mark = |label: u32, flags: u32| of_label(sums, label).into_iter().for_each(|sums| sums.mark(flags));
    for region in regions {
        if let Some(other) = region.divided_from(labels) {
            // The other may remember a part that was dropped.
            mark(region.label, flags::BLENDED);
            mark(other, flags::BLENDED);
        }
        if region.plateau > 0.0 {
            mark(region.label, flags::PLATEAU);
        }
    }
}

fn of_label(sums: &mut [Sums], label: u32) -> Option<&mut Sums> {
    (label as usize).checked_sub(1).and_then(|index| sums.get_mut(index))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{COUNT, HEIGHT, Room, WIDTH, counts};
    use super::*;
    use crate::arithmetic::Fixed14;
    use crate::config::Config;
    use crate::plane::camera::Camera;
    use crate::plane::raster::{BadPixel, Raster};

    extern crate std;
    use std::vec;
    use std::vec::Vec;

    const CAMERA: Camera = Camera { black: 0.0, gain: 2.0, read_noise: 5.0, saturation: 2000.0, psf_sigma: 1.0 };

    /// What a run measures in parts of so many rows.
    fn measured<L: Level>(frame: &[u16], known: Known<'_>, rows: usize) -> Vec<Sums> {
        let mut room = Room::<L>::full_of(0);
        let frame = Raster::new(frame, WIDTH, HEIGHT, WIDTH).expect("a frame");
        let mut run = Extractor::over(&Config::NOISE_AWARE, frame, known, room.work()).expect("room enough");
        let found = loop {
            if let Progress::Done(found) = run.poll(usize::MAX).expect("a sky with noise") {
                break found;
            }
        };
        let mut sums = vec![Sums::default(); found.sources as usize];
        let (mut so_far, mut calls) = (Measuring::default(), 1);
        while !run.measure(&mut so_far, rows, &mut sums).expect("room for all") {
            calls += 1;
        }
        assert!(calls >= HEIGHT.div_ceil(rows), "{calls} calls of {rows} rows");
        assert_eq!(sums.iter().map(|sums| sums.area).sum::<u32>(), found.mask_pixels);
        sums
    }

    #[test]
    fn parts_of_any_size_and_all_arithmetics_measure_the_same_numbers() {
        let frame = counts(4000.0, WIDTH);
        let whole = measured::<f32>(&frame, Known::default(), usize::MAX);
        assert!(whole.len() > 1);
        for rows in [1, 7, HEIGHT] {
            assert_eq!(measured::<f32>(&frame, Known::default(), rows), whole, "{rows} rows");
        }
        // Two arithmetics may outline differently, but measure the same pixels.
        for sums in measured::<Fixed14>(&frame, Known::default(), 7) {
            let same = whole
                .iter()
                .find(|other| (other.columns, other.rows, other.area) == (sums.columns, sums.rows, sums.area));
            assert!(same.is_none_or(|same| same.centroid() == sums.centroid()));
        }
    }

    #[test]
    fn a_camera_tells_saturation_and_the_noise_of_light() {
        let frame = counts(4000.0, WIDTH);
        let without = measured::<f32>(&frame, Known::default(), 9);
        let peaks = without.iter().filter_map(|sums| sums.peak).map(|(peak, _)| peak);
        // The brightest pixel just reaches it.
        let camera = Camera { saturation: peaks.fold(0.0, f32::max), ..CAMERA };
        let with = measured::<f32>(&frame, Known { camera: Some(&camera), ..Known::default() }, 9);
        let is_saturated = |sums: &&Sums| sums.flags() & flags::SATURATED != 0;
        let saturated = [&without, &with].map(|sums| sums.iter().filter(is_saturated).count());
        assert!(saturated[0] == 0 && (1..with.len()).contains(&saturated[1]), "{saturated:?}");
        for (without, with) in without.iter().zip(&with) {
            assert_eq!((with.area, with.peak), (without.area, without.peak));
            assert_eq!(with.peak.is_some_and(|(peak, _)| peak >= camera.saturation), is_saturated(&with));
            assert!(with.centroid().errors.0 > without.centroid().errors.0);
        }
    }

    #[test]
    fn undefined_pixels_and_the_edge_are_flags() {
        let frame = counts(4000.0, WIDTH);
        let whole = measured::<f32>(&frame, Known::default(), 5);
        let star = whole.iter().max_by(|a, b| a.total().total_cmp(&b.total())).expect("a star");
        let (_, (x, y)) = star.peak.expect("defined pixels");
        let bad = [BadPixel { x: x as u16, y: y as u16 }];
        let with = measured::<f32>(&frame, Known { bad: &bad, ..Known::default() }, 5);
        let masked: Vec<&Sums> = with.iter().filter(|sums| sums.flags() & flags::MASKED != 0).collect();
        assert!(masked.len() == 1 && masked[0].rows.0 <= y && masked[0].rows.1 >= y, "{masked:?}");
        let at_edge = |sums: &&Sums| {
            sums.columns.0 == 0
                || sums.rows.0 == 0
                || sums.columns.1 == WIDTH as u32 - 1
                || sums.rows.1 == HEIGHT as u32 - 1
        };
        for sums in &whole {
            assert_eq!(at_edge(&sums), sums.flags() & flags::TRUNCATED != 0, "{sums:?}");
        }
        assert!(whole.iter().any(|sums| at_edge(&sums)));
    }

    #[test]
    fn what_is_too_early_or_too_short_is_refused() {
        let frame = counts(4000.0, WIDTH);
        let frame = Raster::new(&frame, WIDTH, HEIGHT, WIDTH).expect("a frame");
        let mut room = Room::<f32>::full_of(0);
        let mut run = Extractor::over(&Config::NOISE_AWARE, frame, Known::default(), room.work()).expect("room enough");
        let measure = |run: &mut Extractor<'_, '_, f32, u16>, sums: &mut [Sums]| {
            run.measure(&mut Measuring::default(), COUNT, sums)
        };
        assert!(matches!(measure(&mut run, &mut []), Err(Error::Together { .. })));
        while !matches!(run.poll(usize::MAX), Ok(Progress::Done(_))) {}
        assert!(
            matches!(measure(&mut run, &mut []), Err(Error::Length { name: "sums", given: 0, needed }) if needed > 0)
        );
        let camera = Camera { gain: 0.0, ..CAMERA };
        let mut room = Room::<f32>::full_of(0);
        let refused = Extractor::over(
            &Config::NOISE_AWARE,
            frame,
            Known { camera: Some(&camera), ..Known::default() },
            room.work(),
        );
        assert!(matches!(refused, Err(Error::Parameter { name: "gain", .. })));
    }
}
