//! Sources that are found in several bands together.

use skyfront::pipeline::{Drive, segment};
use skyfront::read::image;
use skyfront::write::Entry;
use skyfront::write::fits::Writer;
use skyfront_core::config::Config;
use skyfront_tests::command::{Folder, messages, skyfront};
use std::fs;
use std::path::Path;

const SIDE: usize = 128;
/// In blue alone, in red alone, and in both too faint for either.
const PLACES: [(f32, f32); 3] = [(30.0, 40.0), (90.0, 36.0), (60.0, 94.0)];
const BLUE: [f32; 3] = [12.0, 0.0, 1.05];
const RED: [f32; 3] = [0.0, 12.0, 1.05];

/// A tangential projection whose reference pixel is moved by so many columns.
fn header(moved: f64) -> Vec<Entry> {
    let mut all = vec![Entry::new("CTYPE1", "RA---TAN", ""), Entry::new("CTYPE2", "DEC--TAN", "")];
    let numbers = [
        ("CRVAL1", 150.0),
        ("CRVAL2", 2.0),
        ("CRPIX1", 64.0 + moved),
        ("CRPIX2", 64.0),
        ("CDELT1", -1e-4),
        ("CDELT2", 1e-4),
    ];
    all.extend(numbers.map(|(name, value)| Entry::new(name, value, "")));
    all
}

/// Normal noise of 1 and galaxies with peaks of so many times it, all times a scale, over a level.
fn write(file: &str, seed: u32, (level, scale): (f32, f32), peaks: [f32; 3], header: &[Entry], rows: usize) {
    let mut state = seed;
    let mut uniform = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    let mut pixels = vec![0.0; SIDE * rows];
    for (at, pixel) in pixels.iter_mut().enumerate() {
        let (x, y) = ((at % SIDE) as f32, (at / SIDE) as f32);
        let light = PLACES
            .iter()
            .zip(peaks)
            .map(|((cx, cy), peak)| peak * (-((x - cx).powi(2) + (y - cy).powi(2)) / (2.0 * 2.5 * 2.5)).exp());
        *pixel = level + scale * (light.sum::<f32>() + (0..12).map(|_| uniform()).sum::<f32>());
    }
    let mut writer = Writer::create(Path::new(file)).expect("a file can be made");
    writer.image((SIDE, rows), header, |y, out| out.copy_from_slice(&pixels[y * SIDE..][..SIDE])).expect("rows");
    writer.finish().expect("the file can be closed");
}

fn with_bands(name: &str) -> Folder {
    let folder = Folder::new(name);
    write(&folder.file("blue.fits"), 11, (500.0, 3.0), BLUE, &header(0.0), SIDE);
    write(&folder.file("red.fits"), 12, (20.0, 3.0), RED, &header(0.0), SIDE);
    folder
}

/// Runs over an image of the folder; the labels at the three places, or the exit code and message.
fn labels(folder: &Folder, file: &str, options: &[&str]) -> Result<[bool; 3], (Option<i32>, String)> {
    let (sky, out) = (folder.file(file), folder.file("out"));
    let with: Vec<String> = options
        .iter()
        .map(|word| if word.ends_with(".fits") { folder.file(word) } else { (*word).to_owned() })
        .collect();
    let line = ["segment", &sky, "--out", &out, "--overwrite", "--no-pictures", "--quiet"];
    let output = skyfront(line.into_iter().chain(with.iter().map(String::as_str)));
    if !output.status.success() {
        return Err((output.status.code(), messages(&output)));
    }
    let map = image(folder.file("out/segmentation.fits").as_ref(), None).expect("a map").pixels;
    Ok(PLACES.map(|(x, y)| map[y as usize * SIDE + x as usize] > 0.0))
}

#[test]
fn what_each_band_shows_alone_is_found_together() {
    let folder = with_bands("two-bands");
    assert_eq!(labels(&folder, "blue.fits", &[]), Ok([true, false, false]));
    assert_eq!(labels(&folder, "red.fits", &[]), Ok([false, true, false]));
    for how in ["weighted", "chi2"] {
        let found = labels(&folder, "blue.fits", &["--with", "red.fits", "--combine", how]).expect("both");
        assert_eq!(found[..2], [true, true], "{how}");
        // What is as bright in both stands out by sqrt 2 more in the weighted sum.
        assert!(found[2] || how == "chi2", "{how}");
    }
}

/// Each source has its fluxes in every band, in the units of that.
#[test]
fn sources_are_measured_in_every_band() {
    let folder = with_bands("two-bands-measured");
    labels(&folder, "blue.fits", &["--with", "red.fits", "--combine", "chi2"]).expect("both");
    let csv = fs::read_to_string(folder.file("out/catalog.csv")).expect("a catalogue");
    let mut lines = csv.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().expect("names");
    let column =
        |name: &str| names.iter().position(|other| *other == name).unwrap_or_else(|| panic!("{name}: {names:?}"));
    let [x, y, blue, red] = ["x", "y", "flux", "m2_flux"].map(column);
    let rows: Vec<[f32; 4]> = lines.map(|row| [x, y, blue, red].map(|at| row[at].parse().expect("a number"))).collect();
    let near = |(px, py): (f32, f32)| {
        // Places in catalogues count from 1.
        let row = rows.iter().find(|[x, y, ..]| (x - 1.0 - px).hypot(y - 1.0 - py) < 3.0).expect("found");
        [row[2], row[3]]
    };
    // Twelve times the noise of 3 over 2 pi 2.5^2 pixels.
    let full = 12.0 * 3.0 * 2.0 * std::f32::consts::PI * 2.5 * 2.5;
    let ([in_blue, not_in_red], [not_in_blue, in_red]) = (near(PLACES[0]), near(PLACES[1]));
    assert!((0.7..1.15).contains(&(in_blue / full)), "{in_blue} of {full}");
    assert!((0.7..1.15).contains(&(in_red / full)), "{in_red} of {full}");
    assert!(not_in_red.abs() < 0.15 * full && not_in_blue.abs() < 0.15 * full, "{not_in_red} {not_in_blue}");
    let header = image(folder.file("out/segmentation.fits").as_ref(), None).expect("a map").header;
    assert_eq!(header.text("SFCOMBIN").as_deref(), Some("chi2"));
}

/// One front that goes by each band, the paper's steps before it in each.
#[test]
fn a_front_that_goes_by_each_band_finds_what_either_shows() {
    let folder = with_bands("bands-of-a-front");
    let preset = ["--preset", "chan-vese"];
    assert_eq!(labels(&folder, "blue.fits", &preset), Ok([true, false, false]));
    assert_eq!(labels(&folder, "red.fits", &preset), Ok([false, true, false]));
    let both = ["--preset", "chan-vese", "--with", "red.fits", "--combine", "vector"];
    assert_eq!(labels(&folder, "blue.fits", &both), Ok([true, true, false]));
    let read = |name: &str| image(folder.file(name).as_ref(), None).expect("a plane");
    let map = read("out/segmentation.fits");
    assert_eq!(map.header.text("SFCOMBIN").as_deref(), Some("vector"));
    // The same as by the library.
    let [blue, red] = ["blue.fits", "red.fits"].map(|name| read(name).pixels);
    let mut drive = Drive { bands: &[&red], ..Drive::default() };
    let run = segment(&Config::CHAN_VESE, &blue, SIDE, SIDE, &mut drive).expect("bands");
    assert_eq!(map.pixels, run.labels.iter().map(|&label| label as f32).collect::<Vec<_>>());
    let csv = fs::read_to_string(folder.file("out/catalog.csv")).expect("a catalogue");
    assert!(csv.lines().any(|line| line.starts_with("label") && line.contains(",m2_flux")), "measured in each");
    let vector =
        |more: &[&str]| labels(&folder, "blue.fits", &[&["--with", "red.fits", "--combine", "vector"], more].concat());
    for (options, expected) in [
        (&[][..], "--combine vector needs --scheme chan-vese"),
        (&["--preset", "paper-f160"], "--combine vector needs --scheme chan-vese"),
        (&["--scheme", "chan-vese"], "--combine vector needs --sky none"),
        (&["--preset", "chan-vese", "--arithmetic", "q11"], "arithmetic q11: the force of several bands needs"),
    ] {
        let (code, message) = vector(options).expect_err("no front goes by both");
        assert!(code == Some(2) && message.contains(expected), "{options:?}: {message}");
    }
    let many: Vec<&str> = [&["--with", "red.fits"][..]; 8].concat();
    let (code, message) =
        labels(&folder, "blue.fits", &[&many[..], &["--combine", "vector"], &preset].concat()).expect_err("nine bands");
    assert!(code == Some(2) && message.contains("bands is 9; must be at most 8"), "{message}");
}

#[test]
fn bands_of_other_pixels_are_refused() {
    let folder = with_bands("other-bands");
    write(&folder.file("moved.fits"), 12, (20.0, 3.0), RED, &header(3.0), SIDE);
    write(&folder.file("lower.fits"), 12, (20.0, 3.0), RED, &header(0.0), SIDE - 8);
    write(&folder.file("nowhere.fits"), 12, (20.0, 3.0), RED, &[], SIDE);
    let (code, message) = labels(&folder, "blue.fits", &["--with", "moved.fits"]).expect_err("moved");
    let moved = folder.file("moved.fits");
    assert!(
        code == Some(1) && message.contains(&format!("--with: {moved} does not lie where the image does")),
        "{message}"
    );
    assert!(message.contains("3.0 away"), "{message}");
    let (_, message) = labels(&folder, "blue.fits", &["--with", "lower.fits"]).expect_err("another shape");
    assert!(message.contains("lower.fits has 128 x 120 pixels, the image 128 x 128"), "{message}");
    assert_eq!(labels(&folder, "blue.fits", &["--with", "nowhere.fits"]).map(|found| found[1]), Ok(true));
    let (code, message) = labels(&folder, "blue.fits", &["--combine", "chi2"]).expect_err("nothing to combine");
    assert!(code == Some(2) && message.contains("--with"), "{message}");
}
