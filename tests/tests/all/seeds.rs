//! A front that grows from seeds within objects until edges hold it.

use skyfront::crosscheck::parameters;
use skyfront::input::StartMap;
use skyfront::pipeline::{Drive, Segmentation, segment, segment_in};
use skyfront::reference;
use skyfront_core::arithmetic::{F32, Q11, Q24};
use skyfront_core::config::{Config, Filter, Motion, Rescale, Scheme, Start};
use skyfront_tests::command::{Folder, messages, skyfront};
use skyfront_tests::fits_bytes::{Header, samples};
use std::fs;

const WIDTH: usize = 90;
const HEIGHT: usize = 76;
/// Centres and radii of two discs.
const LARGE: (f64, f64, f64) = (30.0, 34.0, 14.0);
const SMALL: (f64, f64, f64) = (70.0, 50.0, 8.0);

const BASE: Config = Config {
    rescale: Rescale::None,
    filter: Filter::None,
    start: Start::Given,
    motion: Motion::Outward,
    ..Config::PAPER_F160
};

fn distance(at: usize, (x, y, _): (f64, f64, f64)) -> f64 {
    ((at % WIDTH) as f64 - x).hypot((at / WIDTH) as f64 - y)
}

/// Flat discs with edges about two pixels wide.
fn discs() -> Vec<f32> {
    let light = |at, disc: (f64, f64, f64)| 0.5 - 0.5 * (distance(at, disc) - disc.2).tanh();
    (0..WIDTH * HEIGHT).map(|at| (light(at, LARGE) + light(at, SMALL)) as f32).collect()
}

/// A seed of one pixel, four pixels off the centre of the large disc.
fn seed() -> StartMap {
    let mut map = vec![0.0; WIDTH * HEIGHT];
    map[34 * WIDTH + 34] = 1.0;
    StartMap::of(&map, WIDTH, 2.0)
}

fn grown<R>(config: &Config, run: impl Fn(&Config, &mut Drive<'_>) -> R) -> R {
    let seed = seed();
    run(config, &mut Drive { start: Some(&seed), ..Drive::default() })
}

/// The labels are the large disc, up to its edge, and nothing else.
fn assert_large_disc(labels: &[u32], what: &str) {
    for (at, &label) in labels.iter().enumerate() {
        let d = distance(at, LARGE);
        assert!(label == 1 || d > LARGE.2 - 3.0, "{what}: {d} pixels from the centre is left out");
        assert!(label == 0 || d < LARGE.2 + 1.5, "{what}: {d} pixels from the centre is taken in");
    }
}

#[test]
fn a_seed_grows_to_the_edge_of_its_object_by_every_scheme() {
    let pixels = discs();
    let schemes = [Scheme::Fd, Scheme::Sl, Scheme::FdCurvature, Scheme::SlCurvature, Scheme::FdFiltered];
    for scheme in schemes.into_iter().chain([Scheme::FastMarching]) {
        for band in [None, Some(8.0)] {
            let config = Config { band, t_max: 4.0, nu: 0.01, ..BASE.with_scheme(scheme) };
            let run = grown(&config, |config, drive| segment(config, &pixels, WIDTH, HEIGHT, drive)).expect("f32");
            let what = format!("{scheme:?}, band {band:?}");
            assert_large_disc(&run.labels, &what);
            let inside: Vec<bool> = run.front.iter().map(|&u| u > 0.0).collect();
            assert!(run.labels.iter().zip(&inside).all(|(&label, &inside)| (label > 0) == inside), "{what}");
        }
    }
}

#[test]
fn arithmetics_threads_and_slices_agree() {
    let pixels = discs();
    let config = Config { band: Some(8.0), ..BASE };
    let of = |run: Result<Segmentation, _>| run.expect("a good image").labels;
    let whole = of(grown(&config, |config, drive| segment_in::<F32>(config, &pixels, WIDTH, HEIGHT, drive)));
    let q24 = of(grown(&config, |config, drive| segment_in::<Q24>(config, &pixels, WIDTH, HEIGHT, drive)));
    let q11 = of(grown(&config, |config, drive| segment_in::<Q11>(config, &pixels, WIDTH, HEIGHT, drive)));
    assert_large_disc(&q11, "q11");
    let apart = |other: &[u32]| whole.iter().zip(other).filter(|(a, b)| a != b).count();
    assert!(apart(&q24) <= 3 && apart(&q11) <= 12, "q24 {}, q11 {}", apart(&q24), apart(&q11));
    for (threads, slice) in [(1, 1), (1, 13), (3, HEIGHT)] {
        let other = of(grown(&config, |config, drive| {
            (drive.threads, drive.slice) = (threads, slice);
            segment(config, &pixels, WIDTH, HEIGHT, drive)
        }));
        assert_eq!(other, whole, "{threads} threads, slices of {slice}");
    }
}

/// The same front upside down: the reference shrinks what is outside of the seed.
#[test]
fn the_reference_agrees() {
    let pixels = discs();
    let wide: Vec<f64> = pixels.iter().map(|&v| v.into()).collect();
    for scheme in [Scheme::Fd, Scheme::Sl, Scheme::FdCurvature] {
        let config = Config { t_max: 3.0, nu: 0.01, ..BASE.with_scheme(scheme) };
        let mut u0 = vec![0.0; pixels.len()];
        seed().fill::<F32>(&config, (WIDTH, HEIGHT), &mut u0);
        let upside_down =
            reference::Plane::from_fn(WIDTH, HEIGHT, |i, j| -f64::from(u0[j as usize * WIDTH + i as usize]));
        let truth = reference::run_from(&parameters(&config), &wide, upside_down).expect("a good image");
        let run = grown(&config, |config, drive| segment(config, &pixels, WIDTH, HEIGHT, drive)).expect("f32");
        assert_eq!(run.outcome.steps, truth.steps);
        for (at, (core, truth)) in run.front.iter().zip(truth.u.values()).enumerate() {
            assert!((f64::from(*core) + truth).abs() < 5e-4, "{scheme:?}, pixel {at}: {core} and {truth}");
        }
    }
}

#[test]
fn seeds_from_the_command_line_are_a_map_or_places() {
    let folder = Folder::new("seeds");
    let [image, map, table, out] = ["sky.fits", "map.fits", "seeds.csv", "out"].map(|name| folder.file(name));
    let header = || Header::primary(-32, &[WIDTH as u64, HEIGHT as u64]);
    let write = |file: &str, values: &[f64]| fs::write(file, header().with(samples(-32, values))).expect("a file");
    write(&image, &discs().into_iter().map(f64::from).collect::<Vec<_>>());
    let marked: Vec<f64> = (0..WIDTH * HEIGHT).map(|at| f64::from(u8::from(at == 34 * WIDTH + 34))).collect();
    write(&map, &marked);
    // Places count from 1.
    fs::write(&table, "x,y\n35,35\n").expect("a table");
    let run = |start: &str, more: &[&str]| {
        let words = ["segment", &image, "--preset", "paper-f160", "--rescale", "none", "--out", &out, "--overwrite"];
        skyfront(words.into_iter().chain(["--no-pictures", "--json", "--start", start]).chain(more.iter().copied()))
    };
    let labels = |start: &str, more: &[&str]| {
        let output = run(start, more);
        assert!(output.status.success(), "{}", messages(&output));
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        (summary["labels_crc32"].clone(), summary["sources"].clone())
    };
    let outward = ["--motion", "outward"];
    let grown = labels(&map, &outward);
    assert_eq!(labels(&table, &outward), grown);
    assert_ne!(labels(&map, &[]), grown);
    for (start, more, expected) in [
        ("frame", &outward[..], "skyfront: --motion is not used by --start frame; it needs --start map"),
        (&table, &["--motion", "outward", "--scheme", "chan-vese"], "skyfront: --motion is not used by --scheme"),
    ] {
        let output = run(start, more);
        assert_eq!(output.status.code(), Some(2));
        assert!(messages(&output).starts_with(expected), "{}", messages(&output));
    }
    fs::write(&table, "x,y\n35,35\n91,3\n").expect("a table");
    let output = run(&table, &outward);
    let expected = format!("--start: {table}: place 2 is not in the image");
    assert!(messages(&output).contains(&expected), "{}", messages(&output));
}
