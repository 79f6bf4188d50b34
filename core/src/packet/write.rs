//! Packets on board.

use super::{BEGINNING, BYTES, ENDS, Kind, PIECE, RECORD, VERSION};
use crate::arithmetic::digest::Digest;
use crate::error::Error;
use crate::track::{Pixel, Raster, Star, Window};

/// Where the next packet of a product begins.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cursor {
    /// The caller's number of the product, such as that of the frame.
    pub product: u32,
    /// Packets written.
    pub packet: u32,
    /// Stars, pixels of the map, or cut-outs written.
    pub item: u32,
    /// Pixels of the next cut-out written.
    pub pixel: u32,
}

impl Cursor {
    /// Before the first packet of a product.
    pub const fn new(product: u32) -> Cursor {
        Cursor { product, packet: 0, item: 0, pixel: 0 }
    }

    /// Whether all of `total` is written; of nothing there is one packet.
    fn is_done(&self, total: u32) -> bool {
        self.item >= total && (self.packet > 0 || self.item > 0)
    }
}

/// A packet in the caller's bytes.
struct Writer<'a> {
    out: &'a mut [u8],
    length: usize,
}

impl<'a> Writer<'a> {
    fn new(cursor: &Cursor, kind: Kind, out: &'a mut [u8]) -> Result<Self, Error> {
        let (given, (needed, most)) = (out.len(), BYTES);
        if given < needed {
            return Err(Error::Length { name: "a packet", given, needed });
        }
        let mut writer = Writer { out: out.get_mut(..given.min(most)).unwrap_or(&mut []), length: 0 };
        writer.put(&BEGINNING);
        writer.put(&[VERSION, kind as u8, 0, 0]);
        writer.word(cursor.product);
        writer.word(cursor.packet);
        Ok(writer)
    }

    fn put(&mut self, bytes: &[u8]) {
        let end = self.length.saturating_add(bytes.len());
        if let Some(to) = self.out.get_mut(self.length..end) {
            to.iter_mut().zip(bytes).for_each(|(to, byte)| *to = *byte);
            self.length = end;
        }
    }

    fn word(&mut self, word: u32) {
        self.put(&word.to_le_bytes());
    }

    fn short(&mut self, short: u16) {
        self.put(&short.to_le_bytes());
    }

    /// Bytes that are left for the body.
    fn room(&self) -> usize {
        self.out.len().saturating_sub(self.length).saturating_sub(ENDS.1)
    }

    /// Ends the packet; its bytes.
    fn close(mut self, cursor: &mut Cursor) -> usize {
        let bytes = self.length.saturating_add(ENDS.1) as u16;
        if let Some(place) = self.out.get_mut(6..8) {
            place.iter_mut().zip(bytes.to_le_bytes()).for_each(|(to, byte)| *to = byte);
        }
        let mut digest = Digest::default();
        digest.bytes(self.out.get(..self.length).unwrap_or(&[]));
        self.word(digest.value());
        cursor.packet = cursor.packet.saturating_add(1);
        self.length
    }
}

/// A number in bytes of seven bits, and how many they are.
fn sevens(mut number: u32) -> ([u8; 5], usize) {
    let (mut bytes, mut length) = ([0; 5], 0usize);
    for byte in &mut bytes {
        length = length.saturating_add(1);
        *byte = (number & 0x7F) as u8;
        number >>= 7;
        if number == 0 {
            break;
        }
        *byte |= 0x80;
    }
    (bytes, length)
}

/// Writes the next packet of stars; its bytes, or none where all are written. Cost: the bytes.
///
/// ```
/// use skyfront_core::packet::{Contents, Cursor, Packet, stars};
/// use skyfront_core::track::Star;
///
/// let (mut cursor, mut out) = (Cursor::new(7), [0; 256]);
/// let found = [Star { x: 12.5, y: 3.25, ..Star::default() }; 9];
/// let mut received = 0;
/// while let Some(length) = stars(&mut cursor, &found, &mut out)? {
///     let packet = Packet::read(&out[..length]).expect("nothing was damaged");
///     assert_eq!(packet.product, 7);
///     if let Contents::Stars { records, .. } = packet.contents {
///         received += records.count();
///     }
/// }
/// assert_eq!((received, cursor.packet), (9, 2));
/// # Ok::<(), skyfront_core::error::Error>(())
/// ```
///
/// # Errors
/// [`Error::Length`] for an `out` of fewer bytes than [`BYTES`] says; of more than that only as many are used.
/// Then, as for the other kinds, the cursor stays where it is.
pub fn stars(cursor: &mut Cursor, stars: &[Star], out: &mut [u8]) -> Result<Option<usize>, Error> {
    let total = u32::try_from(stars.len()).unwrap_or(u32::MAX);
    if cursor.is_done(total) {
        return Ok(None);
    }
    let mut packet = Writer::new(cursor, Kind::Stars, out)?;
    packet.word(total);
    packet.word(cursor.item);
    for star in stars.iter().skip(cursor.item as usize) {
        if packet.room() < RECORD {
            break;
        }
        let Star { x, y, flux, snr, errx2, erry2, errxy, flags } = *star;
        [x, y, flux, snr, errx2, erry2, errxy].into_iter().for_each(|number| packet.word(number.to_bits()));
        packet.word(flags);
        cursor.item = cursor.item.saturating_add(1);
    }
    Ok(Some(packet.close(cursor)))
}

/// Writes the next packet of a map of `width` x `height` labels, of which `label` gives the one at a place in
/// row-major order, 0 for the background, always the same; the packet's bytes, or none where all are written.
/// Cost: the labels in the packet are looked at once, those of the run that no longer fits once more.
///
/// # Errors
/// [`Error::Size`] for a map without pixels or of 2^32 and more, [`Error::Length`] as for [`stars`].
pub fn labels(
    cursor: &mut Cursor,
    (width, height): (u32, u32),
    label: impl Fn(usize) -> u32,
    out: &mut [u8],
) -> Result<Option<usize>, Error> {
    let Some(total) = width.checked_mul(height).filter(|&total| total > 0) else {
        let (most_columns, most_pixels) = (u32::MAX as usize, u32::MAX as usize);
        return Err(Error::Size {
            width: width as usize,
            height: height as usize,
            least: 1,
            most_columns,
            most_pixels,
        });
    };
    if cursor.is_done(total) {
        return Ok(None);
    }
    let mut packet = Writer::new(cursor, Kind::Labels, out)?;
    [width, height, cursor.item].into_iter().for_each(|word| packet.word(word));
    while cursor.item < total {
        let value = label(cursor.item as usize);
        let rest = cursor.item.saturating_add(1)..total;
        let more = rest.take_while(|&at| label(at as usize) == value).fold(1, |count: u32, _| count.saturating_add(1));
        let (numbers, counts) = (sevens(value), sevens(more));
        if packet.room() < numbers.1.saturating_add(counts.1) {
            break;
        }
        for (bytes, length) in [numbers, counts] {
            packet.put(bytes.get(..length).unwrap_or(&bytes));
        }
        cursor.item = cursor.item.saturating_add(more);
    }
    Ok(Some(packet.close(cursor)))
}

/// Writes the next packet of cut-outs, the parts of `windows` that lie in the frame; its bytes, or none where all
/// are written. Cost: the windows are looked at once, and the bytes.
///
/// # Errors
/// [`Error::Parameter`] for a window out of bounds, or more than 65535 of them; [`Error::Length`] as for [`stars`].
pub fn cutouts<P: Pixel>(
    cursor: &mut Cursor,
    frame: &Raster<'_, P>,
    windows: &[Window],
    out: &mut [u8],
) -> Result<Option<usize>, Error> {
    let Ok(total) = u16::try_from(windows.len()) else {
        let (value, limit) = (windows.len() as f32, f32::from(u16::MAX));
        return Err(Error::Parameter { name: "number of windows", value, bound: "at most", limit });
    };
    windows.iter().try_for_each(Window::validate)?;
    if cursor.is_done(u32::from(total)) {
        return Ok(None);
    }
    let mut packet = Writer::new(cursor, Kind::Cutouts, out)?;
    packet.short(total);
    packet.short(P::BITS as u16);
    for window in windows.iter().skip(cursor.item as usize) {
        if !cutout(cursor, frame, window, &mut packet) {
            break;
        }
    }
    Ok(Some(packet.close(cursor)))
}

/// Writes as much of a cut-out as there is room for; whether that is all.
fn cutout<P: Pixel>(cursor: &mut Cursor, frame: &Raster<'_, P>, window: &Window, packet: &mut Writer<'_>) -> bool {
    let ((x, columns), (y, rows)) = window.within(frame);
    // A window's sides are 64 pixels at most.
    let pixels = columns.saturating_mul(rows);
    let (each, first) = ((P::BITS >> 3) as usize, (cursor.pixel as usize).min(pixels));
    let Some(room) = packet.room().checked_sub(PIECE) else { return false };
    let left = pixels.saturating_sub(first);
    let count = left.min(if each == 1 { room } else { room >> 1 });
    if count == 0 && left > 0 {
        return false;
    }
    for number in [cursor.item as usize, x, y, columns, rows, first, count] {
        packet.short(number as u16);
    }
    let all = (y..y.saturating_add(rows)).flat_map(|y| frame.part(y, x..x.saturating_add(columns)));
    for pixel in all.skip(first).take(count) {
        packet.put(pixel.count().to_le_bytes().get(..each).unwrap_or(&[]));
    }
    if count < left {
        cursor.pixel = first.saturating_add(count) as u32;
        return false;
    }
    (cursor.item, cursor.pixel) = (cursor.item.saturating_add(1), 0);
    true
}
