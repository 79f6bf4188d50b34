//! Maps beside the image: masks, weights, a second image to measure in, a start for the front.

use skyfront::read::image;
use skyfront::write::Entry;
use skyfront::write::fits::Writer;
use skyfront_tests::command::{Folder, messages, skyfront};
use skyfront_tests::fits_bytes::{Header, samples};
use std::fs;
use std::path::Path;

const SIDE: usize = 64;

/// Writes a plane of `SIDE` columns.
fn write(path: &str, header: &[Entry], rows: usize, pixel: impl Fn(usize, usize) -> f32) {
    let mut writer = Writer::create(Path::new(path)).expect("the file can be made");
    let row = |y: usize, out: &mut [f32]| out.iter_mut().enumerate().for_each(|(x, out)| *out = pixel(x, y));
    writer.image((SIDE, rows), header, row).expect("the plane can be written");
    writer.finish().expect("the file can be closed");
}

/// A sky with scatter, the same for every run.
fn noise(x: usize, y: usize) -> f32 {
    let mixed = ((x * 7919 + y * 104_729 + 17) as u32).wrapping_mul(2_654_435_761);
    let mixed = (mixed ^ mixed >> 15).wrapping_mul(2_246_822_519);
    ((mixed >> 8) as f32 / (1 << 24) as f32 - 0.5) * 3.46
}

fn star(x: usize, y: usize, (cx, cy): (f32, f32), light: f32) -> f32 {
    let square = (x as f32 - cx).powi(2) + (y as f32 - cy).powi(2);
    light * (-square / 8.0).exp()
}

/// Two stars on a sky of 100; `second` times as bright is the one at (45, 40).
fn sky(second: f32) -> impl Fn(usize, usize) -> f32 {
    move |x, y| 100.0 + noise(x, y) + star(x, y, (16.0, 20.0), 200.0) + star(x, y, (45.0, 40.0), 200.0 * second)
}

/// A folder with that sky in sky.fits.
fn with_sky(name: &str) -> Folder {
    let folder = Folder::new(name);
    write(&folder.file("sky.fits"), &[], SIDE, sky(1.0));
    folder
}

/// Segments the sky with more options into `out`, and gives the lines on stderr.
fn segment(folder: &Folder, out: &str, options: &[&str]) -> String {
    let (image, out) = (folder.file("sky.fits"), folder.file(out));
    let line = ["segment", &image, "--out", &out, "--no-pictures", "--overwrite"];
    let output = skyfront(line.iter().chain(options));
    assert!(output.status.success(), "{}", messages(&output));
    messages(&output)
}

/// What a run that must fail says, and its exit code.
fn refused(folder: &Folder, options: &[&str]) -> (String, Option<i32>) {
    let (image, out) = (folder.file("sky.fits"), folder.file("refused"));
    let output = skyfront(["segment", &image, "--out", &out].iter().chain(options));
    assert!(!output.status.success() && folder.names("refused").is_empty(), "{options:?}");
    (messages(&output), output.status.code())
}

fn column(folder: &Folder, run: &str, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(folder.file(&format!("{run}/catalog.csv"))).expect("a catalogue");
    let mut lines = text.lines();
    let names = lines.next().expect("a line of names");
    let at = names.split(',').position(|column| column == name).expect(name);
    lines.map(|line| line.split(',').nth(at).expect("a cell").parse().unwrap_or(f64::NAN)).collect()
}

fn plane(folder: &Folder, file: &str) -> Vec<f32> {
    image(folder.file(file).as_ref(), None).expect("a product").pixels
}

const PAPER: [&str; 2] = ["--preset", "paper-f160"];

#[test]
fn a_masked_source_is_gone_and_one_beside_the_mask_is_flagged() {
    let folder = with_sky("mask");
    // All of the first star, and one column through the second.
    let bad = |x: usize, y: usize| if (x < 30 && y < 30) || x == 47 { 4.0 } else { 0.0 };
    write(&folder.file("mask.fits"), &[], SIDE, bad);
    let mask = folder.file("mask.fits");
    for preset in [PAPER.as_slice(), &[]] {
        let said = segment(&folder, "out", &[preset, &["--mask", &mask]].concat());
        assert!(said.contains("take 964 pixels away"), "{said}");
        let labels = plane(&folder, "out/segmentation.fits");
        assert!((0..labels.len()).all(|at| labels[at] == 0.0 || bad(at % SIDE, at / SIDE) == 0.0));
        let (x, flags) = (column(&folder, "out", "x"), column(&folder, "out", "flags"));
        let at = (0..x.len()).find(|&at| (40.0..52.0).contains(&x[at])).expect("the second star");
        assert_eq!(flags[at] as u32 & 4, 4, "it touches masked pixels");
        let summary: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(folder.file("out/summary.json")).expect("a summary"))
                .expect("JSON");
        assert_eq!(summary["pixels_removed_by_maps"], 964);
        assert_eq!(summary["undefined_pixels"], 964);
        assert_eq!(summary["input"]["beside"]["mask"]["file"], *mask);
        let header = image(folder.file("out/segmentation.fits").as_ref(), None).expect("a map").header;
        assert_eq!(header.text("SFMASK"), Some(mask.clone()));
    }
}

#[test]
fn maps_that_cannot_be_meant_are_refused_in_one_line() {
    let folder = with_sky("refused-maps");
    let file = |name: &str| folder.file(name);
    write(&file("small.fits"), &[], SIDE - 1, |_, _| 0.0);
    write(&file("all.fits"), &[], SIDE, |_, _| 1.0);
    write(&file("none.fits"), &[], SIDE, |_, _| 0.0);
    fs::write(file("text.fits"), "no image").expect("a file can be written");
    let cases: [(&[&str], &[&str]); 9] = [
        (&["--mask", &file("small.fits")], &["--mask", "small.fits", "64 x 63", "the image 64 x 64"]),
        (&["--mask", &file("all.fits")], &["all.fits", "leaves no pixel", "where it is 0"]),
        (&["--mask", &file("sky.fits")], &["sky.fits", "pixel (1, 1)", "whole numbers"]),
        (&["--mask", &file("text.fits")], &["--mask", "text.fits", "not a FITS"]),
        (&["--mask", &file("all.fits[3]")], &["all.fits, HDU", "no HDU 3"]),
        (
            &["--weight", &file("none.fits"), "--weight-type", "variance"],
            &["--weight", "leaves no pixel", "--weight-type"],
        ),
        (&["--weight", &file("small.fits"), "--weight-type", "rms"], &["--weight", "64 x 63"]),
        (&["--measure", &file("small.fits")], &["--measure", "64 x 63"]),
        (&["--preset", "paper-f160", "--start", &file("none.fits")], &["--start", "marks no pixel"]),
    ];
    for (options, words) in cases {
        let (line, code) = refused(&folder, options);
        let words: Vec<&&str> = words
            .iter()
            .filter(|word| !line.replace("all.fits: no HDU", "all.fits, HDU: no HDU").contains(**word))
            .collect();
        assert!(words.is_empty() && line.lines().count() == 1 && code == Some(1), "{options:?}: {words:?} {line}");
    }
    assert_eq!(refused(&folder, &["--weight", &file("all.fits")]).1, Some(2), "the type of weights is not guessed");
    assert_eq!(refused(&folder, &["--arrival"]).1, Some(2), "only fast marching knows arrival times");
}

#[test]
fn errors_follow_the_weight_map_whatever_its_type() {
    let folder = with_sky("weights");
    let sigma = |x: usize| if x < 32 { 2.0 } else { 6.0 };
    let value = |kind: &str, sigma: f32| match kind {
        "rms" => sigma,
        "variance" => sigma * sigma,
        _ => 9.0 / (sigma * sigma),
    };
    let mut errors = Vec::new();
    for kind in ["rms", "variance", "weight"] {
        let map = folder.file(&format!("{kind}.fits"));
        write(&map, &[], SIDE, |x, y| if y == 0 { 0.0 } else { value(kind, sigma(x)) });
        segment(&folder, kind, &[PAPER.as_slice(), &["--weight", &map, "--weight-type", kind]].concat());
        let (area, error) = (column(&folder, kind, "area"), column(&folder, kind, "flux_err"));
        assert!(plane(&folder, &format!("{kind}/segmentation.fits"))[..SIDE].iter().all(|&label| label == 0.0));
        let x = column(&folder, kind, "x");
        errors.push(
            (0..x.len()).map(|at| error[at] / area[at].sqrt() / f64::from(sigma(x[at] as usize))).collect::<Vec<_>>(),
        );
    }
    assert!(errors[0].len() >= 2);
    for map in &errors[..2] {
        assert!(map.iter().all(|ratio| (ratio - 1.0).abs() < 1e-6), "{errors:?}");
    }
    // Relative weights: one factor for all, measured on the sky.
    let factor = errors[2][0];
    assert!(errors[2].iter().all(|ratio| (ratio / factor - 1.0).abs() < 1e-5) && factor < 1.0, "{errors:?}");
}

#[test]
fn noisy_pixels_make_no_sources_where_a_weight_map_tells_of_them() {
    let folder = Folder::new("noisy");
    // The right third is eight times as noisy, and a mesh cell holds all of the frame.
    let sigma = |x: usize| if x < 43 { 1.0 } else { 8.0 };
    write(&folder.file("sky.fits"), &[], SIDE, |x, y| {
        100.0 + noise(x, y) * sigma(x) + star(x, y, (16.0, 20.0), 60.0) + star(x, y, (52.0, 44.0), 400.0)
    });
    let map = folder.file("weight.fits");
    write(&map, &[], SIDE, |x, _| 5.0 / (sigma(x) * sigma(x)));
    segment(&folder, "alone", &[]);
    segment(&folder, "weighed", &["--weight", &map, "--weight-type", "weight", "--sky-maps"]);
    let (alone, x) = (column(&folder, "alone", "x"), column(&folder, "weighed", "x"));
    assert!(alone.len() > 3, "without weights noise is taken for sources: {alone:?}");
    assert_eq!(x.iter().map(|x| x.round()).collect::<Vec<_>>(), [17.0, 53.0]);
    let per_pixel = |at: usize| column(&folder, "weighed", "noise")[at];
    assert!((per_pixel(1) / per_pixel(0) - 8.0).abs() < 1e-5 && (0.8..1.3).contains(&per_pixel(0)));
    let background = plane(&folder, "weighed/background.fits");
    assert!(background.iter().all(|level| (level - 100.0).abs() < 1.0), "{}", background[0]);
    assert_eq!(plane(&folder, "weighed/noise.fits").len(), SIDE * SIDE);
}

#[test]
fn a_given_sky_and_noise_are_those_of_the_fluxes() {
    let folder = with_sky("given");
    for (preset, run) in [(PAPER.as_slice(), "paper"), (&[], "default")] {
        segment(
            &folder,
            run,
            &[preset, &["--background", "90", "--weight", "9", "--weight-type", "variance"]].concat(),
        );
        let value = |name: &str| column(&folder, run, name);
        assert!(!value("x").is_empty());
        for at in 0..value("x").len() {
            let (area, sum) = (value("area")[at], value("sum")[at]);
            assert_eq!((value("background")[at], value("noise")[at]), (90.0, 3.0));
            assert!((value("flux")[at] - (sum - 90.0 * area)).abs() < 1e-6 * sum);
            assert!((value("flux_err")[at] / (3.0 * area.sqrt()) - 1.0).abs() < 1e-8);
        }
    }
    let header = image(folder.file("paper/segmentation.fits").as_ref(), None).expect("a map").header;
    assert_eq!((header.text("SFBGMAP").as_deref(), header.text("SFWEIGHT").as_deref()), (Some("90"), Some("9")));
}

#[test]
fn sources_found_in_one_image_are_measured_in_another() {
    let folder = with_sky("double");
    let header = [Entry::new("GAIN", 2.0, ""), Entry::new("SATURATE", 150.0, ""), Entry::new("BUNIT", "e-", "")];
    let other = folder.file("other.fits");
    write(&other, &header, SIDE, |x, y| if (x, y) == (16, 20) { f32::NAN } else { sky(0.5)(x, y) - 50.0 });
    segment(&folder, "one", &[]);
    segment(&folder, "two", &["--measure", &other]);
    let map = |run: &str| plane(&folder, &format!("{run}/segmentation.fits"));
    assert!(map("one") == map("two"), "the same sources");
    let value = |run: &str, name: &str| column(&folder, run, name);
    for name in ["label", "xmin", "ymax", "area"] {
        assert_eq!(value("one", name), value("two", name), "{name}");
    }
    let second = value("one", "x").iter().position(|x| (40.0..50.0).contains(x)).expect("the second star");
    let ratio = value("two", "flux")[second] / value("one", "flux")[second];
    assert!((ratio - 0.5).abs() < 0.03, "{ratio}");
    assert!(value("two", "peak")[second] > 140.0 && value("two", "peak")[second] < 155.0);
    assert!((value("two", "background")[second] - 50.0).abs() < 0.5);
    let first = 1 - second.min(1);
    let flags = value("two", "flags")[first] as u32;
    assert_eq!(flags & 6, 6, "saturated by its own header, beside a pixel of its own that is undefined");
    let mean = value("two", "sum")[first] / (value("two", "area")[first] - 1.0);
    assert!((value("two", "mean")[first] / mean - 1.0).abs() < 1e-8, "the mean is of the defined pixels");
    let table = image(folder.file("two/segmentation.fits").as_ref(), None).expect("a map").header;
    assert_eq!(table.text("SFMEAS"), Some(other));
}

/// Electrons are in EGAIN where a camera has its setting in GAIN; a setting that stands alone is not believed.
#[test]
fn a_camera_s_setting_is_no_gain() {
    let folder = Folder::new("gain");
    let path = folder.file("counts.fits");
    let counts: Vec<f64> = (0..SIDE * SIDE).map(|at| f64::from(sky(0.5)(at % SIDE, at / SIDE).round())).collect();
    let told = |bitpix: i32, keys: &[(&str, f64)], options: &[&str]| {
        let primary = Header::primary(bitpix, &[SIDE as u64, SIDE as u64]);
        let header = keys.iter().fold(primary, |header, &(key, value)| header.card(key, value));
        fs::write(&path, header.with(samples(bitpix, &counts))).expect("a file");
        let out = folder.file("out");
        let line = ["segment", &path, "--out", &out, "--no-pictures", "--overwrite"];
        let output = skyfront(line.iter().chain(options));
        assert!(output.status.success(), "{}", messages(&output));
        let summary = fs::read_to_string(folder.file("out/summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
        (summary["measuring"]["SFGAIN"].as_f64(), messages(&output).contains("GAIN = 120"))
    };
    assert_eq!(told(16, &[("GAIN", 2.5)], &[]), (Some(2.5), false));
    assert_eq!(told(16, &[("GAIN", 120.0)], &[]), (None, true), "a setting");
    assert_eq!(told(16, &[("GAIN", 120.0), ("EGAIN", 0.9)], &[]), (Some(0.9), false));
    assert_eq!(told(16, &[("GAIN", 120.0)], &["--gain", "0.8"]), (Some(0.8), false));
    assert_eq!(told(-32, &[("GAIN", 120.0)], &[]), (Some(120.0), false), "seconds of a sum");
    assert_eq!(told(16, &[("GAIN", 0.0)], &[]), (None, false));
}

/// One set of columns for each image, and the first with the plain names.
#[test]
fn many_images_are_measured_in_one_run() {
    let folder = with_sky("bands");
    let [half, twice] = [("half.fits", 0.5f32), ("twice.fits", 2.0)].map(|(name, scale)| {
        let path = folder.file(name);
        let header = [Entry::new("BUNIT", name, ""), Entry::new("GAIN", f64::from(scale), "")];
        write(&path, &header, SIDE, |x, y| sky(0.5)(x, y) * scale);
        path
    });
    let of = |run: &str, options: &[&str]| segment(&folder, run, options);
    of("half", &["--measure", &half, "--measure-background", "50"]);
    of("twice", &["--measure", &twice, "--measure-background", "200"]);
    let backgrounds = ["--measure-background", "50", "--measure-background", "200"];
    of("both", &[&["--measure", &half, "--measure", &twice], &backgrounds[..]].concat());
    let bits = |run: &str, name: &str| column(&folder, run, name).iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
    for name in ["x", "flux", "flux_kron_err", "peak", "background", "flags"] {
        assert_eq!(bits("both", name), bits("half", name), "{name}");
        assert_eq!(bits("both", &format!("m2_{name}")), bits("twice", name), "{name}");
    }
    let csv = std::fs::read_to_string(folder.file("both/catalog.csv")).expect("a catalogue");
    assert!(!csv.contains("m2_area") && !csv.contains("m3_"), "{csv}");
    let header = image(folder.file("both/segmentation.fits").as_ref(), None).expect("a map").header;
    let text = |keyword: &str| header.text(keyword);
    assert_eq!(
        (text("SFMEAS"), text("SFMEAS2"), text("SFMBGM2").as_deref()),
        (Some(half.clone()), Some(twice.clone()), Some("200"))
    );
    let summary = std::fs::read_to_string(folder.file("both/summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    assert_eq!(summary["input"]["beside"]["measure_2"]["file"], twice);
    // What an image has for itself is told of each, what was asked once.
    let told = |keyword: &str| &summary["measuring"][keyword];
    assert_eq!((told("SFGAIN").as_f64(), told("SFGAIN2").as_f64()), (Some(0.5), Some(2.0)));
    assert!(told("SFNOIS2").is_string() && told("SFNEIGHB").is_string() && told("SFNEIG2").is_null());
    let mut table = fitsio::FitsFile::open(folder.file("both/catalog.fits")).expect("a table");
    let hdu = table.hdu("CATALOG").expect("the table");
    assert_eq!(hdu.read_key::<f64>(&mut table, "SFGAIN2").expect("the second gain"), 2.0);
    let (message, code) = refused(&folder, &["--measure", &half, "--measure", &twice, "--measure-background", "5"]);
    assert!(code == Some(2) && message.contains("once for each --measure"), "{message}");
}

#[test]
fn a_front_starts_from_a_map_and_its_own_result_is_at_rest() {
    let folder = with_sky("start");
    segment(&folder, "frame", &[PAPER.as_slice(), &["--band", "8"]].concat());
    let map = folder.file("frame/segmentation.fits");
    segment(&folder, "near", &[PAPER.as_slice(), &["--band", "8", "--start", &map, "--margin", "3"]].concat());
    let (frame, near) = (plane(&folder, "frame/segmentation.fits"), plane(&folder, "near/segmentation.fits"));
    let differ = frame.iter().zip(&near).filter(|(a, b)| (**a > 0.0) != (**b > 0.0)).count();
    assert!(differ <= 8, "{differ} pixels differ from the run that started at the frame");
    let steps = |run: &str| {
        let text = fs::read_to_string(folder.file(&format!("{run}/summary.json"))).expect("a summary");
        serde_json::from_str::<serde_json::Value>(&text).expect("JSON")["iterations"].as_u64().expect("steps")
    };
    assert!(steps("near") * 2 < steps("frame"), "{} and {} steps", steps("near"), steps("frame"));
    // A level set is taken as it is: the front that came to rest stays where it is.
    let front = folder.file("frame/front.fits");
    segment(&folder, "again", &[PAPER.as_slice(), &["--band", "8", "--start", &front]].concat());
    let again = plane(&folder, "again/segmentation.fits");
    let differ = frame.iter().zip(&again).filter(|(a, b)| (**a > 0.0) != (**b > 0.0)).count();
    assert!(differ <= 8 && steps("again") < steps("near"), "{differ} pixels, {} steps", steps("again"));
    let dumped = skyfront(["segment", "--dump-config", PAPER[0], PAPER[1], "--start", &front]);
    assert!(String::from_utf8_lossy(&dumped.stdout).contains(&format!("start = \"{front}\"")));
}

#[test]
fn arrival_times_grow_from_the_frame_to_the_sources() {
    let folder = with_sky("arrival");
    segment(&folder, "out", &[PAPER.as_slice(), &["--scheme", "fast-marching", "--arrival"]].concat());
    let times = plane(&folder, "out/arrival.fits");
    let labels = plane(&folder, "out/segmentation.fits");
    let at = |x: usize, y: usize| times[y * SIDE + x];
    // g is near 1 on the sky, a pixel is 0.1 wide, and the front starts two pixels inside the frame.
    assert_eq!(at(0, 32), 0.0);
    let ten = at(32, 12) - at(32, 2);
    assert!((0.95..1.3).contains(&ten), "ten pixels take {ten}");
    for (label, time) in labels.iter().zip(&times) {
        assert!(if *label > 0.0 { time.is_nan() } else { time.is_nan() || (0.0..=50.0).contains(time) });
    }
    assert!(labels.iter().any(|&label| label > 0.0));
}
