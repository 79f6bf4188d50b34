//! A simulated FRAM on an SPI bus, and a simulated pin, with the faults that real ones have.

use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use skyfront_core::run::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};

/// What goes wrong, once, at transaction `0`, `1`, `2`, ...
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The transaction does not take place.
    Bus(u32),
    /// The last byte that the transaction writes arrives with its lowest bit turned.
    Write(u32),
}

/// A bus or pin that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

impl spi::Error for Failed {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

impl digital::Error for Failed {
    fn kind(&self) -> digital::ErrorKind {
        digital::ErrorKind::Other
    }
}

/// The memory: what it holds, and how it answers. It wants WREN before every WRITE.
#[derive(Debug)]
pub struct Fram<'a> {
    bytes: &'a mut [u8],
    writable: bool,
    /// Transactions so far.
    pub transactions: u32,
    /// The fault to come.
    pub fault: Option<Fault>,
}

impl<'a> Fram<'a> {
    /// A memory of these bytes, from address 0 on.
    pub fn new(bytes: &'a mut [u8]) -> Self {
        Fram { bytes, writable: false, transactions: 0, fault: None }
    }

    /// What it holds.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes
    }

    /// The bytes from a command's address on.
    fn at(&mut self, address: &[u8; 3]) -> &mut [u8] {
        let [high, middle, low] = *address;
        let start = u32::from_be_bytes([0, high, middle, low]) as usize;
        self.bytes.get_mut(start..).unwrap_or(&mut [])
    }

    fn write(&mut self, address: &[u8; 3], data: &[u8], damaged: bool) {
        if !core::mem::take(&mut self.writable) {
            return;
        }
        let to = self.at(address);
        to.iter_mut().zip(data).for_each(|(to, &from)| *to = from);
        if let (true, Some(last)) = (damaged, to.get_mut(data.len().saturating_sub(1))) {
            *last ^= 1;
        }
    }
}

impl spi::ErrorType for Fram<'_> {
    type Error = Failed;
}

impl SpiDevice for Fram<'_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Failed> {
        let number = self.transactions;
        self.transactions += 1;
        let fault = self.fault;
        if fault == Some(Fault::Bus(number)) {
            return Err(Failed);
        }
        match operations {
            [Operation::Write([0x06])] => self.writable = true,
            [Operation::Write([0x03, address @ ..]), Operation::Read(out)] if address.len() == 3 => {
                let address = address.first_chunk().ok_or(Failed)?;
                let stored = self.at(address);
                out.iter_mut().zip(stored).for_each(|(to, from)| *to = *from);
            }
            [Operation::Write([0x02, address @ ..]), Operation::Write(data)] if address.len() == 3 => {
                let address = address.first_chunk().ok_or(Failed)?;
                self.write(address, data, fault == Some(Fault::Write(number)));
            }
            _ => return Err(Failed),
        }
        Ok(())
    }
}

/// A pin that counts its edges.
#[derive(Debug, Default)]
pub struct Pin {
    high: bool,
    /// Edges so far.
    pub edges: u32,
    /// The next edge fails.
    pub stuck: bool,
}

impl digital::ErrorType for Pin {
    type Error = Failed;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Failed> {
        self.set(false)
    }

    fn set_high(&mut self) -> Result<(), Failed> {
        self.set(true)
    }
}

impl Pin {
    fn set(&mut self, high: bool) -> Result<(), Failed> {
        if core::mem::take(&mut self.stuck) {
            return Err(Failed);
        }
        self.edges += u32::from(self.high != high);
        self.high = high;
        Ok(())
    }
}

/// Columns of the widest sky that [`sky_in_fram`] makes.
const WIDEST: usize = 64;

/// A memory with a simulated sky at address 0, in 16-bit pixels with the high byte first.
pub fn sky_in_fram(bytes: &mut [u8], width: usize, height: usize) -> Fram<'_> {
    let mut sky = Sky::new(Kind::Bright, 5, width, height);
    let mut pixels = [0.0; WIDEST];
    let pixels = pixels.get_mut(..width).unwrap_or(&mut []);
    for (y, row) in bytes.chunks_exact_mut(2 * width).take(height).enumerate() {
        let Ok(()) = sky.row(y, pixels);
        for (bytes, pixel) in row.chunks_exact_mut(2).zip(&*pixels) {
            let counts = (200.0 + 10_000.0 * pixel) as u16;
            bytes.copy_from_slice(&counts.to_be_bytes());
        }
    }
    Fram::new(bytes)
}
