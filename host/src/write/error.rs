//! Why a product could not be written, in one line that names the file, the reason and the way out.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A product that could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The product is there already.
    #[error("{}: exists already; name another output or give --overwrite", .0.display())]
    Exists(PathBuf),
    /// Another run writes into the same folder.
    #[error("{}: another run is writing into this folder; wait for its end or name another output", .0.display())]
    Busy(PathBuf),
    /// The operating system refused.
    #[error("{}: cannot be written: {reason}{}", file.display(), hint(reason))]
    Io {
        /// The product or its folder.
        file: PathBuf,
        /// What the system said. It is part of the line and therefore not given as a source as well.
        reason: std::io::Error,
    },
}

impl WriteError {
    /// Wraps what the system said about `file`.
    pub fn io(file: &Path, reason: std::io::Error) -> Self {
        Self::Io { file: file.to_owned(), reason }
    }

    /// The same error about another file: a product is known to the user by its final name, not by its temporary one.
    pub(super) fn about(self, product: &Path) -> Self {
        let file = product.to_owned();
        match self {
            Self::Exists(_) => Self::Exists(file),
            Self::Busy(folder) => Self::Busy(folder),
            Self::Io { reason, .. } => Self::Io { file, reason },
        }
    }
}

/// The way out, where the reason alone does not show it.
fn hint(reason: &std::io::Error) -> &'static str {
    match reason.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "; make room or choose another folder",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "; choose a folder you may write to",
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => "; a file stands where a folder is needed",
        _ => "",
    }
}
