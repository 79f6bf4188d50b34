//! The world coordinate system of the input, as the header entries that a map of the same pixels needs.

use super::entry::{Entry, Value};
use crate::read::Header;

/// Entries for the coordinates of a two-dimensional image (FITS WCS papers I to III, SIP, TPV, TNX, ZPX, plate solutions),
/// copied card by card.
///
/// Axes beyond the second are left out. Distortions kept in other HDUs of the input (lookup tables: `CPDISj`, `DPj`,
/// `D2IMDISj`) cannot be carried over and are left out too.
pub fn entries(header: &Header) -> Vec<Entry> {
    header
        .cards()
        .iter()
        .filter(|card| card.value().is_some() && is_planar(card.keyword()))
        .map(|card| match (card.keyword(), card.value().and_then(|v| v.trim().parse::<i64>().ok())) {
            (keyword, Some(3..)) if keyword.starts_with("WCSAXES") => {
                Entry::Key(keyword.to_owned(), Value::Integer(2), "number of coordinate axes".to_owned())
            }
            _ => Entry::Copy(*card),
        })
        .collect()
}

/// Whether a keyword belongs to the coordinates of the first two axes.
fn is_planar(keyword: &str) -> bool {
    const WHOLE: [&str; 15] = [
        "EPOCH", "RADECSYS", "MJD-OBS", "DATE-OBS", "A_ORDER", "B_ORDER", "AP_ORDER", "BP_ORDER", "A_DMAX", "B_DMAX",
        "WAT0_001", "TIMESYS", "MJDREF", "CROTA1", "CROTA2",
    ];
    const PLATE: [&str; 4] = ["PLT", "AMDX", "AMDY", "CNPIX"];
    const PLATE_WHOLE: [&str; 8] = ["PPO1", "PPO2", "PPO3", "PPO4", "PPO5", "PPO6", "XPIXELSZ", "YPIXELSZ"];
    const PER_SYSTEM: [&str; 7] = ["WCSAXES", "WCSNAME", "RADESYS", "EQUINOX", "LONPOLE", "LATPOLE", "VELREF"];
    const PER_AXIS: [&str; 7] = ["CTYPE", "CRVAL", "CRPIX", "CDELT", "CUNIT", "CRDER", "CSYER"];
    const PAIR: [&str; 2] = ["CD", "PC"];
    const PARAMETER: [&str; 2] = ["PV", "PS"];
    const SIP: [&str; 4] = ["A_", "B_", "AP_", "BP_"];

    let base = without_version(keyword);
    let rest = |names: &[&str], of: &str| -> Option<String> {
        names.iter().find_map(|name| of.strip_prefix(name)).map(str::to_owned)
    };
    WHOLE.contains(&keyword)
        || PLATE_WHOLE.contains(&keyword)
        || PLATE.iter().any(|name| keyword.starts_with(name))
        || PER_SYSTEM.contains(&keyword)
        || PER_SYSTEM.contains(&base)
        || rest(&PER_AXIS, base).is_some_and(|n| axis(&n))
        || rest(&PAIR, base).and_then(|n| two(&n).or_else(|| old(&n))).is_some_and(|(i, j)| axis(&i) && axis(&j))
        || rest(&PARAMETER, base).and_then(|n| two(&n)).is_some_and(|(i, m)| axis(&i) && number(&m))
        || SIP
            .iter()
            .any(|name| keyword.strip_prefix(name).and_then(two).is_some_and(|(p, q)| number(&p) && number(&q)))
        || rest(&["WAT"], keyword).and_then(|n| two(&n)).is_some_and(|(i, m)| axis(&i) && number(&m))
}

/// A keyword without the letter of an alternate system (`CRVAL1A`), if it ends in one.
fn without_version(keyword: &str) -> &str {
    keyword.strip_suffix(|c: char| c.is_ascii_uppercase()).unwrap_or(keyword)
}

fn two(text: impl AsRef<str>) -> Option<(String, String)> {
    text.as_ref().split_once('_').map(|(a, b)| (a.to_owned(), b.to_owned()))
}

/// The numbers of an old matrix, `PC001002`.
fn old(text: &str) -> Option<(String, String)> {
    (text.len() == 6).then(|| text.split_at_checked(3)).flatten().map(|(i, j)| (i.to_owned(), j.to_owned()))
}

/// One of the first two axes; old matrices have zeros in front, `PC01_02`.
fn axis(text: &str) -> bool {
    matches!(text.trim_start_matches('0'), "1" | "2")
}

fn number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::Card;

    #[test]
    fn coordinates_of_two_axes_are_kept() {
        for keyword in [
            "CTYPE1", "CRVAL2", "CRPIX1A", "CD1_2", "PC2_1", "CDELT2", "CROTA2", "LONPOLE", "LATPOLEB", "RADESYS",
            "RADECSYS", "EQUINOX", "A_ORDER", "A_0_2", "AP_10_0", "B_DMAX", "PV1_10", "PV2_3A", "WCSAXES", "CUNIT1",
            "WAT1_001", "AMDX13", "PLTDECSN", "PPO6", "CNPIX1", "XPIXELSZ", "WCSNAMEA", "PC001002", "PC01_02",
            "CD002001",
        ] {
            assert!(is_planar(keyword), "{keyword}");
        }
    }

    #[test]
    fn other_keywords_are_not() {
        for keyword in [
            "CTYPE3", "CD3_1", "CD1_3", "PC1_3", "PV3_1", "NAXIS1", "BSCALE", "BLANK", "A_RADIUS", "CPDIS1", "DP1",
            "D2IMDIS1", "TCTYP1", "ZNAXIS1", "COMMENT", "HISTORY", "", "CD", "PV1", "CRVAL", "EXTNAME", "CRVAL10",
            "PC001003", "PC0012",
        ] {
            assert!(!is_planar(keyword), "{keyword}");
        }
    }

    #[test]
    fn the_number_of_axes_becomes_two() {
        let header = Header::new(vec![Card::new("WCSAXES =                    4"), Card::new("CRVAL4  = 1.0")]);
        let entries = entries(&header);
        assert_eq!(entries, [Entry::new("WCSAXES", 2, "number of coordinate axes")]);
    }
}
