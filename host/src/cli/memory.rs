//! The memory of runs: known when the header of an image is read, asked for before its pixels are, and shared by the
//! images that are worked on at a time.

use crate::extraction;
use crate::pipeline::{Segmentation, room_for_sources};
use crate::planes::can_be_had;
use crate::read::{HduChoice, Image, Place, ReadError};
use skyfront_core::config::{Config, Scheme};
use skyfront_core::run::memory::bytes;
use std::path::Path;
use std::sync::{Condvar, Mutex, PoisonError};

/// The most pixels of an image: labels and places are told apart by 30 bits.
pub const MOST_PIXELS: u64 = 1 << 30;
/// What a run takes beside its planes: buffers, tables, the stacks of its threads.
pub const BESIDE: u64 = 24_000_000;
pub const MEGA: u64 = 1_000_000;

/// Columns and rows.
pub type Size = (u64, u64);

/// The bytes that an image takes at most from its first pixel to its last product, beside those of its sources, with
/// so many maps of its size, and with `pictures`.
///
/// # Errors
/// One line for an image with too many pixels.
pub fn need(config: &Config, pictures: bool, maps: usize, (width, height): Size) -> Result<u64, String> {
    countable(width, height)?;
    let (w, h) = (width as usize, height as usize);
    let plane = w * h * size_of::<f32>();
    // Planes beside those of the run: the image, and what its sky takes while sources are measured.
    let (mut bytes_of_run, mut others, mut of_pictures) = (0, 0, 4);
    if config.sky.is_known() {
        bytes_of_run += extraction::memory(config, w, h).iter().map(|(bytes, _)| bytes).sum::<usize>();
    }
    if config.needs_segmenter() {
        bytes_of_run += of_segmenter(config, w, h);
        (others, of_pictures) = (4, 5);
    }
    let planes = others + maps + if pictures { of_pictures } else { 0 };
    Ok((bytes_of_run + planes * plane) as u64 + BESIDE)
}

/// The planes of a front of the paper or a filter in steps over a frame of so many columns and rows, and its catalogue.
pub fn of_segmenter(config: &Config, width: usize, height: usize) -> usize {
    let sources = room_for_sources(width * height);
    bytes(width, height, size_of::<f32>(), config.scheme == Scheme::SlCurvature, sources)
}

/// The bytes that the sources of a run take at most while they are measured and written: each a row of the catalogue.
pub fn need_of_sources(run: &Segmentation) -> u64 {
    const ROW: u64 = 2000;
    run.sources.len() as u64 * ROW
}

/// Reads an image, or the part of it that brackets name, for a command that takes at most so many bytes per pixel of it,
/// if they can be had.
///
/// # Errors
/// The file, and one line that names need and limit or what is wrong with it.
pub fn image_within(per_pixel: u64, path: &Path, hdu: Option<&HduChoice>) -> Result<Image, ReadError> {
    Place::new(path).read_hdu_if(hdu, &mut |width, height| {
        let pixels = countable(width, height)?;
        Memory::new(None).take(pixels.saturating_mul(per_pixel) + BESIDE, (width, height)).map(drop)
    })
}

/// The number of pixels, if they can be labelled.
fn countable(width: u64, height: u64) -> Result<u64, String> {
    width.checked_mul(height).filter(|&pixels| pixels <= MOST_PIXELS).ok_or_else(|| {
        format!(
            "{width} x {height} pixels are more than {MOST_PIXELS}, the most that can be labelled; cut the image into \
             pieces, or give --strips"
        )
    })
}

/// A number of bytes that must not be exceeded.
#[derive(Clone, Copy, Debug)]
struct Limit {
    bytes: u64,
    /// Who sets it, as the beginning of a sentence.
    set_by: &'static str,
}

/// The limit of the control group that a container is; the system kills what exceeds it.
fn of_the_container() -> Option<Limit> {
    const FILES: [&str; 2] = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    let text = FILES.iter().find_map(|file| std::fs::read_to_string(file).ok())?;
    // Without a limit it says "max", or nearly 2^63.
    text.trim().parse().ok().map(|bytes| Limit { bytes, set_by: "the container has" })
}

/// What all runs may take together, and what those under way take.
pub struct Memory {
    limit: Option<Limit>,
    taken: Mutex<u64>,
    given_back: Condvar,
}

impl Memory {
    /// At most `wanted` bytes, or what container and system give.
    pub fn new(wanted: Option<u64>) -> Self {
        let wanted = wanted.map(|bytes| Limit { bytes, set_by: "--max-memory allows" });
        Memory { limit: wanted.or_else(of_the_container), taken: Mutex::new(0), given_back: Condvar::new() }
    }

    /// Takes `need` bytes for an image of `size`, as soon as the runs under way leave them.
    ///
    /// # Errors
    /// One line that names need and limit, where they cannot be had even alone.
    pub fn take(&self, need: u64, size: Size) -> Result<Share<'_>, String> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        // What the others have taken may not be in their hands yet.
        while !self.gives(*taken + need) {
            if *taken == 0 {
                return Err(self.refusal(need, size) + "; cut the image into pieces, or give --strips");
            }
            taken = self.given_back.wait(taken).unwrap_or_else(PoisonError::into_inner);
        }
        *taken += need;
        Ok(Share { memory: self, bytes: need })
    }

    /// The most bytes up to `need` that can be had.
    pub fn most(&self, need: u64) -> u64 {
        let wanted = self.limit.map_or(need, |limit| need.min(limit.bytes));
        if can_be_had(wanted) { wanted } else { most_that_can_be_had(wanted) }
    }

    fn gives(&self, bytes: u64) -> bool {
        self.limit.is_none_or(|limit| bytes <= limit.bytes) && can_be_had(bytes)
    }

    /// Why so many bytes cannot be had.
    pub fn refusal(&self, need: u64, (width, height): Size) -> String {
        let limit = match self.limit {
            Some(limit) if limit.bytes < need => format!("{} {} MB", limit.set_by, limit.bytes / MEGA),
            _ => format!("the system gives {} MB", most_that_can_be_had(need) / MEGA),
        };
        let need = need.div_ceil(MEGA);
        format!("{width} x {height} pixels need {need} MB of memory, but {limit}")
    }
}

/// The greatest number of bytes, below `need`, that the system gives.
fn most_that_can_be_had(need: u64) -> u64 {
    let (mut least, mut most) = (0, need);
    while most - least > MEGA {
        let middle = least.midpoint(most);
        if can_be_had(middle) { least = middle } else { most = middle }
    }
    least
}

/// The memory of one run; given back when dropped.
pub struct Share<'m> {
    memory: &'m Memory,
    bytes: u64,
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        *self.memory.taken.lock().unwrap_or_else(PoisonError::into_inner) -= self.bytes;
        self.memory.given_back.notify_all();
    }
}

/// A number of bytes, with k, M or G for 10^3, 10^6 or 10^9.
pub fn amount(text: &str) -> Result<u64, String> {
    let (digits, unit) = match text.trim().split_at_checked(text.trim().len().saturating_sub(1)) {
        Some((digits, "k" | "K")) => (digits, 1000),
        Some((digits, "M")) => (digits, MEGA),
        Some((digits, "G")) => (digits, 1000 * MEGA),
        _ => (text.trim(), 1),
    };
    let bytes = digits.parse::<u64>().ok().and_then(|number| number.checked_mul(unit));
    bytes.ok_or_else(|| "is not a number of bytes such as 800M or 4G".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_have_units() {
        assert_eq!(amount("12"), Ok(12));
        assert_eq!(amount("3k"), Ok(3000));
        assert_eq!(amount(" 4G "), Ok(4_000_000_000));
        for odd in ["", "G", "-1", "1.5G", "4T", "99999999999999G", "星"] {
            assert!(amount(odd).is_err(), "{odd}");
        }
    }

    #[test]
    fn runs_wait_for_each_other_and_what_exceeds_the_limit_is_refused() {
        let memory = Memory::new(Some(100 * MEGA));
        let refused = memory.take(101 * MEGA, (5, 7)).err();
        let line = "5 x 7 pixels need 101 MB of memory, but --max-memory allows 100 MB; cut the image into \
                    pieces, or give --strips";
        assert_eq!(refused.as_deref(), Some(line));
        let most = Mutex::new((0, 0));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    let share = memory.take(40 * MEGA, (5, 7));
                    assert!(share.is_ok());
                    let enter = |by: i32| {
                        let mut most = most.lock().unwrap();
                        most.0 += by;
                        most.1 = std::cmp::max(most.1, most.0);
                    };
                    enter(1);
                    std::thread::sleep(std::time::Duration::from_millis(5));
                    enter(-1);
                });
            }
        });
        assert_eq!(most.into_inner().unwrap(), (0, 2));
    }

    #[test]
    fn more_than_any_machine_has_is_refused_with_what_it_has() {
        let memory = Memory { limit: None, ..Memory::new(None) };
        let line = memory.take(1 << 60, (1, 1)).err().unwrap_or_default();
        assert!(line.contains("need 1152921504607 MB") && line.contains("the system gives "), "{line}");
    }
}
