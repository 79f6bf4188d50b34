//! 16-bit planes with the first-order scheme alone.

#![no_std]
#![no_main]

use skyfront_core::arithmetic::Q11;
use skyfront_core::config::Scheme;
use skyfront_core::front::scheme::Fd;
use skyfront_firmware::sized;

sized!(Q11, Fd<Q11>, Scheme::Fd);
