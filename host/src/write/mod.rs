//! Writing results: whole files or none.
//!
//! [`Products`] gives every product a temporary name beside its final one and renames them all when all are complete.
//! [`fits`] writes images and tables, [`wcs`] picks the coordinate keywords of the input for them.

mod checksum;
pub mod entry;
mod error;
pub mod fits;
mod products;
mod scratch;
mod temporaries;
pub mod wcs;

pub use entry::{Entry, Value};
pub use error::WriteError;
pub use products::Products;
pub use scratch::Scratch;
pub use temporaries::interrupted;
