//! No setting is dead: each changes a result, on the command line and in a file, or is refused.

use skyfront::read::image;
use skyfront::write::fits::Writer;
use skyfront_core::config::PARAMETERS;
use skyfront_core::run::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};
use skyfront_tests::command::{Folder, messages, skyfront};
use skyfront_tests::noise::galaxy_with_knots;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The two skies that settings are tried on, with their sides.
const BRIGHT: (&str, Kind, u32, usize) = ("bright.fits", Kind::Bright, 3, 64);
const STARS: (&str, Kind, u32, usize) = ("stars.fits", Kind::Stars, 1, 160);

fn with_skies(name: &str) -> Folder {
    let folder = Folder::new(name);
    for (file, kind, seed, side) in [BRIGHT, STARS] {
        let mut sky = Sky::new(kind, seed, side, side);
        let mut writer = Writer::create(Path::new(&folder.file(file))).expect("the file can be made");
        let row = |y, out: &mut [f32]| {
            let Ok(()) = sky.row(y, out);
        };
        writer.image((side, side), &[], row).expect("the image can be written");
        writer.finish().expect("the file can be closed");
    }
    let mut writer = Writer::create(Path::new(&folder.file(KNOTS))).expect("the file can be made");
    let mut pixels = galaxy_with_knots(6, &[0.003; 3]);
    pixels[20 * 140 + 20] += 1000.0;
    writer.image((140, 140), &[], |y, out| out.copy_from_slice(&pixels[y * 140..][..140])).expect("it can be written");
    writer.finish().expect("the file can be closed");
    let mut writer = Writer::create(Path::new(&folder.file("seed.fits"))).expect("the file can be made");
    let row = |y, out: &mut [f32]| out.iter_mut().enumerate().for_each(|(x, out)| *out = f32::from((x, y) == (30, 30)));
    writer.image((BRIGHT.3, BRIGHT.3), &[], row).expect("the map can be written");
    writer.finish().expect("the file can be closed");
    folder
}

/// A setting, the image and the other settings with which it is tried, and two values.
type Case = (&'static str, &'static str, &'static str, [&'static str; 2]);

const B: &str = BRIGHT.0;
const S: &str = STARS.0;
/// A galaxy with three knots, and a hot pixel.
const KNOTS: &str = "knots.fits";
/// Sources that only the allowance for noise decides about.
const FAINT: &str = "threshold=0.3 min-peak=0 min-light=0 min-area=3";

#[rustfmt::skip]
const CASES: &[Case] = &[
    ("sky", S, "", ["mesh", "frame"]),
    ("sky", S, "", ["mesh:64", "mesh:40"]),
    ("sky", S, "preset=paper-f160", ["none", "mesh:40"]),
    ("spike-height", KNOTS, "", ["5", "0"]),
    ("threshold", S, "", ["1", "2"]),
    ("outline-steps", S, "", ["5", "0"]),
    ("outline-curvature", S, "", ["0.6", "0"]),
    ("dx", B, "preset=paper-f160", ["0.1", "0.2"]),
    ("dx", B, "preset=paper-f160 scheme=sl", ["0.1", "0.11"]),
    ("dx", B, "preset=paper-f160 scheme=chan-vese", ["0.1", "0.11"]),
    ("dx", B, "preset=paper-f160 scheme=fast-marching", ["0.1", "0.11"]),
    ("normalize", B, "preset=paper-f160", ["minmax", "noise:3,30"]),
    ("normalize", B, "preset=paper-f160", ["noise:3,30", "noise:3,10"]),
    ("range", B, "preset=paper-f160 normalize=percentile", ["0.5,99.9", "5,99"]),
    ("rescale", B, "preset=paper-f160", ["r1", "r3"]),
    ("alpha", B, "preset=paper-f160 rescale=r1", ["0.25", "0.5"]),
    ("alpha", B, "preset=paper-f160 rescale=r2", ["0.25", "0.5"]),
    ("beta", B, "preset=paper-f160", ["8", "2"]),
    ("tau", B, "preset=paper-f160", ["otsu", "noise:3"]),
    ("tau", B, "preset=paper-f160", ["noise:3", "noise:8"]),
    ("filter", B, "preset=paper-f160", ["none", "heat"]),
    ("filter", S, "", ["adaptive", "gauss"]),
    ("filter", S, "", ["gauss", "none"]),
    ("filter", S, "", ["none", "heat"]),
    ("filter", S, "", ["heat", "pm"]),
    ("filter", S, "", ["median", "median5"]),
    ("filter", S, "", ["bilateral:0.1", "bilateral:0.01"]),
    ("filter", S, "", ["tv:0.1", "tv:0.01"]),
    ("filter", S, "", ["starlet:3", "starlet:10"]),
    ("filter-steps", S, "filter=heat", ["5", "50"]),
    ("filter-dt", S, "filter=heat", ["1e-4", "2e-3"]),
    ("dx", S, "filter=heat", ["0.1", "0.05"]),
    ("pm", S, "filter=pm pm-mu=1", ["f1", "f2"]),
    ("pm-mu", S, "filter=pm", ["1", "30"]),
    ("normalize", S, "filter=bilateral", ["minmax", "noise:3,30"]),
    ("normalize", S, "filter=bilateral", ["noise:3,30", "noise:3,300"]),
    ("range", S, "filter=bilateral normalize=percentile", ["0.5,99.9", "5,99"]),
    ("filter", S, "preset=rsa", ["adaptive", "gauss"]),
    ("filter", S, "preset=rsa", ["none", "heat"]),
    ("filter", B, "preset=paper-f160", ["heat", "median"]),
    ("filter-steps", B, "preset=paper-f160 filter=median", ["1", "2"]),
    ("filter", B, "preset=paper-f160", ["median", "median5"]),
    ("filter", B, "preset=paper-f160 rescale=r1", ["bilateral:0.1", "bilateral:0.01"]),
    ("filter", B, "preset=paper-f160 rescale=r1", ["tv:0.1", "tv:0.01"]),
    ("filter-steps", B, "preset=paper-f160 rescale=r1 filter=tv", ["50", "1"]),
    ("filter", B, "preset=paper-f160 rescale=r1", ["starlet:3", "starlet:10"]),
    ("filter-steps", B, "preset=paper-f160 rescale=r1 filter=starlet", ["4", "1"]),
    ("filter-steps", B, "preset=paper-f160", ["5", "50"]),
    ("filter-dt", B, "preset=paper-f160", ["1e-4", "2e-3"]),
    ("pm", B, "preset=paper-f160 filter=pm pm-mu=1", ["f1", "f2"]),
    ("pm-mu", B, "preset=paper-f160 filter=pm", ["1", "30"]),
    ("order", B, "preset=paper-f160 rescale=r1", ["rescale-first", "filter-first"]),
    ("edge", B, "preset=paper-f160", ["g1", "g2mod"]),
    ("edge", B, "preset=paper-f160 scheme=fast-marching", ["g1", "g2mod"]),
    ("p", B, "preset=paper-f160 edge=g1", ["1", "5000"]),
    ("c2", B, "preset=paper-f160", ["0.8", "0.5"]),
    ("scheme", B, "preset=paper-f160", ["fd", "sl"]),
    ("scheme", S, "", ["region", "fd"]),
    ("scheme", B, "preset=chan-vese", ["chan-vese", "multiphase"]),
    ("nu", B, "preset=paper-f160 scheme=fd-curvature t-max=2", ["1e-4", "1e-2"]),
    ("nu", B, "preset=paper-f160 scheme=sl-curvature t-max=2", ["1e-4", "1e-2"]),
    ("curvature-form", B, "preset=paper-f160 scheme=fd-curvature t-max=2", ["consistent", "printed"]),
    ("curvature-form", B, "preset=paper-f160 scheme=sl-curvature t-max=2", ["consistent", "printed"]),
    ("degenerate", B, "preset=paper-f160 scheme=fd-curvature t-max=2", ["0.1", "1"]),
    ("degenerate", B, "preset=paper-f160 scheme=sl-curvature t-max=2", ["0.1", "1"]),
    ("degenerate", B, "preset=chan-vese", ["0.1", "0.5"]),
    ("degenerate", B, "preset=paper-f160 normalize=noise:3,30 rescale=none scheme=multiphase", ["0.1", "0.5"]),
    ("directions", B, "preset=paper-f160 scheme=sl", ["16", "64"]),
    ("directions", B, "preset=paper-f160 scheme=sl-curvature t-max=2", ["16", "64"]),
    ("mu", B, "preset=chan-vese", ["0.015", "0.1"]),
    ("mu", B, "preset=paper-f160 normalize=noise:3,30 rescale=none scheme=multiphase", ["0.005", "0.02"]),
    ("lambda1", B, "preset=chan-vese", ["1", "2"]),
    ("lambda2", B, "preset=chan-vese", ["1", "2"]),
    ("start", B, "preset=paper-f160", ["frame", "threshold"]),
    ("start", B, "preset=chan-vese", ["frame", "threshold"]),
    ("start", B, "preset=paper-f160 scheme=fast-marching", ["frame", "threshold"]),
    ("margin", B, "preset=paper-f160 start=threshold", ["1", "4"]),
    ("motion", B, "preset=paper-f160 start=FOLDER/seed.fits", ["inward", "outward"]),
    ("degenerate-power", B, "preset=paper-f160 scheme=fd-curvature t-max=2", ["1", "0"]),
    ("degenerate-power", B, "preset=paper-f160 scheme=sl-curvature t-max=2", ["1", "0"]),
    ("dt", B, "preset=paper-f160", ["0.02", "0.025"]),
    ("dt", B, "preset=paper-f160 scheme=sl", ["0.02", "0.025"]),
    ("dt", B, "preset=paper-f160 scheme=fd-filtered", ["0.02", "0.025"]),
    ("dt", B, "preset=paper-f160 scheme=fd-curvature t-max=2", ["0.005", "0.01"]),
    ("dt", B, "preset=paper-f160 scheme=sl-curvature t-max=2", ["0.02", "0.025"]),
    ("dt", B, "preset=chan-vese", ["4", "8"]),
    ("dt", B, "preset=paper-f160 normalize=noise:3,30 rescale=none scheme=multiphase", ["1", "8"]),
    ("t-max", B, "preset=paper-f160", ["50", "1"]),
    ("t-max", B, "preset=paper-f160 normalize=noise:3,30 rescale=none scheme=multiphase", ["8", "16"]),
    ("t-max", B, "preset=paper-f160 scheme=fast-marching", ["0.5", "1"]),
    ("t-max", B, "preset=chan-vese", ["8", "16"]),
    ("band", B, "preset=paper-f160", ["none", "4"]),
    ("band", B, "preset=paper-f160 scheme=sl", ["none", "4"]),
    ("band", B, "preset=paper-f160 scheme=fd-filtered", ["none", "4"]),
    ("band", B, "preset=paper-f160 scheme=fd-curvature t-max=2", ["none", "4"]),
    ("band", B, "preset=paper-f160 scheme=sl-curvature t-max=2", ["none", "4"]),
    ("eps-front", B, "preset=paper-f160", ["0.1", "0.001"]),
    ("eps", B, "preset=paper-f160", ["1e-3", "10"]),
    ("eps", B, "preset=chan-vese", ["1e-3", "10"]),
    ("eps", B, "preset=paper-f160 normalize=noise:3,30 rescale=none scheme=multiphase", ["1e-3", "10"]),
    ("stop", B, "preset=paper-f160", ["paper", "rate"]),
    ("stop", B, "preset=chan-vese eps=0.1", ["paper", "rate"]),
    ("separate", S, "", ["tree", "components"]),
    ("connectivity", S, "", ["8", "4"]),
    ("connectivity", S, "separate=components filter=none select=area", ["8", "4"]),
    ("connectivity", B, "preset=paper-f160 tau=noise:2", ["8", "4"]),
    ("deblend-contrast", S, "", ["0.0005", "0.9"]),
    ("deblend-light", S, "", ["10", "1000"]),
    ("deblend-sharpening", S, "", ["0.5", "2"]),
    ("deblend-excess", S, "", ["5.5", "50"]),
    ("deblend-area", S, "", ["4", "40"]),
    ("deblend-knots", KNOTS, "", ["3", "4"]),
    ("select", S, "threshold=0.3", ["significance", "area"]),
    ("false-sources", S, FAINT, ["0.001", "1000"]),
    ("false-share", S, FAINT, ["0", "0.5"]),
    ("min-peak", S, "", ["1.42", "4"]),
    ("min-light", S, "", ["15", "500"]),
    ("min-area", S, "", ["6", "40"]),
    ("min-area", S, "select=area", ["6", "40"]),
    ("min-area", B, "preset=paper-f160", ["1", "1000"]),
];

/// What a run makes of an image: its labels, its front, and the steps of that.
#[derive(Debug, PartialEq)]
struct Found {
    labels: serde_json::Value,
    steps: serde_json::Value,
    front: Vec<f32>,
}

/// Runs `skyfront segment`; what it finds, or its exit code and message.
fn found(folder: &Folder, file: &str, options: &[String]) -> Result<Found, (Option<i32>, String)> {
    let (sky, out) = (folder.file(file), folder.file("out"));
    let line = ["segment", &sky, "--out", &out, "--overwrite", "--no-pictures", "--quiet", "--json"];
    let output = skyfront(line.into_iter().chain(options.iter().map(String::as_str)));
    if !output.status.success() {
        return Err((output.status.code(), messages(&output)));
    }
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let front = image(folder.file("out/front.fits").as_ref(), None).expect("a front").pixels;
    Ok(Found { labels: summary["labels_crc32"].clone(), steps: summary["iterations"].clone(), front })
}

/// Settings `name=value` as options, or as a file that is named by one.
fn as_options(settings: &[&str]) -> Vec<String> {
    settings.iter().map(|setting| format!("--{setting}")).collect()
}

fn as_file(folder: &Folder, settings: &[&str]) -> Vec<String> {
    let lines = settings.iter().map(|setting| {
        let (name, value) = setting.split_once('=').expect("name=value");
        let value = value.parse::<f64>().map_or(format!("'{value}'"), |_| value.to_owned());
        format!("{} = {value}\n", name.replace('-', "_"))
    });
    let file = folder.file("settings.toml");
    fs::write(&file, lines.collect::<String>()).expect("the file can be written");
    vec!["--config".to_owned(), file]
}

#[test]
fn every_setting_changes_a_result_by_option_and_by_file() {
    let folder = with_skies("settings");
    for &(name, file, others, values) in CASES {
        let results = values.map(|value| {
            let (setting, others) = (format!("{name}={value}"), others.replace("FOLDER", &folder.file(".")));
            let settings: Vec<&str> = others.split_whitespace().chain([setting.as_str()]).collect();
            let by_option = found(&folder, file, &as_options(&settings));
            let by_file = found(&folder, file, &as_file(&folder, &settings));
            assert!(by_option.is_ok(), "{settings:?}: {:?}", by_option.err());
            assert!(by_option == by_file, "{settings:?}: a file gives another result than options");
            by_option
        });
        assert!(results[0] != results[1], "{name} is dead: {values:?} with '{others}' give the same");
    }
    let tried: BTreeSet<&str> = CASES.iter().map(|case| case.0).collect();
    let known: BTreeSet<&str> = PARAMETERS.iter().map(|parameter| parameter.name).collect();
    assert_eq!(tried, known, "every parameter has a case");
}

#[test]
fn what_the_default_does_not_use_is_refused_by_option_and_by_file() {
    let folder = with_skies("unused");
    let refused = [
        ("rescale=r3", "--rescale", "--scheme region", "--preset rsa"),
        ("tau=otsu", "--tau", "--scheme region", "--preset rsa"),
        ("beta=8", "--beta", "--scheme region", "--preset rsa"),
        ("beta=7", "--beta", "--scheme region", "--preset rsa"),
        ("dt=0.025", "--dt", "--scheme region", "--preset rsa"),
        ("normalize=minmax", "--normalize", "--scheme region", "--filter heat, pm, median"),
        ("filter=median dx=0.2", "--dx", "--scheme region", "--filter heat or pm"),
        ("filter-steps=3", "--filter-steps", "--filter adaptive", "--filter heat, pm, median"),
        ("scheme=fd outline-steps=2", "--outline-steps", "--scheme fd", "--preset noise-aware"),
        ("separate=components deblend-light=2", "--deblend-light", "--separate components", "--preset noise-aware"),
        ("select=area min-light=2", "--min-light", "--select area", "--preset noise-aware"),
        ("preset=paper-f160 threshold=2", "--threshold", "--sky none", "--preset noise-aware"),
        ("preset=paper-f160 alpha=0.3", "--alpha", "--rescale r3", "--rescale r1 or r2"),
        ("preset=paper-real beta=4", "--beta", "--rescale r1", "--rescale r3"),
        ("preset=paper-f160 pm-mu=2", "--pm-mu", "--filter heat", "--filter pm"),
        ("preset=paper-f160 edge=g1 c2=0.5", "--c2", "--edge g1", "--edge g2mod"),
        ("preset=paper-f160 nu=0.1", "--nu", "--scheme fd", "--scheme fd-curvature or sl-curvature"),
        ("preset=paper-f160 lambda1=2", "--lambda1", "--scheme fd", "--scheme chan-vese"),
        ("preset=paper-f160 margin=2", "--margin", "--start frame", "--start threshold or map"),
        ("preset=paper-f160 range=1,99", "--range", "--normalize minmax", "--normalize percentile"),
        ("preset=paper-f160 scheme=fast-marching dt=0.01", "--dt", "--scheme fast-marching", "--scheme fd"),
    ];
    for (settings, option, not_used_by, way_out) in refused {
        let settings: Vec<&str> = settings.split_whitespace().collect();
        for options in [as_options(&settings), as_file(&folder, &settings)] {
            let (code, message) = found(&folder, B, &options).expect_err("an option that is not used");
            assert_eq!(code, Some(2), "{settings:?}: {message}");
            let expected = format!("skyfront: {option} is not used by {not_used_by}; it needs ");
            assert!(message.starts_with(&expected) && message.contains(way_out), "{settings:?}: {message}");
            assert_eq!(message.lines().count(), 1, "{message}");
        }
    }
}

#[test]
fn choices_that_cannot_go_together_are_refused_by_option_and_by_file() {
    let folder = with_skies("together");
    for (settings, expected) in [
        ("sky=none", "--scheme region needs --sky mesh or frame"),
        ("preset=paper-f160 filter=adaptive", "--filter adaptive needs --sky mesh or frame"),
        ("preset=paper-f160 filter=gauss", "--filter gauss needs --sky mesh or frame"),
        ("preset=paper-f160 separate=tree", "--separate tree needs --sky mesh or frame"),
        ("preset=paper-f160 select=significance", "--select significance needs --sky mesh or frame"),
    ] {
        let settings: Vec<&str> = settings.split_whitespace().collect();
        for options in [as_options(&settings), as_file(&folder, &settings)] {
            let refused = found(&folder, S, &options).expect_err("choices that cannot go together");
            assert_eq!(refused, (Some(2), format!("skyfront: {expected}\n")), "{settings:?}");
        }
    }
}

#[test]
fn connectivity_and_area_are_no_wish_for_another_outline() {
    let folder = with_skies("same-outline");
    for settings in [["preset=noise-aware", "connectivity=4"], ["min-area=7", "connectivity=8"]] {
        let result = found(&folder, S, &as_options(&settings)).expect("a result");
        assert_eq!(result.steps, serde_json::Value::Null, "{settings:?}: no front moves");
    }
}

#[test]
fn names_of_other_programs_are_translated() {
    let folder = with_skies("foreign");
    for (option, ours) in [
        ("--DETECT_THRESH=1.5", "--threshold"),
        ("-DETECT_THRESH", "--threshold"),
        ("--thresh", "--threshold"),
        ("--detect-minarea=5", "--min-area"),
        ("--deblend-mincont=0.01", "--deblend-contrast"),
    ] {
        let (code, message) = found(&folder, B, &[option.to_owned()]).expect_err("a foreign name");
        assert_eq!(code, Some(2), "{message}");
        assert!(message.contains(&format!("here it is {ours}")), "{option}: {message}");
    }
    let file = as_file(&folder, &["detect_thresh=2"]);
    let (code, message) = found(&folder, B, &file).expect_err("a foreign key");
    assert!(code == Some(2) && message.contains("here it is threshold"), "{message}");
}

#[test]
fn results_tell_every_parameter_that_was_used_and_no_other() {
    let folder = with_skies("told");
    for (options, used, unused) in [
        (&["threshold=2", "min-area=9"], ["SFTHRESH", "SFMINAR", "SFCONTR"], ["SFNORM", "SFDT"]),
        (&["preset=paper-f160", "min-area=9"], ["SFSKY", "SFMINAR", "SFTAU"], ["SFTHRESH", "SFALPHA"]),
    ] {
        found(&folder, B, &as_options(options)).expect("a result");
        let header = image(folder.file("out/segmentation.fits").as_ref(), None).expect("a map").header;
        let has = |keyword: &str| header.cards().iter().any(|card| card.keyword() == keyword);
        assert_eq!(header.integer("SFMINAR"), Some(9));
        assert!(used.into_iter().all(has) && !unused.into_iter().any(has), "{options:?}");
        let text = fs::read_to_string(folder.file("out/summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(summary["parameters"]["min_area"], 9, "{summary}");
    }
}
