//! Another program over the same image, where it is installed.

use crate::read::{Image, image};
use crate::write::fits::Writer;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io, process};

/// The names under which it is installed.
const NAMES: [&str; 3] = ["source-extractor", "sextractor", "sex"];
/// Its default filter.
const FILTER: &str = "CONV NORM\n1 2 1\n2 4 2\n1 2 1\n";

/// The labels that source-extractor gives an image at the default settings that it prints; none where it is not
/// installed.
///
/// # Errors
/// Files that cannot be written or read, and runs that fail.
pub fn source_extractor(pixels: &Image) -> io::Result<Option<Vec<u32>>> {
    let printed = NAMES.into_iter().find_map(|name| Some((name, Command::new(name).arg("-dd").output().ok()?)));
    let Some((name, defaults)) = printed else { return Ok(None) };
    let folder = Scratch::new()?;
    fs::write(folder.file("default.sex"), defaults.stdout)?;
    fs::write(folder.file("none.param"), "NUMBER\n")?;
    fs::write(folder.file("default.conv"), FILTER)?;
    write(&folder.file("image.fits"), pixels).map_err(io::Error::other)?;
    let options = [
        ("-c", "default.sex"),
        ("-PARAMETERS_NAME", "none.param"),
        ("-FILTER_NAME", "default.conv"),
        ("-CHECKIMAGE_TYPE", "SEGMENTATION"),
        ("-CHECKIMAGE_NAME", "labels.fits"),
        ("-VERBOSE_TYPE", "QUIET"),
    ];
    let options = options.iter().flat_map(|(option, value)| [*option, *value]);
    let run = Command::new(name).arg("image.fits").args(options).current_dir(&folder.0).output()?;
    if !run.status.success() {
        return Err(io::Error::other(format!("{name}: {}", String::from_utf8_lossy(&run.stderr))));
    }
    let labels = image(&folder.file("labels.fits"), None).map_err(io::Error::other)?;
    Ok(Some(labels.pixels.iter().map(|&label| label as u32).collect()))
}

fn write(file: &Path, pixels: &Image) -> Result<(), crate::write::WriteError> {
    let width = pixels.width;
    let mut writer = Writer::create(file)?;
    writer.image((width, pixels.height), &[], |y, row: &mut [f32]| {
        row.copy_from_slice(&pixels.pixels[y * width..(y + 1) * width]);
    })?;
    writer.finish()
}

/// A folder that goes with its owner.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> io::Result<Scratch> {
        let folder = env::temp_dir().join(format!("skyfront-peer-{}", process::id()));
        fs::create_dir_all(&folder)?;
        Ok(Scratch(folder))
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
