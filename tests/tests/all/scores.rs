//! `skyfront score`: by hand, against the independent scorer, and what the default reaches.

use serde_json::Value;
use skyfront::extraction::segment;
use skyfront::pipeline::Drive;
use skyfront::read::{HduChoice, image};
use skyfront::score::score;
use skyfront::write::fits::Writer;
use skyfront_core::arithmetic::{F32, Fixed14};
use skyfront_core::config::Config;
use skyfront_tests::command::{Folder, skyfront};
use skyfront_tests::runs::apart;
use skyfront_tests::scenes::{folder, load};
use std::path::Path;
use std::process::Command;

/// Two objects of four pixels in a row of twelve.
const TRUTH: [i64; 12] = [0, 1, 1, 1, 1, 0, 0, 2, 2, 2, 2, 0];
const LIGHT: [f32; 12] = [0.0, 2.0, 9.0, 2.0, 1.0, 0.0, 0.0, 1.0, 5.0, 2.0, 1.0, 0.0];

#[test]
fn a_perfect_map_has_full_marks_whatever_its_labels() {
    let map = TRUTH.map(|label| [0, 70, 5][label as usize]);
    let result = score(&TRUTH, &map, &LIGHT);
    assert_eq!((result.f_score, result.combined, result.mean_iou, result.panoptic), (1.0, 1.0, 1.0, 1.0));
}

#[test]
fn a_lost_and_a_merged_object_cost_what_they_should() {
    let lost = TRUTH.map(|label| if label == 2 { 0 } else { label });
    let result = score(&TRUTH, &lost, &LIGHT);
    assert_eq!((result.completeness, result.purity), (0.5, 1.0));
    assert!((result.f_score - 2.0 / 3.0).abs() < 1e-12);
    // Object 2 and the true background share a segment of 8 pixels: twice (8 - 4) 4 / 8, over 12 pixels.
    assert!((result.over_merging - 4.0 / 12.0).abs() < 1e-12);
    assert_eq!(result.under_merging, 0.0);
    let merged = [0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0];
    let result = score(&TRUTH, &merged, &LIGHT);
    // The segment of ten pixels goes to the brighter of the two that it covers.
    assert_eq!((result.matched, result.completeness, result.purity), (1, 0.5, 1.0));
    assert!((result.mean_iou - 0.4).abs() < 1e-12);
    // Each object lies in that segment: twice (10 - 4) 4 / 10. Of the background half is in each
    // segment; the first counts, which holds nothing else.
    assert!((result.over_merging - 4.8 / 12.0).abs() < 1e-12);
}

#[test]
fn a_split_object_is_one_find_and_one_false_alarm() {
    let split = [0, 1, 1, 3, 3, 0, 0, 2, 2, 2, 2, 0];
    let result = score(&TRUTH, &split, &LIGHT);
    assert_eq!((result.matched, result.segments, result.completeness), (2, 3, 1.0));
    assert!((result.purity - 2.0 / 3.0).abs() < 1e-12);
    // Each half misses two of four pixels: twice (4 - 2) 2 / 4.
    assert!((result.under_merging - 2.0 / 12.0).abs() < 1e-12);
}

/// Python with what `score.py` needs.
fn python() -> bool {
    let found = Command::new("python3").args(["-c", "import numpy, astropy"]).output();
    let found = found.is_ok_and(|output| output.status.success());
    if !found {
        eprintln!("SKIPPED: python3 has no numpy or no astropy");
    }
    found
}

#[test]
fn the_command_agrees_with_the_independent_scorer() {
    let Some(scenes) = folder().filter(|_| python()) else { return };
    let place = |name: &str| scenes.join(name).display().to_string();
    let (truth, light) = (place("deep_dev0_truth.fits.gz"), place("deep_dev0.fits"));
    let scene = load("deep_dev0").expect("the folder is there");
    let run =
        segment::<F32, f32>(&Config::NOISE_AWARE, &scene.pixels, scene.width, &mut Drive::default()).expect("a scene");
    let temporary = Folder::new("scores");
    let map = temporary.file("map.fits");
    let mut writer = Writer::create(Path::new(&map)).expect("the file can be made");
    let row = |y: usize, out: &mut [f32]| {
        out.iter_mut().zip(&run.labels[y * scene.width..]).for_each(|(out, &label)| *out = label as f32);
    };
    writer.image((scene.width, scene.height), &[], row).expect("the map can be written");
    writer.finish().expect("the file can be closed");
    let ours = skyfront(["score", &truth, &map, "--image", &light]).stdout;
    let theirs = Command::new("python3")
        .args([&place("score.py"), &truth, &map, "--image", &light])
        .output()
        .expect("python3 runs");
    let [ours, theirs]: [Value; 2] = [ours, theirs.stdout].map(|text| serde_json::from_slice(&text).expect("JSON"));
    let measures = ours.as_object().expect("a table");
    assert!(measures.len() > 10);
    for (name, value) in measures {
        let (value, other) = (value.as_f64().expect("a number"), theirs[name].as_f64().expect("the same measure"));
        assert!((value - other).abs() <= 1e-6, "{name}: {value} here, {other} there");
    }
}

/// A little below what was measured, so that a change that loses quality is seen; and fixed point beside it.
#[test]
fn the_default_keeps_its_scores_on_the_simulated_skies() {
    for (kind, least) in [("f160", 0.897), ("deep", 0.917), ("crowded", 0.952), ("startracker", 0.990), ("lsb", 0.932)]
    {
        let mut sums = [0.0; 2];
        for seed in 0..3 {
            let name = format!("{kind}_dev{seed}");
            let Some(scene) = load(&name) else { return };
            let path = folder().expect("it was there").join(format!("{name}_truth.fits.gz"));
            let truth = image(&path, Some(&HduChoice::Number(0))).unwrap_or_else(|error| panic!("{error}"));
            let truth: Vec<i64> = truth.pixels.iter().map(|&label| label as i64).collect();
            let runs = [
                segment::<F32, f32>(&Config::NOISE_AWARE, &scene.pixels, scene.width, &mut Drive::default()),
                segment::<F32, Fixed14>(&Config::NOISE_AWARE, &scene.pixels, scene.width, &mut Drive::default()),
            ]
            .map(|run| run.expect("a scene"));
            for (sum, run) in sums.iter_mut().zip(&runs) {
                let labels: Vec<i64> = run.labels.iter().map(|&label| i64::from(label)).collect();
                *sum += score(&truth, &labels, &scene.pixels).combined / 3.0;
            }
            let [sources, pixels] = apart(&runs);
            println!("{name}: q24 differs in {sources} sources and {pixels} pixels of the mask");
            assert!(sources <= 1 && pixels <= scene.pixels.len() / 5000, "{name}: {sources} sources, {pixels} pixels");
        }
        let [single, fixed] = sums;
        println!("{kind}: {single:.4}, in q24 {fixed:.4}");
        assert!(single > least, "{kind}: {single:.4}, {least} is asked for");
        assert!((single - fixed).abs() < 0.002, "{kind}: {single:.4}, in q24 {fixed:.4}");
    }
}
