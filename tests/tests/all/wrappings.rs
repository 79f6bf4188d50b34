//! One image in many wrappings, segmented: the catalogue and the map do not know how it was stored.

use skyfront_tests::command::{Folder, messages, skyfront};
use skyfront_tests::compressed;
use skyfront_tests::fits_bytes::{Header, gzip, samples};
use std::fs;

const WIDTH: usize = 72;
const HEIGHT: usize = 48;

/// Two stars on a noisy sky, whole numbers that 16 bits hold, also times 4.
fn scene() -> Vec<f64> {
    let pixel = |n: usize| {
        let (x, y) = ((n % WIDTH) as f64, (n / WIDTH) as f64);
        let star = |cx: f64, cy: f64, light: f64| light * (-((x - cx).powi(2) + (y - cy).powi(2)) / 6.0).exp();
        let noise = ((n as u32).wrapping_mul(2_654_435_761) >> 20) % 41;
        (100.0 + f64::from(noise) + star(20.0, 15.0, 900.0) + star(50.3, 30.8, 4000.0)).floor()
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// Writes the scene in every way that keeps all of it; the names of the files, the plain one first.
fn written(folder: &Folder) -> Vec<String> {
    let (scene, axes) = (scene(), [WIDTH as u64, HEIGHT as u64]);
    let plain = Header::primary(16, &axes).with(samples(16, &scene));
    let stored = |scale: f64, zero: f64| samples(16, &scene.iter().map(|v| (v - zero) / scale).collect::<Vec<_>>());
    let scaled = Header::primary(16, &axes).card("BSCALE", 0.25).card("BZERO", 300.0).with(stored(0.25, 300.0));
    let unsigned = Header::primary(16, &axes).card("BSCALE", 1).card("BZERO", 32768).with(stored(1.0, 32768.0));
    let extension = Header::image(-32, &axes).with(samples(-32, &scene));
    let files = [
        ("plain.fits", plain.clone()),
        ("long.fits", Header::primary(64, &axes).with(samples(64, &scene))),
        ("double.fits", Header::primary(-64, &axes).with(samples(-64, &scene))),
        ("gzipped.fits.gz", gzip(&plain)),
        ("scaled.fits", scaled),
        ("unsigned.fits", unsigned),
        ("extension.fits", [Header::primary(8, &[]).bytes(), extension].concat()),
        ("cube.fits", Header::primary(32, &[WIDTH as u64, HEIGHT as u64, 1]).with(samples(32, &scene))),
    ];
    let mut names: Vec<String> = files.iter().map(|(name, _)| folder.file(name)).collect();
    for ((_, bytes), path) in files.iter().zip(&names) {
        fs::write(path, bytes).expect("a file can be written");
    }
    for kind in compressed::KINDS.iter().filter(|kind| kind.lossless) {
        let path = folder.file(&format!("tiles-{}.fits", kind.name));
        compressed::write_sized(path.as_ref(), kind, &scene, [HEIGHT, WIDTH])
            .unwrap_or_else(|error| panic!("{}: {error}", kind.name));
        names.push(path);
    }
    names
}

#[test]
fn results_do_not_depend_on_the_wrapping() {
    let folder = Folder::new("wrappings");
    let files = written(&folder);
    for (run, options) in [("default", [].as_slice()), ("paper", &["--preset", "paper-f160"])] {
        let out = folder.file(run);
        let line = ["segment", "--json", "--no-pictures", "--quiet", "--out", &out];
        let output =
            skyfront(line.iter().copied().chain(options.iter().copied()).chain(files.iter().map(String::as_str)));
        assert!(output.status.success(), "{}", messages(&output));
        let text = String::from_utf8(output.stdout).expect("text");
        let digests: Vec<String> = text
            .lines()
            .map(|line| serde_json::from_str::<serde_json::Value>(line).expect("JSON")["labels_crc32"].to_string())
            .collect();
        assert_eq!(digests.len(), files.len());
        let folders: Vec<String> = folder.names(run).into_iter().filter(|name| name != "summary.csv").collect();
        let catalogue = |name: &str| fs::read_to_string(folder.file(&format!("{run}/{name}/catalog.csv"))).expect(name);
        let plain = catalogue("plain");
        assert!(plain.lines().count() > 1, "{run}: nothing was found");
        for (digest, file) in digests.iter().zip(&files) {
            assert_eq!(digest, &digests[0], "{run}: {file}");
        }
        assert_eq!(folders.len(), files.len());
        for name in &folders {
            assert_eq!(catalogue(name), plain, "{run}: {name}");
        }
    }
}
