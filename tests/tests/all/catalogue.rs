//! The catalogue and the outlines as a user meets them: every format tells the same.

use skyfront::outline::{Ring, write_polygons, write_regions};
use skyfront::read::image;
use skyfront::sky::Sky;
use skyfront::write::fits::Writer;
use skyfront::write::{Entry, Value};
use skyfront_tests::command::{Folder, messages, program, skyfront};
use std::fs;
use std::process::Command;

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
        "csv,ecsv,fits,jsonl,votable",
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
fn maps_have_units_that_readers_accept() {
    let folder = Folder::new("units");
    let (sky, out) = (folder.file("sky.fits"), folder.file("out"));
    write_sky(&sky, &[]);
    let output = skyfront(["segment", &sky, "--out", &out, "--no-pictures", "--sky-maps"]);
    assert!(output.status.success(), "{}", messages(&output));
    for (name, unit) in
        [("segmentation", ""), ("segmented", "adu"), ("front", ""), ("background", "adu"), ("noise", "adu")]
    {
        let header = image(folder.path().join(format!("out/{name}.fits")).as_ref(), None).expect(name).header;
        assert_eq!(header.text("BUNIT").as_deref(), Some(unit), "{name}");
        assert_eq!(header.text("SFARITH").as_deref(), Some("f32"), "{name}");
    }
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

/// The centre of the first pixel is (1, 1) in DS9 as in FITS.
#[test]
fn outlines_are_written_at_their_pixels() {
    let ring = Ring { label: 7, hole: true, points: vec![(0.0, 0.0), (2.5, 0.25), (-0.5, 3.0)] };
    let (mut regions, mut polygons) = (Vec::new(), Vec::new());
    write_regions(std::slice::from_ref(&ring), None, &mut regions).expect("a vector takes all");
    write_polygons(&[ring], None, &mut polygons).expect("a vector takes all");
    let text = String::from_utf8(regions).expect("text");
    assert_eq!(text.lines().last(), Some("-polygon(1.000,1.000,3.500,1.250,0.500,4.000) # text={7}"));
    let rings: serde_json::Value = serde_json::from_slice(&polygons).expect("JSON");
    assert_eq!(rings[0]["pixel"], serde_json::json!([[1.0, 1.0], [3.5, 1.25], [0.5, 4.0]]));
}

/// A table of a batch can be stacked on the others: its columns stay.
#[test]
fn coordinates_that_are_not_supported_are_empty_and_said() {
    let (folder, messages) = segmented("unsupported", &[Entry::new("CPDIS1", "Lookup", "")]);
    assert!(messages.contains("CPDIS1"), "{messages}");
    let csv = lines(&folder, "catalog.csv");
    let (supported, _) = segmented("supported", &[]);
    assert_eq!(csv[0], lines(&supported, "catalog.csv")[0]);
    for name in ["ra", "dec", "pa", "a_sky", "mu_max"] {
        assert_eq!(cell(&csv, 1, name), "", "{name}");
    }
    let flags: u32 = cell(&csv, 1, "flags").parse().expect("flags");
    assert!(flags & skyfront_core::sources::flags::NO_COORDINATES != 0);
    assert!(!folder.path().join("out/regions_sky.reg").exists());
    let map = image(folder.path().join("out/segmentation.fits").as_ref(), None).expect("a map").header;
    assert!(map.text("SFWCS").is_some_and(|reason| reason.contains("CPDIS1")));
}

/// A cell of a table of lines.
fn cell<'a>(csv: &'a [String], row: usize, name: &str) -> &'a str {
    let column = csv[0].split(',').position(|column| column == name).expect(name);
    csv[row].split(',').nth(column).expect("a cell")
}

/// Segments the sky with more options, and gives the lines of its CSV.
fn csv_with(name: &str, options: &[&str]) -> Vec<String> {
    let folder = Folder::new(name);
    let sky = folder.file("sky.fits");
    write_sky(&sky, &[]);
    let out = folder.file("out");
    let fixed = ["segment", &sky, "--out", &out, "--preset", "paper-f160", "--no-pictures", "--map-only"];
    let output = skyfront(fixed.iter().chain(options));
    assert!(output.status.success(), "{}", messages(&output));
    lines(&folder, "catalog.csv")
}

#[test]
fn columns_are_chosen_by_our_names_or_sextractors() {
    let csv = csv_with("columns", &["--columns", "NUMBER,xwin,FLUX_AUTO,flags_sex"]);
    assert_eq!(csv[0], "label,xwin,flux_kron,flags_sex");
    assert!((cell(&csv, 1, "xwin").parse::<f64>().expect("a number") - 16.0).abs() < 0.05);
    let folder = Folder::new("param");
    let file = folder.file("mine.param");
    fs::write(&file, "NUMBER   # running number\n#X_IMAGE\nALPHA_J2000\nFLUX_APER(2)\n").expect("a file");
    let csv = csv_with("columns-file", &["--columns", &file, "--apertures", "3,5"]);
    assert_eq!(csv[0], "label,ra,flux_aper_1,flux_aper_2");
    let all = csv_with("columns-all", &["--columns", "all", "--apertures", "3", "--zero-point", "25"]);
    assert!(["glon", "snr_local", "mag_aper_1_err", "mu_max"].iter().all(|name| all[0].split(',').any(|c| c == *name)));
    assert_eq!((cell(&all, 1, "glon"), cell(&all, 1, "snr_local").is_empty()), ("", false));
}

#[test]
fn columns_made_of_others_agree_with_them() {
    let csv = csv_with("made-of-others", &["--columns", "a,b,elongation,ellipticity,flags,flags_sex"]);
    for row in 1..csv.len() {
        let number = |name: &str| cell(&csv, row, name).parse::<f64>().expect(name);
        let (a, b) = (number("a"), number("b"));
        assert!(a > b && (number("elongation") - a / b).abs() < 1e-6, "{csv:?}");
        assert!((number("ellipticity") - (1.0 - b / a)).abs() < 1e-6, "{csv:?}");
        assert_eq!([number("flags"), number("flags_sex")], [0.0; 2], "nothing is wrong with them");
    }
    assert_eq!(csv.len(), 3, "two sources");
}

#[test]
fn columns_that_cannot_be_had_are_bad_usage() {
    for (options, word) in [
        (&["--columns", "fluxx"][..], "fluxx"),
        (&["--columns", "mag_kron"], "--zero-point"),
        (&["--columns", "MU_MAX"], "--zero-point"),
        (&["--columns", "flux_aper_1"], "--apertures"),
        (&["--wcs", "a"], "one letter"),
    ] {
        let output = skyfront(["segment", "sky.fits", "--out", "nowhere"].iter().chain(options));
        assert_eq!(output.status.code(), Some(2), "{}", messages(&output));
        assert!(messages(&output).contains(word), "{}", messages(&output));
    }
}

#[test]
fn tables_tell_virtual_observatories_what_columns_are() {
    let (folder, _) = segmented("described", &[]);
    let mut table = fitsio::FitsFile::open(folder.path().join("out/catalog.fits")).expect("a FITS file");
    let hdu = table.hdu("CATALOG").expect("the table");
    let ra = lines(&folder, "catalog.csv")[0].split(',').position(|name| name == "ra").expect("ra") + 1;
    assert_eq!(hdu.read_key::<String>(&mut table, &format!("TUCD{ra}")).expect("a UCD"), "pos.eq.ra;meta.main");
    let described = hdu.read_key::<String>(&mut table, &format!("TDESC{ra}")).expect("a description");
    assert!(described.starts_with("right ascension"), "{described}");
    let bytes = fs::read(folder.path().join("out/catalog.fits")).expect("the file");
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("COMMENT --BEGIN-ASTROPY-SERIALIZED-COLUMNS--"), "what astropy reads");
    let vot = fs::read_to_string(folder.path().join("out/catalog.vot")).expect("a VOTable");
    assert!(vot.contains("<FIELD name=\"ra\" datatype=\"double\" unit=\"deg\" ucd=\"pos.eq.ra;meta.main\">"), "{vot}");
    assert_eq!(vot.matches("<TR>").count(), 2);
    let csv = lines(&folder, "catalog.csv");
    let row: String = csv[2].split(',').map(|cell| format!("<TD>{cell}</TD>")).collect();
    assert!(vot.contains(&row), "the same cells");
}

#[test]
fn a_given_map_is_measured_under_its_own_labels() {
    let (folder, _) = segmented("given", &[]);
    let found = image(folder.path().join("out/segmentation.fits").as_ref(), None).expect("a map");
    // Other numbers, with gaps, the other way round.
    let renamed = folder.file("renamed.fits");
    let mut writer = Writer::create(renamed.as_ref()).expect("a file can be made");
    let of = |value: f32| if value == 1.0 { 70 } else { value as i32 * 2 };
    writer
        .image((SIDE, SIDE), &[], |y, row: &mut [i32]| {
            row.iter_mut().zip(&found.pixels[y * SIDE..]).for_each(|(out, &value)| *out = of(value));
        })
        .expect("an image can be written");
    writer.finish().expect("the file can be completed");
    let (sky, out) = (folder.file("sky.fits"), folder.file("again"));
    let output = skyfront(["segment", &sky, "--out", &out, "--segmentation", &renamed, "--catalog-format", "csv"]);
    assert!(output.status.success(), "{}", messages(&output));
    assert!(messages(&output).contains("measured as given"), "{}", messages(&output));
    let map = image(folder.path().join("again/segmentation.fits").as_ref(), None).expect("a map");
    assert_eq!(map.pixels, image(renamed.as_ref(), None).expect("a map").pixels);
    assert_eq!(map.header.text("SFMETHOD").as_deref(), Some("given"));
    assert_eq!(map.header.text("BUNIT").as_deref(), Some(""), "a unit that readers accept");
    assert!(!folder.path().join("again/front.fits").exists());
    let text = fs::read_to_string(folder.path().join("again/catalog.csv")).expect("a catalogue");
    let again: Vec<String> = text.lines().map(str::to_owned).collect();
    assert_eq!((cell(&again, 1, "label"), cell(&again, 2, "label")), ("4", "70"));
    let first = lines(&folder, "catalog.csv");
    assert_eq!(cell(&again, 2, "area"), cell(&first, 1, "area"));
    // The sky of the given run is a mesh, that of the other one level.
    let x = |csv: &[String], row: usize| cell(csv, row, "x").parse::<f64>().expect("a place");
    assert!((x(&again, 2) - x(&first, 1)).abs() < 0.01, "{} {}", x(&again, 2), x(&first, 1));
    let mut odd = Writer::create(folder.file("odd.fits").as_ref()).expect("a file can be made");
    odd.image((SIDE, SIDE), &[], |_, row: &mut [f32]| row.fill(0.5)).expect("an image can be written");
    odd.finish().expect("the file can be completed");
    let output = skyfront(["segment", &sky, "--out", &out, "--segmentation", &folder.file("odd.fits"), "--overwrite"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(messages(&output).contains("labels are whole numbers"), "{}", messages(&output));
}

#[test]
fn places_of_a_table_are_measured_without_detection() {
    let folder = Folder::new("places-given");
    let (sky, places, out) = (folder.file("sky.fits"), folder.file("places.csv"), folder.file("out"));
    write_sky(&sky, &[]);
    let run = |table: &str| {
        fs::write(&places, table).expect("a file");
        let output = skyfront([
            "segment",
            &sky,
            "--out",
            &out,
            "--overwrite",
            "--positions",
            &places,
            "--apertures",
            "7",
            "--no-pictures",
        ]);
        assert!(output.status.success(), "{}", messages(&output));
        assert_eq!(messages(&output).contains("1 places are not"), table.contains("-80"), "{}", messages(&output));
        lines(&folder, "catalog.csv")
    };
    let csv = run("id,x,y\n5,16,21\n6,41,41\n7,-90,1\n");
    assert_eq!(csv[0], "label,x,y,ra,dec,flux_aper_1,flux_aper_1_err,flags");
    let light = |csv: &[String], row: usize| cell(csv, row, "flux_aper_1").parse::<f64>().expect("a flux");
    // Of the disc of 1000 - 10 r^2 within six pixels, 92 500 in all.
    assert!((light(&csv, 1) / light(&csv, 2) - 1.0).abs() < 0.02 && (8e4..1.0e5).contains(&light(&csv, 1)), "{csv:?}");
    assert_eq!((cell(&csv, 1, "label"), cell(&csv, 3, "flux_aper_1")), ("5", ""));
    let (ra, dec) = (cell(&csv, 2, "ra"), cell(&csv, 2, "dec"));
    let again = run(&format!("ra,dec\n{ra},{dec}\n250,-80\n"));
    assert_eq!((again.len(), cell(&again, 2, "flux_aper_1")), (3, ""));
    assert!((light(&again, 1) / light(&csv, 2) - 1.0).abs() < 1e-4, "{again:?}");
    assert!((cell(&again, 1, "x").parse::<f64>().expect("a place") - 41.0).abs() < 1e-4);
}

/// Pixels and places are those of the whole image, whichever way it comes in.
#[test]
fn an_image_comes_as_a_section_or_by_standard_input() {
    let folder = Folder::new("section");
    let (sky, out) = (folder.file("sky.fits"), folder.file("out"));
    write_sky(&sky, &[]);
    let fixed = ["--out", &out, "--overwrite", "--preset", "paper-f160", "--no-pictures"];
    let section = format!("{sky}[PRIMARY][31:60,*]");
    let output = skyfront(["segment", &section].iter().chain(&fixed));
    assert!(output.status.success(), "{}", messages(&output));
    let part = lines(&folder, "catalog.csv");
    let mut piped = Command::new(program());
    piped.args(["segment", "-"]).args(fixed).stdin(fs::File::open(&sky).expect("a file"));
    let piped = piped.output().expect("the program can be started");
    assert!(piped.status.success(), "{}", messages(&piped));
    let whole = lines(&folder, "catalog.csv");
    assert_eq!((part.len(), whole.len()), (2, 3));
    let value = |csv: &[String], row: usize, name: &str| cell(csv, row, name).parse::<f64>().expect("a number");
    assert!((value(&part, 1, "x") + 30.0 - value(&whole, 2, "x")).abs() < 1e-3);
    assert!((value(&part, 1, "ra") - value(&whole, 2, "ra")).abs() < 1e-7);
    let output = skyfront(["segment", &format!("{sky}[1:99,1:9]")].iter().chain(&fixed));
    assert_eq!(output.status.code(), Some(1));
    assert!(messages(&output).contains("section [1:99,1:9]"), "{}", messages(&output));
}

#[test]
fn neighbours_are_an_option_that_the_table_tells() {
    let folder = Folder::new("neighbours");
    let sky = folder.file("sky.fits");
    write_sky(&sky, &[]);
    let kron = |how: &[&str]| {
        let out = folder.file("out");
        let fixed = ["segment", &sky, "--out", &out, "--overwrite", "--no-pictures", "--preset", "paper-f160"];
        let output = skyfront(fixed.iter().chain(how));
        assert!(output.status.success(), "{}", messages(&output));
        let table = image(folder.path().join("out/segmentation.fits").as_ref(), None);
        assert!(table.is_ok());
        let text = fs::read_to_string(folder.path().join("out/summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        summary["measuring"]["SFNEIGHB"].as_str().expect("a text").to_owned()
    };
    assert_eq!(kron(&[]), "correct");
    assert_eq!(kron(&["--neighbours", "mask"]), "mask");
}

#[test]
fn alternate_coordinates_are_those_of_their_letter() {
    let more = ["CTYPE1A", "CTYPE2A", "CRPIX1A", "CRPIX2A", "CRVAL1A", "CRVAL2A", "CDELT1A", "CDELT2A"];
    let values: [Value; 8] = [
        "RA---CAR".into(),
        "DEC--CAR".into(),
        30.0.into(),
        30.0.into(),
        200.0.into(),
        0.0.into(),
        (-1e-4).into(),
        1e-4.into(),
    ];
    let more: Vec<Entry> = more.iter().zip(values).map(|(name, value)| Entry::new(name, value, "")).collect();
    let folder = Folder::new("alternate");
    let sky = folder.file("sky.fits");
    write_sky(&sky, &more);
    for (letter, ra) in [(None, 83.6), (Some("A"), 200.0)] {
        let out = folder.file("out");
        let fixed = ["segment", &sky, "--out", &out, "--overwrite", "--no-pictures", "--preset", "paper-f160"];
        let letter: Vec<&str> = letter.iter().flat_map(|letter| ["--wcs", letter]).collect();
        assert!(skyfront(fixed.iter().chain(&letter)).status.success());
        let found: f64 = cell(&lines(&folder, "catalog.csv"), 1, "ra").parse().expect("a number");
        assert!((found - ra).abs() < 0.01, "{found} is not near {ra}");
    }
}

#[test]
fn the_names_of_sextractor_are_listed() {
    let output = skyfront(["columns", "--sextractor"]);
    let text = String::from_utf8_lossy(&output.stdout);
    for pair in [["FLUX_AUTO", "flux_kron"], ["XWIN_IMAGE", "xwin"], ["FLAGS", "flags_sex"]] {
        let found = text.lines().any(|line| line.split_whitespace().eq(pair));
        assert!(found, "{pair:?} is not in {text}");
    }
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
