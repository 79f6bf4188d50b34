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
    let image = sky(&folder, 40);
    let again = skyfront(["segment", &image, "--preset", "paper-f160", "--quiet", "--out", &folder.file("out")]);
    assert!(again.status.success(), "{}", messages(&again));
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
