//! f32 with the paper's best setting and no other.

#![no_std]
#![no_main]

use skyfront_core::arithmetic::F32;
use skyfront_core::config::{Config, Scheme};
use skyfront_core::front::scheme::{Fd, Fixed, Preset};
use skyfront_firmware::sized;
use skyfront_machine::Processor;

/// What the program is built for.
struct Paper;

impl Fixed for Paper {
    const CONFIG: Config = Config::PAPER_F160;
}

sized!(F32<Processor>, Preset<Fd<F32<Processor>>, Paper>, Scheme::Fd);
