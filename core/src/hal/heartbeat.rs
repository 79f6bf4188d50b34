//! The sign of life for an external watchdog.

use crate::arithmetic::{Arithmetic, Level};
use crate::error::Error;
use crate::front::scheme::Evolve;
use crate::plane::raster::Sample;
use crate::run::extract::{self, Extractor};
use crate::run::frame::Frame;
use crate::run::outcome::Progress;
use crate::run::segmenter::Segmenter;
use core::convert::Infallible;
use core::fmt;
use embedded_hal::digital::OutputPin;

/// Why a poll with a heartbeat failed. `F` is the error of the frame source, `P` that of the pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PollError<F, P> {
    /// The run could not go on; the pin was left alone.
    Run(Error<F>),
    /// The rows were done, but the pin did not follow.
    Pin(P),
}

impl<F: fmt::Display, P: embedded_hal::digital::Error> fmt::Display for PollError<F, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PollError::Run(error) => error.fmt(f),
            PollError::Pin(error) => write!(f, "the heartbeat's pin: {}", error.kind()),
        }
    }
}

impl<F: fmt::Debug + fmt::Display, P: embedded_hal::digital::Error> core::error::Error for PollError<F, P> {}

/// Toggles a pin after every bounded piece of work.
///
/// The interval between two edges is the time of at most `rows` rows of one pass, whatever the image
/// holds: choose `rows` so that it stays below the watchdog's. A run that fails or hangs in its
/// frame source stops the edges.
#[derive(Debug)]
pub struct Heartbeat<P> {
    pin: P,
    rows: usize,
    high: bool,
}

impl<P: OutputPin> Heartbeat<P> {
    /// A heartbeat on a pin that is low, with an edge at least every `rows` rows (at least one).
    pub const fn new(pin: P, rows: usize) -> Self {
        Heartbeat { pin, rows, high: false }
    }

    /// Polls a run for at most `rows` rows and toggles the pin.
    ///
    /// # Errors
    /// [`PollError::Run`] or [`PollError::Pin`]; after a failed pin, as after a failed frame source,
    /// the next call goes on where this one ended.
    pub fn poll<A: Arithmetic, S: Evolve<A>, F: Frame>(
        &mut self,
        run: &mut Segmenter<'_, A, S>,
        frame: &mut F,
    ) -> Result<Progress, PollError<F::Error, P::Error>> {
        let progress = run.poll(self.rows, frame).map_err(PollError::Run)?;
        self.beat().map_err(PollError::Pin)?;
        Ok(progress)
    }

    /// Polls a run of the default, as [`Heartbeat::poll`] does one of the front.
    ///
    /// # Errors
    /// [`PollError::Run`] or [`PollError::Pin`].
    pub fn poll_extractor<L: Level, S: Sample>(
        &mut self,
        run: &mut Extractor<'_, '_, L, S>,
    ) -> Result<extract::Progress, PollError<Infallible, P::Error>> {
        let progress = run.poll(self.rows).map_err(PollError::Run)?;
        self.beat().map_err(PollError::Pin)?;
        Ok(progress)
    }

    /// Toggles the pin: for bounded work beside a run, such as a chunk of a map.
    ///
    /// # Errors
    /// The pin's; the next beat tries the same edge again.
    pub fn beat(&mut self) -> Result<(), P::Error> {
        if self.high {
            self.pin.set_low()?;
        } else {
            self.pin.set_high()?;
        }
        self.high = !self.high;
        Ok(())
    }

    /// Gives the pin back.
    pub fn release(self) -> P {
        self.pin
    }
}
