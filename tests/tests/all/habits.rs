//! What people expect of a command: configuration files, presets, many inputs, manual, completions.

use skyfront::write::fits::Writer;
use skyfront_core::config::PARAMETERS;
use skyfront_core::run::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};
use skyfront_tests::command::{Folder, messages, program, skyfront};
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const SIDE: usize = 64;

/// Writes a simulated sky.
fn sky(path: &str, seed: u32) {
    sky_of(path, seed, SIDE);
}

fn sky_of(path: &str, seed: u32, side: usize) {
    let mut sky = Sky::new(Kind::Bright, seed, side, side);
    let mut writer = Writer::create(Path::new(path)).expect("the file can be made");
    let row = |y, out: &mut [f32]| {
        let Ok(()) = sky.row(y, out);
    };
    writer.image((side, side), &[], row).expect("the image can be written");
    writer.finish().expect("the file can be closed");
}

/// Rings around the middle, each of which has an ellipse as wide as the image.
fn rings_of(path: &str, side: usize) {
    let middle = side as f32 / 2.0;
    let mut writer = Writer::create(Path::new(path)).expect("the file can be made");
    let row = |y: usize, out: &mut [f32]| {
        for (x, pixel) in out.iter_mut().enumerate() {
            let noise = (((y * side + x) as u32).wrapping_mul(2_654_435_761) >> 20) % 41;
            let far = (x as f32 - middle).hypot(y as f32 - middle);
            *pixel = noise as f32 + if far % 16.0 < 3.0 { 500.0 } else { 0.0 };
        }
    };
    writer.image((side, side), &[], row).expect("the image can be written");
    writer.finish().expect("the file can be closed");
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{}", messages(output));
    String::from_utf8(output.stdout.clone()).expect("stdout is text")
}

fn dumped(options: &[&str]) -> String {
    stdout(&skyfront(["segment", "--dump-config"].iter().chain(options)))
}

#[test]
fn dumped_settings_give_the_same_settings_again() {
    let folder = Folder::new("dump");
    let file = folder.file("settings.toml");
    let cases: [&[&str]; 8] = [
        &[],
        &["--preset", "paper-f160"],
        &["--preset", "paper-real", "--pm-mu", "2", "--hdu", "SCI,2", "--no-pictures"],
        &["--scheme", "sl", "--sky", "mesh:40", "--filter", "none", "--separate", "components", "--select", "area"],
        &["--preset", "paper-f160", "--tau", "0.25", "--normalize", "percentile", "--range", "1,99.5"],
        &["--preset", "paper-f160", "--scheme", "sl-curvature", "--nu", "1e-5", "--start", "map.fits", "--margin", "7"],
        &["--threshold", "1.5", "--connectivity", "4", "--deblend-contrast", "0.01", "--min-area", "9"],
        &["--preset", "paper-f160", "--rescale", "r2", "--alpha", "0.3", "--edge", "g1", "--p", "10", "--jobs", "3"],
    ];
    for options in cases {
        let first = dumped(options);
        fs::write(&file, &first).expect("the file can be written");
        assert_eq!(dumped(&["--config", &file]), first, "{options:?}");
        for pair in options.windows(2).filter(|pair| pair[0].starts_with("--") && !pair[1].starts_with("--")) {
            let key = pair[0].trim_start_matches("--");
            let line = first.lines().find(|line| line.starts_with(&format!("{key} = ")));
            let line = line.unwrap_or_else(|| panic!("{key} is missing in:\n{first}"));
            let number = |text: &str| text.parse::<f64>().ok();
            let value = line.split(" = ").nth(1).expect("a value").trim_matches('"');
            assert!(value == pair[1] || number(value).is_some() && number(value) == number(pair[1]), "{line}");
        }
    }
}

#[test]
fn a_time_that_is_not_given_follows_from_the_frame() {
    let has_time = |options: &[&str]| dumped(options).lines().any(|line| line.starts_with("t-max = "));
    assert!(!has_time(&["--preset", "paper-f160"]), "fed back, it would be the user's own");
    assert!(has_time(&["--preset", "paper-f160", "--t-max", "50"]));
    let budget = ["budget", "--preset", "paper-f160", "--width", "600", "--height", "600"];
    assert!(stdout(&skyfront(budget)).contains("evolve, at most 4000 passes"));
    assert!(stdout(&skyfront(budget.iter().chain(&["--t-max", "50"]))).contains("evolve, at most 2000 passes"));
}

#[test]
fn the_command_line_goes_before_the_file_and_the_file_before_the_preset() {
    let folder = Folder::new("order");
    let file = folder.file("settings.toml");
    fs::write(&file, "preset = 'paper-real'\nc2 = 0.5\nfilter_steps = 7\n").expect("the file can be written");
    let text = dumped(&["--config", &file, "--filter-steps", "9"]);
    for line in ["preset = \"paper-real\"", "c2 = 0.5", "filter-steps = 9", "alpha = 0.25"] {
        assert!(text.lines().any(|other| other == line), "'{line}' is not in:\n{text}");
    }
}

#[test]
fn a_bad_configuration_names_file_and_key() {
    let folder = Folder::new("bad-config");
    let file = folder.file("settings.toml");
    let cases = [
        ("alfa = 0.3", "unknown key 'alfa'"),
        ("out = 'x'", "unknown key 'out'"),
        ("alpha = 'much'", "--alpha"),
        ("scheme = 'upwind'", "fd-curvature"),
        ("start = 'frame'\nalpha = [1, 2]", "--alpha"),
        ("overwrite = 1", "key 'overwrite'"),
        ("[front]\ndx = 1", "unknown key 'front'"),
        ("alpha = ", "line 1"),
    ];
    for (text, word) in cases {
        fs::write(&file, text).expect("the file can be written");
        let output = skyfront(["segment", "x.fits", "--out", "x", "--config", &file]);
        let message = messages(&output);
        assert_eq!(output.status.code(), Some(2), "{text}: {message}");
        assert!(message.contains("settings.toml") && message.contains(word), "{text}: {message}");
        assert_eq!(message.lines().count(), 1, "{text}: {message}");
    }
    let absent = skyfront(["segment", "--dump-config", "--config", &folder.file("absent.toml")]);
    assert_eq!(absent.status.code(), Some(2));
    assert!(messages(&absent).contains("absent.toml"));
}

/// How many images the run over many has; a twentieth of them are broken.
fn many() -> usize {
    std::env::var("SKYFRONT_MANY").map_or(60, |number| number.parse().expect("SKYFRONT_MANY is a number"))
}

/// Runs `skyfront` and watches its greatest resident memory, kB.
fn watched(arguments: &[&str]) -> (Output, u64) {
    watched_command(Command::new(program()).args(arguments))
}

/// The same for a command that becomes `skyfront`.
pub fn watched_command(command: &mut Command) -> (Output, u64) {
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let child = child.expect("the program can be started");
    let status = format!("/proc/{}/status", child.id());
    let watch = std::thread::spawn(move || {
        let mut most = 0;
        while let Ok(text) = fs::read_to_string(&status) {
            let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let Some(line) = line else { break };
            let kilobytes = line.trim().trim_end_matches(" kB").parse().expect("a number of kB");
            most = std::cmp::max(most, kilobytes);
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        most
    });
    let output = child.wait_with_output().expect("the program ends");
    (output, watch.join().expect("the watch ends"))
}

#[test]
fn broken_images_stop_no_others_and_memory_stays_flat() {
    let folder = Folder::new("many");
    let images: Vec<String> = (0..many()).map(|n| folder.file(&format!("image{n:04}.fits"))).collect();
    let broken = |n: usize| n % 20 == 7;
    for (n, image) in images.iter().enumerate() {
        if broken(n) {
            fs::write(image, "SIMPLE  =                    T, but no more").expect("the file can be written");
        } else {
            sky(image, n as u32);
        }
    }
    let vast: Vec<String> = (0..3).map(|n| folder.file(&format!("vast{n}.fits"))).collect();
    vast.iter().for_each(|image| sky_of(image, 1, 1200));
    let bad = (0..images.len()).filter(|&n| broken(n)).count();
    let line = |out: &str, count: usize| {
        let options = ["segment", "--preset", "paper-f160", "--quiet", "--no-pictures", "--jobs", "2"];
        let words =
            options.into_iter().chain(["--max-memory", "55M", "--out"]).map(str::to_owned).chain([folder.file(out)]);
        words.chain(images[..count].iter().cloned()).collect::<Vec<_>>()
    };
    let run = |line: &[String]| watched(&line.iter().map(String::as_str).collect::<Vec<_>>());
    let (_, memory_of_few) = run(&line("few", 20));
    let (output, memory_of_many) = run(&[line("all", images.len()), vast.clone()].concat());

    assert_eq!(output.status.code(), Some(1), "{}", messages(&output));
    let text = messages(&output);
    assert_eq!(text.lines().count(), bad + vast.len(), "one line for each image without a result: {text}");
    for image in (0..images.len()).filter(|&n| broken(n)).map(|n| &images[n]).chain(&vast) {
        assert!(text.lines().any(|line| line.contains(image)), "{image} is not named in: {text}");
    }
    assert_eq!(text.matches("but --max-memory allows 55 MB").count(), vast.len(), "{text}");
    let table = fs::read_to_string(folder.file("all/summary.csv")).expect("the table was written");
    assert_eq!(table.lines().count(), images.len() + vast.len() + 1);
    for n in 0..images.len() {
        let name = format!("image{n:04}");
        let row = table.lines().find(|row| row.contains(&format!(",{name},"))).expect("a row for every image");
        let results = folder.names(&format!("all/{name}")).len();
        assert_eq!((results, row.ends_with(',')), if broken(n) { (0, false) } else { (6, true) }, "{row}");
    }
    println!("{} images, {bad} broken: {memory_of_few} kB for 20, {memory_of_many} kB for all", images.len());
    assert!(memory_of_few > 0 && memory_of_many < memory_of_few + 6_000, "{memory_of_few} and {memory_of_many} kB");
}

#[test]
fn memory_stays_within_what_the_budget_said_before() {
    let folder = Folder::new("budget");
    let [sky, rings] = ["sky.fits", "rings.fits"].map(|name| folder.file(name));
    sky_of(&sky, 5, 700);
    rings_of(&rings, 700);
    // The program, its libraries and buffers: those of the front's run are not within its planes.
    for (image, preset, total, beside) in [
        (&sky, "noise-aware", "all memory", 14_000_000),
        (&rings, "noise-aware", "all memory", 14_000_000),
        (&sky, "paper-f160", "here, with the image", 21_000_000),
    ] {
        let told = stdout(&skyfront(["budget", "--width", "700", "--height", "700", "--preset", preset]));
        let line = told.lines().find(|line| line.contains(total)).expect("a total");
        let bytes: u64 = line.split_whitespace().next().and_then(|word| word.parse().ok()).expect("a number");
        let out = folder.file(preset);
        let settings = ["--no-pictures", "--quiet", "--threads", "1", "--preset", preset, "--overwrite", "--out", &out];
        let (output, kilobytes) = watched(&[["segment", image].as_slice(), &settings].concat());
        assert!(output.status.success(), "{}", messages(&output));
        println!("{image}, {preset}: {kilobytes} kB, said {bytes} bytes");
        assert!(kilobytes * 1000 < bytes + beside, "{image}, {preset}: {kilobytes} kB, said {bytes} bytes");
    }
}

#[test]
fn images_of_one_name_get_their_own_folders_and_the_bytes_of_a_single_run() {
    let folder = Folder::new("names");
    for (below, seed) in [("a", 1), ("b", 2)] {
        fs::create_dir_all(folder.path().join(below)).expect("the folder can be made");
        sky(&folder.file(&format!("{below}/sky.fits")), seed);
    }
    let (one, two) = (folder.file("a/sky.fits"), folder.file("b/sky.fits"));
    let both = skyfront(["segment", &one, &two, "--jobs", "2", "--out", &folder.file("both"), "--json"]);
    let lines = stdout(&both);
    assert_eq!(folder.names("both"), ["sky", "sky-2", "summary.csv"]);
    assert!(messages(&both).contains("2 images segmented, 0 failed"), "{}", messages(&both));
    let alone = stdout(&skyfront(["segment", &two, "--out", &folder.file("alone"), "--quiet", "--json"]));
    let alone: serde_json::Value = serde_json::from_str(&alone).expect("--json prints JSON");
    let second: serde_json::Value = serde_json::from_str(lines.lines().nth(1).expect("two lines")).expect("JSON");
    assert_eq!(second["labels_crc32"], alone["labels_crc32"]);
    let bytes = |file: &str| fs::read(folder.file(file)).expect("the product was written");
    assert!(bytes("both/sky-2/segmentation.fits") == bytes("alone/segmentation.fits"), "the same map either way");
}

#[test]
fn help_manual_and_completions_come_from_the_options() {
    for words in [["--help"].as_slice(), &["segment", "--help"]] {
        let help = stdout(&skyfront(words));
        assert!(help.contains("Exit codes: 0 done; 1 bad input"), "{help}");
    }
    assert!(stdout(&skyfront(["man"])).contains("skyfront\\-segment"));
    assert!(stdout(&skyfront(["man", "segment"])).contains("curvature\\-form"));
    assert_eq!(skyfront(["man", "nothing"]).status.code(), Some(1));
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        assert!(stdout(&skyfront(["completions", shell])).contains("curvature-form"), "{shell}");
    }
    let short = stdout(&skyfront(["segment", "-h"]));
    assert!(short.lines().count() <= 50, "the short help fits a screen:\n{short}");
    let (long, listed) = (stdout(&skyfront(["segment", "--help"])), stdout(&skyfront(["parameters"])));
    for parameter in PARAMETERS {
        let option = format!("--{} ", parameter.name);
        assert!(long.contains(&option) && listed.contains(&option), "{option}");
        assert_eq!(short.contains(&option), parameter.common, "{option}");
        assert!(listed.contains(parameter.help) && long.contains(parameter.step.title()), "{option}");
    }
    let presets = stdout(&skyfront(["presets"]));
    for words in ["paper-f160", "paper-real", "c2                  0.78", "deblend-contrast    0.0005"] {
        assert!(presets.contains(words), "'{words}' is not in:\n{presets}");
    }
}

#[test]
fn verbose_tells_sky_noise_threshold_flags_and_stages_and_excludes_quiet() {
    let folder = Folder::new("verbose");
    let image = folder.file("sky.fits");
    sky_of(&image, 3, 128);
    let output = skyfront(["segment", &image, "--out", &folder.file("out"), "--verbose", "--preset", "paper-f160"]);
    let said = messages(&output);
    assert!(said.contains("  evolve") && said.contains("  tau ") && !said.contains("  noise "), "{said}");
    let wanted = ["segment", &image, "--out", &folder.file("default"), "-v", "--threshold", "2", "--json"];
    let output = skyfront(wanted);
    let (said, summary) = (messages(&output), stdout(&output));
    assert_eq!(summary.lines().count(), 1, "one line of JSON: {summary}");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    let told = |name: &str| {
        let line =
            said.lines().find_map(|line| line.trim().strip_prefix(name)).unwrap_or_else(|| panic!("{name}: {said}"));
        line.trim().to_owned()
    };
    let number = |text: &str| text.trim_end_matches(',').parse::<f64>().expect("a number");
    let noise = number(told("noise").split(',').next().expect("a number"));
    let close = |one: f64, other: f64| (one - other).abs() < 1e-5 * other.abs();
    assert!(close(noise, summary["noise"].as_f64().expect("a number")), "{noise}: {summary}");
    assert!((noise - 8e-4).abs() < 1e-4, "the noise that the sky was made with: {noise}");
    assert!(close(
        number(told("sky").split(',').next().expect("a number")),
        summary["background"].as_f64().expect("a number")
    ));
    assert!(told("threshold").starts_with("2 times the noise, "), "{said}");
    assert!(close(number(told("threshold").split(' ').nth(4).expect("a number")), 2.0 * noise), "{said}");
    for (flag, count) in summary["flags"].as_object().expect("counts") {
        assert!(told("flags").contains(&format!("{count} {flag}")), "{flag}: {said}");
    }
    let table = fs::read_to_string(folder.file("default/catalog.csv")).expect("a catalogue");
    let flags =
        table.lines().skip(1).map(|line| line.rsplit(',').next().expect("flags").parse::<u32>().expect("a number"));
    let truncated = flags.filter(|flags| flags & 1 != 0).count();
    assert!(truncated > 0 && summary["flags"]["truncated"] == truncated, "{summary}");
    assert_eq!(skyfront(["segment", &image, "--out", "x", "-v", "-q"]).status.code(), Some(2));
}

#[test]
fn manual_pages_of_all_commands_are_written_with_their_examples() {
    let folder = Folder::new("man");
    let pages = folder.file("man1");
    for _ in 0..2 {
        let output = skyfront(["man", "--out", &pages]);
        assert!(output.status.success() && output.stdout.is_empty(), "{}", messages(&output));
    }
    let names = folder.names("man1");
    assert_eq!(names.len(), 14, "{names:?}");
    for (page, words) in
        [("skyfront.1", "a first look"), ("skyfront-segment.1", "NUMBER,X_IMAGE"), ("skyfront-man.1", "man1")]
    {
        let text = fs::read_to_string(folder.path().join("man1").join(page)).expect("a page");
        assert!(text.contains(words), "{page}: {words}");
    }
}

#[test]
fn the_overlay_has_the_scale_that_is_wanted() {
    let folder = Folder::new("overlay");
    let image = folder.file("sky.fits");
    sky(&image, 3);
    for (scale, side) in [(None, 8 * SIDE), (Some("3"), 3 * SIDE), (Some("1/4"), SIDE / 4)] {
        let line = ["segment", &image, "--quiet", "--overwrite", "--out", &folder.file("out")];
        let more = scale.map(|scale| ["--overlay-scale", scale]).into_iter().flatten();
        let output = skyfront(line.into_iter().chain(more));
        assert!(output.status.success(), "{}", messages(&output));
        let file = fs::File::open(folder.file("out/overlay.png")).expect("a picture");
        let picture = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG");
        assert_eq!(picture.info().size(), (side as u32, side as u32), "{scale:?}");
    }
    for odd in ["0", "2/3", "1/100"] {
        assert_eq!(skyfront(["segment", &image, "--out", "x", "--overlay-scale", odd]).status.code(), Some(2), "{odd}");
    }
}

#[test]
fn an_image_is_not_scored_as_a_map() {
    let folder = Folder::new("no-map");
    let made = skyfront(["simulate", "--side", "40", "--out", &folder.file("sky")]);
    assert!(made.status.success(), "{}", messages(&made));
    let [sky, truth] = ["sky", "truth"].map(|name| folder.file(&format!("sky/{name}.fits")));
    let score = |truth: &str, map: &str| skyfront(["score", truth, map, "--image", &sky]);
    for refused in [score(&truth, &sky), score(&sky, &truth)] {
        assert_eq!((refused.status.code(), refused.stdout.len()), (Some(1), 0));
        assert!(messages(&refused).contains("sky.fits is no label map: pixel (1, 1) is "), "{}", messages(&refused));
    }
    let text = stdout(&score(&truth, &truth));
    assert_eq!(text.lines().count(), 1);
    assert_eq!(serde_json::from_str::<serde_json::Value>(&text).expect("JSON")["f_score"], 1.0);
}

/// Every condition changes the sky, and those that move light change who owns it.
#[test]
fn skies_are_made_as_telescopes_and_cameras_show_them() {
    let folder = Folder::new("conditions");
    let made = |name: &str, options: &[&str]| {
        let out = folder.file(name);
        let output = skyfront(["simulate", "--side", "60", "--out", &out].iter().chain(options));
        assert!(output.status.success(), "{}", messages(&output));
        ["sky.fits", "truth.fits"].map(|file| fs::read(folder.path().join(name).join(file)).expect("a plane"))
    };
    let [sky, truth] = made("perfect", &[]);
    let options: [(&[&str], bool); 7] = [
        (&["--optics", "coma"], true),
        (&["--optics", "trail"], true),
        (&["--optics", "ring"], true),
        (&["--lopsided"], true),
        (&["--gradient", "-5"], false),
        (&["--full-well", "40"], true),
        (&["--step", "0.5"], false),
    ];
    for (option, moves) in options {
        let [shown, owned] = made(&option.join(""), option);
        assert!(shown != sky && (owned != truth) == moves, "{option:?}");
    }
    let refused = skyfront(["simulate", "--out", &folder.file("refused"), "--step", "0"]);
    assert!(refused.status.code() == Some(2) && messages(&refused).contains("--step"));
}
