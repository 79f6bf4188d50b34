//! A set of products that appear together or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use super::error::WriteError;
use super::temporaries;

/// The files one run will write. Until [`publish`](Self::publish) they exist under temporary names only, beside their
/// final ones; dropping the set removes them.
#[derive(Debug)]
pub struct Products {
    folder: PathBuf,
    overwrite: bool,
    /// Temporary and final name of every product begun.
    begun: Vec<(PathBuf, PathBuf)>,
}

impl Products {
    /// Makes the folder if it is absent and checks, before any work is done, that it can be written to and that no
    /// product exists already.
    ///
    /// A name may be a path of its own, relative to `folder` or absolute.
    ///
    /// # Errors
    /// [`WriteError::Exists`] without `overwrite`, [`WriteError::Io`] if the folder cannot be made or written to.
    pub fn plan(folder: &Path, names: &[&str], overwrite: bool) -> Result<Self, WriteError> {
        fs::create_dir_all(folder).map_err(|reason| WriteError::io(folder, reason))?;
        let products = Self { folder: folder.to_owned(), overwrite, begun: Vec::new() };
        for name in names {
            products.check(&folder.join(name))?;
        }
        probe(folder)?;
        Ok(products)
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
                let mut file = BufWriter::with_capacity(1 << 18, File::create_new(temporary)?);
                write(&mut file)?;
                file.flush()
            };
            fill().map_err(|reason| WriteError::io(temporary, reason))
        })
    }

    /// Writes one product by a function that creates the file of the given name itself.
    ///
    /// # Errors
    /// What `write` returns, told of the product's final name.
    pub fn write_path<F>(&mut self, name: &str, write: F) -> Result<(), WriteError>
    where
        F: FnOnce(&Path) -> Result<(), WriteError>,
    {
        let product = self.path(name);
        self.check(&product)?;
        let temporary = temporary(&product);
        temporaries::add(temporary.clone());
        self.begun.push((temporary.clone(), product.clone()));
        write(&temporary).map_err(|error| error.about(&product))
    }

    /// Gives every product its final name. Returns the names in the order of writing.
    ///
    /// # Errors
    /// The first product that could not be renamed; those before it stay, the others are removed.
    pub fn publish(mut self) -> Result<Vec<PathBuf>, WriteError> {
        let mut names = Vec::new();
        for (temporary, product) in &self.begun {
            self.check(product)?;
            temporaries::publish(temporary, product).map_err(|reason| WriteError::io(product, reason))?;
            names.push(product.clone());
        }
        self.begun.clear();
        Ok(names)
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
        for (temporary, _) in &self.begun {
            temporaries::discard(temporary);
        }
    }
}

/// A name in the product's own folder that no other product of this or another process uses.
fn temporary(product: &Path) -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    product.with_file_name(format!(".skyfront-{}-{count}.part", std::process::id()))
}

/// Whether files can be made in the folder: better known now than after the work.
fn probe(folder: &Path) -> Result<(), WriteError> {
    let file = temporary(&folder.join("probe"));
    temporaries::add(file.clone());
    let made = File::create_new(&file).map_err(|reason| WriteError::io(folder, reason));
    temporaries::discard(&file);
    made.map(|_| ())
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
    fn a_folder_that_cannot_be_made_is_named() {
        let folder = folder("unmakeable");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("file"), "").unwrap();
        let error = Products::plan(&folder.join("file").join("out"), &[], false).unwrap_err().to_string();
        assert!(error.contains("file/out"), "{error}");
        fs::remove_dir_all(folder).unwrap();
    }
}
