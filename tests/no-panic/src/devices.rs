//! A flight computer's devices.

use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use skyfront_core::arithmetic::{Narrow, Q11};
use skyfront_core::run::frame::Frame;
use skyfront_core::hal::{Heartbeat, MapWriter, MemoryError, MemoryFrame, PixelFormat, PollError, SerialMemory};
use skyfront_core::run::outcome::Progress;
use skyfront_core::run::segmenter::Segmenter;

/// A bus and a pin that may fail.
pub trait Board {
    /// One transaction on the bus.
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), spi::ErrorKind>;
    /// Sets the pin.
    fn set(&mut self, high: bool) -> Result<(), digital::ErrorKind>;
}

/// A board behind a pointer.
pub struct On<'a>(&'a mut dyn Board);

impl spi::ErrorType for On<'_> {
    type Error = spi::ErrorKind;
}

impl SpiDevice for On<'_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), spi::ErrorKind> {
        self.0.transaction(operations)
    }
}

impl digital::ErrorType for On<'_> {
    type Error = digital::ErrorKind;
}

impl OutputPin for On<'_> {
    fn set_low(&mut self) -> Result<(), digital::ErrorKind> {
        self.0.set(false)
    }

    fn set_high(&mut self) -> Result<(), digital::ErrorKind> {
        self.0.set(true)
    }
}

type Failed = MemoryError<spi::ErrorKind>;

#[unsafe(export_name = "memory_read")]
fn read(board: &mut dyn Board, address: u32, out: &mut [u8]) -> Result<(), Failed> {
    SerialMemory::new(On(board)).read(address, out)
}

#[unsafe(export_name = "memory_write")]
fn write(board: &mut dyn Board, address: u32, bytes: &[u8]) -> Result<(), Failed> {
    SerialMemory::new(On(board)).write(address, bytes)
}

#[unsafe(export_name = "memory_row")]
fn row(board: &mut dyn Board, start: u32, size: (usize, usize), format: PixelFormat, undefined: u16, y: usize, out: &mut [f32]) -> Result<(), Failed> {
    let frame = MemoryFrame::new(SerialMemory::new(On(board)), start, size.0, size.1, format)?;
    frame.with_undefined(undefined).row(y, out)
}

#[unsafe(export_name = "map_new")]
fn map(start: u32, pixels: usize, format: PixelFormat) -> Result<MapWriter, Failed> {
    MapWriter::new(start, pixels, format)
}

#[unsafe(export_name = "map_poll")]
fn poll_map(map: &mut MapWriter, board: &mut dyn Board, labels: &[Narrow]) -> Result<bool, Failed> {
    map.poll(&mut SerialMemory::new(On(board)), labels)
}

#[unsafe(export_name = "heartbeat")]
fn heartbeat(run: &mut Segmenter<'_, Q11>, rows: usize, board: &mut dyn Board, medium: &mut dyn super::Medium) -> Result<Progress, PollError<u8, digital::ErrorKind>> {
    Heartbeat::new(On(board), rows).poll(run, &mut super::Through(medium))
}
