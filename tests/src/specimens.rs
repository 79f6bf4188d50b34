//! A zoo of our own: good, odd and broken image files, each with what reading it must give.

mod broken;
mod pictures;

use crate::fits_bytes::{Header, bzip2, gzip, samples, tiled};

/// Size of the scene.
pub const WIDTH: usize = 24;
pub const HEIGHT: usize = 16;
const AXES: [u64; 2] = [WIDTH as u64, HEIGHT as u64];

/// A file and what reading it must give.
pub struct Specimen {
    pub name: &'static str,
    pub bytes: Vec<u8>,
    pub expect: Expect,
}

/// What reading a file must give.
pub enum Expect {
    /// An image in this HDU with these pixels (NaN = undefined).
    Pixels(usize, Vec<f32>),
    /// A refusal whose line holds these words.
    Refused(&'static str),
}

/// The scene: a sky with a slope, and two sources. Whole numbers that 16 bits hold.
pub fn scene() -> Vec<f64> {
    let source = |x: usize, y: usize, (cx, cy): (f64, f64), peak: f64| {
        let r2 = (x as f64 - cx).powi(2) + (y as f64 - cy).powi(2);
        peak / (1.0 + r2)
    };
    let pixel = |n: usize| {
        let (x, y) = (n % WIDTH, n / WIDTH);
        (100 + x + (7 * x + 13 * y) % 5) as f64 + source(x, y, (6.0, 5.0), 900.0) + source(x, y, (17.5, 10.0), 4000.0)
    };
    (0..WIDTH * HEIGHT).map(|n| pixel(n).floor()).collect()
}

/// The scene as it must be read.
fn as_read() -> Vec<f32> {
    scene().iter().map(|&v| v as f32).collect()
}

fn good(name: &'static str, hdu: usize, bytes: Vec<u8>) -> Specimen {
    Specimen { name, bytes, expect: Expect::Pixels(hdu, as_read()) }
}

fn refused(name: &'static str, words: &'static str, bytes: Vec<u8>) -> Specimen {
    Specimen { name, bytes, expect: Expect::Refused(words) }
}

/// The plain file that most others vary.
fn plain() -> Vec<u8> {
    Header::primary(16, &AXES).with(samples(16, &scene()))
}

fn changed(change: impl FnOnce(Header) -> Header) -> Vec<u8> {
    change(Header::primary(16, &AXES)).with(samples(16, &scene()))
}

/// Every specimen that can be made without cfitsio.
pub fn all() -> Vec<Specimen> {
    [stored(), undefined(), layouts(), names_and_wrappings(), tables(), broken::all(), pictures::all()]
        .into_iter()
        .flatten()
        .collect()
}

/// Sample types and scaling.
fn stored() -> Vec<Specimen> {
    let of = |bitpix: i32| Header::primary(bitpix, &AXES).with(samples(bitpix, &scene()));
    let offset = |bitpix: i32, zero: f64, zero_text: &str| {
        let stored: Vec<f64> = scene().iter().map(|v| v - zero).collect();
        Header::primary(bitpix, &AXES).card("BZERO", zero_text).with(samples(bitpix, &stored))
    };
    let unsigned_64 = {
        let stored = scene().iter().flat_map(|&v| (i64::MIN + v as i64).to_be_bytes()).collect();
        Header::primary(64, &AXES).card("BZERO", "9223372036854775808").with(stored)
    };
    let halves: Vec<f64> = scene().iter().map(|v| (v - 500.0) * 2.0).collect();
    let small: Vec<f64> = scene().iter().map(|v| v / 32.0).collect();
    let bytes: Vec<f32> = small.iter().map(|&v| f32::from(v as u8)).collect();
    vec![
        good("bitpix_16.fits", 0, of(16)),
        good("bitpix_32.fits", 0, of(32)),
        good("bitpix_64.fits", 0, of(64)),
        good("bitpix_-32.fits", 0, of(-32)),
        good("bitpix_-64.fits", 0, of(-64)),
        Specimen {
            name: "bitpix_8.fits",
            bytes: Header::primary(8, &AXES).with(samples(8, &small)),
            expect: Expect::Pixels(0, bytes),
        },
        good("unsigned_16.fits", 0, offset(16, 32768.0, "32768")),
        good("unsigned_32.fits", 0, offset(32, 2147483648.0, "2.147483648D9")),
        good("unsigned_64.fits", 0, unsigned_64),
        good(
            "scaled.fits",
            0,
            Header::primary(16, &AXES).card("BSCALE", 0.5).card("BZERO", 500).with(samples(16, &halves)),
        ),
        refused("scale_zero.fits", "BSCALE = 0", changed(|h| h.card("BSCALE", "0.0"))),
        refused("scale_text.fits", "BZERO = many", changed(|h| h.text("BZERO", "many"))),
    ]
}

/// NaN, infinities and BLANK.
fn undefined() -> Vec<Specimen> {
    let float = |change: fn(&mut [f64])| {
        let mut values = scene();
        change(&mut values);
        let expect = Expect::Pixels(0, values.iter().map(|&v| v as f32).collect());
        (Header::primary(-32, &AXES).with(samples(-32, &values)), expect)
    };
    let (nan, nan_pixels) = float(|v| v[..40].fill(f64::NAN));
    let (infinite, infinite_pixels) = float(|v| (v[0], v[99]) = (f64::INFINITY, f64::NEG_INFINITY));
    let mut blank = scene();
    blank[30..50].fill(-32768.0);
    let blank_pixels = blank.iter().map(|&v| if v < 0.0 { f32::NAN } else { v as f32 }).collect();
    let everywhere = |value: f64| Header::primary(-32, &AXES).with(samples(-32, &vec![value; scene().len()]));
    vec![
        Specimen { name: "nan.fits", bytes: nan, expect: nan_pixels },
        Specimen { name: "infinite.fits", bytes: infinite, expect: infinite_pixels },
        Specimen {
            name: "blank.fits",
            bytes: Header::primary(16, &AXES).card("BLANK", -32768).with(samples(16, &blank)),
            expect: Expect::Pixels(0, blank_pixels),
        },
        refused("nan_everywhere.fits", "every pixel is undefined", everywhere(f64::NAN)),
        refused("infinite_everywhere.fits", "every pixel is undefined", everywhere(f64::INFINITY)),
    ]
}

/// Where in the file the image is.
fn layouts() -> Vec<Specimen> {
    let data = || samples(16, &scene());
    let extension = |name: &str| Header::image(16, &AXES).text("EXTNAME", name).with(data());
    let empty = || Header::primary(8, &[]).bytes();
    let table = Header::table(4, 3, 100, &[("A", "1J")]).with(vec![1; 112]);
    let cube = Header::primary(16, &[24, 8, 2]).with(data());
    let with_axes = |axes: &[u64]| Header::primary(16, axes).with(data());
    vec![
        good("extension.fits", 1, [empty(), extension("SCI")].concat()),
        good("behind_a_table.fits", 2, [empty(), table.clone(), extension("SCI")].concat()),
        good("behind_1d.fits", 1, [Header::primary(-32, &[7]).with(vec![0; 28]), extension("A")].concat()),
        good("behind_a_cube.fits", 1, [cube.clone(), extension("A")].concat()),
        good("primary_first.fits", 0, [plain(), extension("A")].concat()),
        good("three_axes.fits", 0, with_axes(&[24, 16, 1])),
        good("five_axes.fits", 0, with_axes(&[24, 16, 1, 1, 1])),
        refused("cube.fits", "3-D array of 24 x 8 x 2", cube),
        refused("spectrum.fits", "1-D array of 7", Header::primary(-32, &[7]).with(vec![0; 28])),
        refused("nothing.fits", "no axes", empty()),
        refused("table_only.fits", "a binary table", [empty(), table].concat()),
        refused("no_rows.fits", "no 2-D image", Header::primary(16, &[24, 0]).bytes()),
        refused(
            "groups.fits",
            "random groups",
            Header::primary(-32, &[0, 3]).card("GROUPS", "T").card("PCOUNT", 2).card("GCOUNT", 4).with(vec![0; 80]),
        ),
        refused("many_axes.fits", "more than 9 axes", Header::primary(8, &[1; 999]).with(vec![1])),
    ]
}

/// The size of the scene in tiles of one row in GZIP_2, all 0 but for what stands in the fifth.
fn gzip_2(fifth: Vec<u8>) -> Vec<u8> {
    let mut pieces = vec![gzip(&[0; 2 * WIDTH]); HEIGHT];
    pieces[5] = fifth;
    tiled(16, (AXES[0], AXES[1]), "GZIP_2", "COMPRESSED_DATA", &pieces, |header| header)
}

/// Names that other readers take for commands, and compressed files.
fn names_and_wrappings() -> Vec<Specimen> {
    let zipped = gzip(&plain());
    let (first, second) = (gzip(&plain()[..3000]), gzip(&plain()[3000..]));
    let claim = Header::primary(16, &[1_000_000, 1_000_000]).bytes();
    let gzip_2 = |fifth: &[u8]| gzip_2(gzip(fifth));
    let mut off = gzip(&[0; 2 * WIDTH]);
    let sum_at = off.len() - 8;
    off[sum_at] ^= 1;
    let sum_off = self::gzip_2(off);
    vec![
        good("plus+1.fits", 0, plain()),
        good("brackets[1:3,2].fits", 0, plain()),
        good("not a [filter.fits", 0, plain()),
        good("-.fits", 0, plain()),
        good("ñ_星.fits", 0, plain()),
        good("zipped.fits.gz", 0, zipped.clone()),
        good("zipped_without_suffix.fits", 0, zipped.clone()),
        refused("zipped_short.fits.gz", "broken gzip", zipped[..zipped.len() / 2].to_vec()),
        good("zipped_twice.fits.gz", 0, [first, second].concat()),
        good("zipped_and_padded.fits.gz", 0, [zipped.clone(), vec![0; 700]].concat()),
        good("bzip2_twice.fits.bz2", 0, [bzip2(&plain()[..3000]), bzip2(&plain()[3000..])].concat()),
        refused("bzip2_of_nothing.fits.bz2", "truncated: the header promises 2000000000000 bytes", bzip2(&claim)),
        refused("tile_of_another_length.fits", "tile 5 has another number of bytes", gzip_2(&[0; 2 * WIDTH + 1])),
        refused("tile_with_another_sum.fits", "tile 5 is not a sound gzip stream", sum_off),
        refused("xz.fits.xz", "compressed with xz", b"\xfd7zXZ\0 and so on".to_vec()),
    ]
}

/// Tile compression that cfitsio reads but does not write.
fn tables() -> Vec<Specimen> {
    let rows = |bitpix: i32| -> Vec<Vec<u8>> { scene().chunks(WIDTH).map(|row| samples(bitpix, row)).collect() };
    let zipped = |bitpix: i32| -> Vec<Vec<u8>> { rows(bitpix).iter().map(|row| gzip(row)).collect() };
    let planes = |row: &[u8]| (0..4).flat_map(|b| row[b..].iter().step_by(4)).copied().collect::<Vec<u8>>();
    let shuffled: Vec<Vec<u8>> = rows(-32).iter().map(|row| gzip(&planes(row))).collect();
    let endless_zeros = vec![vec![0, 0, 0, 0, 8, 0]; HEIGHT];
    let same = |header: Header| header;
    let make = |bitpix, coding, column, pieces: &[Vec<u8>]| tiled(bitpix, (24, 16), coding, column, pieces, same);
    let claim = |width, height| tiled(16, (width, height), "RICE_1", "COMPRESSED_DATA", &rows(16), same);
    vec![
        good("tiles_gzip_2.fits", 1, make(-32, "GZIP_2", "COMPRESSED_DATA", &shuffled)),
        good("tiles_gzip_f64.fits", 1, make(-64, "GZIP_1", "COMPRESSED_DATA", &zipped(-64))),
        good("tiles_raw.fits", 1, make(16, "NOCOMPRESS", "COMPRESSED_DATA", &rows(16))),
        good("tiles_fallback.fits", 1, make(-32, "RICE_1", "GZIP_COMPRESSED_DATA", &zipped(-32))),
        refused("tiles_missing.fits", "16 tiles make up", make(16, "RICE_1", "COMPRESSED_DATA", &rows(16)[..9])),
        refused("tiles_short.fits", "ends before its pixels", make(16, "RICE_1", "COMPRESSED_DATA", &endless_zeros)),
        refused("tiles_not_gzip.fits", "not a sound gzip", make(16, "GZIP_1", "COMPRESSED_DATA", &rows(16))),
        refused("tiles_unknown.fits", "compression BZIP2_1", make(16, "BZIP2_1", "COMPRESSED_DATA", &rows(16))),
        refused("tiles_huge.fits", "truncated", claim(2_000_000_000, 2_000_000_000)),
        refused(
            "tiles_hcompress.fits",
            "HCOMPRESS data of its size",
            make(16, "HCOMPRESS_1", "COMPRESSED_DATA", &rows(16)),
        ),
    ]
}
