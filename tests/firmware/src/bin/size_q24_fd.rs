//! 32-bit fixed point with the first-order scheme alone.

#![no_std]
#![no_main]

use skyfront_core::arithmetic::Q24;
use skyfront_core::config::Scheme;
use skyfront_core::front::scheme::Fd;
use skyfront_firmware::sized;

sized!(Q24, Fd<Q24>, Scheme::Fd);
