//! Everything that changes during a run on signal-to-noise but lies in no plane, list or table.

use crate::arithmetic::Level;
use crate::arithmetic::codec::Codec;
use crate::plane::walk::Walk;
use crate::sky::photon::Curve;
use crate::sky::signal::{Measured, Smoothing};
use crate::sky::values::Look;
use crate::sources::selection::{Cutting, Kept};
use crate::sources::separate::{Dividing, Growing};
use crate::sources::tree::{Count, Noise};

/// A source is masked when a pixel of it stands this high above the noise: noise peaks are not,
/// for without them the sky would be biased low.
const MASKED_PEAK: f32 = 3.5;

/// The state between two polls: what each step has left, and how far the one under way is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<L: Level> {
    /// Steps of the plan that are done.
    pub done: usize,
    pub walk: Walk,
    pub look: Look,
    pub measured: Measured,
    pub smoothing: Smoothing<L>,
    pub curve: Curve,
    pub growing: Growing,
    pub dividing: Dividing<L>,
    pub cutting: Cutting<L>,
    pub kept: Kept,
    /// Pixels that no front can have reached.
    pub unreached: u32,
}

impl<L: Level> State<L> {
    /// Before the first step.
    pub const NEW: State<L> = State {
        done: 0,
        walk: Walk::whole(),
        look: Look::NOTHING,
        measured: Measured::NOTHING,
        smoothing: Smoothing::NOTHING,
        curve: Curve::NOTHING,
        growing: Growing::NOTHING,
        dividing: Dividing::NOTHING,
        cutting: Cutting::NOTHING,
        kept: Kept { sources: 0, pixels: 0 },
        unreached: 0,
    };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.size(&mut self.done)?;
        self.walk.code(codec)?;
        self.look.code(codec)?;
        self.measured.code(codec)?;
        self.smoothing.code(codec)?;
        self.curve.code(codec)?;
        self.growing.code(codec)?;
        self.dividing.code(codec)?;
        self.cutting.code(codec)?;
        for word in [&mut self.kept.sources, &mut self.kept.pixels, &mut self.unreached] {
            codec.word(word)?;
        }
        Ok(())
    }

    /// Regions that are in use.
    pub fn regions(&self) -> usize {
        self.growing.count.regions.max(self.count().regions)
    }

    /// Whether a run could have come to this state: no step and no region beyond the last, and no more work than it
    /// can need.
    pub fn is_sound(&self, steps: usize, regions: usize, bound: u64) -> bool {
        self.done <= steps && self.regions() <= regions && self.walk.spent() <= bound
    }

    /// The noise of the lightly smoothed plane.
    pub fn noise(&self) -> Noise<L> {
        Noise { least: self.smoothing.fine.noise, photon: self.curve.slope() }
    }

    /// The height from which on a source is masked.
    pub fn masked_from(&self) -> L {
        self.smoothing.fine.height(MASKED_PEAK)
    }

    /// The regions.
    pub fn count(&self) -> Count {
        self.dividing.opening.count
    }
}
