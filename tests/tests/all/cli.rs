//! The command line as a user meets it: results, messages, exit codes, and nothing half-written.

use skyfront::read::image;
use skyfront_core::packet::{Cursor, stars};
use skyfront_core::track::Star;
use skyfront_tests::command::{Folder, messages, program, skyfront};
use skyfront_tests::fits_bytes::{Header, samples};
use std::fs;
use std::process::Command;

const PRODUCTS: [&str; 9] = [
    "catalog.csv",
    "catalog.fits",
    "front.fits",
    "overlay.png",
    "report.html",
    "segmentation.fits",
    "segmented.fits",
    "stages.png",
    "summary.json",
];

/// A folder with the demo's sky in it.
fn with_sky(name: &str) -> (Folder, String) {
    let folder = Folder::new(name);
    let demo = skyfront(["demo", "--quiet", "--out", &folder.file("demo")]);
    assert!(demo.status.success(), "{}", messages(&demo));
    let sky = folder.file("demo/sky.fits");
    (folder, sky)
}

fn summary(folder: &Folder, run: &str) -> serde_json::Value {
    let text = fs::read_to_string(folder.path().join(run).join("summary.json")).expect("a summary was written");
    serde_json::from_str(&text).expect("the summary is JSON")
}

/// Runs `skyfront` and expects failure: exit code, one line on stderr that contains `word`.
fn fails(arguments: &[&str], code: i32, word: &str) {
    let output = skyfront(arguments);
    let text = messages(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
    assert!(text.contains(word), "{arguments:?}: '{word}' is not in: {text}");
    if code == 1 {
        assert_eq!(text.lines().count(), 1, "{arguments:?}: more than one line: {text}");
    }
}

#[test]
fn the_demo_makes_a_sky_and_every_product() {
    let folder = Folder::new("demo");
    let output = skyfront(["demo", "--out", &folder.file("out")]);
    assert!(output.status.success(), "{}", messages(&output));
    let mut expected: Vec<&str> = PRODUCTS.to_vec();
    expected.extend(["sky.fits", "truth.fits", "demo.png", "demo.json"]);
    expected.sort_unstable();
    assert_eq!(folder.names("out"), expected);

    // What it says of the default is what scoring the map against the truth gives.
    let [sky, truth, map] = ["sky", "truth", "segmentation"].map(|name| folder.file(&format!("out/{name}.fits")));
    let score = skyfront(["score", &truth, &map, "--image", &sky]);
    let score: serde_json::Value = serde_json::from_slice(&score.stdout).expect("JSON");
    let text = fs::read_to_string(folder.file("out/demo.json")).expect("a record");
    let record: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let of = |run: &str, what: &str| record[run][what].as_u64().expect("a number");
    for (ours, theirs) in [("found", "tp"), ("false", "fp"), ("objects", "n_truth"), ("sources", "n_seg")] {
        assert_eq!(record["default"][ours], score[theirs], "{ours}");
    }
    assert!(10 * of("default", "found") > 9 * of("default", "objects") && of("default", "false") <= 2, "{record}");
    let said = messages(&output);
    for (run, name) in [("default", "The default"), ("paper", "The paper's setting")] {
        let line = said.lines().find(|line| line.starts_with(name)).expect("a line for each setting");
        let finds = format!("finds {} of the {} objects, and ", of(run, "found"), of(run, "objects"));
        let wrong = format!("and {} of its {} sources false", of(run, "false"), of(run, "sources"));
        assert!(line.contains(&finds) && line.contains(&wrong), "{line}");
    }
    assert!(said.contains("demo.png first"), "{said}");
}

#[test]
fn the_demo_renews_its_own_files_and_no_others() {
    let folder = Folder::new("demo-again");
    let demo = |more: Option<&str>| skyfront(["demo", "--quiet", "--out", &folder.file("out")].into_iter().chain(more));
    assert!(demo(None).status.success());
    assert!(demo(None).status.success(), "its own files are renewed");
    let picture = folder.file("out/overlay.png");
    fs::write(&picture, "mine").expect("the file can be written");
    let refused = demo(None);
    assert_eq!(refused.status.code(), Some(1));
    assert!(messages(&refused).contains("--overwrite"), "{}", messages(&refused));
    assert_eq!(fs::read(&picture).expect("still there"), b"mine");
    assert!(demo(Some("--overwrite")).status.success());
    assert!(demo(None).status.success());
}

#[test]
fn without_a_command_there_is_help_and_nothing_is_written() {
    let folder = Folder::new("bare");
    let output = Command::new(program()).current_dir(folder.path()).output().expect("the program can be started");
    assert!(output.status.success() && output.stderr.is_empty());
    let help = String::from_utf8(output.stdout).expect("text");
    assert!(help.contains("Usage: skyfront") && help.contains("demo"), "{help}");
    assert!(folder.names(".").is_empty(), "{:?}", folder.names("."));
}

#[test]
fn a_segmented_file_gives_the_same_bytes_as_the_demo_and_as_itself() {
    let (folder, sky) = with_sky("bytes");
    for run in ["one", "two"] {
        let output = skyfront(["segment", &sky, "--preset", "paper-f160", "--quiet", "--out", &folder.file(run)]);
        assert!(output.status.success(), "{}", messages(&output));
        assert!(output.stderr.is_empty(), "quiet is quiet: {}", messages(&output));
    }
    assert_eq!(folder.names("one"), PRODUCTS);
    for product in PRODUCTS.iter().filter(|&&product| product != "summary.json") {
        let read = |run: &str| fs::read(folder.path().join(run).join(product)).expect("the product was written");
        assert_eq!(read("one"), read("two"), "{product} differs between two runs");
    }
    let output = skyfront(["segment", &sky, "--quiet", "--out", &folder.file("default")]);
    assert!(output.status.success(), "{}", messages(&output));
    let digest = |run: &str| summary(&folder, run)["labels_crc32"].clone();
    assert_eq!(digest("default"), digest("demo"));
}

#[test]
fn the_map_alone_is_the_map_of_a_full_run() {
    let (folder, sky) = with_sky("map-only");
    let marched = ["--preset", "paper-f160", "--scheme", "fast-marching", "--arrival", "--no-pictures", "--quiet"];
    let runs = |[full, map]: [&str; 2], options: &[&str]| {
        for (run, more) in [(full, None), (map, Some("--map-only"))] {
            let out = folder.file(run);
            let line = ["segment", &sky, "--out", &out].into_iter().chain(options.iter().copied()).chain(more);
            assert!(skyfront(line).status.success());
        }
    };
    let read = |run: &str, product: &str| fs::read(folder.path().join(run).join(product)).expect("it was written");
    runs(["full", "map"], &marched);
    let expected = ["arrival.fits", "catalog.csv", "catalog.fits", "segmentation.fits", "summary.json"];
    assert_eq!(folder.names("map"), expected);
    assert_eq!(folder.names("full").len(), expected.len() + 2);
    for product in &expected[..4] {
        assert_eq!(read("full", product), read("map", product), "{product} depends on what else is written");
    }
    runs(["default", "default-map"], &["--no-pictures", "--quiet"]);
    for product in ["catalog.csv", "segmentation.fits"] {
        assert_eq!(read("default", product), read("default-map", product), "{product} of the default");
    }
}

#[test]
fn the_map_of_means_has_the_mean_of_each_source() {
    let (folder, sky) = with_sky("means");
    let out = folder.file("out");
    assert!(skyfront(["segment", &sky, "--out", &out, "--no-pictures", "--quiet"]).status.success());
    let product = |name: &str| folder.file(&format!("out/{name}.fits"));
    let [pixels, labels, means] = [sky.clone(), product("segmentation"), product("segmented")]
        .map(|path| image(path.as_ref(), None).expect("it can be read").pixels);
    let mut sums = std::collections::BTreeMap::<u32, (f64, f64)>::new();
    for (label, pixel) in labels.iter().map(|&label| label as u32).zip(&pixels).filter(|(label, _)| *label > 0) {
        let (sum, count) = sums.entry(label).or_default();
        (*sum, *count) = (*sum + f64::from(*pixel), *count + 1.0);
    }
    assert!(sums.len() > 5, "{} sources", sums.len());
    for (label, &mean) in labels.iter().zip(&means) {
        let expected = sums.get(&(*label as u32)).map_or(0.0, |(sum, count)| sum / count);
        assert!((f64::from(mean) - expected).abs() <= 1e-5 * expected.abs(), "source {label}: {mean}, not {expected}");
    }
}

#[test]
fn every_preset_and_scheme_runs() {
    let (folder, sky) = with_sky("schemes");
    let runs: [&[&str]; 8] = [
        &["--preset", "paper-real"],
        &["--preset", "paper-f160", "--scheme", "sl"],
        &["--preset", "paper-f160", "--scheme", "fd-curvature", "--edge", "g1", "--t-max", "1"],
        &["--preset", "paper-f160", "--scheme", "fd-filtered", "--t-max", "1"],
        &["--preset", "chan-vese", "--mu", "0.01", "--lambda1", "2"],
        &["--preset", "paper-f160", "--scheme", "sl-curvature", "--t-max", "1", "--directions", "64"],
        &[
            "--preset",
            "paper-f160",
            "--normalize",
            "percentile",
            "--range",
            "1,99.5",
            "--rescale",
            "r2",
            "--stop",
            "rate",
        ],
        &["--preset", "paper-f160", "--rescale", "none", "--filter", "none", "--edge", "g2", "--connectivity", "4"],
    ];
    for (index, options) in runs.iter().enumerate() {
        let run = format!("run{index}");
        let out = folder.file(&run);
        let arguments = ["segment", &sky, "--out", &out].into_iter().chain(options.iter().copied());
        let output = skyfront(arguments);
        assert!(output.status.success(), "{options:?}: {}", messages(&output));
        assert!(summary(&folder, &run)["iterations"].as_u64().expect("a number") > 0);
    }
}

#[test]
fn the_default_runs_in_32_bits_of_fixed_point_and_is_refused_in_16() {
    let (folder, sky) = with_sky("fixed");
    let run = |arithmetic: &str| {
        skyfront(["segment", &sky, "--no-pictures", "--arithmetic", arithmetic, "--out", &folder.file(arithmetic)])
    };
    for arithmetic in ["f32", "q24"] {
        let output = run(arithmetic);
        assert!(output.status.success(), "{}", messages(&output));
        let summary = summary(&folder, arithmetic);
        assert_eq!(
            (summary["arithmetic"].as_str(), &summary["iterations"]),
            (Some(arithmetic), &serde_json::Value::Null)
        );
    }
    let sources = |run: &str| summary(&folder, run)["n_sources"].clone();
    assert_eq!(sources("f32"), sources("q24"));
    let refused = run("q11");
    assert_eq!(refused.status.code(), Some(2), "{}", messages(&refused));
    assert!(messages(&refused).contains("32 bits"), "{}", messages(&refused));
}

#[test]
fn bad_input_is_one_line_and_leaves_nothing() {
    let (folder, sky) = with_sky("bad");
    let out = folder.file("out");
    let text = folder.file("text.fits");
    fs::write(&text, "this is not an image\n").expect("the file can be written");
    let bytes = fs::read(&sky).expect("the sky was written");
    let cut = folder.file("cut.fits");
    fs::write(&cut, &bytes[..bytes.len() / 2]).expect("the file can be written");

    fails(&["segment", &folder.file("absent.fits"), "--out", &out], 1, "absent.fits");
    fails(&["segment", &text, "--out", &out], 1, "text.fits");
    fails(&["segment", &cut, "--out", &out], 1, "cut.fits");
    fails(&["segment", &sky, "--out", &out, "--hdu", "7"], 1, "7");
    assert!(folder.names("out").is_empty(), "nothing is left behind: {:?}", folder.names("out"));
}

#[test]
fn parameters_out_of_bounds_name_parameter_value_and_bound() {
    let (folder, sky) = with_sky("bounds");
    let out = folder.file("out");
    let cases: [(&[&str], &[&str]); 6] = [
        (&["--dt", "0.06"], &["--dt is 0.06; must be at most 0.05"]),
        (&["--rescale", "r1", "--alpha", "1.5"], &["--alpha is 1.5; must be below 1"]),
        (&["--c2", "1"], &["c2", "below 1"]),
        (&["--filter-dt", "0.01"], &["--filter-dt is 0.01; must be at most 0.0025"]),
        (&["--t-max", "nan"], &["--t-max is NaN; must be"]),
        (&["--normalize", "percentile", "--range", "60,40"], &["--range is 40; must be above 60"]),
    ];
    for (options, words) in cases {
        let arguments =
            ["segment", &sky, "--preset", "paper-f160", "--out", &out].into_iter().chain(options.iter().copied());
        let output = skyfront(arguments);
        let text = messages(&output);
        assert_eq!(output.status.code(), Some(2), "{options:?}: {text}");
        for word in words {
            assert!(text.contains(word), "{options:?}: '{word}' is not in: {text}");
        }
    }
    assert!(folder.names("out").is_empty());
}

#[test]
fn an_image_in_which_nothing_can_stand_out_has_every_product_and_no_source() {
    let folder = Folder::new("flat");
    for (width, height, blank) in [(1, 1, 0), (2, 2, 0), (1, 30, 0), (30, 4, 0), (40, 30, 0), (40, 30, 5), (1, 1, 5)] {
        let image = folder.file("flat.fits");
        let header = Header::primary(16, &[width as u64, height as u64]).card("BLANK", blank);
        fs::write(&image, header.with(samples(16, &vec![5.0; width * height]))).expect("the image can be written");
        for preset in ["noise-aware", "paper-f160"] {
            let out = folder.file("out");
            let more = ["--regions", "--polygons", "--catalog-format", "csv,ecsv,fits,jsonl"];
            let line = ["segment", &image, "--out", &out, "--overwrite", "--preset", preset];
            let output = skyfront(line.iter().chain(&more));
            let text = messages(&output);
            assert!(output.status.success(), "{width} x {height}, {preset}: {text}");
            assert!(text.contains("0 sources") && text.contains("warning: "), "{width} x {height}, {preset}: {text}");
            assert!(PRODUCTS.iter().all(|product| folder.path().join("out").join(product).is_file()));
            let table = fs::read_to_string(folder.file("out/catalog.csv")).expect("a catalogue");
            assert_eq!(table.lines().count(), 1, "the names of the columns only");
            assert_eq!(summary(&folder, "out")["n_sources"], 0);
        }
    }
}

#[test]
fn existing_results_stay_unless_overwrite_is_given() {
    let (folder, sky) = with_sky("overwrite");
    let out = folder.file("out");
    fs::create_dir_all(&out).expect("the folder can be made");
    fs::write(folder.path().join("out/catalog.csv"), "mine").expect("the file can be written");
    fails(&["segment", &sky, "--out", &out], 1, "--overwrite");
    assert_eq!(folder.names("out"), ["catalog.csv"]);
    assert_eq!(fs::read(folder.path().join("out/catalog.csv")).expect("still there"), b"mine");
    let output = skyfront(["segment", &sky, "--out", &out, "--overwrite", "--preset", "paper-f160"]);
    assert!(output.status.success(), "{}", messages(&output));
    assert_eq!(folder.names("out"), PRODUCTS);
}

#[test]
fn bad_usage_is_exit_code_2() {
    fails(&["segment"], 2, "Usage");
    fails(&["segment", "x.fits", "--out", "y", "--scheme", "none"], 2, "scheme");
    fails(&["--no-such-option"], 2, "no-such-option");
}

#[test]
fn packets_from_board_are_printed_and_losses_told() {
    let folder = Folder::new("packets");
    let (mut cursor, mut out, mut bytes) = (Cursor::new(3), [0; 64], Vec::new());
    while let Some(length) = stars(&mut cursor, &[Star::EMPTY; 3], &mut out).expect("room for a packet") {
        bytes.extend(&out[..length]);
    }
    let file = folder.file("downlink.bin");
    let printed = |bytes: &[u8]| {
        fs::write(&file, bytes).expect("a file");
        let output = skyfront(["packets", &file]);
        let lines = String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect::<Vec<_>>();
        (output.status.code(), lines, messages(&output))
    };
    let (code, whole, said) = printed(&bytes);
    assert_eq!((code, whole.len(), said.as_str()), (Some(0), 3, ""));
    let star: serde_json::Value = serde_json::from_str(&whole[2]).expect("a line of JSON");
    assert_eq!((&star["product"], &star["index"]), (&3.into(), &2.into()));
    let (code, lines, said) = printed(&[&bytes[..60], &bytes].concat());
    assert_eq!((code, lines.len()), (Some(0), 3), "a repeated packet is no loss: {said}");
    assert!(said.contains("once more"), "{said}");
    let (code, lines, said) = printed(&bytes[60..]);
    assert_eq!((code, &lines[..]), (Some(1), &whole[1..]));
    assert!(said.contains("packet 0 is lost; 1 of 3 stars are missing"), "{said}");
    fails(&["packets", &folder.file("absent")], 1, "cannot be read");
    fs::write(&file, b"SIMPLE").expect("a file");
    fails(&["packets", &file], 1, "holds no packet");
    fails(&["packets"], 2, "FILE");
}
