//! Electrons in a unit of the image, as its header tells them.

use crate::read::Image;

/// The most electrons in a whole count of a detector: what a full well of a million makes in 15 bits.
const MOST_IN_A_COUNT: f64 = 30.0;

/// Electrons in a unit of the image by EGAIN or, without it, by GAIN; none where neither is above 0.
///
/// Capture programs for CMOS cameras write the camera's setting, such as 120, as GAIN, and electrons as EGAIN. A GAIN that
/// no detector of whole counts has is taken for such a setting.
///
/// # Errors
/// A warning where that is so, with the value.
pub fn of_header(image: &Image) -> Result<Option<f64>, String> {
    let above_zero = |keyword| image.real(keyword).filter(|&gain| gain > 0.0);
    let (electrons, gain) = (above_zero("EGAIN"), above_zero("GAIN"));
    let counts = image.bitpix > 0 && image.header.real("BSCALE").is_none_or(|scale| scale == 1.0);
    match (electrons, gain) {
        (None, Some(gain)) if counts && gain > MOST_IN_A_COUNT => Err(format!(
            "GAIN = {gain} is no number of electrons in a count (a camera's setting?): errors are without those of \
             the sources' own photons; --gain E gives it"
        )),
        (electrons, gain) => Ok(electrons.or(gain)),
    }
}
