//! f32 with the first-order scheme alone.

#![no_std]
#![no_main]

use skyfront_core::arithmetic::F32;
use skyfront_core::config::Scheme;
use skyfront_core::front::scheme::Fd;
use skyfront_firmware::sized;
use skyfront_machine::Processor;

sized!(F32<Processor>, Fd<F32<Processor>>, Scheme::Fd);
