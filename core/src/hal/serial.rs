//! A serial memory with 24-bit addresses, byte by byte.

use core::fmt;
use embedded_hal::spi::{Operation, SpiDevice};

/// The most bytes of data in one bus transaction.
pub const CHUNK: usize = 64;

/// First byte of a read: READ, followed by the address, high byte first.
const READ: u8 = 0x03;
/// Sets the write enable latch, which every write clears: WREN.
const WRITE_ENABLE: u8 = 0x06;
/// First byte of a write: WRITE, followed by the address, high byte first.
const WRITE: u8 = 0x02;
/// Addresses have 24 bits.
const SIZE: u32 = 1 << 24;

/// What can go wrong with a serial memory. `E` is the error of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryError<E> {
    /// The bus failed.
    Bus(E),
    /// The range does not lie within 24-bit addresses.
    Range {
        /// First address.
        address: u32,
        /// Number of bytes.
        bytes: usize,
    },
    /// The memory gave back something else than was written.
    Mismatch {
        /// The first address that differs.
        address: u32,
        /// What was written there.
        written: u8,
        /// What was read there.
        read: u8,
    },
    /// A row that the image does not have, or a row of another length.
    Row {
        /// The row.
        y: usize,
        /// Columns asked for.
        columns: usize,
    },
    /// A label larger than the format of the map holds.
    Label {
        /// The label.
        label: u32,
        /// The greatest that the format holds.
        greatest: u16,
    },
}

impl<E: embedded_hal::spi::Error> fmt::Display for MemoryError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MemoryError::Bus(error) => write!(f, "the bus: {}", error.kind()),
            MemoryError::Range { address, bytes } => {
                write!(f, "{bytes} bytes from {address:#x} on are beyond 24-bit addresses")
            }
            MemoryError::Mismatch { address, written, read } => {
                write!(f, "wrote {written:#04x} to {address:#x}, but read {read:#04x}")
            }
            MemoryError::Row { y, columns } => write!(f, "the image has no row {y} of {columns} columns"),
            MemoryError::Label { label, greatest } => {
                write!(f, "label {label} does not fit the map, whose greatest is {greatest}")
            }
        }
    }
}

impl<E: embedded_hal::spi::Error> core::error::Error for MemoryError<E> {}

/// FRAM, MRAM or, to read from, NOR flash: READ 0x03, WREN 0x06 and WRITE 0x02, 24-bit addresses.
///
/// A write is over when the transaction is: so FRAM and MRAM have it. NOR flash and EEPROM need pages,
/// erasing and waiting, which this driver does not do.
#[derive(Debug)]
pub struct SerialMemory<D> {
    device: D,
}

impl<D: SpiDevice> SerialMemory<D> {
    /// The memory on a device of the bus; mode 0 or 3.
    pub const fn new(device: D) -> Self {
        SerialMemory { device }
    }

    /// Gives the device back.
    pub fn release(self) -> D {
        self.device
    }

    /// Reads bytes from `address` on, one transaction for each [`CHUNK`].
    ///
    /// # Errors
    /// [`MemoryError::Range`] or [`MemoryError::Bus`].
    pub fn read(&mut self, address: u32, out: &mut [u8]) -> Result<(), MemoryError<D::Error>> {
        in_range(address, out.len())?;
        for (at, chunk) in (address..).step_by(CHUNK).zip(out.chunks_mut(CHUNK)) {
            let mut operations = [Operation::Write(&command(READ, at)), Operation::Read(chunk)];
            self.device.transaction(&mut operations).map_err(MemoryError::Bus)?;
        }
        Ok(())
    }

    /// Writes bytes from `address` on and reads each [`CHUNK`] back: three transactions a chunk.
    ///
    /// # Errors
    /// [`MemoryError::Range`], [`MemoryError::Bus`], or [`MemoryError::Mismatch`] at the first byte
    /// that was read back wrong. The chunks before it are written.
    pub fn write(&mut self, address: u32, bytes: &[u8]) -> Result<(), MemoryError<D::Error>> {
        in_range(address, bytes.len())?;
        for (at, chunk) in (address..).step_by(CHUNK).zip(bytes.chunks(CHUNK)) {
            self.device.transaction(&mut [Operation::Write(&[WRITE_ENABLE])]).map_err(MemoryError::Bus)?;
            let mut operations = [Operation::Write(&command(WRITE, at)), Operation::Write(chunk)];
            self.device.transaction(&mut operations).map_err(MemoryError::Bus)?;
            self.verify(at, chunk)?;
        }
        Ok(())
    }

    /// Compares at most one chunk with what lies in the memory.
    fn verify(&mut self, address: u32, chunk: &[u8]) -> Result<(), MemoryError<D::Error>> {
        let mut buffer = [0; CHUNK];
        let back = buffer.get_mut(..chunk.len()).unwrap_or(&mut []);
        self.read(address, back)?;
        for ((at, &written), &read) in (address..).zip(chunk).zip(&*back) {
            if written != read {
                return Err(MemoryError::Mismatch { address: at, written, read });
            }
        }
        Ok(())
    }
}

/// Whether `bytes` bytes from `address` on have addresses.
pub(super) fn in_range<E>(address: u32, bytes: usize) -> Result<(), MemoryError<E>> {
    let end = u32::try_from(bytes).ok().and_then(|bytes| address.checked_add(bytes));
    match end {
        Some(end) if end <= SIZE => Ok(()),
        _ => Err(MemoryError::Range { address, bytes }),
    }
}

/// A command and its address.
fn command(code: u8, address: u32) -> [u8; 4] {
    let [_, high, middle, low] = address.to_be_bytes();
    [code, high, middle, low]
}
