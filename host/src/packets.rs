//! What a file of packets from board holds ([`skyfront_core::packet`]), and what is missing.

use crate::provenance::shortest;
use serde_json::{Value, json};
use skyfront_core::packet::{BEGINNING, Contents, Kind, Packet, PacketError, Piece};
use skyfront_core::track::{BLENDED, EDGE, HOT, LOST, SATURATED, Star};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt;

/// The flags of a star, by name.
const STAR_FLAGS: [(u32, &str); 5] =
    [(EDGE, "edge"), (SATURATED, "saturated"), (HOT, "hot"), (BLENDED, "blended"), (LOST, "lost")];

/// What is to be known about a file of packets. Places of bytes count from 0.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Remark {
    /// Bytes in which no packet is.
    #[error("bytes {from} to {to} are left out: {reason}")]
    Damaged {
        /// The first byte.
        from: usize,
        /// The last byte.
        to: usize,
        /// What is wrong with the first packet of them.
        reason: PacketError,
    },
    /// A packet that was there before.
    #[error("{product}: packet {number} is there once more, and left out")]
    Repeated {
        /// Of which product.
        product: Name,
        /// Its number.
        number: u32,
    },
    /// A packet that says something else of its product than the first one did.
    #[error("{product}: packet {number} is left out: it belongs to another product of this number")]
    Other {
        /// Of which product.
        product: Name,
        /// Its number.
        number: u32,
    },
    /// Packets that are not there.
    #[error("{product}: {missing}; {items} are missing")]
    Lost {
        /// Of which product.
        product: Name,
        /// Which packets.
        missing: String,
        /// How much was in them.
        items: String,
    },
}

impl Remark {
    /// Whether something was lost.
    pub fn is_loss(&self) -> bool {
        !matches!(self, Remark::Repeated { .. })
    }
}

/// A product: the sender's number, and what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Name {
    /// The number.
    pub number: u32,
    /// What it is.
    pub kind: Kind,
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "product {}, {}", self.number, self.kind.name())
    }
}

/// The packets of a file.
///
/// ```
/// use skyfront::packets::Received;
///
/// // Bytes that are no packet are told, not guessed at.
/// let received = Received::of(b"noise on the line");
/// assert_eq!(received.packets(), 0);
/// ```
#[derive(Debug, Default)]
pub struct Received<'a> {
    products: BTreeMap<Name, BTreeMap<u32, Contents<'a>>>,
    /// What is to be known about them.
    pub remarks: Vec<Remark>,
}

impl<'a> Received<'a> {
    /// Finds all packets, one behind the other; bytes between them are told and left out.
    pub fn of(bytes: &'a [u8]) -> Received<'a> {
        let mut received = Received::default();
        let (mut at, mut damaged) = (0, None);
        while at < bytes.len() {
            match Packet::read(&bytes[at..]) {
                Ok(packet) => {
                    received.damaged(damaged.take(), at);
                    received.take(&packet);
                    at += packet.length;
                }
                Err(reason) => {
                    damaged.get_or_insert((at, reason));
                    let next = bytes[at + 1..].windows(BEGINNING.len()).position(|window| window == BEGINNING);
                    at = next.map_or(bytes.len(), |next| at + 1 + next);
                }
            }
        }
        received.damaged(damaged, at);
        let lost: Vec<Remark> = received.products.iter().filter_map(|(name, packets)| lost(*name, packets)).collect();
        received.remarks.extend(lost);
        received
    }

    /// How many packets are used.
    pub fn packets(&self) -> usize {
        self.products.values().map(BTreeMap::len).sum()
    }

    fn damaged(&mut self, damaged: Option<(usize, PacketError)>, end: usize) {
        self.remarks.extend(damaged.map(|(from, reason)| Remark::Damaged { from, to: end - 1, reason }));
    }

    fn take(&mut self, packet: &Packet<'a>) {
        let (product, number) = (Name { number: packet.product, kind: packet.contents.kind() }, packet.number);
        let packets = self.products.entry(product).or_default();
        let first = packets.first_key_value().map(|(_, first)| whole(first));
        match packets.entry(number) {
            Entry::Occupied(_) => self.remarks.push(Remark::Repeated { product, number }),
            Entry::Vacant(_) if first.is_some_and(|first| first != whole(&packet.contents)) => {
                self.remarks.push(Remark::Other { product, number });
            }
            Entry::Vacant(place) => {
                place.insert(packet.contents);
            }
        }
    }

    /// Gives `line` every star, map and cut-out, by product.
    ///
    /// # Errors
    /// Those of `line`, at the first of which it ends.
    pub fn lines<E>(&self, mut line: impl FnMut(&Value) -> Result<(), E>) -> Result<(), E> {
        for (name, packets) in &self.products {
            match name.kind {
                Kind::Stars => stars(packets).try_for_each(|star| line(&of(*name, star)))?,
                Kind::Labels => map(packets).map_or(Ok(()), |map| line(&of(*name, map)))?,
                Kind::Cutouts => {
                    let pieces: Vec<Piece<'_>> = pieces(packets).collect();
                    let cutouts = pieces.chunk_by(|one, other| one.cutout == other.cutout);
                    cutouts.map(cutout).try_for_each(|cutout| line(&of(*name, cutout)))?;
                }
            }
        }
        Ok(())
    }
}

/// What all packets of a product say alike.
fn whole(contents: &Contents<'_>) -> (u32, u32) {
    match *contents {
        Contents::Stars { total, .. } => (total, 0),
        Contents::Labels { size, .. } => size,
        Contents::Cutouts { total, bits, .. } => (u32::from(total), u32::from(bits)),
    }
}

/// How much of a product there is, and how much there should be: stars, pixels, or whole cut-outs.
fn shares(packets: &BTreeMap<u32, Contents<'_>>) -> (u64, u64) {
    let wanted = match packets.values().next() {
        Some(Contents::Labels { size: (width, height), .. }) => u64::from(*width) * u64::from(*height),
        Some(contents) => u64::from(whole(contents).0),
        None => 0,
    };
    let of_packets: u64 = packets
        .values()
        .map(|contents| match *contents {
            Contents::Stars { records, .. } => records.count() as u64,
            Contents::Labels { runs, .. } => runs.map(|run| u64::from(run.length)).sum(),
            Contents::Cutouts { .. } => 0,
        })
        .sum();
    (of_packets + whole_cutouts(packets), wanted)
}

/// How many cut-outs have all of their pixels.
fn whole_cutouts(packets: &BTreeMap<u32, Contents<'_>>) -> u64 {
    let pieces: Vec<Piece<'_>> = pieces(packets).collect();
    let cutouts = pieces.chunk_by(|one, other| one.cutout == other.cutout);
    let is_whole = |pieces: &&[Piece<'_>]| {
        let (columns, rows) = pieces[0].size;
        pieces.iter().map(|piece| u32::from(piece.count)).sum::<u32>() >= u32::from(columns) * u32::from(rows)
    };
    cutouts.filter(is_whole).count() as u64
}

/// What a product lacks.
fn lost(product: Name, packets: &BTreeMap<u32, Contents<'_>>) -> Option<Remark> {
    let (there, wanted) = shares(packets);
    if there >= wanted {
        return None;
    }
    let last = packets.keys().next_back()?;
    let mut gaps = Vec::new();
    let mut next = 0;
    for &number in packets.keys() {
        match number - next {
            0 => {}
            1 => gaps.push(format!("packet {next} is lost")),
            _ => gaps.push(format!("packets {next} to {} are lost", number - 1)),
        }
        next = number.saturating_add(1);
    }
    if gaps.is_empty() {
        gaps.push(format!("all packets behind packet {last} are lost"));
    }
    let unit = match product.kind {
        Kind::Labels => "pixels of the map",
        kind => kind.name(),
    };
    let items = format!("{} of {wanted} {unit}", wanted - there);
    Some(Remark::Lost { product, missing: gaps.join(", "), items })
}

/// A line of JSON that begins with its product.
fn of(name: Name, mut value: Value) -> Value {
    value["product"] = name.number.into();
    value
}

/// The stars of a product.
fn stars(packets: &BTreeMap<u32, Contents<'_>>) -> impl Iterator<Item = Value> {
    packets
        .values()
        .flat_map(|contents| match *contents {
            Contents::Stars { first, records, .. } => {
                Some((first..).zip(records).map(|(index, star)| star_of(index, &star)))
            }
            _ => None,
        })
        .flatten()
}

fn star_of(index: u32, star: &Star) -> Value {
    let flags: Vec<&str> = STAR_FLAGS.iter().filter(|(bit, _)| star.flags & bit != 0).map(|(_, name)| *name).collect();
    let Star { x, y, flux, snr, errx2, erry2, errxy, .. } = *star;
    let [x, y, flux, snr, errx2, erry2, errxy] = [x, y, flux, snr, errx2, erry2, errxy].map(shortest);
    json!({
        "kind": "star", "index": index, "x": x, "y": y, "flux": flux, "snr": snr,
        "errx2": errx2, "erry2": erry2, "errxy": errxy, "flags": flags,
    })
}

/// The map of labels of a product: runs of pixels that have one, and of those that are missing.
fn map(packets: &BTreeMap<u32, Contents<'_>>) -> Option<Value> {
    let (mut at, mut runs, mut missing) = (0, Vec::new(), Vec::new());
    let (width, height) = whole(packets.values().next()?);
    for contents in packets.values() {
        let Contents::Labels { first, runs: more, .. } = *contents else { continue };
        if first > at {
            missing.push([at, first - at]);
        }
        at = first;
        for run in more {
            if run.label > 0 {
                runs.push([at, run.length, run.label]);
            }
            at += run.length;
        }
    }
    let pixels = width * height;
    if at < pixels {
        missing.push([at, pixels - at]);
    }
    Some(json!({ "kind": "labels", "width": width, "height": height, "runs": runs, "missing": missing }))
}

/// The pieces of a product's cut-outs.
fn pieces<'a>(packets: &BTreeMap<u32, Contents<'a>>) -> impl Iterator<Item = Piece<'a>> {
    packets
        .values()
        .filter_map(|contents| match *contents {
            Contents::Cutouts { pieces, .. } => Some(pieces),
            _ => None,
        })
        .flatten()
}

/// A cut-out of its pieces; pixels that are missing are null.
fn cutout(pieces: &[Piece<'_>]) -> Value {
    let Piece { cutout, origin: (x, y), size: (columns, rows), .. } = pieces[0];
    let mut pixels = vec![None; usize::from(columns) * usize::from(rows)];
    for piece in pieces {
        let to = pixels.iter_mut().skip(usize::from(piece.first));
        to.zip(piece.pixels()).for_each(|(to, pixel)| *to = Some(pixel));
    }
    json!({
        "kind": "cut-out", "index": cutout, "x": x, "y": y, "width": columns, "height": rows, "pixels": pixels,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use skyfront_core::packet::{Cursor, cutouts, labels, stars};
    use skyfront_core::track::{Raster, Window};

    const WINDOWS: [Window; 2] =
        [Window { x: 10.0, y: 9.0, width: 9, height: 8 }, Window { x: 20.0, y: 15.0, width: 8, height: 8 }];

    /// The packets of seven stars, a map and two cut-outs: 4, 3 and 5.
    fn sent() -> Vec<Vec<u8>> {
        let star = Star { x: 14.3, snr: 20.0, errx2: f32::INFINITY, flags: EDGE | LOST, ..Star::EMPTY };
        let label = |at: usize| if (at / 20).is_multiple_of(2) { at as u32 / 2 } else { 0 };
        let pixels: Vec<u16> = (0..40 * 30).collect();
        let raster = Raster::new(&pixels, 40, 30, 40).expect("a frame");
        let mut packets = Vec::new();
        for kind in Kind::ALL {
            let (mut cursor, mut out) = (Cursor::new(7), [0; 100]);
            let mut next = || match kind {
                Kind::Stars => stars(&mut cursor, &[star; 7], &mut out).map(|length| (length, out)),
                Kind::Labels => labels(&mut cursor, (20, 14), label, &mut out).map(|length| (length, out)),
                Kind::Cutouts => cutouts(&mut cursor, &raster, &WINDOWS, &mut out).map(|length| (length, out)),
            };
            while let (Some(length), out) = next().expect("sound products") {
                packets.push(out[..length].to_vec());
            }
        }
        packets
    }

    fn lines(received: &Received<'_>) -> Vec<Value> {
        let mut lines = Vec::new();
        let Ok(()) = received.lines::<std::convert::Infallible>(|line| {
            lines.push(line.clone());
            Ok(())
        });
        lines
    }

    fn remarks(received: &Received<'_>) -> Vec<String> {
        received.remarks.iter().map(Remark::to_string).collect()
    }

    #[test]
    fn what_was_sent_is_told_and_in_any_order() {
        let mut packets = sent();
        assert_eq!(packets.iter().map(|packet| packet[5]).collect::<Vec<_>>(), [1, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3, 3]);
        let bytes = packets.concat();
        let received = Received::of(&bytes);
        assert_eq!((received.packets(), remarks(&received)), (12, vec![]));
        let told = lines(&received);
        assert_eq!(told.len(), 7 + 1 + 2);
        let star = json!({
            "product": 7, "kind": "star", "index": 6, "x": 14.3, "y": 0.0, "flux": 0.0, "snr": 20.0, "errx2": null,
            "erry2": 0.0, "errxy": 0.0, "flags": ["edge", "lost"],
        });
        assert_eq!(told[6], star);
        let runs = told[7]["runs"].as_array().expect("runs");
        assert_eq!((&runs[0], &runs[9], &runs[10]), (&json!([2, 2, 1]), &json!([40, 2, 20]), &json!([42, 2, 21])));
        assert_eq!(told[7]["missing"], json!([]));
        assert_eq!((&told[9]["x"], &told[9]["y"], &told[9]["pixels"][9]), (&json!(17), &json!(12), &json!(538)));
        packets.reverse();
        assert_eq!(lines(&Received::of(&packets.concat())), told);
    }

    #[test]
    fn a_lost_packet_costs_what_was_in_it() {
        let packets = sent();
        for lost in 0..packets.len() {
            let rest: Vec<u8> = (0..12).filter(|at| *at != lost).flat_map(|at| packets[at].clone()).collect();
            let received = Received::of(&rest);
            let told = remarks(&received);
            assert_eq!((received.packets(), told.len()), (11, 1), "{told:?}");
            assert!(received.remarks[0].is_loss() && told[0].contains("lost"), "{told:?}");
        }
        let without = |lost: &[usize]| {
            let rest: Vec<u8> = (0..12).filter(|at| !lost.contains(at)).flat_map(|at| packets[at].clone()).collect();
            let received = Received::of(&rest);
            (remarks(&received), lines(&received))
        };
        assert_eq!(without(&[1, 2]).0, ["product 7, stars: packets 1 to 2 are lost; 4 of 7 stars are missing"]);
        let (told, map) = without(&[5]);
        assert!(
            told[0].starts_with("product 7, labels: packet 1 is lost; ")
                && told[0].ends_with("of 280 pixels of the map are missing")
        );
        assert_eq!(map[7]["missing"].as_array().expect("gaps").len(), 1);
        let (told, map) = without(&[6]);
        assert!(told[0].starts_with("product 7, labels: all packets behind packet 1 are lost; "), "{told:?}");
        let gap = map[7]["missing"][0].as_array().expect("a gap");
        assert_eq!(gap[0].as_u64().expect("a place") + gap[1].as_u64().expect("a length"), 280);
        let (told, cut) = without(&[8]);
        assert_eq!(told, ["product 7, cut-outs: packet 1 is lost; 1 of 2 cut-outs are missing"]);
        let pixels = cut[8]["pixels"].as_array().expect("pixels");
        assert!(pixels.len() == 72 && pixels[0] == 246 && pixels[40] == Value::Null, "{pixels:?}");
    }

    #[test]
    fn damaged_and_repeated_packets_are_left_out_and_told() {
        let mut packets = sent();
        packets[2][30] ^= 4;
        let again = packets[4].clone();
        packets.insert(5, again);
        let mut bytes = b"idle".to_vec();
        bytes.extend(packets.concat());
        bytes.extend(&packets[0][..50]);
        let received = Received::of(&bytes);
        let at = 4 + packets[0].len() + packets[1].len();
        assert_eq!(
            remarks(&received),
            [
                "bytes 0 to 3 are left out: the packet has another beginning".to_owned(),
                format!("bytes {at} to {} are left out: the packet is damaged: its checksum fails", at + 91),
                "product 7, labels: packet 0 is there once more, and left out".to_owned(),
                format!(
                    "bytes {} to {} are left out: the packet has 92 bytes, of which 50 are there",
                    bytes.len() - 50,
                    bytes.len() - 1
                ),
                "product 7, stars: packet 2 is lost; 2 of 7 stars are missing".to_owned(),
            ]
        );
        assert_eq!(received.remarks.iter().map(Remark::is_loss).collect::<Vec<_>>(), [true, true, false, true, true]);
        assert_eq!(lines(&received).len(), 5 + 1 + 2);
    }

    #[test]
    fn every_flipped_bit_of_a_file_is_told() {
        let good = sent().concat();
        for bit in 0..8 * good.len() {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(Received::of(&bad).remarks.iter().any(Remark::is_loss), "bit {bit}");
        }
    }

    #[test]
    fn packets_of_two_products_with_one_number_are_not_mixed() {
        let mut bytes = sent()[0].clone();
        let (mut cursor, mut out) = (Cursor { packet: 1, item: 2, ..Cursor::new(7) }, [0; 100]);
        let length = stars(&mut cursor, &[Star::EMPTY; 9], &mut out).expect("stars").expect("a packet");
        bytes.extend(&out[..length]);
        let told = remarks(&Received::of(&bytes));
        assert_eq!(told[0], "product 7, stars: packet 1 is left out: it belongs to another product of this number");
    }
}
