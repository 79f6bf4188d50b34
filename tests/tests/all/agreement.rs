//! The core against the f64 reference: f32 takes the same steps to the same masks, with |du| within the promised 5e-4;
//! of 90 000 mask pixels q24 differs in at most 3 and q11, for all its band, in at most 180.
//!
//! The nine small scenes of high and low signal to noise and of crowded fields, as the paper would segment them.

use skyfront::crosscheck::{Check, Tolerances, table};
use skyfront_core::config::Scheme;
use skyfront_tests::agreement::Agreement;
use skyfront_tests::captions::{RESCALINGS, paper};
use skyfront_tests::scenes;

fn assert_agrees(kind: &str, scheme: Scheme) {
    for seed in 0..3 {
        let name = format!("{kind}_dev{seed}");
        let Some(scene) = scenes::load(&name) else { return };
        for (rescaling, rescale) in RESCALINGS {
            let caption = format!("{name} {rescaling} {scheme:?}");
            let core = Agreement::of(&paper(rescale, scheme), &scene).core;
            let [f32, q24, q11] = core.map(|comparison| comparison.expect("all arithmetics serve first order"));
            println!("{caption}: {}, {} and {} pixels", f32.mask_pixels, q24.mask_pixels, q11.mask_pixels);
            assert!(q24.mask_pixels <= 3 && q11.mask_pixels <= 180, "{caption}: {q24:?} {q11:?}");
            let tolerances = Tolerances::of("f32", scene.pixels.len());
            let check = [Check { arithmetic: "f32", comparison: f32, tolerances }];
            assert!(check[0].failures().is_empty(), "{}", table(&caption, &check));
        }
    }
}

#[test]
fn bright_scenes_by_finite_differences() {
    assert_agrees("f160", Scheme::Fd);
}

#[test]
fn bright_scenes_semi_lagrangian() {
    assert_agrees("f160", Scheme::Sl);
}

#[test]
fn deep_scenes_by_finite_differences() {
    assert_agrees("deep", Scheme::Fd);
}

#[test]
fn deep_scenes_semi_lagrangian() {
    assert_agrees("deep", Scheme::Sl);
}

#[test]
fn crowded_scenes_by_finite_differences() {
    assert_agrees("crowded", Scheme::Fd);
}

#[test]
fn crowded_scenes_semi_lagrangian() {
    assert_agrees("crowded", Scheme::Sl);
}
