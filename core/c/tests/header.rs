//! The header is what the sources say. Rewrite it with `SKYFRONT_HEADER=write cargo test -p skyfront-c --test header`.

use std::path::Path;

#[test]
fn the_header_is_made_from_the_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut made = Vec::new();
    cbindgen::generate(folder).expect("sources and configuration of the header").write(&mut made);
    let made = String::from_utf8(made).expect("a text");
    let header = folder.join("include/skyfront.h");
    if std::env::var_os("SKYFRONT_HEADER").is_some() {
        std::fs::write(&header, &made).expect("a header that can be written");
    }
    let kept = std::fs::read_to_string(&header).expect("core/c/include/skyfront.h");
    let line = made.lines().zip(kept.lines()).position(|(made, kept)| made != kept);
    assert!(made == kept, "include/skyfront.h is out of date from line {line:?} on");
}
