//! f32 with every scheme; sized on the semi-Lagrangian one with curvature.

#![no_std]
#![no_main]

use skyfront_core::arithmetic::F32;
use skyfront_core::config::Scheme;
use skyfront_core::front::scheme::AnyScheme;
use skyfront_firmware::sized;
use skyfront_machine::Processor;

sized!(F32<Processor>, AnyScheme<F32<Processor>>, Scheme::SlCurvature);
