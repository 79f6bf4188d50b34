//! Writes the specimens into a folder, as seeds for the fuzzer.

use std::fs;
use std::path::PathBuf;

use skyfront_tests::{compressed, specimens};

fn main() -> std::io::Result<()> {
    let folder: PathBuf = std::env::args_os().nth(1).unwrap_or_else(|| "corpus".into()).into();
    fs::create_dir_all(&folder)?;
    for specimen in specimens::all() {
        fs::write(folder.join(specimen.name), &specimen.bytes)?;
    }
    for kind in compressed::KINDS {
        let path = folder.join(format!("{}.fits", kind.name));
        let _ = fs::remove_file(&path);
        compressed::write(&path, &kind, &specimens::scene()).map_err(std::io::Error::other)?;
    }
    Ok(())
}
