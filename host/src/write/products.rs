//! A set of products that appear together or not at all.

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::error::WriteError;
use super::scratch::Scratch;
use super::temporaries::{self, Begun};

/// The files one run will write. Until [`publish`](Self::publish) they exist under temporary names only, beside their
/// final ones; dropping the set removes them.
///
/// Whole files, all or none, hold for every end of this process but one: a kill in the middle of `publish` leaves whole
/// files of both runs. What a loss of power takes is up to the file system: nothing is flushed to the disk.
///
/// ```
/// use skyfront::write::Products;
/// use std::io::Write;
///
/// let folder = std::env::temp_dir().join(format!("skyfront-products-{}", std::process::id()));
/// let mut products = Products::plan(&folder, &["list.txt"], false)?;
/// products.write("list.txt", |out| writeln!(out, "1 2 3"))?;
/// // Until now there is no file of that name.
/// let published = products.publish()?;
/// assert_eq!(std::fs::read_to_string(&published[0]).expect("it is there"), "1 2 3\n");
/// # std::fs::remove_dir_all(&folder).expect("it is there");
/// # Ok::<(), skyfront::write::WriteError>(())
/// ```
#[derive(Debug)]
pub struct Products {
    folder: PathBuf,
    overwrite: bool,
    /// Every product begun.
    begun: Vec<Begun>,
    /// Keeps other runs out of the folder, where its file system has locks.
    _lock: Option<File>,
}

impl Products {
    /// Makes the folder if it is absent and checks, before any work is done, that it can be written to, that no other
    /// run writes into it and that no product exists already. What a killed run left there is removed.
    ///
    /// A name may be a path of its own, relative to `folder` or absolute.
    ///
    /// # Errors
    /// [`WriteError::Exists`] without `overwrite`, [`WriteError::Busy`] beside another run, [`WriteError::Io`] if the
    /// folder cannot be made or written to.
    pub fn plan(folder: &Path, names: &[&str], overwrite: bool) -> Result<Self, WriteError> {
        fs::create_dir_all(folder).map_err(|reason| WriteError::io(folder, reason))?;
        let lock = lock(folder)?;
        if lock.is_some() {
            temporaries::remove_stale(folder);
        }
        let products = Self { folder: folder.to_owned(), overwrite, begun: Vec::new(), _lock: lock };
        for name in names {
            products.check(&folder.join(name))?;
        }
        // Whether files can be made here is better known now than after the work.
        let probe = temporaries::create(folder).map_err(|reason| WriteError::io(folder, reason))?;
        temporaries::discard(&probe);
        Ok(products)
    }

    /// An empty file beside the products for what a run cannot keep in memory; it is never published.
    ///
    /// # Errors
    /// [`WriteError::Io`] if the folder cannot be written to.
    pub fn scratch(&self) -> Result<Scratch, WriteError> {
        Scratch::new(&self.folder)
    }

    /// Where a product will be.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes one product through a buffered writer.
    ///
    /// # Errors
    /// What `write` returns or the system says, with the product's final name.
    pub fn write<F>(&mut self, name: &str, write: F) -> Result<(), WriteError>
    where
        F: FnOnce(&mut dyn Write) -> io::Result<()>,
    {
        self.write_path(name, |temporary| {
            let fill = || -> io::Result<()> {
                let mut file = BufWriter::with_capacity(1 << 18, File::create(temporary)?);
                write(&mut file)?;
                file.flush()
            };
            fill().map_err(|reason| WriteError::io(temporary, reason))
        })
    }

    /// Writes one product by a function that opens the file of the given name, which is there and empty.
    ///
    /// # Errors
    /// What `write` returns, told of the product's final name.
    pub fn write_path<F>(&mut self, name: &str, write: F) -> Result<(), WriteError>
    where
        F: FnOnce(&Path) -> Result<(), WriteError>,
    {
        let product = self.path(name);
        self.check(&product)?;
        let folder = product.parent().unwrap_or(&self.folder);
        let temporary = temporaries::create(folder).map_err(|reason| WriteError::io(&product, reason))?;
        self.begun.push(Begun { temporary: temporary.clone(), product: product.clone() });
        write(&temporary).map_err(|error| error.about(&product))
    }

    /// Gives every product its final name. Returns the names in the order of writing. An interrupt waits until all
    /// have theirs.
    ///
    /// # Errors
    /// The first product that could not be renamed; then all is as it was before, where the file system has links.
    pub fn publish(mut self) -> Result<Vec<PathBuf>, WriteError> {
        self.begun.iter().try_for_each(|begun| self.check(&begun.product))?;
        temporaries::publish(&self.begun).map_err(|(product, reason)| WriteError::io(&product, reason))?;
        Ok(self.begun.drain(..).map(|begun| begun.product).collect())
    }

    fn check(&self, product: &Path) -> Result<(), WriteError> {
        match fs::symlink_metadata(product) {
            Ok(about) if about.is_dir() => Err(WriteError::io(product, ErrorKind::IsADirectory.into())),
            Ok(_) if !self.overwrite => Err(WriteError::Exists(product.to_owned())),
            _ => Ok(()),
        }
    }
}

impl Drop for Products {
    fn drop(&mut self) {
        self.begun.iter().for_each(|begun| temporaries::discard(&begun.temporary));
    }
}

/// Locks a folder for this process; `None` where folders or their file system have no locks.
fn lock(folder: &Path) -> Result<Option<File>, WriteError> {
    let Ok(handle) = File::open(folder) else { return Ok(None) };
    match handle.try_lock() {
        Ok(()) => Ok(Some(handle)),
        Err(TryLockError::WouldBlock) => Err(WriteError::Busy(folder.to_owned())),
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An empty folder of this test's own.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("skyfront-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    fn entries(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn products_appear_together() {
        let folder = folder("together");
        let mut products = Products::plan(&folder, &["a.txt", "b.txt"], false).unwrap();
        products.write("a.txt", |out| out.write_all(b"a")).unwrap();
        products.write_path("b.txt", |path| fs::write(path, "b").map_err(|e| WriteError::io(path, e))).unwrap();
        assert!(entries(&folder).iter().all(|name| name.ends_with(".part")));
        products.publish().unwrap();
        assert_eq!(entries(&folder), ["a.txt", "b.txt"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_failure_leaves_nothing_behind() {
        let folder = folder("failure");
        let mut products = Products::plan(&folder, &["a.txt"], false).unwrap();
        products.write("a.txt", |out| out.write_all(b"a")).unwrap();
        let error = products.write("b.txt", |_| Err(ErrorKind::StorageFull.into())).unwrap_err().to_string();
        assert!(error.contains("b.txt") && error.contains("make room"), "{error}");
        drop(products);
        assert!(entries(&folder).is_empty());
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_scratch_holds_words_at_any_place_and_leaves_nothing_behind() {
        let folder = folder("scratch");
        let products = Products::plan(&folder, &[], false).unwrap();
        let mut scratch = products.scratch().unwrap();
        // More than goes at once, and the second half first.
        let half = (1 << 17) + 5;
        scratch.put(half, half as u32..2 * half as u32).unwrap();
        scratch.put(0, 0..half as u32).unwrap();
        let mut words = Vec::new();
        scratch.get(1, 2 * half - 1, |word| words.push(word)).unwrap();
        assert!(words.into_iter().eq(1..2 * half as u32));
        assert!(scratch.get(half, half + 1, |_| {}).is_err());
        drop((scratch, products));
        assert!(entries(&folder).is_empty());
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn an_existing_product_is_kept_unless_overwritten() {
        let folder = folder("existing");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("a.txt"), "old").unwrap();
        let error = Products::plan(&folder, &["a.txt"], false).unwrap_err().to_string();
        assert!(error.contains("a.txt") && error.contains("--overwrite"), "{error}");
        let mut products = Products::plan(&folder, &["a.txt"], true).unwrap();
        products.write("a.txt", |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(folder.join("a.txt")).unwrap(), b"old");
        products.publish().unwrap();
        assert_eq!(fs::read(folder.join("a.txt")).unwrap(), b"new");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn one_folder_has_one_writer_and_nothing_stale() {
        let folder = folder("locked");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join(".skyfront-left.part"), "by a killed run").unwrap();
        fs::write(folder.join(".skyfront-notes"), "mine").unwrap();
        let first = Products::plan(&folder, &["a.txt"], false).unwrap();
        assert_eq!(entries(&folder), [".skyfront-notes"]);
        let error = Products::plan(&folder, &["b.txt"], false).unwrap_err().to_string();
        assert!(error.contains("another run"), "{error}");
        drop(first);
        Products::plan(&folder, &["b.txt"], false).unwrap();
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_cannot_be_published_whole_leaves_all_as_it_was() {
        let folder = folder("whole");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("a.txt"), "old").unwrap();
        let mut products = Products::plan(&folder, &["a.txt", "b.txt", "c.txt"], true).unwrap();
        for name in ["a.txt", "b.txt", "c.txt"] {
            products.write(name, |out| out.write_all(b"new")).unwrap();
        }
        fs::remove_file(&products.begun[2].temporary).unwrap();
        let error = products.publish().unwrap_err().to_string();
        assert!(error.contains("c.txt"), "{error}");
        assert_eq!(entries(&folder), ["a.txt"]);
        assert_eq!(fs::read(folder.join("a.txt")).unwrap(), b"old");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let folder = folder("unmakeable");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("file"), "").unwrap();
        let error = Products::plan(&folder.join("file").join("out"), &[], false).unwrap_err().to_string();
        assert!(error.contains("file/out"), "{error}");
        fs::remove_dir_all(folder).unwrap();
    }
}
