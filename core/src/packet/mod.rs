//! What goes to the ground in packets: stars, the map of labels, and cut-outs of the frame.
//!
//! [`stars`], [`labels`] and [`cutouts`] write one packet a call into the caller's bytes, 64 to 65535 of them,
//! and move a [`Cursor`] on; a copy of it is enough to go on later, or to send a packet again. Every packet is
//! read by itself ([`Packet::read`]), so that a lost one costs no more than what was in it.
//!
//! All numbers are little-endian. A packet is: "SkyD"; a byte of version and one of kind (1 stars, 2 labels, 3
//! cut-outs); its bytes, 16 bits; the caller's number of the product and the packet's within it, 32 bits each;
//! the body; and the CRC-32 of everything before. The bodies:
//!
//! * stars: how many there are in all, the index of the first, 32 bits each; records of 32 bytes, the fields of
//!   [`Star`](crate::track::Star) in their order;
//! * labels: columns and rows of the map, the place of the first pixel in row-major order, 32 bits each; runs,
//!   each a label and how many pixels have it, in bytes of seven bits, the lowest first, of which all but the
//!   last have bit 7 set (LEB128);
//! * cut-outs: how many there are in all, bits of a pixel, 16 bits each; pieces, each of seven numbers of 16 bits
//!   (index of the cut-out, its first column and row, its columns and rows, the first pixel of the piece in it,
//!   how many there are), and the pixels, 8 or 16 bits each.
//!
//! A product with nothing in it is one packet that says so. Of damaged packets the CRC-32 lets one in 2^32 pass.

mod read;
mod write;

pub use read::{Contents, Packet, PacketError, Piece, Pieces, Records, Run, Runs};
pub use write::{Cursor, cutouts, labels, stars};

/// The first bytes of every packet, by which the next is found behind a damaged one.
pub const BEGINNING: [u8; 4] = *b"SkyD";
/// Changes with the format.
const VERSION: u8 = 1;
/// Bytes before the body, and after it.
const ENDS: (usize, usize) = (16, 4);
/// Bytes of a record of a star, and of a piece of a cut-out without its pixels.
const RECORD: usize = 32;
const PIECE: usize = 14;

/// The least and the greatest size of a packet, bytes.
pub const BYTES: (usize, usize) = (64, 65_535);

/// What is in a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Stars of windows.
    Stars = 1,
    /// The map of labels.
    Labels = 2,
    /// Parts of the frame.
    Cutouts = 3,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Kind; 3] = [Kind::Stars, Kind::Labels, Kind::Cutouts];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Stars => "stars",
            Kind::Labels => "labels",
            Kind::Cutouts => "cut-outs",
        }
    }
}

#[cfg(test)]
#[allow(clippy::arithmetic_side_effects, reason = "a test that overflows fails")]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::track::{Raster, Star, Window};

    extern crate std;
    use std::string::ToString;
    use std::vec::Vec;

    const SIZES: [usize; 5] = [64, 65, 100, 333, 70_000];

    /// All packets of a product.
    fn all(size: usize, mut next: impl FnMut(&mut Cursor, &mut [u8]) -> Result<Option<usize>, Error>) -> Vec<Vec<u8>> {
        let (mut cursor, mut out, mut packets) = (Cursor::new(7), std::vec![0xAA; size], Vec::new());
        while let Some(length) = next(&mut cursor, &mut out).unwrap() {
            assert!(length <= size && length <= BYTES.1);
            packets.push(out[..length].to_vec());
            assert_eq!(cursor.packet as usize, packets.len());
        }
        assert_eq!(next(&mut cursor, &mut out), Ok(None), "the end stays the end");
        packets
    }

    fn sky(count: usize) -> Vec<Star> {
        let star = |at: usize| {
            let x = at as f32;
            Star { x, y: -x, flux: x * x, snr: 9.5, errx2: f32::INFINITY, erry2: 0.1, errxy: -0.0, flags: at as u32 }
        };
        (0..count).map(star).collect()
    }

    /// A label of a map of 50 columns: rows of background, short runs, one that fills five bytes.
    fn label(at: usize) -> u32 {
        match at / 50 {
            0 | 3 | 4 => 0,
            1 => (at % 7) as u32,
            2 => u32::MAX,
            row => (at / row) as u32,
        }
    }

    fn frame() -> Vec<u16> {
        (0..40 * 30).map(|at: u32| (at * 331 % 60_000) as u16).collect()
    }

    const WINDOWS: [Window; 4] = [
        Window { x: 10.2, y: 9.0, width: 9, height: 8 },
        Window { x: -200.0, y: 9.0, width: 9, height: 8 },
        Window { x: 38.0, y: 28.0, width: 21, height: 21 },
        Window { x: 20.0, y: 15.0, width: 15, height: 15 },
    ];

    /// Some packets of every kind.
    fn mixed() -> Vec<Vec<u8>> {
        let (stars_of, pixels) = (sky(5), frame());
        let raster = Raster::new(&pixels, 40, 30, 40).unwrap();
        let mut packets = all(100, |cursor, out| stars(cursor, &stars_of, out));
        packets.extend(all(100, |cursor, out| labels(cursor, (50, 12), label, out)));
        packets.extend(all(100, |cursor, out| cutouts(cursor, &raster, &WINDOWS, out)));
        packets
    }

    #[test]
    fn stars_come_back_whatever_the_packets() {
        for (count, size) in [0, 1, 3, 50].into_iter().flat_map(|count| SIZES.map(|size| (count, size))) {
            let (sent, mut got) = (sky(count), Vec::new());
            for (number, bytes) in all(size, |cursor, out| stars(cursor, &sent, out)).iter().enumerate() {
                let packet = Packet::read(bytes).unwrap();
                assert_eq!((packet.product, packet.number, packet.length), (7, number as u32, bytes.len()));
                let Contents::Stars { total, first, records } = packet.contents else { panic!("stars") };
                assert_eq!((total as usize, first as usize), (count, got.len()));
                got.extend(records);
            }
            assert_eq!(got, sent);
        }
    }

    #[test]
    fn labels_come_back_whatever_the_packets() {
        for size in SIZES {
            let mut got = Vec::new();
            for bytes in all(size, |cursor, out| labels(cursor, (50, 12), label, out)) {
                let Contents::Labels { size, first, runs } = Packet::read(&bytes).unwrap().contents else { panic!() };
                assert_eq!((size, first as usize), ((50, 12), got.len()));
                got.extend(runs.flat_map(|run| std::iter::repeat_n(run.label, run.length as usize)));
            }
            assert!(got.into_iter().eq((0..600).map(label)));
        }
    }

    #[test]
    fn an_empty_map_is_one_short_packet() {
        let packets = all(64, |cursor, out| labels(cursor, (512, 512), |_| 0, out));
        assert_eq!(packets.iter().map(Vec::len).collect::<Vec<_>>(), [16 + 12 + 1 + 3 + 4]);
    }

    #[test]
    fn cut_outs_come_back_whatever_the_packets() {
        let pixels = frame();
        let raster = Raster::new(&pixels, 40, 30, 40).unwrap();
        let bytes: Vec<u8> = pixels.iter().map(|&pixel| pixel as u8).collect();
        let narrow = Raster::new(&bytes, 40, 30, 40).unwrap();
        for size in SIZES {
            let wide = all(size, |cursor, out| cutouts(cursor, &raster, &WINDOWS, out));
            let narrow = all(size, |cursor, out| cutouts(cursor, &narrow, &WINDOWS, out));
            for (packets, depth, mask) in [(wide, 16, 0xFFFF), (narrow, 8, 0xFF)] {
                let mut got: [Vec<u16>; 4] = Default::default();
                for bytes in &packets {
                    let Contents::Cutouts { total, bits, pieces } = Packet::read(bytes).unwrap().contents else {
                        panic!("cut-outs")
                    };
                    assert_eq!((total, bits), (4, depth));
                    for piece in pieces {
                        let place = match piece.cutout {
                            0 => ((6, 6), (9, 8)),
                            1 => ((0, 6), (0, 8)),
                            2 => ((28, 18), (12, 12)),
                            _ => ((13, 8), (15, 15)),
                        };
                        assert_eq!((piece.origin, piece.size), place);
                        let cutout = &mut got[usize::from(piece.cutout)];
                        assert_eq!(usize::from(piece.first), cutout.len());
                        cutout.extend(piece.pixels());
                        assert_eq!(usize::from(piece.first + piece.count), cutout.len());
                    }
                }
                for (got, (x, y, w, h)) in
                    got.iter().zip([(6, 6, 9, 8), (0, 0, 0, 0), (28, 18, 12, 12), (13, 8, 15, 15)])
                {
                    let of_frame = (y..y + h).flat_map(|y| (x..x + w).map(move |x| (x, y)));
                    assert!(got.iter().copied().eq(of_frame.map(|(x, y)| pixels[y * 40 + x] & mask)));
                }
            }
        }
    }

    #[test]
    fn a_packet_can_be_written_again_from_a_copy_of_the_cursor() {
        let sent = sky(9);
        let (mut cursor, mut out) = (Cursor::new(1), [0; 130]);
        stars(&mut cursor, &sent, &mut out).unwrap();
        let (mut copy, mut again) = (cursor, [1; 130]);
        let length = stars(&mut cursor, &sent, &mut out).unwrap().unwrap();
        assert_eq!(stars(&mut copy, &sent, &mut again), Ok(Some(length)));
        assert_eq!(out[..length], again[..length]);
    }

    #[test]
    fn every_flipped_bit_and_every_cut_is_found() {
        let packets = mixed();
        assert!(packets.len() > 12, "{}", packets.len());
        for good in packets {
            assert!(Packet::read(&good).is_ok());
            for bit in 0..8 * good.len() {
                let mut bad = good.clone();
                bad[bit / 8] ^= 1 << (bit % 8);
                // What follows in the file may make a longer packet of it.
                bad.extend([0; 70_000]);
                assert!(Packet::read(&bad).is_err(), "bit {bit}");
            }
            for length in 0..good.len() {
                assert!(Packet::read(&good[..length]).is_err(), "{length} bytes");
            }
            for first in 1..good.len() {
                assert!(Packet::read(&good[first..]).is_err(), "from {first}");
            }
        }
    }

    /// The packet with other bytes from a place on, and a right checksum.
    fn signed(good: &[u8], at: usize, bytes: &[u8]) -> Vec<u8> {
        let mut packet = good.to_vec();
        packet[at..at + bytes.len()].copy_from_slice(bytes);
        let mut digest = crate::arithmetic::digest::Digest::default();
        let (front, end) = packet.split_last_chunk_mut::<4>().unwrap();
        digest.bytes(front);
        *end = digest.value().to_le_bytes();
        packet
    }

    #[test]
    fn what_is_no_such_product_is_refused_by_name() {
        let packets = mixed();
        let first = |kind: u8| packets.iter().find(|packet| packet[5] == kind).unwrap();
        let wrong = |kind: u8, at: usize, bytes: &[u8]| {
            Packet::read(&signed(first(kind), at, bytes)).map(|packet| packet.number).unwrap_err().to_string()
        };
        assert_eq!(wrong(1, 0, b"FITS"), "the packet has another beginning");
        assert_eq!(wrong(1, 4, &[2]), "the packet has another format version");
        assert_eq!(wrong(1, 5, &[9]), "the packet has no sound kind");
        for (at, bytes) in [(16, [1, 0, 0, 0]), (20, [255; 4])] {
            assert_eq!(wrong(1, at, &bytes), "the packet has no sound records of stars");
        }
        for (at, bytes) in [(16, &[1, 0, 0, 0][..]), (16, &[255; 4]), (24, &[255; 4]), (28, &[0, 0]), (28, &[255; 5])] {
            assert_eq!(wrong(2, at, bytes), "the packet has no sound runs of labels");
        }
        for (at, short) in [(16, 0u16), (18, 12), (20, 4), (26, 65), (28, 65), (30, 65_000), (32, 71)] {
            assert_eq!(wrong(3, at, &short.to_le_bytes()), "the packet has no sound pieces of cut-outs");
        }
        let short = Packet::read(&first(2)[..40]).unwrap_err().to_string();
        assert!(short.ends_with("bytes, of which 40 are there"), "{short}");
        assert_eq!(Packet::read(&[]).unwrap_err().to_string(), "the packet has 20 bytes, of which 0 are there");
    }

    #[test]
    fn what_is_out_of_bounds_is_named_and_nothing_moves() {
        let mut cursor = Cursor::new(3);
        let mut short = [0; 63];
        let length = Err(Error::Length { name: "a packet", given: 63, needed: 64 });
        assert_eq!(stars(&mut cursor, &sky(1), &mut short), length);
        assert_eq!(labels(&mut cursor, (5, 5), |_| 0, &mut short), length);
        let pixels = frame();
        let raster = Raster::new(&pixels, 40, 30, 40).unwrap();
        assert_eq!(cutouts(&mut cursor, &raster, &WINDOWS, &mut short), length);
        let mut out = [0; 64];
        for size in [(0, 5), (5, 0), (65_536, 65_536)] {
            assert!(matches!(labels(&mut cursor, size, |_| 0, &mut out), Err(Error::Size { least: 1, .. })));
        }
        let wide = [Window { width: 65, ..WINDOWS[0] }];
        assert!(matches!(cutouts(&mut cursor, &raster, &wide, &mut out), Err(Error::Parameter { .. })));
        let many = std::vec![WINDOWS[0]; 65_536];
        assert!(matches!(cutouts(&mut cursor, &raster, &many, &mut out), Err(Error::Parameter { .. })));
        assert_eq!(cursor, Cursor::new(3));
    }

    #[test]
    fn a_cursor_that_an_upset_has_changed_comes_to_an_end() {
        let (sent, pixels) = (sky(5), frame());
        let raster = Raster::new(&pixels, 40, 30, 40).unwrap();
        for bit in 0..128u32 {
            let flip = |word: u32| if bit / 32 == word { 1 << (bit % 32) } else { 0 };
            let from = Cursor { product: flip(0), packet: flip(1), item: 1 ^ flip(2), pixel: 2 ^ flip(3) };
            let mut out = [0; 100];
            for kind in Kind::ALL {
                let mut cursor = from;
                let mut calls = 0;
                let mut next = || match kind {
                    Kind::Stars => stars(&mut cursor, &sent, &mut out),
                    Kind::Labels => labels(&mut cursor, (50, 12), label, &mut out),
                    Kind::Cutouts => cutouts(&mut cursor, &raster, &WINDOWS, &mut out),
                };
                while next().unwrap().is_some() {
                    calls += 1;
                    assert!(calls < 200, "{kind:?}, bit {bit}");
                }
            }
        }
    }
}
