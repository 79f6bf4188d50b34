//! Files that break the standard: some can be read all the same, the others must be refused in time.

use super::{AXES, Specimen, changed, good, plain, refused, scene};
use crate::fits_bytes::{Header, padded, samples};

const HEADER_BYTES: usize = 2880;

pub(super) fn all() -> Vec<Specimen> {
    [readable(), headers(), sizes(), no_fits()].into_iter().flatten().collect()
}

fn data() -> Vec<u8> {
    samples(16, &scene())
}

/// Small sins that do no harm.
fn readable() -> Vec<Specimen> {
    let unpadded = [Header::primary(16, &AXES).bytes(), data()].concat();
    let mut nul = plain();
    nul[5 * 80 - 20] = 0;
    let swapped = Header::default()
        .card("SIMPLE", "T")
        .card("BITPIX", 16)
        .card("NAXIS", 2)
        .card("NAXIS2", 16)
        .card("NAXIS1", 24)
        .with(data());
    vec![
        good("no_padding.fits", 0, unpadded),
        good("junk_behind.fits", 0, [plain(), b"some junk".to_vec()].concat()),
        good("zeros_behind.fits", 0, [plain(), vec![0; 5760]].concat()),
        good("nul_in_comment.fits", 0, nul),
        good("swapped_axes.fits", 0, swapped),
        good("given_twice.fits", 0, changed(|h| h.card("NAXIS1", 7))),
        good("utf8.fits", 0, changed(|h| h.line("OBJECT  = 'Sombrèro'"))),
        good("bad_checksum.fits", 0, changed(|h| h.text("CHECKSUM", "nonsense").text("DATASUM", "1"))),
        good("continued.fits", 0, changed(|h| h.line("LONG    = 'one &'").line("CONTINUE  'two'"))),
    ]
}

/// Headers that leave the layout unknown.
fn headers() -> Vec<Specimen> {
    let lower = String::from_utf8(Header::primary(16, &AXES).bytes()).map(|text| text.to_lowercase().into_bytes());
    let mut endless = Header::primary(16, &AXES).bytes();
    endless[5 * 80..5 * 80 + 3].fill(b' ');
    vec![
        refused("only_simple.fits", "ends inside the header", b"SIMPLE  =                    T".to_vec()),
        refused("no_end.fits", "ends inside the header", endless.clone()),
        refused("no_end_before_data.fits", "END", [endless, data(), vec![0; 2880]].concat()),
        refused("lower_case.fits", "does not begin with SIMPLE", lower.expect("headers are ASCII")),
        refused("no_bitpix.fits", "BITPIX is missing", changed(|h| h.without("BITPIX"))),
        refused("odd_bitpix.fits", "BITPIX = 17", Header::primary(17, &AXES).with(data())),
        refused("float_bitpix.fits", "BITPIX = -32.0", changed(|h| h.without("BITPIX").card("BITPIX", "-32.0"))),
        refused("newline.fits", "NAXIS1 = 2\\n4", changed(|h| h.without("NAXIS1").line("NAXIS1  = 2\n4"))),
        refused("no_naxis2.fits", "NAXIS2 is missing", changed(|h| h.without("NAXIS2"))),
        refused("negative.fits", "NAXIS1 = -24", changed(|h| h.without("NAXIS1").card("NAXIS1", -24))),
        refused("naxis_negative.fits", "NAXIS = -2", changed(|h| h.without("NAXIS ").card("NAXIS", -2))),
        refused(
            "naxis_endless.fits",
            "NAXIS = 1000000000",
            changed(|h| h.without("NAXIS ").card("NAXIS", 1_000_000_000)),
        ),
    ]
}

/// Headers that promise more than there is.
fn sizes() -> Vec<Specimen> {
    let claim = |axes: &[u64]| Header::primary(-32, axes).with(vec![0; 5760]);
    let claim_behind = |axes: &[u64]| [Header::primary(8, &[]).bytes(), Header::image(64, axes).bytes()].concat();
    let too_long = Header::primary(16, &AXES).without("NAXIS1").card("NAXIS1", "99999999999999999999").with(data());
    vec![
        refused("header_only.fits", "truncated", plain()[..HEADER_BYTES].to_vec()),
        refused("half.fits", "truncated", plain()[..HEADER_BYTES + 100].to_vec()),
        refused("claim_40_gb.fits", "truncated", claim(&[100_000, 100_000])),
        refused("claim_wraps_32_bits.fits", "truncated", claim(&[65_537, 65_537])),
        refused("claim_wraps_64_bits.fits", "truncated", claim(&[i64::MAX as u64, i64::MAX as u64])),
        refused("claim_beyond_128_bits.fits", "exceed any file", claim(&[i64::MAX as u64; 4])),
        refused("claim_no_integer.fits", "not a 64-bit integer", too_long),
        refused("claim_in_extension.fits", "truncated", claim_behind(&[2_000_000_000, 2_000_000_000])),
    ]
}

/// Files of another kind.
fn no_fits() -> Vec<Specimen> {
    let noise = (0u32..8640).map(|n| (n.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    vec![
        refused("empty.fits", "it is empty", Vec::new()),
        refused("web_page.fits", "web page", b"<!DOCTYPE html><title>404</title>".to_vec()),
        refused("newline_first.fits", "something stands before", [b"\n".to_vec(), plain()].concat()),
        refused("byte_order_mark.fits", "something stands before", [b"\xef\xbb\xbf".to_vec(), plain()].concat()),
        refused("zeros.fits", "does not begin with SIMPLE", vec![0; 2880]),
        refused("blanks.fits", "does not begin with SIMPLE", padded(vec![b' '], b' ')),
        refused("noise.fits", "does not begin with SIMPLE", noise),
    ]
}
