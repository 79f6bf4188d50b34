//! Full disks, unwritable folders, interrupts and kills: never a half-written product under its final name.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use skyfront_tests::command::{Folder, messages, program, skyfront};
use skyfront_tests::fits_bytes::{Header, samples};

/// A sky of `size` x `size` pixels in a file.
fn sky(folder: &Folder, size: usize) -> String {
    let pixel = |n: usize| ((n % size) % 97 + (n / size) % 89 + n % 7) as f64;
    let values: Vec<f64> = (0..size * size).map(pixel).collect();
    let path = folder.file("sky.fits");
    fs::write(&path, Header::primary(16, &[size as u64; 2]).with(samples(16, &values))).unwrap();
    path
}

/// Starts a run that has little to compute and much to write, and waits until it writes.
fn caught_writing(folder: &Folder) -> Child {
    let image = sky(folder, 1500);
    let arguments = ["segment", &image, "--preset", "paper-f160", "--t-max", "0.05", "--quiet"];
    let mut run = Command::new(program());
    run.args(arguments).args(["--out", &folder.file("out")]).stderr(Stdio::piped());
    let mut run = run.spawn().unwrap();
    let start = Instant::now();
    // The probe for writability is such a file as well, but it is gone at once: two looks.
    let writing = || folder.names("out").iter().any(|name| name.ends_with(".part"));
    while !(writing() && writing()) {
        assert!(run.try_wait().unwrap().is_none(), "the run ended before it was caught writing");
        assert!(start.elapsed() < Duration::from_secs(120), "the run does not come to writing");
        std::thread::sleep(Duration::from_millis(1));
    }
    run
}

fn signal(run: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &run.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

#[test]
fn an_interrupt_leaves_nothing_and_says_130() {
    let folder = Folder::new("interrupt");
    for name in ["-INT", "-TERM"] {
        let mut run = caught_writing(&folder);
        signal(&run, name);
        assert_eq!(run.wait().unwrap().code(), Some(130), "{name}");
        assert_eq!(folder.names("out"), [""; 0], "{name}");
    }
}

#[test]
fn a_killed_run_leaves_no_product_and_is_no_obstacle() {
    let folder = Folder::new("kill");
    let mut run = caught_writing(&folder);
    signal(&run, "-KILL");
    assert_eq!(run.wait().unwrap().code(), None);
    let left = folder.names("out");
    assert!(left.iter().all(|name| name.starts_with(".skyfront-") && name.ends_with(".part")), "{left:?}");
    assert!(!left.is_empty(), "it was killed while it wrote");
    let image = sky(&folder, 40);
    let again = skyfront(["segment", &image, "--preset", "paper-f160", "--quiet", "--out", &folder.file("out")]);
    assert!(again.status.success(), "{}", messages(&again));
    assert!(folder.names("out").iter().all(|name| !name.starts_with('.')), "{:?}", folder.names("out"));
}

#[test]
fn a_second_writer_is_told_before_it_computes() {
    let folder = Folder::new("second");
    let mut first = caught_writing(&folder);
    let image = folder.file("sky.fits");
    let line = ["segment", &image, "--preset", "paper-f160", "--overwrite", "--out", &folder.file("out")];
    let second = skyfront(line);
    assert_eq!(second.status.code(), Some(1), "{}", messages(&second));
    assert!(messages(&second).contains("another run is writing into this folder"), "{}", messages(&second));
    assert!(first.wait().unwrap().success(), "the first goes on");
    assert_eq!(folder.names("out").len(), 9);
}

#[test]
fn equal_process_ids_are_no_obstacle() {
    let folder = Folder::new("equal");
    let image = sky(&folder, 60);
    let alone = ["--map-root-user", "--pid", "--fork", "--kill-child"];
    let allowed = Command::new("unshare").args(alone).arg("true").output();
    if !allowed.is_ok_and(|output| output.status.success()) {
        println!("SKIPPED: this system does not let a user number processes anew");
        return;
    }
    let run = |out: &str| {
        let line = ["segment", &image, "--preset", "paper-f160", "--t-max", "0.1", "--quiet", "--overwrite", "--out"];
        let mut command = Command::new("unshare");
        command.args(alone).arg(program()).args(line).arg(folder.file(out)).stderr(Stdio::piped()).spawn().unwrap()
    };
    for trial in 0..4 {
        // Two folders at a time, and one folder twice: all of them are process 1.
        let runs = [run("one"), run("two")];
        for run in runs {
            let output = run.wait_with_output().unwrap();
            assert!(output.status.success(), "{trial}: {}", messages(&output));
        }
    }
}

/// The sides of the images in the FITS products of a folder.
fn sides(folder: &Folder) -> Vec<String> {
    let names = ["segmentation.fits", "segmented.fits", "front.fits"];
    let side = |name: &str| {
        let bytes = fs::read(folder.path().join("out").join(name)).unwrap();
        let at = bytes.windows(8).position(|window| window == b"NAXIS1  ").unwrap();
        String::from_utf8_lossy(&bytes[at + 10..at + 30]).trim().to_owned()
    };
    names.map(side).to_vec()
}

#[test]
fn an_interrupt_leaves_the_old_products_or_the_new() {
    let folder = Folder::new("mixture");
    let out = folder.file("out");
    let line = |image: &str| {
        let words = ["segment", image, "--preset", "paper-f160", "--t-max", "0.025", "--no-pictures", "--quiet"];
        words.map(str::to_owned).into_iter().chain(["--overwrite".into(), "--out".into(), out.clone()])
    };
    let images = [150, 160].map(|side| {
        let path = folder.file(&format!("{side}.fits"));
        fs::rename(sky(&folder, side), &path).unwrap();
        path
    });
    let start = Instant::now();
    assert!(skyfront(line(&images[0])).status.success());
    let whole = start.elapsed();
    let mut seen = [0, 0];
    for trial in 0..40 {
        let mut run = Command::new(program()).args(line(&images[trial % 2])).spawn().unwrap();
        // Most signals come while products are written and renamed, at the end.
        std::thread::sleep(whole * (60 + trial as u32) / 100);
        signal(&run, "-TERM");
        let code = run.wait().unwrap().code();
        let sides = sides(&folder);
        assert!(sides.iter().all(|side| *side == sides[0]), "trial {trial}: {sides:?}");
        assert_eq!(folder.names("out").len(), 6, "trial {trial}: {:?}", folder.names("out"));
        seen[usize::from(code == Some(0))] += 1;
    }
    println!("interrupted and completed: {seen:?}");
}

#[test]
fn a_full_disk_is_one_clear_line() {
    // A file system of its own, a few pages large, that exists for this run only.
    let folder = Folder::new("full");
    let image = sky(&folder, 300);
    fs::create_dir(folder.path().join("small")).unwrap();
    let small = folder.file("small");
    let script = format!(
        "mount -t tmpfs -o size=600k none '{small}' || exit 77; \
         '{}' segment '{image}' --preset paper-f160 --quiet --out '{small}/out'; \
         code=$?; ls -A '{small}/out'; exit $code",
        program().display()
    );
    let run = Command::new("unshare").args(["--map-root-user", "--mount", "sh", "-c", &script]).output();
    let Ok(run) =
        run.and_then(|run| if unsupported(&run) { Err(std::io::ErrorKind::Unsupported.into()) } else { Ok(run) })
    else {
        println!("SKIPPED: this system does not let a user mount a small file system");
        return;
    };
    let line = messages(&run);
    assert_eq!(run.status.code(), Some(1), "{line}");
    assert_eq!(line.lines().count(), 1, "{line}");
    assert!(line.contains("small/out/") && line.contains("No space left") && line.contains("make room"), "{line}");
    assert!(!line.contains(".part"), "the temporary name is no concern of the user: {line}");
    assert!(run.stdout.is_empty(), "left behind: {}", String::from_utf8_lossy(&run.stdout));
}

fn unsupported(run: &std::process::Output) -> bool {
    run.status.code() == Some(77) || messages(run).starts_with("unshare:")
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = Folder::new("unwritable");
    let image = sky(&folder, 40);
    fs::write(folder.path().join("file"), "").unwrap();
    for out in ["/proc/skyfront".to_owned(), folder.file("file"), folder.file("file/below")] {
        let run = skyfront(["segment", &image, "--out", &out]);
        let line = messages(&run);
        assert_eq!(run.status.code(), Some(1), "{line}");
        assert_eq!(line.lines().count(), 1, "{line}");
        assert!(line.contains(&out) && line.contains("cannot be written"), "{line}");
    }
}
