//! What is known of a camera: the same for stars in windows and for the sources of a run.

use crate::error::Error;

/// What is known of the camera.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The value of a pixel without light, counts.
    pub black: f32,
    /// Electrons per count, above 0.
    pub gain: f32,
    /// Noise of a pixel without light, electrons, at least 0.
    pub read_noise: f32,
    /// Pixels from this value on are saturated, counts.
    pub saturation: f32,
    /// Standard deviation of a star's image before pixels sample it, pixels, 0.5 to 3.
    pub psf_sigma: f32,
}

impl Camera {
    /// Checks every parameter.
    ///
    /// # Errors
    /// [`Error::Parameter`] names the first that is out of bounds.
    pub fn validate(&self) -> Result<(), Error> {
        let within = |name, value: f32, (least, most): (f32, f32)| match value {
            value if value >= least && value <= most => Ok(()),
            value if value > most => Err(Error::Parameter { name, value, bound: "at most", limit: most }),
            value => Err(Error::Parameter { name, value, bound: "at least", limit: least }),
        };
        let counts = (0.0, 65_536.0);
        within("black", self.black, counts)?;
        within("gain", self.gain, (1e-3, 1e6))?;
        within("read noise", self.read_noise, (0.0, 1e6))?;
        within("saturation", self.saturation, counts)?;
        within("PSF sigma", self.psf_sigma, (0.5, 3.0))
    }

    /// The least count that is saturated.
    pub(crate) fn full(&self) -> u32 {
        libm::ceilf(self.saturation) as u32
    }

    /// Variance of a pixel on a sky level in counts: read-out, photons, and the rounding to whole counts.
    pub(crate) fn variance(&self, sky: f32) -> f32 {
        let (light, dark) = (sky - self.black, self.read_noise / self.gain);
        dark * dark + if light > 0.0 { light / self.gain } else { 0.0 } + 1.0 / 12.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: Camera = Camera { black: 100.0, gain: 2.0, read_noise: 4.0, saturation: 4000.5, psf_sigma: 1.0 };

    #[test]
    fn the_variance_is_that_of_reading_photons_and_rounding() {
        let rounding = 1.0 / 12.0;
        assert_eq!(
            [100.0, 90.0, 150.0].map(|sky| CAMERA.variance(sky)),
            [4.0 + rounding, 4.0 + rounding, 29.0 + rounding]
        );
        assert_eq!(CAMERA.full(), 4001);
    }

    #[test]
    fn bounds_belong_to_what_is_allowed() {
        let valid = |camera: Camera| camera.validate().is_ok();
        assert!(
            valid(CAMERA) && valid(Camera { psf_sigma: 0.5, ..CAMERA }) && valid(Camera { psf_sigma: 3.0, ..CAMERA })
        );
        assert!(!valid(Camera { psf_sigma: 0.49, ..CAMERA }) && !valid(Camera { psf_sigma: 3.01, ..CAMERA }));
        assert!(!valid(Camera { gain: 0.0, ..CAMERA }) && !valid(Camera { black: f32::NAN, ..CAMERA }));
    }
}
