//! f32 with the first-order scheme alone.

#![no_std]
#![no_main]

use skyfront_core::arithmetic::F32;
use skyfront_core::config::Scheme;
use skyfront_core::scheme::Fd;
use skyfront_firmware::machine::Processor;
use skyfront_firmware::measured;
use skyfront_workload::case::Case;

measured!(F32<Processor>, Fd<F32<Processor>>, Case::paper(Scheme::Fd));
