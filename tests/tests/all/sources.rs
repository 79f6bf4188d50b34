//! What real optics and detectors make of a star stays one source, in every arithmetic.

use skyfront::extraction::segment;
use skyfront::pipeline::{Drive, Segmentation};
use skyfront::write::fits::Writer;
use skyfront_core::arithmetic::{F32, Fixed14, Level};
use skyfront_core::config::Config;
use skyfront_core::sources::flags::PLATEAU;
use skyfront_tests::command::{Folder, skyfront};
use skyfront_tests::noise::gaussian;
use std::fs::read_to_string;
use std::path::Path;

const SIDE: usize = 320;
/// Places of stars in a frame, not on pixel centres.
const PLACES: [(f32, f32); 16] = [
    (40.3, 41.2),
    (119.6, 38.9),
    (200.1, 42.5),
    (278.8, 39.7),
    (38.5, 120.0),
    (121.2, 121.7),
    (198.4, 118.3),
    (281.1, 122.9),
    (42.7, 199.4),
    (118.1, 201.8),
    (202.6, 200.5),
    (279.3, 198.2),
    (39.9, 280.6),
    (120.8, 278.4),
    (199.5, 281.3),
    (280.4, 279.1),
];

/// A star's light at a distance from its centre, with the wings of the atmosphere; 1 at the centre.
fn moffat(dx: f32, dy: f32, fwhm: f32) -> f32 {
    let beta = 2.8;
    let scale = 0.5 * fwhm / (2f32.powf(1.0 / beta) - 1.0).sqrt();
    (1.0 + (dx * dx + dy * dy) / (scale * scale)).powf(-beta)
}

/// Noise of 1, and a star of the shape at each place.
fn stars(seed: u64, shape: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    let mut pixels = gaussian(seed, SIDE * SIDE);
    for (x, y) in PLACES {
        for (at, pixel) in pixels.iter_mut().enumerate() {
            let (dx, dy) = ((at % SIDE) as f32 - x, (at / SIDE) as f32 - y);
            if dx.abs() < 39.0 && dy.abs() < 39.0 {
                *pixel += shape(dx, dy);
            }
        }
    }
    pixels
}

fn run<L: Level>(pixels: &[f32]) -> Segmentation {
    segment::<F32, L>(&Config::NOISE_AWARE, pixels, SIDE, &mut Drive::default()).expect("the frame can be segmented")
}

/// Every star is one source, and there is no other, in either arithmetic; what single precision found.
#[track_caller]
fn whole(pixels: &[f32]) -> Segmentation {
    let [found, fixed] = [run::<f32>(pixels), run::<Fixed14>(pixels)];
    assert_eq!([found.outcome.sources, fixed.outcome.sources], [PLACES.len() as u32; 2], "f32, q24");
    let mut labels: Vec<u32> = PLACES.iter().map(|&place| found.labels[nearest(place)]).collect();
    labels.sort_unstable();
    assert!(labels.iter().copied().eq(1..=PLACES.len() as u32), "{labels:?}");
    found
}

fn nearest((x, y): (f32, f32)) -> usize {
    y.round() as usize * SIDE + x.round() as usize
}

#[test]
fn a_star_out_of_focus_is_one_source() {
    let ring = |dx: f32, dy: f32| {
        let off = (dx.hypot(dy) - 5.0) / 1.3;
        (-0.5 * off * off).exp() * (1.0 + 0.05 * dx / (dx.hypot(dy) + 0.1))
    };
    for (seed, peak) in [(1, 60.0), (2, 300.0)] {
        whole(&stars(seed, |dx, dy| peak * ring(dx, dy)));
    }
}

/// The frame's typical source has the coma, which the mirror image of none explains.
#[test]
fn a_comatic_star_is_one_source() {
    let tail = [(0.0, 1.0), (1.5, 0.35), (3.0, 0.2), (4.5, 0.1)];
    let coma = |dx: f32, dy: f32| {
        tail.iter().map(|&(d, weight)| weight * moffat(dx - d, dy - 0.2 * d, 3.0 + 0.25 * d)).sum::<f32>()
    };
    for (seed, peak) in [(3, 60.0), (4, 600.0)] {
        whole(&stars(seed, |dx, dy| peak * coma(dx, dy)));
    }
}

#[test]
fn a_trailed_star_is_one_source() {
    let trail = |dx: f32, dy: f32| {
        let steps = (-9i8..=9).map(|step| 0.5 * f32::from(step));
        steps.map(|d| moffat(dx - d, dy - 0.4 * d, 3.0)).sum::<f32>() / 6.0
    };
    for (seed, peak) in [(5, 60.0), (6, 600.0)] {
        whole(&stars(seed, |dx, dy| peak * trail(dx, dy)));
    }
}

#[test]
fn a_saturated_star_is_one_source_with_a_plateau() {
    for (seed, full, peak) in [(7, 1500.0f32, 225.0f32), (8, 3000.0, 150.0)] {
        let found = whole(&stars(seed, |dx, dy| peak.min(full * moffat(dx, dy, 3.0))));
        assert_eq!(found.plateaus, [true; PLACES.len()]);
        for (x, y) in PLACES {
            let source = &found.sources[found.labels[nearest((x, y))] as usize - 1];
            let middle = |(from, to): (u32, u32)| 0.5 * (from + to) as f32;
            let off = (middle(source.columns) - x).hypot(middle(source.rows) - y);
            assert!(off < 3.0, "source {} lies {off} pixels beside its star", source.label);
        }
    }
    let round = whole(&stars(9, |dx, dy| 600.0 * moffat(dx, dy, 3.0)));
    assert_eq!(round.plateaus, [false; PLACES.len()]);
}

#[test]
fn the_catalogue_tells_of_a_plateau() {
    let folder = Folder::new("plateau");
    let place = folder.file("stars.fits");
    let pixels = stars(8, |dx, dy| 150f32.min(3000.0 * moffat(dx, dy, 3.0)));
    let mut writer = Writer::create(Path::new(&place)).expect("the file can be made");
    let row = |y: usize, out: &mut [f32]| out.copy_from_slice(&pixels[y * SIDE..(y + 1) * SIDE]);
    writer.image((SIDE, SIDE), &[], row).expect("the image can be written");
    writer.finish().expect("the file can be closed");
    let out = folder.file("out");
    skyfront(["segment", &place, "--out", &out, "--no-pictures", "--quiet"]);
    let text = read_to_string(Path::new(&out).join("catalog.csv")).expect("there is a catalogue");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let column = lines.next().and_then(|names| names.split(',').position(|name| name == "flags"));
    let column = column.expect("there is a column of flags");
    let flags: Vec<u32> = lines.filter_map(|line| line.split(',').nth(column)?.parse().ok()).collect();
    assert_eq!(flags, [PLATEAU; PLACES.len()]);
}

/// A galaxy with a companion on either side: where the mirror shows the other, nothing but its ellipse tells what a
/// galaxy has farther out.
#[test]
fn a_galaxy_keeps_its_outskirts() {
    let (x, y) = (160.2, 158.7);
    let mut pixels = gaussian(21, SIDE * SIDE);
    for (at, pixel) in pixels.iter_mut().enumerate() {
        let (dx, dy) = ((at % SIDE) as f32 - x, (at / SIDE) as f32 - y);
        let (along, across) = (0.8 * dx + 0.6 * dy, 0.8 * dy - 0.6 * dx);
        let companion = |off: f32| 60.0 * moffat(dx - 0.8 * off, dy - 0.6 * off, 3.0);
        *pixel += 200.0 * (-along.hypot(2.0 * across) / 16.0).exp() + companion(40.0) + companion(-40.0);
    }
    for found in [run::<f32>(&pixels), run::<Fixed14>(&pixels)] {
        let on_axis = |off: f32| found.labels[nearest((x + 0.8 * off, y + 0.6 * off))];
        let galaxy = on_axis(0.0);
        let companions = [on_axis(40.0), on_axis(-40.0)];
        assert!(companions[0] != companions[1] && !companions.contains(&galaxy), "{galaxy}, {companions:?}");
        let outskirts = [-60.0, -55.0, -50.0, 50.0, 55.0, 60.0].map(on_axis);
        assert_eq!(outskirts, [galaxy; 6], "{companions:?}");
    }
}

/// Each of two companions on opposite sides of a brighter star lies where the mirror shows the other.
#[test]
fn companions_opposite_each_other_are_sources() {
    let mut pixels = stars(13, |dx, dy| 40.0 * moffat(dx, dy, 3.0));
    let beside = |off: f32| PLACES.map(|(x, y)| (x + off, y + 0.5 * off));
    for (x, y) in beside(6.0).into_iter().chain(beside(-6.0)) {
        for (at, pixel) in pixels.iter_mut().enumerate() {
            let (dx, dy) = ((at % SIDE) as f32 - x, (at / SIDE) as f32 - y);
            *pixel += 20.0 * moffat(dx, dy, 3.0);
        }
    }
    let found = [run::<f32>(&pixels), run::<Fixed14>(&pixels)].map(|found| found.outcome.sources);
    assert_eq!(found, [3 * PLACES.len() as u32; 2], "f32, q24");
}

/// With the whole limits of peak and light half as many are found. On a faint wide disc noise reaches half
/// of them as often as it likes, but does not stand out.
#[test]
fn faint_stars_count_where_they_stand_out() {
    let mut found = [0, 0];
    for seed in 20..26 {
        let pixels = stars(seed, |dx, dy| 2.6 * moffat(dx, dy, 3.0));
        found[0] += run::<f32>(&pixels).outcome.sources;
        found[1] += run::<Fixed14>(&pixels).outcome.sources;
    }
    assert!(found.iter().all(|&found| found >= 46), "{found:?}");
    let disc = |dx: f32, dy: f32| 0.9 * (-0.5 * (dx * dx + dy * dy) / 100.0).exp();
    let found: u32 = (30..36).map(|seed| run::<f32>(&stars(seed, disc)).outcome.sources).sum();
    assert!(found < 20, "{found} sources on {} discs", 6 * PLACES.len());
}

/// Adds a star that hardly lights two by two pixels at each place: a Gaussian of FWHM 0.8.
fn add_sharp(pixels: &mut [f32], light: impl Fn(usize) -> f32) {
    // Its mean over the width of a pixel.
    let gauss = |off: f32| (-0.5 * (off / 0.34).powi(2)).exp() / (0.34 * std::f32::consts::TAU.sqrt());
    let part = |off: f32| (-10i8..=10).map(|step| gauss(off + f32::from(step) / 21.0)).sum::<f32>() / 21.0;
    for (index, (x, y)) in PLACES.into_iter().enumerate() {
        for (at, pixel) in pixels.iter_mut().enumerate() {
            *pixel += light(index) * part((at % SIDE) as f32 - x) * part((at / SIDE) as f32 - y);
        }
    }
}

#[test]
fn the_sharpest_stars_are_found_among_hot_pixels() {
    let mut pixels = gaussian(10, SIDE * SIDE);
    let light = |index: usize| [60.0, 120.0][index % 2];
    add_sharp(&mut pixels, light);
    for (index, (x, y)) in PLACES.into_iter().enumerate() {
        pixels[nearest((x + 40.0, y))] += light(index);
    }
    whole(&pixels);
}

/// Of 96 of a signal-to-noise of 22, some have four or five pixels inside their outlines.
#[test]
fn sharp_stars_need_few_pixels() {
    let mut found = [0, 0];
    for seed in 40..46 {
        let mut pixels = gaussian(seed, SIDE * SIDE);
        add_sharp(&mut pixels, |_| 27.0);
        found[0] += run::<f32>(&pixels).outcome.sources;
        found[1] += run::<Fixed14>(&pixels).outcome.sources;
    }
    assert_eq!(found, [96; 2]);
}

fn dense(seed: u64, count: usize) -> Vec<f32> {
    let random = gaussian(seed + 1000, 3 * count);
    let mut pixels = gaussian(seed, SIDE * SIDE);
    let within = |number: f32| (number * 1e4).rem_euclid(SIDE as f32);
    for star in random.chunks_exact(3) {
        let (x, y, peak) = (within(star[0]), within(star[1]), 12.0 * (1.2 * star[2]).exp());
        for (at, pixel) in pixels.iter_mut().enumerate() {
            let (dx, dy) = ((at % SIDE) as f32 - x, (at / SIDE) as f32 - y);
            if dx.abs() < 20.0 && dy.abs() < 20.0 {
                *pixel += peak * moffat(dx, dy, 3.0);
            }
        }
    }
    pixels
}

/// Pixels around one, corners included.
fn around(at: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (at % SIDE, at / SIDE);
    let near = |place: usize| place.saturating_sub(1)..(place + 2).min(SIDE);
    near(y).flat_map(move |y| near(x).map(move |x| y * SIDE + x))
}

#[test]
fn every_label_is_one_piece() {
    for seed in [11, 12] {
        let found = run::<f32>(&dense(seed, 900));
        assert!(found.outcome.sources > 300, "{} sources", found.outcome.sources);
        let mut seen = vec![false; SIDE * SIDE];
        let mut pieces = vec![0; found.sources.len()];
        for first in 0..seen.len() {
            let label = found.labels[first];
            if label == 0 || seen[first] {
                continue;
            }
            pieces[label as usize - 1] += 1;
            let mut open = vec![first];
            while let Some(at) = open.pop() {
                open.extend(around(at).filter(|&near| found.labels[near] == label && !seen[near]));
                around(at).filter(|&near| found.labels[near] == label).for_each(|near| seen[near] = true);
            }
        }
        let broken = pieces.iter().filter(|&&pieces| pieces != 1).count();
        assert_eq!(broken, 0, "labels in several pieces, of {}", pieces.len());
    }
}

/// A source whose brightest part was dropped forgot the others: of two that touch each other and
/// nothing else, one was blended.
#[test]
fn sources_are_blended_with_one_another() {
    for seed in 11..15 {
        let found = run::<f32>(&dense(seed, 300));
        let blended = found.blended.expect("the default divides");
        let mut touched = vec![Vec::new(); found.sources.len()];
        for at in 0..SIDE * SIDE {
            let label = found.labels[at];
            for near in around(at).map(|near| found.labels[near]).filter(|&near| near != 0 && near != label) {
                if label != 0 && !touched[label as usize - 1].contains(&near) {
                    touched[label as usize - 1].push(near);
                }
            }
        }
        for (index, touched) in touched.iter().enumerate() {
            let other = touched.first().map_or(0, |&label| label as usize);
            if touched.len() == 1 && blended[index] {
                assert!(blended[other - 1], "{} is blended, {other} is not, in sky {seed}", index + 1);
            }
        }
    }
}
