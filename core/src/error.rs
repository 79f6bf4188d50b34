//! What a caller can get wrong, named: the parameter, its value and its bound.

use core::fmt;

/// Why a pipeline cannot be set up or go on. `E` is the error of the frame source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error<E = core::convert::Infallible> {
    /// A parameter lies outside its bounds.
    Parameter {
        /// The parameter's name.
        name: &'static str,
        /// Its value.
        value: f32,
        /// What it must satisfy, in words.
        bound: &'static str,
        /// The bound as a number.
        limit: f32,
    },
    /// The image has an impossible or unsupported size.
    Size {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// The least number of columns, and of rows, that this configuration can work with.
        least: usize,
        /// The greatest number of columns.
        most_columns: usize,
        /// The greatest number of pixels this arithmetic can label.
        most_pixels: usize,
    },
    /// A slice of the caller's memory has the wrong length.
    Length {
        /// Which slice.
        name: &'static str,
        /// Its length, in elements.
        given: usize,
        /// The length it must have at least.
        needed: usize,
    },
    /// No pixel is finite: there is nothing to segment.
    NothingDefined {
        /// How many pixels the image has.
        pixels: usize,
    },
    /// All defined pixels, or the two percentiles, are equal: min-max scaling is undefined.
    Constant {
        /// The value they share.
        value: f32,
    },
    /// No cell of the frame has enough defined pixels for its sky to be measured.
    NoSky {
        /// How many pixels are defined.
        defined: u32,
        /// How many one cell must have at least.
        needed: usize,
    },
    /// The values show no noise, and none was given: significance is undefined.
    NoNoise {
        /// The commonest value.
        value: f32,
        /// How many defined pixels have it.
        equal: u32,
        /// How many pixels are defined.
        defined: u32,
    },
    /// The chosen arithmetic cannot serve this scheme or option.
    Arithmetic {
        /// The arithmetic.
        name: &'static str,
        /// What it cannot do, and why.
        reason: &'static str,
    },
    /// Two choices that cannot go together.
    Together {
        /// A choice.
        choice: &'static str,
        /// What was chosen.
        value: &'static str,
        /// The other choice.
        other: &'static str,
        /// What it would have to be.
        wanted: &'static str,
    },
    /// The front of [`Scheme::Region`](crate::config::Scheme::Region) starts from signal-to-noise: it is
    /// moved by [`crate::run::extract`], not by a [`crate::run::segmenter::Segmenter`]; and other fronts
    /// the other way round.
    Front {
        /// The scheme.
        scheme: &'static str,
        /// What moves it.
        mover: &'static str,
    },
    /// The frame is a part of an image whose other parts have yet to answer (see [`crate::plane::part`]).
    Waiting,
    /// The memory between two polls is not what the pipeline left there.
    Corrupted {
        /// Which plane or table.
        name: &'static str,
    },
    /// The frame was changed by others while the run read it.
    FrameChanged,
    /// A snapshot was not taken up, and the run that was to take it up has lost its memory.
    NotRestored,
    /// The frame source failed.
    Frame(E),
}

impl<E> Error<E> {
    /// The same error for any frame source; a frame error is given to `frame`.
    pub fn map_frame<F>(self, frame: impl FnOnce(E) -> F) -> Error<F> {
        self.of_run().unwrap_or_else(|error| Error::Frame(frame(error)))
    }

    /// An error of the run, after which it cannot go on; that of a frame source, after which it can.
    pub(crate) fn of_run<F>(self) -> Result<Error<F>, E> {
        Ok(match self {
            Error::Parameter { name, value, bound, limit } => Error::Parameter { name, value, bound, limit },
            Error::Size { width, height, least, most_columns, most_pixels } => {
                Error::Size { width, height, least, most_columns, most_pixels }
            }
            Error::Length { name, given, needed } => Error::Length { name, given, needed },
            Error::NothingDefined { pixels } => Error::NothingDefined { pixels },
            Error::Constant { value } => Error::Constant { value },
            Error::NoSky { defined, needed } => Error::NoSky { defined, needed },
            Error::NoNoise { value, equal, defined } => Error::NoNoise { value, equal, defined },
            Error::Arithmetic { name, reason } => Error::Arithmetic { name, reason },
            Error::Together { choice, value, other, wanted } => Error::Together { choice, value, other, wanted },
            Error::Front { scheme, mover } => Error::Front { scheme, mover },
            Error::Waiting => Error::Waiting,
            Error::Corrupted { name } => Error::Corrupted { name },
            Error::FrameChanged => Error::FrameChanged,
            Error::NotRestored => Error::NotRestored,
            Error::Frame(error) => return Err(error),
        })
    }
}

impl<E: fmt::Display> fmt::Display for Error<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Parameter { name, value, bound, limit } => {
                write!(f, "{name} is {value}; must be {bound} {limit}")
            }
            Error::Size { width, height, least, most_columns, most_pixels } => write!(
                f,
                "the image is {width} x {height} pixels, but must be at least {least} x {least}, and have at most \
                 {most_columns} columns and {most_pixels} pixels"
            ),
            Error::Length { name, given, needed } => {
                write!(f, "the memory for {name} has {given} elements, but needs {needed}")
            }
            Error::NothingDefined { pixels } => {
                write!(f, "none of the {pixels} pixels is a finite number")
            }
            Error::Constant { value } => {
                write!(f, "all pixels in the range to normalise equal {value}: nothing stands out")
            }
            Error::NoSky { defined, needed } => write!(
                f,
                "no part of the frame has {needed} defined pixels to measure its sky on; {defined} are defined in all"
            ),
            Error::NoNoise { value, equal, defined } => {
                write!(f, "{equal} of {defined} defined pixels equal {value}: there is no noise to measure")
            }
            Error::Arithmetic { name, reason } => write!(f, "arithmetic {name}: {reason}"),
            Error::Together { choice, value, other, wanted } => {
                write!(f, "{choice} {value} needs {other} {wanted}")
            }
            Error::Front { scheme, mover } => write!(f, "the front of the scheme {scheme} is moved by {mover}"),
            Error::Waiting => f.write_str("the other parts of the image have yet to answer"),
            Error::Corrupted { name } => write!(f, "the memory of {name} was changed between two polls"),
            Error::FrameChanged => f.write_str("the frame was changed while it was worked on"),
            Error::NotRestored => f.write_str("the snapshot was not taken up: the run has lost its memory"),
            Error::Frame(error) => write!(f, "reading the frame: {error}"),
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for Error<E> {}
