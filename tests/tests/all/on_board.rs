//! The catalogue on board and that on the ground: the same numbers, to the bit.

use skyfront::planes::SignalRoom;
use skyfront_core::config::Config;
use skyfront_core::plane::camera::Camera;
use skyfront_core::plane::raster::Raster;
use skyfront_core::run::extract::catalogue::Measuring;
use skyfront_core::run::extract::{Extractor, Progress};
use skyfront_core::run::frame::Frame;
use skyfront_core::run::workspace::regions;
use skyfront_core::simulate::{Kind, Sky};
use skyfront_core::sky::view::Known;
use skyfront_core::sources::flags::{APERTURE, BLENDED, NEIGHBOUR, SATURATED, TRUNCATED};
use skyfront_core::sources::measure::Sums;
use skyfront_tests::command::{Folder, messages, skyfront};
use skyfront_tests::fits_bytes::{Header, samples};
use std::fs;

const SIZE: (usize, usize) = (150, 110);
const CAMERA: Camera = Camera { black: 0.0, gain: 2.5, read_noise: 4.0, saturation: 4000.0, psf_sigma: 1.0 };

/// A simulated sky as a camera of 14 bits counts it.
fn counts(kind: Kind, seed: u32) -> Vec<u16> {
    let (mut sky, mut frame) = (Sky::new(kind, seed, SIZE.0, SIZE.1), Vec::new());
    for y in 0..SIZE.1 {
        let mut row = [0.0; SIZE.0];
        let Ok(()) = sky.row(y, &mut row);
        frame.extend(row.iter().map(|&value| (500.0 + 8000.0 * value).clamp(0.0, 16383.0) as u16));
    }
    frame
}

/// What a run on board measures, a few rows at a time.
fn on_board(frame: &[u16]) -> Vec<Sums> {
    let (config, all) = (&Config::NOISE_AWARE, regions(SIZE.0, SIZE.1));
    let mut room = SignalRoom::<f32>::new(config, (frame.len(), SIZE.0), SIZE, all, 1);
    let raster = Raster::new(frame, SIZE.0, SIZE.1, SIZE.0).expect("a frame");
    let known = Known { camera: Some(&CAMERA), ..Known::default() };
    let mut run = Extractor::over(config, raster, known, room.workspace()).expect("room enough");
    let sources = loop {
        if let Progress::Done(found) = run.poll(7).expect("a sky with noise") {
            break found.sources as usize;
        }
    };
    let (mut sums, mut so_far) = (vec![Sums::default(); sources], Measuring::default());
    while !run.measure(&mut so_far, 7, &mut sums).expect("room for all") {}
    sums
}

/// The columns that the program writes, by name.
fn on_the_ground(frame: &[u16]) -> impl Fn(&str) -> Vec<f64> {
    let folder = Folder::new("on-board");
    let image = folder.file("frame.fits");
    let values: Vec<f64> = frame.iter().map(|&count| f64::from(count)).collect();
    let header = Header::primary(16, &[SIZE.0 as u64, SIZE.1 as u64]);
    fs::write(&image, header.with(samples(16, &values))).expect("a file can be written");
    let output = skyfront([
        "segment",
        &image,
        "--out",
        &folder.file("out"),
        "--gain",
        &CAMERA.gain.to_string(),
        "--saturation",
        &CAMERA.saturation.to_string(),
    ]);
    assert!(output.status.success(), "{}", messages(&output));
    move |name| {
        let mut table = fitsio::FitsFile::open(folder.path().join("out/catalog.fits")).expect("a FITS file");
        let hdu = table.hdu("CATALOG").expect("the table");
        hdu.read_col(&mut table, name).expect(name)
    }
}

/// A number with as many digits as columns have.
fn rounded(value: f64) -> f64 {
    format!("{value:.8e}").parse().expect("a number")
}

/// What a column is of the sums of a source.
type Value = fn(&Sums) -> f64;

#[test]
fn the_catalogue_on_board_is_the_one_on_the_ground() {
    const GAIN: Option<f64> = Some(2.5);
    const APERTURES: u32 = APERTURE | NEIGHBOUR;
    let columns: [(&str, Value); 22] = [
        // Columns and rows count from 1 on the ground.
        ("x", |sums| sums.centroid().x + 1.0),
        ("y", |sums| sums.centroid().y + 1.0),
        ("xmin", |sums| f64::from(sums.columns.0 + 1)),
        ("xmax", |sums| f64::from(sums.columns.1 + 1)),
        ("ymin", |sums| f64::from(sums.rows.0 + 1)),
        ("ymax", |sums| f64::from(sums.rows.1 + 1)),
        ("area", |sums| f64::from(sums.area)),
        ("sum", Sums::total),
        ("mean", |sums| sums.total() / sums.defined()),
        ("peak", |sums| sums.peak.map_or(f64::NAN, |(peak, _)| f64::from(peak))),
        ("background", |sums| sums.levels().background),
        ("noise", |sums| sums.levels().noise),
        ("threshold", |sums| sums.levels().threshold),
        ("x2", |sums| sums.centroid().moments.0),
        ("y2", |sums| sums.centroid().moments.1),
        ("xy", |sums| sums.centroid().moments.2),
        ("errx2", |sums| sums.centroid().errors.0),
        ("erry2", |sums| sums.centroid().errors.1),
        ("errxy", |sums| sums.centroid().errors.2),
        ("flux", |sums| sums.flux(GAIN).value),
        ("flux_err", |sums| sums.flux(GAIN).error),
        ("flags", |sums| f64::from(sums.flags())),
    ];
    let mut flags = 0;
    for (kind, seed) in [(Kind::Bright, 3), (Kind::Noisy, 8), (Kind::Bright, 30)] {
        let frame = counts(kind, seed);
        let (board, ground) = (on_board(&frame), on_the_ground(&frame));
        assert!(board.len() > 2, "{} sources", board.len());
        for (name, value) in columns {
            let printed = ground(name);
            assert_eq!(printed.len(), board.len());
            for (label, (printed, sums)) in (1..).zip(printed.iter().zip(&board)) {
                // Apertures are measured on the ground alone.
                let printed = if name == "flags" { f64::from(*printed as u32 & !APERTURES) } else { *printed };
                assert_eq!(rounded(value(sums)).to_bits(), printed.to_bits(), "{name} of source {label}: {printed}");
            }
        }
        flags |= board.iter().fold(0, |flags, sums| flags | sums.flags());
    }
    let seen = SATURATED | TRUNCATED | BLENDED;
    assert_eq!(flags & seen, seen, "the skies have sources that are saturated, cut off and divided");
}
