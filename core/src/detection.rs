//! What the noise-aware segmentation asks of a source: immutable, checked once.

use crate::arithmetic::{Level, Real};
use crate::error::Error;
use crate::tree::{Field, Region};

/// The settings of [`crate::detect::detect`]. "Noise units" are standard deviations of a pixel of
/// empty sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// The outline: where the smoothed image has this many noise units. 0.1 to 100.
    pub outline: f32,
    /// A source's peak in the matched image, as a multiple of the outline: what is hardly above it
    /// there has hardly a pixel inside. 0 to 100.
    pub peak: f32,
    /// Peaks of pure noise that may be taken for sources in a frame, on average. 0.001 to 1000.
    pub false_sources: f32,
    /// The share of the sources that may be such peaks, where that is more. 0 to 0.5.
    pub false_share: f32,
    /// Light of a branch above the saddle that makes it a source, in noise units. 0 to 10^6.
    pub branch: f32,
    /// The same as a part of the brighter neighbour's light. 0 to 1.
    pub contrast: f32,
    /// Light of a source in all, in noise units. 0 to 10^6.
    pub light: f32,
    /// Pixels of a source, at least 1.
    pub min_area: u32,
    /// Light that the mirrored host does not explain, in noise of the lightly smoothed image. 0 to
    /// 10^6.
    pub excess: f32,
    /// Pixels of it, at least 1.
    pub reopened_area: u32,
    /// How much the image is sharpened before it is divided into sources. 0 to 4.
    pub sharpening: f32,
}

/// The photon noise counts with this factor in the variance: the measured one is a lower bound.
const PHOTON_MARGIN: f32 = 1.5;

/// How far a peak must rise above the saddle, as a part of the saddle's light: the image of a point
/// in real optics is that uneven, as the ring of a mirror out of focus and the rim of a saturated star.
const DEPTH: f32 = 0.15;

/// How much larger the noise is at the brightness `value` for the photon noise `photon` (see
/// [`crate::photon`]).
pub fn grown<L: Level>(photon: f32, value: L) -> L {
    (L::ONE + value.positive().scaled(L::Weight::of(PHOTON_MARGIN * photon))).root()
}

impl Detection {
    /// The default for every kind of sky.
    pub const DEFAULT: Detection = Detection {
        outline: 1.0,
        peak: 1.42,
        false_sources: 0.5,
        false_share: 0.05,
        branch: 10.0,
        contrast: 0.0005,
        light: 15.0,
        min_area: 6,
        excess: 5.5,
        reopened_area: 4,
        sharpening: 0.5,
    };

    /// Pixels of a part that was divided from another source, five thirds of [`Detection::min_area`]:
    /// noise on the light of a bright galaxy makes smaller ones.
    pub fn part_area(&self) -> u32 {
        self.min_area.saturating_add(self.min_area.saturating_mul(2) / 3)
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`Error::Parameter`] names the first that is out of bounds.
    pub fn validate(&self) -> Result<(), Error> {
        for (name, value, low, high) in [
            ("outline", self.outline, 0.1, 100.0),
            ("peak", self.peak, 0.0, 100.0),
            ("false sources", self.false_sources, 0.001, 1000.0),
            ("false share", self.false_share, 0.0, 0.5),
            ("branch", self.branch, 0.0, 1e6),
            ("contrast", self.contrast, 0.0, 1.0),
            ("light", self.light, 0.0, 1e6),
            ("min area", self.min_area as f32, 1.0, 1e9),
            ("excess", self.excess, 0.0, 1e6),
            ("reopened area", self.reopened_area as f32, 1.0, 1e9),
            ("sharpening", self.sharpening, 0.0, 4.0),
        ] {
            // Written so that a NaN fails.
            let (enough, within) = (value >= low, value <= high);
            if !enough {
                return Err(Error::Parameter { name, value, bound: "at least", limit: low });
            }
            if !within {
                return Err(Error::Parameter { name, value, bound: "at most", limit: high });
            }
        }
        Ok(())
    }

    /// Whether the fainter of two regions that meet at `saddle` is a source of its own: enough
    /// pixels and light above the saddle for the noise there, a peak that rises above it by more than
    /// the noise and the unevenness of optics, and around its peak more than twice
    /// the mirrored light of the brighter.
    pub fn stands_apart<L: Level>(
        &self,
        field: Field<'_, L>,
        [bright, faint]: [&Region<L>; 2],
        saddle: L,
        photon: f32,
    ) -> bool {
        let light = faint.sum - saddle.times(faint.area);
        let noise = grown(photon, saddle);
        let significant = faint.area >= 3
            && light > L::share(noise.times(1), self.branch)
            && light > L::share(bright.sum, self.contrast)
            && faint.value - saddle > noise.greatest(saddle.scaled(L::Weight::of(DEPTH)));
        if !significant {
            return false;
        }
        let centre = field.centre(bright.peak as usize);
        let peak = faint.peak as usize;
        let twice = |at: usize| field.mirrored(centre, at).map_or(L::ZERO, |light| light + light);
        let own = |&at: &usize| field.at(at) > twice(at);
        field.grid.neighbours(peak).chain([peak]).filter(own).count() >= 3
    }
}
