//! What other programs call the columns: the words of the IVOA (UCD1+) and of SExtractor.

/// What must be measured for a column beyond the pixels of the sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing.
    Pixels,
    /// The Kron aperture.
    Kron,
    /// The windowed centroid.
    Windowed,
    /// The background beside the source.
    Local,
    /// The Petrosian radius.
    Petrosian,
}

/// A column as others know it.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Our name; `#` stands for the number of an aperture.
    pub name: &'static str,
    /// Unified content descriptor.
    pub ucd: &'static str,
    /// The names that SExtractor gives the same quantity.
    pub sextractor: &'static [&'static str],
    /// What it needs.
    pub needs: Needs,
    /// Whether it is in the catalogue when no columns are chosen.
    pub usual: bool,
}

const fn usual(name: &'static str, ucd: &'static str, sextractor: &'static [&'static str]) -> Known {
    Known { name, ucd, sextractor, needs: Needs::Pixels, usual: true }
}

const fn on_request(name: &'static str, ucd: &'static str, sextractor: &'static [&'static str], needs: Needs) -> Known {
    Known { name, ucd, sextractor, needs, usual: false }
}

const fn kron(name: &'static str, ucd: &'static str, sextractor: &'static [&'static str]) -> Known {
    Known { needs: Needs::Kron, ..usual(name, ucd, sextractor) }
}

/// All columns.
pub const KNOWN: [Known; 74] = [
    usual("label", "meta.id;meta.main", &["NUMBER"]),
    usual("x", "pos.cartesian.x;instr.det", &["X_IMAGE"]),
    usual("y", "pos.cartesian.y;instr.det", &["Y_IMAGE"]),
    usual("ra", "pos.eq.ra;meta.main", &["ALPHA_J2000", "ALPHA_SKY", "X_WORLD"]),
    usual("dec", "pos.eq.dec;meta.main", &["DELTA_J2000", "DELTA_SKY", "Y_WORLD"]),
    usual("glon", "pos.galactic.lon", &[]),
    usual("glat", "pos.galactic.lat", &[]),
    usual("elon", "pos.ecliptic.lon", &[]),
    usual("elat", "pos.ecliptic.lat", &[]),
    usual("xmin", "pos.cartesian.x;stat.min", &["XMIN_IMAGE"]),
    usual("xmax", "pos.cartesian.x;stat.max", &["XMAX_IMAGE"]),
    usual("ymin", "pos.cartesian.y;stat.min", &["YMIN_IMAGE"]),
    usual("ymax", "pos.cartesian.y;stat.max", &["YMAX_IMAGE"]),
    usual("area", "phys.angArea;instr.det", &["ISOAREA_IMAGE"]),
    usual("sum", "phot.count", &[]),
    usual("mean", "phot.count;stat.mean", &[]),
    usual("peak", "phot.count;stat.max", &[]),
    usual("xpeak", "pos.cartesian.x;stat.max", &["XPEAK_IMAGE"]),
    usual("ypeak", "pos.cartesian.y;stat.max", &["YPEAK_IMAGE"]),
    usual("background", "instr.skyLevel", &["BACKGROUND"]),
    usual("noise", "instr.skyLevel;stat.stdev", &[]),
    usual("threshold", "phot.count;stat.min", &[]),
    usual("x2", "src.morph.param", &["X2_IMAGE"]),
    usual("y2", "src.morph.param", &["Y2_IMAGE"]),
    usual("xy", "src.morph.param", &["XY_IMAGE"]),
    usual("errx2", "stat.variance;pos.cartesian.x", &["ERRX2_IMAGE"]),
    usual("erry2", "stat.variance;pos.cartesian.y", &["ERRY2_IMAGE"]),
    usual("errxy", "stat.covariance;pos.cartesian", &["ERRXY_IMAGE"]),
    usual("a", "phys.angSize.smajAxis;instr.det", &["A_IMAGE"]),
    usual("b", "phys.angSize.sminAxis;instr.det", &["B_IMAGE"]),
    usual("theta", "pos.posAng;instr.det", &["THETA_IMAGE"]),
    usual("elongation", "src.ellipticity", &["ELONGATION"]),
    usual("ellipticity", "src.ellipticity", &["ELLIPTICITY"]),
    usual("fwhm", "phys.angSize;instr.det", &["FWHM_IMAGE"]),
    usual("a_sky", "phys.angSize.smajAxis", &["A_WORLD"]),
    usual("b_sky", "phys.angSize.sminAxis", &["B_WORLD"]),
    usual("pa", "pos.posAng", &["THETA_J2000", "THETA_SKY"]),
    usual("flux", "phot.count", &["FLUX_ISO"]),
    usual("flux_err", "stat.error;phot.count", &["FLUXERR_ISO"]),
    usual("snr", "stat.snr", &[]),
    kron("half_light_radius", "phys.angSize", &["FLUX_RADIUS"]),
    kron("kron_radius", "phys.angSize;instr.det", &[]),
    kron("flux_kron", "phot.count", &["FLUX_AUTO"]),
    kron("flux_kron_err", "stat.error;phot.count", &["FLUXERR_AUTO"]),
    usual("flux_aper_#", "phot.count", &["FLUX_APER"]),
    usual("flux_aper_#_err", "stat.error;phot.count", &["FLUXERR_APER"]),
    usual("mag", "phot.mag", &["MAG_ISO"]),
    usual("mag_err", "stat.error;phot.mag", &["MAGERR_ISO"]),
    kron("mag_kron", "phot.mag", &["MAG_AUTO"]),
    kron("mag_kron_err", "stat.error;phot.mag", &["MAGERR_AUTO"]),
    usual("mag_aper_#", "phot.mag", &["MAG_APER"]),
    usual("mag_aper_#_err", "stat.error;phot.mag", &["MAGERR_APER"]),
    usual("mu_max", "phot.mag.sb;stat.max", &["MU_MAX"]),
    usual("flags", "meta.code.qual", &[]),
    on_request("flags_sex", "meta.code.qual", &["FLAGS"], Needs::Kron),
    on_request("flux_max", "phot.count;stat.max", &["FLUX_MAX"], Needs::Pixels),
    on_request("kron_factor", "src.morph.param", &["KRON_RADIUS"], Needs::Kron),
    on_request("xwin", "pos.cartesian.x;instr.det", &["XWIN_IMAGE"], Needs::Windowed),
    on_request("ywin", "pos.cartesian.y;instr.det", &["YWIN_IMAGE"], Needs::Windowed),
    on_request("errx2win", "stat.variance;pos.cartesian.x", &["ERRX2WIN_IMAGE"], Needs::Windowed),
    on_request("erry2win", "stat.variance;pos.cartesian.y", &["ERRY2WIN_IMAGE"], Needs::Windowed),
    on_request("errxywin", "stat.covariance;pos.cartesian", &["ERRXYWIN_IMAGE"], Needs::Windowed),
    on_request("ra_win", "pos.eq.ra", &["ALPHAWIN_J2000", "ALPHAWIN_SKY", "XWIN_WORLD"], Needs::Windowed),
    on_request("dec_win", "pos.eq.dec", &["DELTAWIN_J2000", "DELTAWIN_SKY", "YWIN_WORLD"], Needs::Windowed),
    on_request("petrosian_radius", "phys.angSize;instr.det", &[], Needs::Petrosian),
    on_request("flux_petrosian", "phot.count", &["FLUX_PETRO"], Needs::Petrosian),
    on_request("flux_petrosian_err", "stat.error;phot.count", &["FLUXERR_PETRO"], Needs::Petrosian),
    on_request("mag_petrosian", "phot.mag", &["MAG_PETRO"], Needs::Petrosian),
    on_request("mag_petrosian_err", "stat.error;phot.mag", &["MAGERR_PETRO"], Needs::Petrosian),
    on_request("background_local", "instr.skyLevel", &[], Needs::Local),
    on_request("noise_local", "instr.skyLevel;stat.stdev", &[], Needs::Local),
    on_request("flux_local", "phot.count", &[], Needs::Local),
    on_request("flux_local_err", "stat.error;phot.count", &[], Needs::Local),
    on_request("snr_local", "stat.snr", &[], Needs::Local),
];

/// What is known of a column, of a further image too (`m2_`).
pub fn known(name: &str) -> Option<&'static Known> {
    let of_band = name.strip_prefix('m').and_then(|rest| rest.split_once('_'));
    let name = match of_band {
        Some((band, name)) if !band.is_empty() && band.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => name,
    };
    let numbered = name.split_once("aper_").and_then(|(head, tail)| {
        let end = tail.trim_start_matches(|c: char| c.is_ascii_digit());
        (end.len() < tail.len()).then(|| format!("{head}aper_#{end}"))
    });
    let pattern = numbered.as_deref().unwrap_or(name);
    KNOWN.iter().find(|known| known.name == pattern)
}

/// The columns that a person may mean by a word: the one of ours with exactly this name, else those
/// that SExtractor calls so, whatever the size of the letters and the number of elements.
pub fn meant(word: &str) -> impl Fn(&str) -> bool {
    let ours = known(word).is_some();
    let word = word.split('(').next().unwrap_or_default().to_owned();
    move |name| {
        let theirs = |known: &Known| known.sextractor.iter().any(|theirs| theirs.eq_ignore_ascii_case(&word));
        if ours { name == word } else { known(name).is_some_and(theirs) }
    }
}
