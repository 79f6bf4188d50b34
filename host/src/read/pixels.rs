//! Stored numbers to physical values: big-endian samples, `BZERO + BSCALE * stored`, `BLANK` as NaN.

use super::Take;
use super::error::Fault;
use super::hdu::Hdu;
use super::header::Header;
use super::source::Source;
use crate::planes::ask_for_large_pages;

/// Bytes decoded at a time; a multiple of every sample size.
const CHUNK: usize = 1 << 16;

/// How stored numbers become physical values (FITS standard 4.0, section 4.4.2).
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaling {
    zero: f64,
    scale: f64,
    /// The stored integer that marks an undefined pixel.
    blank: Option<i64>,
}

impl Scaling {
    /// `BSCALE`, `BZERO` and, for integers, `BLANK` of a header.
    pub(super) fn of(header: &Header, bitpix: i64) -> Result<Self, Fault> {
        let scale = number(header, "BSCALE", 1.0)?;
        if scale == 0.0 {
            return Err(Fault::Header("BSCALE = 0 makes all pixels equal; correct the header".into()));
        }
        let blank = if bitpix > 0 { blank(header, "BLANK")? } else { None };
        Ok(Self { zero: number(header, "BZERO", 0.0)?, scale, blank })
    }

    /// The zero point.
    pub(super) fn zero(self) -> f64 {
        self.zero
    }

    /// The same scaling for values to which `offset` has been added already, if that is its zero point.
    pub(super) fn without_offset(self, offset: f64) -> Self {
        if self.zero != offset {
            return self;
        }
        Self { zero: 0.0, blank: self.blank.map(|blank| blank.saturating_add(offset as i64)), ..self }
    }

    /// The physical value of a stored integer. The sum is taken in f64 and rounded once to f32.
    pub(super) fn integer(self, stored: i64) -> f32 {
        if self.blank == Some(stored) { f32::NAN } else { self.real(stored as f64) }
    }

    /// The same for 64-bit integers, whose sum with a zero point of 2^63 (unsigned numbers) f64 would not hold.
    pub(super) fn long(self, stored: i64) -> f32 {
        if self.blank == Some(stored) || self.scale != 1.0 || self.zero.fract() != 0.0 {
            return self.integer(stored);
        }
        (i128::from(stored) + self.zero as i128) as f32
    }

    /// The physical value of a stored floating-point number.
    pub(super) fn real(self, stored: f64) -> f32 {
        (self.zero + self.scale * stored) as f32
    }
}

/// The integer for undefined pixels, where there is one.
pub(super) fn blank(header: &Header, keyword: &str) -> Result<Option<i64>, Fault> {
    let odd = |text: String| Fault::Header(format!("{keyword} = {text} is not a whole number"));
    match (header.whole(keyword), header.text(keyword)) {
        (None, Some(text)) => Err(odd(text)),
        (number, _) => Ok(number),
    }
}

fn number(header: &Header, keyword: &str, default: f64) -> Result<f64, Fault> {
    match header.text(keyword) {
        None => Ok(default),
        Some(text) => {
            header.real(keyword).ok_or_else(|| Fault::Header(format!("{keyword} = {text} is not a finite number")))
        }
    }
}

/// Reads the array that starts here into row-major f32.
///
/// Memory is reserved only after the file has been found long enough, or grows with the data that arrive. What `take`
/// has taken is not kept.
pub(super) fn read(
    source: &mut Source,
    hdu: &Hdu,
    bitpix: i64,
    plane: (u64, u64),
    take: &mut Option<&mut Take<'_>>,
) -> Result<Vec<f32>, Fault> {
    let scaling = Scaling::of(&hdu.header, bitpix)?;
    let size = bitpix.unsigned_abs() as usize / 8;
    let present = source.at_most_left();
    let promised = u128::from(plane.0) * u128::from(plane.1) * size as u128;
    if let Some(present) = present.filter(|&present| u128::from(present) < promised) {
        return Err(Fault::Truncated { promised, present });
    }
    let mut pixels = Vec::new();
    let out_of_memory = || memory(plane);
    let total = usize::try_from(promised).map_err(|_| out_of_memory())?;
    if present.is_some() && take.is_none() {
        pixels.try_reserve_exact(total / size).map_err(|_| out_of_memory())?;
        ask_for_large_pages(&mut pixels);
    }
    let mut buffer = vec![0u8; CHUNK.min(total)];
    let mut left = total;
    while left > 0 {
        let chunk = &mut buffer[..left.min(CHUNK)];
        let got = source.fill(chunk)?;
        if got < chunk.len() {
            return Err(Fault::Truncated { promised, present: (total - left + got) as u64 });
        }
        pixels.try_reserve(chunk.len() / size).map_err(|_| out_of_memory())?;
        decode(chunk, bitpix, scaling, &mut pixels);
        if let Some(take) = take {
            take(&pixels)?;
            pixels.clear();
        }
        left -= got;
    }
    Ok(pixels)
}

/// The error for an image that does not fit in memory.
pub(super) fn memory((width, height): (u64, u64)) -> Fault {
    let bytes = u128::from(width) * u128::from(height) * 4;
    Fault::Memory { width, height, megabytes: (bytes / 1_000_000) as u64 }
}

/// Appends the values of big-endian samples.
pub(super) fn decode(bytes: &[u8], bitpix: i64, scaling: Scaling, out: &mut Vec<f32>) {
    let plain = scaling.zero == 0.0 && scaling.scale == 1.0;
    match bitpix {
        8 => out.extend(bytes.iter().map(|&b| scaling.integer(b.into()))),
        16 => out.extend(samples(bytes).map(|b| scaling.integer(i16::from_be_bytes(b).into()))),
        32 => out.extend(samples(bytes).map(|b| scaling.integer(i32::from_be_bytes(b).into()))),
        64 => out.extend(samples(bytes).map(|b| scaling.long(i64::from_be_bytes(b)))),
        -32 if plain => out.extend(samples(bytes).map(f32::from_be_bytes)),
        -32 => out.extend(samples(bytes).map(|b| scaling.real(f32::from_be_bytes(b).into()))),
        _ => out.extend(samples(bytes).map(|b| scaling.real(f64::from_be_bytes(b)))),
    }
}

fn samples<const N: usize>(bytes: &[u8]) -> impl Iterator<Item = [u8; N]> {
    bytes.as_chunks::<N>().0.iter().copied()
}
