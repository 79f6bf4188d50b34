//! Simulated skies with known truth, kept beside the repository; tests that need them say so when they are absent.

use std::path::PathBuf;

/// An image as f64, row-major, row 0 first.
pub struct Scene {
    /// Grey levels.
    pub pixels: Vec<f64>,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// `../shared/scenes`, or `None` with a note on stderr.
pub fn folder() -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    if path.is_dir() {
        return Some(path);
    }
    eprintln!("SKIPPED: ../shared/scenes is absent");
    None
}

/// The scene of that name, a primary image of 32-bit floats.
pub fn load(name: &str) -> Option<Scene> {
    let path = folder()?.join(name).with_extension("fits");
    let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let cards: Vec<&str> =
        bytes.chunks(80).map_while(|c| std::str::from_utf8(c).ok()).take_while(|c| c.trim() != "END").collect();
    let number = |key: &str| -> i64 {
        let card = cards.iter().find(|c| c.starts_with(key));
        let value = card.and_then(|c| c[10..].split('/').next());
        value.and_then(|v| v.trim().parse().ok()).expect(key)
    };
    assert_eq!(number("BITPIX  "), -32, "{name}");
    let (width, height) = (number("NAXIS1  ") as usize, number("NAXIS2  ") as usize);
    let start = (cards.len() + 1).div_ceil(36) * 2880;
    let data = &bytes[start..start + 4 * width * height];
    let values = data.chunks(4).map(|b| [b[0], b[1], b[2], b[3]]);
    Some(Scene { pixels: values.map(|b| f32::from_be_bytes(b).into()).collect(), width, height })
}
