//! The rooms of the core: none uses one that lies above it, and no two files need each other.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// From the ground up.
const ROOMS: [&str; 12] =
    ["error", "arithmetic", "config", "plane", "sky", "image", "front", "sources", "track", "run", "simulate", "hal"];

fn core() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src")
}

/// Every file below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries =
        fs::read_dir(folder).expect("the core lies beside the tests").map(|entry| entry.expect("an entry").path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// The paths from `crate::` on in a file's code, without comments and tests, as their parts.
fn used(file: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(file).expect("a file of the core");
    let code = text.split("#[cfg(test)]\nmod").next().unwrap_or_default();
    let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default());
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == ':';
    let paths = lines.flat_map(|line| line.split("crate::").skip(1).map(move |rest| rest.split(|c| !word(c)).next()));
    paths.flatten().map(|path| path.split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect()).collect()
}

/// A file's module, from the crate on.
fn module(file: &Path) -> Vec<String> {
    let place = file.strip_prefix(core()).expect("a file of the core").with_extension("");
    let parts = place.iter().map(|part| part.to_string_lossy().into_owned());
    parts.filter(|part| part != "mod" && part != "lib").collect()
}

#[test]
fn no_room_uses_one_above_it() {
    let floor = |room: &str| ROOMS.iter().position(|other| *other == room);
    for file in files(&core()) {
        let Some(own) = module(&file).first().cloned() else { continue };
        let own_floor = floor(&own).unwrap_or_else(|| panic!("{own} has no floor"));
        for path in used(&file) {
            let other = floor(&path[0]).unwrap_or_else(|| panic!("{}: {} has no floor", file.display(), path[0]));
            assert!(other <= own_floor, "{} uses {}, which lies above it", file.display(), path.join("::"));
        }
    }
}

#[test]
fn no_two_files_need_each_other() {
    let modules: BTreeMap<Vec<String>, PathBuf> =
        files(&core()).into_iter().map(|file| (module(&file), file)).collect();
    let of =
        |path: &[String]| (1..=path.len()).rev().map(|n| path[..n].to_vec()).find(|path| modules.contains_key(path));
    let needs: BTreeMap<&Vec<String>, BTreeSet<Vec<String>>> = modules
        .iter()
        .map(|(own, file)| (own, used(file).iter().filter_map(|path| of(path)).filter(|other| other != own).collect()))
        .collect();
    // Whoever needs only what is known already is known; what is never known stands in a circle.
    let mut known: BTreeSet<&Vec<String>> = BTreeSet::new();
    loop {
        let before = known.len();
        known.extend(
            needs
                .iter()
                .filter(|(_, needs)| needs.iter().all(|other| known.contains(other)))
                .map(|(own, _)| *own)
                .collect::<Vec<_>>(),
        );
        if known.len() == before {
            break;
        }
    }
    let circle: Vec<String> = needs.keys().filter(|own| !known.contains(*own)).map(|own| own.join("::")).collect();
    assert!(circle.is_empty(), "these, or what they need, stand in a circle: {circle:?}");
    assert!(needs.values().map(BTreeSet::len).sum::<usize>() > 150, "the files were read");
}
