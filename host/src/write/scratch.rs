//! A file for what a run cannot keep in memory.

use super::error::WriteError;
use super::temporaries;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Words on the disk, read and written at any place; the file is gone with this.
#[derive(Debug)]
pub struct Scratch {
    folder: PathBuf,
    path: PathBuf,
    file: File,
}

/// Bytes on their way.
const PIECE: usize = 1 << 18;
const WORD: usize = size_of::<u32>();

impl Scratch {
    /// An empty one in a folder.
    pub(super) fn new(folder: &Path) -> Result<Scratch, WriteError> {
        let refused = |reason| WriteError::io(folder, reason);
        let path = temporaries::create(folder).map_err(refused)?;
        match OpenOptions::new().read(true).write(true).open(&path) {
            Ok(file) => Ok(Scratch { folder: folder.to_owned(), path, file }),
            Err(reason) => {
                temporaries::discard(&path);
                Err(refused(reason))
            }
        }
    }

    /// Puts words at a place, which counts in words.
    ///
    /// # Errors
    /// [`WriteError::Io`] if the system refuses, for instance on a full disk.
    pub fn put(&mut self, at: usize, words: impl IntoIterator<Item = u32>) -> Result<(), WriteError> {
        let (mut words, mut piece) = (words.into_iter().peekable(), Vec::with_capacity(PIECE));
        let mut write = || -> io::Result<()> {
            self.seek(at)?;
            while words.peek().is_some() {
                piece.clear();
                piece.extend(words.by_ref().take(PIECE / WORD).flat_map(u32::to_le_bytes));
                self.file.write_all(&piece)?;
            }
            Ok(())
        };
        write().map_err(|reason| WriteError::io(&self.folder, reason))
    }

    /// Gives so many words from a place on.
    ///
    /// # Errors
    /// [`WriteError::Io`] if the system refuses, or has fewer.
    pub fn get(&mut self, at: usize, count: usize, mut each: impl FnMut(u32)) -> Result<(), WriteError> {
        let mut piece = vec![0; PIECE.min(count * WORD)];
        let mut read = || -> io::Result<()> {
            self.seek(at)?;
            let mut left = count * WORD;
            while left > 0 {
                let piece = &mut piece[..left.min(PIECE)];
                self.file.read_exact(piece)?;
                piece.as_chunks().0.iter().for_each(|word| each(u32::from_le_bytes(*word)));
                left -= piece.len();
            }
            Ok(())
        };
        read().map_err(|reason| WriteError::io(&self.folder, reason))
    }

    fn seek(&mut self, at: usize) -> io::Result<()> {
        self.file.seek(SeekFrom::Start((at * WORD) as u64)).map(|_| ())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        temporaries::discard(&self.path);
    }
}
