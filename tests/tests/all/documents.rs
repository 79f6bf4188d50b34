//! What README and documents say: commands run, options and links exist, what is quoted is what is printed.

use skyfront_core::config::{Config, PARAMETERS, Parameter};
use skyfront_tests::command::{Folder, messages, program, skyfront, workspace};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn readme() -> String {
    fs::read_to_string(workspace().join("README.md")).expect("there is a README")
}

/// README, contributing, changelogs and documents.
fn pages() -> Vec<PathBuf> {
    let folders = ["", ".github", "core", "core/doc", "host", "host/doc"].map(|folder| workspace().join(folder));
    let entries = folders.into_iter().flat_map(|folder| fs::read_dir(folder).expect("a folder").flatten());
    entries.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|kind| kind == "md")).collect()
}

/// The lines of the fenced blocks of a kind.
fn blocks(text: &str, kind: &str) -> Vec<String> {
    let mut inside = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        match line.strip_prefix("```") {
            Some(fence) => inside = !inside && fence == kind,
            None if inside => lines.push(line.to_owned()),
            None => {}
        }
    }
    lines
}

#[test]
fn the_readme_is_short_and_names_the_rust_that_is_needed() {
    let text = readme();
    assert!(text.lines().count() <= 120, "{} lines", text.lines().count());
    let manifest = fs::read_to_string(workspace().join("Cargo.toml")).expect("a manifest");
    let version = manifest.lines().find_map(|line| line.strip_prefix("rust-version = ")).expect("a version");
    assert!(text.contains(&format!("Rust {} or newer", version.trim_matches('"'))), "Rust {version}");
    for package in ["core", "host", "host/python"] {
        let manifest = fs::read_to_string(workspace().join(package).join("Cargo.toml")).expect("a manifest");
        assert!(manifest.contains("rust-version.workspace = true"), "{package}: told once");
    }
}

#[test]
fn the_readme_quotes_what_the_demo_prints() {
    let folder = Folder::new("readme-demo");
    let said = messages(&skyfront(["demo", "--out", &folder.file("out")]));
    let quoted = blocks(&readme(), "text");
    assert_eq!(quoted.len(), 2);
    for line in quoted {
        assert!(said.lines().any(|other| other == line), "'{line}' is not in:\n{said}");
    }
}

#[test]
fn the_commands_of_the_readme_run() {
    let folder = Folder::new("readme-commands");
    let sky = skyfront(["simulate", "--side", "150", "--out", &folder.file("sky")]);
    assert!(sky.status.success(), "{}", messages(&sky));
    fs::rename(folder.path().join("sky/sky.fits"), folder.path().join("image.fits")).expect("it can be moved");
    // Any map above 0 is a weight map.
    let weight = ["simulate", "--kind", "stars", "--side", "150", "--out", &folder.file("weight")];
    assert!(skyfront(weight).status.success());
    fs::rename(folder.path().join("weight/sky.fits"), folder.path().join("wht.fits")).expect("it can be moved");
    let ours = program().parent().expect("a folder").display().to_string();
    let path = format!("{ours}:{}", std::env::var("PATH").expect("a path"));
    let lines = blocks(&readme(), "sh");
    let commands: Vec<&String> = lines.iter().filter(|line| line.starts_with("skyfront ")).collect();
    assert_eq!(commands.len(), 3);
    for line in commands {
        let run = Command::new("sh").args(["-c", line]).current_dir(folder.path()).env("PATH", &path).output();
        let run = run.expect("a shell");
        assert!(run.status.success(), "{line}: {}", messages(&run));
    }
    let text = readme();
    for file in folder.names("results") {
        assert!(text.contains(&format!("`{file}`")), "{file} is not in the table");
    }
    for line in lines.iter().filter(|line| line.starts_with("tests/run")) {
        assert!(workspace().join(line.split_whitespace().next().expect("a word")).is_file(), "{line}");
    }
}

/// Where the links of a page lead.
fn links(page: &Path) -> Vec<(String, PathBuf)> {
    let text = fs::read_to_string(page).expect("a page").replace('\n', " ");
    let folder = page.parent().expect("a folder").to_owned();
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let local = targets.filter(|target| !target.starts_with("http") && !target.starts_with('#'));
    local.map(|target| (target.to_owned(), folder.join(target.split('#').next().unwrap_or(target)))).collect()
}

#[test]
fn links_lead_somewhere() {
    let pages = pages();
    assert!(pages.len() > 10, "{pages:?}");
    for page in pages {
        for (target, path) in links(&page) {
            assert!(path.exists(), "{}: {target}", page.display());
        }
    }
}

/// The options of all commands.
fn options() -> BTreeSet<String> {
    let commands = ["segment", "crosscheck", "reproduce", "demo", "budget", "simulate", "score", "columns", "man"];
    let helps = commands.map(|name| String::from_utf8(skyfront([name, "--help"]).stdout).expect("text"));
    let words = helps.iter().flat_map(|help| help.split(|c: char| !c.is_ascii_alphanumeric() && c != '-'));
    words.filter(|word| word.starts_with("--")).map(str::to_owned).collect()
}

#[test]
fn options_of_the_documents_exist() {
    let known = options();
    // Of cargo, of the checks' programs, and one that does not exist, quoted as such.
    let others = [
        "--release",
        "--path",
        "--store",
        "--locked",
        "--all",
        "--example",
        "--ignored",
        "--nocapture",
        "--detect-thresh",
    ];
    for page in pages() {
        let text = fs::read_to_string(&page).expect("a page");
        let words = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '-').filter(|word| {
            word.strip_prefix("--").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()))
        });
        for word in words {
            assert!(known.contains(word) || others.contains(&word), "{}: {word}", page.display());
        }
    }
}

#[test]
fn the_table_for_users_of_other_programs_has_our_defaults() {
    let text = fs::read_to_string(workspace().join("host/doc/coming-from.md")).expect("a page");
    let default = |name: &str| {
        let parameter = Parameter::named(name).unwrap_or_else(|| panic!("{name} is a parameter"));
        parameter.get(&Config::NOISE_AWARE).expect("a value").to_string()
    };
    let rows = text.lines().filter(|line| line.starts_with("| `") || line.starts_with("| two"));
    let mut checked = 0;
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let names = cells[4].split('`').skip(1).step_by(2).filter_map(|word| word.strip_prefix("--"));
        let names: Vec<&str> = names.map(|word| word.split(' ').next().unwrap_or(word)).collect();
        let told: Vec<&str> =
            cells[6].split(',').map(|word| word.trim().trim_matches('`')).filter(|word| !word.is_empty()).collect();
        for (name, told) in names.iter().zip(told) {
            assert_eq!(told, default(name), "{name} in: {row}");
            checked += 1;
        }
    }
    assert_eq!(checked, 7, "the table has the defaults that it should");
    assert!(PARAMETERS.len() > 7);
    let refused = skyfront(["segment", "image.fits", "--detect-thresh", "1.5", "--out", "x"]);
    assert!(
        messages(&refused).contains("there is no --detect-thresh; here it is --threshold"),
        "{}",
        messages(&refused)
    );
}
