//! The tests that core/doc/evidence.md names exist.

use skyfront_tests::command::workspace;
use std::fs;

#[test]
fn every_requirement_names_tests_that_exist() {
    let page = fs::read_to_string(workspace().join("core/doc/evidence.md")).expect("a page");
    let requirements = page.split("\n## ").next().expect("a first part");
    let rows: Vec<&str> =
        requirements.lines().filter(|line| line.starts_with("| ") && !line.contains("requirement")).collect();
    assert!(rows.len() > 10, "{} requirements", rows.len());
    for row in rows {
        let proof = row.split('|').nth(2).expect("a second cell");
        let names: Vec<&str> = proof.split('`').skip(1).step_by(2).collect();
        assert!(!names.is_empty(), "nothing proves: {row}");
        for (file, test) in names.iter().filter_map(|name| name.split_once("::")) {
            let path = if file.contains('/') { file.to_owned() } else { format!("tests/tests/all/{file}.rs") };
            let text = fs::read_to_string(workspace().join(&path)).unwrap_or_else(|error| panic!("{path}: {error}"));
            let test = format!("#[test]\n{}fn {test}()", if path.contains("/src/") { "    " } else { "" });
            assert!(text.contains(&test), "{path} has no {test}");
        }
        for part in names.iter().filter(|name| !name.contains("::")) {
            let parts = fs::read_to_string(workspace().join("tests/on_target/src/main.rs")).expect("the parts");
            assert!(parts.contains(&format!("wanted(\"{part}\")")), "tests/on_target has no part {part}");
        }
    }
}
