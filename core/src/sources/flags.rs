//! What a user of a source should know about it: one bit each, with its name and meaning.
//!
//! Catalogue headers and documentation are written from [`FLAGS`].

/// A bit of a source's flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flag {
    /// Its value, a power of two.
    pub bit: u32,
    /// Its name, one word.
    pub name: &'static str,
    /// What it says, one line.
    pub meaning: &'static str,
}

/// The source touches the edge of the image.
pub const TRUNCATED: u32 = 1;
/// A pixel reaches the saturation level.
pub const SATURATED: u32 = 1 << 1;
/// A pixel touches an undefined one.
pub const MASKED: u32 = 1 << 2;
/// The source was divided from another one; without a deblender: it touches another one.
pub const BLENDED: u32 = 1 << 3;
/// The front was given up at its time limit.
pub const LIMIT: u32 = 1 << 4;
/// The table of labels or the catalogue was full.
pub const NO_ROOM: u32 = 1 << 5;
/// No pixel stands above the background.
pub const NO_FLUX: u32 = 1 << 6;
/// An aperture is incomplete.
pub const APERTURE: u32 = 1 << 7;
/// An aperture reaches into other sources.
pub const NEIGHBOUR: u32 = 1 << 8;
/// The header's coordinates are not supported.
pub const NO_COORDINATES: u32 = 1 << 9;
/// The source ends in a plateau.
pub const PLATEAU: u32 = 1 << 10;

/// All flags, in the order of their bits.
pub const FLAGS: [Flag; 11] = [
    flag(TRUNCATED, "truncated", "touches the edge of the image"),
    flag(SATURATED, "saturated", "holds a pixel at or above the saturation level"),
    flag(MASKED, "masked", "touches undefined or masked pixels"),
    flag(BLENDED, "blended", "was divided from another source, or touches one"),
    flag(LIMIT, "limit", "the front was given up at t_max: outlines may be too wide"),
    flag(NO_ROOM, "no-room", "the table of labels or the catalogue was full: sources or pixels are missing"),
    flag(NO_FLUX, "no-flux", "no pixel stands above the background: centroid and shape are those of the pixels"),
    flag(APERTURE, "aperture", "an aperture reaches beyond the image or over undefined pixels, or Kron's is cut short"),
    flag(NEIGHBOUR, "neighbour", "the Kron or another aperture reaches into other sources"),
    flag(
        NO_COORDINATES,
        "no-coordinates",
        "the header's coordinates are of a kind not supported: ra, dec, pa are empty",
    ),
    flag(PLATEAU, "plateau", "ends in a plateau, as a saturated star does: its light was not divided"),
];

const fn flag(bit: u32, name: &'static str, meaning: &'static str) -> Flag {
    Flag { bit, name, meaning }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_in_order_and_apart() {
        for (index, flag) in FLAGS.iter().enumerate() {
            assert_eq!(flag.bit, 1 << index, "{}", flag.name);
        }
    }
}
