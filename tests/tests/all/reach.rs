//! A front that did not arrive says so, and what it did not reach is no source.

use skyfront::pipeline::{Drive, Segmentation, segment};
use skyfront::write::fits::Writer;
use skyfront_core::arithmetic::{F32, Q24};
use skyfront_core::config::{Config, MAX_STEPS, Scheme, Start};
use skyfront_core::run::outcome::StopReason;
use skyfront_core::simulate::Kind;
use skyfront_tests::command::{Folder, messages, skyfront};
use skyfront_tests::runs::sky;
use std::path::Path;

const WIDTH: usize = 90;
const HEIGHT: usize = 70;
const FROM_THE_FRAME: [Scheme; 6] =
    [Scheme::Fd, Scheme::Sl, Scheme::FdCurvature, Scheme::SlCurvature, Scheme::FdFiltered, Scheme::FastMarching];

fn run(config: &Config) -> Segmentation {
    segment(config, &sky(Kind::Bright, 2, WIDTH, HEIGHT), WIDTH, HEIGHT, &mut Drive::default()).expect("a sky")
}

/// Twelve pixels of free motion, and 33 from the border to the middle: the rest is one component, 60 pixels wide.
#[test]
fn what_no_front_can_have_reached_is_no_source() {
    for scheme in FROM_THE_FRAME {
        let config = Config { t_max: 1.2, ..Config::PAPER_F160.with_scheme(scheme) };
        let short = run(&config);
        assert_eq!(short.labels[HEIGHT / 2 * WIDTH + WIDTH / 2], 0, "{scheme:?}");
        // The front came by a star or two.
        assert!(short.sources.iter().all(|source| source.area < 100), "{scheme:?}");
        let short = short.outcome;
        assert_eq!(short.reason, StopReason::TimeLimit, "{scheme:?}");
        // 16 pixels from the border: 12 of the way, 1.5 to the start of the front, 2 for its width.
        assert_eq!(short.unreached, ((WIDTH - 32) * (HEIGHT - 32)) as u32, "{scheme:?}");
        assert!(short.mask_pixels > short.unreached, "{scheme:?}: the component is larger: {short:?}");
        let long = run(&config.with_time_for(WIDTH, HEIGHT)).outcome;
        assert!(long.sources > 0 && long.unreached == 0, "{scheme:?}: {long:?}");
        assert_eq!(long.reason, StopReason::Rest, "{scheme:?}");
    }
}

/// A source that the front went around is kept where another part of the frame was not reached.
#[test]
fn what_the_front_went_around_stays_a_source() {
    let mut pixels = vec![0.0f32; WIDTH * HEIGHT];
    // Flat, but for a block near the border.
    for y in 6..10 {
        pixels[y * WIDTH + 6..y * WIDTH + 10].fill(1.0);
    }
    let config = Config { t_max: 2.0, ..Config::PAPER_F160 };
    let outcome = segment(&config, &pixels, WIDTH, HEIGHT, &mut Drive::default()).expect("an image").outcome;
    assert!(outcome.unreached > 0 && outcome.sources == 1, "{outcome:?}");
}

#[test]
fn time_follows_from_the_frame() {
    let paper = Config::PAPER_F160;
    assert_eq!([(300, 300), (40, 30), (900, 300)].map(|(w, h)| paper.with_time_for(w, h).t_max), [50.0; 3]);
    assert!((paper.with_time_for(2048, 2048).t_max - 2048.0 / 6.0).abs() < 1e-3);
    assert!((paper.with_time_for(600, 2048).t_max - 100.0).abs() < 1e-4);
    // Where the front starts near the objects it has no frame to cross.
    for near in [Start::Threshold { margin: 4.0 }, Start::Given] {
        assert_eq!(Config { start: near, ..paper }.with_time_for(2048, 2048).t_max, 50.0);
    }
    for scheme in FROM_THE_FRAME {
        // Beyond some 6000 pixels the steps of a run are too many for the paper's nu in one of the schemes.
        let side = if scheme == Scheme::SlCurvature { 6000 } else { 1 << 20 };
        let huge = paper.with_scheme(scheme).with_time_for(side, side);
        assert_eq!((huge.validate::<F32>(), huge.validate::<Q24>()), (Ok(()), Ok(())), "{scheme:?}");
        assert!(huge.max_steps() <= MAX_STEPS);
    }
}

#[test]
fn the_command_line_warns_and_gives_time() {
    let folder = Folder::new("reach");
    let path = folder.file("flat.fits");
    let (width, height) = (40, 900);
    let pixel =
        |x: usize, y: usize| if (18..22).contains(&x) && (440..450).contains(&y) { 9.0 } else { (x % 2) as f32 };
    let mut writer = Writer::create(Path::new(&path)).expect("the file can be made");
    writer
        .image((width, height), &[], |y, out| out.iter_mut().enumerate().for_each(|(x, out)| *out = pixel(x, y)))
        .expect("the image can be written");
    writer.finish().expect("the file can be closed");
    let segment = |name: &str, options: &[&str]| {
        let paper = ["segment", &path, "--preset", "paper-f160", "--no-pictures", "--out", &folder.file(name)];
        let run = skyfront(paper.iter().chain(options));
        assert_eq!(run.status.code(), Some(0), "{}", messages(&run));
        messages(&run)
    };
    let short = segment("short", &["--t-max", "0.5"]);
    assert!(short.contains("no front can have reached by t_max: they are no source; raise --t-max"), "{short}");
    assert!(short.contains("0 sources") && short.contains("was given up at t = 0.5"), "{short}");
    let long = segment("long", &[]);
    assert!(!long.contains("no front can have reached") && long.contains("1 sources"), "{long}");
    let summary =
        |name: &str| std::fs::read_to_string(folder.file(&format!("{name}/summary.json"))).expect("a summary");
    assert!(summary("long").contains("\"pixels_not_reached\": 0"));
    assert!(!summary("short").contains("\"pixels_not_reached\": 0"));
}
