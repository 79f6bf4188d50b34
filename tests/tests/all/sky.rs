//! Sky coordinates against astropy.
//!
//! The numbers come from astropy 8.0.2 on the same header texts: `WCS(header).all_pix2world(.., 1)`,
//! and `SkyCoord.position_angle` between two points 0.005 pixels to both sides. Tolerances are
//! 1e-3 arcsec and 1e-3 degrees.

use skyfront::read::{Card, Header};
use skyfront::sky::Sky;

const SIP: &str = "\
CTYPE1  = 'RA---TAN-SIP'
CTYPE2  = 'DEC--TAN-SIP'
CRPIX1  = 480.3
CRPIX2  = 410.7
CRVAL1  = 10.0
CRVAL2  = 41.0
CD1_1   = -9.9E-4
CD1_2   = 2.0E-5
CD2_1   = 3.0E-5
CD2_2   = 1.01E-3
A_ORDER = 3
A_2_0   = 2.0E-5
A_0_2   = -1.0E-5
A_1_1   = 3.0E-5
A_3_0   = 1.0E-8
A_1_2   = -2.0E-8
B_ORDER = 3
B_2_0   = 1.0E-5
B_1_1   = -2.0E-5
B_0_3   = 3.0E-8
B_2_1   = 2.0E-8";

const TPV: &str = "\
CTYPE1  = 'RA---TPV'
CTYPE2  = 'DEC--TPV'
CRPIX1  = -2000.5
CRPIX2  = 3000.25
CRVAL1  = 148.3
CRVAL2  = 1.7
CD1_1   = -1.1E-7
CD1_2   = 7.3E-5
CD2_1   = 7.3E-5
CD2_2   = 1.1E-7
PV1_0   = 0.002
PV1_1   = 1.0097
PV1_2   = 0.00017
PV1_4   = 0.0078
PV1_5   = 0.0006
PV1_6   = -0.0007
PV1_7   = 0.0013
PV1_10  = -0.0047
PV1_11  = 0.003
PV1_12  = 0.02
PV1_22  = 0.05
PV1_39  = 0.4
PV2_1   = 1.0066
PV2_2   = 0.0003
PV2_4   = -0.0004
PV2_7   = -0.007
PV2_9   = -0.0008
PV2_23  = -0.04
PV2_31  = 0.3";

const SWAPPED: &str = "\
CTYPE1  = 'DEC--TAN'
CTYPE2  = 'RA---TAN'
CRPIX1  = 369.5
CRPIX2  = 240.5
CRVAL1  = -58.6
CRVAL2  = 159.2
CDELT1  = 1.6829E-4
CDELT2  = 1.6829E-4
PC1_1   = 0.9757
PC1_2   = -0.2189
PC2_1   = 0.2189
PC2_2   = 0.9757
RADESYS = 'FK5'";

const SIN: &str = "\
CTYPE1  = 'RA---SIN'
CTYPE2  = 'DEC--SIN'
CRPIX1  = 20.0
CRPIX2  = 30.0
CRVAL1  = 359.99
CRVAL2  = -59.7
CDELT1  = -0.002
CDELT2  = 0.002
CROTA2  = 33.0
LONPOLE = 150.0
EQUINOX = 1950.0";

const TNX: &str = "CTYPE1  = 'RA---TNX'
CTYPE2  = 'DEC--TNX'
CD1_1   = -1E-4
CD2_2   = 1E-4";

fn header(text: &str) -> Header {
    Header::new(text.lines().map(Card::new).collect())
}

/// Header, frame, and for two FITS pixels (x, y): ra, dec, position angle of the direction 0.5 rad.
type Known = (&'static str, &'static str, [[f64; 5]; 2]);

const KNOWN: [Known; 4] = [
    (
        SIP,
        "icrs",
        [[1.0, 1.0, 10.6015251249, 40.5649204346, 122.9951], [250.25, 777.5, 10.3164059864, 41.3671849804, 120.8051]],
    ),
    (
        TPV,
        "icrs",
        [[1.0, 1.0, 148.0810730884, 1.8465762754, 28.5367], [250.25, 777.5, 148.1380742095, 1.8650159449, 28.5803]],
    ),
    (
        SWAPPED,
        "fk5",
        [[1.0, 1.0, 159.0983141150, -58.6516449352, 41.3797], [250.25, 777.5, 159.3609890941, -58.6392627715, 41.1555]],
    ),
    (
        SIN,
        "fk4",
        [[1.0, 1.0, 0.1265920149, -59.6924022611, 55.5300], [250.25, 777.5, 356.9614208336, -59.3964163794, 58.2695]],
    ),
];

#[test]
fn positions_and_angles_are_those_of_astropy() {
    for (text, frame, points) in KNOWN {
        let sky = Sky::of(&header(text)).expect("a supported header").expect("a celestial header");
        assert_eq!(sky.frame().name(), frame);
        for [x, y, ra, dec, angle] in points {
            let found = sky.position(x - 1.0, y - 1.0).expect("a place on the sky");
            let east = (found.0 - ra) * dec.to_radians().cos() * 3600.0;
            let north = (found.1 - dec) * 3600.0;
            assert!(east.hypot(north) < 1e-3, "{text}\n{found:?}, {:e} arcsec off", east.hypot(north));
            let found = sky.position_angle(x - 1.0, y - 1.0, 0.5).expect("an angle on the sky");
            assert!((found - angle).abs() < 1e-3, "{text}\n{found} is not {angle}");
        }
    }
}

#[test]
fn what_is_not_supported_is_refused_by_name() {
    let cases = [
        (SIP.replace("TAN-SIP", "TAN"), "without -SIP"),
        (SIP.replace("A_ORDER = 3", "A_ORDER = 12"), "A_ORDER"),
        (SIP.replace("TAN-SIP", "TNX"), "without -SIP"),
        (SIP.replace("TAN-SIP", "TNX-SIP"), "together"),
        (SWAPPED.replace("TAN", "TNX"), "latitude as the first axis"),
        (format!("{TNX}\nWAT1_001= 'lngcor = \"3 2 2 1 -1 1 -1 1 0 0 0\"'"), "lngcor of WAT1: 3 coefficients"),
        (TNX.replace("TNX", "ZPX") + "\nWAT2_001= 'projp3=much'", "projp3 = much of WAT2"),
        (format!("{TNX}\nAMDX1   = 67.2\nAMDY1   = 67.2"), "a plate solution without XPIXELSZ"),
        (format!("{TNX}\nAMDX1   = 67.2\nAMDY1   = 67.2\nXPIXELSZ= 0"), "XPIXELSZ = 0"),
        (format!("{SIP}\nCPDIS1  = 'Lookup'"), "CPDIS1"),
        (format!("{SIP}\nD2IMDIS1= 'Lookup'"), "D2IMDIS1"),
        (TPV.replace("TPV", "STG"), "PV2_"),
        (SIN.replace("SIN", "QSC"), "QSC"),
        (SIN.replace("SIN", "COE"), "COE without PV2_1"),
        (format!("{SIN}\nPV1_1   = 5.0"), "PV1_1"),
        (SWAPPED.replace("DEC--TAN", "FREQ"), "FREQ"),
        (SWAPPED.replace("FK5", "GAPPT"), "GAPPT"),
        (SIN.replace("1950.0", "1975.0"), "1975"),
        (SIN.replace("RA---", "TLON-").replace("DEC--", "TLAT-"), "TLON-SIN"),
        (format!("{SIN}\nCUNIT1  = 'm'"), "unit m"),
        (SIN.replace("CRVAL1  = 359.99", "CRVAL1  = NAN"), "CRVAL1  = NAN"),
        (SIN.replace("CRVAL1  = 359.99", "CRVAL1  = '10:00:24'"), "10:00:24"),
        (format!("{SIP}\nCD2_1   =-1E-4"), "CD2_1   =-1E-4"),
        (SIN.replace("CRVAL1", "crval1"), "crval1"),
        (SIP.replace("A_1_1   = 3.0E-5", "A_1_1   = 'much'"), "A_1_1"),
        (format!("{SWAPPED}\nCD1_1   = 1.0"), "that differ"),
        (SIN.replace("CDELT2  = 0.002", "CDELT2  = 0.0"), "inverse"),
    ];
    for (text, word) in cases {
        let reason = Sky::of(&header(&text)).expect_err(word);
        assert!(reason.contains(word), "{reason}");
    }
}

#[test]
fn a_header_without_celestial_axes_has_no_coordinates() {
    for text in ["", "CTYPE1  = 'LINEAR'\nCTYPE2  = 'LINEAR'", "CRVAL1  = 10.0", "CTYPE1  = ''\nCTYPE2  = ''"] {
        assert!(Sky::of(&header(text)).expect("no distortion").is_none(), "{text}");
    }
}

/// Headers of every projection, frame and way of writing, each with the right ascension and
/// declination that astropy 8.0.2 gives for three FITS pixels
/// (`WCS(header).wcs_pix2world`, `SkyCoord.icrs`); for SCAMP's TAN with parameters those of TPV.
const PROJECTIONS: &str = include_str!("projections.txt");

#[test]
fn every_projection_is_that_of_astropy() {
    let (mut cases, mut far) = (0, Vec::new());
    for case in PROJECTIONS.split("# ").filter(|case| !case.trim().is_empty()) {
        let (lines, points): (Vec<&str>, Vec<&str>) = case.lines().skip(1).partition(|line| !line.starts_with("= "));
        let text = lines.join("\n");
        let letter = text.contains("CRVAL1A").then_some('A');
        let sky = Sky::alternate(&header(&text), letter).unwrap_or_else(|reason| panic!("{reason}\n{text}"));
        let sky = sky.expect("a celestial header");
        for point in points {
            let numbers: Vec<f64> = point[2..].split(' ').filter_map(|number| number.parse().ok()).collect();
            let found = sky.position(numbers[0] - 1.0, numbers[1] - 1.0);
            let (Some(found), [ra, dec]) = (found, &numbers[2..]) else {
                far.extend((found.is_some() || numbers.len() > 2).then(|| format!("{point}: {found:?}\n{text}")));
                continue;
            };
            let east = ((found.0 - ra + 540.0).rem_euclid(360.0) - 180.0) * dec.to_radians().cos() * 3600.0;
            let north = (found.1 - dec) * 3600.0;
            let off = east.hypot(north);
            far.extend((off >= 1e-3).then(|| format!("{point}: {found:?}, {off:e} arcsec off\n{text}")));
        }
        cases += 1;
    }
    assert!(far.is_empty(), "\n{}", far.join("\n\n"));
    assert!(cases > 60, "only {cases} headers");
}

#[test]
fn galactic_axes_keep_their_own_coordinates() {
    let galactic = SIN.replace("RA---", "GLON-").replace("DEC--", "GLAT-");
    let sky = Sky::of(&header(&galactic)).expect("supported").expect("celestial");
    assert_eq!(sky.frame().name(), "icrs");
    let (longitude, latitude) = sky.own_position(19.0, 29.0).expect("a place");
    assert!((longitude - 359.99).abs() < 1e-9 && (latitude + 59.7).abs() < 1e-9);
}

/// A rotated frame with rectangular pixels: an ellipse along north is one on the sky.
#[test]
fn shapes_are_turned_onto_the_sky() {
    let text = "CTYPE1  = 'RA---TAN'\nCTYPE2  = 'DEC--TAN'\nCRPIX1  = 1.0\nCRPIX2  = 1.0\nCRVAL1  = 30.0\n\
                CRVAL2  = 60.0\nCD1_1   = 0.0\nCD1_2   = 1E-4\nCD2_1   = 2E-4\nCD2_2   = 0.0";
    let sky = Sky::of(&header(text)).expect("supported").expect("celestial");
    let patch = sky.patch(0.0, 0.0).expect("a patch");
    assert!((patch.area() - 0.36 * 0.72).abs() < 1e-6, "{}", patch.area());
    // x runs north by 0.72 arcsec, y east by 0.36.
    let ellipse = patch.ellipse((4.0, 9.0, 0.0));
    assert!((ellipse.a - 1.44).abs() < 1e-5 && (ellipse.b - 1.08).abs() < 1e-5, "{ellipse:?}");
    assert!(ellipse.theta.abs() < 1e-5, "along north: {}", ellipse.theta);
}

/// Pixels aslant: an ellipse of 2 and 1 arcsec, 25 degrees from north through east, by what it covers of the pixels.
#[test]
fn shapes_are_those_on_the_sky_however_pixels_lie() {
    let text = "CTYPE1  = 'RA---TAN'\nCTYPE2  = 'DEC--TAN'\nCRPIX1  = 1.0\nCRPIX2  = 1.0\nCRVAL1  = 30.0\n\
                CRVAL2  = 60.0\nCD1_1   = -1.2E-4\nCD1_2   = 5E-5\nCD2_1   = 7E-5\nCD2_2   = 1.1E-4";
    let sky = Sky::of(&header(text)).expect("supported").expect("celestial");
    let patch = sky.patch(0.0, 0.0).expect("a patch");
    let (sin, cos) = 25f64.to_radians().sin_cos();
    let (north, east, both) = (4.0 * cos * cos + sin * sin, 4.0 * sin * sin + cos * cos, 3.0 * sin * cos);
    let ((ex, ey), (nx, ny)) = (patch.pixels(1.0, 0.0).expect("a place"), patch.pixels(0.0, 1.0).expect("a place"));
    let moment = |e: (f64, f64), n: (f64, f64)| east * e.0 * e.1 + north * n.0 * n.1 + both * (e.0 * n.1 + e.1 * n.0);
    let ellipse = patch.ellipse((moment((ex, ex), (nx, nx)), moment((ey, ey), (ny, ny)), moment((ex, ey), (nx, ny))));
    assert!((ellipse.a - 2.0).abs() < 1e-6 && (ellipse.b - 1.0).abs() < 1e-6, "{ellipse:?}");
    assert!((ellipse.theta.to_degrees() - 25.0).abs() < 1e-6, "{ellipse:?}");
}

/// The four faces of the cube around its equator, at their middles and half way to the right.
#[test]
fn a_cube_s_faces_follow_each_other() {
    let text = "CTYPE1  = 'RA---TSC'\nCTYPE2  = 'DEC--TSC'\nCRPIX1  = 1.0\nCRPIX2  = 1.0\nCRVAL1  = 100.0\n\
                CRVAL2  = 0.0\nCDELT1  = -1.0\nCDELT2  = 1.0";
    let sky = Sky::of(&header(text)).expect("supported").expect("celestial");
    for (x, ra) in [(0.0, 100.0), (90.0, 10.0), (180.0, 280.0), (-90.0, 190.0)] {
        for (aside, degrees) in [(0.0, 0.0), (22.5, 0.5f64.atan().to_degrees())] {
            let (found, dec) = sky.position(x - aside, 0.0).expect("a place");
            assert!((found - ra - degrees).abs() < 1e-9 && dec.abs() < 1e-9, "{found}, {dec} at {x} and {aside}");
        }
    }
}

/// The rotation stands with the latitude axis, wherever that is; the places are astropy's.
#[test]
fn a_rotation_turns_swapped_axes_the_right_way() {
    let text = "CTYPE1  = 'DEC--TAN'
CTYPE2  = 'RA---TAN'
CRPIX1  = 20.0
CRPIX2  = 30.0
CRVAL1  = -59.7
CRVAL2  = 150.5
CDELT1  = 0.002
CDELT2  = -0.002
CROTA1  = 33.0";
    let sky = Sky::of(&header(text)).expect("supported").expect("celestial");
    for ((x, y), (ra, dec)) in [
        ((1.0, 1.0), (150.637_434_742_444_5, -59.700_208_616_050_35)),
        ((250.25, 777.5), (147.481_942_557_819_62, -60.093_661_475_140_27)),
    ] {
        let (found_ra, found_dec) = sky.position(x - 1.0, y - 1.0).expect("a place");
        assert!((found_ra - ra).abs() < 1e-8 && (found_dec - dec).abs() < 1e-8, "{found_ra}, {found_dec}");
    }
}
