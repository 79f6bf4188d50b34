//! The rooms of core and host: none of the core's uses one that lies above it, and no two files need each other.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// From the ground up.
const ROOMS: [&str; 13] = [
    "error",
    "arithmetic",
    "config",
    "plane",
    "sky",
    "image",
    "front",
    "sources",
    "track",
    "packet",
    "run",
    "simulate",
    "hal",
];

/// The sources of a crate, `core` or `host`.
fn sources(krate: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(krate).join("src")
}

/// Every Rust file below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the crates lie beside the tests").map(|entry| entry.expect("an entry"));
    let paths = entries.map(|entry| entry.path());
    let all = paths.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] });
    all.filter(|path| path.extension().is_some_and(|extension| extension == "rs")).collect()
}

/// The paths from the crate on that a file's code uses, without comments and tests, as their parts.
fn used(file: &Path, own: &[String]) -> Vec<Vec<String>> {
    let text = fs::read_to_string(file).expect("a file of a crate");
    let code = text.split("#[cfg(test)]\n").next().unwrap_or_default();
    let code: String = code.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned() + "\n").collect();
    let above = &own[..own.len().saturating_sub(1)];
    let from_crate = code.split("crate::").skip(1).flat_map(|rest| paths(&[], rest));
    let from_above = code.split("super::").skip(1).flat_map(|rest| paths(above, rest));
    from_crate.chain(from_above).collect()
}

/// The paths that `rest` begins with, below `place`: one, or each of the first names in braces.
fn paths(place: &[String], rest: &str) -> Vec<Vec<String>> {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == ':';
    let path = |text: &str| {
        let text = text.trim().split(|c| !word(c)).next().unwrap_or_default();
        let parts = text.split("::").filter(|part| !part.is_empty() && *part != "self").map(str::to_owned);
        place.iter().cloned().chain(parts).collect()
    };
    match rest.strip_prefix('{') {
        Some(braced) => braced.split('}').next().unwrap_or_default().split(',').map(path).collect(),
        None => vec![path(rest)],
    }
}

/// A file's module, from the crate on.
fn module(krate: &str, file: &Path) -> Vec<String> {
    let place = file.strip_prefix(sources(krate)).expect("a file of the crate").with_extension("");
    let parts = place.iter().map(|part| part.to_string_lossy().into_owned());
    parts.filter(|part| part != "mod" && part != "lib").collect()
}

#[test]
fn no_room_of_the_core_uses_one_above_it() {
    let floor = |room: &str| ROOMS.iter().position(|other| *other == room);
    for file in files(&sources("core")) {
        let module = module("core", &file);
        let Some(own) = module.first() else { continue };
        let own_floor = floor(own).unwrap_or_else(|| panic!("{own} has no floor"));
        for path in used(&file, &module) {
            let Some(room) = path.first() else { continue };
            let other = floor(room).unwrap_or_else(|| panic!("{}: {room} has no floor", file.display()));
            assert!(other <= own_floor, "{} uses {}, which lies above it", file.display(), path.join("::"));
        }
    }
}

/// The files of a crate that stand in a circle, or need one that does; and how many times one needs another.
fn circle(krate: &str) -> (Vec<String>, usize) {
    let modules: BTreeMap<Vec<String>, PathBuf> =
        files(&sources(krate)).into_iter().map(|file| (module(krate, &file), file)).collect();
    let of =
        |path: &[String]| (1..=path.len()).rev().map(|n| path[..n].to_vec()).find(|path| modules.contains_key(path));
    let needs: BTreeMap<&Vec<String>, BTreeSet<Vec<String>>> = modules
        .iter()
        .map(|(own, file)| {
            (own, used(file, own).iter().filter_map(|path| of(path)).filter(|other| other != own).collect())
        })
        .collect();
    // Whoever needs only what is known already is known; what is never known stands in a circle.
    let mut known: BTreeSet<&Vec<String>> = BTreeSet::new();
    loop {
        let before = known.len();
        let more = needs.iter().filter(|(_, needs)| needs.iter().all(|other| known.contains(other)));
        known.extend(more.map(|(own, _)| *own).collect::<Vec<_>>());
        if known.len() == before {
            break;
        }
    }
    let circle = needs.keys().filter(|own| !known.contains(*own)).map(|own| own.join("::")).collect();
    (circle, needs.values().map(BTreeSet::len).sum())
}

#[test]
fn no_two_files_need_each_other() {
    for krate in ["core", "host"] {
        let (circle, uses) = circle(krate);
        assert!(circle.is_empty(), "{krate}: these, or what they need, stand in a circle: {circle:?}");
        assert!(uses > 150, "{krate}: the files were read");
    }
}
