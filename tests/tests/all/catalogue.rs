//! The catalogue and the outlines as a user meets them: every format tells the same.

use skyfront::read::image;
use skyfront::sky::Sky;
use skyfront::write::Entry;
use skyfront::write::fits::Writer;
use skyfront_tests::command::{Folder, messages, skyfront};
use std::fs;

const SIDE: usize = 60;

/// Two round sources on a dark sky, at the FITS positions (16, 21) and (41, 41).
fn write_sky(path: &str, more: &[Entry]) {
    let mut header = vec![
        Entry::new("CTYPE1", "RA---TAN", ""),
        Entry::new("CTYPE2", "DEC--TAN", ""),
        Entry::new("CRPIX1", 30.0, ""),
        Entry::new("CRPIX2", 30.0, ""),
        Entry::new("CRVAL1", 83.6, ""),
        Entry::new("CRVAL2", 22.0, ""),
        Entry::new("CDELT1", -1e-4, ""),
        Entry::new("CDELT2", 1e-4, ""),
        Entry::new("BUNIT", "adu", ""),
        Entry::new("GAIN", 4.0, ""),
    ];
    header.extend_from_slice(more);
    let mut writer = Writer::create(path.as_ref()).expect("a file can be made");
    writer
        .image((SIDE, SIDE), &header, |y, row: &mut [f32]| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let star = |cx: f64, cy: f64| {
                    let square = (x as f64 - cx).powi(2) + (y as f64 - cy).powi(2);
                    if square < 36.0 { 1000.0 - 10.0 * square } else { 0.0 }
                };
                // A sky that is not level, so that there is noise to estimate.
                *pixel = (star(15.0, 20.0) + star(40.0, 40.0)) as f32 + ((x * 7 + y * 3) % 5) as f32;
            }
        })
        .expect("an image can be written");
    writer.finish().expect("the file can be completed");
}

fn lines(folder: &Folder, name: &str) -> Vec<String> {
    let text = fs::read_to_string(folder.path().join("out").join(name)).expect(name);
    text.lines().map(str::to_owned).collect()
}

/// Segments the sky with all that can be told, and gives the folder.
fn segmented(name: &str, more: &[Entry]) -> (Folder, String) {
    let folder = Folder::new(name);
    let sky = folder.file("sky.fits");
    write_sky(&sky, more);
    let out = folder.file("out");
    let output = skyfront([
        "segment",
        &sky,
        "--out",
        &out,
        "--preset",
        "paper-f160",
        "--no-pictures",
        "--apertures",
        "3,8.5",
        "--zero-point",
        "25",
        "--catalog-format",
        "csv,ecsv,fits,jsonl",
        "--regions",
        "--polygons",
    ]);
    assert!(output.status.success(), "{}", messages(&output));
    (folder, messages(&output))
}

#[test]
fn every_format_has_the_same_columns_and_values() {
    let (folder, _) = segmented("formats", &[]);
    let csv = lines(&folder, "catalog.csv");
    let names: Vec<&str> = csv[0].split(',').collect();
    assert_eq!(csv.len(), 3, "two sources");
    let ecsv = lines(&folder, "catalog.ecsv");
    let described = ecsv.iter().filter(|line| line.starts_with("# - {name: ")).count();
    assert_eq!(described, names.len());
    assert_eq!(ecsv.iter().filter(|line| !line.starts_with('#')).cloned().collect::<Vec<_>>(), csv);
    let mut table = fitsio::FitsFile::open(folder.path().join("out/catalog.fits")).expect("a FITS file");
    let hdu = table.hdu("CATALOG").expect("the table");
    let json: Vec<serde_json::Value> =
        lines(&folder, "catalog.jsonl").iter().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    for (column, name) in names.iter().enumerate() {
        let reals: Vec<f64> = hdu.read_col(&mut table, name).expect(name);
        for (row, real) in reals.iter().enumerate() {
            let text = csv[row + 1].split(',').nth(column).expect("a cell");
            let cell: f64 = text.parse().unwrap_or(f64::NAN);
            let number = json[row][*name].as_f64().unwrap_or(f64::NAN);
            let same = (cell - real).abs() <= 1e-8 * real.abs() || (cell.is_nan() && real.is_nan());
            assert!(same && (number == cell || number.is_nan() && cell.is_nan()), "{name}: {text} {real} {number}");
        }
    }
    let unit = |name: &str, table: &mut fitsio::FitsFile| {
        let number = names.iter().position(|column| *column == name).expect(name) + 1;
        hdu.read_key::<String>(table, &format!("TUNIT{number}")).expect(name)
    };
    assert_eq!((unit("ra", &mut table), unit("flux", &mut table)), ("deg".to_owned(), "adu".to_owned()));
    assert_eq!(hdu.read_key::<f64>(&mut table, "SFGAIN").expect("the gain in use"), 4.0);
    assert_eq!(hdu.read_key::<String>(&mut table, "SFAPERT").expect("the apertures"), "3,8.5");
}

#[test]
fn sources_are_where_they_are_on_the_sky() {
    let (folder, _) = segmented("places", &[]);
    let csv = lines(&folder, "catalog.csv");
    let value = |row: usize, name: &str| -> f64 {
        let column = csv[0].split(',').position(|column| column == name).expect(name);
        csv[row].split(',').nth(column).expect("a cell").parse().expect("a number")
    };
    assert!((value(1, "x") - 16.0).abs() < 0.05 && (value(1, "y") - 21.0).abs() < 0.05);
    let header = image(folder.file("sky.fits").as_ref(), None).expect("an image").header;
    let sky = Sky::of(&header).expect("supported").expect("celestial");
    let (ra, dec) = sky.position(value(2, "x") - 1.0, value(2, "y") - 1.0).expect("a place");
    assert!((value(2, "ra") - ra).abs() < 1e-8 && (value(2, "dec") - dec).abs() < 1e-8);
    // East is to the left: the source on the right has the smaller right ascension.
    assert!(value(2, "ra") < 83.6 && value(2, "dec") > 22.0 && value(1, "ra") > 83.6);
}

#[test]
fn regions_and_polygons_enclose_their_sources() {
    let (folder, _) = segmented("regions", &[]);
    for (name, frame) in [("regions.reg", "image"), ("regions_sky.reg", "icrs")] {
        let text = lines(&folder, name);
        assert!(text[0].starts_with("# Region file format: DS9") && text[2] == frame, "{text:?}");
        assert_eq!(text[3..].iter().filter(|line| line.starts_with("polygon(")).count(), 2, "{text:?}");
    }
    let text = fs::read_to_string(folder.path().join("out/outlines.json")).expect("outlines");
    let rings: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let rings = rings.as_array().expect("an array");
    for (ring, (x, y)) in rings.iter().zip([(16.0, 21.0), (41.0, 41.0)]) {
        let corners = ring["pixel"].as_array().expect("corners");
        assert_eq!(corners.len(), ring["sky"].as_array().expect("corners on the sky").len());
        for corner in corners {
            let at = |axis: usize| corner[axis].as_f64().expect("a number");
            let distance = (at(0) - x).hypot(at(1) - y);
            assert!((1.0..12.0).contains(&distance), "{distance} pixels from the middle");
        }
    }
}

#[test]
fn coordinates_that_are_not_supported_are_left_out_and_said() {
    let (folder, messages) = segmented("unsupported", &[Entry::new("CPDIS1", "Lookup", "")]);
    assert!(messages.contains("CPDIS1"), "{messages}");
    let csv = lines(&folder, "catalog.csv");
    assert!(csv[0].split(',').all(|name| name != "ra" && name != "pa"));
    let flags: u32 = csv[1].rsplit(',').next().expect("a cell").parse().expect("flags");
    assert!(flags & skyfront_core::flags::NO_COORDINATES != 0);
    assert!(!folder.path().join("out/regions_sky.reg").exists());
}

#[test]
fn columns_and_flags_are_listed() {
    let output = skyfront(["columns"]);
    let text = String::from_utf8_lossy(&output.stdout);
    for word in ["half_light_radius", "flux_aper_1_err", "position angle", "no-coordinates"] {
        assert!(text.contains(word), "{word} is not in {text}");
    }
}

#[test]
fn impossible_apertures_are_bad_usage() {
    for value in ["0", "-1", "x", "1e9"] {
        let output = skyfront(["segment", "sky.fits", "--out", "nowhere", &format!("--apertures={value}")]);
        assert_eq!(output.status.code(), Some(2), "{}", messages(&output));
    }
}
