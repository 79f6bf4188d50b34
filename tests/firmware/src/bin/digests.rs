//! Prints the digests of everything that has to be the same on every processor.

#![no_std]
#![no_main]

use skyfront_firmware::machine::Console;
use skyfront_firmware::{bits, entry, report};

entry!(run);

fn run(mut line: Console) {
    report::digest(&mut line, "powf", bits::powers());
    report::done(&mut line);
}
