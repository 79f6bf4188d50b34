//! Packets for the ground.

use skyfront_core::error::Error;
use skyfront_core::packet::{Contents, Cursor, Packet, PacketError, cutouts, labels, stars};
use skyfront_core::track::{Raster, Star, Window};

#[unsafe(no_mangle)]
fn packet_stars(cursor: &mut Cursor, of: &[Star], out: &mut [u8]) -> Result<Option<usize>, Error> {
    stars(cursor, of, out)
}

#[unsafe(no_mangle)]
fn packet_labels(cursor: &mut Cursor, size: (u32, u32), map: &[u32], out: &mut [u8]) -> Result<Option<usize>, Error> {
    labels(cursor, size, |at| map.get(at).copied().unwrap_or(0), out)
}

macro_rules! cut_outs {
    ($name:ident, $pixel:ty) => {
        #[unsafe(no_mangle)]
        fn $name(cursor: &mut Cursor, frame: &Raster<'_, $pixel>, windows: &[Window], out: &mut [u8]) -> Result<Option<usize>, Error> {
            cutouts(cursor, frame, windows, out)
        }
    };
}

cut_outs!(packet_cutouts_u8, u8);
cut_outs!(packet_cutouts_u16, u16);

/// Reads a packet to its end.
#[unsafe(no_mangle)]
fn packet_read(bytes: &[u8]) -> Result<u32, PacketError> {
    Packet::read(bytes).map(|packet| match packet.contents {
        Contents::Stars { records, .. } => records.fold(0, |sum, star| sum ^ star.flags),
        Contents::Labels { runs, .. } => runs.fold(0, |sum, run| sum ^ run.label),
        Contents::Cutouts { pieces, .. } => pieces.flat_map(|piece| piece.pixels()).fold(0, |sum, pixel| sum ^ u32::from(pixel)),
    })
}
