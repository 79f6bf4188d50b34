//! A flight computer's devices through `embedded-hal` 1.0 (feature `hal`).
//!
//! - [`SerialMemory`]: FRAM, MRAM or, to read from, NOR flash on an SPI bus;
//! - [`MemoryFrame`]: the frame source that streams the image's rows out of it;
//! - [`MapWriter`]: writes the label map back, a bounded chunk a poll, each chunk read back;
//! - [`Heartbeat`]: polls a run and toggles the pin that an external watchdog looks at.
//!
//! Every error of a bus or pin comes back as it is, inside a typed error; after one the same call
//! can be made again. Nothing here keeps more than [`CHUNK`] bytes, and no call holds the bus for
//! longer than one chunk and its address.
//!
//! Not supported: pages, erasing and the busy flag, which writing to NOR flash or EEPROM needs.

mod frame;
mod heartbeat;
mod map;
mod pixels;
mod serial;

pub use frame::MemoryFrame;
pub use heartbeat::{Heartbeat, PollError};
pub use map::MapWriter;
pub use pixels::PixelFormat;
pub use serial::{CHUNK, MemoryError, SerialMemory};
