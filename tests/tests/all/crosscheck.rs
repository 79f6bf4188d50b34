//! `skyfront crosscheck` and `skyfront reproduce` as a user runs them: verdicts, JSON, test vectors and the captions.

use serde_json::Value;
use skyfront::crosscheck::combination;
use skyfront::input::Combine;
use skyfront::read::Image;
use skyfront::reproduce::captions;
use skyfront::truth::simulated;
use skyfront::write::fits::Writer;
use skyfront_core::config::{Config, Filter, Order};
use skyfront_core::run::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};
use skyfront_tests::command::{Folder, messages, skyfront};
use std::fs;
use std::path::Path;
use std::process::Output;

const WIDTH: usize = 52;
const HEIGHT: usize = 44;

fn with_sky(name: &str) -> (Folder, String) {
    let folder = Folder::new(name);
    let path = folder.file("sky.fits");
    let mut sky = Sky::new(Kind::Bright, 5, WIDTH, HEIGHT);
    let mut writer = Writer::create(Path::new(&path)).expect("the file can be made");
    let row = |y, out: &mut [f32]| {
        let Ok(()) = sky.row(y, out);
    };
    writer.image((WIDTH, HEIGHT), &[], row).expect("the image can be written");
    writer.finish().expect("the file can be closed");
    (folder, path)
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn all_schemes_and_arithmetics_pass_within_the_documented_tolerances() {
    let (_folder, sky) = with_sky("crosscheck");
    let run = skyfront(["crosscheck", &sky, "--preset", "paper-f160", "--json"]);
    assert_eq!(run.status.code(), Some(0), "{}{}", text(&run), messages(&run));
    let report: Value = serde_json::from_slice(&run.stdout).expect("JSON and nothing else");
    assert_eq!(report["passed"], true);
    let checks = report["checks"].as_array().expect("a list of checks");
    let word = |check: &Value, name: &str| check[name].as_str().expect("a word").to_owned();
    let names: Vec<String> = checks.iter().map(|c| [word(c, "scheme"), word(c, "arithmetic")].join(" ")).collect();
    // 16 bits cannot resolve so weak a curvature as the paper's.
    let wanted = ["fd f32", "fd q24", "fd q11", "sl f32", "sl q24", "sl q11"];
    let curved = ["fd-curvature f32", "fd-curvature q24", "sl-curvature f32", "sl-curvature q24"];
    assert_eq!(names, [&wanted[..], &curved[..]].concat());
    for check in checks {
        let compared = check["compared"].as_array().expect("the steps that were compared");
        let steps: Vec<&str> = compared.iter().flat_map(|step| step["step"].as_str()).collect();
        assert_eq!(steps, STEPS);
        assert!(compared[1]["max"].as_f64() > Some(0.0), "two programs that agree to the last bit are one: {check}");
        let whole = &check["whole_run"];
        assert!(whole["steps"]["core"].as_u64() > Some(10) && check["failures"] == serde_json::json!([]), "{check}");
    }
    let table = text(&skyfront(["crosscheck", &sky, "--preset", "paper-f160", "--scheme", "sl"]));
    assert!(table.starts_with("sl f32: ok\n") && table.contains("mask pixels 0,"), "{table}");
    assert!(STEPS.iter().all(|step| table.contains(&format!("\n  {step:<12} "))), "{table}");
}

/// Stars without noise, whose neighbouring pixels are together beyond the range of fixed point.
#[test]
fn the_brightest_pixels_pass_step_by_step() {
    let folder = Folder::new("crosscheck-brightest");
    let path = folder.file("sky.fits");
    let mut writer = Writer::create(Path::new(&path)).expect("the file can be made");
    let star = |x: usize, y: usize, peak: f32, (cx, cy): (f32, f32)| {
        let square = (x as f32 - cx).powi(2) + (y as f32 - cy).powi(2);
        peak * (-square / 4.0).exp()
    };
    let row = |y: usize, out: &mut [f32]| {
        for (x, pixel) in out.iter_mut().enumerate() {
            let noise = ((x * 7919 + y * 104_729) % 97) as f32 / 97.0;
            *pixel = noise + star(x, y, 90_000.0, (20.3, 17.6)) + star(x, y, 30_000.0, (33.5, 28.0));
        }
    };
    writer.image((WIDTH, HEIGHT), &[], row).expect("the image can be written");
    writer.finish().expect("the file can be closed");
    let run = skyfront(["crosscheck", &path]);
    assert_eq!(run.status.code(), Some(0), "{}{}", text(&run), messages(&run));
    assert!(text(&run).contains("region q24: ok"), "{}", text(&run));
}

/// What `crosscheck` compares of a run of the paper, in the order in which it looks at it.
const STEPS: [&str; 13] = [
    "filtered",
    "u",
    "change",
    "stop",
    "levels",
    "normalised",
    "tau",
    "rescaled",
    "gradient",
    "g",
    "u0",
    "labels",
    "centroids",
];

/// What is compared of the default, and of the paper's front on signal-to-noise.
const DEFAULT_STEPS: [&str; 19] = [
    "sky",
    "signal",
    "fine",
    "smooth",
    "mask",
    "u0",
    "u",
    "sharpened",
    "tree",
    "opened",
    "shapes",
    "borders",
    "deblended",
    "matched",
    "labels",
    "facts",
    "photon",
    "cut",
    "centroids",
];

#[test]
fn the_default_passes_step_by_step() {
    let (_folder, sky) = with_sky("crosscheck-default");
    let options = [&[][..], &["--filter", "median5"], &["--preset", "rsa"]];
    for (options, scheme) in options.into_iter().zip(["region", "region", "fd"]) {
        let run = skyfront(["crosscheck", &sky, "--json"].iter().chain(options));
        assert_eq!(run.status.code(), Some(0), "{}{}", text(&run), messages(&run));
        let report: Value = serde_json::from_slice(&run.stdout).expect("JSON and nothing else");
        let checks = report["checks"].as_array().expect("a list of checks");
        let names: Vec<_> =
            checks.iter().map(|check| (check["scheme"].as_str(), check["arithmetic"].as_str())).collect();
        assert_eq!(names, [(Some(scheme), Some("f32")), (Some(scheme), Some("q24"))]);
        for check in checks {
            let compared = check["compared"].as_array().expect("the steps that were compared");
            let steps: Vec<&str> = compared.iter().flat_map(|step| step["step"].as_str()).collect();
            let missing = DEFAULT_STEPS.iter().filter(|step| !steps.contains(step));
            assert_eq!(missing.collect::<Vec<_>>(), [&""; 0], "{check}");
            let filters = options.contains(&"median5");
            assert!(["filtered", "smoothed"].iter().all(|step| steps.contains(step) == filters), "{check}");
            assert!(scheme == "region" || STEPS[..11].iter().all(|step| *step == "filtered" || steps.contains(step)));
            assert!(
                compared[1]["max"].as_f64() > Some(0.0),
                "two programs that agree to the last bit are one: {check}"
            );
            assert_eq!(check["whole_run"]["sources"]["core"], check["whole_run"]["sources"]["reference"]);
        }
    }
    let run = skyfront(["crosscheck", &sky, "--vectors", "nowhere"]);
    assert_eq!(run.status.code(), Some(2), "{}", text(&run));
    assert!(messages(&run).contains("--vectors are those of a front on pixel values"), "{}", messages(&run));
}

#[test]
fn brackets_choose_a_part_of_the_image() {
    let (_folder, sky) = with_sky("crosscheck-part");
    let run = skyfront(["crosscheck", &format!("{sky}[5:44,3:34]"), "--json"]);
    assert_eq!(run.status.code(), Some(0), "{}{}", text(&run), messages(&run));
    let outside = skyfront(["crosscheck", &format!("{sky}[5:44,3:99]")]);
    assert!(outside.status.code() == Some(1) && messages(&outside).contains("52 x 44"), "{}", messages(&outside));
}

/// Images that are searched together: their combination and the run over it, or one front in all of them.
#[test]
fn images_searched_together_pass_step_by_step() {
    let folder = Folder::new("crosscheck-together");
    let skies = ["31", "32", "33"].map(|seed| {
        let out = folder.file(seed);
        let sky = skyfront(["simulate", "--kind", "noisy", "--seed", seed, "--side", "60", "--out", &out]);
        assert!(sky.status.success(), "{}", messages(&sky));
        format!("{out}/sky.fits")
    });
    let line = ["crosscheck", &skies[0], "--json", "--with", &skies[1], "--with", &skies[2]];
    let vector: &[&str] = &["--preset", "chan-vese", "--combine", "vector"];
    let chi2_of_paper: &[&str] = &["--preset", "chan-vese", "--combine", "chi2"];
    for (options, combined, arithmetics) in
        [(&[][..], true, 2), (&["--combine", "chi2"], true, 2), (chi2_of_paper, true, 3), (vector, false, 2)]
    {
        let run = skyfront(line.iter().chain(options));
        assert_eq!(run.status.code(), Some(0), "{options:?}: {}{}", text(&run), messages(&run));
        let report: Value = serde_json::from_slice(&run.stdout).expect("JSON and nothing else");
        let checks = report["checks"].as_array().expect("a list of checks");
        assert_eq!(checks.len(), arithmetics, "{options:?}");
        for check in checks {
            let compared = check["compared"].as_array().expect("the steps that were compared");
            let steps: Vec<&str> = compared.iter().flat_map(|step| step["step"].as_str()).collect();
            assert_eq!(steps.contains(&"combined"), combined, "{options:?}");
            let of_front =
                ["levels", "normalised", "rescaled", "filtered", "tau", "u0", "u", "change", "stop", "labels"];
            assert!(options != vector || of_front.iter().all(|step| steps.contains(step)), "{steps:?}");
            assert_eq!(check["whole_run"]["sources"]["core"], check["whole_run"]["sources"]["reference"]);
        }
    }
    for (options, expected) in [
        (&["--with", &skies[1], "--combine", "vector"][..], "--combine vector needs --scheme chan-vese"),
        (&["--with", &skies[1], "--combine", "sum"], "invalid value 'sum'"),
        (&["--combine", "chi2"], "--with <IMAGE2>"),
        (&["--with", &skies[1], "--vectors", "nowhere"], "cannot be used with"),
    ] {
        let run = skyfront(["crosscheck", &skies[0]].iter().chain(options));
        assert_eq!(run.status.code(), Some(2), "{options:?}: {}", text(&run));
        assert!(messages(&run).contains(expected), "{options:?}: {}", messages(&run));
    }
}

/// A combination of another kind, or of other images, is noticed.
#[test]
fn other_combinations_are_noticed() {
    const SIDE: usize = 60;
    let [mut one, two] = [31, 32].map(|seed| simulated(Kind::Noisy, seed, SIDE, SIDE).0);
    one.pixels[200] = f32::NAN;
    let together = Combine::Chi2.of(&[&one, &two]);
    let beyond = |images: [&Image; 2], how| {
        let images = images.map(|image| image.pixels.as_slice());
        combination(&images, how, &together, SIDE).map(|found| found.beyond > 0.0)
    };
    assert_eq!(beyond([&one, &two], Combine::Chi2), Some(false));
    assert_eq!(beyond([&one, &two], Combine::Weighted), Some(true));
    assert_eq!(beyond([&one, &one], Combine::Chi2), Some(true));
    assert_eq!(beyond([&one, &two], Combine::Vector), None, "they stay apart");
}

/// In miniature what `tests/proof/crosscheck` does: every preset, in every arithmetic that serves it.
#[test]
fn every_preset_passes_on_every_kind_of_sky() {
    let folder = Folder::new("crosscheck-presets");
    let arithmetics = |preset: &str| match preset {
        // 16 bits cannot resolve so weak a curvature as the paper's.
        "paper-f160" | "paper-real" => 10,
        "chan-vese" => 3,
        _ => 2,
    };
    let listed = text(&skyfront(["presets"]));
    let names = listed.lines().filter(|line| line.starts_with(char::is_alphabetic));
    let presets: Vec<&str> = names.flat_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(presets.len(), 6, "{presets:?}");
    for (seed, kind) in [("21", "bright"), ("22", "noisy"), ("23", "stars")] {
        let out = folder.file(kind);
        let sky = skyfront(["simulate", "--kind", kind, "--seed", seed, "--side", "44", "--out", &out]);
        assert!(sky.status.success(), "{}", messages(&sky));
        for preset in &presets {
            let run = skyfront(["crosscheck", &format!("{out}/sky.fits"), "--preset", *preset]);
            assert_eq!(run.status.code(), Some(0), "{kind}, {preset}: {}{}", text(&run), messages(&run));
            let passed = text(&run).lines().filter(|line| line.ends_with(": ok")).count();
            assert_eq!(passed, arithmetics(preset), "{kind}, {preset}: {}", text(&run));
        }
    }
}

/// Where the reference has nothing to say, nothing is "ok".
#[test]
fn what_has_no_reference_is_refused_by_name() {
    let (_folder, sky) = with_sky("no-reference");
    let run = skyfront(["crosscheck", &sky, "--preset", "paper-f160", "--start", &sky]);
    assert_eq!(run.status.code(), Some(2), "{}", text(&run));
    assert!(messages(&run).contains("no word on a front that starts from a map"), "{}", messages(&run));
}

/// A limit that no number exceeds would let everything pass.
#[test]
fn limits_that_are_none_are_refused() {
    let (_folder, sky) = with_sky("limits");
    for limit in ["nan", "-1e-3", "-inf", "much"] {
        for option in ["front", "normalised", "rescaled", "edge", "centroid"] {
            let run = skyfront(["crosscheck", &sky, "--preset", "paper-f160", &format!("--max-{option}={limit}")]);
            assert_eq!(run.status.code(), Some(2), "--max-{option}={limit}: {}", text(&run));
            assert!(messages(&run).contains(&format!("--max-{option}")), "{}", messages(&run));
        }
    }
}

/// A manifest whose sizes overflow any product.
#[test]
fn vectors_of_no_possible_size_are_refused() {
    let folder = Folder::new("vectors-overflow");
    fs::write(folder.path().join("input.f32"), b"").expect("it can be written");
    for (width, height) in [(1, 1u64 << 62), (1 << 62, 8), (u64::MAX, u64::MAX), (1 << 40, 1 << 40)] {
        let manifest = serde_json::json!({
            "width": width, "height": height, "input": { "file": "input.f32", "crc32": "00000000" },
            "configurations": [],
        });
        fs::write(folder.path().join("vectors.json"), manifest.to_string()).expect("it can be written");
        let run = skyfront(["crosscheck", "--from-vectors", &folder.path().display().to_string()]);
        assert_eq!(run.status.code(), Some(1), "{width} x {height}: {}", messages(&run));
        assert!(messages(&run).contains("not the image that vectors.json describes"), "{}", messages(&run));
    }
}

/// The presets of the paper are figures of it, one for each of its tests, in `segment` as in `reproduce`.
#[test]
fn the_presets_are_captions() {
    let figures = captions();
    let text = |config: Config| figures.iter().find(|caption| caption.config == config).map(|caption| caption.text);
    assert_eq!(text(Config::PAPER_F160), Some("r3, FD, g2mod 0.8"));
    assert_eq!(text(Config::PAPER_REAL), Some("r1, PM, FD, g2mod 0.78"));
    // The paper rescales before Perona and Malik's filter, and filters by the heat equation before it rescales.
    for caption in figures.iter().filter(|caption| caption.test == 2) {
        let pm = matches!(caption.config.filter, Filter::PeronaMalik { .. });
        let order = if pm { Order::RescaleFirst } else { Order::FilterFirst };
        assert_eq!(caption.config.order, order, "{}", caption.text);
    }
}

#[test]
fn a_tolerance_that_is_exceeded_is_exit_code_1_and_named() {
    let (_folder, sky) = with_sky("tight");
    for (option, failure) in [("--max-front", "u"), ("--max-normalised", "normalised"), ("--max-edge", "g")] {
        let run = skyfront(["crosscheck", &sky, "--preset", "paper-f160", "--scheme", "fd", option, "1e-12"]);
        assert_eq!(run.status.code(), Some(1), "{}", text(&run));
        assert!(text(&run).contains(&format!("fd f32: FAILED: {failure}\n")), "{}", text(&run));
        assert!(messages(&run).contains("of 3 checks exceed a tolerance"), "{}", messages(&run));
    }
}

#[test]
fn vectors_are_replayed_and_a_damaged_one_is_caught() {
    let (folder, sky) = with_sky("vectors");
    let vectors = folder.file("vectors");
    let options = ["--preset", "paper-f160", "--scheme", "sl", "--rescale", "r1", "--t-max", "0.9"];
    let run = skyfront(["crosscheck", &sky, "--vectors", &vectors].iter().chain(&options));
    assert_eq!(run.status.code(), Some(0), "{}{}", text(&run), messages(&run));
    let stages = ["normalised", "rescaled", "filtered", "g", "u0", "u", "labels"];
    let mut wanted = vec!["input.f32".to_owned(), "vectors.json".to_owned()];
    wanted.extend(["f32", "q24", "q11"].iter().flat_map(|a| stages.map(|stage| format!("{a}-sl-{stage}.bin"))));
    wanted.sort();
    assert_eq!(folder.names("vectors"), wanted);
    let bytes = |name: &str| fs::metadata(folder.path().join("vectors").join(name)).expect("a vector").len();
    assert_eq!([bytes("f32-sl-u.bin"), bytes("q11-sl-u.bin")], [4, 2].map(|cell| cell * (WIDTH * HEIGHT) as u64));

    let replay = || skyfront(["crosscheck", "--from-vectors", &vectors]);
    let run = replay();
    assert_eq!(run.status.code(), Some(0), "{}{}", text(&run), messages(&run));

    let manifest = folder.path().join("vectors/vectors.json");
    let good = fs::read_to_string(&manifest).expect("the manifest");
    let description: Value = serde_json::from_str(&good).expect("JSON");
    let crc = description["configurations"][0]["runs"][1]["stages"][3]["crc32"].as_str().expect("a digest");
    fs::write(&manifest, good.replace(crc, "01234567")).expect("it can be written");
    let run = replay();
    assert_eq!(run.status.code(), Some(1));
    assert!(text(&run).starts_with(&format!("sl q24: g is {crc}, not \"01234567\"")), "{}", text(&run));

    fs::write(&manifest, &good).expect("it can be written");
    let input = folder.path().join("vectors/input.f32");
    let mut image = fs::read(&input).expect("the image");
    image[1000] ^= 1;
    fs::write(&input, image).expect("it can be written");
    let run = replay();
    assert_eq!(run.status.code(), Some(1));
    assert!(messages(&run).contains("not the image that vectors.json describes"), "{}", messages(&run));
}

#[test]
fn every_caption_is_reproduced_and_drawn() {
    let (folder, sky) = with_sky("reproduce");
    let run = skyfront(["reproduce", &sky, "--out", &folder.file("out")]);
    assert_eq!(run.status.code(), Some(0), "{}", messages(&run));
    let table = text(&run);
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split('\t').collect()).collect();
    assert_eq!(
        rows[0],
        ["image", "test", "caption", "paper t", "t", "time", "steps", "stop", "mask pixels", "sources"]
    );
    assert_eq!(rows.iter().filter(|row| row[1] == "1").count(), 16, "{table}");
    assert_eq!(rows.iter().filter(|row| row[1] == "2").count(), 8, "{table}");
    // Erratum 3: as printed, finite differences with curvature come to rest later, or in a larger frame never.
    let [consistent, printed] = [3, 4].map(|index| &rows[index]);
    assert_eq!((consistent[2], printed[2]), ("none, FD curvature 1e-4, g1", "the same, as printed"));
    let steps = |row: &[&str]| row[6].parse::<u32>().expect("a number of steps");
    assert!(steps(printed) > steps(consistent), "{table}");
    let sheet =
        png::Decoder::new(std::io::BufReader::new(fs::File::open(folder.file("out/reproduce.png")).expect("a sheet")));
    let sheet = sheet.read_info().expect("a PNG");
    assert!(sheet.info().width as usize > 2 * WIDTH && sheet.info().height as usize > 8 * HEIGHT, "{:?}", sheet.info());
    let page = fs::read_to_string(folder.file("out/reproduce.md")).expect("a page");
    for row in &rows[1..] {
        assert!(
            page.contains(&format!("| {} | {} | {} | {} | {} |", row[1], row[2], row[3], row[4], row[5])),
            "{row:?}"
        );
    }
    assert!(
        page.contains("| - | the default | - | - | - |") && page.contains("| r3 is best (high resolution) |"),
        "{page}"
    );
    let pictures = page.lines().filter_map(|line| line.strip_prefix("![")?.split_once(']'));
    let pictures: Vec<&str> = pictures.map(|(name, _)| name).collect();
    assert_eq!(pictures, ["reproduce-curves.png", "reproduce-1.png", "reproduce.png"]);
    assert!(pictures.iter().all(|name| folder.path().join("out").join(name).exists()));
}
