//! Memory, threads and outputs that cannot be had, and names that mean something elsewhere: each image has its result
//! or its line, and the others go on.

use skyfront_tests::command::{Folder, messages, program, skyfront};
use skyfront_tests::fits_bytes::{Header, samples, tiled};
use std::fs;
use std::io::{Read, pipe};
use std::process::{Command, Output, Stdio};

/// A sky of `side` x `side` pixels with a few sources.
fn sky(path: &str, side: usize) {
    let pixel = |n: usize| {
        let (x, y) = ((n % side % 40) as f64 - 20.0, (n / side % 40) as f64 - 20.0);
        let noise = ((n as u32).wrapping_mul(2_654_435_761) >> 20) % 41;
        f64::from(noise) + (2000.0 * (-(x * x + y * y) / 6.0).exp()).floor()
    };
    let pixels: Vec<f64> = (0..side * side).map(pixel).collect();
    fs::write(path, Header::primary(16, &[side as u64; 2]).with(samples(16, &pixels))).expect("a sky can be written");
}

/// A mask of 10 000 x 10 000 zeros in one tile: 100 million pixels in 50 kB.
fn vast(path: &str) {
    let words = [0i16, 7, -100, 7, 0, 0, 0];
    let mut tile: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
    tile.resize(50_000, 0);
    let bytes = tiled(16, (10_000, 10_000), "PLIO_1", "COMPRESSED_DATA", &[tile], |header| {
        header.without("TFORM1").text("TFORM1", "1PI").card("ZTILE1", 10_000).card("ZTILE2", 10_000)
    });
    // The descriptor counts 16-bit words.
    let at = bytes.windows(8).position(|w| w == [50_000i32.to_be_bytes(), [0; 4]].concat()).expect("a descriptor");
    let mut bytes = bytes;
    bytes[at..at + 4].copy_from_slice(&25_000i32.to_be_bytes());
    fs::write(path, bytes).expect("a mask can be written");
}

/// Runs `skyfront` after some words to the shell, such as limits; ends it after two minutes of the processor.
fn under(words: &str, arguments: &[&str]) -> Output {
    let script = format!("ulimit -t 120; {words}; exec \"$0\" \"$@\"");
    Command::new("sh").args(["-c", &script]).arg(program()).args(arguments).output().expect("a shell")
}

/// The rows of a batch's table.
fn table(folder: &Folder, out: &str) -> Vec<String> {
    let text = fs::read_to_string(folder.file(&format!("{out}/summary.csv"))).expect("the table was written");
    text.lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn memory_that_cannot_be_had_refuses_one_image_and_not_its_neighbours() {
    let folder = Folder::new("memory");
    let [a, big, b] = ["a.fits", "big.fits", "b.fits"].map(|name| folder.file(name));
    sky(&a, 80);
    vast(&big);
    sky(&b, 80);
    let out = folder.file("out");
    let line = ["segment", &a, &big, &b, "--out", &out, "--no-pictures", "--quiet", "--overwrite"];
    for (limit, more, word) in [
        ("ulimit -v 2000000", ["--jobs", "1"], "but the system gives "),
        ("ulimit -v 2000000", ["--jobs", "3"], "but the system gives "),
        ("true", ["--max-memory", "900M"], "--max-memory allows 900 MB"),
    ] {
        let run = under(limit, &[&line, more.as_slice()].concat());
        let text = messages(&run);
        assert_eq!(run.status.code(), Some(1), "{limit}: {text}");
        assert_eq!(text.lines().count(), 1, "{limit}: {text}");
        assert!(text.contains("big.fits") && text.contains("10000 x 10000 pixels need 4"), "{limit}: {text}");
        assert!(text.contains(word), "{limit}: {text}");
        let failed: Vec<bool> = table(&folder, "out").iter().map(|row| !row.ends_with(',')).collect();
        assert_eq!(failed, [false, true, false], "{limit}");
    }
}

#[test]
fn no_limit_of_memory_ends_a_run_by_a_signal() {
    let folder = Folder::new("sweep");
    let image = folder.file("sky.fits");
    sky(&image, 700);
    let mut ends = [0, 0];
    for kilobytes in (40_000..=240_000).step_by(20_000) {
        for options in [&["--threads", "2"][..], &["--threads", "32", "--preset", "paper-f160", "--t-max", "0.4"]] {
            let line = ["segment", &image, "--quiet", "--overwrite", "--out", &folder.file("out")];
            let run = under(&format!("ulimit -v {kilobytes}"), &[&line, options].concat());
            let text = messages(&run);
            let code = run.status.code().unwrap_or_else(|| panic!("{kilobytes} kB, {options:?}: {text}"));
            assert_eq!(text.lines().count(), code as usize, "{kilobytes} kB, {options:?}: {text}");
            ends[code as usize] += 1;
        }
    }
    assert!(ends[0] > 2 && ends[1] > 2, "done and refused: {ends:?}");
}

#[test]
fn a_run_takes_no_more_than_it_asked_for() {
    let folder = Folder::new("asked");
    let image = folder.file("sky.fits");
    sky(&image, 900);
    let maps = ["--background", &image, "--weight", "6", "--weight-type", "rms"];
    for options in [
        &[][..],
        &["--no-pictures"],
        &["--arithmetic", "q24", "--sky-maps"],
        &maps,
        &["--preset", "paper-f160"],
        &["--preset", "paper-f160", "--no-pictures", "--threads", "4"],
        &["--preset", "chan-vese", "--regions", "--polygons"],
    ] {
        let out = folder.file("out");
        let line = ["segment", &image, "--quiet", "--overwrite", "--out", &out];
        let refused = skyfront(line.iter().chain(options).chain(&["--max-memory", "1M"]));
        let text = messages(&refused);
        let asked = text.split_once(" need ").and_then(|(_, rest)| rest.split_once(" MB"));
        let asked: u64 = asked.and_then(|(number, _)| number.parse().ok()).unwrap_or_else(|| panic!("{text}"));
        let command = &mut Command::new(program());
        let (run, kilobytes) = crate::habits::watched_command(command.args(line).args(options));
        assert!(run.status.success(), "{options:?}: {}", messages(&run));
        println!("{options:?}: {kilobytes} kB, asked for {asked} MB");
        assert!(kilobytes < 1000 * asked, "{options:?}: {kilobytes} kB, asked for {asked} MB");
    }
}

/// Commands that read whole images beside `segment`.
fn whole<'a>(image: &'a str, out: &'a str) -> [Vec<&'a str>; 3] {
    [
        vec!["crosscheck", image, "--preset", "paper-f160", "--t-max", "0.1"],
        vec!["score", image, image, "--image", image],
        vec!["reproduce", image, "--overwrite", "--out", out],
    ]
}

#[test]
fn every_command_asks_for_memory_before_it_reads_pixels() {
    let folder = Folder::new("every");
    let [small, big, out] = ["small.fits", "big.fits", "out"].map(|name| folder.file(name));
    sky(&small, 150);
    vast(&big);
    for (small, big) in whole(&small, &out).iter().zip(whole(&big, &out)) {
        let refused = under("ulimit -v 2000000", &big);
        let text = messages(&refused);
        assert_eq!((refused.status.code(), text.lines().count()), (Some(1), 1), "{big:?}: {text}");
        assert!(text.contains("big.fits") && text.contains("but the system gives "), "{big:?}: {text}");
        let asked = text.split_once(" need ").and_then(|(_, rest)| rest.split_once(" MB"));
        let asked: u64 = asked.and_then(|(number, _)| number.parse().ok()).unwrap_or_else(|| panic!("{text}"));
        let per_pixel = (asked - 24) / 100;
        let (run, kilobytes) = crate::habits::watched_command(Command::new(program()).args(small));
        assert!(run.status.success(), "{small:?}: {}", messages(&run));
        println!("{}: {per_pixel} bytes per pixel, {kilobytes} kB", small[0]);
        assert!(1000 * kilobytes < 24_000_000 + per_pixel * 150 * 150, "{small:?}: {kilobytes} kB");
    }
}

#[test]
fn more_pixels_than_can_be_labelled_are_told_by_the_header() {
    let folder = Folder::new("labels");
    let path = folder.file("vast.fits");
    let header = Header::primary(16, &[40_000, 40_000]).bytes();
    fs::write(&path, &header).expect("a header can be written");
    let file = fs::File::options().write(true).open(&path).expect("it is there");
    file.set_len(header.len() as u64 + 2 * 40_000 * 40_000).expect("a file with a hole");
    let (run, kilobytes) =
        crate::habits::watched_command(Command::new(program()).args(["segment", &path, "--out", &folder.file("out")]));
    let text = messages(&run);
    assert_eq!(run.status.code(), Some(1), "{text}");
    assert!(text.contains("40000 x 40000 pixels are more than 1073741824"), "{text}");
    assert!(kilobytes < 30_000, "{kilobytes} kB");
}

#[test]
fn a_map_of_another_size_is_refused_before_it_is_read() {
    let folder = Folder::new("map");
    let [image, mask] = ["sky.fits", "mask.fits"].map(|name| folder.file(name));
    sky(&image, 80);
    vast(&mask);
    let line = ["segment", &image, "--mask", &mask, "--out", &folder.file("out")];
    let (run, kilobytes) = crate::habits::watched_command(Command::new(program()).args(line));
    assert!(messages(&run).contains("has 10000 x 10000 pixels, the image 80 x 80"), "{}", messages(&run));
    assert!(kilobytes < 30_000, "{kilobytes} kB");
}

#[test]
fn threads_that_cannot_be_had_are_done_without() {
    let folder = Folder::new("threads");
    let image = folder.file("sky.fits");
    sky(&image, 512);
    let paper = ["--preset", "paper-f160", "--t-max", "2"];
    let digest = |run: &Output| {
        assert!(run.status.success(), "{}", messages(run));
        let summary: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
        summary["labels_crc32"].clone()
    };
    let line = |out: &str, threads: &str| {
        let out = folder.file(out);
        let words = ["segment", &image, "--no-pictures", "--json", "--quiet", "--threads", threads, "--out", &out];
        words.iter().chain(&paper).map(|&word| word.to_owned()).collect::<Vec<_>>()
    };
    let run = |words: &str, line: &[String]| under(words, &line.iter().map(String::as_str).collect::<Vec<_>>());
    let alone = digest(&run("true", &line("alone", "1")));
    // 32 stacks of two megabytes are not within it.
    assert_eq!(digest(&run("ulimit -v 100000", &line("few", "32"))), alone);
}

/// A pipe that nobody reads.
fn unread() -> Stdio {
    let (reader, writer) = pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

fn full() -> Stdio {
    fs::File::options().write(true).open("/dev/full").expect("/dev/full").into()
}

#[test]
fn results_that_cannot_be_printed_are_an_exit_code() {
    let lines: [&[&str]; 9] = [
        &["presets"],
        &["columns"],
        &["--help"],
        &["man"],
        &["completions", "bash"],
        &["budget", "--width", "300", "--height", "300"],
        &["budget", "--width", "300", "--height", "300", "--preset", "paper-f160"],
        &["segment", "--dump-config"],
        &["--version"],
    ];
    for line in lines {
        let run = |stdout: Stdio| {
            let child = Command::new(program()).args(line).stdout(stdout).stderr(Stdio::piped()).spawn();
            child.and_then(std::process::Child::wait_with_output).expect("the program runs")
        };
        let (full, unread) = (run(full()), run(unread()));
        for output in [&full, &unread] {
            assert_eq!(output.status.code(), Some(1), "{line:?}: {}", messages(output));
            assert!(!messages(output).contains("panicked"), "{line:?}: {}", messages(output));
        }
        assert!(messages(&full).lines().count() <= 1, "{line:?}: {}", messages(&full));
        assert_eq!(messages(&unread), "", "{line:?}: who has gone wants no message");
    }
}

#[test]
fn a_batch_goes_on_when_nobody_listens() {
    let folder = Folder::new("deaf");
    let images = ["a", "broken", "b"].map(|name| folder.file(&format!("{name}.fits")));
    sky(&images[0], 64);
    fs::write(&images[1], "SIMPLE  =                    T, but no more").expect("it can be written");
    sky(&images[2], 64);
    for (number, output) in [full, unread, full, unread].into_iter().enumerate() {
        let out = format!("out{number}");
        let mut command = Command::new(program());
        command.args(["segment", "--no-pictures", "--json", "--out", &folder.file(&out)]).args(&images);
        let (stdout, stderr) = if number < 2 { (Stdio::null(), output()) } else { (output(), Stdio::null()) };
        let status = command.stdout(stdout).stderr(stderr).status().expect("the program runs");
        assert_eq!(status.code(), Some(1));
        let failed: Vec<bool> = table(&folder, &out).iter().map(|row| !row.ends_with(',')).collect();
        assert_eq!(failed, [false, true, false], "{out}");
    }
}

#[test]
fn names_are_names_and_nothing_else() {
    let folder = Folder::new("odd-names");
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).expect("a folder");
    for name in ["...fits", "=1+1.fits"] {
        sky(&inner.join(name).display().to_string(), 48);
    }
    let deep: String = (0..7).map(|_| format!("{}/", "d".repeat(200))).collect();
    for out in [" lead", "trail ", "a[1]", deep.trim_end_matches('/')] {
        let mut command = Command::new(program());
        command.current_dir(&inner).args(["segment", "...fits", "=1+1.fits", "--no-pictures", "--quiet", "--out", out]);
        let run = command.output().expect("the program runs");
        assert!(run.status.success(), "'{out}': {}", messages(&run));
        let names = folder.names(&format!("inner/{out}"));
        assert_eq!(names, ["...fits", "=1+1", "summary.csv"], "'{out}'");
        assert_eq!(folder.names(&format!("inner/{out}/...fits")).len(), 6, "'{out}'");
        let rows = table(&folder, &format!("inner/{out}"));
        assert!(rows[0].starts_with("...fits,...fits,") && rows[1].starts_with("./=1+1.fits,./=1+1,"), "{rows:?}");
    }
    let mut left = folder.names("inner");
    left.retain(|name| !name.starts_with('d'));
    assert_eq!(left, [" lead", "...fits", "=1+1.fits", "a[1]", "trail "], "nothing is written elsewhere");
}

#[test]
fn frames_beyond_all_bounds_have_no_budget() {
    for side in ["4000000000", "18446744073709551615", "32769"] {
        for preset in ["noise-aware", "paper-f160"] {
            let run = skyfront(["budget", "--width", side, "--height", side, "--preset", preset]);
            assert_eq!(run.status.code(), Some(2), "{side}: {}", messages(&run));
            assert!(messages(&run).contains("at most 2^30 pixels"), "{side}: {}", messages(&run));
        }
    }
    let sources =
        ["budget", "--width", "9", "--height", "9", "--preset", "paper-f160", "--sources", "99999999999999999"];
    assert_eq!(skyfront(sources).status.code(), Some(2));
}

#[test]
fn a_frame_too_wide_is_refused_with_the_bound_that_it_exceeds() {
    let folder = Folder::new("wide");
    let path = folder.file("wide.fits");
    let pixels: Vec<f64> = (0..5 * 1_048_577).map(|n| f64::from(n % 7)).collect();
    fs::write(&path, Header::primary(8, &[1_048_577, 5]).with(samples(8, &pixels))).expect("it can be written");
    let run = skyfront(["segment", &path, "--preset", "paper-f160", "--no-pictures", "--out", &folder.file("out")]);
    assert!(messages(&run).contains("at most 1048576 columns"), "{}", messages(&run));
}

#[test]
fn the_room_of_a_full_catalogue_is_told() {
    let folder = Folder::new("room");
    let (path, side) = (folder.file("dots.fits"), 820);
    let dot = |n: usize| f64::from(u8::from((n % side).is_multiple_of(2) && (n / side).is_multiple_of(2)));
    let pixels: Vec<f64> = (0..side * side).map(dot).collect();
    fs::write(&path, Header::primary(8, &[side as u64; 2]).with(samples(8, &pixels))).expect("it can be written");
    let out = folder.file("out");
    let steps = ["--rescale", "none", "--filter", "none", "--start", "threshold", "--margin", "1", "--t-max", "0.05"];
    let line =
        ["segment", &path, "--preset", "paper-f160", "--connectivity", "4", "--map-only", "--no-pictures", "--json"];
    let run = skyfront(line.iter().chain(&steps).chain(&["--out", &out]));
    assert!(run.status.success(), "{}", messages(&run));
    let summary: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert_eq!(summary["catalog_room"], 100_000);
    let lost = summary["sources_not_in_catalog"].as_u64().expect("a number");
    assert_eq!(summary["n_sources"], 100_000 + lost);
    assert!(lost > 0, "{summary:#}");
    assert!(summary["result_warnings"].to_string().contains("room for 100000 sources only"), "{summary:#}");
    let mut told = String::new();
    (&run.stderr[..]).read_to_string(&mut told).expect("text");
    assert!(told.contains("room for 100000 sources only"), "{told}");
}
