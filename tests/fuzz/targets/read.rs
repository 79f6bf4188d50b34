//! Any bytes are an image or an error: no panic, no endless loop, no memory that the bytes do not justify.
//!
//! How to run it is told in `tests/fuzz/run`.
#![no_main]

use std::io::Cursor;
use std::path::Path;

use libfuzzer_sys::fuzz_target;
use skyfront::read::{self, HduChoice};

fuzz_target!(|bytes: &[u8]| {
    for choice in [None, Some(HduChoice::Number(1)), Some(HduChoice::Name("SCI".to_owned(), Some(2)))] {
        let input = Box::new(Cursor::new(bytes.to_vec()));
        match read::stream(input, Some(bytes.len() as u64), Path::new("fuzz"), choice.as_ref()) {
            Ok(image) => assert_eq!(image.pixels.len(), image.width * image.height),
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "more than one line: {error}"),
        }
    }
});
